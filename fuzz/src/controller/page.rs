//! The parts of `docs/controller.md` that a C example prints.

use std::path::PathBuf;

use anyhow::{Context, Result};

const TEXT: &str = "<!-- text: controller/speed_limit -->\n";
const TABLE: &str = "<!-- controller/speed_limit table -->\n";
const END: &str = "<!-- end -->\n";

/// The page.
pub fn path() -> PathBuf {
    super::directory().join("../docs/controller.md")
}

/// Returns `page` with the parts between its marks replaced by what `controller/speed_limit.c` prints, called with the
/// arguments that `printed` takes.
///
/// # Errors
/// Names the mark that the page lacks, or what `printed` says.
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
