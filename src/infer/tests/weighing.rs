//! Weights, refinement and variants of hypotheses, on the echoes of a known staircase and on random echoes.

use crate::estimate::Estimate;
use crate::infer::refine::{Refinement, refine};
use crate::infer::variants::{Hypothesis, Variants, weight};
use crate::model::cloud::{Cloud, ReportedAnswer};
use crate::model::tests::{Dice, VIEW, echo, echoes, flight, geometry, model, regular, reported};
use crate::model::{GroundKind, MAX_STEPS, Model, Sigmas, Staircase};
use crate::params::Params;
use crate::signal::echoes::Echo;
use proptest::prelude::*;

/// Returns usual flights of two to four risers.
fn flights() -> Vec<Staircase> {
    let mut flights = Vec::new();
    for n in [2, 3, 4] {
        for (going_m, rise_m) in [(0.26, 0.19), (0.29, 0.17), (0.34, 0.14)] {
            for first_m in [0.6, 0.85] {
                flights.push(regular(n, first_m, going_m, rise_m));
            }
        }
    }
    flights
}

#[test]
fn true_flight_has_a_greater_weight_than_other_hypotheses() {
    let mut dice = Dice::new(11);
    let geometry = geometry();
    for s in flights() {
        let echoes = echoes(&s, &mut dice, 0.5);
        let model = model(&echoes, &geometry);
        let truth = weight(&model, &s);
        let against = |other: &Staircase, nats: f32, what: &str| {
            let rival = weight(&model, other);
            assert!(truth > rival + nats, "{what}: {truth} {rival} of {s:?}");
        };
        against(&Staircase::nothing(), 10.0, "nothing");
        against(&s.without_last(), 3.0, "one less");
        let (n, next) = (s.len(), s.last_x() + s.going().unwrap());
        // Behind a nosing above the mirror little of it would be visible.
        let nats = if s.level(n) < VIEW.height_m { 1.9 } else { 0.5 };
        against(&s.with(n, next, s.level(n) + s.rise()), nats, "one more");
        for k in 0..n {
            // Behind a nosing above the mirror its height is hardly determined.
            if s.level(k) > VIEW.height_m - 0.01 {
                continue;
            }
            for off in [-0.04, 0.04] {
                let mut other = s;
                other.top_m[k] += off;
                against(&other, 1.0, "one height");
            }
        }
        for off in [-0.04, 0.04] {
            let mut other = s;
            let tops = other.top_m.iter_mut().take(n);
            tops.for_each(|top| *top += off);
            against(&other, 3.0, "all heights");
            let mut other = s;
            other.x_m.iter_mut().for_each(|x| *x += off);
            against(&other, 10.0, "all places");
        }
    }
}

#[test]
fn floor_has_a_greater_weight_than_stairs_with_and_without_a_gap() {
    let geometry = geometry();
    let floor: Vec<Echo> = (0..12)
        .map(|k| echo(0.4 + 0.09 * k as f32, 0.0, 14.0))
        .collect();
    let model = model(&floor, &geometry);
    let nothing = weight(&model, &Staircase::nothing());
    for s in flights() {
        assert!(nothing > weight(&model, &s) + 5.0);
    }
}

/// Returns a staircase refined on the model's echoes, and the standard deviations of its treads' heights, metres. Its
/// rise is known with a standard deviation of 2 cm.
fn refined(model: &Model<'_>, s: &Staircase) -> (Staircase, Sigmas) {
    let rise = Estimate::new(s.rise(), 0.02);
    let (mut s, mut out) = (*s, Refinement::default());
    refine(model, &mut s, rise, &Params::DEFAULT, &mut out);
    (s, out.levels.map(|level| level.height.sigma()))
}

#[test]
fn refined_heights_have_errors_as_large_as_their_sigma() {
    let mut dice = Dice::new(21);
    let geometry = geometry();
    let (mut squares, mut errors, mut number) = (0.0f32, 0.0f32, 0.0f32);
    let mut sigma_sum = 0.0;
    for round in 0..200 {
        let rise = dice.even(0.13, 0.18);
        let mut truth = regular(2 + round % 2, dice.even(0.55, 0.9), 0.29, rise);
        truth
            .top_m
            .iter_mut()
            .take(truth.steps.into())
            .for_each(|top| *top += dice.normal(0.004));
        let echoes = echoes(&truth, &mut dice, 1.0);
        let model = model(&echoes, &geometry);
        // Start of the refinement as by the search: a rise 5 mm off, risers at the corners.
        let off = if round % 4 < 2 { 0.005 } else { -0.005 };
        let start = regular(truth.len(), truth.x(0) + 0.004, 0.29, rise + off);
        let (found, sigmas) = refined(&model, &start);
        assert_eq!(found.len(), truth.len());
        for (k, sigma) in sigmas.iter().enumerate().take(truth.len()) {
            assert!(
                (found.x(k) - truth.x(k)).abs() < 0.01,
                "{found:?} {truth:?}"
            );
            let error = found.level(k + 1) - truth.level(k + 1);
            let z = error / sigma;
            squares += z * z;
            errors += error.abs();
            sigma_sum += sigma;
            number += 1.0;
        }
    }
    let rms = (squares / number).sqrt();
    assert!((0.6..1.5).contains(&rms), "deviations off by {rms}");
    assert!(errors / number < 0.005, "{}", errors / number);
    assert!(sigma_sum / number < 0.008, "{}", sigma_sum / number);
}

#[test]
fn refinement_without_echoes_keeps_heights_and_enlarges_their_sigma() {
    let geometry = geometry();
    let s = regular(3, 0.7, 0.3, 0.16);
    let (found, sigmas) = refined(&model(&[], &geometry), &s);
    for k in 0..3 {
        assert!((found.level(k + 1) - s.level(k + 1)).abs() < 1e-5);
        assert_eq!(found.x(k), s.x(k));
    }
    // The rise has a standard deviation of 2 cm, so that of a level grows with its height, and any step may be
    // irregular.
    assert!((0.020..0.025).contains(&sigmas[0]), "{sigmas:?}");
    assert!((0.060..0.065).contains(&sigmas[2]), "{sigmas:?}");
}

#[test]
fn weight_of_a_hypothesis_is_the_sum_over_its_risers() {
    let geometry = geometry();
    for s in flights() {
        let echoes = echoes(&s, &mut Dice::new(7), 0.5);
        let model = model(&echoes, &geometry);
        let base = Hypothesis::new(&model, s, [0.01; MAX_STEPS]);
        assert!((base.log_weight - weight(&model, &s)).abs() < 1e-3);
    }
}

#[test]
fn variants_find_the_step_that_a_hypothesis_lacks_or_has_too_many() {
    let geometry = geometry();
    let truth = regular(3, 0.7, 0.29, 0.16);
    let echoes = echoes(&truth, &mut Dice::new(9), 0.2);
    let model = model(&echoes, &geometry);
    let more = truth.with(3, 1.57, 0.64);
    let front = flight(&[(0.99, 0.32), (1.28, 0.48)]);
    let odd = flight(&[(0.7, 0.16), (0.99, 0.365), (1.28, 0.48)]);
    for (start, n) in [(truth.without_last(), 3), (more, 3), (front, 3), (odd, 3)] {
        let mut cloud = Cloud::new();
        let reported = ReportedAnswer {
            edges: &[],
            drop: None,
            view: VIEW,
        };
        let base = Hypothesis::new(&model, start, [0.01; MAX_STEPS]);
        let mut variants = Variants {
            model: &model,
            reported: &reported,
            cloud: &mut cloud,
        };
        variants.add_variants(&base);
        let counts = cloud.counts();
        assert!(counts[n] > 0.5, "{start:?}: {counts:?}");
    }
}

#[test]
fn a_rise_that_is_odd_is_proposed() {
    let geometry = geometry();
    let truth = flight(&[(0.7, 0.16), (0.99, 0.35), (1.28, 0.51)]);
    let echoes = echoes(&truth, &mut Dice::new(13), 0.2);
    let model = model(&echoes, &geometry);
    let mut cloud = Cloud::new();
    let reported = ReportedAnswer {
        edges: &[],
        drop: None,
        view: VIEW,
    };
    let base = Hypothesis::new(&model, regular(3, 0.7, 0.29, 0.16), [0.01; MAX_STEPS]);
    Variants {
        model: &model,
        reported: &reported,
        cloud: &mut cloud,
    }
    .add_variants(&base);
    let near: f32 = cloud
        .particles()
        .filter(|(s, _)| s.len() == 3 && (s.level(2) - 0.35).abs() < 0.005)
        .map(|(_, p)| p)
        .sum();
    assert!(near > 0.3, "{near}");
}

#[test]
fn variant_with_fewer_risers_has_the_weight_of_that_flight() {
    let geometry = geometry();
    let truth = regular(2, 0.7, 0.29, 0.16);
    let echoes = echoes(&truth, &mut Dice::new(17), 0.2);
    let model = model(&echoes, &geometry);
    let reported = ReportedAnswer {
        edges: &[],
        drop: None,
        view: VIEW,
    };
    let mut cloud = Cloud::new();
    // Two steps too many, which are removed one after the other.
    let base = Hypothesis::new(&model, regular(4, 0.7, 0.29, 0.16), [0.01; MAX_STEPS]);
    Variants {
        model: &model,
        reported: &reported,
        cloud: &mut cloud,
    }
    .add_variants(&base);
    // A reference particle of the same weight.
    let mark = Staircase {
        kind: GroundKind::Box,
        ..truth
    };
    cloud.add(&mark, weight(&model, &truth), &base.sigmas, &reported);
    let probability = |kind: GroundKind| {
        let mut same = cloud
            .particles()
            .filter(|(s, _)| s.kind == kind && s.len() == 2 && s.x(0) == truth.x(0));
        same.next().map_or(0.0, |(_, p)| p)
    };
    let (put, mark) = (
        probability(GroundKind::Stairs),
        probability(GroundKind::Box),
    );
    assert!(
        mark > 0.1 && (put / mark - 1.0).abs() < 0.02,
        "{put} {mark}"
    );
}

/// Returns a strategy of numbers that are evenly distributed between `low` and `high`.
fn between(low: f32, high: f32) -> impl Strategy<Value = f32> {
    any::<u16>().prop_map(move |v| low + (high - low) * f32::from(v) / f32::from(u16::MAX))
}

fn any_echo() -> impl Strategy<Value = Echo> {
    let snr = prop_oneof![8 => between(2.8, 60.0), 1 => Just(0.0f32), 1 => between(60.0, 300.0)];
    let range = prop_oneof![12 => between(0.1, 3.2), 1 => Just(0.0f32), 1 => between(0.12, 0.13)];
    let sigma = prop_oneof![4 => between(0.0005, 0.02), 1 => Just(0.0f32), 1 => between(0.02, 3.0)];
    (snr, range, between(-0.4, 1.7), between(0.0, 8.0), sigma).prop_map(
        |(snr_db, range_m, angle_rad, width, angle_sigma_rad)| Echo {
            snr_db,
            range_m,
            angle_rad,
            x_m: range_m * angle_rad.cos(),
            y_m: VIEW.height_m - range_m * angle_rad.sin(),
            width,
            angle_sigma_rad,
            range_sigma_m: 0.001,
            native_bin: 0.0,
            phasor: [1.0, 0.0],
        },
    )
}

fn any_staircase() -> impl Strategy<Value = Staircase> {
    let riser = (between(0.0, 0.6), between(-0.05, 0.35));
    let ramp = (between(0.0, 2.5), between(0.0, 0.3));
    let kinds = prop_oneof![
        4 => Just(GroundKind::Stairs),
        1 => Just(GroundKind::Nothing),
        1 => ramp.prop_map(|(from_m, slope)| GroundKind::Ramp { from_m, slope }),
        1 => between(0.0, 2.5).prop_map(|at_m| GroundKind::Drop { at_m }),
        1 => Just(GroundKind::Box),
        1 => Just(GroundKind::Threshold),
    ];
    let wall = prop_oneof![Just(f32::INFINITY), between(0.0, 3.0)];
    let risers = prop::collection::vec(riser, 0..=MAX_STEPS);
    (kinds, risers, prop::bool::ANY, between(0.0, 0.08), wall).prop_map(
        |(kind, risers, open, overhang_m, wall_m)| {
            let mut s = Staircase::nothing();
            let bare = matches!(
                kind,
                GroundKind::Nothing | GroundKind::Ramp { .. } | GroundKind::Drop { .. }
            );
            if !bare {
                let (mut x, mut top) = (0.1, 0.0);
                for (k, (going, rise)) in risers.into_iter().enumerate() {
                    (x, top) = (x + going, top + rise);
                    s = s.with(k, x, top);
                }
            }
            Staircase {
                kind,
                open,
                overhang_m,
                wall_m: match kind {
                    GroundKind::Ramp { .. } | GroundKind::Drop { .. } => f32::INFINITY,
                    _ => wall_m,
                },
                ..s
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn any_echoes_have_a_likelihood(
        echoes in prop::collection::vec(any_echo(), 0..=64),
        s in any_staircase(),
    ) {
        let geometry = geometry();
        let model = model(&echoes, &geometry);
        for k in 0..=s.len() {
            prop_assert!(model.riser_log_likelihood(&s, k).is_finite(), "riser {k} of {s:?}");
        }
        let all = weight(&model, &s);
        prop_assert!(all.is_finite(), "{all}");
        let (found, sigmas) = refined(&model, &s);
        for (k, sigma) in sigmas.iter().enumerate().take(found.len()) {
            prop_assert!(found.x(k).is_finite() && found.level(k + 1).is_finite());
            prop_assert!(sigma.is_finite() && *sigma > 0.0);
        }
        let mut cloud = Cloud::new();
        let edges = reported(&[(0.8, 0.16)]);
        let reported = ReportedAnswer { edges: &edges, drop: None, view: VIEW };
        Variants { model: &model, reported: &reported, cloud: &mut cloud }
            .add_variants(&Hypothesis::new(&model, found, sigmas));
        cloud.resample();
        prop_assert!(cloud.error_log_odds().iter().all(|d| d.is_finite()));
        let sum: f32 = cloud.counts().iter().sum();
        prop_assert!(sum == 0.0 || (sum - 1.0).abs() < 1e-4, "{sum}");
    }
}

#[test]
fn wall_changes_the_log_likelihood_of_the_landing_alone() {
    let geometry = geometry();
    let mut dice = Dice::new(7);
    let echoes: Vec<Echo> = (0..24)
        .map(|_| {
            let (x_m, y_m) = (dice.even(0.4, 2.4), dice.even(0.0, 1.0));
            echo(x_m, y_m, dice.even(5.0, 45.0))
        })
        .collect();
    let model = model(&echoes, &geometry);
    for s in [Staircase::nothing(), regular(3, 0.6, 0.3, 0.17)] {
        let base = Hypothesis::new(&model, s, [0.0; MAX_STEPS]);
        for wall_m in [1.7, 2.3, f32::INFINITY] {
            let walled = base.walled(&model, wall_m);
            let anew = Hypothesis::new(&model, Staircase { wall_m, ..s }, [0.0; MAX_STEPS]);
            let off = walled.log_weight - anew.log_weight;
            assert!(off.abs() < 1e-2, "{wall_m}: {off}");
            // The change is reversible.
            let back = walled.walled(&model, s.wall_m);
            assert!((back.log_weight - base.log_weight).abs() < 1e-2);
        }
    }
}
