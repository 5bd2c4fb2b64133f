//! The estimator on synthetic maps: known answers for some, plausibility for the rest.

use crate::answer::{Direction, PossibleStep, Step};
use crate::config::Config;
use crate::estimate::expanded;
use crate::infer::propose::scene::Scene;
use crate::infer::*;
use crate::model::tests::Dice;
use crate::params::Params;
use crate::signal::echoes::Echo;
use crate::signal::echoes::tests::noise;
use crate::signal::image::tests::{Seen, scene};
use crate::verdict::{Outcome, Reasons, Status};
use proptest::prelude::*;

fn estimate(seen: &Seen, config: &Config, backwards: bool) -> Outcome {
    let mut estimator = Box::new(Likelihood::new());
    estimator.finish(seen, &seen.found(config, backwards), config, 1, &mut ())
}

/// Returns point scatterers (distance and height, metres; power, dB over the noise) of closed stairs: a corner and a
/// nosing at each riser, and floor before the first. `heights` are those of the risers' tops above the ground, metres.
fn staircase(first: f32, going: f32, heights: &[f32]) -> Vec<(f32, f32, f64)> {
    let mut points = vec![(0.42, 0.0, 18.0), (0.52, 0.0, 15.0)];
    let mut level = 0.0;
    for (k, &height) in heights.iter().enumerate() {
        let x = first + k as f32 * going;
        if level < 0.35 {
            points.push((x, level, 38.0));
        }
        points.push((x, height, 30.0));
        level = height;
    }
    points
}

#[test]
fn stairs_are_found_where_they_are() {
    let config = Config::default();
    let heights = [0.16, 0.32, 0.48];
    let map = scene(&config, &staircase(0.70, 0.29, &heights));
    let outcome = estimate(&map, &config, false);
    assert_eq!(outcome.answer.direction, crate::answer::Direction::Up);
    assert_eq!(outcome.answer.steps.len(), 3, "{outcome:?}");
    for (k, (step, height)) in outcome.answer.steps.iter().zip(heights).enumerate() {
        let x = 0.70 + 0.29 * k as f32;
        assert!((step.distance_m - x).abs() < 0.005, "{step:?}");
        assert!((step.height_m - height).abs() < 0.03, "{step:?}");
        assert!(step.distance_sigma_m > 0.0 && step.height_sigma_m > 0.0);
    }
    assert_eq!(outcome, estimate(&map, &config, true));
}

#[test]
fn a_floor_is_no_staircase() {
    let config = Config::default();
    let floor: Vec<_> = (0..12).map(|k| (0.4 + 0.1 * k as f32, 0.0, 20.0)).collect();
    let outcome = estimate(&scene(&config, &floor), &config, false);
    assert!(outcome.answer.steps.is_empty(), "{outcome:?}");
    assert_ne!(outcome.status(), Status::Fault);
}

#[test]
fn noise_alone_is_a_fault() {
    let config = Config::default();
    let outcome = estimate(&scene(&config, &[]), &config, false);
    assert_eq!(outcome.reasons(), Reasons::NONE.with(Reason::NoEcho));
    assert!(outcome.status() == Status::Fault && outcome.answer == Answer::NONE);
}

/// Returns the configuration of a mirror 1.1 m above the ground that scans the height plane.
fn over_an_edge() -> Config {
    Config {
        mount: crate::config::MountConfig {
            mount_height: 110_000,
            plane: crate::config::Planes::Height,
            ..Default::default()
        },
        ..Config::default()
    }
}

#[test]
fn stairs_going_down_are_rows_below_each_other() {
    let config = over_an_edge();
    let points = [
        (-0.30, 0.0, 18.0),
        (-0.20, 0.0, 20.0),
        (-0.11, 0.0, 24.0),
        (0.0, -0.16, 40.0),
        (0.16, -0.16, 16.0),
        (0.28, -0.32, 15.0),
        (0.40, -0.32, 14.0),
        (0.55, -0.32, 12.0),
    ];
    let outcome = estimate(&scene(&config, &points), &config, false);
    assert_eq!(outcome.answer.direction, Direction::Down, "{outcome:?}");
    let levels: Vec<f32> = outcome.answer.steps.iter().map(|s| s.height_m).collect();
    assert_eq!(levels.len(), 2, "{outcome:?}");
    assert!((levels[0] + 0.16).abs() < 0.01 && (levels[1] + 0.32).abs() < 0.01);
}

/// Returns echoes along a surface at a height, metres, some 4 cm apart, from `from_m` up to `to_m`.
fn surface(
    dice: &mut Dice,
    from_m: f32,
    to_m: f32,
    height_m: f32,
    db: f64,
) -> Vec<(f32, f32, f64)> {
    let mut points = Vec::new();
    let mut x = from_m + dice.even(0.0, 0.04);
    while x < to_m {
        let level = height_m + dice.normal(0.002);
        points.push((x, level, db + f64::from(dice.even(-3.0, 3.0))));
        x += dice.even(0.025, 0.055);
    }
    points
}

#[test]
fn errors_of_steps_going_down_are_as_large_as_their_standard_deviations_say() {
    let config = over_an_edge();
    let (mut squares, mut steps) = ([0.0f32; 2], 0.0);
    for seed in 0..40 {
        let mut dice = Dice::new(seed);
        let (edge, going, rise) = (
            dice.even(-0.1, 0.1),
            dice.even(0.27, 0.32),
            dice.even(0.15, 0.18),
        );
        let mut points = surface(&mut dice, edge - 0.35, edge, 0.0, 20.0);
        for k in 0..2 {
            let (from, level) = (edge + k as f32 * going, -rise * (k + 1) as f32);
            // The tread before hides the beginning.
            let hidden = rise * from.max(0.0) / (1.1 + level + rise);
            points.extend(surface(&mut dice, from + hidden, from + going, level, 18.0));
        }
        let outcome = estimate(&scene(&config, &points), &config, false);
        for step in &outcome.answer.steps {
            let k = (-step.height_m / rise).round();
            let truth = (edge + (k - 1.0) * going, -k * rise);
            let z = [
                (step.distance_m - truth.0) / step.distance_sigma_m,
                (step.height_m - truth.1) / step.height_sigma_m,
            ];
            squares = [0, 1].map(|i| squares[i] + z[i] * z[i]);
            steps += 1.0;
        }
    }
    assert_eq!(steps, 80.0, "two steps of each flight");
    let [distance, height] = squares.map(|square| square / steps);
    // Half the standard deviation would make four times the mean square, twice of it a quarter. That of the height contains
    // errors of the mounting, which are not simulated here.
    assert!((0.35..1.4).contains(&distance), "{distance}");
    assert!((0.05..0.25).contains(&height), "{height}");
}

#[test]
fn a_corner_without_anything_above_is_no_clear_way() {
    let config = Config::default();
    for x in [1.0, 1.1, 1.2] {
        let map = scene(&config, &[(x, 0.0, 42.0)]);
        let outcome = estimate(&map, &config, false);
        // This may be the corner of a kerb or a threshold: the answer must not be valid beyond it.
        assert!(
            outcome.horizon_m().is_some_and(|end| end < x),
            "{outcome:?}"
        );
    }
}

/// Returns the answer to a scan of point scatterers at (distance, height, power): metres, metres, dB over the noise.
fn answer(points: &[(f32, f32, f64)]) -> Outcome {
    let config = Config::default();
    estimate(&scene(&config, points), &config, false)
}

#[test]
fn a_second_flight_goes_on_behind_a_landing() {
    let mut points = staircase(0.60, 0.28, &[0.15, 0.30]);
    points.extend([(1.85, 0.30, 34.0), (1.85, 0.45, 28.0)]);
    points.extend([(1.85, 0.40, 40.0), (2.13, 0.60, 26.0)]);
    let outcome = answer(&points);
    let steps: Vec<_> = outcome
        .answer
        .steps
        .iter()
        .map(|s| (s.distance_m, s.height_m))
        .collect();
    assert_eq!(steps.len(), 4, "{steps:?}");
    for (step, x) in steps.iter().zip([0.60, 0.88, 1.85, 2.13]) {
        assert!((step.0 - x).abs() < 0.02, "{steps:?}");
    }
    // A landing makes no step irregular: the rises are equal.
    assert!(!outcome.reasons().has(Reason::IrregularStep), "{outcome:?}");
}

#[test]
fn no_horizon_reaches_over_a_wall_behind_a_landing() {
    let mut points = staircase(0.60, 0.28, &[0.15, 0.30]);
    points.extend([(1.85, 0.30, 34.0), (1.85, 0.40, 40.0)]);
    let answer = answer(&points);
    let end_m = answer.horizon_m().unwrap();
    let valid = answer.answer.steps.iter().filter(|s| s.distance_m < end_m);
    assert_eq!(valid.count(), 2, "{answer:?}");
    assert!(end_m < 1.85, "{answer:?}");
}

#[test]
fn a_flight_that_fades_into_the_noise_may_go_on() {
    let config = over_an_edge();
    let weak = |bright: f64| {
        let ground = (-0.11, 0.0, 24.0);
        let points = [ground, (0.0, -0.16, 24.0), (0.15, -0.16, bright)];
        let outcome = estimate(&scene(&config, &points), &config, false);
        assert_eq!(outcome.answer.steps.len(), 1, "{outcome:?}");
        outcome.reasons().has(Reason::WeakEchoes)
    };
    assert_eq!((weak(25.0), weak(9.0)), (false, true));
}

#[test]
fn a_height_that_no_echo_of_its_own_shows_is_inferred() {
    let config = Config::default();
    let mut points = staircase(0.70, 0.29, &[0.16, 0.32]);
    let two = estimate(&scene(&config, &points), &config, false);
    assert!(!two.reasons().has(Reason::InferredStep), "{two:?}");
    // The third riser has no echo but its flash.
    points.push((1.28, 0.40, 42.0));
    let three = estimate(&scene(&config, &points), &config, false);
    assert_eq!(three.answer.steps.len(), 3, "{three:?}");
    assert!(three.answer.steps[2].height_sigma_m > Params::DEFAULT.sure_height_m);
    assert!(three.reasons().has(Reason::InferredStep), "{three:?}");
}

#[test]
fn echo_on_the_tread_behind_an_edge_is_not_taken_for_the_edge() {
    let config = Config::default();
    let heights = [0.16, 0.31];
    let mut points = staircase(0.70, 0.29, &heights);
    points.push((1.03, 0.345, 24.0));
    let outcome = estimate(&scene(&config, &points), &config, false);
    assert_eq!(outcome.answer.steps.len(), 2, "{outcome:?}");
    assert!(
        (outcome.answer.steps[1].height_m - 0.31).abs()
            < expanded(outcome.answer.steps[1].height_sigma_m),
        "{outcome:?}"
    );
}

#[test]
fn echoes_above_one_another_share_a_column() {
    let echo = |x_m, y_m, snr_db| Echo {
        x_m,
        y_m,
        snr_db,
        range_m: 1.0,
        ..Echo::default()
    };
    let echoes = [
        echo(0.8, 0.0, 30.0),
        // Treads overhang their risers by up to 4 cm.
        echo(0.76, 0.17, 20.0),
        echo(1.1, 0.17, 25.0),
        echo(0.2, 0.1, 40.0),
    ];
    let mut scene = Scene::new(0.4, &Params::DEFAULT);
    scene.risers(&echoes);
    let along: Vec<f32> = scene.columns.iter().map(|c| c.along_m).collect();
    assert_eq!(along, [0.8, 1.1]);
}

/// Returns a scan of random blocks of 9 rows by 3 bins, each of one power between `low` and `low + span`, eighths of an
/// octave above a tenth of the noise, and of one phase, but for small noise: it has echoes of all sizes.
fn blocks(config: &Config, seed: u64, low: u8, span: u64) -> Seen {
    let power = |row: usize, bin: usize| {
        let block = (noise(row / 9, bin / 3, seed) * span as f64) as u64 % span;
        let units = low as f64 + block as f64 + noise(row, bin, seed) * 4.0;
        0.1 * (units / 8.0).exp2()
    };
    Seen::new(config, power, |row, bin| {
        let (sin, cos) = (noise(row / 9, bin / 3, seed + 1) * 9.0).sin_cos();
        // Within the mantissas.
        let size = power(row, bin).sqrt().min(2_800.0);
        [size * cos, size * sin]
    })
}

/// A sector of 23 rows gives two samples of the noise level, and the first one may be far from the median of both;
/// still the order of the rows must not change the answer.
#[test]
fn a_narrow_sector_gives_the_same_both_ways() {
    let mut config = Config::default();
    config.sweep.angle_count = 23;
    let map = blocks(&config, 1_280_115_877_751_946_492, 0, 37);
    config.seed = 2_640_853_756;
    assert_eq!(
        estimate(&map, &config, false),
        estimate(&map, &config, true)
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn any_map_gives_finite_steps_and_the_same_both_ways(
        seed in any::<u64>(),
        low in 0u8..200,
        span in 1u64..120,
        height in prop::bool::ANY,
        rows in 3u16..288,
    ) {
        let mut config = Config::default();
        config.sweep.angle_count = rows.min(281);
        config.seed = seed as u32;
        if height {
            config.mount.plane = crate::config::Planes::Height;
        }
        let map = blocks(&config, seed, low, span);
        let outcome = estimate(&map, &config, false);
        prop_assert_eq!(&outcome, &estimate(&map, &config, true));
        if outcome.status() == Status::Fault {
            prop_assert!(outcome.answer.steps.is_empty());
        }
        for s in &outcome.answer.steps {
            for v in [s.distance_m, s.height_m, s.distance_sigma_m, s.height_sigma_m] {
                prop_assert!(v.is_finite());
            }
            prop_assert!(s.distance_sigma_m > 0.0 && s.height_sigma_m > 0.0);
        }
    }
}

#[test]
fn an_answer_is_not_valid_beyond_a_kerb_that_shows_only_its_corner() {
    for x in [1.0, 1.2, 1.4] {
        let floor = (0..10).map(|k| (0.4 + 0.1 * k as f32, 0.0, 15.0));
        let mut points: Vec<_> = floor.filter(|p| p.0 < x - 0.05).collect();
        let floor = answer(&points);
        // The floor's echoes end there: things may stand behind that place, and none before it.
        let behind = |m: &PossibleStep| m.distance_m > x - 0.2;
        assert!(floor.answer.steps.is_empty());
        assert!(floor.answer.possible_steps.iter().all(behind), "{floor:?}");
        points.push((x, 0.0, 36.0));
        let kerb = answer(&points);
        // A step of unknown height may be reported where the corner is.
        let there = |step: &Step| (step.distance_m - x).abs() < 0.03;
        assert!(kerb.answer.steps.iter().all(there), "{kerb:?}");
        assert!(kerb.horizon_m().is_some_and(|end| end < x), "{kerb:?}");
        let reported = |m: &PossibleStep| (m.distance_m - x).abs() < 0.03;
        let mut maybes = kerb.answer.possible_steps.iter();
        assert!(maybes.all(|m| reported(m) || behind(m)), "{kerb:?}");
    }
}
