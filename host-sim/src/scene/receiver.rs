//! The receiver: from the echoes at the antenna to the samples, with noise and errors.

use core::f64::consts::{PI, TAU};

use num_complex::Complex64;
use stairscan::Iq;

use super::maths::{LIGHT, Random, amplitude, cis, power};
use super::spec::{RadarSpec, ReceiverSpec};

/// Boltzmann's constant times the reference temperature of noise figures, W/Hz.
const KT0: f64 = 1.380_649e-23 * 290.0;

/// Offset frequency at which the scene file states the phase noise, Hz.
const PHASE_NOISE_OFFSET: f64 = 100e3;

/// The receiver of one scene.
pub struct Receiver<'a> {
    /// The radar with the ADC's own sample count and rate; a real receiver takes twice as many
    /// values at twice the rate.
    radar: RadarSpec,
    spec: &'a ReceiverSpec,
}

impl<'a> Receiver<'a> {
    /// Creates the receiver of a scene.
    pub fn new(radar: &RadarSpec, spec: &'a ReceiverSpec) -> Self {
        let values = radar.values_per_sample();
        let radar = RadarSpec {
            samples_per_chirp: values * radar.samples_per_chirp,
            sample_rate_hz: values as f64 * radar.sample_rate_hz,
            ..radar.clone()
        };
        Self { radar, spec }
    }

    /// Returns the number of values that each ADC takes in a chirp.
    pub fn samples(&self) -> usize {
        self.radar.samples_per_chirp
    }

    /// Returns the amplitude at the ADC, in full scales, of an echo of √σ/(r₁r₂) = 1/m by the radar
    /// equation P_r = P_t G² λ² σ / ((4π)³ r⁴ L) (Skolnik, Introduction to Radar Systems, eq. 1.8).
    pub fn gain(&self, antenna_gain_dbi: f64) -> f64 {
        let wavelength = LIGHT / self.radar.carrier_hz;
        let four_pi = 4.0 * PI;
        let budget = self.radar.tx_power_dbm - self.radar.system_loss_db - self.spec.full_scale_dbm;
        amplitude(budget) * power(antenna_gain_dbi) * wavelength / (four_pi * four_pi.sqrt())
    }

    /// Returns the beat frequency of an echo at `range` metres from the radar, cycles per sample:
    /// 2R/c · B/Ns.
    pub fn beat(&self, range: f64) -> f64 {
        2.0 * range * self.radar.bandwidth_hz / (LIGHT * self.radar.samples_per_chirp as f64)
    }

    /// Returns the effective sample times, in samples, by the frequency of the real sweep. Where
    /// the sweep runs ahead of its straight line, the beat tones are further on (Griffiths, IEE
    /// Proc. F 138, 1991). The bow is a parabola that starts and ends on the line. A sweep that is
    /// steeper than recorded turns about the carrier, its middle.
    pub fn times(&self) -> Vec<f64> {
        let n = self.radar.samples_per_chirp as f64;
        let middle = 0.5 * (n - 1.0);
        (0..self.radar.samples_per_chirp)
            .map(|k| {
                let x = k as f64 / n;
                let even = (k as f64 - middle) * (1.0 + self.spec.sweep_slope) + middle;
                let bow = self.spec.sweep_bow * 4.0 * x * (1.0 - x);
                let turn = TAU * self.spec.sweep_ripple_cycles * x;
                let ripple = self.spec.sweep_ripple * libm::sin(turn);
                even + (bow + ripple) * n
            })
            .collect()
    }

    /// Returns the complex response of the anti-alias filter (Butterworth) at `frequency` cycles per sample, from the
    /// product over its poles.
    pub fn filter(&self, frequency: f64) -> Complex64 {
        let order = f64::from(self.spec.antialias_order);
        let cutoff = self.spec.antialias_cutoff / self.radar.values_per_sample() as f64;
        let s = Complex64::new(0.0, frequency / cutoff);
        (0..self.spec.antialias_order).fold(Complex64::ONE, |response, k| {
            let pole = cis(PI * (2.0 * f64::from(k) + order + 1.0) / (2.0 * order));
            response * -pole / (s - pole)
        })
    }

    /// Returns the power of the thermal noise of both channels at the ADC, in squared full scales:
    /// k T₀ F f_s over the power that fills the ADC.
    pub fn noise_power(&self) -> f64 {
        let watts = KT0 * power(self.spec.noise_figure_db) * self.radar.sample_rate_hz;
        watts * 1e3 / power(self.spec.full_scale_dbm)
    }

    /// Returns the mean square of the quantisation error of both channels: a twelfth of a squared
    /// step each.
    pub fn quantisation_power(&self) -> f64 {
        let step = 2.0 / libm::exp2(f64::from(self.spec.adc_bits));
        2.0 * step * step / 12.0
    }

    /// Returns the deviations of the sample times of one chirp by phase noise, in samples.
    ///
    /// A phase noise that falls with 20 dB per decade is white frequency noise of density 2 f²
    /// L(f). Mixing with the own echo leaves the phase 2πτ δf(t) (range correlation for f τ ≪ 1;
    /// Budge and Burt, Range correlation effects in radars, 1993), as does a sweep that is off its
    /// line by δf.
    pub fn phase_noise(&self, random: &mut Random) -> Vec<f64> {
        let offset = PHASE_NOISE_OFFSET;
        let density = 2.0 * offset * offset * power(self.spec.phase_noise_dbc_hz);
        let deviation = (0.5 * density * self.radar.sample_rate_hz).sqrt();
        let samples = self.radar.samples_per_chirp;
        let scale = deviation * samples as f64 / self.radar.bandwidth_hz;
        let mut deviations = vec![0.0; samples];
        random.normals(&mut deviations);
        deviations.iter_mut().for_each(|x| *x *= scale);
        deviations
    }

    /// Returns by how much later, in samples, one chirp is sampled at `time_s`: trigger jitter, and the drift of the
    /// sweep's middle, which a linear sweep reaches later or earlier.
    pub fn delay(&self, time_s: f64, random: &mut Random) -> f64 {
        let samples = self.radar.samples_per_chirp as f64;
        let drifted = self.spec.carrier_drift_hz_s * time_s / self.radar.bandwidth_hz * samples;
        if self.spec.trigger_jitter_s > 0.0 {
            let late = self.spec.trigger_jitter_s * random.normal();
            return drifted + late * self.radar.sample_rate_hz;
        }
        drifted
    }

    /// Returns the deviations of the sample times of one chirp at `time_s`, in samples: phase noise and the drift of the
    /// sweep's slope.
    pub fn warp(&self, time_s: f64, random: &mut Random) -> Vec<f64> {
        let mut warp = self.phase_noise(random);
        let steeper = self.spec.slope_drift_s * time_s;
        if steeper != 0.0 {
            let late = warp.iter_mut().enumerate();
            late.for_each(|(n, w)| *w += steeper * n as f64);
        }
        warp
    }

    /// Returns the phase factor with which a chirp begins.
    pub fn start_phase(&self, random: &mut Random) -> Complex64 {
        if self.spec.start_phase_deg > 0.0 {
            return cis(self.spec.start_phase_deg.to_radians() * random.normal());
        }
        Complex64::ONE
    }

    /// Applies the last stages of the receiver to the signals `analog` (in full scales): noise, I/Q imbalance, offsets
    /// and the ADC. Returns the samples; a real chirp's values come as pairs in place of I and Q.
    pub fn digitise(&self, analog: &[Complex64], random: &mut Random) -> Vec<Iq> {
        let mut drawn = vec![0.0; 2 * analog.len()];
        random.normals(&mut drawn);
        let (drawn, _) = drawn.as_chunks::<2>();
        let deviation = (self.noise_power() / 2.0).sqrt();
        let noisy = analog
            .iter()
            .zip(drawn)
            .map(|(s, [re, im])| s + Complex64::new(re * deviation, im * deviation));
        let adc = Adc::new(self.spec.adc_bits);
        if self.radar.real {
            let values: Vec<i16> = noisy.map(|s| adc.convert(s.re + self.spec.dc_i)).collect();
            let (pairs, _) = values.as_chunks::<2>();
            return pairs.iter().map(|[a, b]| Iq::new(*a, *b)).collect();
        }
        let offset = Complex64::new(self.spec.dc_i, self.spec.dc_q);
        let [gain, shear] = self.skew();
        noisy
            .map(|s| {
                let skewed = Complex64::new(s.re, gain * s.im + shear * s.re) + offset;
                Iq::new(adc.convert(skewed.re), adc.convert(skewed.im))
            })
            .collect()
    }

    /// Returns the factors of Q and of I in the output of channel Q, whose gain differs from that of I by g and whose
    /// phase differs by φ from 90°. The image lies (1 + 2g cos φ + g²) / (1 - 2g cos φ + g²) below the signal (Razavi,
    /// RF Microelectronics, sec. 4.2).
    fn skew(&self) -> [f64; 2] {
        let gain = amplitude(self.spec.iq_gain_db);
        let (sin, cos) = libm::sincos(self.spec.iq_phase_deg.to_radians());
        [gain * cos, gain * sin]
    }
}

/// Quantisation of one channel of the ADC.
struct Adc {
    /// Number of the ADC's codes from zero to full scale.
    half: f64,
    /// Distance of two neighbouring codes of the ADC in left-aligned 16-bit values.
    step: f64,
}

impl Adc {
    fn new(bits: u32) -> Self {
        let half = libm::exp2(f64::from(bits) - 1.0);
        Self {
            half,
            step: 32768.0 / half,
        }
    }

    /// Clips and rounds `x`, in full scales, to a code of the ADC, and left-aligns the code in 16 bits.
    fn convert(&self, x: f64) -> i16 {
        let code = libm::floor(x * self.half + 0.5).clamp(-self.half, self.half - 1.0);
        (code * self.step) as i16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tones::Tones;

    /// Returns a receiver without errors, to which each test adds one.
    fn perfect() -> ReceiverSpec {
        ReceiverSpec {
            noise_figure_db: -300.0,
            dc_i: 0.0,
            dc_q: 0.0,
            phase_noise_dbc_hz: -300.0,
            sweep_bow: 0.0,
            sweep_ripple: 0.0,
            iq_gain_db: 0.0,
            iq_phase_deg: 0.0,
            adc_bits: 16,
            antialias_order: 0,
            ..ReceiverSpec::default()
        }
    }

    /// Returns the digitised samples of a tone of amplitude 0.5 from `range` metres, in full scales.
    fn received(spec: &ReceiverSpec, range: f64, seed: u64) -> Vec<Complex64> {
        let radar = RadarSpec::default();
        let receiver = Receiver::new(&radar, spec);
        let tones = Tones::new(&receiver.times(), |f| receiver.filter(f));
        let mut grid = tones.grid();
        let place = tones.place(receiver.beat(range)).unwrap();
        Tones::add(&mut grid, &place, place.centre * 0.5);
        let mut random = Random::new(seed, 7);
        let warp = receiver.phase_noise(&mut random);
        let mut samples = vec![Complex64::ZERO; radar.samples_per_chirp];
        tones.sum(&grid, &warp, &mut samples);
        let digital = receiver.digitise(&samples, &mut random);
        digital
            .iter()
            .map(|s| Complex64::new(f64::from(s.i), f64::from(s.q)) / 32768.0)
            .collect()
    }

    /// Returns the amplitude of the spectral line at `frequency` cycles per sample, with a rectangular window.
    fn line(samples: &[Complex64], frequency: f64) -> f64 {
        let sum = samples
            .iter()
            .enumerate()
            .map(|(n, s)| s * cis(-TAU * frequency * n as f64))
            .fold(Complex64::ZERO, |a, b| a + b);
        sum.norm_sqr().sqrt() / samples.len() as f64
    }

    /// Returns the range, metres, whose beat frequency is that of bin `k` of 200.
    fn range_of(k: f64) -> f64 {
        k * LIGHT / 20e9
    }

    fn assert_close(found: f64, book: f64, share: f64) {
        println!(
            "{found:.5e} of {book:.5e}: {:+.2} %",
            100.0 * (found / book - 1.0)
        );
        assert!(
            (found / book - 1.0).abs() < share,
            "{found}, textbook {book}"
        );
    }

    #[test]
    fn a_target_lies_in_the_bin_of_its_range() {
        // 1.4990 m is 100 range resolutions (eq. 1): the 100th of 200 bins.
        let samples = received(&perfect(), 1.498_962_29, 1);
        assert_close(line(&samples, 0.5), 0.5, 1e-3);
        assert!(line(&samples, 0.49) < 1e-4, "nothing in the bins beside");
    }

    #[test]
    fn a_steeper_sweep_scales_all_ranges() {
        // 0.1 % more bandwidth than recorded: 1.5 mm too far at 1.5 m.
        let spec = ReceiverSpec {
            sweep_slope: 1e-3,
            ..perfect()
        };
        for bins in [50.0, 100.0, 150.0] {
            let samples = received(&spec, range_of(bins), 1);
            assert_close(line(&samples, 1.001 * bins / 200.0), 0.5, 1e-3);
        }
    }

    #[test]
    fn the_image_of_an_imbalance() {
        let spec = ReceiverSpec {
            iq_gain_db: 0.8,
            iq_phase_deg: 3.0,
            ..perfect()
        };
        let samples = received(&spec, range_of(40.0), 1);
        let (g, c) = (10_f64.powf(0.04), 3.0_f64.to_radians().cos());
        let book = (1.0 - 2.0 * g * c + g * g) / (1.0 + 2.0 * g * c + g * g);
        assert_close(
            line(&samples, -0.2) / line(&samples, 0.2),
            book.sqrt(),
            0.02,
        );
    }

    #[test]
    fn offsets_lie_at_zero_frequency() {
        let spec = ReceiverSpec {
            dc_i: 0.03,
            dc_q: -0.04,
            ..perfect()
        };
        assert_close(line(&received(&spec, range_of(40.0), 1), 0.0), 0.05, 0.01);
    }

    #[test]
    fn thermal_noise_is_ktbf() {
        // -173.98 dBm/Hz at 290 K, 200 kHz, F = 30 dB, against a full scale of -40 dBm.
        let spec = ReceiverSpec {
            noise_figure_db: 30.0,
            full_scale_dbm: -40.0,
            ..perfect()
        };
        let radar = RadarSpec::default();
        let receiver = Receiver::new(&radar, &spec);
        let book = power(-173.975 + 53.0103 + 30.0 + 40.0);
        assert_close(receiver.noise_power(), book, 1e-3);
        let silence = vec![Complex64::ZERO; 40_000];
        let noise = receiver.digitise(&silence, &mut Random::new(1, 1));
        let square = |x: i16| (f64::from(x) / 32768.0).powi(2);
        let mean = noise.iter().map(|s| square(s.i) + square(s.q)).sum::<f64>() / 40_000.0;
        assert_close(mean, book, 0.03);
    }

    #[test]
    fn quantisation_errors_are_a_twelfth_of_a_squared_step() {
        let radar = RadarSpec::default();
        let spec = ReceiverSpec {
            adc_bits: 10,
            ..perfect()
        };
        let receiver = Receiver::new(&radar, &spec);
        let tone: Vec<Complex64> = (0..20_000)
            .map(|n| cis(TAU * 0.123_456_7 * f64::from(n)) * 0.9)
            .collect();
        let digital = receiver.digitise(&tone, &mut Random::new(1, 1));
        assert!(
            digital.iter().all(|s| s.i % 64 == 0 && s.q % 64 == 0),
            "left-aligned"
        );
        let error = tone.iter().zip(&digital).map(|(t, d)| {
            (t - Complex64::new(f64::from(d.i), f64::from(d.q)) / 32768.0).norm_sqr()
        });
        assert_close(
            error.sum::<f64>() / 20_000.0,
            receiver.quantisation_power(),
            0.05,
        );
    }

    #[test]
    fn the_adc_clips() {
        let radar = RadarSpec::default();
        let spec = perfect();
        let receiver = Receiver::new(&radar, &spec);
        let loud = [Complex64::new(3.0, -3.0), Complex64::new(0.25, -1.0)];
        let clipped = receiver.digitise(&loud, &mut Random::new(1, 1));
        assert_eq!(clipped, [Iq::new(32767, -32768), Iq::new(8192, -32768)]);
    }

    #[test]
    fn the_filter_takes_half_the_power_at_its_corner() {
        let spec = ReceiverSpec {
            antialias_cutoff: 0.8,
            antialias_order: 6,
            ..perfect()
        };
        let radar = RadarSpec::default();
        let receiver = Receiver::new(&radar, &spec);
        assert_close(receiver.filter(0.8).norm_sqr(), 0.5, 1e-9);
        assert_close(receiver.filter(1.6).norm_sqr(), 1.0 / 4097.0, 1e-9);
        // A target beyond the maximum range appears at the aliased range, attenuated by the filter.
        let samples = received(&spec, range_of(250.0), 1);
        assert_close(
            line(&samples, 0.25),
            0.5 / (1.0 + (1.25_f64 / 0.8).powi(12)).sqrt(),
            0.01,
        );
    }

    #[test]
    fn a_rippled_sweep_gives_paired_echoes() {
        // Phase modulation by 2πτ ΔF in n cycles of the sweep gives a pair n bins away, J₁(m) ≈ m/2
        // high.
        let spec = ReceiverSpec {
            sweep_ripple: 1e-4,
            sweep_ripple_cycles: 9.0,
            ..perfect()
        };
        let range = range_of(100.0);
        let samples = received(&spec, range, 1);
        let m = TAU * (2.0 * range / LIGHT) * 1e-4 * 10e9;
        for side in [91.0, 109.0] {
            assert_close(line(&samples, side / 200.0) / 0.5, 0.5 * m, 0.02);
        }
    }

    #[test]
    fn a_bowed_sweep_spreads_what_is_far() {
        // A parabola of ε B at its top turns the phase by 2πτ ε B from the ends to the middle.
        let spec = ReceiverSpec {
            sweep_bow: 2e-4,
            ..perfect()
        };
        let range = range_of(150.0);
        let samples = received(&spec, range, 1);
        let turned = |n: usize| samples[n] * cis(-TAU * 0.75 * n as f64);
        let middle = turned(100) * turned(0).conj();
        let book = TAU * (2.0 * range / LIGHT) * 2e-4 * 10e9;
        assert_close(libm::atan2(middle.im, middle.re), book, 0.02);
    }

    #[test]
    fn phase_noise_grows_with_the_range_as_its_correlation_says() {
        // Variance of the beat's phase: ∫ 2 L(f) 4 sin²(πfτ) df up to half the sample rate, which for
        // 20 dB a decade and these delays is 2 L(f₀) f₀² (2πτ)² f_s / 2.
        let spec = ReceiverSpec {
            phase_noise_dbc_hz: -50.0,
            ..perfect()
        };
        for bins in [60.0, 180.0] {
            let range = range_of(bins);
            let tau = 2.0 * range / LIGHT;
            let book = 2.0 * 1e-5 * 1e10 * (TAU * tau).powi(2) * 100e3;
            let mut sum = 0.0;
            for seed in 0..20 {
                let samples = received(&spec, range, seed);
                let turned: Vec<Complex64> = samples
                    .iter()
                    .enumerate()
                    .map(|(n, s)| s * cis(-TAU * bins / 200.0 * n as f64))
                    .collect();
                sum += turned.iter().map(|s| (s.im / s.re).powi(2)).sum::<f64>() / 200.0;
            }
            assert_close((sum / 20.0).sqrt(), book.sqrt(), 0.05);
        }
    }
}
