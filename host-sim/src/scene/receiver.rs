//! From the antenna to the samples, with everything that goes wrong on the way.

use core::f64::consts::{PI, TAU};

use num_complex::Complex64;
use stairscan::Iq;

use super::maths::{LIGHT, Random, amplitude, cis, power};
use super::spec::{RadarSpec, ReceiverSpec};

/// Boltzmann's constant times the reference temperature of noise figures, W/Hz.
const KT0: f64 = 1.380_649e-23 * 290.0;

/// Frequency at which the scene file states the phase noise, Hz.
const PHASE_NOISE_OFFSET: f64 = 100e3;

/// The receiver of one scene.
pub struct Receiver<'a> {
    radar: &'a RadarSpec,
    spec: &'a ReceiverSpec,
}

impl<'a> Receiver<'a> {
    /// The receiver that a scene describes.
    pub fn new(radar: &'a RadarSpec, spec: &'a ReceiverSpec) -> Self {
        Self { radar, spec }
    }

    /// Amplitude at the ADC, in full scales, of an echo √σ/(r₁r₂) of 1/m: the radar equation
    /// P_r = P_t G² λ² σ / ((4π)³ r⁴ L) (Skolnik, Introduction to Radar Systems, eq. 1.8).
    pub fn gain(&self, antenna_gain_dbi: f64) -> f64 {
        let wavelength = LIGHT / self.radar.carrier_hz;
        let four_pi = 4.0 * PI;
        let budget = self.radar.tx_power_dbm - self.radar.system_loss_db - self.spec.full_scale_dbm;
        amplitude(budget) * power(antenna_gain_dbi) * wavelength / (four_pi * four_pi.sqrt())
    }

    /// Beat frequency of an echo from `range` metres (from the radar), cycles per sample:
    /// 2R/c · B/Ns.
    pub fn beat(&self, range: f64) -> f64 {
        2.0 * range * self.radar.bandwidth_hz / (LIGHT * self.radar.samples_per_chirp as f64)
    }

    /// The samples' times, in samples, as the sweep's frequency has them: where the sweep runs ahead of
    /// its straight line, the beat tones are further on (Griffiths, IEE Proc. F 138, 1991). The bow is
    /// a parabola that starts and ends on the line.
    pub fn times(&self) -> Vec<f64> {
        let n = self.radar.samples_per_chirp as f64;
        (0..self.radar.samples_per_chirp)
            .map(|k| {
                let x = k as f64 / n;
                let bow = self.spec.sweep_bow * 4.0 * x * (1.0 - x);
                let turn = TAU * self.spec.sweep_ripple_cycles * x;
                let ripple = self.spec.sweep_ripple * libm::sin(turn);
                k as f64 + (bow + ripple) * n
            })
            .collect()
    }

    /// The anti-alias filter's response to `frequency` cycles per sample: Butterworth, from the product
    /// over its poles.
    pub fn filter(&self, frequency: f64) -> Complex64 {
        let order = f64::from(self.spec.antialias_order);
        let s = Complex64::new(0.0, frequency / self.spec.antialias_cutoff);
        (0..self.spec.antialias_order).fold(Complex64::ONE, |response, k| {
            let pole = cis(PI * (2.0 * f64::from(k) + order + 1.0) / (2.0 * order));
            response * -pole / (s - pole)
        })
    }

    /// Power of the thermal noise at the ADC in squared full scales, both channels: k T₀ F f_s over the
    /// power that fills the ADC.
    pub fn noise_power(&self) -> f64 {
        let watts = KT0 * power(self.spec.noise_figure_db) * self.radar.sample_rate_hz;
        watts * 1e3 / power(self.spec.full_scale_dbm)
    }

    /// Mean square of the quantisation error of both channels: a twelfth of a squared step each.
    pub fn quantisation_power(&self) -> f64 {
        let step = 2.0 / libm::exp2(f64::from(self.spec.adc_bits));
        2.0 * step * step / 12.0
    }

    /// Deviation of the sample times of one chirp by phase noise, in samples.
    ///
    /// A phase noise that falls with 20 dB a decade is white frequency noise of density 2 f² L(f), and
    /// mixing with its own echo leaves the phase 2πτ δf(t) (range correlation for f τ ≪ 1; Budge and
    /// Burt, Range correlation effects in radars, 1993): the same as a sweep off its line by δf.
    pub fn phase_noise(&self, random: &mut Random) -> Vec<f64> {
        let offset = PHASE_NOISE_OFFSET;
        let density = 2.0 * offset * offset * power(self.spec.phase_noise_dbc_hz);
        let deviation = (0.5 * density * self.radar.sample_rate_hz).sqrt();
        let samples = self.radar.samples_per_chirp;
        let scale = deviation * samples as f64 / self.radar.bandwidth_hz;
        (0..samples).map(|_| scale * random.normal()).collect()
    }

    /// The last stages: noise, I/Q imbalance, offsets, and the ADC.
    pub fn digitise(&self, analog: &[Complex64], random: &mut Random) -> Vec<Iq> {
        let noise = self.noise_power();
        let offset = Complex64::new(self.spec.dc_i, self.spec.dc_q);
        analog
            .iter()
            .map(|s| {
                let skewed = self.imbalance(s + random.complex(noise)) + offset;
                Iq::new(self.convert(skewed.re), self.convert(skewed.im))
            })
            .collect()
    }

    /// Q with another gain than I and not quite at right angles to it; the image lies
    /// (1 + 2g cos φ + g²) / (1 - 2g cos φ + g²) below the signal (Razavi, RF Microelectronics, sec. 4.2).
    pub fn imbalance(&self, s: Complex64) -> Complex64 {
        let gain = amplitude(self.spec.iq_gain_db);
        let (sin, cos) = libm::sincos(self.spec.iq_phase_deg.to_radians());
        Complex64::new(s.re, gain * (s.im * cos + s.re * sin))
    }

    /// One channel of the ADC: clipped, rounded, left-aligned in 16 bits.
    fn convert(&self, x: f64) -> i16 {
        let half = libm::exp2(f64::from(self.spec.adc_bits) - 1.0);
        let code = libm::floor(x * half + 0.5).clamp(-half, half - 1.0);
        (code * (32768.0 / half)) as i16
    }
}
