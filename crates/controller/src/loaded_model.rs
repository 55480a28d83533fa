//! The arm that was chosen, and what a recording must keep to build it again.

use kinematics::{Calibration, RobotModel};
use recorder::Setup;

use crate::cell::Cell;
use crate::config::ControllerConfig;
use crate::options::{ClockChoice, ModelChoice, PlantChoice};
use crate::start::StartError;
use crate::start_configuration;

/// Simulated time zero of the virtual clock, ns since 1970: 2026-01-01T00:00:00Z.
const VIRTUAL_EPOCH_NS: u64 = 1_767_225_600_000_000_000;

/// A model with what the recording needs to build it again.
pub(crate) struct LoadedModel {
    pub(crate) model: RobotModel,
    given: String,
    urdf: Option<String>,
}

impl LoadedModel {
    pub(crate) fn open(config: &ControllerConfig) -> Result<Self, StartError> {
        let given = config.model.to_string();
        let (model, urdf) = match &config.model {
            ModelChoice::BuiltIn(name) => (RobotModel::built_in(name), None),
            ModelChoice::Urdf(path) => {
                let text = config
                    .read_text(path)
                    .map_err(|source| StartError::ModelFile {
                        path: path.clone(),
                        source,
                    })?;
                (RobotModel::from_urdf(&text), Some(text))
            }
        };
        let model = model.map_err(|source| StartError::Model {
            model: given.clone(),
            source,
        })?;
        for warning in model.warnings() {
            tracing::warn!("model {given}: {warning}");
        }
        let model = match &config.calibration {
            Some(calibration) => {
                let file = calibration.path().display();
                tracing::info!("model {given}, with the kinematics measured in {file}");
                model.calibrated(calibration)?
            }
            None => model,
        };
        Ok(Self { model, given, urdf })
    }
}

/// How the controller is started, for the recording.
pub(crate) fn setup(
    config: &ControllerConfig,
    loaded: &LoadedModel,
    cell: Option<&Cell>,
    powered_off: bool,
) -> Setup {
    let (clock, epoch_ns) = match config.clock {
        ClockChoice::Virtual => ("virtual", VIRTUAL_EPOCH_NS),
        ClockChoice::Realtime => ("realtime", unix_nanos()),
    };
    Setup {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        model: loaded.given.clone(),
        urdf: loaded.urdf.clone(),
        calibration: loaded.model.calibration().map(Calibration::to_toml),
        cell: cell.map(|cell| cell.text().to_owned()),
        files: cell.map(|cell| cell.files().clone()).unwrap_or_default(),
        home: config.home,
        tcp: config.tcp,
        payload: config.payload,
        step_time: config.step.as_secs(),
        seed: config.seed,
        plant: match config.plant {
            PlantChoice::Rigid => start_configuration::RIGID.to_owned(),
            PlantChoice::Rapier => start_configuration::RAPIER.to_owned(),
            PlantChoice::Ideal => start_configuration::IDEAL.to_owned(),
        },
        clock: clock.to_owned(),
        powered_off,
        epoch_ns,
        part: 1,
    }
}

fn unix_nanos() -> u64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0, |d| u64::try_from(d.as_nanos()).unwrap_or(u64::MAX))
}
