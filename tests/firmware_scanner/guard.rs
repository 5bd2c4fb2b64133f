//! Tests of `guard` and `watch`: consecutive sweeps, full scans in between, and the conditions that end them.

use stairscan::motion::Reading;
use stairscan::report::{GuardLine, Sentence, Tenths, motion};
use stairscan::scanner::Settings;
use stairscan::scanner::settings::{GuardConfig, SweepMode};
use stairscan::signal::radar::LinkError;
use stairscan::verdict::{FreeGround, HazardKind, Reason, Reasons, Status};

use crate::bench::{Bench, IDENTITY, World};

/// Free distance up to a rise.
const RISE: FreeGround = FreeGround {
    free_m: 1.2,
    hazard: HazardKind::Rise,
    confidence: 0.999,
};

/// Settings of a scanner whose guard accepts any rate.
fn settings(sweep_mode: SweepMode) -> Settings {
    Settings {
        sweep_mode,
        guard: GuardConfig {
            rate: 0,
            ..GuardConfig::default()
        },
        ..Settings::default()
    }
}

/// A stopped scanner in front of a rise.
fn bench(settings: Settings, prepare: impl FnOnce(&mut World)) -> Bench {
    Bench::boot(Some(settings), IDENTITY, |w| {
        w.board.get().stopped = true;
        w.ground = Some(RISE);
        prepare(w);
    })
}

fn sweep(bench: &mut Bench) -> GuardLine {
    let lines = bench.until(|s| matches!(s, Sentence::Guard(_)));
    let word = |line: &String| match Sentence::parse(line) {
        Ok(Sentence::Guard(word)) => Some(word),
        _ => None,
    };
    lines.iter().find_map(word).unwrap()
}

/// Whether the next sentence of a sweep or a scan belongs to a scan.
fn is_scan_next(bench: &mut Bench) -> bool {
    let lines = bench.until(|s| matches!(s, Sentence::Guard(_) | Sentence::Scan(_)));
    lines.iter().any(|line| line.starts_with("$PSTR,SCAN"))
}

#[test]
fn sweeps_go_both_ways_in_turn_over_the_guards_angles() {
    for mode in [SweepMode::Stop, SweepMode::Continuous] {
        let mut bench = bench(settings(mode), |_| ());
        assert_eq!(bench.ask("guard on"), "DONE,guard");
        for number in 1..=3 {
            let word = sweep(&mut bench);
            let reported = (word.sweep, word.status, word.free, word.hazard);
            let free = Some(Tenths(12_000));
            assert_eq!(reported, (number, Status::Ok, free, HazardKind::Rise));
            assert_eq!(word.reasons, Reasons::NONE);
        }
        assert_eq!(bench.scanner.state(), "guarding");
        assert_eq!(bench.scanner.scans(), 0);
        let world = bench.world.0.borrow();
        let forward: Vec<u16> = (0..31).collect();
        let backward: Vec<u16> = (0..31).rev().collect();
        assert_eq!(world.rows[..31], forward[..], "{mode:?}");
        assert_eq!(world.rows[31..62], backward[..]);
        assert_eq!(world.rows[62..93], forward[..]);
        for (at, angle) in [(0, 8_000), (30, 38_000), (31, 38_000), (61, 8_000)] {
            assert!(
                (world.module.get().echoes.triggers[at] - angle).abs() < 5,
                "{mode:?}"
            );
        }
        assert_eq!(world.begun[..3], [1, 2, 3]);
    }
}

/// The sentence of a continuous sweep is sent while the shaft still decelerates.
#[test]
fn the_word_does_not_wait_for_the_mirror() {
    let mut bench = bench(settings(SweepMode::Continuous), |_| ());
    bench.ask("guard on");
    sweep(&mut bench);
    assert!(bench.world.0.borrow().passing.is_some());
    // A full scan does not begin before the shaft has stopped: the simulated mirror checks this.
    assert_eq!(bench.ask("scan"), "DONE,scan");
    assert_eq!(bench.scan().scan, 1);
    assert_eq!(bench.ask("guard off"), "DONE,guard");
    while bench.scanner.state() != "idle" {
        bench.step();
    }
    assert!(bench.world.0.borrow().passing.is_some());
    assert_eq!(bench.ask("scan"), "DONE,scan");
    assert_eq!(bench.scan().scan, 2);
}

#[test]
fn a_scan_comes_in_between_and_the_guard_goes_on() {
    let mut bench = bench(settings(SweepMode::Stop), |_| ());
    bench.ask("guard on");
    let before = sweep(&mut bench).sweep;
    assert_eq!(bench.ask("scan"), "DONE,scan");
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (1, Status::Ok));
    let after = sweep(&mut bench).sweep;
    assert!(after > before && after <= before + 3, "{before} {after}");
    assert_eq!(bench.ask("guard off"), "DONE,guard");
    for _ in 0..2_000 {
        bench.step();
    }
    assert_eq!((bench.scanner.state(), bench.scanner.scans()), ("idle", 1));
    bench.take_lines();
    bench.ask("guard on");
    assert_eq!(sweep(&mut bench).sweep, 1, "counted anew");
}

#[test]
fn start_and_stop_end_the_guard() {
    let mut bench = bench(settings(SweepMode::Stop), |_| ());
    bench.ask("watch on");
    sweep(&mut bench);
    assert_eq!(bench.ask("start"), "DONE,start");
    bench.scan();
    assert!(is_scan_next(&mut bench));
    bench.ask("guard on");
    sweep(&mut bench);
    assert_eq!(bench.ask("stop"), "DONE,stop");
    assert_eq!(bench.scanner.state(), "idle");
    assert!(!bench.world.0.borrow().enabled);
}

#[test]
fn what_cannot_keep_up_is_refused_by_its_field() {
    let settings = |change: fn(&mut Settings)| {
        let mut settings = Settings::default();
        change(&mut settings);
        settings.validate().unwrap();
        settings
    };
    type Change = fn(&mut Settings);
    let changes: [(Change, &str); 10] = [
        (|s| s.sweep_mode = SweepMode::Stop, "sweep-mode"),
        (|s| s.module.baud = 1_000_000, "link-rate"),
        (|_| (), ""),
        (|s| s.guard.rate = 8, "acceleration"),
        (
            |s| (s.guard.rate, s.motor.acceleration) = (8, 4_000_000),
            "",
        ),
        (|s| s.motor.speed = 12_800, "speed"),
        (|s| (s.guard.rate, s.motor.acceleration) = (1, 200_000), ""),
        (
            |s| s.config.mount.plane = stairscan::config::Planes::Height,
            "plane",
        ),
        (|s| s.config.mount.beamwidth = 500, "guard-step"),
        (
            |s| (s.guard.first, s.guard.step) = (-20_000, 200),
            "link-rate",
        ),
    ];
    for (change, field) in changes {
        let mut bench = bench(settings(change), |_| ());
        let answer = bench.ask("guard on");
        match field {
            "" => assert_eq!(answer, "DONE,guard"),
            _ => assert!(
                answer.starts_with(&format!("FAIL,guard,{field},")),
                "{field}: {answer}"
            ),
        }
    }
}

/// The simulated module stays at 1 Mbaud.
#[test]
fn a_module_that_turns_out_slower_ends_the_guard_and_says_so() {
    let mut settings = Settings::default();
    settings.motor.acceleration = 10_000_000;
    let mut bench = bench(settings, |_| ());
    assert_eq!(bench.ask("guard on"), "DONE,guard");
    let lines = bench.until(|s| matches!(s, Sentence::Fail { .. }));
    let fail = lines.last().unwrap();
    assert!(fail.starts_with("$PSTR,FAIL,guard,link-rate,"), "{fail}");
    assert_eq!(bench.scanner.state(), "idle");
}

#[test]
fn settings_that_the_guard_cannot_have_are_refused_while_it_is_on() {
    let mut bench = bench(settings(SweepMode::Stop), |_| ());
    bench.ask("guard on");
    sweep(&mut bench);
    let answer = bench.send("set,plane,height");
    assert!(answer.starts_with("FAIL,set,plane,"), "{answer}");
    assert_eq!(bench.send("set,guard-last,30000"), "CONF,guard-last,30000");
    let answer = bench.send("set,guard-last,16000");
    assert_eq!(answer, "CONF,guard-last,16000");
    let answer = bench.send("set,guard-last,15999");
    assert!(answer.starts_with("FAIL,set,guard-last,"), "{answer}");
    let answer = bench.send("set,guard-step,5000");
    assert!(answer.starts_with("FAIL,set,guard-last,"), "{answer}");
}

#[test]
fn a_stall_is_reported_at_once_and_the_guard_goes_on_after_the_self_test() {
    let mut bench = bench(settings(SweepMode::Stop), |_| ());
    bench.ask("guard on");
    sweep(&mut bench);
    bench.world.0.borrow_mut().stall = true;
    let word = sweep(&mut bench);
    assert_eq!((word.status, word.free), (Status::Fault, None));
    assert_eq!(word.reasons, Reasons::NONE.with(Reason::MotorStall));
    bench.step();
    assert_eq!(bench.scanner.state(), "fault");
    bench.world.0.borrow_mut().stall = false;
    assert_eq!(sweep(&mut bench).status, Status::Ok);
}

#[test]
fn lost_rows_degrade_and_too_many_are_a_fault() {
    let mut settings = settings(SweepMode::Stop);
    settings.timing.retries = 0;
    let mut bench = bench(settings, |_| ());
    bench.ask("guard on");
    sweep(&mut bench);
    let lose = |bench: &mut Bench, count| {
        let lost = std::iter::repeat_n([None, Some(LinkError::Timeout)], count);
        bench.world.0.borrow().module.get().errors = lost.flatten().collect();
        // The current sweep may have begun before.
        sweep(bench);
        sweep(bench)
    };
    bench.world.0.borrow().module.get().errors = [Some(LinkError::Timeout)].into();
    let words = [sweep(&mut bench), sweep(&mut bench)];
    let lost = words.iter().find(|word| word.status != Status::Ok).unwrap();
    assert_eq!(lost.reasons, Reasons::NONE.with(Reason::LostRows));
    assert_eq!(lost.free, Some(Tenths(12_000)));
    let words = lose(&mut bench, 12);
    assert_eq!(words.reasons, Reasons::NONE.with(Reason::TooManyLost));
}

#[test]
fn the_nearer_hazard_of_the_last_scan_counts_for_some_seconds() {
    let mut bench = bench(settings(SweepMode::Stop), |w| w.drop_m = Some(0.9));
    bench.ask("guard on");
    sweep(&mut bench);
    bench.ask("scan");
    bench.scan();
    let word = sweep(&mut bench);
    // 0.9 m less three standard deviations of 1 cm.
    assert_eq!(
        (word.free, word.hazard),
        (Some(Tenths(8_700)), HazardKind::Drop)
    );
    assert_eq!(word.reasons, Reasons::NONE.with(Reason::ScanNearer));
    for _ in 0..5_000 {
        bench.step();
    }
    bench.take_lines();
    assert_eq!(sweep(&mut bench).reasons, Reasons::NONE);
}

#[test]
fn a_watch_scans_once_what_comes_near_a_chair_that_stands() {
    let mut settings = settings(SweepMode::Stop);
    settings.motion = stairscan::motion::Mode::Standing;
    let mut bench = bench(settings, |w| w.ground = None);
    let near = |bench: &mut Bench, free_m, hazard| {
        bench.world.0.borrow_mut().ground = Some(FreeGround {
            free_m,
            hazard,
            ..RISE
        });
    };
    near(&mut bench, 1.6, HazardKind::Rise);
    assert_eq!(bench.ask("watch on"), "DONE,watch");
    assert!(!is_scan_next(&mut bench) && !is_scan_next(&mut bench));
    near(&mut bench, 1.4, HazardKind::Obstacle);
    assert!(
        (0..3).all(|_| !is_scan_next(&mut bench)),
        "no rise, no drop"
    );
    near(&mut bench, 1.4, HazardKind::Drop);
    assert!((0..3).any(|_| is_scan_next(&mut bench)));
    assert!((0..3).all(|_| !is_scan_next(&mut bench)), "one of each");
    near(&mut bench, 1.6, HazardKind::Drop);
    assert!((0..2).all(|_| !is_scan_next(&mut bench)));
    near(&mut bench, 1.4, HazardKind::Rise);
    assert!((0..3).any(|_| is_scan_next(&mut bench)), "and the next one");
}

/// Sends a motion sentence of a chair at this speed, mm/s, every 10 ms until `words` sweeps and scans have been
/// reported. Returns whether a scan was among them.
fn drive(bench: &mut Bench, travel: &mut (u16, f32), speed: f32, words: usize) -> bool {
    let (mut reported, mut scanned) = (0, false);
    for step in 0..400_000 {
        if step % 10 == 0 {
            travel.0 = travel.0.wrapping_add(1);
            travel.1 += 0.1 * speed;
            let reading = Reading {
                sequence: travel.0,
                travel: travel.1 as i32,
                pitch: None,
            };
            bench.type_line(motion::write(&reading).trim_end());
        }
        bench.step();
        for line in bench.take_lines() {
            reported +=
                usize::from(line.starts_with("$PSTR,GUARD") || line.starts_with("$PSTR,SCAN"));
            scanned |= line.starts_with("$PSTR,SCAN");
        }
        if reported >= words {
            return scanned;
        }
    }
    panic!("never came");
}

#[test]
fn a_watch_waits_until_a_chair_that_drives_slows() {
    let mut bench = bench(settings(SweepMode::Stop), |_| ());
    let mut travel = (0, 0.0);
    drive(&mut bench, &mut travel, 300.0, 0);
    bench.type_line("watch on");
    assert!(!drive(&mut bench, &mut travel, 300.0, 12), "at full speed");
    assert!(drive(&mut bench, &mut travel, 150.0, 4));
}

#[test]
fn without_motion_input_a_watch_scans_nothing() {
    let mut bench = bench(settings(SweepMode::Stop), |_| ());
    bench.ask("watch on");
    assert!((0..5).all(|_| !is_scan_next(&mut bench)));
}
