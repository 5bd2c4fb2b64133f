//! Chirps of other programs' files in memory, and their conversion to a recording.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use serde_json::Value;
use stairscan::Iq;

use super::keys::{self, Given};
use super::npy::{self, Layout};
use super::{samples, sigmf};
use crate::recording::{Recording, standard};

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
    /// Messages that name contents of the file that the chirps lack, such as annotations.
    pub left_out: Vec<String>,
}

impl Chirps {
    /// Reads the chirps of a `.npy` file, whose numbers are arranged as `layout` says. `full_scale` is the number at full scale, by default 1.0 or the converter's range; unsigned numbers
    /// have their zero there.
    ///
    /// # Errors
    /// Names the header's key, the length or the sample, and the expected value.
    pub fn of_array(file: &[u8], full_scale: Option<f64>, layout: &Layout) -> Result<Self> {
        let array = npy::read(file, layout)?;
        let ns = array.samples_per_chirp;
        Ok(Self {
            samples: samples::decode(&array.bytes, array.format, full_scale, ns)?,
            samples_per_chirp: ns,
            real: array.real,
            metadata: Value::Null,
            left_out: Vec::new(),
        })
    }

    /// Reads the chirps of a SigMF pair of any datatype, from its first capture on. `given` is the number of samples
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
        let (format, real) = sigmf::format(&metadata)?;
        standard::check_hash(&metadata, data)?;
        let stated = metadata["global"][keys::SAMPLES].as_u64();
        let stated = stated.and_then(|n| usize::try_from(n).ok());
        let Some(ns) = stated.or(given).filter(|n| *n > 0) else {
            bail!("missing: {} (--samples-per-chirp)", keys::SAMPLES);
        };
        ensure!(
            !real || ns.is_multiple_of(2),
            "{ns} real samples in a chirp, expected an even number"
        );
        standard::whole_chirps(&metadata, ns)?;
        let sample = format.bytes * if real { 1 } else { 2 };
        let before = standard::before_first(&metadata)?;
        let data = data
            .get(before.saturating_mul(sample)..)
            .unwrap_or_default();
        ensure!(
            !data.is_empty() && data.len().is_multiple_of(ns.saturating_mul(sample)),
            "{} bytes of samples from the first capture on, expected whole chirps of {ns} samples of {sample} bytes",
            data.len()
        );
        let ns = if real { ns / 2 } else { ns };
        Ok(Self {
            samples: samples::decode(data, format, full_scale, ns)?,
            samples_per_chirp: ns,
            real,
            left_out: left_out(&metadata, before),
            metadata,
        })
    }

    /// Returns the number of chirps in memory.
    pub fn count(&self) -> usize {
        self.samples.len() / self.samples_per_chirp.max(1)
    }

    /// Returns these chirps as the recording `name`, with one angle per chirp, degrees. The keys of `given` replace
    /// those of `base` and of the chirps' own metadata.
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
        let base = keys::merged(&self.metadata, base);
        let document = given.document(&base, size, self.real, angles)?;
        Recording::of(name, &document, self.samples)
    }
}

/// Returns what is not taken of a SigMF pair, whose first capture begins after `before` samples.
fn left_out(metadata: &Value, before: usize) -> Vec<String> {
    let mut words = Vec::new();
    if before > 0 {
        words.push(format!(
            "{before} samples before the first capture (captures[0] core:sample_start) are left out"
        ));
    }
    let annotations = metadata["annotations"].as_array().map_or(0, Vec::len);
    if annotations > 0 {
        words.push(format!("annotations are left out: {annotations}"));
    }
    words
}

/// Returns a path's suffix without its dot; empty if it has none.
pub fn suffix(path: &Path) -> &str {
    path.extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default()
}
