//! Levels of a flight's treads: a Gaussian mixture that combines each step's own echoes with the regularity of the
//! flight.

use crate::estimate::Estimate;
use crate::math;
use crate::model::MAX_STEPS;
use crate::params::Params;

/// Maximum exponent of a likelihood ratio. e⁴⁰ = 10¹⁷ outweighs every prior, and sums of such ratios stay within an
/// f32.
const MAX_EXPONENT: f32 = 40.0;

/// Inverse-variance weighted mean of several estimates of one length: height of a tread above the ground, or riser
/// height, metres.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fusion {
    weight: f32,
    sum: f32,
}

impl Fusion {
    /// Adds an estimate of the length, metres, with its inverse variance as weight.
    pub fn add(&mut self, reading: Estimate) {
        let w = 1.0 / reading.variance;
        self.weight += w;
        self.sum += w * reading.value;
    }

    /// Whether no estimate was added.
    pub fn is_empty(&self) -> bool {
        self.weight <= 0.0
    }

    /// Returns the weighted mean, metres, and its variance; without estimates 0 with infinite variance.
    pub fn mean(&self) -> Estimate {
        if self.is_empty() {
            return Estimate {
                value: 0.0,
                variance: f32::INFINITY,
            };
        }
        Estimate {
            value: self.sum / self.weight,
            variance: 1.0 / self.weight,
        }
    }
}

/// Height of one tread above the ground, and the deviation of its riser or tread from a flight of equal rises.
#[derive(Clone, Copy, Debug, Default)]
pub struct TreadLevel {
    /// Height of the tread above the ground, metres; negative going down.
    pub height: Estimate,
    /// Deviation of this step's riser or tread from a flight of equal rises, metres, times the probability that this
    /// step is the flight's irregular one.
    pub off: Estimate,
}

/// Heights of a flight's treads, each with its deviation, the nearest step first.
pub type TreadLevels = [TreadLevel; MAX_STEPS];

/// Sums over some steps of a flight, each weighted by its inverse variance: of 1, of the step's number, and of the
/// height of its tread, metres.
#[derive(Clone, Copy, Debug, Default)]
struct StepSums {
    one: f32,
    number: f32,
    level: f32,
}

impl StepSums {
    fn add(&mut self, other: &Self) {
        self.one += other.one;
        self.number += other.number;
        self.level += other.level;
    }
}

/// Moments of one step over all mixture components, weighted by likelihood: first and second moment of its deviation
/// from the regular flight, and the deviation that an irregular riser or tread explains with its variance.
#[derive(Clone, Copy, Debug, Default)]
struct LevelMoments {
    mean: f32,
    square: f32,
    irregular: f32,
    irregular_variance: f32,
}

/// Fit of a flight of equal rises in which some levels deviate by one common `irregular`, metres: riser height, metres,
/// this deviation, and the covariance matrix of both, m².
#[derive(Clone, Copy, Debug)]
struct FlightFitResult {
    rise: f32,
    irregular: f32,
    rise_variance: f32,
    irregular_variance: f32,
    covariance: f32,
}

impl FlightFitResult {
    /// Returns the height of the tread of step `number`, counted from 1, metres above the ground; with `departs`, the
    /// deviation is added.
    fn at(&self, number: f32, departs: bool) -> Estimate {
        let line = Estimate {
            value: number * self.rise,
            variance: number * number * self.rise_variance,
        };
        if !departs {
            return line;
        }
        Estimate {
            value: line.value + self.irregular,
            variance: line.variance + 2.0 * number * self.covariance + self.irregular_variance,
        }
    }

    /// Returns the likelihood ratio of the readings of the levels under a flight with the deviation to those without
    /// it, with the deviation integrated out. `irregular_sigma_m` is the deviation's prior standard deviation, metres.
    fn likelihood(&self, irregular_sigma_m: f32) -> f32 {
        let exponent = 0.5 * self.irregular * self.irregular / self.irregular_variance;
        math::sqrt(self.irregular_variance) / irregular_sigma_m
            * math::exp(math::min(exponent, MAX_EXPONENT))
    }
}

/// Least-squares fit of a flight of equal rises from the ground to the measured heights of its treads.
struct FlightFit<'p> {
    p: &'p Params,
    /// For each step, the nearest first: measured height of its tread above the ground, metres, and that height's
    /// weight, the inverse of its variance plus that of a step's regular deviation from equal rises.
    steps: heapless::Vec<(f32, f32), MAX_STEPS>,
    whole: StepSums,
    squares: f32,
}

impl<'p> FlightFit<'p> {
    fn new(steps: impl Iterator<Item = Fusion>, rise: Estimate, p: &'p Params) -> Self {
        let mut fit = Self {
            p,
            steps: heapless::Vec::new(),
            whole: StepSums {
                level: rise.value / rise.variance,
                ..StepSums::default()
            },
            squares: 1.0 / rise.variance,
        };
        for (number, step) in (1u8..).map(f32::from).zip(steps) {
            let level = step.mean();
            let weight = 1.0 / (level.variance + p.rise_sigma_m * p.rise_sigma_m);
            fit.whole.level += weight * number * level.value;
            fit.squares += weight * number * number;
            // Cannot fail: a flight has no more steps.
            let _ = fit.steps.push((level.value, weight));
        }
        fit.squares = math::max(fit.squares, f32::MIN_POSITIVE);
        fit
    }

    /// Returns the fit in which the treads that are summed in `sums` deviate in height from a flight of equal rises by
    /// one common amount.
    fn solve(&self, sums: &StepSums) -> FlightFitResult {
        let own = sums.one + 1.0 / (self.p.odd_rise_sigma_m * self.p.odd_rise_sigma_m);
        let det = self.squares * own - sums.number * sums.number;
        FlightFitResult {
            rise: (self.whole.level * own - sums.number * sums.level) / det,
            irregular: (self.squares * sums.level - sums.number * self.whole.level) / det,
            rise_variance: own / det,
            irregular_variance: self.squares / det,
            covariance: -sums.number / det,
        }
    }
}

/// Fits a straight flight from the ground to the steps' levels and to `rise`, the other knowledge of its riser
/// height. Each level may deviate from the flight as far as its own echoes say.
///
/// The model: every step deviates a little. In addition, either one riser is irregular, which shifts all later
/// levels, or one tread is, which shifts its own level only. With a probability of one half there is no irregular
/// one, otherwise each is equally likely. The result is the mean over these cases, weighted by their likelihood, and
/// the variance of the mixture. A step without readings is therefore as uncertain as the irregular steps of built
/// stairs.
pub fn fit(
    steps: impl Iterator<Item = Fusion>,
    rise: Estimate,
    p: &Params,
    levels: &mut TreadLevels,
) {
    mixture(&FlightFit::new(steps, rise, p), levels);
}

/// Writes mean and variance of each tread's height over all mixture components: the regular flight, each riser
/// irregular, each tread irregular.
#[inline(never)]
fn mixture(fit: &FlightFit<'_>, levels: &mut TreadLevels) {
    let p = fit.p;
    let steps = &fit.steps;
    let regular = fit.solve(&StepSums::default());
    let mut moments = [LevelMoments::default(); MAX_STEPS];
    let mut total = 0.0;
    let builder = p.rise_sigma_m * p.rise_sigma_m;
    let mut weigh =
        |flight: &FlightFitResult, departs: core::ops::Range<usize>, likelihood: f32| {
            total += likelihood;
            for ((k, &(level, weight)), moments) in steps.iter().enumerate().zip(&mut moments) {
                let number = (k + 1) as f32;
                let line = flight.at(number, departs.contains(&k));
                let gain = builder * weight;
                let left = 1.0 - gain;
                let off = left * line.value + gain * level - number * regular.rise;
                let variance = left * builder + left * left * line.variance;
                moments.mean += likelihood * off;
                moments.square += likelihood * (off * off + variance);
                if departs.start == k {
                    moments.irregular += likelihood * flight.irregular;
                    moments.irregular_variance = flight.irregular_variance;
                }
            }
        };
    // The regular flight is as likely as all irregular ones together.
    let odds = (2 * steps.len().max(1) - 1) as f32;
    weigh(&regular, MAX_STEPS..MAX_STEPS, odds);
    let mut behind = StepSums::default();
    for (k, &(level, weight)) in steps.iter().enumerate().rev() {
        let alone = StepSums {
            one: weight,
            number: weight * (k + 1) as f32,
            level: weight * level,
        };
        behind.add(&alone);
        let riser = fit.solve(&behind);
        weigh(&riser, k..steps.len(), riser.likelihood(p.odd_rise_sigma_m));
        // An irregular last tread is the same as an irregular last riser.
        if k + 1 < steps.len() {
            let tread = fit.solve(&alone);
            weigh(&tread, k..k + 1, tread.likelihood(p.odd_rise_sigma_m));
        }
    }
    for ((number, place), moments) in (1u8..).zip(levels).zip(&moments) {
        let mean = moments.mean / total;
        *place = TreadLevel {
            height: Estimate {
                value: f32::from(number) * regular.rise + mean,
                variance: math::max(moments.square / total - mean * mean, 0.0),
            },
            off: Estimate {
                value: moments.irregular / total,
                variance: moments.irregular_variance,
            },
        };
    }
}

/// Returns the heights of the treads of a flight of equal rises, of which only the riser height is known.
pub fn straight(rise: Estimate) -> TreadLevels {
    let mut levels = TreadLevels::default();
    for (number, level) in (1u8..).map(f32::from).zip(&mut levels) {
        level.height = Estimate {
            value: number * rise.value,
            variance: number * number * rise.variance,
        };
    }
    levels
}
