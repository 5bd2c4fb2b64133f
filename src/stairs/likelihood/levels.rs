//! The levels of a flight's treads: each step's own echoes weighed against the regularity of the
//! whole.

use super::search::MAX_FLIGHT;
use crate::math;

/// A step's own departure from the straight flight, metres. Building codes allow 5 mm between
/// neighbours; what the echoes know better than that, they decide.
const TAU: f32 = 0.005;

/// Beyond so many standard deviations a step is not like the others.
const SURPRISE: f32 = 2.6;
/// Share of its departure that an irregular step's σ covers at least.
const LIES: f32 = 0.25;
/// Rounds in which departures are granted.
const ROUNDS: usize = 3;

/// A measured value and its standard deviation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// The value.
    pub value: f32,
    /// Its standard deviation.
    pub sigma: f32,
}

/// Weighted mean of readings.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fusion {
    weight: f32,
    sum: f32,
    readings: u8,
}

impl Fusion {
    /// Takes a reading in.
    pub fn add(&mut self, reading: Reading) {
        let w = 1.0 / (reading.sigma * reading.sigma);
        self.weight += w;
        self.sum += w * reading.value;
        self.readings = self.readings.saturating_add(1);
    }

    /// Whether there is any.
    pub fn is_empty(&self) -> bool {
        self.weight <= 0.0
    }

    /// The weighted mean; 0 without any.
    pub fn mean(&self) -> f32 {
        if self.is_empty() {
            0.0
        } else {
            self.sum / self.weight
        }
    }

    /// Variance of the mean.
    fn variance(&self) -> f32 {
        1.0 / self.weight.max(1e-9)
    }

    /// Weight of the mean against a straight flight from which the step departs by `tau`.
    fn against_line(&self, tau: f32) -> f32 {
        if self.is_empty() {
            0.0
        } else {
            1.0 / (1.0 / self.weight + tau * tau)
        }
    }
}

/// The level of one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    /// Height over the ground; negative going down.
    pub height: f32,
    /// Its standard deviation.
    pub sigma: f32,
    /// How far the step's own readings put it off the straight flight.
    pub off: f32,
    /// Standard deviation of those readings.
    pub off_sigma: f32,
}

/// The levels of a flight.
#[derive(Clone, Copy, Debug, Default)]
pub struct Levels {
    /// Of each step, the first one first.
    pub places: [Place; MAX_FLIGHT],
    /// Height of one riser of the straight flight.
    rise: f32,
}

/// Fits a straight flight from the ground through the steps' readings, with further readings of
/// its slope, and lets each step depart from it as its own readings say.
///
/// Steps depart by [`TAU`] as a rule. One whose readings lie beyond [`SURPRISE`] standard deviations
/// is irregular, or its readings lie. Where two readings or more agree it is granted the departure
/// that it shows, so that the others neither pull it to their line nor are pulled by it; a single
/// one meets them half-way. Its σ covers both ways.
pub fn fit(steps: &[Fusion], slopes: &[Reading]) -> Levels {
    let mut taus = [TAU; MAX_FLIGHT];
    let mut levels = Levels::default();
    for _ in 0..ROUNDS {
        levels = fit_with(steps, slopes, &taus);
        let lines = (1u8..).map(|i| f32::from(i) * levels.rise);
        for ((tau, step), line) in taus.iter_mut().zip(steps).zip(lines) {
            let off = (step.mean() - line).abs();
            let usual = step.against_line(TAU) * off * off;
            let surprising = !step.is_empty() && usual > SURPRISE * SURPRISE;
            *tau = if surprising { off } else { TAU };
        }
    }
    levels
}

fn fit_with(steps: &[Fusion], slopes: &[Reading], taus: &[f32; MAX_FLIGHT]) -> Levels {
    let (mut sum, mut weight) = (0.0, 0.0);
    for slope in slopes {
        let w = 1.0 / (slope.sigma * slope.sigma);
        sum += w * slope.value;
        weight += w;
    }
    for ((i, step), &tau) in (1u8..).map(f32::from).zip(steps).zip(taus) {
        sum += step.against_line(tau) * i * step.mean();
        weight += step.against_line(tau) * i * i;
    }
    let rise = if weight > 0.0 { sum / weight } else { 0.0 };
    let mut levels = Levels {
        rise,
        ..Levels::default()
    };
    let places = levels.places.iter_mut();
    for (((place, i), step), &tau) in places.zip((1u8..).map(f32::from)).zip(steps).zip(taus) {
        let line = i * rise;
        let irregular = tau > TAU;
        let gain = if irregular && step.readings < 2 {
            0.5
        } else {
            tau * tau * step.against_line(tau)
        };
        let lean = (1.0 - gain) * i;
        let off = if step.is_empty() {
            0.0
        } else {
            step.mean() - line
        };
        // What an irregular step leaves open: the rest of the way, or that its readings lie.
        let open = if irregular {
            off * (1.0 - gain).max(LIES)
        } else {
            0.0
        };
        let own = if irregular {
            gain * step.variance()
        } else {
            (1.0 - gain) * TAU * TAU
        };
        let spread = own + lean * lean / weight.max(1e-9) + open * open;
        *place = Place {
            height: line + gain * off,
            sigma: math::sqrt(spread),
            off,
            off_sigma: if step.is_empty() {
                0.0
            } else {
                math::sqrt(step.variance())
            },
        };
    }
    levels
}

impl Levels {
    /// A straight flight of which nothing but the riser's height is known.
    pub fn straight(rise: f32) -> Self {
        let mut levels = Self {
            rise,
            ..Self::default()
        };
        for (i, place) in (1u8..).zip(&mut levels.places) {
            place.height = f32::from(i) * rise;
        }
        levels
    }

    /// Levels at the foot and at the top of each riser.
    pub fn risers(&self) -> impl Iterator<Item = (f32, f32)> {
        let tops = self.places.iter().map(|p| p.height);
        core::iter::once(0.0).chain(tops.clone()).zip(tops)
    }
}
