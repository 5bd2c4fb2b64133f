//! A staircase as a hypothesis: where its risers stand and how high their tops are.

use super::normal::above;
use super::sight::tread_begins_m;
use crate::config::Plane;
use crate::estimate::COVERAGE_FACTOR;
pub use crate::estimate::RIGHT_M;
use crate::estimate::{MOST_UNCERTAIN_M, expanded};
use crate::math;
use crate::params::current;
use crate::params::posterior as number;
use crate::signal::grid::PolarMap;
use heapless::Vec;

/// Most risers of a staircase.
pub const MAX_STEPS: usize = 10;
/// Two steps are the same within this distance, metres: design contract of scoring.
pub const SAME_M: f32 = 0.10;

/// What stands there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum GroundKind {
    /// Level ground, and perhaps a wall.
    #[default]
    Nothing,
    /// Ground that rises steadily.
    Ramp {
        /// From this distance on, metres.
        from_m: f32,
        /// By so much a metre.
        slope: f32,
    },
    /// Ground that ends: a brink, a hole.
    Drop {
        /// Where, metres.
        at_m: f32,
    },
    /// Steps going up: risers and the levels of their tops.
    Stairs,
    /// Steps going down: edges and the levels of the treads below them.
    Descent,
    /// One thing too tall to climb.
    Box,
    /// One thing too low for a step.
    Threshold,
}

impl GroundKind {
    /// One thing so high, metres, that rises from the ground.
    pub fn single(height_m: f32) -> Self {
        let p = current();
        if height_m < p.lowest_step_m {
            Self::Threshold
        } else if height_m <= p.highest_step_m {
            Self::Stairs
        } else {
            Self::Box
        }
    }
}

/// A staircase, or what else may be there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Staircase {
    /// What it is.
    pub kind: GroundKind,
    /// Number of risers.
    pub steps: u8,
    /// Whether there is nothing below the treads.
    pub open: bool,
    /// How far the nosings stand before their risers, metres.
    pub overhang_m: f32,
    /// Where each riser stands, metres from the mirror.
    pub x_m: [f32; MAX_STEPS],
    /// Level at its top, metres.
    pub top_m: [f32; MAX_STEPS],
    /// Where a wall stands behind, metres; infinitely far off for none.
    pub wall_m: f32,
}

/// Standard deviation of each level of a staircase, metres.
pub type Sigmas = [f32; MAX_STEPS];

/// What can be seen from the mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// What the mirror sweeps.
    pub plane: Plane,
    /// Mirror above the ground, metres.
    pub height_m: f32,
    /// Tangents of the angles between which an edge can be seen, the scanned sector less half a beam: above the
    /// horizontal in the depth plane, forward of the vertical in the height plane.
    pub lowest: f32,
    /// See [`View::lowest`].
    pub highest: f32,
    /// Farthest edge that is seen, metres from the mirror.
    pub farthest_m: f32,
}

impl View {
    /// Whether a sight line, by its tangent, meets something at a range, metres, that can be seen.
    fn shows(&self, tangent: f32, range_m: f32) -> bool {
        tangent > self.lowest && tangent < self.highest && range_m < self.farthest_m
    }
}

/// Bins at the far end of the range that show no peak.
const UNSEEN_BINS: f32 = 8.0;

impl View {
    /// Nothing is seen.
    pub const NOTHING: Self = Self {
        plane: Plane::Depth,
        height_m: 0.0,
        lowest: 0.0,
        highest: 0.0,
        farthest_m: 0.0,
    };

    /// What a map looks at: its outermost rows less half a beam, and its bins less those that show no
    /// peak.
    pub fn of(map: &PolarMap) -> Self {
        let geometry = map.geometry();
        let last = map.rows().saturating_sub(1);
        let (first, last) = (map.angle_rad(0), map.angle_rad(last));
        let tangent = |angle_rad: f32| {
            let (sin, cos) = math::sin_cos(angle_rad);
            let slope = sin / math::max(cos, f32::EPSILON);
            match geometry.plane {
                Plane::Depth => -slope,
                Plane::Height => slope,
            }
        };
        let half = 0.5 * geometry.beamwidth_rad;
        let (near, far) = (math::min(first, last) + half, math::max(first, last) - half);
        let (lowest, highest) = match geometry.plane {
            Plane::Depth => (far, near),
            Plane::Height => (near, far),
        };
        Self {
            plane: geometry.plane,
            height_m: geometry.mount_height_m,
            lowest: tangent(lowest),
            highest: tangent(highest),
            farthest_m: geometry.range_m(map.bins() as f32 - UNSEEN_BINS),
        }
    }
}

/// An edge of a staircase that counts as a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Horizontal distance, metres.
    pub x_m: f32,
    /// Height, metres.
    pub y_m: f32,
    /// Whether it can be seen.
    pub seen: bool,
}

/// A step of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToldStep {
    /// Horizontal distance, metres.
    pub x_m: f32,
    /// Height, metres.
    pub y_m: f32,
    /// Expanded uncertainty of the distance, metres.
    pub x_within_m: f32,
    /// Expanded uncertainty of the height, metres.
    pub y_within_m: f32,
}

impl ToldStep {
    /// From distance and height, metres, and their standard deviations.
    pub fn new((x_m, y_m): (f32, f32), sigmas_m: (f32, f32)) -> Self {
        let within = |sigma_m| math::min(expanded(sigma_m), MOST_UNCERTAIN_M);
        Self {
            x_m,
            y_m,
            x_within_m: within(sigmas_m.0),
            y_within_m: within(sigmas_m.1),
        }
    }
}

/// Where an answer says that the ground ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToldDrop {
    /// Horizontal distance, metres.
    pub x_m: f32,
    /// So far off a drop is still the one that is told, metres.
    pub within_m: f32,
}

impl ToldDrop {
    /// From a distance, metres, and its standard deviation.
    pub fn new(x_m: f32, sigma_m: f32) -> Self {
        let within_m = math::max(SAME_M, COVERAGE_FACTOR * sigma_m);
        Self { x_m, within_m }
    }

    /// Whether it covers one at a distance, metres.
    pub fn covers(&self, x_m: f32) -> bool {
        (self.x_m - x_m).abs() <= self.within_m
    }
}

/// Where a staircase, if it is true, makes an answer wrong, and how likely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conflict {
    /// Horizontal distance, metres.
    pub x_m: f32,
    /// Probability.
    pub probability: f32,
}

/// One for each step on either side at most, and a drop.
pub type Conflicts = Vec<Conflict, { 2 * MAX_STEPS + 1 }>;

impl Staircase {
    /// Level ground.
    pub fn nothing() -> Self {
        Self {
            wall_m: f32::INFINITY,
            ..Self::default()
        }
    }

    /// Ground that rises steadily from a distance on, metres.
    pub fn ramp(from_m: f32, slope: f32) -> Self {
        Self {
            kind: GroundKind::Ramp { from_m, slope },
            ..Self::nothing()
        }
    }

    /// Ground that ends at a distance, metres.
    pub fn drop(at_m: f32) -> Self {
        Self {
            kind: GroundKind::Drop { at_m },
            ..Self::nothing()
        }
    }

    /// Whether another one has its risers in the same places, and the same wall behind.
    pub fn is_like(&self, other: &Self) -> bool {
        let places = self.x_m.iter().zip(&other.x_m).take(self.len());
        self.kind == other.kind
            && self.steps == other.steps
            && self.open == other.open
            && self.wall_m == other.wall_m
            && places.map(|(a, b)| (a - b).abs()).all(|off| off < RIGHT_M)
    }

    /// Number of risers.
    pub fn len(&self) -> usize {
        usize::from(self.steps).min(MAX_STEPS)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.steps == 0
    }

    /// Place of riser `k`, metres; infinitely far off beyond the last.
    pub fn x(&self, k: usize) -> f32 {
        if k < self.len() {
            self.x_m.get(k).copied().unwrap_or(f32::INFINITY)
        } else {
            f32::INFINITY
        }
    }

    /// Level of the tread before riser `k`, metres.
    pub fn level(&self, k: usize) -> f32 {
        let below = k.checked_sub(1).and_then(|k| self.top_m.get(k));
        below.copied().unwrap_or(0.0)
    }

    /// The last riser's place, metres; the mirror's without any.
    pub fn last_x(&self) -> f32 {
        self.len().checked_sub(1).map_or(0.0, |k| self.x(k))
    }

    /// From riser to riser on the mean, metres, landings left out; none for a single one.
    pub fn going(&self) -> Option<f32> {
        let (mut sum, mut spans) = (0.0, 0.0);
        for k in 1..self.len() {
            let going_m = self.x(k) - self.x(k - 1);
            if going_m < number::GOINGS_M.1 {
                sum += going_m;
                spans += 1.0;
            }
        }
        (spans > 0.0).then(|| sum / spans)
    }

    /// Height of a riser on the mean, metres.
    pub fn rise(&self) -> f32 {
        self.level(self.len()) / self.len().max(1) as f32
    }

    /// The same with a riser at `x_m` whose top is at `top_m`, as number `k`; itself if it has as
    /// many as it can.
    #[inline(never)]
    pub fn with(&self, k: usize, x_m: f32, top_m: f32) -> Self {
        let mut out = *self;
        let n = self.len();
        if n >= MAX_STEPS || k > n {
            return out;
        }
        out.kind = GroundKind::Stairs;
        out.steps = (n + 1) as u8;
        for (places, value) in [(&mut out.x_m, x_m), (&mut out.top_m, top_m)] {
            let mut moved = value;
            for place in places.iter_mut().take(n + 1).skip(k) {
                core::mem::swap(place, &mut moved);
            }
        }
        out
    }

    /// The same without its last riser.
    pub fn less_last(&self) -> Self {
        let mut out = *self;
        out.steps = self.steps.saturating_sub(1);
        if out.steps == 0 {
            out = Self {
                wall_m: self.wall_m,
                ..Self::nothing()
            };
        }
        out
    }

    /// Steps going down: where each edge is, metres, and the level of the tread below it, one below the other.
    pub fn descent(edges: impl Iterator<Item = (f32, f32)>) -> Self {
        let mut out = Self::nothing();
        let places = out.x_m.iter_mut().zip(&mut out.top_m);
        for ((x_m, y_m), edge) in places.zip(edges) {
            (*x_m, *y_m) = edge;
            out.kind = GroundKind::Descent;
            out.steps += 1;
        }
        out
    }

    /// The edges that count as steps, the nearest first.
    pub fn edges(&self, view: &View) -> impl Iterator<Item = Edge> + '_ {
        let counts = match self.kind {
            GroundKind::Stairs | GroundKind::Descent => self.len(),
            _ => 0,
        };
        let down = self.kind == GroundKind::Descent;
        let overhang_m = if self.open { 0.0 } else { self.overhang_m };
        let (open, view) = (self.open, *view);
        let mut hidden = f32::NEG_INFINITY;
        let places = self.x_m.iter().zip(&self.top_m).take(counts);
        places.enumerate().map(move |(k, (&x_m, &y_m))| {
            let x_m = x_m - overhang_m;
            let seen = if down {
                self.shows_below(k, &view)
            } else {
                let up_m = y_m - view.height_m;
                let slope = up_m / math::max(x_m, RIGHT_M);
                let in_front = slope >= hidden;
                if !open {
                    hidden = math::max(hidden, slope);
                }
                in_front && view.shows(slope, math::hypot(x_m, up_m))
            };
            Edge { x_m, y_m, seen }
        })
    }

    /// Whether edge `k` of stairs going down is in sight, and with it some of the tread below.
    fn shows_below(&self, k: usize, view: &View) -> bool {
        let x_m = self.x(k);
        let above_m = view.height_m - self.level(k);
        let below_m = view.height_m - self.level(k + 1);
        let begins_m = tread_begins_m(x_m, below_m / above_m);
        view.shows(x_m / above_m, math::hypot(x_m, above_m)) && begins_m < self.x(k + 1)
    }

    /// Where this, if it is true with levels known to `sigmas`, makes an answer wrong: steps that are
    /// missing, made up, or off by more than their expanded uncertainty, and a drop that is missing or made up.
    #[inline(never)]
    pub fn conflicts(
        &self,
        told: &[ToldStep],
        drop: Option<ToldDrop>,
        view: &View,
        sigmas: &Sigmas,
    ) -> Conflicts {
        let mut conflicts = Conflicts::new();
        let mut used = [false; MAX_STEPS];
        let mut push = |x_m, probability| {
            // One for each step.
            let _ = conflicts.push(Conflict { x_m, probability });
        };
        for (edge, &sigma_m) in self.edges(view).zip(sigmas) {
            let off = |t: &ToldStep| (t.x_m - edge.x_m).abs();
            let near = told.iter().zip(&mut used);
            let near = near.filter(|(t, used)| !**used && off(t) <= SAME_M);
            match near.min_by(|a, b| off(a.0).total_cmp(&off(b.0))) {
                Some((t, used)) => {
                    *used = true;
                    if !edge.seen {
                        continue;
                    }
                    if off(t) > t.x_within_m {
                        push(math::min(edge.x_m, t.x_m), 1.0);
                    } else {
                        let x_m = math::min(edge.x_m, t.x_m);
                        push(x_m, outside(t.y_m - edge.y_m, sigma_m, t.y_within_m));
                    }
                }
                None if edge.seen => push(edge.x_m, 1.0),
                None => {}
            }
        }
        for (t, used) in told.iter().zip(&used) {
            if !used {
                push(t.x_m, 1.0);
            }
        }
        let real = match self.kind {
            GroundKind::Drop { at_m } => Some(at_m),
            _ => None,
        };
        match (real, drop) {
            (Some(at_m), Some(told)) if told.covers(at_m) => {}
            (Some(at_m), told) => push(told.map_or(at_m, |told| math::min(told.x_m, at_m)), 1.0),
            (None, Some(told)) => push(told.x_m, 1.0),
            (None, None) => {}
        }
        crate::sort::shell_sort(&mut conflicts, |a, b| a.x_m < b.x_m);
        conflicts
    }
}

/// Probability that a normal deviate of standard deviation `sigma_m` about `off_m` is farther than
/// `within_m` from 0.
fn outside(off_m: f32, sigma_m: f32, within_m: f32) -> f32 {
    let sigma_m = math::max(sigma_m, number::LEAST_SIGMA_M);
    above((within_m - off_m) / sigma_m) + above((within_m + off_m) / sigma_m)
}
