//! Angles of the image's rows, and the matched filter between them and the map's rows.

use crate::math;
use crate::signal::grid::{Geometry, MAX_BINS, PolarMap};

/// Ratio of the one-way 3 dB width to the standard deviation of the two-way pattern in voltage: √(8 ln 2).
const WIDTH_PER_SIGMA: f32 = 2.354_82;
/// Spacing of the nodes, in widths of the beam: 0.42 of a lobe's standard deviation behind the filter. Sampled so, a
/// Gaussian lobe is reproduced to better than 1e-10 of its power.
const SPACING: f32 = 0.25;
/// Extent of the filter to each side, in standard deviations of the pattern: beyond it lies 0.07 % of its energy.
const REACH: f32 = 2.4;
/// Maximum number of nodes whose filters overlap one row: 2 · [`REACH`] deviations over the spacing, and one.
pub const MAX_OPEN: usize = 9;
/// Maximum number of nodes of an image.
pub const MAX_NODES: usize = 256;
/// Fewest bins of a map, over which the number of nodes is bounded.
const _: () = assert!(MAX_NODES <= u16::MAX as usize && MAX_BINS <= 256);

/// Angles of an image's nodes, and the filter that joins the rows around each.
#[derive(Clone, Copy, Debug)]
pub struct Nodes {
    first_rad: f32,
    spacing_rad: f32,
    count: usize,
    /// Standard deviation of the two-way pattern in voltage, radians.
    sigma_rad: f32,
    /// Filter's weight at its middle: 1 / ‖g‖.
    peak: f32,
}

impl Nodes {
    /// No nodes.
    pub const EMPTY: Self = Self {
        first_rad: 0.0,
        spacing_rad: 0.0,
        count: 0,
        sigma_rad: 0.0,
        peak: 0.0,
    };

    /// Returns the nodes of a scan with the shape of `map`, at most `most`: with more, they lie farther apart.
    pub fn of(map: &PolarMap, most: usize) -> Self {
        let geometry = map.geometry();
        let Some(last) = map.rows().checked_sub(1).filter(|_| most > 1) else {
            return Self::EMPTY;
        };
        let first_rad = map.angle_rad(0);
        let span = math::max(map.angle_rad(last) - first_rad, 0.0);
        let most = most.min(MAX_NODES);
        let spacing_rad = math::max(
            SPACING * geometry.beamwidth_rad,
            span / (most - 1) as f32 + f32::EPSILON,
        );
        let sigma_rad = geometry.beamwidth_rad / WIDTH_PER_SIGMA;
        Self {
            first_rad,
            spacing_rad,
            // The cast saturates.
            count: (math::floor(span / spacing_rad) as usize + 1).min(most),
            sigma_rad,
            peak: 1.0 / math::sqrt(energy(geometry)),
        }
    }

    /// Returns the number of nodes.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the angle of node `j`, which may be fractional, radians.
    pub fn angle_rad(&self, j: f32) -> f32 {
        self.first_rad + j * self.spacing_rad
    }

    /// Returns the (fractional) node at an angle, radians.
    pub fn at(&self, angle_rad: f32) -> f32 {
        (angle_rad - self.first_rad) / self.spacing_rad
    }

    /// Returns the standard deviation of a point's lobe in voltage behind the filter, nodes.
    pub fn lobe_sigma(&self) -> f32 {
        self.sigma_rad * core::f32::consts::SQRT_2 / self.spacing_rad
    }

    /// Returns the standard deviation of the two-way pattern in voltage, radians.
    pub fn sigma_rad(&self) -> f32 {
        self.sigma_rad
    }

    /// Returns the nodes whose filter reaches a row at this angle: the first, and the one behind the last.
    pub fn around(&self, angle_rad: f32) -> (usize, usize) {
        let (at, reach) = (
            self.at(angle_rad),
            REACH * self.sigma_rad / self.spacing_rad,
        );
        // The casts saturate.
        let first = math::max(math::ceil(at - reach), 0.0) as usize;
        let end = math::max(math::floor(at + reach) + 1.0, 0.0) as usize;
        (first, end.min(self.count).min(first + MAX_OPEN))
    }

    /// Returns the filter's weight for a row at `angle_rad` in node `j`.
    pub fn weight(&self, j: usize, angle_rad: f32) -> f32 {
        let t = (angle_rad - self.angle_rad(j as f32)) / self.sigma_rad;
        self.peak * math::exp(-0.5 * t * t)
    }
}

/// Returns Σg² over all rows, the gain in power of a point over one cell: √π s / step.
pub fn energy(geometry: &Geometry) -> f32 {
    const SQRT_PI: f32 = 1.772_453_9;
    let sigma = geometry.beamwidth_rad / WIDTH_PER_SIGMA;
    math::max(
        SQRT_PI * sigma / math::max(geometry.step_rad, f32::MIN_POSITIVE),
        1.0,
    )
}
