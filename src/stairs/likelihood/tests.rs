//! The estimator on maps made by hand: the answers known, the rest merely sane.

use super::beam::{self, BeamFilter};
use super::evidence::Evidence;
use super::levels::{self, Fusion, Reading};
use super::*;
use crate::stairs::Status;
use proptest::prelude::*;

/// Noise of the maps made here, map units.
const NOISE: u8 = 80;

/// A map of `config` whose cells are `cell(row, bin)`.
fn map(config: &Config, cell: impl Fn(usize, usize) -> u8) -> Box<PolarMap> {
    let mut map = Box::new(PolarMap::new());
    map.begin(config).unwrap();
    for k in 0..map.rows() {
        let angle = map.angle_rad(k);
        let row = map.row_mut(k, angle).unwrap();
        for (bin, value) in row.cells.iter_mut().enumerate() {
            *value = cell(k, bin);
        }
    }
    map
}

fn estimate(map: &PolarMap, config: &Config, backwards: bool) -> Outcome {
    let mut estimator = Box::new(Likelihood::new());
    estimator.begin(map);
    for k in 0..map.rows() {
        estimator.row(map, if backwards { map.rows() - 1 - k } else { k });
    }
    estimator.finish(map, config, 1)
}

/// Exponential noise in map units, the same for the same cell.
fn noise(row: usize, bin: usize, seed: u64) -> f64 {
    let mut h = (row as u64 * 1009 + bin as u64 + 1) ^ seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    for _ in 0..3 {
        h ^= h >> 31;
        h = h.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    }
    let uniform = ((h >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    -uniform.ln()
}

/// Point scatterers (x, y, dB above the noise) seen by the beam through noise.
fn scene(config: &Config, points: &[(f32, f32, f64)]) -> Box<PolarMap> {
    let mut blank = Box::new(PolarMap::new());
    blank.begin(config).unwrap();
    let geometry = *blank.geometry();
    let sigma = f64::from(beam::two_way_sigma(geometry.beamwidth_rad));
    let native = f64::from(config.radar.range_resolution_m());
    let places: Vec<(f64, f64, f64)> = points
        .iter()
        .map(|&(x, y, db)| {
            let (range, angle) = geometry.polar(x, y);
            (range.into(), angle.into(), db)
        })
        .collect();
    map(config, |row, bin| {
        let angle = f64::from(blank.angle_rad(row));
        let range = f64::from(geometry.range_m(bin as f32));
        let mut power = noise(row, bin, 7);
        for &(r, a, db) in &places {
            let bins = (range - r) / native;
            let turn = (angle - a) / sigma;
            let response = (-6.0 * bins * bins).max(-45.0);
            power += 10f64.powf((db + response) / 10.0) * (-0.5 * turn * turn).exp();
        }
        (f64::from(NOISE) + 8.0 * power.log2())
            .round()
            .clamp(0.0, 255.0) as u8
    })
}

/// Closed stairs: a corner and a nosing at each riser, floor before the first.
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
fn the_filter_is_two_boxes_whichever_way_the_rows_come() {
    let config = Config::default();
    let map = map(&config, |row, bin| 60 + ((row * 37 + bin * 11) % 90) as u8);
    let last = map.rows() - 1;
    let bins = map.bins();
    let run = |backwards: bool| {
        let place = |k: usize| {
            if backwards {
                last - k.min(last)
            } else {
                k.min(last)
            }
        };
        let mut filter = BeamFilter::new();
        filter.begin(map.geometry());
        let mut rows = Vec::new();
        for k in 0..=last + filter.lag() {
            let mut levels = vec![0; bins];
            filter.feed(
                map.row(place(k)),
                |back| map.row(place(k - back)),
                &mut levels,
            );
            rows.push(levels);
        }
        let mut rows = rows.split_off(filter.lag());
        if backwards {
            rows.reverse();
        }
        (rows, filter.gain())
    };
    let (forward, gain) = run(false);
    assert_eq!(forward, run(true).0);
    // Against the definition in f64, in a few places away from the ends.
    let box_rows = beam::box_rows(map.geometry()) as isize;
    for (row, bin) in [(40, 3), (100, 77), (200, 150), (250, 210)] {
        let mut sum = 0.0;
        for offset in 1 - box_rows..box_rows {
            let cell = map.cell((row as isize + offset) as usize, bin);
            sum += (box_rows - offset.abs()) as f64 * (f64::from(cell) / 8.0).exp2();
        }
        let level = f64::from(forward[row][bin]) - f64::from(gain);
        let expected = 128.0 * (sum / (box_rows * box_rows) as f64).log2();
        assert!((level - expected).abs() < 3.0, "{level} for {expected}");
    }
}

#[test]
fn a_patch_is_the_filter_worked_out_again() {
    let config = Config::default();
    let map = map(&config, |row, bin| 70 + ((row * 53 + bin * 29) % 100) as u8);
    let mut filter = BeamFilter::new();
    filter.begin(map.geometry());
    let mut rows = Vec::new();
    for k in 0..map.rows() {
        let mut levels = vec![0; map.bins()];
        filter.feed(map.row(k), |back| map.row(k - back), &mut levels);
        rows.push(levels);
    }
    let patch = beam::patch(&map, 120, 50);
    for (levels, bin) in patch.iter().zip(49usize..) {
        for (level, row) in levels.iter().zip([117usize, 118, 120, 122, 123]) {
            assert_eq!(*level, rows[row + filter.lag()][bin]);
        }
    }
}

#[test]
fn stairs_are_found_where_they_are() {
    let config = Config::default();
    let heights = [0.16, 0.32, 0.48];
    let map = scene(&config, &staircase(0.70, 0.29, &heights));
    let outcome = estimate(&map, &config, false);
    assert_eq!(outcome.direction, crate::stairs::Direction::Up);
    assert_eq!(outcome.steps.len(), 3, "{outcome:?}");
    for (k, (step, height)) in outcome.steps.iter().zip(heights).enumerate() {
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
    assert!(outcome.steps.is_empty(), "{outcome:?}");
    assert_ne!(outcome.status, Status::Fault);
}

#[test]
fn rows_that_cfar_lets_through_are_counted_beside_a_bin_too() {
    let config = Config::default();
    let mut map = map(&config, |_, _| 0);
    for (row, bin) in [(10, 31), (11, 32), (12, 33), (13, 34), (20, 0), (21, 1)] {
        let angle = map.angle_rad(row);
        map.row_mut(row, angle).unwrap().mask[bin / 32] |= 1 << (bin % 32);
    }
    assert_eq!(map.rows_hit(5..15, 32), 3);
    assert_eq!(map.rows_hit(11..15, 32), 2);
    assert_eq!(map.rows_hit(0..40, 0), 2);
    assert_eq!(map.rows_hit(0..40, 2), 1);
    assert_eq!(map.rows_hit(0..400, 250), 0);
}

#[test]
fn an_echo_that_cfar_lets_through_is_no_oscillator_noise() {
    let config = Config::default();
    // A corner, and 41 dB below it in the same direction something farther off.
    let (x, y) = (0.8, 0.0);
    let far = |r: f32| (r * x, 0.4 - r * 0.4);
    let (fx, fy) = far(1.8);
    let seen = |hit: bool| {
        let mut map = scene(&config, &[(x, y, 56.0), (fx, fy, 15.0)]);
        let (range, angle) = map.geometry().polar(fx, fy);
        let bin = ((range - map.geometry().range_m(0.0)) / map.geometry().bin_m) as usize;
        let row = (0..map.rows()).find(|&k| map.angle_rad(k) > angle).unwrap();
        for k in row - 2..=row + 2 {
            let angle = map.angle_rad(k);
            let mask = map.row_mut(k, angle).unwrap().mask;
            mask[bin / 32] |= u32::from(hit) << (bin % 32);
        }
        let mut rows = Rows::new();
        rows.begin(&map);
        for k in 0..map.rows() {
            rows.row(&map, k);
        }
        let echoes = rows.echoes(&map, &config, 1, &mut ());
        echoes
            .iter()
            .any(|e| (e.x - fx).abs() < 0.02 && (e.y - fy).abs() < 0.02)
    };
    assert!(seen(true) && !seen(false));
}

#[test]
fn noise_alone_is_a_fault() {
    let config = Config::default();
    let outcome = estimate(&scene(&config, &[]), &config, false);
    assert_eq!(outcome, Outcome::fault(Reason::NoEcho));
}

/// The mirror 1.1 m up, sweeping the height plane.
fn over_an_edge() -> Config {
    Config {
        mount: crate::config::MountConfig {
            mount_height: 110_000,
            plane: Plane::Height,
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
    assert_eq!(
        outcome.direction,
        crate::stairs::Direction::Down,
        "{outcome:?}"
    );
    let levels: Vec<f32> = outcome.steps.iter().map(|s| s.height_m).collect();
    assert_eq!(levels.len(), 2, "{outcome:?}");
    assert!((levels[0] + 0.16).abs() < 0.01 && (levels[1] + 0.32).abs() < 0.01);
}

#[test]
fn a_corner_without_anything_above_is_no_clear_way() {
    let config = Config::default();
    for x in [1.0, 1.1, 1.2] {
        let map = scene(&config, &[(x, 0.0, 42.0)]);
        let outcome = estimate(&map, &config, false);
        assert_eq!(outcome.status, Status::Degraded, "{outcome:?}");
    }
}

#[test]
fn a_flight_that_fades_into_the_noise_may_go_on() {
    let config = over_an_edge();
    let status = |bright: f64| {
        let ground = (-0.11, 0.0, 24.0);
        let points = [ground, (0.0, -0.16, 24.0), (0.15, -0.16, bright)];
        let outcome = estimate(&scene(&config, &points), &config, false);
        assert_eq!(outcome.steps.len(), 1, "{outcome:?}");
        outcome.status
    };
    assert_eq!((status(25.0), status(9.0)), (Status::Ok, Status::Degraded));
}

#[test]
fn regularity_stands_in_for_one_edge_hidden_by_its_flash_and_no_more() {
    let config = Config::default();
    let mut points = staircase(0.70, 0.29, &[0.16, 0.32]);
    // The third riser shows nothing but its flash; the fourth stands above the mirror.
    points.push((1.28, 0.40, 42.0));
    let three = estimate(&scene(&config, &points), &config, false);
    assert_eq!(three.steps.len(), 3, "{three:?}");
    assert_eq!(three.status, Status::Ok, "{three:?}");
    points.push((1.57, 0.56, 24.0));
    let four = estimate(&scene(&config, &points), &config, false);
    assert_eq!(four.steps.len(), 4, "{four:?}");
    assert!(four.reasons.has(Reason::InferredStep), "{four:?}");
    assert!(four.steps[3].height_sigma_m > 0.015);
}

#[test]
fn regularity_stands_in_for_nothing_where_a_step_may_be_odd() {
    let status = |off: f32| {
        let mut outcome = Outcome::clear();
        let mut supports = Vec::new();
        for height_sigma_m in [0.004, 0.012, 0.022] {
            let step = crate::stairs::Step {
                height_sigma_m,
                ..Default::default()
            };
            outcome.steps.push(step).unwrap();
            supports.push(doubt::Support {
                db: Some(40.0),
                next_db: 15.0,
                flashes: true,
                off,
                ..Default::default()
            });
        }
        doubt::judge(&mut outcome, 9.0, &supports, 0);
        outcome.status
    };
    assert_eq!((status(0.0), status(0.004)), (Status::Ok, Status::Degraded));
}

#[test]
fn what_lies_on_the_tread_behind_an_edge_is_not_the_edge() {
    let config = Config::default();
    let heights = [0.16, 0.31];
    let mut points = staircase(0.70, 0.29, &heights);
    points.push((1.03, 0.345, 24.0));
    let outcome = estimate(&scene(&config, &points), &config, false);
    assert_eq!(outcome.steps.len(), 2, "{outcome:?}");
    assert!(
        (outcome.steps[1].height_m - 0.31).abs() < 0.01,
        "{outcome:?}"
    );
}

/// A step of two agreeing readings.
fn step(value: f32) -> Fusion {
    let mut fusion = Fusion::default();
    for _ in 0..2 {
        fusion.add(Reading {
            value,
            sigma: 0.004,
        });
    }
    fusion
}

#[test]
fn an_irregular_step_is_reported_as_it_is() {
    let slope = [Reading {
        value: 0.16,
        sigma: 0.01,
    }];
    let levels = levels::fit(&[step(0.16), step(0.35), step(0.48)], &slope);
    let second = levels.places[1];
    assert!((second.height - 0.35).abs() < 0.004, "{second:?}");
    assert!(second.sigma < 0.015 && second.off > 0.02);
    // And it does not drag the others along.
    assert!((levels.places[0].height - 0.16).abs() < 0.004);
    assert!((levels.places[2].height - 0.48).abs() < 0.004);
}

#[test]
fn a_step_without_readings_lies_on_the_line_and_says_so() {
    let levels = levels::fit(&[step(0.15), Fusion::default(), step(0.45)], &[]);
    let unseen = levels.places[1];
    assert!((unseen.height - 0.30).abs() < 1e-4);
    assert!(unseen.sigma >= 0.005 && unseen.sigma > levels.places[0].sigma);
}

#[test]
fn what_no_echo_measures_is_known_no_better_than_builders_can_be_trusted() {
    let slope = [Reading {
        value: 0.17,
        sigma: 0.01,
    }];
    let levels = levels::fit(&[step(0.17), step(0.34), Fusion::default()], &slope);
    let [first, _, last, ..] = levels.places;
    assert!((last.height - 0.51).abs() < 0.004);
    assert!(first.sigma < 0.005 && last.sigma > 0.010, "{levels:?}");
}

#[test]
fn readings_that_contradict_each_other_leave_the_level_open() {
    let both = |other: f32| {
        let mut fusion = Fusion::default();
        for (value, sigma) in [(0.16, 0.004), (other, 0.008)] {
            fusion.add(Reading { value, sigma });
        }
        let rise = Reading {
            value: 0.16,
            sigma: 0.01,
        };
        levels::fit(&[fusion, step(0.32), step(0.48)], &[rise]).places[0].sigma
    };
    assert!(both(0.20) > 1.2 * both(0.163));
}

#[test]
fn echoes_above_one_another_share_a_column() {
    let echo = |x, y, db| Echo {
        x,
        y,
        db,
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
    let mut evidence = Evidence::new(0.4);
    evidence.risers(&echoes);
    let along: Vec<f32> = evidence.columns.iter().map(|c| c.along).collect();
    assert_eq!(along, [0.8, 1.1]);
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
            config.mount.plane = Plane::Height;
        }
        // Blocks of cells of one value make echoes of all sizes.
        let map = map(&config, |row, bin| {
            let block = (noise(row / 9, bin / 3, seed) * span as f64) as u64 % span;
            (u64::from(low) + block + (noise(row, bin, seed) * 4.0) as u64).min(255) as u8
        });
        let outcome = estimate(&map, &config, false);
        prop_assert_eq!(&outcome, &estimate(&map, &config, true));
        if outcome.status == Status::Fault {
            prop_assert!(outcome.steps.is_empty());
        }
        for s in &outcome.steps {
            for v in [s.distance_m, s.height_m, s.distance_sigma_m, s.height_sigma_m] {
                prop_assert!(v.is_finite());
            }
            prop_assert!(s.distance_sigma_m > 0.0 && s.height_sigma_m > 0.0);
        }
    }
}
