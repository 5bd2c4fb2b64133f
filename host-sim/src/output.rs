//! Output files of commands. A command never overwrites its inputs, overwrites other existing files only with
//! `--force`, and writes each file completely or not at all. While another program writes it, it is refused.

use std::fs;
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::convert::suffix;
use crate::recording::{
    Content, DATA_SUFFIX, Readers, Recording, meta_path, named, writable, write_together,
};

/// The option that all commands with an output share.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Overwrite {
    /// Replace output files that exist; inputs are never replaced
    #[arg(long)]
    force: bool,
}

impl Overwrite {
    /// Returns whether existing files are replaced.
    pub fn is_forced(self) -> bool {
        self.force
    }

    /// Returns the checked outputs of a command that reads `inputs`: files, or recordings with or
    /// without suffix.
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

/// Checks and writes the output files of a command.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    force: bool,
    /// Canonical paths of the files that the command reads.
    inputs: Vec<PathBuf>,
}

impl Outputs {
    /// Checks whether a path may be written. Long commands check before they begin.
    ///
    /// # Errors
    /// The path is `-` or an input, or exists and `--force` is not given; the message names it.
    pub fn check(&self, path: &Path) -> Result<()> {
        no_stdout(path)?;
        let place = fs::canonicalize(path);
        ensure!(
            place.is_err() || place.is_ok_and(|place| !self.inputs.contains(&place)),
            "{}: is an input: expected another name",
            path.display()
        );
        // Existing directories and special files are refused by `write_whole`, with or without the option.
        ensure!(
            self.force || !path.is_file(),
            "{}: exists: expected another name, or --force to replace it",
            path.display()
        );
        Ok(())
    }

    /// Checks a path as [`Self::check`] does, and that its name, if it has a suffix, has one of `suffixes`: the file is
    /// what its name says.
    ///
    /// # Errors
    /// Those of [`Self::check`], or another suffix.
    pub fn check_kind(&self, path: &Path, suffixes: &[&str]) -> Result<()> {
        self.check(path)?;
        let found = suffix(path);
        ensure!(
            found.is_empty() || suffixes.iter().any(|s| found.eq_ignore_ascii_case(s)),
            "{}: .{found}: expected .{}",
            path.display(),
            suffixes.join(" or .")
        );
        Ok(())
    }

    /// Checks both files of a recording, as [`Self::check`] does for one.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn check_recording(&self, path: &Path) -> Result<()> {
        no_stdout(path)?;
        pair(path).iter().try_for_each(|file| self.check(file))
    }

    /// Checks a path as [`Self::check`] does, and that a file can be made there. Commands that run until the user ends
    /// them, or that build first, check their outputs in this way before.
    ///
    /// # Errors
    /// Those of [`Self::check`], or no file can be made; the message has the system's reason.
    pub fn ready(&self, path: &Path) -> Result<()> {
        self.check(path)?;
        writable(path)
    }

    /// Checks both files of a recording, as [`Self::ready`] does for one.
    ///
    /// # Errors
    /// Those of [`Self::ready`].
    pub fn ready_recording(&self, path: &Path) -> Result<()> {
        no_stdout(path)?;
        named(path)?;
        pair(path).iter().try_for_each(|file| self.ready(file))
    }

    /// Checks the files `names` of a folder, as [`Self::ready`] does for one; creates the folder if it is missing.
    ///
    /// # Errors
    /// Those of [`Self::ready`], or the folder cannot be created; the message names it.
    pub fn ready_folder(&self, dir: &Path, names: &[String]) -> Result<()> {
        folder(dir)?;
        let mut paths = names.iter().map(|name| dir.join(name));
        paths.try_for_each(|path| self.ready(&path))
    }

    /// Writes a file completely or not at all.
    ///
    /// # Errors
    /// Those of [`Self::check`], or the file cannot be written.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<()> {
        self.check(path)?;
        write_together(&[(path, bytes, Readers::All)], || self.check(path))
    }

    /// Writes the files of a folder, by name: all of them or none, so that two programs do not mix theirs. Creates the
    /// folder if it is missing.
    ///
    /// # Errors
    /// Those of [`Self::check`] for each file, another program is writing one of them, or one cannot be written; the
    /// message names it.
    pub fn write_folder(&self, dir: &Path, files: &[(String, Vec<u8>)]) -> Result<()> {
        no_stdout(dir)?;
        let paths: Vec<PathBuf> = files.iter().map(|(name, _)| dir.join(name)).collect();
        let check = || paths.iter().try_for_each(|path| self.check(path));
        check()?;
        fs::create_dir_all(dir).with_context(|| format!("{}", dir.display()))?;
        let contents = paths.iter().zip(files);
        let contents: Vec<Content<'_>> = contents
            .map(|(path, (_, bytes))| (path.as_path(), &bytes[..], Readers::All))
            .collect();
        write_together(&contents, check)
    }

    /// Writes a file as [`Self::write`] does, and creates its directory if that is missing.
    ///
    /// # Errors
    /// The directory or the file cannot be written; the message names it.
    pub fn write_picture(&self, path: &Path, bytes: &[u8]) -> Result<()> {
        self.check(path)?;
        if let Some(dir) = path.parent().filter(|d| !d.as_os_str().is_empty()) {
            fs::create_dir_all(dir)
                .with_context(|| format!("{}: no directory for pictures", dir.display()))?;
        }
        self.write(path, bytes)
    }

    /// Writes a recording's two files.
    ///
    /// # Errors
    /// Those of [`Self::check_recording`], or a file cannot be written.
    pub fn write_recording(&self, path: &Path, recording: &Recording) -> Result<()> {
        self.check_recording(path)?;
        recording.write_checked(path, || self.check_recording(path))
    }
}

/// Refuses `-`, by which other programs mean stdout, and a file in a directory of that name: no command writes its output
/// there.
///
/// # Errors
/// The path is `-`, or begins with it.
pub fn no_stdout(path: &Path) -> Result<()> {
    ensure!(
        path.components().next() != Some(Component::Normal("-".as_ref())),
        "{}: outputs are not written to stdout: expected a name, ./- for one of that name",
        path.display()
    );
    Ok(())
}

/// Creates an output's folder, if it is missing.
///
/// # Errors
/// That of [`no_stdout`], or the folder cannot be created; the message names it.
pub fn folder(dir: &Path) -> Result<()> {
    no_stdout(dir)?;
    fs::create_dir_all(dir).with_context(|| format!("{}", dir.display()))
}

/// Returns the paths of metadata and samples of a recording named with or without suffix.
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
