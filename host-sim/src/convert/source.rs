//! Inputs of `convert` on the disk: recordings, SigMF of other programs, numpy arrays, captures of
//! TI's DCA1000.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use stairscan_replay::convert::keys::Given;
use stairscan_replay::convert::npy::{Axes, Layout};
use stairscan_replay::convert::{Chirps, angles, mirrored, sigmf, suffix};

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
    /// Whether each row of an array holds all I of a chirp, then all Q.
    pub planar: bool,
}

/// Reads a whole file.
fn bytes(path: &Path) -> Result<Vec<u8>> {
    recording::regular(path)?;
    fs::read(path).with_context(|| format!("{}", path.display()))
}

fn text(path: &Path) -> Result<String> {
    recording::regular(path)?;
    recording::text(path)
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
        let ours = matches!(datatype, Some("ci16_le" | "ri16_le"));
        let is_whole = ours && !sigmf::begins_late(&metadata);
        Ok(is_whole && !has_options && self.full_scale.is_none())
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
        for (option, is_given) in [("--real", self.real.is_some()), ("--planar", self.planar)] {
            ensure!(
                !is_given || suffix(&self.path) == "npy",
                "{}: {option} is about the axes of an array: expected .npy",
                self.path.display()
            );
        }
        if self.is_recording()? {
            return Recording::read(&self.path);
        }
        let base = self.keys_of.as_ref();
        let base = base.map(|path| sigmf::metadata(path)).transpose()?;
        let chirps = self.chirps(base.as_ref())?;
        let angles = self.angles(chirps.count())?;
        let note = |words: &str| crate::note!("note: {}: {words}", self.path.display());
        chirps.left_out.iter().for_each(|words| note(words));
        let recording = chirps.recording(name, &self.given, base.as_ref(), angles.as_deref());
        let recording = recording.with_context(|| format!("{}", self.path.display()))?;
        if let Some(words) = mirrored::warning(&recording)? {
            note(&words);
        }
        Ok(recording)
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

    /// Returns the arrangement of an array's numbers. `samples` is the number of samples per chirp, if it is known.
    fn layout(&self, samples: Option<usize>) -> Layout {
        match &self.real {
            Some(axes) => Layout::Real(axes.clone()),
            None if self.planar => Layout::Planar,
            None => Layout::ByShape(samples),
        }
    }

    /// Reads the chirps; `base` are the metadata of the recording that supplies keys.
    fn chirps(&self, base: Option<&Value>) -> Result<Chirps> {
        let of_base = base.and_then(|base| base["global"]["stairscan:samples_per_chirp"].as_u64());
        let of_base = of_base.and_then(|samples| usize::try_from(samples).ok());
        let known = self.given.samples_per_chirp.or(of_base);
        let file = || format!("{}", self.path.display());
        let chirps = match suffix(&self.path) {
            "npy" => {
                let (file_bytes, layout) = (bytes(&self.path)?, self.layout(known));
                Chirps::of_array(&file_bytes, self.full_scale, &layout).with_context(file)?
            }
            "bin" => self.capture()?,
            _ => {
                let metadata = sigmf::metadata(&self.path)?;
                let data = recording::meta_path(&self.path).with_extension(DATA_SUFFIX);
                let data = bytes(&data)?;
                Chirps::of_sigmf(metadata, &data, self.full_scale, known).with_context(file)?
            }
        };
        if let Some(given) = self.given.samples_per_chirp {
            let (kind, found) = match chirps.real {
                false => ("complex", chirps.samples_per_chirp),
                true => ("real", 2 * chirps.samples_per_chirp),
            };
            ensure!(
                given == found,
                "{}: {found} {kind} samples in a chirp, --samples-per-chirp is {given}",
                self.path.display()
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
            left_out: Vec::new(),
        })
    }
}
