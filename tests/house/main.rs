//! Checks of the sources of the firmware and of the host's programs: no import cycles among files, no folder
//! above its share of the code. For the firmware also: no import against the data flow, no cycles among folders,
//! no tuned number outside its table, no two types of one name, no status that is assigned outside `verdict`,
//! no register that is written from a reset value other than 0. For the documents: no broken links, the correct count of tuned numbers, a diagram that matches the imports, and, as in
//! comments, no word that the glossary replaces.

mod diagram;
mod documents;
mod graph;
mod literals;
mod names;
mod registers;
mod sources;
mod statuses;
mod terms;

use std::path::{Path, PathBuf};

use diagram::Layer;
use graph::Graph;
use sources::Sources;
use stairscan::params::{Origin, Params};

/// Folders of `src/` in the order of the data flow: none imports from a later one.
const WAY: &[&str] = &["signal", "mount", "model", "infer"];
/// Folders and files of `src/` in which numbers must be in `params*.rs` or in a constant with a comment.
const TUNED: &[&str] = &[
    "signal/echoes",
    "motion/sweeps",
    "mount/online",
    "mount/ground",
    "model",
    "infer",
    "health",
];
/// The folder that assigns a status, and the one that writes and parses its text.
const STATUSES: &[&str] = &["verdict", "report"];
/// Layers of the diagram in docs/design/architecture.md. It leaves out the files directly in `src/` that are in none of
/// them; in the search for circles they count.
const LAYERS: &[Layer] = &[
    ("the image", &[("board", &["board", "main"])]),
    (
        "the loop, and the stages joined",
        &[
            ("scanner", &["scanner"]),
            ("pipeline", &["pipeline", "finder"]),
        ],
    ),
    (
        "estimators",
        &[
            ("infer", &["infer"]),
            ("paper", &["paper"]),
            ("guard", &["guard"]),
        ],
    ),
    (
        "interface of estimators and observers, earlier scans",
        &[
            ("observer", &["observer", "estimator"]),
            ("past", &["past"]),
        ],
    ),
    ("scene model", &[("model", &["model"])]),
    (
        "instrument and mounting",
        &[("mount", &["mount"]), ("health", &["health"])],
    ),
    (
        "status and sentences",
        &[("report", &["report"]), ("verdict", &["verdict"])],
    ),
    (
        "chirps and echoes, the chair's motion",
        &[("motion", &["motion"]), ("signal", &["signal"])],
    ),
];
/// Folders that the diagram leaves out: nearly all import them. In the search for circles they count.
const LEFT_OUT: &[&str] = &["params"];
/// Maximum share of the lines of `src/` in one folder, without tests.
const LARGEST_SHARE: f64 = 0.25;

/// Returns the sources of the crate `name`, whose directory is relative to the workspace's root.
fn sources(name: &str, directory: &str) -> Sources {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = workspace.join(directory).join("src");
    let sources = Sources::read(name, &root);
    assert!(sources.files.len() > 20, "where is {}?", root.display());
    sources
}

fn firmware() -> Sources {
    sources("stairscan", ".")
}

/// Returns the sources of the programs on the host.
fn host() -> [Sources; 3] {
    [
        sources("host_sim", "host-sim"),
        sources("stairscan_replay", "replay"),
        sources("studies", "studies"),
    ]
}

/// Returns the sources of all crates.
fn all() -> Vec<Sources> {
    [firmware()].into_iter().chain(host()).collect()
}

/// Returns `folders` after checking that all exist: renaming one must not disable a check.
fn all_of(sources: &Sources, folders: &'static [&'static str]) -> &'static [&'static str] {
    let there = |folder: &&str| sources.files.iter().any(|f| f.is_in(folder));
    assert!(
        folders.iter().all(there),
        "src does not hold all of {folders:?}"
    );
    folders
}

fn none(violations: &[String]) {
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

/// Asserts that there are no violations; each message begins with the name of the crate.
fn none_in(sources: &Sources, violations: impl IntoIterator<Item = String>) {
    let violations = violations.into_iter();
    let named = violations.map(|violation| format!("{}: {violation}", sources.name));
    none(&named.collect::<Vec<_>>());
}

#[test]
fn no_file_imports_itself_round_a_circle() {
    for sources in all() {
        none_in(&sources, Graph::new(&sources).circles(|_| true));
    }
}

#[test]
fn no_arrow_runs_back_up_the_way_of_the_data() {
    let sources = firmware();
    let graph = Graph::new(&sources);
    let way = all_of(&sources, WAY);
    none(&graph.circles(|file| way.iter().any(|folder| file.is_in(folder))));
    none(&graph.arrows_back(way));
}

#[test]
fn no_folder_outgrows_the_others() {
    for sources in all() {
        let large = sources.large_folders(LARGEST_SHARE);
        none_in(&sources, large.iter().map(ToString::to_string));
    }
}

#[test]
fn each_type_has_a_name_of_its_own() {
    none(&names::shared(&firmware()));
}

#[test]
fn tuned_numbers_stand_in_their_table() {
    let sources = firmware();
    let tuned = all_of(&sources, TUNED);
    let files = sources
        .files
        .iter()
        .filter(|f| tuned.iter().any(|folder| f.is_in(folder)));
    let violations = files.filter(|f| !f.is_params()).flat_map(literals::stray);
    none(&violations.collect::<Vec<_>>());
}

#[test]
fn one_folder_writes_a_status() {
    let sources = firmware();
    let may = all_of(&sources, STATUSES);
    let files = sources.files.iter();
    let others = files.filter(|f| !may.iter().any(|folder| f.is_in(folder)));
    none(&others.flat_map(statuses::written).collect::<Vec<_>>());
}

/// Folders with code that writes registers.
const CHIP: &[&str] = &["src/board", "boot/src/chip"];

#[test]
fn no_register_is_written_from_a_reset_value_that_nobody_sees() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let walk = CHIP.iter().flat_map(|folder| {
        let files: Vec<_> = walkdir::WalkDir::new(root.join(folder))
            .into_iter()
            .collect();
        assert!(files.len() > 3, "where is {folder}?");
        files
    });
    let paths = walk.map(|entry| entry.unwrap().into_path());
    let paths = paths.filter(|path| path.extension().is_some_and(|e| e == "rs"));
    let found = paths.chain([root.join("src/main.rs")]).flat_map(|path| {
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.strip_prefix(root).unwrap().to_string_lossy();
        registers::writes(&name, &text)
    });
    none(&found.collect::<Vec<_>>());
}

/// Compares the list of registers with the crate that describes them, where it is wider than that crate.
#[test]
fn every_register_with_a_reset_value_is_in_the_list() {
    let crates = register_crate();
    let mut missing = Vec::new();
    for peripheral in registers::PERIPHERALS {
        let name = peripheral.trim_end_matches(|c: char| c.is_ascii_digit());
        let name = if name.starts_with("gpio") {
            "gpio"
        } else {
            name
        };
        let known = |register: &str| {
            let mut all = registers::REGISTERS.iter();
            all.any(|(of, known, _)| (*of, *known) == (name, register))
        };
        for entry in walkdir::WalkDir::new(crates.join(peripheral)) {
            let path = entry.unwrap().into_path();
            let file = path.file_stem().unwrap().to_string_lossy().into_owned();
            if path.is_file() {
                let text = std::fs::read_to_string(&path).unwrap();
                let register = registers::of_crate(&file, &text).filter(|r| !known(r));
                missing.extend(register.map(|r| format!("{name}.{r} is not in the list")));
            }
        }
    }
    none(&missing);
}

/// Returns the folder of the chip's registers in the crate `stm32f4`.
fn register_crate() -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = std::process::Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--locked", "--quiet"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let package = packages.iter().find(|package| package["name"] == "stm32f4");
    let manifest = package.unwrap()["manifest_path"].as_str().unwrap();
    Path::new(manifest).with_file_name("src").join("stm32f405")
}

/// Compares the counts in the document with the table.
#[test]
fn the_document_on_the_fit_counts_the_tuned_numbers() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/design/fit.md");
    let text = std::fs::read_to_string(path).unwrap();
    let mut said = vec![format!("{} numbers, of three origins", Params::TABLE.len())];
    for origin in [Origin::Derived, Origin::Custom, Origin::Hand] {
        let of = Params::TABLE.iter().filter(|e| e.origin == origin);
        said.push(format!("**{}** ({}", origin.as_str(), of.count()));
    }
    for said in said {
        assert!(
            text.contains(&said),
            "docs/design/fit.md does not say {said}"
        );
    }
}

/// The repository, and its files below `folder` whose names end in `suffix`. Hidden folders and `target` are left out.
fn files(folder: &str, suffix: &str) -> (PathBuf, Vec<PathBuf>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .canonicalize()
        .unwrap();
    let skipped =
        |name: &std::ffi::OsStr| name == "target" || name.as_encoded_bytes().starts_with(b".");
    let walk = walkdir::WalkDir::new(root.join(folder)).sort_by_file_name();
    let files: Vec<_> = walk
        .into_iter()
        .filter_entry(|e| e.depth() == 0 || !skipped(e.file_name()))
        .map(|e| e.unwrap().into_path())
        .filter(|path| path.extension().is_some_and(|e| e == suffix))
        .collect();
    assert!(files.len() > 10, "{files:?}");
    (root, files)
}

#[test]
fn every_link_of_a_document_leads_somewhere() {
    let (root, documents) = files("", "md");
    none(&documents::dead_links(&root, &documents));
}

/// Documents in which replaced words may stand: the glossary, and what quotes earlier states.
const QUOTING: &[&str] = &[
    "docs/design/glossary.md",
    "docs/design/history.md",
    "CHANGELOG.md",
];

#[test]
fn no_word_that_the_glossary_replaces_stands_in_comments_and_documents() {
    let (root, documents) = files("", "md");
    let glossary = std::fs::read_to_string(root.join("docs/design/glossary.md")).unwrap();
    let replaced = terms::replaced(&glossary);
    assert!(replaced.len() > 10, "{} words", replaced.len());
    let sources = [
        "src", "host-sim", "replay", "studies", "boot", "fuzz", "testbed",
    ]
    .map(|folder| files(folder, "rs").1);
    let mut violations = Vec::new();
    for path in documents.iter().chain(sources.iter().flatten()) {
        let name = path.strip_prefix(&root).unwrap().to_string_lossy();
        if QUOTING.contains(&&*name) {
            continue;
        }
        let text = std::fs::read_to_string(path).unwrap();
        let text = match name.ends_with(".rs") {
            true => terms::comments(&text),
            false => text,
        };
        violations.extend(terms::violations(&name, &text, &replaced));
    }
    none(&violations);
}

/// All folders of `src/` and all files directly in it, those of one node of the diagram together.
#[test]
fn no_folder_imports_itself_round_a_circle() {
    none(&diagram::circles(LAYERS, &Graph::new(&firmware())));
}

/// The diagram of docs/design/architecture.md, from above.
#[test]
fn the_diagram_of_the_folders_shows_who_imports_whom() {
    let sources = firmware();
    for (_, folders) in LAYERS.iter().flat_map(|(_, parts)| *parts) {
        all_of(&sources, folders);
    }
    none(&diagram::forgotten(LAYERS, LEFT_OUT, &sources.files));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/design/architecture.md");
    let document = std::fs::read_to_string(path).unwrap();
    none(&diagram::differences(
        LAYERS,
        &Graph::new(&sources),
        &document,
    ));
}
