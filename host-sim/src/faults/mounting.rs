//! Errors of the configured mounting. The samples are unchanged, so that these faults are exact: the
//! recording states another value than the real one.

use super::signal::Signal;

/// Returns a random sign.
fn way(signal: &mut Signal) -> f64 {
    if signal.random.chance(0.5) { 1.0 } else { -1.0 }
}

/// All angles are off by `degrees`: wrong homing, or a pitched chair without a reported pitch.
pub fn angle_offset(signal: &mut Signal, degrees: f64) {
    let off = degrees * way(signal);
    let angles = signal.recording.meta.angles_deg.iter_mut();
    angles.for_each(|angle| *angle += off);
}

/// The mirror is `metres` higher or lower than configured.
pub fn height(signal: &mut Signal, metres: f64) {
    let off = metres * way(signal);
    signal.set_mirror(|mirror| mirror.mount_height_m += off);
}

/// The mirror is `metres` farther from the radar or nearer than configured.
pub fn offset(signal: &mut Signal, metres: f64) {
    let off = metres * way(signal);
    signal.set_mirror(|mirror| mirror.offset_m = (mirror.offset_m + off).max(0.01));
}

/// The chirp's bandwidth is `share` larger or smaller than configured.
pub fn bandwidth(signal: &mut Signal, share: f64) {
    let off = share * way(signal);
    signal.recording.meta.bandwidth_hz *= 1.0 + off;
}
