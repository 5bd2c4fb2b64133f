//! The table of all settings, read from docs/user/hardware.md. A test of the library compares it with the rows in `src/`.
//! In this way the image does not contain units and meanings.

use std::sync::LazyLock;

use stairscan::scanner::Settings;

use super::units::Unit;

/// The document that holds the table.
const DOCUMENT: &str = include_str!("../../../docs/user/hardware.md");
/// Header of the table in the document.
const HEADER: &str = "| key | unit | values | default | hash | meaning |";
/// Text in the column of values for settings that no command changes.
const READ_ONLY: &str = "read only";

/// One setting, a row of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// Name of the setting, the key in files and commands.
    pub key: &'static str,
    /// Unit of the setting's number, and its notation in files.
    pub unit: &'static Unit,
    /// Minimum and maximum in units of commands; `None` if the type is the only limit, or the value
    /// is a word.
    pub limits: Option<(i64, i64)>,
    /// Permitted words; empty for numbers.
    pub words: Vec<&'static str>,
    /// Default value, in the notation of commands.
    pub default: &'static str,
    /// Whether no command changes the setting, because the radar module reports it.
    pub read_only: bool,
    /// Meaning of the setting, in words.
    pub meaning: &'static str,
}

impl Row {
    /// Returns the permitted values with units; empty if only the type limits them.
    pub fn range(&self) -> String {
        if self.read_only {
            return "reported by the radar module, not set".to_owned();
        }
        if !self.words.is_empty() {
            return self.words.join(", ");
        }
        let shown = |number: i64| self.unit.shown(number.into());
        let limits = self.limits.map(|(least, most)| (shown(least), shown(most)));
        limits.map_or_else(String::new, |(least, most)| format!("{least} to {most}"))
    }

    /// Converts `text` from the notation of files, a number with its unit or a word, to that of commands: `0.4 m` to
    /// `40000`. A word is unchanged; the scanner checks it.
    ///
    /// # Errors
    /// Names the setting, and what was found and expected.
    pub fn without_unit(&self, text: &str) -> Result<String, String> {
        if !self.words.is_empty() {
            return Ok(text.to_owned());
        }
        let number = self.unit.parse(self.key, text);
        let number = number.map_err(|expected| format!("{}: found {text:?}, {expected}", self.key));
        number.map(|number| number.to_string())
    }

    /// Converts `value` from the notation of commands to that of files: `0.4 m` for `40000`. A value that is not a
    /// number is unchanged.
    pub fn with_unit(&self, value: &str) -> String {
        match (self.unit.word_of(self.key, value), value.parse::<i64>()) {
            (Some(word), _) => word,
            (None, Ok(number)) if self.words.is_empty() => self.unit.shown(number.into()),
            _ => value.to_owned(),
        }
    }
}

/// Returns all settings, in the order of the table in the document.
pub fn rows() -> &'static [Row] {
    static ROWS: LazyLock<Vec<Row>> = LazyLock::new(read);
    &ROWS
}

/// Returns the row of the setting `key`; `None` if there is no such setting.
pub fn row(key: &str) -> Option<&'static Row> {
    rows().iter().find(|row| row.key == key)
}

fn read() -> Vec<Row> {
    let lines = DOCUMENT.lines().skip_while(|line| *line != HEADER).skip(2);
    let table = lines.take_while(|line| line.starts_with('|'));
    table.filter_map(parse).collect()
}

fn parse(line: &'static str) -> Option<Row> {
    let mut cells = line.trim_matches('|').split('|').map(str::trim);
    let key = Settings::key(cells.next()?.trim_matches('`'))?;
    let (unit, values, default) = (cells.next()?, cells.next()?, cells.next()?);
    let meaning = cells.nth(1)?;
    let limits = values.split_once(" to ");
    let limits = limits.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    let read_only = values == READ_ONLY;
    let words = match limits.is_some() || read_only || values.is_empty() {
        true => Vec::new(),
        false => values.split(", ").collect(),
    };
    Some(Row {
        key,
        unit: Unit::of(key, unit)?,
        limits,
        words,
        default,
        read_only,
        meaning,
    })
}
