//! Scans as one page that any browser opens without a network: verdict, side view, range profiles.
//!
//! | file | holds |
//! |---|---|
//! | `page.html` | the page's skeleton |
//! | `page.css` | its looks, on a screen of any width |
//! | `page.js` | what draws: side view, profile, tables, index |
//!
//! The page holds its data as one JSON object. All numbers in it are the scanner's own: sentences of the
//! report, and what the estimator told an onlooker on its way to them.

mod index;
mod view;

use anyhow::{Context, Result};
use serde_json::{Value, json};

pub use index::{Entry, Rank};
pub use view::{entry, failed};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The page of these recordings, the failing ones first.
///
/// # Errors
/// When the data cannot be written as JSON.
pub fn page(mut entries: Vec<Entry>) -> Result<String> {
    entries.sort_by_key(|entry| entry.rank);
    let title = match entries.as_slice() {
        [only] => format!("{} – stairscan", only.data["name"].as_str().unwrap_or("")),
        many => format!("{} recordings – stairscan", many.len()),
    };
    let recordings: Vec<Value> = entries.into_iter().map(|entry| entry.data).collect();
    let data = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "revision": stairscan::REVISION,
        "recordings": recordings,
    });
    let data = serde_json::to_string(&data).context("the page's data")?;
    // A script ends at the first "</", wherever it stands.
    let data = data.replace("</", "<\\/");
    Ok(PAGE
        .replace("{{title}}", &escaped(&title))
        .replace("{{style}}", STYLE)
        .replace("{{script}}", SCRIPT)
        .replace("{{data}}", &data))
}

/// Text as it may stand between tags.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests;
