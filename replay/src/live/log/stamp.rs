//! Times before the lines of a log.

use super::super::Ms;

/// A day, ms.
const DAY: i64 = 86_400_000;
/// Time back, ms, from which a clock has begun anew.
const ANEW: i64 = 1_000;

/// A time before a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamp {
    /// Time since 1970, ms.
    Date(Ms),
    /// Time of day, ms.
    Day(Ms),
    /// Time since some beginning, ms.
    Count(Ms),
    /// Time since the beginning of the log, ms.
    Own(Ms),
}

/// Times of a log's lines, which never run backwards.
#[derive(Debug, Default)]
pub struct Clock {
    /// The first time, as the log tells it; the log begins there.
    first: Option<Stamp>,
    /// Time added since the clock has begun anew, or a day has passed, ms.
    offset: i64,
    last: Ms,
}

impl Clock {
    /// Returns the time of a line, ms since the log's beginning; without a stamp that of the line before.
    pub fn at(&mut self, stamp: Option<Stamp>) -> Ms {
        let Some(stamp) = stamp else {
            return self.last;
        };
        let first = *self.first.get_or_insert(stamp);
        let (told, begun) = match (stamp, first) {
            (Stamp::Own(ms), _) => (ms, 0),
            (Stamp::Date(ms), Stamp::Date(begun))
            | (Stamp::Day(ms), Stamp::Day(begun))
            | (Stamp::Count(ms), Stamp::Count(begun)) => (ms, begun),
            // Another kind of time: noise that looks like one.
            _ => return self.last,
        };
        let passed = told as i64 - begun as i64;
        let back = self.last as i64 - (passed + self.offset);
        if back > DAY / 2 && matches!(stamp, Stamp::Day(_)) {
            self.offset += DAY;
        } else if back > ANEW && !matches!(stamp, Stamp::Date(_)) {
            // The clock has begun anew, as after a restart.
            self.offset = self.last as i64 - passed;
        }
        self.last = self.last.max((passed + self.offset).max(0) as Ms);
        self.last
    }

    /// Returns the time of the log's beginning, ms since 1970; `None` if it is not known.
    pub fn begun_ms(&self) -> Option<u64> {
        match self.first {
            Some(Stamp::Date(ms)) => Some(ms),
            _ => None,
        }
    }
}

/// Returns the time in the text before a sentence; `None` if there is none.
pub fn parse(before: &str) -> Option<Stamp> {
    if let Some((place, ms)) = time_of_day(before) {
        let date = before.get(..place).and_then(date);
        return Some(date.map_or(Stamp::Day(ms), |days| Stamp::Date(days * DAY as Ms + ms)));
    }
    let text = before.trim_start_matches(['[', '(', ' ']);
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.')?;
    let (number, rest) = text.split_at(end);
    let unit_ms = rest.trim_start().starts_with("ms");
    // A digit of noise directly before the sentence is no time.
    let separated = rest.starts_with([' ', ']', ')', ',', ';', ':', '|', '>', '\\', 's', 'm']);
    let value: f64 = number.parse().ok().filter(|_| separated)?;
    Some(match number.contains('.') {
        true if !unit_ms && value >= 1e9 => Stamp::Date((1000.0 * value) as Ms),
        true if !unit_ms => Stamp::Count((1000.0 * value) as Ms),
        _ if value >= 1e12 => Stamp::Date(value as Ms),
        _ if value >= 1e9 && !unit_ms => Stamp::Date(1000 * value as Ms),
        _ => Stamp::Count(value as Ms),
    })
}

/// Returns place and value, ms, of the first `HH:MM:SS` with or without a fraction.
fn time_of_day(text: &str) -> Option<(usize, Ms)> {
    let bytes = text.as_bytes();
    let digits = |at: usize, count: usize| -> Option<Ms> {
        let part = text.get(at..at + count)?;
        part.bytes()
            .all(|b| b.is_ascii_digit())
            .then(|| part.parse().ok())?
    };
    let colon = |at: usize| bytes.get(at) == Some(&b':');
    (0..bytes.len()).find_map(|at| {
        let two = at >= 2 && digits(at - 2, 2).is_some();
        let (hours, from) = match two {
            true => (digits(at - 2, 2)?, at - 2),
            false => (digits(at.checked_sub(1)?, 1)?, at - 1),
        };
        if !colon(at) || !colon(at + 3) {
            return None;
        }
        let (minutes, seconds) = (digits(at + 1, 2)?, digits(at + 4, 2)?);
        let fraction = text.get(at + 6..)?.strip_prefix(['.', ',']).unwrap_or("");
        let count = fraction.bytes().take_while(u8::is_ascii_digit).count();
        let ms: Ms = format!("{:0<3}", &fraction[..count])[..3].parse().ok()?;
        let sane = hours < 24 && minutes < 60 && seconds < 61;
        sane.then_some((from, ((hours * 60 + minutes) * 60 + seconds) * 1000 + ms))
    })
}

/// Returns the days since 1970 of the date `YYYY-MM-DD` or `YYYY/MM/DD` in a text.
fn date(text: &str) -> Option<Ms> {
    let place = (0..text.len()).find(|&at| {
        let Some(part) = text.as_bytes().get(at..at + 10) else {
            return false;
        };
        let mark = |k: usize| matches!(part[k], b'-' | b'/');
        let digit = |k: usize| part[k].is_ascii_digit();
        (0..10).all(|k| if k == 4 || k == 7 { mark(k) } else { digit(k) })
    })?;
    let number = |from: usize, to: usize| text[place + from..place + to].parse::<u64>().ok();
    let (year, month, day) = (number(0, 4)?, number(5, 7)?, number(8, 10)?);
    if year < 1970 || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Years begin in March, so that the leap day is the last one.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days = 365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + day - 1;
    Some(days - 719_468)
}
