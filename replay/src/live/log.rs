//! Logs of a scanner's sentences: the files of `live --record` and `record`, and those of any serial logger.
//!
//! A time may stand before each line: `MS <` of `live`, a time of day with or without a date, seconds or milliseconds.
//! Without times those of `LIVE` count, else a second an answer. Lines end with CR, LF or both; a byte order mark, UTF-16
//! and noise between the sentences are taken.

mod stamp;

use anyhow::{Result, bail};
use stairscan::report::{GuardLine, Sentence};

use super::Ms;
use super::arrived::Arrived;
use super::lines::Splitter;
use super::model::{Event, State, Way};
use crate::answer::Answer;
use stamp::{Clock, Stamp};

/// First words of the remark with which `live --record` begins a file.
const BEGUN: &str = ", begun ";

/// A line of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Logged {
    /// Time, ms since the log's beginning.
    pub at: Ms,
    /// Direction of the line, or remark; [`Way::In`] also for lines that are no sentence.
    pub way: Way,
    /// The line, without its time.
    pub text: String,
}

/// The lines of a log in order.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// Name of the log, for messages.
    pub name: String,
    /// The lines, oldest first.
    pub lines: Vec<Logged>,
    /// Time of the log's beginning, ms since 1970; `None` if the log does not tell it. A local time is taken as UTC.
    pub begun_ms: Option<u64>,
    /// Source of the times: `log`, `LIVE`, or `none` (a second an answer).
    pub clock: &'static str,
}

/// Whether `bytes` may be a log: a text with the beginning of a sentence.
pub fn may_be(bytes: &[u8]) -> bool {
    let bytes = utf8(bytes);
    bytes.windows(6).any(|six| six == b"$PSTR,")
}

/// Returns the text's bytes without a byte order mark, as UTF-8 if they are UTF-16.
fn utf8(bytes: &[u8]) -> Vec<u8> {
    let wide = |of: fn([u8; 2]) -> u16| -> Vec<u8> {
        let (pairs, _) = bytes[2..].as_chunks::<2>();
        let units: Vec<u16> = pairs.iter().map(|pair| of(*pair)).collect();
        String::from_utf16_lossy(&units).into_bytes()
    };
    // Noise may begin with the same two bytes.
    let zeros = bytes.iter().filter(|byte| **byte == 0).count();
    match bytes {
        [0xFF, 0xFE, ..] if 3 * zeros > bytes.len() => wide(u16::from_le_bytes),
        [0xFE, 0xFF, ..] if 3 * zeros > bytes.len() => wide(u16::from_be_bytes),
        [0xEF, 0xBB, 0xBF, rest @ ..] => rest.to_vec(),
        _ => bytes.to_vec(),
    }
}

/// Returns time, way and text of a line of `live --record` or `record`.
fn own(line: &[u8]) -> Option<(Ms, u8, &[u8])> {
    let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let (number, rest) = line.split_at(digits);
    let &[b' ', way @ (b'<' | b'>' | b'#' | b'r'), b' ', ref text @ ..] = rest else {
        return None;
    };
    let ms = std::str::from_utf8(number).ok()?.parse().ok()?;
    Some((ms, way, text))
}

impl Log {
    /// Reads a log with the name `name`.
    ///
    /// # Errors
    /// It has no intact sentence; the message tells what it has.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self> {
        let mut log = Self {
            name: name.to_owned(),
            clock: "log",
            ..Self::default()
        };
        let mut clock = Clock::default();
        let (mut arrived, mut stamped) = (Arrived::default(), 0_u64);
        for line in utf8(bytes).split(|byte| matches!(byte, b'\r' | b'\n')) {
            let (stamp, way, text) = match own(line) {
                Some((_, b'r', _)) => continue,
                Some((ms, way, text)) => (Some(Stamp::Own(ms)), way, text),
                None => (None, b'<', line),
            };
            let mut pieces = Splitter::default().push(&[text, b"\n"].concat());
            if way != b'<' {
                log.remark(clock.at(stamp), way, &pieces.concat());
                continue;
            }
            let before = pieces.first().filter(|piece| !piece.starts_with('$'));
            let stamp = stamp.or_else(|| before.and_then(|before| stamp::parse(before)));
            let at = clock.at(stamp);
            if pieces.len() > 1
                && (stamp.is_some() || before.is_some_and(|text| text.trim().is_empty()))
            {
                pieces.retain(|piece| piece.starts_with('$'));
            }
            for text in pieces {
                let intact = arrived.line(&text);
                stamped += u64::from(intact && stamp.is_some());
                log.lines.push(Logged {
                    at,
                    way: Way::In,
                    text,
                });
            }
        }
        if arrived.sentences == 0 {
            bail!("{name}: {}", arrived.instead_of_sentences());
        }
        log.begun_ms = log.begun_ms.or(clock.begun_ms());
        if 2 * stamped < arrived.sentences {
            log.time_by_sentences();
        }
        Ok(log)
    }

    /// Adds a sent line or a remark.
    fn remark(&mut self, at: Ms, way: u8, text: &str) {
        let way = if way == b'>' { Way::Out } else { Way::Note };
        let seconds = text.split_once(BEGUN).and_then(|(_, rest)| {
            let (number, _) = rest.split_once(' ')?;
            number.parse::<u64>().ok()
        });
        match seconds {
            Some(seconds) if way == Way::Note => self.begun_ms = Some(1000 * seconds),
            _ => self.lines.push(Logged {
                at,
                way,
                text: text.to_owned(),
            }),
        }
    }

    /// Replaces the times by those of `LIVE`, or without it by a second an answer.
    fn time_by_sentences(&mut self) {
        let is = |line: &Logged, live: bool| match Sentence::parse(&line.text) {
            Ok(Sentence::Live(_)) => live,
            Ok(Sentence::Scan(_)) => !live,
            _ => false,
        };
        let lives = self.lines.iter().filter(|line| is(line, true)).count();
        self.clock = if lives > 1 { "LIVE" } else { "none" };
        self.begun_ms = None;
        let (mut clock, mut answers) = (Clock::default(), 0);
        for line in &mut self.lines {
            let stamp = match Sentence::parse(&line.text) {
                Ok(Sentence::Live(live)) if lives > 1 => Some(Stamp::Count(live.uptime_ms.into())),
                Ok(Sentence::Scan(_)) if lives <= 1 => {
                    answers += 1;
                    Some(Stamp::Count(1000 * answers))
                }
                _ => None,
            };
            line.at = clock.at(stamp);
        }
    }

    /// Returns the log's duration, ms.
    pub fn length(&self) -> Ms {
        self.lines.last().map_or(0, |line| line.at)
    }

    /// Calls `seen` with each line and the state of the scanner after it, as `live` shows it.
    pub fn follow(&self, mut seen: impl FnMut(&Logged, &State)) {
        let mut state = State::new(&self.name, 0);
        state.take(self.lines.first().map_or(0, |line| line.at), &Event::Opened);
        for line in &self.lines {
            match line.way {
                Way::Out => state.sent(line.at, &line.text),
                Way::Note => state.note(line.at, &line.text),
                Way::In | Way::Damaged => state.take(line.at, &Event::Line(line.text.clone())),
            }
            seen(line, &state);
        }
    }

    /// Returns the lines of guard sweeps, with what they say.
    pub fn sweeps(&self) -> impl Iterator<Item = (&Logged, GuardLine)> {
        self.lines
            .iter()
            .filter_map(|line| match Sentence::parse(&line.text) {
                Ok(Sentence::Guard(sweep)) if line.way == Way::In => Some((line, sweep)),
                _ => None,
            })
    }

    /// Returns the complete answers with their times, ms since the log's beginning.
    pub fn answers(&self) -> Vec<(Ms, Answer)> {
        let mut answers = Vec::new();
        self.follow(|_, state| {
            if let Some((at, answer)) = &state.answer
                && state.answers > answers.len() as u64
            {
                answers.push((*at, answer.clone()));
            }
        });
        answers
    }
}

#[cfg(test)]
mod tests;
