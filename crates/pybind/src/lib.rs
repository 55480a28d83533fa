//! The Python wheel `elitescript`: the arms' mathematics with numpy arrays in and out, controllers in the process of
//! Python, recordings as tables, and the program `eliteserver` as a function.
//!
//! Owns the conversion of arguments and results and the wording of argument errors. What Python sees is assembled in
//! `python/elitescript/`; what is native of controllers is small: numbers and texts in, numbers and texts out.

mod arguments;
mod arm_batch;
mod command;
mod functions;
mod identify;
mod native_controller;
mod paths;
mod recording;
mod results;
mod robot;
mod row;
mod settings;
mod trace;

use pyo3::prelude::*;

pyo3::create_exception!(
    elitescript,
    NoSolutionError,
    pyo3::exceptions::PyRuntimeError,
    "No joint positions inside the limits reach the pose."
);

pyo3::create_exception!(
    elitescript,
    ControllerClosed,
    pyo3::exceptions::PyRuntimeError,
    "The controller was closed."
);

pyo3::create_exception!(
    elitescript,
    ScriptError,
    pyo3::exceptions::PyRuntimeError,
    "A program did not end well. Raised only where it is asked for, by Result.check()."
);

pyo3::create_exception!(
    elitescript,
    PlanningError,
    pyo3::exceptions::PyRuntimeError,
    "There is no path; `reason` is one word, `detail` a sentence."
);

/// Native part of `elitescript`; import that instead.
#[pymodule]
mod _elitescript {
    #[pymodule_export]
    use super::NoSolutionError;
    #[pymodule_export]
    use super::arm_batch::ArmBatch;
    #[pymodule_export]
    use super::command::{eliteserver, preset};
    #[pymodule_export]
    use super::functions::{
        bit_list_to_integer, d2r, integer_to_bit_list, interpolate_pose, log, models, norm,
        normalize, point_dist, pose_add, pose_dist, pose_inv, pose_sub, pose_trans, r2d,
        rotvec2rpy, rpy2rotvec, wrench_trans,
    };
    #[pymodule_export]
    use super::identify::{identified_arrays, identified_files};
    #[pymodule_export]
    use super::native_controller::NativeController;
    #[pymodule_export]
    use super::paths::{measure_clearance, planned_path};
    #[pymodule_export]
    use super::recording::{recording_cycles, recording_table};
    #[pymodule_export]
    use super::robot::Robot;
    #[pymodule_export]
    use super::row::row_fields;
    #[pymodule_export]
    use super::settings::option_names;
    #[pymodule_export]
    use super::{ControllerClosed, PlanningError, ScriptError};

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's name")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
