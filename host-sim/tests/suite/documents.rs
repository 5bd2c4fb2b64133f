//! Tests that documents contain the current output of the commands that they name.

use std::path::Path;
use std::process::Command;

use stairscan::crc::CRC32;

use crate::common::Scratch;
use crate::common::shared_documents::{compare, documents, name, printed as output, root};

const PROGRAM: &str = env!("CARGO_BIN_EXE_host-sim");

fn printed(words: &str) -> String {
    output(PROGRAM, words)
}

#[test]
fn blocks_of_text_are_what_their_commands_print() {
    compare("sim", PROGRAM);
}

/// Documents that commands write as a whole.
const MADE: &[&str] = &[
    "ablation.md",
    "accuracy.md",
    "benchmarks.md",
    "capability.md",
    "parameters.md",
    "reasons.md",
    "sequences.md",
];

/// A block of text follows one of these comments: what a command prints; what the named test compares; what no command
/// prints, such as a drawing or a format; a quotation with invented values.
const MARKS: &[&str] = &[
    "<!-- text: ",
    "<!-- compared: ",
    "<!-- by hand: ",
    "<!-- example: ",
];

#[test]
fn every_block_of_text_is_compared_or_marked_as_an_example() {
    for (path, document) in documents() {
        if MADE.contains(&&*name(&path)) {
            continue;
        }
        let lines: Vec<&str> = document.lines().collect();
        for (at, _) in lines.iter().enumerate().filter(|(_, l)| **l == "```text") {
            let before = at.checked_sub(1).map_or("", |before| lines[before]);
            assert!(
                MARKS.iter().any(|mark| before.starts_with(mark)),
                "{}:{}: none of {MARKS:?} stands before this block",
                path.display(),
                at + 1
            );
        }
    }
}

/// Whether the sentence that begins `text` has the checksum behind one of its asterisks, or is not shown as a whole.
fn intact(text: &str) -> bool {
    let mut sums = text.match_indices('*').filter_map(|(at, _)| {
        let sum = text.get(at + 1..at + 9)?;
        let sum = u32::from_str_radix(sum, 16).ok()?;
        Some(CRC32.checksum(&text.as_bytes()[1..at]) == sum)
    });
    sums.next()
        .is_none_or(|first| first || sums.any(|fits| fits))
}

#[test]
fn sentences_in_documents_have_their_checksums() {
    let mut sentences = 0;
    for (path, document) in documents() {
        for (number, line) in document.lines().enumerate() {
            for (at, _) in line.match_indices("$PST") {
                let (number, name) = (number + 1, name(&path));
                assert!(intact(&line[at..]), "{name}:{number}: wrong checksum");
                sentences += 1;
            }
        }
    }
    assert!(sentences > 10, "{sentences} sentences");
}

/// Runs `cargo sim WORDS` in the repository, which writes below `directory`.
fn drawn(words: &str, directory: &Path) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    for word in words.split(' ') {
        let path = word.strip_prefix("OUT/").map(|below| directory.join(below));
        command.arg(path.unwrap_or_else(|| word.into()));
    }
    let output = command.current_dir(root()).output().unwrap();
    assert!(output.status.success(), "cargo sim {words}: {output:?}");
}

/// The commands are those of `docs/make pictures`.
#[test]
fn pictures_are_what_their_commands_draw() {
    let directory = Scratch::new("pictures");
    drawn("replay recordings/stair_a --plots OUT/", directory.path());
    drawn("inspect recordings/stair_a --plots OUT/", directory.path());
    drawn(
        "simulate scenes/approach.toml --approach 5 --step 0.15 -o OUT/approach",
        directory.path(),
    );
    drawn(
        "replay OUT/approach --film OUT/approach.svg",
        directory.path(),
    );
    let pictures = [
        "stair_a-fig09-cfar-threshold.png",
        "stair_a-fig10-map-cfar.png",
        "stair_a-fig13-staircase.png",
        "stair_a-inspect.png",
        "approach.svg",
    ];
    for picture in pictures {
        let committed = std::fs::read(root().join("docs/generated").join(picture)).unwrap();
        let drawn = std::fs::read(directory.path().join(picture)).unwrap();
        assert!(
            committed == drawn,
            "docs/generated/{picture}: sh docs/make pictures"
        );
    }
}

/// The words of a document of the repository, without line breaks.
fn flowing(path: &str) -> String {
    let text = std::fs::read_to_string(root().join(path)).unwrap();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The number behind `row` at the beginning of a line of docs/generated/benchmarks.md.
fn measured(row: &str) -> f64 {
    let text = std::fs::read_to_string(root().join("docs/generated/benchmarks.md")).unwrap();
    let mut rows = text.lines().filter_map(|line| line.strip_prefix(row));
    let number = rows.find_map(|rest| rest.split_whitespace().next()?.parse().ok());
    number.unwrap_or_else(|| panic!("docs/generated/benchmarks.md has no row {row}"))
}

#[test]
fn figures_of_the_image_are_those_of_the_benchmarks() {
    let (chirp, post) = (measured("chirp "), measured("post "));
    let [flash, ram] = ["flash ", "static RAM "].map(|row| measured(row) / 1024.0);
    let said = format!(
        "Chirp to map row in {:.0},{:03} instructions, last row to report in {:.1} million ({:.0} ms), in \
         {flash:.0} KB of flash and {ram:.0} KB of RAM",
        (chirp / 1e3).floor(),
        chirp % 1e3,
        post / 1e6,
        post / 168e3,
    );
    assert!(
        flowing("README.md").contains(&said),
        "README does not say: {said}"
    );
}

#[test]
fn scan_times_are_those_that_timing_prints() {
    let timing = printed("timing");
    let seconds = |row: &str| {
        let line = timing.lines().find_map(|line| line.strip_prefix(row));
        let scan_ms = line.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok());
        let scan_ms = scan_ms.unwrap_or_else(|| panic!("timing prints no {row}:\n{timing}"));
        format!("{:.1}", scan_ms / 1e3)
    };
    let stop = seconds("stop        1.0 Mbaud");
    let [one, two, three, spi] = ["1.0 Mbaud", "2.0 Mbaud", "3.0 Mbaud", "bgt60, SPI"]
        .map(|link| seconds(&format!("continuous  {link}")));
    for (path, said) in [
        (
            "README.md",
            format!("takes {spi} to {stop} s, {one} s unless set otherwise"),
        ),
        (
            "docs/README.md",
            format!("{spi} to {stop} s, {one} s unless set otherwise"),
        ),
        (
            "docs/user/hardware.md",
            format!(
                "A scan takes {one} s at 1 Mbaud, {two} s at 2, {three} s at 3, {spi} s with a BGT60TR13C on SPI, \
                 and {stop} s with stops at every angle"
            ),
        ),
        (
            "docs/design/guard.md",
            format!("A full scan takes {spi} to {stop} s"),
        ),
        (
            "docs/design/motion.md",
            format!("A scan takes {spi} to {stop} s, {one} s with the default settings"),
        ),
    ] {
        assert!(flowing(path).contains(&said), "{path} does not say: {said}");
    }
}
