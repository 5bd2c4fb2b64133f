//! Revision of the simulator: a checksum over everything that decides on a simulated recording's bytes.

use std::fs;
use std::path::{Path, PathBuf};

/// Sources of the simulator and of the recordings that it makes.
const SOURCES: [&str; 2] = ["src/scene", "src/recording"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let mut files = vec![PathBuf::from("../Cargo.lock")];
    for folder in SOURCES {
        println!("cargo::rerun-if-changed={folder}");
        collect(Path::new(folder), &mut files);
    }
    println!("cargo::rerun-if-changed=../Cargo.lock");
    files.sort();
    let mut sum = 0xCBF2_9CE4_8422_2325;
    for file in files {
        let name = file.to_string_lossy().into_owned();
        sum = fnv1a(sum, name.as_bytes());
        // An unreadable source fails the build elsewhere.
        sum = fnv1a(sum, &fs::read(&file).unwrap_or_default());
    }
    println!("cargo::rustc-env=SIMULATOR_REVISION={sum:016x}");
}

/// All files below a folder, but those of tests.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            collect(&path, files);
        } else if !path.to_string_lossy().ends_with("tests.rs") {
            files.push(path);
        }
    }
}

/// 64-bit FNV-1a (Fowler, Noll, Vo), continued from `sum`.
fn fnv1a(sum: u64, bytes: &[u8]) -> u64 {
    let step = |sum: u64, byte: &u8| (sum ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3);
    bytes.iter().fold(sum, step)
}
