//! Arrays of samples to the samples of a recording.

use host_sim::convert::samples::scaled;
use numpy::{Element, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use stairscan::Iq;

use crate::refusals::refused;

/// Name of the recording that an array becomes. It stands in messages until [`in_words_of_python`] takes it out.
pub const NAME: &str = "iq";

/// I and Q of each sample of each chirp, shape (chirps, samples, 2); read where they lie.
#[derive(FromPyObject)]
pub enum Numbers<'py> {
    /// As the converter gave them, full scale 32768.
    Whole(PyReadonlyArray3<'py, i16>),
    /// Full scale 1.
    Single(PyReadonlyArray3<'py, f32>),
    /// Full scale 1.
    Double(PyReadonlyArray3<'py, f64>),
}

impl Numbers<'_> {
    /// Number of chirps, samples of each, and the samples, rounded to 16 bits as `cargo sim convert` rounds them.
    ///
    /// # Errors
    /// Names chirp and sample of what is no number within full scale.
    pub fn samples(&self) -> PyResult<(usize, usize, Vec<Iq>)> {
        match self {
            Self::Whole(array) => pairs(array, Some),
            Self::Single(array) => pairs(array, |value| scaled(value.into(), 1.0)),
            Self::Double(array) => pairs(array, |value| scaled(value, 1.0)),
        }
    }
}

fn pairs<T: Element + Copy + std::fmt::Display>(
    array: &PyReadonlyArray3<'_, T>,
    number: impl Fn(T) -> Option<i16>,
) -> PyResult<(usize, usize, Vec<Iq>)> {
    let view = array.as_array();
    let (chirps, each, two) = view.dim();
    if two != 2 {
        return Err(refused("iq: expected I and Q in the last dimension"));
    }
    let mut samples = Vec::with_capacity(chirps * each);
    let mut parts = view.iter().copied().enumerate();
    let mut next = || -> PyResult<Option<i16>> {
        let Some((k, value)) = parts.next() else {
            return Ok(None);
        };
        let (pair, part) = (k / 2, if k % 2 == 0 { "I" } else { "Q" });
        let found = number(value).ok_or_else(|| {
            refused(&format!(
                "iq: chirp {}, sample {}: {part} is {value}, expected a number within ±1 (full scale)",
                pair / each.max(1),
                pair % each.max(1),
            ))
        });
        found.map(Some)
    };
    while let (Some(i), Some(q)) = (next()?, next()?) {
        samples.push(Iq::new(i, q));
    }
    Ok((chirps, each, samples))
}

/// A refusal of the host tool, which names keys of a file, in the names of `scan`'s arguments.
pub fn in_words_of_python(py: Python<'_>, error: PyErr) -> PyErr {
    if !error.is_instance_of::<PyValueError>(py) {
        return error;
    }
    let message = error.value(py).to_string();
    let message = message
        .replace(&format!("{NAME}.sigmf-meta: "), "")
        .replace("] stairscan:mirror_angle_deg: ", "]: ")
        .replace("global stairscan:scan_plane", "config.plane")
        .replace(
            "global stairscan:samples_per_chirp",
            "iq: samples per chirp",
        )
        .replace("global stairscan:", "config.")
        .replace("global core:sample_rate", "config.sample_rate_hz")
        .replace("captures[0] core:frequency", "config.carrier_hz")
        .replace("captures[", "angles[")
        .replace("captures:", "angles:");
    refused(&message)
}
