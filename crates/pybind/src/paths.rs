//! Clearances and planned paths for Python: options as texts, numbers and texts out.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use controller::clearance::{ClearanceError, MeasureOptions, MeasuredEnd, measure};
use controller::planned_path::{PathTarget, PlanError, PlanOptions, plan_path};
use elite_runtime::ProgramText;
use kinematics::{JointPositions, RpyPose};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::PlanningError;
use crate::native_controller::{preset_all, seconds, start_error};
use crate::settings;

/// Line, node, kind, distance, a, b, time, tcp, joint margin, singularity.
type MotionParts = (
    u32,
    Option<String>,
    &'static str,
    Option<f64>,
    Option<String>,
    Option<String>,
    Option<f64>,
    Option<[f64; 6]>,
    f64,
    f64,
);

/// Rows, what kept the program from its end, its simulated time.
type ClearanceParts = (Vec<MotionParts>, Option<String>, f64);

/// Waypoints, program, distance, length, time, planning time, warnings.
type PathParts = (
    Vec<[f64; 6]>,
    String,
    Option<f64>,
    f64,
    f64,
    f64,
    Vec<String>,
);

fn clearance_error(error: &ClearanceError) -> PyErr {
    match error {
        ClearanceError::Start(error) => start_error(error),
        other => PyRuntimeError::new_err(other.to_string()),
    }
}

/// Whether Python wants to go on: asked on the thread that waits, with the lock for as long as that takes.
struct SignalCheck(AtomicBool);

impl SignalCheck {
    fn keep_going(&self) -> bool {
        let is_interrupted = Python::attach(|py| py.check_signals().is_err());
        if is_interrupted {
            self.0.store(true, Ordering::Relaxed);
        }
        !is_interrupted
    }
}

/// Runs a program and measures its motions; `elitescript.clearance` is the function to use.
#[pyfunction]
pub(crate) fn measure_clearance(
    py: Python<'_>,
    options: BTreeMap<String, String>,
    name: String,
    text: String,
    presets: Vec<(String, String)>,
    timeout: f64,
) -> PyResult<ClearanceParts> {
    let config = settings::read(&options)?;
    let measuring = MeasureOptions {
        presets: preset_all(&presets)?,
        limit: seconds("timeout", timeout)?.get(),
        has_history: false,
    };
    let signals = SignalCheck(AtomicBool::new(false));
    let run = py.detach(|| {
        let program = ProgramText { name, text };
        measure(&config, program, &measuring, &mut || signals.keep_going())
    });
    if signals.0.load(Ordering::Relaxed) {
        return Err(pyo3::exceptions::PyKeyboardInterrupt::new_err(()));
    }
    let run = run.map_err(|error| clearance_error(&error))?;
    let rows = run.rows.into_iter().map(|row| {
        let least = row.least;
        (
            row.line,
            row.node,
            row.kind,
            least.as_ref().map(|least| least.distance),
            least.as_ref().map(|least| least.a.to_string()),
            least.as_ref().map(|least| least.b.to_string()),
            least.as_ref().map(|least| least.time),
            least.as_ref().map(|least| least.tcp),
            row.joint_margin,
            row.singularity,
        )
    });
    let error = (run.end != MeasuredEnd::Finished).then(|| run.end.to_string());
    Ok((rows.collect(), error, run.result.time))
}

/// Plans a path; `elitescript.plan` is the function to use.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "what Python gives, and only Python calls it"
)]
pub(crate) fn planned_path(
    py: Python<'_>,
    options: BTreeMap<String, String>,
    target: [f64; 6],
    is_pose: bool,
    via: Vec<[f64; 6]>,
    margin: f64,
    time: f64,
    held: Option<String>,
    approach: f64,
    speed: Option<f64>,
    acceleration: Option<f64>,
) -> PyResult<PathParts> {
    let config = settings::read(&options)?;
    let target = match is_pose {
        true => PathTarget::Pose(RpyPose::from_array(target)),
        false => PathTarget::Joints(JointPositions(target)),
    };
    let defaults = PlanOptions::to(target);
    let planning = PlanOptions {
        via: via.into_iter().map(JointPositions).collect(),
        margin: within("margin", margin, 0.0, 10.0)?,
        time: Duration::from_secs_f64(within("time", time, 0.001, 3600.0)?),
        held,
        approach: within("approach", approach, 0.0, 10.0)?,
        speed: within("speed", speed.unwrap_or(defaults.speed), 0.001, 100.0)?,
        acceleration: within(
            "acceleration",
            acceleration.unwrap_or(defaults.acceleration),
            0.001,
            100.0,
        )?,
        ..defaults
    };
    let signals = SignalCheck(AtomicBool::new(false));
    #[allow(clippy::result_large_err, reason = "made once in a call")]
    let planned = py.detach(|| plan_path(&config, &planning, &mut || signals.keep_going()));
    if signals.0.load(Ordering::Relaxed) {
        return Err(pyo3::exceptions::PyKeyboardInterrupt::new_err(()));
    }
    let path = planned.map_err(|error| match error {
        PlanError::NoPath { reason, detail } => {
            PlanningError::new_err((reason.as_str(), detail.to_string()))
        }
        PlanError::Start(error) => start_error(&error),
        PlanError::Run(error) => clearance_error(&error),
        other => PyValueError::new_err(other.to_string()),
    })?;
    Ok((
        path.waypoints.iter().map(|q| q.0).collect(),
        path.program,
        path.distance,
        path.length,
        path.time,
        path.planning_time,
        path.warnings.iter().map(ToString::to_string).collect(),
    ))
}

fn within(name: &str, given: f64, least: f64, most: f64) -> PyResult<f64> {
    match (least..=most).contains(&given) {
        true => Ok(given),
        false => Err(PyValueError::new_err(format!(
            "{name} must be a number from {least} to {most}, got {given}"
        ))),
    }
}
