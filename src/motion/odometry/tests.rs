//! Tests of the motion input on sentences and rows at given times.

use super::*;
use std::vec::Vec;

/// Returns the `k`-th of motion sentences 10 ms apart from a chair at 0.2 m/s whose nose comes up by half a
/// degree a second.
fn reading(k: u16) -> Reading {
    Reading {
        sequence: 65_500_u16.wrapping_add(k),
        travel: 123_456 + 20 * i32::from(k),
        pitch: Some(-300 + 5 * i32::from(k)),
    }
}

fn at(k: u16) -> Micros {
    // Across the counter's wrap.
    Micros(u32::MAX - 400_000).plus(10_000 * u32::from(k))
}

const ROWS: u16 = 281;

/// Returns the time of row `row`, µs after sentence 0: the scan begins between two sentences.
fn seen(row: u16) -> u32 {
    24_000 + 4_630 * u32::from(row)
}

/// Runs a scan of `ROWS` rows; `send` is called in place of each sentence `k`.
fn scan(odometry: &mut Odometry, mut send: impl FnMut(&mut Odometry, u16)) {
    let mut row = 0;
    odometry.begin(ROWS);
    for k in 0..140 {
        while row < ROWS && seen(row) < 10_000 * u32::from(k) {
            odometry.row(row, at(0).plus(seen(row)));
            row += 1;
        }
        if row == ROWS {
            break;
        }
        send(odometry, k);
    }
    odometry.finish(at(0).plus(seen(ROWS - 1) + 100));
}

fn take(odometry: &mut Odometry, k: u16) {
    odometry.take(at(k), reading(k));
}

#[test]
fn rows_lie_where_the_chair_was_at_their_mid_chirp() {
    for every in [1, 3, 15] {
        let mut odometry = Odometry::new();
        scan(&mut odometry, |o, k| {
            if k % every == 0 {
                take(o, k);
            }
        });
        let drive = odometry.drive(Mode::Auto, 1_000);
        assert_eq!(drive.input, Input::Good, "{every}");
        let track = drive.known().unwrap();
        for row in [0, 3, 100, 277, 280] {
            let s = (seen(row) - seen(0)) as f32 * 1e-6;
            let place = track.at(f32::from(row));
            let turned = place.pitch_rad - track.at(0.0).pitch_rad;
            assert!((place.time_s - s).abs() < 2e-5, "{row}: {place:?}");
            let travel_m = place.travel_m - track.at(0.0).travel_m;
            assert!((travel_m - 0.2 * s).abs() < 2e-5, "{row}: {place:?}");
            assert!((turned - 0.5 * s * RAD_PER_DEG).abs() < 2e-5, "{row}");
        }
        assert_eq!((drive.moved_m, drive.since_s), (None, None));
    }
}

#[test]
fn the_way_between_two_scans_is_from_last_row_to_last_row() {
    let mut odometry = Odometry::new();
    odometry.take(at(0), reading(0));
    let mut ends = Vec::new();
    for first in [1u16, 41] {
        odometry.begin(2);
        for row in 0..2 {
            let k = first + 10 * row;
            odometry.row(row, at(k).plus(5_000));
            (k..k + 10).for_each(|k| take(&mut odometry, k));
        }
        odometry.finish(at(first + 19));
        (first + 20..first + 40).for_each(|k| take(&mut odometry, k));
        ends.push((odometry.moved_m, odometry.since_s));
    }
    let (moved, since) = (ends[1].0.unwrap(), ends[1].1.unwrap());
    assert!((moved - 0.08).abs() < 1e-5 && (since - 0.4).abs() < 1e-5);
}

/// The counter's span, µs.
const SPAN: u64 = 1 << 32;

/// Keeps the ages every five minutes from `since` on for `us` microseconds, and returns the time then.
fn wait(odometry: &mut Odometry, since: Micros, us: u64) -> Micros {
    for k in 1..=us / 300_000_000 {
        odometry.keep_ages(since.plus((k * 300_000_000) as u32));
    }
    since.plus(us as u32)
}

#[test]
fn an_input_that_is_stale_stays_stale_when_the_counter_wraps() {
    let mut odometry = Odometry::new();
    take(&mut odometry, 0);
    take(&mut odometry, 1);
    let now = wait(&mut odometry, at(1), SPAN + 1_000);
    assert_eq!(odometry.state(now), Input::Late);
    odometry.take(now, reading(2));
    assert_eq!((odometry.state(now), odometry.faults()), (Input::Late, 1));
}

#[test]
fn a_scan_of_an_hour_ago_is_not_a_recent_one() {
    let mut odometry = Odometry::new();
    let scan = |odometry: &mut Odometry, now: Micros| {
        odometry.begin(1);
        odometry.row(0, now);
        odometry.finish(now);
        odometry.since_s
    };
    assert_eq!(scan(&mut odometry, at(0)), None);
    let now = wait(&mut odometry, at(0), SPAN + 1_000);
    let since_s = scan(&mut odometry, now).unwrap();
    assert!(since_s > 1_000.0, "{since_s}");
}

/// Each fault has its name, and the scan then has no motion input.
#[test]
fn faults_are_named_and_leave_the_scan_without_motion_input() {
    type Send = fn(&mut Odometry, u16);
    let cases: [(&str, Input, Send); 7] = [
        ("never", Input::Absent, |_, _| {}),
        ("late", Input::Late, |o, k| {
            if !(40..65).contains(&k) {
                take(o, k);
            }
        }),
        ("ends", Input::Late, |o, k| {
            if k < 100 {
                take(o, k);
            }
        }),
        ("jumps", Input::Jumping, |o, k| {
            let jump = if k > 70 { 1_000 } else { 0 };
            let travel = reading(k).travel + jump;
            o.take(
                at(k),
                Reading {
                    travel,
                    ..reading(k)
                },
            );
        }),
        ("tips", Input::Jumping, |o, k| {
            let jump = if k > 70 { 3_000 } else { 0 };
            let pitch = reading(k).pitch.map(|p| p + jump);
            o.take(
                at(k),
                Reading {
                    pitch,
                    ..reading(k)
                },
            );
        }),
        ("stuck", Input::Frozen, |o, k| {
            o.take(at(k), reading(k.min(60)));
        }),
        ("swapped", Input::Disordered, |o, k| {
            let swap = if k % 20 < 18 { k } else { k ^ 1 };
            o.take(at(k), reading(swap));
        }),
    ];
    for (name, input, send) in cases {
        let mut odometry = Odometry::new();
        scan(&mut odometry, send);
        let drive = odometry.drive(Mode::Auto, 1_000);
        assert_eq!(drive.input, input, "{name}");
        assert!(drive.known().is_none() && drive.moved_m.is_none(), "{name}");
        assert_eq!(odometry.faults() > 0, name != "never", "{name}");
        // The rows' times are known all the same.
        let end_s = drive.track.unwrap().at(280.0).time_s;
        assert!((end_s - 280.0 * 4.63e-3).abs() < 1e-4, "{name}: {end_s}");
    }
    let mut odometry = Odometry::new();
    scan(&mut odometry, |o, k| match k {
        50 => o.garbled(),
        _ => take(o, k),
    });
    assert_eq!(odometry.drive(Mode::Auto, 1_000).input, Input::Garbled);
}

/// Sentences of a chair at 1 m/s, every 50 ms; those of a quarter of a second are held back and arrive together.
#[test]
fn sentences_that_arrive_together_are_no_jump() {
    let said = |k: u16| Reading {
        sequence: k,
        travel: 500 * i32::from(k),
        pitch: None,
    };
    let at = |ms: u16| Micros(0).plus(1_000 * u32::from(ms));
    let mut odometry = Odometry::new();
    // At the very beginning, in one read.
    (0..3).for_each(|k| odometry.take(at(100), said(k)));
    odometry.begin(100);
    let mut row = 0;
    for k in 3..20 {
        while row * 5 < 50 * (k - 2) {
            odometry.row(row, at(100 + row * 5));
            row += 1;
        }
        let now = at(50 * k);
        match k {
            8..10 => {}
            10 => (8..=10).for_each(|k| odometry.take(now, said(k))),
            _ => odometry.take(now, said(k)),
        }
    }
    odometry.finish(at(950));
    assert_eq!(
        (odometry.state(at(950)), odometry.faults()),
        (Input::Good, 0)
    );
    let drive = odometry.drive(Mode::Auto, 0);
    assert_eq!(drive.input, Input::Good);
    // Every row lies where the chair was, also those of the gap.
    let track = drive.known().unwrap();
    for row in [0u16, 40, 50, 60, 79, 80, 100] {
        let travel_m = track.at(f32::from(row)).travel_m - track.at(0.0).travel_m;
        let expected = 0.005 * f32::from(row);
        assert!((travel_m - expected).abs() < 1e-3, "{row}: {travel_m}");
    }
    // One that tells more than a chair can travel in the gap is a jump all the same.
    odometry.take(at(1_000), said(20));
    odometry.take(at(1_150), said(22));
    odometry.take(at(1_150), said(30));
    assert_eq!(odometry.state(at(1_150)), Input::Jumping);
}

/// On the wire, sentences of a burst arrive one after another: where rows were placed in between, the first was late.
#[test]
fn a_burst_between_rows_is_late() {
    let said = |k: u16| Reading {
        sequence: k,
        travel: 500 * i32::from(k),
        pitch: None,
    };
    let mut odometry = Odometry::new();
    odometry.take(Micros(0), said(0));
    odometry.take(Micros(50_000), said(1));
    odometry.begin(3);
    odometry.row(0, Micros(60_000));
    odometry.take(Micros(200_000), said(2));
    odometry.row(1, Micros(201_000));
    odometry.take(Micros(204_000), said(4));
    odometry.row(2, Micros(206_000));
    odometry.finish(Micros(207_000));
    assert_eq!(odometry.drive(Mode::Auto, 0).input, Input::Late);
}

#[test]
fn a_controller_that_begins_anew_is_believed_from_the_next_scan_on() {
    let mut odometry = Odometry::new();
    scan(&mut odometry, |o, k| {
        let travel = reading(k).travel - if k > 70 { 123_000 } else { 0 };
        o.take(
            at(k),
            Reading {
                travel,
                ..reading(k)
            },
        );
    });
    assert_eq!(odometry.drive(Mode::Auto, 0).input, Input::Jumping);
    odometry.begin(2);
    for k in 130..160 {
        if k == 140 || k == 150 {
            odometry.row(k / 10 - 14, at(k));
        }
        let travel = reading(k).travel - 123_000;
        odometry.take(
            at(k),
            Reading {
                travel,
                ..reading(k)
            },
        );
    }
    odometry.finish(at(159));
    let drive = odometry.drive(Mode::Auto, 0);
    assert_eq!((drive.input, drive.moved_m), (Input::Good, None));
}

#[test]
fn a_standing_chair_has_no_track() {
    let mut odometry = Odometry::new();
    scan(&mut odometry, take);
    assert!(odometry.drive(Mode::Standing, 0).track.is_none());
    assert_eq!(odometry.state(at(139)), Input::Good);
    assert_eq!(odometry.state(at(139).plus(300_000)), Input::Late);
}

#[test]
fn the_travel_during_a_scan_counts_from_its_first_sentence_on() {
    let mut odometry = Odometry::new();
    assert_eq!(odometry.expected_travel(Mode::Standing, at(0)), None);
    let unknown = odometry.expected_travel(Mode::Auto, at(1));
    assert_eq!(unknown, Some(ExpectedTravel::default()));
    take(&mut odometry, 0);
    // Half a second's way before the scan, without a sentence.
    odometry.begin(ROWS);
    odometry.row(0, at(49));
    let first = odometry.expected_travel(Mode::Auto, at(49));
    assert_eq!(first, Some(ExpectedTravel::default()));
    for (k, travel_m, step_m) in [(50, 0.0, 0.0), (51, 0.002, 0.002), (54, 0.008, 0.006)] {
        take(&mut odometry, k);
        let travel = odometry.expected_travel(Mode::Auto, at(k)).unwrap();
        assert!((travel.since_first_m - travel_m).abs() < 1e-6, "{travel:?}");
        assert!((travel.step_m - step_m).abs() < 1e-6, "{travel:?}");
    }
    // A sentence that comes a millisecond late is 3 % of the speed, not 10 %.
    take(&mut odometry, 55);
    take(&mut odometry, 56);
    odometry.take(at(57).plus(1_000), reading(57));
    let late = odometry.expected_travel(Mode::Auto, at(55)).unwrap();
    assert!((late.step_m / 0.002 - 1.0).abs() < 0.035, "{late:?}");
    // It stops: the last two sentences are alike.
    for k in [58, 59] {
        odometry.take(
            at(k),
            Reading {
                travel: reading(57).travel,
                ..reading(k)
            },
        );
    }
    assert_eq!(odometry.expected_travel(Mode::Auto, at(60)), None);
}
