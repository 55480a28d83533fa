//! The Python wheel `elitescript`: the kinematics crate with numpy arrays in and out.
//!
//! Owns the conversion of arguments and results and the wording of argument errors. Knows no robot that runs: no script,
//! no port, no controller. What Python sees is assembled in `python/elitescript/`.

mod arguments;
mod functions;
mod results;
mod robot;

use pyo3::prelude::*;

pyo3::create_exception!(
    elitescript,
    NoSolutionError,
    pyo3::exceptions::PyRuntimeError,
    "No joint positions inside the limits reach the pose."
);

/// Native part of `elitescript`; import that instead.
#[pymodule]
mod _elitescript {
    #[pymodule_export]
    use super::NoSolutionError;
    #[pymodule_export]
    use super::functions::{
        bit_list_to_integer, d2r, integer_to_bit_list, interpolate_pose, log, models, norm,
        normalize, point_dist, pose_add, pose_dist, pose_inv, pose_sub, pose_trans, r2d,
        rotvec2rpy, rpy2rotvec, wrench_trans,
    };
    #[pymodule_export]
    use super::robot::Robot;

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's name")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
