//! Functions that tests of `cargo sim` and of `cargo study` share.

#![allow(
    dead_code,
    reason = "compiled into two test programs, of which each uses a part"
)]

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use host_sim::emulate::image;
use host_sim::emulate::tools::Tool;
use host_sim::recording::Recording;
use host_sim::replay;
use serde_json::{Value, json};

/// Whether everything that a test needs is installed. If not, it reports the skipped test and how to install
/// the tools; in CI that is a failure.
pub fn tools(needed: &[Tool]) -> bool {
    let missing: Vec<&str> = (needed.iter())
        .filter(|tool| !tool.available())
        .map(|tool| tool.how_to_get())
        .collect();
    let ci = std::env::var_os("CI").is_some_and(|value| value == "true");
    assert!(missing.is_empty() || !ci, "{}", missing.join("; "));
    if !missing.is_empty() {
        let thread = std::thread::current();
        let test = thread.name().unwrap_or("a test");
        // Not with `eprintln`, whose output the test harness hides for passing tests.
        let _ = writeln!(std::io::stderr(), "SKIPPED {test}: {}", missing.join("; "));
    }
    missing.is_empty()
}

/// Returns the image, built once; `None` after a message if it cannot be run.
pub fn elf() -> Option<&'static Path> {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    let ready = tools(&[Tool::Target, Tool::Emulator]);
    ready.then(|| ELF.get_or_init(|| image::build(&[]).unwrap()).as_path())
}

/// Returns the sentences of `replay` for the first `scans` scans.
pub fn replayed(recording: &Recording, scans: u32) -> Vec<Vec<String>> {
    let options = replay::Options {
        scans: Some(scans),
        ..replay::Options::default()
    };
    let answers = replay::answers(recording, &options, |_| ()).unwrap();
    answers.into_iter().map(|answer| answer.sentences).collect()
}

/// Directory of one test, removed at its end.
pub struct Scratch(PathBuf);

impl Scratch {
    /// Creates an empty directory, named `test`; no other test may use this name.
    pub fn new(test: &str) -> Self {
        let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
        let _ = fs::remove_dir_all(&dir);
        fs::create_dir_all(&dir).unwrap();
        Self(dir)
    }

    /// Writes the recording `bad`: chirps of 16 samples with these captures and further keys of `global`, with
    /// the metadata changed by `change`.
    pub fn damaged(
        &self,
        captures: &[Value],
        further: Value,
        change: impl FnOnce(&mut Value),
    ) -> PathBuf {
        let mut global = json!({
            "core:datatype": "ci16_le",
            "core:version": "1.2.0",
            "stairscan:bandwidth_hz": 10e9,
            "stairscan:samples_per_chirp": 16,
            "stairscan:mirror_offset_m": 0.0,
            "stairscan:beamwidth_deg": 5.0,
            "stairscan:mount_height_m": 0.4,
            "stairscan:scan_plane": "depth",
        });
        for (key, value) in further.as_object().into_iter().flatten() {
            global[key] = value.clone();
        }
        let mut meta = json!({"global": global, "captures": captures, "annotations": []});
        change(&mut meta);
        let samples = vec![0u8; captures.len() * 16 * 4];
        fs::write(self.path().join("bad.sigmf-meta"), meta.to_string()).unwrap();
        fs::write(self.path().join("bad.sigmf-data"), samples).unwrap();
        self.path().join("bad")
    }

    /// Returns its path.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
