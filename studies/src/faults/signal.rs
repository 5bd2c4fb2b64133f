//! A scan separated into the scanner's own reflections, the scene's echoes, and noise.

use anyhow::Result;
use num_complex::Complex64;
use stairscan::Iq;

use host_sim::recording::{MirrorSetup, Recording};
use host_sim::scene::maths::{LIGHT, Random, cis};

/// Only every third row is used to estimate the noise and the component common to all rows (leakage and mirror echo).
const INSIDE_STRIDE: usize = 3;
/// Ratio of the mean to the median of an exponentially distributed power, as noise has it: 1 / ln 2.
const MEAN_OVER_MEDIAN: f64 = core::f64::consts::LOG2_E;
/// Number of frequencies of a chirp's spectrum at which the noise is estimated, in each of the rows used for it.
const NOISE_TONES: usize = 16;

/// A scan, separated into its components, to which faults are applied.
pub struct Signal {
    /// The recording; `chirps` replaces its samples in [`Self::into_recording`].
    pub recording: Recording,
    /// The chirps, in the order in which they were fired, in units of the 16-bit samples.
    pub chirps: Vec<Vec<Complex64>>,
    /// Generator of the random numbers of the fault.
    pub random: Random,
    /// The converter's offset: the mean of all samples.
    offset: Complex64,
    /// Component that the chirps of all rows have in common, leakage and mirror echo, sample by sample, in the phase of
    /// the first row.
    inside: Vec<Complex64>,
    /// Phase of each row's common component relative to the first row's, as a complex number of magnitude 1: not every
    /// radar keeps it constant.
    phases: Vec<Complex64>,
    /// Power of the receiver's noise in a sample, squared units of the 16-bit samples, sum of I and Q.
    noise: f64,
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Returns the phase between `chirp` and the chirp `reference`, by the component that both have in common (leakage and
/// mirror echo), as a complex number of magnitude 1. The converter's `offset` is removed from both.
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

/// Returns the noise power of a sample, squared units of the 16-bit samples, sum of I and Q: from the median of
/// windowed spectra over frequencies and rows.
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
            // Between a third and nine tenths of the range axis, at different places in neighbouring
            // rows.
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
    /// Separates the scan of `recording` into offset, common component and scene, and estimates its noise.
    ///
    /// # Errors
    /// A recording without a mirror is not a scan.
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

    /// Returns the recording with the changed chirps, rounded and clipped as by the converter.
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

    /// Returns the recording's mirror and mounting: scan plane, mounting height, distance from the radar.
    pub fn mirror(&self) -> MirrorSetup {
        // `new` refuses a recording without one.
        self.recording
            .meta
            .mirror
            .clone()
            .unwrap_or_else(|| unreachable!())
    }

    /// Applies `change` to the mounting that the recording states.
    pub fn set_mirror(&mut self, change: impl FnOnce(&mut MirrorSetup)) {
        if let Some(mirror) = &mut self.recording.meta.mirror {
            change(mirror);
        }
    }

    /// Returns the recorded beam angle of a row, degrees from the plane's zero: downwards from the horizontal (stairs
    /// going up), or forwards from straight down (stairs going down).
    pub fn angle_deg(&self, row: usize) -> f64 {
        self.recording
            .meta
            .angles_deg
            .get(row)
            .copied()
            .unwrap_or(0.0)
    }

    /// Returns the difference of the recorded beam angle from the first row to the second, degrees.
    pub fn step_deg(&self) -> f64 {
        self.angle_deg(1) - self.angle_deg(0)
    }

    /// Returns the index of a random row, not the first, after which there are more than `rows` further rows.
    pub fn any_row(&mut self, rows: usize) -> usize {
        let last = self.rows().saturating_sub(rows + 2).max(1);
        1 + self.random.index(last)
    }

    /// Returns the RMS amplitude of the noise in I, and equally in Q, in units of the 16-bit samples.
    pub fn noise_rms(&self) -> f64 {
        (self.noise / 2.0).sqrt()
    }

    /// Returns a random complex sample of noise whose power is `share` times that of the receiver's noise.
    pub fn noise(&mut self, share: f64) -> Complex64 {
        self.random.complex(self.noise * share)
    }

    /// Returns a row's chirp without offset and common component, in the phase of the first row: the scene's echoes
    /// with noise.
    pub fn scene_echoes(&self, row: usize) -> Vec<Complex64> {
        let (offset, turn) = (self.offset, self.phases[row].conj());
        let chirp = self.chirps[row].iter();
        chirp
            .zip(&self.inside)
            .map(|(s, inside)| (s - offset) * turn - inside)
            .collect()
    }

    /// Returns a row's chirp in which `echoes` replace the scene's own: their sum with leakage and mirror echo, in the
    /// row's phase, plus the converter's offset.
    fn chirp(&self, row: usize, echoes: &[Complex64]) -> Vec<Complex64> {
        let (offset, turn) = (self.offset, self.phases[row]);
        let sum = echoes.iter().zip(&self.inside);
        sum.map(|(s, inside)| (s + inside) * turn + offset)
            .collect()
    }

    /// Replaces the scene's echoes in a row's chirp by `echoes`, one value a sample, in the phase of the first row.
    pub fn set_scene_echoes(&mut self, row: usize, echoes: &[Complex64]) {
        self.chirps[row] = self.chirp(row, echoes);
    }

    /// Returns a chirp for row `to` with `echoes`, to which noise is added with `share` of the receiver's noise power:
    /// that by which averaging or interpolation has reduced it.
    fn renewed(&mut self, to: usize, echoes: Vec<Complex64>, share: f64) -> Vec<Complex64> {
        let echoes: Vec<_> = echoes.into_iter().map(|s| s + self.noise(share)).collect();
        self.chirp(to, &echoes)
    }

    /// Returns a chirp for row `to` that repeats the echoes of row `from` with other noise. The echoes are averaged
    /// over row `from` and its two neighbours, which leaves a third of the noise power; new noise adds the other two
    /// thirds.
    pub fn repeated_chirp(&mut self, from: usize, to: usize) -> Vec<Complex64> {
        let last = self.rows().saturating_sub(1);
        let around = [from.saturating_sub(1), from, (from + 1).min(last)];
        let [a, b, c] = around.map(|k| self.scene_echoes(k));
        let mean = a
            .iter()
            .zip(&b)
            .zip(&c)
            .map(|((a, b), c)| (a + b + c) / 3.0)
            .collect();
        self.renewed(to, mean, 2.0 / 3.0)
    }

    /// Returns a chirp for row `to` with the echoes at a fractional row `place` (1.5 is half-way from row 1 to row 2),
    /// interpolated linearly. Before the first row and beyond the last it has that row's echoes with other noise.
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
            return self.repeated_chirp(a, to);
        }
        let kept = part * part + (1.0 - part) * (1.0 - part);
        let mixed = self.scene_echoes(a).into_iter().zip(self.scene_echoes(b));
        let mixed = mixed.map(|(x, y)| x * (1.0 - part) + y * part).collect();
        self.renewed(to, mixed, 1.0 - kept)
    }

    /// Returns the beat signal of an echo at `range_m` metres from the mirror, one value a sample, with amplitude 1 and
    /// the phase of the carrier over that range.
    pub fn tone(&self, range_m: f64) -> Vec<Complex64> {
        let range = range_m + self.mirror().offset_m;
        let phase = 2.0 * core::f64::consts::TAU * self.recording.meta.carrier_hz * range / LIGHT;
        self.turn(range)
            .into_iter()
            .map(|s| s * cis(phase))
            .collect()
    }

    /// Returns the factors, one a sample, that shift echoes by `range_m` metres: the beat signal of that range, with
    /// phase 0 in the middle of the chirp.
    pub fn turn(&self, range_m: f64) -> Vec<Complex64> {
        let meta = &self.recording.meta;
        let samples = meta.samples_per_chirp as f64;
        let beat = 2.0 * range_m * meta.bandwidth_hz / (LIGHT * samples);
        let middle = 0.5 * (samples - 1.0);
        (0..meta.samples_per_chirp)
            .map(|n| cis(core::f64::consts::TAU * beat * (n as f64 - middle)))
            .collect()
    }

    /// Returns the mirror's own echo, one value a sample, in the phase of the first row: the part of the common component
    /// at the mirror's range, under a Hann window.
    pub fn own_echo(&self) -> Vec<Complex64> {
        let tone = self.turn(self.mirror().offset_m);
        let window = |n: usize| {
            let turn = core::f64::consts::TAU * (n as f64 + 0.5) / tone.len() as f64;
            1.0 - libm::cos(turn)
        };
        // The window's mean is 1.
        let pairs = self.inside.iter().zip(&tone).enumerate();
        let part = pairs
            .map(|(n, (inside, tone))| inside * tone.conj() * window(n))
            .sum::<Complex64>()
            / tone.len().max(1) as f64;
        tone.iter().map(|s| s * part).collect()
    }

    /// Adds `factor` times an echo, given in the phase of the first row, to a row's chirp.
    pub fn add_echo(&mut self, row: usize, echo: &[Complex64], factor: Complex64) {
        let change = self.phases[row] * factor;
        for (sample, echo) in self.chirps[row].iter_mut().zip(echo) {
            *sample += echo * change;
        }
    }

    /// Returns the RMS amplitude of the scene's echoes with noise in the strongest row, in units of the 16-bit samples.
    pub fn strongest(&self) -> f64 {
        let power = |row: usize| {
            let echoes = self.scene_echoes(row);
            echoes.iter().map(Complex64::norm_sqr).sum::<f64>() / echoes.len().max(1) as f64
        };
        (0..self.rows()).map(power).fold(0.0, f64::max).sqrt()
    }
}
