//! `crash ELF`: file and line of a crash that a scanner has reported.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use stairscan_boot::receive::FIRST_BAUD;

use super::emit;
use crate::crash::image::Image;
use crate::crash::report::{self, Report};
use crate::crash::{check, text};
use crate::live::talk::Talk;
use crate::recording::regular;

/// Arguments of `crash`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "The last crash counts: of a BOOT with the fields of a crash, or of a CRASH, the answer to the command `crash?`. A log is what \
`live --record` or any serial logger writes; a port is asked."
)]
pub struct Args {
    /// The image that crashed, as it was built
    elf: PathBuf,
    /// A log of the report port, `-` for stdin, or the port itself, such as /dev/ttyUSB0
    #[arg(required_unless_present = "sentence")]
    source: Option<String>,
    /// The sentence itself, in quotes
    #[arg(long, conflicts_with = "source")]
    sentence: Option<String>,
    /// Baud rate of the port
    #[arg(long, default_value_t = FIRST_BAUD)]
    baud: u32,
    /// Take the image although it was built from another revision
    #[arg(long)]
    force: bool,
}

/// Prints the crash in words.
pub fn run(args: &Args) -> Result<ExitCode> {
    regular(&args.elf)?;
    let bytes = std::fs::read(&args.elf).with_context(|| args.elf.display().to_string())?;
    let image = Image::parse(&args.elf, &bytes)?;
    let report = reported(args)?;
    match check(&image, &report) {
        Err(error) if args.force => crate::note!("warning: {error}"),
        checked => checked.with_context(|| args.elf.display().to_string())?,
    }
    match report.revision.as_deref() {
        None => crate::note!(
            "warning: the sentence does not tell the image's revision: lines are right only if {} is the image that \
             crashed",
            args.elf.display()
        ),
        Some(revision) if revision.ends_with("-dirty") => crate::note!(
            "warning: the image was built from changed sources: lines are right only if {} is that very build",
            args.elf.display()
        ),
        Some(_) => {}
    }
    emit(&text(&image, &report)?);
    Ok(ExitCode::SUCCESS)
}

/// Returns the last crash of the sentence, the log or the scanner that the arguments name.
fn reported(args: &Args) -> Result<Report> {
    let source = match (&args.sentence, &args.source) {
        (Some(sentence), _) => {
            return report::last(sentence.as_bytes()).context("--sentence");
        }
        (None, Some(source)) => source,
        (None, None) => bail!("expected a log, a port or --sentence"),
    };
    let mut log = Vec::new();
    if source == "-" {
        std::io::stdin().read_to_end(&mut log).context("stdin")?;
    } else if Path::new(source).is_file() {
        log = std::fs::read(source).with_context(|| source.clone())?;
    } else {
        let mut talk = Talk::open(source, args.baud)?;
        let version = talk.version_line()?;
        log = [version, talk.crash()?].join("\n").into_bytes();
    }
    report::last(&log).with_context(|| source.clone())
}
