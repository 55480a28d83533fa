//! From what a recording keeps about the start to the configuration of the control cycle, and to settings of a robot.
//!
//! Starting and running again go through this one place, so they cannot drift apart. Reads no file.

use std::path::{Path, PathBuf};

use kinematics::{Calibration, CalibrationError, RobotModel};
use messages::{Localized, Text};
use motion::{CycleConfig, PlantKind};
use recorder::Setup;
use thiserror::Error;

use crate::cell::Cell;
use crate::config::ControllerConfig;
use crate::options::{ModelChoice, PlantChoice, StepMillis};

/// The plant that follows the servos as a mass with drives does.
pub const RIGID: &str = "rigid";
/// Name of the rigid bodies in the rapier engine.
pub const RAPIER: &str = "rapier";
/// The plant that is always where it should be.
pub const IDEAL: &str = "ideal";
/// What a recording of a robot elsewhere has in place of a plant and a clock.
pub const ROBOT: &str = "robot";

/// A [`Setup`] that this version cannot start from.
#[derive(Debug, Error, PartialEq, Localized)]
#[non_exhaustive]
pub enum SetupError {
    /// The plant is none of this version's.
    #[error("there is no plant {0:?}; allowed are {RIGID:?}, {RAPIER:?} and {IDEAL:?}")]
    #[zh("没有 plant {0:?}；允许 {RIGID:?}、{RAPIER:?} 和 {IDEAL:?}")]
    Plant(String),
    /// Another controller than ours moved the arm.
    #[error(
        "this is a recording of a robot elsewhere, which has no commands to run again; `compare` tells how far another \
         recording is from it"
    )]
    #[zh("这是其他机器人的记录，其中没有可重新运行的命令；`compare` 可报告另一记录与它相差多少")]
    RemoteRobot,
    /// A payload the arm is not rated for.
    #[error("--payload {mass} kg is more than the {rated} kg that {model} is rated for")]
    #[zh("--payload {mass} kg 超过 {model} 的额定负载 {rated} kg")]
    Payload {
        /// Mass that was given, kg.
        mass: f64,
        /// Mass that the arm is rated for, kg.
        rated: f64,
        /// Model of the arm.
        model: String,
    },
}

/// Settings in a recording that no controller here can have.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum RecordedSettingsError {
    /// The plant is none of this version's.
    #[error(transparent)]
    Plant(#[from] SetupError),
    /// What was measured of the arm is damaged.
    #[error("the calibration in the recording is not usable: {0}")]
    #[zh("记录中的标定不可用：{0}")]
    Calibration(#[from] CalibrationError),
    /// The cycles were longer or shorter than those of a controller here.
    #[error("the recording has cycles of {millis} ms; {allowed}")]
    #[zh("记录的周期为 {millis} ms；{allowed}")]
    Step {
        /// Length of a cycle, rounded, ms.
        millis: f64,
        /// What is allowed.
        allowed: Text,
    },
}

/// The robot of a recording as settings of a controller here. Files that the recording holds the text of are wherever
/// the caller has them: the arm's as `model`, the cell file as `cell`. What a recording does not say is as in `others`.
///
/// # Errors
/// [`RecordedSettingsError`]
pub fn recorded_settings(
    setup: &Setup,
    model: ModelChoice,
    cell: Option<PathBuf>,
    others: ControllerConfig,
) -> Result<ControllerConfig, RecordedSettingsError> {
    let calibration = setup.calibration.as_deref();
    let calibration = calibration
        .map(|text| Calibration::from_text(text, Path::new("the recorded calibration")))
        .transpose()?;
    let millis = (setup.step_time * 1e3).round();
    let step = match millis.to_string().parse() {
        Ok(step) => step,
        // A robot elsewhere that was recorded more slowly moved in steps of its own.
        Err(_) if setup.plant == ROBOT => StepMillis::DEFAULT,
        Err(allowed) => return Err(RecordedSettingsError::Step { millis, allowed }),
    };
    Ok(ControllerConfig {
        model,
        calibration,
        cell,
        step,
        plant: plant_of(setup)?,
        tcp: setup.tcp,
        payload: setup.payload,
        home: setup.home,
        seed: setup.seed,
        ..others
    })
}

fn plant_of(setup: &Setup) -> Result<PlantChoice, SetupError> {
    match setup.plant.as_str() {
        // A robot elsewhere is shown as rigid bodies, and compared with them; it is never run again.
        RIGID | ROBOT => Ok(PlantChoice::Rigid),
        RAPIER => Ok(PlantChoice::Rapier),
        IDEAL => Ok(PlantChoice::Ideal),
        other => Err(SetupError::Plant(other.to_owned())),
    }
}

/// The configuration of the cycle for `model` in `cell`, both of which `setup` names.
///
/// # Errors
/// [`SetupError`] names what does not fit.
pub fn cycle_config(
    setup: &Setup,
    model: RobotModel,
    cell: Option<&Cell>,
) -> Result<CycleConfig, SetupError> {
    if let Some(rated) = model.rated_payload_kg()
        && setup.payload.mass > rated
    {
        return Err(SetupError::Payload {
            mass: setup.payload.mass,
            rated,
            model: model.name().to_owned(),
        });
    }
    let plant = match plant_of(setup)? {
        PlantChoice::Rigid => PlantKind::Rigid,
        PlantChoice::Rapier => PlantKind::Rapier,
        PlantChoice::Ideal => PlantKind::Ideal,
    };
    Ok(CycleConfig {
        step_time: setup.step_time,
        home: setup.home,
        tcp: setup.tcp,
        payload: setup.payload,
        plant,
        limits: cell.map(Cell::limits).unwrap_or_default(),
        reduced_limits: cell.map(Cell::reduced_limits).unwrap_or_default(),
        safety_inputs: cell.map(Cell::safety_inputs).unwrap_or_default(),
        powered_off: setup.powered_off,
        io: cell.map(Cell::io).unwrap_or_default(),
        safety: cell
            .map(|cell| cell.safety_bounds().clone())
            .unwrap_or_default(),
        belts: cell.map(Cell::belts).unwrap_or_default(),
        loads: cell.map(Cell::loads).unwrap_or_default(),
        surroundings: cell.map(Cell::surroundings).unwrap_or_default(),
        truth: cell.map(Cell::truth).unwrap_or_default(),
        sensor_noise: cell
            .map(|cell| cell.sensor_noise(setup.seed))
            .unwrap_or_default(),
        ..CycleConfig::new(model)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(setup: &Setup) -> Result<ControllerConfig, String> {
        let others = ControllerConfig {
            task_dir: "elsewhere".into(),
            ..ControllerConfig::default()
        };
        let model = ModelChoice::BuiltIn("cs612");
        recorded_settings(setup, model, None, others).map_err(|error| error.to_string())
    }

    #[test]
    fn a_recording_says_the_robot_and_nothing_else() {
        let mut setup = Setup {
            plant: RAPIER.to_owned(),
            step_time: 0.002,
            seed: 7,
            ..Setup::default()
        };
        setup.home.0[0] = 0.25;
        setup.payload.mass = 1.5;
        let config = settings(&setup).unwrap();
        assert_eq!(config.model, ModelChoice::BuiltIn("cs612"));
        assert_eq!(config.plant, PlantChoice::Rapier);
        assert_eq!(config.step, "2".parse().unwrap());
        assert_eq!((config.home, config.payload), (setup.home, setup.payload));
        assert_eq!((config.seed, config.tcp), (7, setup.tcp));
        assert_eq!(config.task_dir, PathBuf::from("elsewhere"));
    }

    #[test]
    fn what_no_controller_here_can_have_is_named() {
        let with = |plant: &str, step_time| Setup {
            plant: plant.to_owned(),
            step_time,
            ..Setup::default()
        };
        let plant = settings(&with("sponge", 0.004)).unwrap_err();
        assert!(plant.starts_with("there is no plant \"sponge\""), "{plant}");
        assert_eq!(
            settings(&with(IDEAL, 0.020)),
            Err(
                "the recording has cycles of 20 ms; allowed are whole milliseconds from 1 to 8"
                    .to_owned()
            )
        );
        let elsewhere = settings(&with(ROBOT, 0.020)).unwrap();
        assert_eq!(
            (elsewhere.plant, elsewhere.step),
            (PlantChoice::Rigid, StepMillis::DEFAULT)
        );
        let measured = Setup {
            calibration: Some("no table".to_owned()),
            ..Setup::default()
        };
        let measured = settings(&measured).unwrap_err();
        assert!(
            measured.starts_with("the calibration in the recording is not usable: "),
            "{measured}"
        );
    }
}
