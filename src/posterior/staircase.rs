//! A staircase as a hypothesis: where its risers stand and how high their tops are.

use crate::math;

/// Most risers of a staircase.
pub const MAX_STEPS: usize = 10;
/// Two steps are the same within this distance, metres: design contract of scoring.
const SAME_M: f32 = 0.10;
/// Tangents of the angles below and above the horizontal between which an edge can be seen: the
/// scanned sector less half a beam.
const LOWEST_SIGHT: f32 = -1.09;
/// See [`LOWEST_SIGHT`].
const HIGHEST_SIGHT: f32 = 0.315;
/// Farthest edge that is seen, metres from the mirror.
const FARTHEST_M: f32 = 2.67;

/// What stands there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Level ground, and perhaps a wall.
    #[default]
    Nothing,
    /// Ground that rises steadily.
    Ramp,
    /// Steps.
    Stairs,
    /// One thing too tall to climb.
    Box,
    /// One thing too low for a step.
    Threshold,
}

/// A staircase, or what else may be there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Staircase {
    /// What it is.
    pub kind: Kind,
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
    /// Where a wall stands behind, metres; infinitely far off for none. Of a ramp, where it begins.
    pub wall_m: f32,
    /// Slope of a ramp.
    pub slope: f32,
}

impl Staircase {
    /// Level ground.
    pub fn nothing() -> Self {
        Self {
            wall_m: f32::INFINITY,
            ..Self::default()
        }
    }

    /// Number of risers.
    pub fn len(&self) -> usize {
        usize::from(self.steps).min(MAX_STEPS)
    }

    /// Place of riser `k`, metres; infinitely far off beyond the last.
    pub fn x(&self, k: usize) -> f32 {
        if k < self.len() {
            self.x_m.get(k).copied().unwrap_or(f32::INFINITY)
        } else {
            f32::INFINITY
        }
    }

    /// Level behind riser `k - 1`, metres: of the tread before riser `k`.
    pub fn level(&self, k: usize) -> f32 {
        let below = k.checked_sub(1).and_then(|k| self.top_m.get(k));
        below.copied().unwrap_or(0.0)
    }

    /// The same with a riser at `x_m` whose top is at `top_m`, as number `k`; itself if it has as
    /// many as it can.
    pub fn with(&self, k: usize, x_m: f32, top_m: f32) -> Self {
        let mut out = *self;
        let n = self.len();
        if n >= MAX_STEPS || k > n {
            return out;
        }
        out.kind = Kind::Stairs;
        out.steps = (n + 1) as u8;
        for (places, value) in [(&mut out.x_m, x_m), (&mut out.top_m, top_m)] {
            if let Some(rest) = places.get_mut(k..=n) {
                rest.rotate_right(1);
                if let Some(first) = rest.first_mut() {
                    *first = value;
                }
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

    /// Edges that count as steps: distance and height, and whether they can be seen from `height_m`.
    pub fn edges(&self, height_m: f32) -> impl Iterator<Item = (f32, f32, bool)> + '_ {
        let counts = if self.kind == Kind::Stairs {
            self.len()
        } else {
            0
        };
        let mut hidden = f32::NEG_INFINITY;
        self.x_m
            .iter()
            .zip(&self.top_m)
            .take(counts)
            .map(move |(&x_m, &y_m)| {
                let x_m = if self.open { x_m } else { x_m - self.overhang_m };
                let slope = (y_m - height_m) / math::max(x_m, 0.05);
                let seen = slope > LOWEST_SIGHT
                    && slope < HIGHEST_SIGHT
                    && slope >= hidden - 1e-6
                    && math::hypot(x_m, y_m - height_m) < FARTHEST_M;
                if !self.open {
                    hidden = math::max(hidden, slope);
                }
                (x_m, y_m, seen)
            })
    }

    /// From which distance on this, if it is true, makes an answer wrong: a step that is missing, made
    /// up, or farther off than `right_m`. Infinite if nowhere.
    pub fn contradicts(&self, told: &[(f32, f32)], height_m: f32, right_m: f32) -> f32 {
        let mut bad = f32::INFINITY;
        let mut used = [false; MAX_STEPS];
        for (x_m, y_m, seen) in self.edges(height_m) {
            let near = told.iter().zip(&used).enumerate();
            let near = near.filter(|(_, ((x, _), used))| !**used && (x - x_m).abs() <= SAME_M);
            let best = near.min_by(|a, b| (a.1.0.0 - x_m).abs().total_cmp(&(b.1.0.0 - x_m).abs()));
            match best {
                Some((j, ((x, y), _))) => {
                    let off = (x - x_m).abs() > right_m || (y - y_m).abs() > right_m;
                    if seen && off {
                        bad = math::min(bad, math::min(x_m, *x));
                    }
                    if let Some(used) = used.get_mut(j) {
                        *used = true;
                    }
                }
                None if seen => bad = math::min(bad, x_m),
                None => {}
            }
        }
        for ((x, _), used) in told.iter().zip(&used) {
            if !used {
                bad = math::min(bad, *x);
            }
        }
        bad
    }
}
