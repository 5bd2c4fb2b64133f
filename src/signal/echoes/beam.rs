//! Check that the mirror's step between rows is as configured, by the widths of the echoes' lobes.
//!
//! The lobe of a point scatterer over the angle has the beam's width, independent of the scene. If the mirror's
//! step is larger than configured, all lobes are narrower than the beam; if it is smaller, all are wider. An
//! extended scatterer is wider, too, but hardly ever all strong echoes are extended.

use super::echo::{Echo, MAX_ECHOES};
use crate::params::Params;
use crate::signal::grid::Geometry;
use crate::sort::shell_sort;

/// Maximum standard deviation of the angle of an echo whose width counts, as a share of the beam's width: others disturb
/// the lobes of the rest.
const UNDISTURBED: f32 = 0.04;

/// Statistics of the widths of strong echoes' lobes, relative to that of a point scatterer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobes {
    /// Number of strong echoes: those with an SNR above `beam_echo_db` whose lobes nothing disturbs.
    pub echoes: usize,
    /// Smallest width of their lobes; 1 is a point scatterer's.
    pub least: f32,
    /// Median width of their lobes; 1 is a point scatterer's.
    pub median: f32,
}

impl Lobes {
    /// Computes the statistics for the echoes of a map; `None` without a strong echo.
    #[inline(never)]
    pub fn of(echoes: &[Echo], geometry: &Geometry, p: &Params) -> Option<Self> {
        let mut widths = heapless::Vec::<f32, MAX_ECHOES>::new();
        let most_rad = UNDISTURBED * geometry.beamwidth_rad;
        let undisturbed = |e: &&Echo| e.snr_db > p.beam_echo_db && e.angle_sigma_rad < most_rad;
        for e in echoes.iter().filter(undisturbed) {
            // The vector has room for all echoes.
            let _ = widths.push(e.width);
        }
        shell_sort(&mut widths, |a, b| a < b);
        Some(Self {
            echoes: widths.len(),
            least: *widths.first()?,
            median: *widths.get(widths.len() / 2)?,
        })
    }

    /// Returns two limits: the minimum of the median width, then the maximum of the smallest width. An extended
    /// scatterer may be wider than a point, and noise can make a single lobe narrower. Few lobes therefore fail
    /// only if all of them are far too wide.
    pub fn limits(&self, p: &Params) -> [f32; 2] {
        match self.echoes < p.beam_echoes as usize {
            true => [0.0, p.beam_broad_few],
            false => [p.beam_narrow, p.beam_broad],
        }
    }

    /// Returns whether the lobes' widths are those of the configured beam and mirror step: median and smallest
    /// width within [`Lobes::limits`].
    pub fn fit(&self, p: &Params) -> bool {
        let [narrow, broad] = self.limits(p);
        self.median >= narrow && self.least < broad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: &Params = &Params::DEFAULT;

    fn geometry(beamwidth_deg: f32) -> Geometry {
        Geometry {
            step_rad: 0.25f32.to_radians(),
            beamwidth_rad: beamwidth_deg.to_radians(),
            ..Geometry::default()
        }
    }

    fn lobes(widths: &[f32], beamwidth_deg: f32) -> Option<Lobes> {
        let echo = |&width: &f32| Echo {
            snr_db: 30.0,
            width,
            ..Echo::default()
        };
        let echoes: std::vec::Vec<_> = widths.iter().map(echo).collect();
        Lobes::of(&echoes, &geometry(beamwidth_deg), P)
    }

    #[test]
    fn lobes_of_points_and_of_some_wider_things_fit() {
        let fit = |widths: &[f32]| lobes(widths, 5.0).unwrap().fit(P);
        assert!(fit(&[1.03, 1.07, 1.10, 1.6, 3.0]));
        assert!(fit(&[1.05, 1.4, f32::INFINITY]));
        // Steps a quarter larger, and a fifth smaller, than configured.
        assert!(!fit(&[0.82, 0.86, 0.88, 1.28, 2.4]));
        assert!(!fit(&[1.29, 1.34, 1.38, 2.0, 3.8]));
    }

    #[test]
    fn few_strong_echoes_only_show_lobes_that_are_far_too_wide() {
        let fit = |widths: &[f32]| lobes(widths, 5.0).unwrap().fit(P);
        assert!(fit(&[0.5, 0.5]) && fit(&[1.2, 3.0]) && fit(&[1.2]));
        assert!(!fit(&[1.5, 3.0]) && !fit(&[1.5]));
        let weak = Echo {
            snr_db: 10.0,
            width: 0.5,
            ..Echo::default()
        };
        assert_eq!(Lobes::of(&[weak; 5], &geometry(5.0), P), None);
    }
}
