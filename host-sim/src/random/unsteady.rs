//! Draws of what moves and drifts while the scanner scans: the chair's vibration, the shaft's run-out, the oscillator.

use crate::scene::maths::Random;
use crate::scene::spec::SceneSpec;

/// Amplitude of the chair's vibration, metres, and its frequency, Hz: at most 0.19 m/s together.
const VIBRATION_M: (f64, f64) = (5e-5, 5e-4);
const VIBRATION_HZ: (f64, f64) = (5.0, 60.0);
/// Run-out of the mirror's shaft, metres.
const RUNOUT_M: (f64, f64) = (1e-5, 5e-5);
/// Periods of the run-out in a turn: a bent shaft, or the balls of a bearing.
const RUNOUT_CYCLES: [f64; 3] = [1.0, 2.0, 3.0];
/// Times from row to row, s: a mirror that turns, and one that stops at each row.
const ROW_S: [f64; 2] = [4.63e-3, 20.3e-3];

/// Draws vibration, run-out and drifts, from the ranges for which [`SceneSpec`] names the sources.
pub fn unsteady(scene: &mut SceneSpec, rng: &mut Random) {
    scene.sweep.row_s = ROW_S[rng.index(ROW_S.len())];
    let mount = &mut scene.mount;
    mount.vibration_m = logarithmic(rng, VIBRATION_M);
    mount.vibration_hz = logarithmic(rng, VIBRATION_HZ);
    mount.vibration_up_deg = rng.between(0.0, 180.0);
    mount.vibration_phase_deg = rng.between(0.0, 360.0);
    let mirror = &mut scene.mirror;
    mirror.shaft_runout_m = rng.between(RUNOUT_M.0, RUNOUT_M.1);
    mirror.shaft_runout_cycles = RUNOUT_CYCLES[rng.index(RUNOUT_CYCLES.len())];
    mirror.shaft_runout_phase_deg = rng.between(0.0, 360.0);
    mirror.offset_drift_m_s = 5e-7 * rng.normal().clamp(-3.0, 3.0);
    let receiver = &mut scene.receiver;
    receiver.slope_drift_s = 5e-6 * rng.normal().clamp(-3.0, 3.0);
    receiver.carrier_drift_hz_s = 5e5 * rng.normal().clamp(-3.0, 3.0);
    receiver.trigger_jitter_s = rng.between(0.0, 2e-7);
}

/// Draws a number between two limits, uniform in its logarithm.
fn logarithmic(rng: &mut Random, (low, high): (f64, f64)) -> f64 {
    low * libm::exp(libm::log(high / low) * rng.unit())
}
