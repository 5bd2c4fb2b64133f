//! A session of the emulator with an observer at the report port, over a pseudo-terminal.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Result;
use stairscan::report::Sentence;
use stairscan::scanner::command::framed;

use super::{PAUSE, Session};
use crate::emulate::qemu::write_all;
use crate::live::pty::Pty;

impl Session<'_> {
    /// Connects `pty`: all reports of the image, also those so far, go there, and what is typed there goes to the
    /// image.
    pub fn watch(&mut self, mut pty: Pty) {
        for line in &self.lines {
            pty.write(format!("{line}\r\n").as_bytes());
        }
        self.watcher = Some(pty);
    }

    /// Passes the image's output to the observer, and the observer's input to the image. Returns whether there was
    /// any input.
    pub(super) fn pass_on(&mut self, said: &[u8]) -> Result<bool> {
        let Some(pty) = &mut self.watcher else {
            return Ok(false);
        };
        pty.write(said);
        let typed = pty.read();
        write_all(&mut self.qemu.report, &typed)?;
        Ok(!typed.is_empty())
    }

    /// Lets the image scan until `ended`, with the recording's settings for each scan. After all `scans` of a
    /// recording of several scans, the scanner is stopped.
    ///
    /// # Errors
    /// The emulator process has ended.
    pub fn follow(&mut self, scans: usize, ended: &AtomicBool) -> Result<()> {
        let (mut commanded, mut answered) = (0, 0);
        while !ended.load(Ordering::Relaxed) {
            if !self.poll()? {
                std::thread::sleep(PAUSE);
            }
            if self.module.begun() > commanded {
                for (key, value) in self.playback.commands_after(commanded) {
                    self.type_bytes(framed(&["set", key, &value]).as_bytes())?;
                }
                commanded += 1;
            }
            let is_scan = |line: &&String| matches!(Sentence::parse(line), Ok(Sentence::Scan(scan)) if scan.scan > 0);
            let before = answered;
            answered += self.lines.iter().filter(is_scan).count();
            if scans > 1 && before < scans && answered >= scans {
                self.type_bytes(b"stop\r\n")?;
            }
            // Not needed here: the observer has them.
            self.lines.clear();
            self.live.clear();
            self.shots.clear();
            (self.read, self.skipped) = (0, 0);
        }
        Ok(())
    }
}
