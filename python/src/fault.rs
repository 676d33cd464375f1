//! Faults of the library as exceptions.

use detune::notes::Note;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyList;

/// The `DetuneError` of all faults at once.
pub(crate) fn raised(py: Python<'_>, notes: &[Note]) -> PyErr {
    error(py, notes).unwrap_or_else(|failed| failed)
}

fn error(py: Python<'_>, notes: &[Note]) -> PyResult<PyErr> {
    let module = py.import("detune.errors")?;
    let fault = module.getattr("Fault")?;
    let faults = PyList::empty(py);
    for note in notes {
        let file = note.place.file.as_ref().map(|file| file.display().to_string());
        faults.append(fault.call1((
            note.code.name(),
            note.to_string(),
            file,
            note.place.line,
        ))?)?;
    }
    Ok(PyErr::from_value(module.getattr("DetuneError")?.call1((faults,))?))
}

/// What has no cause in what the user gave.
pub(crate) fn internal(what: impl std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(what.to_string())
}
