//! `settings PORT`: reads a scanner's settings into a file, writes them from one, or compares.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use stairscan::scanner::Settings;

use super::emit;
use crate::counted::counted;
use crate::live::talk::{Reply, Talk};
use crate::live::trouble::REPORT_BAUD;
use crate::output::Overwrite;
use crate::recording;
use crate::setting_file::profile::{self, Profile};
use crate::setting_file::table;

/// Timeout of the commands for saving. `save` may erase a sector of flash, during which the scanner does not reply.
const PATIENCE: Duration = Duration::from_secs(15);

/// Arguments of `settings`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Values with a unit are strings, mount-height = \"0.4 m\"; counts and words have no unit and
are: retries = 2, plane = \"depth\". `--get` writes each key with its range. All values are checked before the first is
sent; then every key is read back and compared. Set values hold until the next reset; --save stores them."
)]
pub struct Args {
    /// The report port, such as /dev/ttyUSB0
    port: String,
    #[command(flatten)]
    what: What,
    /// With --set: store the settings in flash; the scanner stops for it, and starts again if it was scanning
    #[arg(long, requires = "set")]
    save: bool,
    /// Baud rate of the port; the scanner uses 115200
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
    /// Set the values in this file; other settings keep theirs
    #[arg(long, value_name = "FILE")]
    set: Option<PathBuf>,
    /// Print the differences between scanner and file; the exit status is 1 if there are any
    #[arg(long, value_name = "FILE")]
    diff: Option<PathBuf>,
}

/// Reads the scanner's settings into a file, sends it those of a file, or compares both.
pub fn run(args: &Args) -> Result<ExitCode> {
    let open = || Talk::open(&args.port, args.baud);
    match &args.what {
        What {
            get: Some(path), ..
        } => {
            let outputs = args.overwrite.reading::<&PathBuf>([]);
            outputs.ready(path)?;
            let mut talk = open()?;
            let version = talk.version()?;
            let reported = talk.settings()?;
            let about = format!(
                "Settings of a scanner, firmware {version}. Written by `cargo sim settings --get`; \
                 `--set` sends\nthem, `--diff` compares. Keys may be omitted; they keep their \
                 values."
            );
            outputs.write(path, profile::text(&reported, &about).as_bytes())?;
            emit(&format!(
                "{}: {}\n",
                path.display(),
                counted(reported.len(), "setting")
            ));
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
            let reported = open()?.settings()?;
            let lines = profile.differences(&reported);
            lines.iter().for_each(|line| emit(&format!("{line}\n")));
            let left = reported
                .keys()
                .filter(|key| !profile.entries.iter().any(|e| e.row.key == **key));
            let left = left
                .filter(|key| table::row(key).is_none_or(|row| !row.read_only))
                .count();
            if left > 0 {
                crate::note!(
                    "note: not in the file and not compared: {} of the scanner",
                    counted(left, "setting")
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
    let text = recording::text(path)?;
    let profile = Profile::parse(&name, &text)?;
    if profile.entries.is_empty() {
        bail!("{name}: holds no setting");
    }
    Ok(profile)
}

/// Sends the file's settings to the scanner, reads all back, and saves them if requested.
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
            "{error}\n  {sent} of {} set before {key}, valid until the next reset: repeat the command",
            counted(changes.len(), "setting")
        );
    }
    let after = talk.settings()?;
    let deviations = deviations(&wanted, &after);
    refused
        .iter()
        .chain(&deviations)
        .for_each(|line| emit(&format!("{line}\n")));
    let changed = after
        .iter()
        .filter(|(key, value)| before.get(*key) != Some(value));
    let lines = changed.filter_map(|(key, value)| {
        let row = table::row(key)?;
        let was = before
            .get(key)
            .map_or("?".to_owned(), |was| row.with_unit(was));
        Some(format!("{key}: {was} -> {}\n", row.with_unit(value)))
    });
    emit(&lines.collect::<String>());
    if !(refused.is_empty() && deviations.is_empty()) {
        bail!(
            "the scanner's values differ from the file's; the set values hold until its next reset, and were not saved"
        );
    }
    emit(&format!(
        "{}: {} set and read back\n",
        path.display(),
        counted(changes.len(), "setting")
    ));
    if save {
        keep(talk)?;
    } else {
        crate::note!("note: they hold until the next reset; --save stores them");
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns one line for each setting of the scanner that differs from the wanted value. `after` are the scanner's
/// values by key.
fn deviations(wanted: &Settings, after: &BTreeMap<String, String>) -> Vec<String> {
    let rows = table::rows().iter().filter(|row| !row.read_only);
    let lines = rows.filter_map(|row| {
        let (wanted, there) = (wanted.get(row.key)?, after.get(row.key));
        match there {
            Some(there) if there.as_str() == wanted.as_str() => None,
            Some(there) => Some(format!(
                "{}: scanner holds {}, expected {}",
                row.key,
                row.with_unit(there),
                row.with_unit(&wanted)
            )),
            None => Some(format!("{}: not reported by the scanner", row.key)),
        }
    });
    lines.collect()
}

/// Saves the scanner's settings in flash at standstill, and resumes scanning if the scanner was scanning.
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
