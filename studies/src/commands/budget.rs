//! `budget`: compares the image's use of the chip with its limits.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use serde_json::json;
use stairscan::config::EstimatorKind;
use stairscan::report::Sentence;
use stairscan::scanner::Settings as ScannerSettings;

use super::{Format, Settings, emit, progress};
use host_sim::budgets;
use host_sim::emulate::Session;
use host_sim::emulate::image::{self, Image};
use host_sim::emulate::session::Waits;
use host_sim::emulate::tools::Tool;
use host_sim::playback::Playback;
use host_sim::recording::Recording;

/// Arguments of `budget`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings to scan in the emulator with every estimator, for the stack's high-water mark and the instructions
    /// after the last row
    recordings: Vec<PathBuf>,
    /// The image; without it the workspace's image is built
    #[arg(long)]
    elf: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// A resource of the chip: the amount that the image uses, and the limit.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of the resource with its unit.
    pub what: String,
    /// Amount of the resource that the image uses, in the unit of `what`.
    pub used: u64,
    /// Maximum amount of the resource that the image may use, in the unit of `what`.
    pub limit: u64,
}

impl Figure {
    fn new(what: &str, used: u64, limit: u64) -> Self {
        Self {
            what: what.to_owned(),
            used,
            limit,
        }
    }

    /// Whether the used amount of the resource is within its limit.
    pub fn holds(&self) -> bool {
        self.used <= self.limit
    }
}

/// Returns an image's use of flash and static RAM, and its numbers of symbols and functions that must not occur:
/// allocator, double precision, panics.
pub fn of_image(elf: &Path) -> Result<Vec<Figure>> {
    let image = Image::read(elf)?;
    for function in &image.may_panic {
        host_sim::note!("may panic: {function}");
    }
    let panics = image.may_panic.len() as u64;
    Ok(vec![
        Figure::new("flash, bytes", image.flash, budgets::FLASH),
        Figure::new("static RAM, bytes", image.ram, budgets::RAM),
        Figure::new("allocator symbols", image.count(image::ALLOCATOR), 0),
        Figure::new("double-precision symbols", image.count(image::DOUBLE), 0),
        Figure::new("functions that may panic", panics, 0),
    ])
}

/// Returns the flash of the boot loader without its vector table, which has a sector of its own.
pub fn of_loader(elf: &Path) -> Result<Figure> {
    let image = Image::read(elf)?;
    let sections = image.sections.iter();
    let vectors = sections.filter(|(name, _)| name == ".vector_table");
    let vectors: u64 = vectors.map(|(_, size)| size).sum();
    let used = image.flash.saturating_sub(vectors);
    Ok(Figure::new("boot loader, bytes", used, budgets::LOADER))
}

/// Returns the maximum stack use over two scans of a recording, one in each direction, bytes.
pub fn stack(elf: &Path, recording: &Recording, settings: &ScannerSettings) -> Result<u64> {
    let playback = Playback::new(recording, &settings.config)?;
    let settings = ScannerSettings {
        timing: settings.timing,
        motor: settings.motor,
        ..playback.settings()
    };
    let mut session = Session::boot(elf, &playback)?;
    session.configure(&settings, Waits::default())?;
    session.skip_lines();
    session.connect()?;
    session.scans(2, |_, _| Ok(()))?;
    let answer = session.command("get,stack-used")?;
    match Sentence::parse(&answer) {
        Ok(Sentence::Config { value, .. }) => Ok(value.parse()?),
        _ => anyhow::bail!("get,stack-used: the image answers {answer}"),
    }
}

/// Measures the image's use of every resource and prints the table; exit status 1 if a budget is exceeded.
pub fn run(args: &Args) -> Result<ExitCode> {
    let elf = match &args.elf {
        Some(elf) => elf.clone(),
        None => image::build(&[])?,
    };
    let mut figures = of_image(&elf)?;
    figures.push(of_loader(&image::build_loader()?)?);
    if !args.recordings.is_empty() {
        Tool::Emulator.need()?;
    }
    let stacks = args.recordings.len() * EstimatorKind::ALL.len();
    let bar = progress(stacks as u64).with_prefix("in the emulator");
    for path in &args.recordings {
        let recording = Recording::read(path)?;
        for &estimator in EstimatorKind::ALL {
            let mut settings = ScannerSettings {
                config: args.settings.config()?,
                ..ScannerSettings::default()
            };
            settings.config.estimator = estimator;
            let what = format!("stack, {} on {}, bytes", estimator.as_str(), recording.name);
            let used = stack(&elf, &recording, &settings).with_context(|| what.clone())?;
            figures.push(Figure::new(&what, used, budgets::STACK));
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    if !args.recordings.is_empty() {
        let post = super::bench::worst_post(&args.recordings)?;
        figures.push(Figure::new(
            "last row to report, instructions",
            post,
            budgets::POST,
        ));
    }
    print(&figures, args.format);
    Ok(if figures.iter().all(Figure::holds) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn print(figures: &[Figure], format: Format) {
    for f in figures {
        match format {
            Format::Json => {
                let line = json!({"what": f.what, "used": f.used, "limit": f.limit});
                emit(&format!("{line}\n"));
            }
            Format::Text => {
                let verdict = if f.holds() { "" } else { "  ABOVE BUDGET" };
                emit(&format!(
                    "{:<44} {:>8} of {:>8}{verdict}\n",
                    f.what, f.used, f.limit
                ));
            }
        }
    }
}
