//! A script run here as the arm of a recording: its model, calibration, tool, payload, place, step and cell.
//!
//! What the recording does not say is as `run` has it. The run is recorded, and compared from there like any other.

use std::io;
use std::path::{Component, Path, PathBuf};

use elite_runtime::TaskEnd;
use messages::{Localized, Text, text};
use recorder::{CellFiles, Setup};
use tempfile::TempDir;
use thiserror::Error;

use editor::dap::DebugHub;

use crate::command::CommandStatus;
use crate::commands::check::read_script;
use crate::commands::run::SENDER;
use crate::controller_host::{ControllerHost, HostError};
use crate::event_broadcast::PrintTarget;
use crate::language;
use crate::shutdown::Shutdown;
use controller::ControllerConfig;
use controller::options::{ModelChoice, RecordTarget};
use controller::start_configuration::{RecordedSettingsError, recorded_settings};

/// A reason why there is no run, told in a sentence.
#[derive(Debug, Error, Localized)]
pub(super) enum RunHereError {
    #[error("the recording {0} does not say which arm it is of")]
    #[zh("记录 {0} 没有说明是哪种手臂")]
    NoSetup(String),
    #[error("{0}")]
    Script(Text),
    #[error("the script does not compile; there is nothing to compare")]
    #[zh("脚本无法编译；没有可比较的内容")]
    NotCompiled,
    #[error("the run was broken off; nothing is compared")]
    #[zh("运行已中断；不作比较")]
    BrokenOff,
    #[error("the recording is of an arm {given:?}, which is none of ours: {allowed}")]
    #[zh("记录来自手臂 {given:?}，不是所支持的型号：{allowed}")]
    Model { given: String, allowed: Text },
    #[error(transparent)]
    Settings(#[from] RecordedSettingsError),
    #[error("cannot write the run beside the comparison: {0}")]
    #[zh("无法在比较旁写入运行记录：{0}")]
    Folder(#[from] io::Error),
    #[error(transparent)]
    Start(Box<HostError>),
}

impl From<HostError> for RunHereError {
    fn from(error: HostError) -> Self {
        Self::Start(Box::new(error))
    }
}

/// A run that was recorded. Unless it is kept, its file goes with this.
pub(super) struct LocalRun {
    /// The recording.
    pub(super) path: PathBuf,
    _folder: TempDir,
}

/// Runs the script on the arm that `setup` describes; `keep` is where the recording stays.
pub(super) fn run_here(
    setup: &Setup,
    script: &Path,
    keep: Option<&Path>,
) -> Result<LocalRun, RunHereError> {
    let program = read_script(script).map_err(RunHereError::Script)?;
    let folder = tempfile::Builder::new()
        .prefix("eliteserver-compare-")
        .tempdir()?;
    let path = keep.map_or_else(|| folder.path().join("run.mcap"), Path::to_owned);
    let config = config_of(setup, folder.path(), &path)?;
    let shutdown = Shutdown::start(CommandStatus::NotDone)?;
    let host = ControllerHost::start(
        &config,
        None,
        PrintTarget::Stderr,
        false,
        DebugHub::default(),
    )?;
    let controller = host.controller();
    shutdown.set_recording_closer(controller.closer());
    let end = controller.run_to_end(program, SENDER, shutdown.token().cancelled())?;
    host.shut_down();
    if shutdown.token().is_cancelled() {
        return Err(RunHereError::BrokenOff);
    }
    match end {
        Some(TaskEnd::NotCompiled) | None => return Err(RunHereError::NotCompiled),
        Some(TaskEnd::Finished) => {}
        Some(_) => language::say(&text!(
            "the script did not end well here; what it did is compared",
            "脚本在此没有正常结束；比较其所做的"
        )),
    }
    Ok(LocalRun {
        path,
        _folder: folder,
    })
}

/// The settings of `run` with what the recording says.
fn config_of(
    setup: &Setup,
    folder: &Path,
    record: &Path,
) -> Result<ControllerConfig, RunHereError> {
    let model = match &setup.urdf {
        Some(urdf) => {
            let path = folder.join("arm.urdf");
            std::fs::write(&path, urdf)?;
            ModelChoice::Urdf(path)
        }
        None => setup
            .model
            .parse()
            .map_err(|allowed: Text| RunHereError::Model {
                given: setup.model.clone(),
                allowed,
            })?,
    };
    let cell = match &setup.cell {
        Some(text) => {
            let path = folder.join("cell.toml");
            std::fs::write(&path, text)?;
            write_cell_files(folder, &setup.files)?;
            Some(path)
        }
        None => None,
    };
    let others = ControllerConfig {
        record: RecordTarget::File(record.to_owned()),
        ..ControllerConfig::default()
    };
    Ok(recorded_settings(setup, model, cell, others)?)
}
/// Puts the files of a recorded cell beside its text. A path that leads elsewhere is left out: the cell refuses it.
fn write_cell_files(folder: &Path, files: &CellFiles) -> std::io::Result<()> {
    for (path, content) in files {
        let is_within = Path::new(path)
            .components()
            .all(|part| matches!(part, Component::Normal(_)));
        if is_within {
            let path = folder.join(path);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent)?;
            }
            std::fs::write(path, content)?;
        }
    }
    Ok(())
}
