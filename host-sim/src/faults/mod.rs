//! What can go wrong with the instrument, put on recordings.
//!
//! Every fault is a change of a clean recording, drawn from a seed: of its samples (`converter`), of
//! which row got which chirp (`rows`), of what stands in the way (`world`), or of what the scanner
//! believes of its own mounting (`mounting`). `signal` takes a scan apart into what the scanner itself
//! reflects, what the scene does, and noise.

mod converter;
mod kinds;
mod mounting;
mod rows;
mod signal;
mod world;

pub use kinds::ALL;

use anyhow::{Result, ensure};
use stairscan::answer::Reason;

use crate::recording::Recording;
use crate::scene::maths::Random;
use signal::Signal;

/// Streams of random numbers of faults, apart from those of scenes and scans.
const STREAM: u64 = 0x4641_554C_5400;

/// One kind of fault.
pub struct Fault {
    /// Its name.
    pub name: &'static str,
    /// What is put on: some strengths, weakest first.
    pub strengths: &'static [f64],
    /// Unit of the strengths.
    pub unit: &'static str,
    /// The reasons that name it.
    pub reasons: &'static [Reason],
    /// Puts it on, that strong.
    apply: fn(&mut Signal, f64),
}

impl Fault {
    /// The fault of a name.
    pub fn named(name: &str) -> Option<&'static Fault> {
        ALL.iter().find(|fault| fault.name == name)
    }

    /// `recording` with the fault on it, `strength` strong. One seed is one recording.
    ///
    /// # Errors
    /// Names the recording that no fault can be put on.
    pub fn on(&self, recording: &Recording, strength: f64, seed: u64) -> Result<Recording> {
        ensure!(
            recording.scans() == 1,
            "{}: {} scans: expected one, faults are put on single scans",
            recording.name,
            recording.scans()
        );
        ensure!(
            !recording.meta.real,
            "{}: real samples: expected I and Q, which faults are put on",
            recording.name
        );
        let place = ALL.iter().position(|f| core::ptr::eq(f, self));
        let random = Random::new(seed, STREAM + place.unwrap_or(ALL.len()) as u64);
        let mut signal = Signal::new(recording.clone(), random)?;
        (self.apply)(&mut signal, strength);
        Ok(signal.into_recording())
    }
}

#[cfg(test)]
mod tests;
