//! Tests that outputs replace no input, and another existing file only with `--force`.

use std::fs;
use std::path::Path;

use crate::common::{Scratch, sim};

/// Copies a recording of the repository; returns the names of its two files.
fn recording(scratch: &Scratch) -> [String; 3] {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings/empty");
    let to = scratch.path().join("hall");
    let mut names = vec![to.display().to_string()];
    for suffix in ["sigmf-meta", "sigmf-data"] {
        fs::copy(from.with_extension(suffix), to.with_extension(suffix)).unwrap();
        names.push(to.with_extension(suffix).display().to_string());
    }
    names.try_into().unwrap()
}

/// Returns the content of every file of the directory, by name.
fn contents(scratch: &Scratch) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(scratch.path()).unwrap();
    let mut all: Vec<_> = entries
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.display().to_string(), fs::read(&path).unwrap()))
        .collect();
    all.sort();
    all
}

/// Asserts that the program refuses to write `file` with `words` in its message, and that no file
/// changes.
fn refused(scratch: &Scratch, args: &[&str], file: &str, words: &str) {
    let before = contents(scratch);
    let out = sim(args);
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
    let named = message
        .lines()
        .filter(|line| line.starts_with(&format!("error: {file}: ")));
    let named: Vec<_> = named.collect();
    assert_eq!(named.len(), 1, "{args:?}: {message}");
    assert!(named[0].contains(words), "{args:?}: {message}");
    assert!(contents(scratch) == before, "{args:?}: files have changed");
}

#[test]
fn an_input_is_never_replaced() {
    let scratch = Scratch::new("outputs-inputs");
    let [name, meta, data] = &recording(&scratch);
    let scene = scratch.path().join("scene.toml");
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/empty.toml");
    fs::copy(from, &scene).unwrap();
    let scene = scene.to_str().unwrap();
    // A scene with the suffix of a recording's metadata.
    let disguised = scratch.path().join("scene.sigmf-meta");
    fs::copy(scene, &disguised).unwrap();
    let disguised = disguised.to_str().unwrap();
    for force in [&[][..], &["--force"]] {
        for (args, file) in [
            (&["report", name, "-o", meta][..], meta.as_str()),
            (&["report", meta, "-o", data], data),
            (&["web", name, "-o", meta], meta),
            (&["replay", name, "--film", data], data),
            (&["profile", name, "--plot", meta], meta),
            (&["convert", name, "-o", name], meta),
            (&["simulate", disguised, "-o", disguised], disguised),
        ] {
            refused(&scratch, &[args, force].concat(), file, "is an input");
        }
    }
    // By another path to the same file.
    let around = format!(
        "{}/../outputs-inputs/hall.sigmf-meta",
        scratch.path().display()
    );
    let args = ["report", name, "-o", &around, "--force"];
    refused(&scratch, &args, &around, "is an input");
}

#[test]
fn an_existing_file_is_replaced_with_force_only() {
    let scratch = Scratch::new("outputs-existing");
    let [name, ..] = &recording(&scratch);
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/empty.toml");
    let path = |file: &str| scratch.path().join(file).display().to_string();
    let [page, film, picture, table, simulated, many] = [
        "page.html",
        "film.svg",
        "picture.png",
        "table.csv",
        "simulated",
        "many_000",
    ]
    .map(path);
    let [meta, manual] = ["simulated.sigmf-data", "host-sim.1"].map(path);
    let pattern = many.replace("000", "{}");
    let (many, own) = (format!("{many}.sigmf-meta"), path("hall-inspect.png"));
    let dir = scratch.path().to_str().unwrap();
    let cases = [
        (&["report", name, "-o", &page][..], &page),
        (&["web", name, "-o", &page], &page),
        (&["replay", name, "--film", &film], &film),
        (&["profile", name, "--plot", &picture], &picture),
        (&["inspect", name, "--plots", dir], &own),
        (&["convert", name, "-o", &table], &table),
        (&["simulate", scene, "-o", &simulated], &meta),
        (&["simulate", scene, "--count", "1", "-o", &pattern], &many),
        (&["man", dir], &manual),
    ];
    for (args, file) in cases {
        fs::write(file, "a stranger's").unwrap();
        refused(&scratch, args, file, "--force");
        // This command needs a target of the compiler.
        if args[0] == "web" {
            continue;
        }
        let out = sim(&[args, &["--force"]].concat());
        let message = String::from_utf8(out.stderr).unwrap();
        assert!(out.status.success(), "{args:?}: {message}");
        assert_ne!(fs::read(file).unwrap(), b"a stranger's", "{args:?}");
    }
    let parts = contents(&scratch);
    assert!(!parts.iter().any(|(name, _)| name.ends_with(".part")));
}
