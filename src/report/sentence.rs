//! Sentences of the report UART: format, writer and parser.
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
//! | `GUARD` | number of the sweep since the guard was switched on; `ok`, `degraded` or `fault`; free distance; hazard that ends it: `none`, `rise`, `drop`, `obstacle` or `unknown`; confidence; reasons joined by `+` |
//! | `BOOT` | version; git revision; reset cause; clock source; boots since power-on; settings; serial number of the chip; second memory (`none`, `ccm-64`, `sram3-64`, `damaged`); option bytes; of the crash before the reset: PC, LR, CFSR, fault address, hash of the panic's place |
//! | `CRASH` | last crash since power-on: reset cause, or `none`; number of the boot that crashed; PC, LR, CFSR, fault address, hash of the panic's place |
//! | `STAT` | state; clock source; scans since boot; estimator; reasons joined by `+`; motion input (`absent`, `good`, `late`, `jumping`, `frozen`, `garbled`, `disordered`); faults of the motion input since boot; settings |
//! | `LIVE` | state; scan; ms since boot; ms since the last row of the last scan that was no fault; motion input; faults of the motion input; refused lines; damaged or lost bytes of this port; requests that the radar module did not answer correctly |
//! | `CONF` | key; value |
//! | `DONE` | command |
//! | `FAIL` | command or `-`; field or `-`; expected value: all text up to the CRC, possibly a command with its own frame |
//! | `HALT` | reason: the firmware stopped with a fault and resets the chip |
//!
//! Lengths are in millimetres with one decimal; a field without a value (the last step's tread depth) is empty.
//! The horizon is the distance from the mirror up to which the answer is valid: `ok` guarantees that no step up
//! to there is missing or false and that each distance and height is within max(30 mm, 3σ), at most 80 mm. The
//! confidence is the probability that the answer is right up to the horizon (or over the first metre, if that
//! is farther), in per cent with one decimal. Both are empty if the estimator does not give them.
//!
//! A scan is one `SCAN`, then its `STEP`s, then at most one `DROP`, then its `MAYBE`s, each nearest first. A
//! `DROP` is sent where the ground ends or falls by more than 40 mm and no staircase going down is reported;
//! the ground does not end before distance − 3σ, and the depth of the next surface is empty if it is not known.
//! A `MAYBE` is a possible step or drop that the answer does not contain, with its probability in per cent; a
//! negative height is a possible end of the ground. None of these sentences contains a time or a clock, so the
//! same chirps give the same bytes everywhere.
//!
//! `GUARD` is the result of one guard sweep. The free distance is that up to which the ground has no rise or
//! drop of more than 40 mm and no obstacle, from the mirror at the sweep's last row; it is empty in a `fault`,
//! and 0.0 if a health check of the instrument failed or the mounting was never configured. `none`: nothing ends
//! it within the range of a sweep. `unknown`: the ground is not seen beyond. The confidence is the probability
//! that no hazard is nearer.
//!
//! `LIVE` is sent five times a second without a request, in every state, possibly between the sentences of a
//! scan. It is the only sentence with times. Its counters count since boot and saturate at 65535.
//!
//! The field settings is the CRC-32 of all settings that change an answer ([`crate::scanner::Settings::hash`]),
//! in eight hex digits: a host can verify with every scan that its settings are still in force.
//!
//! Numbers are written digit by digit instead of by `core::fmt`, which would be the largest part of the image
//! and would link unreachable panics.

mod boot;
mod crash;
mod fields;
mod frame;
mod guard;
mod lines;
mod live;
mod writer;

use crate::answer::Direction;
use crate::verdict::{Outcome, Reason, Reasons, Status};
pub use boot::BootLine;
pub use crash::{CrashLine, CrashSite};
pub(super) use fields::Fields;
pub use fields::ParseError;
pub use frame::{Line, MAX_SENTENCE, PREFIX, Tenths, crc32};
pub use guard::GuardLine;
pub use lines::{DropLine, MaybeLine, ScanLine, SlopeField, StepLine};
pub use live::LiveLine;
pub(crate) use writer::Writer;

/// Any sentence of the scanner; its text is borrowed from the parsed line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sentence<'a> {
    /// Head of a scan's answer.
    Scan(ScanLine),
    /// One step of a scan.
    Step(StepLine),
    /// Edge where the ground ends, if no staircase going down is reported.
    Drop(DropLine),
    /// Possible step or drop that the answer does not contain.
    Maybe(MaybeLine),
    /// Free distance ahead by a guard sweep.
    Guard(GuardLine),
    /// First sentence after boot.
    Boot(BootLine<'a>),
    /// Answer to `crash?`.
    Crash(CrashLine<'a>),
    /// Answer to `status`.
    State {
        /// Name of the scanner's state, such as `idle` or `scanning`.
        state: &'a str,
        /// Clock source of the core: `hse-168` or `hsi-16`.
        clock: &'a str,
        /// Number of scans begun since boot.
        scans: u32,
        /// Name of the estimator in use.
        estimator: &'a str,
        /// Reasons of the last answer, guard sweep or failed self-test; before the first of these, those of the
        /// reset.
        reasons: Reasons,
        /// State of the motion input, such as `absent` or `good`.
        motion: &'a str,
        /// Number of motion sentences that were wrong or too late, since boot.
        motion_faults: u16,
        /// Hash of the settings of the next scan.
        settings: u32,
    },
    /// State and counters of the scanner, five times a second.
    Live(LiveLine<'a>),
    /// Value of one setting or diagnostic value, or the version.
    Config {
        /// Key of the setting or diagnostic value, or `version`.
        key: &'a str,
        /// The value as text.
        value: &'a str,
    },
    /// A command was executed.
    Done {
        /// Word of the command that was executed.
        command: &'a str,
    },
    /// A command was refused; nothing changed.
    Fail {
        /// Word of the command that was refused; `-` if the line has no known one.
        command: &'a str,
        /// Argument or condition that is wrong, or `-`.
        field: &'a str,
        /// Value or condition that is expected in its place.
        expected: &'a str,
    },
    /// The firmware stopped and is about to reset the chip.
    Halt {
        /// Reason for which the firmware stopped.
        reason: Reason,
    },
}

impl Status {
    /// Returns the status as it appears in a sentence.
    pub const fn as_str(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Degraded => "degraded",
            Status::Fault => "fault",
        }
    }
}

impl Direction {
    /// Returns the direction of the stairs as it appears in a sentence.
    pub const fn as_str(self) -> &'static str {
        match self {
            Direction::None => "none",
            Direction::Up => "up",
            Direction::Down => "down",
        }
    }
}

impl Sentence<'_> {
    /// Returns the sentence as a line, with its CRC and line end.
    pub fn write(&self) -> Line {
        match *self {
            Sentence::Scan(s) => s.write(),
            Sentence::Step(s) => s.write(),
            Sentence::Drop(d) => d.write(),
            Sentence::Maybe(m) => m.write(),
            Sentence::Guard(g) => g.write(),
            Sentence::Boot(ref b) => b.write(),
            Sentence::Crash(ref c) => c.write(),
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
    /// Returns whether the frame, the CRC or which field is wrong.
    pub fn parse(line: &str) -> Result<Sentence<'_>, ParseError> {
        let line = line.trim_end_matches(['\r', '\n']);
        if !line.bytes().all(|b| matches!(b, b' '..=b'~')) {
            return Err(ParseError::Frame);
        }
        let body = line.strip_prefix('$').ok_or(ParseError::Frame)?;
        let (body, sum) = body.rsplit_once('*').ok_or(ParseError::Frame)?;
        // `from_str_radix` would accept a sign.
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
            "BOOT" => Sentence::Boot(BootLine::parse(&mut fields)?),
            "CRASH" => Sentence::Crash(CrashLine::parse(&mut fields)?),
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
            // The last field of `FAIL` may contain any text.
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

/// Identity of a scan in its sentences.
#[derive(Clone, Copy, Debug)]
pub struct ScanId {
    /// Number of the scan since boot.
    pub scan: u32,
    /// Hash of the settings in force.
    pub settings: u32,
}

impl ScanId {
    /// First scan of a scanner whose settings have the hash 0: for answers that no scanner gave.
    pub const FIRST: Self = Self {
        scan: 1,
        settings: 0,
    };
}

/// Returns sentence `k` (from 0) of the answer `outcome` to the scan `id`: head, steps, drop, possible further steps,
/// in this order; `None` beyond the last.
pub fn of_scan(id: ScanId, lost_rows: u16, outcome: &Outcome, k: u8) -> Option<Sentence<'static>> {
    let ScanId { scan, settings } = id;
    let head = ScanLine::new(scan, lost_rows, outcome, settings);
    let Some(step) = k.checked_sub(1) else {
        return Some(Sentence::Scan(head));
    };
    let answer = &outcome.answer;
    let Some(drop) = step.checked_sub(head.steps) else {
        let reported = answer.steps.get(usize::from(step))?;
        return Some(Sentence::Step(StepLine::new(scan, k, head.steps, reported)));
    };
    let Some(maybe) = drop.checked_sub(head.drops) else {
        return Some(Sentence::Drop(DropLine::new(scan, answer.drop.as_ref()?)));
    };
    let reported = answer.possible_steps.get(usize::from(maybe));
    let reported = reported.filter(|_| maybe < head.possible_steps)?;
    let line = MaybeLine::new(scan, maybe.saturating_add(1), head.possible_steps, reported);
    Some(Sentence::Maybe(line))
}

/// Passes all sentences of the answer to the scan `id` to `sink`, in order.
pub fn write_scan(id: ScanId, lost_rows: u16, outcome: &Outcome, mut sink: impl FnMut(&Line)) {
    for k in 0..=u8::MAX {
        match of_scan(id, lost_rows, outcome, k) {
            Some(sentence) => sink(&sentence.write()),
            None => return,
        }
    }
}

#[cfg(test)]
mod tests;
