//! Disk cache of simulated recordings: returns the recording of a key and simulates it only if it is not
//! stored.
//!
//! An entry is one file. Its name is a checksum of the key. The file also contains the key, so that two
//! keys never share an entry. The revision of the simulator is part of the key, so that a changed
//! simulator does not use old entries. Files are written under a temporary name and renamed, and a file
//! that is not complete counts as absent. Therefore the directory may be deleted at any time, and several
//! programs may use it at once. When it exceeds its limit, the least recently used entries are removed.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

use anyhow::Result;
use crc::{CRC_32_ISO_HDLC, CRC_64_XZ, Crc};

use crate::recording::Recording;

/// Environment variable with the directory of the cache, used instead of `target/simulated`; `off`
/// for no cache.
pub const VARIABLE: &str = "STAIRSCAN_CACHE";
/// Maximum total size of the cache's files, bytes: enough for the scans of all draws.
const MAX_BYTES: u64 = 12 << 30;
/// Size to which the cache is reduced when it exceeds its maximum, per cent of the maximum.
const KEPT_PERCENT: u64 = 80;
/// Number of entries written between two checks of the directory's size.
const WRITES_PER_LOOK: u64 = 256;
/// First bytes of the file of an entry, which mark its format.
const MAGIC: &[u8; 8] = b"STAIRSC1";
/// Suffix of the name of an entry's file.
const SUFFIX: &str = "scan";
/// Revision of the simulator: a checksum that build.rs computes.
const REVISION: &str = env!("SIMULATOR_REVISION");

const NAME: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Disk cache in one directory, with a file for each recording.
#[derive(Debug)]
pub struct Cache {
    directory: PathBuf,
    most_bytes: u64,
    writes: AtomicU64,
}

/// Returns the recording that `key` describes, with the name `name`: from the workspace's cache, or
/// simulated and then stored.
///
/// # Errors
/// Those of `simulate`.
pub fn recording(
    name: &str,
    key: &str,
    simulate: impl FnOnce() -> Result<Recording>,
) -> Result<Recording> {
    static SHARED: OnceLock<Option<Cache>> = OnceLock::new();
    let shared = SHARED.get_or_init(|| {
        let directory = match std::env::var_os(VARIABLE) {
            Some(off) if off == "off" => return None,
            Some(directory) => PathBuf::from(directory),
            None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/simulated"),
        };
        Some(Cache::new(directory, MAX_BYTES))
    });
    match shared {
        Some(cache) => cache.recording(name, key, simulate),
        None => simulate(),
    }
}

impl Cache {
    /// Creates a cache in `directory` of at most `most_bytes`. The directory need not exist yet.
    pub fn new(directory: PathBuf, most_bytes: u64) -> Self {
        Self {
            directory,
            most_bytes,
            writes: AtomicU64::new(0),
        }
    }

    /// Returns the recording that `key` describes, with the name `name`: the stored one, or the
    /// result of `simulate`, which is then stored. A directory that cannot be written to costs only
    /// time.
    ///
    /// # Errors
    /// Those of `simulate`.
    pub fn recording(
        &self,
        name: &str,
        key: &str,
        simulate: impl FnOnce() -> Result<Recording>,
    ) -> Result<Recording> {
        let key = format!("{REVISION}\n{name}\n{key}");
        let path = self.path(&key);
        if let Some(found) = read(&path, name, &key) {
            return Ok(found);
        }
        let recording = simulate()?;
        if self.write(&path, &key, &recording).is_ok()
            && self
                .writes
                .fetch_add(1, Ordering::Relaxed)
                .is_multiple_of(WRITES_PER_LOOK)
        {
            // A failed check is repeated after the next writes.
            let _ = self.trim();
        }
        Ok(recording)
    }

    fn path(&self, key: &str) -> PathBuf {
        let sum = NAME.checksum(key.as_bytes());
        self.directory.join(format!("{sum:016x}.{SUFFIX}"))
    }

    fn write(&self, path: &Path, key: &str, recording: &Recording) -> Result<()> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let bytes = encode(key, recording)?;
        fs::create_dir_all(&self.directory)?;
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let part = path.with_extension(format!("{}-{number}.part", std::process::id()));
        let written = fs::write(&part, bytes).and_then(|()| fs::rename(&part, path));
        if written.is_err() {
            // No file is left after a failed write.
            let _ = fs::remove_file(&part);
        }
        Ok(written?)
    }

    /// Removes the least recently used entries, and files of interrupted programs, if the cache
    /// exceeds its maximum size.
    fn trim(&self) -> io::Result<()> {
        let mut entries = Vec::new();
        for entry in fs::read_dir(&self.directory)? {
            let entry = entry?;
            // Another program may have removed it.
            if let Ok(meta) = entry.metadata() {
                entries.push((meta.modified()?, meta.len(), entry.path()));
            }
        }
        let mut total: u64 = entries.iter().map(|(_, size, _)| size).sum();
        if total <= self.most_bytes {
            return Ok(());
        }
        entries.sort();
        for (_, size, path) in entries {
            if total <= self.most_bytes / 100 * KEPT_PERCENT {
                break;
            }
            let _ = fs::remove_file(path);
            total -= size;
        }
        Ok(())
    }
}

/// Returns the bytes of an entry's file: magic, lengths of key and metadata, key, metadata,
/// samples, checksum of all.
fn encode(key: &str, recording: &Recording) -> Result<Vec<u8>> {
    let meta = recording.metadata_text()?;
    let mut bytes = Vec::from(MAGIC);
    for part in [key, &meta] {
        bytes.extend((part.len() as u32).to_le_bytes());
    }
    bytes.extend(key.as_bytes());
    bytes.extend(meta.as_bytes());
    bytes.extend(recording.sample_bytes());
    let sum = CHECK.checksum(&bytes);
    bytes.extend(sum.to_le_bytes());
    Ok(bytes)
}

/// Returns the recording in an entry's file and marks the entry as used; `None` unless the file is
/// complete and has this key.
fn read(path: &Path, name: &str, key: &str) -> Option<Recording> {
    let bytes = fs::read(path).ok()?;
    let recording = decode(&bytes, name, key)?;
    // A failure affects only the order of removal.
    let _ = File::options()
        .append(true)
        .open(path)
        .and_then(|file| file.set_modified(SystemTime::now()));
    Some(recording)
}

fn decode(bytes: &[u8], name: &str, key: &str) -> Option<Recording> {
    let (rest, sum) = bytes.split_last_chunk::<4>()?;
    if CHECK.checksum(rest) != u32::from_le_bytes(*sum) {
        return None;
    }
    let rest = rest.strip_prefix(MAGIC.as_slice())?;
    let (key_length, rest) = rest.split_first_chunk::<4>()?;
    let (meta_length, rest) = rest.split_first_chunk::<4>()?;
    let (found, rest) = rest.split_at_checked(u32::from_le_bytes(*key_length) as usize)?;
    let (meta, samples) = rest.split_at_checked(u32::from_le_bytes(*meta_length) as usize)?;
    if found != key.as_bytes() {
        return None;
    }
    Recording::parse(name, str::from_utf8(meta).ok()?, samples).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Kind, random};
    use crate::scene::Scene;

    fn directory(name: &str) -> PathBuf {
        let directory =
            std::env::temp_dir().join(format!("stairscan-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&directory);
        directory
    }

    fn simulated(seed: u64) -> Result<Recording> {
        Ok(Scene::new(random(Kind::Mounting, seed))?.simulate("scan", seed))
    }

    fn same(a: &Recording, b: &Recording) -> bool {
        a.name == b.name
            && a.samples == b.samples
            && a.metadata_text().unwrap() == b.metadata_text().unwrap()
            && a.meta.angles_deg == b.meta.angles_deg
            && a.meta.truth == b.meta.truth
    }

    fn absent() -> Result<Recording> {
        panic!("simulated though the entry is there")
    }

    #[test]
    fn an_entry_is_the_recording_that_was_simulated() {
        let directory = directory("entry");
        let cache = Cache::new(directory.clone(), u64::MAX);
        let first = cache.recording("scan", "3", || simulated(3)).unwrap();
        let again = cache.recording("scan", "3", absent).unwrap();
        assert!(same(&first, &again) && same(&first, &simulated(3).unwrap()));
        let other = cache.recording("scan", "4", || simulated(4)).unwrap();
        assert!(!same(&first, &other));
        fs::remove_dir_all(directory).unwrap();
    }

    #[test]
    fn a_damaged_entry_and_another_key_s_are_simulated_anew() {
        let directory = directory("damaged");
        let cache = Cache::new(directory.clone(), u64::MAX);
        let first = cache.recording("scan", "3", || simulated(3)).unwrap();
        let path = cache.path(&format!("{REVISION}\nscan\n3"));
        let whole = fs::read(&path).unwrap();
        for length in [0, 3, 100, whole.len() - 1] {
            fs::write(&path, &whole[..length]).unwrap();
            let again = cache.recording("scan", "3", || simulated(3)).unwrap();
            assert!(same(&first, &again));
        }
        let mut flipped = whole.clone();
        flipped[whole.len() / 2] ^= 1;
        fs::write(&path, &flipped).unwrap();
        assert!(read(&path, "scan", &format!("{REVISION}\nscan\n3")).is_none());
        fs::write(&path, &whole).unwrap();
        assert!(read(&path, "scan", "another revision's").is_none());
        fs::remove_dir_all(directory).unwrap();
    }

    #[test]
    fn the_directory_keeps_its_bound_and_the_entries_in_use() {
        let directory = directory("bound");
        let cache = Cache::new(directory.clone(), 2_000_000);
        for seed in 0..6 {
            let key = seed.to_string();
            cache.recording("scan", &key, || simulated(seed)).unwrap();
            // The first entry is used repeatedly, and each write checks the size.
            cache.recording("scan", "0", || simulated(0)).unwrap();
            cache.writes.store(0, Ordering::Relaxed);
            cache.trim().unwrap();
        }
        let entries: Vec<_> = fs::read_dir(&directory).unwrap().flatten().collect();
        let sizes = entries.iter().map(|e| e.metadata().unwrap().len());
        assert!(sizes.sum::<u64>() <= 2_000_000 && !entries.is_empty());
        cache.recording("scan", "0", absent).unwrap();
        fs::remove_dir_all(directory).unwrap();
    }

    #[test]
    fn a_directory_that_cannot_be_made_costs_nothing_but_time() {
        let file = directory("file");
        fs::write(&file, "no directory").unwrap();
        let cache = Cache::new(file.clone(), u64::MAX);
        let first = cache.recording("scan", "3", || simulated(3)).unwrap();
        assert!(same(&first, &simulated(3).unwrap()));
        fs::remove_file(file).unwrap();
    }

    #[test]
    fn programs_at_once_read_whole_entries() {
        let directory = directory("at-once");
        let [a, b] = [(); 2].map(|()| Cache::new(directory.clone(), u64::MAX));
        let expected: Vec<Recording> = (0..3).map(|seed| simulated(seed).unwrap()).collect();
        std::thread::scope(|scope| {
            for cache in [&a, &b] {
                let expected = &expected;
                scope.spawn(move || {
                    for k in 0..12 {
                        let seed = k % 3;
                        let simulate = || simulated(seed);
                        let got = cache.recording("scan", &seed.to_string(), simulate);
                        assert!(same(&got.unwrap(), &expected[seed as usize]));
                    }
                });
            }
        });
        fs::remove_dir_all(directory).unwrap();
    }
}
