//! Tests that no command replaces a file unasked.

use std::fs;

use crate::common::{Scratch, study};

#[test]
fn outputs_that_exist_are_kept() {
    let scratch = Scratch::new("study-outputs");
    let page = scratch.path().join("page.html").display().to_string();
    let cases = [
        &["fit", "--keep", "--output", &page][..],
        &["fit", "--keep", "--output", "x", "--dump", &page],
        &["sequences", "--fit", "--output", &page],
        &["accuracy", "--each", &page],
    ];
    for args in cases {
        fs::write(&page, "a stranger's").unwrap();
        let out = study(args);
        let message = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
        assert!(message.contains("--force"), "{args:?}: {message}");
        assert_eq!(fs::read(&page).unwrap(), b"a stranger's", "{args:?}");
    }
}

#[test]
fn the_firmwares_tables_are_not_replaced_unasked() {
    for (args, file) in [
        (&["fit", "--scenes", "1"][..], "fitted.rs"),
        (&["fit", "--scenes", "1", "--only-model"], "measured.rs"),
        (&["sequences", "--fit", "--count", "1"], "counted.rs"),
    ] {
        let out = study(args);
        let message = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(1), "{args:?}: {message}");
        assert!(
            message.contains(file) && message.contains("--force"),
            "{args:?}: {message}"
        );
    }
}

/// Every fault of the motion sentences has its row, over the same scans as without faults.
#[test]
fn sequences_with_faults_count_every_fault() {
    let out = study(&["sequences", "--faults", "--count", "1"]);
    assert_eq!(out.status.code(), Some(0));
    let text = String::from_utf8(out.stdout).unwrap();
    assert!(
        text.contains("1 sequences, each with every fault: 9 runs"),
        "{text}"
    );
    let row = |name: &str| -> Vec<&str> {
        let line = text.lines().find(|l| l.starts_with(&format!("{name} ")));
        line.unwrap_or_else(|| panic!("{name}: {text}"))
            .split_whitespace()
            .collect()
    };
    let scans = |name: &str| row(name)[1].split_once('/').unwrap().1.to_owned();
    for name in [
        "absent", "lost", "swapped", "delayed", "stuck", "frozen", "jumping", "reversed", "garbled",
    ] {
        assert_eq!(scans(name), scans("none"), "{name}: {text}");
    }
    // With sentences that the input check refuses, no answer of a moving chair is `ok`.
    for name in ["swapped", "garbled"] {
        assert_eq!(row(name)[2], "0", "{name}: {text}");
    }
}
