//! The echoes of stairs that go down, in the height plane: their likelihood, and what it says of the edges.
//!
//! Seen from above each tread shows echoes along its level and none beyond its ends: it begins where the sight line over
//! the edge before meets its level (at the riser's foot where that edge lies behind the mirror), and it ends at its own
//! edge. Both ends often shine by themselves. With b the density of all other echoes, r that of a tread's along it, N the
//! density of its echoes' heights, and l what of a tread shows at a place, its ends included,
//!
//! ```text
//! ln p(Z | treads) - ln p(Z | nothing) = Σ ln(1 + r N l / b) - Λ
//! ```
//!
//! where Λ is the expected number of echoes. Apart from echoes that both ends of a tread touch, this is a sum over edges:
//! each is where one tread ends and the sight line to the next begins. So the likelihood of all edges' places is a product
//! of functions of one place, and with equal goings but for small departures it is summed up over first edge and going.

mod edges;
mod flights;

use self::edges::{EdgeDensity, LEAST_NATS, PLACE_M, PLACES, place_beyond, place_m, spread_all};
use super::normal::above;
use super::sight::tread_begins_m;
use super::staircase::{MAX_STEPS, View};
use crate::estimate::Estimate;
use crate::math;
use crate::params::generative::{LEVELS, TreadEnd, TreadNumbers};
use crate::params::posterior as number;
use crate::signal::echoes::{Echo, MAX_ECHOES};
use heapless::Vec;

/// Most treads below the ground that a hypothesis has: no sector of the mirror shows more.
pub const MAX_TREADS: usize = 8;
const _: () = assert!(MAX_TREADS <= MAX_STEPS);
/// Standard deviation of what lies evenly within one place, metres.
const HALF_PLACE_M: f32 = PLACE_M * 0.29;
/// Farther off its level an echo is none of a tread's, metres.
pub const OFF_M: f32 = 0.03;
/// An echo that a tread explains so little better than anything else is none of its.
const LEAST_RATIO: f32 = 0.05;
/// Share of echoes whose height is known worse …
const WIDE: f32 = 0.15;
/// … by so much.
const WIDER: f32 = 3.0;
/// Farther off an end than this an echo lies on the tread or does not, metres.
const AROUND_M: f32 = 0.05;
/// Echoes of a tread lie up to so far beyond its ends on the mean, metres: a lobe's top is not the scatterer.
pub const BEYOND_M: f32 = 0.009;
/// Sight lines up to which the expected number of echoes is summed up, by their tangents: so far apart …
const TANGENT_STEP: f32 = 0.02;
/// … from here on, 31° behind the vertical, …
const FIRST_TANGENT: f32 = -0.6;
/// … up to 60° before it.
const TANGENTS: usize = 116;
/// Degrees of a radian.
const DEG_PER_RAD: f32 = 180.0 / core::f32::consts::PI;
/// Where the scene's number of echoes says how bright it is, so many as expected are added to it.
const USUAL_ECHOES: f32 = 4.0;
/// Echoes below are mostly noise, dB.
const NOISE_DB: f32 = 5.0;
/// Decibels of a level.
pub const LEVEL_DB: f32 = 1.0;
/// Rates of echoes count per so many degrees off the vertical.
const TEN_DEG: f32 = 10.0;

/// An echo as treads explain it.
#[derive(Clone, Copy, Debug)]
struct TreadEcho {
    x_m: f32,
    y_m: f32,
    /// Standard deviation along the tread that its angle's noise leaves, metres.
    x_sigma_m: f32,
    y_sigma_m: f32,
    /// Density of its level on treads over that of all other echoes in a square metre: square metres.
    ratio_m2: f32,
    /// Number of echoes on a tread where it lies, per metre.
    rate: f32,
}

impl TreadEcho {
    /// How much likelier each echo a metre on a tread at a level makes it than chance, metres.
    fn ratio_m(&self, y_m: f32) -> f32 {
        let off_m = self.y_m - y_m;
        if off_m.abs() > OFF_M {
            return 0.0;
        }
        let density = height_density(off_m, self.y_sigma_m);
        let ratio_m = self.ratio_m2 * density;
        if ratio_m * self.rate < LEAST_RATIO {
            0.0
        } else {
            ratio_m
        }
    }
}

/// Density of heights that are off a level by so much, metres: a Gaussian, and a wider one for some.
pub fn height_density(off_m: f32, sigma_m: f32) -> f32 {
    let gauss = |sigma_m: f32| {
        let z = off_m / sigma_m;
        number::PER_ROOT_TAU / sigma_m * math::exp(-0.5 * z * z)
    };
    (1.0 - WIDE) * gauss(sigma_m) + WIDE * gauss(WIDER * sigma_m)
}

/// A tread of a hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreadAt {
    /// Its level, metres.
    pub y_m: f32,
    /// Whether it shows echoes; else its level is that of its neighbours.
    pub shown: bool,
}

/// Treads below the ground, one below the other.
pub type Treads = Vec<TreadAt, MAX_TREADS>;

/// The likelihood of a scan's echoes for stairs going down, and its working memory.
#[derive(Clone, Debug)]
pub struct Descending {
    echoes: Vec<TreadEcho, MAX_ECHOES>,
    /// Of the hypothesis looked at last: its edges' densities.
    edges: [EdgeDensity; MAX_TREADS],
    /// The treads that those belong to, the ground's first.
    treads: Vec<TreadAt, { MAX_TREADS + 1 }>,
    /// Logarithms of the largest densities.
    tops: [f32; MAX_TREADS],
    /// Expected number of echoes of a level one metre below the mirror, up to each sight line.
    expected: [f32; TANGENTS],
    view: View,
    numbers: &'static TreadNumbers,
}

/// What a hypothesis comes to.
#[derive(Clone, Copy, Debug)]
pub struct WeighedTreads {
    /// Logarithm of prior times likelihood, over that of no echo explained.
    pub log_weight: f32,
    /// First edge, metres from the mirror, …
    pub edge_m: f32,
    /// … and going, on the mean.
    pub going_m: f32,
}

impl Descending {
    /// Of no echoes.
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

    /// Takes in a scan's echoes.
    #[inline(never)]
    pub fn take(&mut self, echoes: &[Echo], view: View) {
        let strongest_db = echoes.iter().map(|e| e.snr_db).fold(0.0, math::max);
        let [start, per_q, per_angle, per_both] = self.numbers.rate;
        let q = (strongest_db - number::REFERENCE_DB) * number::PER_TEN_DB;
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
        // A scene that shows more than is usual does so on all its treads.
        let clear = echoes.iter().filter(|e| e.snr_db > NOISE_DB).count() as f32;
        let bright = (clear + USUAL_ECHOES) / (sum * view.height_m + USUAL_ECHOES);
        self.expected.iter_mut().for_each(|e| *e *= bright);
        self.echoes.clear();
        for e in echoes {
            let (_, cos) = math::sin_cos(e.angle_rad);
            let arc_m = e.range_m * e.angle_sigma_rad;
            // `as` saturates.
            let level = math::round(e.snr_db / LEVEL_DB) as usize;
            let ratio_m2 = self.numbers.ratio_m2.get(level.min(LEVELS - 1));
            // As many as there are echoes.
            let _ = self.echoes.push(TreadEcho {
                x_m: e.x_m,
                y_m: e.y_m,
                x_sigma_m: arc_m * cos,
                y_sigma_m: math::sqrt(self.height_variance(e)),
                ratio_m2: ratio_m2.copied().unwrap_or(0.0),
                rate: bright * usual(e.angle_rad * DEG_PER_RAD),
            });
        }
        self.treads.clear();
        self.view = view;
    }

    /// Depth of a level below the mirror, metres.
    pub fn depth_m(&self, y_m: f32) -> f32 {
        math::max(self.view.height_m - y_m, number::LEAST_RANGE_M)
    }

    /// Expected number of echoes on a level one metre below the mirror up to a sight line, by its tangent.
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

    /// The tread at a level, metres.
    pub fn tread(&self, y_m: f32) -> TreadAt {
        TreadAt {
            y_m,
            shown: self.shown(y_m) > 0.0,
        }
    }

    /// Variance of an echo's height, square metres.
    pub fn height_variance(&self, e: &Echo) -> f32 {
        let arc_m = e.range_m * e.angle_sigma_rad * math::sin_cos(e.angle_rad).0;
        self.numbers.height_sigma_m * self.numbers.height_sigma_m + arc_m * arc_m
    }

    /// What an endless tread at a level explains of all echoes, nats.
    pub fn shown(&self, y_m: f32) -> f32 {
        self.explained(|_| y_m)
    }

    /// What ground explains that falls steadily from a distance on, metres, by so much a metre: nats.
    pub fn ramp(&self, from_m: f32, slope: f32) -> f32 {
        let shown = self.explained(|x_m| -slope * math::max(x_m - from_m, 0.0));
        shown - self.depth_m(0.0) * self.expected_to(f32::INFINITY)
    }

    /// What a surface explains of all echoes whose level is known at each distance, nats.
    fn explained(&self, level: impl Fn(f32) -> f32) -> f32 {
        let on = self.echoes.iter().map(|e| (e, e.ratio_m(level(e.x_m))));
        on.map(|(e, ratio_m)| math::ln(1.0 + ratio_m * e.rate))
            .sum()
    }

    /// Weighs the densities of a hypothesis's edges, those that differ from the last one's.
    #[inline(never)]
    pub fn look(&mut self, treads: &[TreadAt]) {
        let ground = TreadAt {
            y_m: 0.0,
            shown: true,
        };
        let known = self.treads.iter().skip(1).zip(treads);
        let known = known.take_while(|(a, b)| a == b).count();
        self.treads.truncate(known + 1);
        if self.treads.is_empty() {
            // There is room for one.
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
            // As many as there are edges, and the ground.
            let _ = self.treads.push(lower);
        }
    }

    /// Log-likelihood of an edge at each place: where the tread before it ends, and the next one begins.
    #[inline(never)]
    fn edge(&self, upper: TreadAt, lower: TreadAt, nats: &mut [f32; PLACES]) {
        let (above_m, below_m) = (self.depth_m(upper.y_m), self.depth_m(lower.y_m));
        let deeper = below_m / above_m;
        let (per_above, per_below) = (1.0 / above_m, 1.0 / below_m);
        for (k, nats) in nats.iter_mut().enumerate() {
            let x_m = place_m(k);
            let before = self.expected_to(x_m * per_above);
            // Over an edge before the mirror the next tread begins on the same sight line.
            let behind = if x_m < 0.0 {
                self.expected_to(x_m * per_below)
            } else {
                before
            };
            *nats = below_m * behind - above_m * before;
        }
        if upper.shown {
            self.end(upper.y_m, None, nats);
        }
        if lower.shown {
            self.end(lower.y_m, Some(deeper), nats);
        }
    }

    /// Density of an edge's place over its largest, and the logarithm of that.
    #[inline(never)]
    fn density(&self, upper: TreadAt, lower: TreadAt, out: &mut [f32; PLACES]) -> f32 {
        self.edge(upper, lower, out);
        let top = out.iter().copied().fold(f32::NEG_INFINITY, math::max);
        for value in out.iter_mut() {
            let nats = *value - top;
            *value = if nats < LEAST_NATS {
                0.0
            } else {
                math::exp(nats)
            };
        }
        top
    }

    /// Adds what the echoes on a tread at a level say of an edge at each place: that the tread ends there, or begins behind
    /// it, so many times as far from the mirror.
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
            let first = place_beyond(edge_of(e.x_m - AROUND_M));
            let last = place_beyond(edge_of(e.x_m + AROUND_M));
            let off = if begins.is_none() {
                0..first
            } else {
                last..PLACES
            };
            let off = nats.get_mut(off).into_iter().flatten();
            off.for_each(|nats| *nats -= endless);
            let shine = [behind, ahead].map(|end| Shine::of(end, e));
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

    /// What the echoes on a tread say of its level: the weighted mean of those between its ends.
    pub fn level(&self, tread: TreadAt, (from_m, to_m): (f32, f32)) -> Option<Estimate> {
        let (mut weight, mut sum) = (0.0, 0.0);
        for e in self.echoes.iter().filter(|_| tread.shown) {
            let inside = e.x_m > from_m - AROUND_M && e.x_m < to_m + AROUND_M;
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

/// What an end of a tread shows of an echo.
struct Shine {
    off_m: f32,
    number: f32,
    per_sigma: f32,
}

impl Shine {
    fn of(end: &TreadEnd, e: &TreadEcho) -> Self {
        let sigma_m = math::hypot(math::hypot(end.sigma_m, HALF_PLACE_M), e.x_sigma_m);
        let per_sigma = 1.0 / sigma_m;
        Self {
            off_m: end.off_m,
            number: end.number * number::PER_ROOT_TAU * per_sigma,
            per_sigma,
        }
    }

    /// Share of the tread that shows so far from its end, metres, and number of echoes a metre that the end shows itself.
    fn at(&self, on_m: f32) -> (f32, f32) {
        let z = (on_m - self.off_m) * self.per_sigma;
        let on = above(-(on_m + BEYOND_M) * self.per_sigma);
        (on, self.number * math::exp(-0.5 * z * z))
    }
}

#[cfg(test)]
mod tests;
