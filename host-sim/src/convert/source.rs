//! Inputs of `convert` on the disk: recordings, SigMF of other programs, numpy arrays, captures of
//! TI's DCA1000.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use stairscan_replay::convert::keys::Given;
use stairscan_replay::convert::npy::Axes;
use stairscan_replay::convert::{Chirps, angles, sigmf, suffix};

use super::dca1000;
use crate::recording::{self, DATA_SUFFIX, Recording};

/// Chirps of another program's file, and the sources of the recording's keys that it lacks.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// File with the chirps.
    pub path: PathBuf,
    /// The TOML file that describes a DCA1000's capture; by default it has the capture's name.
    pub setup: Option<PathBuf>,
    /// Table with one angle per chirp, if the file contains none.
    pub angles: Option<PathBuf>,
    /// The recording that supplies keys that are not given one by one.
    pub keys_of: Option<PathBuf>,
    /// Keys of the recording that are given one by one.
    pub given: Given,
    /// The value of the file's numbers that counts as full scale; `None` for the default of their format.
    pub full_scale: Option<f64>,
    /// Axes of an array of real samples; `None` for complex samples.
    pub real: Option<Axes>,
}

/// Reads a whole file.
fn bytes(path: &Path) -> Result<Vec<u8>> {
    recording::regular(path)?;
    fs::read(path).with_context(|| format!("{}", path.display()))
}

fn text(path: &Path) -> Result<String> {
    String::from_utf8(bytes(path)?).with_context(|| format!("{}: no text in UTF-8", path.display()))
}

impl Source {
    /// Whether the path names a complete recording, which is taken unchanged.
    fn is_recording(&self) -> Result<bool> {
        if matches!(suffix(&self.path), "npy" | "bin") {
            return Ok(false);
        }
        let has_options = self.given.any() || self.angles.is_some() || self.keys_of.is_some();
        let metadata = sigmf::metadata(&self.path)?;
        let datatype = metadata["global"]["core:datatype"].as_str();
        // Real samples are taken unchanged or not at all: with other keys they are rejected.
        let ours = matches!(datatype, Some("ci16_le" | "ri16_le"));
        Ok(ours && !has_options && self.full_scale.is_none())
    }

    /// Reads the file as a recording with the name `name`.
    ///
    /// # Errors
    /// Names the file, the key or the place, and the expected value.
    pub fn read(&self, name: &str) -> Result<Recording> {
        if let Some(scale) = self.full_scale {
            ensure!(
                scale.is_finite() && scale > 0.0,
                "--full-scale: {scale}: expected a number above 0"
            );
        }
        ensure!(
            self.real.is_none() || suffix(&self.path) == "npy",
            "{}: --real names the axes of an array: expected .npy",
            self.path.display()
        );
        if self.is_recording()? {
            return Recording::read(&self.path);
        }
        let chirps = self.chirps()?;
        let angles = self.angles(chirps.count())?;
        let base = self.keys_of.as_ref();
        let base = base.map(|path| sigmf::metadata(path)).transpose()?;
        let recording = chirps.recording(name, &self.given, base.as_ref(), angles.as_deref());
        recording.with_context(|| format!("{}", self.path.display()))
    }

    /// Returns the angles of the table, one per chirp; `None` without a table. `chirps` is their expected number.
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
            "npy" => {
                let (file_bytes, real) = (bytes(&self.path)?, self.real.as_ref());
                Chirps::of_array(&file_bytes, self.full_scale, real).with_context(file)?
            }
            "bin" => self.capture()?,
            _ => {
                let metadata = sigmf::metadata(&self.path)?;
                let data = recording::meta_path(&self.path).with_extension(DATA_SUFFIX);
                let data = bytes(&data)?;
                let given = self.given.samples_per_chirp;
                Chirps::of_sigmf(metadata, &data, self.full_scale, given).with_context(file)?
            }
        };
        if let Some(given) = self.given.samples_per_chirp {
            let (kind, found) = match chirps.real {
                false => ("complex", chirps.samples_per_chirp),
                true => ("real", 2 * chirps.samples_per_chirp),
            };
            ensure!(
                given == found,
                "{}: {found} {kind} samples in a chirp, --samples-per-chirp is {given}{}",
                self.path.display(),
                if given == 2 * found {
                    ": --real AXES takes real samples"
                } else {
                    ""
                }
            );
        }
        Ok(chirps)
    }

    fn capture(&self) -> Result<Chirps> {
        ensure!(
            self.full_scale.is_none(),
            "--full-scale: of a DCA1000's capture it is given by adc_bits"
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
            real: false,
            metadata: Value::Null,
        })
    }
}
