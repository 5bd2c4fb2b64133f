//! The program `host-sim`, by alias `cargo sim`.

use clap::{Parser, Subcommand};
use host_sim::scene::command::{SimulateArgs, simulate};

/// The stair scanner's other side.
#[derive(Parser)]
#[command(name = "host-sim", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Scans a scene file with the simulated radar and writes the recording.
    Simulate(SimulateArgs),
}

fn main() {
    let Command::Simulate(args) = Cli::parse().command;
    if let Err(error) = simulate(&args) {
        eprintln!("{error:#}");
        std::process::exit(1);
    }
}
