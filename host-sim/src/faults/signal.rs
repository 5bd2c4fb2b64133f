//! A scan taken apart: what comes from inside the scanner, what from the scene, and noise.

use anyhow::Result;
use num_complex::Complex64;
use stairscan::Iq;

use crate::recording::{MirrorSetup, Recording};
use crate::scene::maths::{LIGHT, Random, cis};

/// Of so many rows one is looked at for what all rows have in common.
const INSIDE_STRIDE: usize = 3;
/// A second difference of rows has six times the noise's power.
const SECOND_DIFFERENCE: f64 = 6.0;
/// Mean over median of an exponentially distributed power: 1 / ln 2.
const MEAN_OVER_MEDIAN: f64 = core::f64::consts::LOG2_E;

/// A scan whose samples are being spoilt.
pub struct Signal {
    /// The recording; its samples are those of the chirps below once it is given back.
    pub recording: Recording,
    /// The chirps, in the order in which they were fired.
    pub chirps: Vec<Vec<Complex64>>,
    /// The recording's own draw.
    pub random: Random,
    /// What all rows have in common: leakage, mirror, offsets.
    inside: Vec<Complex64>,
    /// Power of the noise, both channels.
    noise: f64,
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

impl Signal {
    /// Takes `recording` apart.
    ///
    /// # Errors
    /// A recording without a mirror is no scan.
    pub fn new(recording: Recording, random: Random) -> Result<Self> {
        recording.scan_setup()?;
        let chirps: Vec<Vec<Complex64>> = (0..recording.chirps())
            .map(|k| {
                let samples = recording.chirp(k).unwrap_or_default();
                let complex = |s: &Iq| Complex64::new(s.i.into(), s.q.into());
                samples.iter().map(complex).collect()
            })
            .collect();
        let samples = recording.meta.samples_per_chirp;
        let part = |n: usize, of: fn(&Complex64) -> f64| {
            let rows = chirps.iter().step_by(INSIDE_STRIDE);
            median(&mut rows.map(|c| of(&c[n])).collect::<Vec<_>>())
        };
        let inside = (0..samples)
            .map(|n| Complex64::new(part(n, |s| s.re), part(n, |s| s.im)))
            .collect();
        let mut bends: Vec<f64> = (chirps.windows(3).step_by(INSIDE_STRIDE))
            .flat_map(|w| {
                let bend = |n: usize| (w[0][n] - w[1][n] * 2.0 + w[2][n]).norm_sqr();
                (0..samples).map(bend).collect::<Vec<_>>()
            })
            .collect();
        let noise = median(&mut bends) * MEAN_OVER_MEDIAN / SECOND_DIFFERENCE;
        Ok(Self {
            recording,
            chirps,
            random,
            inside,
            noise,
        })
    }

    /// The recording with what has become of its chirps, as the converter takes them.
    pub fn into_recording(self) -> Recording {
        let sample = |s: &Complex64| {
            let convert = |x: f64| libm::floor(x + 0.5) as i16;
            Iq::new(convert(s.re), convert(s.im))
        };
        Recording {
            samples: self.chirps.iter().flatten().map(sample).collect(),
            ..self.recording
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.chirps.len()
    }

    /// The mirror's set-up.
    pub fn mirror(&self) -> MirrorSetup {
        // A recording without one was refused.
        self.recording
            .meta
            .mirror
            .clone()
            .unwrap_or_else(|| unreachable!())
    }

    /// Changes what the scanner believes of its mounting.
    pub fn set_mirror(&mut self, change: impl FnOnce(&mut MirrorSetup)) {
        if let Some(mirror) = &mut self.recording.meta.mirror {
            change(mirror);
        }
    }

    /// The angle of a row, degrees.
    pub fn angle_deg(&self, row: usize) -> f64 {
        self.recording
            .meta
            .angles_deg
            .get(row)
            .copied()
            .unwrap_or(0.0)
    }

    /// Degrees from row to row, positive where the scan goes down.
    pub fn step_deg(&self) -> f64 {
        self.angle_deg(1) - self.angle_deg(0)
    }

    /// A row drawn from the middle of the scan, `rows` before its end at least.
    pub fn any_row(&mut self, rows: usize) -> usize {
        let last = self.rows().saturating_sub(rows + 2).max(1);
        1 + self.random.index(last)
    }

    /// Amplitude of the noise in each channel, root mean square.
    pub fn noise_rms(&self) -> f64 {
        (self.noise / 2.0).sqrt()
    }

    /// One sample of noise of `share` of the receiver's own power.
    pub fn noise(&mut self, share: f64) -> Complex64 {
        self.random.complex(self.noise * share)
    }

    /// A row's echoes of the scene, noise included.
    pub fn outside(&self, row: usize) -> Vec<Complex64> {
        let chirp = self.chirps[row].iter();
        chirp
            .zip(&self.inside)
            .map(|(s, inside)| s - inside)
            .collect()
    }

    /// Puts a row together of what comes from inside and the echoes of the scene.
    pub fn set_outside(&mut self, row: usize, echoes: &[Complex64]) {
        let sum = echoes
            .iter()
            .zip(&self.inside)
            .map(|(s, inside)| s + inside);
        self.chirps[row] = sum.collect();
    }

    /// A row's chirp as it would have come once more: the same echoes, other noise. Three neighbouring
    /// rows have nearly the same echoes, and their mean a third of the noise.
    pub fn again(&mut self, row: usize) -> Vec<Complex64> {
        let last = self.rows().saturating_sub(1);
        let around = [row.saturating_sub(1), row, (row + 1).min(last)];
        let mean = |n: usize| around.iter().map(|&k| self.chirps[k][n]).sum::<Complex64>() / 3.0;
        let mean: Vec<Complex64> = (0..self.inside.len()).map(mean).collect();
        mean.into_iter()
            .map(|s| s + self.noise(2.0 / 3.0))
            .collect()
    }

    /// The chirp at a place between rows, 1.5 being half-way from row 1 to row 2; beyond the ends that of
    /// the last row, with noise of its own.
    pub fn between(&mut self, place: f64) -> Vec<Complex64> {
        let last = self.rows().saturating_sub(1) as f64;
        let clamped = place.clamp(0.0, last);
        let low = libm::floor(clamped);
        let part = clamped - low;
        let (a, b) = (low as usize, (low + 1.0).min(last) as usize);
        if part == 0.0 && place == clamped {
            return self.chirps[a].clone();
        }
        if part == 0.0 {
            return self.again(a);
        }
        let kept = part * part + (1.0 - part) * (1.0 - part);
        let mixed = self.chirps[a].iter().zip(&self.chirps[b]);
        let mixed: Vec<Complex64> = mixed.map(|(x, y)| x * (1.0 - part) + y * part).collect();
        mixed
            .into_iter()
            .map(|s| s + self.noise(1.0 - kept))
            .collect()
    }

    /// The tone of an echo at `range_m` from the mirror with amplitude 1 and its carrier's phase.
    pub fn tone(&self, range_m: f64) -> Vec<Complex64> {
        let range = range_m + self.mirror().offset_m;
        let phase = 2.0 * core::f64::consts::TAU * self.recording.meta.carrier_hz * range / LIGHT;
        self.turn(range)
            .into_iter()
            .map(|s| s * cis(phase))
            .collect()
    }

    /// What shifts echoes by `range_m`: the beat of that range, without a phase in the chirp's middle.
    pub fn turn(&self, range_m: f64) -> Vec<Complex64> {
        let meta = &self.recording.meta;
        let samples = meta.samples_per_chirp as f64;
        let beat = 2.0 * range_m * meta.bandwidth_hz / (LIGHT * samples);
        let middle = 0.5 * (samples - 1.0);
        (0..meta.samples_per_chirp)
            .map(|n| cis(core::f64::consts::TAU * beat * (n as f64 - middle)))
            .collect()
    }

    /// The strongest that a row's echoes get, root mean square of a chirp.
    pub fn strongest(&self) -> f64 {
        let power = |row: usize| {
            let echoes = self.outside(row);
            echoes.iter().map(Complex64::norm_sqr).sum::<f64>() / echoes.len().max(1) as f64
        };
        (0..self.rows()).map(power).fold(0.0, f64::max).sqrt()
    }
}
