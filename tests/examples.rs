//! Tests that the examples run and print what their comments state.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Runs an example with `input` on its standard input.
fn run(example: &str, arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["run", "--locked", "--quiet", "--example", example, "--"])
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(input.as_bytes()).unwrap();
    drop(stdin);
    child.wait_with_output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    str::from_utf8(bytes).unwrap()
}

#[test]
fn a_chirp_becomes_a_profile() {
    let output = run("chirp_to_profile", &[], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let (notes, rows): (Vec<&str>, Vec<&str>) = text(&output.stdout)
        .lines()
        .partition(|l| l.starts_with('#'));
    assert!(rows.len() > 150 && rows.iter().all(|row| row.split(' ').count() == 3));
    // The two targets behind the mirror only.
    let found: Vec<f64> = notes
        .iter()
        .filter_map(|note| note.strip_prefix("# detection at ")?.split(' ').next())
        .map(|range| range.parse().unwrap())
        .collect();
    assert_eq!(found.len(), 2, "{notes:?}");
    assert!((found[0] - 0.60).abs() < 2e-3 && (found[1] - 0.95).abs() < 2e-3);
}

#[test]
fn a_recording_becomes_steps() {
    let output = run("recording_to_steps", &["recordings/stair_a"], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let answer = text(&output.stdout);
    assert!(answer.contains("direction up, 3 steps"), "{answer}");
    let output = run("recording_to_steps", &["recordings/descending"], "");
    let answer = text(&output.stdout);
    assert!(answer.contains("direction down, 4 steps"), "{answer}");
}

#[test]
fn a_recording_that_is_not_there_is_named() {
    let output = run("recording_to_steps", &["recordings/nowhere"], "");
    assert!(!output.status.success());
    assert!(text(&output.stderr).contains("recordings/nowhere.sigmf-meta"));
}

#[test]
fn the_readme_s_report_is_parsed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    // Without the lines that describe a sentence's fields.
    let is_sentence = |line: &&str| line.starts_with("$PSTR,") && !line.contains('<');
    let lines: Vec<&str> = readme.lines().map(str::trim).filter(is_sentence).collect();
    assert_eq!(lines.len(), 4);
    let output = run("parse_report", &[], &lines.join("\r\n"));
    let answer = text(&output.stdout);
    assert!(output.status.success(), "{answer}");
    let mut reported = answer.lines();
    let head = reported.next().unwrap_or_default();
    assert!(
        head.starts_with("scan 1: ok") && head.contains("3 steps up"),
        "{answer}"
    );
    let step = reported.next().unwrap_or_default();
    assert!(
        step.starts_with("scan 1, step 1 of 3: distance 500.2 mm"),
        "{answer}"
    );

    let damaged = lines.join("\n").replacen("780.1", "790.1", 1);
    let output = run("parse_report", &[], &damaged);
    let answer = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{answer}");
    assert!(
        answer.contains("line 3 is damaged: CRC-32 is wrong"),
        "{answer}"
    );
    assert!(
        answer.contains("scan 1: incomplete, 2 of 3 steps came"),
        "{answer}"
    );
}
