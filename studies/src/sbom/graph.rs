//! Finds the crates that are linked into the image, as Cargo resolves them for the chip.
//!
//! `cargo tree` resolves features for this package alone, as a build of it does. `cargo metadata` resolves them for
//! the whole workspace and would list crates that only host programs use; it is used for the folders of the sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use host_sim::emulate::tools::TARGET;

/// Name of the package that the image is built from.
pub const ROOT: &str = "stairscan";
/// Format of a line of `cargo tree`: package, licence and repository, separated by [`PARTED`].
const FIELDS: &str = "{p}|{l}|{r}";
/// Separator of the fields in a line of `cargo tree`; no name, licence or address contains it.
const PARTED: char = '|';

/// Name and version of a crate.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Id {
    /// Name of the crate as in its `Cargo.toml`.
    pub name: String,
    /// Version: three numbers.
    pub version: String,
}

/// One crate of the image or of its build.
#[derive(Clone, Debug, Default)]
pub struct Crate {
    /// SPDX expression of the crate's licence.
    pub licence: String,
    /// Address of the crate's repository; empty if it does not state one.
    pub repository: String,
    /// SHA-256 of the crate's package from `Cargo.lock`, in hexadecimal; `None` for a package of
    /// the workspace.
    pub checksum: Option<String>,
    /// Folder of the crate's sources.
    pub folder: PathBuf,
    /// Whether the crate has a build script.
    pub build_script: bool,
    /// Whether the crate is a procedural macro, which runs in the compiler.
    pub proc_macro: bool,
    /// Crates on which this one depends.
    pub depends: BTreeSet<Id>,
    /// Names of the crates that depend on this one.
    pub used_by: BTreeSet<String>,
}

/// Crates by name and version.
pub type Crates = BTreeMap<Id, Crate>;

/// Returns the crates that are linked into the image, including its own package. `root` is the
/// workspace's folder.
///
/// # Errors
/// A command of Cargo failed, or its output is incomplete; the message names it.
pub fn linked(root: &Path) -> Result<Crates> {
    let tree = tree(root, "normal,no-proc-macro")?;
    completed(root, tree)
}

/// Returns the crates that run during the build, in the compiler or before it, and are not part of the image.
///
/// # Errors
/// Those of [`linked`].
pub fn built_with(root: &Path, linked: &Crates) -> Result<Crates> {
    let mut tree = tree(root, "normal,build")?;
    tree.retain(|id, _| !linked.contains_key(id));
    completed(root, tree)
}

/// Runs Cargo in the folder `root` and returns its output.
fn cargo(root: &Path, args: &[&str]) -> Result<String> {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let done = Command::new(program)
        .current_dir(root)
        .args(args)
        .output()
        .context("cargo")?;
    let said = String::from_utf8_lossy(&done.stderr);
    ensure!(
        done.status.success(),
        "cargo {}: {}",
        args.join(" "),
        said.trim()
    );
    Ok(String::from_utf8(done.stdout)?)
}

/// Returns the crates that `cargo tree` lists for these kinds of dependencies (`edges`), with
/// licence, repository and dependencies.
fn tree(root: &Path, edges: &str) -> Result<Crates> {
    let args = ["tree", "--locked", "--quiet", "--package", ROOT];
    let which = ["--target", TARGET, "--edges", edges];
    let form = ["--prefix", "depth", "--no-dedupe", "--format", FIELDS];
    parsed(&cargo(root, &[&args[..], &which, &form].concat())?)
}

/// Parses the output of `cargo tree`, whose lines begin with their depth in the tree.
fn parsed(text: &str) -> Result<Crates> {
    let mut crates = Crates::new();
    // Ancestors of the current line, the root first.
    let mut above: Vec<Id> = Vec::new();
    for line in text.lines().filter(|line| !line.is_empty()) {
        let digits = line.find(|c: char| !c.is_ascii_digit()).unwrap_or(0);
        let (depth, rest) = line.split_at(digits);
        let depth: usize = depth
            .parse()
            .with_context(|| format!("cargo tree: {line}"))?;
        let fields: Vec<&str> = rest.split(PARTED).collect();
        let [package, licence, repository] = fields[..] else {
            bail!("cargo tree: {line}: expected three fields");
        };
        let mut words = package.split(' ');
        let (Some(name), Some(version)) = (words.next(), words.next()) else {
            bail!("cargo tree: {line}: expected name and version");
        };
        let id = Id {
            name: name.to_owned(),
            version: version.trim_start_matches('v').to_owned(),
        };
        above.truncate(depth);
        let of = crates.entry(id.clone()).or_insert_with(|| Crate {
            // An obsolete form of SPDX expressions.
            licence: licence.replace('/', " OR "),
            repository: repository.to_owned(),
            ..Crate::default()
        });
        if let Some(user) = above.last() {
            of.used_by.insert(user.name.clone());
            if let Some(user) = crates.get_mut(user) {
                user.depends.insert(id.clone());
            }
        }
        above.push(id);
    }
    Ok(crates)
}

/// Adds checksum, source folder and kind of each crate, from the lock file and from the crates' own
/// manifests.
fn completed(root: &Path, mut crates: Crates) -> Result<Crates> {
    let checksums = checksums(root)?;
    let args = ["metadata", "--format-version", "1", "--locked", "--quiet"];
    let text = cargo(root, &[&args[..], &["--filter-platform", TARGET]].concat())?;
    let metadata: Value = serde_json::from_str(&text).context("cargo metadata")?;
    let packages = metadata["packages"]
        .as_array()
        .context("cargo metadata: packages")?;
    for package in packages {
        let id = Id {
            name: package["name"].as_str().unwrap_or_default().to_owned(),
            version: package["version"].as_str().unwrap_or_default().to_owned(),
        };
        let Some(of) = crates.get_mut(&id) else {
            continue;
        };
        let manifest = Path::new(package["manifest_path"].as_str().unwrap_or_default());
        of.folder = manifest.parent().unwrap_or(manifest).to_owned();
        let targets = package["targets"].as_array().map_or(&[][..], Vec::as_slice);
        let holds = |kind: &str| {
            let kinds = targets
                .iter()
                .filter_map(|target| target["kind"].as_array());
            kinds.flatten().any(|k| k.as_str() == Some(kind))
        };
        of.build_script = holds("custom-build");
        of.proc_macro = holds("proc-macro");
        of.checksum = checksums.get(&id).cloned();
    }
    for (id, of) in &crates {
        let lost = of.folder.as_os_str().is_empty();
        ensure!(!lost, "cargo metadata: no {} {}", id.name, id.version);
    }
    Ok(crates)
}

/// Returns the checksums of all packages in the lock file, in hexadecimal.
fn checksums(root: &Path) -> Result<BTreeMap<Id, String>> {
    let path = root.join("Cargo.lock");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let lock: toml::Table = toml::from_str(&text).with_context(|| path.display().to_string())?;
    let packages = lock.get("package").and_then(toml::Value::as_array);
    let mut checksums = BTreeMap::new();
    for package in packages.context("Cargo.lock: no packages")? {
        let text = |key: &str| package.get(key).and_then(toml::Value::as_str);
        if let (Some(name), Some(version), Some(sum)) =
            (text("name"), text("version"), text("checksum"))
        {
            let id = Id {
                name: name.to_owned(),
                version: version.to_owned(),
            };
            checksums.insert(id, sum.to_owned());
        }
    }
    Ok(checksums)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_gives_each_crate_once_with_what_it_depends_on() {
        let text = "0a v1.0.0 (/somewhere)|MIT|\n1b v2.0.1|MIT/Apache-2.0|https://b\n2c v0.1.0|0BSD|\n\
                    1c v0.1.0|0BSD|\n1c v0.2.0 (proc-macro)|0BSD|\n";
        let crates = parsed(text).unwrap();
        let names = |ids: &BTreeSet<Id>| -> Vec<String> {
            ids.iter()
                .map(|id| format!("{}-{}", id.name, id.version))
                .collect()
        };
        assert_eq!(
            names(&crates.keys().cloned().collect()),
            ["a-1.0.0", "b-2.0.1", "c-0.1.0", "c-0.2.0"]
        );
        let last = crates.values().next_back().unwrap();
        assert_eq!(last.used_by, BTreeSet::from(["a".to_owned()]));
        let depends: Vec<_> = crates.values().map(|of| names(&of.depends)).collect();
        assert_eq!(depends[0], ["b-2.0.1", "c-0.1.0", "c-0.2.0"]);
        assert_eq!(depends[1], ["c-0.1.0"]);
        let b = crates.values().nth(1).unwrap();
        assert_eq!(
            (&b.licence[..], &b.repository[..]),
            ("MIT OR Apache-2.0", "https://b")
        );
    }
}
