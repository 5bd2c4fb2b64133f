//! Statistics of range profiles over the chirps of a recording: leakage, echoes, noise, phase.
//!
//! Input are the complex spectra of all chirps, in frames of successive chirps during which the scene is
//! taken to be still. Noise is half the power of the difference of two successive chirps of a frame, so that
//! echoes cancel. Of each selected bin the phase is followed within frames and from frame to frame. A value that the
//! chirps do not give is `None`, with its reason below the table.

mod table;

use anyhow::{Result, ensure};
use num_complex::Complex64;
use std::f64::consts::LN_2;

/// Limit of mean power, as a multiple of the noise in the same bin, below which a bin counts as without an echo: 2 dB.
const EMPTY: f64 = 1.6;
/// Power, as a multiple of the noise, down to which the leakage extends, and from which a coherent echo's phase is
/// followed: 10 dB.
const FOLLOWED: f64 = 10.0;
/// Multiple of the mean that exponentially distributed power exceeds in one of a hundred cases: ln 100.
const HUNDREDTH: f64 = 4.605;
/// Number of bins next to the leakage whose noise is compared with that of bins without echoes.
const NEAR_BINS: usize = 4;
/// Ratio of the variance of white noise's second difference to that of the noise itself: 1 + 4 + 1.
const SECOND_DIFFERENCE: f64 = 6.0;

/// Complex spectra of a recording's chirps, in frames.
#[derive(Clone, Debug)]
pub struct Spectra {
    /// Complex spectrum of each chirp, with magnitude 1 for a tone at full scale; all have the same number of bins.
    pub chirps: Vec<Vec<Complex64>>,
    /// Number of chirps in a frame, at least 2.
    pub frame: usize,
    /// Range difference between bins, metres.
    pub spacing_m: f64,
    /// Index of the first bin beyond the leakage, and of the first one after those that are tested for echoes.
    pub tested: (usize, usize),
    /// Magnitude of the correlation of white noise in bins 1 apart, and 2 apart, that the window function of the
    /// transform causes.
    pub window: [f64; 2],
}

/// Noise of a recording in the bins without echoes.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Number of bins without echoes.
    pub bins: usize,
    /// Range of the first and the last bin without an echo, metres.
    pub range_m: [f64; 2],
    /// Mean noise power of a bin, dB relative to full scale; `None` if it is 0.
    pub power_db: Option<f64>,
    /// Mean of the noise power over its median; in theory 1 / ln 2. `None` if no noise varies.
    pub mean_over_median: Option<f64>,
    /// Share of the noise powers that exceed 4.6 times their mean; in theory 1 %. `None` if no noise varies.
    pub above: Option<f64>,
    /// Magnitude of the correlation of the recorded noise in bins 1 apart, and 2 apart; `None` without such bins.
    pub correlation: [Option<f64>; 2],
    /// Correlation of the noise in successive chirps of a frame, in the same bin; in theory 0. `None` if no noise varies.
    pub chirps: Option<f64>,
}

/// Power and phase of the leakage, or of one echo, over the chirps.
#[derive(Clone, Debug)]
pub struct Echo {
    /// Name of the table's row: leakage, strongest echo or steadiest echo.
    pub name: &'static str,
    /// Range, interpolated between bins, metres.
    pub range_m: f64,
    /// Mean power over the chirps, dB relative to full scale; `None` if it is 0.
    pub power_db: Option<f64>,
    /// Mean power, dB above the noise of bins without echoes; `None` without noise.
    pub over_noise_db: Option<f64>,
    /// Noise in the echo's bin, dB above that of bins without echoes; `None` without noise.
    pub noise_db: Option<f64>,
    /// Standard deviation of the echo's phase from chirp to chirp within a frame after the part that changes linearly, a
    /// steady motion's, is removed, radians; `None` with fewer than three chirps in a frame.
    pub phase_rad: Option<f64>,
    /// Standard deviation of the phase that noise alone causes, with the power of bins without echoes, radians; `None`
    /// without power.
    pub phase_of_noise_rad: Option<f64>,
    /// Change of the phase from frame to frame, rms, radians; `None` with a single frame, or without power.
    pub frames_rad: Option<f64>,
    /// Change of the power from frame to frame, rms, dB; `None` with a single frame, or without power.
    pub level_db: Option<f64>,
}

/// Statistics over the chirps of a recording.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Number of chirps in whole frames.
    pub chirps: usize,
    /// Number of chirps in a frame.
    pub frame: usize,
    /// Noise of the bins without echoes; `None` if every bin holds an echo.
    pub noise: Option<Noise>,
    /// Leakage, strongest echo and steadiest echo.
    pub echoes: Vec<Echo>,
    /// Range of the first bin behind the leakage that is less than 10 dB over the noise, metres.
    pub leakage_end_m: Option<f64>,
    /// Noise of the first tested bins, next to the leakage, dB above that of bins without echoes; `None` without noise.
    pub near_noise_db: Option<f64>,
    /// Magnitude of the correlation of white noise in bins 1 apart, and 2 apart, that the window function of the
    /// transform causes.
    window: [f64; 2],
}

fn decibels(power: f64) -> f64 {
    10.0 * power.log10()
}

/// Returns the quotient; `None` if it is no number.
fn ratio(value: f64, of: f64) -> Option<f64> {
    Some(value / of).filter(|ratio| ratio.is_finite())
}

/// Returns a ratio of powers in decibels; `None` if one of them is 0.
fn ratio_db(power: f64, of: f64) -> Option<f64> {
    ratio(power, of)
        .map(decibels)
        .filter(|level| level.is_finite())
}

/// Returns the root of the mean of the squares; `None` without any.
fn rms(squares: impl Iterator<Item = f64>) -> Option<f64> {
    Some(mean(squares).sqrt()).filter(|rms| rms.is_finite())
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value;
        count += 1.0;
    }
    sum / count
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    *median
}

impl Spectra {
    fn bins(&self) -> usize {
        self.chirps.first().map_or(0, Vec::len)
    }

    fn frames(&self) -> impl Iterator<Item = &[Vec<Complex64>]> {
        self.chirps.chunks_exact(self.frame)
    }

    /// Returns the difference of each pair of successive chirps in `bin`, divided by √2 so that its power is that of
    /// one chirp's noise.
    fn differences(&self, bin: usize) -> Vec<Complex64> {
        let pairs = self.frames().flat_map(|frame| frame.as_chunks::<2>().0);
        pairs
            .map(|[a, b]| (b[bin] - a[bin]) / 2f64.sqrt())
            .collect()
    }

    /// Returns the complex mean of all chirps in `bin`.
    fn coherent(&self, bin: usize) -> Complex64 {
        let sum: Complex64 = self.chirps.iter().map(|chirp| chirp[bin]).sum();
        sum / self.chirps.len() as f64
    }

    /// Returns the noise power of each bin, from the median over the chirps, which single jumps do not affect: the
    /// median of exponentially distributed power is ln 2 of its mean.
    fn noise(&self) -> Vec<f64> {
        let power = |bin| {
            self.differences(bin)
                .iter()
                .map(Complex64::norm_sqr)
                .collect()
        };
        (0..self.bins())
            .map(|bin| median(power(bin)) / LN_2)
            .collect()
    }

    /// Returns the statistics.
    ///
    /// # Errors
    /// Fewer than two chirps in a frame, a frame longer than the recording, or fewer than two bins to test.
    pub fn statistics(&self) -> Result<Statistics> {
        let (first, end) = self.tested;
        ensure!(
            self.frame >= 2,
            "one chirp in a frame, expected two for the noise"
        );
        ensure!(
            self.frame <= self.chirps.len(),
            "--frame {}: longer than the recording of {} chirps",
            self.frame,
            self.chirps.len()
        );
        ensure!(
            first + 2 <= end && end <= self.bins(),
            "fewer than two range bins beyond the leakage, expected more bandwidth or samples"
        );
        let whole = self.frames().count() * self.frame;
        let noise = self.noise();
        let power = |bin: usize| mean(self.chirps.iter().map(|chirp| chirp[bin].norm_sqr()));
        let power: Vec<f64> = (0..self.bins()).map(power).collect();
        let coherent = |bin: usize| self.coherent(bin).norm_sqr();
        let coherent: Vec<f64> = (0..self.bins()).map(coherent).collect();
        let empty = (first..self.bins()).filter(|&bin| power[bin] < EMPTY * noise[bin]);
        let empty: Vec<usize> = empty.collect();
        let floor = match empty.len() {
            0 => median(noise[first..end].to_vec()),
            _ => mean(empty.iter().map(|&bin| noise[bin])),
        };
        let peak = |levels: &[f64], bin: usize| {
            levels[bin - 1] < levels[bin] && levels[bin] >= levels[bin + 1]
        };
        let inside = first.max(1)..end.min(self.bins() - 1);
        let strongest = inside.clone().filter(|&bin| peak(&power, bin));
        let strongest = strongest.max_by(|&a, &b| power[a].total_cmp(&power[b]));
        let steady =
            |bin: usize| coherent[bin] / (power[bin] - coherent[bin]).max(f64::MIN_POSITIVE);
        let steadiest =
            inside.filter(|&bin| peak(&coherent, bin) && coherent[bin] > FOLLOWED * floor);
        let steadiest = steadiest.max_by(|&a, &b| steady(a).total_cmp(&steady(b)));
        let leakage = (1..first).max_by(|&a, &b| power[a].total_cmp(&power[b]));
        let end_of_leakage =
            leakage.and_then(|peak| (peak..end).find(|&bin| power[bin] < FOLLOWED * floor));
        let near = first..end.min(first + NEAR_BINS);
        let rows = [
            ("leakage", leakage, &power),
            ("strongest echo", strongest, &power),
            ("steadiest echo", steadiest, &coherent),
        ];
        let echoes = rows.into_iter().filter_map(|(name, bin, levels)| {
            let bin = bin?;
            Some(Echo {
                name,
                range_m: self.spacing_m * interpolated(levels, bin),
                power_db: ratio_db(power[bin], 1.0),
                over_noise_db: ratio_db(power[bin], floor),
                noise_db: ratio_db(noise[bin], floor),
                phase_of_noise_rad: ratio(floor, 2.0 * power[bin]).map(f64::sqrt),
                ..self.phase(name, bin)
            })
        });
        Ok(Statistics {
            chirps: whole,
            frame: self.frame,
            echoes: echoes.collect(),
            leakage_end_m: end_of_leakage.map(|bin| self.spacing_m * bin as f64),
            near_noise_db: ratio_db(mean(noise[near].iter().copied()), floor),
            noise: (!empty.is_empty()).then(|| self.noise_of(&empty, floor)),
            window: self.window,
        })
    }

    fn noise_of(&self, empty: &[usize], floor: f64) -> Noise {
        let differences = |bin: usize| self.differences(bin);
        let mut relative = Vec::new();
        let (mut along, mut own) = (0.0, 0.0);
        for &bin in empty {
            let powers: Vec<f64> = differences(bin).iter().map(Complex64::norm_sqr).collect();
            let centre = mean(powers.iter().copied());
            relative.extend(powers.iter().filter_map(|p| ratio(*p, centre)));
            let still = self.coherent(bin);
            for pair in self.frames().flat_map(|frame| frame.windows(2)) {
                let [a, b] = [0, 1].map(|k| pair[k][bin] - still);
                along += (b * a.conj()).re;
                own += 0.5 * (a.norm_sqr() + b.norm_sqr());
            }
        }
        let correlation = |apart: usize| {
            let pairs = empty.iter().filter(|&&bin| empty.contains(&(bin + apart)));
            let (mut cross, mut powers) = (Complex64::ZERO, 0.0);
            for &bin in pairs {
                for (a, b) in differences(bin).into_iter().zip(differences(bin + apart)) {
                    cross += b * a.conj();
                    powers += 0.5 * (a.norm_sqr() + b.norm_sqr());
                }
            }
            ratio(cross.norm_sqr().sqrt(), powers)
        };
        let ends = [empty.first(), empty.last()];
        Noise {
            bins: empty.len(),
            range_m: ends.map(|bin| bin.map_or(0.0, |&bin| self.spacing_m * bin as f64)),
            power_db: ratio_db(floor, 1.0),
            mean_over_median: (!relative.is_empty())
                .then(|| ratio(mean(relative.iter().copied()), median(relative.clone())))
                .flatten(),
            above: ratio(
                relative.iter().filter(|&&r| r > HUNDREDTH).count() as f64,
                relative.len() as f64,
            ),
            correlation: [1, 2].map(correlation),
            chirps: ratio(along, own),
        }
    }

    /// Returns an [`Echo`] named `name` with the changes of phase and power in `bin` over time; the other fields are to be
    /// set by the caller.
    fn phase(&self, name: &'static str, bin: usize) -> Echo {
        let angle = |z: Complex64| z.im.atan2(z.re);
        let turn = |a: Complex64, b: Complex64| angle(b * a.conj());
        let triples = self.frames().flat_map(|frame| frame.windows(2 + 1));
        let bends = triples.map(|t| {
            let middle = t[1][bin].conj();
            angle(t[2][bin] * t[0][bin] * middle * middle)
        });
        let bends: Vec<f64> = bends.collect();
        let sums = self
            .frames()
            .map(|frame| frame.iter().map(|chirp| chirp[bin]).sum());
        let sums: Vec<Complex64> = sums.collect();
        // A frame without power has neither phase nor level.
        let pairs = sums.windows(2).filter_map(|pair| {
            let change = ratio_db(pair[1].norm_sqr(), pair[0].norm_sqr())?;
            Some((turn(pair[0], pair[1]).powi(2), change.powi(2)))
        });
        let (changes, steps): (Vec<f64>, Vec<f64>) = pairs.unzip();
        let is_empty = self
            .chirps
            .iter()
            .all(|chirp| chirp[bin] == Complex64::ZERO);
        Echo {
            name,
            range_m: 0.0,
            power_db: None,
            over_noise_db: None,
            noise_db: None,
            phase_rad: rms(bends.iter().map(|b| b * b / SECOND_DIFFERENCE)).filter(|_| !is_empty),
            phase_of_noise_rad: None,
            frames_rad: rms(changes.into_iter()),
            level_db: rms(steps.into_iter()),
        }
    }
}

/// Returns the fractional index of the bin at which the maximum near index `bin` of `levels` (dB) lies: the top of a
/// parabola through three of them.
fn interpolated(levels: &[f64], bin: usize) -> f64 {
    let level = |bin: usize| levels.get(bin).map(|&p| decibels(p));
    let around = (level(bin.wrapping_sub(1)), level(bin), level(bin + 1));
    let (Some(left), Some(peak), Some(right)) = around else {
        return bin as f64;
    };
    let shift = 0.5 * (left - right) / (left - 2.0 * peak + right);
    // Without noise a neighbour's power may be 0, and the shift no number. At the end of the bins beyond the leakage the level may rise further.
    bin as f64 + if shift.abs() < 1.0 { shift } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use rand_core::{Rng as _, SeedableRng as _};
    use rand_xoshiro::Xoshiro128PlusPlus;

    use super::*;

    fn polar(radius: f64, angle: f64) -> Complex64 {
        let (sin, cos) = angle.sin_cos();
        Complex64::new(radius * cos, radius * sin)
    }

    /// Returns spectra with white noise of power 1e-6 in 32 bins, a leakage in bin 1, and an echo in bin 10 whose phase
    /// moves on by 0.1 rad a chirp with a jitter of `jitter`, radians.
    fn spectra(jitter: f64) -> Spectra {
        let mut random = Xoshiro128PlusPlus::seed_from_u64(1);
        let mut normal = |power: f64| {
            let mut uniform = || (f64::from(random.next_u32()) + 0.5) / 4_294_967_296.0;
            let radius = (-power * uniform().ln()).sqrt();
            polar(radius, std::f64::consts::TAU * uniform())
        };
        let chirps = (0..800).map(|k| {
            let mut bins: Vec<_> = (0..32).map(|_| normal(1e-6)).collect();
            bins[1] += Complex64::new(0.3, 0.0);
            let phase = 0.1 * f64::from(k) + jitter * normal(2.0).re;
            bins[10] += polar(0.1, phase);
            bins
        });
        Spectra {
            chirps: chirps.collect(),
            frame: 8,
            spacing_m: 0.03,
            tested: (4, 30),
            window: [0.0, 0.0],
        }
    }

    #[test]
    fn white_noise_and_a_moving_echo_have_their_statistics() {
        let found = spectra(0.01).statistics().unwrap();
        println!("{}", found.text("test"));
        let noise = found.noise.as_ref().unwrap();
        assert_eq!((found.chirps, noise.bins), (800, 27));
        assert!((noise.power_db.unwrap() + 60.0).abs() < 0.2, "{noise:?}");
        assert!(
            (noise.mean_over_median.unwrap() - 1.443).abs() < 0.03,
            "{noise:?}"
        );
        assert!((noise.above.unwrap() - 0.01).abs() < 0.003, "{noise:?}");
        assert!(
            noise.correlation.iter().all(|c| c.unwrap() < 0.03),
            "{noise:?}"
        );
        assert!(noise.chirps.unwrap().abs() < 0.02, "{noise:?}");
        let [leakage, echo] = &found.echoes[..] else {
            panic!("{:?}", found.echoes)
        };
        assert_eq!(found.leakage_end_m, Some(2.0 * 0.03));
        assert!(found.near_noise_db.unwrap().abs() < 0.3, "{found:?}");
        assert_eq!((leakage.name, echo.name), ("leakage", "strongest echo"));
        assert!((echo.range_m - 0.3).abs() < 0.015 && (echo.power_db.unwrap() + 20.0).abs() < 0.1);
        assert!((echo.over_noise_db.unwrap() - 40.0).abs() < 0.3, "{echo:?}");
        // Noise alone: 1 / sqrt(2 · 10^4) rad. With the jitter the root of both squares.
        assert!(
            (echo.phase_of_noise_rad.unwrap() - 0.00707).abs() < 2e-4,
            "{echo:?}"
        );
        assert!((echo.phase_rad.unwrap() - 0.01225).abs() < 8e-4, "{echo:?}");
        // Eight chirps of 0.1 rad each.
        assert!((echo.frames_rad.unwrap() - 0.8).abs() < 0.02, "{echo:?}");
        assert!(
            (leakage.phase_rad.unwrap() - 0.00236).abs() < 2e-4,
            "{leakage:?}"
        );
        assert_eq!(found.json()["echoes"][1]["name"], "strongest echo");
    }

    #[test]
    fn a_still_echo_is_the_steadiest() {
        let mut spectra = spectra(0.0);
        for chirp in &mut spectra.chirps {
            chirp[20] += Complex64::new(0.0, 0.02);
        }
        let found = spectra.statistics().unwrap();
        let steadiest = found.echoes.iter().find(|e| e.name == "steadiest echo");
        let steadiest = steadiest.unwrap();
        assert!((steadiest.range_m - 0.6).abs() < 0.015, "{steadiest:?}");
        // 26 dB over the noise, and averaged over 8 chirps: 0.035 / sqrt(8) · sqrt(2).
        assert!(
            (steadiest.frames_rad.unwrap() - 0.0177).abs() < 3e-3,
            "{steadiest:?}"
        );
    }

    fn refused(spectra: &Spectra) -> String {
        spectra.statistics().unwrap_err().to_string()
    }

    #[test]
    fn too_few_chirps_or_bins_are_named() {
        let all = spectra(0.0);
        let short = Spectra {
            chirps: all.chirps[..7].to_vec(),
            ..all.clone()
        };
        assert_eq!(
            refused(&short),
            "--frame 8: longer than the recording of 7 chirps"
        );
        let single = Spectra {
            frame: 1,
            ..all.clone()
        };
        assert!(refused(&single).starts_with("one chirp in a frame"));
        let narrow = Spectra {
            tested: (4, 5),
            ..all
        };
        assert!(refused(&narrow).starts_with("fewer than two range bins"));
    }

    /// Returns the text of the statistics, and fails if a number in it or in the JSON is none.
    fn shown(spectra: &Spectra) -> String {
        let found = spectra.statistics().unwrap();
        let text = found.text("test");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        for echo in found.json()["echoes"].as_array().unwrap() {
            let levels =
                ["power_db", "over_noise_db", "noise_db", "level_db"].map(|key| echo[key].as_f64());
            assert!(
                levels
                    .into_iter()
                    .flatten()
                    .all(|level| level.abs() < 200.0),
                "{echo}"
            );
        }
        text
    }

    #[test]
    fn a_value_that_is_none_has_a_reason() {
        let all = spectra(0.0);
        let frames_of = |frame: usize, chirps: usize| Spectra {
            frame,
            chirps: all.chirps[..chirps].to_vec(),
            ..all.clone()
        };
        assert!(!shown(&all).contains("\n- "), "all values are there");
        let text = shown(&frames_of(2, 64));
        assert!(
            text.contains("\n- phase, chirps: a frame has 2 chirps, expected 3"),
            "{text}"
        );
        let text = shown(&frames_of(8, 8));
        assert!(
            text.contains("\n- frame to frame: a single frame"),
            "{text}"
        );
        // Every second bin holds an echo: no two bins without one are neighbours, and none are 3 apart.
        let mut combed = all.clone();
        for chirp in &mut combed.chirps {
            chirp
                .iter_mut()
                .step_by(2)
                .for_each(|bin| *bin += Complex64::new(0.1, 0.0));
        }
        let text = shown(&combed);
        assert!(
            text.contains("\n- bins 1 apart: no two without an echo"),
            "{text}"
        );
        assert!(!text.contains("bins 2 apart: no two"), "{text}");
        let same = Spectra {
            chirps: vec![all.chirps[0].clone(); 16],
            ..all.clone()
        };
        let text = shown(&same);
        assert!(
            text.contains("\n- noise: the chirps are the same"),
            "{text}"
        );
        let silent = Spectra {
            chirps: vec![vec![Complex64::ZERO; 32]; 16],
            ..all
        };
        assert!(shown(&silent).contains("\n- noise: the chirps are the same"));
    }
}
