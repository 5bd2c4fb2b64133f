//! Tests of report pages, and of recordings on the command line.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::{Value, json};

use crate::common::{Scratch, sim};

/// Returns the directory of the repository's recordings.
fn recordings() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings")
}

fn run(command: &[&str], paths: &[PathBuf]) -> Output {
    let paths = paths.iter().map(|path| path.to_str().unwrap());
    let arguments: Vec<&str> = command.iter().copied().chain(paths).collect();
    sim(&arguments)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn a_directory_becomes_a_page_with_an_index() {
    let scratch = Scratch::new("report-directory");
    let page = scratch.path().join("all.html");
    let output = run(&["report", "-o", page.to_str().unwrap()], &[recordings()]);
    let printed = text(&output.stdout);
    assert!(
        printed.contains("all.html") && printed.contains("open it"),
        "{printed}"
    );
    let page = fs::read_to_string(page).unwrap();
    for name in ["stair_a", "stair_b", "stair_c", "descending", "empty"] {
        assert!(page.contains(&format!("\"name\":\"{name}\"")), "{name}");
    }
}

/// A mistyped name leaves no page that would be in the way of the right one; a file of another kind is named itself.
#[test]
fn no_page_is_made_of_nothing() {
    let scratch = Scratch::new("report-nothing");
    let page = scratch.path().join("page.html");
    let other = scratch.path().join("samples.csv");
    fs::write(&other, "1,2\n").unwrap();
    for (path, why) in [
        (scratch.path().join("mistyped"), "mistyped.sigmf-meta"),
        (other, "samples.csv: no recording"),
    ] {
        let output = run(&["report", "-o", page.to_str().unwrap()], &[path]);
        assert_eq!(output.status.code(), Some(1));
        let printed = text(&output.stderr);
        assert!(printed.contains(why), "{printed}");
        assert!(!page.exists());
    }
}

/// A bad recording does not affect the others, and the page has the same message as the terminal.
#[test]
fn a_bad_recording_stands_in_the_page() {
    let scratch = Scratch::new("report-bad");
    let bad = scratch.path().join("bad.sigmf-meta");
    fs::write(&bad, "{").unwrap();
    fs::write(scratch.path().join("bad.sigmf-data"), "").unwrap();
    let page = scratch.path().join("page.html");
    let good = recordings().join("empty");
    let output = run(&["report", "-o", page.to_str().unwrap()], &[good, bad]);
    assert_eq!(output.status.code(), Some(1));
    let printed = text(&output.stderr);
    assert!(printed.contains("bad.sigmf-meta"), "{printed}");
    let page = fs::read_to_string(page).unwrap();
    let (first, second) = (page.find("\"bad\""), page.find("\"empty\""));
    assert!(first.is_some() && first < second, "the failing one first");
    assert!(page.contains("bad.sigmf-meta"));
}

#[test]
fn a_shells_star_means_its_recordings_each_once() {
    let mut paths: Vec<_> = fs::read_dir(recordings())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    let output = run(&["replay", "--format", "json"], &paths);
    // Five scans, and six guard sweeps.
    assert_eq!(text(&output.stdout).lines().count(), 5 + 6);
    let skipped = text(&output.stderr);
    assert!(skipped.contains("README.md: no recording"), "{skipped}");
    assert_eq!(skipped.lines().count(), 1, "{skipped}");
}

#[test]
fn nothing_but_what_is_none_is_an_error() {
    let readme = recordings().join("README.md");
    let output = run(&["replay"], &[readme.clone(), readme]);
    assert_eq!(output.status.code(), Some(1));
    let printed = text(&output.stderr);
    assert!(printed.contains("README.md: no recording"), "{printed}");
}

/// Compares; returns the output and the page's data.
fn compared(scratch: &Scratch, command: &[&str]) -> (String, Value) {
    let page = scratch.path().join("compare.html");
    let page = page.to_str().unwrap();
    let output = sim(&[&["report"], command, &["--compare", "--force", "-o", page]].concat());
    let printed = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let page = fs::read_to_string(page).unwrap();
    let (_, rest) = page.split_once("type=\"application/json\">").unwrap();
    let (data, _) = rest.split_once("</script>").unwrap();
    (printed, serde_json::from_str(data).unwrap())
}

/// Returns a row of the differences.
fn row<'a>(data: &'a Value, what: &str) -> &'a Value {
    let rows = data["compare"]["rows"].as_array().unwrap();
    let row = rows.iter().find(|row| row["what"] == what);
    row.unwrap_or_else(|| panic!("{what}: {rows:?}"))
}

#[test]
fn two_recordings_stand_side_by_side_with_their_differences_first() {
    let scratch = Scratch::new("report-compare");
    let [a, b] = ["stair_a", "stair_c"].map(|name| recordings().join(name).display().to_string());
    let (printed, data) = compared(&scratch, &[&a, &b]);
    assert!(printed.starts_with("stair_a | stair_c\n"), "{printed}");
    assert_eq!(data["recordings"][0]["name"], "stair_a");
    assert_eq!(data["recordings"][1]["name"], "stair_c");
    let height = row(&data, "step 1, height");
    let [by, sigma] = ["by", "sigma"].map(|key| height[key].as_str().unwrap());
    assert!(by.starts_with('+') && sigma.contains(" / "), "{height}");
    assert_eq!(row(&data, "reason inferred-step")["second"], "–");
    for row in data["compare"]["rows"].as_array().unwrap() {
        assert!(printed.contains(row["what"].as_str().unwrap()), "{row}");
    }
}

#[test]
fn one_recording_stands_beside_itself_under_other_settings() {
    let scratch = Scratch::new("report-compare-settings");
    let a = recordings().join("stair_a").display().to_string();
    let settings = |data: &Value| data["compare"]["settings"].clone();
    let (_, data) = compared(&scratch, &[&a, "--estimator", "paper"]);
    assert_eq!(
        data["recordings"][1]["name"],
        "stair_a with estimator=paper"
    );
    assert_eq!(
        settings(&data),
        json!([["estimator", "likelihood", "paper"]])
    );
    assert_eq!(row(&data, "horizon")["second"], "–");
    assert_eq!(row(&data, "status")["second"], "degraded");
    assert_eq!(row(&data, "reason no-promise")["first"], "–");
    let (_, data) = compared(&scratch, &[&a, "--with", "mount-height=43cm,seed=3"]);
    assert_eq!(row(&data, "status")["second"], "degraded");
    let expected = json!([["mount-height", "0.4 m", "0.43 m"], ["seed", "1", "3"]]);
    assert_eq!(settings(&data), expected);
    let sets = ["--with", "mount-height=0.43 m", "--with", "beamwidth=4deg"];
    let (_, data) = compared(&scratch, &[&[a.as_str()], &sets[..]].concat());
    let expected = json!([
        ["mount-height", "0.43 m", "0.4 m"],
        ["beamwidth", "5 deg", "4 deg"]
    ]);
    assert_eq!(settings(&data), expected);
    // A setting that equals the recording's own changes nothing, and the page states it.
    let (printed, data) = compared(&scratch, &[&a, "--with", "mount-height=40cm"]);
    assert!(printed.contains("nothing differs"), "{printed}");
    assert_eq!(data["compare"]["rows"], json!([]));
}

#[test]
fn what_cannot_be_compared_is_reported() {
    let scratch = Scratch::new("report-compare-bad");
    let page = scratch.path().join("page.html");
    let [a, b, c] =
        ["stair_a", "stair_b", "stair_c"].map(|name| recordings().join(name).display().to_string());
    for (command, words) in [
        (&[a.as_str()][..], "expected a second recording"),
        (&[&a, &b, &c], "found 3 recordings, expected two"),
        (&[&a, "nowhere"], "nowhere.sigmf-meta"),
        (
            &[&a, "--with", "colour=red"],
            "\"colour\": expected one of estimator",
        ),
        (&[&a, "--with", "seed"], "expected KEY=VALUE"),
        (
            &[&a, "--with", "mount-height=43"],
            "a number and its unit (m, cm, mm)",
        ),
        (
            &[&a, "--with", "mount-height=9m"],
            "found 9 m, expected 0.01 m to 5 m",
        ),
        (&[&a, "--with", "plane=both"], "expected depth or height"),
        (
            &[
                &a, "--with", "seed=1", "--with", "seed=2", "--with", "seed=3",
            ],
            "found 3 sets",
        ),
    ] {
        let page = page.to_str().unwrap();
        let output = sim(&[&["report"], command, &["--compare", "-o", page]].concat());
        let printed = text(&output.stderr);
        assert!(!output.status.success(), "{command:?}");
        assert!(printed.contains(words), "{command:?}: {printed}");
    }
    assert!(!page.exists());
    let output = sim(&["report", &a, "--with", "seed=2"]);
    assert!(text(&output.stderr).contains("--compare"));
}
