//! A hypothesis about the scene: distances and top levels of a staircase's risers, or an alternative.

use super::kinds::{FirstRise, GroundKind};
use super::normal::above;
use super::sight::tread_begins_m;
use super::surfaces::Surfaces;
use crate::answer::{Direction, Step};
use crate::config::Plane;
use crate::estimate::COVERAGE_FACTOR;
pub use crate::estimate::MIN_EXPANDED_M;
use crate::estimate::{MAX_EXPANDED_M, expanded};
use crate::math;
use crate::params::posterior;
use crate::signal::grid::PolarMap;
use heapless::Vec;

/// Maximum number of risers of a staircase.
pub const MAX_STEPS: usize = 10;
/// Maximum distance between two steps that count as the same, such as a reported and a true one, metres: design
/// contract of scoring.
pub const SAME_M: f32 = 0.10;

/// A staircase, or another hypothesis about the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Staircase {
    /// Kind of the hypothesis.
    pub kind: GroundKind,
    /// Number of risers; going down, of edges.
    pub steps: u8,
    /// Whether the treads are open (no risers).
    pub open: bool,
    /// Distance by which the nosings stand before their risers, metres.
    pub overhang_m: f32,
    /// Distance of each riser (going down: of each edge) from the mirror, metres, the nearest first; only the first
    /// `steps` entries count.
    pub x_m: [f32; MAX_STEPS],
    /// Height above the ground of each riser's top (going down: of the tread below each edge), metres; only the first
    /// `steps` entries count.
    pub top_m: [f32; MAX_STEPS],
    /// Distance of a wall behind the risers, or on bare ground, from the mirror, metres; infinite for none.
    pub wall_m: f32,
}

/// Standard deviation of the height of each tread of a staircase, metres, in the order of the risers.
pub type Sigmas = [f32; MAX_STEPS];

/// Field of view of the scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Plane in which the mirror scans.
    pub plane: Plane,
    /// Height of the mirror above the ground at the scan, metres.
    pub height_m: f32,
    /// Tangent of the lowest angle at which an edge is visible: the limit of the scanned sector less half a beam.
    /// Angles are above the horizontal in the depth plane, and forward of the vertical in the height plane.
    pub lowest: f32,
    /// Tangent of the highest angle at which an edge is visible, measured as for `lowest`.
    pub highest: f32,
    /// Maximum range of a visible edge, metres from the mirror.
    pub farthest_m: f32,
}

impl View {
    /// Whether an object at range `range_m`, metres, on a sight line whose angle has this tangent, is visible.
    fn is_visible(&self, tangent: f32, range_m: f32) -> bool {
        tangent > self.lowest && tangent < self.highest && range_m < self.farthest_m
    }
}

/// Number of range bins at the far end of the map in which no peak can be found.
const UNSEEN_BINS: f32 = 8.0;

impl View {
    /// Empty field of view.
    pub const NOTHING: Self = Self {
        plane: Plane::Depth,
        height_m: 0.0,
        lowest: 0.0,
        highest: 0.0,
        farthest_m: 0.0,
    };

    /// Returns the field of view of a map: its outermost rows less half a beam, and its bins less those without a
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
    /// Horizontal distance of the edge from the mirror, metres.
    pub x_m: f32,
    /// Height above the ground of the tread above the riser (going down: below the edge), metres.
    pub y_m: f32,
    /// Whether the scan can see the edge.
    pub seen: bool,
}

/// A step of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportedStep {
    /// Horizontal distance of the step from the mirror, metres.
    pub x_m: f32,
    /// Height of the step's tread above the ground, metres; negative going down.
    pub y_m: f32,
    /// Expanded uncertainty (3σ, within limits) of the step's distance, metres.
    pub x_within_m: f32,
    /// Expanded uncertainty (3σ, within limits) of the step's height, metres.
    pub y_within_m: f32,
}

impl ReportedStep {
    /// Returns the place of a step, with expanded uncertainties from its standard deviations: at most 8 cm each.
    pub fn of(step: &Step) -> Self {
        let within = |sigma_m| math::min(expanded(sigma_m), MAX_EXPANDED_M);
        Self {
            x_m: step.distance_m,
            y_m: step.height_m,
            x_within_m: within(step.distance_sigma_m),
            y_within_m: within(step.height_sigma_m),
        }
    }
}

/// A drop of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReportedDrop {
    /// Horizontal distance of the drop from the mirror, metres.
    pub x_m: f32,
    /// Maximum difference of distance at which another drop counts as the reported one, metres.
    pub within_m: f32,
}

impl ReportedDrop {
    /// Returns the reported drop at a distance, metres, with a permitted error of three times its standard deviation,
    /// and at least 10 cm.
    pub fn new(x_m: f32, sigma_m: f32) -> Self {
        let within_m = math::max(SAME_M, COVERAGE_FACTOR * sigma_m);
        Self { x_m, within_m }
    }

    /// Whether a drop at a distance, metres, counts as the reported one.
    pub fn covers(&self, x_m: f32) -> bool {
        (self.x_m - x_m).abs() <= self.within_m
    }
}

/// Place at which an answer is wrong if a staircase is true, and the probability of that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conflict {
    /// Horizontal distance from the mirror at which the answer is wrong, metres.
    pub x_m: f32,
    /// Probability that the answer is wrong there if the staircase is true.
    pub probability: f32,
}

/// Conflicts of a hypothesis with an answer, the nearest first: at most one for each step of either, and one for a
/// drop.
pub type Conflicts = Vec<Conflict, { 2 * MAX_STEPS + 1 }>;

impl Staircase {
    /// Returns level ground.
    pub fn nothing() -> Self {
        Self {
            wall_m: f32::INFINITY,
            ..Self::default()
        }
    }

    /// Returns a hypothesis of this kind, without risers and without a wall.
    pub fn of(kind: GroundKind) -> Self {
        Self {
            kind,
            ..Self::nothing()
        }
    }

    /// Returns ground with a slope that begins at a distance, metres.
    pub fn ramp(from_m: f32, slope: f32) -> Self {
        Self::of(GroundKind::Ramp { from_m, slope })
    }

    /// Returns ground that ends at a distance, metres.
    pub fn drop(at_m: f32) -> Self {
        Self::of(GroundKind::Drop { at_m })
    }

    /// Returns the log-likelihood ratio of the hypothesis to ground that goes on, by its nearest riser, wall or end, from
    /// the power along the ground's line, nats.
    #[inline(never)]
    pub fn ground_line(&self, line: &Surfaces) -> f32 {
        let first = FirstRise {
            x_m: self.x(0),
            open: self.open,
            wall_m: self.wall_m,
        };
        self.kind.ground_line(line, first)
    }

    /// Whether another hypothesis is of the same kind and build, has its risers in the same places (within 3 cm), and
    /// the same wall behind.
    pub fn is_like(&self, other: &Self) -> bool {
        let places = self.x_m.iter().zip(&other.x_m).take(self.len());
        self.kind == other.kind
            && self.steps == other.steps
            && self.open == other.open
            && self.wall_m == other.wall_m
            && places
                .map(|(a, b)| (a - b).abs())
                .all(|off| off < MIN_EXPANDED_M)
    }

    /// Returns the number of risers.
    pub fn len(&self) -> usize {
        usize::from(self.steps).min(MAX_STEPS)
    }

    /// Whether the hypothesis has no risers.
    pub fn is_empty(&self) -> bool {
        self.steps == 0
    }

    /// Returns the distance of riser `k`, metres; infinity beyond the last one.
    pub fn x(&self, k: usize) -> f32 {
        if k < self.len() {
            self.x_m.get(k).copied().unwrap_or(f32::INFINITY)
        } else {
            f32::INFINITY
        }
    }

    /// Returns the height above the ground of the tread before riser `k`, metres; with `k` the number of risers, that
    /// of the landing.
    pub fn level(&self, k: usize) -> f32 {
        let below = k.checked_sub(1).and_then(|k| self.top_m.get(k));
        below.copied().unwrap_or(0.0)
    }

    /// Returns the distance of the last riser, metres; 0 without risers.
    pub fn last_x(&self) -> f32 {
        self.len().checked_sub(1).map_or(0.0, |k| self.x(k))
    }

    /// Returns the mean going without landings, metres; none for a single riser.
    pub fn going(&self) -> Option<f32> {
        let (mut sum, mut spans) = (0.0, 0.0);
        for k in 1..self.len() {
            let going_m = self.x(k) - self.x(k - 1);
            if going_m < posterior::GOINGS_M.high {
                sum += going_m;
                spans += 1.0;
            }
        }
        (spans > 0.0).then(|| sum / spans)
    }

    /// Returns the distance at which the goings beside those to riser `k` put it, metres; none without such goings, or
    /// beside a landing.
    pub fn regular_x(&self, k: usize) -> Option<f32> {
        let n = self.len();
        let going = |i: usize| self.x(i) - self.x(i - 1);
        let regular = |i: &usize| going(*i) < posterior::GOINGS_M.high;
        let others = (1..n).filter(regular).filter(|&i| i != k && i != k + 1);
        let count = others.clone().count();
        if count == 0 {
            return None;
        }
        let mean = others.map(going).sum::<f32>() / count as f32;
        match (k.checked_sub(1), k + 1 < n) {
            (Some(before), true) => {
                let span = self.x(k + 1) - self.x(before);
                ((span - 2.0 * mean).abs() < mean / 2.0).then(|| self.x(before) + span / 2.0)
            }
            (Some(before), false) => Some(self.x(before) + mean),
            (None, _) => Some(self.x(1) - mean),
        }
    }

    /// Returns the mean riser height, metres; negative going down, 0 without risers.
    pub fn rise(&self) -> f32 {
        self.level(self.len()) / self.len().max(1) as f32
    }

    /// Returns the staircase with a riser inserted as number `k`, at `x_m` and with its top at `top_m`, metres. A
    /// full staircase is returned unchanged.
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

    /// Returns the staircase without its last riser.
    pub fn without_last(&self) -> Self {
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

    /// Returns steps going down, given as the distance of each edge from the mirror and the height above the ground of
    /// the tread below it, metres, from the top down.
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

    /// Returns the edges that count as steps, the nearest first.
    pub fn edges(&self, view: &View) -> impl Iterator<Item = Edge> + '_ {
        let (counts, down) = match self.kind.direction() {
            Direction::None => (0, false),
            Direction::Up => (self.len(), false),
            Direction::Down => (self.len(), true),
        };
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
                let slope = up_m / math::max(x_m, MIN_EXPANDED_M);
                let in_front = slope >= hidden;
                if !open {
                    hidden = math::max(hidden, slope);
                }
                in_front && view.is_visible(slope, math::hypot(x_m, up_m))
            };
            Edge { x_m, y_m, seen }
        })
    }

    /// Whether edge `k` of stairs going down is visible together with a part of the tread below it.
    fn shows_below(&self, k: usize, view: &View) -> bool {
        let x_m = self.x(k);
        let above_m = view.height_m - self.level(k);
        let below_m = view.height_m - self.level(k + 1);
        let begins_m = tread_begins_m(x_m, below_m / above_m);
        view.is_visible(x_m / above_m, math::hypot(x_m, above_m)) && begins_m < self.x(k + 1)
    }

    /// Returns the places, the nearest first, at which this hypothesis, if it is true, makes an answer wrong: steps
    /// that are missing, false, or off by more than their expanded uncertainty, and a missing or false drop. `sigmas`
    /// are the standard deviations of the heights of this hypothesis's treads, metres.
    #[inline(never)]
    pub fn conflicts(
        &self,
        reported: &[ReportedStep],
        drop: Option<ReportedDrop>,
        view: &View,
        sigmas: &Sigmas,
    ) -> Conflicts {
        let mut conflicts = Conflicts::new();
        let mut used = [false; MAX_STEPS];
        let mut push = |x_m, probability| {
            // Cannot fail: there is at most one conflict for each step and for a drop.
            let _ = conflicts.push(Conflict { x_m, probability });
        };
        for (edge, &sigma_m) in self.edges(view).zip(sigmas) {
            let off = |t: &ReportedStep| (t.x_m - edge.x_m).abs();
            let near = reported.iter().zip(&mut used);
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
                        push(
                            x_m,
                            exceedance_probability(t.y_m - edge.y_m, sigma_m, t.y_within_m),
                        );
                    }
                }
                None if edge.seen => push(edge.x_m, 1.0),
                None => {}
            }
        }
        for (t, used) in reported.iter().zip(&used) {
            if !used {
                push(t.x_m, 1.0);
            }
        }
        match (self.kind.end_m(), drop) {
            (Some(at_m), Some(reported)) if reported.covers(at_m) => {}
            (Some(at_m), reported) => push(
                reported.map_or(at_m, |reported| math::min(reported.x_m, at_m)),
                1.0,
            ),
            (None, Some(reported)) => push(reported.x_m, 1.0),
            (None, None) => {}
        }
        crate::sort::shell_sort(&mut conflicts, |a, b| a.x_m < b.x_m);
        conflicts
    }
}

/// Returns the probability that a normal variable of mean `off_m` and standard deviation `sigma_m` exceeds `within_m`
/// in magnitude.
fn exceedance_probability(off_m: f32, sigma_m: f32, within_m: f32) -> f32 {
    let sigma_m = math::max(sigma_m, posterior::MIN_SIGMA_M);
    above((within_m - off_m) / sigma_m) + above((within_m + off_m) / sigma_m)
}
