//! Ground truth of a scene: the report of a perfect scanner, and the signal-to-noise ratio of each
//! step.

use core::f64::consts::TAU;

use num_complex::Complex64;

use super::geometry::{BuiltStep, World};
use super::maths::{Vec2, cis, decibel};
use super::sight::visible;
use super::spec::{PlaneSpec, SceneSpec};
use crate::recording::{TrueStep, Truth};

/// Maximum distance of a cell (range bin of one row) from the step to which it belongs, metres.
const NEAR: f64 = 0.03;

/// Minimum rise of a step that a scanner must report, metres. Wheelchairs drive over lower ones.
const MIN_RISE_M: f64 = 0.06;

/// Maximum single rise that counts as a step, metres. A higher one is an obstacle.
const MAX_SINGLE_RISE_M: f64 = 0.30;

/// Number of range bins at the far end of the range axis that are not evaluated: the width of the window's main lobe.
const EDGE_CELLS: f64 = 4.0;

/// Geometry of the scan as stated in the recording.
pub struct ScanGeometry<'a> {
    /// The scene, as its file states it.
    pub spec: &'a SceneSpec,
    /// Recorded mirror angles of the rows, degrees.
    pub angles: &'a [f64],
    /// Range resolution, metres.
    pub resolution: f64,
}

impl ScanGeometry<'_> {
    /// Returns the number of points of the scanner's Fourier transform.
    fn fft_len(&self) -> usize {
        self.spec.radar.samples_per_chirp.next_power_of_two()
    }

    /// Returns the beam's angle at the mirror angle `angle`, both degrees, by the recorded pitch.
    fn beam(&self, angle: f64) -> f64 {
        let mount = &self.spec.mount;
        angle + mount.tilt_deg(mount.pitch_deg.unwrap_or(0.0))
    }

    /// Returns the point in the plane that lies `range` metres from the mirror at the mirror angle `angle`, degrees.
    fn point(&self, range: f64, angle: f64) -> Vec2 {
        let (sin, cos) = libm::sincos(self.beam(angle).to_radians());
        let height = self.spec.mount.height_m;
        match self.spec.mount.plane {
            PlaneSpec::Depth => Vec2::new(range * cos, height - range * sin),
            PlaneSpec::Height => Vec2::new(range * sin, height - range * cos),
        }
    }

    /// Returns whether `p` lies within the scan's ranges and angles, and so does the main lobe of a beam that points at
    /// it.
    fn covers(&self, p: Vec2) -> bool {
        let mount = &self.spec.mount;
        let way = p - Vec2::new(0.0, mount.height_m);
        let angle = match mount.plane {
            PlaneSpec::Depth => libm::atan2(-way.y, way.x),
            PlaneSpec::Height => libm::atan2(way.x, -way.y),
        }
        .to_degrees();
        let half = 0.5 * mount.beamwidth_deg;
        let (first, last) = match (self.angles.first(), self.angles.last()) {
            (Some(a), Some(b)) => (self.beam(*a) + half, self.beam(*b) - half),
            _ => return false,
        };
        let farthest = self.resolution * (self.spec.radar.samples_per_chirp as f64 - EDGE_CELLS);
        (first..=last).contains(&angle) && way.len() + mount.mirror_offset_m <= farthest
    }

    /// Returns whether the cell at the place `p` of the plane belongs to `step`: it lies within [`NEAR`] of the step's
    /// edge and surfaces.
    fn belongs(step: &BuiltStep, p: Vec2) -> bool {
        match step.below {
            None => {
                (p.x - step.edge.x).abs() <= NEAR
                    && p.y >= step.span.0 - NEAR
                    && p.y <= step.span.1 + NEAR
            }
            Some((from, to)) => {
                let row =
                    (p.y - from.y).abs() <= NEAR && p.x >= from.x - NEAR && p.x <= to.x + NEAR;
                row || (p - step.edge).len() <= NEAR
            }
        }
    }

    /// Returns the signal-to-noise ratio, dB, of the strongest cell of every step, from the chirps without receiver
    /// noise.
    ///
    /// `noise` is the power of the noise of one sample, in the squared units of the chirps.
    pub fn snr(&self, steps: &[BuiltStep], chirps: &[Vec<Complex64>], noise: f64) -> Vec<f64> {
        let samples = self.spec.radar.samples_per_chirp;
        // Hann, as in the scanner.
        let window: Vec<f64> = (0..samples)
            .map(|n| 0.5 - 0.5 * libm::cos(TAU * (n as f64 + 0.5) / samples as f64))
            .collect();
        let noise = noise * window.iter().fold(0.0, |sum, w| sum + w * w);
        let fft = self.fft_len();
        let spacing = self.resolution * samples as f64 / fft as f64;
        let mut best = vec![0.0_f64; steps.len()];
        for (angle, chirp) in self.angles.iter().zip(chirps) {
            for bin in 0..fft {
                let range = bin as f64 * spacing - self.spec.mount.mirror_offset_m;
                let p = self.point(range, *angle);
                let mine = |s: &BuiltStep| range > 0.0 && Self::belongs(s, p);
                if !steps.iter().any(mine) {
                    continue;
                }
                let power = cell(chirp, &window, bin as f64 / fft as f64);
                for (step, best) in steps.iter().zip(&mut best) {
                    if mine(step) {
                        *best = best.max(power);
                    }
                }
            }
        }
        best.into_iter()
            .map(|p| decibel(p.max(1e-30) / noise))
            .collect()
    }

    /// Returns whether a scanner must report this step.
    fn counted(&self, world: &World, step: &BuiltStep) -> bool {
        let eye = Vec2::new(0.0, self.spec.mount.height_m);
        let in_sight = |p: Vec2| self.covers(p) && visible(world, eye, p);
        let Some((from, to)) = step.below else {
            return step.rise >= MIN_RISE_M && in_sight(step.edge);
        };
        // A drop is detected by the surface below it, some of which must be in sight.
        self.covers(step.edge) && (1..20).any(|k| in_sight(from.towards(to, f64::from(k) / 20.0)))
    }

    /// Returns the truth, with the steps' signal-to-noise ratios `snr`.
    ///
    /// A step belongs to the plane that shows it: steps up to the depth plane, steps down to the
    /// height plane. A drop ahead of a scan of the depth plane (stairs down, a hole, the end of the
    /// floor) is no step of that scan. Its truth has no direction and lists the drops as
    /// `uncounted`, with negative heights, because reporting them as steps is neither right nor
    /// wrong. The way is not clear, however: an `ok` whose horizon lies beyond the first of them is
    /// wrong, unless a reported drop covers it.
    ///
    /// A box of 6 to 30 cm is `uncounted` unless the scene states that a chair could mount it,
    /// because one scan cannot tell it from a platform.
    pub fn truth(&self, world: &World, snr: impl Fn(&[BuiltStep]) -> Vec<Option<f64>>) -> Truth {
        let (name, mine, others) = match self.spec.mount.plane {
            PlaneSpec::Depth => ("up", &world.up, &world.down),
            PlaneSpec::Height => ("down", &world.down, &world.up),
        };
        let counted: Vec<BuiltStep> = mine
            .iter()
            .filter(|s| self.counted(world, s))
            .copied()
            .collect();
        // In the height plane a box is no step down.
        let climbable = |b: &&BuiltStep| (MIN_RISE_M..=MAX_SINGLE_RISE_M).contains(&b.rise);
        let boxes = world
            .boxes
            .iter()
            .filter(|_| name == "up")
            .filter(climbable);
        let rest = mine
            .iter()
            .filter(|s| !self.counted(world, s))
            .chain(others)
            .chain(boxes);
        let steps: Vec<TrueStep> = counted
            .iter()
            .zip(snr(&counted))
            .map(|(s, snr)| true_step(s, snr.map(|snr| rounded(snr, 10.0))))
            .collect();
        Truth {
            direction: if steps.is_empty() { "none" } else { name }.into(),
            steps,
            uncounted: rest.map(|s| true_step(s, None)).collect(),
            drops: None,
        }
    }
}

fn true_step(s: &BuiltStep, snr_db: Option<f64>) -> TrueStep {
    TrueStep {
        distance_m: rounded(s.distance, 1e5),
        height_m: rounded(s.height, 1e5),
        snr_db,
    }
}

/// Returns `x` rounded to a multiple of `1 / unit`, and never -0.
fn rounded(x: f64, unit: f64) -> f64 {
    libm::floor(x * unit + 0.5) / unit + 0.0
}

/// Returns the power of a windowed chirp at `frequency` cycles per sample.
fn cell(chirp: &[Complex64], window: &[f64], frequency: f64) -> f64 {
    let turn = cis(-TAU * frequency);
    let mut phase = Complex64::ONE;
    let mut sum = Complex64::ZERO;
    for (s, w) in chirp.iter().zip(window) {
        sum += s * phase * w;
        phase *= turn;
    }
    sum.norm_sqr()
}
