//! Converts errors and panics to Python's exceptions, with the host tool's own message.

use std::io::{self, ErrorKind};
use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::exceptions::{
    PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyRuntimeError,
    PyValueError,
};
use pyo3::prelude::*;

/// Returns a `ValueError` with this message.
pub fn refused(message: &str) -> PyErr {
    PyValueError::new_err(message.to_owned())
}

/// Converts an I/O error to `OSError` or its specific subclass, every other error to `ValueError`.
fn exception(error: &anyhow::Error) -> PyErr {
    let message = format!("{error:#}");
    let io = error.chain().find_map(|e| e.downcast_ref::<io::Error>());
    match io.map(io::Error::kind) {
        None | Some(ErrorKind::InvalidData) => PyValueError::new_err(message),
        Some(ErrorKind::NotFound) => PyFileNotFoundError::new_err(message),
        Some(ErrorKind::PermissionDenied) => PyPermissionError::new_err(message),
        Some(ErrorKind::IsADirectory) => PyIsADirectoryError::new_err(message),
        Some(_) => PyOSError::new_err(message),
    }
}

/// Runs `work` while other Python threads run. No input is known to cause a panic. A panic becomes a
/// `RuntimeError` instead of ending the interpreter.
pub fn guarded<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> anyhow::Result<T> + Send,
) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    match done {
        Ok(result) => result.map_err(|error| exception(&error)),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            let text = text.unwrap_or("no message");
            Err(PyRuntimeError::new_err(format!(
                "defect in stairscan, please report it: {text}"
            )))
        }
    }
}
