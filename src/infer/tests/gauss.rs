//! The Gaussian mixture over a flight's levels.

use crate::estimate::Estimate;
use crate::infer::gauss::{self, Fusion, TreadLevels};
use crate::params::Params;

/// Returns the heights of a flight's treads fitted to the measured ones, `steps`, and to `rise`, the other knowledge of
/// its riser height.
fn fit(steps: &[Fusion], rise: Estimate) -> TreadLevels {
    let mut levels = TreadLevels::default();
    gauss::fit(steps.iter().copied(), rise, &Params::DEFAULT, &mut levels);
    levels
}

/// Returns a step with two readings of the height `value` of its tread, metres, each with a standard deviation of 4 mm.
fn step(value: f32) -> Fusion {
    let mut fusion = Fusion::default();
    for _ in 0..2 {
        fusion.add(Estimate::new(value, 0.004));
    }
    fusion
}

#[test]
fn irregular_step_keeps_its_measured_height() {
    let rise = Estimate::new(0.16, 0.01);
    let levels = fit(&[step(0.16), step(0.35), step(0.48)], rise);
    let second = levels[1];
    assert!((second.height.value - 0.35).abs() < 0.004, "{second:?}");
    assert!(second.height.sigma() < 0.015 && second.off.value > 0.02);
    // It does not change the other levels.
    assert!((levels[0].height.value - 0.16).abs() < 0.004);
    assert!((levels[2].height.value - 0.48).abs() < 0.004);
}

#[test]
fn step_without_readings_has_the_regular_height_and_a_larger_sigma() {
    let levels = fit(
        &[step(0.15), Fusion::default(), step(0.45)],
        Fusion::default().mean(),
    );
    let unseen = levels[1];
    assert!((unseen.height.value - 0.30).abs() < 1e-4);
    assert!(unseen.height.sigma() >= 0.005 && unseen.height.sigma() > levels[0].height.sigma());
}

#[test]
fn sigma_without_echoes_includes_the_building_tolerance() {
    let rise = Estimate::new(0.17, 0.01);
    let levels = fit(&[step(0.17), step(0.34), Fusion::default()], rise);
    let [first, _, last, ..] = levels;
    assert!((last.height.value - 0.51).abs() < 0.004);
    assert!(
        first.height.sigma() < 0.005 && last.height.sigma() > 0.010,
        "{levels:?}"
    );
}
