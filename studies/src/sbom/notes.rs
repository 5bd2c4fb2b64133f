//! Purpose and maintainer of each crate of the image: written by hand in `notes.txt`, one line for each crate and version
//! series.
//!
//! A crate without an entry, or an entry without a crate, fails a test: an added dependency needs both.

use std::sync::LazyLock;

use super::graph::Id;

/// Purpose and maintainer of a crate.
#[derive(Clone, Copy, Debug)]
pub struct Note {
    /// Name of the crate, and the beginning of its version.
    pub of: (&'static str, &'static str),
    /// Purpose of the crate in the image.
    pub why: &'static str,
    /// Maintainer of the crate: `working group` (embedded, of the Rust project), `Rust project`, `several` (an
    /// organisation, or several people with the rights to publish), `one person`, or `here`.
    pub by: &'static str,
}

impl Note {
    fn parse(line: &'static str) -> Option<Self> {
        let mut fields = line.split(" | ");
        Some(Self {
            of: fields.next()?.split_once(' ')?,
            by: fields.next()?,
            why: fields.next()?,
        })
    }
}

/// Notes on all crates of the image, in the order of their names: one line each in `notes.txt`, with name and beginning
/// of the version, maintainer and purpose.
pub static NOTES: LazyLock<Vec<Note>> = LazyLock::new(|| {
    let notes = include_str!("notes.txt").lines().map(Note::parse);
    notes.map(|note| note.expect("a note")).collect()
});

/// Returns the note on a crate; `None` if there is none for its version.
pub fn of(id: &Id) -> Option<&'static Note> {
    NOTES.iter().find(|note| {
        let (name, version) = note.of;
        name == id.name && id.version.starts_with(version)
    })
}
