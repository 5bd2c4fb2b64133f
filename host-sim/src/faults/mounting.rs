//! Faults of what the scanner believes of its mounting. The samples stay what they are, so that these are
//! exact: what is real is another number than the recording says.

use super::signal::Signal;

/// One way or the other.
fn way(signal: &mut Signal) -> f64 {
    if signal.random.chance(0.5) { 1.0 } else { -1.0 }
}

/// All angles are off by `degrees`: the shaft was homed wrong, or the chair is pitched and nobody says so.
pub fn angle_offset(signal: &mut Signal, degrees: f64) {
    let off = degrees * way(signal);
    let angles = signal.recording.meta.angles_deg.iter_mut();
    angles.for_each(|angle| *angle += off);
}

/// The mirror is `metres` higher or lower than believed.
pub fn height(signal: &mut Signal, metres: f64) {
    let off = metres * way(signal);
    signal.set_mirror(|mirror| mirror.mount_height_m += off);
}

/// The mirror is `metres` farther from the radar or nearer than believed.
pub fn offset(signal: &mut Signal, metres: f64) {
    let off = metres * way(signal);
    signal.set_mirror(|mirror| mirror.offset_m = (mirror.offset_m + off).max(0.01));
}

/// The sweep is wider or narrower by `share` than believed.
pub fn bandwidth(signal: &mut Signal, share: f64) {
    let off = share * way(signal);
    signal.recording.meta.bandwidth_hz *= 1.0 + off;
}
