//! Parser of commands: lines of the report UART.
//!
//! A command is one line, ended by CR or LF: a command word and its arguments, separated by commas or spaces,
//! in lower case. Like a sentence it may be framed as `$PSTC,…*CRC` (CRC-32 in eight hex digits); the CRC must
//! then be right. A person at a terminal may omit the frame. Commands that change something permanently must be
//! framed, since one damaged letter makes another value. If the frame is missing, `FAIL` contains the framed
//! sentence to send instead ([`framed`] writes it).
//!
//! | command | effect | answer |
//! |---|---|---|
//! | `start` | scans repeatedly; survives a reset | `DONE` |
//! | `stop` | ends the current scan and stays idle; survives a reset | `DONE` |
//! | `scan` | one scan, when stopped or guarding | `DONE`, later `SCAN` and `STEP`s |
//! | `guard,on\|off` | sweeps the ground ahead many times a second; `scan` comes in between | `DONE`, later `GUARD`s |
//! | `watch,on\|off` | as `guard`, and a full scan when a rise or a drop comes near and the chair stands or slows | `DONE`, later `GUARD`s |
//! | `status` | | `STAT` |
//! | `version` | | `CONF` with version and revision |
//! | `crash?` | | `CRASH` with the last crash since power-on |
//! | `crash-clear` | deletes the record of the last crash | `DONE` |
//! | `selftest` | arithmetic, home, link, when stopped | `DONE` once passed, else `FAIL` |
//! | `get` | every setting, one sentence each | `CONF`s, `DONE` |
//! | `get,KEY` | a setting, or one of [`Measure`] | `CONF` |
//! | `set,KEY,VALUE` | framed; effective from the next scan ([`super::settings`] lists the keys) | `CONF` |
//! | `save` | framed, when stopped: writes the settings to flash ([`super::store`]) | `DONE` |
//! | `update` | framed, when stopped: resets the chip into the boot loader, which then takes a new image | none from the image |
//! | `calibrate,WALL_MM,DATE` | framed, when stopped: scans a flat floor and a wall, date as YYYYMMDD; sets and saves how the scanner is mounted ([`crate::mount::command`]) | later `CONF` with the range scale (1e-6), `DONE`, else `FAIL` |
//! | `reset` | discards the evidence of earlier scans: the next answer is a first one | `DONE` |
//! | `MOTION,…` | the chair's own motion, always framed ([`crate::report::motion`]) | none |
//!
//! Each error gets one `FAIL` that names the field, and changes nothing.

use core::iter::Filter;
use core::str::Split;

use super::settings::Settings;
use crate::config::ConfigError;
use crate::motion::Reading;
use crate::report::motion;
use crate::report::sentence::{Line, ParseError, Writer, crc32};
use crate::setting::{ValueText, hex, number};

/// Maximum length of a command line, bytes.
pub const MAX_COMMAND: usize = 96;

/// A parsed command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command<'a> {
    /// Scans repeatedly.
    Start,
    /// Ends the current scan and stays idle.
    Stop,
    /// Makes one scan.
    Scan,
    /// Switches repeated guard sweeps on or off.
    Guard(bool),
    /// Switches repeated guard sweeps on or off, with one full scan when a rise or drop comes near.
    Watch(bool),
    /// Reports state, clock and number of scans.
    Status,
    /// Reports version and revision.
    Version,
    /// Reports the last crash.
    Crash,
    /// Deletes the record of the last crash.
    ForgetCrash,
    /// Runs the self-test.
    SelfTest,
    /// Discards the evidence of earlier scans; the chip is not reset.
    Reset,
    /// Reports every setting.
    GetAll,
    /// Reports a diagnostic value, which is measured and cannot be set.
    Measure(Measure),
    /// Reports one setting.
    Get(&'static str),
    /// Changes one setting: its key, and its new value as text.
    Set(&'static str, &'a str),
    /// Saves the settings in flash.
    Save,
    /// Resets the chip into the boot loader, which then takes a new image.
    Update,
    /// Calibrates the mounting.
    Calibrate(CalibrationRequest),
    /// Travel and pitch of the chair, from its controller.
    Motion(Reading),
}

/// Arguments of `calibrate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CalibrationRequest {
    /// Horizontal distance from the mirror's centre to the wall, mm.
    pub wall_mm: u16,
    /// Year, month and day of the calibration as one number, such as 20261122.
    pub date: u32,
}

/// Diagnostic values that `get` reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Maximum stack use since boot, bytes.
    StackUsed,
    /// Size of the stack, bytes.
    StackSize,
    /// Content of the chip's option bytes ([`OptionBytes`](super::option_bytes::OptionBytes)); 0 if it is unknown.
    OptionBytes,
}

impl Measure {
    /// All diagnostic values.
    pub const ALL: [Self; 3] = [Self::StackUsed, Self::StackSize, Self::OptionBytes];

    /// Returns the key by which `get` reads this diagnostic value.
    pub const fn key(self) -> &'static str {
        match self {
            Measure::StackUsed => "stack-used",
            Measure::StackSize => "stack-size",
            Measure::OptionBytes => "option-bytes",
        }
    }

    /// Returns a value as text: a number; option bytes as eight hex digits, or `unknown`.
    pub(super) fn text(self, value: u32) -> ValueText {
        match (self, value) {
            (Measure::OptionBytes, 0) => ValueText::try_from("unknown").unwrap_or_default(),
            (Measure::OptionBytes, _) => hex(value),
            _ => number(i64::from(value)),
        }
    }

    fn find(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|measure| measure.key() == key)
    }
}

impl Command<'_> {
    /// Returns the word that names this command in the sentences `DONE` and `FAIL`.
    pub const fn word(&self) -> &'static str {
        match self {
            Command::Start => "start",
            Command::Stop => "stop",
            Command::Scan => "scan",
            Command::Guard(_) => "guard",
            Command::Watch(_) => "watch",
            Command::Status => "status",
            Command::Version => "version",
            Command::Crash => "crash?",
            Command::ForgetCrash => "crash-clear",
            Command::SelfTest => "selftest",
            Command::Reset => "reset",
            Command::GetAll | Command::Get(_) | Command::Measure(_) => "get",
            Command::Set(..) => "set",
            Command::Save => "save",
            Command::Update => "update",
            Command::Calibrate(_) => "calibrate",
            Command::Motion(_) => "MOTION",
        }
    }
}

/// A line that is no valid command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadCommand {
    /// The command word; `-` if the line has no known one.
    pub command: &'static str,
    /// The invalid field and its expected value.
    pub error: ConfigError,
}

fn bad(command: &'static str, field: &'static str, expected: &'static str) -> BadCommand {
    let error = ConfigError { field, expected };
    BadCommand { command, error }
}

/// Iterator over the words of a line, which commas and spaces separate.
type CommandWords<'a> = Filter<Split<'a, [char; 2]>, fn(&&'a str) -> bool>;

/// Returns the next word; `None` at the end of the line.
fn next<'a>(words: &mut CommandWords<'a>) -> Option<&'a str> {
    words.next()
}

/// Returns the next word as a whole number; `None` if there is no next word, or it is no number of 32 bits
/// without sign.
fn next_number(words: &mut CommandWords<'_>) -> Option<u32> {
    let number: i64 = next(words)?.parse().ok()?;
    number.try_into().ok()
}

/// Parses one line, framed or not, which is given without its line end.
pub fn parse(line: &str) -> Result<Command<'_>, BadCommand> {
    let body = unframe(line)?;
    if is_motion(line) {
        return motion::parse(body).map(Command::Motion).map_err(|error| {
            let field = match error {
                ParseError::Field(field) => field,
                ParseError::Frame | ParseError::Crc => "frame",
            };
            bad("MOTION", field, "a motion sentence's field")
        });
    }
    let mut words: CommandWords<'_> = body.split([',', ' ']).filter(|word| !word.is_empty());
    let command = match next(&mut words) {
        Some("start") => Command::Start,
        Some("stop") => Command::Stop,
        Some("scan") => Command::Scan,
        Some("guard") => Command::Guard(switch("guard", &mut words)?),
        Some("watch") => Command::Watch(switch("watch", &mut words)?),
        Some("status") => Command::Status,
        Some("version") => Command::Version,
        Some("crash?") => Command::Crash,
        Some("crash-clear") => Command::ForgetCrash,
        Some("selftest") => Command::SelfTest,
        Some("save") => Command::Save,
        Some("update") => Command::Update,
        Some("reset") => Command::Reset,
        Some("calibrate") => Command::Calibrate(calibration(&mut words)?),
        Some("get") => match next(&mut words) {
            None => Command::GetAll,
            Some(key) => match Measure::find(key) {
                Some(measure) => Command::Measure(measure),
                None => Command::Get(known_key("get", key)?),
            },
        },
        Some("set") => {
            let key = next(&mut words).unwrap_or("");
            let key = known_key("set", key)?;
            let value = next(&mut words);
            Command::Set(key, value.ok_or(bad("set", key, "a value"))?)
        }
        _ => {
            let expected = "start stop scan guard watch status version crash? crash-clear selftest reset get set save update or calibrate";
            return Err(bad("-", "command", expected));
        }
    };
    match next(&mut words) {
        None => Ok(command),
        Some(_) => Err(bad(command.word(), "arguments", "no further arguments")),
    }
}

/// Returns a command's words as a framed sentence, with CRC and line end.
///
/// ```
/// use stairscan::scanner::command::framed;
///
/// assert_eq!(framed(&["set", "seed", "7"]), "$PSTC,set,seed,7*352B37A8\r\n");
/// ```
pub fn framed(words: &[&str]) -> Line {
    let (name, rest) = words.split_first().unwrap_or((&"", &[]));
    let begun = Writer::behind("$PSTC,", name);
    rest.iter()
        .fold(begun, |line, word| line.text(word))
        .finish()
}

/// Whether `line` has a frame with a CRC. The line must be one that [`parse`] accepts: then the CRC is right.
pub fn is_framed(line: &str) -> bool {
    line.starts_with('$')
}

/// Whether a line is a motion sentence, possibly a damaged one: up to a hundred of these come in a second, and
/// none is answered.
pub fn is_motion(line: &str) -> bool {
    line.starts_with(motion::PREFIX)
}

/// Parses the argument of `guard` and `watch`: `on` gives `true`, `off` gives `false`.
fn switch(command: &'static str, words: &mut CommandWords<'_>) -> Result<bool, BadCommand> {
    match next(words) {
        Some("on") => Ok(true),
        Some("off") => Ok(false),
        _ => Err(bad(command, "switch", "on or off")),
    }
}

/// Parses the arguments of `calibrate`: distance of the wall, and date.
fn calibration(words: &mut CommandWords<'_>) -> Result<CalibrationRequest, BadCommand> {
    let wall_mm = next_number(words).and_then(|wall| wall.try_into().ok());
    let wall_mm = wall_mm.ok_or(bad("calibrate", "wall", "a distance in mm"))?;
    let valid = |date: &u32| {
        let (month, day) = (date / 100 % 100, date % 100);
        let years = (20_000_000..100_000_000).contains(date);
        years && (1..=12).contains(&month) && (1..=31).contains(&day)
    };
    let date = next_number(words).filter(valid);
    let date = date.ok_or(bad("calibrate", "date", "year, month and day: YYYYMMDD"))?;
    Ok(CalibrationRequest { wall_mm, date })
}

fn known_key(command: &'static str, key: &str) -> Result<&'static str, BadCommand> {
    Settings::key(key).ok_or(bad(command, "key", "a key listed by get"))
}

/// Returns the text of a framed line between `$PSTC,` and `*`, if its CRC is right; returns a line without a
/// frame whole.
fn unframe(line: &str) -> Result<&str, BadCommand> {
    let Some(body) = line.strip_prefix('$') else {
        return Ok(line);
    };
    // Not `rsplit_once`, which has a path to a panic.
    let star = body.len().checked_sub(9);
    let (body, sum) = star
        .and_then(|at| body.split_at_checked(at))
        .and_then(|(body, sum)| Some((body, sum.strip_prefix('*')?)))
        // `from_str_radix` would accept a leading sign.
        .filter(|(_, sum)| sum.bytes().all(|b| b.is_ascii_hexdigit()))
        .ok_or(bad("-", "crc", "* and eight hex digits at the end"))?;
    if u32::from_str_radix(sum, 16) != Ok(crc32(body)) {
        return Err(bad("-", "crc", "the CRC-32 of the text between $ and *"));
    }
    if body.bytes().any(|b| matches!(b, b'$' | b'*')) {
        return Err(bad("-", "frame", "neither $ nor * within"));
    }
    body.strip_prefix("PSTC,")
        .ok_or(bad("-", "frame", "$PSTC at the beginning"))
}

/// Result of one received byte, by [`LineReader::push`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParserEvent {
    /// The line is not complete yet.
    Partial,
    /// [`LineReader::line`] holds a line.
    Line,
    /// The line is too long, or has a byte that is not printable ASCII: the rest of it is skipped.
    Bad(ConfigError),
}

/// Collects bytes into lines. A line that is too long or not plain text causes one error, reported at once.
#[derive(Debug, Default)]
pub struct LineReader {
    bytes: heapless::Vec<u8, MAX_COMMAND>,
    complete: bool,
    skipping: bool,
}

impl LineReader {
    /// Takes one received byte; returns whether it completes a line, or makes the line invalid.
    pub fn push(&mut self, byte: u8) -> ParserEvent {
        if self.complete {
            self.complete = false;
            self.bytes.clear();
        }
        if matches!(byte, b'\r' | b'\n') {
            let skipped = core::mem::take(&mut self.skipping);
            if skipped || self.bytes.is_empty() {
                return ParserEvent::Partial;
            }
            self.complete = true;
            return ParserEvent::Line;
        }
        if self.skipping {
            return ParserEvent::Partial;
        }
        if !(b' '..=b'~').contains(&byte) {
            return self.skip("printable ASCII");
        }
        if self.bytes.push(byte).is_err() {
            return self.skip("at most 96 characters");
        }
        ParserEvent::Partial
    }

    fn skip(&mut self, expected: &'static str) -> ParserEvent {
        self.bytes.clear();
        self.skipping = true;
        ParserEvent::Bad(ConfigError {
            field: "line",
            expected,
        })
    }

    /// Returns the line that the last byte completed; empty if it completed none.
    pub fn line(&self) -> &str {
        if self.complete {
            core::str::from_utf8(&self.bytes).unwrap_or("")
        } else {
            ""
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::{format, string::String, vec::Vec};

    fn closed(body: &str) -> String {
        format!("${body}*{:08X}", crc32(body))
    }

    #[test]
    fn commands_parse_with_commas_spaces_and_frames() {
        assert_eq!(parse("start"), Ok(Command::Start));
        assert_eq!(parse(" status "), Ok(Command::Status));
        assert_eq!(parse("set,seed,7"), Ok(Command::Set("seed", "7")));
        assert_eq!(parse("set seed 7"), Ok(Command::Set("seed", "7")));
        assert_eq!(parse("get"), Ok(Command::GetAll));
        assert_eq!(parse(&closed("PSTC,get,plane")), Ok(Command::Get("plane")));
        let measure = Command::Measure(Measure::StackUsed);
        assert_eq!(parse("get stack-used"), Ok(measure));
    }

    #[test]
    fn errors_name_the_field() {
        for (line, command, field) in [
            ("", "-", "command"),
            ("Start", "-", "command"),
            ("startle", "-", "command"),
            ("start now", "start", "arguments"),
            ("get nothing", "get", "key"),
            ("calibrate", "calibrate", "wall"),
            ("calibrate 1500", "calibrate", "date"),
            ("calibrate 70000 20261122", "calibrate", "wall"),
            ("calibrate 1500 20261322", "calibrate", "date"),
            ("calibrate 1500 20261122 1", "calibrate", "arguments"),
            ("set", "set", "key"),
            ("set seed", "set", "seed"),
            ("set seed 1 2", "set", "arguments"),
            ("$PSTC,start", "-", "crc"),
            ("$PSTC,start*00000000", "-", "crc"),
            ("$PSTC,start*xyz", "-", "crc"),
        ] {
            let error = parse(line).unwrap_err();
            assert_eq!(
                (error.command, error.error.field),
                (command, field),
                "{line}"
            );
        }
        for body in [
            "XXXX,start",
            "PSTC,set,seed,7*",
            "PSTC,$start",
            "PSTC,set,seed,$7",
        ] {
            let error = parse(&closed(body)).unwrap_err();
            assert_eq!(error.error.field, "frame", "{body}");
        }
    }

    fn read(bytes: &[u8]) -> (Vec<String>, usize) {
        let mut reader = LineReader::default();
        let (mut lines, mut errors) = (Vec::new(), 0);
        for &byte in bytes {
            match reader.push(byte) {
                ParserEvent::Line => lines.push(reader.line().into()),
                ParserEvent::Bad(_) => errors += 1,
                ParserEvent::Partial => {}
            }
        }
        (lines, errors)
    }

    #[test]
    fn bad_lines_are_one_error_each_and_end_with_the_line() {
        let mut bytes = vec![b'x'; 5 * MAX_COMMAND];
        bytes.extend(b"\r\nstop\r\n\x00\xff\x07\nstatus\n\n");
        let (lines, errors) = read(&bytes);
        assert_eq!((lines, errors), (vec!["stop".into(), "status".into()], 2));
        let (lines, errors) = read(&[[b'y'; MAX_COMMAND].as_slice(), b"\n"].concat());
        assert_eq!((lines[0].len(), errors), (MAX_COMMAND, 0));
    }

    #[test]
    fn a_sign_is_no_digit_of_a_crc() {
        // A body whose CRC-32 begins with a zero; a sign then replaces that digit.
        let body = (0..).map(|k| std::format!("PSTC,set,seed,{k}"));
        let body = body
            .into_iter()
            .find(|body| crc32(body) >> 28 == 0)
            .unwrap();
        let line = closed(&body);
        assert!(parse(&line).is_ok(), "{line}");
        let signed = line.replace("*0", "*+");
        assert_eq!(parse(&signed).unwrap_err().error.field, "crc", "{signed}");
    }

    proptest! {
        #[test]
        fn any_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
            let (lines, _) = read(&bytes);
            for line in lines {
                let _ = parse(&line);
            }
        }

        #[test]
        fn any_text_never_panics(line in "[$*,a-z0-9 -]{0,96}") {
            let _ = parse(&line);
        }
    }
}
