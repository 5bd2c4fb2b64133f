//! The sentence that says how the scanner fares: the only one that bears times.

use super::fields::{Fields, ParseError};
use super::frame::Line;
use super::writer::Writer;

/// How the scanner fares, five times a second. Counters stay at 65535 once they are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LiveLine<'a> {
    /// State of the scanner.
    pub state: &'a str,
    /// Number of the scan that began last; 0 before the first.
    pub scan: u32,
    /// Time since boot, ms; begins anew after 49 days.
    pub uptime_ms: u32,
    /// Time since the last row of the last scan that was no fault, ms; none before the first.
    pub age_ms: Option<u32>,
    /// What the motion input is.
    pub motion: &'a str,
    /// Motion sentences since boot that were not as they should be, or missing too long.
    pub motion_faults: u16,
    /// Lines of the report port since boot that were refused: damaged, or no command.
    pub refused: u16,
    /// Bytes of the report port since boot that came damaged or were lost.
    pub port_errors: u16,
    /// Requests since boot that the radar module did not answer as it should, each attempt by itself.
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
