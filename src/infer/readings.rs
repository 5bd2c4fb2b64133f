//! Readings: what each riser's own echoes say of its place and its height, given a hypothesis that
//! says which echo is which feature.

use super::gauss::Fusion;
use crate::estimate::Estimate;
use crate::math;
use crate::model::{Class, MAX_STEPS, Model, Seen, Staircase};
use crate::params::posterior as number;
use heapless::Vec;

/// What one step's own echoes say.
#[derive(Clone, Copy, Debug, Default)]
pub struct Face {
    /// Horizontal distance of its riser, metres, where the foot or the face shows.
    pub foot_m: Option<f32>,
    /// Horizontal distance of its edge, metres, where that shows.
    pub edge_m: Option<f32>,
    /// Level of the tread, metres.
    pub level: Fusion,
}

impl Face {
    /// Whether nosing and riser show apart from each other.
    pub fn overhang_seen(&self) -> bool {
        self.foot_m.is_some() && self.edge_m.is_some()
    }
}

/// What the echoes say about all steps.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    /// Of each step, the nearest first.
    pub faces: Vec<Face, MAX_STEPS>,
    /// Of the risers' height, metres: by faces whose foot is hidden.
    pub rise: Fusion,
}

impl Model<'_> {
    /// Reads every riser's echoes as if staircase `s` stood there.
    #[inline(never)]
    pub fn readings(&self, s: &Staircase, out: &mut Readings) {
        out.faces.clear();
        out.rise = Fusion::default();
        for k in 0..s.len() {
            let face = self.face_of(s, k, out);
            // As many as the staircase has risers.
            let _ = out.faces.push(face);
        }
    }

    /// Reads riser `k`'s echoes; what a corner says of the tread before, and a hidden face of all
    /// risers, goes to `out`.
    fn face_of(&self, s: &Staircase, k: usize, out: &mut Readings) -> Face {
        let mut face = Face::default();
        self.features(s, k, |class, reading| {
            let level = Estimate::new(reading.level_m, reading.sigma_m);
            match class {
                Class::Corner => {
                    if let Some(before) = out.faces.last_mut().filter(|_| !reading.masked) {
                        before.level.add(level);
                    }
                }
                // It shows the riser's place; its height is the mirror's.
                Class::Flash => {}
                Class::Hidden => {
                    if let Some(rise) = self.hidden_rise(s, k, reading.echo) {
                        out.rise.add(rise);
                    }
                }
                _ if !reading.masked => face.level.add(level),
                _ => {}
            }
            let place = match class {
                Class::Corner | Class::Flash | Class::Hidden => &mut face.foot_m,
                _ => &mut face.edge_m,
            };
            *place = place.or(Some(reading.echo.x_m));
        });
        face
    }

    /// Height of the flight's risers from the echo of riser `k`, whose foot the nosing before hides: it lies
    /// anywhere on the visible part. Both ends of that are linear in the risers' height.
    fn hidden_rise(&self, s: &Staircase, k: usize, e: &Seen) -> Option<Estimate> {
        let before_m = k.checked_sub(1).map(|before| s.x(before))?;
        let distances = s.x(k) / before_m;
        let per_rise = 0.5 * (distances * k as f32 + (k + 1) as f32);
        let fixed_m = 0.5 * self.height_m * (1.0 - distances);
        let (low_m, top_m) = self.face_span(s, k);
        let span_m = math::max(top_m - low_m, number::LEAST_FACE_M);
        let across_m = e.across_m * e.range_m / math::max(e.x_m, number::LEAST_RANGE_M);
        // Of an even distribution, and of the ends.
        let variance =
            span_m * span_m * number::EVEN_VARIANCE + number::HIDDEN_END_M2 + across_m * across_m;
        Some(Estimate {
            value: (e.y_m - fixed_m) / per_rise,
            variance: variance / (per_rise * per_rise),
        })
    }
}
