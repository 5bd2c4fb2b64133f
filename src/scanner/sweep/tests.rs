//! Tests of sweeps on a simulated bench with a clock: steps come as the ramp computes them, bytes at the wire's
//! speed, and the module captures what the shaft does in that time.

mod bench;
mod chip;

use super::*;
use crate::scanner::settings::SweepMode;
use crate::testing::framed::AnswerFault;
use bench::{Bench, Outcome, SPARE};
use proptest::prelude::*;

fn settings(mode: SweepMode) -> Settings {
    Settings {
        sweep_mode: mode,
        ..Settings::default()
    }
}

/// Asserts that for every captured row the shaft stood on the row's microstep from trigger to end.
fn assert_still(outcome: &Outcome) {
    for capture in &outcome.captures {
        let (begin, end) = (capture.begin, capture.end);
        assert_eq!(begin, end, "the mirror moved during {capture:?}");
        assert_eq!(begin, f64::from(capture.wanted), "{capture:?}");
    }
}

/// Asserts that every row was received or reported as lost, each with its own chirp.
fn assert_whole(outcome: &Outcome, rows: u16) {
    let mut all: Vec<u16> = outcome.rows.iter().chain(&outcome.lost).copied().collect();
    all.sort_unstable();
    let every: Vec<u16> = (0..rows).collect();
    assert_eq!(all, every);
    assert_eq!(outcome.mixed_up, 0, "a row with another row's chirp");
}

#[test]
fn in_stop_mode_chirps_travel_while_the_mirror_moves() {
    for backward in [false, true] {
        let settings = settings(SweepMode::Stop);
        let outcome = Bench::new(1_000_000).scan(&settings, backward);
        assert_eq!((outcome.fault, outcome.lost.len()), (None, 0));
        assert_whole(&outcome, 281);
        assert_still(&outcome);
        // `timing` compares its result with the same figure.
        assert!((outcome.ms - 3_716.4).abs() < 5.0, "{} ms", outcome.ms);
        // Move, settle, trigger, chirp: the transmission of the samples adds nothing.
        assert!(
            outcome.ms > 281.0 * (6.8 + 5.0 + 0.16 + 1.0),
            "{}",
            outcome.ms
        );
    }
}

/// A scanner that sleeps between interrupts polls far less, triggers every row at the same time and takes as long.
#[test]
fn sleep_costs_no_time() {
    for (mode, baud, share) in [
        (SweepMode::Stop, 1_000_000, 0.7),
        (SweepMode::Stop, 3_000_000, 0.7),
        (SweepMode::Continuous, 1_000_000, 1.0),
        (SweepMode::Continuous, 3_000_000, 1.0),
    ] {
        let scan = |sleeps: bool| {
            let mut bench = Bench::new(baud);
            bench.sleeps = sleeps;
            bench.scan(&settings(mode), false)
        };
        let (awake, asleep) = (scan(false), scan(true));
        assert_eq!((asleep.fault, asleep.lost.len()), (None, 0));
        assert_whole(&asleep, 281);
        assert!(
            (asleep.ms / awake.ms - 1.0).abs() < 0.001,
            "{} ms, {} ms",
            asleep.ms,
            awake.ms
        );
        let polls = asleep.polls as f64 / awake.polls as f64;
        assert!(polls < share, "{mode:?}, {baud}: {polls} of the polls");
        // The mean time between two triggers, which each row's deadline limits in passing.
        let apart = |outcome: &Outcome| {
            let times: Vec<u32> = outcome.fired.iter().map(|&(_, at)| at).collect();
            f64::from(times[280] - times[0]) / 280.0
        };
        let later = apart(&asleep) - apart(&awake);
        assert!(later.abs() < f64::from(SPARE), "{later} µs");
    }
}

#[test]
fn a_chirp_of_unknown_length_keeps_the_mirror_until_it_has_come() {
    let mut settings = settings(SweepMode::Stop);
    settings.timing.chirp_duration = 0;
    let mut bench = Bench::new(1_000_000);
    bench.module(|module| module.chirp_us = 3_000);
    let outcome = bench.scan(&settings, false);
    assert_whole(&outcome, 281);
    assert_still(&outcome);
    assert!(
        outcome.ms > 281.0 * (3.0 + 8.12 + 5.0 + 6.8),
        "{}",
        outcome.ms
    );
}

/// If a module answers after the mirror has moved on, the mirror returns to the row.
#[test]
fn a_lost_row_is_gone_back_for() {
    let settings = settings(SweepMode::Stop);
    for fate in [
        AnswerFault::Lost,
        AnswerFault::Corrupt,
        AnswerFault::Late,
        AnswerFault::Error,
        AnswerFault::Repeat,
    ] {
        let mut bench = Bench::new(1_000_000);
        bench.module(|module| {
            module.faults = [(3, fate), (4, fate), (20, fate), (285, fate)].into()
        });
        let outcome = bench.scan(&settings, false);
        assert_eq!((outcome.fault, outcome.lost.len()), (None, 0), "{fate:?}");
        assert_whole(&outcome, 281);
        assert_still(&outcome);
        let forward: Vec<u16> = (0..281).collect();
        assert_eq!(outcome.rows, forward, "in the order of the sweep");
    }
    // The same row three times: reported as lost.
    let mut bench = Bench::new(1_000_000);
    bench.module(|module| module.faults = (7..10).map(|k| (k, AnswerFault::Lost)).collect());
    let outcome = bench.scan(&settings, false);
    assert_eq!((outcome.fault, &outcome.lost[..]), (None, &[7][..]));
    assert_whole(&outcome, 281);
}

#[test]
fn a_continuous_sweep_sees_every_row_in_mid_chirp() {
    // `timing` compares its results with the same figures. They hold for a module with known properties; here
    // it becomes known during the first move that the module captures ahead, which takes a second move of some
    // ms.
    for (baud, ms) in [
        (1_000_000, 2_420.5),
        (2_000_000, 1_222.3),
        (3_000_000, 835.2),
    ] {
        for backward in [false, true] {
            let settings = settings(SweepMode::Continuous);
            let outcome = Bench::new(baud).scan(&settings, backward);
            assert_eq!((outcome.fault, outcome.lost.len()), (None, 0), "{baud}");
            assert_whole(&outcome, 281);
            assert!(
                (outcome.ms - ms).abs() < 15.0,
                "{} ms at {baud}",
                outcome.ms
            );
            let mut off: Vec<f64> = (outcome.captures.iter())
                .map(|c| c.middle - f64::from(c.wanted))
                .collect();
            off.sort_unstable_by(f64::total_cmp);
            // Within one microstep, 0.007 degree.
            let (least, most) = (off[0], off[off.len() - 1]);
            assert!(least > -1.0 && most < 1.0, "{least} to {most} at {baud}");
            assert!(off[off.len() / 2].abs() < 0.5, "{} at {baud}", off[140]);
            // Regular in time: odometry gets each row's own time.
            let gaps = outcome.fired.windows(2).map(|w| w[1].1 - w[0].1);
            let (short, long) = gaps.fold((u32::MAX, 0), |(a, b), gap| (a.min(gap), b.max(gap)));
            let grain = 4 * SPARE + 200;
            assert!(long - short < 2 * grain, "{short} to {long} at {baud}");
        }
    }
}

#[test]
fn several_chirps_per_row_are_waited_for_in_both_modes() {
    for (mode, ms) in [
        (SweepMode::Stop, 281.0 * (6.8 + 5.0 + 0.06 + 8.0 + 0.1)),
        (SweepMode::Continuous, 280.0 * 8.15 * 1.05 + 50.0),
    ] {
        let mut settings = settings(mode);
        settings.module.chirps = 8;
        let outcome = Bench::new(3_000_000).scan(&settings, false);
        assert_eq!((outcome.fault, outcome.lost.len()), (None, 0), "{mode:?}");
        assert_whole(&outcome, 281);
        assert!(
            (outcome.ms / ms - 1.0).abs() < 0.03,
            "{mode:?}: {} ms",
            outcome.ms
        );
        match mode {
            SweepMode::Stop => assert_still(&outcome),
            // The row's position comes in the middle of its chirps, within one microstep.
            SweepMode::Continuous => {
                let off = |c: &bench::Capture| (c.middle - f64::from(c.wanted)).abs();
                assert!(outcome.captures.iter().all(|c| off(c) < 1.0));
            }
        }
    }
}

#[test]
fn a_module_that_cannot_add_chirps_is_a_fault_of_the_configuration() {
    let mut settings = settings(SweepMode::Continuous);
    settings.module.chirps = 8;
    let mut bench = Bench::new(3_000_000);
    bench.module(|module| module.ability.adds = false);
    let outcome = bench.scan(&settings, false);
    assert_eq!(outcome.fault, Some(Reason::ModuleConfig));
}

#[test]
fn a_chip_that_wakes_up_first_sees_every_row_in_mid_chirp() {
    for backward in [false, true] {
        let settings = settings(SweepMode::Continuous);
        let outcome = Bench::new(1_000_000).scan_chip(&settings, backward);
        assert_eq!((outcome.fault, outcome.lost.len()), (None, 0));
        assert_whole(&outcome, 281);
        // A scan with stops takes 3.7 s.
        assert!((700.0..800.0).contains(&outcome.ms), "{} ms", outcome.ms);
        for capture in &outcome.captures {
            let off = capture.middle - f64::from(capture.wanted);
            assert!(off.abs() < 1.0, "{capture:?}");
        }
    }
}

/// A module that takes one request at a time gets a sweep that is slow enough for it.
#[test]
fn a_module_without_a_second_buffer_is_swept_more_slowly() {
    let settings = settings(SweepMode::Continuous);
    let mut bench = Bench::new(2_000_000);
    bench.module(|module| module.ability.ahead = false);
    let outcome = bench.scan(&settings, false);
    assert_eq!((outcome.fault, outcome.lost.len()), (None, 0));
    assert_whole(&outcome, 281);
    assert!((1_600.0..1_800.0).contains(&outcome.ms), "{}", outcome.ms);
}

#[test]
fn a_continuous_sweep_tells_what_it_lost_and_does_not_stop() {
    let settings = settings(SweepMode::Continuous);
    for fate in [AnswerFault::Corrupt, AnswerFault::Lost, AnswerFault::Error] {
        let mut bench = Bench::new(2_000_000);
        bench.module(|module| {
            module.faults = [(3, fate), (100, fate), (101, fate), (280, fate)].into()
        });
        let outcome = bench.scan(&settings, false);
        let lost = &outcome.lost;
        assert_eq!(outcome.fault, None, "{fate:?}");
        // A missing chirp occupies its buffer until its timeout, so another row may be lost, too.
        let most = if fate == AnswerFault::Lost { 8 } else { 4 };
        assert!((4..=most).contains(&lost.len()), "{fate:?}: {lost:?}");
        let own: &[u16] = if fate == AnswerFault::Lost {
            &[3]
        } else {
            &[3, 100, 101, 280]
        };
        assert!(
            own.iter().all(|row| lost.contains(row)),
            "{fate:?}: {lost:?}"
        );
        assert_whole(&outcome, 281);
        assert!(outcome.ms < 1_300.0, "{} ms with {fate:?}", outcome.ms);
    }
}

/// Answers that nobody requested use the wire's time: rows are lost, and the wire catches up.
#[test]
fn a_continuous_sweep_outlives_what_comes_twice() {
    let settings = settings(SweepMode::Continuous);
    let mut bench = Bench::new(2_000_000);
    bench.module(|module| module.faults = [3, 100, 200].map(|k| (k, AnswerFault::Repeat)).into());
    let outcome = bench.scan(&settings, false);
    assert_eq!(outcome.fault, None, "{:?}", outcome.lost);
    assert!(outcome.lost.len() < 25, "{:?}", outcome.lost);
    assert_whole(&outcome, 281);
}

#[test]
fn a_mute_module_ends_either_sweep() {
    for mode in [SweepMode::Stop, SweepMode::Continuous] {
        for baud in [1_000_000, 3_000_000] {
            let mut bench = Bench::new(baud);
            bench.module(|module| {
                module.faults = (60..400).map(|k| (k, AnswerFault::Lost)).collect()
            });
            let outcome = bench.scan(&settings(mode), false);
            assert_eq!(
                outcome.fault,
                Some(Reason::LinkSilent),
                "{mode:?} at {baud}"
            );
            assert_eq!(outcome.mixed_up, 0);
        }
    }
}

/// With TRIG neither the chirp nor the mirror waits for the trigger's bytes.
#[test]
fn a_pin_triggers_on_the_spot() {
    for mode in [SweepMode::Stop, SweepMode::Continuous] {
        let mut settings = settings(mode);
        settings.module.pin = true;
        let mut bench = Bench::new(1_000_000);
        bench.module(|module| module.ability.pin = true);
        let outcome = bench.scan(&settings, false);
        assert_eq!((outcome.fault, outcome.lost.len()), (None, 0));
        assert_eq!(outcome.without_edge, 0);
        assert_whole(&outcome, 281);
        if mode == SweepMode::Stop {
            assert_still(&outcome);
            // Saves 281 triggers of 160 µs on the wire.
            assert!((outcome.ms - 3_680.0).abs() < 10.0, "{} ms", outcome.ms);
        }
        let off = |c: &bench::Capture| c.middle - f64::from(c.wanted);
        let most = outcome
            .captures
            .iter()
            .map(|c| off(c).abs())
            .fold(0.0, f64::max);
        assert!(most < 1.0, "{most}");
    }
}

/// A module that was reset during a scan is at 1 Mbaud. With stops the link recovers at the row's second try;
/// in continuous mode the scan ends, since all rows were planned for the other rate.
#[test]
fn a_module_that_forgets_its_rate_is_found_again_or_reported() {
    for rate in [2_000_000, 3_000_000] {
        let mut bench = Bench::new(rate);
        bench.module(|module| module.reset_at = Some(100));
        let outcome = bench.scan(&settings(SweepMode::Stop), false);
        assert_eq!((outcome.fault, outcome.lost.len()), (None, 0));
        assert_whole(&outcome, 281);
        assert_still(&outcome);
        let mut bench = Bench::new(rate);
        bench.module(|module| module.reset_at = Some(100));
        let outcome = bench.scan(&settings(SweepMode::Continuous), false);
        assert_eq!(outcome.fault, Some(Reason::LinkSilent));
        assert_eq!(outcome.mixed_up, 0);
    }
}

/// Without room for the ramps the mirror stops at every row.
#[test]
fn a_sector_at_the_end_of_the_shaft_is_stopped_in() {
    let mut settings = settings(SweepMode::Continuous);
    settings.config.sweep.first_angle = -170_000;
    settings.config.sweep.angle_count = 20;
    let outcome = Bench::new(2_000_000).scan(&settings, false);
    assert_eq!(outcome.fault, None);
    assert_whole(&outcome, 20);
    assert_still(&outcome);
}

fn fate() -> impl Strategy<Value = AnswerFault> {
    prop_oneof![
        Just(AnswerFault::Lost),
        Just(AnswerFault::Corrupt),
        Just(AnswerFault::Late),
        Just(AnswerFault::Error),
        Just(AnswerFault::Repeat),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// For any behaviour of the module and any load of the scanner: no row gets another's chirp, every row is
    /// accounted for, in `stop` nothing is captured while the mirror moves, and no deadline is missed.
    #[test]
    fn whatever_happens_rows_get_their_own_chirps(
        mode in prop_oneof![Just(SweepMode::Stop), Just(SweepMode::Continuous)],
        baud in prop_oneof![Just(1_000_000_u32), Just(2_000_000), Just(3_000_000)],
        fates in proptest::collection::btree_map(0_u32..120, fate(), 0..40),
        busy in proptest::collection::vec(0_u32..6_000, 0..50),
        backward: bool, ahead: bool,
        chirp_us in 0_u32..4_000, chirps in prop_oneof![3 => Just(1_u8), 1 => 2_u8..=8],
    ) {
        let mut settings = settings(mode);
        settings.config.sweep.angle_count = 70;
        settings.timing.chirp_duration = chirp_us;
        settings.module.chirps = chirps;
        let mut bench = Bench::new(baud);
        bench.module(|module| module.chirp_us = chirp_us.into());
        bench.module(|module| module.ability.ahead = ahead);
        bench.module(|module| module.faults = fates);
        bench.busy_us = busy;
        let outcome = bench.scan(&settings, backward);
        prop_assert_eq!(outcome.mixed_up, 0);
        if outcome.fault.is_none() {
            assert_whole(&outcome, 70);
        }
        if mode == SweepMode::Stop {
            assert_still(&outcome);
        }
    }
}
