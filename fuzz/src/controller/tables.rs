//! The generated part of `controller/stairscan.h`: reasons with their meanings, keys of settings.

use std::path::PathBuf;

use anyhow::{Context, Result};
use stairscan::scanner::Settings;
use stairscan::scanner::command::Measure;
use stairscan::verdict::Reason;

const BEGIN: &str =
    "/* begin generated: `cargo run -p stairscan-fuzz --example controller -- --write` */\n";
const END: &str = "/* end generated */\n";

/// The header.
pub fn path() -> PathBuf {
    super::directory().join("stairscan.h")
}

/// `header` with its tables made anew.
///
/// # Errors
/// Says which mark the header lacks.
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

/// A C string.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Keys of what is measured. A new one does not compile until it stands here.
pub fn measures() -> Vec<&'static str> {
    let all = [Measure::StackUsed, Measure::StackSize];
    all.map(|measure| match measure {
        Measure::StackUsed | Measure::StackSize => measure.key(),
    })
    .to_vec()
}
