//! Checks of vibrations, run-out and drifts: how far phases may move while the simulator's approximations hold.

use core::f64::consts::TAU;

use anyhow::{Result, ensure};

use super::number::numbers;
use crate::scene::spec::{MirrorSpec, MountSpec, SceneSpec};

/// Maximum speed of a vibration, m/s. In a chirp of 1 ms an echo at 94 GHz then turns by an eighth of a turn, which the
/// parabola through three times of the chirp follows to 0.5 %.
const MAX_VIBRATION_M_S: f64 = 0.2;
/// Maximum displacement of the mirror by drift in a scan, metres: a tenth of a range bin.
const MAX_OFFSET_DRIFT_M: f64 = 1e-3;
/// Maximum shift of a chirp's last sample by the slope's drift in a scan, samples, which is applied to first order.
const MAX_SLOPE_DRIFT: f64 = 0.05;

/// Checks the vibration of the chair.
pub fn mount(m: &MountSpec) -> Result<()> {
    numbers(
        "mount.",
        &[
            ("vibration_m", m.vibration_m, (0.0, 2e-3)),
            ("vibration_hz", m.vibration_hz, (0.1, 200.0)),
            ("vibration_up_deg", m.vibration_up_deg, (-180.0, 180.0)),
            ("vibration_phase_deg", m.vibration_phase_deg, (0.0, 360.0)),
        ],
    )?;
    let speed = TAU * m.vibration_hz * m.vibration_m;
    ensure!(
        speed <= MAX_VIBRATION_M_S,
        "mount.vibration_m: {}: expected at most {MAX_VIBRATION_M_S} m/s at vibration_hz, not {speed:.2}",
        m.vibration_m
    );
    Ok(())
}

/// Checks run-out and drift of the mirror.
pub fn mirror(m: &MirrorSpec) -> Result<()> {
    numbers(
        "mirror.",
        &[
            ("shaft_runout_m", m.shaft_runout_m, (0.0, 1e-3)),
            ("shaft_runout_cycles", m.shaft_runout_cycles, (0.0, 100.0)),
            (
                "shaft_runout_phase_deg",
                m.shaft_runout_phase_deg,
                (0.0, 360.0),
            ),
            ("offset_drift_m_s", m.offset_drift_m_s, (-0.01, 0.01)),
        ],
    )
}

/// Checks how far the drifts go in the `scan_s` seconds of a scan.
pub fn drifts(s: &SceneSpec, scan_s: f64) -> Result<()> {
    let offset = (s.mirror.offset_drift_m_s * scan_s).abs();
    ensure!(
        offset <= MAX_OFFSET_DRIFT_M,
        "mirror.offset_drift_m_s: {}: expected at most {MAX_OFFSET_DRIFT_M} m in a scan, not {offset:.4}",
        s.mirror.offset_drift_m_s
    );
    let samples = (s.radar.samples_per_chirp * s.radar.values_per_sample()) as f64;
    let slope = (s.receiver.slope_drift_s * scan_s).abs() * samples;
    ensure!(
        slope <= MAX_SLOPE_DRIFT,
        "receiver.slope_drift_s: {}: expected a chirp's end to shift by at most {MAX_SLOPE_DRIFT} samples in a \
         scan, not {slope:.3}",
        s.receiver.slope_drift_s
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    fn refused(keys: &str) -> String {
        let text = format!("{keys}\n[[floor]]\nmaterial = \"concrete\"\n");
        Scene::parse(&text).err().unwrap().to_string()
    }

    #[test]
    fn what_the_approximations_do_not_follow_is_refused_by_its_key() {
        for (keys, message) in [
            (
                "[mount]\nvibration_m = 1e-3\nvibration_hz = 60.0",
                "mount.vibration_m: 0.001: expected at most 0.2 m/s at vibration_hz, not 0.38",
            ),
            (
                "[mount]\nvibration_hz = 0.0",
                "mount.vibration_hz: 0: expected a number from 0.1 to 200",
            ),
            (
                "[mirror]\noffset_drift_m_s = 1e-3",
                "mirror.offset_drift_m_s: 0.001: expected at most 0.001 m in a scan, not 0.0013",
            ),
            (
                "[mirror]\nshaft_runout_m = -1e-6",
                "mirror.shaft_runout_m: -0.000001: expected a number from 0 to 0.001",
            ),
            (
                "[receiver]\nslope_drift_s = 1e-3",
                "receiver.slope_drift_s: 0.001: expected a chirp's end to shift by at most 0.05 samples in a scan",
            ),
            (
                "[receiver]\ntrigger_jitter_s = nan",
                "receiver.trigger_jitter_s: NaN: expected a number from 0 to 0.001",
            ),
            (
                "[sweep]\nrow_s = 0.0",
                "sweep.row_s: 0: expected a number from 0.0001 to 1",
            ),
        ] {
            let error = refused(keys);
            assert!(error.contains(message), "{keys}: {error}");
        }
    }
}
