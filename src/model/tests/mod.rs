//! Hypotheses, simulated echoes of a staircase by the model, and random numbers for tests.

mod points;
mod staircase;

use super::feature::{Class, FeaturePlace};
use super::kinds::GroundKind;
use super::points::Model;
use super::staircase::{ReportedStep, Staircase, View};
use crate::answer::Step;
use crate::config::Config;
use crate::params::{Numbers, measured};
use crate::signal::echoes::Echo;
use crate::signal::grid::{Geometry, PolarMap};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoroshiro64Star;
use std::boxed::Box;
use std::vec::Vec;

/// Field of view from 40 cm above the ground: 2.9 m far, from 70° below the horizontal to 20° above it.
pub(crate) const VIEW: View = View {
    plane: crate::config::Plane::Depth,
    height_m: 0.4,
    lowest: -2.75,
    highest: 0.36,
    farthest_m: 2.9,
};

/// Returns a staircase with these risers (x, top), metres.
pub(crate) fn flight(risers: &[(f32, f32)]) -> Staircase {
    let start = Staircase::nothing();
    let all = risers.iter().enumerate();
    all.fold(start, |s, (k, &(x_m, top_m))| s.with(k, x_m, top_m))
}

/// Returns a staircase of `n` equal risers: distance of the first one, going and riser height in metres.
pub(crate) fn regular(n: usize, first_m: f32, going_m: f32, rise_m: f32) -> Staircase {
    let riser = |k: usize| (first_m + going_m * k as f32, rise_m * (k + 1) as f32);
    flight(&(0..n).map(riser).collect::<Vec<_>>())
}

/// Returns the steps of an answer without any uncertainty, from distances and heights, metres.
pub(crate) fn reported(steps: &[(f32, f32)]) -> Vec<ReportedStep> {
    let step = |&(distance_m, height_m)| {
        ReportedStep::of(&Step {
            distance_m,
            height_m,
            ..Step::default()
        })
    };
    steps.iter().map(step).collect()
}

/// Returns the geometry of the default scan.
pub(crate) fn geometry() -> Geometry {
    let mut map = Box::new(PolarMap::new());
    map.begin(&Config::default()).unwrap();
    *map.geometry()
}

/// Returns the measurement model with these echoes, as of a default scan.
pub(crate) fn model<'a>(echoes: &[Echo], geometry: &Geometry) -> Model<'a> {
    Model::new(echoes, VIEW, geometry, &measured::MODEL, Numbers::DEFAULT)
}

/// Returns an undisturbed echo at a distance and height, metres.
pub(crate) fn echo(x_m: f32, y_m: f32, snr_db: f32) -> Echo {
    let down = VIEW.height_m - y_m;
    Echo {
        snr_db,
        range_m: x_m.hypot(down),
        angle_rad: down.atan2(x_m),
        x_m,
        y_m,
        width: 1.0,
        angle_sigma_rad: 0.001,
        range_sigma_m: 0.0005,
        native_bin: 0.0,
        phasor: [1.0, 0.0],
    }
}

/// Seeded random number generator for tests.
pub(crate) struct Dice(Xoroshiro64Star);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Xoroshiro64Star::seed_from_u64(seed))
    }

    /// Returns an evenly distributed number between `low` and `high`.
    pub(crate) fn even(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.0.next_u32() as f32 / u32::MAX as f32)
    }

    /// Returns a normally distributed number of standard deviation `sigma`: the sum of twelve evenly distributed ones.
    pub(crate) fn normal(&mut self, sigma: f32) -> f32 {
        let sum: f32 = (0..12).map(|_| self.even(-0.5, 0.5)).sum();
        sigma * sum
    }
}

/// Returns a point feature's echo at its expected place, plus the measurement model's own noise times `noise`.
fn shows(place: &FeaturePlace, snr_db: f32, dice: &mut Dice, noise: f32) -> Echo {
    let p = &measured::MODEL.points[place.class as usize];
    let (x, y) = (place.x_m, place.y_m - VIEW.height_m);
    let across_sigma = p.across_sigma_m.hypot(place.range_m * 0.0021);
    let across = p.across_m + dice.normal(noise * across_sigma);
    let range = place.range_m + p.range_m + dice.normal(noise * p.range_sigma_m);
    let along = range / place.range_m;
    let turn = across / place.range_m;
    echo(
        x * along - y * turn,
        VIEW.height_m + y * along + x * turn,
        snr_db,
    )
}

/// Returns the echoes of every point feature of `s`, and of the floor before it, with the measurement model's own noise
/// times `noise`.
pub(crate) fn echoes(s: &Staircase, dice: &mut Dice, noise: f32) -> Vec<Echo> {
    let blank = model(&[], &geometry());
    let mut echoes = Vec::new();
    for k in 0..s.len() {
        for place in blank.places(s, k) {
            let snr_db = match place.class {
                Class::Corner => 36.0,
                Class::Flash => 38.0,
                Class::Hidden => 20.0,
                _ => 24.0,
            };
            echoes.push(shows(&place, snr_db, dice, noise));
        }
    }
    let mut x_m = 0.4;
    while x_m < s.x(0).min(1.2) - 0.1 {
        echoes.push(echo(x_m, dice.normal(0.003), 12.0));
        x_m += 0.1;
    }
    echoes
}
