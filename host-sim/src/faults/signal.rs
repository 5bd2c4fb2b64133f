//! A scan taken apart: what comes from inside the scanner, what from the scene, and noise.

use anyhow::Result;
use num_complex::Complex64;
use stairscan::Iq;

use crate::recording::{MirrorSetup, Recording};
use crate::scene::maths::{LIGHT, Random, cis};

/// Of so many rows one is looked at for what all rows have in common.
const INSIDE_STRIDE: usize = 3;
/// Mean over median of an exponentially distributed power: 1 / ln 2.
const MEAN_OVER_MEDIAN: f64 = core::f64::consts::LOG2_E;
/// Frequencies at which the noise is looked for, in each of the rows that are looked at.
const NOISE_TONES: usize = 16;

/// A scan whose samples are being spoilt.
pub struct Signal {
    /// The recording; its samples are those of the chirps below once it is given back.
    pub recording: Recording,
    /// The chirps, in the order in which they were fired.
    pub chirps: Vec<Vec<Complex64>>,
    /// The recording's own draw.
    pub random: Random,
    /// The converter's offset.
    offset: Complex64,
    /// What all rows have in common: leakage and mirror.
    inside: Vec<Complex64>,
    /// The phase of each row's chirp against the common one: not every radar keeps it.
    phases: Vec<Complex64>,
    /// Power of the noise, both channels.
    noise: f64,
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// The phase of what two chirps have in common.
fn phase(chirp: &[Complex64], reference: &[Complex64], offset: Complex64) -> Complex64 {
    let pairs = chirp.iter().zip(reference);
    let product: Complex64 = pairs.map(|(a, b)| (a - offset) * (b - offset).conj()).sum();
    let size = product.norm_sqr().sqrt();
    if size > 0.0 {
        product / size
    } else {
        Complex64::ONE
    }
}

/// Power of the noise in a sample: the median over frequencies and rows of windowed spectra.
fn noise_power(chirps: &[Vec<Complex64>]) -> f64 {
    let mut powers = Vec::new();
    for (k, chirp) in chirps.iter().enumerate().step_by(INSIDE_STRIDE) {
        let samples = chirp.len() as f64;
        let turn = |n: usize| core::f64::consts::TAU * n as f64 / samples;
        let hann: Vec<f64> = (0..chirp.len())
            .map(|n| 0.5 - 0.5 * libm::cos(turn(n)))
            .collect();
        let energy: f64 = hann.iter().map(|w| w * w).sum();
        for tone in 0..NOISE_TONES {
            // Between a third and nine tenths of the range axis, another place in every row.
            let place = 0.33 + 0.57 * (tone as f64 + (k % 7) as f64 / 7.0) / NOISE_TONES as f64;
            let bin = libm::floor(place * samples);
            let line: Complex64 = (chirp.iter().zip(&hann).enumerate())
                .map(|(n, (s, w))| s * *w * cis(-bin * turn(n)))
                .sum();
            powers.push(line.norm_sqr() / energy.max(f64::MIN_POSITIVE));
        }
    }
    median(&mut powers) * MEAN_OVER_MEDIAN
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
        let count = (chirps.len() * samples).max(1) as f64;
        let offset = chirps.iter().flatten().sum::<Complex64>() / count;
        let reference = chirps.first().cloned().unwrap_or_default();
        let phases: Vec<Complex64> = chirps
            .iter()
            .map(|c| phase(c, &reference, offset))
            .collect();
        let part = |n: usize, of: fn(&Complex64) -> f64| {
            let rows = chirps.iter().zip(&phases).step_by(INSIDE_STRIDE);
            median(
                &mut rows
                    .map(|(c, p)| of(&((c[n] - offset) * p.conj())))
                    .collect::<Vec<_>>(),
            )
        };
        let inside = (0..samples)
            .map(|n| Complex64::new(part(n, |s| s.re), part(n, |s| s.im)))
            .collect();
        let noise = noise_power(&chirps);
        Ok(Self {
            recording,
            chirps,
            random,
            offset,
            inside,
            phases,
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

    /// A row's echoes of the scene, noise included, in the phase that all rows have in common.
    pub fn outside(&self, row: usize) -> Vec<Complex64> {
        let (offset, turn) = (self.offset, self.phases[row].conj());
        let chirp = self.chirps[row].iter();
        chirp
            .zip(&self.inside)
            .map(|(s, inside)| (s - offset) * turn - inside)
            .collect()
    }

    /// A row's chirp of what comes from inside and these echoes of the scene.
    fn chirp(&self, row: usize, echoes: &[Complex64]) -> Vec<Complex64> {
        let (offset, turn) = (self.offset, self.phases[row]);
        let sum = echoes.iter().zip(&self.inside);
        sum.map(|(s, inside)| (s + inside) * turn + offset)
            .collect()
    }

    /// Puts a row together of what comes from inside and the echoes of the scene.
    pub fn set_outside(&mut self, row: usize, echoes: &[Complex64]) {
        self.chirps[row] = self.chirp(row, echoes);
    }

    /// The chirp of row `to` with these echoes, whose noise lacks `share` of its power.
    fn renewed(&mut self, to: usize, echoes: Vec<Complex64>, share: f64) -> Vec<Complex64> {
        let echoes: Vec<_> = echoes.into_iter().map(|s| s + self.noise(share)).collect();
        self.chirp(to, &echoes)
    }

    /// The chirp of row `from` as it would have come once more in place of row `to`: the same echoes,
    /// other noise. Three neighbouring rows have nearly the same echoes, and their mean a third of the
    /// noise.
    pub fn again(&mut self, from: usize, to: usize) -> Vec<Complex64> {
        let last = self.rows().saturating_sub(1);
        let around = [from.saturating_sub(1), from, (from + 1).min(last)];
        let [a, b, c] = around.map(|k| self.outside(k));
        let mean = a
            .iter()
            .zip(&b)
            .zip(&c)
            .map(|((a, b), c)| (a + b + c) / 3.0)
            .collect();
        self.renewed(to, mean, 2.0 / 3.0)
    }

    /// The chirp at a place between rows, 1.5 being half-way from row 1 to row 2, in place of row `to`;
    /// beyond the ends that of the last row, with noise of its own.
    pub fn between(&mut self, place: f64, to: usize) -> Vec<Complex64> {
        let last = self.rows().saturating_sub(1) as f64;
        let clamped = place.clamp(0.0, last);
        let low = libm::floor(clamped);
        let part = clamped - low;
        let (a, b) = (low as usize, (low + 1.0).min(last) as usize);
        if part == 0.0 && place == clamped {
            return self.chirps[a].clone();
        }
        if part == 0.0 {
            return self.again(a, to);
        }
        let kept = part * part + (1.0 - part) * (1.0 - part);
        let mixed = self.outside(a).into_iter().zip(self.outside(b));
        let mixed = mixed.map(|(x, y)| x * (1.0 - part) + y * part).collect();
        self.renewed(to, mixed, 1.0 - kept)
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
