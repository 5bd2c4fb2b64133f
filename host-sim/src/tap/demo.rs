//! A radar module without hardware: a thread that plays a recording at the other end of a pseudo-terminal.

use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, Result};
use serialport::{SerialPort as _, TTYPort};
use stairscan::config::{Config, SweepConfig};

use crate::emulate::Module;
use crate::playback::Playback;
use crate::recording::Recording;
use crate::setup;

/// A look for bytes takes so long.
const LOOK: Duration = Duration::from_millis(5);
/// Longer than a chirp takes on its way to a reader that is busy.
const ANSWER: Duration = Duration::from_secs(10);

/// The module, until it is dropped.
#[derive(Debug)]
pub struct Demo {
    /// Where it is asked.
    pub port: String,
    /// The angles that it knows chirps of.
    pub sweep: SweepConfig,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Demo {
    /// Plays the first scan of the recording `path`, again and again.
    ///
    /// # Errors
    /// Names what in the recording no scan can be made of.
    pub fn start(path: &Path, config: &Config) -> Result<Self> {
        let (recording, config) = (Recording::read(path)?, *config);
        Playback::new(&recording, &config)?;
        let sweep = setup::schedule(&recording, 0)?.sweep;
        let (mut master, slave) = TTYPort::pair().context("no pseudo-terminal")?;
        let port = slave.name().context("a pseudo-terminal without a name")?;
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let thread = std::thread::spawn(move || {
            // Open as long as the module plays: without it the master would hang up between two users.
            let _slave = slave;
            let Ok(playback) = Playback::new(&recording, &config) else {
                return;
            };
            let mut module = Module::new(&playback);
            module.get_ready();
            let mut buffer = [0; 256];
            while !stopped.load(Ordering::Relaxed) {
                let _ = master.set_timeout(LOOK);
                if let Ok(count) = master.read(&mut buffer) {
                    let (answer, _) = module.receive(&buffer[..count]);
                    let _ = master.set_timeout(ANSWER);
                    let _ = master.write_all(&answer);
                }
            }
        });
        Ok(Self {
            port,
            sweep,
            stop,
            thread: Some(thread),
        })
    }
}

impl Drop for Demo {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
