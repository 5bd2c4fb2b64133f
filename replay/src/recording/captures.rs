//! Reads the captures of a SigMF document, one per chirp: mirror angle, and the readings of the
//! chair's odometer and inclinometer.

use anyhow::{Result, anyhow, ensure};
use serde_json::Value;

use super::keys::Keys;
use super::motion::Motion;
use super::standard::{self, FREQUENCY, START, list};

/// Default carrier of recordings that do not state one, Hz (paper II-A).
const DEFAULT_CARRIER_HZ: f64 = 94e9;

const ANGLE: &str = "stairscan:mirror_angle_deg";
pub(super) const TRAVEL: &str = "stairscan:travel_m";
pub(super) const TIME: &str = "stairscan:time_s";
pub(super) const PITCH: &str = "stairscan:pitch_deg";

/// Keys of a capture that are read; a key that nearly equals one of them is rejected as misspelt.
const KEYS: [&str; 6] = [START, FREQUENCY, ANGLE, TRAVEL, TIME, PITCH];

/// Maximum magnitude of the chair's pitch, degrees.
const STEEPEST_DEG: f64 = 45.0;
/// Maximum magnitude of the chair's travel in a recording, metres.
const FARTHEST_M: f64 = 1_000.0;
/// Maximum time of a chirp since the recording's first one, seconds; the scanner's 32-bit clock overflows after 71
/// minutes.
const LONGEST_S: f64 = 3_600.0;

/// Carrier, beam angles and chair motion from the captures of a recording.
pub(super) struct Captures {
    pub(super) carrier_hz: f64,
    pub(super) angles_deg: Vec<f64>,
    pub(super) motion: Motion,
}

/// Reads a pitch in degrees, which may be in `global` or in a capture; `None` without the key.
pub(super) fn pitch(keys: &Keys<'_>) -> Result<Option<f64>> {
    keys.optional(PITCH, "a finite pitch within ±45 degrees", |v| {
        v.abs() <= STEEPEST_DEG
    })
}

/// Returns beam angles, motion and carrier of a recording of `scans` scans. If no capture has an
/// angle (recordings of other radars), only the carrier is read. `global_pitch` (degrees) applies
/// where a capture has no pitch.
pub(super) fn parse(
    document: &Value,
    samples_per_chirp: usize,
    scans: usize,
    global_pitch: Option<f64>,
) -> Result<Captures> {
    let captures = list(document, "captures")?;
    let start = first(document)?;
    let carrier_hz = carrier(captures)?;
    let with = |key: &str| captures.iter().any(|c| c.get(key).is_some());
    let mut result = Captures {
        carrier_hz,
        angles_deg: Vec::new(),
        motion: Motion::default(),
    };
    if !with(ANGLE) {
        standard::whole_chirps(document, samples_per_chirp)?;
        if scans > 1 {
            return Err(anyhow!(
                "global stairscan:scans: found {scans}, expected captures with {ANGLE} for as many"
            ));
        }
        return Ok(result);
    }
    if !captures.len().is_multiple_of(scans) {
        return Err(anyhow!(
            "global stairscan:scans: found {scans}, expected a divisor of the {} captures: all \
             scans hold as many",
            captures.len()
        ));
    }
    let order = Order::new(captures.len() / scans);
    let (with_travel, with_time) = (with(TRAVEL), with(TIME));
    let with_pitch = with(PITCH) || global_pitch.is_some();
    for (k, capture) in captures.iter().enumerate() {
        let capture = Keys::of(Some(capture), &format!("captures[{k}]"))?;
        let start = start + k * samples_per_chirp;
        if capture.get("core:sample_start").and_then(Value::as_u64) != Some(start as u64) {
            let expected =
                format!("{start} (one chirp of {samples_per_chirp} samples after another)");
            return Err(capture.wrong("core:sample_start", &expected));
        }
        let angle = capture.number(ANGLE, "a finite angle within ±170 degrees", |v| {
            v.abs() <= 170.0
        })?;
        order
            .check(&result.angles_deg, angle)
            .map_err(|expected| capture.wrong(ANGLE, &expected))?;
        result.angles_deg.push(angle);
        if k + 1 == captures.len() {
            degrees(&result.angles_deg).map_err(|e| anyhow!("captures {ANGLE}: {e}"))?;
        }
        let motion = &mut result.motion;
        if with_travel {
            let expected = "metres of travel, within ±1000, in every capture";
            let travel = capture.number(TRAVEL, expected, |v| v.abs() <= FARTHEST_M)?;
            motion.travel_m.push(travel);
        }
        if with_time {
            let since = motion.time_s.last().copied().unwrap_or(0.0);
            let expected = format!("seconds from {since} to {LONGEST_S}, in every capture");
            let time = capture.number(TIME, &expected, |v| (since..=LONGEST_S).contains(&v))?;
            // A recorder's clock may be coarser than the rows, but goes on during a scan.
            let first = motion.time_s.get(k - k % order.per_scan);
            if (k + 1).is_multiple_of(order.per_scan) && first == Some(&time) {
                let expected =
                    format!("seconds above {time}: the time stands still during the scan");
                return Err(capture.wrong(TIME, &expected));
            }
            motion.time_s.push(time);
        }
        if with_pitch {
            let degrees = pitch(&capture)?.or(global_pitch);
            let degrees =
                degrees.ok_or_else(|| capture.wrong(PITCH, "a pitch in every capture"))?;
            motion.pitch_deg.push(degrees);
        }
    }
    Ok(result)
}

/// Returns the number of the first sample, from which captures count: that of the first capture, because a recording
/// holds nothing else.
fn first(document: &Value) -> Result<usize> {
    let before = standard::before_first(document)?;
    let offset = document["global"][standard::OFFSET].as_u64().unwrap_or(0) as usize;
    ensure!(
        before == 0,
        "captures[0] core:sample_start: found {}, expected {offset}; `cargo sim convert` leaves out the {before} \
         samples before it",
        before + offset
    );
    Ok(offset)
}

/// Refuses angles that must be radians: a scan of at least sixteen, all within half a turn in radians and closer together
/// than any beam in degrees.
///
/// # Errors
/// Names the first and the last angle.
pub fn degrees(angles: &[f64]) -> Result<()> {
    const FEWEST: usize = 16;
    let wide = |angle: &f64| angle.abs() > std::f64::consts::PI;
    let (Some(first), Some(last)) = (angles.first(), angles.last()) else {
        return Ok(());
    };
    ensure!(
        angles.len() < FEWEST || angles.iter().any(wide),
        "{} angles, from {first:.4} to {last:.4}: they look like radians, expected degrees (times 57.2958)",
        angles.len()
    );
    Ok(())
}

/// Returns the first capture's carrier, Hz, and checks the frequencies and the spelling of the keys
/// of all captures.
fn carrier(captures: &[Value]) -> Result<f64> {
    let mut carrier_hz = None;
    for (k, capture) in captures.iter().enumerate() {
        let capture = Keys::of(Some(capture), &format!("captures[{k}]"))?;
        capture.check_spelling(&KEYS)?;
        let found = capture.optional(FREQUENCY, "a frequency above 0 Hz", |v| v > 0.0)?;
        let found = found.unwrap_or(DEFAULT_CARRIER_HZ);
        let first = *carrier_hz.get_or_insert(found);
        if found != first {
            return Err(capture.wrong(FREQUENCY, &format!("{first}, that of the first capture")));
        }
    }
    Ok(carrier_hz.unwrap_or(DEFAULT_CARRIER_HZ))
}

/// Required order of the angles: strictly monotonic within a scan, reversed in the next scan.
struct Order {
    /// Number of captures, and so of angles, of a scan.
    per_scan: usize,
}

impl Order {
    fn new(per_scan: usize) -> Self {
        Self { per_scan }
    }

    /// Checks whether `angle` may follow the angles `before` (degrees, those of all captures so
    /// far); the error describes the expected angle.
    fn check(&self, before: &[f64], angle: f64) -> Result<(), String> {
        let (scan, place) = (before.len() / self.per_scan, before.len() % self.per_scan);
        let this = &before[before.len() - place..];
        match *this {
            [] => Ok(()),
            [.., a, b] if (angle - b) * (b - a) > 0.0 => Ok(()),
            [last] if angle != last && self.turned(before, scan, angle - last) => Ok(()),
            [last] if angle != last => Err(format!(
                "angles that {} in scan {}: they {} in the scan before",
                if angle > last { "fall" } else { "rise" },
                scan + 1,
                if angle > last { "rise" } else { "fall" },
            )),
            _ => Err(format!(
                "angles strictly in order, without repetition, within scan {}",
                scan + 1
            )),
        }
    }

    /// Whether a scan that begins with the angle difference `way` runs opposite to the previous
    /// scan; true for the first scan.
    fn turned(&self, before: &[f64], scan: usize, way: f64) -> bool {
        let Some(start) = scan.checked_sub(1).map(|s| s * self.per_scan) else {
            return true;
        };
        (before[start + 1] - before[start]) * way < 0.0
    }
}
