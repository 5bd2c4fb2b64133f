//! `crash ELF`: file and line of a crash that a scanner has reported.

use std::io::Read as _;
use std::os::unix::fs::FileTypeExt as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail, ensure};
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
    } else if is_port(source)? {
        let mut talk = Talk::open(source, args.baud)?;
        let version = talk.version_line()?;
        log = [version, talk.crash()?].join("\n").into_bytes();
    } else {
        log = std::fs::read(source).with_context(|| source.clone())?;
    }
    report::last(&log).with_context(|| source.clone())
}

/// Whether a source is a port to ask, also one that is not there, rather than a log: a file or a pipe.
///
/// # Errors
/// There is no such file, and the name is none of a device; or it is a directory.
fn is_port(source: &str) -> Result<bool> {
    let found = match std::fs::metadata(source) {
        Err(_) if Path::new(source).starts_with("/dev") => return Ok(true),
        found => found.with_context(|| format!("{source}: neither a log nor a port"))?,
    };
    ensure!(
        !found.is_dir(),
        "{source}: a directory, expected a log or a port"
    );
    Ok(found.file_type().is_char_device())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_no_port_and_a_missing_one_is_named_as_such() {
        let here = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
        assert!(!is_port(here).unwrap());
        assert!(is_port("/dev/ttyNONE7").unwrap() && is_port("/dev/null").unwrap());
        let missing = format!("{:#}", is_port("session.log").unwrap_err());
        assert!(
            missing.starts_with("session.log: neither a log nor a port: No such file"),
            "{missing}"
        );
        let dir = is_port(env!("CARGO_MANIFEST_DIR")).unwrap_err().to_string();
        assert!(
            dir.contains("a directory, expected a log or a port"),
            "{dir}"
        );
    }
}
