//! Compares the controller's C parser with the scanner's own, and writes the files that are generated from the
//! scanner's tables.
//!
//! `cargo run --release -p stairscan-fuzz --example controller -- --lines 1000000`

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Parser;
use stairscan_fuzz::controller::{page, program, tables, vectors};

#[derive(Parser)]
struct Args {
    /// So many mutated lines
    #[arg(long, default_value_t = 100_000)]
    lines: usize,
    /// Seed of the first mutation
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where the C program is compiled to
    #[arg(long, default_value = "target/controller")]
    directory: PathBuf,
    /// Compile without the address and undefined-behaviour sanitizers, where the compiler has none
    #[arg(long)]
    plain: bool,
    /// Write the tables of the C header, the golden vectors and the printed parts of docs/user/controller.md anew, and
    /// compare nothing
    #[arg(long)]
    write: bool,
}

fn main() -> Result<()> {
    let args = Args::parse();
    if args.write {
        let header = fs::read_to_string(tables::path())?;
        fs::write(tables::path(), tables::renewed(&header)?)?;
        fs::write(vectors::path(), vectors::text())?;
    }
    let compiler = program::compiler().context("no C compiler: install one, or name it in CC")?;
    fs::create_dir_all(&args.directory)?;
    let directory = args.directory.canonicalize()?;
    if args.write {
        let example = program::compile(&compiler, "speed_limit.c", &directory, !args.plain)?;
        let held = fs::read_to_string(page::path())?;
        let made = page::renewed(&held, |arguments| program::printed(&example, arguments))?;
        fs::write(page::path(), made)?;
        return Ok(());
    }
    let verdict = program::compile(&compiler, "test/verdict.c", &directory, !args.plain)?;
    let begun = Instant::now();
    let tally = program::agree(&verdict, args.lines, args.seed)?;
    for (kind, count) in &tally {
        println!("{count:>9}  {kind}");
    }
    let seconds = begun.elapsed().as_secs_f64();
    println!("{} lines: C and Rust agree ({seconds:.0} s)", args.lines);
    Ok(())
}
