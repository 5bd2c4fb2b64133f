//! Sentence `CRASH`: the last crash, and the place where the firmware crashed.

use super::fields::{Fields, ParseError};
use super::frame::Line;
use super::writer::Writer;

/// Place of a crash in the image: registers of the processor, and the hash of a panic's source line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrashSite {
    /// Program counter at the crash; `None` if it is unknown, as where the stack has overflowed.
    pub pc: Option<u32>,
    /// Link register at the crash, or a return address from the stack; `None` if it is unknown, as in a panic.
    pub lr: Option<u32>,
    /// Register SCB_CFSR, which has the kind of a fault (PM0214 4.4.13); `None` only where nothing has crashed.
    pub cfsr: Option<u32>,
    /// Address whose access failed; `None` if the processor has recorded no valid one.
    pub address: Option<u32>,
    /// Hash of a panic's place in the source ([`crc::of_place`](crate::crc::of_place)); `None` for anything else.
    pub place: Option<u32>,
}

impl CrashSite {
    /// Nothing has crashed.
    pub const NONE: Self = Self {
        pc: None,
        lr: None,
        cfsr: None,
        address: None,
        place: None,
    };

    /// Appends the five fields.
    pub(super) fn write(&self, line: Writer) -> Writer {
        line.word(self.pc)
            .word(self.lr)
            .word(self.cfsr)
            .word(self.address)
            .word(self.place)
    }

    /// Parses the five fields.
    pub(super) fn parse(fields: &mut Fields<'_>) -> Result<Self, ParseError> {
        Ok(Self {
            pc: fields.optional_hash("pc")?,
            lr: fields.optional_hash("lr")?,
            cfsr: fields.optional_hash("cfsr")?,
            address: fields.optional_hash("address")?,
            place: fields.optional_hash("place")?,
        })
    }
}

/// Content of the sentence `CRASH`: the last crash since power-on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CrashLine<'a> {
    /// Cause, as in `BOOT`, such as `panic`; `none` without a crash.
    pub cause: &'a str,
    /// Number of the boot since power-on that crashed, from 1; 0 without a crash.
    pub boot: u32,
    /// Place of the crash.
    pub site: CrashSite,
}

impl CrashLine<'static> {
    /// Nothing has crashed.
    pub const NONE: Self = Self {
        cause: "none",
        boot: 0,
        site: CrashSite::NONE,
    };
}

impl<'a> CrashLine<'a> {
    /// Returns the sentence, with its CRC and line end.
    pub(super) fn write(&self) -> Line {
        let line = Writer::new("CRASH").text(self.cause).number(self.boot);
        self.site.write(line).finish()
    }

    /// Parses the fields of a sentence after its name `CRASH`.
    pub(super) fn parse(fields: &mut Fields<'a>) -> Result<Self, ParseError> {
        Ok(Self {
            cause: fields.text("cause")?,
            boot: fields.number("boot")?,
            site: CrashSite::parse(fields)?,
        })
    }
}
