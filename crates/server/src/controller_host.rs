//! A controller with what the binary adds: who is told on ports, in the log and on the console.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use controller::{Controller, ControllerConfig, PreparedController, StartError, StartOptions};
use editor::dap::{DebugHub, HubDebugger};
use elite_runtime::Instrumentation;
use messages::Localized;
use motion::ConfigError;
use thiserror::Error;

use crate::describe::robot_description;
use crate::event_broadcast::{EventBroadcaster, PrintTarget};
use crate::log_dir::InterpreterLog;
use crate::ports::description::RobotDescription;
use crate::sample_feed::SampleFeed;

/// What kept the controller from starting; each is a sentence for the person who typed the command.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum HostError {
    /// The controller itself.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A setting does not fit the arm.
    #[error(transparent)]
    Settings(#[from] ConfigError),
    /// No log files.
    #[error("--log-dir: cannot write into {}: {source}", path.display())]
    #[zh("--log-dir：无法写入 {}：{source}", path.display())]
    LogDir {
        /// Path of the folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The operating system gave no thread.
    #[error("cannot start a thread: {0}")]
    #[zh("无法启动线程：{0}")]
    Thread(#[from] io::Error),
}

/// A running controller and those who are told of it.
pub struct ControllerHost {
    controller: Controller,
    feed: Arc<SampleFeed>,
    announcer: Arc<EventBroadcaster>,
    interpreter_log: InterpreterLog,
    description: RobotDescription,
    debuggers: Arc<DebugHub>,
}

impl ControllerHost {
    /// Starts a controller of which `console` tells; one that tells the log is served. `log_dir` is the folder of the
    /// vendor's log files.
    ///
    /// # Errors
    /// [`HostError`], in a sentence.
    pub fn start(
        config: &ControllerConfig,
        log_dir: Option<&PathBuf>,
        console: PrintTarget,
        powered_off: bool,
        debuggers: DebugHub,
    ) -> Result<Self, HostError> {
        let manner = match console {
            PrintTarget::Log => StartOptions::for_server(powered_off),
            PrintTarget::Stdout | PrintTarget::Stderr => StartOptions::for_single_run(),
        };
        let prepared = PreparedController::new(config, manner)?;
        let interpreter_log = match log_dir {
            Some(folder) => {
                let snapshot = prepared.snapshot().clone();
                InterpreterLog::open(folder, snapshot, prepared.faults()).map_err(|source| {
                    let path = folder.clone();
                    HostError::LogDir { path, source }
                })?
            }
            None => InterpreterLog::default(),
        };
        let feed = Arc::new(SampleFeed::new(prepared.model().clone()));
        let announcer = EventBroadcaster::new(console, interpreter_log.clone(), feed.clone());
        let announcer = Arc::new(announcer);
        let debuggers = Arc::new(debuggers);
        let extras = match console {
            PrintTarget::Log => Instrumentation {
                debug: Some(Arc::new(HubDebugger(debuggers.clone()))),
                ..Instrumentation::default()
            },
            PrintTarget::Stdout | PrintTarget::Stderr => Instrumentation::default(),
        };
        let controller =
            prepared.start_with_timeline(announcer.clone(), extras, |timeline| timeline)?;
        feed.follow(controller.supervisor().watch());
        let description = robot_description(controller.settings())?;
        Ok(Self {
            controller,
            feed,
            announcer,
            interpreter_log,
            description,
            debuggers,
        })
    }

    /// The controller.
    pub const fn controller(&self) -> &Controller {
        &self.controller
    }

    /// Ends it, as [`Controller::shut_down`] says.
    pub fn shut_down(self) -> bool {
        self.controller.shut_down()
    }

    /// The hub that debuggers attach to, if the controller serves.
    pub const fn debuggers(&self) -> &Arc<DebugHub> {
        &self.debuggers
    }

    /// What every cycle is shown to.
    pub const fn feed(&self) -> &Arc<SampleFeed> {
        &self.feed
    }

    /// Who tells everybody.
    pub const fn announcer(&self) -> &Arc<EventBroadcaster> {
        &self.announcer
    }

    /// The log files of interpreter mode.
    pub const fn interpreter_log(&self) -> &InterpreterLog {
        &self.interpreter_log
    }

    /// What ports tell of the arm.
    pub const fn description(&self) -> &RobotDescription {
        &self.description
    }
}
