//! Maximises a smooth log-likelihood of a few parameters with Gaussian priors (damped Newton
//! method).

use super::super::logistic::Matrix;

/// Gaussian prior of a fitted parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Mean of the prior, in the parameter's unit.
    pub mean: f64,
    /// Standard deviation of the prior, in the parameter's unit.
    pub sigma: f64,
}

/// Peak of the posterior density of the fitted parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Peak {
    /// Value of each parameter at the peak.
    pub at: Vec<f64>,
    /// Standard error of each parameter, from the curvature at the peak.
    pub errors: Vec<f64>,
}

/// Maximum number of Newton steps.
const STEPS: usize = 60;
/// Step of the finite differences, in units of the prior's standard deviation.
const APART: f64 = 1e-3;
/// Convergence threshold: gain of the log-posterior in a step, nats.
const SETTLED: f64 = 1e-6;
/// Initial damping, in units of the prior's precision.
const DAMPING: f64 = 1e-3;
/// Factor by which the damping grows after a step that does not increase the posterior, and shrinks
/// after one that does.
const DAMPING_FACTOR: f64 = 10.0;
/// Damping at which the search ends, in units of the prior's precision.
const MAX_DAMPING: f64 = 1e12;

/// Maximises `likelihood` (nats) plus the log-priors as `climb` does, from the priors' means.
pub fn from_means(priors: &[Prior], likelihood: impl Fn(&[f64]) -> f64) -> Peak {
    let start: Vec<f64> = priors.iter().map(|p| p.mean).collect();
    climb(&start, priors, likelihood)
}

/// Maximises `likelihood` (nats) plus the log-priors from `start`. The likelihood must be smooth
/// over a thousandth of a prior's standard deviation.
fn climb(start: &[f64], priors: &[Prior], likelihood: impl Fn(&[f64]) -> f64) -> Peak {
    let count = start.len();
    // In units of the priors' standard deviations.
    let place = |u: &[f64]| -> Vec<f64> {
        let pairs = u.iter().zip(priors);
        pairs
            .map(|(u, prior)| prior.mean + u * prior.sigma)
            .collect()
    };
    let value = |u: &[f64]| likelihood(&place(u)) - 0.5 * u.iter().map(|u| u * u).sum::<f64>();
    let mut u: Vec<f64> = start
        .iter()
        .zip(priors)
        .map(|(x, prior)| (x - prior.mean) / prior.sigma)
        .collect();
    let (mut best, mut damping) = (value(&u), DAMPING);
    for _ in 0..STEPS {
        let (slope, curvature) = differences(&u, best, &value);
        let mut gained = f64::INFINITY;
        while damping < MAX_DAMPING {
            let mut damped = curvature.clone();
            (0..count).for_each(|k| damped.add(k, k, damping));
            let step = damped.solve(&slope);
            let next: Vec<f64> = u.iter().zip(&step).map(|(u, s)| u + s).collect();
            let reached = value(&next);
            // Also false where the matrix is not positive definite and the step is no number.
            if reached >= best {
                (gained, best, u) = (reached - best, reached, next);
                damping /= DAMPING_FACTOR;
                break;
            }
            damping *= DAMPING_FACTOR;
        }
        if damping >= MAX_DAMPING || gained < SETTLED {
            break;
        }
    }
    let (_, curvature) = differences(&u, best, &value);
    let error = |k: usize| {
        let mut unit = vec![0.0; count];
        unit[k] = 1.0;
        let variance = curvature.solve(&unit)[k];
        // Without curvature (the peak lies on a floor) the error is the prior's.
        if variance > 0.0 { variance.sqrt() } else { 1.0 }
    };
    Peak {
        errors: (0..count).map(|k| error(k) * priors[k].sigma).collect(),
        at: place(&u),
    }
}

/// Returns gradient and negative Hessian of the function `value` at the point `u` by central differences; `here` is the
/// function's value at `u`.
fn differences(u: &[f64], here: f64, value: &impl Fn(&[f64]) -> f64) -> (Vec<f64>, Matrix) {
    let count = u.len();
    let moved = |steps: &[(usize, f64)]| {
        let mut u = u.to_vec();
        steps.iter().for_each(|&(k, d)| u[k] += d * APART);
        value(&u)
    };
    let mut slope = vec![0.0; count];
    let mut curvature = Matrix::new(count);
    for (i, slope) in slope.iter_mut().enumerate() {
        let (up, down) = (moved(&[(i, 1.0)]), moved(&[(i, -1.0)]));
        *slope = (up - down) / (2.0 * APART);
        curvature.add(i, i, -(up + down - 2.0 * here) / (APART * APART));
        for j in 0..i {
            let (same, across) = (
                moved(&[(i, 1.0), (j, 1.0)]) + moved(&[(i, -1.0), (j, -1.0)]),
                moved(&[(i, 1.0), (j, -1.0)]) + moved(&[(i, -1.0), (j, 1.0)]),
            );
            curvature.add(i, j, -0.25 * (same - across) / (APART * APART));
        }
    }
    (slope, curvature)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_spread_of_a_gaussian() {
        let samples: Vec<f64> = (0..400).map(|k| 3.0 + f64::from(k % 5) - 2.0).collect();
        let wide = |mean| Prior { mean, sigma: 20.0 };
        let peak = climb(&[0.0, 1.0], &[wide(0.0), wide(1.0)], |p| {
            let log = |x: &f64| -0.5 * ((x - p[0]) / p[1]).powi(2) - p[1].abs().ln();
            samples.iter().map(log).sum()
        });
        // Variance 2: standard errors sqrt(2 / 400) and sqrt(2 / 800).
        assert!((peak.at[0] - 3.0).abs() < 2e-3, "{peak:?}");
        assert!((peak.at[1].abs() - 2.0_f64.sqrt()).abs() < 2e-3, "{peak:?}");
    }

    #[test]
    fn what_nothing_tells_stays_where_the_prior_is() {
        let prior = Prior {
            mean: 0.3,
            sigma: 0.2,
        };
        let peak = climb(&[0.9], &[prior], |_| 0.0);
        assert!((peak.at[0] - 0.3).abs() < 1e-6 && (peak.errors[0] - 0.2).abs() < 1e-6);
    }
}
