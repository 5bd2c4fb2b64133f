//! Reported standard deviations against the errors that they state, and thresholds from both sides.

use crate::answer::{DropEdge, Step};
use crate::infer::bases::Posterior;
use crate::infer::dimensions::{self, RisenFlight};
use crate::infer::horizon::HorizonAccumulator;
use crate::infer::judgement::Likeliest;
use crate::infer::propose::ascending::Ascending;
use crate::infer::propose::scene::Scene;
use crate::infer::propose::search::Search;
use crate::infer::propose::stairs::{Flight, FlightShape};
use crate::model::cloud::{CELL_M, FIRST_END_M, ReportedAnswer};
use crate::model::tests::{Dice, VIEW, echoes, geometry, model, regular};
use crate::model::{GroundKind, MAX_STEPS, Staircase};
use crate::params::{Numbers, Params, measured};

/// Mean squares of error / σ over the steps of many scans.
#[derive(Debug, Default)]
struct MeanSquares {
    distance: f32,
    height: f32,
    steps: f32,
}

/// Returns the mean squares of error / σ of the steps that are measured on simulated echoes of flights of three risers,
/// with the measurement model's own noise.
fn mean_squares() -> MeanSquares {
    let geometry = geometry();
    let mut sums = MeanSquares::default();
    for seed in 0..300 {
        let mut dice = Dice::new(seed);
        let truth = regular(3, dice.even(0.55, 0.9), 0.29, dice.even(0.13, 0.18));
        let echoes = echoes(&truth, &mut dice, 1.0);
        let model = model(&echoes, &geometry);
        let mut scene = Scene::new(VIEW.height_m, &Params::DEFAULT);
        scene.risers(&echoes);
        let stairs = Ascending::new(&scene);
        let search = Search::new(&stairs);
        let mut flight = Flight {
            shape: FlightShape {
                rise_m: truth.rise(),
                open: false,
            },
            ..Flight::default()
        };
        for k in 0..truth.len() {
            flight.chain.push(search.at(truth.x(k))).unwrap();
        }
        let risen = RisenFlight::of(&search, flight);
        let measured = dimensions::ascending(&stairs, &risen, &model, truth, 0.0);
        for (k, step) in measured.answer.steps.iter().enumerate() {
            let distance = (step.distance_m - truth.x(k)) / step.distance_sigma_m;
            let height = (step.height_m - truth.level(k + 1)) / step.height_sigma_m;
            sums.distance += distance * distance;
            sums.height += height * height;
            sums.steps += 1.0;
        }
    }
    sums.distance /= sums.steps;
    sums.height /= sums.steps;
    sums
}

#[test]
fn errors_of_steps_are_as_large_as_their_standard_deviations_say() {
    let mean = mean_squares();
    assert!(mean.steps > 850.0, "{mean:?}");
    // Half the standard deviation would make four times the mean square, twice of it a quarter.
    assert!((0.4..1.6).contains(&mean.distance), "{mean:?}");
    assert!((0.2..0.9).contains(&mean.height), "{mean:?}");
}

/// Returns the likeliest explanation where stairs outweigh level ground by `lead`, nats.
fn likeliest(lead: f32) -> Likeliest {
    let mut posterior = std::boxed::Box::new(Posterior::new(&measured::MODEL, Numbers::DEFAULT));
    posterior.model.view = VIEW;
    let none = ReportedAnswer {
        edges: &[],
        drop: None,
        view: VIEW,
    };
    let sigmas = [0.01; MAX_STEPS];
    let stairs = regular(2, 0.8, 0.3, 0.16);
    posterior.cloud.add(&stairs, lead, &sigmas, &none);
    posterior
        .cloud
        .add(&Staircase::nothing(), 0.0, &sigmas, &none);
    posterior.likeliest(None)
}

#[test]
fn stairs_are_accepted_from_even_odds_on() {
    for lead in [0.05, 1.0, 5.0] {
        assert_eq!(
            likeliest(lead).staircase.map(|s| s.len()),
            Some(2),
            "{lead}"
        );
    }
    for lead in [-0.05, -1.0, -5.0] {
        assert_eq!(likeliest(lead).staircase, None, "{lead}");
    }
}

#[test]
fn a_drop_is_reported_from_a_probability_of_one_half_on() {
    let end = |probability: f32| {
        let mut posterior =
            std::boxed::Box::new(Posterior::new(&measured::MODEL, Numbers::DEFAULT));
        let none = ReportedAnswer {
            edges: &[],
            drop: None,
            view: VIEW,
        };
        let log_odds = (probability / (1.0 - probability)).ln();
        let sigmas = [0.01; MAX_STEPS];
        posterior
            .cloud
            .add(&Staircase::drop(0.9), log_odds, &sigmas, &none);
        posterior
            .cloud
            .add(&Staircase::nothing(), 0.0, &sigmas, &none);
        posterior.cloud.end()
    };
    assert_eq!(end(0.49), None);
    assert!(end(0.51).is_some_and(|drop| (drop.distance_m - 0.9).abs() < 0.05));
}

#[test]
fn a_single_rise_is_a_step_from_55_mm_to_30_cm() {
    let kind = |height_m: f32| GroundKind::single(height_m, &Params::DEFAULT);
    assert_eq!(kind(0.054), GroundKind::Threshold);
    assert_eq!(kind(0.056), GroundKind::Stairs);
    assert_eq!(kind(0.299), GroundKind::Stairs);
    assert_eq!(kind(0.301), GroundKind::Box);
}

/// Returns the horizon, metres, of an answer that is correct with probability `near` up to one metre and `far` beyond;
/// the threshold of `ok` is 0.98.
fn horizon_m(steps: &[Step], drop: Option<DropEdge>, near: f32, far: f32) -> f32 {
    let mut reach = HorizonAccumulator::new(steps, drop);
    for k in 0..24 {
        let end_m = FIRST_END_M + CELL_M * k as f32;
        let p_correct = if end_m < 1.05 { near } else { far };
        reach.add_cell(end_m, p_correct, 0.98);
    }
    reach.horizon_m(&Params::DEFAULT)
}

#[test]
fn an_answer_is_valid_up_to_one_metre_from_the_threshold_of_ok_on() {
    assert!((horizon_m(&[], None, 0.981, 0.5) - 1.0).abs() < 0.01);
    assert_eq!(horizon_m(&[], None, 0.979, 0.5), 0.0);
}

#[test]
fn an_answer_is_valid_beyond_one_metre_from_995_per_mille_on() {
    assert!((horizon_m(&[], None, 0.999, 0.9951) - 2.0).abs() < 0.01);
    assert!((horizon_m(&[], None, 0.999, 0.9949) - 1.0).abs() < 0.01);
}

#[test]
fn the_horizon_ends_before_a_step_whose_expanded_uncertainty_exceeds_8_cm() {
    let step = |distance_sigma_m, height_sigma_m| Step {
        distance_m: 1.54,
        height_m: 0.17,
        distance_sigma_m,
        height_sigma_m,
        ..Step::default()
    };
    // Three standard deviations.
    for vague in [step(0.0268, 0.005), step(0.005, 0.0268)] {
        assert!(horizon_m(&[vague], None, 0.999, 0.999) < 1.52, "{vague:?}");
    }
    for sharp in [step(0.0265, 0.005), step(0.005, 0.0265)] {
        assert!(horizon_m(&[sharp], None, 0.999, 0.999) > 1.9, "{sharp:?}");
    }
}
