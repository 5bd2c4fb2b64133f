//! What the particles say of the answer: doubts, and what may stand there besides.

use super::belief::{LANDING_M, NEAREST_M, Posterior, walls};
use super::dimensions::Measured;
use crate::answer::{MAX_MAYBES, Maybe, Step};
use crate::math;
use crate::observer::{Event, Observer};
use crate::params::current;
use crate::posterior::{
    Base, CELLS, Cloud, Edge, GroundKind, MAX_STEPS, Proposals, SAME_M, Sigmas, Staircase, Told,
    ToldStep, weight,
};
use crate::sort::shell_sort;
use heapless::Vec;

/// Places where something may stand that are told apart, and what is told of: from this probability on.
const MAX_PLACES: usize = 16;
/// See [`MAX_PLACES`].
const LEAST_MAYBE: f32 = 0.05;
/// So many hypotheses are looked around that are not like each other …
const LOOKED: usize = 2;
/// … if they are within so many nats of the likeliest.
const NEAR_NATS: f32 = 4.0;
/// The particles' word against the search's counts from this probability on: so sure of one more step, they were
/// right in 27 of 31 scenes of the simulator.
const SURE: f32 = 0.9;
/// Where ramps begin, metres, and their slopes.
const RAMPS_FROM_M: [f32; 3] = [0.4, 0.8, 1.2];
/// See [`RAMPS_FROM_M`].
const SLOPES: [f32; 4] = [0.06, 0.09, 0.13, 0.18];

/// What the particles say of an answer.
#[derive(Clone, Debug, Default)]
pub struct Belief {
    /// Log-odds of an error in each cell of the way ahead, all that may stand there considered.
    pub doubts: [f32; CELLS],
    /// What may stand there though the answer does not hold it.
    pub maybes: Vec<Maybe, MAX_MAYBES>,
    /// Whether the answer has steps where the particles are sure of ground without any obstacle.
    pub unfounded: bool,
}

impl Posterior {
    /// What the particles say of the answer, after [`Posterior::choose`]: into `belief`, so that no second one stands
    /// on the stack.
    #[inline(never)]
    pub fn judge(&mut self, measured: Option<&Measured>, belief: &mut Belief) {
        let mut edges: Vec<ToldStep, MAX_STEPS> = Vec::new();
        let mut answer = Staircase::nothing();
        let mut sigmas = [0.0; MAX_STEPS];
        if let Some(m) = measured {
            let steps = &m.answer.steps;
            let begins = |b: &&Base| {
                let first = steps.first().map_or(0.0, |s| s.distance_m);
                (b.staircase.x(0) - first).abs() < SAME_M
            };
            let mut same = self
                .bases
                .iter()
                .filter(|b| b.staircase.len() == steps.len());
            let same = same.clone().find(begins).or_else(|| same.next());
            answer = same.map_or(answer, |b| b.staircase);
            let levels = answer.top_m.iter_mut().zip(&mut sigmas);
            for (step, (top, sigma)) in steps.iter().zip(levels) {
                // As many as a staircase has.
                let _ = edges.push(ToldStep::new(
                    (step.distance_m, step.height_m),
                    (step.distance_sigma_m, step.height_sigma_m),
                ));
                (*top, *sigma) = (step.height_m, step.height_sigma_m);
            }
        }
        let told = Told {
            edges: &edges,
            view: self.model.view,
        };
        let flights = self.bases.len();
        self.add_ground(&answer, &sigmas);
        self.spread(&told);
        self.cloud.resample();
        // Another answer may be judged after this one.
        self.bases.truncate(flights);
        belief.doubts = self.cloud.doubts();
        belief.maybes = maybes(&self.cloud, &told);
        belief.unfounded = is_unfounded(&self.cloud, &told);
    }

    /// Where one more step stands behind the last one of the answer that was judged, metres, if the
    /// particles are sure of it. They see the flight as a whole, where the search adds step after step.
    #[inline(never)]
    pub fn next_step(&self, steps: &[Step]) -> Option<f32> {
        let (mut sure, mut sum) = (0.0, 0.0);
        for (staircase, probability) in self.cloud.particles() {
            let mut edges = staircase.edges(&self.model.view).filter(|e| e.seen);
            let mut pairs = steps.iter().zip(edges.by_ref());
            let same = pairs.all(|(step, e)| (step.distance_m - e.x_m).abs() < SAME_M);
            // The pairs end with the steps: where edges end before them, none is left.
            if let Some(next) = edges.next().filter(|_| same) {
                sure += probability;
                sum += probability * next.x_m;
            }
        }
        (sure > SURE && !steps.is_empty()).then(|| sum / sure)
    }

    /// Tells the observer the particles.
    pub fn tell(&self, observer: &mut dyn Observer) {
        observer.event(Event::Posterior {
            cloud: &self.cloud,
            view: &self.model.view,
        });
    }

    /// Level ground and the answer, either with a wall behind.
    #[inline(never)]
    fn add_ground(&mut self, answer: &Staircase, sigmas: &Sigmas) {
        let nothing = Staircase::nothing();
        let grounds = [(&nothing, NEAREST_M), (answer, answer.last_x() + LANDING_M)];
        let different = if answer.is_empty() { 1 } else { 2 };
        for (from, from_m) in grounds.into_iter().take(different) {
            for &wall_m in &walls(&self.model, from_m) {
                let s = Staircase { wall_m, ..*from };
                // There is room for each wall and none, twice.
                let _ = self.bases.push(Base::new(&self.model, s, *sigmas));
            }
        }
    }

    /// Fills the cloud with what may stand there: the hypotheses, and what is near the likeliest of them.
    #[inline(never)]
    fn spread(&mut self, told: &Told<'_>) {
        let Self {
            model,
            bases,
            cloud,
        } = self;
        cloud.clear();
        let ramps = RAMPS_FROM_M
            .into_iter()
            .flat_map(|from_m| SLOPES.map(|slope| Staircase::ramp(from_m, slope)));
        for ramp in ramps.filter(|_| current().rules.ramp_particles) {
            cloud.add(&ramp, weight(model, &ramp), &[0.0; MAX_STEPS], told);
        }
        let weights = bases.iter().map(|b| b.log_weight);
        let top = weights.fold(f32::NEG_INFINITY, math::max);
        for base in bases.iter() {
            cloud.add(&base.staircase, base.log_weight, &base.sigmas, told);
        }
        let mut looked: Vec<&Base, LOOKED> = Vec::new();
        while !looked.is_full() {
            // Level ground with another wall has the same around it.
            let fresh = |b: &&Base| {
                let ground = b.staircase.kind == GroundKind::Nothing;
                !looked.iter().any(|l| {
                    b.staircase.is_like(&l.staircase)
                        || ground && l.staircase.kind == GroundKind::Nothing
                })
            };
            let near = bases.iter().filter(|b| b.log_weight > top - NEAR_NATS);
            let next = near.filter(fresh);
            let next = next.max_by(|a, b| a.log_weight.total_cmp(&b.log_weight));
            let Some(base) = next else { break };
            Proposals { model, told, cloud }.around(base);
            // There is room, or the loop would have ended.
            let _ = looked.push(base);
        }
    }
}

/// Whether the particles agree on ground without an obstacle where the answer has steps. A wall there is none of that:
/// echoes behind it may yet be those of a flight.
fn is_unfounded(cloud: &Cloud, told: &Told<'_>) -> bool {
    let Some(last) = told.edges.last() else {
        return false;
    };
    let ground = |s: &Staircase| match s.kind {
        GroundKind::Nothing | GroundKind::Threshold => s.wall() > last.x_m + SAME_M,
        GroundKind::Ramp => true,
        _ => false,
    };
    let agreed = cloud.particles().filter(|(s, _)| ground(s)).map(|(_, p)| p);
    agreed.sum::<f32>() > SURE
}

/// The edges of particles that the answer does not hold, those near each other as one.
fn maybes(cloud: &Cloud, told: &Told<'_>) -> Vec<Maybe, MAX_MAYBES> {
    let mut sums: Vec<Maybe, MAX_PLACES> = Vec::new();
    for (staircase, probability) in cloud.particles() {
        let seen = staircase.edges(&told.view).filter(|e| e.seen);
        let drop = (staircase.kind == GroundKind::Drop).then_some(Edge {
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
