//! Tests of staircases for which the search alone gives a wrong answer.

use host_sim::answer::{Answer, metres};
use host_sim::random::Kind;
use host_sim::replay::{self, Options};
use host_sim::simulation::random_scan;

/// Maximum distance between matching steps, metres, as in scoring.
const SAME_M: f64 = 0.10;

/// Returns the answer to a random scene, and the distances of its true steps, metres.
fn answer(kind: Kind, seed: u64) -> (Answer, Vec<f64>) {
    let recording = random_scan(kind, kind.variety(), seed).unwrap();
    let mut answers = replay::answers(&recording, &Options::default(), |_| ()).unwrap();
    let truth = recording.meta.truth.unwrap().steps;
    let steps = truth.iter().map(|s| s.distance_m);
    (answers.remove(0), steps.collect())
}

/// Asserts that every step is reported and no other.
fn assert_exact(kind: Kind, seeds: &[u64]) {
    for &seed in seeds {
        let (answer, truth) = answer(kind, seed);
        let steps = &answer.steps;
        assert_eq!(steps.len(), truth.len(), "{seed}: {:?}", answer.sentences);
        for (step, x) in steps.iter().zip(truth) {
            let off = (metres(step.distance) - x).abs();
            assert!(off < SAME_M, "{seed}: {:?}", answer.sentences);
        }
    }
}

#[test]
fn floating_treads_before_a_wall() {
    assert_exact(Kind::Ascending, &[5_097]);
    assert_exact(Kind::Mounting, &[5_135]);
}

#[test]
fn a_kerb_whose_height_only_the_pavement_behind_shows() {
    assert_exact(Kind::Ascending, &[5_041, 5_133]);
}

#[test]
fn a_second_flight_behind_a_landing() {
    assert_exact(Kind::Landing, &[1_000_015]);
}

#[test]
fn a_step_whose_top_is_just_above_the_mirror() {
    assert_exact(Kind::Ascending, &[5_384]);
}

#[test]
fn ramps_with_echoes_as_regular_as_flat_steps() {
    assert_exact(Kind::None, &[5_056]);
    assert_exact(Kind::Clutter, &[5_021, 5_132]);
}
