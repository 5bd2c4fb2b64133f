//! Access to the keys of JSON objects, with messages that name the place and the expected value.

use anyhow::{Result, anyhow};
use serde_json::{Map, Value};
use strsim::levenshtein;

/// Maximum number of characters of a wrong value that a message quotes.
const SHOWN: usize = 40;
/// Maximum number of edits (Levenshtein distance) at which an unknown key counts as the misspelling of a known one. A
/// swap of two letters counts as two edits.
const MISSPELT: usize = 2;

/// The members of a JSON object, and the object's place in the document for messages.
pub(super) struct Keys<'a> {
    /// The object's members.
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

    /// Returns an error if a key is not one of `known` but nearly equals one, because it would be
    /// ignored otherwise.
    pub(super) fn check_spelling(&self, known: &[&str]) -> Result<()> {
        let unknown = |key: &&String| !known.contains(&key.as_str());
        for key in self.object.keys().filter(unknown) {
            let nearest = known.iter().min_by_key(|known| levenshtein(key, known));
            if let Some(meant) = nearest.filter(|known| levenshtein(key, known) <= MISSPELT) {
                return Err(anyhow!(
                    "{} {key}: no such key, expected {meant}",
                    self.place
                ));
            }
        }
        Ok(())
    }

    /// Returns the error for `key`: the value found, or that it is missing, and the expected value.
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

    /// Returns the array under `key`, which must have `length` items; `None` without the key.
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

/// Returns the message for a JSON syntax error: its line and column, and the key before it, because
/// a NaN has no other name.
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn check(object: &Value) -> String {
        let keys = Keys::of(Some(object), "captures[3]").unwrap();
        let checked = keys.check_spelling(&["stairscan:time_s", "stairscan:travel_m"]);
        checked.map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn a_key_that_is_nearly_a_known_one_is_refused_and_others_are_not() {
        assert_eq!(
            check(&json!({"stairscan:tiem_s": 0.1})),
            "captures[3] stairscan:tiem_s: no such key, expected stairscan:time_s"
        );
        assert_eq!(check(&json!({"stairscan:time_s": 0.1, "my:note": 1})), "");
        assert_eq!(check(&json!({"stairscan:temperature_c": 21})), "");
    }
}
