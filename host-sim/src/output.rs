//! Files that commands write: never one that the command reads, another existing one only with `--force`, and each
//! whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::recording::{DATA_SUFFIX, Recording, meta_path, write_whole};

/// The option that all commands with an output share.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Overwrite {
    /// Replace output files that exist; inputs are never replaced
    #[arg(long)]
    force: bool,
}

impl Overwrite {
    /// Whether existing files are replaced.
    pub fn is_forced(self) -> bool {
        self.force
    }

    /// The outputs of a command that reads `inputs`: files, or recordings with or without suffix.
    pub fn reading<P: AsRef<Path>>(self, inputs: impl IntoIterator<Item = P>) -> Outputs {
        let named = inputs.into_iter().flat_map(|path| {
            let [meta, data] = pair(path.as_ref());
            [path.as_ref().to_owned(), meta, data]
        });
        Outputs {
            force: self.force,
            inputs: named
                .filter_map(|path| fs::canonicalize(path).ok())
                .collect(),
        }
    }
}

/// Guard of the files that a command writes.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    force: bool,
    /// Canonical paths of the files that the command reads.
    inputs: Vec<PathBuf>,
}

impl Outputs {
    /// Refuses a path that may not be written. Long work asks before it begins.
    ///
    /// # Errors
    /// Names the path: an input, or a file that exists while `--force` is not given.
    pub fn check(&self, path: &Path) -> Result<()> {
        let place = fs::canonicalize(path);
        ensure!(
            place.is_err() || place.is_ok_and(|place| !self.inputs.contains(&place)),
            "{}: is what is read: expected another name",
            path.display()
        );
        // What exists and is no file is refused by `write_whole`, with or without the option.
        ensure!(
            self.force || !path.is_file(),
            "{}: exists: expected another name, or --force to replace it",
            path.display()
        );
        Ok(())
    }

    /// [`Self::check`] of both files of a recording.
    ///
    /// # Errors
    /// Names the file.
    pub fn check_recording(&self, path: &Path) -> Result<()> {
        pair(path).iter().try_for_each(|file| self.check(file))
    }

    /// Writes a file whole or not at all.
    ///
    /// # Errors
    /// Those of [`Self::check`], and a file that cannot be written.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<()> {
        self.check(path)?;
        write_whole(path, bytes)
    }

    /// [`Self::write`], making the directory where there is none.
    ///
    /// # Errors
    /// Names the directory or the file.
    pub fn write_picture(&self, path: &Path, bytes: &[u8]) -> Result<()> {
        if let Some(dir) = path.parent().filter(|d| !d.as_os_str().is_empty()) {
            fs::create_dir_all(dir)
                .with_context(|| format!("{}: no directory for pictures", dir.display()))?;
        }
        self.write(path, bytes)
    }

    /// Writes a recording's two files.
    ///
    /// # Errors
    /// Those of [`Self::check_recording`], and a file that cannot be written.
    pub fn write_recording(&self, path: &Path, recording: &Recording) -> Result<()> {
        self.check_recording(path)?;
        recording.write(path)
    }
}

/// Metadata and samples of a recording named with or without suffix.
fn pair(path: &Path) -> [PathBuf; 2] {
    let meta = meta_path(path);
    let data = meta.with_extension(DATA_SUFFIX);
    [meta, data]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_directory_can_be_made_below_a_file() {
        let dir = std::env::temp_dir().join(format!("stairscan-output-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        fs::write(dir.join("file"), b"").unwrap();
        let outputs = Outputs::default();
        let error = outputs.write_picture(&dir.join("file/inner/picture.png"), b"x");
        let error = format!("{:#}", error.unwrap_err());
        assert!(error.contains("file/inner"), "{error}");
        let picture = dir.join("made/picture.png");
        outputs.write_picture(&picture, b"x").unwrap();
        assert_eq!(fs::read(&picture).unwrap(), b"x");
        fs::remove_dir_all(&dir).unwrap();
    }
}
