//! From a recording's metadata to the scanner's configuration: the same fixed-point numbers that
//! commands carry, rounded by the same function.

use anyhow::{Result, anyhow, ensure};
use stairscan::config::{Config, MountConfig, Plane, RadarConfig, SweepConfig, to_fixed};
use stairscan::motion::Mode;

use crate::recording::{META_SUFFIX, Recording};

/// Part of an angle step that a capture may lie off the schedule: a shaft is not exact.
const OFF_SCHEDULE: f64 = 0.1;

/// The key that says what a recording's scans are.
const MODE: &str = "stairscan:mode";

/// Kind of a recording's scans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Full scans.
    Scans,
    /// Coarse sweeps of the guard.
    Guard,
}

/// Returns what the scans of `recording` are.
///
/// # Errors
/// Names the key and a value that there is not.
pub fn kind(recording: &Recording) -> Result<Kind> {
    match recording.meta.extra.get(MODE) {
        None => Ok(Kind::Scans),
        Some(mode) if mode.as_str() == Some("guard") => Ok(Kind::Guard),
        Some(mode) => Err(anyhow!(
            "{}.{META_SUFFIX}: global {MODE}: found {mode}, expected \"guard\", or no such key for full scans",
            recording.name
        )),
    }
}

/// Marks the scans of a recording as guard sweeps.
pub fn mark_guard(recording: &mut Recording) {
    recording.meta.extra.insert(MODE.into(), "guard".into());
}

/// Refuses guard sweeps where full scans are wanted.
///
/// # Errors
/// Names the recording.
pub fn full_scans(recording: &Recording) -> Result<()> {
    ensure!(
        kind(recording)? == Kind::Scans,
        "{}: holds guard sweeps, expected full scans; replay, report, score, live --demo and faults --guard take \
         guard sweeps",
        recording.name
    );
    Ok(())
}

/// The radar's part of the configuration, for any recording.
///
/// # Errors
/// Names a key that is out of range.
pub fn radar(recording: &Recording) -> Result<RadarConfig> {
    let meta = &recording.meta;
    let fixed = |value, key| {
        to_fixed(value, 1e3)
            .and_then(|v| u32::try_from(v).ok())
            .ok_or_else(|| {
                anyhow!(
                    "{}.{META_SUFFIX}: {key}: {value} is out of range",
                    recording.name
                )
            })
    };
    Ok(RadarConfig {
        carrier_khz: fixed(meta.carrier_hz, "captures[0] core:frequency")?,
        bandwidth_khz: fixed(meta.bandwidth_hz, "global stairscan:bandwidth_hz")?,
        samples: u16::try_from(meta.samples_per_chirp)?,
        real: meta.real,
    })
}

/// What holds without motion input: a single scan without any was made by a chair that stood.
pub fn mode(recording: &Recording) -> Mode {
    let alone = recording.scans() == 1 && recording.meta.motion.travel_m.is_empty();
    if alone { Mode::Standing } else { Mode::Auto }
}

/// Duration of a chirp, µs; that of the paper's radar where a recording bears no sample rate.
pub fn chirp_us(recording: &Recording) -> Option<u32> {
    let meta = &recording.meta;
    let us = 1e6 * meta.file_samples() as f64 / meta.sample_rate_hz?;
    (1.0..=1e6).contains(&us).then_some(us.round() as u32)
}

/// How a scan's chirps lie on the schedule of angles.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// The equal steps that the scanner turns in.
    pub sweep: SweepConfig,
    /// For each scheduled angle the recording's chirp; `None` where it holds none.
    pub chirps: Vec<Option<usize>>,
    /// Whether the scan was made from the last angle to the first.
    pub backward: bool,
}

/// The equal angle steps that scan `scan` (from 0) was made with. Missing angles become lost chirps.
///
/// A recording that knows the chair's pitch, but not its travel, gets its angles shifted by the scan's
/// mean pitch, so that they count from the true horizontal. Where it knows both, motion sentences
/// bring them to the scanner.
///
/// # Errors
/// Names the capture whose angle does not fit the others', or what the scanner cannot turn to.
pub fn schedule(recording: &Recording, scan: usize) -> Result<Schedule> {
    let name = &recording.name;
    let range = recording.chirps_of(scan);
    let angles = recording.meta.angles_deg.get(range.clone());
    let angles = angles.unwrap_or_default();
    let (Some(&first), Some(&last)) = (angles.first(), angles.last()) else {
        return Err(anyhow!("{name}.{META_SUFFIX}: captures: holds no angle"));
    };
    let low = first.min(last);
    ensure!(
        angles.len() >= 3,
        "{name}.{META_SUFFIX}: captures: {} chirps, expected at least 3 angles for a scan",
        angles.len()
    );
    // The usual difference is the step, refined over the whole sweep.
    let mut differences: Vec<f64> = angles.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    differences.sort_by(f64::total_cmp);
    let step = differences[differences.len() / 2];
    let steps = ((last - first).abs() / step).round();
    let step = (last - first).abs() / steps;
    let sweep = SweepConfig {
        first_angle: angle_fixed(low + lean(recording, scan))?,
        angle_step: angle_fixed(step)?,
        angle_count: u16::try_from(steps as i64 + 1).unwrap_or(u16::MAX),
    };
    sweep
        .validate()
        .map_err(|e| anyhow!("{name}.{META_SUFFIX}: captures: {e}"))?;
    let mut chirps = vec![None; usize::from(sweep.angle_count)];
    for (k, angle) in range.zip(angles) {
        let place = (angle - low) / step;
        let slot = chirps
            .get_mut(place.round() as usize)
            .filter(|_| (place - place.round()).abs() <= OFF_SCHEDULE);
        *slot.ok_or_else(|| {
            anyhow!(
                "{name}.{META_SUFFIX}: captures[{k}] stairscan:mirror_angle_deg: found {angle}, \
                 expected a multiple of {step:.4} degrees from {low}"
            )
        })? = Some(k);
    }
    Ok(Schedule {
        sweep,
        chirps,
        backward: last < first,
    })
}

/// What the chair's pitch adds to the angles of a scan, degrees: nose up lifts the beam. Angles
/// count downwards from the horizontal, or in the height plane from straight down to the front.
fn lean(recording: &Recording, scan: usize) -> f64 {
    let motion = &recording.meta.motion;
    let pitch = (motion.travel_m.is_empty())
        .then(|| motion.mean_pitch_deg(recording.chirps_of(scan)))
        .flatten();
    let height = (recording.meta.mirror.as_ref()).is_some_and(|m| m.plane == Plane::Height);
    match (pitch, height) {
        (None, _) => 0.0,
        (Some(pitch), false) => -pitch,
        (Some(pitch), true) => pitch,
    }
}

fn angle_fixed(degrees: f64) -> Result<i32> {
    to_fixed(degrees, 1e-3).ok_or_else(|| anyhow!("an angle of {degrees} degrees is out of range"))
}

/// The configuration that scan `scan` (from 0) of a recording brings, on top of `base` (seed,
/// estimator, ...).
///
/// # Errors
/// Names the key that is missing or whose value the scanner cannot work with.
pub fn config(recording: &Recording, scan: usize, base: &Config) -> Result<(Config, Schedule)> {
    kind(recording)?;
    let mirror = recording.scan_setup()?;
    let schedule = schedule(recording, scan)?;
    let name = &recording.name;
    let fixed = |value, unit, key| {
        to_fixed(value, unit)
            .ok_or_else(|| anyhow!("{name}.{META_SUFFIX}: global {key}: {value} is out of range"))
    };
    let config = Config {
        radar: radar(recording)?,
        mount: MountConfig {
            mirror_offset: fixed(mirror.offset_m, 1e-5, "stairscan:mirror_offset_m")?,
            mount_height: fixed(mirror.mount_height_m, 1e-5, "stairscan:mount_height_m")?,
            beamwidth: fixed(mirror.beamwidth_deg, 1e-3, "stairscan:beamwidth_deg")?,
            plane: mirror.plane.into(),
            // What a calibration leaves, which no recording knows.
            ..base.mount
        },
        sweep: schedule.sweep,
        ..*base
    };
    config
        .validate()
        .map_err(|e| anyhow!("{name}.{META_SUFFIX}: {e}"))?;
    Ok((config, schedule))
}
