//! Errors of the library as exceptions of the package: the same text, and the values that the error names as attributes.

use comminute::Error;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use std::io;

/// The exception of an error. Its class stands in `comminute/errors.py`.
pub fn exception(py: Python<'_>, error: &Error) -> PyErr {
    made(py, error).map_or_else(|failure| failure, PyErr::from_value)
}

/// Passes on what is good, and turns an error into its exception.
pub fn raised<T>(py: Python<'_>, result: comminute::Result<T>) -> PyResult<T> {
    result.map_err(|error| exception(py, &error))
}

fn made<'py>(py: Python<'py>, error: &Error) -> PyResult<Bound<'py, PyAny>> {
    let class = py.import("comminute.errors")?.getattr(class(error))?;
    let made = class.call1((error.to_string(),))?;
    made.setattr("exit_code", error.exit_code())?;
    let set = |name: &str, value: &dyn Fn() -> PyResult<Py<PyAny>>| made.setattr(name, value()?);
    match error {
        Error::Input { place, key, value, message } => {
            set("place", &|| place.into_py_any(py))?;
            set("key", &|| key.into_py_any(py))?;
            set("value", &|| value.as_ref().into_py_any(py))?;
            set("message", &|| message.into_py_any(py))?;
        }
        Error::Several(errors) => {
            let errors: Vec<PyErr> = errors.iter().map(|error| exception(py, error)).collect();
            set("errors", &|| errors.iter().map(|e| e.value(py).clone()).collect::<Vec<_>>().into_py_any(py))?;
        }
        Error::Read { path, source } | Error::Write { path, source } => {
            set("path", &|| path.into_py_any(py))?;
            set("errno", &|| source.raw_os_error().into_py_any(py))?;
        }
        Error::Exists { path } | Error::Other { path, .. } | Error::Busy { path } | Error::Checkpoint { path, .. } => {
            set("path", &|| path.into_py_any(py))?
        }
        Error::Campaign { failed, .. } | Error::Stopped { failed, .. } => set("failed", &|| failed.into_py_any(py))?,
        Error::Unstable { step, grain, .. } => {
            set("step", &|| step.into_py_any(py))?;
            set("grain", &|| grain.into_py_any(py))?;
        }
        Error::Impossible { step, .. } | Error::Stalled { step, .. } | Error::Failed { step, .. } => {
            set("step", &|| step.into_py_any(py))?
        }
        Error::Interrupted { step, out } => {
            set("step", &|| step.into_py_any(py))?;
            set("path", &|| out.into_py_any(py))?;
        }
        _ => {}
    }
    Ok(made)
}

/// Name of the class of an error.
fn class(error: &Error) -> &'static str {
    match error {
        Error::Input { .. } => "InputError",
        Error::Several(_) => "InputErrors",
        Error::Read { source, .. } if source.kind() == io::ErrorKind::NotFound => "NotFoundError",
        Error::Read { .. } => "ReadError",
        Error::Write { .. } => "WriteError",
        Error::Exists { .. } => "ExistsError",
        Error::Other { .. } => "OtherRunError",
        Error::Busy { .. } => "BusyError",
        Error::Campaign { .. } => "CampaignError",
        Error::Stopped { .. } => "StoppedError",
        Error::Unstable { .. } => "UnstableError",
        Error::Impossible { .. } => "ImpossibleError",
        Error::Stalled { .. } => "StalledError",
        Error::Failed { .. } => "FailedError",
        Error::Device(_) => "DeviceError",
        Error::Checkpoint { .. } => "CheckpointError",
        Error::Figure { .. } => "FigureError",
        Error::Interrupted { .. } | Error::Cut { .. } => "Interrupted",
        _ => "Error",
    }
}
