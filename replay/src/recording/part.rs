//! Files that appear completely or not at all, and that one program at a time writes.
//!
//! Each is written under the temporary name `NAME.part`, which is locked meanwhile, and then renamed. What an
//! interrupted program has left under that name holds no lock and is replaced.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, ensure};

/// Who may read a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readers {
    /// Everybody whom the system lets.
    All,
    /// The file's owner only, from its creation on.
    Owner,
}

/// A file to write: its path, its content and who may read it.
pub type Content<'a> = (&'a Path, &'a [u8], Readers);

/// Writes files that belong together: each under its temporary name first, then all are renamed. `check` is called
/// while no other program can write them.
///
/// # Errors
/// Names the path that is no regular file, that another program is writing, or that cannot be written; or the error of
/// `check`. No file has changed then, unless renaming fails.
pub fn write_together(files: &[Content<'_>], check: impl FnOnce() -> Result<()>) -> Result<()> {
    let mut parts = Vec::new();
    for &(path, _, readers) in files {
        named(path)?;
        replaceable(path)?;
        parts.push(Part::claim(path, readers)?);
    }
    check()?;
    for (part, (path, bytes, readers)) in parts.iter_mut().zip(files) {
        part.fill(bytes, *readers).map_err(|e| failed(path, &e))?;
    }
    for (part, (path, ..)) in parts.iter_mut().zip(files) {
        part.rename(path).map_err(|e| failed(path, &e))?;
    }
    Ok(())
}

/// Checks that a file of this name can be made or replaced, by making another one beside it and removing it again.
///
/// # Errors
/// Names the path that is no regular file, or in whose directory no file can be made.
pub fn writable(path: &Path) -> Result<()> {
    named(path)?;
    replaceable(path)?;
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    // Not the name of a writer, which would meet this file at the end of a long session.
    name.push(format!(".{}.part", std::process::id()));
    let probe = path.with_file_name(name);
    let made = OpenOptions::new().write(true).create_new(true).open(&probe);
    drop(made.map_err(|e| failed(path, &e))?);
    fs::remove_file(&probe).map_err(|e| failed(path, &e))
}

/// Returns an error for a path that names no file: `/`, `..`, or one that ends in a separator or a
/// dot, whose files would be hidden.
///
/// # Errors
/// Names the path.
pub fn named(path: &Path) -> Result<()> {
    let text = path.as_os_str().as_encoded_bytes();
    let last = text
        .rsplit(|&b| std::path::is_separator(b.into()))
        .next()
        .unwrap_or_default();
    ensure!(
        !matches!(last, b"" | b"." | b".."),
        "{}: expected the name of a file, not of a directory",
        path.display()
    );
    Ok(())
}

/// Returns an error if something that is no regular file exists at the path, such as a device that
/// root could replace.
fn replaceable(path: &Path) -> Result<()> {
    let found = fs::metadata(path);
    ensure!(
        found.is_err() || found.is_ok_and(|found| found.is_file()),
        "{}: expected a regular file, or none yet",
        path.display()
    );
    Ok(())
}

fn failed(path: &Path, error: &io::Error) -> anyhow::Error {
    anyhow!("{}: {error}", path.display())
}

/// A locked file under its temporary name, removed unless it is renamed.
struct Part {
    path: PathBuf,
    file: File,
    renamed: bool,
}

impl Part {
    fn claim(path: &Path, readers: Readers) -> Result<Self> {
        let mut name = path.file_name().unwrap_or_default().to_os_string();
        name.push(".part");
        let part = path.with_file_name(name);
        let busy = || {
            anyhow!(
                "{}: another program is writing it: expected another name, or that it ends first",
                path.display()
            )
        };
        // Twice, if a left file was found.
        for _ in 0..2 {
            match created(&part, readers) {
                Ok(file) => {
                    if !locked(&file).map_err(|e| failed(path, &e))? || !stands(&file, &part) {
                        return Err(busy());
                    }
                    return Ok(Self {
                        path: part,
                        file,
                        renamed: false,
                    });
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(failed(path, &error)),
            }
            match OpenOptions::new().write(true).open(&part) {
                // The name still means the file that is locked here, so that no other program's is removed.
                Ok(left)
                    if locked(&left).map_err(|e| failed(path, &e))? && stands(&left, &part) =>
                {
                    fs::remove_file(&part).map_err(|e| failed(path, &e))?;
                }
                Ok(_) => return Err(busy()),
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(failed(path, &error)),
            }
        }
        Err(busy())
    }

    fn fill(&mut self, bytes: &[u8], readers: Readers) -> io::Result<()> {
        self.file.write_all(bytes)?;
        // A secret cannot be made again.
        match readers {
            Readers::Owner => self.file.sync_all(),
            Readers::All => Ok(()),
        }
    }

    fn rename(&mut self, to: &Path) -> io::Result<()> {
        fs::rename(&self.path, to)?;
        self.renamed = true;
        Ok(())
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if !self.renamed {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Creates a file that does not exist.
fn created(part: &Path, readers: Readers) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if readers == Readers::Owner {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    #[cfg(not(unix))]
    let _ = readers;
    options.open(part)
}

/// Locks a file unless another program has. File systems without locks have none to respect.
fn locked(file: &File) -> io::Result<bool> {
    match file.try_lock() {
        Ok(()) => Ok(true),
        Err(TryLockError::WouldBlock) => Ok(false),
        Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => Ok(true),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// Whether `path` still means this open file: until it is locked, another program may rename or remove it.
fn stands(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        let place = |found: io::Result<fs::Metadata>| found.ok().map(|m| (m.dev(), m.ino()));
        place(file.metadata()).is_some_and(|here| place(fs::metadata(path)) == Some(here))
    }
    #[cfg(not(unix))]
    {
        let _ = (file, path);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory of one test, with a path in it.
    fn place(test: &str) -> (PathBuf, PathBuf) {
        let dir = std::env::temp_dir().join(format!("stairscan-{test}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&dir);
        fs::create_dir_all(&dir).unwrap();
        let path = dir.join("out");
        (dir, path)
    }

    #[test]
    fn while_one_writes_another_is_refused_and_changes_nothing() {
        let (dir, path) = place("two-writers");
        let mut first = Part::claim(&path, Readers::All).unwrap();
        first.fill(b"first", Readers::All).unwrap();
        let second = write_together(&[(&path, b"second", Readers::All)], || Ok(()));
        let error = second.unwrap_err().to_string();
        assert!(error.contains("another program is writing it"), "{error}");
        first.rename(&path).unwrap();
        drop(first);
        assert_eq!(fs::read(&path).unwrap(), b"first");
        // Nothing is left that would refuse the next.
        write_together(&[(&path, b"third", Readers::All)], || Ok(())).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"third");
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn what_an_interrupted_program_left_is_replaced() {
        let (dir, path) = place("left-part");
        fs::write(dir.join("out.part"), b"half of it, and more than the whole").unwrap();
        write_together(&[(&path, b"whole", Readers::Owner)], || Ok(())).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            let mode = fs::metadata(&path).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
        }
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
        fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn files_that_belong_together_change_together() {
        let (dir, path) = place("together");
        let other = dir.join("other");
        let files: [Content<'_>; 2] = [(&path, b"a", Readers::All), (&other, b"b", Readers::All)];
        let refused = write_together(&files, || Err(anyhow!("checked")));
        assert_eq!(refused.unwrap_err().to_string(), "checked");
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 0);
        // The second file's name is taken by a directory.
        fs::create_dir(&other).unwrap();
        write_together(&files, || Ok(())).unwrap_err();
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
        fs::remove_dir_all(&dir).unwrap();
    }
}
