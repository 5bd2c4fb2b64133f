//! Tests of `calibrate` on simulated scans of the ground and a wall by scanners with known errors.

use std::path::Path;

use crate::common::{Scratch, sim};
use host_sim::answer::{Answer, metres};
use host_sim::commands::calibrate::mounting;
use host_sim::commands::help::SIM;
use host_sim::playback::Playback;
use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use host_sim::scene::Scene;
use stairscan::config::Config;
use stairscan::mount::Mounting;
use stairscan::pipeline::Pipeline;
use stairscan::scanner::{DataPath, Settings};
use stairscan::verdict::Reason;

/// Errors: height, m, angle by homing and by pitch, degrees, and relative error of the configured
/// bandwidth.
#[derive(Clone, Copy, Default)]
struct Off {
    height_m: f64,
    bias_deg: f64,
    pitch_deg: f64,
    bandwidth: f64,
}

/// A scan of the ground up to a wall, with further objects.
fn scan(wall_m: f64, off: Off, else_there: &str) -> Recording {
    let text = format!(
        "[mount]\nheight_error_m = {}\npitch_error_deg = {}\n[mirror]\nbias_deg = {}\njitter_deg = 0.02\n\
         [[floor]]\nto_m = {wall_m}\nmaterial = \"concrete\"\n\
         [[wall]]\nat_m = {wall_m}\nmaterial = \"plaster\"\n{else_there}",
        off.height_m, off.pitch_deg, off.bias_deg
    );
    let mut recording = Scene::parse(&text).unwrap().simulate("wall", 7);
    // The recording contains the configured value; the samples come from the real one.
    recording.meta.bandwidth_hz *= 1.0 - off.bandwidth;
    recording
}

fn calibrated(recording: &Recording, wall_m: f32) -> Result<Mounting, String> {
    mounting(recording, wall_m, &Options::default()).map_err(|e| format!("{e:#}"))
}

#[test]
fn known_errors_are_found_within_their_standard_errors() {
    let cases = [
        (1.5, Off::default()),
        (
            1.5,
            Off {
                height_m: 0.03,
                bias_deg: 1.0,
                ..Off::default()
            },
        ),
        (
            1.2,
            Off {
                height_m: -0.05,
                pitch_deg: 2.0,
                ..Off::default()
            },
        ),
        (
            1.8,
            Off {
                bias_deg: -3.0,
                bandwidth: 0.02,
                ..Off::default()
            },
        ),
        (
            0.9,
            Off {
                height_m: 0.06,
                bias_deg: 0.5,
                pitch_deg: -1.0,
                bandwidth: -0.01,
            },
        ),
    ];
    for (wall_m, off) in cases {
        let found = calibrated(&scan(wall_m, off, ""), wall_m as f32).unwrap();
        // A homing error lowers the beam; a higher nose lifts it.
        let lower = (off.bias_deg - off.pitch_deg).to_radians();
        // If the configured bandwidth is smaller than the real one, bins and ranges are
        // overestimated.
        let scale = 1.0 - off.bandwidth;
        let values = [
            ("height", found.height_m, 0.4 + off.height_m, 0.004),
            ("offset", found.offset_rad, lower, 0.15_f64.to_radians()),
            ("scale", found.scale, scale, 0.002),
        ];
        for (what, estimate, real, within) in values {
            let error = f64::from(estimate.value) - real;
            assert!(
                error.abs() < within,
                "{what} at {wall_m} m: {estimate:?}, really {real}"
            );
            let sigmas = error.abs() / f64::from(estimate.sigma());
            assert!(
                sigmas < 4.0,
                "{what} at {wall_m} m: {sigmas} standard errors off"
            );
        }
        let echo = f64::from(found.mirror_echo_m.value);
        assert!((echo - 0.22).abs() < 0.022, "{echo}");
    }
}

/// Scans the repository's stair A with `config` after `change` has changed its samples.
fn stairs(config: Config, change: impl Fn(&mut Recording)) -> Answer {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    let mut recording = Recording::read(&dir.join("stair_a")).unwrap();
    change(&mut recording);
    let options = Options {
        config,
        ..Options::default()
    };
    replay::answer(&recording, &options).unwrap()
}

#[test]
fn a_calibrated_sweep_gives_distances_as_they_are() {
    let wide = |recording: &mut Recording| recording.meta.bandwidth_hz *= 1.02;
    let first = |answer: &Answer| metres(answer.steps[0].distance);
    let off = stairs(Config::default(), wide);
    assert!((first(&off) - 0.5).abs() > 0.01, "{}", first(&off));
    let mut config = Config::default();
    config.mount.range_scale = 20_000;
    let right = stairs(config, wide);
    assert!((first(&right) - 0.5).abs() < 0.002, "{}", first(&right));
    assert_eq!(right.steps.len(), 3);
}

#[test]
fn a_calibrated_level_betrays_a_gain_that_is_lost() {
    let halve = |recording: &mut Recording| {
        for sample in &mut recording.samples {
            (sample.i, sample.q) = (sample.i / 2, sample.q / 2);
        }
    };
    let mut level = 0.0;
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    let clean = Recording::read(&dir.join("stair_a")).unwrap();
    replay::answers(&clean, &Options::default(), |scanned| {
        level = scanned.pipeline.health().mirror_level_db();
    })
    .unwrap();
    assert!((-100.0..0.0).contains(&level), "{level}");
    let mut config = Config::default();
    let drifts = |answer: Answer| answer.scan.reasons.has(Reason::GainDrift);
    assert!(!drifts(stairs(config, halve)), "nobody has calibrated it");
    config.mount.mirror_level = (level * 1e3) as i32;
    assert!(!drifts(stairs(config, |_| ())));
    assert!(drifts(stairs(config, halve)));
}

#[test]
fn scenes_that_do_not_fit_are_refused_with_a_reason() {
    let none = Off::default();
    // An object before the wall hides it.
    let near = "[[wall]]\nat_m = 1.1\nbottom_m = 0.25\ntop_m = 0.6\nmaterial = \"plaster\"\n";
    let cases = [
        (scan(1.5, none, ""), 1.2, "no wall"),
        (scan(1.5, none, near), 1.5, "no wall"),
        (scan(1.5, none, ""), 3.0, "wall: expected at 0.6 to 2.5 m"),
        (
            scan(
                1.5,
                Off {
                    height_m: 0.2,
                    ..none
                },
                "",
            ),
            1.5,
            "no floor",
        ),
    ];
    for (recording, wall_m, words) in cases {
        let refusal = calibrated(&recording, wall_m).unwrap_err();
        assert!(refusal.contains(words), "{words}: {refusal}");
    }
    let alone = |text: &str| Scene::parse(text).unwrap().simulate("alone", 7);
    let floor = alone("[[floor]]\nto_m = 2.5\nmaterial = \"concrete\"\n");
    assert!(calibrated(&floor, 1.5).unwrap_err().contains("no wall"));
    let wall = alone("[[wall]]\nat_m = 1.5\nbottom_m = 0.15\nmaterial = \"plaster\"\n");
    let refusal = calibrated(&wall, 1.5).unwrap_err();
    assert!(
        refusal.contains("no floor") || refusal.contains("too few echoes"),
        "{refusal}"
    );
    let stairs = "../recordings/stair_a";
    let stairs = Recording::read(stairs.as_ref()).unwrap();
    assert!(calibrated(&stairs, 1.5).is_err());
}

#[test]
fn an_instrument_that_is_not_well_is_not_calibrated() {
    let mut recording = scan(1.5, Off::default(), "");
    for sample in &mut recording.samples {
        sample.q = sample.i;
    }
    let refusal = calibrated(&recording, 1.5).unwrap_err();
    let named =
        refusal.contains("the instrument failed health checks") && refusal.contains("channel-dead");
    assert!(named, "{refusal}");
}

#[test]
fn the_command_prints_what_the_scanner_takes() {
    let scratch = Scratch::new("calibrate");
    let path = scratch.path().join("wall");
    let off = Off {
        height_m: 0.03,
        bias_deg: 1.0,
        ..Off::default()
    };
    scan(1.5, off, "").write(&path).unwrap();
    let path = path.to_str().unwrap();
    let out = sim(&[
        "calibrate",
        path,
        "--wall",
        "1.5",
        "--home-angle",
        "-160000",
    ]);
    let text = String::from_utf8(out.stdout).unwrap();
    assert_eq!(out.status.code(), Some(0), "{text}");
    let mut settings = Settings::default();
    for line in text
        .lines()
        .map(str::trim)
        .filter(|line| line.starts_with("$PSTC"))
    {
        let Ok(stairscan::scanner::command::Command::Set(key, value)) =
            stairscan::scanner::command::parse(line)
        else {
            panic!("{line}: no command that sets");
        };
        settings.set(key, value).unwrap();
    }
    let (mount, home) = (settings.config.mount, settings.motor.home_angle);
    assert!(
        (mount.mount_height - 43_000).abs() < 400,
        "{}",
        mount.mount_height
    );
    assert!((home + 159_000).abs() < 150, "{home}");
    assert!(
        (mount.mirror_echo - 22_000).abs() < 1_000,
        "{}",
        mount.mirror_echo
    );
    let refused = sim(&["calibrate", path, "--wall", "1.2"]);
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        message.contains("wall: no wall: expected a strong echo"),
        "{message}"
    );
    assert!(refused.stdout.is_empty());
}

/// The command `calibrate` on the scanner and this program give the same result for the same scan.
#[test]
fn the_scanner_finds_what_the_program_finds() {
    let off = Off {
        height_m: 0.03,
        bias_deg: 1.0,
        ..Off::default()
    };
    for (wall_m, else_there) in [
        (1.5, ""),
        (
            1.5,
            "[[wall]]\nat_m = 1.1\nbottom_m = 0.25\ntop_m = 0.6\nmaterial = \"plaster\"\n",
        ),
    ] {
        let recording = scan(wall_m, off, else_there);
        let playback = Playback::new(&recording, &Config::default()).unwrap();
        let config = playback.config();
        let mut pipeline = Box::new(Pipeline::new());
        pipeline.begin(config, 1).unwrap();
        for row in 0..config.sweep.angle_count {
            let chirp = recording.chirp(usize::from(row)).unwrap();
            pipeline.samples().copy_from_slice(chirp);
            pipeline.row(row);
        }
        let found = pipeline.calibrate(wall_m as f32);
        match calibrated(&recording, wall_m as f32) {
            Ok(mounting) => assert_eq!(found, Ok(mounting)),
            Err(error) => {
                let expected = found.unwrap_err().expected;
                assert!(error.contains(expected), "{error}: {expected}");
            }
        }
    }
}

/// The example of `--help` works on the recording that it creates.
#[test]
fn the_example_calibrates() {
    let scratch = Scratch::new("calibrate-example");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/wall.toml");
    let wall = scratch.path().join("wall");
    let wall = wall.to_str().unwrap();
    assert!(sim(&["simulate", scene, "-o", wall]).status.success());
    let line = SIM.examples_of("calibrate").next().unwrap();
    let words = line
        .split(' ')
        .map(|word| if word == "wall" { wall } else { word });
    let done = sim(&words.collect::<Vec<_>>());
    let printed = String::from_utf8(done.stdout).unwrap();
    let message = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.success(), "{message}");
    assert!(printed.contains("mount height"), "{printed}");
}
