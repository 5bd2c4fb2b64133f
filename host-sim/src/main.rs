//! `cargo sim …`: recordings in, steps, figures and pictures out.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use host_sim::commands;
use host_sim::scene::command::{SimulateArgs, simulate};

#[derive(Parser)]
#[command(
    name = "sim",
    bin_name = "cargo sim",
    version,
    about = "The stair scanner on the host"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Scan recordings with the scanner's own loop and print the steps
    Replay(commands::replay::Args),
    /// Show the range profile of one chirp with its CFAR threshold and detections
    Profile(commands::profile::Args),
    /// Check flash, RAM, stack and symbols of the image against its budgets
    Budget(commands::budget::Args),
    /// Put the checksum into an image by which it knows at boot that it is whole
    Seal(commands::seal::Args),
    /// Show how long a scan takes and with what
    Timing(commands::timing::Args),
    /// Scan recordings with the image itself, in an emulator, and print the steps
    Emulate(commands::emulate::Args),
    /// Watch a scanner at a serial port: side view, status in words, age, a command line
    Live(commands::live::Args),
    /// Listen on the radar link and write what goes over it as a recording, with the scanner's answers
    Record(commands::record::Args),
    /// Show why a scan came out as it did: scatterers with their roles, the winner and its rivals
    Inspect(commands::inspect::Args),
    /// Write scans as one page for any browser: verdict, side view, range profiles, rivals
    Report(commands::report::Args),
    /// Measure the estimators on random scenes of the simulator: the tables of docs/accuracy.md
    Accuracy(commands::accuracy::Args),
    /// Measure the answers to all recordings of a directory against their truth
    Score(commands::score::Args),
    /// Tell how the scanner is mounted, from a scan of a floor and a wall at a measured distance
    Calibrate(commands::calibrate::Args),
    /// Put every fault of the instrument on recordings and count what the answers make of it
    Faults(commands::faults::Args),
    /// Let one scanner scan thousands of times, each answer held against a fresh scanner's
    Soak(commands::soak::Args),
    /// Print every tuned number, and what a fifth more or less of it does
    Params(commands::params::Args),
    /// Count the verdict's hazards from simulated scans and write the firmware's table
    Fit(commands::fit::Args),
    /// How answers better from scan to scan while the chair moves; --fit counts what one scan's word
    /// counts in the next one
    Sequences(commands::sequences::Args),
    /// Count the instructions of every stage in the emulator, beside its peers and budgets
    Bench(commands::bench::Args),
    /// Measure the fixed-point transform's signal-to-error ratio over the input's level
    Snr(commands::snr::Args),
    /// Check in the emulator that instructions and their portable definitions give the same bits
    Twins,
    /// Scan a scene file with the simulated radar and write the recording
    Simulate(SimulateArgs),
    /// How fast the particles converge, beside the paper's numbers of rounds
    Convergence(commands::convergence::Args),
    /// Scan the paper's stairs A, B and C and compare with its table I
    Table1(commands::table1::Args),
}

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Replay(args) => commands::replay::run(&args),
        Command::Budget(args) => commands::budget::run(&args),
        Command::Seal(args) => commands::seal::run(&args),
        Command::Timing(args) => commands::timing::run(&args),
        Command::Emulate(args) => commands::emulate::run(&args),
        Command::Live(args) => commands::live::run(&args),
        Command::Record(args) => commands::record::run(&args),
        Command::Inspect(args) => commands::inspect::run(&args),
        Command::Report(args) => commands::report::run(&args),
        Command::Profile(args) => commands::profile::run(&args),
        Command::Accuracy(args) => commands::accuracy::run(&args),
        Command::Calibrate(args) => commands::calibrate::run(&args),
        Command::Faults(args) => commands::faults::run(&args),
        Command::Soak(args) => commands::soak::run(&args),
        Command::Params(args) => commands::params::run(&args),
        Command::Fit(args) => commands::fit::run(&args),
        Command::Sequences(args) => commands::sequences::run(&args),
        Command::Score(args) => commands::score::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
        Command::Snr(args) => commands::snr::run(&args),
        Command::Twins => commands::twins::run(),
        Command::Simulate(args) => simulate(&args).map(|()| ExitCode::SUCCESS),
        Command::Convergence(args) => commands::convergence::run(&args),
        Command::Table1(args) => commands::table1::run(&args),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
