//! Updates the table of speed limits in `docs/user/controller.md`, which a C example prints.

use std::path::PathBuf;

use anyhow::{Context, Result};

const TABLE: &str = "<!-- controller/speed_limit table -->\n";
const END: &str = "<!-- end -->\n";

/// Returns the path of the page.
pub fn path() -> PathBuf {
    super::directory().join("../docs/user/controller.md")
}

/// Replaces the table of speed limits in `page` by the output of `controller/speed_limit.c`. `printed` runs it with the
/// given arguments.
///
/// # Errors
/// The page lacks a mark (the message names it), or an error of `printed`.
pub fn renewed(page: &str, printed: impl Fn(&[&str]) -> Result<String>) -> Result<String> {
    filled(page, TABLE, &printed(&["table"])?)
}

fn filled(page: &str, mark: &str, with: &str) -> Result<String> {
    let lacks = || format!("no {} in the page", mark.trim());
    let (before, rest) = page.split_once(mark).with_context(lacks)?;
    let (_, after) = rest.split_once(END).with_context(lacks)?;
    Ok([before, mark, with, END, after].concat())
}
