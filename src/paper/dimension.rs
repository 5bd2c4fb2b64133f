//! Conversion of a cluster to a step: distance and height with their standard deviations (paper IV).

use super::cluster::{ClusterVerdict, Extent};
use super::particles::{Moments, PointParticle};
use crate::answer::{Answer, Direction, Step};
use crate::config::{ParticleConfig, Plane};
use crate::math;
use crate::signal::grid::Geometry;
use crate::sort::shell_sort;

/// Number of gaps between neighbouring particles, from the topmost one down, whose mean measures the particles'
/// density.
const TOP_GAPS: usize = 4;

/// Statistics of one cluster's particles, in units of their coordinates (1/64 range bin) from the mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClusterShape {
    /// Number of the cluster's particles.
    count: u16,
    /// Power-weighted mean along the axis from which the mirror's angle is measured (eq. 5).
    along: f32,
    /// Standard deviation along the axis from which the mirror's angle is measured, weighted by power.
    along_sigma: f32,
    /// Mean across the axis from which the mirror's angle is measured, each particle with the same weight.
    across: f32,
    /// Smallest coordinate across the axis: that of the topmost particle, in the height plane of the nearest one.
    top: f32,
    /// Mean distance across the axis between neighbouring particles, from the one at `top` on.
    gap: f32,
}

impl ClusterShape {
    /// Returns the statistics of the particles `members`, which are sorted with the topmost first.
    pub fn of(members: &[PointParticle]) -> Self {
        let peak = members.iter().map(|p| p.weight).max().unwrap_or(0);
        let power = Moments::of(members, |p| linear_power(peak - p.weight.min(peak)));
        let places = Moments::of(members, |_| 1);
        let (Some(power), Some(places), Some(top)) = (power, places, members.first()) else {
            return Self::default();
        };
        let next = (members.get(TOP_GAPS)).or(members.last()).unwrap_or(top);
        let gaps = TOP_GAPS.min(members.len() - 1).max(1);
        let across = |p: &PointParticle| f32::from(p.at[1]);
        Self {
            count: members.len() as u16,
            along: power.mean[0],
            along_sigma: math::sqrt(power.variance[0]),
            across: places.mean[1],
            top: across(top),
            gap: (across(next) - across(top)) / gaps as f32,
        }
    }

    /// Returns particle count and mean position of the cluster, metres, for the rejection rules; `unit_m` is the unit
    /// of the particles' coordinates, metres.
    pub fn extent(&self, unit_m: f32) -> Extent {
        Extent {
            count: self.count,
            along_m: self.along * unit_m,
            // Coordinates increase downwards.
            across_m: -self.across * unit_m,
            verdict: ClusterVerdict::Kept,
        }
    }

    /// Returns the step that the cluster represents; `unit_m` is the unit of the particles' coordinates, metres.
    fn step(&self, geometry: &Geometry, unit_m: f32, config: &ParticleConfig) -> Step {
        let along = self.along * unit_m;
        let (sin, cos) = math::sin_cos(0.5 * geometry.beamwidth_rad);
        // Half of the beam's width at the cluster's distance (eq. 3): an edge is detected up to this distance outside
        // the beam.
        let half_beam = along * sin / cos;
        let edge = self.top * unit_m + half_beam;
        // The mean is as accurate as the echo is narrow, limited by the rounding of a bin. The edge is as accurate as
        // the beam model, whose width depends on the echo's level, and as the density of the particles.
        let along_sigma = math::hypot(0.5 * self.along_sigma * unit_m, 0.1 * geometry.bin_m);
        let across_sigma = math::hypot(0.5 * half_beam, self.gap * unit_m);
        let share = f32::from(config.particles) / f32::from(config.modes.max(1));
        let quality = (100.0 * f32::from(self.count) / share).min(100.0) as u8;
        let (distance_m, height_m, distance_sigma_m, height_sigma_m) = match geometry.plane {
            Plane::Depth => (
                along,
                geometry.mount_height_m - edge,
                along_sigma,
                across_sigma,
            ),
            Plane::Height => (
                edge,
                geometry.mount_height_m - along,
                across_sigma,
                along_sigma,
            ),
        };
        Step {
            distance_m,
            height_m,
            distance_sigma_m,
            height_sigma_m,
            quality,
            ..Step::default()
        }
    }
}

/// Returns the linear power, Q15, of a level `below` map units (eighths of an octave) under that of power 1.
fn linear_power(below: u16) -> u16 {
    /// Entry k: 2^(-k/8), Q15.
    const EIGHTHS: [u16; 8] = [32768, 30048, 27554, 25268, 23170, 21247, 19484, 17867];
    let eighth = EIGHTHS.get(usize::from(below % 8)).copied().unwrap_or(0);
    eighth.checked_shr(u32::from(below / 8)).unwrap_or(0)
}

/// Adds the step of each cluster of `kept` to `answer`, the nearest step first.
pub fn steps<'a>(
    kept: impl Iterator<Item = &'a ClusterShape>,
    geometry: &Geometry,
    unit_m: f32,
    config: &ParticleConfig,
    answer: &mut Answer,
) {
    for shape in kept {
        // Where the list is full, further steps are dropped.
        let _ = answer.steps.push(shape.step(geometry, unit_m, config));
    }
    shell_sort(&mut answer.steps, |a, b| a.distance_m < b.distance_m);
    if !answer.steps.is_empty() {
        answer.direction = match geometry.plane {
            Plane::Depth => Direction::Up,
            Plane::Height => Direction::Down,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mirror 40 cm above the ground with a 5° beam and range bins of 1.28 cm: 64 coordinate units of 0.2 mm.
    fn geometry(plane: Plane) -> Geometry {
        Geometry {
            first_range_m: 0.15,
            bin_m: 0.0128,
            mount_height_m: 0.4,
            step_rad: 0.004,
            beamwidth_rad: 5_f32.to_radians(),
            plane,
        }
    }
    const UNIT_M: f32 = 0.0128 / 64.0;

    fn particle(along_m: f32, across_m: f32, weight: u16) -> PointParticle {
        let at = [along_m, across_m].map(|m| (m / UNIT_M).round() as i16);
        PointParticle {
            at,
            weight,
            mark: 0,
        }
    }

    fn step(members: &[PointParticle], plane: Plane) -> Step {
        let shape = ClusterShape::of(members);
        shape.step(&geometry(plane), UNIT_M, &ParticleConfig::default())
    }

    #[test]
    fn distance_is_the_power_weighted_mean_and_height_the_topmost_less_half_a_beam() {
        // 8 units are an octave: the second particle has half the weight of the others.
        let members = [
            particle(1.0, 0.1, 80),
            particle(1.0, 0.2, 72),
            particle(1.05, 0.25, 80),
        ];
        let step = step(&members, Plane::Depth);
        assert!((step.distance_m - (1.0 + 0.5 + 1.05) / 2.5).abs() < 2e-4);
        let half_beam = step.distance_m * 2.5_f32.to_radians().tan();
        assert!((step.height_m - (0.4 - 0.1 - half_beam)).abs() < 2e-4);
        assert_eq!(step.quality, 3);
    }

    #[test]
    fn in_the_height_plane_depth_and_height_exchange_their_roles() {
        let members = [particle(0.6, -0.1, 80), particle(0.6, 0.1, 80)];
        let step = step(&members, Plane::Height);
        assert!((step.height_m + 0.2).abs() < 2e-4);
        let half_beam = 0.6 * 2.5_f32.to_radians().tan();
        assert!((step.distance_m - (half_beam - 0.1)).abs() < 2e-4);
        assert!(step.distance_sigma_m > step.height_sigma_m);
    }

    #[test]
    fn a_single_particle_and_none_make_finite_steps() {
        for members in [&[][..], &[particle(1.0, 0.3, 0)]] {
            let step = step(members, Plane::Depth);
            let values = [
                step.distance_m,
                step.height_m,
                step.distance_sigma_m,
                step.height_sigma_m,
            ];
            assert!(values.iter().all(|v| v.is_finite()));
        }
    }

    #[test]
    fn linear_power_halves_every_eight_units() {
        for below in 0..200_u16 {
            let exact = 32768.0 * (-f64::from(below) / 8.0).exp2();
            assert!(
                (f64::from(linear_power(below)) - exact).abs() <= 1.0,
                "{below}"
            );
        }
        assert_eq!(linear_power(u16::MAX), 0);
    }

    #[test]
    fn steps_are_reported_nearest_first_with_their_plane_s_direction() {
        let far = ClusterShape::of(&[particle(1.2, 0.0, 80)]);
        let near = ClusterShape::of(&[particle(0.6, 0.2, 80)]);
        let config = ParticleConfig::default();
        for (plane, direction) in [
            (Plane::Depth, Direction::Up),
            (Plane::Height, Direction::Down),
        ] {
            let kept = [far, near];
            let mut answer = Answer::NONE;
            steps(kept.iter(), &geometry(plane), UNIT_M, &config, &mut answer);
            assert_eq!(answer.direction, direction);
            let distances: std::vec::Vec<f32> = answer.steps.iter().map(|s| s.distance_m).collect();
            assert!(distances.is_sorted() && distances.len() == 2);
        }
        let mut none = Answer::NONE;
        let geometry = geometry(Plane::Depth);
        steps([].iter(), &geometry, UNIT_M, &config, &mut none);
        assert_eq!(none, Answer::NONE);
    }
}
