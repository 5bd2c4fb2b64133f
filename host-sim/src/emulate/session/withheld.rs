//! A session whose module keeps its chirps back, to see whether the mirror waits for them.

use std::time::Duration;

use anyhow::Result;

use super::Session;
use crate::emulate::qemu::write_all;

/// A mirror that has gone so far, microsteps, has gone on to another row of 0.25 degrees: 35 are one less the
/// fraction, and what it may have gone while its trigger was served.
const ROW_APART: u64 = 20;
/// A chirp that is kept back is the last row's when the mirror has not gone on by then.
const LAST_ROW: Duration = Duration::from_secs(3);

impl Session<'_> {
    /// Sends a chirp that was kept back once the mirror has gone on by a row; behind the last row it does not.
    pub(super) fn release(&mut self) -> Result<bool> {
        let Some((answer, from, since)) = &self.withheld else {
            return Ok(false);
        };
        let way = |(a, b): (i64, i64)| a.abs_diff(b);
        let gone = self.shaft.position().zip(*from).map_or(0, way);
        let overtaken = gone >= ROW_APART;
        if !overtaken && since.elapsed() < LAST_ROW {
            return Ok(false);
        }
        self.overtaken += usize::from(overtaken);
        write_all(&mut self.qemu.link, answer)?;
        self.withheld = None;
        Ok(true)
    }
}
