//! Draws of the scanner of a random scene.

use crate::scene::maths::{LIGHT, Random};
use crate::scene::spec::{PlaneSpec, SceneSpec};

/// Draws a scanner of the paper's design with its tolerances: dirt and rain on the lens, mounting
/// errors.
pub fn equipment(scene: &mut SceneSpec, rng: &mut Random) {
    scene.radar.system_loss_db = rng.between(10.0, 46.0);
    scene.mirror.bias_deg = (0.15 * rng.normal()).clamp(-0.4, 0.4);
    scene.mirror.jitter_deg = rng.between(0.005, 0.05);
    scene.mirror.sidelobe_db = rng.between(18.0, 24.0);
    scene.mount.height_error_m = (0.002 * rng.normal()).clamp(-0.005, 0.005);
    let receiver = &mut scene.receiver;
    receiver.leakage_dbfs = rng.between(-14.0, -8.0);
    receiver.mirror_echo_dbfs = rng.between(-30.0, -22.0);
    receiver.dc_i = rng.between(-0.1, 0.1);
    receiver.dc_q = rng.between(-0.1, 0.1);
    receiver.iq_gain_db = rng.between(-0.2, 0.2);
    receiver.iq_phase_deg = rng.between(-1.2, 1.2);
    receiver.sweep_bow = rng.between(-1.5e-4, 1.5e-4);
    receiver.sweep_ripple = rng.between(0.0, 4e-5);
    receiver.sweep_ripple_cycles = rng.between(2.0, 12.0);
}

/// Length of a chirp, s: the paper's 200 samples at the default rate.
const CHIRP_S: f64 = 1e-3;

/// Maximum number of rows with a transform of 256 points: the scanner's map of 65,536 cells then holds them, whatever
/// part of the range axis the mirror's own echo takes.
const ROWS_AT_256: f64 = 255.0;

/// Draws a scanner of another design: replaces mounting, beam, bandwidth, samples, angles and pitch.
///
/// Mount heights of 25 to 80 cm are available at foot rest, battery box and arm rest of a powered
/// wheelchair (ISO 7176-5 dimensions). Beams of 3 to 8° are those of horns and lenses of 25 to 75
/// mm at 94 GHz (70 λ/D). W-band modules sweep 4 to 10 GHz. A pitch of ±5° is a ramp of 1:12, the
/// steepest that ISO 21542 allows, or a soft front tyre.
pub fn wide(scene: &mut SceneSpec, rng: &mut Random) {
    let radar = &mut scene.radar;
    radar.bandwidth_hz = round_to(rng.between(4e9, 10e9), 1e7);
    let resolution = LIGHT / (2.0 * radar.bandwidth_hz);
    // The range that a chair's scanner needs, limited by the longest transform.
    let reach = rng.between(2.8, 5.0);
    radar.samples_per_chirp = ((reach / resolution) as usize).clamp(64, 256);
    radar.sample_rate_hz = radar.samples_per_chirp as f64 / CHIRP_S;
    let mount = &mut scene.mount;
    mount.mirror_offset_m = round_to(rng.between(0.15, 0.30), 1e-3);
    mount.beamwidth_deg = round_to(rng.between(3.0, 8.0), 0.01);
    if mount.plane == PlaneSpec::Depth {
        mount.height_m = round_to(rng.between(0.25, 0.80), 1e-3);
    }
    let sweep = &mut scene.sweep;
    sweep.first_deg = 0.5 * libm::floor(2.0 * rng.between(-20.0, -12.0));
    let last = 0.5 * libm::floor(2.0 * rng.between(44.0, 51.0));
    let rows = if radar.samples_per_chirp > 128 {
        ROWS_AT_256
    } else {
        281.0
    };
    sweep.last_deg = last.min(sweep.first_deg + (rows - 1.0) * sweep.step_deg);
    // Half of the chairs stand level and report no pitch.
    if rng.chance(0.5) {
        scene.mount.pitch_deg = Some(round_to(rng.between(-5.0, 5.0), 0.01));
        scene.mount.pitch_error_deg = (0.05 * rng.normal()).clamp(-0.1, 0.1);
    }
}

/// Rounds `x` to a multiple of `unit`, so that the numbers in a recording's metadata have few digits.
fn round_to(x: f64, unit: f64) -> f64 {
    let per = libm::floor(1.0 / unit + 0.5);
    if per >= 1.0 {
        libm::floor(x * per + 0.5) / per
    } else {
        libm::floor(x / unit + 0.5) * unit
    }
}
