//! The sentences of the report UART, written and parsed in one place.
//!
//! ASCII lines in the style of NMEA 0183: `$PSTR,` (a proprietary sentence of the stair scanner),
//! the sentence's name, comma-separated fields, `*`, a CRC-32 (ISO-HDLC, of everything between `$`
//! and `*`) as eight upper-case hex digits, CR LF. NMEA's 8-bit sum would let one garbled line in
//! 256 through.
//!
//! | sentence | fields |
//! |---|---|
//! | `SCAN` | number; `ok`, `degraded` or `fault`; `none`, `up` or `down`; steps; lost rows; reasons joined by `+`; horizon; confidence; maybes; settings; drops; with `plane both` the plane, else left out |
//! | `STEP` | scan number; index (from 1); of count; distance; height; tread depth; riser height; σ of distance; σ of height; quality 0…100 |
//! | `DROP` | scan number; distance; σ of distance; depth; probability |
//! | `MAYBE` | scan number; index (from 1); of count; distance; height; probability |
//! | `GUARD` | number of the sweep since the guard was switched on; `ok`, `degraded` or `fault`; free distance; what ends it: `none`, `rise`, `drop`, `obstacle` or `unknown`; confidence; reasons joined by `+` |
//! | `BOOT` | version; git revision; reset cause; clock; boots since power came; settings; serial number of the chip |
//! | `STAT` | state; clock; scans since boot; estimator; reasons joined by `+`; motion input (`absent`, `good`, `late`, `jumping`, `frozen`, `garbled`, `disordered`); faults of it since boot; settings |
//! | `LIVE` | state; scan; ms since boot; ms since the last row of the last scan that was no fault; motion input; faults of it; refused lines; damaged or lost bytes of this port; requests that the radar module did not answer as it should |
//! | `CONF` | key; value |
//! | `DONE` | command |
//! | `FAIL` | command or `-`; field or `-`; what was expected: all up to the CRC, which may hold a command with its own frame |
//! | `HALT` | reason: the firmware stopped with a fault and resets the chip |
//!
//! Lengths are millimetres with one decimal; a field without a value (the last step's tread depth)
//! is empty. The horizon is how far the answer vouches for itself, from the mirror: up to there `ok` promises that no step is
//! missing or made up and that each distance and height is within max(30 mm, 3σ), at most 80 mm. The confidence is
//! the probability that nothing is wrong up to there (or over the first metre, if that is farther), in
//! per cent with one decimal; both are empty where the estimator does not say. A scan is one `SCAN`, then its `STEP`s, then
//! at most one `DROP` (where the ground ends or falls by more than 40 mm and no staircase going down is told; the ground
//! does not end before distance − 3σ; the depth of the next surface is empty where it is not known), then its `MAYBE`s (what may stand there though the answer does not hold it, with its probability in per
//! cent; a negative height: the ground may end), each nearest first; they hold no time and no
//! clock, so that the same chirps give the same bytes everywhere.
//!
//! `GUARD` is the word of one guard sweep. The free distance is that up to which the ground goes on without a rise or a
//! drop of more than 40 mm and without anything on it, from the mirror at the sweep's last row; it is empty in a
//! `fault`, and 0.0 where the instrument is in doubt. `none` says that nothing ends it within the range that a sweep
//! sees, `unknown` that the ground is just not seen farther. The confidence is the probability that no hazard is nearer.
//!
//! `LIVE` comes by itself five times a second, in every state, and may stand between any two sentences.
//! Only there stand times. Its counters count since boot and stay at 65535.
//!
//! Settings are the CRC-32 of the values that decide an answer ([`crate::scanner::Settings::hash`]), in
//! eight hex digits: whoever set the scanner up sees at every scan that it still is.
//!
//! Numbers are written digit by digit rather than through `core::fmt`, which would be the largest
//! thing in the image and brings panics that no one can reach but everyone must link.

mod fields;
mod frame;
mod guard;
mod lines;
mod live;
mod writer;

use crate::answer::Direction;
use crate::verdict::{Outcome, Reason, Reasons, Status};
pub(super) use fields::Fields;
pub use fields::ParseError;
pub use frame::{Line, MAX_SENTENCE, PREFIX, Tenths, crc32};
pub use guard::GuardLine;
pub use lines::{DropLine, MaybeLine, ScanLine, StepLine};
pub use live::LiveLine;
pub(crate) use writer::Writer;

/// Any sentence; text is borrowed from the line it was parsed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sentence<'a> {
    /// Head of a scan's answer.
    Scan(ScanLine),
    /// One step of a scan.
    Step(StepLine),
    /// Where the ground ends.
    Drop(DropLine),
    /// What may stand there though the answer does not hold it.
    Maybe(MaybeLine),
    /// How far the ground is free by a guard sweep.
    Guard(GuardLine),
    /// First sentence after boot.
    Boot {
        /// Version of the firmware.
        version: &'a str,
        /// Git revision it was built from.
        revision: &'a str,
        /// Why the chip was reset.
        reset: &'a str,
        /// What drives the core: `hse-168` or `hsi-16`.
        clock: &'a str,
        /// Boots since power came, this one included.
        boots: u32,
        /// Hash of the settings that it begins with.
        settings: u32,
        /// The chip's own number, 96 bits, as it stands in its memory.
        serial: [u32; 3],
    },
    /// Answer to `status`.
    State {
        /// State of the scanner.
        state: &'a str,
        /// What drives the core.
        clock: &'a str,
        /// Scans since boot.
        scans: u32,
        /// Estimator in use.
        estimator: &'a str,
        /// What is wrong at present.
        reasons: Reasons,
        /// What the motion input is.
        motion: &'a str,
        /// Motion sentences since boot that were not as they should be, or missing too long.
        motion_faults: u16,
        /// Hash of the settings of the next scan.
        settings: u32,
    },
    /// How the scanner fares, five times a second.
    Live(LiveLine<'a>),
    /// One value of the configuration.
    Config {
        /// Its key.
        key: &'a str,
        /// Its value.
        value: &'a str,
    },
    /// A command was carried out.
    Done {
        /// The command.
        command: &'a str,
    },
    /// A command was refused; nothing changed.
    Fail {
        /// The command, or `-`.
        command: &'a str,
        /// The field that is wrong, or `-`.
        field: &'a str,
        /// What was expected of it.
        expected: &'a str,
    },
    /// The firmware stopped and is about to reset the chip.
    Halt {
        /// Why.
        reason: Reason,
    },
}

impl Status {
    /// The word that stands in a sentence.
    pub const fn as_str(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Degraded => "degraded",
            Status::Fault => "fault",
        }
    }
}

impl Direction {
    /// The word that stands in a sentence.
    pub const fn as_str(self) -> &'static str {
        match self {
            Direction::None => "none",
            Direction::Up => "up",
            Direction::Down => "down",
        }
    }
}

impl Sentence<'_> {
    /// The line, with its CRC and line end.
    pub fn write(&self) -> Line {
        match *self {
            Sentence::Scan(s) => s.write(),
            Sentence::Step(s) => s.write(),
            Sentence::Drop(d) => d.write(),
            Sentence::Maybe(m) => m.write(),
            Sentence::Guard(g) => g.write(),
            Sentence::Boot {
                version,
                revision,
                reset,
                clock,
                boots,
                settings,
                ref serial,
            } => Writer::new("BOOT")
                .text(version)
                .text(revision)
                .text(reset)
                .text(clock)
                .number(boots)
                .hex(&[settings])
                .hex(serial)
                .finish(),
            Sentence::State {
                state,
                clock,
                scans,
                estimator,
                reasons,
                motion,
                motion_faults,
                settings,
            } => Writer::new("STAT")
                .text(state)
                .text(clock)
                .number(scans)
                .text(estimator)
                .reasons(reasons)
                .text(motion)
                .number(motion_faults.into())
                .hex(&[settings])
                .finish(),
            Sentence::Live(l) => l.write(),
            Sentence::Config { key, value } => Writer::new("CONF").text(key).text(value).finish(),
            Sentence::Done { command } => Writer::new("DONE").text(command).finish(),
            Sentence::Fail {
                command,
                field,
                expected,
            } => Writer::new("FAIL")
                .text(command)
                .text(field)
                .rest(expected)
                .finish(),
            Sentence::Halt { reason } => Writer::new("HALT").text(reason.as_str()).finish(),
        }
    }

    /// Parses a line, with or without its line end.
    ///
    /// ```
    /// use stairscan::report::{ParseError, Sentence, Tenths};
    ///
    /// let line = "$PSTR,STEP,1,1,3,500.5,165.3,279.6,165.3,3.0,3.7,100*24063914\r\n";
    /// let Sentence::Step(step) = Sentence::parse(line)? else {
    ///     panic!("not a STEP");
    /// };
    /// assert_eq!((step.index, step.count), (1, 3));
    /// assert_eq!(step.distance, Tenths(5005));
    /// assert_eq!(Sentence::Step(step).write(), line);
    ///
    /// let damaged = line.replace("500.5", "600.5");
    /// assert_eq!(Sentence::parse(&damaged), Err(ParseError::Crc));
    /// # Ok::<(), ParseError>(())
    /// ```
    ///
    /// # Errors
    /// Says whether the frame, the CRC or which field is wrong.
    pub fn parse(line: &str) -> Result<Sentence<'_>, ParseError> {
        let line = line.trim_end_matches(['\r', '\n']);
        if !line.bytes().all(|b| matches!(b, b' '..=b'~')) {
            return Err(ParseError::Frame);
        }
        let body = line.strip_prefix('$').ok_or(ParseError::Frame)?;
        let (body, sum) = body.rsplit_once('*').ok_or(ParseError::Frame)?;
        // `from_str_radix` would take a sign for a digit.
        let digits = sum.len() == 8 && sum.bytes().all(|b| b.is_ascii_hexdigit());
        if !digits || u32::from_str_radix(sum, 16) != Ok(crc32(body)) {
            return Err(ParseError::Crc);
        }
        let mut fields = Fields(body.split([',']));
        if fields.0.next() != Some("PSTR") {
            return Err(ParseError::Frame);
        }
        let sentence = match fields.text("name")? {
            "SCAN" => Sentence::Scan(ScanLine::parse(&mut fields)?),
            "STEP" => Sentence::Step(StepLine::parse(&mut fields)?),
            "DROP" => Sentence::Drop(DropLine::parse(&mut fields)?),
            "MAYBE" => Sentence::Maybe(MaybeLine::parse(&mut fields)?),
            "GUARD" => Sentence::Guard(GuardLine::parse(&mut fields)?),
            "BOOT" => Sentence::Boot {
                version: fields.text("version")?,
                revision: fields.text("revision")?,
                reset: fields.text("reset")?,
                clock: fields.text("clock")?,
                boots: fields.number("boots")?,
                settings: fields.hash("settings")?,
                serial: fields.hex("serial")?,
            },
            "STAT" => Sentence::State {
                state: fields.text("state")?,
                clock: fields.text("clock")?,
                scans: fields.number("scans")?,
                estimator: fields.text("estimator")?,
                reasons: fields.reasons("reasons")?,
                motion: fields.text("motion")?,
                motion_faults: fields.number("motion-faults")?,
                settings: fields.hash("settings")?,
            },
            "LIVE" => Sentence::Live(LiveLine::parse(&mut fields)?),
            "CONF" => Sentence::Config {
                key: fields.text("key")?,
                value: fields.text("value")?,
            },
            "DONE" => Sentence::Done {
                command: fields.text("command")?,
            },
            // The last field holds what it likes.
            "FAIL" => {
                return Ok(Sentence::Fail {
                    command: fields.text("command")?,
                    field: fields.text("field")?,
                    expected: (body.splitn(5, ',').nth(4)).ok_or(ParseError::Field("expected"))?,
                });
            }
            "HALT" => Sentence::Halt {
                reason: fields.word("reason", Reason::ALL, |r| r.as_str())?,
            },
            _ => return Err(ParseError::Field("name")),
        };
        match fields.0.next() {
            None => Ok(sentence),
            Some(_) => Err(ParseError::Field("end")),
        }
    }
}

/// Sentence `k` (from 0) of a scan of this number, made with settings of this hash: its head, its steps, its drop, what else may stand there;
/// none beyond the last.
pub fn of_scan(
    (scan, settings): (u32, u32),
    lost_rows: u16,
    outcome: &Outcome,
    k: u8,
) -> Option<Sentence<'static>> {
    let head = ScanLine::new(scan, lost_rows, outcome, settings);
    let Some(step) = k.checked_sub(1) else {
        return Some(Sentence::Scan(head));
    };
    let answer = &outcome.answer;
    let Some(drop) = step.checked_sub(head.steps) else {
        let told = answer.steps.get(usize::from(step))?;
        return Some(Sentence::Step(StepLine::new(scan, k, head.steps, told)));
    };
    let Some(maybe) = drop.checked_sub(head.drops) else {
        return Some(Sentence::Drop(DropLine::new(scan, answer.drop.as_ref()?)));
    };
    let told = answer.maybes.get(usize::from(maybe));
    let told = told.filter(|_| maybe < head.maybes)?;
    let line = MaybeLine::new(scan, maybe.saturating_add(1), head.maybes, told);
    Some(Sentence::Maybe(line))
}

/// Hands the sentences of one scan to `sink`, in order; `of` is its number and its settings' hash.
pub fn write_scan(of: (u32, u32), lost_rows: u16, outcome: &Outcome, mut sink: impl FnMut(&Line)) {
    for k in 0..=u8::MAX {
        match of_scan(of, lost_rows, outcome, k) {
            Some(sentence) => sink(&sentence.write()),
            None => return,
        }
    }
}

#[cfg(test)]
mod tests;
