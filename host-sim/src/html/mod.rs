//! Scans as one page that any browser opens without a network: verdict, side view, range profiles.
//!
//! | file | holds |
//! |---|---|
//! | `page.html` | the page's skeleton |
//! | `report.html`, `pane.html` | its body: index, slider, and one view of a scan |
//! | `compare.html`, `compare.js` | the body with two views side by side, and what differs between them |
//! | `article.html` | a page of text, tables and drawings, without a script |
//! | `page.css` | its looks, on a screen of any width |
//! | `draw.js`, `tell.js`, `page.js` | what draws a scan; what tells it in words and tables; what is chosen and pointed at |
//! | `twin.rs` | the same page with the scanner in it, of `../../web/page/` |
//!
//! The page holds its data as one JSON object. All numbers in it are the scanner's own: sentences of the
//! report, and what the estimator told an onlooker on its way to them.

#[cfg(feature = "program")]
pub mod compare;
#[cfg(feature = "program")]
mod differences;
mod index;
#[cfg(feature = "program")]
pub mod twin;
mod view;

use anyhow::{Context, Result};
use serde_json::{Value, json};

pub use index::{Entry, Rank};
pub use view::{answered, entry, failed};

const PAGE: &str = include_str!("page.html");
#[cfg(feature = "program")]
const ARTICLE: &str = include_str!("article.html");
const REPORT: &str = include_str!("report.html");
const PANE: &str = include_str!("pane.html");
const SLIDER: &str = include_str!("slider.html");
const LAYERS: &str = "<fieldset id=\"layers\"><legend>Show</legend></fieldset>\n";
const STYLE: &str = include_str!("page.css");
const SCRIPT: [&str; 3] = [
    include_str!("draw.js"),
    include_str!("tell.js"),
    include_str!("page.js"),
];

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
    let parts = Parts {
        title: &title,
        body: &report(""),
        data: &data,
        ..Parts::default()
    };
    Ok(parts.filled())
}

/// The body of a page that shows one scan, with `controls` above the recording's name.
fn report(controls: &str) -> String {
    REPORT
        .replace("{{controls}}", controls)
        .replace("{{pane}}", &pane("", SLIDER, LAYERS))
}

/// One view of a scan; the names of its elements end with `suffix`.
fn pane(suffix: &str, slider: &str, layers: &str) -> String {
    PANE.replace("{{suffix}}", suffix)
        .replace("{{slider}}", slider)
        .replace("{{layers}}", layers)
}

/// Contents of the skeleton's places, beside the page's own style and script; each may be empty.
#[derive(Clone, Copy, Debug, Default)]
struct Parts<'a> {
    title: &'a str,
    /// Further elements of the head.
    head: &'a str,
    /// Further rules of style, behind the page's own.
    style: &'a str,
    /// Elements of the body, up to the footer.
    body: &'a str,
    /// JSON of the recordings.
    data: &'a str,
    /// Further elements in front of the script.
    stock: &'a str,
    /// Further script, behind the page's own.
    script: &'a str,
}

impl Parts<'_> {
    /// The page. Text of recordings is filled in last, so that it is taken for no place of the skeleton.
    fn filled(&self) -> String {
        // A script ends at the first "</", wherever it stands.
        let data = self.data.replace("</", "<\\/");
        PAGE.replace("{{head}}", self.head)
            .replace("{{style}}", &[STYLE, self.style].concat())
            .replace("{{body}}", self.body)
            .replace("{{script}}", &[&SCRIPT.concat(), self.script].concat())
            .replace("{{stock}}", self.stock)
            .replace("{{title}}", &escaped(self.title))
            .replace("{{data}}", &data)
    }
}

/// A page of text, tables and drawings, with the looks of a report and without a script; `body` are elements.
#[cfg(feature = "program")]
pub fn article(title: &str, body: &str) -> String {
    ARTICLE
        .replace("{{style}}", STYLE)
        .replace("{{title}}", &escaped(title))
        .replace("{{body}}", body)
}

/// Text as it may stand between tags.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests;
