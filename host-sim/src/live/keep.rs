//! Writes the files of `--record`: every line with its time.
//!
//! One text file for each session: `live-001.txt` and so on. A line is `MS < LINE` for a received line, `MS >
//! LINE` for a sent one, `MS # REMARK` for an event of the port. MS counts from the start of the session. Each
//! line is written with one call and without buffering, so that no partial line is left when the program ends.

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use super::Ms;
use crate::output::folder;
use crate::recording::writable;

/// Maximum number of recorded sessions, a file each, in a directory.
const MAX_SESSIONS: u32 = 9_999;

/// File that records the lines of one session.
#[derive(Debug)]
pub struct Keep {
    file: File,
    /// Path of the session's file.
    pub path: PathBuf,
    /// Whether the file has a received or sent line.
    pub used: bool,
}

impl Drop for Keep {
    /// Removes a file without a line of the scanner, as of a program that a service starts until the port is there.
    fn drop(&mut self) {
        if !self.used {
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl Keep {
    /// Checks that a session can be recorded in `dir`, which is created if it is missing.
    ///
    /// # Errors
    /// The directory cannot be created, or no file in it; the message names the path.
    pub fn check(dir: &Path) -> Result<()> {
        folder(dir)?;
        writable(&dir.join("live-000.txt"))
    }

    /// Creates a new file in `dir`, with the remark `about` as its first line; the directory is created if it is
    /// missing. Existing files are never overwritten.
    ///
    /// # Errors
    /// The directory or the file cannot be created; the message names the path.
    pub fn begin(dir: &Path, about: &str) -> Result<Self> {
        folder(dir)?;
        for number in 1..=MAX_SESSIONS {
            let path = dir.join(format!("live-{number:03}.txt"));
            match OpenOptions::new().append(true).create_new(true).open(&path) {
                Ok(file) => {
                    let mut keep = Self {
                        file,
                        path,
                        used: false,
                    };
                    keep.line(0, '#', about)?;
                    return Ok(keep);
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error).with_context(|| format!("{}", path.display())),
            }
        }
        bail!("{}: holds {MAX_SESSIONS} sessions already", dir.display())
    }

    /// Writes one line to the session's file: the time `at`, ms, the direction `way` (`<` received, `>` sent, `#`
    /// remark), and the text.
    ///
    /// # Errors
    /// The file cannot be written; the message names it.
    pub fn line(&mut self, at: Ms, way: char, text: &str) -> Result<()> {
        self.used |= way != '#';
        let line = format!("{at} {way} {text}\n");
        let written = self.file.write_all(line.as_bytes());
        written.with_context(|| format!("{}", self.path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_session_has_a_file_of_its_own() {
        let dir = std::env::temp_dir().join(format!("stairscan-keep-{}", std::process::id()));
        let mut first = Keep::begin(&dir, "one").unwrap();
        let mut second = Keep::begin(&dir, "two").unwrap();
        first.line(12, '<', "$PSTR,DONE,stop").unwrap();
        second.line(7, '>', "stop").unwrap();
        let read = |keep: &Keep| fs::read_to_string(&keep.path).unwrap();
        assert_eq!(read(&first), "0 # one\n12 < $PSTR,DONE,stop\n");
        assert_eq!(read(&second), "0 # two\n7 > stop\n");
        // A session in which no port was opened leaves no file.
        let mut third = Keep::begin(&dir, "three").unwrap();
        third.line(1, '#', "no port").unwrap();
        drop(third);
        assert!(!dir.join("live-003.txt").exists());
        fs::remove_dir_all(&dir).unwrap();
    }
}
