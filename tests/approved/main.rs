//! Answers to scans with and without faults, compared with the approved ones in the text files of this folder: a line
//! with the answer, and one with checksums over the figures of each stage, which the last bit moves.
//!
//! The other tests ask whether an answer is right; this one shows which answers a change moves, and at which stage. Where
//! the move is intended, `APPROVE=1 cargo test --test approved` writes the file anew, and the change carries its
//! difference.

mod alter;

use std::fmt::Write;
use std::fs;
use std::path::Path;

use stairscan::Iq;
use stairscan::config::{Config, EstimatorKind, MountConfig, Planes, SweepConfig};
use stairscan::crc::CRC32;
use stairscan::drive::{Drive, Input, Mode, Retention};
use stairscan::health::Expected;
use stairscan::observer::{Event, Observer};
use stairscan::pipeline::Pipeline;
use stairscan::report::sentence::{ScanId, write_scan};
use stairscan::scanner::DataPath;
use stairscan::track::{RowPose, Track};
use stairscan::verdict::{Conditions, Outcome, Reason, Reasons};

use alter::{ALTERATIONS, Alteration, Chirps};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Complex samples of a chirp in the repository's recordings.
const SAMPLES: usize = 200;
/// Rows of one guard sweep of `recordings/guard_kerb`.
const GUARD_ROWS: u16 = 31;

/// Returns the chirps of a recording in `recordings/`.
fn chirps(name: &str) -> Chirps {
    let bytes = fs::read(Path::new(ROOT).join(format!("recordings/{name}.sigmf-data"))).unwrap();
    let part = |b: &[u8]| i16::from_le_bytes([b[0], b[1]]);
    let sample = |b: &[u8]| Iq::new(part(&b[..2]), part(&b[2..]));
    let samples: Vec<Iq> = bytes.chunks(4).map(sample).collect();
    samples.chunks(SAMPLES).map(<[Iq]>::to_vec).collect()
}

/// The configuration of a recording's scanner.
fn config(name: &str) -> Config {
    let mut config = Config {
        seed: 1,
        ..Config::default()
    };
    if name == "descending" {
        config.mount = MountConfig {
            plane: Planes::Height,
            mount_height: 120_000,
            ..config.mount
        };
    }
    config
}

/// The text of all events, by kind.
#[derive(Default)]
struct Events(Vec<(String, Vec<u8>)>);

impl Observer for Events {
    fn event(&mut self, event: Event<'_>) {
        if matches!(event, Event::Done(_)) {
            return;
        }
        let text = match event {
            // By the particles themselves, so that the figure does not depend on the names of the event's fields.
            Event::Particles {
                stage,
                particles,
                clusters,
            } => format!("Particles {stage:?} {particles:?} {clusters:?}"),
            _ => format!("{event:?}"),
        };
        let kind = text.split([' ', '(']).next().unwrap_or_default();
        match self.0.iter_mut().find(|(of, _)| of == kind) {
            Some((_, texts)) => texts.extend(text.as_bytes()),
            None => self.0.push((kind.into(), text.into_bytes())),
        }
    }
}

/// The checksum of a text: it differs where a figure of a stage has moved.
fn bits(text: impl AsRef<[u8]>) -> String {
    format!("{:08x}", CRC32.checksum(text.as_ref()))
}

/// Circumstances of a scan besides its chirps.
#[derive(Clone, Copy)]
struct Circumstances<'a> {
    config: Config,
    drive: Drive<'a>,
    conditions: Conditions,
    backwards: bool,
}

impl Circumstances<'_> {
    fn of(config: Config) -> Self {
        Self {
            config,
            drive: Drive::STANDING,
            conditions: Conditions::GOOD,
            backwards: false,
        }
    }
}

/// Passes `chirps` to the pipeline, row by row; an empty chirp is a lost row.
fn feed(pipeline: &mut Pipeline, chirps: &[Vec<Iq>], backwards: bool) {
    let rows = chirps.len();
    for k in 0..rows {
        let row = if backwards { rows - 1 - k } else { k };
        let chirp = &chirps[row];
        if chirp.is_empty() {
            pipeline.lost(row as u16);
        } else {
            pipeline.samples().copy_from_slice(chirp);
            pipeline.row(row as u16);
        }
    }
}

/// Returns the checksums of map and detections, and of the health checks, of the scan that `pipeline` has just made.
fn checks(pipeline: &Pipeline, config: &Config, moving: bool) -> String {
    let (map, health) = (pipeline.map(), pipeline.health());
    let cells: Vec<u8> = (0..map.rows()).flat_map(|k| map.row(k)).copied().collect();
    let found = (0..map.rows()).flat_map(|k| map.detections(k).map(move |(bin, _)| (k, bin)));
    let found: Vec<u8> = found.flat_map(|(k, bin)| [k as u8, bin as u8]).collect();
    let mut checked = format!(
        "noise {}, fault {:?}, echo {}, mirror {:?}",
        health.noise(),
        health.fault(config.mount.mirror_offset > 0),
        health.has_echo(map),
        health.mirror_seen(config)
    );
    let expected = Expected {
        moving,
        uncalibrated: false,
    };
    health.report_checks(config, map, expected, &mut |check| {
        let reason = check.reason.as_str();
        write!(checked, " {reason} {}/{}", check.value, check.limit).unwrap();
    });
    let map = bits([cells, found].concat());
    format!("map {map} checks {}", bits(checked))
}

/// Returns the answer in words, from its sentences.
fn words(sentences: &str, outcome: &Outcome) -> String {
    let fields = |line: &str| -> Vec<String> {
        let body = line.split('*').next().unwrap_or_default();
        body.split(',').map(str::to_owned).collect()
    };
    let mut text = String::new();
    for line in sentences.lines().map(fields) {
        let line: Vec<&str> = line.iter().map(String::as_str).collect();
        match line[..] {
            [
                "$PSTR",
                "SCAN",
                _,
                status,
                direction,
                _,
                _,
                reasons,
                horizon,
                confidence,
                ..,
            ] => {
                write!(text, "{status} {direction}").unwrap();
                if !reasons.is_empty() {
                    write!(text, " ({reasons})").unwrap();
                }
                write!(text, ", valid to {horizon} mm at {confidence} %").unwrap();
            }
            [
                "$PSTR",
                "STEP",
                _,
                _,
                _,
                distance,
                height,
                _,
                _,
                distance_sigma,
                height_sigma,
                ..,
            ] => {
                write!(
                    text,
                    "; {distance}±{distance_sigma} {height}±{height_sigma}"
                )
                .unwrap();
            }
            ["$PSTR", kind, _, ref rest @ ..] => {
                write!(text, "; {} {}", kind.to_lowercase(), rest.join(" ")).unwrap();
            }
            _ => panic!("{line:?} is no sentence"),
        }
    }
    if let Some(free_m) = outcome.free_m() {
        write!(text, "; free {free_m:.3} m").unwrap();
    }
    text
}

/// Makes one full scan and prints its figures.
fn scan(
    name: &str,
    pipeline: &mut Pipeline,
    number: u32,
    chirps: &[Vec<Iq>],
    of: &Circumstances<'_>,
    out: &mut String,
) {
    pipeline.begin(&of.config, number).unwrap();
    feed(pipeline, chirps, of.backwards);
    let checks = checks(pipeline, &of.config, of.drive.track.is_some());
    let mut events = Events::default();
    let outcome = pipeline.conclude_observed(&of.drive, of.conditions, &mut events);
    let mut sentences = String::new();
    write_scan(
        ScanId {
            scan: number,
            settings: 0,
        },
        0,
        &outcome,
        |line| {
            sentences.push_str(line.as_str());
        },
    );
    writeln!(out, "{name}: {}", words(&sentences, &outcome)).unwrap();
    write!(out, "  {checks}").unwrap();
    for (kind, texts) in &events.0 {
        write!(out, " {} {}", kind.to_lowercase(), bits(texts)).unwrap();
    }
    writeln!(out, " sentences {}", bits(&sentences)).unwrap();
}

/// Every recording, untouched and with each alteration.
fn alterations(out: &mut String) {
    let mut pipeline = Box::new(Pipeline::new());
    for name in ["stair_a", "stair_b", "stair_c", "descending", "empty"] {
        let of = Circumstances::of(config(name));
        scan(name, &mut pipeline, 1, &chirps(name), &of, out);
    }
    for name in ["stair_a", "descending", "empty"] {
        for (alteration, alter) in ALTERATIONS {
            let mut chirps = chirps(name);
            alter(&mut chirps);
            let title = format!("{name}, {alteration}");
            let of = Circumstances::of(config(name));
            scan(&title, &mut pipeline, 1, &chirps, &of, out);
        }
    }
}

/// Settings that differ from those of the recording's scanner.
fn settings(out: &mut String) {
    let mut pipeline = Box::new(Pipeline::new());
    type Change = (&'static str, fn(&mut Config));
    let mounts: [Change; 9] = [
        ("height 2 cm more", |c| c.mount.mount_height += 2_000),
        ("height 5 cm less", |c| c.mount.mount_height -= 5_000),
        ("range scale 2 %", |c| c.mount.range_scale = 20_000),
        ("beam of 3 deg", |c| c.mount.beamwidth = 3_000),
        ("mirror echo calibrated", |c| {
            (c.mount.mirror_echo, c.mount.mirror_level) = (22_300, -20_000)
        }),
        ("first angle 1 deg less", |c| c.sweep.first_angle -= 1_000),
        ("false alarms 1e-5", |c| c.cfar.false_alarm = 1e-5),
        ("without a mirror", |c| c.mount.mirror_offset = 0),
        ("paper's estimator", |c| c.estimator = EstimatorKind::Paper),
    ];
    for name in ["stair_c", "descending", "empty"] {
        for (title, change) in mounts {
            let mut of = Circumstances::of(config(name));
            change(&mut of.config);
            let title = format!("{name}, {title}");
            scan(&title, &mut pipeline, 1, &chirps(name), &of, out);
        }
        let mut of = Circumstances::of(config(name));
        of.backwards = true;
        scan(
            &format!("{name}, backwards"),
            &mut pipeline,
            1,
            &chirps(name),
            &of,
            out,
        );
    }
}

/// A track along which the chair moves by `travel_m` and pitches by `pitch_rad` over a scan of `rows`.
fn track(rows: u16, travel_m: f32, pitch_rad: f32) -> Track {
    let mut track = Track::new();
    track.begin(rows);
    for row in 0..rows {
        let share = f32::from(row) / f32::from(rows - 1);
        let pose = RowPose {
            time_s: share,
            travel_m: travel_m * share,
            pitch_rad: pitch_rad * share,
        };
        track.add(row, pose);
    }
    track
}

/// Motion and conditions: the same chirps several times in a row, the evidence kept from scan to scan.
fn sequences(out: &mut String) {
    let (still, creeping) = (track(281, 0.0, 0.0), track(281, 0.02, 0.004));
    let moved = |track, moved_m: f32| Drive {
        mode: Mode::Auto,
        input: Input::Good,
        track: Some(track),
        moved_m: Some(moved_m),
        since_s: Some(1.5),
        chirp_s: 0.001,
        memory: Retention::Kept,
        ..Drive::STANDING
    };
    let without = |mode, input| Drive {
        mode,
        input,
        memory: Retention::Kept,
        ..Drive::STANDING
    };
    let steps = [
        ("standing", moved(&still, 0.0)),
        ("standing again", moved(&still, 0.0)),
        ("2 cm on", moved(&creeping, 0.02)),
        (
            "aside",
            Drive {
                memory: Retention::Aside,
                ..moved(&still, 0.0)
            },
        ),
        ("without motion input", without(Mode::Auto, Input::Absent)),
        ("input late", without(Mode::Auto, Input::Late)),
        ("input required", without(Mode::Required, Input::Garbled)),
        (
            "anew",
            Drive {
                memory: Retention::Anew,
                ..moved(&still, 0.0)
            },
        ),
    ];
    for name in ["stair_a", "descending", "empty"] {
        let mut pipeline = Box::new(Pipeline::new());
        let chirps = chirps(name);
        for (number, (title, drive)) in (1..).zip(steps) {
            let mut of = Circumstances::of(config(name));
            of.drive = drive;
            of.backwards = number % 2 == 0;
            scan(
                &format!("{name}, {number}: {title}"),
                &mut pipeline,
                number,
                &chirps,
                &of,
                out,
            );
        }
    }
    let conditions = [
        (
            "supply low",
            Conditions {
                board: Reasons::NONE.with(Reason::Supply),
                ..Conditions::GOOD
            },
        ),
        (
            "not configured",
            Conditions {
                configured: false,
                ..Conditions::GOOD
            },
        ),
        (
            "rows lost",
            Conditions {
                lost_rows: true,
                ..Conditions::GOOD
            },
        ),
    ];
    for (title, conditions) in conditions {
        let mut of = Circumstances::of(config("stair_b"));
        of.conditions = conditions;
        let title = format!("stair_b, {title}");
        scan(
            &title,
            &mut Box::new(Pipeline::new()),
            1,
            &chirps("stair_b"),
            &of,
            out,
        );
    }
}

/// Guard sweeps, one after the other, with and without motion input and alterations.
fn guard(out: &mut String) {
    let config = Config {
        sweep: SweepConfig {
            first_angle: 8_000,
            angle_step: 1_000,
            angle_count: GUARD_ROWS,
        },
        ..config("guard_kerb")
    };
    let still = track(GUARD_ROWS, 0.0, 0.0);
    let moving = track(GUARD_ROWS, 0.009, 0.001);
    let known = |track| Drive {
        mode: Mode::Auto,
        input: Input::Good,
        track: Some(track),
        moved_m: Some(0.019),
        since_s: Some(0.13),
        chirp_s: 0.001,
        ..Drive::STANDING
    };
    let unknown = Drive {
        mode: Mode::Auto,
        since_s: Some(0.13),
        ..Drive::STANDING
    };
    let late = Drive {
        input: Input::Late,
        since_s: Some(2.0),
        ..unknown
    };
    let drives = [
        ("moving", known(&moving)),
        ("track of one that stands", known(&still)),
        ("no input", unknown),
        ("late", late),
    ];
    let untouched: Alteration = ("untouched", |_| ());
    let alterations = [untouched].into_iter().chain(ALTERATIONS);
    let cases = drives
        .into_iter()
        .map(|drive| (drive, untouched))
        .chain(alterations.map(|alteration| (drives[0], alteration)));
    for ((motion, drive), (alteration, alter)) in cases {
        let title = format!("guard_kerb, {motion}, {alteration}");
        sweeps(&title, &config, &drive, alter, out);
    }
    let mut without = config;
    without.mount.mirror_offset = 0;
    sweeps(
        "guard_kerb, without a mirror",
        &without,
        &unknown,
        |_| (),
        out,
    );
}

/// Makes the guard sweeps of the recording and prints status and free distance of each, and the checksums of all.
fn sweeps(
    title: &str,
    config: &Config,
    drive: &Drive<'_>,
    alter: fn(&mut Chirps),
    out: &mut String,
) {
    let mut pipeline = Box::new(Pipeline::new());
    let chirps = chirps("guard_kerb");
    let (mut results, mut figures) = (String::new(), String::new());
    write!(out, "{title}:").unwrap();
    for (number, sweep) in (1..).zip(chirps.chunks(GUARD_ROWS.into())) {
        let mut sweep = sweep.to_vec();
        alter(&mut sweep);
        pipeline.begin_guard(config, number).unwrap();
        feed(&mut pipeline, &sweep, false);
        if number == 1 {
            figures = checks(&pipeline, config, true);
        }
        let result = pipeline.guard(drive, Conditions::GOOD);
        write!(results, "{result:?}").unwrap();
        let free = result.free_m().map_or("-".into(), |m| format!("{m:.2} m"));
        let status = result.status().as_str();
        let hazard = format!("{:?}", result.hazard()).to_lowercase();
        write!(out, " {status} {free} {hazard},").unwrap();
    }
    out.pop();
    writeln!(out, "\n  {figures} results {}", bits(&results)).unwrap();
}

/// Compares `printed` with the approved figures, or writes them anew.
fn compare(name: &str, printed: &str) {
    let path = Path::new(ROOT).join(format!("tests/approved/{name}.txt"));
    if std::env::var_os("APPROVE").is_some() {
        fs::write(&path, printed).unwrap();
        return;
    }
    let approved = fs::read_to_string(&path).unwrap();
    let mut title = "";
    for (line, (found, expected)) in (1..).zip(printed.lines().zip(approved.lines())) {
        if !found.starts_with(' ') {
            title = found.split(':').next().unwrap_or(found);
        }
        assert_eq!(
            found, expected,
            "{title}: tests/approved/{name}.txt:{line} has another figure; if the change is meant to move it: APPROVE=1 \
             cargo test --test approved"
        );
    }
    assert_eq!(
        printed.lines().count(),
        approved.lines().count(),
        "{name}: scans are missing or new"
    );
}

#[test]
fn figures_of_altered_recordings() {
    let mut out = String::new();
    alterations(&mut out);
    compare("alterations", &out);
}

#[test]
fn figures_with_other_settings() {
    let mut out = String::new();
    settings(&mut out);
    compare("settings", &out);
}

#[test]
fn figures_of_sequences() {
    let mut out = String::new();
    sequences(&mut out);
    compare("sequences", &out);
}

#[test]
fn figures_of_guard_sweeps() {
    let mut out = String::new();
    guard(&mut out);
    compare("guard", &out);
}
