//! A recording as the radar module, and a shaft without a motor: what `replay` puts behind the
//! scanner's hardware traits, and what the emulator's radar module plays.

use std::task::Poll;

use anyhow::Result;
use stairscan::Iq;
use stairscan::config::{Config, Plane, RadarConfig};
use stairscan::scan::settings::MotorConfig;
use stairscan::scan::{LinkError, Micros, Mirror, MirrorError, Motion, RadarLink};

use crate::recording::Recording;
use crate::setup;

/// A recording that answers triggers by their angle.
#[derive(Clone, Debug)]
pub struct Playback<'a> {
    recording: &'a Recording,
    config: Config,
    chirps: Vec<Option<usize>>,
}

impl<'a> Playback<'a> {
    /// `recording` with its set-up on top of `base`.
    pub fn new(recording: &'a Recording, base: &Config) -> Result<Self> {
        let (config, schedule) = setup::config(recording, base)?;
        Ok(Self {
            recording,
            config,
            chirps: schedule.chirps,
        })
    }

    /// The configuration that the recording brings.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// What the radar module is set to.
    pub fn radar(&self) -> RadarConfig {
        self.config.radar
    }

    /// The chirp that was recorded with the shaft at `shaft_angle` (0.001°); `None` where the
    /// recording holds none.
    pub fn chirp(&self, shaft_angle: i32) -> Option<&'a [Iq]> {
        let beam = match self.config.mount.plane {
            Plane::Depth => shaft_angle,
            Plane::Height => 90_000 - shaft_angle,
        };
        let sweep = &self.config.sweep;
        let row = (beam - sweep.first_angle + sweep.angle_step / 2).div_euclid(sweep.angle_step);
        let chirp = (*self.chirps.get(usize::try_from(row).ok()?)?)?;
        self.recording.chirp(chirp)
    }
}

impl RadarLink for PlaybackLink<'_> {
    fn configure(&mut self, _: Micros, _: u32) {}

    fn poll_settings(&mut self, _: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        Poll::Ready(Ok(self.playback.radar()))
    }

    fn trigger(&mut self, _: Micros, shaft_angle: i32, _: u32) {
        self.shaft_angle = shaft_angle;
    }

    fn poll_chirp(&mut self, _: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        Poll::Ready(match self.playback.chirp(self.shaft_angle) {
            Some(chirp) if chirp.len() == samples.len() => {
                samples.copy_from_slice(chirp);
                Ok(())
            }
            Some(_) => Err(LinkError::Answer),
            None => Err(LinkError::Timeout),
        })
    }
}

/// The radar link of a [`Playback`]: no frames, no waiting.
#[derive(Debug)]
pub struct PlaybackLink<'a> {
    playback: &'a Playback<'a>,
    shaft_angle: i32,
}

impl<'a> PlaybackLink<'a> {
    /// The link to `playback`.
    pub fn new(playback: &'a Playback<'a>) -> Self {
        Self {
            playback,
            shaft_angle: 0,
        }
    }
}

/// A shaft that is at once where it is sent.
#[derive(Clone, Copy, Debug, Default)]
pub struct SimShaft {
    position: i32,
    homed: bool,
}

impl Mirror for SimShaft {
    fn start_home(&mut self, _: &MotorConfig) {
        *self = Self {
            position: 0,
            homed: true,
        };
    }

    fn start_move(&mut self, position: i32, _: &MotorConfig) {
        self.position = position;
    }

    fn poll(&mut self) -> Result<Motion, MirrorError> {
        if self.homed {
            Ok(Motion::Still)
        } else {
            Err(MirrorError::NotHomed)
        }
    }

    fn position(&self) -> i32 {
        self.position
    }

    fn homed(&self) -> bool {
        self.homed
    }

    fn disable(&mut self) {
        self.homed = false;
    }
}
