//! `keys`: pairs of keys, and images that are signed with them.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use stairscan_boot::key::PublicKey;

use super::emit;
use crate::emulate::image;
use crate::output::Overwrite;
use crate::update::client::version;
use crate::update::keys::{self, Key, hex};
use crate::update::package::Package;

/// Arguments of `keys`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "A boot loader trusts one key, that which `STAIRSCAN_UPDATE_KEY=maker.pub` named when it was built; without \
it the development key of boot/keys/, whose secret half everybody has. docs/user/update.md says how a maker keeps keys."
)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

/// What is done.
#[derive(clap::Subcommand, Debug)]
enum What {
    /// Make a new pair: the secret half in NAME.key, for its owner only, the public half beside it in NAME.pub
    New {
        /// File of the secret half, NAME.key
        file: PathBuf,
        #[command(flatten)]
        overwrite: Overwrite,
    },
    /// Seal an image and sign it for both slots: the file that `update` sends
    Sign {
        /// The image that `cargo firmware` builds; without it the workspace's image is built
        elf: Option<PathBuf>,
        /// The signed file
        #[arg(short, long)]
        output: PathBuf,
        /// File of the secret half; without it the development key
        #[arg(long)]
        key: Option<PathBuf>,
        /// Number that the anti-rollback counter takes over once the image has been confirmed; images of lower numbers are
        /// refused from then on, so it rises only where older images must never run again
        #[arg(long, default_value_t = 0)]
        number: u32,
        #[command(flatten)]
        overwrite: Overwrite,
    },
    /// Print what a key is, or what a signed file holds
    Show {
        /// File of a key, or one that `keys sign` wrote
        file: PathBuf,
    },
}

/// Makes a pair of keys, signs an image, or prints the content of a file.
pub fn run(args: &Args) -> Result<ExitCode> {
    match &args.what {
        What::New { file, overwrite } => {
            let key = keys::create(file, overwrite.is_forced())?;
            let public = keys::public_path(file);
            emit(&format!(
                "{}: secret half, mode 600: keep a copy where no network reaches\n{}: public half, {}\n",
                file.display(),
                public.display(),
                hex(&key.id())
            ));
        }
        What::Sign {
            elf,
            output,
            key,
            number,
            overwrite,
        } => {
            let outputs = overwrite.reading(elf.iter().chain(key));
            outputs.ready(output)?;
            let key = match key {
                Some(path) => keys::read_secret(path)?,
                None => {
                    crate::note!(
                        "warning: signed with the development key, which everybody has: expected --key for a scanner that \
                         somebody relies on"
                    );
                    keys::development()?
                }
            };
            let elf = match elf {
                Some(elf) => elf.clone(),
                None => image::build(&[])?,
            };
            image::seal_built(&elf)?;
            let package = Package::sign(&elf, *number, &key)?;
            let bytes = package.bytes();
            outputs.write(output, &bytes)?;
            emit(&format!(
                "{}: {}, {} bytes, key {}\n",
                output.display(),
                version(&package),
                bytes.len(),
                hex(&PublicKey(key.verifying_key().to_bytes()).id())
            ));
        }
        What::Show { file } => show(file)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn show(file: &Path) -> Result<()> {
    let name = file.display();
    match keys::read(file) {
        Ok(key) => {
            let kind = match key {
                Key::Pair(_) => "secret key",
                Key::Public(_) => "public key",
            };
            let whose = match key.is_development() {
                true => ", the development key, which everybody has",
                false => "",
            };
            let public = key.public();
            emit(&format!(
                "{name}: {kind} {}{whose}\n  public half {}\n",
                hex(&public.id()),
                hex(&public.0)
            ));
        }
        Err(no_key) => {
            if !std::fs::read(file).is_ok_and(|bytes| Package::begins(&bytes)) {
                return Err(no_key);
            }
            let package = Package::read(file)?;
            let id = package.key_id();
            emit(&format!(
                "{name}: signed image {}, key {}\n",
                version(&package),
                hex(&id)
            ));
        }
    }
    Ok(())
}
