//! Converts a recording's metadata to the scanner's configuration: fixed-point numbers as in
//! commands, rounded by the function that commands use.

use anyhow::{Result, anyhow, ensure};
use stairscan::config::{Config, MountConfig, Plane, RadarConfig, SweepConfig, to_fixed};
use stairscan::motion::Mode;

use crate::recording::{META_SUFFIX, Recording};

/// Maximum deviation of a chirp's angle from the schedule, as a fraction of an angle step: a shaft
/// is not exact.
const OFF_SCHEDULE: f64 = 0.1;

/// Metadata key that says whether a recording contains full scans or guard sweeps.
const MODE: &str = "stairscan:mode";

/// Kind of a recording's scans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Full scans.
    Scans,
    /// Guard sweeps, with few rows.
    Guard,
}

/// Returns the kind of scans of `recording`.
///
/// # Errors
/// The value is unknown; the message names the key and the value.
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

/// Refuses a recording of guard sweeps.
///
/// # Errors
/// The recording contains guard sweeps; the message names it.
pub fn full_scans(recording: &Recording) -> Result<()> {
    ensure!(
        kind(recording)? == Kind::Scans,
        "{}: holds guard sweeps, expected full scans; replay, report, score, live --demo and faults --guard take \
         guard sweeps",
        recording.name
    );
    Ok(())
}

/// Returns the radar's part of the scanner's configuration for any recording.
///
/// # Errors
/// A key is out of range; the message names it.
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

/// Returns the motion mode that applies without motion sentences: standing for a single scan
/// without motion data, else automatic.
pub fn mode(recording: &Recording) -> Mode {
    let alone = recording.scans() == 1 && recording.meta.motion.travel_m.is_empty();
    if alone { Mode::Standing } else { Mode::Auto }
}

/// Returns the duration of a chirp, µs; `None` if the recording contains no sample rate, or the
/// duration is not 1 µs to 1 s.
pub fn chirp_us(recording: &Recording) -> Option<u32> {
    let meta = &recording.meta;
    let us = 1e6 * meta.file_samples() as f64 / meta.sample_rate_hz?;
    (1.0..=1e6).contains(&us).then_some(us.round() as u32)
}

/// Assignment of a scan's chirps to equally spaced angles.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// First angle, step and number of angles.
    pub sweep: SweepConfig,
    /// Index in the recording of the chirp at each angle, lowest angle first; `None` if it is
    /// missing.
    pub chirps: Vec<Option<usize>>,
    /// Whether the scan went from the last angle to the first.
    pub backward: bool,
}

/// Returns the angles of scan `scan` (from 0) and their chirps. Missing angles become lost chirps.
///
/// If a recording contains the chair's pitch but not its travel, the angles are shifted by the
/// scan's mean pitch, so that they are relative to the true horizontal. If it contains both, the
/// scanner gets them by motion sentences.
///
/// # Errors
/// The angle of a capture does not fit the others', or the scanner cannot turn to it; the message
/// names it.
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
    // The median difference is the step, refined over the whole sweep.
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

/// Returns the angle that the chair's pitch adds to the angles of a scan, degrees; 0 if the
/// recording has no pitch, or has travel too. Nose up lifts the beam. Angles are positive downwards
/// from the horizontal, or in the height plane from straight down to the front.
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

/// Returns the scanner's configuration for scan `scan` (from 0) of a recording, on top of `base`
/// (seed, estimator, ...), and the assignment of its chirps to angles.
///
/// # Errors
/// A key is missing, or the scanner cannot work with its value; the message names it.
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
            // The results of a calibration, which recordings do not contain.
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
