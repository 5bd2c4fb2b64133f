//! What else may be there: level ground, and ramps.

use super::scene::{Mark, Scene};
use crate::math;

/// Slopes of ramps tried: tan of 3.2° … 11.6° in steps of 1.2°, over which an echo's height changes
/// at a metre by two of its standard deviations.
const RAMP_SLOPES: [f32; 8] = [
    0.0559, 0.0769, 0.0981, 0.1192, 0.1405, 0.1620, 0.1835, 0.2053,
];
/// Where ramps begin, metres: the steepest misses what begins between these by less than an echo's
/// height is known.
const RAMPS_FROM_M: [f32; 8] = [0.30, 0.42, 0.54, 0.66, 0.78, 0.90, 1.02, 1.14];

impl Scene<'_> {
    /// Score of `marks` on ground that rises steadily by `slope` from `from_m` on, added to that of
    /// the marks before them; slope 0 is the flat floor.
    fn ramp(&self, marks: &[Mark], from_m: f32, slope: f32, before: f32) -> f32 {
        let p = self.params;
        let mut total = before;
        for m in marks {
            let z = (m.y_m - slope * math::max(m.x_m - from_m, 0.0)) / m.y_sigma_m;
            let on = p.tread_nats - 0.5 * z * z;
            total += m.weight
                * if on > 0.0 {
                    on
                } else if z < -2.0 {
                    -p.inside_nats
                } else {
                    -p.stray_nats
                };
        }
        total
    }

    /// Score of the best ramp or flat floor, nats.
    pub fn best_ramp(&self) -> f32 {
        let p = self.params;
        let (mut flat, mut rest) = (0.0, self.between(p.nearest_riser_m, f32::INFINITY));
        let mut best = f32::NEG_INFINITY;
        for from in RAMPS_FROM_M {
            let split = rest.partition_point(|m| m.x_m <= from);
            let (before, behind) = rest.split_at_checked(split).unwrap_or((rest, &[]));
            (flat, rest) = (self.ramp(before, 0.0, 0.0, flat), behind);
            for slope in RAMP_SLOPES.into_iter().filter(|_| p.rules.ramps) {
                best = math::max(best, self.ramp(rest, from, slope, flat));
            }
        }
        math::max(best, self.ramp(rest, 0.0, 0.0, flat))
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
