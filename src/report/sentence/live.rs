//! Sentence `LIVE`: state and counters of the scanner; the only sentence with times.

use super::fields::{Fields, ParseError};
use super::frame::Line;
use super::writer::Writer;

/// Content of the sentence `LIVE`: state and counters of the scanner, five times a second. Counters saturate at
/// 65535.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LiveLine<'a> {
    /// Name of the scanner's state, such as `idle` or `scanning`.
    pub state: &'a str,
    /// Number of the last scan that was begun; 0 before the first.
    pub scan: u32,
    /// Time since boot, ms; wraps after 49 days.
    pub uptime_ms: u32,
    /// Time since the last row of the last scan that was no fault, ms; `None` before the first.
    pub age_ms: Option<u32>,
    /// State of the motion input, such as `absent` or `good`.
    pub motion: &'a str,
    /// Number of motion sentences that were wrong or too late, since boot.
    pub motion_faults: u16,
    /// Number of refused lines of the report port since boot: damaged, or no command.
    pub refused: u16,
    /// Number of bytes of the report port that were damaged or lost since boot.
    pub port_errors: u16,
    /// Number of requests since boot that the radar module did not answer correctly; every attempt counts.
    pub link_errors: u16,
}

impl<'a> LiveLine<'a> {
    pub(super) fn write(&self) -> Line {
        let line = Writer::new("LIVE")
            .text(self.state)
            .number(self.scan)
            .number(self.uptime_ms);
        let line = match self.age_ms {
            Some(ms) => line.number(ms),
            None => line.text(""),
        };
        line.text(self.motion)
            .number(self.motion_faults.into())
            .number(self.refused.into())
            .number(self.port_errors.into())
            .number(self.link_errors.into())
            .finish()
    }

    pub(super) fn parse(fields: &mut Fields<'a>) -> Result<Self, ParseError> {
        Ok(Self {
            state: fields.text("state")?,
            scan: fields.number("scan")?,
            uptime_ms: fields.number("uptime")?,
            age_ms: match fields.text("age")? {
                "" => None,
                ms => Some(ms.parse().map_err(|_| ParseError::Field("age"))?),
            },
            motion: fields.text("motion")?,
            motion_faults: fields.number("motion-faults")?,
            refused: fields.number("refused")?,
            port_errors: fields.number("port-errors")?,
            link_errors: fields.number("link-errors")?,
        })
    }
}
