//! Displacements of mirror and chair while a scan is taken, far below a range bin: they turn the phases of echoes.
//!
//! In: run-out and drift of the mirror, vibration of the chair, the time. Out: by how much the paths become longer, and
//! beat tones in the phases that follow. Echoes and the mirror's own echo turn by different angles, so that a receiver
//! that takes the latter as its reference keeps the difference. [`super::shaft`] has the errors of the beam's angle.

use core::f64::consts::TAU;

use super::Scene;
use super::bundles::{Bundles, Source};
use super::maths::{Vec2, cis};
use super::spec::{MirrorSpec, MountSpec, PlaneSpec};

/// Displacement of the mirror as it changes the ranges, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MirrorShift {
    /// Change of the range of the mirror's own echo.
    pub own: f64,
    /// Change of the ranges of all echoes by way of the mirror.
    pub echoes: f64,
}

impl MirrorShift {
    /// Returns the displacement at the shaft's angle `shaft`, radians, at `time_s`.
    ///
    /// The mirror stands at 45° to its shaft, which is the radar's axis. Moved by a along the axis and by b along the beam,
    /// the way from the radar by the mirror to a target becomes a - b longer.
    pub fn new(mirror: &MirrorSpec, shaft: f64, time_s: f64) -> Self {
        let phase = mirror.shaft_runout_cycles * shaft + mirror.shaft_runout_phase_deg.to_radians();
        let (sin, cos) = libm::sincos(phase);
        let own = mirror.shaft_runout_m * sin + mirror.offset_drift_m_s * time_s;
        Self {
            own,
            echoes: own - mirror.shaft_runout_m * cos,
        }
    }
}

/// Returns whether the chair vibrates.
pub(super) fn vibrates(mount: &MountSpec) -> bool {
    mount.vibration_m > 0.0
}

/// Returns the displacement of the chair by its vibration at `time_s`, metres forward and up.
fn vibration(mount: &MountSpec, time_s: f64) -> Vec2 {
    let phase = TAU * mount.vibration_hz * time_s + mount.vibration_phase_deg.to_radians();
    let (up, forward) = libm::sincos(mount.vibration_up_deg.to_radians());
    Vec2::new(forward, up) * (mount.vibration_m * libm::sin(phase))
}

/// Returns the unit vector, forward and up, of a direction given as a mirror angle, radians.
fn direction(plane: PlaneSpec, angle: f64) -> Vec2 {
    let (sin, cos) = libm::sincos(angle);
    match plane {
        PlaneSpec::Depth => Vec2::new(cos, -sin),
        PlaneSpec::Height => Vec2::new(sin, -cos),
    }
}

impl Scene {
    /// Returns the beat tones as the vibrating chair receives them at `time_s`.
    pub(super) fn shaken(&self, tones: &[&Bundles], time_s: f64) -> Vec<Bundles> {
        let mount = &self.spec.mount;
        let moved = vibration(mount, time_s);
        let wavenumber = self.view().wavenumber;
        let turn = |&Source { out, back, .. }: &Source| {
            let ways = direction(mount.plane, out) + direction(mount.plane, back);
            (cis(-wavenumber * moved.dot(ways)), [out, back])
        };
        tones.iter().map(|bundles| bundles.turned(turn)).collect()
    }
}
