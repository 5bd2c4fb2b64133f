//! Other programs' files to recordings, and recordings to other programs' files.
//!
//! | file | format |
//! |---|---|
//! | `npy.rs` | numpy's arrays, in and out |
//! | `dca1000.rs` | captures of TI's DCA1000, in |
//! | `sigmf.rs` | SigMF of others, in |
//! | `angles.rs` | tables of angles, in |
//! | `tables.rs` | CSV of steps, echoes and map, out |
//! | `mcap.rs` | MCAP, out |
//! | `messages.rs`, `ros.rs` | topics and messages of a scan, in MCAP and live; ROS 2's definitions and encoding |
//! | `samples.rs`, `keys.rs` | numbers to 16 bits; what an input does not say of itself |
//! | `scans.rs` | what the scanner makes of a recording, for the outputs |
//!
//! What stands in the outputs is what `replay --format json` and `inspect --format json` print: taken from
//! the same objects, number for number. docs/formats.md is for users.

pub mod angles;
pub mod dca1000;
pub mod keys;
pub mod mcap;
pub mod messages;
pub mod npy;
pub(crate) mod ros;
pub mod samples;
pub mod scans;
pub mod sigmf;
pub mod tables;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;
use stairscan::Iq;

use crate::recording::{self, DATA_SUFFIX, META_SUFFIX, Recording};
use keys::Given;

/// Chirps from elsewhere, and where what they do not say comes from.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// The TOML file of a DCA1000's capture; without it the one of the capture's name.
    pub setup: Option<PathBuf>,
    /// One angle a chirp.
    pub angles: Option<PathBuf>,
    /// The recording whose keys hold where none is given.
    pub keys_of: Option<PathBuf>,
    /// Keys given one by one.
    pub given: Given,
    /// The value that is full scale.
    pub full_scale: Option<f64>,
}

/// Chirps in memory.
struct Chirps {
    samples: Vec<Iq>,
    samples_per_chirp: usize,
    /// What they say of themselves.
    metadata: Value,
}

/// What a path's suffix says.
pub fn suffix(path: &Path) -> &str {
    path.extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default()
}

/// A whole file.
fn bytes(path: &Path) -> Result<Vec<u8>> {
    recording::regular(path)?;
    fs::read(path).with_context(|| format!("{}", path.display()))
}

fn text(path: &Path) -> Result<String> {
    String::from_utf8(bytes(path)?).with_context(|| format!("{}: no text in UTF-8", path.display()))
}

impl Source {
    /// Whether the path names a recording that needs nothing from elsewhere: it is taken as it is.
    fn is_recording(&self) -> Result<bool> {
        if matches!(suffix(&self.path), "npy" | "bin") {
            return Ok(false);
        }
        let told = self.given.any() || self.angles.is_some() || self.keys_of.is_some();
        let metadata = sigmf::metadata(&self.path)?;
        let datatype = metadata["global"]["core:datatype"].as_str();
        // Real samples come in as they are or not at all: with keys from elsewhere they are refused.
        let ours = matches!(datatype, Some("ci16_le" | "ri16_le"));
        Ok(ours && !told && self.full_scale.is_none())
    }

    /// The recording, under the name `name`.
    ///
    /// # Errors
    /// Names the file, the key or the place, and what was expected.
    pub fn read(&self, name: &str) -> Result<Recording> {
        if let Some(scale) = self.full_scale {
            ensure!(
                scale.is_finite() && scale > 0.0,
                "--full-scale: {scale}: expected a number above 0"
            );
        }
        if self.is_recording()? {
            return Recording::read(&self.path);
        }
        let file = format!("{}", self.path.display());
        let chirps = self.chirps()?;
        let count = chirps.samples.len() / chirps.samples_per_chirp.max(1);
        let angles = self.angles(count)?;
        let base = match &self.keys_of {
            Some(path) => sigmf::metadata(path)?,
            None => chirps.metadata,
        };
        let size = (count, chirps.samples_per_chirp);
        let document = self.given.document(&base, size, angles.as_deref());
        let document = document.with_context(|| file.clone())?;
        Recording::of(name, &document, chirps.samples).with_context(|| file)
    }

    /// The angles of the table, as many as there are chirps.
    fn angles(&self, chirps: usize) -> Result<Option<Vec<f64>>> {
        let Some(path) = &self.angles else {
            return Ok(None);
        };
        let angles = angles::parse(&text(path)?).with_context(|| format!("{}", path.display()))?;
        ensure!(
            angles.len() == chirps,
            "{}: {} angles, expected {chirps}: one a chirp of {}",
            path.display(),
            angles.len(),
            self.path.display()
        );
        Ok(Some(angles))
    }

    fn chirps(&self) -> Result<Chirps> {
        let file = || format!("{}", self.path.display());
        let chirps = match suffix(&self.path) {
            "npy" => self.array(&bytes(&self.path)?).with_context(file)?,
            "bin" => self.capture()?,
            _ => {
                let metadata = sigmf::metadata(&self.path)?;
                let data = recording::meta_path(&self.path).with_extension(DATA_SUFFIX);
                let data = bytes(&data)?;
                self.foreign(metadata, &data).with_context(file)?
            }
        };
        if let Some(given) = self.given.samples_per_chirp {
            ensure!(
                given == chirps.samples_per_chirp,
                "{}: {} complex samples in a chirp, --samples-per-chirp says {given}{}",
                self.path.display(),
                chirps.samples_per_chirp,
                if given == 2 * chirps.samples_per_chirp {
                    ": real samples are refused"
                } else {
                    ""
                }
            );
        }
        Ok(chirps)
    }

    fn array(&self, file: &[u8]) -> Result<Chirps> {
        let array = npy::read(file)?;
        let ns = array.samples_per_chirp;
        Ok(Chirps {
            samples: samples::decode(&array.bytes, array.format, self.full_scale, ns)?,
            samples_per_chirp: ns,
            metadata: Value::Null,
        })
    }

    fn capture(&self) -> Result<Chirps> {
        ensure!(
            self.full_scale.is_none(),
            "--full-scale: of a DCA1000's capture adc_bits says it"
        );
        let beside = self.path.with_extension("toml");
        let file = self.setup.as_ref().unwrap_or(&beside);
        let setup =
            text(file).context("a DCA1000's capture needs a TOML file beside it (--setup FILE)")?;
        let setup = dca1000::Setup::parse(&setup).with_context(|| format!("{}", file.display()))?;
        let samples = setup.samples(&bytes(&self.path)?);
        Ok(Chirps {
            samples: samples.with_context(|| format!("{}", self.path.display()))?,
            samples_per_chirp: setup.samples_per_chirp,
            metadata: Value::Null,
        })
    }

    fn foreign(&self, metadata: Value, data: &[u8]) -> Result<Chirps> {
        let format = sigmf::format(&metadata)?;
        let told = metadata["global"][keys::SAMPLES].as_u64();
        let told = told.and_then(|n| usize::try_from(n).ok());
        let Some(ns) = told.or(self.given.samples_per_chirp).filter(|n| *n > 0) else {
            bail!("missing: {} (--samples-per-chirp)", keys::SAMPLES);
        };
        let chirp = ns.saturating_mul(2 * format.bytes);
        ensure!(
            !data.is_empty() && data.len().is_multiple_of(chirp),
            "{} bytes of samples, expected whole chirps of {ns} samples of {} bytes",
            data.len(),
            2 * format.bytes
        );
        Ok(Chirps {
            samples: samples::decode(data, format, self.full_scale, ns)?,
            samples_per_chirp: ns,
            metadata,
        })
    }
}

/// The name of a recording written to `path`, or of any file: without directory and suffix.
pub fn name(path: &Path) -> String {
    match suffix(path) {
        META_SUFFIX | DATA_SUFFIX | "npy" | "bin" => recording::name_of(path),
        _ => path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
    }
}

#[cfg(test)]
mod tests;
