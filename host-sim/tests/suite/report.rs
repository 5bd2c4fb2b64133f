//! Pages, and what counts as a recording on a command line.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::common::{Scratch, sim};

/// Those of the repository.
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
    let told = text(&output.stdout);
    assert!(
        told.contains("all.html") && told.contains("open it"),
        "{told}"
    );
    let page = fs::read_to_string(page).unwrap();
    for name in ["stair_a", "stair_b", "stair_c", "descending", "empty"] {
        assert!(page.contains(&format!("\"name\":\"{name}\"")), "{name}");
    }
}

/// One bad recording does not cost the others, and what the page says of it is what the terminal says.
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
    let told = text(&output.stderr);
    assert!(told.contains("bad.sigmf-meta"), "{told}");
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
    assert_eq!(text(&output.stdout).lines().count(), 5);
    let skipped = text(&output.stderr);
    assert!(skipped.contains("README.md: no recording"), "{skipped}");
    assert_eq!(skipped.lines().count(), 1, "{skipped}");
}

#[test]
fn nothing_but_what_is_none_is_an_error() {
    let readme = recordings().join("README.md");
    let output = run(&["replay"], &[readme.clone(), readme]);
    assert_eq!(output.status.code(), Some(1));
    let told = text(&output.stderr);
    assert!(told.contains("README.md: no recording"), "{told}");
}
