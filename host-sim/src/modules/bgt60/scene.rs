//! Converter codes of the BGT60TR13C for a simulated scene.

use anyhow::Result;

use super::chirp::Chirp;
use crate::recording::Recording;
use crate::scene::Scene;
use crate::scene::spec::{RadarSpec, ReceiverSpec, SceneSpec};

/// Transmitted power at the lowest power setting, dBm: 15 dB below 4 dBm (table 55).
const POWER_DBM: f64 = -11.0;
/// Noise figure of one sideband at 100 kHz, dB (table 55).
const NOISE_FIGURE_DB: f64 = 12.0;
/// Phase noise 100 kHz off the carrier, dBc/Hz (table 54).
const PHASE_NOISE_DBC_HZ: f64 = -80.0;
/// Power at the antenna at which the converter reaches full scale, dBm: 0.655 V peak (table 60),
/// after 14 dB in the mixer (table 55) and 38 dB in the baseband, at 50 Ω.
const FULL_SCALE_DBM: f64 = -45.7;
/// Cutoff of the anti-alias filter, Hz, and its number of poles (table 58).
const CUTOFF_HZ: f64 = 500e3;
const POLES: u32 = 4;

/// Simulates a scan of `scene` with `chirp` behind a lens. Returns a recording with the scene's
/// truth, and for each row the codes of the chip's single converter. The recording's samples have I
/// and Q, although the chip has no Q channel.
///
/// The high-pass filter is left out: 2 dB at the nearest step.
///
/// # Errors
/// Names the reason for which a scene cannot be scanned.
pub fn chirps(scene: &SceneSpec, chirp: &Chirp, seed: u64) -> Result<(Recording, Vec<Vec<u16>>)> {
    let spec = SceneSpec {
        radar: RadarSpec {
            carrier_hz: chirp.carrier_hz(),
            bandwidth_hz: chirp.bandwidth_hz(),
            samples_per_chirp: chirp.samples,
            sample_rate_hz: chirp.rate_hz,
            tx_power_dbm: POWER_DBM,
            ..scene.radar.clone()
        },
        receiver: ReceiverSpec {
            noise_figure_db: NOISE_FIGURE_DB,
            full_scale_dbm: FULL_SCALE_DBM,
            phase_noise_dbc_hz: PHASE_NOISE_DBC_HZ,
            adc_bits: 12,
            antialias_cutoff: CUTOFF_HZ / chirp.rate_hz,
            antialias_order: POLES,
            ..scene.receiver.clone()
        },
        ..scene.clone()
    };
    let recording = Scene::new(spec)?.simulate("bgt60", seed);
    let codes = (recording.samples.chunks_exact(chirp.samples))
        .map(|row| row.iter().map(|x| ((x.i >> 4) + 2048) as u16).collect())
        .collect();
    Ok((recording, codes))
}
