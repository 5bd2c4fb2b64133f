//! JSON objects asked for their keys, with messages that say where and what was expected.

use anyhow::{Result, anyhow};
use serde_json::{Map, Value};

/// Longest piece of a wrong value that a message shows, characters.
const SHOWN: usize = 40;

/// A JSON object's members, with the path to it for messages.
pub(super) struct Keys<'a> {
    /// The members.
    pub(super) object: &'a Map<String, Value>,
    place: String,
}

impl<'a> Keys<'a> {
    pub(super) fn of(value: Option<&'a Value>, place: &str) -> Result<Self> {
        let object = value
            .and_then(Value::as_object)
            .ok_or_else(|| anyhow!("{place}: missing or no object, expected a JSON object"))?;
        Ok(Self {
            object,
            place: place.to_owned(),
        })
    }

    pub(super) fn get(&self, key: &str) -> Option<&'a Value> {
        self.object.get(key)
    }

    /// The refusal of `key`: what was found there, or that it is missing, and what was expected.
    pub(super) fn wrong(&self, key: &str, expected: &str) -> anyhow::Error {
        match self.object.get(key) {
            None => anyhow!("{} {key}: missing, expected {expected}", self.place),
            Some(found) => {
                let mut found = found.to_string();
                if found.chars().count() > SHOWN {
                    found = found.chars().take(SHOWN).chain("…".chars()).collect();
                }
                anyhow!("{} {key}: found {found}, expected {expected}", self.place)
            }
        }
    }

    pub(super) fn number(
        &self,
        key: &str,
        expected: &str,
        ok: impl Fn(f64) -> bool,
    ) -> Result<f64> {
        self.get(key)
            .and_then(Value::as_f64)
            .filter(|v| v.is_finite() && ok(*v))
            .ok_or_else(|| self.wrong(key, expected))
    }

    pub(super) fn optional(
        &self,
        key: &str,
        expected: &str,
        ok: impl Fn(f64) -> bool,
    ) -> Result<Option<f64>> {
        self.get(key)
            .map(|_| self.number(key, expected, ok))
            .transpose()
    }

    pub(super) fn text(&self, key: &str, expected: &str) -> Result<&'a str> {
        self.get(key)
            .and_then(Value::as_str)
            .ok_or_else(|| self.wrong(key, expected))
    }

    /// The array `key`, of `length` items; `None` without the key.
    pub(super) fn list(
        &self,
        key: &str,
        expected: &str,
        length: usize,
    ) -> Result<Option<&'a [Value]>> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        match value.as_array() {
            Some(list) if list.len() == length => Ok(Some(list)),
            Some(list) => Err(anyhow!(
                "{} {key}: found {} items, expected {length} ({expected})",
                self.place,
                list.len()
            )),
            None => Err(self.wrong(key, &format!("an array of {length} ({expected})"))),
        }
    }
}

/// Where JSON stops making sense, with the key before that place: a NaN has no other name.
pub(super) fn explain_syntax(text: &str, error: &serde_json::Error) -> String {
    let before: usize = text
        .lines()
        .take(error.line().saturating_sub(1))
        .map(|l| l.len() + 1)
        .sum();
    let head = text
        .get(..(before + error.column()).min(text.len()))
        .unwrap_or(text);
    let key = head
        .rfind("\":")
        .and_then(|end| head[..end].rfind('"').map(|start| &head[start + 1..end]));
    match key {
        Some(key) => format!("near key {key}: {error}"),
        None => format!("no JSON: {error}"),
    }
}
