//! The measurement model going down, in the height plane: likelihood of the scan's echoes, given the treads of a
//! staircase, and the places of its edges.
//!
//! Seen from above, each tread has echoes along its level and none beyond its ends. It begins where the sight line
//! over the edge before meets its level (at the riser's foot where that edge lies behind the mirror), and it ends at
//! its own edge. Both ends often have an echo of their own. With b the density of all other echoes, r the density of
//! a tread's echoes along it, N the density of their heights, and l the visible share of a tread at a place, its
//! ends' own echoes included,
//!
//! ```text
//! ln p(Z | treads) - ln p(Z | nothing) = Σ ln(1 + r N l / b) - Λ
//! ```
//!
//! where Λ is the expected number of echoes. Apart from echoes near both ends of a tread, this is a sum over edges:
//! at each one tread ends and the sight line to the next begins. The likelihood of all edges' places is therefore a
//! product of functions of one place. It is summed over first edge and going, with equal goings but for small
//! deviations.

mod edges;
mod flights;

use self::edges::{EdgeDensity, MIN_NATS, PLACE_M, PLACES, place_beyond, place_m, spread_all};
use super::kinds::GroundKind;
use super::normal::above;
use super::sight::tread_begins_m;
use super::staircase::{MAX_STEPS, View};
use crate::estimate::Estimate;
use crate::math;
use crate::params::descent::{
    END_AROUND_M, END_BEYOND_M, MIN_RATIO, NOISE_DB, TREAD_OFF_M, USUAL_ECHOES, WIDE_FACTOR,
    WIDE_SHARE,
};
use crate::params::generative::{LEVELS, TreadEnd, TreadNumbers};
use crate::params::posterior::{self, Limits};
use crate::signal::echoes::{Echo, MAX_ECHOES};
use heapless::Vec;

/// Maximum number of treads below the ground of a hypothesis: no sector of the mirror shows more.
pub const MAX_TREADS: usize = 8;
const _: () = assert!(MAX_TREADS <= MAX_STEPS);
/// Standard deviation of an even distribution over one place of an edge (1 cm), metres.
const HALF_PLACE_M: f32 = PLACE_M * 0.29;
/// Spacing of the sight lines up to which the expected number of echoes is summed, as tangents of the angle from the
/// vertical.
const TANGENT_STEP: f32 = 0.02;
/// Tangent of the first sight line: 31° behind the vertical.
const FIRST_TANGENT: f32 = -0.6;
/// Number of sight lines: up to 60° before the vertical.
const TANGENTS: usize = 116;
/// Degrees per radian.
const DEG_PER_RAD: f32 = 180.0 / core::f32::consts::PI;
/// Width of the SNR classes in the table of density ratios, dB.
pub const LEVEL_DB: f32 = 1.0;
/// Unit of the angle from the vertical in the rates of echoes, degrees.
const TEN_DEG: f32 = 10.0;

/// An echo with the densities that it has as part of a tread.
#[derive(Clone, Copy, Debug)]
struct TreadEcho {
    x_m: f32,
    y_m: f32,
    /// Standard deviation of the echo's position along the tread, from the noise of the echo's angle, metres.
    x_sigma_m: f32,
    y_sigma_m: f32,
    /// Density of the echo's SNR on treads over that of all other echoes in a square metre, m².
    ratio_m2: f32,
    /// Expected number of echoes per metre of tread at the echo's place.
    rate: f32,
}

impl TreadEcho {
    /// Returns the likelihood ratio for this echo of a tread at height `y_m` above the ground, metres, to everything
    /// else, divided by the rate of echoes along a tread (per metre), so that its unit is metres; 0 for an echo that is
    /// not the tread's.
    fn ratio_m(&self, y_m: f32) -> f32 {
        let off_m = self.y_m - y_m;
        if off_m.abs() > TREAD_OFF_M {
            return 0.0;
        }
        let density = height_density(off_m, self.y_sigma_m);
        let ratio_m = self.ratio_m2 * density;
        if ratio_m * self.rate < MIN_RATIO {
            0.0
        } else {
            ratio_m
        }
    }
}

/// Returns the density, per metre, of a tread echo's height at `off_m` from the tread's height: a mixture of two normal
/// distributions.
pub fn height_density(off_m: f32, sigma_m: f32) -> f32 {
    let gauss = |sigma_m: f32| {
        let z = off_m / sigma_m;
        posterior::PER_ROOT_TAU / sigma_m * math::exp(-0.5 * z * z)
    };
    (1.0 - WIDE_SHARE) * gauss(sigma_m) + WIDE_SHARE * gauss(WIDE_FACTOR * sigma_m)
}

/// A tread of a hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreadAt {
    /// Height of the tread above the ground, metres; negative.
    pub y_m: f32,
    /// Whether the tread has echoes; otherwise its height follows from its neighbours'.
    pub has_echoes: bool,
}

/// Treads below the ground, from the top down.
pub type Treads = Vec<TreadAt, MAX_TREADS>;

/// The likelihood of a scan's echoes for stairs going down, and its working memory.
#[derive(Clone, Debug)]
pub struct Descending {
    echoes: Vec<TreadEcho, MAX_ECHOES>,
    /// Densities of the edges of the hypothesis that was evaluated last; entry k is the edge at which tread k ends, the
    /// ground being tread 0.
    edges: [EdgeDensity; MAX_TREADS],
    /// Treads of the hypothesis that was evaluated last, the ground first.
    treads: Vec<TreadAt, { MAX_TREADS + 1 }>,
    /// Maximum over all places of each edge's log-likelihood, nats, in the order of `edges`, whose densities are
    /// relative to it.
    tops: [f32; MAX_TREADS],
    /// Expected number of echoes on a horizontal surface one metre below the mirror, cumulated up to each sight line,
    /// the rearmost first.
    expected: [f32; TANGENTS],
    view: View,
    numbers: &'static TreadNumbers,
}

/// Weight of a hypothesis of stairs going down, and its mean dimensions.
#[derive(Clone, Copy, Debug)]
pub struct WeighedTreads {
    /// Weight of the hypothesis: log-prior plus log-likelihood ratio against no treads at all, nats.
    pub log_weight: f32,
    /// Posterior mean of the first edge's horizontal distance, metres from the mirror.
    pub edge_m: f32,
    /// Posterior mean of the going, from edge to edge, metres.
    pub going_m: f32,
}

impl Descending {
    /// Returns the model without echoes.
    pub const fn new(numbers: &'static TreadNumbers) -> Self {
        Self {
            echoes: Vec::new(),
            edges: [[0; PLACES]; MAX_TREADS],
            treads: Vec::new(),
            tops: [0.0; MAX_TREADS],
            expected: [0.0; TANGENTS],
            view: View::NOTHING,
            numbers,
        }
    }

    /// Replaces the echoes by those of a scan, and computes the expected numbers of echoes.
    #[inline(never)]
    pub fn set_echoes(&mut self, echoes: &[Echo], view: View) {
        let strongest_db = echoes.iter().map(|e| e.snr_db).fold(0.0, math::max);
        let [start, per_q, per_angle, per_both] = self.numbers.rate;
        let q = (strongest_db - posterior::REFERENCE_DB) * posterior::PER_TEN_DB;
        let fall = (per_angle + per_both * q) / TEN_DEG;
        let usual = |angle_deg: f32| math::exp(start + per_q * q + fall * angle_deg.abs());
        let mut sum = 0.0;
        for (k, expected) in (0u8..).map(f32::from).zip(&mut self.expected) {
            let tangent = FIRST_TANGENT + TANGENT_STEP * k;
            if (view.lowest..=view.highest).contains(&tangent) {
                sum += TANGENT_STEP * usual(math::atan2(tangent, 1.0) * DEG_PER_RAD);
            }
            *expected = sum;
        }
        // A scene with more echoes than usual has more on all its treads.
        let clear = echoes.iter().filter(|e| e.snr_db > NOISE_DB).count() as f32;
        let echo_factor = (clear + USUAL_ECHOES) / (sum * view.height_m + USUAL_ECHOES);
        self.expected.iter_mut().for_each(|e| *e *= echo_factor);
        self.echoes.clear();
        for e in echoes {
            let (_, cos) = math::sin_cos(e.angle_rad);
            let arc_m = e.range_m * e.angle_sigma_rad;
            // `as` saturates.
            let level = math::round(e.snr_db / LEVEL_DB) as usize;
            let ratio_m2 = self.numbers.ratio_m2.get(level.min(LEVELS - 1));
            // Cannot fail: there is room for all echoes.
            let _ = self.echoes.push(TreadEcho {
                x_m: e.x_m,
                y_m: e.y_m,
                x_sigma_m: arc_m * cos,
                y_sigma_m: math::sqrt(self.height_variance(e)),
                ratio_m2: ratio_m2.copied().unwrap_or(0.0),
                rate: echo_factor * usual(e.angle_rad * DEG_PER_RAD),
            });
        }
        self.treads.clear();
        self.view = view;
    }

    /// Returns the depth below the mirror of a surface at height `y_m` above the ground, metres.
    pub fn depth_m(&self, y_m: f32) -> f32 {
        math::max(self.view.height_m - y_m, posterior::MIN_RANGE_M)
    }

    /// Returns the expected number of echoes on a horizontal surface one metre below the mirror, up to a sight line
    /// whose angle from the vertical has this tangent.
    fn expected_to(&self, tangent: f32) -> f32 {
        let place = math::max((tangent - FIRST_TANGENT) * (1.0 / TANGENT_STEP), 0.0);
        // `as` saturates.
        let k = (place as usize).min(TANGENTS - 1);
        let at = |k: usize| {
            let sum = self.expected.get(k.min(TANGENTS - 1));
            sum.copied().unwrap_or(0.0)
        };
        let share = math::min(place - k as f32, 1.0);
        at(k) + share * (at(k + 1) - at(k))
    }

    /// Returns the tread at height `y_m` above the ground, metres, with whether it has echoes: the log-likelihood ratio
    /// of the echoes for it is positive.
    pub fn tread(&self, y_m: f32) -> TreadAt {
        TreadAt {
            y_m,
            has_echoes: self.unlimited_tread_llr(y_m) > 0.0,
        }
    }

    /// Returns the variance of an echo's height, m².
    pub fn height_variance(&self, e: &Echo) -> f32 {
        let arc_m = e.range_m * e.angle_sigma_rad * math::sin_cos(e.angle_rad).0;
        self.numbers.height_sigma_m * self.numbers.height_sigma_m + arc_m * arc_m
    }

    /// Returns the log-likelihood ratio of a tread of unlimited length at height `y_m` above the ground, metres, to
    /// none, nats, without the term for the expected number of echoes.
    pub fn unlimited_tread_llr(&self, y_m: f32) -> f32 {
        self.surface_llr(|_| y_m)
    }

    /// Returns the log-likelihood ratio, to no surface, of a surface of this kind without edges, nats.
    pub fn ground(&self, kind: GroundKind) -> f32 {
        let shown = self.surface_llr(|x_m| kind.height_m(x_m, 0.0));
        shown - self.depth_m(0.0) * self.expected_to(f32::INFINITY)
    }

    /// Returns the log-likelihood ratio, to no surface, of a surface given by its height at each distance, nats,
    /// without the term for the expected number of echoes.
    fn surface_llr(&self, level: impl Fn(f32) -> f32) -> f32 {
        let on = self.echoes.iter().map(|e| (e, e.ratio_m(level(e.x_m))));
        on.map(|(e, ratio_m)| math::ln(1.0 + ratio_m * e.rate))
            .sum()
    }

    /// Computes the densities of the edges of a hypothesis, given by its treads from the top down. Those that it shares
    /// with the last hypothesis are kept.
    #[inline(never)]
    pub fn evaluate(&mut self, treads: &[TreadAt]) {
        let ground = TreadAt {
            y_m: 0.0,
            has_echoes: true,
        };
        let known = self.treads.iter().skip(1).zip(treads);
        let known = known.take_while(|(a, b)| a == b).count();
        self.treads.truncate(known + 1);
        if self.treads.is_empty() {
            // Cannot fail: there is room for the ground.
            let _ = self.treads.push(ground);
        }
        for (k, &lower) in treads.iter().enumerate().skip(known) {
            let upper = self.treads.last().copied().unwrap_or(ground);
            let mut density = [0.0; PLACES];
            let top = self.density(upper, lower, &mut density);
            let Some((edge, room)) = self.edges.get_mut(k).zip(self.tops.get_mut(k)) else {
                break;
            };
            *room = top;
            spread_all(&density, edge);
            // Cannot fail: there is room for as many treads as edges, and the ground.
            let _ = self.treads.push(lower);
        }
    }

    /// Writes the log-likelihood of an edge at each place, in nats, where tread `upper` ends and tread `lower` begins.
    #[inline(never)]
    fn edge(&self, upper: TreadAt, lower: TreadAt, nats: &mut [f32; PLACES]) {
        let (above_m, below_m) = (self.depth_m(upper.y_m), self.depth_m(lower.y_m));
        let deeper = below_m / above_m;
        let (per_above, per_below) = (1.0 / above_m, 1.0 / below_m);
        for (k, nats) in nats.iter_mut().enumerate() {
            let x_m = place_m(k);
            let before = self.expected_to(x_m * per_above);
            // Ahead of the mirror the next tread begins on the same sight line.
            let behind = if x_m < 0.0 {
                self.expected_to(x_m * per_below)
            } else {
                before
            };
            *nats = below_m * behind - above_m * before;
        }
        if upper.has_echoes {
            self.end(upper.y_m, None, nats);
        }
        if lower.has_echoes {
            self.end(lower.y_m, Some(deeper), nats);
        }
    }

    /// Writes the density of the edge between treads `upper` and `lower` at each place, relative to the largest one,
    /// whose logarithm it returns, nats.
    #[inline(never)]
    fn density(&self, upper: TreadAt, lower: TreadAt, out: &mut [f32; PLACES]) -> f32 {
        self.edge(upper, lower, out);
        let top = out.iter().copied().fold(f32::NEG_INFINITY, math::max);
        for value in out.iter_mut() {
            let nats = *value - top;
            *value = if nats < MIN_NATS {
                0.0
            } else {
                math::exp(nats)
            };
        }
        top
    }

    /// Adds to `nats` the log-likelihood that the echoes on a tread at height `y_m` above the ground, metres, give to
    /// an edge at each place. The tread ends at the edge, or, with `begins`, it begins behind the edge; `begins` is the
    /// ratio of the tread's depth below the mirror to the edge's.
    #[inline(never)]
    fn end(&self, y_m: f32, begins: Option<f32>, nats: &mut [f32; PLACES]) {
        let [behind, ahead] = match begins {
            None => &self.numbers.ends,
            Some(_) => &self.numbers.starts,
        };
        let end_of = |x_m: f32| match begins {
            Some(deeper) => tread_begins_m(x_m, deeper),
            None => x_m,
        };
        let edge_of = |x_m: f32| match begins {
            Some(deeper) => tread_begins_m(x_m, 1.0 / deeper),
            None => x_m,
        };
        for e in &self.echoes {
            let ratio_m = e.ratio_m(y_m);
            if ratio_m <= 0.0 {
                continue;
            }
            let endless = math::ln(1.0 + ratio_m * e.rate);
            let first = place_beyond(edge_of(e.x_m - END_AROUND_M));
            let last = place_beyond(edge_of(e.x_m + END_AROUND_M));
            let off = if begins.is_none() {
                0..first
            } else {
                last..PLACES
            };
            let off = nats.get_mut(off).into_iter().flatten();
            off.for_each(|nats| *nats -= endless);
            let shine = [behind, ahead].map(|end| EndEcho::of(end, e));
            let near = nats.iter_mut().enumerate().take(last).skip(first);
            for (k, nats) in near {
                let x_m = place_m(k);
                let beyond_m = end_of(x_m) - e.x_m;
                let on_m = if begins.is_none() {
                    beyond_m
                } else {
                    -beyond_m
                };
                let [behind, ahead] = &shine;
                let (on, shines) = if x_m < 0.0 { behind } else { ahead }.at(on_m);
                *nats += math::ln(1.0 + ratio_m * (e.rate * on + shines)) - endless;
            }
        }
    }

    /// Returns the height of a tread above the ground, metres: the weighted mean of its echoes' heights between its
    /// ends, `ends_m`; `None` without echoes.
    pub fn level(&self, tread: TreadAt, ends_m: Limits) -> Option<Estimate> {
        let (mut weight, mut sum) = (0.0, 0.0);
        for e in self.echoes.iter().filter(|_| tread.has_echoes) {
            let inside = e.x_m > ends_m.low - END_AROUND_M && e.x_m < ends_m.high + END_AROUND_M;
            if inside && e.ratio_m(tread.y_m) * e.rate > 1.0 {
                let w = 1.0 / (e.y_sigma_m * e.y_sigma_m);
                weight += w;
                sum += w * e.y_m;
            }
        }
        (weight > 0.0).then(|| Estimate {
            value: sum / weight,
            variance: 1.0 / weight,
        })
    }
}

/// Density of one echo near a tread's end: as the echo of the end itself, and as one of the tread.
struct EndEcho {
    off_m: f32,
    number: f32,
    per_sigma: f32,
}

impl EndEcho {
    fn of(end: &TreadEnd, e: &TreadEcho) -> Self {
        let sigma_m = math::hypot(math::hypot(end.sigma_m, HALF_PLACE_M), e.x_sigma_m);
        let per_sigma = 1.0 / sigma_m;
        Self {
            off_m: end.off_m,
            number: end.number * posterior::PER_ROOT_TAU * per_sigma,
            per_sigma,
        }
    }

    /// Returns the visible share of the tread at a distance `on_m` from its end onto it, metres, and the number of the
    /// end's own echoes per metre.
    fn at(&self, on_m: f32) -> (f32, f32) {
        let z = (on_m - self.off_m) * self.per_sigma;
        let on = above(-(on_m + END_BEYOND_M) * self.per_sigma);
        (on, self.number * math::exp(-0.5 * z * z))
    }
}

#[cfg(test)]
mod tests;
