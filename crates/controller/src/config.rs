//! The settings of a robot, whoever starts it. Reads no file but the calibration that it is given read.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use elite_runtime::SandboxRoots;
use kinematics::{Calibration, JointPositions, Payload, RpyPose};

use crate::cell::{Cell, CellError};
use crate::options::{
    ByteSize, ClockChoice, HomeJoints, ModelChoice, Permission, PlantChoice, RecordTarget,
    RotationLimit, StepMillis,
};

/// Settings of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerConfig {
    /// Model of the arm.
    pub model: ModelChoice,
    /// What was measured of it.
    pub calibration: Option<Calibration>,
    /// The cell file.
    pub cell: Option<PathBuf>,
    /// What a second is.
    pub clock: ClockChoice,
    /// Length of a control cycle.
    pub step: StepMillis,
    /// Under the real clock cycles begin this long after a multiple of the step on the machine's clock; `None`: when it
    /// starts.
    pub cycle_phase: Option<Duration>,
    /// How the arm is simulated.
    pub plant: PlantChoice,
    /// Folder of the task files.
    pub task_dir: PathBuf,
    /// Target of the recording.
    pub record: RecordTarget,
    /// Limit at which the recording goes on in its next file.
    pub record_rotate: Option<RotationLimit>,
    /// Size of finished recordings above which the oldest are removed.
    pub record_budget: Option<ByteSize>,
    /// TCP relative to the flange.
    pub tcp: RpyPose,
    /// What hangs on the flange.
    pub payload: Payload,
    /// Joint positions at start.
    pub home: JointPositions,
    /// Seed of everything random.
    pub seed: u64,
    /// What scripts may reach beyond the robot.
    pub allow: BTreeSet<Permission>,
    /// The folders beneath which the files are that these settings name, links followed; `None`: anywhere.
    pub sandbox: Option<SandboxRoots>,
}

impl Default for ControllerConfig {
    /// A CS66 under the virtual clock with nothing around it and no recording.
    fn default() -> Self {
        Self {
            model: ModelChoice::BuiltIn("cs66"),
            calibration: None,
            cell: None,
            clock: ClockChoice::Virtual,
            step: StepMillis::DEFAULT,
            cycle_phase: None,
            plant: PlantChoice::Rigid,
            task_dir: "tasks".into(),
            record: RecordTarget::Off,
            record_rotate: None,
            record_budget: None,
            tcp: RpyPose::default(),
            payload: Payload::default(),
            home: HomeJoints::default().0,
            seed: 0,
            allow: BTreeSet::from([Permission::Net]),
            sandbox: None,
        }
    }
}

impl ControllerConfig {
    /// The text of a file that these settings name.
    pub(crate) fn read_text(&self, path: &Path) -> io::Result<String> {
        read_text_within(self.sandbox.as_ref(), path)
    }

    /// What stands around the arm, where these settings name a cell file.
    ///
    /// # Errors
    /// [`CellError`], with the path and, for what the file says, the line.
    pub(crate) fn read_cell(&self) -> Result<Option<Cell>, CellError> {
        let Some(path) = self.cell.as_deref() else {
            return Ok(None);
        };
        let text = self
            .read_text(path)
            .map_err(|source| CellError::Unreadable {
                path: path.to_owned(),
                source,
            })?;
        Cell::from_text_beside_files(text, path).map(Some)
    }
}

/// The text of a file, which must be beneath the folders if there are any, links followed.
///
/// # Errors
/// The operating system's; a file that is too long, is no text, or lies elsewhere.
pub fn read_text_within(within: Option<&SandboxRoots>, path: &Path) -> io::Result<String> {
    match within {
        Some(folders) => folders.read_text(path),
        None => kinematics::text_file::read_text_file(path),
    }
}
