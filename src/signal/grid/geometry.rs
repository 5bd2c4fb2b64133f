//! Position of the cells of a polar map in the sagittal plane.

use crate::config::Plane;
use crate::math;

/// Ratio of the one-way 3 dB width to the standard deviation of the two-way power pattern exp(-8 ln2
/// (t/width)²) over the angle t: sqrt(16 ln 2).
const WIDTH_PER_SIGMA: f32 = 3.330_218_4;

/// Returns the standard deviation of the two-way power pattern of a beam whose one-way 3 dB width is `width`,
/// in the same unit of angle.
pub fn two_way_sigma(width: f32) -> f32 {
    width / WIDTH_PER_SIGMA
}

/// Conversion between the cells of a map, ranges and angles, and points in the sagittal plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Range of the first stored bin from the mirror's centre, metres.
    pub first_range_m: f32,
    /// Range difference between neighbouring stored bins, metres.
    pub bin_m: f32,
    /// Height of the mirror centre above the ground, metres.
    pub mount_height_m: f32,
    /// Scheduled step of the beam's angle between neighbouring rows, radians.
    pub step_rad: f32,
    /// Full width of the beam between its one-way 3 dB points, radians.
    pub beamwidth_rad: f32,
    /// Plane in which the mirror turns the beam.
    pub plane: Plane,
}

impl Geometry {
    /// Geometry of a map without cells.
    pub(super) const EMPTY: Self = Self {
        first_range_m: 0.0,
        bin_m: 0.0,
        mount_height_m: 0.0,
        step_rad: 0.0,
        beamwidth_rad: 0.0,
        plane: Plane::Depth,
    };

    /// Returns the range of the (fractional) stored bin from the mirror's centre, metres.
    pub fn range_m(&self, bin: f32) -> f32 {
        self.first_range_m + bin * self.bin_m
    }

    /// Returns the point (x, y), metres, at `range_m` from the mirror and beam angle `angle_rad`: x forward from the
    /// mirror's centre, y up from the ground. The angle is below the horizontal (depth plane), or forward from straight
    /// down (height plane).
    pub fn point(&self, range_m: f32, angle_rad: f32) -> (f32, f32) {
        let (sin, cos) = math::sin_cos(angle_rad);
        match self.plane {
            Plane::Depth => (range_m * cos, self.mount_height_m - range_m * sin),
            Plane::Height => (range_m * sin, self.mount_height_m - range_m * cos),
        }
    }

    /// Returns range from the mirror, metres, and beam angle, radians, of the point (x, y): x forward from the mirror's
    /// centre, y up from the ground. The angle is below the horizontal (depth plane), or forward from straight down
    /// (height plane).
    pub fn polar(&self, x: f32, y: f32) -> (f32, f32) {
        let down = self.mount_height_m - y;
        let angle = match self.plane {
            Plane::Depth => math::atan2(down, x),
            Plane::Height => math::atan2(x, down),
        };
        (math::hypot(x, down), angle)
    }
}
