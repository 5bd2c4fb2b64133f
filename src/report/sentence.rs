//! The sentences of the report UART, written and parsed in one place.
//!
//! ASCII lines in the style of NMEA 0183: `$PSTR,` (a proprietary sentence of the stair scanner),
//! the sentence's name, comma-separated fields, `*`, a CRC-32 (ISO-HDLC, of everything between `$`
//! and `*`) as eight upper-case hex digits, CR LF. NMEA's 8-bit sum would let one garbled line in
//! 256 through.
//!
//! | sentence | fields |
//! |---|---|
//! | `SCAN` | number; `ok`, `degraded` or `fault`; `none`, `up` or `down`; steps; lost rows; reasons joined by `+`; horizon; confidence |
//! | `STEP` | scan number; index (from 1); of count; distance; height; tread depth; riser height; σ of distance; σ of height; quality 0…100 |
//! | `BOOT` | version; git revision; reset cause; clock |
//! | `STAT` | state; clock; scans since boot; estimator; reasons joined by `+` |
//! | `CONF` | key; value |
//! | `DONE` | command |
//! | `FAIL` | command or `-`; field or `-`; what was expected |
//! | `HALT` | reason: the firmware stopped with a fault and resets the chip |
//!
//! Lengths are millimetres with one decimal; a field without a value (the last step's tread depth)
//! is empty. The horizon is how far the answer vouches for itself, from the mirror; the confidence is
//! the probability that nothing is wrong up to there (or over the first metre, if that is farther), in
//! per cent with one decimal; both are empty where the estimator does not say. A scan is one `SCAN` and then its `STEP`s, nearest first; they hold no time and no
//! clock, so that the same chirps give the same bytes everywhere.
//!
//! Numbers are written digit by digit rather than through `core::fmt`, which would be the largest
//! thing in the image and brings panics that no one can reach but everyone must link.

use core::fmt;

use super::crc::CRC32;
use crate::answer::{Direction, Outcome, Reason, Reasons, Status, Step};

/// Longest sentence with its line end, bytes.
pub const MAX_SENTENCE: usize = 224;

/// One line, CR LF included.
pub type Line = heapless::String<MAX_SENTENCE>;

/// What every sentence begins with.
pub const PREFIX: &str = "$PSTR,";

/// CRC-32 (ISO-HDLC) of a sentence's body: what stands between `$` and `*`.
pub fn crc32(body: &str) -> u32 {
    CRC32.checksum(body.as_bytes())
}

/// A length in tenths of a millimetre, as sentences carry it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Tenths(pub i32);

impl Tenths {
    /// Largest magnitude that is written: 100 m.
    const LIMIT: i32 = 1_000_000;

    /// Rounds metres to a tenth of a millimetre, half away from zero; saturates at ±100 m, NaN is 0.
    pub fn from_metres(metres: f32) -> Self {
        let scaled = metres * 10_000.0;
        let rounded = scaled + if scaled < 0.0 { -0.5 } else { 0.5 };
        Self((rounded as i32).clamp(-Self::LIMIT, Self::LIMIT))
    }
}

/// One step as its sentence carries it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepLine {
    /// Number of the scan.
    pub scan: u32,
    /// Index of the step, from 1.
    pub index: u8,
    /// Number of steps of the scan.
    pub count: u8,
    /// Horizontal distance from the mirror's centre, negative behind it.
    pub distance: Tenths,
    /// Height above the ground.
    pub height: Tenths,
    /// Depth of the tread.
    pub tread: Option<Tenths>,
    /// Height of the riser.
    pub riser: Option<Tenths>,
    /// Standard deviation of the distance.
    pub distance_sigma: Tenths,
    /// Standard deviation of the height.
    pub height_sigma: Tenths,
    /// How much of the step was seen, 0…100.
    pub quality: u8,
}

impl StepLine {
    /// The sentence of `step`.
    pub fn new(scan: u32, index: u8, count: u8, step: &Step) -> Self {
        Self {
            scan,
            index,
            count,
            distance: Tenths::from_metres(step.distance_m),
            height: Tenths::from_metres(step.height_m),
            tread: step.tread_m.map(Tenths::from_metres),
            riser: step.riser_m.map(Tenths::from_metres),
            distance_sigma: Tenths::from_metres(step.distance_sigma_m),
            height_sigma: Tenths::from_metres(step.height_sigma_m),
            quality: step.quality.min(100),
        }
    }
}

/// The head of a scan's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanLine {
    /// Number of the scan since boot, from 1.
    pub scan: u32,
    /// What the answer is worth.
    pub status: Status,
    /// Where the stairs lead.
    pub direction: Direction,
    /// Number of `STEP` sentences that follow.
    pub steps: u8,
    /// Rows whose chirp was lost.
    pub lost_rows: u16,
    /// Why it is not `ok`, and what is weak where it is.
    pub reasons: Reasons,
    /// How far the answer vouches for itself, from the mirror.
    pub horizon: Option<Tenths>,
    /// How likely nothing is wrong up to there, tenths of a per cent.
    pub confidence: Option<u16>,
}

impl ScanLine {
    /// The head of an answer to scan number `scan`.
    pub fn new(scan: u32, lost_rows: u16, outcome: &Outcome) -> Self {
        let told = outcome.status != Status::Fault;
        let permille = |p: f32| (1000.0 * p + 0.5) as u16;
        Self {
            scan,
            status: outcome.status,
            direction: outcome.direction,
            steps: if told { outcome.steps.len() as u8 } else { 0 },
            lost_rows,
            reasons: outcome.reasons,
            horizon: outcome.horizon_m.filter(|_| told).map(Tenths::from_metres),
            confidence: outcome.confidence.filter(|_| told).map(permille),
        }
    }
}

/// Any sentence; text is borrowed from the line it was parsed from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sentence<'a> {
    /// Head of a scan's answer.
    Scan(ScanLine),
    /// One step of a scan.
    Step(StepLine),
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
    },
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

/// Builds one line field by field. A line that would grow too long is cut, never broken: the CRC
/// still closes what is there.
struct Writer {
    line: Line,
}

impl Writer {
    /// Room kept for `*`, the CRC and the line end.
    const TAIL: usize = 11;
    /// Room kept for horizon and confidence, which follow a scan's reasons.
    const AFTER_REASONS: usize = 20;

    fn new(name: &str) -> Self {
        let mut writer = Self { line: Line::new() };
        writer.raw(PREFIX);
        writer.raw(name);
        writer
    }

    fn push(&mut self, c: char) {
        if self.line.len() + Self::TAIL < MAX_SENTENCE {
            let _ = self.line.push(c);
        }
    }

    fn raw(&mut self, text: &str) {
        text.chars().for_each(|c| self.push(c));
    }

    /// Free text: whatever would break the sentence's frame becomes a space.
    fn text(mut self, text: &str) -> Self {
        self.push(',');
        for c in text.chars() {
            let plain = (' '..='~').contains(&c) && !matches!(c, ',' | '*' | '$');
            self.push(if plain { c } else { ' ' });
        }
        self
    }

    fn digits(&mut self, mut value: u32) {
        let mut reversed = [b'0'; 10];
        let mut count = 0;
        for slot in &mut reversed {
            *slot = b'0' + (value % 10) as u8;
            value /= 10;
            count += 1;
            if value == 0 {
                break;
            }
        }
        for &digit in reversed.iter().take(count).rev() {
            self.push(char::from(digit));
        }
    }

    fn number(mut self, value: u32) -> Self {
        self.push(',');
        self.digits(value);
        self
    }

    fn length(mut self, value: Option<Tenths>) -> Self {
        self.push(',');
        if let Some(Tenths(tenths)) = value {
            if tenths < 0 {
                self.push('-');
            }
            let magnitude = tenths.unsigned_abs();
            self.digits(magnitude / 10);
            self.push('.');
            self.digits(magnitude % 10);
        }
        self
    }

    fn reasons(mut self, reasons: Reasons) -> Self {
        self.push(',');
        let mut first = true;
        for reason in reasons.iter() {
            // What follows must find room, too: the rarest reasons stand last.
            let length = self.line.len() + 1 + reason.as_str().len();
            if length + Self::AFTER_REASONS + Self::TAIL > MAX_SENTENCE {
                break;
            }
            if !first {
                self.push('+');
            }
            first = false;
            self.raw(reason.as_str());
        }
        self
    }

    fn finish(mut self) -> Line {
        let crc = crc32(self.line.get(1..).unwrap_or(""));
        let _ = self.line.push('*');
        for shift in (0..8).rev() {
            let digit = (crc >> (4 * shift)) & 15;
            let _ = self.line.push(
                char::from_digit(digit, 16)
                    .unwrap_or('0')
                    .to_ascii_uppercase(),
            );
        }
        let _ = self.line.push_str("\r\n");
        self.line
    }
}

impl Sentence<'_> {
    /// The line, with its CRC and line end.
    pub fn write(&self) -> Line {
        match *self {
            Sentence::Scan(s) => Writer::new("SCAN")
                .number(s.scan)
                .text(s.status.as_str())
                .text(s.direction.as_str())
                .number(u32::from(s.steps))
                .number(u32::from(s.lost_rows))
                .reasons(s.reasons)
                .length(s.horizon)
                .length(s.confidence.map(|tenths| Tenths(tenths.into())))
                .finish(),
            Sentence::Step(s) => write_step(&s),
            Sentence::Boot {
                version,
                revision,
                reset,
                clock,
            } => Writer::new("BOOT")
                .text(version)
                .text(revision)
                .text(reset)
                .text(clock)
                .finish(),
            Sentence::State {
                state,
                clock,
                scans,
                estimator,
                reasons,
            } => Writer::new("STAT")
                .text(state)
                .text(clock)
                .number(scans)
                .text(estimator)
                .reasons(reasons)
                .finish(),
            Sentence::Config { key, value } => Writer::new("CONF").text(key).text(value).finish(),
            Sentence::Done { command } => Writer::new("DONE").text(command).finish(),
            Sentence::Fail {
                command,
                field,
                expected,
            } => Writer::new("FAIL")
                .text(command)
                .text(field)
                .text(expected)
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
        let body = line.strip_prefix('$').ok_or(ParseError::Frame)?;
        let (body, sum) = body.rsplit_once('*').ok_or(ParseError::Frame)?;
        if sum.len() != 8 || u32::from_str_radix(sum, 16) != Ok(crc32(body)) {
            return Err(ParseError::Crc);
        }
        let mut fields = Fields(body.split(','));
        if fields.0.next() != Some("PSTR") {
            return Err(ParseError::Frame);
        }
        let sentence = match fields.text("name")? {
            "SCAN" => Sentence::Scan(parse_scan(&mut fields)?),
            "STEP" => Sentence::Step(parse_step(&mut fields)?),
            "BOOT" => Sentence::Boot {
                version: fields.text("version")?,
                revision: fields.text("revision")?,
                reset: fields.text("reset")?,
                clock: fields.text("clock")?,
            },
            "STAT" => Sentence::State {
                state: fields.text("state")?,
                clock: fields.text("clock")?,
                scans: fields.number("scans")?,
                estimator: fields.text("estimator")?,
                reasons: fields.reasons("reasons")?,
            },
            "CONF" => Sentence::Config {
                key: fields.text("key")?,
                value: fields.text("value")?,
            },
            "DONE" => Sentence::Done {
                command: fields.text("command")?,
            },
            "FAIL" => Sentence::Fail {
                command: fields.text("command")?,
                field: fields.text("field")?,
                expected: fields.text("expected")?,
            },
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

fn write_step(s: &StepLine) -> Line {
    Writer::new("STEP")
        .number(s.scan)
        .number(u32::from(s.index))
        .number(u32::from(s.count))
        .length(Some(s.distance))
        .length(Some(s.height))
        .length(s.tread)
        .length(s.riser)
        .length(Some(s.distance_sigma))
        .length(Some(s.height_sigma))
        .number(u32::from(s.quality))
        .finish()
}

fn parse_scan(fields: &mut Fields<'_>) -> Result<ScanLine, ParseError> {
    Ok(ScanLine {
        scan: fields.number("scan")?,
        status: fields.word(
            "status",
            &[Status::Ok, Status::Degraded, Status::Fault],
            |s| s.as_str(),
        )?,
        direction: fields.word(
            "direction",
            &[Direction::None, Direction::Up, Direction::Down],
            |d| d.as_str(),
        )?,
        steps: fields.number("steps")?,
        lost_rows: fields.number("lost-rows")?,
        reasons: fields.reasons("reasons")?,
        horizon: fields.length("horizon")?,
        confidence: match fields.length("confidence")? {
            None => None,
            Some(Tenths(tenths @ 0..=1000)) => Some(tenths as u16),
            Some(_) => return Err(ParseError::Field("confidence")),
        },
    })
}

fn parse_step(fields: &mut Fields<'_>) -> Result<StepLine, ParseError> {
    let absent = |field| move |value: Option<Tenths>| value.ok_or(ParseError::Field(field));
    Ok(StepLine {
        scan: fields.number("scan")?,
        index: fields.number("index")?,
        count: fields.number("count")?,
        distance: fields.length("distance").and_then(absent("distance"))?,
        height: fields.length("height").and_then(absent("height"))?,
        tread: fields.length("tread")?,
        riser: fields.length("riser")?,
        distance_sigma: fields
            .length("distance-sigma")
            .and_then(absent("distance-sigma"))?,
        height_sigma: fields
            .length("height-sigma")
            .and_then(absent("height-sigma"))?,
        quality: fields.number("quality")?,
    })
}

/// Why a line is no sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParseError {
    /// It does not begin with `$PSTR` or has no `*`.
    Frame,
    /// Its CRC-32 does not fit.
    Crc,
    /// This field is missing or not what it should be.
    Field(&'static str),
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParseError::Frame => f.write_str("not a $PSTR sentence"),
            ParseError::Crc => f.write_str("CRC-32 does not fit"),
            ParseError::Field(field) => write!(f, "field {field} is missing or malformed"),
        }
    }
}

impl core::error::Error for ParseError {}

/// The fields of one sentence, taken from the left.
struct Fields<'a>(core::str::Split<'a, char>);

impl<'a> Fields<'a> {
    fn text(&mut self, field: &'static str) -> Result<&'a str, ParseError> {
        self.0.next().ok_or(ParseError::Field(field))
    }

    fn number<T: core::str::FromStr>(&mut self, field: &'static str) -> Result<T, ParseError> {
        self.text(field)?
            .parse()
            .map_err(|_| ParseError::Field(field))
    }

    fn word<T: Copy>(
        &mut self,
        field: &'static str,
        all: &[T],
        name: impl Fn(T) -> &'static str,
    ) -> Result<T, ParseError> {
        let text = self.text(field)?;
        all.iter()
            .copied()
            .find(|&t| name(t) == text)
            .ok_or(ParseError::Field(field))
    }

    fn length(&mut self, field: &'static str) -> Result<Option<Tenths>, ParseError> {
        let text = self.text(field)?;
        if text.is_empty() {
            return Ok(None);
        }
        let malformed = ParseError::Field(field);
        let (sign, digits) = match text.strip_prefix('-') {
            Some(rest) => (-1, rest),
            None => (1, text),
        };
        let (whole, tenth) = digits.split_once('.').ok_or(malformed)?;
        if tenth.len() != 1
            || whole.is_empty()
            || !digits.bytes().all(|b| b.is_ascii_digit() || b == b'.')
        {
            return Err(malformed);
        }
        let whole: i32 = whole.parse().map_err(|_| malformed)?;
        let tenth: i32 = tenth.parse().map_err(|_| malformed)?;
        let value = whole
            .checked_mul(10)
            .and_then(|v| v.checked_add(tenth))
            .ok_or(malformed)?;
        Ok(Some(Tenths(sign * value)))
    }

    fn reasons(&mut self, field: &'static str) -> Result<Reasons, ParseError> {
        let text = self.text(field)?;
        let mut reasons = Reasons::NONE;
        for word in text.split('+').filter(|w| !w.is_empty()) {
            let reason = Reason::ALL.iter().find(|r| r.as_str() == word);
            reasons.add(*reason.ok_or(ParseError::Field(field))?);
        }
        Ok(reasons)
    }
}

/// Hands the sentences of one scan to `sink`, in order.
pub fn write_scan(scan: u32, lost_rows: u16, outcome: &Outcome, mut sink: impl FnMut(&Line)) {
    let head = ScanLine::new(scan, lost_rows, outcome);
    let count = head.steps;
    sink(&Sentence::Scan(head).write());
    for (index, step) in (1..=count).zip(&outcome.steps) {
        sink(&Sentence::Step(StepLine::new(scan, index, count, step)).write());
    }
}

#[cfg(test)]
mod tests;
