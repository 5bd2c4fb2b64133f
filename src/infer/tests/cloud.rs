//! The cloud: independence of the particles' order and scale, sums of weights, and resampling.

use crate::model::cloud::{CAPACITY, CELL_M, CELLS, Cloud, FIRST_END_M, PARTICLES, ReportedAnswer};
use crate::model::tests::{Dice, VIEW, flight, regular, reported};
use crate::model::{MAX_STEPS, Staircase};

/// Standard deviations of tread heights that are exactly known: 0 m.
const SURE: [f32; MAX_STEPS] = [0.0; MAX_STEPS];

/// Returns a flight of `n` risers with a wall behind, whose distance identifies it by number `name`.
fn named(n: usize, name: usize) -> Staircase {
    Staircase {
        wall_m: 3.0 + name as f32,
        ..regular(n, 0.6, 0.3, 0.1)
    }
}

/// Returns a cloud of flights given as (number of risers, log-weight), which are compared with an answer without steps.
fn cloud(particles: &[(usize, f32)]) -> Cloud {
    let mut cloud = Cloud::new();
    let reported = ReportedAnswer {
        edges: &[],
        drop: None,
        view: VIEW,
    };
    for (name, &(n, log_weight)) in particles.iter().enumerate() {
        cloud.add(&named(n, name), log_weight, &SURE, &reported);
    }
    cloud
}

/// Returns the numbers by which a cloud's particles are identified, with their probabilities.
fn held(cloud: &Cloud) -> Vec<(usize, f32)> {
    let all = cloud.particles();
    all.map(|(s, p)| ((s.wall_m - 3.0) as usize, p)).collect()
}

/// Returns the probability of each number of steps, the index, computed directly from (number of risers, log-weight).
fn expected(particles: &[(usize, f32)]) -> [f64; MAX_STEPS + 1] {
    let weights = particles.iter().map(|p| f64::from(p.1));
    let top = weights.clone().fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = weights.map(|w| (w - top).exp()).sum();
    let mut counts = [0.0; MAX_STEPS + 1];
    for (n, w) in particles {
        counts[*n] += (f64::from(*w) - top).exp() / total;
    }
    counts
}

fn assert_counts(particles: &[(usize, f32)]) {
    let counts = cloud(particles).counts();
    for (have, want) in counts.iter().zip(expected(particles)) {
        assert!(
            (f64::from(*have) - want).abs() < 1e-4,
            "{particles:?}: {counts:?}"
        );
    }
}

#[test]
fn weights_count_alike_in_every_order_and_at_every_scale() {
    let logs = [-3.0, 0.0, -1.5, -7.25, -0.5, -20.0, -0.75];
    for turn in 0..logs.len() {
        for scale in [0.0, 88.0, -88.0, 700.0, -5000.0, 30_000.0] {
            let mut particles: Vec<(usize, f32)> = logs
                .iter()
                .enumerate()
                .map(|(k, log)| (k % 4, log + scale))
                .collect();
            particles.rotate_left(turn);
            assert_counts(&particles);
            particles.reverse();
            assert_counts(&particles);
        }
    }
    // Many light particles weigh as much as one heavy particle, also if they come first, and in any number.
    let mut many: Vec<(usize, f32)> = (0..300).map(|_| (1, -5.703_782_5)).collect();
    many.push((3, 0.0));
    assert_counts(&many);
    many.reverse();
    assert_counts(&many);
}

#[test]
fn weights_that_are_none_are_left_out() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for bad in odd {
        for place in 0..3 {
            let mut particles = std::vec![(1, 0.0), (2, 0.0)];
            particles.insert(place, (3, bad));
            let cloud = cloud(&particles);
            let counts = cloud.counts();
            assert!(
                (counts[1] - 0.5).abs() < 1e-6,
                "{bad} at {place}: {counts:?}"
            );
            assert!(cloud.error_log_odds().iter().all(|d| d.is_finite()));
            assert_eq!(held(&cloud).len(), 2);
        }
        let alone = cloud(&[(3, bad)]);
        assert!(alone.counts().iter().all(|c| *c == 0.0));
        assert!(alone.error_log_odds().iter().all(|d| d.is_finite()));
    }
}

#[test]
fn weights_a_million_apart_leave_the_heaviest() {
    for logs in [
        [0.0, -1e6, 1e6],
        [1e6, 0.0, -1e6],
        [f32::MIN, f32::MAX, 0.0],
    ] {
        let heaviest = logs.iter().copied().fold(f32::MIN, f32::max);
        let particles: Vec<(usize, f32)> = logs.iter().copied().enumerate().collect();
        let mut cloud = cloud(&particles);
        cloud.resample();
        let counts = cloud.counts();
        let k = logs.iter().position(|l| *l == heaviest).unwrap();
        assert_eq!(counts[k], 1.0, "{logs:?}");
        assert!(cloud.error_log_odds().iter().all(|d| d.is_finite()));
        let sum: f32 = held(&cloud).iter().map(|h| h.1).sum();
        assert!((sum - 1.0).abs() < 1e-5);
    }
}

#[test]
fn steps_that_cannot_be_seen_are_not_counted() {
    let mut cloud = Cloud::new();
    let reported = ReportedAnswer {
        edges: &[],
        drop: None,
        view: VIEW,
    };
    // The first step hides the second.
    cloud.add(&flight(&[(0.5, 0.55), (0.9, 0.6)]), 0.0, &SURE, &reported);
    assert_eq!(cloud.counts()[..3], [0.0, 1.0, 0.0]);
}

#[test]
fn an_emptied_cloud_is_as_new() {
    let mut cloud = cloud(&[(1, 50.0), (2, 49.0)]);
    cloud.clear();
    let reported = ReportedAnswer {
        edges: &[],
        drop: None,
        view: VIEW,
    };
    cloud.add(&named(3, 0), -100.0, &SURE, &reported);
    assert_eq!(cloud.counts()[3], 1.0);
    assert_eq!(held(&cloud), [(0, 1.0)]);
}

#[test]
fn log_odds_of_a_cell_are_those_of_the_first_error_in_it() {
    // The answer has one step at 0.75 m. One half of the particles agrees, a quarter has another step at 1.05 m, an
    // eighth has no steps, an eighth has another step at 0.35 m.
    let one = flight(&[(0.75, 0.16)]);
    let edges = reported(&[(0.75, 0.16)]);
    let reported = ReportedAnswer {
        edges: &edges,
        drop: None,
        view: VIEW,
    };
    let mut cloud = Cloud::new();
    let log = |share: f32| share.ln();
    cloud.add(&one, log(0.5), &SURE, &reported);
    cloud.add(&one.with(1, 1.05, 0.3), log(0.25), &SURE, &reported);
    cloud.add(&Staircase::nothing(), log(0.125), &SURE, &reported);
    cloud.add(&one.with(0, 0.35, 0.08), log(0.125), &SURE, &reported);
    let log_odds = cloud.error_log_odds();
    let odds = |x_m: f32| {
        // An error is assigned to a place 3 cm nearer; a cell ends where its error may still lie.
        let k = ((x_m - 0.03 - FIRST_END_M) / CELL_M).ceil() as usize;
        (k, log_odds[k].exp())
    };
    let close = |(_, odds): (usize, f32), want: f32| (odds / want - 1.0).abs() < 1e-3;
    assert!(close(odds(0.35), 0.125 / 0.875), "{log_odds:?}");
    assert!(close(odds(0.75), 0.125 / 0.75), "{log_odds:?}");
    assert!(close(odds(1.05), 0.25 / 0.5), "{log_odds:?}");
    let places = [odds(0.35).0, odds(0.75).0, odds(1.05).0];
    for (k, log_odds_of_cell) in log_odds.iter().enumerate() {
        assert!(
            places.contains(&k) || *log_odds_of_cell < -8.0,
            "cell {k}: {log_odds_of_cell}"
        );
    }
    // The product of the survival probabilities of all cells is the probability of no error.
    let right: f32 = log_odds.iter().map(|d| 1.0 / (1.0 + d.exp())).product();
    assert!((right - 0.5).abs() < 0.01, "{right}");
    let sum: f32 = cloud.counts().iter().sum();
    assert!((sum - 1.0).abs() < 1e-5);
}

#[test]
fn error_of_partial_probability_is_split_between_its_cell_and_later_ones() {
    let one = flight(&[(0.75, 0.16)]);
    let edges = reported(&[(0.75, 0.16)]);
    let reported = ReportedAnswer {
        edges: &edges,
        drop: None,
        view: VIEW,
    };
    let mut cloud = Cloud::new();
    cloud.add(&one.with(1, 1.05, 0.3), 0.0, &[0.03; MAX_STEPS], &reported);
    let log_odds = cloud.error_log_odds();
    let k = ((0.72 - FIRST_END_M) / CELL_M).ceil() as usize;
    let wrong = 1.0 / (1.0 + (-log_odds[k]).exp());
    assert!((wrong - 0.3173).abs() < 0.02, "{wrong}");
    // The particles without an error there have one at the missing step, with certainty.
    assert_eq!(log_odds.iter().copied().fold(f32::MIN, f32::max), 4.0);
    assert_eq!(log_odds.len(), CELLS);
}

#[test]
fn resampling_keeps_the_heavy_exactly_and_no_more_than_there_is_room_for() {
    let mut dice = Dice::new(1);
    for round in 0..50 {
        let particles: Vec<(usize, f32)> = (0..CAPACITY)
            .map(|k| match k % 5 {
                0 => (k % 4, dice.even(-1.0, 0.0)),
                _ => (k % 4, dice.even(-9.0, -4.0)),
            })
            .collect();
        let mut cloud = cloud(&particles);
        let before = held(&cloud);
        assert_eq!(before.len(), CAPACITY);
        cloud.resample();
        let after = held(&cloud);
        assert!(after.len() <= PARTICLES && after.len() > PARTICLES - 3);
        let weight = |name: usize| after.iter().find(|h| h.0 == name).map(|h| h.1);
        let first = (particles[0].1, weight(0).expect("a heavy one"));
        for name in (0..CAPACITY).step_by(5) {
            let (log, now) = (particles[name].1, weight(name).expect("a heavy one"));
            let ratio = (now / first.1).ln();
            assert!((ratio - (log - first.0)).abs() < 1e-4, "{round}: {name}");
        }
        // A second resampling changes nothing.
        let twice = {
            cloud.resample();
            held(&cloud)
        };
        assert_eq!(twice, after);
    }
}

#[test]
fn resampling_is_the_same_every_time() {
    let mut dice = Dice::new(2);
    let particles: Vec<(usize, f32)> = (0..500).map(|k| (k % 5, dice.even(-8.0, 0.0))).collect();
    let run = || {
        let mut cloud = cloud(&particles);
        cloud.resample();
        held(&cloud)
    };
    assert_eq!(run(), run());
}

#[test]
fn resampling_keeps_every_particles_mean_weight() {
    let mut dice = Dice::new(3);
    let rounds = 600;
    let (mut off, mut squares) = ([0.0f32; 4], [0.0f32; 4]);
    for _ in 0..rounds {
        let particles: Vec<(usize, f32)> = (0..CAPACITY)
            .map(|k| (k % 4, dice.even(-6.0, 0.0) - (k % 4) as f32))
            .collect();
        let before = cloud(&particles);
        let mut after = cloud(&particles);
        after.resample();
        for (n, (off, squares)) in off.iter_mut().zip(&mut squares).enumerate() {
            let share = |cloud: &Cloud| -> f32 {
                let all = cloud.particles();
                all.filter(|(s, _)| s.len() == n).map(|(_, p)| p).sum()
            };
            let d = share(&after) - share(&before);
            *off += d / rounds as f32;
            *squares += d * d / rounds as f32;
        }
    }
    for (off, squares) in off.iter().zip(squares) {
        let error = (squares / rounds as f32).sqrt();
        assert!(
            off.abs() < 4.0 * error && off.abs() < 2e-3,
            "{off} ± {error}"
        );
    }
}

#[test]
fn resampling_keeps_shares_where_all_weigh_about_the_same() {
    // More particles than are kept, the second half with another count: none is heavy.
    let alike: Vec<(usize, f32)> = (0..CAPACITY).map(|k| (1 + 2 * k / CAPACITY, 0.0)).collect();
    let long: Vec<(usize, f32)> = (0..40 * PARTICLES)
        .map(|k| (1 + k / (20 * PARTICLES), 0.001 * (k % 7) as f32))
        .collect();
    for particles in [alike, long] {
        let mut cloud = cloud(&particles);
        cloud.resample();
        let all = cloud.particles();
        let second: f32 = all.filter(|(s, _)| s.len() == 2).map(|(_, p)| p).sum();
        assert!((second - 0.5).abs() < 0.05, "{second}");
        assert!(held(&cloud).len() > PARTICLES / 2);
    }
}

#[test]
fn resampling_keeps_rivals_alive() {
    // One particle is almost certain; the others, of two counts, have one per cent together.
    let mut dice = Dice::new(4);
    let light = (0.01f32 / 63.0).ln();
    let mut particles: Vec<(usize, f32)> = (0..63)
        .map(|k| (1 + k / 32, light + dice.even(-0.5, 0.5)))
        .collect();
    particles.insert(17, (3, 0.0));
    let before = expected(&particles);
    let mut cloud = cloud(&particles);
    cloud.resample();
    let all = |n: usize| cloud.particles().filter(move |(s, _)| s.len() == n);
    for n in [1, 2] {
        let share: f32 = all(n).map(|(_, p)| p).sum();
        let was = before[n] as f32;
        // One draw more or less of the sixteen, in each of two resamplings.
        assert!((share / was - 1.0).abs() < 0.13, "{n}: {share} was {was}");
        assert!(all(n).count() > 12);
    }
    assert_eq!(all(3).count(), 1);
}
