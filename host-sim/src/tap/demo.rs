//! A simulated radar module: a thread that plays a recording at the other end of a pseudo-terminal.

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
use crate::setup::{self, Kind};

/// Maximum time to wait for bytes before the thread checks whether to stop.
const LOOK: Duration = Duration::from_millis(5);
/// Maximum time of writing an answer; longer than a busy reader needs for a chirp.
const ANSWER: Duration = Duration::from_secs(10);

/// The simulated radar module. Dropping it ends the thread.
#[derive(Debug)]
pub struct Demo {
    /// Path of the pseudo-terminal at which the module can be opened as a serial port.
    pub port: String,
    /// Schedule of the angles for which the recording has chirps.
    pub sweep: SweepConfig,
    /// Kind of the scans that the recording holds.
    pub kind: Kind,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Demo {
    /// Plays the first scan of the recording `path` repeatedly.
    ///
    /// # Errors
    /// The recording cannot be scanned; the message names the cause.
    pub fn start(path: &Path, config: &Config) -> Result<Self> {
        let (recording, config) = (Recording::read(path)?, *config);
        Playback::new(&recording, &config)?;
        let sweep = setup::schedule(&recording, 0)?.sweep;
        let kind = setup::kind(&recording)?;
        let (mut master, slave) = TTYPort::pair().context("no pseudo-terminal")?;
        let port = slave.name().context("a pseudo-terminal without a name")?;
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let thread = std::thread::spawn(move || {
            // Kept open while the module plays: otherwise the master would hang up between two users.
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
            kind,
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
