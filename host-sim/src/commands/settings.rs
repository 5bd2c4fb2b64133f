//! `settings PORT`: reads a scanner's settings into a file, writes them from one, or compares.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use stairscan::scanner::Settings;

use super::emit;
use crate::live::talk::{Reply, Talk};
use crate::live::trouble::REPORT_BAUD;
use crate::output::Overwrite;
use crate::recording;
use crate::setting_file::profile::{self, Profile};
use crate::setting_file::table;

/// Timeout of a command. `save` may erase a sector of flash, during which the scanner does not reply.
const PATIENCE: Duration = Duration::from_secs(15);

/// Arguments of `settings`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Values are numbers with their unit in a string, mount-height = \"0.4 m\"; counts and words stand as they
are: retries = 2, plane = \"depth\". `--get` writes each key with its range. All values are checked before the first is
sent; then every key is read back and compared. What is set counts until the next reset: --save keeps it."
)]
pub struct Args {
    /// The report port, such as /dev/ttyUSB0
    port: String,
    #[command(flatten)]
    what: What,
    /// With --set: keep the settings over loss of power; the scanner stops for it, and starts again if it was scanning
    #[arg(long, requires = "set")]
    save: bool,
    /// Speed of the port; the scanner's is 115200
    #[arg(long, default_value_t = REPORT_BAUD, value_parser = clap::value_parser!(u32).range(50..=4_000_000))]
    baud: u32,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Direction between file and scanner, or a comparison of both.
#[derive(clap::Args, Clone, Debug)]
#[group(required = true, multiple = false)]
struct What {
    /// Write the scanner's settings to this file
    #[arg(long, value_name = "FILE")]
    get: Option<PathBuf>,
    /// Set what this file holds; other settings stay as they are
    #[arg(long, value_name = "FILE")]
    set: Option<PathBuf>,
    /// Print where scanner and file differ; then the exit status is 1
    #[arg(long, value_name = "FILE")]
    diff: Option<PathBuf>,
}

/// Reads, writes or compares.
pub fn run(args: &Args) -> Result<ExitCode> {
    let open = || Talk::open(&args.port, args.baud);
    match &args.what {
        What {
            get: Some(path), ..
        } => {
            let outputs = args.overwrite.reading::<&PathBuf>([]);
            outputs.check(path)?;
            let mut talk = open()?;
            let version = talk.version()?;
            let told = talk.settings()?;
            let about = format!(
                "Settings of a scanner, firmware {version}. Written by `cargo sim settings --get`; `--set` sends\n\
                 them, `--diff` compares. Keys may be left out: those stay as they are."
            );
            outputs.write(path, profile::text(&told, &about).as_bytes())?;
            emit(&format!("{}: {} settings\n", path.display(), told.len()));
            Ok(ExitCode::SUCCESS)
        }
        What {
            set: Some(path), ..
        } => {
            let profile = read(path)?;
            set(&mut open()?, path, &profile, args.save)
        }
        What {
            diff: Some(path), ..
        } => {
            let profile = read(path)?;
            let told = open()?.settings()?;
            let lines = profile.differences(&told);
            lines.iter().for_each(|line| emit(&format!("{line}\n")));
            let left = told
                .keys()
                .filter(|key| !profile.entries.iter().any(|e| e.row.key == **key));
            let left = left
                .filter(|key| table::row(key).is_none_or(|row| !row.read_only))
                .count();
            if left > 0 {
                eprintln!(
                    "note: {left} settings of the scanner are not in the file and were not compared"
                );
            }
            Ok(ExitCode::from(u8::from(!lines.is_empty())))
        }
        _ => bail!("expected --get, --set or --diff"),
    }
}

fn read(path: &Path) -> Result<Profile> {
    recording::regular(path)?;
    let name = path.display().to_string();
    let text = fs::read_to_string(path).with_context(|| name.clone())?;
    let profile = Profile::parse(&name, &text)?;
    if profile.entries.is_empty() {
        bail!("{name}: holds no setting");
    }
    Ok(profile)
}

/// Sends the file's settings, reads all back, and saves them if requested.
fn set(talk: &mut Talk, path: &Path, profile: &Profile, save: bool) -> Result<ExitCode> {
    let before = talk.settings()?;
    let (changes, wanted) = profile.changes(&path.display().to_string(), &before)?;
    let (mut refused, mut broken) = (Vec::new(), None);
    for (key, value) in &changes {
        match talk.command(&["set", key, value]) {
            Ok(Reply::Good(_)) => {}
            Ok(Reply::Refused(field, expected)) => {
                refused.push(format!("{key}: refused: {field}: expected {expected}"))
            }
            Err(error) => {
                broken = Some((key, error));
                break;
            }
        }
    }
    if let Some((key, error)) = broken {
        let sent = changes.iter().take_while(|change| change.0 != *key).count();
        bail!(
            "{error}\n  {sent} of {} settings were set before {key}, and count until the next reset: repeat the command",
            changes.len()
        );
    }
    let after = talk.settings()?;
    let astray = astray(&wanted, &after);
    refused
        .iter()
        .chain(&astray)
        .for_each(|line| emit(&format!("{line}\n")));
    let changed = after
        .iter()
        .filter(|(key, value)| before.get(*key) != Some(value));
    let lines = changed.filter_map(|(key, value)| {
        let row = table::row(key)?;
        let was = before
            .get(key)
            .map_or("?".to_owned(), |was| row.spoken(was));
        Some(format!("{key}: {was} -> {}\n", row.spoken(value)))
    });
    emit(&lines.collect::<String>());
    if !(refused.is_empty() && astray.is_empty()) {
        bail!(
            "the scanner does not hold what the file says; what was set counts until its next reset, and was not saved"
        );
    }
    emit(&format!(
        "{}: {} settings set and read back\n",
        path.display(),
        changes.len()
    ));
    if save {
        keep(talk)?;
    } else {
        eprintln!("note: they count until the next reset: --save keeps them");
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the settings of the scanner that differ from the wanted ones, one line each.
fn astray(wanted: &Settings, after: &BTreeMap<String, String>) -> Vec<String> {
    let rows = table::rows().iter().filter(|row| !row.read_only);
    let lines = rows.filter_map(|row| {
        let (wanted, there) = (wanted.get(row.key)?, after.get(row.key));
        match there {
            Some(there) if there.as_str() == wanted.as_str() => None,
            Some(there) => Some(format!(
                "{}: scanner holds {}, expected {}",
                row.key,
                row.spoken(there),
                row.spoken(&wanted)
            )),
            None => Some(format!("{}: the scanner does not tell it", row.key)),
        }
    });
    lines.collect()
}

/// Saves at standstill, and resumes scanning if the scanner was scanning.
fn keep(talk: &mut Talk) -> Result<()> {
    let status = talk.status()?;
    let stood = status.contains(",STAT,idle,");
    let mut command = |word: &'static str| match talk.slow_command(&[word], PATIENCE)? {
        Some(Reply::Good(_)) => Ok(()),
        Some(Reply::Refused(field, expected)) => {
            bail!("{word}: refused: {field}: expected {expected}")
        }
        None => bail!("{word}: no answer"),
    };
    if !stood {
        command("stop")?;
    }
    let saved = command("save");
    if !stood {
        command("start")?;
    }
    saved.context("set, but not saved")?;
    emit("saved\n");
    Ok(())
}
