//! Logistic regression by Newton's method, with a Gaussian prior around 0.

use crate::fit::portable::Portable as _;

/// Weights of a logistic regression and their standard errors.
#[derive(Clone, Debug, PartialEq)]
pub struct LogisticFit {
    /// One weight for each feature.
    pub weights: Vec<f64>,
    /// Standard error of each weight, from the curvature of the posterior.
    pub errors: Vec<f64>,
    /// Number of samples that the weights are fitted to.
    pub samples: usize,
    /// Number of samples whose outcome is `true`.
    pub positives: usize,
}

/// Maximum number of Newton steps. The posterior has one peak and is smooth, so that few suffice.
const STEPS: usize = 30;
/// Convergence threshold: largest change of a weight in one Newton step, log-odds per unit of its feature.
const SETTLED: f64 = 1e-9;

/// Fits the maximum-posterior weights of `count` features to binary outcomes. The prior of each
/// weight is a Gaussian around 0 with standard deviation `prior_sigma`.
pub fn fit(samples: &[(Vec<f64>, bool)], count: usize, prior_sigma: f64) -> LogisticFit {
    let once = |(features, positives): &(Vec<f64>, bool)| (features.clone(), *positives, 1.0);
    let samples: Vec<_> = samples.iter().map(once).collect();
    weighted(&samples, count, prior_sigma)
}

/// Fits as [`fit()`] does, with each sample counted by a weight: a sample is (features, outcome, weight).
pub fn weighted(samples: &[(Vec<f64>, bool, f64)], count: usize, prior_sigma: f64) -> LogisticFit {
    let mut weights = vec![0.0; count];
    let precision = 1.0 / (prior_sigma * prior_sigma);
    let mut curvature = Matrix::new(count);
    for _ in 0..STEPS {
        curvature = Matrix::new(count);
        let mut slope: Vec<f64> = weights.iter().map(|w| -precision * w).collect();
        for k in 0..count {
            curvature.add(k, k, precision);
        }
        for (features, positives, times) in samples {
            let x: f64 = features.iter().zip(&weights).map(|(f, w)| f * w).sum();
            let p = 1.0 / (1.0 + (-x).exp_portable());
            let left = times * (f64::from(u8::from(*positives)) - p);
            let spread = times * p * (1.0 - p);
            for (i, &a) in features.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                slope[i] += left * a;
                for (j, &b) in features.iter().enumerate().take(i + 1) {
                    curvature.add(i, j, spread * a * b);
                }
            }
        }
        let step = curvature.solve(&slope);
        // Far from the peak a full step may overshoot it.
        let longest = step.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
        let scale = (2.0 / longest.max(f64::MIN_POSITIVE)).min(1.0);
        weights
            .iter_mut()
            .zip(&step)
            .for_each(|(w, s)| *w += scale * s);
        if longest < SETTLED {
            break;
        }
    }
    let error = |k: usize| {
        let mut unit = vec![0.0; count];
        unit[k] = 1.0;
        curvature.solve(&unit)[k].sqrt()
    };
    LogisticFit {
        errors: (0..count).map(error).collect(),
        weights,
        samples: samples.len(),
        positives: samples.iter().filter(|s| s.1).count(),
    }
}

/// A symmetric, positive definite matrix; only the lower half is stored.
#[derive(Clone, Debug)]
pub struct Matrix {
    size: usize,
    values: Vec<f64>,
}

impl Matrix {
    /// A matrix of zeros.
    pub fn new(size: usize) -> Self {
        Self {
            size,
            values: vec![0.0; size * size],
        }
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.size + column]
    }

    /// Adds `value` to an element of the lower half.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.values[row * self.size + column] += value;
    }

    /// Solves the linear equations with this matrix for one right-hand side (Cholesky) and returns the solution, NaN if
    /// the matrix is not positive definite.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let n = self.size;
        let mut root = Self::new(n);
        for i in 0..n {
            for j in 0..=i {
                let sum: f64 = (0..j).map(|k| root.at(i, k) * root.at(j, k)).sum();
                let left = self.at(i, j) - sum;
                let value = if i == j {
                    left.sqrt()
                } else {
                    left / root.at(j, j)
                };
                root.add(i, j, value);
            }
        }
        let mut x = right.to_vec();
        for i in 0..n {
            let sum: f64 = (0..i).map(|k| root.at(i, k) * x[k]).sum();
            x[i] = (x[i] - sum) / root.at(i, i);
        }
        for i in (0..n).rev() {
            let sum: f64 = (i + 1..n).map(|k| root.at(k, i) * x[k]).sum();
            x[i] = (x[i] - sum) / root.at(i, i);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_give_their_own_odds() {
        // Outcome `true` for 30 of 100 samples with feature 0 and for 80 of 100 with feature 1.
        let sample = |k: u32| {
            let feature = f64::from(k / 100);
            (vec![1.0, feature], k % 100 < if k < 100 { 30 } else { 80 })
        };
        let samples: Vec<_> = (0..200).map(sample).collect();
        let fit = fit(&samples, 2, 1e3);
        let odds = |p: f64| (p / (1.0 - p)).ln();
        assert!((fit.weights[0] - odds(0.3)).abs() < 1e-4, "{fit:?}");
        assert!((fit.weights[1] - odds(0.8) + odds(0.3)).abs() < 1e-4);
        // Standard error of log-odds: sqrt(1 / (n p (1 - p))).
        assert!((fit.errors[0] - (1.0 / 21.0_f64).sqrt()).abs() < 1e-4);
        assert_eq!((fit.samples, fit.positives), (200, 110));
    }

    #[test]
    fn what_nothing_tells_stays_where_the_prior_is() {
        let samples = vec![(vec![1.0, 0.0], true), (vec![1.0, 0.0], false)];
        let fit = fit(&samples, 2, 3.0);
        assert!(fit.weights[1].abs() < 1e-12 && (fit.errors[1] - 3.0).abs() < 1e-9);
    }
}
