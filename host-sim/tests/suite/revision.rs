//! Tests of the firmware's build script: when it runs again, and the revisions that it and the
//! simulator's script report.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::Scratch;

fn run(dir: &Path, program: &str, args: &[&str]) -> String {
    let command = Command::new(program)
        .args(args)
        .current_dir(dir)
        .env("CARGO_CFG_TARGET_OS", "linux")
        .env_remove("GIT_DIR")
        .output();
    let output = command.unwrap_or_else(|error| panic!("{program}: {error}"));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {args:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

fn git(dir: &Path, args: &[&str]) {
    let who = ["-c", "user.name=x", "-c", "user.email=x@localhost"];
    run(dir, "git", &[&who[..], args].concat());
}

/// Returns the contents of the files that the script watches, and the revision.
fn watched(dir: &Path, script: &Path) -> (BTreeMap<PathBuf, Vec<u8>>, String) {
    let output = run(dir, script.to_str().unwrap(), &[]);
    let values = |key: &str| -> Vec<String> {
        let lines = output.lines().filter_map(|line| line.strip_prefix(key));
        lines.map(str::to_owned).collect()
    };
    let files = values("cargo::rerun-if-changed=").into_iter().map(|path| {
        let path = dir.join(path);
        let elsewhere = ["memory.x", "demo.x", "build.rs"];
        assert!(path.exists() || elsewhere.iter().any(|name| path.ends_with(name)));
        let content = fs::read(&path).unwrap_or_default();
        (path, content)
    });
    let files = files.collect();
    (
        files,
        values("cargo::rustc-env=STAIRSCAN_REVISION=").concat(),
    )
}

#[test]
fn a_commit_reruns_the_build_script_and_staging_does_not() {
    let scratch = Scratch::new("build-script");
    let script = scratch.path().join("script");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/../build.rs");
    let built = ["--edition=2024", "-o", script.to_str().unwrap(), source];
    run(scratch.path(), "rustc", &built);
    let tree = scratch.path().join("tree");
    fs::create_dir_all(tree.join("src")).unwrap();
    git(&tree, &["init", "--quiet"]);
    fs::write(tree.join("src/main.rs"), "1").unwrap();
    git(&tree, &["add", "src"]);
    git(&tree, &["commit", "--quiet", "-m", "one"]);
    // Also for a worktree, whose `.git` is a file.
    let other = scratch.path().join("other");
    git(
        &tree,
        &["worktree", "add", "--quiet", other.to_str().unwrap()],
    );
    for tree in [&tree, &other] {
        let (before, revision) = watched(tree, &script);
        assert_eq!(revision.len(), 12, "{revision}");
        fs::write(tree.join("README.md"), "text").unwrap();
        git(tree, &["add", "README.md"]);
        let (staged, _) = watched(tree, &script);
        assert!(staged == before, "{:?}", staged.keys());
        git(tree, &["commit", "--quiet", "-m", "two"]);
        let (after, next) = watched(tree, &script);
        assert!(after != before && next != revision, "{next}");
        assert!(after.contains_key(&tree.join("src")));
        fs::write(tree.join("src/main.rs"), "2").unwrap();
        let (_, changed) = watched(tree, &script);
        assert_eq!(changed, format!("{next}-dirty"));
    }
}

/// Returns the revision of the simulator, or the error, from its build script beside this lock file.
fn simulator_revision(dir: &Path, script: &Path, lock: &str) -> String {
    fs::write(dir.join("../Cargo.lock"), lock).unwrap();
    let output = run(dir, script.to_str().unwrap(), &[]);
    let mut printed = output.lines().filter_map(|line| {
        line.strip_prefix("cargo::rustc-env=")
            .or(line.strip_prefix("cargo::error="))
    });
    printed.next().unwrap().to_owned()
}

/// A change of another dependency must not invalidate the cached recordings.
#[test]
fn the_simulator_s_revision_counts_only_the_packages_it_computes_with() {
    let scratch = Scratch::new("simulator-revision");
    let (script, dir) = (scratch.path().join("script"), scratch.path().join("p"));
    fs::create_dir_all(dir.join("src/scene")).unwrap();
    fs::create_dir_all(dir.join("src/recording")).unwrap();
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/build.rs");
    let built = ["--edition=2024", "-o", script.to_str().unwrap(), source];
    run(scratch.path(), "rustc", &built);
    let lock = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.lock");
    let lock = fs::read_to_string(lock).unwrap();
    let changed = |package: &str| {
        let entry = format!("name = \"{package}\"\nversion = \"");
        assert!(lock.contains(&entry), "{package}");
        simulator_revision(&dir, &script, &lock.replace(&entry, &format!("{entry}9")))
    };
    let now = simulator_revision(&dir, &script, &lock);
    assert!(now.starts_with("SIMULATOR_REVISION="), "{now}");
    for package in ["clap", "ratatui", "host-sim"] {
        assert_eq!(changed(package), now, "{package}");
    }
    for package in ["libm", "num-complex", "num-traits", "toml"] {
        let other = changed(package);
        assert!(
            other.starts_with("SIMULATOR_REVISION=") && other != now,
            "{other}"
        );
    }
    let without = lock.replace("\"num-complex\",", "");
    assert_eq!(
        simulator_revision(&dir, &script, &without),
        "../Cargo.lock: host-sim: no dependency num-complex"
    );
}

/// A first build takes minutes: the README's commands show its progress.
#[test]
fn a_first_build_shows_its_progress() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let config = fs::read_to_string(root.join(".cargo/config.toml")).unwrap();
    let commands: Vec<&str> = (config.lines())
        .filter(|line| line.contains("--bin"))
        .collect();
    assert!(
        commands.iter().any(|line| line.starts_with("sim = ")),
        "{config}"
    );
    for command in commands {
        assert!(!command.contains("--quiet"), "{command}");
    }
}

/// The workspaces beside this one and the change log have the same version, and each version of the log has its day.
#[test]
fn all_manifests_and_the_change_log_have_one_version() {
    let version = env!("CARGO_PKG_VERSION");
    for manifest in [
        include_str!("../../../python/Cargo.toml"),
        include_str!("../../../web/Cargo.toml"),
    ] {
        let line = manifest.lines().find(|line| line.starts_with("version = "));
        assert_eq!(line, Some(&*format!("version = \"{version}\"")));
    }
    let log = include_str!("../../../CHANGELOG.md");
    let headings = log.lines().filter_map(|line| line.strip_prefix("## "));
    let mut headings = headings
        .filter(|heading| *heading != "[Unreleased]")
        .peekable();
    let newest = headings.peek().copied().unwrap_or_default();
    assert!(newest.starts_with(&format!("[{version}] - ")), "{newest}");
    for heading in headings {
        let (_, day) = heading.split_once("] - ").expect(heading);
        let parts: Vec<&str> = day.split('-').collect();
        let lengths: Vec<usize> = parts.iter().map(|part| part.len()).collect();
        assert_eq!(lengths, [4, 2, 2], "{heading}");
        assert!(
            parts.iter().all(|part| part.parse::<u16>().is_ok()),
            "{heading}"
        );
    }
}
