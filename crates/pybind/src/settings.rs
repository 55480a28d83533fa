//! Options of a controller as texts, in the forms of the command line, to the settings of a robot.
//!
//! Owns which options there are. Python makes texts of numbers and arrays before it calls.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::str::FromStr;

use controller::ControllerConfig;
use controller::options::{HomeJoints, ModelChoice, PayloadChoice, Tcp};
use kinematics::Calibration;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Every option of a controller.
const NAMES: [&str; 13] = [
    "model",
    "cell",
    "plant",
    "step_ms",
    "seed",
    "home",
    "tcp",
    "payload",
    "calibration",
    "task_dir",
    "record",
    "allow",
    "inertia",
];

/// The settings that these options make; options that are not given have the defaults of the command line.
pub(crate) fn read(given: &BTreeMap<String, String>) -> PyResult<ControllerConfig> {
    if let Some(unknown) = given.keys().find(|name| !NAMES.contains(&name.as_str())) {
        return Err(PyValueError::new_err(format!(
            "there is no option {unknown}; allowed are {}",
            NAMES[..12].join(", ")
        )));
    }
    let mut config = ControllerConfig::default();
    let text = |name: &str| given.get(name).map(String::as_str);
    let calibration = text("calibration").map(|path| Calibration::load(path.as_ref()));
    let calibration = calibration.transpose().map_err(wrong)?;
    if let Some(calibration) = calibration {
        let asked: Option<ModelChoice> = value(given, "model")?;
        let asked = asked.map(|model| model.to_string());
        let name = calibration.model_for(asked.as_deref()).map_err(wrong)?;
        config.model = name.parse().map_err(wrong)?;
        config.calibration = Some(calibration);
    } else if let Some(model) = value(given, "model")? {
        config.model = model;
    }
    config.cell = text("cell").map(Into::into);
    config.task_dir = text("task_dir").map_or(config.task_dir, Into::into);
    config.plant = value(given, "plant")?.unwrap_or(config.plant);
    config.step = value(given, "step_ms")?.unwrap_or(config.step);
    config.record = value(given, "record")?.unwrap_or(config.record);
    config.home = value(given, "home")?.map_or(config.home, |home: HomeJoints| home.0);
    config.tcp = value(given, "tcp")?.map_or(config.tcp, |tcp: Tcp| tcp.0);
    let payload: Option<PayloadChoice> = value(given, "payload")?;
    config.payload = payload.map_or(config.payload, |payload| payload.0);
    if let Some(inertia) = text("inertia") {
        let numbers: Result<Vec<f64>, _> = inertia.split(',').map(str::parse).collect();
        let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
        config.payload.inertia = numbers.ok_or_else(|| {
            PyValueError::new_err("payload: the inertia must be six numbers, kg m^2")
        })?;
    }
    if let Some(seed) = text("seed") {
        config.seed = seed.parse().map_err(|_| {
            PyValueError::new_err(format!(
                "seed: allowed are whole numbers from 0 to {}, got {seed}",
                u64::MAX
            ))
        })?;
    }
    if let Some(allow) = text("allow") {
        let permissions = allow.split('\n').filter(|word| !word.is_empty());
        let permissions: Result<BTreeSet<_>, _> = permissions
            .map(|word| {
                word.parse()
                    .map_err(|why: String| told("allow", word, &why))
            })
            .collect();
        config.allow = permissions?;
    }
    Ok(config)
}

fn value<T: FromStr<Err = String>>(
    given: &BTreeMap<String, String>,
    name: &str,
) -> PyResult<Option<T>> {
    let text = given.get(name);
    text.map(|text| text.parse().map_err(|why: String| told(name, text, &why)))
        .transpose()
}

fn told(name: &str, given: &str, why: &str) -> PyErr {
    PyValueError::new_err(format!("{name}: {why}, got {given}"))
}

fn wrong(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}
