//! Exact conversion between the integers of commands and the notation of files.
//!
//! A command counts in the unit of the settings' table (`mount-height` in 0.01 mm); a file contains `"0.4 m"`. Both
//! conversions use integers, so that a file that was read from a scanner sets the same bits again.

use stairscan::scanner::MICROSTEPS_PER_TURN;

/// A unit that may stand in a file, such as `cm`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Name of the unit, as in the file.
    pub name: &'static str,
    /// Number of command units in one of this unit: numerator and denominator.
    pub ratio: (i128, i128),
    /// Magnitude from which a number is written in this unit, in command units.
    pub from: i128,
}

/// Notation in files of numbers that commands count in one unit.
#[derive(Debug, PartialEq, Eq)]
pub struct Unit {
    /// Name of the command unit in the settings' table, such as `0.01 mm`.
    pub name: &'static str,
    /// Units that a file may use, in the order in which they are tried for writing; empty for a
    /// number without a unit.
    pub written: &'static [Written],
    /// Number of command units that the number 1 means in a file if it has no unit there.
    pub one: i128,
    /// Whether a value between two command units is rounded; otherwise it is refused.
    pub rounds: bool,
}

/// Magnitude that marks a unit as one that is read but never written.
const NEVER: i128 = i128::MAX;
/// Degrees per turn.
const TURN_DEG: i128 = 360;
const MICROSTEPS: i128 = MICROSTEPS_PER_TURN as i128;

const fn written(name: &'static str, ratio: (i128, i128), from: i128) -> Written {
    Written { name, ratio, from }
}

const fn unit(name: &'static str, written: &'static [Written]) -> Unit {
    Unit {
        name,
        written,
        one: 1,
        rounds: false,
    }
}

/// Notation of numbers without a unit: counts, dates, checksums.
static NUMBER: Unit = unit("", &[]);
/// Notations of all units of the settings' table.
static UNITS: &[Unit] = &[
    unit(
        "0.01 mm",
        &[
            written("m", (100_000, 1), 1_000),
            written("cm", (1_000, 1), NEVER),
            written("mm", (100, 1), 0),
        ],
    ),
    unit("0.001 dB", &[written("dB", (1_000, 1), 0)]),
    unit(
        "1e-6",
        &[written("%", (10_000, 1), 0), written("ppm", (1, 1), NEVER)],
    ),
    unit(
        "0.001 deg",
        &[
            written("deg", (1_000, 1), 0),
            written("°", (1_000, 1), NEVER),
        ],
    ),
    unit(
        "1e-9",
        &[
            written("%", (10_000_000, 1), 0),
            written("ppm", (1_000, 1), NEVER),
        ],
    ),
    unit(
        "us",
        &[
            written("s", (1_000_000, 1), 1_000_000),
            written("ms", (1_000, 1), 1_000),
            written("µs", (1, 1), NEVER),
            written("us", (1, 1), 0),
        ],
    ),
    unit(
        "kHz",
        &[
            written("GHz", (1_000_000, 1), 0),
            written("MHz", (1_000, 1), NEVER),
            written("kHz", (1, 1), NEVER),
        ],
    ),
    unit(
        "mA",
        &[written("A", (1_000, 1), 1_000), written("mA", (1, 1), 0)],
    ),
    unit(
        "baud",
        &[
            written("Mbaud", (1_000_000, 1), 0),
            written("baud", (1, 1), NEVER),
        ],
    ),
    Unit {
        rounds: true,
        ..unit(
            "microsteps/s",
            &[
                written("deg/s", (MICROSTEPS, TURN_DEG), 0),
                written("turns/s", (MICROSTEPS, 1), NEVER),
                written("microsteps/s", (1, 1), NEVER),
            ],
        )
    },
    Unit {
        rounds: true,
        ..unit(
            "microsteps/s2",
            &[
                written("deg/s2", (MICROSTEPS, TURN_DEG), 0),
                written("turns/s2", (MICROSTEPS, 1), NEVER),
                written("microsteps/s2", (1, 1), NEVER),
            ],
        )
    },
    Unit {
        one: 1_000,
        ..unit("0.001", &[])
    },
    unit("angles", &[]),
    unit("cells", &[]),
    unit("particles", &[]),
    unit("modes", &[]),
    unit("rounds", &[]),
    unit("triggers", &[]),
    unit("rows", &[]),
    unit("sweeps/s", &[]),
    unit("samples", &[]),
    unit("chirps", &[]),
    unit("microsteps", &[]),
];

/// Numbers that files contain as a word: key, number and word.
const WORDS: &[(&str, i64, &str)] = &[
    ("mirror-echo", 0, "never"),
    ("mirror-level", 0, "never"),
    ("calibrated", 0, "never"),
    ("encoder-home", -1, "unknown"),
];
/// Key of the setting whose number is a date, YYYYMMDD.
const DATE: &str = "calibrated";

impl Unit {
    /// Returns the notation of the unit `name` in the settings' table, for the setting `key`;
    /// `None` for an unknown unit.
    pub fn of(key: &str, name: &str) -> Option<&'static Self> {
        if name.is_empty() || key == DATE {
            return Some(&NUMBER);
        }
        UNITS.iter().find(|unit| unit.name == name)
    }

    /// Returns the word that stands for the number `value` of `key`, or its date as `YYYY-MM-DD`;
    /// `None` for all other numbers.
    pub fn word_of(&self, key: &str, value: &str) -> Option<String> {
        let number: i64 = value.parse().ok()?;
        let word = WORDS.iter().find(|word| (word.0, word.1) == (key, number));
        let date = || {
            format!(
                "{:04}-{:02}-{:02}",
                number / 10_000,
                number / 100 % 100,
                number % 100
            )
        };
        word.map(|word| word.2.to_owned())
            .or_else(|| (key == DATE).then(date))
    }

    /// Converts `number`, in command units, to the notation of files, with its unit.
    pub fn shown(&self, number: i128) -> String {
        let of = |w: &&Written| number == 0 || number.abs() >= w.from;
        match self.written.iter().find(of) {
            None => decimal(number, self.one),
            Some(w) => format!("{} {}", decimal(number * w.ratio.1, w.ratio.0), w.name),
        }
    }

    /// Converts `text` of a file to the number of a command, in command units.
    ///
    /// # Errors
    /// A description of the expected value.
    pub fn parse(&self, key: &str, text: &str) -> Result<i128, String> {
        let text = text.trim();
        if let Some(word) = WORDS.iter().find(|word| (word.0, word.2) == (key, text)) {
            return Ok(word.1.into());
        }
        if key == DATE {
            return date(text).ok_or("expected a date, such as 2026-11-22, or never".to_owned());
        }
        let end = text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | '_')));
        let (digits, name) = text.split_at(end.unwrap_or(text.len()));
        let name = name.trim();
        let (digits, places) = digits_of(digits).ok_or_else(|| self.expected())?;
        let ratio = match self.written.iter().find(|w| w.name == name) {
            Some(w) => w.ratio,
            None if self.written.is_empty() && (name.is_empty() || name == self.name) => {
                (self.one, 1)
            }
            None => return Err(self.expected()),
        };
        let (above, below) = (digits * ratio.0, 10_i128.pow(places) * ratio.1);
        if above % below == 0 {
            Ok(above / below)
        } else if self.rounds {
            Ok((2 * above + below).div_euclid(2 * below))
        } else if self.name.starts_with(|c: char| c.is_ascii_digit()) {
            Err(format!("expected a multiple of {}", self.name))
        } else {
            Err(format!("expected a whole number of {}", self.name)
                .trim_end_matches(" of ")
                .to_owned())
        }
    }

    /// Returns a description of the notations that are accepted.
    fn expected(&self) -> String {
        let names: Vec<&str> = self.written.iter().map(|w| w.name).collect();
        match names.first() {
            None if self.one == 1 => "expected a whole number".to_owned(),
            None => "expected a number".to_owned(),
            Some(first) => format!(
                "expected a number and its unit ({}), such as \"1 {first}\"",
                names.join(", ")
            ),
        }
    }
}

/// Returns the quotient `above / below` as the text of a decimal number, exact if it ends within twelve places.
fn decimal(above: i128, below: i128) -> String {
    const PLACES: usize = 12;
    let sign = if above < 0 { "-" } else { "" };
    let above = above.abs();
    let (mut rest, mut places) = (above % below, String::new());
    while rest != 0 && places.len() < PLACES {
        rest *= 10;
        places.push(char::from(b'0' + (rest / below) as u8));
        rest %= below;
    }
    let dot = if places.is_empty() { "" } else { "." };
    format!("{sign}{}{dot}{places}", above / below)
}

/// Splits a decimal number into its digits as an integer, and the number of its decimal places;
/// `None` if it is no number.
fn digits_of(text: &str) -> Option<(i128, u32)> {
    const MAX_LETTERS: usize = 24;
    let text = text.replace('_', "");
    let (whole, places) = text.split_once('.').unwrap_or((&text, ""));
    let digits = format!("{whole}{places}");
    let unsigned = digits.trim_start_matches(['-', '+']);
    let good = !unsigned.is_empty()
        && digits.len() <= MAX_LETTERS
        && digits.len() - unsigned.len() <= 1
        && unsigned.bytes().all(|b| b.is_ascii_digit());
    let number = good.then(|| digits.parse().ok()).flatten()?;
    Some((number, u32::try_from(places.len()).ok()?))
}

/// Converts a date `YYYY-MM-DD` to the number YYYYMMDD; `None` if it is no date.
fn date(text: &str) -> Option<i128> {
    let parts: Vec<&str> = text.split('-').collect();
    let [year, month, day] = parts[..] else {
        return None;
    };
    let lengths = (year.len(), month.len(), day.len()) == (4, 2, 2);
    let [year, month, day] = [year, month, day].map(|part| part.parse::<u32>().ok());
    let (year, month, day) = (year?, month?, day?);
    let valid = lengths && year >= 2000 && (1..=12).contains(&month) && (1..=31).contains(&day);
    valid.then_some(i128::from(year * 10_000 + month * 100 + day))
}
