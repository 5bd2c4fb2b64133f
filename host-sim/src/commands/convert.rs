//! `convert IN… -o OUT`: converts other programs' files to recordings, and recordings to other formats.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail, ensure};
use stairscan::config::Config;

use super::{Settings, emit, full_scans, logs, progress, recordings};
use crate::convert::keys::Given;
use crate::convert::npy::Axes;
use crate::convert::scans::{self, Scan};
use crate::convert::tables::{self, Table};
use crate::convert::{self, Source, mcap, npy, suffix};
use crate::counted::counted;
use crate::live::log::Log;
use crate::output::{Outputs, Overwrite};
use crate::recording::{DATA_SUFFIX, META_SUFFIX, Recording};
use crate::replay::Options;
use crate::setup;

/// Arguments of `convert`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Input: a recording or any SigMF file of samples, a NumPy array (.npy), or a capture of TI's DCA1000
    /// (.bin with a .toml); for a table also several recordings, or directories of them; for a table or .mcap also a
    /// log of sentences
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Output; its suffix selects the format: .npy, .csv, .mcap, or a recording (.sigmf-meta or no suffix)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Rows of a .csv: a step (or a scan without), an answer, a guard sweep of a log, an echo, or a cell of the polar map;
    /// reasons: docs/reasons.md
    #[arg(
        long,
        value_enum,
        default_value_t,
        value_name = "steps|answers|sweeps|echoes|map",
        hide_possible_values = true
    )]
    table: Table,
    /// Write a .npy of complex64, full scale 1.0, instead of 16-bit I and Q
    #[arg(long)]
    complex: bool,
    /// Radar settings of a DCA1000 capture (docs/user/formats.md); without it NAME.toml of NAME.bin
    #[arg(long, value_name = "FILE", help_heading = "Inputs of other programs")]
    setup: Option<PathBuf>,
    /// Angles of the beam, degrees: one a line, one line a chirp
    #[arg(long, value_name = "FILE", help_heading = "Inputs of other programs")]
    angles: Option<PathBuf>,
    /// Take keys that are not given from this recording
    #[arg(long, value_name = "REC", help_heading = "Inputs of other programs")]
    keys_of: Option<PathBuf>,
    /// Full-scale value of a sample, and the zero of unsigned numbers; without it 1.0 for floating point, the
    /// format's range for integers
    #[arg(long, value_name = "VALUE", help_heading = "Inputs of other programs")]
    full_scale: Option<f64>,
    /// The .npy holds real samples, not I and Q, with these axes in order: frame, chirp, sample, and NAME=ENTRY
    /// for one entry of another axis: chirp,sample or frame,receiver=0,chirp,sample
    #[arg(long, value_name = "AXES", help_heading = "Inputs of other programs")]
    real: Option<Axes>,
    /// Each row of the .npy holds all I of a chirp, then all Q
    #[arg(long, conflicts_with = "real")]
    planar: bool,
    #[command(flatten)]
    given: Given,
    /// Treat every scan of a recording as if it were the first
    #[arg(long)]
    single: bool,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Output format, selected by the suffix of the file's name.
enum Output {
    Recording,
    Array,
    Table,
    Messages,
}

impl Output {
    fn of(path: &Path) -> Result<Self> {
        Ok(match suffix(path) {
            "npy" => Self::Array,
            "csv" => Self::Table,
            "mcap" => Self::Messages,
            "" | META_SUFFIX | DATA_SUFFIX => Self::Recording,
            other => bail!(
                "{}: .{other}: expected .npy, .csv, .mcap, or a recording (.{META_SUFFIX} or no suffix)",
                path.display()
            ),
        })
    }
}

/// Converts the inputs to the output file, and prints the number of chirps, rows or messages in it.
pub fn run(args: &Args) -> Result<ExitCode> {
    let output = Output::of(&args.output)?;
    if let Some(logs) = logs::all(&args.inputs)? {
        return of_logs(args, &output, &logs);
    }
    ensure!(
        args.table != Table::Sweeps,
        "--table sweeps: expected a log of sentences, not a recording: cargo sim replay prints its guard sweeps"
    );
    let paths = inputs(&args.inputs)?;
    ensure!(
        paths.len() == 1 || matches!(output, Output::Table),
        "{}: {} inputs, expected one: only a table holds several",
        args.output.display(),
        paths.len()
    );
    let beside = [&args.setup, &args.angles, &args.keys_of];
    let read_too = beside.into_iter().flatten();
    let outputs = args.overwrite.reading(paths.iter().chain(read_too));
    match output {
        Output::Recording => outputs.ready_recording(&args.output)?,
        _ => outputs.ready(&args.output)?,
    }
    let summary = match output {
        Output::Recording => write_recording(args, only(&paths)?, &outputs)?,
        Output::Array => {
            let recording = read(args, only(&paths)?)?;
            ensure!(
                !recording.meta.real,
                "{}: real samples: a .npy holds I and Q, expected another kind of output",
                recording.name
            );
            outputs.write(&args.output, &npy::write(&recording, args.complex))?;
            chirps(&recording)
        }
        Output::Table => {
            let scans = scan_all(args, &paths)?;
            outputs.write(&args.output, &tables::write(&scans, args.table)?)?;
            summary(&scans, "rows of")
        }
        Output::Messages => {
            let scans = scan_all(args, &paths)?;
            outputs.write(&args.output, &mcap::write(&scans, &[])?)?;
            summary(&scans, "messages of")
        }
    };
    emit(&format!("{}: {summary}\n", args.output.display()));
    Ok(ExitCode::SUCCESS)
}

/// Writes answers or guard sweeps of logs, and prints their number.
fn of_logs(args: &Args, output: &Output, logs: &[Log]) -> Result<ExitCode> {
    let outputs = args.overwrite.reading(&args.inputs);
    outputs.check(&args.output)?;
    match (output, args.table) {
        (_, Table::Sweeps) => sweeps_of_logs(args, output, logs, &outputs),
        (Output::Messages, _) => messages_of_logs(args, logs, &outputs),
        (Output::Table, Table::Answers | Table::Steps) => rows_of_logs(args, logs, &outputs),
        _ => bail!(
            "{}: a log has sentences only, no chirps: expected .mcap, or .csv with --table answers, steps or sweeps",
            logs.first().map_or("", |log| &log.name)
        ),
    }
}

/// Writes the answers of logs as rows, and prints the number of scans.
fn rows_of_logs(args: &Args, logs: &[Log], outputs: &Outputs) -> Result<ExitCode> {
    let mut all = Vec::new();
    for log in logs {
        all.extend(logs::scans(log)?);
    }
    outputs.write(&args.output, &tables::write(&all, args.table)?)?;
    let summary = summary(&all, "rows of");
    emit(&format!("{}: {summary}\n", args.output.display()));
    Ok(ExitCode::SUCCESS)
}

/// Writes the messages of logs, and prints the number of scans and guard sweeps.
fn messages_of_logs(args: &Args, logs: &[Log], outputs: &Outputs) -> Result<ExitCode> {
    let (mut scans, mut sweeps) = (Vec::new(), Vec::new());
    for log in logs {
        let of = logs::sweeps(log).unwrap_or_default();
        match logs::scans(log) {
            Ok(of) => scans.extend(of),
            Err(error) if of.is_empty() => return Err(error),
            Err(_) => {}
        }
        sweeps.extend(of);
    }
    outputs.write(&args.output, &mcap::write(&scans, &sweeps)?)?;
    let counts = [(scans.len(), "scan"), (sweeps.len(), "guard sweep")];
    let counts: Vec<String> = counts
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, noun)| counted(*count, noun))
        .collect();
    let file = args.output.display();
    emit(&format!("{file}: messages of {}\n", counts.join(" and ")));
    Ok(ExitCode::SUCCESS)
}

/// Writes the guard sweeps of logs, and prints their number.
fn sweeps_of_logs(
    args: &Args,
    output: &Output,
    logs: &[Log],
    outputs: &Outputs,
) -> Result<ExitCode> {
    let file = args.output.display();
    ensure!(
        matches!(output, Output::Table),
        "{file}: --table sweeps: expected .csv"
    );
    let mut all = Vec::new();
    for log in logs {
        all.extend(logs::sweeps(log)?);
    }
    outputs.write(&args.output, &tables::sweeps(&all)?)?;
    let count = counted(all.len(), "guard sweep");
    emit(&format!("{file}: rows of {count}\n"));
    Ok(ExitCode::SUCCESS)
}

/// Returns the paths of the inputs: foreign files as given, recordings as other commands find them.
fn inputs(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    if let Some(archive) = paths.iter().find(|path| suffix(path) == "npz") {
        bail!(
            "{}: an archive of arrays: expected one array, which numpy.save writes as .npy",
            archive.display()
        );
    }
    let file = |path: &PathBuf| matches!(suffix(path), "npy" | "bin");
    if paths.iter().any(file) {
        return Ok(paths.to_vec());
    }
    // Sweeps of the guard among the recordings of a directory have no steps to tabulate.
    let mut all = Vec::new();
    for path in paths {
        match path.is_dir() {
            true => all.extend(full_scans(path)?),
            false => all.push(path.clone()),
        }
    }
    recordings(&all)
}

fn only(paths: &[PathBuf]) -> Result<&Path> {
    paths.first().map(PathBuf::as_path).context("no input")
}

fn source(args: &Args, path: &Path) -> Source {
    Source {
        path: path.to_owned(),
        setup: args.setup.clone(),
        angles: args.angles.clone(),
        keys_of: args.keys_of.clone(),
        given: args.given.clone(),
        full_scale: args.full_scale,
        real: args.real.clone(),
        planar: args.planar,
    }
}

fn read(args: &Args, path: &Path) -> Result<Recording> {
    source(args, path).read(&convert::name(path))
}

/// Scans all recordings. Returns every scan with its answer, and with its map if the output is a table of maps.
fn scan_all(args: &Args, paths: &[PathBuf]) -> Result<Vec<Scan>> {
    let options = Options {
        single: args.single,
        ..args.settings.options(args.settings.config()?)
    };
    let with_map = suffix(&args.output) == "csv" && args.table == Table::Map;
    let mut all = Vec::new();
    let bar = progress(paths.len() as u64);
    for path in paths {
        all.extend(scans::of(&read(args, path)?, &options, with_map)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(all)
}

fn write_recording(args: &Args, path: &Path, outputs: &Outputs) -> Result<String> {
    let recording = source(args, path).read(&convert::name(&args.output))?;
    outputs.write_recording(&args.output, &recording)?;
    let next = match setup::config(&recording, 0, &Config::default()) {
        Ok(_) => "next: cargo sim replay".to_owned(),
        Err(error) => format!("cannot be scanned: {error:#}; range profile: cargo sim profile"),
    };
    Ok(format!(
        "{}; {next} {}",
        chirps(&recording),
        args.output.display()
    ))
}

fn chirps(recording: &Recording) -> String {
    format!(
        "{} of {} samples",
        counted(recording.chirps(), "chirp"),
        recording.meta.file_samples()
    )
}

fn summary(scans: &[Scan], what: &str) -> String {
    format!("{what} {}", counted(scans.len(), "scan"))
}
