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

use super::normal::above;
use super::prior::{GOES_ON, departure, ln};
use super::sight::tread_begins_m;
use super::staircase::{MAX_STEPS, View};
use crate::estimate::{COVERAGE_FACTOR, Estimate};
use crate::math;
use crate::params::generative::{LEVELS, TreadEnd, TreadNumbers};
use crate::params::posterior as number;
use crate::signal::echoes::{Echo, MAX_ECHOES};
use heapless::Vec;

/// Most treads below the ground that a hypothesis has: no sector of the mirror shows more.
pub const MAX_TREADS: usize = 8;
const _: () = assert!(MAX_TREADS <= MAX_STEPS);
/// Places at which an edge may lie: from behind the mirror of a chair that stands before the stairs to the end of the
/// scanned sector …
const PLACES: usize = 201;
/// … metres from the mirror …
const FIRST_PLACE_M: f32 = -0.30;
/// … a centimetre apart, which is about as well as the echoes know them.
const PLACE_M: f32 = 0.01;
/// Standard deviation of what lies evenly within one place, metres.
const HALF_PLACE_M: f32 = PLACE_M * 0.29;
/// First edges, in places: up to 28 cm behind the mirror and 8 cm before it.
const FIRST_EDGES: core::ops::Range<usize> = 2..39;
/// Goings that stairs have, in places.
const GOINGS: core::ops::Range<usize> = 20..63;
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
/// Share of edges that depart from equal goings by up to [`ODD_PLACES`].
const ODD: f32 = 0.05;
/// See [`ODD`].
const ODD_PLACES: usize = 7;
/// Share of them at each place.
const EACH_ODD: f32 = ODD / (2 * ODD_PLACES + 1) as f32;
/// The others depart by 6 mm, half a place included: share of them at each place beside.
const BESIDE: f32 = 0.166;
/// First edges and goings so much below the likeliest are left out: 9 nats, in 64ths.
const NOTHING: i32 = 9 * 64;
/// A place lies farther than three standard deviations off as rarely.
const OUTSIDE: f32 = 0.005;
/// Below any density.
const NONE: i32 = i32::MIN / 2;
/// Logarithms are kept in 64ths of a nat …
const PER_NAT: f32 = 64.0;
/// … down to here, where nothing counts any more …
const LEAST_NATS: f32 = -20.0;
/// … and its density.
const LEAST_DENSITY: f32 = 2e-9;
/// Volume that the echoes leave of a tread's level, metres: √(2π) times the 3 mm to which they are known.
const VOLUME_M: f32 = 0.0075;
/// Range of first rises, metres.
const RISES_M: f32 = 0.16;
/// 2 rise + going of a flight, metres, and its standard deviation: Blondel 1675; codes allow 3 cm, and what is
/// older or lower than they allow as much again.
const STRIDE_M: f32 = 0.63;
/// See [`STRIDE_M`].
const STRIDE_SIGMA_M: f32 = 0.06;
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

/// Logarithm of the density of an edge's place over its largest, by place, in 64ths of a nat.
type EdgeDensity = [i16; PLACES];

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

    /// Logarithm of prior times likelihood of the first `count` of the treads that were looked at last, over that of no
    /// echo explained, with the means of first edge and going.
    #[inline(never)]
    pub fn weigh(&self, count: usize) -> WeighedTreads {
        let treads = self.treads.get(..count + 1).unwrap_or(&self.treads);
        let deepest_m = treads.last().map_or(0.0, |t| t.y_m);
        let shown = treads.iter().filter(|t| t.shown);
        let mut log_weight = shown.map(|t| self.shown(t.y_m)).sum::<f32>() + prior(treads);
        log_weight += self.tops.iter().take(count).sum::<f32>();
        log_weight -= self.depth_m(deepest_m) * self.expected_to(f32::INFINITY);
        let mut sums = Sums::default();
        self.each_flight(count, |nats, first, going| sums.add(nats, first, going));
        let flights = FIRST_EDGES.len() as f32 * if count > 1 { GOINGS.len() as f32 } else { 1.0 };
        if count > 0 {
            log_weight += sums.top as f32 * (1.0 / PER_NAT) + ln(sums.weight / flights);
        }
        let per = PLACE_M / math::max(sums.weight, f32::MIN_POSITIVE);
        WeighedTreads {
            log_weight,
            edge_m: FIRST_PLACE_M + sums.first * per,
            going_m: sums.going * per,
        }
    }

    /// Logarithm of the density of each first edge and going that is not too unlikely, in places.
    #[inline(always)]
    fn each_flight(&self, count: usize, mut each: impl FnMut(i32, usize, usize)) {
        let (Some((first, others)), true) = (self.edges.split_first(), count > 0) else {
            return;
        };
        let others = others.get(..count - 1).unwrap_or(others);
        let rise_m = -self.treads.get(count).map_or(0.0, |t| t.y_m) / count as f32;
        let mut strides = [0; GOINGS.end - GOINGS.start];
        for (stride, going) in strides.iter_mut().zip(GOINGS) {
            let z = (2.0 * rise_m + PLACE_M * going as f32 - STRIDE_M) / STRIDE_SIGMA_M;
            // `as` saturates.
            *stride = (-0.5 * PER_NAT * z * z) as i32;
        }
        // A single edge has no going.
        let goings = if others.is_empty() {
            &[0]
        } else {
            &strides[..]
        };
        let mut top = NONE;
        let firsts = || {
            first
                .iter()
                .enumerate()
                .take(FIRST_EDGES.end)
                .skip(FIRST_EDGES.start)
        };
        let likeliest = firsts().max_by_key(|(_, nats)| **nats).map(|(k, _)| k);
        // First what is likely by itself, so that little is looked at which is not likely besides.
        for (from, &nats) in firsts().filter(|(k, _)| Some(*k) == likeliest) {
            for (&stride, going) in goings.iter().zip(GOINGS) {
                let sum = flight(i32::from(nats) + stride, (from, going), others, top);
                top = top.max(sum.unwrap_or(top));
            }
        }
        for (from, &nats) in firsts() {
            if i32::from(nats) < top - NOTHING {
                continue;
            }
            for (&stride, going) in goings.iter().zip(GOINGS) {
                let begun = i32::from(nats) + stride;
                if begun < top - NOTHING {
                    continue;
                }
                if let Some(sum) = flight(begun, (from, going), others, top) {
                    top = top.max(sum);
                    each(sum, from, going);
                }
            }
        }
    }

    /// Place of edge `k` of the first `count` that were looked at last, by all flights and departures from them.
    #[inline(never)]
    pub fn place(&self, count: usize, k: usize) -> Estimate {
        let mut flights = [0.0; PLACES];
        let mut top = NONE;
        self.each_flight(count, |nats, first, going| {
            if nats > top {
                flights.iter_mut().for_each(|w| *w *= share(top - nats));
                top = nats;
            }
            if let Some(weight) = flights.get_mut((first + k * going).min(PLACES - 1)) {
                *weight += share(nats - top);
            }
        });
        let mut density = [0.0; PLACES];
        if let Some((&upper, &lower)) = self.treads.get(k).zip(self.treads.get(k + 1)) {
            self.density(upper, lower, &mut density);
        }
        let spread = EdgeSpread { density: &density };
        let mut places = [0.0; PLACES];
        for (place, &weight) in flights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            let per = weight / spread.at(place);
            spread.each(place, &mut |near, density| {
                if let Some(sum) = places.get_mut(near) {
                    *sum += per * density;
                }
            });
        }
        self.estimate(&places)
    }

    /// Mean and variance of a place from its density, not normalised. Where that has wide tails the variance is so large that
    /// the place lies within three standard deviations as often as it should.
    fn estimate(&self, density: &[f32; PLACES]) -> Estimate {
        let mean_of = |of: &dyn Fn(f32) -> f32| {
            let each = density.iter().enumerate();
            each.map(|(k, w)| w * of(place_m(k))).sum::<f32>()
        };
        let sum = math::max(mean_of(&|_| 1.0), f32::MIN_POSITIVE);
        let value = mean_of(&|x_m| x_m) / sum;
        let scale = self.numbers.edge_sigma_scale;
        let spread = mean_of(&|x_m| (x_m - value) * (x_m - value)) / sum;
        let variance = scale * scale * (spread + number::EVEN_VARIANCE * PLACE_M * PLACE_M);
        let outside = |reach_m: f32| mean_of(&|x_m| f32::from((x_m - value).abs() > reach_m)) / sum;
        let reaches = (0u8..).map(|k| PLACE_M * f32::from(k)).take(PLACES);
        let reach_m = reaches
            .map_while(|m| (outside(m) > OUTSIDE).then_some(m))
            .last();
        let tail_m = reach_m.unwrap_or(0.0) / COVERAGE_FACTOR;
        Estimate {
            value,
            variance: math::max(variance, tail_m * tail_m),
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

/// Distance of a place from the mirror, metres.
fn place_m(k: usize) -> f32 {
    FIRST_PLACE_M + PLACE_M * k as f32
}

/// Adds the densities of a flight's further edges; none where it gets too unlikely.
fn flight(
    begun: i32,
    (from, going): (usize, usize),
    others: &[EdgeDensity],
    top: i32,
) -> Option<i32> {
    let (mut sum, mut place) = (begun, from);
    for edge in others {
        place = (place + going).min(PLACES - 1);
        sum += edge.get(place).map_or(0, |nats| i32::from(*nats));
        if sum < top - NOTHING {
            return None;
        }
    }
    Some(sum)
}

/// The first place beyond a distance from the mirror, metres.
fn place_beyond(x_m: f32) -> usize {
    // `as` saturates.
    (math::ceil((x_m - FIRST_PLACE_M) * (1.0 / PLACE_M)) as usize).min(PLACES)
}

/// Logarithm of the prior of a flight's treads, the ground's first, times the volume that the echoes leave their levels.
fn prior(treads: &[TreadAt]) -> f32 {
    let count = treads.len().saturating_sub(1);
    let (Some(ground), Some(last)) = (treads.first(), treads.last()) else {
        return 0.0;
    };
    let rise_m = (ground.y_m - last.y_m) / math::max(count as f32, 1.0);
    let mut sum = 0.0;
    for (k, pair) in treads.windows(2).enumerate() {
        let [upper, lower] = pair else { continue };
        if k > 0 {
            sum += const { ln(GOES_ON) };
        }
        if lower.shown {
            sum += if k > 0 {
                let off_m = upper.y_m - lower.y_m - rise_m;
                departure(off_m, number::RISE_DEPARTS) + const { ln(VOLUME_M) }
            } else {
                const { ln(VOLUME_M / RISES_M) }
            };
        }
    }
    sum
}

/// Edges spread over what they depart from equal goings: most by half a place, some by a few.
struct EdgeSpread<'d> {
    density: &'d [f32; PLACES],
}

impl EdgeSpread<'_> {
    /// Density where a flight puts an edge at a place.
    fn at(&self, place: usize) -> f32 {
        let mut sum = 0.0;
        self.each(place, &mut |_, density| sum += density);
        math::max(sum, f32::MIN_POSITIVE)
    }

    /// Its parts, by where the edge really lies.
    fn each(&self, place: usize, part: &mut dyn FnMut(usize, f32)) {
        let first = place.saturating_sub(ODD_PLACES);
        let near = self.density.iter().enumerate().skip(first);
        for (k, &density) in near.take(place + ODD_PLACES + 1 - first) {
            let small = match k.abs_diff(place) {
                0 => 1.0 - 2.0 * BESIDE,
                1 => BESIDE,
                _ => 0.0,
            };
            part(k, density * ((1.0 - ODD) * small + EACH_ODD));
        }
    }
}

/// The same at all places, as logarithms.
#[inline(never)]
fn spread_all(density: &[f32; PLACES], out: &mut EdgeDensity) {
    let at = |k: Option<usize>| k.and_then(|k| density.get(k)).copied().unwrap_or(0.0);
    let mut around: f32 = density.iter().take(ODD_PLACES).sum();
    for (place, value) in out.iter_mut().enumerate() {
        around += at(Some(place + ODD_PLACES)) - at(place.checked_sub(ODD_PLACES + 1));
        let beside = at(place.checked_sub(1)) + at(Some(place + 1));
        let small = (1.0 - 2.0 * BESIDE) * at(Some(place)) + BESIDE * beside;
        let sum = (1.0 - ODD) * small + EACH_ODD * math::max(around, 0.0);
        let nats = if sum > LEAST_DENSITY {
            math::ln(sum)
        } else {
            LEAST_NATS
        };
        // `as` saturates.
        *value = (nats * PER_NAT) as i16;
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

/// Weighted sums over flights, relative to the likeliest so far: of 1, first edge, going, in places.
#[derive(Debug)]
struct Sums {
    top: i32,
    weight: f32,
    first: f32,
    going: f32,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            top: NONE,
            weight: 0.0,
            first: 0.0,
            going: 0.0,
        }
    }
}

impl Sums {
    fn add(&mut self, nats: i32, first: usize, going: usize) {
        if nats > self.top {
            let shrink = share(self.top - nats);
            let sums = [&mut self.weight, &mut self.first, &mut self.going];
            sums.into_iter().for_each(|sum| *sum *= shrink);
            self.top = nats;
        }
        let weight = share(nats - self.top);
        self.weight += weight;
        self.first += weight * first as f32;
        self.going += weight * going as f32;
    }
}

/// e to so many 64ths of a nat, none of them above 0; 0 from [`NOTHING`] on.
fn share(nats: i32) -> f32 {
    // `as` saturates.
    let share = SHARES.get(nats.unsigned_abs() as usize);
    share.copied().unwrap_or(0.0)
}

/// See [`share`].
static SHARES: [f32; NOTHING as usize + 1] = {
    // e to the power of -1/64.
    const STEP: f64 = 0.984_496_437_005_408_4;
    let mut shares = [0.0; NOTHING as usize + 1];
    let (mut share, mut k) = (1.0, 0);
    while k < shares.len() {
        shares[k] = share as f32;
        share *= STEP;
        k += 1;
    }
    shares
};

#[cfg(test)]
mod tests;
