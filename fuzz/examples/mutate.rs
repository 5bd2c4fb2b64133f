//! Fuzzes without libFuzzer, on a stable compiler: mutations of the corpus, determined by the seed.
//!
//! `cargo run --release -p stairscan-fuzz --example mutate -- radar_link --runs 1000000`

use std::fs;
use std::panic::catch_unwind;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use stairscan_fuzz::mutate::Mutator;
use stairscan_fuzz::{TARGETS, corpus, corpus_of, seeds};

#[derive(Parser)]
struct Args {
    /// Targets; without any, all of them
    targets: Vec<String>,
    /// So many inputs for each
    #[arg(long, default_value_t = 10_000)]
    runs: u64,
    /// Seed of the first mutation
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where an input that fails is written to
    #[arg(long, default_value = "target/fuzz-findings")]
    findings: PathBuf,
    /// Write the corpus anew from the seeds, and run nothing
    #[arg(long)]
    write_corpus: bool,
}

fn main() -> Result<ExitCode> {
    let args = Args::parse();
    if args.write_corpus {
        for (target, name, bytes) in seeds::all() {
            let dir = corpus_of(target);
            fs::create_dir_all(&dir)?;
            fs::write(dir.join(name), bytes)?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let known = |name: &&String| !TARGETS.iter().any(|target| target.name == **name);
    let unknown: Vec<_> = args.targets.iter().filter(known).collect();
    ensure!(unknown.is_empty(), "unknown targets: {unknown:?}");
    let mut found = 0;
    for target in &TARGETS {
        if !args.targets.is_empty() && !args.targets.iter().any(|name| name == target.name) {
            continue;
        }
        let corpus = corpus(target.name)?;
        let mut mutator = Mutator::new(&corpus, args.seed);
        let (begun, before) = (Instant::now(), found);
        for run in 0..args.runs {
            let input = mutator.input();
            if catch_unwind(|| (target.run)(&input)).is_err() {
                fs::create_dir_all(&args.findings)?;
                let path = args
                    .findings
                    .join(format!("{}-{}-{run}", target.name, args.seed));
                fs::write(&path, &input).with_context(|| path.display().to_string())?;
                eprintln!("{}: fails, kept as {}", target.name, path.display());
                found += 1;
            }
        }
        let seconds = begun.elapsed().as_secs_f64();
        println!(
            "{}: {} runs in {seconds:.0} s, {} findings",
            target.name,
            args.runs,
            found - before
        );
    }
    Ok(ExitCode::from(u8::from(found > 0)))
}
