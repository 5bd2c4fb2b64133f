//! `seal ELF`: adds the checksum to an image, or compares two images.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};

use super::emit;
use crate::emulate::seal::{same, seal};

/// Arguments of `seal`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// The image
    elf: PathBuf,
    /// Change nothing: compare what both images bring into flash, byte for byte; exit status 1 where they differ
    #[arg(long, value_name = "ELF", conflicts_with = "flash")]
    compare: Option<PathBuf>,
    /// Then write it to the board and show its log, as `cargo flash` does
    #[arg(long)]
    flash: bool,
}

/// Program that flashes the board, with its arguments before the image's name.
const PROBE: [&str; 4] = ["probe-rs", "run", "--chip", "STM32F405RGTx"];

/// Seals the image, and flashes it if requested.
pub fn run(args: &Args) -> Result<ExitCode> {
    if let Some(other) = &args.compare {
        let bytes = same(&args.elf, other)?;
        emit(&format!("the same {bytes} bytes of flash\n"));
        return Ok(ExitCode::SUCCESS);
    }
    let [.., crc] = seal(&args.elf)?;
    emit(&format!(
        "{}: sealed, CRC-32 {crc:08X}\n",
        args.elf.display()
    ));
    if !args.flash {
        return Ok(ExitCode::SUCCESS);
    }
    let [program, rest @ ..] = PROBE;
    let status = Command::new(program).args(rest).arg(&args.elf).status();
    let status = status.with_context(|| format!("{program} (https://probe.rs installs it)"))?;
    Ok(match status.success() {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}
