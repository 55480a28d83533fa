//! Recordings as tables: `/cycle` as rows of numbers, any other topic as rows of texts.

use std::path::PathBuf;

use numpy::PyArray1;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use recorder::{ReadError, Recording, TopicTable};

use crate::row::Row;

/// Names of the columns, and the rows; a cell that a message does not have is None.
type TextTable = (Vec<String>, Vec<Vec<Option<String>>>);

pub(crate) fn told(error: &ReadError) -> PyErr {
    match error {
        ReadError::Io { .. } => PyOSError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// The bytes of all rows of `/cycle`, one after the other, as `row_fields` describes them.
#[pyfunction]
pub(crate) fn recording_cycles(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyArray1<u8>>> {
    let bytes = py.detach(|| {
        let recording = Recording::open(&path)?;
        let mut bytes = Vec::new();
        for cycle in recording.cycles()? {
            Row::from(&cycle?).write(&mut bytes);
        }
        Ok::<_, ReadError>(bytes)
    });
    Ok(PyArray1::from_vec(py, bytes.map_err(|error| told(&error))?))
}

/// Names of the topics of a recording if `topic` is None, else its table as texts.
#[pyfunction]
#[pyo3(signature = (path, topic=None))]
pub(crate) fn recording_table(
    py: Python<'_>,
    path: PathBuf,
    topic: Option<String>,
) -> PyResult<TextTable> {
    let table = py.detach(|| {
        let recording = Recording::open(&path)?;
        let Some(topic) = topic else {
            return Ok((recording.topics()?.into_iter().collect(), Vec::new()));
        };
        let table = TopicTable::new(&recording, &topic)?;
        let rows: Result<Vec<_>, ReadError> = table.rows()?.collect();
        Ok::<_, ReadError>((table.columns().to_vec(), rows?))
    });
    table.map_err(|error| told(&error))
}
