//! `web -o FILE`: writes the scanner as WebAssembly in one page for any browser.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, ensure};

use super::report::{plain_name, save};
use super::{emit, full_scans, recordings};
use crate::emulate::image;
use crate::html::twin;
use crate::output::Overwrite;
use crate::recording::Recording;
use crate::scene::Scene;
use crate::scene::sequence::Approach;

/// Arguments of `web`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings that the page contains, or directories of them; without any, those of the repository and a simulated
    /// approach of three scans
    recordings: Vec<PathBuf>,
    /// Output file; without it stairscan.html, of one recording its NAME-web.html, in this directory
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Builds the scanner for WebAssembly, and writes the page that contains it and the recordings.
pub fn run(args: &Args) -> Result<ExitCode> {
    let root = image::workspace();
    let paths = match args.recordings.as_slice() {
        [] => full_scans(&root.join("recordings"))?,
        given => recordings(given)?,
    };
    let outputs = args.overwrite.reading(&paths);
    let own = match args.recordings.as_slice() {
        [one] => format!("{}-web.html", plain_name(one)),
        _ => "stairscan.html".to_owned(),
    };
    let file = args.output.clone().unwrap_or_else(|| own.into());
    outputs.check_kind(&file, &["html", "htm"])?;
    outputs.ready(&file)?;
    let read = |path: &PathBuf| Recording::read(path);
    let mut stock: Vec<Recording> = paths.iter().map(read).collect::<Result<_>>()?;
    if args.recordings.is_empty() {
        stock.push(approach(&root.join("scenes"))?);
    }
    let page = twin::page(&wasm(&image::build_web()?)?, &stock)?;
    let names: Vec<&str> = stock.iter().map(|r| r.name.as_str()).collect();
    let with = format!(", with {}", names.join(", "));
    emit(&save(&outputs, &file, &page, &with)?);
    Ok(ExitCode::SUCCESS)
}

/// Simulates a sequence for the page: a chair that approaches stairs, with scene and seed as in `simulate`.
fn approach(scenes: &Path) -> Result<Recording> {
    const SEED: u64 = 0;
    const SCANS: usize = 3;
    const STEP_M: f64 = 0.15;
    let scene = Scene::read(&scenes.join("approach.toml"))?;
    scene.simulate_approach("approach", SEED, &Approach::new(SEED, SCANS, STEP_M))
}

/// Reads the bytes of a WebAssembly module.
fn wasm(path: &Path) -> Result<Vec<u8>> {
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    ensure!(
        bytes.starts_with(b"\0asm"),
        "{}: expected a WebAssembly module",
        path.display()
    );
    Ok(bytes)
}
