//! Sentence `BOOT`: identity of firmware and chip, and where the firmware before the reset crashed.

use super::crash::CrashSite;
use super::fields::{Fields, ParseError};
use super::frame::Line;
use super::writer::Writer;

/// Content of the sentence `BOOT`, the first one after a reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BootLine<'a> {
    /// Version of the firmware.
    pub version: &'a str,
    /// Git revision of the build.
    pub revision: &'a str,
    /// Cause of the reset, such as `power-on` or `watchdog`.
    pub reset: &'a str,
    /// Clock source of the core: `hse-168` or `hsi-16`.
    pub clock: &'a str,
    /// Number of boots since power-on, including this one.
    pub boots: u32,
    /// Hash ([`Settings::hash`](crate::scanner::Settings::hash)) of the settings at boot.
    pub settings: u32,
    /// Unique number of the chip, 96 bits, in the order of its memory.
    pub serial: [u32; 3],
    /// State of the chip's second memory, such as `ccm-64`; empty if unknown.
    pub second_memory: &'a str,
    /// Register FLASH_OPTCR with the option bytes; `None` if unknown.
    pub option_bytes: Option<u32>,
    /// Place of the crash that caused the reset; empty without one.
    pub crash: CrashSite,
}

impl<'a> BootLine<'a> {
    /// Returns the sentence, with its CRC and line end.
    pub(super) fn write(&self) -> Line {
        let line = Writer::new("BOOT")
            .text(self.version)
            .text(self.revision)
            .text(self.reset)
            .text(self.clock)
            .number(self.boots)
            .hex(&[self.settings])
            .hex(&self.serial)
            .text(self.second_memory)
            .word(self.option_bytes);
        self.crash.write(line).finish()
    }

    /// Parses the fields of a sentence after its name `BOOT`. The sentence of an older firmware ends behind the
    /// chip's number.
    pub(super) fn parse(fields: &mut Fields<'a>) -> Result<Self, ParseError> {
        let older = Self {
            version: fields.text("version")?,
            revision: fields.text("revision")?,
            reset: fields.text("reset")?,
            clock: fields.text("clock")?,
            boots: fields.number("boots")?,
            settings: fields.hash("settings")?,
            serial: fields.hex("serial")?,
            ..Self::default()
        };
        if fields.ended() {
            return Ok(older);
        }
        Ok(Self {
            second_memory: fields.text("second-memory")?,
            option_bytes: fields.optional_hash("option-bytes")?,
            crash: CrashSite::parse(fields)?,
            ..older
        })
    }
}
