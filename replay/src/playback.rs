//! A recording in the place of the radar module: the simulated hardware of `replay`, with the shaft
//! without a motor, and the data of the emulator's radar module.

use std::cell::RefCell;
use std::rc::Rc;
use std::task::Poll;

use anyhow::Result;
use stairscan::Iq;
use stairscan::config::{Config, Plane, RadarConfig, SweepConfig};
use stairscan::motion::Mode;
use stairscan::scanner::settings::{GuardConfig, MAX_TIME, SweepMode, Sweeping, Timing};
pub use stairscan::scanner::shaft::SimShaft;
use stairscan::scanner::{Micros, Settings};
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::{LinkError, RadarModule};

use crate::motion::Timetable;
use crate::motion::by_trigger::ByTrigger;
use crate::recording::Recording;
use crate::setup::{self, Kind};

/// One scan of a recording: the scanner's configuration for it, and its chirps by angle.
#[derive(Clone, Debug)]
struct Part {
    config: Config,
    chirps: Vec<Option<usize>>,
}

/// A recording that answers triggers with the chirp recorded at their angle, scan after scan.
#[derive(Clone, Debug)]
pub struct Playback<'a> {
    recording: &'a Recording,
    parts: Vec<Part>,
    /// Whether the first scan goes from the last row to the first.
    backward: bool,
    mode: Mode,
    kind: Kind,
    /// Whether motion sentences are sent with the triggers instead of at their times.
    by_trigger: bool,
}

impl<'a> Playback<'a> {
    /// Creates the playback of `recording`, whose set-up is applied on top of `base`.
    ///
    /// # Errors
    /// The recording cannot be scanned; the message names the key or the capture.
    pub fn new(recording: &'a Recording, base: &Config) -> Result<Self> {
        let mut parts = Vec::new();
        let mut backward = false;
        for scan in 0..recording.scans() {
            let (config, schedule) = setup::config(recording, scan, base)?;
            let chirps = schedule.chirps;
            parts.push(Part { config, chirps });
            backward |= scan == 0 && schedule.backward;
        }
        Ok(Self {
            recording,
            parts,
            backward,
            mode: setup::mode(recording),
            kind: Kind::Scans,
            by_trigger: false,
        })
    }

    /// Returns the playback with the mirror turning in the opposite direction.
    pub fn reversed(self) -> Self {
        Self {
            backward: !self.backward,
            ..self
        }
    }

    /// Returns the playback with the motion mode (standing or automatic) that applies without
    /// motion sentences.
    pub fn with_mode(self, mode: Mode) -> Self {
        Self { mode, ..self }
    }

    /// Returns the playback for a scanner whose clock differs from the recording's. Motion
    /// sentences, if there are any, are sent with the triggers, and the result must not depend on
    /// their times.
    pub fn by_trigger(self) -> Self {
        Self {
            by_trigger: !self.recording.meta.motion.travel_m.is_empty(),
            ..self
        }
    }

    /// Returns the motion sentences that are sent with the triggers; `None` if they are sent at
    /// their times or there are none.
    pub fn motion(&self) -> Option<ByTrigger> {
        let wanted = self.by_trigger.then_some(self.recording);
        wanted.and_then(ByTrigger::new)
    }

    /// Returns configuration and chirps of scan `scan` (from 0); after the last one the recording
    /// repeats.
    fn part(&self, scan: usize) -> &Part {
        // There is at least one scan: see `Recording::scans`.
        &self.parts[scan % self.parts.len()]
    }

    /// Returns the scanner's configuration for the first scan of the recording.
    pub fn config(&self) -> &Config {
        &self.part(0).config
    }

    /// Returns the scanner's configuration for scan `scan`, from 0.
    pub fn config_of(&self, scan: usize) -> &Config {
        &self.part(scan).config
    }

    /// Returns the playback with each scan of the recording as a guard sweep.
    pub fn guarding(self) -> Self {
        Self {
            kind: Kind::Guard,
            ..self
        }
    }

    /// Returns whether the recording's scans are played as full scans or as guard sweeps.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Returns the guard's settings for a sweep over the angles of `sweep`; the defaults if full
    /// scans are played.
    fn guard(&self, sweep: &SweepConfig) -> GuardConfig {
        match self.kind {
            Kind::Scans => GuardConfig::default(),
            Kind::Guard => GuardConfig {
                first: sweep.first_angle,
                last: sweep.angle(sweep.angle_count.saturating_sub(1)),
                step: u16::try_from(sweep.angle_step).unwrap_or(u16::MAX),
                // Neither a recording nor the emulator runs in the scanner's time.
                rate: 0,
                ..GuardConfig::default()
            },
        }
    }

    /// Returns the scanner's settings with which the first scan begins; the mirror's angles and
    /// direction are those of the recording.
    pub fn settings(&self) -> Settings {
        let mut timing = Timing::default();
        if let Some(us) = setup::chirp_us(self.recording) {
            timing.chirp_duration = us;
        }
        if self.by_trigger {
            // A duration of 0 turns off the range-Doppler compensation, which needs the chair's speed.
            (timing.chirp_duration, timing.motion_timeout) = (0, MAX_TIME);
        }
        Settings {
            config: *self.config(),
            guard: self.guard(&self.config().sweep),
            timing,
            // The simulated shaft moves without delay: it passes no angles.
            sweep_mode: SweepMode::Stop,
            motion: self.mode,
            module: RequestedSettings {
                chirps: self.chirps(),
                ..RequestedSettings::DEFAULT
            },
            sweeping: match self.backward {
                true => Sweeping::Backward,
                false => Sweeping::Both,
            },
            ..Settings::default()
        }
    }

    /// Returns the commands that change a scanner's settings from those of scan `scan` (from 0) to those of
    /// the next one. They apply from the next scan on, also if they are sent during this one.
    pub fn commands_after(&self, scan: usize) -> Vec<(&'static str, String)> {
        let settings = |k| Settings {
            config: *self.config_of(k),
            guard: self.guard(&self.config_of(k).sweep),
            ..Settings::default()
        };
        let (this, next) = (settings(scan), settings(scan + 1));
        let changed = (Settings::KEYS.iter()).filter(|key| this.get(key) != next.get(key));
        let mut commands: Vec<(&str, String)> = changed
            .filter_map(|key| Some((*key, next.get(key)?.as_str().to_owned())))
            .collect();
        if scan == 0 && self.backward && self.kind == Kind::Scans {
            // After one backward scan the directions alternate.
            commands.push(("sweep", "both".into()));
        }
        commands
    }

    /// Returns the radar module's settings, those of the recording.
    pub fn radar(&self) -> RadarConfig {
        self.config().radar
    }

    /// Returns the number of chirps per row that the recording's samples are the mean of.
    pub fn chirps(&self) -> u8 {
        self.recording.meta.chirps_per_row.unwrap_or(1)
    }

    /// Returns the index in the recording of the chirp of scan `scan` (from 0) at `shaft_angle`
    /// (0.001°); `None` if the recording contains none.
    pub fn chirp(&self, scan: usize, shaft_angle: i32) -> Option<usize> {
        let Part { config, chirps } = self.part(scan);
        *chirps.get(row_at(config, shaft_angle)?)?
    }
}

/// Returns the row of a scan with `config` that is nearest to `shaft_angle` (0.001°); `None` before
/// the first row. Rows beyond the last are not excluded.
pub fn row_at(config: &Config, shaft_angle: i32) -> Option<usize> {
    let beam = match config.mount.plane.first() {
        Plane::Depth => shaft_angle,
        Plane::Height => 90_000 - shaft_angle,
    };
    let sweep = &config.sweep;
    let row = (beam - sweep.first_angle + sweep.angle_step / 2).div_euclid(sweep.angle_step);
    usize::try_from(row).ok()
}

/// State of a [`Playback`] during its scans: which scan the requests belong to.
///
/// Every scan begins with a request for the module's settings. Such a request after a trigger
/// therefore begins the next scan.
#[derive(Clone, Debug)]
pub struct Player<'a> {
    playback: &'a Playback<'a>,
    scan: usize,
    triggered: bool,
}

impl<'a> Player<'a> {
    /// Creates the state before the first scan of `playback`.
    pub fn new(playback: &'a Playback<'a>) -> Self {
        Self {
            playback,
            scan: 0,
            triggered: false,
        }
    }

    /// Handles a request for the module's settings, which may begin the next scan, and returns
    /// them.
    pub fn configure(&mut self) -> RadarConfig {
        if std::mem::take(&mut self.triggered) {
            self.scan += 1;
        }
        self.playback.radar()
    }

    /// Returns the chirp of the current scan at `shaft_angle` (0.001°); `None` if the recording
    /// contains none.
    pub fn trigger(&mut self, shaft_angle: i32) -> Option<&'a [Iq]> {
        self.triggered = true;
        let chirp = self.playback.chirp(self.scan, shaft_angle)?;
        self.playback.recording.chirp(chirp)
    }

    /// Returns the index in the recording of the chirp that [`Player::trigger`] would return.
    pub fn number(&self, shaft_angle: i32) -> Option<usize> {
        self.playback.chirp(self.scan, shaft_angle)
    }

    /// Returns the number of scans with at least one requested chirp.
    pub fn begun(&self) -> usize {
        self.scan + usize::from(self.triggered)
    }
}

/// The radar link of a simulated scanner to a [`Playback`], without frames or delays.
#[derive(Debug)]
pub struct PlaybackLink<'a> {
    player: Player<'a>,
    radar: RadarConfig,
    shaft_angle: i32,
    timetable: Option<Rc<RefCell<Timetable>>>,
}

impl<'a> PlaybackLink<'a> {
    /// Creates a link to `playback`; a timetable, if given, sets the times of the chirps.
    pub fn new(playback: &'a Playback<'a>, timetable: Option<Rc<RefCell<Timetable>>>) -> Self {
        Self {
            player: Player::new(playback),
            radar: playback.radar(),
            shaft_angle: 0,
            timetable,
        }
    }
}

impl RadarModule for PlaybackLink<'_> {
    fn program(&mut self, _: Micros, _: &RequestedSettings, _: u32) {
        self.radar = self.player.configure();
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        let early = |table: &Rc<RefCell<Timetable>>| table.borrow().early(now);
        if self.timetable.as_ref().is_some_and(early) {
            return Poll::Pending;
        }
        Poll::Ready(Ok(self.radar))
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, _: u32) {
        self.shaft_angle = shaft_angle;
        if let (Some(table), Some(chirp)) = (&self.timetable, self.player.number(shaft_angle)) {
            table.borrow_mut().fired(chirp, now);
        }
    }

    fn poll(&mut self, _: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        Poll::Ready(deliver(self.player.trigger(self.shaft_angle), samples))
    }
}

/// Copies a chirp to `samples`. One of another length is a wrong answer of the module, none is a lost one.
///
/// # Errors
/// The chirp is no answer.
pub fn deliver(chirp: Option<&[Iq]>, samples: &mut [Iq]) -> Result<(), LinkError> {
    match chirp {
        Some(chirp) if chirp.len() == samples.len() => {
            samples.copy_from_slice(chirp);
            Ok(())
        }
        Some(_) => Err(LinkError::Answer),
        None => Err(LinkError::Timeout),
    }
}
