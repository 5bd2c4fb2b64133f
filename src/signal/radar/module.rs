//! The radar module as the scanner sees it, whatever its protocol.

use core::task::Poll;

use super::wire::RowTimes;
use crate::Iq;
use crate::config::RadarConfig;
use crate::setting::{settings, words};
use crate::time::Micros;

/// What is wrong with bytes that began like a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Another version of the format.
    Version,
    /// A kind that this version does not have.
    Kind,
    /// A payload longer than any.
    Length,
    /// Damaged on the way.
    Crc,
}

/// Why an answer is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkError {
    /// No answer in time.
    Timeout,
    /// The answer was damaged on the way, or not of this version of the protocol.
    Frame(FrameError),
    /// Only answers to other requests came in time: late or repeated ones.
    Sequence,
    /// The answer is of the wrong kind or length.
    Answer,
    /// The module says that it cannot; its own code.
    Module(u8),
}

/// Which module hangs on the scanner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModuleKind {
    /// One that speaks this project's frames ([`super::frame`]).
    #[default]
    Pstr,
    /// SiRad Easy or Simple, 120 GHz, over the same serial port.
    SiRad,
    /// Infineon BGT60TR13C, 58.0 to 63.5 GHz, over SPI.
    Bgt60,
}

impl ModuleKind {
    /// Least time-outs for its settings and for a chirp, microseconds, with which it can answer at all.
    pub fn patience_us(self) -> (u32, u32) {
        match self {
            // It is listened to for 160 ms, and mends its link within a chirp's time ([`super::sirad`]).
            ModuleKind::SiRad => (400_000, 100_000),
            ModuleKind::Pstr | ModuleKind::Bgt60 => (0, 0),
        }
    }
}

words!(ModuleKind: "pstr" ModuleKind::Pstr, "sirad" ModuleKind::SiRad, "bgt60" ModuleKind::Bgt60);

settings! {
    /// What a module is to be set to. Defaults: a module as it is, at the fastest rate.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Wish
    parts {}
    rows {
        /// Radar module that hangs on the scanner.
        kind: ModuleKind = ModuleKind::Pstr, "module" "" [] Pace;
        /// Swept bandwidth that the module is to be set to; 0: as the module has it, or its protocol's default.
        bandwidth_khz: u32 = 0, "module-bandwidth" "kHz" [0 to 100_000_000] Pace;
        /// Samples per chirp, counted as `radar-samples`, 16 to 256; 0: as the module has it.
        samples: u16 = 0, "module-samples" "samples" [0 to 256] Pace;
        /// Fastest rate that the wire may be raised to: 1000000, 2000000 or 3000000.
        baud: u32 = 3_000_000, "link-rate" "baud" [1_000_000 to 3_000_000] Pace;
        /// Whether chirps begin at an edge of TRIG, where the module can.
        pin: bool = false, "trigger-pin" "" [] Pace;
    }
    also {}
}

impl Wish {
    /// Whether anything is to be set in the module itself.
    pub fn is_of_module(&self) -> bool {
        self.bandwidth_khz != 0 || self.samples != 0 || self.pin
    }
}

/// A radar module: one request at a time, one answer each. No function waits.
///
/// Narrow on purpose: a module with another protocol needs these functions and nothing else of the
/// scanner changes.
pub trait RadarModule {
    /// Sets the module up as wished, as far as it can be, and asks what it is set to.
    fn program(&mut self, now: Micros, wish: &Wish, timeout_us: u32);
    /// The answer to [`RadarModule::program`]: what the module is set to now.
    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>>;
    /// Fires one chirp with the mirror's shaft at `shaft_angle` (0.001°).
    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32);
    /// The answer to [`RadarModule::trigger`]: exactly as many samples as `samples` holds.
    fn poll(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>>;
    /// [`RadarModule::trigger`] once more for a chirp that did not come, from a mirror that stands: there is
    /// time to mend the link first.
    fn retry(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        self.trigger(now, shaft_angle, timeout_us);
    }
    /// Whether the last trigger has been handed to the port, but for what that holds: two bytes.
    fn sent(&self) -> bool {
        true
    }
    /// Times of a row of `samples` whose chirp is triggered while the mirror turns; none where the mirror has to stop
    /// for each chirp.
    fn row_times(&self, _samples: u16) -> Option<RowTimes> {
        None
    }
    /// [`RadarModule::trigger`] while the answer to the trigger before is on its way: answers then come one after
    /// the other, the older first. False, and nothing done, where that cannot be.
    fn trigger_ahead(&mut self, _now: Micros, _shaft_angle: i32, _timeout_us: u32) -> bool {
        false
    }
}

/// So that a module too large for the stack can stay where it is.
impl<R: RadarModule + ?Sized> RadarModule for &mut R {
    fn program(&mut self, now: Micros, wish: &Wish, timeout_us: u32) {
        (**self).program(now, wish, timeout_us);
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

    fn row_times(&self, samples: u16) -> Option<RowTimes> {
        (**self).row_times(samples)
    }

    fn trigger_ahead(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) -> bool {
        (**self).trigger_ahead(now, shaft_angle, timeout_us)
    }
}
