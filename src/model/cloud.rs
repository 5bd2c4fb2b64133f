//! Weighted particles, each a staircase or another hypothesis about the scene, and the posterior probabilities of an
//! answer's errors.

use crate::answer::DropEdge;
use crate::estimate::COVERAGE_FACTOR;
use crate::math;
use crate::model::normal::ln;
use crate::model::surfaces::{SLOT_M, SLOTS};
use crate::model::{
    MAX_STEPS, MIN_EXPANDED_M, ReportedDrop, ReportedStep, Sigmas, Staircase, View,
};
use crate::params::posterior::{
    self, MAX_LOG_ODDS, MAX_NEARER_PROBABILITY, MIN_DROP_PROBABILITY, MIN_LOG_ODDS,
};
use heapless::Vec;

/// Maximum number of particles after resampling.
pub const PARTICLES: usize = 32;
/// Maximum number of particles before resampling.
pub const CAPACITY: usize = PARTICLES + PARTICLES / 4;
/// Number of way cells: 10 cm pieces of the way ahead, for which conflicts of particles with the answer are summed.
pub const CELLS: usize = 29;
/// Far end of the first way cell, horizontal metres from the mirror, negative behind it; the cell holds everything
/// nearer.
pub const FIRST_END_M: f32 = -0.3;
/// Length of each way cell but the first, metres.
pub const CELL_M: f32 = 0.1;
/// Difference of log-weight below the heaviest particle from which on a particle is left out, nats: a thousand of such
/// particles together do not reach [`MIN_LOG_ODDS`].
const NEGLIGIBLE_NATS: f32 = 20.0;
/// Number of 5 cm slots to each side of a slot in which ends of the ground count as ends at the same place.
const NEAR_SLOTS: usize = 2;
/// Number of bisections for the threshold of resampling: to a millionth of the heaviest weight.
const HALVINGS: usize = 20;

/// A weighted sample of the posterior: a staircase, or another hypothesis about the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Staircase (or other hypothesis) of the particle; the heights of its treads are their posterior means.
    pub staircase: Staircase,
    /// Weight of the particle: log-prior plus log-likelihood, nats; after resampling, the logarithm of the resampling
    /// threshold if the particle was lighter than that and drawn.
    pub log_weight: f32,
}

/// The answer with which particles are compared, to find where it would be wrong.
#[derive(Clone, Debug)]
pub struct ReportedAnswer<'a> {
    /// Steps of the answer; empty if it has none.
    pub edges: &'a [ReportedStep],
    /// Reported drop; `None` if the answer has none.
    pub drop: Option<ReportedDrop>,
    /// Field of view of the scan: only edges within it count as steps of a particle.
    pub view: View,
}

/// Particles, and sums over all that were added, resampled away or not. In the sums, weights are relative to the
/// heaviest particle so far.
#[derive(Clone, Debug)]
pub struct Cloud {
    particles: Vec<Particle, CAPACITY>,
    /// Entry k is the sum of the weights of particles by which the answer is first wrong in way cell k; the last entry
    /// holds those by which it is wrong in no cell.
    conflicts: [f32; CELLS + 1],
    /// Entry n is the sum of the weights of particles with n visible steps.
    counts: [f32; MAX_STEPS + 1],
    /// Sum of the weights of particles whose ground ends (a drop), by the 5 cm slot of the way in which it ends, the
    /// nearest first.
    ends: [f32; SLOTS],
    heaviest: f32,
    /// Value with which the next resampling's running sum of weights starts, as a share, 0…1, of the threshold at which
    /// the sum draws a particle.
    resampling_offset: f32,
}

/// Value with which the first resampling's running sum of weights starts, as a share of the threshold at which the sum
/// draws a particle: the middle, so that the first particle has no advantage. Later resamplings start at other shares
/// ([`GOLDEN_RATIO_STEP`]).
const HALF: f32 = 0.5;
/// Increment, modulo 1, from one resampling to the next, of the value with which the running sum of weights starts, as
/// a share of the threshold. Multiples of the golden ratio modulo 1 are evenly spread.
const GOLDEN_RATIO_STEP: f32 = 0.618_034;

impl Default for Cloud {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns the index of the way cell for an error in a step at `x_m`, metres: the cell of the place 3 cm nearer, from
/// which on the step counts; [`CELLS`] beyond the last cell.
fn cell(x_m: f32) -> usize {
    let k = math::ceil((x_m - MIN_EXPANDED_M - FIRST_END_M) / CELL_M);
    math::max(math::min(k, CELLS as f32), 0.0) as usize
}

/// Returns the resampling threshold: heavier particles keep their weight, and lighter ones are drawn with probability
/// weight over threshold, so that at most [`PARTICLES`] remain. `weights` are relative to the heaviest particle.
fn threshold(weights: &[f32; CAPACITY]) -> f32 {
    let kept = |threshold: f32| -> f32 {
        let per = 1.0 / threshold;
        weights.iter().map(|w| math::min(w * per, 1.0)).sum()
    };
    // With the mean weight as the threshold, at most [`PARTICLES`] are kept. It exceeds the heaviest weight, 1, where
    // all weights are similar.
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
    /// Returns an empty cloud.
    pub const fn new() -> Self {
        Self {
            particles: Vec::new(),
            conflicts: [0.0; CELLS + 1],
            counts: [0.0; MAX_STEPS + 1],
            ends: [0.0; SLOTS],
            heaviest: f32::NEG_INFINITY,
            resampling_offset: HALF,
        }
    }

    /// Removes all particles and sums.
    pub fn clear(&mut self) {
        self.particles.clear();
        self.conflicts = [0.0; CELLS + 1];
        self.counts = [0.0; MAX_STEPS + 1];
        self.ends = [0.0; SLOTS];
        self.heaviest = f32::NEG_INFINITY;
        self.resampling_offset = HALF;
    }

    /// Adds a particle. Its conflicts with the answer are summed here, before resampling, which would only add
    /// variance. A particle with a log-weight that is not finite or far below the heaviest is left out.
    #[inline(never)]
    pub fn add(
        &mut self,
        staircase: &Staircase,
        log_weight: f32,
        sigmas: &Sigmas,
        reported: &ReportedAnswer<'_>,
    ) {
        if !log_weight.is_finite() {
            return;
        }
        if log_weight > self.heaviest {
            let shrink = math::exp(math::max(self.heaviest - log_weight, -NEGLIGIBLE_NATS));
            let sums = self
                .conflicts
                .iter_mut()
                .chain(&mut self.counts)
                .chain(&mut self.ends);
            sums.for_each(|sum| *sum *= shrink);
            self.heaviest = log_weight;
        }
        if log_weight < self.heaviest - NEGLIGIBLE_NATS {
            return;
        }
        let weight = math::exp(log_weight - self.heaviest);
        let mut left = weight;
        for conflict in &staircase.conflicts(reported.edges, reported.drop, &reported.view, sigmas)
        {
            if let Some(sum) = self.conflicts.get_mut(cell(conflict.x_m)) {
                *sum += left * conflict.probability;
            }
            left *= 1.0 - conflict.probability;
        }
        if let Some(sum) = self.conflicts.last_mut() {
            *sum += left;
        }
        if let Some(end_m) = staircase.kind.end_m()
            && let Some(sum) = self.ends.get_mut((end_m / SLOT_M) as usize)
        {
            *sum += weight;
        }
        let seen = staircase.edges(&reported.view).filter(|e| e.seen).count();
        if let Some(sum) = self.counts.get_mut(seen) {
            *sum += weight;
        }
        if self.particles.is_full() {
            self.resample();
        }
        // Cannot fail: resampling has made room.
        let _ = self.particles.push(Particle {
            staircase: *staircase,
            log_weight,
        });
    }

    /// Reduces the particles to at most [`PARTICLES`].
    ///
    /// Those with a weight above a threshold are kept. Of the others, some are drawn systematically, each with the
    /// threshold as its new weight (optimal resampling of a discrete state, Fearnhead and Clifford 2003, which keeps
    /// runners-up at the least error). Each call starts at another point, evenly spread over the calls, so that light
    /// particles that come late have a chance.
    #[inline(never)]
    pub fn resample(&mut self) {
        if self.particles.len() <= PARTICLES {
            return;
        }
        let mut weights = [0f32; CAPACITY];
        for (weight, p) in weights.iter_mut().zip(&self.particles) {
            *weight = math::exp(math::max(p.log_weight - self.heaviest, -NEGLIGIBLE_NATS));
        }
        let threshold = threshold(&weights);
        let log_threshold = self.heaviest + ln(threshold);
        let mut sum = self.resampling_offset * threshold;
        let mut weights = weights.into_iter();
        self.particles.retain_mut(|p| {
            // There is one weight for each particle.
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
        // Both are below 1. `%` would link a general floating-point remainder.
        self.resampling_offset += GOLDEN_RATIO_STEP;
        if self.resampling_offset >= 1.0 {
            self.resampling_offset -= 1.0;
        }
        self.particles.truncate(PARTICLES);
    }

    /// Returns the particles, each with its probability; the probabilities add up to 1.
    pub fn particles(&self) -> impl Iterator<Item = (&Staircase, f32)> {
        let of =
            |p: &Particle| math::exp(math::max(p.log_weight - self.heaviest, -NEGLIGIBLE_NATS));
        let total: f32 = self.particles.iter().map(of).sum();
        let scale = 1.0 / math::max(total, f32::MIN_POSITIVE);
        self.particles
            .iter()
            .map(move |p| (&p.staircase, of(p) * scale))
    }

    /// Returns the probability of each number of visible steps: entry n is that of n steps.
    pub fn counts(&self) -> [f32; MAX_STEPS + 1] {
        let total: f32 = self.counts.iter().sum();
        self.counts.map(|c| c / math::max(total, f32::MIN_POSITIVE))
    }

    /// Returns the drop, if the ground ends in one place with a probability of at least 50 %. Its depth is left open:
    /// it is measured from the echoes.
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
        if here < MIN_DROP_PROBABILITY * all || here <= 0.0 {
            return None;
        }
        let middle = |k: usize| (k as f32 + 0.5) * SLOT_M;
        let mean = |of: &dyn Fn(f32) -> f32| {
            around(most).map(|(k, w)| w * of(middle(k))).sum::<f32>() / here
        };
        let distance_m = mean(&|x| x);
        let spread_m2 = mean(&|x| (x - distance_m) * (x - distance_m))
            + SLOT_M * SLOT_M * posterior::EVEN_VARIANCE;
        // One-sided: an end nearer than three standard deviations is as rare as `ok` promises.
        let mut before = 0.0;
        let nearest = self.ends.iter().position(|w| {
            before += w;
            before > MAX_NEARER_PROBABILITY * all
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

    /// Returns, for each way cell, the log-odds that the answer is wrong there, given that it is right up to there,
    /// nats.
    pub fn error_log_odds(&self) -> [f32; CELLS] {
        let mut left: f32 = self.conflicts.iter().sum();
        let mut out = [0.0; CELLS];
        for (out, cell) in out.iter_mut().zip(&self.conflicts) {
            left -= cell;
            let odds = math::max(*cell, posterior::MIN_PROBABILITY)
                / math::max(left, posterior::MIN_PROBABILITY);
            *out = ln(odds).clamp(MIN_LOG_ODDS, MAX_LOG_ODDS);
        }
        out
    }
}
