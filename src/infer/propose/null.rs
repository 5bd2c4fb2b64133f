//! Ground without stairs, as the search scores it: level ahead, level or falling below.

use super::scene::{Mark, Scene};
use crate::math;

impl Scene<'_> {
    /// Score of level ground, nats.
    pub fn flat(&self) -> f32 {
        let p = self.params;
        let on_ground = |m: &Mark| {
            let z = m.y_m / m.y_sigma_m;
            let on = p.tread_nats - 0.5 * z * z;
            let nats = if on > 0.0 {
                on
            } else if z < -2.0 {
                -p.inside_nats
            } else {
                -p.stray_nats
            };
            m.weight * nats
        };
        let marks = self.between(p.nearest_riser_m, f32::INFINITY);
        marks.iter().map(on_ground).sum()
    }

    /// Score of ground that falls steadily by `slope` from `from_m` on, seen in the height plane.
    pub fn falling_ramp(&self, from_m: f32, slope: f32) -> f32 {
        let p = self.params;
        let scores = self.marks.iter().map(|m| {
            let z = (m.y_m + math::max(m.x_m - from_m, 0.0) * slope) / m.y_sigma_m;
            m.weight * math::max(p.lower_tread_nats - 0.5 * z * z, -p.lower_stray_nats)
        });
        scores.sum()
    }
}
