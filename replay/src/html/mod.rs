//! Writes scans as one page that any browser opens without a network: verdict, side view, range profiles.
//!
//! | file | contents |
//! |---|---|
//! | `page.html` | the page's skeleton |
//! | `report.html`, `pane.html` | its body: index, slider, and one view of a scan |
//! | `article.html` | a page of text, tables and drawings, without a script |
//! | `log.html`, `log.css`, `log.js` | the page of logs: answers over time |
//! | `page.css` | its style, for screens of any width |
//! | `draw.js`, `tell.js`, `page.js` | drawing of a scan; texts and tables of a scan; selection and pointer |
//!
//! The page contains its data as one JSON object. All numbers in it are the scanner's own: the sentences of the
//! report, and the events that the estimator passes to an observer.

mod index;
mod log;
mod view;

use anyhow::{Context, Result};
use serde_json::{Value, json};

use crate::counted::counted;
use crate::live::log::Log;
pub use index::{Entry, Rank};
pub use view::{answered, entry, failed, scanned};

const PAGE: &str = include_str!("page.html");
const ARTICLE: &str = include_str!("article.html");
const REPORT: &str = include_str!("report.html");
const PANE: &str = include_str!("pane.html");
/// The slider over the scans of a recording.
pub const SLIDER: &str = include_str!("slider.html");
/// The choice of what a view shows.
pub const LAYERS: &str = "<fieldset id=\"layers\"><legend>Show</legend></fieldset>\n";
const LOG_PAGE: &str = include_str!("log.html");
const LOG_STYLE: &str = include_str!("log.css");
const LOG_SCRIPT: &str = include_str!("log.js");
const STYLE: &str = include_str!("page.css");
const SCRIPT: [&str; 3] = [
    include_str!("draw.js"),
    include_str!("tell.js"),
    include_str!("page.js"),
];

/// Returns the HTML page of these recordings, those with the worst results first.
///
/// # Errors
/// The data cannot be written as JSON.
pub fn page(mut entries: Vec<Entry>) -> Result<String> {
    entries.sort_by_key(|entry| entry.rank);
    let names = entries.iter().map(|entry| entry.data["name"].as_str());
    let names: Vec<&str> = names.map(Option::unwrap_or_default).collect();
    let title = title(&names, "recording");
    let recordings = entries.into_iter().map(|entry| entry.data);
    let parts = Parts {
        title: &title,
        body: &report(""),
        data: &data("recordings", recordings)?,
        ..Parts::default()
    };
    Ok(parts.filled())
}

/// Returns the HTML page of these logs.
///
/// # Errors
/// The data cannot be written as JSON.
pub fn logged(logs: &[Log]) -> Result<String> {
    let names: Vec<&str> = logs.iter().map(|log| log.name.as_str()).collect();
    let data = data("logs", logs.iter().map(log::of))?;
    let body = LOG_PAGE.replace("{{script}}", LOG_SCRIPT);
    let body = body.replace("{{data}}", &in_script(&data));
    Ok(plain(&title(&names, "log"), LOG_STYLE, &body))
}

/// Returns the title of a page of things of one kind.
fn title(names: &[&str], noun: &str) -> String {
    match names {
        [only] => format!("{only} – stairscan"),
        many => format!("{} – stairscan", counted(many.len(), noun)),
    }
}

/// Returns the JSON object of a page: `values` under the name `key`, with the program's version.
fn data(key: &str, values: impl Iterator<Item = Value>) -> Result<String> {
    let data = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "revision": stairscan::REVISION,
        key: values.collect::<Vec<_>>(),
    });
    serde_json::to_string(&data).context("the page's data")
}

/// Returns JSON as the text of a `script` element, which ends at the first "</", also inside a string.
fn in_script(data: &str) -> String {
    data.replace("</", "<\\/")
}

/// Returns the HTML body of a page with one scan, with `controls` above the recording's name.
pub fn report(controls: &str) -> String {
    REPORT
        .replace("{{controls}}", controls)
        .replace("{{pane}}", &pane("", SLIDER, LAYERS))
}

/// Returns the HTML of one view of a scan; the ids of its elements end with `suffix`, which makes
/// them unique.
pub fn pane(suffix: &str, slider: &str, layers: &str) -> String {
    PANE.replace("{{suffix}}", suffix)
        .replace("{{slider}}", slider)
        .replace("{{layers}}", layers)
}

/// Texts for the placeholders of `page.html`, in addition to the page's own style and script; each
/// may be empty.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parts<'a> {
    /// Title of the page, not yet escaped.
    pub title: &'a str,
    /// HTML elements added to the page's head.
    pub head: &'a str,
    /// CSS rules added after the page's own.
    pub style: &'a str,
    /// HTML elements of the page's body, up to the footer.
    pub body: &'a str,
    /// JSON with the data of the recordings that the page shows.
    pub data: &'a str,
    /// HTML `script` elements that the page's script reads, inserted before it: the scanner as WebAssembly, the worker
    /// that runs it, and recordings. Empty except on the page with the scanner itself.
    pub stock: &'a str,
    /// JavaScript added after the page's own.
    pub script: &'a str,
}

impl Parts<'_> {
    /// Returns the complete HTML page. Text of recordings is filled in last, so that it is not
    /// taken for a placeholder.
    pub fn filled(&self) -> String {
        PAGE.replace("{{head}}", self.head)
            .replace("{{style}}", &[STYLE, self.style].concat())
            .replace("{{body}}", self.body)
            .replace("{{script}}", &[&SCRIPT.concat(), self.script].concat())
            .replace("{{stock}}", self.stock)
            .replace("{{title}}", &escaped(self.title))
            .replace("{{data}}", &in_script(self.data))
    }
}

/// Returns an HTML page of text, tables and drawings, in the style of a report and without a
/// script. `body` contains the elements.
pub fn article(title: &str, body: &str) -> String {
    plain(title, "", body)
}

/// Returns an HTML page with `style` after the style of a report, and `body`.
fn plain(title: &str, style: &str, body: &str) -> String {
    ARTICLE
        .replace("{{style}}", &[STYLE, style].concat())
        .replace("{{title}}", &escaped(title))
        .replace("{{body}}", body)
}

/// Returns a number rounded to tenths, without "-0".
pub fn tenths(v: f64) -> String {
    let rounded = (v * 10.0).round() / 10.0;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

/// Escapes text for use between HTML tags.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
