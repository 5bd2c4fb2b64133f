//! Tests of missing files, empty files and special files: one clear message, exit status 1, nothing
//! left behind and nothing replaced.
#![cfg(unix)]

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::{FileTypeExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{Scratch, sim};

fn repository(path: &str) -> String {
    format!("{}/../{path}", env!("CARGO_MANIFEST_DIR"))
}

/// Creates a pipe without a reader or writer.
fn pipe(scratch: &Scratch, name: &str) -> PathBuf {
    let path = scratch.path().join(name);
    let made = Command::new("mkfifo").arg(&path).status().unwrap();
    assert!(made.success());
    path
}

/// Asserts that the program refuses, with `words` in its one message.
fn refused(args: &[&OsStr], words: &str) {
    let out = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(args)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{args:?}: {message}");
    assert!(message.contains(words), "{args:?}: {message}");
}

fn os<'a>(args: &'a [&'a str]) -> Vec<&'a OsStr> {
    args.iter().map(OsStr::new).collect()
}

#[test]
fn pipes_are_no_input() {
    let scratch = Scratch::new("pipes");
    let scene = pipe(&scratch, "scene.toml");
    let out = scratch.path().join("out");
    let regular = "expected a regular file";
    refused(
        &[
            OsStr::new("simulate"),
            scene.as_os_str(),
            OsStr::new("-o"),
            out.as_os_str(),
        ],
        regular,
    );
    pipe(&scratch, "rec.sigmf-meta");
    let recording = scratch.path().join("rec");
    for command in ["replay", "profile", "inspect"] {
        refused(&[OsStr::new(command), recording.as_os_str()], regular);
    }
    fs::remove_file(scratch.path().join("rec.sigmf-meta")).unwrap();
    fs::copy(
        repository("recordings/empty.sigmf-meta"),
        scratch.path().join("rec.sigmf-meta"),
    )
    .unwrap();
    pipe(&scratch, "rec.sigmf-data");
    refused(&[OsStr::new("replay"), recording.as_os_str()], regular);
}

#[test]
fn what_is_no_file_is_not_replaced() {
    let scratch = Scratch::new("replaced");
    let fifo = pipe(&scratch, "fifo.png");
    let device = scratch.path().join("device.png");
    symlink("/dev/null", &device).unwrap();
    let recording = repository("recordings/empty");
    for picture in [&fifo, &device] {
        let args = ["profile", &recording, "--format", "json", "--plot"];
        let args = [&os(&args)[..], &[picture.as_os_str()]].concat();
        refused(&args, "expected a regular file, or none yet");
    }
    assert!(fs::metadata(&fifo).unwrap().file_type().is_fifo());
    assert!(fs::metadata(&device).unwrap().file_type().is_char_device());
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 2);
}

#[test]
fn names_of_directories_leave_no_hidden_file() {
    let scratch = Scratch::new("nameless-files");
    let dir = scratch.path().display().to_string();
    let (scene, recording) = (
        repository("scenes/empty.toml"),
        repository("recordings/empty"),
    );
    let names = [
        "/",
        "..",
        ".",
        &format!("{dir}/"),
        &format!("{dir}/."),
        &format!("{dir}/.."),
    ];
    for name in names {
        refused(
            &os(&["simulate", &scene, "-o", name]),
            "expected the name of a file",
        );
        refused(
            &os(&["profile", &recording, "--plot", name]),
            "expected the name of a file",
        );
    }
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 0);
}

#[test]
fn names_that_are_no_utf_8_are_kept_or_refused() {
    let scratch = Scratch::new("no-utf-8");
    let name = scratch.path().join(OsStr::from_bytes(b"r\xFF.x"));
    let scene = repository("scenes/empty.toml");
    let args = ["simulate", &scene, "-o"];
    let args = [&os(&args)[..], &[name.as_os_str()]].concat();
    refused(
        &[&args[..], &os(&["--count", "2"])].concat(),
        "expected a name in UTF-8",
    );
    let run = |args: &[&OsStr]| {
        Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .args(args)
            .output()
            .unwrap()
    };
    assert!(run(&args).status.success());
    let plots = scratch.path().join(OsStr::from_bytes(b"p\xFE"));
    let args = [
        OsStr::new("replay"),
        name.as_os_str(),
        OsStr::new("--plots"),
        plots.as_os_str(),
    ];
    let out = run(&args);
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    assert!(fs::read_dir(&plots).unwrap().count() > 3);
    let hidden = |path: &Path| {
        let mut entries = fs::read_dir(path).unwrap();
        entries.any(|e| e.unwrap().file_name().as_encoded_bytes().starts_with(b"."))
    };
    assert!(!hidden(scratch.path()) && !hidden(&plots));
}

#[test]
fn a_directory_that_is_a_file_is_named() {
    let scratch = Scratch::new("file-as-directory");
    let file = scratch.path().join("file");
    fs::write(&file, "").unwrap();
    let out = sim(&[
        "replay",
        &repository("recordings/empty"),
        "--plots",
        file.to_str().unwrap(),
    ]);
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1), "{message}");
    assert!(
        message.contains("file: no directory for pictures"),
        "{message}"
    );
}
