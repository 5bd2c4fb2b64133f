//! Stairs going down, as the search sees them: in the height plane treads face the mirror, one
//! below the other, and the roles of depth and height are exchanged. An edge is where a row of
//! echoes ends and where the shadow on the next tread begins.

use super::evidence::{Evidence, Mark};
use super::levels::{self, Fusion, Reading};
use super::role::Role;
use super::search::{Flight, Link, MAX_FLIGHT, Stairs};
use super::trace::Explanation;
use crate::math::{self, RAD_PER_DEG};

/// Gains and costs in nats, times an echo's credibility.
/// An echo on a tread.
const TREAD: f32 = 2.0;
/// An echo where a tread ends.
const EDGE: f32 = 3.5;
/// The specular flash of the tread right below the mirror.
const FLASH: f32 = 4.5;
/// An echo that the hypothesis does not explain.
const STRAY: f32 = 0.5;
/// An echo inside the solid.
const INSIDE: f32 = 2.0;
/// Each further tread must pay for itself.
const STEP: f32 = 1.2;
/// A tread that shows no echo.
const UNSEEN: f32 = 0.7;
/// An echo worth less than this shows no tread.
const SEEN: f32 = 0.3;
/// Echoes this far from a tread in height still belong to it, metres.
const ZONE: f32 = 0.035;
/// The last echo of a tread lies this much before its edge, metres …
const SHORT: f32 = 0.018;
/// … give or take.
const SPREAD: f32 = 0.015;
/// People's step length: twice the rise and the going, metres.
const STRIDE: f32 = 0.63;
/// Its standard deviation.
const STRIDE_SIGMA: f32 = 0.03;
/// Standard deviation of one riser's height against the first, metres.
const RISE_SIGMA: f32 = 0.01;
/// Goings tried, relative to what the stride asks for, metres.
const GOINGS: [f32; 5] = [-0.04, -0.02, 0.0, 0.02, 0.04];
/// First edges tried, metres from the mirror.
const EDGES: [f32; 8] = [-0.24, -0.20, -0.16, -0.12, -0.08, -0.04, 0.0, 0.04];

/// What two flights of the same treads may differ in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shape {
    /// Where the ground ends, metres from the mirror.
    pub edge: f32,
    /// From one edge to the next, metres.
    pub going: f32,
}

/// Stairs going down.
#[derive(Debug)]
pub struct Descent<'e> {
    evidence: &'e Evidence,
    /// The ground's last echo in front, and the one before: where it may end.
    ends: [f32; 2],
    null: f32,
}

/// Whether a mark lies right below the mirror, where treads flash.
pub fn is_flash(m: &Mark) -> bool {
    m.x.abs() < 0.02 + 1.5 * m.sigma_x
}

/// A tread, or the ground before the first edge.
#[derive(Clone, Copy, Debug)]
struct Tread {
    /// Depth below the mirror, metres.
    depth: f32,
    /// From where on it can be seen, metres from the mirror.
    start: f32,
    /// Where it ends.
    end: f32,
}

impl Tread {
    /// Whether the shadow of the edge before lies on the mark's place.
    fn hides(&self, m: &Mark) -> bool {
        m.x < self.start && m.along > self.depth - 0.02
    }

    /// Role and gain of a mark on the tread; none if it lies beyond its ends.
    fn gain(&self, m: &Mark) -> Option<(Role, f32)> {
        let reach = 1.5 * m.sigma_x;
        // Behind the mirror's foot the riser is seen too, and with it the corner.
        let corner = self.start.is_finite() && self.start < 0.0;
        let before = if corner {
            math::max(reach, 0.03)
        } else {
            reach
        };
        if m.x <= self.start - before || m.x >= self.end + reach {
            return None;
        }
        let z = (m.along - self.depth) / m.sigma;
        let (mut role, mut gain) = (Role::Tread, TREAD);
        if self.start < 0.03 && self.end > -0.03 && is_flash(m) {
            (role, gain) = (Role::Flash, FLASH);
        }
        let spot = |off: f32| off * off / (m.sigma_x * m.sigma_x + SPREAD * SPREAD);
        if corner && EDGE - 0.5 * spot(m.x - self.start) > gain {
            (role, gain) = (Role::Corner, EDGE - 0.5 * spot(m.x - self.start));
        }
        if self.end.is_finite() {
            let q = spot(m.x - self.end + SHORT);
            if EDGE - 0.5 * q > gain {
                (role, gain) = (Role::Edge, EDGE - 0.5 * q);
            }
        }
        Some((role, gain - 0.5 * z * z))
    }
}

impl<'e> Descent<'e> {
    /// Scores everything that is no stair: the ground going on, and ramps downwards.
    pub fn new(evidence: &'e Evidence) -> Self {
        let height = evidence.mount_height;
        let mut ends = [0.0f32; 2];
        for m in evidence.between(height - 0.03, height + 0.03) {
            let [last, _] = ends;
            if m.x < 0.1 && (m.x > last || last == 0.0) {
                ends = [m.x, last];
            }
        }
        let mut descent = Self {
            evidence,
            ends,
            null: 0.0,
        };
        let ground = Tread {
            depth: evidence.mount_height,
            start: f32::NEG_INFINITY,
            end: f32::INFINITY,
        };
        descent.null = descent.tread(&ground).0 + descent.below(ground.depth);
        for degrees in 1..=12u8 {
            let (sin, cos) = math::sin_cos(f32::from(degrees) * RAD_PER_DEG);
            for from in [0.0, -0.1, -0.2] {
                descent.null = math::max(descent.null, descent.ramp(from, sin / cos));
            }
        }
        descent
    }

    /// Score of ground that falls steadily by `slope` from `from` on.
    fn ramp(&self, from: f32, slope: f32) -> f32 {
        let scores = self.evidence.marks.iter().map(|m| {
            let z = (m.y + math::max(m.x - from, 0.0) * slope) / m.sigma;
            m.weight * math::max(TREAD - 0.5 * z * z, -STRAY)
        });
        scores.sum()
    }

    /// Score of the marks near a tread's level, and the best single one.
    fn tread(&self, tread: &Tread) -> (f32, f32) {
        let (mut total, mut best) = (0.0, 0f32);
        for m in self
            .evidence
            .between(tread.depth - ZONE, tread.depth + ZONE)
        {
            let gain = match tread.gain(m) {
                Some((_, gain)) if gain > 0.0 => gain,
                _ if tread.hides(m) => -INSIDE,
                _ => -STRAY,
            };
            total += gain * m.weight;
            best = math::max(best, gain * m.weight);
        }
        (total, best)
    }

    /// Score of the marks below everything.
    fn below(&self, depth: f32) -> f32 {
        let marks = self.evidence.between(depth + ZONE, f32::INFINITY);
        marks.iter().map(|m| -INSIDE * m.weight).sum()
    }

    /// Depth of tread `k` of a chain; the ground is tread 0.
    fn depth(&self, chain: &[Link], k: usize) -> f32 {
        let link = k.checked_sub(1).and_then(|k| chain.get(k));
        link.map_or(self.evidence.mount_height, |l| l.along)
    }

    /// The last tread of a chain, without its end.
    fn last(&self, chain: &[Link], shape: Shape) -> Tread {
        let n = chain.len();
        let depth = self.depth(chain, n);
        let start = match n.checked_sub(1) {
            None => f32::NEG_INFINITY,
            Some(before) => {
                let edge = shape.edge + before as f32 * shape.going;
                // Behind an edge before the mirror lies a shadow.
                if edge < 0.0 {
                    edge
                } else {
                    edge * depth / self.depth(chain, before)
                }
            }
        };
        Tread {
            depth,
            start,
            end: f32::INFINITY,
        }
    }

    /// Cost of a tread on which nothing was seen; the ground need not be.
    fn unseen(chain: &[Link], best: f32) -> f32 {
        if !chain.is_empty() && best < SEEN {
            UNSEEN
        } else {
            0.0
        }
    }

    /// Mean and covariance of edge and going over their likelihood, the treads given.
    pub fn edges(&self, flight: &Flight<Shape>) -> Edges {
        // Two and a half centimetres apart: finer than the echoes know it. The bounds are those of
        // stairs that people use and of a wheelchair that stands before them.
        let shape = |(a, g): (u8, u8)| Shape {
            edge: -0.26 + 0.025 * f32::from(a),
            going: 0.20 + 0.025 * f32::from(g),
        };
        let grid = (0..14u8).flat_map(|a| (0..9u8).map(move |g| (a, g)));
        let mut top = f32::NEG_INFINITY;
        let mut sums = [0f32; 6];
        let rise = flight
            .chain
            .first()
            .map_or(0.0, |l| l.along - self.evidence.mount_height);
        let strides = |at: &Shape| (2.0 * rise + at.going - STRIDE).abs() < 2.5 * STRIDE_SIGMA;
        for at in grid.map(shape).filter(strides) {
            let score = self.whole(&flight.chain, at);
            if score > top {
                // A new best: what was summed up shrinks in comparison.
                let shrink = math::exp(top - score);
                sums = sums.map(|s| s * shrink);
                top = score;
            }
            let p = math::exp(score - top);
            let Shape { edge, going } = at;
            let moments = [1.0, edge, going, edge * edge, going * going, edge * going];
            for (sum, moment) in sums.iter_mut().zip(moments) {
                *sum += p * moment;
            }
        }
        let [sum, d, g, dd, gg, dg] = sums;
        let (edge, going) = (d / sum, g / sum);
        Edges {
            edge,
            going,
            edge_variance: dd / sum - edge * edge,
            going_variance: gg / sum - going * going,
            covariance: dg / sum - edge * going,
        }
    }

    /// Levels of the treads.
    pub fn levels(&self, flight: &Flight<Shape>, edges: &Edges) -> levels::Levels {
        let shape = Shape {
            edge: edges.edge,
            going: edges.going,
        };
        let mut steps = [Fusion::default(); MAX_FLIGHT];
        for (k, fusion) in steps.iter_mut().enumerate().take(flight.chain.len()) {
            let chain = flight.chain.get(..=k).unwrap_or(&[]);
            let mut tread = self.last(chain, shape);
            if k + 1 < flight.chain.len() {
                tread.end = shape.edge + (k + 1) as f32 * shape.going;
            }
            let (mut weight, mut sum) = (0.0, 0.0);
            for m in self
                .evidence
                .between(tread.depth - ZONE, tread.depth + ZONE)
            {
                let near = (m.along - tread.depth).abs() < 0.015 + 2.5 * m.sigma;
                if near && m.x > tread.start - 0.02 && m.x < tread.end + 0.03 + m.sigma_x {
                    let w = m.weight / (m.sigma * m.sigma);
                    weight += w;
                    sum += w * m.y;
                }
            }
            if weight > 0.0 {
                let sigma = math::max(math::sqrt(1.0 / weight), 0.003);
                fusion.add(Reading {
                    value: sum / weight,
                    sigma,
                });
            }
        }
        let count = flight.chain.len();
        let deepest = flight
            .chain
            .last()
            .map_or(0.0, |l| l.along - self.evidence.mount_height);
        let slope = Reading {
            value: -deepest / count.max(1) as f32,
            sigma: 0.02,
        };
        levels::fit(steps.get(..count).unwrap_or(&[]), &[slope])
    }
}

/// Where the edges are: the first one, from one to the next, and how sure that is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Edges {
    edge: f32,
    going: f32,
    edge_variance: f32,
    going_variance: f32,
    covariance: f32,
}

impl Edges {
    /// Place of edge `k` (0 is the ground's end) and its standard deviation.
    pub fn at(&self, k: usize) -> Reading {
        /// Speckle: the edge is where the echoes end, but they end where they like.
        const SPECKLE: f32 = 0.008;
        /// The likelihood's tails are heavier than the truth's.
        const SCALE: f32 = 0.6;
        let k = k as f32;
        let variance = self.edge_variance + 2.0 * k * self.covariance + k * k * self.going_variance;
        Reading {
            value: self.edge + k * self.going,
            sigma: SCALE * math::sqrt(math::max(variance, 0.0) + SPECKLE * SPECKLE),
        }
    }
}

impl Stairs for Descent<'_> {
    type Shape = Shape;
    const SPACING: core::ops::RangeInclusive<f32> = 0.09..=0.22;
    const TOLERANCE: f32 = 0.02;
    const SHAPES: usize = (EDGES.len() + 2) * GOINGS.len();

    fn evidence(&self) -> &Evidence {
        self.evidence
    }

    fn shape(&self, first: Link, index: usize) -> Option<Shape> {
        let rise = first.along - self.evidence.mount_height;
        let off = GOINGS.get(index % GOINGS.len())?;
        let ends = EDGES.iter().chain(&self.ends);
        let edge = *ends.clone().nth(index / GOINGS.len())?;
        let going = STRIDE - 2.0 * rise + off;
        Self::SPACING
            .contains(&rise)
            .then_some(Shape { edge, going })
    }

    fn face(&self, chain: &[Link], next: Link, shape: Shape) -> f32 {
        let k = chain.len();
        let edge = shape.edge + k as f32 * shape.going;
        let tread = Tread {
            end: edge,
            ..self.last(chain, shape)
        };
        let (mut total, best) = self.tread(&tread);
        for m in self.evidence.between(tread.depth + ZONE, next.along - ZONE) {
            let inside = m.x < edge - 1.5 * m.sigma_x;
            total -= m.weight * if inside { INSIDE } else { STRAY };
        }
        let rise = next.along - tread.depth;
        total -= STEP + Self::unseen(chain, best);
        total
            - match chain.first() {
                None => {
                    let z = (2.0 * rise + shape.going - STRIDE) / STRIDE_SIGMA;
                    0.5 * z * z
                }
                Some(first) => {
                    let z = (rise - (first.along - self.evidence.mount_height)) / RISE_SIGMA;
                    math::min(0.5 * z * z, 2.0)
                }
            }
    }

    fn behind(&self, chain: &[Link], shape: Shape) -> f32 {
        let tread = self.last(chain, shape);
        let (total, best) = self.tread(&tread);
        total - Self::unseen(chain, best) + self.below(tread.depth)
    }

    fn null(&self) -> f32 {
        self.null
    }

    fn role(&self, mark: &Mark, chain: &[Link], shape: Shape) -> Role {
        let near = |k: &usize| (mark.along - self.depth(chain, *k)).abs() <= ZONE;
        let Some(k) = (0..=chain.len()).find(near) else {
            return Role::Stray;
        };
        let (before, rest) = chain.split_at_checked(k).unwrap_or((chain, &[]));
        let mut tread = self.last(before, shape);
        if !rest.is_empty() {
            tread.end = shape.edge + k as f32 * shape.going;
        }
        match tread.gain(mark) {
            Some((role, gain)) if gain > 0.0 => role,
            _ if tread.hides(mark) => Role::Inside,
            _ => Role::Stray,
        }
    }

    fn explanation(shape: Shape) -> Explanation {
        Explanation::Down {
            edge_m: shape.edge,
            going_m: shape.going,
        }
    }
}
