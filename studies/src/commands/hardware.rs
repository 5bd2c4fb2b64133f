//! `hardware WHAT`: prints the parts of docs/user/build.md.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::ValueEnum;

use super::emit;
use crate::hardware::table::table;
use crate::hardware::{optics, tables, wiring};
use host_sim::output::Overwrite;

/// Arguments of `hardware`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Table or drawing to make
    #[arg(value_enum)]
    what: What,
    /// Write it to this file instead of stdout
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// A table or drawing of the hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    /// Bill of materials with costs, as Markdown
    Parts,
    /// Power budget, as Markdown
    Power,
    /// Wiring diagram, as SVG
    Wiring,
    /// Lens and mirror with their dimensions, as SVG
    Optics,
}

/// Prints the requested table or drawing, or writes it to a file.
pub fn run(args: &Args) -> Result<ExitCode> {
    let text = match args.what {
        What::Parts => tables::parts(table()),
        What::Power => tables::power(table()),
        What::Wiring => wiring::draw(table()).svg(),
        What::Optics => optics::draw().svg(),
    };
    match &args.output {
        None => emit(&text),
        Some(path) => {
            let outputs = args.overwrite.reading::<&PathBuf>([]);
            let suffix = match args.what {
                What::Parts | What::Power => "md",
                What::Wiring | What::Optics => "svg",
            };
            outputs.check_kind(path, &[suffix])?;
            outputs.write(path, text.as_bytes())?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
