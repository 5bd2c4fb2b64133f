//! The sum over flights going down: first edge and going, and each edge's deviation from equal goings.
//!
//! In: the density of each edge's place, given the levels of the treads. Out: the weight of these levels, and mean
//! and variance of each edge's place. Log-densities are integers; their exponentials are in a table.

use super::edges::{
    EdgeDensity, EdgeSpread, FIRST_PLACE_M, MIN_DENSITY, PER_NAT, PLACE_M, PLACES, place_m,
};
use super::{Descending, TreadAt, WeighedTreads};
use crate::estimate::{COVERAGE_FACTOR, Estimate};
use crate::math;
use crate::model::normal::{departure, ln};
use crate::params::descent::{FIRST_RISES_WIDTH_M, OUTSIDE_SHARE};
use crate::params::posterior;
use crate::params::posterior::P_CONTINUES;

/// Places of the first edge, as indices of the grid: up to 28 cm behind the mirror and 8 cm before it.
const FIRST_EDGES: core::ops::Range<usize> = 2..39;
/// Goings of stairs, in places of 1 cm.
const GOINGS: core::ops::Range<usize> = 20..63;
/// Distance below the likeliest flight at which flights are left out: 9 nats, in 1/64 nat.
const UNREACHABLE: i32 = 9 * 64;
/// Stands for no flight: below any log-density, 1/64 nat.
pub(super) const NONE: i32 = i32::MIN / 2;
/// Width of the posterior of a tread's height, metres: √(2π) times its standard deviation of 3 mm.
const VOLUME_M: f32 = 0.0075;
/// Mean of 2 rise + going of a flight, metres: Blondel 1675.
const STRIDE_M: f32 = 0.63;
/// Standard deviation of 2 rise + going, metres: codes allow 3 cm, and older or lower stairs deviate by as much
/// again.
const STRIDE_SIGMA_M: f32 = 0.06;

impl Descending {
    /// Returns the log-weight of the first `count` treads that were evaluated last, relative to no treads at all,
    /// with the mean first edge and going.
    #[inline(never)]
    pub fn weigh(&self, count: usize) -> WeighedTreads {
        let treads = self.treads.get(..count + 1).unwrap_or(&self.treads);
        let deepest_m = treads.last().map_or(0.0, |t| t.y_m);
        let shown = treads.iter().filter(|t| t.has_echoes);
        let mut log_weight =
            shown.map(|t| self.unlimited_tread_llr(t.y_m)).sum::<f32>() + prior(treads);
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

    /// Calls `each` with the log-density in 1/64 nat, the place of the first edge and the going in places, for all
    /// likely flights of `count` treads.
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
        // The likeliest first edge is tried first, so that the limit for the others is high from the start.
        for (from, &nats) in firsts().filter(|(k, _)| Some(*k) == likeliest) {
            for (&stride, going) in goings.iter().zip(GOINGS) {
                let sum = flight(i32::from(nats) + stride, from, going, others, top);
                top = top.max(sum.unwrap_or(top));
            }
        }
        for (from, &nats) in firsts() {
            if i32::from(nats) < top - UNREACHABLE {
                continue;
            }
            for (&stride, going) in goings.iter().zip(GOINGS) {
                let begun = i32::from(nats) + stride;
                if begun < top - UNREACHABLE {
                    continue;
                }
                if let Some(sum) = flight(begun, from, going, others, top) {
                    top = top.max(sum);
                    each(sum, from, going);
                }
            }
        }
    }

    /// Returns the distance from the mirror, metres, of edge `k` of the first `count` treads that were evaluated last,
    /// averaged over all flights and deviations from equal goings.
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
            let sum = spread.at(place);
            if sum > MIN_DENSITY {
                let per = weight / sum;
                spread.each(place, &mut |near, density| {
                    if let Some(sum) = places.get_mut(near) {
                        *sum += per * density;
                    }
                });
            } else if let Some(sum) = places.get_mut(place) {
                // An edge that nothing shows where a flight has it is where the flight has it.
                *sum += weight;
            }
        }
        self.estimate(&places)
    }

    /// Returns mean, metres, and variance of an edge's distance from its density by place, which need not be
    /// normalised. With heavy tails the variance is enlarged, so that the edge lies within three standard deviations as
    /// often as promised.
    fn estimate(&self, density: &[f32; PLACES]) -> Estimate {
        let mean_of = |of: &dyn Fn(f32) -> f32| {
            let each = density.iter().enumerate();
            each.map(|(k, w)| w * of(place_m(k))).sum::<f32>()
        };
        let sum = math::max(mean_of(&|_| 1.0), f32::MIN_POSITIVE);
        let value = mean_of(&|x_m| x_m) / sum;
        let scale = self.numbers.edge_sigma_scale;
        let spread = mean_of(&|x_m| (x_m - value) * (x_m - value)) / sum;
        let variance = scale * scale * (spread + posterior::EVEN_VARIANCE * PLACE_M * PLACE_M);
        let outside = |reach_m: f32| mean_of(&|x_m| f32::from((x_m - value).abs() > reach_m)) / sum;
        let reaches = (0u8..).map(|k| PLACE_M * f32::from(k)).take(PLACES);
        let reach_m = reaches
            .map_while(|m| (outside(m) > OUTSIDE_SHARE).then_some(m))
            .last();
        let tail_m = reach_m.unwrap_or(0.0) / COVERAGE_FACTOR;
        Estimate {
            value,
            variance: math::max(variance, tail_m * tail_m),
        }
    }
}

/// Returns the log-density of a flight, in 1/64 nat: `begun`, and those of its further edges, `going` places apart
/// behind place `from`. It returns none once the flight is too unlikely against `top`.
fn flight(begun: i32, from: usize, going: usize, others: &[EdgeDensity], top: i32) -> Option<i32> {
    let (mut sum, mut place) = (begun, from);
    for edge in others {
        place = (place + going).min(PLACES - 1);
        sum += edge.get(place).map_or(0, |nats| i32::from(*nats));
        if sum < top - UNREACHABLE {
            return None;
        }
    }
    Some(sum)
}

/// Returns the log-prior of a flight's treads, the ground first, plus the logarithm of the volume of their heights
/// after the echoes are known, nats.
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
            sum += const { ln(P_CONTINUES) };
        }
        if lower.has_echoes {
            sum += if k > 0 {
                let off_m = upper.y_m - lower.y_m - rise_m;
                departure(off_m, posterior::RISE_DEPARTS) + const { ln(VOLUME_M) }
            } else {
                const { ln(VOLUME_M / FIRST_RISES_WIDTH_M) }
            };
        }
    }
    sum
}

/// Weighted sums over flights: of 1, of the place of the first edge, and of the going, in places. Weights are relative
/// to the likeliest flight so far, whose log-density is `top`, 1/64 nat.
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

/// Returns e^(nats/64) for a non-positive argument; 0 below -[`UNREACHABLE`].
pub(super) fn share(nats: i32) -> f32 {
    // `as` saturates.
    let share = SHARES.get(nats.unsigned_abs() as usize);
    share.copied().unwrap_or(0.0)
}

/// Table of [`share`].
static SHARES: [f32; UNREACHABLE as usize + 1] = {
    // e^(-1/64).
    const STEP: f64 = 0.984_496_437_005_408_4;
    let mut shares = [0.0; UNREACHABLE as usize + 1];
    let (mut share, mut k) = (1.0, 0);
    while k < shares.len() {
        shares[k] = share as f32;
        share *= STEP;
        k += 1;
    }
    shares
};
