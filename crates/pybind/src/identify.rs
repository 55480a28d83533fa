//! Numbers of an arm from recordings and traces for Python: `eliteserver identify`, its answer as the same JSON object.

use std::path::PathBuf;

use numpy::PyReadonlyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use recorder::CycleMessage;
use server::cli::IdentifyTarget;
use server::commands::identify::{IdentifyError, IdentifyQuestion, Samples};

use crate::recording;
use crate::robot::Robot;

/// Numbers of a cycle in a row of `identified_arrays`: time, six vectors of six, gravity.
const COLUMNS: usize = 1 + 6 * 6 + 3;

fn target(what: &str) -> PyResult<IdentifyTarget> {
    Ok(match what {
        "payload" => IdentifyTarget::Payload,
        "friction" => IdentifyTarget::Friction,
        "tool" => IdentifyTarget::Tool,
        "frame" => IdentifyTarget::Frame,
        "sensor" => IdentifyTarget::Sensor,
        other => {
            return Err(PyValueError::new_err(format!(
                "what must be payload, friction, tool, frame or sensor, got {other}"
            )));
        }
    })
}

fn identify_error(error: &IdentifyError) -> PyErr {
    match error {
        IdentifyError::Read(error) => recording::told(error),
        other => PyValueError::new_err(other.to_string()),
    }
}

/// The answer as JSON. Options: from torques, times of the rests, and whether the axes of a tool are looked for as
/// well.
fn answer(
    py: Python<'_>,
    what: &str,
    (from_torques, at, orientation): (bool, &[f64], bool),
    samples: impl FnOnce() -> Result<Samples, IdentifyError> + Send,
) -> PyResult<String> {
    let question = IdentifyQuestion {
        what: target(what)?,
        from_torques,
        at,
        orientation,
    };
    let answer = py.detach(|| question.answer(&samples()?));
    let answer = answer.map_err(|error| identify_error(&error))?;
    Ok(answer.json().to_string())
}

/// Finds numbers in recordings; `elitescript.identify` is the module to use.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "what Python gives, and only Python calls it"
)]
pub(crate) fn identified_files(
    py: Python<'_>,
    what: &str,
    paths: Vec<PathBuf>,
    start: Option<f64>,
    end: Option<f64>,
    from_torques: bool,
    at: Vec<f64>,
    orientation: bool,
) -> PyResult<String> {
    let options = (from_torques, &*at, orientation);
    answer(py, what, options, || Samples::read(&paths, start, end))
}

/// Finds numbers in cycles that are in memory: rows of time, `actual_q`, `actual_qd`, `target_qdd`, `actual_torque`,
/// `raw_wrench`, `tcp_offset` and `gravity`.
#[pyfunction]
#[expect(
    clippy::needless_pass_by_value,
    reason = "an array of Python is taken by value"
)]
pub(crate) fn identified_arrays(
    py: Python<'_>,
    what: &str,
    robot: &Robot,
    cycles: PyReadonlyArray2<'_, f64>,
    from_torques: bool,
    at: Vec<f64>,
    orientation: bool,
) -> PyResult<String> {
    let array = cycles.as_array();
    if array.ncols() != COLUMNS {
        return Err(PyValueError::new_err(format!(
            "cycles must have {COLUMNS} columns, got {}",
            array.ncols()
        )));
    }
    let cycles: Vec<CycleMessage> = array
        .rows()
        .into_iter()
        .map(|row| {
            let part = |begin: usize, length: usize| row.iter().skip(begin).take(length).copied();
            CycleMessage {
                time: row[0],
                actual_q: part(1, 6).collect(),
                actual_qd: part(7, 6).collect(),
                target_qdd: part(13, 6).collect(),
                actual_torque: part(19, 6).collect(),
                raw_wrench: part(25, 6).collect(),
                tcp_offset: part(31, 6).collect(),
                gravity: part(37, 3).collect(),
                ..CycleMessage::default()
            }
        })
        .collect();
    let model = robot.model().clone();
    let options = (from_torques, &*at, orientation);
    answer(py, what, options, || Samples::of_cycles(model, cycles))
}
