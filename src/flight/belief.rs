//! From the search's flights to particles: what the posterior says of them and of the answer.

use super::ascending::{self, Ascending};
use super::dimensions::Measured;
use super::search::Search;
use super::stairs::{Flight, MAX_FLIGHT};
use crate::answer::{MAX_MAYBES, Maybe};
use crate::math;
use crate::posterior::{
    Base, CELLS, Cloud, Edge, Kind, MAX_STEPS, Model, Proposals, Staircase, Told, refine,
};
use crate::sort::shell_sort;
use heapless::Vec;

/// Hypotheses that begin the posterior: the best flight of each length, with its refined dimensions.
pub type Bases = Vec<Base, MAX_FLIGHT>;

/// How much the measurement model's word counts beside the search's score, which rests on the same
/// echoes.
const SHARE: f32 = 0.5;
/// Riser heights from which the refinement begins, as multiples of the search's.
const STRETCHES: [f32; 3] = [0.92, 1.0, 1.08];
/// Overhangs that are tried beside what the echoes say, metres.
const OVERHANGS_M: [f32; 3] = [0.0, 0.02, 0.04];
/// Places where something may stand that are told apart, and what is told of: from this probability on.
const MAX_PLACES: usize = 16;
/// See [`MAX_PLACES`].
const LEAST_MAYBE: f32 = 0.05;
/// Two steps are the same within this distance, metres: design contract of scoring.
const SAME_M: f32 = 0.10;
/// Only hypotheses within so many nats of the likeliest are looked around.
const NEAR_NATS: f32 = 5.0;
/// Walls that are tried, and echoes that may be one.
const WALLS: usize = 2;
/// See [`WALLS`].
const WALL_DB: f32 = 8.0;
/// Where ramps begin, metres, and their slopes.
const RAMPS_FROM_M: [f32; 3] = [0.4, 0.8, 1.2];
/// See [`RAMPS_FROM_M`].
const SLOPES: [f32; 4] = [0.06, 0.09, 0.13, 0.18];

/// A flight of the search as a staircase.
fn staircase(flight: &Flight<ascending::Shape>) -> Staircase {
    let mut s = Staircase::nothing();
    for (k, link) in flight.chain.iter().enumerate() {
        s = s.with(k, link.along_m, flight.shape.rise_m * (k + 1) as f32);
    }
    s.open = flight.shape.open;
    s
}

/// The search's leaders, refined and weighed.
#[inline(never)]
pub fn bases(model: &Model<'_>, search: &Search<'_, Ascending<'_>>) -> Bases {
    let mut bases = Bases::new();
    for flight in &search.leaders {
        let start = staircase(flight);
        let refined = STRETCHES.map(|stretch| {
            let mut s = start;
            s.top_m.iter_mut().for_each(|top| *top *= stretch);
            let (s, sigmas) = refine(model, &s);
            Base::new(model, s, sigmas)
        });
        let by_weight = |a: &Base, b: &Base| a.log_weight.total_cmp(&b.log_weight);
        let Some(best) = refined.into_iter().max_by(by_weight) else {
            continue;
        };
        let overhangs = OVERHANGS_M.map(|overhang_m| {
            let mut s = best.staircase;
            s.overhang_m = overhang_m;
            Base::new(model, s, best.sigmas)
        });
        let best = overhangs.into_iter().chain([best]).max_by(by_weight);
        if let Some(best) = best {
            // As many as there are leaders.
            let _ = bases.push(best);
        }
    }
    bases
}

/// The leader that explains the echoes best.
pub fn choose(
    search: &Search<'_, Ascending<'_>>,
    bases: &Bases,
    best: Option<Flight<ascending::Shape>>,
) -> Option<Flight<ascending::Shape>> {
    let worth = |(f, b): &(&Flight<ascending::Shape>, &Base)| f.score + SHARE * b.log_weight;
    let pairs = search.leaders.iter().zip(bases);
    let top = pairs.max_by(|a, b| worth(a).total_cmp(&worth(b)));
    best.and(top.map(|(f, _)| f.clone()))
}

/// The strongest echoes behind everything near, where a wall may stand.
fn walls(model: &Model<'_>) -> Vec<f32, { WALLS + 1 }> {
    let mut walls = Vec::new();
    let _ = walls.push(f32::INFINITY);
    for _ in 0..WALLS {
        let far = model.echoes.iter().filter(|e| {
            let apart = walls.iter().all(|w: &f32| (w - e.x_m).abs() > 0.05);
            e.snr_db > WALL_DB && e.x_m > 0.3 && apart
        });
        if let Some(e) = far.max_by(|a, b| a.snr_db.total_cmp(&b.snr_db)) {
            let _ = walls.push(e.x_m);
        }
    }
    walls
}

/// What the particles say of an answer.
#[derive(Clone, Debug, Default)]
pub struct Belief {
    /// Log-odds of an error in each cell of the way ahead, all that may stand there considered.
    pub doubts: [f32; CELLS],
    /// What may stand there though the answer does not hold it.
    pub maybes: Vec<Maybe, MAX_MAYBES>,
}

/// What the particles say of the answer: `cloud` is filled and resampled.
#[inline(never)]
pub fn belief(
    model: &Model<'_>,
    bases: &Bases,
    measured: Option<&Measured>,
    cloud: &mut Cloud,
) -> Belief {
    let mut edges: Vec<Edge, MAX_STEPS> = Vec::new();
    let mut answer = Staircase::nothing();
    let mut sigmas = [0.0; MAX_STEPS];
    if let Some(m) = measured {
        let steps = &m.outcome.steps;
        let same = bases.iter().find(|b| b.staircase.len() == steps.len());
        answer = same.map_or(answer, |b| b.staircase);
        let levels = answer.top_m.iter_mut().zip(&mut sigmas);
        for (step, (top, sigma)) in steps.iter().zip(levels) {
            // As many as a staircase has.
            let _ = edges.push(Edge {
                x_m: step.distance_m,
                y_m: step.height_m,
                seen: true,
            });
            (*top, *sigma) = (step.height_m, step.height_sigma_m);
        }
    }
    let told = Told {
        edges: &edges,
        view: model.view,
    };
    cloud.clear();
    let mut proposals = Proposals {
        model,
        told: &told,
        cloud,
    };
    let walls = walls(model);
    let mut all: Vec<Base, { MAX_FLIGHT + 8 }> = Vec::new();
    for &wall_m in &walls {
        let s = Staircase {
            wall_m,
            ..Staircase::nothing()
        };
        let _ = all.push(Base::new(model, s, sigmas));
    }
    if !answer.is_empty() {
        let behind = answer.last_x() + 0.28;
        for &wall_m in walls.iter().filter(|w| **w > behind) {
            let s = Staircase { wall_m, ..answer };
            let _ = all.push(Base::new(model, s, sigmas));
        }
    }
    for base in bases {
        let _ = all.push(*base);
    }
    for from in RAMPS_FROM_M {
        for slope in SLOPES {
            let s = Staircase {
                kind: Kind::Ramp,
                slope,
                wall_m: from,
                ..Staircase::nothing()
            };
            let base = Base::new(model, s, sigmas);
            proposals.cloud.add(&s, base.log_weight, &sigmas, &told);
        }
    }
    let top = all
        .iter()
        .map(|b| b.log_weight)
        .fold(f32::NEG_INFINITY, math::max);
    for base in &all {
        let cloud = &mut *proposals.cloud;
        cloud.add(&base.staircase, base.log_weight, &base.sigmas, &told);
        if base.log_weight > top - NEAR_NATS {
            proposals.around(base);
        }
    }
    cloud.resample();
    Belief {
        doubts: cloud.doubts(),
        maybes: maybes(cloud, &told),
    }
}

/// The edges of particles that the answer does not hold, those near each other as one.
fn maybes(cloud: &Cloud, told: &Told<'_>) -> Vec<Maybe, MAX_MAYBES> {
    let mut sums: Vec<Maybe, MAX_PLACES> = Vec::new();
    for (staircase, probability) in cloud.particles() {
        let seen = staircase.edges(&told.view).filter(|e| e.seen);
        let drop = (staircase.kind == Kind::Drop).then_some(Edge {
            x_m: staircase.wall_m,
            y_m: Maybe::DROP_M,
            seen: true,
        });
        for edge in seen.chain(drop) {
            let near = |x_m: f32| (x_m - edge.x_m).abs() <= SAME_M;
            if told.edges.iter().any(|t| near(t.x_m)) {
                continue;
            }
            let place = sums.iter_mut().find(|m| {
                near(m.distance_m / m.probability) && (m.height_m < 0.0) == (edge.y_m < 0.0)
            });
            let (distance_m, height_m) = (probability * edge.x_m, probability * edge.y_m);
            match place {
                Some(m) => {
                    m.distance_m += distance_m;
                    m.height_m += height_m;
                    m.probability += probability;
                }
                // Where there is no room any more, many places are more doubtful.
                None => drop_full(sums.push(Maybe {
                    distance_m,
                    height_m,
                    probability,
                })),
            }
        }
    }
    let mut maybes = Vec::new();
    let likely = |m: &&Maybe| m.probability >= LEAST_MAYBE;
    for m in sums.iter().filter(likely) {
        let told = Maybe {
            distance_m: m.distance_m / m.probability,
            height_m: m.height_m / m.probability,
            probability: math::min(m.probability, 1.0),
        };
        drop_full(maybes.push(told));
    }
    shell_sort(&mut maybes, |a: &Maybe, b| a.distance_m < b.distance_m);
    maybes
}

/// What finds no room is left out.
fn drop_full(_: Result<(), Maybe>) {}
