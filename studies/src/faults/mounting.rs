//! Errors of the configured mounting. The samples are unchanged, so that these faults are exact: the
//! recording states another value than the real one.

use super::signal::Signal;

/// Returns +1 or −1 at random: the sign of an error of the mounting.
fn way(signal: &mut Signal) -> f64 {
    if signal.random.chance(0.5) { 1.0 } else { -1.0 }
}

/// The recorded beam angles of all rows are off by `degrees`, up or down at random: wrong homing, or a pitched chair
/// without a reported pitch.
pub fn angle_offset(signal: &mut Signal, degrees: f64) {
    let off = degrees * way(signal);
    let angles = signal.recording.meta.angles_deg.iter_mut();
    angles.for_each(|angle| *angle += off);
}

/// The configured height of the mirror above the ground is off by `metres`, up or down at random.
pub fn height(signal: &mut Signal, metres: f64) {
    let off = metres * way(signal);
    signal.set_mirror(|mirror| mirror.mount_height_m += off);
}

/// The configured distance from the radar to the mirror is off by `metres`, too long or too short at random.
pub fn offset(signal: &mut Signal, metres: f64) {
    let off = metres * way(signal);
    signal.set_mirror(|mirror| mirror.offset_m = (mirror.offset_m + off).max(0.01));
}

/// The configured bandwidth of the chirp is off by a fraction `share` of itself, too large or too small at random.
pub fn bandwidth(signal: &mut Signal, share: f64) {
    let off = share * way(signal);
    signal.recording.meta.bandwidth_hz *= 1.0 + off;
}
