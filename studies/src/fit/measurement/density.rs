//! Densities of the measurement model in double precision, as in `stairscan::model`.

use crate::fit::portable::Portable as _;
use std::f64::consts::TAU;

use stairscan::model::MIN_DB;

/// Weight of the Gaussian core of the density with tails: see `stairscan::model::tailed`.
const CORE: f64 = 0.92;
/// Weight of the tails: see `stairscan::model::tailed`.
const TAIL: f64 = 0.005;
/// Width of the tails: the squared deviation, in variances, at which they have fallen to a sixteenth.
const TAIL_WIDTH: f64 = 128.0;
/// Slope of the logistic approximation of the normal distribution.
const PROBIT: f64 = 1.702;
/// Lower bound of the probability, in the denominator, that an echo's SNR exceeds the detection threshold.
const MIN_TAIL: f64 = 0.02;
/// Width of the uniform component in the distribution of an echo's SNR, dB.
const FLAT_DB: f64 = 50.0;

/// Logarithm of a density with heavy tails, not normalised, at the squared deviation `z2`, in variances.
pub fn log_tailed(z2: f64) -> f64 {
    (CORE * (-0.5 * z2).exp_portable() + TAIL * (1.0 + z2 / TAIL_WIDTH).powi(-4)).ln_portable()
}

/// Density with heavy tails in two dimensions, from the squared deviation in variances and the product of the two
/// variances.
pub fn tailed(z2: f64, variances: f64) -> f64 {
    (log_tailed(z2)).exp_portable() / (TAU * variances.sqrt())
}

/// Upper tail of the standard normal distribution beyond `z`, logistic approximation.
pub fn above(z: f64) -> f64 {
    1.0 / (1.0 + (PROBIT * z).exp_portable())
}

/// Density of an echo's SNR `snr_db`, per dB: a Gaussian with `mean` and `sigma`, dB, truncated at the detection
/// threshold, and a uniform component of weight `flat`.
pub fn level(snr_db: f64, mean: f64, sigma: f64, flat: f64) -> f64 {
    let z = (snr_db - mean) / sigma;
    let tail = above((f64::from(MIN_DB) - mean) / sigma).max(MIN_TAIL);
    (1.0 - flat) * (-0.5 * z * z).exp_portable() / (TAU.sqrt() * sigma * tail) + flat / FLAT_DB
}

#[cfg(test)]
mod tests {
    use super::*;
    use stairscan::model;

    #[test]
    fn they_are_the_firmwares() {
        for k in 0..480 {
            let x = 0.25 * k as f32;
            let tailed = model::tailed(x);
            assert!(
                (f64::from(tailed) - log_tailed(x.into()).exp()).abs() < 1e-5,
                "{x}"
            );
            for (mean, sigma) in [(2.0, 3.0), (9.0, 6.0), (-8.0, 4.0)] {
                let there = f64::from(model::level_density(2.8 + x, mean, sigma, 0.05));
                let here = level((2.8 + x).into(), mean.into(), sigma.into(), 0.05);
                assert!(
                    (there - here).abs() < 1e-4 * (1.0 + here),
                    "{x} {mean} {there} {here}"
                );
            }
        }
    }
}
