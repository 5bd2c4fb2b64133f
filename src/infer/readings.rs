//! Readings: place and height of each riser, measured from its own echoes. Which echo is which feature is given by a
//! hypothesis.

use super::gauss::Fusion;
use crate::estimate::Estimate;
use crate::math;
use crate::model::{Class, MAX_STEPS, Model, ModelEcho, Staircase};
use crate::params::posterior;
use heapless::Vec;

/// Measurements of one step (riser and tread behind it) from its own echoes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Face {
    /// Horizontal distance of the step's riser from the mirror, metres; `None` if neither its foot nor its face has an
    /// echo.
    pub foot_m: Option<f32>,
    /// Horizontal distance of the step's front edge from the mirror, metres; `None` if the edge has no echo.
    pub edge_m: Option<f32>,
    /// Weighted mean of the measured heights of the step's tread, metres above the ground.
    pub level: Fusion,
}

impl Face {
    /// Whether the nosing and the riser of the step have separate echoes.
    pub fn overhang_seen(&self) -> bool {
        self.foot_m.is_some() && self.edge_m.is_some()
    }
}

/// Measurements of all steps of a staircase.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    /// Measurements of each step, the nearest first.
    pub faces: Vec<Face, MAX_STEPS>,
    /// Weighted mean of the flight's riser height, metres, from risers whose foot is hidden.
    pub rise: Fusion,
}

impl Model<'_> {
    /// Assigns the echoes to the features of staircase `s`, measures every riser, and writes the measurements to `out`.
    #[inline(never)]
    pub fn readings(&self, s: &Staircase, out: &mut Readings) {
        out.faces.clear();
        out.rise = Fusion::default();
        for k in 0..s.len() {
            let face = self.face_of(s, k, out);
            // Cannot fail: there are as many faces as risers.
            let _ = out.faces.push(face);
        }
    }

    /// Returns the measurements of riser `k`. A corner also measures the height of the tread before the riser, and a
    /// riser with a hidden foot the riser height of the flight; both are written to `out`.
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
                // A flash measures the riser's place only: its height is always the mirror's.
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

    /// Returns the riser height of the flight, metres, from the echo of riser `k`, whose foot is hidden by the nosing
    /// before it. The echo may lie anywhere on the visible part. Both ends of that part are linear in the riser height.
    fn hidden_rise(&self, s: &Staircase, k: usize, e: &ModelEcho) -> Option<Estimate> {
        let before_m = k.checked_sub(1).map(|before| s.x(before))?;
        let distances = s.x(k) / before_m;
        let per_rise = 0.5 * (distances * k as f32 + (k + 1) as f32);
        let fixed_m = 0.5 * self.height_m * (1.0 - distances);
        let (low_m, top_m) = self.face_span(s, k);
        let span_m = math::max(top_m - low_m, posterior::MIN_FACE_M);
        let across_m = e.across_m * e.range_m / math::max(e.x_m, posterior::MIN_RANGE_M);
        // Variance of an even distribution over the visible part, of its ends, and of the echo.
        let variance = span_m * span_m * posterior::EVEN_VARIANCE
            + posterior::HIDDEN_END_M2
            + across_m * across_m;
        Some(Estimate {
            value: (e.y_m - fixed_m) / per_rise,
            variance: variance / (per_rise * per_rise),
        })
    }
}
