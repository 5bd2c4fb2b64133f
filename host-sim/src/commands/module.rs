//! `module REC`: the radar module of the link, played on standard input and output, for a model of the chip in another
//! process.

use std::io::{ErrorKind, Read, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, ensure};
use serde_json::json;
use stairscan::config::Config;
use stairscan::signal::radar::frame::Ability;

use crate::emulate::Module;
use crate::emulate::module::Request;
use crate::emulate::session::changed;
use crate::playback::Playback;
use crate::recording::Recording;
use crate::replay::SEED;

/// Maximum length of a message, bytes: the longest that the scanner's port sends at once is a few frames.
const LONGEST: u32 = 1 << 16;

/// Arguments of `module`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// The recording, with or without suffix
    recording: PathBuf,
    /// Fastest bit rate of the wire, Mbaud
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=3))]
    fastest: u8,
    /// Chirps begin at the rising edge of TRIG
    #[arg(long)]
    pin: bool,
}

/// Plays the module until standard input ends.
///
/// First a line of JSON goes out, with the settings that a scanner needs for the recording. Then each message in, a length
/// (u32, little-endian) and so many bytes from the scanner, is answered by a message: the bit rate that holds behind the
/// answer (u8, Mbaud; 0: unchanged), the length of the answer (u32) and its bytes.
///
/// # Errors
/// The recording cannot be played, or a message is too long or cut off.
pub fn run(args: &Args) -> Result<ExitCode> {
    let recording = Recording::read(&args.recording)?;
    let base = Config {
        seed: SEED,
        ..Config::default()
    };
    let playback = Playback::new(&recording, &base)?;
    let sets = changed(&playback.settings(), &[])?;
    let module = Module::new(&playback);
    let ability = Ability {
        fastest: args.fastest,
        ahead: true,
        pin: args.pin,
        ..module.ability()
    };
    let mut module = module.with_ability(ability);
    module.get_ready();
    let (mut input, mut out) = (std::io::stdin().lock(), std::io::stdout().lock());
    writeln!(
        out,
        "{}",
        json!({ "recording": recording.name, "set": sets })
    )?;
    out.flush()?;
    while let Some(bytes) = message(&mut input)? {
        let (answer, requests) = module.receive(&bytes);
        let rate = requests.iter().rev().find_map(|request| match request {
            Request::Rate(rate) => Some(*rate),
            _ => None,
        });
        let length = u32::try_from(answer.len()).context("an answer")?;
        out.write_all(&[rate.unwrap_or(0)])?;
        out.write_all(&length.to_le_bytes())?;
        out.write_all(&answer)?;
        out.flush()?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Reads one message; `None` at the end of the input.
fn message(input: &mut impl Read) -> Result<Option<Vec<u8>>> {
    let mut length = [0; 4];
    match input.read_exact(&mut length) {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
        Err(error) => return Err(error.into()),
    }
    let length = u32::from_le_bytes(length);
    ensure!(
        length <= LONGEST,
        "a message of {length} bytes: at most {LONGEST}"
    );
    let mut bytes = vec![0; length as usize];
    input
        .read_exact(&mut bytes)
        .context("a message that is cut off")?;
    Ok(Some(bytes))
}
