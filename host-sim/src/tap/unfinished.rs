//! Scans of a session that may be interrupted: each completed scan is written as a recording of its own, to a
//! directory that is removed when the session's final recordings are written.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use super::beside::Beside;
use super::gather::Gather;
use super::mounting::Mounting;
use super::scans::Scan;
use crate::recording::{DATA_SUFFIX, meta_path, name_of};
use crate::setup::{self, Kind};

/// Completed scans of a running session, each written as a recording.
#[derive(Debug)]
pub struct Unfinished {
    dir: PathBuf,
    name: String,
    /// Paths of the recordings in the directory, without suffix.
    kept: Vec<PathBuf>,
    scans: usize,
}

impl Unfinished {
    /// Prepares the directory `NAME.unfinished` beside `output`, the final recording of the
    /// session; the first scan creates it.
    ///
    /// # Errors
    /// The directory exists and contains the scans of another session.
    pub fn begin(output: &Path) -> Result<Self> {
        let name = name_of(&meta_path(output));
        let dir = output.with_file_name(format!("{name}.unfinished"));
        ensure!(
            !dir.exists(),
            "{}: holds the scans of an interrupted session: move it away, or inspect them with cargo sim \
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

    /// Writes a scan as a recording of its own, marked if it is a guard sweep by what `beside` has received until now.
    /// A scan that cannot be recorded is left out.
    ///
    /// # Errors
    /// The file cannot be written; the message names it.
    pub fn keep(&mut self, scan: &Scan, mounting: &Mounting, beside: &Beside) -> Result<()> {
        self.scans += 1;
        let name = format!("{}-scan{:04}", self.name, self.scans);
        let mut gather = Gather::new(&name, mounting.clone());
        gather.take(scan);
        for mut part in gather.parts() {
            if part.scans_kind(mounting, beside) == Some(Kind::Guard) {
                setup::mark_guard(&mut part.recording);
            }
            let dir = &self.dir;
            fs::create_dir_all(dir).with_context(|| format!("{}", dir.display()))?;
            let path = dir.join(&part.recording.name);
            part.recording.write(&path)?;
            self.kept.push(path);
        }
        Ok(())
    }

    /// Removes the directory, after the final recordings have been written.
    ///
    /// # Errors
    /// A file cannot be removed; the message names it.
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
