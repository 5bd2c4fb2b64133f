//! Recorded scans: SigMF 1.2 pairs with the project's `stairscan:` keys.
//!
//! `NAME.sigmf-meta` is JSON, `NAME.sigmf-data` holds the interleaved little-endian 16-bit I and Q
//! of all chirps one after another, or their real samples. A range profile needs only datatype, Ns
//! and bandwidth, so that recordings of radars without a mirror can be read too.
//! [`Recording::scan_setup`] checks the other keys that a scan needs. A recording may hold several
//! scans, which [`Recording::scan`] separates. Every error names the file, the key and the expected
//! value.

mod captures;
mod keys;
mod metadata;
mod motion;
mod part;
pub(crate) mod standard;
mod truth;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail, ensure};
use serde_json::Value;
use stairscan::Iq;

pub use captures::degrees;
use keys::explain_syntax;
pub use metadata::{KeyLimits, MAX_CHIRPS, Metadata, MirrorSetup, Sequence};
pub use motion::Motion;
pub use part::{Content, Readers, named, writable, write_together};
pub use truth::{Disturbance, TrueDrop, TrueStep, Truth};

/// Suffix of the metadata file.
pub const META_SUFFIX: &str = "sigmf-meta";
/// Suffix of the sample file.
pub const DATA_SUFFIX: &str = "sigmf-data";

/// One recording in memory: metadata and samples.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Base name of the recording's files, without directory and suffix.
    pub name: String,
    /// Metadata from the recording's SigMF document.
    pub meta: Metadata,
    /// Samples of all chirps, one after another; real samples are stored in pairs.
    pub samples: Vec<Iq>,
}

/// Returns the path of the metadata file of `path`, given with or without a suffix.
pub fn meta_path(path: &Path) -> PathBuf {
    with_suffix(path, META_SUFFIX)
}

/// Returns the name of the recording whose metadata file is `meta_file`, without directory and
/// suffix.
pub fn name_of(meta_file: &Path) -> String {
    let stem = meta_file.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    match path.extension().and_then(|e| e.to_str()) {
        Some(META_SUFFIX | DATA_SUFFIX) => path.with_extension(suffix),
        // Not `with_extension`, because a dot within the name is no suffix.
        _ => {
            let mut name = path.as_os_str().to_owned();
            name.push(".");
            name.push(suffix);
            PathBuf::from(name)
        }
    }
}

/// Returns an error for a path that is no regular file: a directory, a pipe, a device.
///
/// # Errors
/// Names the path.
pub fn regular(path: &Path) -> Result<()> {
    let found = fs::metadata(path).with_context(|| format!("{}", path.display()))?;
    ensure!(
        found.is_file(),
        "{}: expected a regular file",
        path.display()
    );
    Ok(())
}

/// Whether a path may name a recording: one of its two files, or both without their suffix.
pub fn may_be(path: &Path) -> bool {
    let suffix = path.extension().and_then(|e| e.to_str());
    matches!(suffix, Some(META_SUFFIX | DATA_SUFFIX)) || meta_path(path).exists() || !path.exists()
}

/// Returns the paths of the metadata files in a directory, sorted by name; an error if there are
/// none.
pub fn list(dir: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(dir).with_context(|| format!("{}", dir.display()))?;
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| format!("{}", dir.display()))?.path();
        if path.extension().is_some_and(|e| e == META_SUFFIX) {
            found.push(path);
        }
    }
    ensure!(
        !found.is_empty(),
        "{}: holds no recording (*.{META_SUFFIX})",
        dir.display()
    );
    found.sort();
    Ok(found)
}

impl Recording {
    /// Reads the recording (metadata and sample file) that `path` names, with or without a suffix.
    ///
    /// # Errors
    /// Names the file, the key and the expected value.
    pub fn read(path: &Path) -> Result<Self> {
        let meta_file = with_suffix(path, META_SUFFIX);
        let named = meta_file.with_extension("");
        ensure!(
            meta_file.exists() || !named.exists(),
            "{}: no recording, expected the name of a pair NAME.{META_SUFFIX}, NAME.{DATA_SUFFIX}; \
             `cargo sim convert` makes one of samples",
            named.display()
        );
        regular(&meta_file)?;
        let (document, meta) = metadata(&text(&meta_file)?, &meta_file)?;
        let data_file = with_suffix(path, DATA_SUFFIX);
        let data = read_data(&data_file, &meta)?;
        standard::check_hash(&document, &data)
            .with_context(|| format!("{}", meta_file.display()))?;
        Ok(Self {
            name: name_of(&meta_file),
            meta,
            samples: samples(&data),
        })
    }

    /// Creates the recording `name` from the text of its metadata file and the bytes of its sample
    /// file.
    ///
    /// # Errors
    /// Names the file, the key and the expected value.
    pub fn parse(name: &str, text: &str, data: &[u8]) -> Result<Self> {
        let file = |suffix: &str| PathBuf::from(format!("{name}.{suffix}"));
        let (document, meta) = metadata(text, &file(META_SUFFIX))?;
        check_length(data.len() as u64, &meta, &file(DATA_SUFFIX))?;
        standard::check_hash(&document, data)
            .with_context(|| format!("{}", file(META_SUFFIX).display()))?;
        Ok(Self {
            name: name.to_owned(),
            meta,
            samples: samples(data),
        })
    }

    /// Creates the recording `name` from samples and a document in the form of a metadata file.
    ///
    /// # Errors
    /// Names the key and the expected value.
    pub fn of(name: &str, document: &Value, samples: Vec<Iq>) -> Result<Self> {
        let meta = Metadata::parse(document)?;
        check_length(4 * samples.len() as u64, &meta, Path::new("samples"))?;
        Ok(Self {
            name: name.to_owned(),
            meta,
            samples,
        })
    }

    /// Returns the content of the metadata file: one line of JSON.
    ///
    /// # Errors
    /// None: JSON's numbers and strings cannot fail here.
    pub fn metadata_text(&self) -> Result<String> {
        let mut text = serde_json::to_string(&self.meta.document(self.chirps()))?;
        text.push('\n');
        Ok(text)
    }

    /// Returns the content of the sample file: 16-bit values, little-endian.
    pub fn sample_bytes(&self) -> Vec<u8> {
        let samples = self.samples.iter().flat_map(|s| {
            let ([a, b], [c, d]) = (s.i.to_le_bytes(), s.q.to_le_bytes());
            [a, b, c, d]
        });
        samples.collect()
    }

    /// Returns the samples of chirp `k`, counted from 0 over all scans; `None` beyond the last.
    pub fn chirp(&self, k: usize) -> Option<&[Iq]> {
        let ns = self.meta.samples_per_chirp;
        self.samples.get(k.checked_mul(ns)?..)?.get(..ns)
    }

    /// Returns the number of chirps of all scans.
    pub fn chirps(&self) -> usize {
        self.samples.len() / self.meta.samples_per_chirp.max(1)
    }

    /// Returns the number of scans, at least 1.
    pub fn scans(&self) -> usize {
        self.meta.sequence.scans.max(1)
    }

    /// Returns the number of chirps of each scan.
    pub fn chirps_per_scan(&self) -> usize {
        self.chirps() / self.scans()
    }

    /// Returns the range of chirp numbers of scan `k`, counted from 0.
    pub fn chirps_of(&self, k: usize) -> Range<usize> {
        let count = self.chirps_per_scan();
        k * count..(k + 1) * count
    }

    /// Returns scan `k`, counted from 0, as a recording of its own. If there are several, it is
    /// named `NAME-scanK` with K from 1. Its truth is that at the end of the scan, if the recording
    /// has one.
    pub fn scan(&self, k: usize) -> Self {
        let (meta, range) = (&self.meta, self.chirps_of(k));
        let ns = meta.samples_per_chirp;
        let samples = self.samples.get(range.start * ns..range.end * ns);
        let angles = meta.angles_deg.get(range.clone());
        let travel = meta.sequence.truth_travel_m.get(k);
        Self {
            name: match self.scans() {
                1 => self.name.clone(),
                _ => format!("{}-scan{}", self.name, k + 1),
            },
            meta: Metadata {
                angles_deg: angles.unwrap_or_default().to_vec(),
                motion: meta.motion.of(range),
                truth: self.truth(k).cloned(),
                sequence: Sequence {
                    scans: 1,
                    truth: Vec::new(),
                    truth_travel_m: travel.copied().into_iter().collect(),
                },
                ..meta.clone()
            },
            samples: samples.unwrap_or_default().to_vec(),
        }
    }

    /// Returns the truth of scan `k`, counted from 0; `None` if the recording has none.
    pub fn truth(&self, k: usize) -> Option<&Truth> {
        let whole = self.meta.truth.as_ref().filter(|_| self.scans() == 1);
        self.meta.sequence.truth.get(k).or(whole)
    }

    /// Returns mirror and mounting, which a scan needs.
    ///
    /// # Errors
    /// Names the key that is missing for a scan.
    pub fn scan_setup(&self) -> Result<&MirrorSetup> {
        metadata::mirror(&self.meta, &format!("{}.{META_SUFFIX}", self.name))
    }

    /// Writes metadata and sample file of the recording that `path` names. Each file appears
    /// completely or not at all.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.write_checked(path, || Ok(()))
    }

    /// Writes both files as [`Self::write`] does. `check` is called while no other program can write them.
    ///
    /// # Errors
    /// Names the file that cannot be written, or the error of `check`.
    pub fn write_checked(&self, path: &Path, check: impl FnOnce() -> Result<()>) -> Result<()> {
        named(path)?;
        let text = self.metadata_text()?;
        let [data, meta] = [DATA_SUFFIX, META_SUFFIX].map(|suffix| with_suffix(path, suffix));
        let files = [
            (&*data, &*self.sample_bytes(), Readers::All),
            (&*meta, text.as_bytes(), Readers::All),
        ];
        write_together(&files, check)
    }
}

/// Writes a file completely or not at all.
///
/// # Errors
/// Names the path if it is no regular file or cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    write_together(&[(path, bytes, Readers::All)], || Ok(()))
}

/// Reads a file of text. A byte order mark before it, which some editors write, is left out.
///
/// # Errors
/// Names the file, and the encoding if it is not UTF-8.
pub fn text(path: &Path) -> Result<String> {
    let file = || format!("{}", path.display());
    let bytes = fs::read(path).with_context(file)?;
    let utf16 = matches!(bytes.as_slice(), [0xff, 0xfe, ..] | [0xfe, 0xff, ..]);
    ensure!(
        !utf16,
        "{}: the byte order mark of UTF-16, expected text in UTF-8",
        path.display()
    );
    let text = String::from_utf8(bytes).with_context(|| format!("{}: no text in UTF-8", file()))?;
    Ok(unmarked(&text).to_owned())
}

/// Returns a text without the byte order mark that may stand before it.
pub fn unmarked(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// Parses the text of a metadata file, with or without a byte order mark, as a JSON document.
///
/// # Errors
/// Names the key before the mistake.
pub fn document(text: &str) -> Result<Value> {
    let text = unmarked(text);
    serde_json::from_str(text).map_err(|e| anyhow!("{}", explain_syntax(text, &e)))
}

/// Parses the metadata in `text`, the content of `file`.
fn metadata(text: &str, file: &Path) -> Result<(Value, Metadata)> {
    let parsed = document(text).and_then(|document| {
        let meta = Metadata::parse(&document)?;
        Ok((document, meta))
    });
    parsed.with_context(|| format!("{}", file.display()))
}

/// Returns an error for a sample file of `found` bytes that does not hold the number of chirps in
/// the metadata.
fn check_length(found: u64, meta: &Metadata, file: &Path) -> Result<()> {
    let chirp = 4 * meta.samples_per_chirp as u64;
    let each = if meta.real { 2 } else { 4 };
    let chirps = meta.angles_deg.len() as u64;
    if chirps > 0 && found != chirps * chirp {
        bail!(
            "{}: {found} bytes, expected {} ({chirps} captures of {} samples of {each} bytes)",
            file.display(),
            chirps * chirp,
            meta.file_samples()
        );
    }
    if found == 0 || !found.is_multiple_of(chirp) {
        bail!(
            "{}: {found} bytes, expected whole chirps of {} samples (stairscan:samples_per_chirp) of {each} bytes",
            file.display(),
            meta.file_samples()
        );
    }
    Ok(())
}

/// Returns the bytes of a sample file, whose length is compared with the metadata before it is
/// read.
fn read_data(path: &Path, meta: &Metadata) -> Result<Vec<u8>> {
    let context = || format!("{}", path.display());
    regular(path)?;
    let found = fs::metadata(path).with_context(context)?.len();
    check_length(found, meta, path)?;
    let bytes = fs::read(path).with_context(context)?;
    ensure!(
        bytes.len() as u64 == found,
        "{}: changed while it was read",
        path.display()
    );
    Ok(bytes)
}

fn samples(bytes: &[u8]) -> Vec<Iq> {
    let (samples, _) = bytes.as_chunks::<4>();
    let sample =
        |&[a, b, c, d]: &[u8; 4]| Iq::new(i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d]));
    samples.iter().map(sample).collect()
}
