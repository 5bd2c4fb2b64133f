//! Updates the parts of `docs/user/controller.md` that a C example prints.

use std::path::PathBuf;

use anyhow::{Context, Result};

const TEXT: &str = "<!-- text: controller/speed_limit -->\n";
const TABLE: &str = "<!-- controller/speed_limit table -->\n";
const END: &str = "<!-- end -->\n";

/// Returns the path of the page.
pub fn path() -> PathBuf {
    super::directory().join("../docs/user/controller.md")
}

/// Replaces the parts of `page` between its marks by the output of `controller/speed_limit.c`. `printed` runs it with
/// the given arguments.
///
/// # Errors
/// The page lacks a mark (the message names it), or an error of `printed`.
pub fn renewed(page: &str, printed: impl Fn(&[&str]) -> Result<String>) -> Result<String> {
    let page = filled(page, TABLE, &printed(&["table"])?)?;
    filled(&page, TEXT, &format!("```text\n{}```\n", printed(&[])?))
}

fn filled(page: &str, mark: &str, with: &str) -> Result<String> {
    let lacks = || format!("no {} in the page", mark.trim());
    let (before, rest) = page.split_once(mark).with_context(lacks)?;
    let (_, after) = rest.split_once(END).with_context(lacks)?;
    Ok([before, mark, with, END, after].concat())
}
