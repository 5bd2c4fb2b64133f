//! `snr`: measures the noise of the fixed-point transform over the input's level.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::Result;
use num_complex::Complex;
use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::Xoshiro128PlusPlus;
use serde_json::json;
use stairscan::Iq;
use stairscan::config::{Config, MAX_SAMPLES, RadarConfig};
use stairscan::signal::range::RangeProcessor;
use stairscan::signal::range::packed::Packed;

use super::{Format, emit};

/// Arguments of `snr`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Number of chirps of each level
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    chirps: u32,
    /// Seed of tones and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Minimum signal-to-error ratio of the fixed-point transform that the worst chirp must reach, dB.
const MIN_DB: f64 = 60.0;
/// Published results of CMSIS-DSP's q15 transform on the same kind of chirp: the chirp's level, dB relative to full
/// scale, and the signal-to-error ratio, dB.
const QUOTED: [(i32, f64); 4] = [(-1, 52.0), (-20, 34.0), (-40, 15.0), (-60, -5.0)];

/// Signal-to-error ratios of the fixed-point transform for chirps of one level, dB relative to full scale.
struct Level {
    dbfs: i32,
    /// Whether the chirps are real-valued.
    real: bool,
    /// Signal-to-error ratio over all chirps, dB.
    snr_db: f64,
    /// Signal-to-error ratio of the worst chirp, dB.
    worst_db: f64,
}

/// Measures the signal-to-error ratios and prints them; exit status 1 below the minimum.
pub fn run(args: &Args) -> Result<ExitCode> {
    let mut levels = measure(args.seed, args.chirps, false)?;
    levels.extend(measure(args.seed, args.chirps, true)?);
    match args.format {
        Format::Text => emit(&table(&levels)),
        Format::Json => {
            let entry = |l: &Level| json!({"level_dbfs": l.dbfs, "real": l.real, "snr_db": l.snr_db, "worst_db": l.worst_db});
            let array: Vec<_> = levels.iter().map(entry).collect();
            emit(&format!("{}\n", json!(array)));
        }
    }
    let low = levels.iter().any(|l| l.worst_db < MIN_DB);
    if low {
        host_sim::note!("error: snr: below {MIN_DB} dB");
    }
    Ok(ExitCode::from(u8::from(low)))
}

fn measure(seed: u64, chirps: u32, real: bool) -> Result<Vec<Level>> {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let config = Config::default();
    let radar = RadarConfig {
        real,
        ..config.radar
    };
    let mut processor = RangeProcessor::new(&radar, &config.mount, &config.cfar)?;
    let reference = Reference::new(&radar);
    let levels = std::iter::once(-1).chain((1..=12).map(|k| -5 * k));
    levels
        .map(|dbfs| {
            let (mut signal, mut error, mut worst_db) = (0.0, 0.0, f64::INFINITY);
            for _ in 0..chirps {
                let chirp = tones(&radar, dbfs.into(), &mut random);
                let (s, e) = powers(&mut processor, &reference, &chirp)?;
                signal += s;
                error += e;
                worst_db = worst_db.min(10.0 * (s / e).log10());
            }
            Ok(Level {
                dbfs,
                real,
                snr_db: 10.0 * (signal / error).log10(),
                worst_db,
            })
        })
        .collect()
}

/// Returns the complex number of this magnitude and angle, radians.
fn polar(magnitude: f64, angle: f64) -> Complex<f64> {
    let (sin, cos) = angle.sin_cos();
    Complex::new(magnitude * cos, magnitude * sin)
}

/// Returns the samples of a chirp: complex, or, if `real`, I and Q of each as two successive real samples.
fn values(chirp: &[Iq], real: bool) -> Vec<Complex<f64>> {
    let both = chirp.iter().map(|x| [f64::from(x.i), f64::from(x.q)]);
    match real {
        false => both.map(|[i, q]| Complex::new(i, q)).collect(),
        true => both.flatten().map(Complex::from).collect(),
    }
}

/// Reference for the fixed-point transform: mean removal, Hann window and zero-padded transform in double precision.
struct Reference {
    real: bool,
    window: Vec<f64>,
    /// exp(-2πik / N) for k = 0…N-1, where N is the number of points of the transform.
    phasors: Vec<Complex<f64>>,
}

impl Reference {
    fn new(radar: &RadarConfig) -> Self {
        let values = 1 + usize::from(radar.real);
        let (samples, points) = (
            values * usize::from(radar.samples),
            values * radar.fft_len(),
        );
        let hann = |n: usize| 0.5 - 0.5 * (TAU * n as f64 / samples as f64).cos();
        let phasor = |k: usize| polar(1.0, -TAU * k as f64 / points as f64);
        Self {
            real: radar.real,
            window: (0..samples).map(hann).collect(),
            phasors: (0..points).map(phasor).collect(),
        }
    }

    /// Returns the spectrum of a chirp, scaled to 1 for a tone at full scale. For a real-valued chirp,
    /// half of whose amplitude is at negative frequencies, it contains the bins of positive
    /// frequencies.
    fn spectrum(&self, chirp: &[Iq]) -> Vec<Complex<f64>> {
        let values = values(chirp, self.real);
        let mean = values.iter().sum::<Complex<f64>>() / values.len() as f64;
        let (points, parts) = (self.phasors.len(), 1 + usize::from(self.real));
        let unit = 32_768.0 * self.window.iter().sum::<f64>() / parts as f64;
        (0..points / parts)
            .map(|k| {
                let terms = values.iter().zip(&self.window).enumerate();
                let sum: Complex<f64> = terms
                    .map(|(n, (x, w))| (x - mean) * w * self.phasors[k * n % points])
                    .sum();
                sum / unit
            })
            .collect()
    }
}

/// Returns the power of a chirp's reference spectrum, and the power of the fixed-point transform's deviation from it.
fn powers(
    processor: &mut RangeProcessor,
    reference: &Reference,
    chirp: &[Iq],
) -> Result<(f64, f64)> {
    let mut bins = [Packed::ZERO; MAX_SAMPLES];
    let unit = f64::from(processor.spectrum(chirp, &mut bins)?);
    let (mut signal, mut error) = (0.0, 0.0);
    for (exact, bin) in reference.spectrum(chirp).into_iter().zip(bins) {
        let fixed = Complex::new(f64::from(bin.re()), f64::from(bin.im())) * unit;
        signal += exact.norm_sqr();
        error += (exact - fixed).norm_sqr();
    }
    Ok((signal, error))
}

/// Returns a chirp of three tones, and noise 50 dB below their peak of `dbfs` dB relative to full scale, quantised.
fn tones(radar: &RadarConfig, dbfs: f64, random: &mut Xoshiro128PlusPlus) -> Vec<Iq> {
    let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
    let peak = 32_767.0 * 10f64.powf(dbfs / 20.0);
    let parts = [0.5, 0.3, 0.2].map(|a| (a * peak, TAU * uniform(), TAU * uniform()));
    let sigma = peak * 10f64.powf(-50.0 / 20.0);
    let mut value = |n: f64| {
        // Box and Muller: radius and angle of a complex normal number.
        let radius = sigma * (-2.0 * uniform().ln()).sqrt();
        let noise = polar(radius, TAU * uniform());
        let tone = |(a, step, phase)| polar(a, step * n + phase);
        let sum: Complex<f64> = noise + parts.into_iter().map(tone).sum::<Complex<f64>>();
        // `as` saturates: the converter clips.
        [sum.re.round() as i16, sum.im.round() as i16]
    };
    (0..radar.samples)
        .map(|n| {
            let n = f64::from(n);
            match radar.real {
                false => value(n),
                true => [value(n)[0], value(n + 0.5)[0]],
            }
        })
        .map(|[i, q]| Iq::new(i, q))
        .collect()
}

fn table(levels: &[Level]) -> String {
    let mut text = String::from("level dBFS   SNR dB   worst chirp   CMSIS-DSP q15 (quoted)\n");
    let mut before = false;
    for level in levels {
        if level.real != before {
            text.push_str("real samples\n");
            before = level.real;
        }
        let mut quoted = QUOTED.iter().filter(|_| !level.real);
        let quoted = quoted.find(|(dbfs, _)| *dbfs == level.dbfs);
        let quoted = quoted.map_or(String::new(), |(_, db)| format!("{db:.0}"));
        let (dbfs, snr, worst) = (level.dbfs, level.snr_db, level.worst_db);
        let _ = writeln!(text, "{dbfs:>10}{snr:>9.1}{worst:>14.1}{quoted:>25}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weak_chirps_keep_their_bits() {
        for real in [false, true] {
            for level in measure(7, 10, real).unwrap() {
                assert!(
                    level.worst_db >= MIN_DB,
                    "{} dBFS, real {real}: {} dB",
                    level.dbfs,
                    level.worst_db
                );
            }
        }
    }
}
