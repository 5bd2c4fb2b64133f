//! Purpose and maintainer of each crate of the image: written by hand, one entry for each crate and version series.
//!
//! A crate without an entry, or an entry without a crate, fails a test: an added dependency needs both.

use super::graph::Id;

/// Kind of maintainer of a crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// The embedded working group of the Rust project.
    WorkingGroup,
    /// The Rust project itself.
    Rust,
    /// An organisation, or several people with the rights to publish.
    Several,
    /// One person's account.
    One,
    /// This repository, for its own crates.
    Here,
}

impl By {
    /// Returns the maintainer's name in the table.
    pub fn as_str(self) -> &'static str {
        match self {
            By::WorkingGroup => "working group",
            By::Rust => "Rust project",
            By::Several => "several",
            By::One => "one person",
            By::Here => "here",
        }
    }
}

/// Purpose and maintainer of a crate.
#[derive(Clone, Copy, Debug)]
pub struct Note {
    /// Name of the crate, and the beginning of its version.
    pub of: (&'static str, &'static str),
    /// Purpose of the crate in the image.
    pub why: &'static str,
    /// Maintainer of the crate.
    pub by: By,
}

const fn note(name: &'static str, version: &'static str, by: By, why: &'static str) -> Note {
    Note {
        of: (name, version),
        why,
        by,
    }
}

/// Notes on all crates of the image, in the order of their names.
pub const NOTES: &[Note] = &[
    note(
        "bare-metal",
        "0.2",
        By::WorkingGroup,
        "token of a critical section, for `cortex-m`",
    ),
    note(
        "bare-metal",
        "1.",
        By::WorkingGroup,
        "the same type in the version of `stm32f4xx-hal`",
    ),
    note(
        "bitfield",
        "0.13",
        By::One,
        "bits of the core's registers, for `cortex-m`",
    ),
    note(
        "bitflags",
        "1.",
        By::Several,
        "flags of a log frame, for `defmt`",
    ),
    note("byteorder", "1.", By::One, "words from bytes, for `hash32`"),
    note(
        "cortex-m",
        "0.7",
        By::WorkingGroup,
        "the core's registers, interrupts off and on, barriers",
    ),
    note(
        "cortex-m-rt",
        "0.7",
        By::WorkingGroup,
        "vector table, reset handler, linker script",
    ),
    note(
        "crc",
        "3.",
        By::Several,
        "CRC-32 of sentences, radar frames, settings and the seal",
    ),
    note(
        "crc-catalog",
        "2.",
        By::One,
        "the polynomial's parameters, for `crc`",
    ),
    note(
        "critical-section",
        "1.",
        By::WorkingGroup,
        "interface of critical sections, which `cortex-m` implements",
    ),
    note(
        "defmt",
        "1.",
        By::Several,
        "log lines as numbers, decoded on the host",
    ),
    note(
        "defmt-rtt",
        "1.",
        By::Several,
        "the memory through which a debug probe reads them",
    ),
    note(
        "deranged",
        "0.5",
        By::One,
        "integers within bounds, for `time`",
    ),
    note(
        "embedded-dma",
        "0.2",
        By::WorkingGroup,
        "what may be a DMA buffer, for `stm32f4xx-hal`",
    ),
    note(
        "embedded-hal",
        "0.2",
        By::WorkingGroup,
        "the older pin and port traits, for `cortex-m` and `stm32f4xx-hal`",
    ),
    note(
        "embedded-hal",
        "1.",
        By::WorkingGroup,
        "pins of the mirror's motor and the SPI bus as traits",
    ),
    note(
        "embedded-hal-nb",
        "1.",
        By::WorkingGroup,
        "the traits' non-blocking half, for `stm32f4xx-hal`",
    ),
    note(
        "embedded-io",
        "0.6",
        By::WorkingGroup,
        "byte streams as traits, for `stm32f4xx-hal`",
    ),
    note(
        "embedded-storage",
        "0.3",
        By::WorkingGroup,
        "the flash of the settings as a trait",
    ),
    note(
        "enumflags2",
        "0.7",
        By::One,
        "sets of peripheral flags, for `stm32f4xx-hal`",
    ),
    note(
        "fugit",
        "0.3",
        By::One,
        "frequencies and durations as types, for `stm32f4xx-hal`",
    ),
    note(
        "fugit-timer",
        "0.1",
        By::One,
        "timers with these types, for `stm32f4xx-hal`",
    ),
    note(
        "gcd",
        "2.",
        By::One,
        "greatest common divisor of two clock rates, for `fugit`",
    ),
    note(
        "hash32",
        "0.3",
        By::One,
        "hashes of 32 bits, for the maps of `heapless`, which are not used here",
    ),
    note(
        "heapless",
        "0.9",
        By::WorkingGroup,
        "vectors and strings of bounded length without a heap",
    ),
    note("libm", "0.2", By::Rust, "correctly rounded square root"),
    note(
        "micromath",
        "2.",
        By::One,
        "ceil, floor and round, the same bits everywhere",
    ),
    note(
        "nb",
        "0.1",
        By::WorkingGroup,
        "the older non-blocking result, which refers to `nb` 1",
    ),
    note(
        "nb",
        "1.",
        By::WorkingGroup,
        "non-blocking results of the serial ports",
    ),
    note(
        "num-conv",
        "0.2",
        By::One,
        "conversions that lose nothing, for `time`",
    ),
    note(
        "portable-atomic",
        "1.",
        By::One,
        "atomic flags, for `rtic` and `stm32f4`",
    ),
    note("powerfmt", "0.2", By::One, "padded output, for `time`"),
    note(
        "rand_core",
        "0.6",
        By::Several,
        "interface that `stm32f4xx-hal` implements for the chip's generator, unused here",
    ),
    note(
        "rand_core",
        "0.9",
        By::Several,
        "the same in its next version",
    ),
    note(
        "rand_core",
        "0.10",
        By::Several,
        "interface of the particles' generator",
    ),
    note(
        "rand_xoshiro",
        "0.8",
        By::Several,
        "the particles' random numbers",
    ),
    note(
        "rtic",
        "2.",
        By::Several,
        "priorities of interrupts, and data that they share without races",
    ),
    note(
        "rtic-core",
        "1.",
        By::Several,
        "traits of shared data, for `rtic`",
    ),
    note(
        "stable_deref_trait",
        "1.",
        By::One,
        "a marker of buffers that do not move, for `heapless` and `embedded-dma`",
    ),
    note("stairscan", "0.", By::Here, "the scanner"),
    note(
        "stm32f4",
        "0.16",
        By::Several,
        "the chip's registers, generated from its maker's description",
    ),
    note(
        "stm32f4xx-hal",
        "0.23",
        By::Several,
        "clocks, pins, serial ports, DMA, timers, flash, ADC",
    ),
    note(
        "time",
        "0.3",
        By::Several,
        "dates of the chip's clock, for `stm32f4xx-hal`, unused here",
    ),
    note(
        "time-core",
        "0.1",
        By::Several,
        "calendar arithmetic, for `time`",
    ),
    note(
        "vcell",
        "0.1",
        By::WorkingGroup,
        "a cell that is read and written as it stands, for registers",
    ),
    note(
        "void",
        "1.",
        By::One,
        "an error that cannot occur, for `nb` 0.1 and `stm32f4xx-hal`",
    ),
    note(
        "volatile-register",
        "0.2",
        By::WorkingGroup,
        "registers that are read or written only, for `cortex-m`",
    ),
];

/// Returns the note on a crate; `None` if there is none for its version.
pub fn of(id: &Id) -> Option<&'static Note> {
    NOTES.iter().find(|note| {
        let (name, version) = note.of;
        name == id.name && id.version.starts_with(version)
    })
}
