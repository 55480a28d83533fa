//! The script's pose and number functions (manual 3.2 and 4.8) as module functions.
//!
//! Owns their Python signatures and docstrings; the meaning is in `kinematics::script_math`. Poses are
//! `[x, y, z, Rx, Ry, Rz]`, metres and radians, R = Rz(Rz) Ry(Ry) Rx(Rx).

use crate::arguments::{Numbers, PyArgument, PyArrayResult, Rows, common_batch, number};
use crate::results::{OneOrBatch, compute, filled, reshaped};
use kinematics::batch::{self, Operand};
use kinematics::script_math as m;
use kinematics::{RobotModel, RpyPose, Wrench};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

fn invalid(error: m::DomainError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A function of two poses that gives a pose, for one pair and for many.
fn pose_of_two<'py>(
    py: Python<'py>,
    (first_name, first): (&str, PyArgument<'_, 'py>),
    (second_name, second): (&str, PyArgument<'_, 'py>),
    one: fn(&RpyPose, &RpyPose) -> RpyPose,
    many: fn(Operand<'_>, Operand<'_>, &mut [[f64; 6]]),
) -> PyArrayResult<'py> {
    let (a, b) = (
        Rows::<6>::read(first_name, first)?,
        Rows::<6>::read(second_name, second)?,
    );
    match common_batch(&[(first_name, a.batch()), (second_name, b.batch())])? {
        None => OneOrBatch::One(one(&pose(a.at(0)), &pose(b.at(0))).to_array()),
        Some(rows) => filled(py, rows, |out| many(a.operand(), b.operand(), out)),
    }
    .into_array(py)
}

/// A function of two poses that gives a number.
fn number_of_two<'py>(
    py: Python<'py>,
    (first_name, first): (&str, PyArgument<'_, 'py>),
    (second_name, second): (&str, PyArgument<'_, 'py>),
    f: fn(&RpyPose, &RpyPose) -> f64,
) -> PyArrayResult<'py> {
    let (a, b) = (
        Rows::<6>::read(first_name, first)?,
        Rows::<6>::read(second_name, second)?,
    );
    let batch = common_batch(&[(first_name, a.batch()), (second_name, b.batch())])?;
    compute(py, batch, |i| f(&pose(a.at(i)), &pose(b.at(i)))).into_number(py)
}

/// A function of one vector of three numbers.
fn of_three<'py>(
    py: Python<'py>,
    (name, given): (&str, PyArgument<'_, 'py>),
    f: fn([f64; 3]) -> [f64; 3],
) -> PyArrayResult<'py> {
    let rows = Rows::<3>::read(name, given)?;
    compute(py, rows.batch(), |i| f(*rows.at(i))).into_array(py)
}

fn pose(row: &[f64; 6]) -> RpyPose {
    RpyPose::from_array(*row)
}

/// A function of every number of an array, or of one number.
fn elementwise<'py>(
    py: Python<'py>,
    (name, given): (&str, PyArgument<'_, 'py>),
    f: impl Fn(f64) -> f64,
) -> PyArrayResult<'py> {
    let Numbers { values, shape } = Numbers::read(name, given)?;
    let values: Vec<f64> = values.into_iter().map(f).collect();
    match (shape.as_slice(), values.as_slice()) {
        ([], [value]) => Ok(pyo3::types::PyFloat::new(py, *value).into_any()),
        _ => reshaped(PyArray1::from_vec(py, values), shape),
    }
}

/// A function of the module: `how` is one of the functions above, which gets the arguments with their names.
macro_rules! function {
    ($(#[$doc:meta])* $name:ident($($argument:ident),+) = $how:ident($($with:path),+)) => {
        $(#[$doc])*
        #[pyfunction]
        pub(crate) fn $name<'py>(
            py: Python<'py>,
            $($argument: PyArgument<'_, 'py>),+
        ) -> PyArrayResult<'py> {
            $how(py, $((stringify!($argument), $argument)),+, $($with),+)
        }
    };
}

/// Names of the built-in arms, smallest first.
///
/// >>> elitescript.models()
/// ('cs63', 'cs66', 'cs612', 'cs616', 'cs620', 'cs625')
#[pyfunction]
pub(crate) fn models(py: Python<'_>) -> PyResult<Bound<'_, PyTuple>> {
    PyTuple::new(py, RobotModel::names().collect::<Vec<_>>())
}

function! {
    /// Positions added, rotations chained R1 R2 (manual 3.2.26).
    ///
    /// Unlike `pose_trans`, the position of `p_2` is not turned by `p_1`.
    ///
    /// p_1, p_2: poses, (6,) or (N, 6), m and rad. Returns the same shape.
    pose_add(p_1, p_2) = pose_of_two(m::pose_add, batch::pose_add)
}

function! {
    /// Positions subtracted, rotation from `p_from` to `p_to`: inverse(R_from) R_to (manual 3.2.29).
    ///
    /// p_to, p_from: poses, (6,) or (N, 6), m and rad. Returns the same shape.
    pose_sub(p_to, p_from) = pose_of_two(m::pose_sub, batch::pose_sub)
}

function! {
    /// A pose given in the frame of `p_from`, expressed in the frame `p_from` is given in (manual 3.2.30).
    ///
    /// p_from, p_from_to: poses, (6,) or (N, 6), m and rad. Returns the same shape.
    ///
    /// >>> elitescript.pose_trans([0.1, 0, 0, 0, 0, 0], [0, 0.2, 0, 0, 0, 0])
    /// array([0.1, 0.2, 0. , 0. , 0. , 0. ])
    pose_trans(p_from, p_from_to) = pose_of_two(m::pose_trans, batch::pose_trans)
}

/// The inverse transform of a pose (manual 3.2.28).
///
/// p_from: pose, (6,) or (N, 6), m and rad. Returns the same shape.
#[pyfunction]
pub(crate) fn pose_inv<'py>(py: Python<'py>, p_from: PyArgument<'_, 'py>) -> PyArrayResult<'py> {
    let rows = Rows::<6>::read("p_from", p_from)?;
    compute(py, rows.batch(), |i| {
        m::pose_inv(&pose(rows.at(i))).to_array()
    })
    .into_array(py)
}

function! {
    /// Euclidean length of the difference of the six numbers (manual 3.2.27).
    ///
    /// Metres and radians are mixed and angles are not wrapped: odd, but it is what the manual's example prints.
    ///
    /// p_from, p_to: poses, (6,) or (N, 6). Returns a float, or (N,).
    pose_dist(p_from, p_to) = number_of_two(m::pose_dist)
}

function! {
    /// Distance of two positions in m; the rotations do not count (manual 3.2.25).
    ///
    /// p_from, p_to: poses, (6,) or (N, 6). Returns a float, or (N,).
    point_dist(p_from, p_to) = number_of_two(m::point_dist)
}

/// Between two poses: straight line for the position, shortest turn for the rotation (manual 3.2.33).
///
/// p_from, p_to: poses, (6,) or (N, 6), m and rad.
/// alpha: number or (N,); 0 gives p_from, 1 gives p_to, outside goes on in the same way.
/// Returns (6,) or (N, 6), pitch in [-pi/2, pi/2].
#[pyfunction]
pub(crate) fn interpolate_pose<'py>(
    py: Python<'py>,
    p_from: PyArgument<'_, 'py>,
    p_to: PyArgument<'_, 'py>,
    alpha: PyArgument<'_, 'py>,
) -> PyArrayResult<'py> {
    let (a, b) = (
        Rows::<6>::read("p_from", p_from)?,
        Rows::<6>::read("p_to", p_to)?,
    );
    let alphas = Numbers::read("alpha", alpha)?;
    let alpha_batch = match *alphas.shape {
        [] => None,
        [rows] => Some(rows),
        _ => {
            return Err(PyValueError::new_err(
                "alpha must be a number or have shape (N,)",
            ));
        }
    };
    let batch = common_batch(&[
        ("p_from", a.batch()),
        ("p_to", b.batch()),
        ("alpha", alpha_batch),
    ])?;
    compute(py, batch, |i| {
        let alpha = alphas.values[if alpha_batch.is_some() { i } else { 0 }];
        m::interpolate_pose(&pose(a.at(i)), &pose(b.at(i)), alpha).to_array()
    })
    .into_array(py)
}

function! {
    /// Rotation vector (axis times angle) to roll, pitch, yaw (manual 3.2.31).
    ///
    /// rotation_vector: (3,) or (N, 3), rad. Returns the same shape.
    rotvec2rpy(rotation_vector) = of_three(m::rotvec2rpy)
}

function! {
    /// Roll, pitch, yaw to rotation vector (axis times angle, angle in [0, pi]) (manual 3.2.32).
    ///
    /// rpy_vector: (3,) or (N, 3), rad. Returns the same shape.
    rpy2rotvec(rpy_vector) = of_three(m::rpy2rotvec)
}

/// A wrench through the transform as it stands: F' = R F, M' = R M + t x F' (manual 4.8).
///
/// T_from_to: pose, (6,) or (N, 6), m and rad. w_from: [Fx, Fy, Fz, Mx, My, Mz], (6,) or (N, 6), N and Nm.
/// Returns the wrench, same shape.
#[pyfunction]
#[pyo3(signature = (T_from_to, w_from))]
#[expect(non_snake_case, reason = "the manual's name of the argument")]
pub(crate) fn wrench_trans<'py>(
    py: Python<'py>,
    T_from_to: PyArgument<'_, 'py>,
    w_from: PyArgument<'_, 'py>,
) -> PyArrayResult<'py> {
    let (poses, wrenches) = (
        Rows::<6>::read("T_from_to", T_from_to)?,
        Rows::<6>::read("w_from", w_from)?,
    );
    let batch = common_batch(&[("T_from_to", poses.batch()), ("w_from", wrenches.batch())])?;
    compute(py, batch, |i| {
        let wrench = Wrench::from_array(*wrenches.at(i));
        m::wrench_trans(&pose(poses.at(i)), &wrench).to_array()
    })
    .into_array(py)
}

/// Euclidean length of a vector or pose (all numbers alike), absolute value of a number (manual 3.2.23).
///
/// a: number, (K,) or (N, K). Returns a float, or (N,).
#[pyfunction]
pub(crate) fn norm<'py>(py: Python<'py>, a: PyArgument<'_, 'py>) -> PyArrayResult<'py> {
    let numbers = Numbers::read("a", a)?;
    match *numbers.shape {
        [] | [_] => compute(py, None, |_| m::norm(&numbers.values)).into_number(py),
        [rows, columns] => compute(py, Some(rows), |i| {
            m::norm(&numbers.values[i * columns..(i + 1) * columns])
        })
        .into_number(py),
        _ => Err(PyValueError::new_err(
            "a must be a number or have shape (K,) or (N, K)",
        )),
    }
}

/// A vector divided by its Euclidean length (manual 3.2.24).
///
/// v: (K,) or (N, K). Returns the same shape. A vector of length zero raises ValueError.
#[pyfunction]
pub(crate) fn normalize<'py>(py: Python<'py>, v: PyArgument<'_, 'py>) -> PyArrayResult<'py> {
    let Numbers { mut values, shape } = Numbers::read("v", v)?;
    let columns = match *shape {
        [columns] | [_, columns] => columns,
        _ => return Err(PyValueError::new_err("v must have shape (K,) or (N, K)")),
    };
    if columns == 0 {
        return Err(invalid(m::DomainError::NoDirection));
    }
    for row in values.chunks_exact_mut(columns) {
        m::normalize(row).map_err(invalid)?;
    }
    reshaped(PyArray1::from_vec(py, values), shape)
}

function! {
    /// Degrees to radians (manual 3.2.16). d: number or array of any shape. Returns the same shape.
    d2r(d) = elementwise(m::d2r)
}

function! {
    /// Radians to degrees (manual 3.2.17). r: number or array of any shape. Returns the same shape.
    r2d(r) = elementwise(m::r2d)
}

/// Logarithm of f to base b; the base comes first, unlike math.log (manual 3.2.20).
#[pyfunction]
pub(crate) fn log(b: PyArgument<'_, '_>, f: PyArgument<'_, '_>) -> PyResult<f64> {
    m::log(number("b", b)?, number("f", f)?).map_err(invalid)
}

/// Bits to a number, the first bit lowest; from 32 bits on, the first 32 are a signed number (manual 3.2.5).
#[pyfunction]
pub(crate) fn bit_list_to_integer(l: Vec<bool>) -> i64 {
    m::bit_list_to_integer(&l)
}

/// The low 32 bits of a number in two's complement, lowest first (manual 3.2.6).
#[pyfunction]
pub(crate) fn integer_to_bit_list(x: i64) -> [bool; 32] {
    m::integer_to_bit_list(x)
}
