//! A session of the emulator whose radar module withholds its chirps, to test whether the mirror waits for them.

use std::time::Duration;

use anyhow::Result;
use stairscan::schedule::microsteps;

use super::Session;
use crate::emulate::qemu::write_all;

/// Minimum distance from a trigger's row at which the mirror counts as moved to another one, microsteps. Rows of 0.25
/// degrees are 35 microsteps apart, less the fraction.
const ROW_APART: u64 = 20;
/// Time without a move of the mirror after which a withheld chirp belongs to the last row.
const LAST_ROW: Duration = Duration::from_secs(3);

/// Whether a mirror at `position`, microsteps from the horizontal, has left the row of a trigger. The row is taken
/// from `shaft_angle`, the trigger's angle in 0.001°: a busy host serves triggers so late that the mirror may already
/// have moved on.
fn has_left(position: Option<i64>, shaft_angle: i32) -> bool {
    let row = i64::from(microsteps(shaft_angle));
    position.is_some_and(|position| position.abs_diff(row) >= ROW_APART)
}

impl Session<'_> {
    /// Sends a withheld chirp once the mirror has moved by a row, or after a timeout, since the mirror does not move
    /// behind the last row. Returns whether a chirp was sent.
    pub(super) fn release(&mut self) -> Result<bool> {
        let Some(chirp) = &self.withheld else {
            return Ok(false);
        };
        let overtaken = has_left(self.shaft.position(), chirp.shaft_angle);
        if !overtaken && chirp.since.elapsed() < LAST_ROW {
            return Ok(false);
        }
        self.overtaken += usize::from(overtaken);
        write_all(&mut self.qemu.link, &chirp.answer)?;
        self.withheld = None;
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The row is that of the trigger, not the position at which the mirror was first observed.
    #[test]
    fn a_mirror_leaves_the_row_and_not_the_place_where_it_was_seen_first() {
        let row = |k: i32| i64::from(microsteps(10_000 + 250 * k));
        assert!(!has_left(Some(row(0)), 10_000));
        assert!(!has_left(None, 10_000));
        for gone in [row(1), row(-1)] {
            assert!(has_left(Some(gone), 10_000));
        }
    }
}
