//! From what a recording keeps about the start to the configuration of the control cycle.
//!
//! Starting and running again go through this one place, so they cannot drift apart. Reads no file.

use kinematics::RobotModel;
use motion::{CycleConfig, PlantKind};
use recorder::Setup;
use thiserror::Error;

use crate::cell::Cell;

/// The plant that follows the servos as a mass with drives does.
pub const RIGID: &str = "rigid";
/// Name of the rigid bodies in the rapier engine.
pub const RAPIER: &str = "rapier";
/// The plant that is always where it should be.
pub const IDEAL: &str = "ideal";
/// What a recording of a robot elsewhere has in place of a plant and a clock.
pub const ROBOT: &str = "robot";

/// A [`Setup`] that this version cannot start from.
#[derive(Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SetupError {
    /// The plant is none of this version's.
    #[error("there is no plant {0:?}; allowed are {RIGID:?}, {RAPIER:?} and {IDEAL:?}")]
    Plant(String),
    /// Another controller than ours moved the arm.
    #[error(
        "this is a recording of a robot elsewhere, which has no commands to run again; `compare` tells how far another \
         recording is from it"
    )]
    RemoteRobot,
    /// A payload the arm is not rated for.
    #[error("--payload {mass} kg is more than the {rated} kg that {model} is rated for")]
    Payload {
        /// Mass that was given, kg.
        mass: f64,
        /// Mass that the arm is rated for, kg.
        rated: f64,
        /// Model of the arm.
        model: String,
    },
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
    let plant = match setup.plant.as_str() {
        // A robot elsewhere is shown as one; it is never run again.
        RIGID | ROBOT => PlantKind::Rigid,
        RAPIER => PlantKind::Rapier,
        IDEAL => PlantKind::Ideal,
        other => return Err(SetupError::Plant(other.to_owned())),
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
        safety: cell.map(|cell| *cell.safety_bounds()).unwrap_or_default(),
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
