//! Counts the measurement model from scans with known truth: going up by hard EM, going down (`treads`) where the truth
//! itself says which tread an echo lies on.
//!
//! Under the true flight and the table so far, every echo is labelled as the feature or the class of
//! extended features that it most likely is (`labels`); the labels give a new
//! table, each number the most likely one under its prior. What the truth does not say (overhang,
//! open or closed, a wall behind, what stands where no step does) is what the table so far finds most
//! likely. A fixed number of rounds from a fixed table: the same scans give the same bytes.

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
pub use flights::{Build, Sighting, standing};
pub use table::{print, write};

/// Rounds of labelling and counting: the labels have settled after six.
const ROUNDS: usize = 8;

/// A table and where it comes from.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The table.
    pub table: Generative,
    /// Its numbers, with errors.
    pub numbers: Vec<Number>,
    /// Scans that it was counted from.
    pub scans: usize,
    /// Mean log-likelihood of the true flights, nats a scan, in each round.
    pub rounds: Vec<f64>,
}

/// The table that the sightings make most likely.
pub fn measure(sightings: &[Sighting]) -> Measured {
    let mut out = Measured {
        table: prior::START,
        numbers: Vec::new(),
        scans: 0,
        rounds: Vec::new(),
    };
    for _ in 0..ROUNDS {
        let labelled: Vec<_> = sightings
            .par_iter()
            .filter(|sighting| sighting.geometry.plane == Plane::Depth)
            .filter_map(|sighting| label(sighting, &out.table))
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
    let (treads, numbers) = treads::measure(sightings);
    out.numbers.extend(numbers);
    out.table = table::rounded(&Generative {
        treads,
        ..out.table
    });
    out
}

/// A scan whose echoes are labelled.
struct Labelled {
    q: f32,
    exposure: [f32; 3],
    samples: Vec<Sample>,
    likelihood: f64,
}

fn label(sighting: &Sighting, g: &Generative) -> Option<Labelled> {
    let model = sighting.model(g);
    let flight = standing(&model, &sighting.truth, sighting.build)?;
    let mut samples = Vec::new();
    let exposure = labels::label(&model, &flight, &mut |sample| samples.push(sample));
    Some(Labelled {
        q: model.q(),
        exposure,
        samples,
        likelihood: model.log_likelihood(&flight).into(),
    })
}

/// How well a table tells true flights from others: means over scans, nats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contrast {
    /// Scans with steps.
    pub scans: usize,
    /// Log-likelihood of the truth.
    pub truth: f64,
    /// -ln of the truth's share against nothing, the flight less its last step, one step more, and a
    /// rise 3 cm higher or lower with all that follows.
    pub cost: [f64; 4],
}

/// An odd rise, metres.
const ODD_M: f32 = 0.03;
/// The going that a further step is taken to have where there is one only, metres.
const GOING_M: f32 = 0.28;

/// The contrast of a table on scans that it was not counted from.
pub fn contrast(sightings: &[Sighting], g: &Generative) -> Contrast {
    let each: Vec<_> = sightings
        .par_iter()
        .filter(|sighting| sighting.geometry.plane == Plane::Depth)
        .filter_map(|sighting| {
            let model = sighting.model(g);
            let truth = standing(&model, &sighting.truth, sighting.build)?;
            (!sighting.truth.steps.is_empty()).then(|| {
                let seen = sighting.truth.steps.len();
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

/// The truth's cost against each of its rivals; of its steps, the first `seen` are in sight.
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
        vec![odd(ODD_M), odd(-ODD_M)],
    ];
    rivals.map(|rivals| {
        let odds: f64 = rivals
            .iter()
            .map(|rival| (rival - here).exp_portable())
            .sum();
        odds.ln_1p_portable()
    })
}
