//! `seal ELF`: adds the checksum and the development signature to an image, or compares two images.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};

use super::emit;
use crate::emulate::image::{build_loader, seal_built};
use crate::emulate::seal::{same, sign};
use crate::update::files::confirmation;

/// Arguments of `seal`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// The image
    elf: PathBuf,
    /// Compare the flash contents of two images byte for byte, without a change; exit status 1 if they differ
    #[arg(long, value_name = "ELF", conflicts_with = "flash")]
    compare: Option<PathBuf>,
    /// Then write boot loader and image to the board and show its log, as `cargo board` does
    #[arg(long)]
    flash: bool,
}

/// Program that flashes the board.
const PROBE: &str = "probe-rs";
/// Arguments of probe-rs that select the board's chip.
const CHIP: [&str; 2] = ["--chip", "STM32F405RGTx"];
/// Confirmation number that is written into an image that is not flashed at once. Of two confirmed images the one with
/// the higher number runs.
const FIRST: u32 = 1;

/// Adds checksum and signature to the image, and flashes it if requested; or compares two images.
pub fn run(args: &Args) -> Result<ExitCode> {
    if let Some(other) = &args.compare {
        let bytes = same(&args.elf, other)?;
        emit(&format!("the same {bytes} bytes of flash\n"));
        return Ok(ExitCode::SUCCESS);
    }
    let [.., crc] = seal_built(&args.elf)?;
    let order = match args.flash {
        true => confirmation(),
        false => FIRST,
    };
    sign(&args.elf, order)?;
    emit(&format!(
        "{}: sealed, CRC-32 {crc:08X}; signed with the development key\n",
        args.elf.display()
    ));
    if !args.flash {
        return Ok(ExitCode::SUCCESS);
    }
    // The loader's sectors and the image's: settings and counter between them stay.
    for (what, elf) in [("download", &build_loader()?), ("run", &args.elf)] {
        let status = Command::new(PROBE).arg(what).args(CHIP).arg(elf).status();
        let status = status.with_context(|| format!("{PROBE} (https://probe.rs installs it)"))?;
        if !status.success() {
            return Ok(ExitCode::FAILURE);
        }
    }
    Ok(ExitCode::SUCCESS)
}
