//! What `--record` keeps: every line with its time.
//!
//! One text file a session, `live-001.txt` and so on. A line is `MS < LINE` for what came, `MS > LINE` for what
//! was sent, `MS # REMARK` for what happened to the port; MS counts from the session's beginning. Each is
//! written whole and at once, so that whatever ends the program leaves no half of one.

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use super::Ms;

/// Most sessions of a directory.
const MOST: u32 = 9_999;

/// A session's file.
#[derive(Debug)]
pub struct Keep {
    file: File,
    /// Where it is.
    pub path: PathBuf,
}

impl Keep {
    /// A new file in `dir`, which is made if there is none; no other is ever written over.
    ///
    /// # Errors
    /// Names the path.
    pub fn begin(dir: &Path, about: &str) -> Result<Self> {
        fs::create_dir_all(dir).with_context(|| format!("{}", dir.display()))?;
        for number in 1..=MOST {
            let path = dir.join(format!("live-{number:03}.txt"));
            match OpenOptions::new().append(true).create_new(true).open(&path) {
                Ok(file) => {
                    let mut keep = Self { file, path };
                    keep.line(0, '#', about)?;
                    return Ok(keep);
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error).with_context(|| format!("{}", path.display())),
            }
        }
        bail!("{}: holds {MOST} sessions already", dir.display())
    }

    /// One line.
    ///
    /// # Errors
    /// Names the file.
    pub fn line(&mut self, at: Ms, way: char, text: &str) -> Result<()> {
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
        fs::remove_dir_all(&dir).unwrap();
    }
}
