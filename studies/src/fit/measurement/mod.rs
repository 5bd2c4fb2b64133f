//! Fits the measurement model to scans with ground truth: upward flights by hard EM; downward ones (`treads`)
//! directly, where the ground truth determines the tread of each echo.
//!
//! Given the true flight and the current table, every echo is labelled with its most likely feature or class of
//! extended features (`labels`). From the labels each number of a new table is estimated under its prior (maximum
//! posterior). What the ground truth does not contain (overhang, open or closed risers, a wall behind, objects in
//! scenes without steps) is set to its most likely value under the current table. The number of rounds and the
//! initial table are fixed, so that the same scans give the same bytes.

use crate::fit::portable::Portable as _;

mod climb;
mod counts;
mod density;
mod estimate;
mod flights;
mod labels;
mod prior;
mod table;
#[cfg(test)]
mod tests;
mod treads;

use labels::Sample;
use rayon::prelude::*;
use stairscan::config::Plane;
use stairscan::model::{Model, Staircase};
use stairscan::params::generative::Generative;

pub use counts::Counts;
pub use estimate::Number;
pub use flights::{Build, MeasurementSample, most_likely_staircase};
pub use table::{print, write};

/// Number of EM rounds. The labels converge after six.
const ROUNDS: usize = 8;

/// Result of the measurement model's fit.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Fitted parameters of the measurement model.
    pub table: Generative,
    /// The parameters of `table` as a list, with standard errors.
    pub numbers: Vec<Number>,
    /// Number of labelled scans of the depth plane.
    pub scans: usize,
    /// Mean log-likelihood of the true flights, nats a scan, in each EM round.
    pub rounds: Vec<f64>,
}

/// Fits the parameters of the measurement model to scans with ground truth, of both planes.
pub fn measure(measurement_samples: &[MeasurementSample]) -> Measured {
    let mut out = Measured {
        table: prior::START,
        numbers: Vec::new(),
        scans: 0,
        rounds: Vec::new(),
    };
    for _ in 0..ROUNDS {
        let labelled: Vec<_> = measurement_samples
            .par_iter()
            .filter(|measurement_sample| measurement_sample.geometry.plane == Plane::Depth)
            .filter_map(|measurement_sample| label(measurement_sample, &out.table))
            .collect();
        let mut counts = Counts::default();
        for scan in &labelled {
            counts.add(scan.q, scan.exposure, &scan.samples);
        }
        out.scans = labelled.len();
        let total: f64 = labelled.iter().map(|scan| scan.likelihood).sum();
        out.rounds.push(total / labelled.len().max(1) as f64);
        let (table, numbers) = estimate::estimate(&counts, &out.table);
        out.numbers = numbers;
        out.table = table::rounded(&table);
    }
    let (treads, numbers) = treads::measure(measurement_samples);
    out.numbers.extend(numbers);
    out.table = table::rounded(&Generative {
        treads,
        ..out.table
    });
    out
}

/// A scan whose echoes are labelled with features or classes of the measurement model.
struct Labelled {
    q: f32,
    exposure: [f32; 3],
    samples: Vec<Sample>,
    likelihood: f64,
}

fn label(measurement_sample: &MeasurementSample, g: &Generative) -> Option<Labelled> {
    let model = measurement_sample.model(g);
    let flight =
        most_likely_staircase(&model, &measurement_sample.truth, measurement_sample.build)?;
    let mut samples = Vec::new();
    let exposure = labels::label(&model, &flight, &mut |sample| samples.push(sample));
    Some(Labelled {
        q: model.q,
        exposure,
        samples,
        likelihood: model.log_likelihood(&flight).into(),
    })
}

/// Discrimination of true flights from alternatives with the parameters of a measurement model: means over scans,
/// nats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contrast {
    /// Number of scans with steps over which the means are taken.
    pub scans: usize,
    /// Mean log-likelihood of the true flight, nats a scan.
    pub truth: f64,
    /// Mean of -ln of the truth's posterior probability against one alternative each, in this order: no staircase;
    /// the flight without its last step; one step more; the upper half of the steps 3 cm higher or lower.
    pub cost: [f64; 4],
}

/// Change of height, metres, of the upper half of the steps in the alternatives to a true flight.
const RISE_CHANGE_M: f32 = 0.03;
/// Going of the alternatives' additional step where the true flight has only one step, metres.
const GOING_M: f32 = 0.28;

/// Returns how well the parameters `g` discriminate true flights from alternatives, on scans to which the parameters
/// were not fitted.
pub fn contrast(measurement_samples: &[MeasurementSample], g: &Generative) -> Contrast {
    let each: Vec<_> = measurement_samples
        .par_iter()
        .filter(|measurement_sample| measurement_sample.geometry.plane == Plane::Depth)
        .filter_map(|measurement_sample| {
            let model = measurement_sample.model(g);
            let truth =
                most_likely_staircase(&model, &measurement_sample.truth, measurement_sample.build)?;
            (!measurement_sample.truth.steps.is_empty()).then(|| {
                let seen = measurement_sample.truth.steps.len();
                (
                    f64::from(model.log_likelihood(&truth)),
                    costs(&model, &truth, seen),
                )
            })
        })
        .collect();
    let mut mean = Contrast {
        scans: each.len(),
        ..Contrast::default()
    };
    for (truth, costs) in &each {
        mean.truth += truth / each.len() as f64;
        for (mean, cost) in mean.cost.iter_mut().zip(costs) {
            *mean += cost / each.len() as f64;
        }
    }
    mean
}

/// Returns -ln of the truth's posterior probability against each of its alternatives, in the order of
/// [`Contrast::cost`]. Only the first `seen` of the true steps, which are visible, are used.
fn costs(model: &Model<'_>, truth: &Staircase, seen: usize) -> [f64; 4] {
    let mut truth = *truth;
    while truth.len() > seen {
        truth = truth.without_last();
    }
    let of = |s: &Staircase| f64::from(model.log_likelihood(s));
    let here = of(&truth);
    let n = truth.len();
    let odd = |by: f32| {
        let mut s = truth;
        s.top_m.iter_mut().skip(n / 2).for_each(|top| *top += by);
        of(&s)
    };
    let nothing = Staircase {
        wall_m: truth.wall_m,
        ..Staircase::nothing()
    };
    let last = n.saturating_sub(1);
    let going = match n {
        0 | 1 => GOING_M,
        _ => truth.x(last) - truth.x(n - 2),
    };
    let rise = truth.level(n) - truth.level(last);
    let more = truth.with(n, truth.x(last) + going, truth.level(n) + rise);
    let rivals = [
        vec![of(&nothing)],
        vec![of(&truth.without_last())],
        vec![of(&more)],
        vec![odd(RISE_CHANGE_M), odd(-RISE_CHANGE_M)],
    ];
    rivals.map(|rivals| {
        let odds: f64 = rivals
            .iter()
            .map(|rival| (rival - here).exp_portable())
            .sum();
        odds.ln_1p_portable()
    })
}
