//! Reads and writes a file of settings: TOML, one key for each setting, a string with a unit if the
//! setting has one.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anyhow::{Result, anyhow, bail};
use stairscan::scanner::Settings;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::order::{self, Change};
use super::table::{self, Row};

/// One setting that a file contains.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The setting, a row of the settings' table.
    pub row: &'static Row,
    /// Value of the setting, in the notation of commands.
    pub value: String,
    /// Line of the file on which the setting stands, from 1.
    pub line: usize,
}

/// The settings of a file, in the order of the settings' table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Profile {
    /// The settings that the file contains.
    pub entries: Vec<Entry>,
}

/// Returns the text of a file with all settings in `values`, by name in the notation of commands;
/// `about` becomes its first comment.
pub fn text(values: &BTreeMap<String, String>, about: &str) -> String {
    let mut text = String::new();
    for line in about.lines() {
        let _ = writeln!(text, "# {line}");
    }
    for row in table::rows() {
        let Some(value) = values.get(row.key) else {
            continue;
        };
        let (range, default) = (row.range(), row.with_unit(row.default));
        let range = if range.is_empty() {
            range
        } else {
            format!("{range}; ")
        };
        let _ = writeln!(text, "\n# {}.\n# {range}default {default}", row.meaning);
        let comment = if row.read_only { "# " } else { "" };
        let _ = writeln!(text, "{comment}{} = {}", row.key, value_text(row, value));
    }
    text
}

/// Converts a value from the notation of commands to that of the file, in quotation marks if
/// needed.
fn value_text(row: &Row, value: &str) -> String {
    let spoken = row.with_unit(value);
    let bare = row.unit.written.is_empty() && spoken.parse::<f64>().is_ok();
    if bare {
        spoken
    } else {
        format!("\"{spoken}\"")
    }
}

impl Profile {
    /// Parses the text of the file `name`. Every value is checked separately.
    ///
    /// # Errors
    /// All wrong keys, with line, value and expected value.
    pub fn parse(name: &str, text: &str) -> Result<Self> {
        let line_of = |at: usize| text.get(..at).unwrap_or_default().matches('\n').count() + 1;
        let parsed = DeTable::parse(text).map_err(|error| {
            let line = line_of(error.span().map_or(0, |span| span.start));
            let message = error
                .message()
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" ");
            anyhow!("{name}:{line}: {message}")
        })?;
        let (mut profile, mut wrong) = (Self::default(), Vec::new());
        for (key, value) in parsed.get_ref() {
            let line = line_of(key.span().start);
            match entry(key.get_ref(), value) {
                Ok((row, value)) => profile.entries.push(Entry { row, value, line }),
                Err(error) => wrong.push((line, error)),
            }
        }
        wrong.sort();
        if !wrong.is_empty() {
            let lines: Vec<String> = wrong
                .iter()
                .map(|(line, error)| format!("{name}:{line}: {error}"))
                .collect();
            bail!("{}", lines.join("\n"));
        }
        let place = |entry: &Entry| Settings::KEYS.iter().position(|key| *key == entry.row.key);
        profile.entries.sort_by_key(place);
        Ok(profile)
    }

    /// Returns the changes of the file in an order that a scanner with the settings `values`
    /// accepts, and the resulting settings.
    ///
    /// # Errors
    /// All keys of the file `name` that such a scanner would refuse.
    pub fn changes(
        &self,
        name: &str,
        values: &BTreeMap<String, String>,
    ) -> Result<(Vec<Change>, Settings)> {
        let settings = order::settings_of(values).map_err(|error| {
            anyhow!("the scanner's own {error}: its firmware is not the one that this program belongs to")
        })?;
        let changes = self
            .entries
            .iter()
            .map(|entry| (entry.row.key, entry.value.clone()));
        let changes: Vec<Change> = changes.collect();
        order::in_order(&settings, &changes).map_err(|refused| {
            let lines = refused.iter().filter_map(|(key, error)| {
                let entry = self.entries.iter().find(|entry| entry.row.key == *key)?;
                let value = entry.row.with_unit(&entry.value);
                Some(format!(
                    "{name}:{}: {key} = {value}: with the other settings, {error}",
                    entry.line
                ))
            });
            anyhow!("{}", lines.collect::<Vec<_>>().join("\n"))
        })
    }

    /// Returns the differences between the scanner's settings `values` and the file, one line each.
    pub fn differences(&self, values: &BTreeMap<String, String>) -> Vec<String> {
        let mut lines = Vec::new();
        for Entry { row, value, line } in &self.entries {
            let file = row.with_unit(value);
            match values.get(row.key) {
                Some(there) if there == value => {}
                Some(there) => lines.push(format!(
                    "{}: scanner {}, file {file} (line {line})",
                    row.key,
                    row.with_unit(there)
                )),
                None => lines.push(format!(
                    "{}: unknown to the scanner, file {file} (line {line})",
                    row.key
                )),
            }
        }
        lines
    }
}

/// Returns the setting, and the value in the notation of commands, for one key of a file; the error
/// describes the expected value.
fn entry(key: &str, value: &Spanned<DeValue<'_>>) -> Result<(&'static Row, String), String> {
    let row = table::row(key).ok_or_else(|| match nearest(key) {
        Some(near) => format!("{key}: no such setting; did you mean {near}?"),
        None => format!("{key}: no such setting"),
    })?;
    let text = match value.get_ref() {
        DeValue::String(text) => text.to_string(),
        DeValue::Integer(number) if number.radix() == 10 => number.as_str().to_owned(),
        DeValue::Float(number) => number.as_str().to_owned(),
        DeValue::Datetime(date) => date.to_string(),
        _ => return Err(format!("{key}: expected a number or a string")),
    };
    let wrong = |expected: String| format!("{key} = {text}: {expected}");
    if row.read_only {
        return Err(wrong(
            "is reported by the radar module and cannot be set".to_owned(),
        ));
    }
    let in_range = || match row.range() {
        range if range.is_empty() => "expected a whole number within its type".to_owned(),
        range => format!("expected {range}"),
    };
    if !row.words.is_empty() {
        let known = row.words.contains(&text.as_str());
        return known
            .then(|| (row, text.clone()))
            .ok_or_else(|| wrong(in_range()));
    }
    let number = row.unit.parse(key, &text).map_err(|expected| {
        let range = row.range();
        let range = if range.is_empty() {
            range
        } else {
            format!("; {range}")
        };
        wrong(expected + &range)
    })?;
    let within =
        |(least, most): (i64, i64)| (i128::from(least)..=i128::from(most)).contains(&number);
    let value = number.to_string();
    // Without limits in the table the type limits the value.
    let typed = || Settings::default().set(row.key, &value).is_ok();
    if row.limits.map_or_else(typed, within) {
        Ok((row, value))
    } else {
        Err(wrong(in_range()))
    }
}

/// Returns the name of a setting that differs from `key` by one letter, or by an underscore in
/// place of a hyphen; `None` without one.
fn nearest(key: &str) -> Option<&'static str> {
    let key = key.to_lowercase().replace('_', "-");
    let mut keys = Settings::KEYS.iter().copied();
    keys.find(|known| strsim::levenshtein(known, &key) <= 1)
}
