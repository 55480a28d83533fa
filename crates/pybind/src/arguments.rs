//! Python arguments to plain Rust numbers, with errors that name the argument and what was given.
//!
//! Owns the rule of the whole module: every vector argument is one row or a batch of rows, everything in it is finite.
//! Rows are copied out of numpy arrays, so that another thread may write to them while a batch runs.

use std::cell::RefCell;

use kinematics::batch::Operand;
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};

/// An argument as it comes.
pub(crate) type PyArgument<'a, 'py> = &'a Bound<'py, PyAny>;

/// What a function gives back.
pub(crate) type PyArrayResult<'py> = PyResult<Bound<'py, PyAny>>;

/// One row of K numbers or a batch of them.
pub(crate) enum Rows<const K: usize> {
    One([f64; K]),
    Many(PooledRows),
}

/// Numbers copied out of an array.
///
/// Their memory is kept for the next call of this thread, up to a bound: given back, the allocator returns it to the
/// system, and fetching it again page by page takes longer than the arithmetic of a batch.
pub(crate) struct PooledRows(Vec<f64>);

thread_local! {
    static SPARE: RefCell<Vec<Vec<f64>>> = const { RefCell::new(Vec::new()) };
}

impl PooledRows {
    /// Most copies that are kept, as many as a function has batches.
    const SPARES_MAX: usize = 3;
    /// Longest copy that is kept: 2 MiB.
    const KEPT_MAX: usize = 1 << 18;

    fn of(values: &[f64]) -> Self {
        let mut copy = SPARE.with_borrow_mut(Vec::pop).unwrap_or_default();
        copy.extend_from_slice(values);
        Self(copy)
    }

    /// The rows; K numbers each.
    #[inline]
    fn rows<const K: usize>(&self) -> &[[f64; K]] {
        self.0.as_chunks().0
    }
}

impl Drop for PooledRows {
    fn drop(&mut self) {
        let mut copy = std::mem::take(&mut self.0);
        copy.clear();
        if copy.capacity() <= Self::KEPT_MAX {
            // While the thread ends there is no place to keep it any more, which is fine.
            let _ = SPARE.try_with(|spare| {
                let mut spare = spare.borrow_mut();
                if spare.len() < Self::SPARES_MAX {
                    spare.push(copy);
                }
            });
        }
    }
}

impl<const K: usize> Rows<K> {
    /// Reads the argument `name`.
    pub(crate) fn read(name: &str, given: PyArgument<'_, '_>) -> PyResult<Self> {
        if let Some(row) = plain_sequence(given) {
            all_finite(name, &row, &[K])?;
            return Ok(Self::One(row));
        }
        if let Ok(array) = given.cast_exact::<PyArrayDyn<f64>>()
            && array.is_c_contiguous()
            && let Ok(array) = array.try_readonly()
            && let Ok(values) = array.as_slice()
        {
            return Self::of(name, values, array.shape());
        }
        let Numbers { values, shape } = Numbers::read(name, given)?;
        Self::of(name, &values, &shape)
    }

    /// Copies rows that lie one after the other.
    fn of(name: &str, values: &[f64], shape: &[usize]) -> PyResult<Self> {
        all_finite(name, values, shape)?;
        let (rows, _) = values.as_chunks::<K>();
        match (shape, rows) {
            (&[k], [row]) if k == K => Ok(Self::One(*row)),
            (&[_, k], _) if k == K => Ok(Self::Many(PooledRows::of(values))),
            _ => Err(PyValueError::new_err(format!(
                "{name} must have shape ({K},) or (N, {K}), got {}",
                shape_text(shape)
            ))),
        }
    }

    /// Reads an argument that may be left out, which means `default`.
    pub(crate) fn read_or(
        name: &str,
        given: Option<PyArgument<'_, '_>>,
        default: [f64; K],
    ) -> PyResult<Self> {
        given.map_or(Ok(Self::One(default)), |given| Self::read(name, given))
    }

    /// Row `index` of a batch; a single row stands for every index.
    #[inline]
    pub(crate) fn at(&self, index: usize) -> &[f64; K] {
        match self {
            Self::One(row) => row,
            Self::Many(copied) => &copied.rows()[index],
        }
    }

    /// Number of rows of a batch, `None` for a single row.
    pub(crate) fn batch(&self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Many(copied) => Some(copied.rows::<K>().len()),
        }
    }
}

impl Rows<6> {
    /// The rows in the form that a computation over many rows takes.
    pub(crate) fn operand(&self) -> Operand<'_> {
        match self {
            Self::One(row) => Operand::Broadcast(row),
            Self::Many(copied) => Operand::PerRow(copied.rows()),
        }
    }
}

/// One row of K numbers; a batch is an error.
pub(crate) fn single<const K: usize>(name: &str, given: PyArgument<'_, '_>) -> PyResult<[f64; K]> {
    match Rows::<K>::read(name, given)? {
        Rows::One(row) => Ok(row),
        Rows::Many(rows) => Err(PyValueError::new_err(format!(
            "{name} must have shape ({K},), got {}",
            shape_text(&[rows.rows::<K>().len(), K])
        ))),
    }
}

/// The common batch size of several arguments: single rows go with any batch, batches must be equally long.
pub(crate) fn common_batch(arguments: &[(&str, Option<usize>)]) -> PyResult<Option<usize>> {
    let mut batches = arguments
        .iter()
        .filter_map(|&(name, batch)| Some((name, batch?)));
    let Some((first, rows)) = batches.next() else {
        return Ok(None);
    };
    match batches.find(|&(_, other)| other != rows) {
        None => Ok(Some(rows)),
        Some((second, other)) => Err(PyValueError::new_err(format!(
            "{first} has {rows} rows and {second} has {other}; batches must be equally long"
        ))),
    }
}

/// Numbers of any shape, row by row.
pub(crate) struct Numbers {
    pub(crate) values: Vec<f64>,
    pub(crate) shape: Vec<usize>,
}

impl Numbers {
    /// Reads the argument `name` through numpy; everything must be a finite real number.
    pub(crate) fn read(name: &str, given: PyArgument<'_, '_>) -> PyResult<Self> {
        let numpy = given.py().import("numpy")?;
        let refused =
            |what: String| PyValueError::new_err(format!("{name} must be numbers, got {what}"));
        let array = numpy.call_method1("asarray", (given,)).map_err(|e| {
            refused(format!(
                "something numpy cannot make an array of: {}",
                e.value(given.py())
            ))
        })?;
        let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
        if !matches!(kind.as_str(), "f" | "i" | "u" | "b") {
            return Err(refused(format!(
                "{} of type {}",
                given.repr()?,
                array.getattr("dtype")?
            )));
        }
        // Taken before the conversion, which makes a row of a single number.
        let shape = array.cast::<PyUntypedArray>()?.shape().to_vec();
        let array = numpy.call_method1("ascontiguousarray", (array, "float64"))?;
        let values = array
            .cast::<PyArrayDyn<f64>>()?
            .to_vec()
            .map_err(PyErr::from)?;
        all_finite(name, &values, &shape)?;
        Ok(Self { values, shape })
    }
}

/// A number that stands alone.
pub(crate) fn number(name: &str, given: PyArgument<'_, '_>) -> PyResult<f64> {
    let value = if given.is_instance_of::<PyFloat>() || given.is_instance_of::<PyInt>() {
        given.extract()?
    } else {
        let array = Numbers::read(name, given)?;
        match (array.shape.as_slice(), array.values.as_slice()) {
            ([], [value]) => *value,
            (shape, _) => {
                return Err(PyValueError::new_err(format!(
                    "{name} must be one number, got {}",
                    shape_text(shape)
                )));
            }
        }
    };
    all_finite(name, &[value], &[])?;
    Ok(value)
}

/// The quick way for the commonest argument, a list or tuple of K numbers.
fn plain_sequence<const K: usize>(given: PyArgument<'_, '_>) -> Option<[f64; K]> {
    let length = if let Ok(list) = given.cast_exact::<PyList>() {
        list.len()
    } else {
        given.cast_exact::<PyTuple>().ok()?.len()
    };
    if length != K {
        return None;
    }
    let mut row = [0.0; K];
    for (slot, item) in row.iter_mut().zip(given.try_iter().ok()?) {
        let item = item.ok()?;
        let plain = item.is_exact_instance_of::<PyFloat>() || item.is_exact_instance_of::<PyInt>();
        *slot = if plain {
            item.extract().ok()?
        } else {
            return None;
        };
    }
    Some(row)
}

fn all_finite(name: &str, values: &[f64], shape: &[usize]) -> PyResult<()> {
    // Zero times a number is zero if that is finite and NaN if not. Eight sums beside each other, so that the compiler
    // can use vector instructions.
    let mut sums = [0.0; 8];
    let (eights, rest) = values.as_chunks::<8>();
    for eight in eights {
        for (sum, x) in sums.iter_mut().zip(eight) {
            *sum += 0.0 * x;
        }
    }
    if sums.iter().chain(rest).all(|x| x.is_finite()) {
        return Ok(());
    }
    let at = values.iter().position(|x| !x.is_finite()).unwrap_or(0);
    let place = match shape {
        [] => String::new(),
        [_] => format!(" at index {at}"),
        [.., columns] => format!(" at row {}, column {}", at / columns, at % columns),
    };
    Err(PyValueError::new_err(format!(
        "{name} must be finite, got {}{place}",
        values[at].to_string().to_lowercase()
    )))
}

/// `shape (2, 5)`, or `a single number` for no dimensions.
fn shape_text(shape: &[usize]) -> String {
    match shape {
        [] => "a single number".to_owned(),
        [n] => format!("shape ({n},)"),
        many => format!(
            "shape ({})",
            many.iter()
                .map(usize::to_string)
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}
