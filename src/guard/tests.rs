//! Guard sweeps over polar maps of hand-made scenes.

use super::*;
use crate::config::Config;
use crate::drive::{Drive, Input};
use crate::signal::echoes::tests::{map, noise as drawn, scene};
use crate::verdict::HazardKind;
use std::boxed::Box;
use std::vec::Vec;

/// Returns the configuration of the default sweep: 31 rows from 8° to 38° below the horizontal.
fn config() -> Config {
    let mut config = Config::default();
    config.sweep.first_angle = 8_000;
    config.sweep.angle_step = 1_000;
    config.sweep.angle_count = 31;
    config
}

/// Returns points (distance, height, dB over the noise) of level ground up to `end_m`, metres: 15 dB over the noise at
/// 0.5 m, 2 dB weaker every 10 cm.
fn ground(end_m: f32) -> Vec<(f32, f32, f64)> {
    let places = (0..240).map(|k| 0.25 + 0.01 * k as f32);
    let shown = places.take_while(|x| *x < end_m);
    shown
        .map(|x| (x, 0.0, 15.0 - 20.0 * (f64::from(x) - 0.5)))
        .collect()
}

fn seen(points: &[(f32, f32, f64)]) -> Box<PolarMap> {
    scene(&config(), points)
}

/// Returns good motion input with `by_m` metres of travel since the last sweep.
fn moved(by_m: f32) -> Drive<'static> {
    Drive {
        mode: Mode::Auto,
        input: Input::Good,
        moved_m: Some(by_m),
        ..Drive::STANDING
    }
}

/// Returns the result of the last of several sweeps over one map from a standing chair.
fn after(sweeps: usize, map: &PolarMap) -> FreeGround {
    let mut guard = Box::new(Guard::new());
    let mut free = None;
    for _ in 0..sweeps {
        free = Some(guard.sweep(map, &config(), &Drive::STANDING));
    }
    free.unwrap()
}

#[test]
fn the_noise_is_found_though_most_rows_see_ground() {
    let level = noise::level(&seen(&ground(2.5)));
    // Noise of the hand-made maps, map units.
    assert!((level - 80.0).abs() < 2.0, "{level}");
}

#[test]
fn level_ground_is_free_as_far_as_it_shows_from_the_first_sweep_on() {
    let map = seen(&ground(2.5));
    for sweeps in [1, 3] {
        let free = after(sweeps, &map);
        assert!(
            free.free_m > 0.9 && matches!(free.hazard, HazardKind::None | HazardKind::Unknown),
            "{sweeps}: {free:?}"
        );
        assert!(free.confidence >= 0.998, "{free:?}");
    }
}

#[test]
fn ground_that_ends_ends_what_is_free() {
    for end_m in [0.8, 1.0] {
        let free = after(3, &seen(&ground(end_m)));
        assert!(
            free.free_m < end_m + 0.05 && free.free_m > end_m - 0.35,
            "{end_m}: {free:?}"
        );
    }
}

/// The lower ground is 6 cm deep. At 1 m its line of sight is 1.9 standard deviations of the two-way beam from the
/// ground's own, so that the beam's flank still reaches it.
#[test]
fn ground_that_goes_on_a_kerb_lower_ends_what_is_free() {
    for end_m in [0.8, 1.0] {
        let mut points = ground(end_m);
        // The edge hides the lower ground just behind it.
        let hidden_m = end_m * (0.4 + 0.06) / 0.4;
        let lower = ground(2.5).into_iter().filter(|(x, ..)| *x > hidden_m);
        points.extend(lower.map(|(x, _, db)| (x, -0.06, db)));
        let free = after(3, &seen(&points));
        assert!(free.free_m < end_m + 0.05, "{end_m}: {free:?}");
        assert!(free.hazard == HazardKind::Drop, "{end_m}: {free:?}");
    }
}

#[test]
fn a_thing_beside_ground_that_goes_on_ends_it() {
    let mut points = ground(2.5);
    // A leg: 30 cm of it from the ground on, in three range cells.
    points.extend((0..30).map(|k| (0.9 + 0.001 * k as f32, 0.01 * k as f32, 28.0)));
    let free = after(2, &seen(&points));
    assert!(free.free_m < 0.95 && free.free_m > 0.4, "{free:?}");
}

#[test]
fn who_steps_in_is_reported_within_two_sweeps() {
    let level = seen(&ground(2.5));
    let mut points = ground(2.5);
    points.extend((0..30).map(|k| (0.9 + 0.001 * k as f32, 0.01 * k as f32, 28.0)));
    let leg = seen(&points);
    let mut guard = Box::new(Guard::new());
    for _ in 0..5 {
        assert!(guard.sweep(&level, &config(), &Drive::STANDING).free_m > 0.9);
    }
    guard.sweep(&leg, &config(), &Drive::STANDING);
    let second = guard.sweep(&leg, &config(), &Drive::STANDING);
    assert!(second.free_m < 0.95, "{second:?}");
}

#[test]
fn two_sweeps_must_agree_before_it_grows() {
    let (near, far) = (seen(&ground(0.8)), seen(&ground(2.5)));
    let mut guard = Box::new(Guard::new());
    guard.sweep(&near, &config(), &Drive::STANDING);
    let first = guard.sweep(&far, &config(), &Drive::STANDING);
    assert!(first.free_m < 0.8, "{first:?}");
}

#[test]
fn what_was_seen_comes_nearer_with_the_chair() {
    let map = seen(&ground(2.5));
    let (mut stood, mut drove) = (Box::new(Guard::new()), Box::new(Guard::new()));
    for _ in 0..3 {
        stood.sweep(&map, &config(), &moved(0.0));
        drove.sweep(&map, &config(), &moved(0.0));
    }
    let stood = stood.sweep(&map, &config(), &moved(0.0));
    let drove = drove.sweep(&map, &config(), &moved(0.1));
    assert!(drove.free_m < stood.free_m - 0.05, "{stood:?} {drove:?}");
}

#[test]
fn without_any_echo_nothing_is_free() {
    let dark = map(&config(), |row, bin| {
        (80.0 + 8.0 * drawn(row, bin, 3).log2())
            .round()
            .clamp(0.0, 255.0) as u8
    });
    let free = after(5, &dark);
    assert!(free.free_m < 0.4, "{free:?}");
}

#[test]
fn maps_of_one_level_do_no_harm() {
    for level in [0, 1, 128, 255] {
        let free = after(2, &map(&config(), |_, _| level));
        assert!(
            free.free_m.is_finite() && free.free_m < 0.6,
            "{level}: {free:?}"
        );
        assert!((0.0..=1.0).contains(&free.confidence));
    }
}

#[test]
fn a_guard_that_forgot_is_a_new_one() {
    let map = seen(&ground(1.0));
    let mut guard = Box::new(Guard::new());
    let first = guard.sweep(&map, &config(), &Drive::STANDING);
    guard.sweep(&map, &config(), &Drive::STANDING);
    guard.forget();
    assert_eq!(guard.sweep(&map, &config(), &Drive::STANDING), first);
}
