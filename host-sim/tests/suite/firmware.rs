//! Tests of the firmware image in the emulator: the same file that is flashed.
//!
//! A boot is expensive (a scan takes some ten seconds), so that each test uses one boot for many checks. Without the
//! chip's target or QEMU the tests report it and pass, except in CI.

mod crashes;
mod faults;

use std::path::{Path, PathBuf};
use std::time::Duration;

use host_sim::budgets;
use host_sim::commands::full_scans;
use host_sim::emulate::session::Waits;
use host_sim::emulate::tools::Tool;
use host_sim::emulate::{Fault, Session, guarding, image};
use host_sim::playback::Playback;
use host_sim::recording::Recording;
use host_sim::replay;
use host_sim::scene::Scene;
use host_sim::scene::driving::Drive;
use stairscan::config::Config;
use stairscan::report::{BootLine, CrashSite, LiveLine, ScanLine, Sentence, Tenths};
use stairscan::scanner::Settings;
use stairscan::scanner::command::framed;
use stairscan::schedule::{Schedule, shaft_angle};
use stairscan::verdict::{Reason, Status};
use stairscan_boot::frame::{Frame, Kind, MAX_FRAME, encode};

use crate::common::{elf, replayed, sim, tools};

fn recordings() -> PathBuf {
    image::workspace().join("recordings")
}

fn read(name: &str) -> Recording {
    Recording::read(&recordings().join(name)).unwrap()
}

/// Returns every third row of a recording: a scan takes a third of the time.
fn thinned(full: &Recording) -> Recording {
    let rows: Vec<usize> = (0..full.chirps()).step_by(3).collect();
    let mut thin = full.clone();
    thin.meta.angles_deg = rows.iter().map(|&k| full.meta.angles_deg[k]).collect();
    thin.samples = rows
        .iter()
        .flat_map(|&k| full.chirp(k).unwrap().to_vec())
        .collect();
    thin
}

/// Boots, configures and connects a session.
fn start<'a>(elf: &Path, playback: &'a Playback<'a>, waits: Waits) -> Session<'a> {
    let mut session = Session::boot(elf, playback).unwrap();
    session.configure(&playback.settings(), waits).unwrap();
    session.skip_lines();
    session.connect().unwrap();
    session
}

/// Whether a scan has no fault and no lost rows. Horizon and status `ok` are up to the estimator and not checked
/// here.
fn is_sound(scan: &ScanLine) -> bool {
    scan.status != Status::Fault && scan.lost_rows == 0 && !scan.reasons.has(Reason::LostRows)
}

fn head(sentences: &[String]) -> ScanLine {
    match Sentence::parse(&sentences[0]) {
        Ok(Sentence::Scan(scan)) => scan,
        other => panic!("{other:?} is no SCAN"),
    }
}

fn body(line: &str) -> &str {
    line.trim_start_matches("$PSTR,")
        .rsplit_once('*')
        .unwrap()
        .0
}

/// The first recording of each plane with all its rows, the others with every other one: the emulator takes half a
/// minute for a whole scan.
#[test]
fn every_recording_gives_the_bytes_that_replay_gives() {
    let Some(elf) = elf() else { return };
    for path in full_scans(&recordings()).unwrap() {
        let mut recording = Recording::read(&path).unwrap();
        if !["stair_a", "descending"].contains(&recording.name.as_str()) {
            recording = every_other(&recording);
        }
        let playback = Playback::new(&recording, &Config::default()).unwrap();
        let mut session = start(elf, &playback, Waits::default());
        let scanned = session.scan().unwrap();
        assert_eq!(scanned, replayed(&recording, 1)[0], "{}", recording.name);
    }
}

#[test]
fn guard_sweeps_give_the_bytes_that_replay_gives() {
    let Some(elf) = elf() else { return };
    let recording = read("guard_kerb");
    let options = replay::Options {
        by_trigger: true,
        ..replay::Options::default()
    };
    let words = replay::guarded(&recording, &options).unwrap();
    let expected: Vec<String> = words.into_iter().map(|word| word.sentence).collect();
    let with = (Waits::default(), &[][..]);
    // Both directions, and the third sweep averaged with the two before it.
    let sweeps = 3;
    let found = guarding::sentences(elf, &recording, &Config::default(), sweeps, with).unwrap();
    assert_eq!(found, expected[..sweeps]);
}

/// A recording of two scans with different pitch. The settings of the second are sent by command during the first.
#[test]
fn a_sequence_gives_the_bytes_that_replay_gives() {
    let Some(elf) = elf() else { return };
    let mut recording = read("stair_a");
    let meta = &mut recording.meta;
    meta.motion.pitch_deg = [vec![0.25; 281], vec![-0.5; 281]].concat();
    let back: Vec<f64> = meta.angles_deg.iter().rev().copied().collect();
    meta.angles_deg.extend(back);
    meta.sequence.scans = 2;
    let back: Vec<_> = recording
        .samples
        .chunks(200)
        .rev()
        .flatten()
        .copied()
        .collect();
    recording.samples.extend(back);
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let mut session = start(elf, &playback, Waits::default());
    let mut scanned = Vec::new();
    let scans = session.scans(2, |_, sentences| {
        scanned.push(sentences);
        Ok(())
    });
    scans.unwrap();
    let expected = replayed(&recording, 2);
    assert_eq!(scanned, expected);
    assert_ne!(expected[0][1..], expected[1][1..]);
}

/// Scans of a chair that drives on between them, with its motion sentences and the evidence of earlier scans: the image reports
/// the same as `replay`, lengths to a millimetre. In both, sentences are sent with the triggers, since the emulator's clock
/// runs fast by a factor that depends on the machine. For the same reason the chair stands while a scan is made: the speed
/// that turns a driving chair's rows back is measured by that clock.
#[test]
fn a_drive_gives_what_replay_gives() {
    let Some(elf) = elf() else { return };
    let scene = Scene::parse(
        "[[stairs]]\ndistance_m = 1.2\ncount = 3\nrise_m = 0.17\ngoing_m = 0.29\n\
         material = \"concrete\"\n[[floor]]\nmaterial = \"concrete\"\n",
    );
    const SCANS: usize = 3;
    let drive = Drive::new(11, SCANS, 0.2).with_rows(1e-6);
    let full = scene.unwrap().simulate_drive("driven", 11, &drive).unwrap();
    let driven = every_other(&full);
    let playback = Playback::new(&driven, &Config::default())
        .unwrap()
        .by_trigger();
    let mut session = start(elf, &playback, Waits::default());
    let mut scanned = Vec::new();
    let scans = session.scans(SCANS, |_, sentences| {
        scanned.push(sentences);
        Ok(())
    });
    scans.unwrap();
    let expected = |by_trigger: bool, single: bool| -> Vec<Vec<String>> {
        let options = replay::Options {
            by_trigger,
            single,
            ..replay::Options::default()
        };
        let answers = replay::answers(&driven, &options, |_| ()).unwrap();
        answers.into_iter().map(|a| a.sentences).collect()
    };
    let fused = expected(true, false);
    for (image, host) in scanned.iter().flatten().zip(fused.iter().flatten()) {
        assert!(says_the_same(image, host), "{image}\n{host}");
    }
    let counts = |scans: &[Vec<String>]| scans.iter().map(Vec::len).collect::<Vec<_>>();
    assert_eq!(counts(&scanned), counts(&fused));
    // The motion input was used, and so was the evidence of earlier scans.
    let last = head(&scanned[SCANS - 1]);
    for reason in [Reason::MotionInput, Reason::Moving, Reason::Unconfirmed] {
        assert!(!last.reasons.has(reason), "{last:?}");
    }
    assert_ne!(fused[SCANS - 1][1..], expected(true, true)[SCANS - 1][1..]);
    let good = session.live.iter().any(|line| line.contains(",good,0,"));
    assert!(good, "{:?}", session.live.last());
}

/// Whether two sentences of a scan differ by at most 1 mm in any length, and a `MAYBE` by at most 1 %: which rows count to a
/// drive follows from the times of sentences and rows.
fn says_the_same(a: &str, b: &str) -> bool {
    let near = |a: Tenths, b: Tenths| a.0.abs_diff(b.0) <= 10;
    let nearly = |a: Option<Tenths>, b: Option<Tenths>| match (a, b) {
        (Some(a), Some(b)) => near(a, b),
        (a, b) => a == b,
    };
    match (Sentence::parse(a), Sentence::parse(b)) {
        (Ok(Sentence::Scan(a)), Ok(Sentence::Scan(b))) => {
            let confidence = |s: &ScanLine| s.confidence.unwrap_or(0);
            let rest = ScanLine {
                horizon: b.horizon,
                confidence: b.confidence,
                ..a
            };
            rest == b
                && match (a.horizon, b.horizon) {
                    (Some(a), Some(b)) => near(a, b),
                    (a, b) => a == b,
                }
                && confidence(&a).abs_diff(confidence(&b)) <= 1
        }
        (Ok(Sentence::Step(a)), Ok(Sentence::Step(b))) => {
            (a.scan, a.index, a.count, a.quality) == (b.scan, b.index, b.count, b.quality)
                && near(a.distance, b.distance)
                && near(a.height, b.height)
                && near(a.distance_sigma, b.distance_sigma)
                && near(a.height_sigma, b.height_sigma)
                && nearly(a.tread, b.tread)
                && nearly(a.riser, b.riser)
        }
        (Ok(Sentence::Maybe(a)), Ok(Sentence::Maybe(b))) => {
            (a.scan, a.index, a.count) == (b.scan, b.index, b.count)
                && near(a.distance, b.distance)
                && near(a.height, b.height)
                && a.probability.abs_diff(b.probability) <= 10
        }
        _ => a == b,
    }
}

/// Returns every other row of each scan of a drive: half of the time.
fn every_other(full: &Recording) -> Recording {
    let per_scan = full.chirps_per_scan();
    let rows: Vec<usize> = (0..full.chirps())
        .filter(|k| (k % per_scan).is_multiple_of(2))
        .collect();
    let mut thin = full.clone();
    let pick =
        |all: &[f64]| -> Vec<f64> { rows.iter().filter_map(|&k| all.get(k).copied()).collect() };
    let (meta, whole) = (&mut thin.meta, &full.meta);
    meta.angles_deg = pick(&whole.angles_deg);
    meta.motion.travel_m = pick(&whole.motion.travel_m);
    meta.motion.pitch_deg = pick(&whole.motion.pitch_deg);
    meta.motion.time_s = pick(&whole.motion.time_s);
    let chirps = rows.iter().flat_map(|&k| full.chirp(k).unwrap().to_vec());
    thin.samples = chirps.collect();
    thin
}

/// Two scans, one in each direction: every pulse is accounted for, commands are answered meanwhile, bad input is
/// refused, and the stack is within its budget.
#[test]
fn two_scans_stand_on_the_schedule_and_answer_commands() {
    let Some(elf) = elf() else { return };
    let recording = read("stair_a");
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let mut session = start(elf, &playback, Waits::default());
    let boot = session.lines[0].clone();
    let revision = concat!("BOOT,", env!("CARGO_PKG_VERSION"), ",");
    assert!(
        boot.contains(revision) && boot.contains(",hsi-16,1,"),
        "{boot}"
    );
    // The emulator's SRAM goes on where a larger chip has SRAM3, and it has no CCM.
    assert!(boot.contains(",sram3-64,"), "{boot}");

    await_first_trigger(&mut session);
    ask_everything(&mut session);
    bad_input(&mut session);
    // The replies above came between the sentences of the first scan, which are complete.
    let expected = replayed(&recording, 2);
    session.rewind();
    assert_eq!(session.scan().unwrap(), expected[0]);
    assert_eq!(session.scan().unwrap(), expected[1]);
    check_shots(&session, playback.config());

    let used: u32 = value(&session.command("get,stack-used").unwrap());
    let size: u32 = value(&session.command("get stack-size").unwrap());
    assert!(
        used > 1024 && u64::from(used) <= budgets::STACK && u64::from(size) == budgets::STACK_SIZE,
        "{used} of {size}"
    );
    assert_eq!(session.module.garbage(), 0);

    stop_start_scan(&mut session);
    check_live(&session);
}

/// Checks that `LIVE` is sent in every lasting state, that its time never decreases, and that errors are counted.
fn check_live(session: &Session<'_>) {
    let live = session.live.iter().map(|line| match Sentence::parse(line) {
        Ok(Sentence::Live(live)) => live,
        other => panic!("{other:?} is no LIVE"),
    });
    let live: Vec<LiveLine<'_>> = live.collect();
    for state in ["self-test", "scanning", "idle"] {
        assert!(live.iter().any(|l| l.state == state), "no LIVE in {state}");
    }
    for pair in live.windows(2) {
        let ms = pair[1].uptime_ms - pair[0].uptime_ms;
        assert!(ms > 0 && pair[0].scan <= pair[1].scan, "{pair:?}");
    }
    assert_eq!(live[0].age_ms, None);
    let last = live.last().unwrap();
    // The bad input above: lines that are no commands are counted, refused values are not.
    assert_eq!((last.refused, last.age_ms.is_some()), (7, true), "{last:?}");
    assert_eq!((last.motion, last.port_errors), ("absent", 0));
}

/// Waits until the scanner scans.
fn await_first_trigger(session: &mut Session<'_>) {
    for _ in 0..600 {
        if !session.shots.is_empty() {
            return;
        }
        session.idle(Duration::from_millis(100)).unwrap();
    }
    panic!("no trigger within a minute");
}

fn value(line: &str) -> u32 {
    match Sentence::parse(line) {
        Ok(Sentence::Config { value, .. }) => value.parse().unwrap(),
        other => panic!("{other:?} is no CONF"),
    }
}

fn ask_everything(session: &mut Session<'_>) {
    let status = session.command("status").unwrap();
    assert!(
        body(&status).starts_with("STAT,scanning,hsi-16,1,"),
        "{status}"
    );
    let version = session.command("version").unwrap();
    let expected = concat!("CONF,version,", env!("CARGO_PKG_VERSION"), " ");
    assert!(body(&version).starts_with(expected), "{version}");
    let bandwidth = session.command("get,radar-bandwidth").unwrap();
    assert_eq!(body(&bandwidth), "CONF,radar-bandwidth,10000000");
    for command in ["scan", "selftest"] {
        let refused = session.command(command).unwrap();
        let expected = format!("FAIL,{command},state,idle: stop first");
        assert_eq!(body(&refused), expected);
    }
    session.set("fault-hold", "1000000").unwrap();
    session.type_bytes(b"get\n").unwrap();
    for key in Settings::KEYS {
        let line = session.next_line("a setting").unwrap();
        assert!(body(&line).starts_with(&format!("CONF,{key},")), "{line}");
    }
    assert_eq!(body(&session.next_line("the end").unwrap()), "DONE,get");
}

fn bad_input(session: &mut Session<'_>) {
    let long = "x".repeat(300);
    for (line, expected) in [
        ("launch", "FAIL,-,command,"),
        ("set,seed,-1", "FAIL,set,seed,"),
        (
            "set,angle-count,8193",
            "FAIL,set,angle-count,3 to 8192 (angles)",
        ),
        ("set,plane,sideways", "FAIL,set,plane,depth or height"),
        ("set,seed,7", "FAIL,set,crc,send $PSTC,set,seed,7*"),
        ("save", "FAIL,save,crc,send $PSTC,save*"),
        ("$PSTC,save*61B7335C", "FAIL,save,state,idle: stop first"),
        ("set,nothing,1", "FAIL,set,key,"),
        ("set,seed", "FAIL,set,seed,a value"),
        ("status now", "FAIL,status,arguments,"),
        ("set,radar-samples,64", "FAIL,set,radar-samples,no value"),
        ("$PSTC,stop*00000000", "FAIL,-,crc,"),
        (&long, "FAIL,-,line,at most 96"),
        ("\u{0}\u{1}\u{7f}\u{ff}", "FAIL,-,line,printable"),
    ] {
        let answer = session.command(line).unwrap();
        assert!(body(&answer).starts_with(expected), "{line}: {answer}");
    }
    let status = session.command("status").unwrap();
    assert!(
        body(&status).starts_with("STAT,scanning,"),
        "the scan goes on: {status}"
    );
}

/// Checks that each trigger contains exactly its row's microstep. The pulses counted since homing agree with it, or
/// show that the mirror has moved on meanwhile: a trigger is read later than it was sent, and the mirror waits only
/// for the chirp's duration. `sweep_modes.rs` finds the places where it stood.
fn check_shots(session: &Session<'_>, config: &Config) {
    let schedule = Schedule::new(config).unwrap();
    let rows = usize::from(schedule.rows());
    assert!(session.shots.len() >= 2 * rows);
    for (k, shot) in session.shots.iter().take(2 * rows).enumerate() {
        let row = if k < rows { k } else { 2 * rows - 1 - k };
        let position = schedule.position(row as u16);
        let next = match k % rows == rows - 1 {
            true => row as u16,
            false if k < rows => row as u16 + 1,
            false => row as u16 - 1,
        };
        let (here, there) = (i64::from(position), i64::from(schedule.position(next)));
        let seen = shot.position.unwrap();
        assert!(
            (here.min(there)..=here.max(there)).contains(&seen),
            "trigger {k}: {seen}, not {here} to {there}"
        );
        assert_eq!(
            shot.trigger.shaft_angle,
            shaft_angle(position),
            "trigger {k}"
        );
        assert_eq!(shot.trigger.attempt, u32::from(k == rows), "trigger {k}");
    }
    assert_eq!(session.shaft.idle_pulses(), 0, "pulses with the driver off");
}

/// Checks that nothing moves while stopped, that `scan` makes one scan, and that `start` continues.
fn stop_start_scan(session: &mut Session<'_>) {
    assert_eq!(body(&session.command("stop").unwrap()), "DONE,stop");
    session.idle(Duration::from_millis(100)).unwrap();
    let pulses = session.shaft.pulses();
    session.idle(Duration::from_millis(300)).unwrap();
    assert_eq!(session.shaft.pulses(), pulses, "moved while stopped");
    assert!(!session.shaft.enabled(), "the driver is on while stopped");
    session.set("angle-count", "24").unwrap();
    // The emulator has no flash controller: saved settings would be lost.
    let save = framed(&["save"]);
    assert_eq!(
        body(&session.command(save.trim_end()).unwrap()),
        "FAIL,save,flash,a responding flash controller"
    );
    for command in ["selftest", "scan"] {
        session.command(command).unwrap();
    }
    let scan = head(&session.scan().unwrap());
    session.idle(Duration::from_millis(300)).unwrap();
    let status = session.command("status").unwrap();
    let expected = format!("STAT,idle,hsi-16,{},", scan.scan);
    assert!(body(&status).starts_with(&expected), "{status}");
    assert_eq!(body(&session.command("start").unwrap()), "DONE,start");
    assert_eq!(head(&session.scan().unwrap()).scan, scan.scan + 1);
}
