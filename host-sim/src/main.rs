//! `cargo sim …`: recordings in, steps, figures and pictures out.

use std::process::ExitCode;
use std::sync::LazyLock;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use host_sim::commands;

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
    /// Make keys, sign images with them, and show both
    Keys(commands::keys::Args),
    /// Send a signed image to a scanner, and see it confirmed
    Update(commands::update::Args),
    /// Show how long a scan takes and with what
    Timing(commands::timing::Args),
    /// Compare the answers by a mirror that stops at every angle with those by one that turns
    Modes(commands::modes::Args),
    /// Scan recordings with the image itself, in an emulator, and print the steps
    Emulate(commands::emulate::Args),
    /// Watch a scanner at a serial port: side view, status in words, age, a command line
    Live(commands::live::Args),
    /// Check a scanner at a serial port part by part: what is wrong, and what helps
    Doctor(commands::doctor::Args),
    /// Read a scanner's settings as a file with units, set them from one, or compare
    Settings(commands::settings::Args),
    /// Listen on the radar link and write what goes over it as a recording, with the scanner's answers
    Record(commands::record::Args),
    /// Show why a scan came out as it did: scatterers with their roles, the winner and its rivals
    Inspect(commands::inspect::Args),
    /// Write scans as one page for any browser: verdict, side view, range profiles, rivals
    Report(commands::report::Args),
    /// Write the scanner itself, as WebAssembly, with recordings as one page for any browser
    Web(commands::web::Args),
    /// Turn other programs' files into recordings, and recordings into NumPy, CSV or MCAP (ROS 2)
    Convert(commands::convert::Args),
    /// Turn the rules of the estimator off, one at a time, and count what that changes
    Ablate(commands::ablate::Args),
    /// Compare two files of `accuracy --each`, scene by scene
    Compare(commands::compare::Args),
    /// Measure the estimators on random scenes of the simulator: the tables of docs/accuracy.md
    Accuracy(commands::accuracy::Args),
    /// Measure the free distance on guard sweeps of random scenes
    Guard(commands::guard::Args),
    /// Drive a simulated chair through random scenes by the free distance
    Drives(commands::drives::Args),
    /// Measure what is detected of each hazard, with bounds and response times: the data sheet docs/capability.md
    Capability(commands::capability::Args),
    /// Measure the answers to all recordings of a directory against their truth
    Score(commands::score::Args),
    /// Show the strongest echo of a SiRad's captures, through the code that the chip runs
    Sirad(commands::sirad::Args),
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
    Simulate(commands::simulate::Args),
    /// How fast the particles converge, beside the paper's numbers of rounds
    Convergence(commands::convergence::Args),
    /// Scan the paper's stairs A, B and C and compare with its table I
    Table1(commands::table1::Args),
    /// What a scanner is built of: bill of materials, power budget, wiring, lens and mirror
    Hardware(commands::hardware::Args),
    /// Print the crates of the image as CycloneDX, or the tables of docs/supply-chain.md
    Sbom(commands::sbom::Args),
    /// Print the table of reasons: what each does to an answer, and when it is told
    Reasons,
    /// Print what lets a shell complete the program's commands and options
    Completions(commands::help::CompletionsArgs),
    /// Write the manual's pages
    Man(commands::help::ManArgs),
}

/// The program's command with all that `--help` tells.
fn program() -> clap::Command {
    static VERSION: LazyLock<String> =
        LazyLock::new(|| format!("{} ({})", env!("CARGO_PKG_VERSION"), stairscan::REVISION));
    commands::help::complete(Cli::command().version(VERSION.as_str()))
}

fn main() -> ExitCode {
    let parsed = Cli::from_arg_matches(&program().get_matches());
    let done = match parsed.unwrap_or_else(|error| error.exit()).command {
        Command::Replay(args) => commands::replay::run(&args),
        Command::Budget(args) => commands::budget::run(&args),
        Command::Seal(args) => commands::seal::run(&args),
        Command::Keys(args) => commands::keys::run(&args),
        Command::Update(args) => commands::update::run(&args),
        Command::Timing(args) => commands::timing::run(&args),
        Command::Modes(args) => commands::modes::run(&args),
        Command::Emulate(args) => commands::emulate::run(&args),
        Command::Live(args) => commands::live::run(&args),
        Command::Doctor(args) => commands::doctor::run(&args),
        Command::Settings(args) => commands::settings::run(&args),
        Command::Record(args) => commands::record::run(&args),
        Command::Inspect(args) => commands::inspect::run(&args),
        Command::Report(args) => commands::report::run(&args),
        Command::Web(args) => commands::web::run(&args),
        Command::Convert(args) => commands::convert::run(&args),
        Command::Profile(args) => commands::profile::run(&args),
        Command::Ablate(args) => commands::ablate::run(&args),
        Command::Compare(args) => commands::compare::run(&args),
        Command::Accuracy(args) => commands::accuracy::run(&args),
        Command::Guard(args) => commands::guard::run(&args),
        Command::Drives(args) => commands::drives::run(&args),
        Command::Capability(args) => commands::capability::run(&args),
        Command::Calibrate(args) => commands::calibrate::run(&args),
        Command::Faults(args) => commands::faults::run(&args),
        Command::Sirad(args) => commands::sirad::run(&args),
        Command::Soak(args) => commands::soak::run(&args),
        Command::Params(args) => commands::params::run(&args),
        Command::Hardware(args) => commands::hardware::run(&args),
        Command::Sbom(args) => commands::sbom::run(&args),
        Command::Reasons => commands::reasons::run(),
        Command::Fit(args) => commands::fit::run(&args),
        Command::Sequences(args) => commands::sequences::run(&args),
        Command::Score(args) => commands::score::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
        Command::Snr(args) => commands::snr::run(&args),
        Command::Twins => commands::twins::run(),
        Command::Simulate(args) => commands::simulate::run(&args),
        Command::Convergence(args) => commands::convergence::run(&args),
        Command::Table1(args) => commands::table1::run(&args),
        Command::Completions(args) => commands::help::completions(&args, program()),
        Command::Man(args) => commands::help::man(&args, program()),
    };
    match done {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use commands::help::{EXAMPLES, GROUPS};
    use stairscan::verdict::Reason;

    use super::*;

    fn names() -> Vec<String> {
        let command = Cli::command();
        let names = command.get_subcommands().map(|c| c.get_name().to_owned());
        names.collect()
    }

    #[test]
    fn every_command_stands_in_one_group_and_has_examples() {
        let mut listed: Vec<&str> = GROUPS
            .iter()
            .flat_map(|(_, names)| names.iter().copied())
            .collect();
        listed.sort_unstable();
        let mut all = names();
        all.sort_unstable();
        assert_eq!(listed, all, "commands/help.rs: GROUPS");
        for name in &all {
            let count = EXAMPLES
                .iter()
                .filter(|(command, _)| command == name)
                .count();
            assert_eq!(count, 1, "commands/help.rs: EXAMPLES of {name}");
        }
        let help = program().render_long_help().to_string();
        for name in &all {
            let lines = help
                .lines()
                .filter(|line| line.trim_start().starts_with(&format!("{name} ")));
            assert_eq!(lines.count(), 1, "{name} in\n{help}");
        }
    }

    #[test]
    fn every_example_is_what_the_program_takes() {
        for (command, lines) in EXAMPLES {
            assert!(!lines.is_empty(), "{command}");
            for line in *lines {
                let words = std::iter::once("sim").chain(line.split_whitespace());
                assert!(line.starts_with(command), "{line}");
                if let Err(error) = program().try_get_matches_from(words) {
                    panic!("cargo sim {line}: {error}");
                }
            }
        }
    }

    /// Where people read answers, each word that they may read is explained, by the library's one table.
    #[test]
    fn every_reason_is_explained_wherever_answers_are_read() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
        let mut places: Vec<(String, String)> = ["README.md", "controller/stairscan.h"]
            .map(|file| {
                (
                    file.to_owned(),
                    std::fs::read_to_string(format!("{root}/{file}")).unwrap(),
                )
            })
            .to_vec();
        for name in ["replay", "emulate", "inspect", "report", "convert"] {
            let mut whole = program();
            let command = whole.find_subcommand_mut(name).unwrap();
            places.push((
                format!("{name} --help"),
                command.render_long_help().to_string(),
            ));
        }
        for (place, text) in &places {
            // However lines are broken.
            let text: Vec<&str> = text.split_whitespace().collect();
            let text = text.join(" ");
            for reason in Reason::ALL {
                let (word, meaning) = (reason.as_str(), reason.meaning());
                assert!(text.contains(word), "{place}: {word}");
                assert!(text.contains(meaning), "{place}: {word}: {meaning}");
            }
        }
    }

    #[test]
    fn the_version_has_its_revision() {
        let version = program().render_version();
        assert!(version.contains(stairscan::REVISION), "{version}");
    }

    #[test]
    fn completions_and_manual_know_every_command() {
        let mut script = Vec::new();
        clap_complete::generate(
            clap_complete::Shell::Bash,
            &mut program(),
            "host-sim",
            &mut script,
        );
        let script = String::from_utf8(script).unwrap();
        for name in names() {
            assert!(script.contains(&name), "{name}");
        }
    }
}
