//! Rust numbers to numpy arrays: one result, or a batch computed without the interpreter lock.

use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;

/// Row count of a batch above which letting other Python threads run is worth its cost (about 0.1 µs).
const DETACH_ABOVE: usize = 8;

/// `f(0)` for a single row, or f of every row of a batch.
pub(crate) enum OneOrBatch<T> {
    One(T),
    Many(Vec<T>),
}

/// `f`, without the interpreter lock unless it is about a few rows only.
pub(crate) fn detached<T: Send>(py: Python<'_>, rows: usize, f: impl FnOnce() -> T + Send) -> T {
    if rows <= DETACH_ABOVE {
        f()
    } else {
        py.detach(f)
    }
}

/// Computes one result or a batch; a batch releases the interpreter lock.
pub(crate) fn compute<T: Send>(
    py: Python<'_>,
    batch: Option<usize>,
    f: impl Fn(usize) -> T + Send + Sync,
) -> OneOrBatch<T> {
    match batch {
        None => OneOrBatch::One(f(0)),
        Some(rows) => OneOrBatch::Many(detached(py, rows, || (0..rows).map(f).collect())),
    }
}

/// A batch that `fill` writes; the interpreter lock is released.
pub(crate) fn filled<const M: usize>(
    py: Python<'_>,
    rows: usize,
    fill: impl FnOnce(&mut [[f64; M]]) + Send,
) -> OneOrBatch<[f64; M]> {
    let mut out = vec![[0.0; M]; rows];
    detached(py, rows, || fill(&mut out));
    OneOrBatch::Many(out)
}

impl<const M: usize> OneOrBatch<[f64; M]> {
    /// An array of shape (M,), or (N, M).
    pub(crate) fn into_array(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        self.into_array_of(py, &[M])
    }

    /// An array whose results have the shape `inner`, with M elements; (N, *inner) for a batch.
    pub(crate) fn into_array_of<'py>(
        self,
        py: Python<'py>,
        inner: &[usize],
    ) -> PyResult<Bound<'py, PyAny>> {
        debug_assert_eq!(inner.iter().product::<usize>(), M);
        match self {
            Self::One(row) => reshaped(PyArray1::from_slice(py, &row), inner.to_vec()),
            Self::Many(rows) => {
                let shape = [&[rows.len()], inner].concat();
                reshaped(PyArray1::from_vec(py, rows.into_flattened()), shape)
            }
        }
    }
}

impl<T: Element + for<'py> IntoPyObject<'py>> OneOrBatch<T> {
    /// A plain number (or truth value), or an array of shape (N,).
    pub(crate) fn into_number(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        match self {
            Self::One(value) => value.into_bound_py_any(py),
            Self::Many(values) => Ok(PyArray1::from_vec(py, values).into_any()),
        }
    }
}

/// Gives a flat array its shape.
pub(crate) fn reshaped<'py, T: Element>(
    flat: Bound<'py, PyArray1<T>>,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    Ok(match *shape {
        [_] => flat.into_any(),
        _ => flat.reshape(shape)?.into_any(),
    })
}
