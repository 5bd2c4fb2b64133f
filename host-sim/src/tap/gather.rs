//! Collects scans into recordings, within the limits of the format.
//!
//! A recording contains consecutive scans of the same angles, alternately forward and backward. A new recording
//! begins with: a scan with missing rows (which is a recording of its own, without them), the scan after one
//! that was left out, other settings of the module, a second scan in the same direction, a guard sweep after a full
//! scan.

use stairscan::config::{RadarConfig, SweepConfig};

use super::beside::Beside;
use super::kinds;
use super::mounting::Mounting;
use super::scans::Scan;
use super::sweep::{self, Sweep};
use crate::live::Ms;
use crate::recording::{Metadata, Recording};
use crate::setup::Kind;

/// Minimum number of rows with a chirp for a scan to be recorded.
const FEWEST: usize = 3;
/// Maximum duration of a recording, ms: one hour.
const LONGEST: Ms = 3_600_000;

/// One of the recordings into which a session's scans are collected, with the times of its scans.
#[derive(Clone, Debug)]
pub struct Part {
    /// The consecutive scans recorded so far.
    pub recording: Recording,
    /// Times of the first and the last trigger of each scan, ms since the session began, in the order of the scans.
    pub times: Vec<(Ms, Ms)>,
    /// Properties that the next scan must share to be added to this recording.
    kind: RecordingKind,
    /// Whether the last scan went from the last angle of its schedule to the first.
    backward: bool,
}

/// Properties common to all scans of a recording: the module's settings, the schedule of angles,
/// and whether no row is missing.
#[derive(Clone, Debug, PartialEq)]
struct RecordingKind {
    radar: RadarConfig,
    chirps: u8,
    /// Schedule of the angles; `None` if the angles follow no schedule.
    sweep: Option<SweepConfig>,
    /// Kind of the scans by their angles; `None` if these do not show it.
    by_angles: Option<Kind>,
    whole: bool,
}

impl Part {
    /// Returns the kind of the scans, by their angles and by what the report port `beside` has received; `None` if it is not
    /// known. `mounting` is that with which they were collected.
    pub fn scans_kind(&self, mounting: &Mounting, beside: &Beside) -> Option<Kind> {
        kinds::kind((self.kind.by_angles, &self.times), mounting, beside)
    }
}

/// Collects scans of a tap into one or several recordings.
#[derive(Clone, Debug)]
pub struct Gather {
    name: String,
    mounting: Mounting,
    parts: Vec<Part>,
    /// Whether the next scan begins a new recording, because the one before it was left out.
    broken: bool,
    scans: usize,
    /// Remarks for the user on scans that were left out or are incomplete.
    pub notes: Vec<String>,
}

impl Gather {
    /// Creates a collector whose recordings are named `name`, `name-2` and so on.
    pub fn new(name: &str, mounting: Mounting) -> Self {
        Self {
            name: name.to_owned(),
            mounting,
            parts: Vec::new(),
            broken: false,
            scans: 0,
            notes: Vec::new(),
        }
    }

    /// Returns the number of scans in all recordings.
    pub fn recorded(&self) -> usize {
        self.parts.iter().map(|part| part.times.len()).sum()
    }

    /// Returns the recordings, in order of time.
    pub fn parts(self) -> Vec<Part> {
        self.parts
    }

    /// Adds the next scan to the last recording or to a new one. A scan that cannot be recorded is
    /// left out, with a remark.
    pub fn take(&mut self, scan: &Scan) {
        self.scans += 1;
        if let Err(why) = self.record(scan) {
            self.broken = true;
            self.note(&format!("left out: {why}"));
        }
    }

    fn note(&mut self, text: &str) {
        self.notes
            .push(format!("scan {} of the tap: {text}", self.scans));
    }

    fn record(&mut self, scan: &Scan) -> Result<(), String> {
        if !scan.begun {
            return Err("the recording began within it".to_owned());
        }
        let Some(radar) = scan.radar else {
            return Err("the module's settings were not received".to_owned());
        };
        if !scan.settings_heard {
            self.note(
                "the module's settings were not received: those of the previous scan are assumed",
            );
        }
        let received = scan.received().count();
        if received < FEWEST {
            return Err(format!("{received} chirps were received ({})", scan.losses));
        }
        let (by_angles, found) = kinds::by_angles(scan, &self.mounting);
        self.check_end(found.as_ref())?;
        if found.is_none() {
            self.note("its angles follow no schedule of this motor: recorded as the shaft's own");
        }
        if scan.lost() > 0 {
            self.note(&format!(
                "{} of {} rows are missing in the recording: {}",
                scan.lost(),
                scan.rows.len(),
                scan.losses
            ));
        }
        let kind = RecordingKind {
            radar,
            chirps: scan.chirps,
            sweep: found.as_ref().map(|found| found.config),
            by_angles,
            whole: scan.lost() == 0,
        };
        self.add(scan, kind, found.as_ref());
        Ok(())
    }

    /// Rejects a scan that ended before the last angle of its schedule, if a schedule of the same angle step is known.
    fn check_end(&self, found: Option<&Sweep>) -> Result<(), String> {
        let Some(found) = found else { return Ok(()) };
        let angle = |row: usize| {
            let row = u16::try_from(row).unwrap_or(u16::MAX);
            found.config.angle(row)
        };
        let rows = (found.rows.iter().min(), found.rows.iter().max());
        let (Some(first_row), Some(last_row)) = rows else {
            return Ok(());
        };
        let (low, high) = (angle(*first_row), angle(*last_row));
        let before = self.parts.last().and_then(|part| part.kind.sweep);
        let reported = [self.mounting.sweep, self.mounting.guard];
        let known = match reported {
            [None, None] => [before, None],
            _ => reported,
        };
        let last = |known: &SweepConfig| known.angle(known.angle_count.saturating_sub(1));
        // The whole schedule is none that has ended early, whatever others are known.
        if (known.iter().flatten()).any(|known| (low, high) == (known.first_angle, last(known))) {
            return Ok(());
        }
        for known in known.into_iter().flatten() {
            let within = low >= known.first_angle && high <= last(&known);
            if within && sweep::is_same_step(&found.config, &known) {
                let degrees = |angle: i32| f64::from(angle) / 1000.0;
                return Err(format!(
                    "it went from {}° to {}° only, of {}° to {}°",
                    degrees(low),
                    degrees(high),
                    degrees(known.first_angle),
                    degrees(last(&known))
                ));
            }
        }
        Ok(())
    }

    fn add(&mut self, scan: &Scan, kind: RecordingKind, found: Option<&Sweep>) {
        let backward = match (scan.rows.first(), scan.rows.last()) {
            (Some(first), Some(last)) => {
                let plane = self.mounting.setup.plane;
                sweep::beam(last.angle, plane) < sweep::beam(first.angle, plane)
            }
            _ => false,
        };
        let times = (scan.rows[0].at, scan.rows[scan.rows.len() - 1].at);
        let follows = |part: &Part| {
            let since = times.1.saturating_sub(part.times[0].0);
            kind.whole
                && kind.sweep.is_some()
                && part.kind == kind
                && part.backward != backward
                && since < LONGEST
        };
        let broken = std::mem::take(&mut self.broken);
        if broken || !self.parts.last().is_some_and(follows) {
            if self.parts.last().is_some() {
                let name = self.name(self.parts.len() + 1);
                self.note(&format!("begins another recording, {name}"));
            }
            let part = self.begin(kind, backward);
            self.parts.push(part);
        }
        let plane = self.mounting.setup.plane;
        let Some(part) = self.parts.last_mut() else {
            return;
        };
        part.backward = backward;
        part.times.push(times);
        let begun = part.times[0].0;
        let meta = &mut part.recording.meta;
        meta.sequence.scans = part.times.len();
        for (k, row) in scan.rows.iter().enumerate() {
            let Some(chirp) = &row.chirp else { continue };
            let scheduled = found.map(|found| {
                let row = found.rows[k] as i32;
                found.config.first_angle + found.config.angle_step * row
            });
            let angle = scheduled.unwrap_or(sweep::beam(row.angle, plane));
            meta.angles_deg.push(f64::from(angle) / 1000.0);
            meta.motion
                .time_s
                .push(row.at.saturating_sub(begun) as f64 / 1000.0);
            part.recording.samples.extend(chirp);
        }
    }

    fn name(&self, number: usize) -> String {
        match number {
            1 => self.name.clone(),
            n => format!("{}-{n}", self.name),
        }
    }

    fn begin(&self, kind: RecordingKind, backward: bool) -> Part {
        let RadarConfig {
            carrier_khz,
            bandwidth_khz,
            samples,
            real,
        } = kind.radar;
        let values = f64::from(samples) * if real { 2.0 } else { 1.0 };
        let rate = |us: u32| values * 1e6 / f64::from(us.max(1));
        Part {
            recording: Recording {
                name: self.name(self.parts.len() + 1),
                meta: Metadata {
                    description:
                        "tap of the radar link; times are those at which triggers were received"
                            .to_owned(),
                    sample_rate_hz: self.mounting.chirp_us.map(rate),
                    carrier_hz: f64::from(carrier_khz) * 1e3,
                    bandwidth_hz: f64::from(bandwidth_khz) * 1e3,
                    samples_per_chirp: usize::from(samples),
                    chirps_per_row: (kind.chirps > 1).then_some(kind.chirps),
                    real,
                    mirror: Some(self.mounting.setup.clone()),
                    ..Metadata::default()
                },
                samples: Vec::new(),
            },
            times: Vec::new(),
            kind,
            backward,
        }
    }
}
