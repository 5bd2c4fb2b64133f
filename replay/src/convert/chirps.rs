//! Chirps of other programs' files in memory, and their conversion to a recording.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use serde_json::Value;
use stairscan::Iq;

use super::keys::{self, Given};
use super::npy::{self, Axes};
use super::{samples, sigmf};
use crate::recording::Recording;

/// Chirps of another program's file, in memory.
#[derive(Clone, Debug)]
pub struct Chirps {
    /// Samples, one chirp after another.
    pub samples: Vec<Iq>,
    /// Number of complex samples of one chirp, or of pairs of real ones.
    pub samples_per_chirp: usize,
    /// Whether the samples are real: I and Q of each are then two consecutive samples.
    pub real: bool,
    /// SigMF metadata of the source; null for an array.
    pub metadata: Value,
}

impl Chirps {
    /// Reads the chirps of a `.npy` file, of complex samples or, with the array's axes, of real ones.
    /// `full_scale` is the number at full scale, by default 1.0 or the converter's range; unsigned numbers
    /// have their zero there.
    ///
    /// # Errors
    /// Names the header's key, the length or the sample, and the expected value.
    pub fn of_array(file: &[u8], full_scale: Option<f64>, real: Option<&Axes>) -> Result<Self> {
        let array = npy::read(file, real)?;
        let ns = array.samples_per_chirp;
        Ok(Self {
            samples: samples::decode(&array.bytes, array.format, full_scale, ns)?,
            samples_per_chirp: ns,
            real: real.is_some(),
            metadata: Value::Null,
        })
    }

    /// Reads the chirps of a SigMF pair of any complex datatype. `given` is the number of samples
    /// per chirp if the metadata do not contain it.
    ///
    /// # Errors
    /// Names the key, the length or the sample, and the expected value.
    pub fn of_sigmf(
        metadata: Value,
        data: &[u8],
        full_scale: Option<f64>,
        given: Option<usize>,
    ) -> Result<Self> {
        let format = sigmf::format(&metadata)?;
        let stated = metadata["global"][keys::SAMPLES].as_u64();
        let stated = stated.and_then(|n| usize::try_from(n).ok());
        let Some(ns) = stated.or(given).filter(|n| *n > 0) else {
            bail!("missing: {} (--samples-per-chirp)", keys::SAMPLES);
        };
        let chirp = ns.saturating_mul(2 * format.bytes);
        ensure!(
            !data.is_empty() && data.len().is_multiple_of(chirp),
            "{} bytes of samples, expected whole chirps of {ns} samples of {} bytes",
            data.len(),
            2 * format.bytes
        );
        Ok(Self {
            samples: samples::decode(data, format, full_scale, ns)?,
            samples_per_chirp: ns,
            real: false,
            metadata,
        })
    }

    /// Returns the number of chirps in memory.
    pub fn count(&self) -> usize {
        self.samples.len() / self.samples_per_chirp.max(1)
    }

    /// Returns these chirps as the recording `name`, with one angle per chirp, degrees. The keys of `given` replace
    /// those of `base`, or without `base` those of the chirps' own metadata.
    ///
    /// # Errors
    /// Names the keys that are missing or wrong.
    pub fn recording(
        self,
        name: &str,
        given: &Given,
        base: Option<&Value>,
        angles: Option<&[f64]>,
    ) -> Result<Recording> {
        let values = self.samples_per_chirp * (1 + usize::from(self.real));
        let size = (self.count(), values);
        let base = base.unwrap_or(&self.metadata);
        let document = given.document(base, size, self.real, angles)?;
        Recording::of(name, &document, self.samples)
    }
}

/// Returns a path's suffix without its dot; empty if it has none.
pub fn suffix(path: &Path) -> &str {
    path.extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default()
}
