//! Tests of `settings` over pseudo-terminals: read, write, compare; errors are reported before anything
//! is sent.

use std::fs;
use std::process::Output;

use stairscan::report::Sentence;
use stairscan::scanner::Settings;

use crate::common::scanner::{Scanner, stair_a};
use crate::common::{Scratch, sim};

fn printed(output: &Output) -> String {
    String::from_utf8([&output.stdout[..], &output.stderr].concat()).unwrap()
}

fn line(sentence: &Sentence<'_>) -> String {
    sentence.write().trim_end().to_owned()
}

#[test]
fn a_scanner_s_settings_are_got_compared_and_set() {
    let dir = Scratch::new("settings-whole");
    let file = dir.path().join("chair.toml");
    let path = file.to_str().unwrap();
    let scanner = Scanner::plug_in(stair_a());
    let run =
        |what: &str, more: &[&str]| sim(&[&["settings", &scanner.path, what, path], more].concat());

    let got = run("--get", &[]);
    assert_eq!(got.status.code(), Some(0), "{}", printed(&got));
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.contains("mount-height = \"0.4 m\"\n"), "{text}");
    assert!(text.contains("# radar-carrier = \"94 GHz\"\n"), "{text}");
    // An existing file is not replaced.
    let again = run("--get", &[]);
    assert_eq!(again.status.code(), Some(1));
    assert!(printed(&again).contains("--force"), "{}", printed(&again));

    let same = run("--diff", &[]);
    assert_eq!(same.status.code(), Some(0), "{}", printed(&same));
    assert!(same.stdout.is_empty(), "{}", printed(&same));

    fs::write(
        &file,
        "mount-height = \"41 cm\"\nretries = 3\nplane = \"depth\"\n",
    )
    .unwrap();
    let differs = run("--diff", &[]);
    assert_eq!(differs.status.code(), Some(1));
    assert_eq!(
        String::from_utf8(differs.stdout.clone()).unwrap(),
        "mount-height: scanner 0.4 m, file 0.41 m (line 1)\nretries: scanner 2, file 3 (line 2)\n"
    );
    assert!(
        printed(&differs).contains("not compared: "),
        "{}",
        printed(&differs)
    );

    let set = run("--set", &[]);
    assert_eq!(set.status.code(), Some(0), "{}", printed(&set));
    for words in [
        "mount-height: 0.4 m -> 0.41 m\n",
        "retries: 2 -> 3\n",
        "3 settings set and read back",
        "--save stores",
    ] {
        assert!(printed(&set).contains(words), "{words}: {}", printed(&set));
    }
    assert_eq!(run("--diff", &[]).status.code(), Some(0));

    // This scanner has no flash: the settings are set but not saved, and scanning continues.
    let saved = run("--set", &["--save"]);
    assert_eq!(saved.status.code(), Some(1));
    assert!(
        printed(&saved).contains("set, but not saved: save: refused: flash"),
        "{}",
        printed(&saved)
    );
    let live = sim(&["doctor", &scanner.path, "--format", "json"]);
    assert!(
        printed(&live).contains("\"check\":\"answer\""),
        "{}",
        printed(&live)
    );
    scanner.unplug();
}

#[test]
fn a_wrong_file_sends_nothing() {
    let dir = Scratch::new("settings-wrong");
    let file = dir.path().join("chair.toml");
    let scanner = Scanner::plug_in(stair_a());
    let path = file.to_str().unwrap();
    for (text, words) in [
        (
            "retries = 3\nmount-height = \"9 m\"\n",
            "chair.toml:2: mount-height = 9 m: expected 0.01 m to 5 m",
        ),
        (
            "retries = 3\nangle-count = 8000\n",
            "chair.toml:2: angle-count = 8000: with the other settings",
        ),
        ("", "holds no setting"),
        ("retries 3\n", "chair.toml:1: "),
    ] {
        fs::write(&file, text).unwrap();
        let set = sim(&["settings", &scanner.path, "--set", path]);
        assert_eq!(set.status.code(), Some(1));
        assert!(printed(&set).contains(words), "{words}: {}", printed(&set));
        assert!(set.stdout.is_empty(), "{}", printed(&set));
    }
    fs::write(&file, "retries = 2\n").unwrap();
    let same = sim(&["settings", &scanner.path, "--diff", path]);
    assert_eq!(same.status.code(), Some(0), "{}", printed(&same));
    scanner.unplug();
}

/// A scanner with another firmware, which refuses one key and stores another value than requested.
#[test]
fn what_the_scanner_refuses_or_keeps_otherwise_is_named() {
    let mut settings = Settings::default();
    let live = || "$PSTR,LIVE,scanning,1,1000,,absent,0,0,0,0".to_owned();
    let live = move || {
        let body = live();
        let body = body.trim_start_matches('$').to_owned();
        format!("${body}*{:08X}", stairscan::report::sentence::crc32(&body))
    };
    let scanner = Scanner::scripted(live, move |typed| {
        let printed = |settings: &Settings, key: &str| {
            let value = settings.get(key).unwrap();
            line(&Sentence::Config { key, value: &value })
        };
        if typed == "get" {
            let mut lines: Vec<String> = Settings::KEYS
                .iter()
                .map(|key| printed(&settings, key))
                .collect();
            lines.push(line(&Sentence::Done { command: "get" }));
            return lines;
        }
        match stairscan::scanner::command::parse(typed) {
            Ok(stairscan::scanner::command::Command::Set("retries", _)) => {
                vec![line(&Sentence::Fail {
                    command: "set",
                    field: "retries",
                    expected: "2",
                })]
            }
            Ok(stairscan::scanner::command::Command::Set("settle", _)) => {
                vec![printed(&settings, "settle")]
            }
            Ok(stairscan::scanner::command::Command::Set(key, value)) => {
                settings.set(key, value).unwrap();
                vec![printed(&settings, key)]
            }
            _ => Vec::new(),
        }
    });
    let dir = Scratch::new("settings-refused");
    let file = dir.path().join("chair.toml");
    fs::write(
        &file,
        "mount-height = \"0.41 m\"\nretries = 3\nsettle = \"6 ms\"\n",
    )
    .unwrap();
    let set = sim(&[
        "settings",
        &scanner.path,
        "--set",
        file.to_str().unwrap(),
        "--save",
    ]);
    assert_eq!(set.status.code(), Some(1));
    for words in [
        "retries: refused: retries: expected 2\n",
        "retries: scanner holds 2, expected 3\n",
        "settle: scanner holds 5 ms, expected 6 ms\n",
        "mount-height: 0.4 m -> 0.41 m\n",
        "were not saved",
    ] {
        assert!(printed(&set).contains(words), "{words}: {}", printed(&set));
    }
    scanner.unplug();
}

#[test]
fn ports_that_cannot_be_used_are_explained() {
    let dir = Scratch::new("settings-ports");
    let file = dir.path().join("chair.toml");
    let path = file.to_str().unwrap();
    let missing = sim(&["settings", "/dev/no-such-port", "--get", path]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(
        printed(&missing).contains("no /dev/no-such-port"),
        "{}",
        printed(&missing)
    );
    let silent = host_sim::live::pty::Pty::new().unwrap();
    let nothing = sim(&["settings", &silent.path, "--get", path]);
    assert_eq!(nothing.status.code(), Some(1));
    assert!(
        printed(&nothing).contains("sends nothing"),
        "{}",
        printed(&nothing)
    );
    assert!(!file.exists());
}
