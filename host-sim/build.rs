//! Revision of the simulator: a checksum over everything that decides on a simulated recording's bytes.

use std::fs;
use std::path::{Path, PathBuf};

/// Sources of the simulator and of the recordings that it makes.
const SOURCES: [&str; 3] = ["src/random", "src/scene", "../replay/src/recording"];
/// Versions of all dependencies.
const LOCK: &str = "../Cargo.lock";
/// Packages that the simulator computes with, each as the path of dependencies from this package: elementary
/// functions, complex numbers, random numbers, and the numbers of scene files and metadata. No other dependency
/// changes a recording's bytes.
const PACKAGES: [&[&str]; 7] = [
    &["libm"],
    &["num-complex"],
    &["num-complex", "num-traits"],
    &["rand_core"],
    &["rand_xoshiro"],
    &["serde_json"],
    &["toml"],
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let mut files = Vec::new();
    for folder in SOURCES {
        println!("cargo::rerun-if-changed={folder}");
        collect(Path::new(folder), &mut files);
    }
    println!("cargo::rerun-if-changed={LOCK}");
    let versions = match fs::read_to_string(LOCK) {
        Ok(lock) => versions(&lock),
        Err(error) => Err(error.to_string()),
    };
    let versions = match versions {
        Ok(versions) => versions,
        Err(error) => {
            println!("cargo::error={LOCK}: {error}");
            return;
        }
    };
    files.sort();
    let mut sum = fnv1a(0xCBF2_9CE4_8422_2325, versions.as_bytes());
    for file in files {
        let name = file.to_string_lossy().into_owned();
        sum = fnv1a(sum, name.as_bytes());
        // An unreadable source fails the build elsewhere.
        sum = fnv1a(sum, &fs::read(&file).unwrap_or_default());
    }
    println!("cargo::rustc-env=SIMULATOR_REVISION={sum:016x}");
}

/// Name, version and checksum of each of [`PACKAGES`], a line each.
fn versions(lock: &str) -> Result<String, String> {
    let entries: Vec<Entry> = lock.split("[[package]]").skip(1).map(Entry::of).collect();
    let mut lines = String::new();
    for path in PACKAGES {
        let mut entry = find(&entries, "host-sim")?;
        for name in path {
            let named = |wanted: &&&str| wanted.split(' ').next() == Some(name);
            let wanted = entry.dependencies.iter().find(named);
            let wanted = wanted.ok_or_else(|| format!("{}: no dependency {name}", entry.name))?;
            entry = find(&entries, wanted)?;
        }
        let (name, version) = (entry.name, entry.version);
        let checksum = entry
            .checksum
            .ok_or_else(|| format!("{name}: no checksum"))?;
        lines += &format!("{name} {version} {checksum}\n");
    }
    Ok(lines)
}

/// The entry of `wanted`: a name, with a version where the lock file holds several.
fn find<'a, 'b>(entries: &'b [Entry<'a>], wanted: &str) -> Result<&'b Entry<'a>, String> {
    let mut words = wanted.split(' ');
    let (name, version) = (words.next(), words.next());
    let mut found = entries.iter().filter(|entry| {
        Some(entry.name) == name && version.is_none_or(|version| entry.version == version)
    });
    match (found.next(), found.next()) {
        (Some(entry), None) => Ok(entry),
        (None, _) => Err(format!("no package {wanted}")),
        (Some(_), Some(_)) => Err(format!("several packages {wanted}")),
    }
}

/// One package of the lock file.
struct Entry<'a> {
    name: &'a str,
    version: &'a str,
    checksum: Option<&'a str>,
    dependencies: Vec<&'a str>,
}

impl<'a> Entry<'a> {
    /// Of the lines that follow `[[package]]`, in Cargo's own layout.
    fn of(text: &'a str) -> Self {
        let value = |key: &str| {
            let rest = |line: &'a str| line.strip_prefix(key)?.strip_prefix(" = \"");
            text.lines().find_map(rest)?.strip_suffix('"')
        };
        let dependency = |line: &'a str| line.strip_prefix(" \"")?.strip_suffix("\",");
        Self {
            name: value("name").unwrap_or_default(),
            version: value("version").unwrap_or_default(),
            checksum: value("checksum"),
            dependencies: text.lines().filter_map(dependency).collect(),
        }
    }
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
