//! Antenna pattern of the beam that leaves the mirror.

use core::f64::consts::{LN_2, PI};

use super::maths::{amplitude, power};

/// One-way amplitude pattern in the plane that the mirror sweeps, and across it.
///
/// In the plane: Taylor's one-parameter pattern (Hansen, Phased Array Antennas, sec. 3.2), F(u) =
/// sinh π√(B²-u²) / (π√(B²-u²)) within the main lobe and its sine beyond. B follows from the first
/// side lobe. A constant power floor stands for scattering by the mirror's surface errors. Across
/// the plane: a Gaussian of the same 3 dB width, because side lobes there would only widen echoes
/// that are already extended.
#[derive(Clone, Debug)]
pub struct Beam {
    parameter: f64,
    peak: f64,
    u_per_sine: f64,
    floor: f64,
    lateral_rad: f64,
    /// In-plane amplitude, 1 at the peak: entry k is that at k · [`GRAIN`] radians off the axis. Tabulated because a
    /// scan evaluates it a million times.
    table: Vec<f64>,
}

/// Step of the amplitude table, radians. Linear interpolation between its entries is exact to 1e-5 of the peak for the
/// narrowest beam.
const GRAIN: f64 = 5e-5;

/// Level of the first side lobe of a uniform line source, dB below its peak.
const UNIFORM_SIDELOBE_DB: f64 = 13.26;

impl Beam {
    /// Creates a beam `width_deg` wide between its half-power points in the plane and `lateral_deg` across it.
    /// `sidelobe_db` is the level of the first side lobe and `floor_db` that of the power floor, both dB below the
    /// peak.
    pub fn new(width_deg: f64, lateral_deg: f64, sidelobe_db: f64, floor_db: f64) -> Self {
        let parameter = taylor_parameter(sidelobe_db);
        let peak = lobe(parameter * parameter);
        let mut beam = Self {
            parameter,
            peak,
            u_per_sine: 1.0,
            floor: power(-floor_db),
            lateral_rad: lateral_deg.to_radians(),
            table: Vec::new(),
        };
        // The half-power point over u, by bisection: the pattern is monotonic in the main lobe.
        let (mut low, mut high) = (0.0, (1.0 + parameter * parameter).sqrt());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if beam.pattern(middle) > amplitude(-10.0 * core::f64::consts::LOG10_2) {
                low = middle;
            } else {
                high = middle;
            }
        }
        beam.u_per_sine = low / libm::sin(0.5 * width_deg.to_radians());
        let entries = (0.5 * PI / GRAIN) as usize;
        beam.table = (0..=entries)
            .map(|k| beam.exactly(k as f64 * GRAIN))
            .collect();
        beam
    }

    /// Returns the one-way amplitude in the plane over Taylor's variable u, without the floor, 1 at the peak.
    fn pattern(&self, u: f64) -> f64 {
        lobe(self.parameter * self.parameter - u * u) / self.peak
    }

    fn exactly(&self, angle: f64) -> f64 {
        let f = self.pattern(libm::sin(angle) * self.u_per_sine);
        (f * f + self.floor * (1.0 - f * f).max(0.0)).sqrt()
    }

    /// Returns the one-way amplitude `angle` radians off the axis in the plane, 1 at the peak.
    pub fn in_plane(&self, angle: f64) -> f64 {
        let at = angle.abs() * (1.0 / GRAIN);
        let k = at as u32;
        match self.table.get(k as usize..k as usize + 2) {
            Some([here, next]) => here + (next - here) * (at - f64::from(k)),
            _ => self.floor.sqrt(),
        }
    }

    /// Returns the one-way amplitude `angle` radians off the axis across the plane, 1 at the peak.
    pub fn lateral(&self, angle: f64) -> f64 {
        let x = 2.0 * angle / self.lateral_rad;
        libm::exp(-0.5 * LN_2 * x * x)
    }

    /// Returns the two-way amplitude across the plane as a function of the place beside it, for places `spacing` metres
    /// apart. The angle of each leg (way out, way back) is linear in that place: `legs` holds its slope, radians per
    /// metre, and its value in the plane, radians.
    pub fn lateral_pair(&self, legs: [(f64, f64); 2], spacing: f64) -> LateralPair {
        let scale = -2.0 * LN_2 / (self.lateral_rad * self.lateral_rad);
        let sum = |part: fn((f64, f64)) -> f64| scale * (part(legs[0]) + part(legs[1]));
        let square = sum(|(slope, _)| slope * slope);
        LateralPair {
            spacing,
            change: libm::exp(2.0 * square * spacing * spacing),
            square,
            linear: sum(|(slope, at)| 2.0 * slope * at),
            constant: sum(|(_, at)| at * at),
        }
    }

    /// Returns the tangent of the angle across the plane beyond which two-way amplitudes are below
    /// 1.6 %.
    pub fn lateral_reach(&self) -> f64 {
        libm::tan((1.2 * self.lateral_rad).min(1.4))
    }
}

/// Two-way amplitude across the plane, over the place beside the plane (metres): the exponential of a second-degree
/// polynomial.
pub struct LateralPair {
    square: f64,
    linear: f64,
    constant: f64,
    spacing: f64,
    /// Factor by which the ratio of two neighbouring amplitudes changes from one place to the next.
    change: f64,
}

impl LateralPair {
    /// Returns `N` amplitudes, the first at `first` metres beside the plane and the next ones `spacing` apart. They are
    /// computed by recursion: the ratio of two neighbours changes by a constant factor.
    pub fn gains<const N: usize>(&self, first: f64) -> [f64; N] {
        let spacing = self.spacing;
        let at = |z: f64| (self.square * z + self.linear) * z + self.constant;
        let start = at(first);
        let step = spacing * (self.square * (2.0 * first + spacing) + self.linear);
        let last = at(first + N as f64 * spacing);
        if start.min(last) < SMALLEST {
            return core::array::from_fn(|k| libm::exp(at(first + k as f64 * spacing)));
        }
        let mut gain = libm::exp(start);
        let mut ratio = libm::exp(step);
        core::array::from_fn(|_| {
            let this = gain;
            gain *= ratio;
            ratio *= self.change;
            this
        })
    }
}

/// Exponent below which an amplitude is near the smallest normal numbers, where ratios of neighbours are no longer
/// exact.
const SMALLEST: f64 = -600.0;

/// Returns sinh(π√q)/(π√q), which for negative q is sin(π√-q)/(π√-q).
fn lobe(q: f64) -> f64 {
    let x = PI * q.abs().sqrt();
    if x < 1e-6 {
        1.0
    } else if q > 0.0 {
        libm::sinh(x) / x
    } else {
        libm::sin(x) / x
    }
}

/// Returns the parameter B of Taylor's pattern for a first side lobe `sidelobe_db` below the peak. The ratio of peak to
/// side lobes is larger by sinh(πB)/(πB) than that of a uniform source.
fn taylor_parameter(sidelobe_db: f64) -> f64 {
    let wanted = amplitude((sidelobe_db - UNIFORM_SIDELOBE_DB).max(0.0));
    let (mut low, mut high) = (0.0, 4.0);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        if lobe(middle * middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn db(a: f64) -> f64 {
        20.0 * a.log10()
    }

    #[test]
    fn half_the_width_off_axis_is_half_the_power() {
        for width in [2.0_f64, 5.0, 11.0] {
            let beam = Beam::new(width, width, 20.0, 60.0);
            let half = (0.5 * width).to_radians();
            assert!((db(beam.in_plane(half)) + 3.01).abs() < 0.02);
            assert!((db(beam.in_plane(-half)) + 3.01).abs() < 0.02);
            assert!((db(beam.lateral(half)) + 3.01).abs() < 0.01);
            assert!((beam.in_plane(0.0) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn gains_across_the_plane_are_those_of_both_legs() {
        let beam = Beam::new(3.0, 3.0, 20.0, 35.0);
        let legs = [(1.0 / 0.4, 0.05), (1.0 / 0.9, -0.08)];
        for (first, spacing) in [
            (-0.3, 2e-3),
            (0.0, 2e-3),
            (0.2, 4e-4),
            (-3.0, 0.2),
            (2.0, 0.5),
        ] {
            let pair = beam.lateral_pair(legs, spacing);
            let gains: [f64; 32] = pair.gains(first);
            for (k, gain) in gains.into_iter().enumerate() {
                let z = first + k as f64 * spacing;
                let exact: f64 = legs.iter().map(|(s, a)| beam.lateral(s * z + a)).product();
                assert!(
                    (gain - exact).abs() < 1e-12 * exact + 1e-300,
                    "{z}: {gain} {exact}"
                );
            }
        }
    }

    #[test]
    fn the_first_side_lobe_is_as_high_as_asked() {
        for level in [13.26, 17.0, 20.0, 25.0] {
            let beam = Beam::new(5.0, 5.0, level, 90.0);
            let first_null = (1.0 + beam.parameter * beam.parameter).sqrt() / beam.u_per_sine;
            let highest = (0..2000)
                .map(|k| beam.in_plane(first_null + f64::from(k) * 1e-4))
                .fold(0.0, f64::max);
            assert!(
                (db(highest) + level).abs() < 0.1,
                "{level}: {}",
                db(highest)
            );
        }
    }

    #[test]
    fn the_floor_is_what_remains_between_the_lobes() {
        let beam = Beam::new(5.0, 5.0, 20.0, 35.0);
        let lowest = (0..4000)
            .map(|k| beam.in_plane(0.1 + f64::from(k) * 1e-4))
            .fold(1.0, f64::min);
        assert!((db(lowest) + 35.0).abs() < 0.1, "{}", db(lowest));
    }
}
