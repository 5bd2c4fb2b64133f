//! The README's accuracy table, measured afresh: every change of accuracy shows in a diff.

use host_sim::commands::accuracy;

/// The table as committed.
const COMMITTED: &str = include_str!("../../docs/accuracy.md");

#[test]
fn accuracy_is_as_committed() {
    let measured = accuracy::table(&accuracy::measure().unwrap());
    assert!(
        measured == COMMITTED,
        "accuracy has changed; if that is meant: cargo sim accuracy > docs/accuracy.md, and the same \
         into README.md\n\ncommitted:\n{COMMITTED}\nmeasured:\n{measured}"
    );
}

#[test]
fn the_readme_shows_the_committed_table() {
    let readme = include_str!("../../README.md");
    assert!(
        readme.contains(COMMITTED),
        "README.md does not hold docs/accuracy.md"
    );
}
