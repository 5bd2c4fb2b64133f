//! Prints the answers to recordings as `cargo sim replay --format json` does, without the rest of that program: what an
//! experiment on the estimator builds (CONTRIBUTING, How to run an experiment).
//!
//!     cargo run --profile quick -p stairscan-replay --example answers -- replay recordings/stair_a [--single]

use std::path::Path;
use std::process::ExitCode;

use anyhow::Result;
use stairscan_replay::recording::Recording;
use stairscan_replay::replay::{self, Options};
use stairscan_replay::setup::{self, Kind};

/// Prints a line for each answer. Returns whether none is a fault.
fn print(path: &Path, options: &Options) -> Result<bool> {
    let recording = Recording::read(path)?;
    let mut good = true;
    if setup::kind(&recording)? == Kind::Guard {
        for answer in replay::guarded(&recording, options)? {
            println!("{}", answer.json());
            good &= !answer.is_fault();
        }
        return Ok(good);
    }
    for answer in replay::answers(&recording, options, |_| ())? {
        println!("{}", answer.json());
        good &= !answer.is_fault();
    }
    Ok(good)
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    // Takes the arguments of `cargo sim replay`, so that scripts can call either.
    let options = Options {
        single: words.iter().any(|word| word == "--single"),
        ..Options::default()
    };
    let recordings = words
        .iter()
        .filter(|word| !word.starts_with("--") && !["replay", "json"].contains(&word.as_str()));
    let mut code = ExitCode::SUCCESS;
    for recording in recordings {
        match print(Path::new(recording), &options) {
            Ok(true) => {}
            Ok(false) => code = ExitCode::FAILURE,
            Err(error) => {
                eprintln!("error: {error:#}");
                code = ExitCode::FAILURE;
            }
        }
    }
    code
}
