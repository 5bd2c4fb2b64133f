//! Echoes seen from a chair that drives: motion compensation, and the comparison of sweeps.

use super::*;
use crate::config::Config;
use crate::drive::PhaseAgreement;
use crate::signal::echoes::{Echo, Echoes, tests};
use crate::signal::grid::PolarMap;
use crate::verdict::{Assessment, Evidence, Outcome, Reason, Status, Validity};

const ROW_S: f32 = 0.0046;
const ROWS: u16 = 281;
/// Time from the last row of a sweep to the first row of the next, seconds.
const TURN_S: f32 = 0.1;
const CHIRP_S: f32 = 0.001;

/// Corners of a flight and of objects around it: x and y in metres, SNR in dB.
const SCENE: [(f32, f32, f32); 7] = [
    (1.3, 0.17, 35.0),
    (1.58, 0.34, 30.0),
    (1.86, 0.51, 22.0),
    (1.3, 0.0, 28.0),
    (0.7, 0.0, 14.0),
    (0.93, 0.0, 15.0),
    (2.1, 0.8, 18.0),
];

/// A chair with a forward speed, m/s, and a pitch rate, nose up positive, rad/s.
#[derive(Clone, Copy)]
struct Chair {
    speed: f32,
    rad_s: f32,
    /// Whether the phases of the echoes agree with the motion input.
    phases: PhaseAgreement,
}

impl Chair {
    fn place(&self, time_s: f32) -> RowPose {
        RowPose {
            time_s,
            travel_m: self.speed * time_s,
            pitch_rad: self.rad_s * time_s,
        }
    }

    /// Returns the track of sweep `sweep`, counted from its first row, and the echoes as they are observed.
    fn sweep(&self, map: &PolarMap, config: &Config, sweep: u16) -> (Track, Echoes) {
        let first_s = f32::from(sweep) * (f32::from(ROWS - 1) * ROW_S + TURN_S);
        let arrival = |row: f32| match sweep % 2 {
            0 => row,
            _ => f32::from(ROWS - 1) - row,
        };
        let mut track = Track::new();
        track.begin(ROWS);
        for k in 0..ROWS {
            let row = arrival(f32::from(k)) as u16;
            track.add(row, self.place(f32::from(k) * ROW_S));
        }
        let coupling_s =
            CHIRP_S * config.radar.carrier_khz as f32 / config.radar.bandwidth_khz as f32;
        let geometry = map.geometry();
        let echo = |&(x, y, snr_db): &(f32, f32, f32)| {
            let mut echo = Echo::default();
            let mut row = 140.0;
            // Iterates to the row whose beam meets the point while the chair drives on.
            for _ in 0..20 {
                let at = self.place(first_s + arrival(row) * ROW_S);
                let seen_from = self.place(first_s).pitch_rad;
                let ahead = x - at.travel_m;
                let (range, angle) = geometry.polar(ahead, y);
                let nearing = self.speed * ahead / range;
                echo = Echo {
                    snr_db,
                    range_m: range - nearing * coupling_s,
                    angle_rad: angle + at.pitch_rad - seen_from,
                    width: 1.0,
                    ..Echo::default()
                };
                row = (echo.angle_rad - map.angle_rad(0)) / geometry.step_rad;
            }
            (echo.x_m, echo.y_m) = geometry.point(echo.range_m, echo.angle_rad);
            echo
        };
        (track, SCENE.iter().map(echo).collect())
    }
}

fn drive(track: &Track, input: Input, moved_m: Option<f32>, sweep: u16) -> Drive<'_> {
    let since_s = (sweep > 0).then_some(f32::from(ROWS - 1) * ROW_S + TURN_S);
    Drive {
        mode: Mode::Auto,
        input,
        track: Some(track),
        moved_m: moved_m.filter(|_| sweep > 0),
        since_s,
        phases: PhaseAgreement::Unknown,
        chirp_s: CHIRP_S,
        memory: Retention::Kept,
    }
}

/// Returns an answer that is `ok` unless `agreement` prevents it.
fn under(agreement: Agreement) -> Outcome {
    let mut outcome = Outcome::silent();
    let sight = Assessment {
        echo_found: true,
        valid: Some(Validity {
            horizon_m: 2.0,
            confidence: 0.999,
            first_step: 1.0,
        }),
        ..Assessment::nothing(agreement)
    };
    outcome.decide(&Evidence {
        assessment: Some(sight),
        ..Evidence::default()
    });
    outcome
}

/// Returns the outcome of the last of `sweeps` sweeps over an answer that is otherwise `ok`, and its
/// compensated echoes; `said` turns the true travel into that of the odometer.
fn reported(chair: Chair, sweeps: u16, input: Input, said: fn(f32) -> f32) -> (Outcome, Echoes) {
    let config = Config::default();
    let map = tests::map(&config, |_, _| 80);
    let mut compared = SweepComparison::new();
    let mut last = (Outcome::silent(), Echoes::new());
    for sweep in 0..sweeps {
        let (track, mut echoes) = chair.sweep(&map, &config, sweep);
        let mut reported = Track::new();
        reported.begin(ROWS);
        for k in 0..ROWS {
            let row = if sweep % 2 == 0 { k } else { ROWS - 1 - k };
            let place = track.at(f32::from(row));
            let travel_m = said(place.travel_m);
            reported.add(row, RowPose { travel_m, ..place });
        }
        let way = said(chair.speed * (f32::from(ROWS - 1) * ROW_S + TURN_S));
        let drive = Drive {
            phases: chair.phases,
            ..drive(&reported, input, Some(way), sweep)
        };
        let agreement = compared.compare(&map, &config, &drive, &mut echoes);
        last = (under(agreement), echoes);
    }
    last
}

const STANDING: Chair = Chair {
    speed: 0.0,
    rad_s: 0.0,
    phases: PhaseAgreement::Unknown,
};

fn driving(speed: f32) -> Chair {
    Chair { speed, ..STANDING }
}

/// Returns the maximum distance of the echoes from their points' positions at the end of sweep `sweep`, metres.
fn worst(chair: Chair, echoes: &Echoes, sweep: u16) -> f32 {
    let sweep_s = f32::from(ROWS - 1) * ROW_S;
    let travel = chair.speed * (f32::from(sweep) * (sweep_s + TURN_S) + sweep_s);
    let off = SCENE.iter().zip(echoes).map(|(&(x, y, _), e)| {
        let (dx, dy) = (e.x_m - (x - travel), e.y_m - y);
        dx.abs().max(dy.abs())
    });
    off.fold(0.0, f32::max)
}

#[test]
fn echoes_are_placed_as_seen_from_the_position_at_their_row() {
    for speed in [-0.2, 0.05, 0.2] {
        let chair = driving(speed);
        for sweep in [0, 1] {
            let (outcome, echoes) = reported(chair, sweep + 1, Input::Good, |m| m);
            let off = worst(chair, &echoes, sweep);
            assert!(off < 5e-4, "{speed}: {off}");
            assert_eq!(outcome.status() == Status::Ok, sweep > 0, "{speed}");
        }
    }
    // The nose rises by a degree during the first sweep.
    let chair = Chair {
        speed: 0.1,
        rad_s: 0.0135,
        ..STANDING
    };
    let (_, echoes) = reported(chair, 1, Input::Good, |m| m);
    assert!(worst(chair, &echoes, 0) < 5e-4);
}

#[test]
fn a_first_sweep_confirms_nothing_and_a_second_one_a_standing_chair() {
    for input in [Input::Absent, Input::Late, Input::Good] {
        let (first, _) = reported(STANDING, 1, input, |m| m);
        assert!(first.status() == Status::Degraded && first.reasons().has(Reason::Unconfirmed));
        let (second, _) = reported(STANDING, 2, input, |m| m);
        assert_eq!(second.status(), Status::Ok, "{input:?}");
        assert_eq!(
            second.reasons().has(Reason::MotionInput),
            input == Input::Late
        );
    }
}

#[test]
fn a_first_sweep_whose_phases_turn_as_reported_needs_no_second() {
    for speed in [0.0, 0.1] {
        let seen = Chair {
            phases: PhaseAgreement::Agrees,
            ..driving(speed)
        };
        let (first, _) = reported(seen, 1, Input::Good, |m| m);
        assert!(first.status() == Status::Ok && first.reasons().is_empty());
        let (unseen, _) = reported(driving(speed), 1, Input::Good, |m| m);
        assert!(unseen.status() == Status::Degraded && !unseen.reasons().is_empty());
        // A sweep before that contradicts the travel, here 30 cm, still prevents `ok`.
        let (second, _) = reported(seen, 2, Input::Good, |_| 0.3);
        assert!(second.status() == Status::Degraded && !second.reasons().is_empty());
    }
}

#[test]
fn phases_that_turn_otherwise_than_reported_contradict_a_first_sweep() {
    let phases = PhaseAgreement::Differs;
    let chair = Chair {
        phases,
        ..driving(0.1)
    };
    let (first, _) = reported(chair, 1, Input::Good, |m| m);
    assert!(first.reasons().has(Reason::Moving), "{first:?}");
    assert_eq!(first.status(), Status::Degraded);
    // Two sweeps that agree say more.
    let (second, _) = reported(chair, 2, Input::Good, |m| m);
    assert_eq!(second.status(), Status::Ok);
}

#[test]
fn odometers_that_stand_or_count_backward_are_contradicted() {
    for said in [(|_| 0.0) as fn(f32) -> f32, |m| -m] {
        for speed in [0.05, 0.2, 0.5] {
            let (outcome, _) = reported(driving(speed), 2, Input::Good, said);
            assert!(outcome.reasons().has(Reason::Moving), "{speed}");
            assert_eq!(outcome.status(), Status::Degraded);
        }
    }
    // A scale error of two per cent is within the tolerance.
    let (outcome, _) = reported(driving(0.2), 2, Input::Good, |m| 1.02 * m);
    assert_eq!(outcome.status(), Status::Ok);
}

#[test]
fn a_steady_creep_is_seen_without_motion_input_and_is_no_ok() {
    for speed in [-0.1, 0.02, 0.05, 0.2] {
        let chair = driving(speed);
        for sweep in [1, 2] {
            let (outcome, echoes) = reported(chair, sweep + 1, Input::Absent, |m| m);
            assert!(outcome.reasons().has(Reason::Moving), "{speed}");
            assert_eq!(outcome.status(), Status::Degraded);
            let off = worst(chair, &echoes, sweep);
            assert!(off < 5e-3, "{speed}: {off}");
        }
    }
}

#[test]
fn a_chair_known_to_stand_is_not_compared() {
    let config = Config::default();
    let map = tests::map(&config, |_, _| 80);
    let (_, seen) = driving(0.3).sweep(&map, &config, 0);
    let mut echoes = seen.clone();
    let mut sweeps = SweepComparison::new();
    let agreement = sweeps.compare(&map, &config, &Drive::STANDING, &mut echoes);
    assert_eq!((agreement, echoes), (Agreement::STANDING, seen));
}

#[test]
fn the_travel_between_sweeps_is_known_by_input_or_agreement_alone() {
    let driven = Drive {
        moved_m: Some(0.3),
        ..Drive::STANDING
    };
    let travel = |finding, input| Agreement { finding, input }.moved_m(&driven);
    assert_eq!(travel(Finding::Agreed, Input::Absent), Some(0.0));
    assert_eq!(travel(Finding::Agreed, Input::Late), Some(0.0));
    assert_eq!(travel(Finding::Unconfirmed, Input::Good), Some(0.3));
    assert_eq!(travel(Finding::Moved, Input::Absent), None);
    assert_eq!(travel(Finding::Unconfirmed, Input::Garbled), None);
    assert_eq!(travel(Finding::Missing, Input::Good), None);
}
