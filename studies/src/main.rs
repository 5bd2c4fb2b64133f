//! `cargo study …`: what the makers measure, fit and print.

// `emit` and `note!` end or go on where stdout or stderr is closed; the macros would panic.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

use std::process::ExitCode;

use clap::{FromArgMatches, Parser, Subcommand};
use host_sim::commands::help;
use host_sim::console::exit;
use studies::commands;
use studies::help::STUDY;

#[derive(Parser)]
#[command(
    name = "study",
    bin_name = "cargo study",
    version,
    about = "Studies of the stair scanner: accuracy, faults, tuned numbers, budgets"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Check flash, RAM, stack and symbols of the image against its budgets
    Budget(commands::budget::Args),
    /// Turn the rules of the estimator off, one at a time, and count the changed answers
    Ablate(commands::ablate::Args),
    /// Count the top edges and the ground that the coherent image shows, on recordings with ground truth
    Coherent(commands::coherent::Args),
    /// Compare two files of `accuracy --each`, scene by scene
    Compare(commands::compare::Args),
    /// Measure the estimators on random scenes of the simulator: the tables of docs/generated/accuracy.md
    Accuracy(commands::accuracy::Args),
    /// Measure the free distance on guard sweeps of random scenes
    Guard(commands::guard::Args),
    /// Drive a simulated chair through random scenes by the free distance
    Drives(commands::drives::Args),
    /// Measure the detection of each hazard, with bounds and response times: the data sheet docs/generated/capability.md
    Capability(commands::capability::Args),
    /// Apply every fault of the instrument to recordings and count the outcomes
    Faults(commands::faults::Args),
    /// Move one property out of the usual draw and compare the answers with those as drawn
    Shift(commands::shift::Args),
    /// Run one scanner over thousands of scans and compare each answer with a new scanner's, or over days of simulated
    /// time
    Soak(commands::soak::Args),
    /// Print every tuned number, and the effect of changing it by a fifth
    Params(commands::params::Args),
    /// Fit the verdict's hazards to simulated scans and write the firmware's table
    Fit(commands::fit::Args),
    /// Measure how answers improve from scan to scan; --fit fits the parameters of carrying evidence
    Sequences(commands::sequences::Args),
    /// Count the instructions of every stage in the emulator, with budgets and other libraries' figures
    Bench(commands::bench::Args),
    /// Measure the fixed-point transform's signal-to-error ratio over the input's level
    Snr(commands::snr::Args),
    /// Check in the emulator that instructions and their portable definitions give the same bits
    Twins,
    /// Scan the paper's stairs A, B and C and compare with its table I
    Table1(commands::table1::Args),
    /// Print the hardware of a scanner: bill of materials, power budget, wiring, lens and mirror
    Hardware(commands::hardware::Args),
    /// Print the crates of the image as CycloneDX, or the tables of docs/generated/supply-chain.md
    Sbom(commands::sbom::Args),
    /// Print the table of reasons: effect and condition of each
    Reasons,
}

/// Returns the program's command with all help texts.
fn program() -> clap::Command {
    help::program::<Cli>(&STUDY)
}

fn main() -> ExitCode {
    let parsed = Cli::from_arg_matches(&program().get_matches());
    exit(match parsed.unwrap_or_else(|error| error.exit()).command {
        Command::Budget(args) => commands::budget::run(&args),
        Command::Ablate(args) => commands::ablate::run(&args),
        Command::Coherent(args) => commands::coherent::run(&args),
        Command::Compare(args) => commands::compare::run(&args),
        Command::Accuracy(args) => commands::accuracy::run(&args),
        Command::Guard(args) => commands::guard::run(&args),
        Command::Drives(args) => commands::drives::run(&args),
        Command::Capability(args) => commands::capability::run(&args),
        Command::Faults(args) => commands::faults::run(&args),
        Command::Shift(args) => commands::shift::run(&args),
        Command::Soak(args) => commands::soak::run(&args),
        Command::Params(args) => commands::params::run(&args),
        Command::Hardware(args) => commands::hardware::run(&args),
        Command::Sbom(args) => commands::sbom::run(&args),
        Command::Reasons => commands::reasons::run(),
        Command::Fit(args) => commands::fit::run(&args),
        Command::Sequences(args) => commands::sequences::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
        Command::Snr(args) => commands::snr::run(&args),
        Command::Twins => commands::twins::run(),
        Command::Table1(args) => commands::table1::run(&args),
    })
}

#[cfg(test)]
#[path = "../../host-sim/tests/suite/common/shared_documents.rs"]
mod shared_documents;

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn every_command_of_a_document_is_what_the_program_takes() {
        let commands = shared_documents::commands_of("study");
        assert!(commands.len() > 5, "{commands:?}");
        for words in commands {
            let all = ["study"]
                .into_iter()
                .chain(words.iter().map(String::as_str));
            if let Err(error) = program().try_get_matches_from(all) {
                panic!("cargo study {}: {error}", words.join(" "));
            }
        }
    }

    /// Beginnings of commands in running text that are not checked, and what in them is no argument.
    const NOT_CHECKED: &[(&str, &str)] = &[
        ("COMMAND ", "a placeholder of the command"),
        ("ablate RULE", "a placeholder of the rule"),
    ];

    #[test]
    fn every_command_in_running_text_is_what_the_program_takes() {
        let count = shared_documents::check_inline(&program(), &["cargo study"], NOT_CHECKED);
        assert!(count > 30, "only {count}");
    }

    #[test]
    fn every_command_stands_in_one_group_and_has_examples_that_parse() {
        let command = Cli::command();
        let mut names: Vec<&str> = command
            .get_subcommands()
            .map(clap::Command::get_name)
            .collect();
        names.sort_unstable();
        let groups = STUDY.groups.iter().flat_map(|(_, names)| *names);
        let mut listed: Vec<&str> = groups.copied().collect();
        listed.sort_unstable();
        assert_eq!(listed, names, "help.rs: groups");
        for name in names {
            let count = STUDY.examples_of(name).count();
            assert!(count > 0, "examples.txt: {name}");
        }
        for line in STUDY.examples.lines() {
            let words = std::iter::once("study").chain(line.split_whitespace());
            if let Err(error) = program().try_get_matches_from(words) {
                panic!("cargo study {line}: {error}");
            }
        }
    }
}
