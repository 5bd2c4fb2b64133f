//! `cargo sim …`: the program on the host, from recordings to steps, figures and drawings.

// `emit` and `note!` end or go on where stdout or stderr is closed; the macros would panic.
#![cfg_attr(not(test), warn(clippy::print_stderr, clippy::print_stdout))]

use std::process::ExitCode;

use clap::{FromArgMatches, Parser, Subcommand};
use host_sim::commands;
use host_sim::commands::help::{self, SIM};
use host_sim::console::exit;

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
    /// Add the checksum with which an image verifies itself at boot
    Seal(commands::seal::Args),
    /// Write boot loader and image as Intel HEX and raw bytes, for programs that write flash
    Image(commands::image::Args),
    /// Make keys, sign images with them, and show both
    Keys(commands::keys::Args),
    /// Send a signed image to a scanner, and see it confirmed
    Update(commands::update::Args),
    /// Find file and line of a crash that a scanner has reported
    Crash(commands::crash::Args),
    /// Show the duration of a scan by parts
    Timing(commands::timing::Args),
    /// Scan recordings with the image itself, in an emulator, and print the steps
    Emulate(commands::emulate::Args),
    /// Play a recording as the radar module of the link, on standard input and output
    Module(commands::module::Args),
    /// Show a scanner at a serial port: side view, status in words, age, a command line
    Live(commands::live::Args),
    /// Check a scanner at a serial port part by part, with remedies
    Doctor(commands::doctor::Args),
    /// Read a scanner's settings as a file with units, set them from one, or compare
    Settings(commands::settings::Args),
    /// Record the traffic of the radar link, with the scanner's answers
    Record(commands::record::Args),
    /// Show how an answer was found: scatterers with their roles, the best hypothesis and its runners-up
    Inspect(commands::inspect::Args),
    /// Write scans as one page for any browser: status, side view, range profiles, runners-up
    Report(commands::report::Args),
    /// Write the scanner itself, as WebAssembly, with recordings as one page for any browser
    Web(commands::web::Args),
    /// Convert other programs' files into recordings, and recordings into NumPy, CSV or MCAP (ROS 2)
    Convert(commands::convert::Args),
    /// Measure the answers to all recordings of a directory against their ground truth
    Score(commands::score::Args),
    /// Show the strongest echo of a SiRad's captures, through the code that the chip runs
    Sirad(commands::sirad::Args),
    /// Estimate the mounting from a scan of the ground and a wall at a measured distance
    Calibrate(commands::calibrate::Args),
    /// Scan a scene file with the simulated radar and write the recording
    Simulate(commands::simulate::Args),
    /// Print shell completions
    Completions(commands::help::CompletionsArgs),
    /// Write the manual's pages
    Man(commands::help::ManArgs),
}

/// Returns the program's command with all help texts.
fn program() -> clap::Command {
    help::program::<Cli>(&SIM)
}

fn main() -> ExitCode {
    let parsed = Cli::from_arg_matches(&program().get_matches());
    exit(match parsed.unwrap_or_else(|error| error.exit()).command {
        Command::Replay(args) => commands::replay::run(&args),
        Command::Seal(args) => commands::seal::run(&args),
        Command::Image(args) => commands::image::run(&args),
        Command::Keys(args) => commands::keys::run(&args),
        Command::Update(args) => commands::update::run(&args),
        Command::Crash(args) => commands::crash::run(&args),
        Command::Timing(args) => commands::timing::run(&args),
        Command::Emulate(args) => commands::emulate::run(&args),
        Command::Module(args) => commands::module::run(&args),
        Command::Live(args) => commands::live::run(&args),
        Command::Doctor(args) => commands::doctor::run(&args),
        Command::Settings(args) => commands::settings::run(&args),
        Command::Record(args) => commands::record::run(&args),
        Command::Inspect(args) => commands::inspect::run(&args),
        Command::Report(args) => commands::report::run(&args),
        Command::Web(args) => commands::web::run(&args),
        Command::Convert(args) => commands::convert::run(&args),
        Command::Profile(args) => commands::profile::run(&args),
        Command::Calibrate(args) => commands::calibrate::run(&args),
        Command::Sirad(args) => commands::sirad::run(&args),
        Command::Score(args) => commands::score::run(&args),
        Command::Simulate(args) => commands::simulate::run(&args),
        Command::Completions(args) => commands::help::completions(&args, program()),
        Command::Man(args) => commands::help::man(&args, program()),
    })
}

#[cfg(test)]
#[path = "../tests/suite/common/shared_documents.rs"]
mod shared_documents;

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use commands::help::GROUPS;
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
            let count = SIM.examples_of(name).count();
            assert!(count > 0, "commands/examples.txt: {name}");
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
        for line in SIM.examples.lines() {
            let words = std::iter::once("sim").chain(line.split_whitespace());
            if let Err(error) = program().try_get_matches_from(words) {
                panic!("cargo sim {line}: {error}");
            }
        }
    }

    #[test]
    fn every_command_of_a_document_is_what_the_program_takes() {
        let commands = shared_documents::commands_of("sim");
        assert!(commands.len() > 40, "{commands:?}");
        for words in commands {
            let all = ["sim"].into_iter().chain(words.iter().map(String::as_str));
            if let Err(error) = program().try_get_matches_from(all) {
                panic!("cargo sim {}: {error}", words.join(" "));
            }
        }
    }

    /// Beginnings of commands in running text that are not checked, and what in them is no argument.
    const NOT_CHECKED: &[(&str, &str)] = &[
        ("COMMAND ", "a placeholder of the command"),
        ("emulate --fault …", "an elided value"),
        (
            "replay REC --motion-fault FAULT",
            "a placeholder of the value",
        ),
        ("simulate random:KIND ", "placeholders of numbers"),
        ("timing [KEY=VALUE…]", "a placeholder of settings"),
    ];

    #[test]
    fn every_command_in_running_text_is_what_the_program_takes() {
        let names = ["cargo sim", "host-sim"];
        let count = shared_documents::check_inline(&program(), &names, NOT_CHECKED);
        assert!(count > 50, "only {count}");
    }

    #[test]
    fn a_wrong_command_in_running_text_is_found() {
        let document = "See `x` and `cargo sim replay\n--no-such REC`, `cargo sim no-such`; `cargo sim live`.\n\n\
            ```sh\ncargo sim fenced\n```\n\nAn odd ` here.\n\n| `cargo sim inspect REC \\| wc` |\n";
        let found = shared_documents::inline_commands(document, "cargo sim");
        assert_eq!(
            found,
            ["replay --no-such REC", "no-such", "live", "inspect REC"]
        );
        let refused = |words: &str| shared_documents::refusal(&program(), words).is_some();
        let refused: Vec<bool> = found.iter().map(|words| refused(words)).collect();
        assert_eq!(refused, [true, true, false, false]);
    }

    /// Every text in which users read answers contains all reasons with their meanings, from the library's table.
    #[test]
    fn every_reason_is_explained_wherever_answers_are_read() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
        let mut places: Vec<(String, String)> = ["docs/reasons.md", "controller/stairscan.h"]
            .map(|file| {
                (
                    file.to_owned(),
                    std::fs::read_to_string(format!("{root}/{file}")).unwrap(),
                )
            })
            .to_vec();
        for name in ["replay", "emulate", "inspect", "report"] {
            let mut whole = program();
            let command = whole.find_subcommand_mut(name).unwrap();
            places.push((
                format!("{name} --help"),
                command.render_long_help().to_string(),
            ));
        }
        for (place, text) in &places {
            // Independent of line breaks.
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
