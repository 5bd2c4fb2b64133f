//! Sentence `GUARD`: result of a guard sweep.

use super::fields::{Fields, ParseError};
use super::frame::{Line, Tenths};
use super::lines::{parse_permille, permille};
use super::writer::Writer;
use crate::verdict::{GuardResult, HazardKind, Reasons, Status};

/// Content of the sentence `GUARD`: free distance ahead by the guard's last sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GuardLine {
    /// Number of the sweep since the guard was switched on, from 1.
    pub sweep: u32,
    /// Status of the result: `ok`, `degraded` or `fault`.
    pub status: Status,
    /// Free distance from the mirror at the sweep's last row, 0.1 mm; `None` in a fault.
    pub free: Option<Tenths>,
    /// Kind of the hazard that ends the free distance, or that there is none.
    pub hazard: HazardKind,
    /// Probability that no hazard is nearer than the free distance, tenths of a per cent.
    pub confidence: u16,
    /// Reasons why the status is not `ok`, and limitations of a result that is.
    pub reasons: Reasons,
}

impl GuardLine {
    /// Creates the sentence of `result`, that of guard sweep number `sweep`.
    pub fn new(sweep: u32, result: &GuardResult) -> Self {
        Self {
            sweep,
            status: result.status(),
            free: result.free_m().map(Tenths::from_metres),
            hazard: result.hazard(),
            confidence: permille(result.confidence()),
            reasons: result.reasons(),
        }
    }

    /// Returns the sentence, with its CRC and line end.
    pub(super) fn write(&self) -> Line {
        Writer::new("GUARD")
            .number(self.sweep)
            .text(self.status.as_str())
            .length(self.free)
            .text(self.hazard.as_str())
            .length(Some(Tenths(self.confidence.into())))
            .reasons(self.reasons)
            .finish()
    }

    /// Parses the fields of a sentence after its name `GUARD`.
    pub(super) fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
        Ok(Self {
            sweep: fields.number("sweep")?,
            status: fields.word(
                "status",
                &[Status::Ok, Status::Degraded, Status::Fault],
                |s| s.as_str(),
            )?,
            free: fields.length("free")?,
            hazard: fields.word("ending", &HazardKind::ALL, |e| e.as_str())?,
            confidence: parse_permille(fields, "confidence")?
                .ok_or(ParseError::Field("confidence"))?,
            reasons: fields.reasons("reasons")?,
        })
    }
}
