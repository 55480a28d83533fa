//! The program `eliteserver` as a function, for the console command of the wheel, and its way to say presets.

use elite_runtime::Preset;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Runs the program with these arguments, the name of the program first; its exit status. The process must have nothing
/// else to do: the program listens for signals, and `--help` ends the process.
#[pyfunction]
pub(crate) fn eliteserver(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| server::program::run_program(arguments))
}

/// The statement that sets a global before a program; ValueError says what is allowed.
#[pyfunction]
pub(crate) fn preset(name: &str, value: &str) -> PyResult<String> {
    let preset = Preset::new(name, value);
    let preset = preset.map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(preset.statement())
}
