//! Help texts in addition to each command's own arguments: the commands in groups, examples, and the
//! meanings of the report's reasons. Completions and manual pages are generated from the same command.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::LazyLock;

use anyhow::{Context, Result, ensure};
use clap::{Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use stairscan::verdict::Reason;

use super::emit;
use crate::output::Overwrite;

/// Name of the installed program; `cargo sim` is an alias for it within the repository.
const PROGRAM: &str = "host-sim";

/// Texts of a program's help.
#[derive(Clone, Copy, Debug)]
pub struct Texts {
    /// The program's name on the command line, in this repository an alias of cargo.
    pub program: &'static str,
    /// Commands by purpose.
    pub groups: &'static [(&'static str, &'static [&'static str])],
    /// Examples, one a line: the arguments behind the program's name, of which the first is the command.
    pub examples: &'static str,
}

impl Texts {
    /// Returns the examples of a command.
    pub fn examples_of(&self, name: &str) -> impl Iterator<Item = &'static str> {
        let own = move |line: &&str| line.split(' ').next() == Some(name);
        self.examples.lines().filter(own)
    }
}

/// Texts of `cargo sim`.
pub const SIM: Texts = Texts {
    program: "cargo sim",
    groups: GROUPS,
    examples: include_str!("examples.txt"),
};

/// The commands of `cargo sim` by purpose, in the order of the list.
pub const GROUPS: &[(&str, &[&str])] = &[
    ("Scan", &["replay", "simulate", "emulate", "calibrate"]),
    (
        "Watch a scanner",
        &["live", "doctor", "settings", "record", "update", "crash"],
    ),
    (
        "Inspect scans",
        &[
            "report", "web", "inspect", "profile", "convert", "sirad", "score",
        ],
    ),
    ("The image", &["timing", "seal", "image", "keys", "module"]),
    ("This program", &["completions", "man"]),
];

/// The commands whose `--help` also lists the report's reasons.
const WITH_REASONS: &[&str] = &["replay", "emulate", "inspect", "report"];

/// Arguments of `completions`.
#[derive(clap::Args, Debug)]
pub struct CompletionsArgs {
    /// Shell that reads the completions
    #[arg(value_enum)]
    shell: Shell,
}

/// Arguments of `man`.
#[derive(clap::Args, Debug)]
pub struct ManArgs {
    /// Directory for the pages; created if missing
    dir: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Returns the command of a program with its version, revision and all help texts.
pub fn program<C: CommandFactory>(texts: &Texts) -> Command {
    static VERSION: LazyLock<String> =
        LazyLock::new(|| format!("{} ({})", env!("CARGO_PKG_VERSION"), stairscan::REVISION));
    complete(C::command().version(VERSION.as_str()), texts)
}

/// Adds the list in groups to the program's command, and examples to each subcommand.
fn complete(command: Command, texts: &Texts) -> Command {
    let list = listed(&command, texts);
    let names: Vec<String> = (command.get_subcommands())
        .map(|c| c.get_name().to_owned())
        .collect();
    let whole = command
        .help_template(
            "{about-with-newline}\n{usage-heading} {usage}{after-help}\n\nOptions:\n{options}",
        )
        .after_help(list);
    names.iter().fold(whole, |whole, name| {
        whole.mut_subcommand(name, |c| {
            // The command's own text follows its examples.
            let own = c.get_after_help().map(|own| format!("\n\n{own}"));
            let examples = examples(name, texts) + &own.unwrap_or_default();
            // Without a longer text `--help` prints what `-h` prints, an option a line.
            match WITH_REASONS.contains(&name.as_str()) {
                true => c.after_long_help(format!("{examples}\n\n{}", reasons())),
                false => c,
            }
            .after_help(examples)
        })
    })
}

/// Returns the commands in their groups, each with its own first sentence.
fn listed(command: &Command, texts: &Texts) -> String {
    let mut text = String::new();
    for (title, names) in texts.groups {
        let _ = writeln!(text, "{title}:");
        for name in *names {
            let known = command.find_subcommand(name);
            let about = known.and_then(Command::get_about).map(ToString::to_string);
            let _ = writeln!(text, "  {name:<12} {}", about.unwrap_or_default());
        }
        text.push('\n');
    }
    let _ = write!(
        text,
        "`{} COMMAND --help` shows the options of a command, with examples.",
        texts.program
    );
    text
}

fn examples(name: &str, texts: &Texts) -> String {
    let mut text = "Examples:".to_owned();
    for line in texts.examples_of(name) {
        let _ = write!(text, "\n  {} {line}", texts.program);
    }
    text
}

/// Returns every reason with its meaning, as text.
pub fn reasons() -> String {
    let mut text = "Reasons that accompany a status:".to_owned();
    for reason in Reason::ALL {
        let _ = write!(text, "\n  {:<17} {}", reason.as_str(), reason.meaning());
    }
    text
}

/// Prints a shell's completions.
pub fn completions(args: &CompletionsArgs, mut command: Command) -> Result<ExitCode> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, PROGRAM, &mut text);
    emit(&String::from_utf8(text).context("completions")?);
    Ok(ExitCode::SUCCESS)
}

/// Writes the manual pages: one of the program, one of each command.
pub fn man(args: &ManArgs, command: Command) -> Result<ExitCode> {
    let dir = &args.dir;
    let mut command = command
        .name(PROGRAM)
        .bin_name(PROGRAM)
        .disable_help_subcommand(true);
    command.build();
    let mut pages = vec![(PROGRAM.to_owned(), command.clone())];
    for part in command.get_subcommands() {
        let name = format!("{PROGRAM}-{}", part.get_name());
        pages.push((name.clone(), part.clone().display_name(name)));
    }
    ensure!(pages.len() > 1, "the program has no commands");
    let count = pages.len();
    let mut files = Vec::new();
    for (name, part) in pages {
        let mut text = Vec::new();
        Man::new(part).render(&mut text)?;
        // The examples use the alias of the repository.
        let text = String::from_utf8(text)?.replace("cargo sim", PROGRAM);
        files.push((format!("{name}.1"), text.into_bytes()));
    }
    let outputs = args.overwrite.reading::<&PathBuf>([]);
    outputs.write_folder(dir, &files)?;
    let first = dir.join(format!("{PROGRAM}.1"));
    emit(&format!(
        "{count} pages in {}: man {}\n",
        dir.display(),
        first.display()
    ));
    Ok(ExitCode::SUCCESS)
}
