//! Vibration of the mirror's shaft while its step motor turns: an error of the beam's angle.

use super::spec::MirrorSpec;

/// Full step of the motor, degrees: 200 per turn.
const FULL_STEP_DEG: f64 = 1.8;

/// Returns whether the mirror turns during a chirp.
pub(super) fn turns(mirror: &MirrorSpec) -> bool {
    mirror.turn_deg_s > 0.0
}

/// Returns the angle error by vibration of the shaft while it passes `angle_deg`, degrees; 0 unless it turns.
pub(super) fn vibration_deg(mirror: &MirrorSpec, angle_deg: f64) -> f64 {
    if !turns(mirror) {
        return 0.0;
    }
    let phase = 360.0 * angle_deg / FULL_STEP_DEG + mirror.vibration_phase_deg;
    mirror.vibration_deg * libm::sin(phase.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vibration_moves_the_beam_by_its_amplitude() {
        let mirror = MirrorSpec {
            turn_deg_s: 60.0,
            vibration_deg: 0.05,
            vibration_phase_deg: 90.0,
            ..MirrorSpec::default()
        };
        assert!((vibration_deg(&mirror, 0.0) - 0.05).abs() < 1e-12);
        assert!((vibration_deg(&mirror, 0.9) + 0.05).abs() < 1e-12);
        let most = (0..1000).map(|k| vibration_deg(&mirror, f64::from(k) * 0.01).abs());
        assert!(most.fold(0.0, f64::max) <= 0.05);
    }
}
