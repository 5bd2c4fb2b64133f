//! Tests that outputs replace no input, and another existing file only with `--force`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

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

/// Takes the place of a program that is writing `path`: its temporary file, locked.
fn writing(path: &Path) -> (fs::File, PathBuf) {
    let part = PathBuf::from(format!("{}.part", path.display()));
    let file = fs::File::create(&part).unwrap();
    file.lock().unwrap();
    (file, part)
}

#[test]
fn of_two_writers_the_second_is_refused_and_nothing_is_mixed() {
    let scratch = Scratch::new("outputs-two-writers");
    let [name, ..] = &recording(&scratch);
    let path = |file: &str| scratch.path().join(file);
    let text = |path: &Path| path.to_str().unwrap().to_owned();
    let [table, copy, manual] = ["table.csv", "copy", "manual"].map(path);
    fs::create_dir(&manual).unwrap();
    let [table_text, copy_text, manual_text] = [&table, &copy, &manual].map(|path| text(path));
    for (args, busy) in [
        (&["convert", name, "-o", &table_text][..], table.clone()),
        // The second of both files, and one of many.
        (
            &["convert", name, "-o", &copy_text],
            copy.with_extension("sigmf-data"),
        ),
        (&["man", &manual_text], manual.join("host-sim-web.1")),
    ] {
        let (file, part) = writing(&busy);
        let args = [args, &["--force"]].concat();
        let out = sim(&args);
        let message = String::from_utf8(out.stderr).unwrap();
        let expected = format!("error: {}: another program is writing it", busy.display());
        assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
        assert!(message.contains(&expected), "{args:?}: {message}");
        drop(file);
        fs::remove_file(part).unwrap();
        // Of those that belong together, none was written.
        assert_eq!(fs::read_dir(&manual).unwrap().count(), 0, "{args:?}");
        assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 3, "{args:?}");
    }
}

#[test]
fn two_writers_at_once_leave_the_files_of_one() {
    let scratch = Scratch::new("outputs-race");
    let recordings = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    let output = scratch.path().join("out");
    let files = |path: &Path| {
        ["sigmf-meta", "sigmf-data"].map(|suffix| fs::read(path.with_extension(suffix)).unwrap())
    };
    let start = |name: &str, to: &Path| {
        Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .args(["convert", "--force", "-o"])
            .args([to, &recordings.join(name)])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let names = ["stair_a", "stair_b"];
    for name in names {
        assert!(start(name, &output).wait().unwrap().success());
        fs::create_dir(scratch.path().join(name)).unwrap();
        for suffix in ["sigmf-meta", "sigmf-data"] {
            let from = output.with_extension(suffix);
            fs::rename(
                &from,
                scratch.path().join(name).join(from.file_name().unwrap()),
            )
            .unwrap();
        }
    }
    let whole = names.map(|name| files(&scratch.path().join(name).join("out")));
    for _ in 0..10 {
        let both = names.map(|name| start(name, &output));
        for child in both {
            let done = child.wait_with_output().unwrap();
            let message = String::from_utf8(done.stderr).unwrap();
            let refused = message.contains("out.sigmf-") && message.contains("another program");
            assert!(done.status.success() || refused, "{message}");
        }
        assert!(whole.contains(&files(&output)));
    }
    let left = fs::read_dir(scratch.path()).unwrap().count();
    assert_eq!(left, 4, "a temporary file is left");
}

#[test]
fn a_closed_stderr_ends_no_command() {
    for args in [
        &["replay", "nothing"][..],
        &["replay", "nothing", "nowhere"],
        &["inspect", "nothing"],
        &["score", "nothing"],
        &["crash", "nothing", "nothing"],
        &["keys", "show", "nothing"],
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        let status = command
            .args(args)
            .stdout(Stdio::null())
            .stderr(writer)
            .status();
        // A panic would give 101.
        assert_eq!(status.unwrap().code(), Some(1), "{args:?}");
    }
}

#[test]
fn a_file_is_what_its_name_says() {
    let scratch = Scratch::new("outputs-names");
    let [name, ..] = &recording(&scratch);
    let path = |file: &str| scratch.path().join(file).display().to_string();
    let [film, page, picture] = ["film.png", "page.pdf", "picture.svg"].map(path);
    refused(
        &scratch,
        &["replay", name, "--film", &film],
        &film,
        "expected .svg",
    );
    refused(
        &scratch,
        &["report", name, "-o", &page],
        &page,
        "expected .html",
    );
    refused(
        &scratch,
        &["web", name, "-o", &page],
        &page,
        "expected .html",
    );
    refused(
        &scratch,
        &["profile", name, "--plot", &picture],
        &picture,
        "expected .png",
    );
}

#[test]
fn no_output_goes_to_a_file_named_like_stdout() {
    let scratch = Scratch::new("outputs-stdout");
    let [name, ..] = &recording(&scratch);
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/empty.toml");
    for args in [
        &["report", name, "-o", "-"][..],
        &["web", name, "-o", "-"],
        &["convert", name, "-o", "-"],
        &["replay", name, "--film", "-"],
        &["replay", name, "--plots", "-"],
        &["inspect", name, "--plots", "-"],
        &["profile", name, "--plot", "-"],
        &["simulate", scene, "-o", "-"],
        &["simulate", scene, "--guard", "-o", "-"],
        &["simulate", scene, "--count", "2", "-o", "-"],
        &["record", "--demo", name, "-o", "-"],
        &["settings", "/dev/null", "--get", "-"],
        &["keys", "new", "-"],
        &["keys", "sign", name, "-o", "-"],
        &["live", "--demo", name, "--record", "-"],
        &["man", "-"],
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        let out = command
            .args(args)
            .current_dir(scratch.path())
            .output()
            .unwrap();
        let message = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
        assert!(
            message.contains("not written to stdout"),
            "{args:?}: {message}"
        );
        assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 2, "{args:?}");
    }
}

/// Of several processes that write the same recording at once, one does, and both its files are that one's.
#[test]
fn of_two_writers_one_wins() {
    let scratch = Scratch::new("outputs-writers");
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    let to = scratch.path().join("both");
    let names = ["empty", "stair_a", "wall", "stair_b"].map(|name| dir.join(name));
    let names: Vec<_> = names
        .iter()
        .filter(|n| n.with_extension("sigmf-meta").exists())
        .collect();
    let children: Vec<_> = (names.iter())
        .map(|name| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
            command.arg("convert").arg(name).arg("-o").arg(&to);
            command
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap()
        })
        .collect();
    let mut winner = None;
    for (child, name) in children.into_iter().zip(&names) {
        let out = child.wait_with_output().unwrap();
        let message = String::from_utf8(out.stderr).unwrap();
        match out.status.code() {
            Some(0) => assert!(winner.replace(name).is_none(), "two have written"),
            code => {
                assert_eq!(code, Some(1), "{message}");
                let why = ["another program is writing it", "exists"];
                assert!(why.iter().any(|why| message.contains(why)), "{message}");
            }
        }
    }
    let samples = |path: &Path| fs::read(path.with_extension("sigmf-data")).unwrap();
    assert_eq!(samples(&to), samples(winner.unwrap()));
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 2);
    assert!(sim(&["replay", to.to_str().unwrap()]).status.success());
}

/// An output that cannot be written is refused before a recording begins or an image is built. The check leaves no file.
#[test]
fn an_output_that_cannot_be_written_is_refused_at_the_beginning() {
    let scratch = Scratch::new("outputs-early");
    let [name, ..] = &recording(&scratch);
    let path = |file: &str| scratch.path().join(file).display().to_string();
    let (file, nowhere) = (path("file"), path("no/such/hall"));
    fs::write(&file, "").unwrap();
    let (below, folder) = (path("file/hall"), path("taken"));
    fs::create_dir(scratch.path().join("taken.sigmf-meta")).unwrap();
    let beginning = |args: &[&str], words: &str| {
        let out = Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .args(args)
            // A build would end here, with another message.
            .env("CARGO", "/no/cargo")
            .output()
            .unwrap();
        let message = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
        assert!(message.contains(words), "{args:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{args:?}: {message}");
    };
    for (output, words) in [
        (".", "expected the name of a file"),
        ("..", "expected the name of a file"),
        (&*nowhere, "No such file or directory"),
        (&below, "Not a directory"),
        (&folder, "expected a regular file, or none yet"),
    ] {
        beginning(&["record", "--demo", name, "-o", output], words);
        // A port that is not there is found out later.
        beginning(&["record", "/dev/no-such-port", "-o", output], words);
    }
    beginning(&["keys", "sign", "-o", "."], "expected the name of a file");
    beginning(&["keys", "sign", "-o", &nowhere], "No such file");
    beginning(&["image", "-o", &file], "File exists");
    beginning(&["web", name, "-o", &nowhere], "No such file");
    beginning(&["simulate", "random:none", "-o", &nowhere], "No such file");
    let left = fs::read_dir(scratch.path()).unwrap().count();
    assert_eq!(left, 4, "the check leaves nothing");
}
