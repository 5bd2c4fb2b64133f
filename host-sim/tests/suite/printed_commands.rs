//! Runs the commands that documents print, as printed and in their order, each document in a directory of its own that
//! looks like the repository. Whether the program takes the arguments of all others is a test of its `main.rs`.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

use rayon::prelude::*;

use crate::common::Scratch;
use crate::common::shared_documents::{commands, instructions, root};

/// Beginnings of commands that this test does not run, and why.
const NOT_RUN: &[(&str, &str)] = &[
    ("./check", "runs this test"),
    ("bash .ci/run", "40 minutes; runs this test"),
    (
        "bash .ci/reproducible",
        "builds the image twice; by hand before a release",
    ),
    (
        "STAIRSCAN_UPDATE_KEY=maker.pub ./dist",
        "half an hour; by hand before a release",
    ),
    (
        "ADVISORIES=required bash .ci/run",
        "40 minutes; runs this test",
    ),
    ("chip/check", "minutes; a step of .ci/run"),
    ("VERBOSE=1 chip/check", "as chip/check"),
    (
        "cargo study",
        "minutes to hours; studies/src/main.rs checks its arguments",
    ),
    (
        "sh docs/make",
        "minutes to hours; what it writes is compared by documents.rs",
    ),
    ("APPROVE=1 cargo test", "writes approved texts anew"),
    (
        "cargo run --release -p stairscan-fuzz",
        "minutes; a shorter run is a step of .ci/run",
    ),
    ("cargo install", "downloads and builds a program"),
    (
        "RUSTC_BOOTSTRAP=1 cargo fuzz",
        "needs cargo-fuzz; ten minutes",
    ),
    ("cargo build", "builds; a step of .ci/run"),
    ("pytest", "a step of .ci/run"),
    (
        "cargo sim simulate scenes/$scene.toml",
        "a loop; committed_recordings.rs compares what it writes",
    ),
    ("git clone", "downloads"),
    ("python3 -m venv", "downloads; as a step of .ci/run does"),
    ("pip install", "downloads; a step of .ci/run"),
    (
        "jupyter",
        "a server; python/tests/test_notebook.py runs the notebook",
    ),
    (
        "diff src/params",
        "compares what a fit of hours has written",
    ),
    ("cargo board", "a board with a probe"),
    (
        "STAIRSCAN_UPDATE_KEY=maker.pub cargo board",
        "a board with a probe",
    ),
    (
        "cargo sim image",
        "builds the image; its files: update/files.rs",
    ),
    (
        "cargo sim keys sign",
        "builds the image; update.rs signs and sends one",
    ),
    (
        "cargo sim report sessions",
        "a log of a scanner; logs.rs writes and reads one",
    ),
    (
        "cargo sim replay --log session.log",
        "a log of a scanner; logs.rs writes and reads one",
    ),
    (
        "cargo sim convert session.log",
        "a log of a scanner; logs.rs writes and reads one",
    ),
    ("dfu-util", "a board"),
    ("openocd", "a board with a probe"),
    ("gdb-multiarch", "a board with a probe"),
    ("STM32_Programmer_CLI", "a board with a probe"),
    ("probe-rs", "a board with a probe"),
    (
        "cargo sim live",
        "a port, or until it is ended: live.rs, demo.rs",
    ),
    ("cargo sim doctor", "a port: doctor.rs"),
    ("cargo sim settings", "a port: settings.rs"),
    ("cargo sim record /dev/", "ports: tap/"),
    ("cargo sim update", "a port: update.rs"),
    ("cargo sim emulate", "the emulator, a minute: firmware.rs"),
    ("cargo sim web", "builds WebAssembly: a step of .ci/run"),
    (
        "cargo sim sirad /tmp/sirad",
        "a download: sirad.rs has captures of its own",
    ),
    (
        "cargo sim seal ONE",
        "two builds of the image: .ci/reproducible",
    ),
    (
        "cargo sim convert radar.npy",
        "an array of real samples: real.rs",
    ),
    (
        "cargo sim convert chirps.npy --real",
        "an array of real samples: real.rs",
    ),
    ("export ROS_DOMAIN_ID", "ROS 2"),
    ("ros2 ", "ROS 2: host-sim/tests/ros2.py"),
];

/// Recordings and files that documents take for the reader's own, by name: made from those of the repository.
const READERS: &[(&str, &str)] = &[
    ("A", "convert recordings/stair_a -o A"),
    ("B", "convert recordings/stair_b -o B"),
    ("chirps.npy", "convert recordings/stair_a -o chirps.npy"),
    ("mine.npy", "convert recordings/stair_a -o mine.npy"),
];

fn reason(command: &str) -> Option<&'static str> {
    let mut rows = NOT_RUN.iter();
    Some(rows.find(|(begin, _)| command.starts_with(begin))?.1)
}

/// Runs a line of shell in `dir`, where `cargo sim` is the tested program. Returns its messages if it fails.
fn run(dir: &Path, line: &str) -> Result<(), String> {
    let path = format!(
        "{}:{}",
        dir.join("bin").display(),
        std::env::var("PATH").unwrap()
    );
    let mut shell = Command::new("sh");
    let output = shell
        .args(["-ec", line])
        .current_dir(dir)
        .env("PATH", path)
        .output();
    let output = output.unwrap();
    match output.status.success() {
        true => Ok(()),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

/// Fills a directory with what the repository holds and what a reader has for these commands.
fn furnish(dir: &Path, lines: &[String]) {
    for entry in fs::read_dir(root()).unwrap() {
        let entry = entry.unwrap();
        if entry.file_name() != "target" {
            symlink(
                entry.path().canonicalize().unwrap(),
                dir.join(entry.file_name()),
            )
            .unwrap();
        }
    }
    fs::create_dir(dir.join("bin")).unwrap();
    let cargo = dir.join("bin/cargo");
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = sim ] || exit 9\nshift\nexec '{}' \"$@\"\n",
        env!("CARGO_BIN_EXE_host-sim")
    );
    fs::write(&cargo, script).unwrap();
    fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).unwrap();
    for (name, line) in READERS {
        let taken = |line: &String| line.split_whitespace().any(|word| word == *name);
        if lines.iter().any(taken) {
            run(dir, &format!("cargo sim {line}")).unwrap();
        }
    }
    let angles: String = (0..281)
        .map(|k| format!("{}\n", -20.0 + 0.25 * f64::from(k)))
        .collect();
    fs::write(dir.join("mine.csv"), angles).unwrap();
}

#[test]
fn commands_of_documents_run_as_printed_and_in_order() {
    let scratch = Scratch::new("printed-commands");
    let all: Vec<_> = instructions()
        .into_iter()
        .map(|(path, text)| (path, commands(&text)))
        .collect();
    let runs = |line: &&String| reason(line).is_none();
    let failures: Vec<String> = (all.par_iter().enumerate())
        .filter(|(_, (_, lines))| lines.iter().any(|line| runs(&line)))
        .flat_map_iter(|(k, (path, lines))| {
            let dir = scratch.path().join(k.to_string());
            fs::create_dir(&dir).unwrap();
            furnish(&dir, lines);
            let failed = lines.iter().filter(runs).filter_map(|line| {
                let why = run(&dir, line).err()?;
                Some(format!("{}: {line}\n  {why}", path.display()))
            });
            failed.collect::<Vec<_>>()
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    let count = all.iter().flat_map(|(_, lines)| lines).filter(runs).count();
    assert!(count > 15, "only {count} commands have run");
}

/// The list of commands that are not run holds none that no document prints any more.
#[test]
fn every_command_that_is_not_run_stands_in_a_document() {
    let all: Vec<String> = instructions()
        .iter()
        .flat_map(|(_, text)| commands(text))
        .collect();
    for (begin, why) in NOT_RUN {
        assert!(!why.is_empty());
        let printed = all.iter().any(|line| line.starts_with(begin));
        assert!(printed, "{begin}: in no document");
    }
}
