//! What a session leaves where it is cut off: each scan that has ended, as a recording of its own, in a directory that
//! goes when the session's own recordings are written.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use super::gather::{Gather, Mounting};
use super::scans::Scan;
use crate::recording::{DATA_SUFFIX, meta_path, name_of};

/// Scans that have ended, of a session that goes on.
#[derive(Debug)]
pub struct Unfinished {
    dir: PathBuf,
    name: String,
    /// The recordings in the directory, without suffix.
    kept: Vec<PathBuf>,
    scans: usize,
}

impl Unfinished {
    /// Of the session that will write `output`: in `NAME.unfinished` beside it.
    ///
    /// # Errors
    /// A directory of that name that holds the scans of another session.
    pub fn begin(output: &Path) -> Result<Self> {
        let name = name_of(&meta_path(output));
        let dir = output.with_file_name(format!("{name}.unfinished"));
        ensure!(
            !dir.exists(),
            "{}: holds the scans of a session that was cut off: move it away, or look at them with cargo sim \
             report {0}",
            dir.display()
        );
        Ok(Self {
            dir,
            name,
            kept: Vec::new(),
            scans: 0,
        })
    }

    /// Writes a scan; one that cannot be recorded is left out.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub fn keep(&mut self, scan: &Scan, mounting: Mounting) -> Result<()> {
        self.scans += 1;
        let name = format!("{}-scan{:04}", self.name, self.scans);
        let mut gather = Gather::new(&name, mounting);
        gather.take(scan);
        for part in gather.parts() {
            let dir = &self.dir;
            fs::create_dir_all(dir).with_context(|| format!("{}", dir.display()))?;
            let path = dir.join(&part.recording.name);
            part.recording.write(&path)?;
            self.kept.push(path);
        }
        Ok(())
    }

    /// Takes the directory away: all of its scans stand in the session's own recordings.
    ///
    /// # Errors
    /// Names the file that cannot be removed.
    pub fn done(self) -> Result<()> {
        let remove =
            |path: PathBuf| fs::remove_file(&path).with_context(|| format!("{}", path.display()));
        for path in &self.kept {
            let meta = meta_path(path);
            remove(meta.with_extension(DATA_SUFFIX))?;
            remove(meta)?;
        }
        match self.kept.is_empty() {
            true => Ok(()),
            false => fs::remove_dir(&self.dir).with_context(|| format!("{}", self.dir.display())),
        }
    }
}
