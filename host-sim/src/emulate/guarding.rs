//! Runs guard sweeps of a recording through the firmware's image in the emulator.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use stairscan::config::Config;
use stairscan::report::Sentence;

use super::module::Fault;
use super::session::{Session, Waits};
use crate::playback::Playback;
use crate::recording::Recording;

/// Returns the `GUARD` sentences of the first `sweeps` sweeps of a recording, after one boot. The motion sentences
/// are sent with the triggers, as on the host with [`crate::replay::Options::by_trigger`].
///
/// # Errors
/// A sweep failed; the message names the recording and the cause.
pub fn sentences(
    elf: &Path,
    recording: &Recording,
    config: &Config,
    sweeps: usize,
    (waits, faults): (Waits, &[Fault]),
) -> Result<Vec<String>> {
    let playback = Playback::new(recording, config)?.by_trigger().guarding();
    let guard = || -> Result<Vec<String>> {
        let mut session = Session::boot(elf, &playback)?;
        session.configure(&playback.settings(), waits)?;
        session.module.set_faults(faults);
        let done = session.command("guard on")?;
        ensure!(
            matches!(Sentence::parse(&done), Ok(Sentence::Done { .. })),
            "guard on: the image answers {done}"
        );
        session.skip_lines();
        session.connect()?;
        session.sweeps(sweeps)
    };
    guard().with_context(|| recording.name.clone())
}
