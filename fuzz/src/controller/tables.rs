//! Generates the tables of `controller/stairscan.h`: reasons with their meanings, keys of settings.

use std::path::PathBuf;

use anyhow::{Context, Result};
use stairscan::scanner::Settings;
use stairscan::scanner::command::Measure;
use stairscan::verdict::Reason;

const BEGIN: &str =
    "/* begin generated: `cargo run -p stairscan-fuzz --example controller -- --write` */\n";
const END: &str = "/* end generated */\n";

/// Returns the path of the header.
pub fn path() -> PathBuf {
    super::directory().join("stairscan.h")
}

/// Returns `header` with new tables.
///
/// # Errors
/// The header lacks a mark; the message names it.
pub fn renewed(header: &str) -> Result<String> {
    let (before, rest) = header
        .split_once(BEGIN)
        .context("no `begin generated` in the header")?;
    let (_, after) = rest
        .split_once(END)
        .context("no `end generated` in the header")?;
    Ok([before, BEGIN, &block(), END, after].concat())
}

fn block() -> String {
    let reasons = Reason::ALL.iter().map(|reason| {
        let word = reason.as_str();
        let name = word.to_uppercase().replace('-', "_");
        format!("X({name}, {}, {})", quoted(word), quoted(reason.meaning()))
    });
    let keys = Settings::KEYS
        .iter()
        .map(|key| format!("X({})", quoted(key)));
    let measures = measures()
        .into_iter()
        .map(|key| format!("X({})", quoted(key)));
    [
        table("REASONS", reasons),
        "\n/* Keys of settings: for `get` and `set`. */\n".to_owned(),
        table("KEYS", keys),
        "\n/* Keys of what is measured: for `get`. */\n".to_owned(),
        table("MEASURES", measures),
    ]
    .concat()
}

fn table(name: &str, rows: impl Iterator<Item = String>) -> String {
    let rows: Vec<String> = rows.map(|row| format!("    {row}")).collect();
    format!("#define STAIRSCAN_{name}(X) \\\n{}\n", rows.join(" \\\n"))
}

/// Returns a C string literal.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Returns the keys of measured values.
pub fn measures() -> Vec<&'static str> {
    Measure::ALL.map(Measure::key).to_vec()
}
