//! Options of a controller as texts, in the forms of the command line, to the settings of a robot.
//!
//! Owns which options there are. Python makes texts of numbers and arrays before it calls.

use std::collections::BTreeMap;

use controller::ControllerConfig;
use controller::options::{ControllerOptions, keys_of};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Options that mean nothing here: time is simulated, and a recording is one file.
const REFUSED: [&str; 3] = ["clock", "record-rotate", "record-budget"];

/// Names of the options of a controller, as Python writes them.
#[pyfunction]
pub(crate) fn option_names() -> Vec<String> {
    let keys = keys_of::<ControllerOptions>().into_iter();
    let taken = keys.filter(|key| !REFUSED.contains(&key.as_str()));
    taken.map(|key| key.replace('-', "_")).collect()
}

/// The settings that these options make; options that are not given have the defaults of the command line. A list is
/// given with one item a line.
pub(crate) fn read(given: &BTreeMap<String, String>) -> PyResult<ControllerConfig> {
    let names = option_names();
    let mut options = ControllerOptions::default();
    for (name, text) in given {
        let key = name.replace('_', "-");
        let slot = options.slot(&key).filter(|_| names.contains(name));
        let Some(slot) = slot else {
            let allowed = names.join(", ");
            return Err(PyValueError::new_err(format!(
                "there is no option {name}; allowed are {allowed}"
            )));
        };
        let texts: Vec<String> = match slot.is_list() {
            true => text
                .split('\n')
                .filter(|word| !word.is_empty())
                .map(str::to_owned)
                .collect(),
            false => vec![text.clone()],
        };
        slot.fill(&texts).map_err(|refused| {
            PyValueError::new_err(format!(
                "{name}: {}, got {}",
                refused.allowed, refused.given
            ))
        })?;
    }
    options
        .resolve(ControllerConfig::default(), None)
        .map_err(|error| PyValueError::new_err(error.to_string()))
}
