//! A beam that turns, or a chair that vibrates, while a chirp is captured.
//!
//! The echoes are computed at the beginning, the middle and the end of the chirp. In between they
//! follow the parabola through these three. For a beam of 5 degrees that turns by a quarter of a
//! degree the error is below 1e-5 of its peak.

use num_complex::Complex64;

use super::chirp::Firing;
use super::displacement::vibrates;
use super::shaft::vibration_deg;
use super::{Bundles, Scene};

impl Scene {
    /// Adds to `echo` the echoes of a chirp during which mirror or chair move, sample by sample.
    pub(super) fn turning_echoes(
        &self,
        firing: &Firing,
        tones: &[&Bundles],
        echo: &mut [Complex64],
    ) {
        let (radar, mirror) = (&self.spec.radar, &self.spec.mirror);
        let count = echo.len();
        let chirp_s = radar.samples_per_chirp as f64 / radar.sample_rate_hz;
        let half_s = 0.5 * chirp_s;
        let half = 0.5 * mirror.turn_deg_s * chirp_s;
        let parts = [-1.0, 0.0, 1.0].map(|at| {
            let angle = firing.row_deg + at * half;
            let beam = (angle + vibration_deg(mirror, angle)).to_radians() + firing.tilt;
            let mut part = vec![Complex64::ZERO; count];
            let grid = if vibrates(&self.spec.mount) {
                let shaken = self.shaken(tones, firing.time_s + at * half_s);
                self.weighed(beam, &shaken.iter().collect::<Vec<_>>(), firing.delay)
            } else {
                self.weighed(beam, tones, firing.delay)
            };
            self.beats().tones.sum(&grid, &firing.warp, &mut part);
            part
        });
        let [begin, middle, end] = &parts;
        for (n, sample) in echo.iter_mut().enumerate() {
            // From -1 at the first sample to 1 at the last.
            let at = 2.0 * n as f64 / (count - 1) as f64 - 1.0;
            let weights = [
                0.5 * at * (at - 1.0),
                (1.0 - at) * (1.0 + at),
                0.5 * at * (at + 1.0),
            ];
            *sample += begin[n] * weights[0] + middle[n] * weights[1] + end[n] * weights[2];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "[radar]\nsamples_per_chirp = 64\n[[wall]]\nat_m = 1.2\n\
                         material = \"concrete\"\n[[floor]]\nmaterial = \"concrete\"\n";

    fn scene(mirror: &str) -> Scene {
        let sweep = "[sweep]\nfirst_deg = -1.0\nlast_deg = 4.0\n";
        Scene::parse(&format!(
            "[mirror]\njitter_deg = 0.0\n{mirror}{sweep}{SCENE}"
        ))
        .unwrap()
    }

    fn difference(a: &Scene, b: &Scene) -> f64 {
        let (a, b) = (a.simulate("a", 3), b.simulate("b", 3));
        let power = |i: f64, q: f64| i * i + q * q;
        let pairs = a.samples.iter().zip(&b.samples);
        let apart: f64 = pairs
            .map(|(a, b)| {
                power(
                    f64::from(a.i) - f64::from(b.i),
                    f64::from(a.q) - f64::from(b.q),
                )
            })
            .sum();
        let all: f64 = (a.samples.iter().map(|s| power(s.i.into(), s.q.into()))).sum();
        (apart / all).sqrt()
    }

    #[test]
    fn a_mirror_that_hardly_turns_is_one_that_stands() {
        let still = scene("");
        let hardly = difference(&still, &scene("turn_deg_s = 0.001\n"));
        let turning = difference(&still, &scene("turn_deg_s = 230.0\n"));
        assert!(
            turning > 1e-4 && hardly < 0.2 * turning,
            "{hardly} {turning}"
        );
        // A shaft at rest does not vibrate.
        assert_eq!(difference(&still, &scene("vibration_deg = 0.5\n")), 0.0);
    }

    /// The beam's gain over the turn during a chirp equals the parabola through its gains at three angles.
    #[test]
    fn three_places_are_enough() {
        let beam = super::super::beam::Beam::new(5.0, 5.0, 20.0, 35.0);
        let gain = |deg: f64| beam.in_plane(deg.to_radians()).powi(2);
        let half = 0.125;
        for axis in [0.0, 1.0, 2.5, 4.0] {
            let exact = |at: f64| gain(axis + at * half);
            for at in [-0.7, -0.3, 0.5, 0.9] {
                let parabola = 0.5 * at * (at - 1.0) * exact(-1.0)
                    + (1.0 - at * at) * exact(0.0)
                    + 0.5 * at * (at + 1.0) * exact(1.0);
                assert!((parabola - exact(at)).abs() < 1e-4, "{axis} {at}");
            }
        }
    }
}
