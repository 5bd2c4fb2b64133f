//! Guard sweeps of a chair that stands: one noiseless sweep in, several noisy sweeps out.
//!
//! The simulator computes the echoes anew for every sweep of a sequence. From one place they are
//! the same, and only the receiver's noise changes. It is added here as the simulator's receiver
//! adds it. Jitter of the mirror and phase noise stay those of the first sweep: a hundredth of the
//! beam's width, and 60 dB below the thermal noise.

use anyhow::Result;
use stairscan::Iq;

use host_sim::recording::Recording;
use host_sim::scene::Scene;
use host_sim::scene::maths::{Random, power};
use host_sim::scene::spec::SceneSpec;
use host_sim::setup;
use host_sim::sweeps::scenes::coarse;

/// Time from row to row, and period of the guard sweeps, seconds: those of the random guard recordings.
const ROW_S: f64 = 0.0028;
const SWEEP_S: f64 = 0.1;
/// Noise figure at which the simulated receiver's noise is negligible, dB.
const NOISELESS_DB: f64 = -300.0;
/// Boltzmann's constant times the reference temperature of noise figures, W/Hz.
const KT0: f64 = 1.380_649e-23 * 290.0;
/// Full scale of I and of Q in a recording, whose samples have 16 bits.
const FULL_SCALE: f64 = 32768.0;
/// Stream of the random numbers from which the receiver's noise is drawn; the scene's streams are others.
const STREAM: u64 = 0x4e4f_4953_4500;

/// The receiver's thermal noise and quantisation.
struct Noise {
    /// Standard deviation of the noise in I, and equally in Q, in units of the recording's 16-bit samples.
    deviation: f64,
    /// Difference of neighbouring codes of the converter, in units of the recording's 16-bit samples.
    step: f64,
}

impl Noise {
    /// Returns noise and quantisation of a scene's receiver. The noise power k T₀ F f_s is relative to the power that
    /// fills the converter, and half of it is in each channel.
    fn of(spec: &SceneSpec) -> Self {
        let receiver = &spec.receiver;
        let watts = KT0 * power(receiver.noise_figure_db) * spec.radar.sample_rate_hz;
        let share = watts * 1e3 / power(receiver.full_scale_dbm);
        Self {
            deviation: FULL_SCALE * (0.5 * share).sqrt(),
            step: FULL_SCALE / libm::exp2(f64::from(receiver.adc_bits) - 1.0),
        }
    }

    /// Returns one channel's sample plus noise, rounded and clipped to the converter's codes. `normal` is a standard
    /// normal deviate.
    fn on(&self, sample: i16, normal: f64) -> i16 {
        let noisy = f64::from(sample) + self.deviation * normal;
        let code = libm::floor(noisy / self.step + 0.5) * self.step;
        code.clamp(-FULL_SCALE, FULL_SCALE - self.step) as i16
    }

    /// Returns a chirp with new noise in every sample, rounded to the converter's codes.
    fn added(&self, chirp: &[Iq], random: &mut Random) -> Vec<Iq> {
        let mut drawn = vec![0.0; 2 * chirp.len()];
        random.normals(&mut drawn);
        let (pairs, _) = drawn.as_chunks::<2>();
        let noisy = |(s, [i, q]): (&Iq, &[f64; 2])| Iq::new(self.on(s.i, *i), self.on(s.q, *q));
        chirp.iter().zip(pairs).map(noisy).collect()
    }
}

/// Returns `count` guard sweeps of a scene from one place, alternately forward and backward.
///
/// # Errors
/// Names the part from which no scene can be built.
pub fn sweeps(mut spec: SceneSpec, count: usize, name: &str, seed: u64) -> Result<Recording> {
    coarse(&mut spec);
    let noise = Noise::of(&spec);
    spec.receiver.noise_figure_db = NOISELESS_DB;
    let mut recording = Scene::new(spec)?.simulate(name, seed);
    let chirps = std::mem::take(&mut recording.samples);
    let chirps: Vec<&[Iq]> = chirps.chunks(recording.meta.samples_per_chirp).collect();
    let angles = std::mem::take(&mut recording.meta.angles_deg);
    let pitch = recording.meta.motion.pitch_deg.first().copied();
    let mut random = Random::new(seed, STREAM);
    let meta = &mut recording.meta;
    meta.motion.pitch_deg.clear();
    for sweep in 0..count {
        let mut rows: Vec<usize> = (0..angles.len()).collect();
        if sweep % 2 == 1 {
            rows.reverse();
        }
        for (k, row) in rows.into_iter().enumerate() {
            recording
                .samples
                .extend(noise.added(chirps[row], &mut random));
            meta.angles_deg.push(angles[row]);
            meta.motion
                .time_s
                .push(sweep as f64 * SWEEP_S + k as f64 * ROW_S);
            meta.motion.travel_m.push(0.0);
            meta.motion.pitch_deg.extend(pitch);
        }
    }
    meta.sequence.scans = count;
    setup::mark_guard(&mut recording);
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capability::body::Body;
    use crate::capability::condition::{Condition, scene};

    fn spec() -> SceneSpec {
        scene(Body::Level, &Condition::REFERENCE, 2, 7).spec
    }

    /// Returns [mean, standard deviation] of I over all samples.
    fn spread(samples: &[Iq]) -> [f64; 2] {
        let of = |f: &dyn Fn(f64) -> f64| {
            samples.iter().map(|s| f(f64::from(s.i))).sum::<f64>() / samples.len() as f64
        };
        let mean = of(&|i| i);
        [mean, of(&|i| (i - mean) * (i - mean)).sqrt()]
    }

    /// The added noise equals the simulator's own: a scene without transmitter contains only noise.
    #[test]
    fn the_noise_is_that_of_the_simulator() {
        let mut silent = spec();
        silent.radar.tx_power_dbm = -300.0;
        silent.receiver.leakage_dbfs = -300.0;
        silent.receiver.mirror_echo_dbfs = -300.0;
        let made = sweeps(silent.clone(), 1, "silent", 3).unwrap();
        coarse(&mut silent);
        let own = Scene::new(silent).unwrap().simulate("silent", 3);
        assert_eq!(made.samples.len(), own.samples.len());
        let [made, own] = [made, own].map(|recording| spread(&recording.samples));
        assert!((made[0] - own[0]).abs() < 3.0, "{made:?} {own:?}");
        assert!((made[1] / own[1] - 1.0).abs() < 0.03, "{made:?} {own:?}");
    }

    #[test]
    fn sweeps_see_the_same_ground_in_new_noise() {
        let recording = sweeps(spec(), 3, "level", 7).unwrap();
        assert_eq!((recording.scans(), recording.chirps()), (3, 3 * 31));
        let [first, second, third] = [0, 1, 2].map(|k| recording.scan(k));
        assert_ne!(first.samples, third.samples);
        assert_eq!(first.meta.angles_deg, third.meta.angles_deg);
        assert!(second.meta.angles_deg[0] > second.meta.angles_deg[30]);
        let far = first.samples.iter().zip(&third.samples);
        let off = far
            .map(|(a, b)| (f64::from(a.i) - f64::from(b.i)).powi(2))
            .sum::<f64>();
        let noise = Noise::of(&spec()).deviation;
        let off = (off / first.samples.len() as f64).sqrt();
        assert!(
            (off / noise / 2f64.sqrt() - 1.0).abs() < 0.05,
            "{off} {noise}"
        );
    }
}
