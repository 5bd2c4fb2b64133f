//! `image`: boot loader and image as files for programs that write flash.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Result, ensure};
use stairscan_boot::key::PublicKey;

use super::emit;
use crate::emulate::image::{build, build_loader, workspace};
use crate::output::Overwrite;
use crate::update::files::{Block, flash, intel_hex, whole};
use crate::update::keys;

/// Arguments of `image`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Folder of the files; created if it is missing
    #[arg(short, long)]
    output: PathBuf,
    /// Write the demo image instead: a recording in place of radar module and motor, started without the boot loader
    #[arg(long, conflicts_with = "key")]
    demo: bool,
    /// File of the secret key that signs the image; without it the development key. The loader trusts the public key that
    /// the environment's STAIRSCAN_UPDATE_KEY names, a path from the repository's root
    #[arg(long)]
    key: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Environment variable that names the public key that the loader trusts (boot/build.rs).
const TRUSTED: &str = "STAIRSCAN_UPDATE_KEY";

/// Builds loader and image, seals and signs the image, and writes both as Intel HEX and as raw bytes.
pub fn run(args: &Args) -> Result<ExitCode> {
    let outputs = args.overwrite.reading(&args.key);
    let name = if args.demo { "demo" } else { "stairscan" };
    // The names of the blocks' files are known after the build only.
    let known = ["hex", "bin"].map(|suffix| format!("{name}.{suffix}"));
    outputs.ready_folder(&args.output, &known)?;
    let files = match args.demo {
        true => files(name, &Block::of_elf(&build(&["demo"])?)?)?,
        false => files(name, &signed(args.key.as_deref())?)?,
    };
    let mut lines = String::new();
    let mut contents = Vec::new();
    for (name, address, bytes) in files {
        let path = args.output.join(&name);
        let place = address.map_or_else(String::new, |at| format!(", for address 0x{at:08x}"));
        lines += &format!("{}: {} bytes{place}\n", path.display(), bytes.len());
        contents.push((name, bytes));
    }
    outputs.write_folder(&args.output, &contents)?;
    emit(&lines);
    Ok(ExitCode::SUCCESS)
}

/// Returns the blocks of loader and image, which is signed with the key in the file `key`, or the development key.
fn signed(key: Option<&Path>) -> Result<Vec<Block>> {
    let key = match key {
        Some(path) => keys::read_secret(path)?,
        None => keys::development()?,
    };
    trusted(&PublicKey(key.verifying_key().to_bytes()))?;
    flash(&build_loader()?, &build(&[])?, &key)
}

/// A file: its name, the address of its first byte in flash (`None` if the file itself says so), its content.
type Named = (String, Option<u32>, Vec<u8>);

/// Returns the files of `blocks`: all as Intel HEX, all as raw bytes, and each block by itself.
fn files(name: &str, blocks: &[Block]) -> Result<Vec<Named>> {
    let hex = intel_hex(blocks)?.into_bytes();
    let all = whole(blocks);
    let raw = |name: String, block: &Block| (name, Some(block.address), block.bytes.clone());
    let mut files = vec![
        (format!("{name}.hex"), None, hex),
        raw(format!("{name}.bin"), &all),
    ];
    let parts = blocks.iter();
    files.extend(parts.map(|block| raw(format!("{name}-{:08x}.bin", block.address), block)));
    Ok(files)
}

/// Refuses a signature that the loader will not accept.
fn trusted(signs: &PublicKey) -> Result<()> {
    let known = match std::env::var_os(TRUSTED) {
        Some(path) => keys::read(&workspace().join(Path::new(&path)))?.public(),
        None => PublicKey(keys::development()?.verifying_key().to_bytes()),
    };
    ensure!(
        known.0 == signs.0,
        "the loader would not execute this image: expected --key with the secret half of the key that it trusts, the \
         development key or that in the file that {TRUSTED} names ({TRUSTED}=maker.pub)"
    );
    Ok(())
}
