//! Interface of a radar module, independent of its protocol.

use core::task::Poll;

use super::wire::RowTimes;
use crate::Iq;
use crate::config::RadarConfig;
use crate::setting::{settings, words};
use crate::time::Micros;

/// Error in bytes that began like a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Another version of the format.
    Version,
    /// A kind of frame that this version of the format does not define.
    Kind,
    /// A payload longer than the maximum.
    Length,
    /// Wrong CRC.
    Crc,
}

/// Reason why there is no valid answer of the radar module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkError {
    /// No answer before the deadline.
    Timeout,
    /// The answer was damaged, or is of another version of the protocol.
    Frame(FrameError),
    /// Only answers to other requests of the scanner arrived before the deadline: late or repeated ones.
    Sequence,
    /// The answer has the wrong kind or length.
    Answer,
    /// The module reports an error, with its own code.
    Module(u8),
    /// The module does not have an ability that a setting requires: to add the chirps of a row.
    Unable,
}

/// Kind of radar module, by its protocol.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModuleKind {
    /// A module with this project's frames ([`super::frame`]).
    #[default]
    Pstr,
    /// SiRad Easy or Simple, 120 GHz, over the same serial port.
    SiRad,
    /// Infineon BGT60TR13C, 58.0 to 63.5 GHz, over SPI.
    Bgt60,
}

impl ModuleKind {
    /// Returns the minimum timeouts for settings and for a chirp, microseconds, that leave the module time to
    /// answer.
    pub fn min_timeouts_us(self) -> (u32, u32) {
        match self {
            // It is observed for 160 ms, and resynchronises within the time of a chirp ([`super::sirad`]).
            ModuleKind::SiRad => (400_000, 100_000),
            ModuleKind::Pstr | ModuleKind::Bgt60 => (0, 0),
        }
    }
}

words!(ModuleKind: "pstr" ModuleKind::Pstr, "sirad" ModuleKind::SiRad, "bgt60" ModuleKind::Bgt60);

settings! {
    /// Requested settings of a module. Defaults: a module's own settings, at the fastest rate.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct RequestedSettings
    parts {}
    rows {
        /// Connected radar module.
        kind: ModuleKind = ModuleKind::Pstr, "module" "" [] Operation;
        /// Requested swept bandwidth; 0: the module's own setting, or its protocol's default.
        bandwidth_khz: u32 = 0, "module-bandwidth" "kHz" [0 to 100_000_000] Operation;
        /// Requested samples per chirp, counted as `radar-samples`, 16 to 256; 0: the module's own setting.
        samples: u16 = 0, "module-samples" "samples" [0 to 256] Operation;
        /// Maximum rate of the radar link: 1000000, 2000000 or 3000000.
        baud: u32 = 3_000_000, "link-rate" "baud" [1_000_000 to 3_000_000] Operation;
        /// Whether chirps begin at an edge of TRIG, if the module supports it.
        pin: bool = false, "trigger-pin" "" [] Operation;
        /// Number of chirps that the module adds for each row; above 1 with `pstr` only.
        chirps: u8 = 1, "chirps-per-row" "chirps" [1 to 32] AnswerUnlessOne;
    }
    also {}
}

impl RequestedSettings {
    /// Returns whether a module of this kind may be able to add the requested chirps per row.
    pub fn chirps_fit(&self) -> bool {
        self.chirps == 1 || self.kind == ModuleKind::Pstr
    }

    /// Returns whether any setting of the module itself is requested, not only of the wire.
    pub fn is_of_module(&self) -> bool {
        self.bandwidth_khz != 0 || self.samples != 0 || self.pin || self.chirps != 1
    }
}

/// A radar module: one request at a time, one answer each. No function blocks.
///
/// The interface is narrow: a module with another protocol implements these functions, and nothing else of the
/// scanner changes.
pub trait RadarModule {
    /// Sets the module up as requested, as far as possible, and requests its settings.
    fn program(&mut self, now: Micros, requested: &RequestedSettings, timeout_us: u32);
    /// Returns the answer to [`RadarModule::program`]: the module's present settings.
    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>>;
    /// Triggers one chirp with the mirror's shaft at `shaft_angle` (0.001° from the horizontal, positive downwards);
    /// its answer is due within `timeout_us`.
    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32);
    /// Receives the answer to [`RadarModule::trigger`]: exactly as many samples as `samples` holds.
    fn poll(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>>;
    /// Repeats [`RadarModule::trigger`] for a row whose chirp was lost, while the mirror stands: there is time to
    /// restore the link first.
    fn retry(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        self.trigger(now, shaft_angle, timeout_us);
    }
    /// Returns whether the port has taken the last trigger; it may still hold two bytes of it.
    fn sent(&self) -> bool {
        true
    }
    /// Whether nothing is left to do before the next byte arrives at the module's port, whose interrupt wakes the
    /// scanner, or a timeout ends; `false` for a module that is polled.
    fn waits(&self) -> bool {
        false
    }
    /// Returns the times of trigger, chirp and answer of a row of `_samples` samples whose chirp is triggered
    /// while the mirror turns; `None` if the mirror must stop for each chirp.
    fn row_times(&self, _samples: u16) -> Option<RowTimes> {
        None
    }
    /// Does [`RadarModule::trigger`] while the answer to the trigger before is still being sent; the answers
    /// then arrive in order. Returns false without any effect if this is not possible.
    fn trigger_ahead(&mut self, _now: Micros, _shaft_angle: i32, _timeout_us: u32) -> bool {
        false
    }
}

/// Allows a module that is too large for the stack to be used by reference.
impl<R: RadarModule + ?Sized> RadarModule for &mut R {
    fn program(&mut self, now: Micros, requested: &RequestedSettings, timeout_us: u32) {
        (**self).program(now, requested, timeout_us);
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        (**self).settings(now)
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        (**self).trigger(now, shaft_angle, timeout_us);
    }

    fn poll(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        (**self).poll(now, samples)
    }

    fn retry(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        (**self).retry(now, shaft_angle, timeout_us);
    }

    fn sent(&self) -> bool {
        (**self).sent()
    }

    fn waits(&self) -> bool {
        (**self).waits()
    }

    fn row_times(&self, samples: u16) -> Option<RowTimes> {
        (**self).row_times(samples)
    }

    fn trigger_ahead(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) -> bool {
        (**self).trigger_ahead(now, shaft_angle, timeout_us)
    }
}
