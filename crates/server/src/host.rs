//! A controller with what the binary adds: who is told on ports, in the log and on the console.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use controller::{Controller, Manner, Prepared, RobotConfig, StartError};
use editor::dap::{Hub, HubLink};
use elite_runtime::Extras;
use motion::ConfigError;
use thiserror::Error;

use crate::announce::{Announcer, Console};
use crate::describe::describe;
use crate::feed::Feed;
use crate::log_dir::InterpreterLog;
use crate::ports::description::RobotDescription;

/// What kept the controller from starting; each is a sentence for the person who typed the command.
#[derive(Debug, Error)]
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
    LogDir {
        /// Which folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The operating system gave no thread.
    #[error("cannot start a thread: {0}")]
    Thread(#[from] io::Error),
}

/// A running controller and those who are told of it.
pub struct Host {
    controller: Controller,
    feed: Arc<Feed>,
    announcer: Arc<Announcer>,
    interpreter_log: InterpreterLog,
    description: RobotDescription,
    debuggers: Arc<Hub>,
}

impl Host {
    /// Starts a controller of which `console` tells; one that tells the log is served. `log_dir` is the folder of the
    /// vendor's log files.
    ///
    /// # Errors
    /// [`HostError`], in a sentence.
    pub fn start(
        config: &RobotConfig,
        log_dir: Option<&PathBuf>,
        console: Console,
        powered_off: bool,
        debuggers: Hub,
    ) -> Result<Self, HostError> {
        let manner = match console {
            Console::Log => Manner::served(powered_off),
            Console::Stdout | Console::Stderr => Manner::alone(),
        };
        let prepared = Prepared::new(config, manner)?;
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
        let feed = Arc::new(Feed::new(prepared.model().clone()));
        let announcer = Announcer::new(console, interpreter_log.clone(), feed.clone());
        let announcer = Arc::new(announcer);
        let debuggers = Arc::new(debuggers);
        let extras = match console {
            Console::Log => Extras {
                debug: Some(Arc::new(HubLink(debuggers.clone()))),
                ..Extras::default()
            },
            Console::Stdout | Console::Stderr => Extras::default(),
        };
        let controller = prepared.start_through(announcer.clone(), extras, |timeline| timeline)?;
        feed.follow(controller.supervisor().watch());
        let description = describe(controller.settings())?;
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

    /// Where debuggers attach, if it serves.
    pub const fn debuggers(&self) -> &Arc<Hub> {
        &self.debuggers
    }

    /// What every cycle is shown to.
    pub const fn feed(&self) -> &Arc<Feed> {
        &self.feed
    }

    /// Who tells everybody.
    pub const fn announcer(&self) -> &Arc<Announcer> {
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
