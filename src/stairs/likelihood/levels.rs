//! The levels of a flight's treads: each step's own echoes weighed against the regularity of the
//! whole.

use super::search::MAX_FLIGHT;
use crate::math;

/// A step's own departure from the straight flight, metres. Building codes allow 5 mm between
/// neighbours; what the echoes know better than that, they decide.
const TAU: f32 = 0.005;
/// Standard deviation by which an irregular riser or tread departs, metres: what people stumble
/// over and yet gets built.
const ODD: f32 = 0.03;
/// Likelihood ratios beyond e to this are certainty.
const CERTAIN: f32 = 40.0;

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
    squares: f32,
    readings: u8,
}

impl Fusion {
    /// Takes a reading in.
    pub fn add(&mut self, reading: Reading) {
        let w = 1.0 / (reading.sigma * reading.sigma);
        self.weight += w;
        self.sum += w * reading.value;
        self.squares += w * reading.value * reading.value;
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

    /// Variance of the mean: where the readings disagree by more than they should, their standard
    /// deviations are too small, all by the same factor (Birge 1932).
    fn variance(&self) -> f32 {
        let weight = self.weight.max(1e-9);
        let spread = self.squares - self.sum * self.sum / weight;
        let excess = spread / f32::from(self.readings.max(2) - 1);
        excess.max(1.0) / weight
    }

    /// Weight of the mean against a straight flight from which the step departs by [`TAU`].
    fn against_line(&self) -> f32 {
        if self.is_empty() {
            0.0
        } else {
            1.0 / (self.variance() + TAU * TAU)
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
    /// How far the readings put its riser or its tread off those of the others.
    pub off: f32,
    /// Standard deviation of that.
    pub off_sigma: f32,
}

/// The levels of a flight.
#[derive(Clone, Copy, Debug, Default)]
pub struct Levels {
    /// Of each step, the first one first.
    pub places: [Place; MAX_FLIGHT],
}

/// Weighted sums over steps: of 1, of the step's number, of its level.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    one: f32,
    number: f32,
    level: f32,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.one += other.one;
        self.number += other.number;
        self.level += other.level;
    }
}

/// What a step's level is over all possibilities, each times its likelihood: first and second
/// moment of its departure from the regular flight; the share of it that is odd.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    mean: f32,
    square: f32,
    odd: f32,
    odd_sigma: f32,
}

/// A straight flight but for one departure `odd`: riser height and departure, their covariance.
#[derive(Clone, Copy, Debug)]
struct Straight {
    rise: f32,
    odd: f32,
    rise_variance: f32,
    odd_variance: f32,
    covariance: f32,
}

impl Straight {
    /// Level of step `number` and its variance; `departs` if the departure reaches it.
    fn at(&self, number: f32, departs: bool) -> (f32, f32) {
        let line = (number * self.rise, number * number * self.rise_variance);
        if departs {
            let variance = line.1 + 2.0 * number * self.covariance + self.odd_variance;
            (line.0 + self.odd, variance)
        } else {
            line
        }
    }

    /// How much likelier the departure makes the readings than none, all departures considered.
    fn likelihood(&self) -> f32 {
        let exponent = 0.5 * self.odd * self.odd / self.odd_variance;
        math::sqrt(self.odd_variance) / ODD * math::exp(exponent.min(CERTAIN))
    }
}

/// Fits a straight flight from the ground through the steps' readings, with further readings of
/// its slope, and lets each step depart from it as its own readings say.
///
/// Steps depart by [`TAU`] as a rule. Besides, any one riser may be odd, so that it shifts all that
/// follows, or any one tread: as likely as not, each as likely as any other. The answer is the mean
/// over these possibilities, weighed by how well they explain the readings, and σ their spread: a
/// step that nothing measures is known no better than builders can be trusted.
pub fn fit(steps: &[Fusion], slopes: &[Reading]) -> Levels {
    let (mut whole, mut squares) = (Sums::default(), 0.0);
    for slope in slopes {
        let w = 1.0 / (slope.sigma * slope.sigma);
        whole.level += w * slope.value;
        squares += w;
    }
    for (number, step) in (1u8..).map(f32::from).zip(steps) {
        let w = step.against_line();
        whole.level += w * number * step.mean();
        squares += w * number * number;
    }
    let squares = squares.max(1e-9);
    let solve = |sums: &Sums| {
        let own = sums.one + 1.0 / (ODD * ODD);
        let det = squares * own - sums.number * sums.number;
        Straight {
            rise: (whole.level * own - sums.number * sums.level) / det,
            odd: (squares * sums.level - sums.number * whole.level) / det,
            rise_variance: own / det,
            odd_variance: squares / det,
            covariance: -sums.number / det,
        }
    };
    let regular = solve(&Sums::default());
    let mut levels = Levels::default();
    let mut moments = [Moments::default(); MAX_FLIGHT];
    let mut total = 0.0;
    let mut weigh = |flight: &Straight, departs: core::ops::Range<usize>, p: f32| {
        total += p;
        for ((k, step), moments) in steps.iter().enumerate().zip(&mut moments) {
            let number = (k + 1) as f32;
            let (line, variance) = flight.at(number, departs.contains(&k));
            let gain = TAU * TAU * step.against_line();
            let left = 1.0 - gain;
            let off = left * line + gain * step.mean() - number * regular.rise;
            moments.mean += p * off;
            moments.square += p * (off * off + left * TAU * TAU + left * left * variance);
            if departs.start == k {
                moments.odd += p * flight.odd;
                moments.odd_sigma = math::sqrt(flight.odd_variance);
            }
        }
    };
    let odds = (2 * steps.len().max(1) - 1) as f32;
    weigh(&regular, MAX_FLIGHT..MAX_FLIGHT, odds);
    let mut behind = Sums::default();
    for (k, step) in steps.iter().enumerate().rev() {
        let (weight, number) = (step.against_line(), (k + 1) as f32);
        let alone = Sums {
            one: weight,
            number: weight * number,
            level: weight * step.mean(),
        };
        behind.add(&alone);
        let riser = solve(&behind);
        weigh(&riser, k..steps.len(), riser.likelihood());
        // The last tread is off when its riser is.
        if k + 1 < steps.len() {
            let tread = solve(&alone);
            weigh(&tread, k..k + 1, tread.likelihood());
        }
    }
    for ((number, place), moments) in (1u8..).zip(&mut levels.places).zip(&moments) {
        let mean = moments.mean / total;
        *place = Place {
            height: f32::from(number) * regular.rise + mean,
            sigma: math::sqrt((moments.square / total - mean * mean).max(0.0)),
            off: moments.odd / total,
            off_sigma: moments.odd_sigma,
        };
    }
    levels
}

impl Levels {
    /// A straight flight of which nothing but the riser's height is known.
    pub fn straight(rise: Reading) -> Self {
        let mut levels = Self::default();
        for (i, place) in (1u8..).map(f32::from).zip(&mut levels.places) {
            place.height = i * rise.value;
            place.sigma = i * rise.sigma;
        }
        levels
    }

    /// Levels at the foot and at the top of each riser.
    pub fn risers(&self) -> impl Iterator<Item = [Place; 2]> {
        let tops = self.places.iter().copied();
        let feet = core::iter::once(Place::default()).chain(tops.clone());
        feet.zip(tops).map(|(foot, top)| [foot, top])
    }
}
