//! `soak`: runs one scanner over thousands of scans and compares each answer with a new scanner's, or over days of
//! simulated time and checks all that it reports.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::Result;

use super::{emit, progress};
use crate::soak::{Tally, days, soak};

/// Maximum growth of the peak memory from the first half of the scans to the second, bytes: the allocator keeps memory
/// of the largest recording.
const GROWTH: u64 = 32 << 20;
/// Maximum number of differing scans that are listed.
const NAMED: usize = 10;

/// Arguments of `soak`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Number of scans
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    scans: u64,
    /// Instead of scans: days of simulated time, with the clock's wraps, resets, saves and faults
    #[arg(long, value_name = "N", conflicts_with = "scans", value_parser = clap::value_parser!(u32).range(1..=1_000))]
    days: Option<u32>,
    /// Seed of scenes, faults and commands
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Runs the endurance test and prints the result; exit status 1 if an answer differs from a new scanner's, memory
/// grows, or a check of the days fails.
pub fn run(args: &Args) -> Result<ExitCode> {
    if let Some(days) = args.days {
        return run_days(days, args.seed);
    }
    let bar = progress(args.scans);
    let tally = soak(args.scans, args.seed, |scans| bar.set_position(scans))?;
    bar.finish_and_clear();
    emit(&text(&tally));
    let [early, late] = tally.memory;
    let grown = late > early + GROWTH;
    if grown {
        host_sim::note!("error: memory grows by more than {} MiB", GROWTH >> 20);
    }
    for line in tally.differing.iter().take(NAMED) {
        host_sim::note!("error: {line}");
    }
    Ok(ExitCode::from(u8::from(
        grown || !tally.differing.is_empty(),
    )))
}

fn run_days(days: u32, seed: u64) -> Result<ExitCode> {
    let bar = progress(days.into());
    let summary = days::days(days.into(), seed, |day| bar.set_position(day));
    bar.finish_and_clear();
    emit(&summary.table());
    for line in summary.failures.iter().take(NAMED) {
        host_sim::note!("error: {line}");
    }
    Ok(ExitCode::from(u8::from(!summary.failures.is_empty())))
}

fn text(tally: &Tally) -> String {
    let [ok, degraded, fault] = tally.statuses;
    let mut out = format!(
        "{} scans, {} of them of recordings with a fault of the instrument: {ok} ok, {degraded} degraded, \
         {fault} fault; {} ended by module or motor, {} with lost rows, {} visits ended within a scan; {} lines \
         typed\n{} scans differ from those of a fresh scanner\n",
        tally.scans,
        tally.faulty,
        tally.ended,
        tally.lossy,
        tally.stopped,
        tally.typed,
        tally.differing.len()
    );
    let _ = match tally.memory {
        [early, late] if early > 0 => writeln!(
            out,
            "resident memory: {:.1} MiB at most in the first half, {:.1} MiB in the second",
            early as f64 / f64::from(1 << 20),
            late as f64 / f64::from(1 << 20)
        ),
        _ => writeln!(out, "resident memory: not available on this system"),
    };
    out
}
