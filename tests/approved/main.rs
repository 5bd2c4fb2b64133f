//! Every figure of scans with and without faults, compared to the last bit with the approved ones in the text files
//! of this folder.
//!
//! The other tests ask whether an answer is right; this one shows each figure that a change moves: health checks,
//! calibration, likelihoods, sentences. Where the move is intended, `APPROVE=1 cargo test --test approved` writes the
//! file anew, and the change carries its difference.

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
use stairscan::report::sentence::write_scan;
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

/// Checksum of all events of a kind, by their text.
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

impl Events {
    fn print(&self, out: &mut String) {
        for (kind, texts) in &self.0 {
            let text = String::from_utf8_lossy(texts);
            match kind.as_str() {
                "Noise" | "Calibration" | "Floor" | "Lobes" => writeln!(out, "  {text}").unwrap(),
                _ => writeln!(out, "  {kind}: {:08x}", CRC32.checksum(texts)).unwrap(),
            }
        }
    }
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

/// Prints the map's checksum and the health checks of the scan that `pipeline` has just made.
fn print_checks(pipeline: &Pipeline, config: &Config, moving: bool, out: &mut String) {
    let (map, health) = (pipeline.map(), pipeline.health());
    let cells: Vec<u8> = (0..map.rows()).flat_map(|k| map.row(k)).copied().collect();
    let found = (0..map.rows()).flat_map(|k| map.detections(k).map(move |(bin, _)| (k, bin)));
    let found: Vec<u8> = found.flat_map(|(k, bin)| [k as u8, bin as u8]).collect();
    writeln!(
        out,
        "  cells {:08x}, {} detections {:08x}, noise {}, fault {:?}, stood {}, echo {}, mirror {:?}",
        CRC32.checksum(&cells),
        found.len() / 2,
        CRC32.checksum(&found),
        health.noise(),
        health.fault(config.mount.mirror_offset > 0),
        health.stood(),
        health.has_echo(map),
        health.mirror_seen(config)
    )
    .unwrap();
    out.push_str("  checks");
    let expected = Expected {
        moving,
        uncalibrated: false,
    };
    health.report_checks(config, map, expected, &mut |check| {
        write!(
            out,
            " {} {}/{}",
            check.reason.as_str(),
            check.value,
            check.limit
        )
        .unwrap();
    });
    out.push('\n');
}

fn print_outcome(outcome: &Outcome, scan: u32, out: &mut String) {
    writeln!(out, "  free {:?}", outcome.free_m()).unwrap();
    write_scan((scan, 0), 0, outcome, |line| {
        write!(out, "  {}", line.as_str()).unwrap()
    });
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
    writeln!(out, "{name}").unwrap();
    pipeline.begin(&of.config, number).unwrap();
    feed(pipeline, chirps, of.backwards);
    let moving = of.drive.track.is_some();
    print_checks(pipeline, &of.config, moving, out);
    let mut events = Events::default();
    let outcome = pipeline.conclude_observed(&of.drive, of.conditions, &mut events);
    events.print(out);
    print_outcome(&outcome, number, out);
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

/// Makes the guard sweeps of the recording and prints their results, and the figures of the first.
fn sweeps(
    title: &str,
    config: &Config,
    drive: &Drive<'_>,
    alter: fn(&mut Chirps),
    out: &mut String,
) {
    let mut pipeline = Box::new(Pipeline::new());
    let chirps = chirps("guard_kerb");
    for (number, sweep) in (1..).zip(chirps.chunks(GUARD_ROWS.into())) {
        let mut sweep = sweep.to_vec();
        alter(&mut sweep);
        writeln!(out, "{title}, sweep {number}").unwrap();
        pipeline.begin_guard(config, number).unwrap();
        feed(&mut pipeline, &sweep, false);
        if number == 1 {
            print_checks(&pipeline, config, true, out);
        }
        let result = pipeline.guard(drive, Conditions::GOOD);
        writeln!(out, "  {result:?}").unwrap();
    }
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
            title = found;
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
