//! Weighted particles, each a staircase, and what they say about an answer.

use crate::answer::DropEdge;
use crate::estimate::COVERAGE_FACTOR;
use crate::math;
use crate::model::prior::ln;
use crate::model::surfaces::{SLOT_M, SLOTS};
use crate::model::{GroundKind, MAX_STEPS, RIGHT_M, Sigmas, Staircase, ToldDrop, ToldStep, View};
use crate::params::posterior as number;
use heapless::Vec;

/// Particles that are kept.
pub const PARTICLES: usize = 32;
/// What is gathered before it is thinned out.
pub const ROOM: usize = PARTICLES + PARTICLES / 4;
/// Stretches of the way ahead over which conflicts with the answer are summed up.
pub const CELLS: usize = 29;
/// Where the first of them ends, metres from the mirror …
pub const FIRST_END_M: f32 = -0.3;
/// … and how long each further one is.
pub const CELL_M: f32 = 0.1;
/// Log-odds count from here …
pub const LEAST_DOUBT: f32 = -9.0;
/// … to here.
const MOST_DOUBT: f32 = 4.0;
/// Lighter by so many nats than the heaviest is nothing: a thousand of them do not reach
/// [`LEAST_DOUBT`].
const NOTHING: f32 = 20.0;
/// Ground that ends in slots so near to each other ends in one place.
const NEAR_SLOTS: usize = 2;
/// A drop is told if the ground ends in one place with this probability at least.
const LEAST_END: f32 = 0.5;
/// Before three standard deviations the ground ends so rarely.
const BEFORE_SHARE: f32 = 0.005;
/// Halvings by which the threshold of resampling is found: to a millionth of the heaviest weight.
const HALVINGS: usize = 20;

/// One staircase that may stand there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// The staircase, its continuous part at its mean.
    pub staircase: Staircase,
    /// Logarithm of its weight.
    pub log_weight: f32,
}

/// What the answer says.
#[derive(Clone, Debug)]
pub struct Told<'a> {
    /// Its steps.
    pub edges: &'a [ToldStep],
    /// Where it says that the ground ends.
    pub drop: Option<ToldDrop>,
    /// What can be seen.
    pub view: View,
}

/// Weights summed up as they come, as multiples of the heaviest so far.
#[derive(Clone, Debug)]
pub struct Cloud {
    particles: Vec<Particle, ROOM>,
    /// Weight of what contradicts the answer, by where it first does; the last entry: nowhere.
    conflicts: [f32; CELLS + 1],
    /// Weight by number of steps.
    counts: [f32; MAX_STEPS + 1],
    /// Weight of ground that ends, by where.
    ends: [f32; SLOTS],
    heaviest: f32,
    /// Where the next resampling begins, as a share of its threshold.
    begin: f32,
}

/// Where the first resampling begins: none is the likelier for coming first.
const HALF: f32 = 0.5;
/// From one beginning to the next: multiples of the golden ratio fill a circle most evenly.
const GOLDEN: f32 = 0.618_034;

impl Default for Cloud {
    fn default() -> Self {
        Self::new()
    }
}

/// Number of the cell in which an error at `x_m` shows; that behind the last if it is beyond.
fn cell(x_m: f32) -> usize {
    let k = math::ceil((x_m - RIGHT_M - FIRST_END_M) / CELL_M);
    math::max(math::min(k, CELLS as f32), 0.0) as usize
}

/// The weight above which particles are kept as they are, so that [`PARTICLES`] are left at most.
fn threshold(weights: &[f32; ROOM]) -> f32 {
    let kept = |threshold: f32| -> f32 {
        let per = 1.0 / threshold;
        weights.iter().map(|w| math::min(w * per, 1.0)).sum()
    };
    // With the mean weight for threshold no more are kept than wanted. It is above the heaviest where
    // all are about alike.
    let total: f32 = weights.iter().sum();
    let (mut low, mut high) = (0.0f32, math::max(total / PARTICLES as f32, 1.0));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if kept(middle) > PARTICLES as f32 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

impl Cloud {
    /// None yet.
    pub const fn new() -> Self {
        Self {
            particles: Vec::new(),
            conflicts: [0.0; CELLS + 1],
            counts: [0.0; MAX_STEPS + 1],
            ends: [0.0; SLOTS],
            heaviest: f32::NEG_INFINITY,
            begin: HALF,
        }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        self.particles.clear();
        self.conflicts = [0.0; CELLS + 1];
        self.counts = [0.0; MAX_STEPS + 1];
        self.ends = [0.0; SLOTS];
        self.heaviest = f32::NEG_INFINITY;
        self.begin = HALF;
    }

    /// Takes a particle in. What it says of the answer counts here, before resampling, which would only
    /// add variance. One whose weight is no number, or nothing, is left out.
    #[inline(never)]
    pub fn add(
        &mut self,
        staircase: &Staircase,
        log_weight: f32,
        sigmas: &Sigmas,
        told: &Told<'_>,
    ) {
        if !log_weight.is_finite() {
            return;
        }
        if log_weight > self.heaviest {
            let shrink = math::exp(math::max(self.heaviest - log_weight, -NOTHING));
            let sums = self
                .conflicts
                .iter_mut()
                .chain(&mut self.counts)
                .chain(&mut self.ends);
            sums.for_each(|sum| *sum *= shrink);
            self.heaviest = log_weight;
        }
        if log_weight < self.heaviest - NOTHING {
            return;
        }
        let weight = math::exp(log_weight - self.heaviest);
        let mut left = weight;
        for conflict in &staircase.conflicts(told.edges, told.drop, &told.view, sigmas) {
            if let Some(sum) = self.conflicts.get_mut(cell(conflict.x_m)) {
                *sum += left * conflict.probability;
            }
            left *= 1.0 - conflict.probability;
        }
        if let Some(sum) = self.conflicts.last_mut() {
            *sum += left;
        }
        if let GroundKind::Drop { at_m } = staircase.kind
            && let Some(sum) = self.ends.get_mut((at_m / SLOT_M) as usize)
        {
            *sum += weight;
        }
        let seen = staircase.edges(&told.view).filter(|e| e.seen).count();
        if let Some(sum) = self.counts.get_mut(seen) {
            *sum += weight;
        }
        if self.particles.is_full() {
            self.resample();
        }
        // There is room now.
        let _ = self.particles.push(Particle {
            staircase: *staircase,
            log_weight,
        });
    }

    /// Leaves [`PARTICLES`] of them at most: those above a threshold as they are, of the others some,
    /// systematically, each with the threshold for weight (the resampling of a discrete state that
    /// keeps rivals alive and whose error is least, Fearnhead and Clifford 2003). Each draw begins
    /// elsewhere, evenly over the draws, so that light ones which come late are not lost.
    #[inline(never)]
    pub fn resample(&mut self) {
        if self.particles.len() <= PARTICLES {
            return;
        }
        let mut weights = [0f32; ROOM];
        for (weight, p) in weights.iter_mut().zip(&self.particles) {
            *weight = math::exp(math::max(p.log_weight - self.heaviest, -NOTHING));
        }
        let threshold = threshold(&weights);
        let log_threshold = self.heaviest + ln(threshold);
        let mut sum = self.begin * threshold;
        let mut weights = weights.into_iter();
        self.particles.retain_mut(|p| {
            // One for each.
            let weight = weights.next().unwrap_or(0.0);
            if weight >= threshold {
                return true;
            }
            sum += weight;
            let drawn = sum >= threshold;
            if drawn {
                sum -= threshold;
                p.log_weight = log_threshold;
            }
            drawn
        });
        // Of two fractions: `%` would bring in a division of any two numbers.
        self.begin += GOLDEN;
        if self.begin >= 1.0 {
            self.begin -= 1.0;
        }
        self.particles.truncate(PARTICLES);
    }

    /// The particles with their probabilities.
    pub fn particles(&self) -> impl Iterator<Item = (&Staircase, f32)> {
        let of = |p: &Particle| math::exp(math::max(p.log_weight - self.heaviest, -NOTHING));
        let total: f32 = self.particles.iter().map(of).sum();
        let scale = 1.0 / math::max(total, f32::MIN_POSITIVE);
        self.particles
            .iter()
            .map(move |p| (&p.staircase, of(p) * scale))
    }

    /// Probability of each number of steps.
    pub fn counts(&self) -> [f32; MAX_STEPS + 1] {
        let total: f32 = self.counts.iter().sum();
        self.counts.map(|c| c / math::max(total, f32::MIN_POSITIVE))
    }

    /// Where the ground ends, if it does so in one place more likely than not. Its depth is for the echoes to say.
    #[inline(never)]
    pub fn end(&self) -> Option<DropEdge> {
        let around = |k: usize| {
            let slots = self.ends.iter().enumerate();
            slots
                .skip(k.saturating_sub(NEAR_SLOTS))
                .take(2 * NEAR_SLOTS + 1)
        };
        let weight = |k: usize| around(k).map(|(_, w)| *w).sum::<f32>();
        let places = 0..self.ends.len();
        let most = places.max_by(|a, b| weight(*a).total_cmp(&weight(*b)))?;
        let (here, all) = (weight(most), self.conflicts.iter().sum::<f32>());
        if here < LEAST_END * all || here <= 0.0 {
            return None;
        }
        let middle = |k: usize| (k as f32 + 0.5) * SLOT_M;
        let mean = |of: &dyn Fn(f32) -> f32| {
            around(most).map(|(k, w)| w * of(middle(k))).sum::<f32>() / here
        };
        let distance_m = mean(&|x| x);
        let spread_m2 = mean(&|x| (x - distance_m) * (x - distance_m))
            + SLOT_M * SLOT_M * number::EVEN_VARIANCE;
        // One-sided: nearer than three of it the ground ends as rarely as the promise allows.
        let mut before = 0.0;
        let nearest = self.ends.iter().position(|w| {
            before += w;
            before > BEFORE_SHARE * all
        });
        let nearest_m = nearest.map_or(distance_m, |k| k as f32 * SLOT_M);
        let distance_sigma_m = math::max(
            math::sqrt(spread_m2),
            (distance_m - nearest_m) / COVERAGE_FACTOR,
        );
        Some(DropEdge {
            distance_m,
            distance_sigma_m,
            depth_m: None,
            probability: math::min(here / all, 1.0),
        })
    }

    /// Log-odds, per cell, of an error there if there is none before.
    pub fn doubts(&self) -> [f32; CELLS] {
        let mut left: f32 = self.conflicts.iter().sum();
        let mut out = [0.0; CELLS];
        for (out, cell) in out.iter_mut().zip(&self.conflicts) {
            left -= cell;
            let odds = math::max(*cell, number::LEAST_PROBABILITY)
                / math::max(left, number::LEAST_PROBABILITY);
            *out = ln(odds).clamp(LEAST_DOUBT, MOST_DOUBT);
        }
        out
    }
}
