//! Looks at a surface: from a place on it to what the coherent image shows there.

use super::chart::Chart;
use super::power::{DEPTHS_M, Power, RangeCell};
use crate::math;
use crate::signal::image::Look;

/// Minimum squared cosine of a line's angle below the horizontal: no scan looks down more steeply.
const STEEPEST: f32 = 0.1;

/// An image with mirror height and angles, from which the powers along its lines are computed.
pub(super) struct Gaze<'c> {
    pub(super) chart: &'c Chart<'c>,
    pub(super) height_m: f32,
    first_rad: f32,
    step_rad: f32,
}

impl<'c> Gaze<'c> {
    pub(super) fn new(chart: &'c Chart<'c>) -> Self {
        let geometry = chart.map.geometry();
        Self {
            chart,
            height_m: geometry.mount_height_m - chart.height_m,
            first_rad: chart.map.angle_rad(0) - chart.bias_rad,
            step_rad: math::max(geometry.step_rad, f32::MIN_POSITIVE),
        }
    }

    /// Returns the line powers of the range cell at `range_m`, metres.
    #[inline(never)]
    pub(super) fn cell(&self, range_m: f32) -> RangeCell {
        let line = |y_m: f32| {
            let look = self.look(range_m, y_m);
            look.map_or(Power::DARK, |(look, _)| {
                Power::new(look.power, look.background)
            })
        };
        RangeCell {
            ground: line(0.0),
            lower: DEPTHS_M.map(|depth_m| line(-depth_m)),
        }
    }

    /// Returns what the image shows at range `range_m` of a surface at height `y_m` above the ground, metres, and the stored bin
    /// and the angle, radians, in which it was seen.
    #[inline(never)]
    pub(super) fn look(&self, range_m: f32, y_m: f32) -> Option<(Look, (usize, f32))> {
        let (bin, row) = self.place(range_m, y_m)?;
        let angle_rad = self.first_rad + self.chart.bias_rad + row * self.step_rad;
        Some((self.chart.image.look(bin, angle_rad)?, (bin, angle_rad)))
    }

    /// Returns range bin and (fractional) row in which a surface at height `y_m` above the ground, metres, was seen;
    /// `range_m` is its range from the mirror's present position. `None` if the line of sight is too steep.
    fn place(&self, range_m: f32, y_m: f32) -> Option<(usize, f32)> {
        let geometry = self.chart.map.geometry();
        let level_m = self.height_m - y_m;
        let squared = range_m * range_m - level_m * level_m;
        if squared < STEEPEST * range_m * range_m {
            return None;
        }
        let x_m = self.chart.bend.reach_m(range_m, level_m);
        let down_m = level_m - self.chart.bend.height_m(x_m);
        let row_of = |x_m: f32| (math::atan2(down_m, x_m) - self.first_rad) / self.step_rad;
        // Where the chair was and how it pitched while it looked there.
        let (x_m, row) = self.chart.ride.map_or((x_m, row_of(x_m)), |ride| {
            let at = ride.at(row_of(x_m));
            let x_m = x_m + ride.end().travel_m - at.travel_m;
            (x_m, row_of(x_m) + at.pitch_rad / self.step_rad)
        });
        let bin = (math::hypot(x_m, down_m) - geometry.first_range_m) / geometry.bin_m;
        // `as` saturates, and beyond the last bin nothing has arrived.
        Some((math::round(bin) as usize, row))
    }
}
