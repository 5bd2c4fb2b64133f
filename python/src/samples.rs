//! Converts arrays to the samples of a recording.

use std::fmt::Display;

use numpy::{Element, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use stairscan::Iq;
use stairscan_replay::convert::samples::scaled;

use crate::refusals::refused;

/// Name of the recording made from an array. It appears in messages until [`in_words_of_python`] removes it.
pub const NAME: &str = "iq";

/// I and Q of each sample of each chirp, shape (chirps, samples, 2); read without a copy.
#[derive(FromPyObject)]
pub enum Numbers<'py> {
    /// Converter output, full scale 32768.
    Whole(PyReadonlyArray3<'py, i16>),
    /// Full scale 1.
    Single(PyReadonlyArray3<'py, f32>),
    /// Full scale 1.
    Double(PyReadonlyArray3<'py, f64>),
}

impl Numbers<'_> {
    /// Returns the number of chirps, the number of samples a chirp, and the samples, rounded to 16 bits as in
    /// `cargo sim convert`.
    ///
    /// # Errors
    /// A value is not a number within full scale; the message names chirp and sample.
    pub fn samples(&self) -> PyResult<(usize, usize, Vec<Iq>)> {
        match self {
            Self::Whole(array) => pairs(array, Some),
            Self::Single(array) => pairs(array, |value| scaled(value.into(), 1.0)),
            Self::Double(array) => pairs(array, |value| scaled(value, 1.0)),
        }
    }
}

fn pairs<T: Element + Copy + Display>(
    array: &PyReadonlyArray3<'_, T>,
    number: impl Fn(T) -> Option<i16>,
) -> PyResult<(usize, usize, Vec<Iq>)> {
    let &[chirps, each, two] = array.shape() else {
        return Err(refused("iq: expected three dimensions"));
    };
    // The Python part of the package ensures both conditions.
    let values = array.as_slice().ok().filter(|_| two == 2);
    let values = values.ok_or_else(|| refused("iq: expected pairs, one after the other"))?;
    let (values, _) = values.as_chunks::<2>();
    let one = |k: usize, value: T, name: char| {
        number(value).ok_or_else(|| {
            refused(&format!(
                "iq: chirp {}, sample {}: {name} is {value}, expected a number within ±1 (full scale)",
                k / each,
                k % each
            ))
        })
    };
    let pairs = values.iter().enumerate();
    let samples = pairs.map(|(k, &[i, q])| Ok(Iq::new(one(k, i, 'I')?, one(k, q, 'Q')?)));
    Ok((chirps, each, samples.collect::<PyResult<_>>()?))
}

/// Replaces the file's keys in a message of the host tool by the names of `scan`'s arguments.
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
        .replace("captures stairscan:mirror_angle_deg:", "angles:")
        .replace("captures:", "angles:");
    refused(&message)
}
