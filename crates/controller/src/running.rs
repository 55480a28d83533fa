//! A controller whose time passes: programs, the arm, the recording, and how all of it ends.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use elite_runtime::message::{CONTROLLER_FAULT_CODE, Message, Observer, Severity};
use elite_runtime::{ProgramText, Robot, SandboxedPath, Supervisor, TaskEnd};
use io_bus::Fieldbus;
use io_bus::modbus_server::tables::Slaves;
use messages::text;
use motion::CycleConfig;
use motion::realtime::ClockMetrics;
use recorder::{CloseHandle, Recorder, RecorderMetrics, ViewerMessages};
use supervision::{Fault, ThreadSupervisor};

use crate::cell::Cell;
use crate::cell_world::CellWorld;
use crate::clock::{ClockDriver, EventPump};
use crate::recording_observer::{LogLines, RecordingObserver};

/// A running controller.
pub struct Controller {
    pub(crate) robot: Arc<Robot>,
    pub(crate) fieldbus: Arc<Fieldbus>,
    pub(crate) supervisor: Supervisor,
    pub(crate) chronicle: Arc<RecordingObserver>,
    pub(crate) clock: ClockDriver,
    pub(crate) pump: EventPump,
    pub(crate) recorder: Option<Recorder>,
    pub(crate) recording_path: Option<PathBuf>,
    /// Held until the recording is written.
    pub(crate) _recording_place: Option<SandboxedPath>,
    pub(crate) viewer: ViewerMessages,
    pub(crate) settings: CycleConfig,
    pub(crate) faults: ThreadSupervisor,
    pub(crate) cell: Option<Cell>,
    pub(crate) world: Option<CellWorld>,
    pub(crate) grippers: BTreeMap<u16, Slaves>,
}

impl Controller {
    /// The supervisor that hears of faults of the controller's threads.
    pub const fn faults(&self) -> &ThreadSupervisor {
        &self.faults
    }

    /// Closes the recording, if there is one, without the controller's help.
    pub fn closer(&self) -> Option<CloseHandle> {
        self.recorder.as_ref().and_then(Recorder::closer)
    }

    /// Tells everybody of the fault after which the process must end.
    pub fn announce_fault(&self, fault: &Fault) {
        self.chronicle.message(&Message::Robot {
            origin: motion_api::Origin::default(),
            code: CONTROLLER_FAULT_CODE,
            sub_code: 0,
            severity: Severity::Error,
            text: text!(
                "the controller ends, the arm is held: {fault}",
                "控制器结束，手臂保持原位：{fault}"
            ),
        });
    }

    /// The robot.
    pub const fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    /// Modbus devices, serial ports and the values of the controller's own Modbus server.
    pub const fn fieldbus(&self) -> &Arc<Fieldbus> {
        &self.fieldbus
    }

    /// Starts and stops programs.
    pub const fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// What `/log` of the recording gets.
    pub fn log_lines(&self) -> LogLines {
        self.chronicle.log_lines()
    }

    /// The file that is being recorded.
    pub fn recording_path(&self) -> Option<&Path> {
        self.recording_path.as_deref()
    }

    /// How the control cycle was set up.
    pub const fn settings(&self) -> &CycleConfig {
        &self.settings
    }

    /// What stands around the arm, as it was read at the start.
    pub const fn cell(&self) -> Option<&Cell> {
        self.cell.as_ref()
    }

    /// The parts of the cell and what handles them, where it has any.
    pub const fn world(&self) -> Option<&CellWorld> {
        self.world.as_ref()
    }

    /// Grippers of the cell on Modbus TCP, by port, for whoever opens these ports.
    pub const fn tcp_grippers(&self) -> &BTreeMap<u16, Slaves> {
        &self.grippers
    }

    /// Makes what viewers show of the arm and its cell.
    pub fn viewer(&self) -> ViewerMessages {
        self.viewer.clone()
    }

    /// How well the motion thread meets its deadlines; all zeros under the virtual clock.
    pub fn clock_meter(&self) -> ClockMetrics {
        match &self.clock {
            ClockDriver::Real(thread, _) => thread.meter(),
            ClockDriver::Virtual(_) => ClockMetrics::default(),
        }
    }

    /// Figures of the recording, if there is one.
    pub fn recorder_meter(&self) -> Option<RecorderMetrics> {
        self.recorder.as_ref().map(Recorder::meter)
    }

    /// Runs a program of `sender` and waits for its end; when `stop` comes first, the program is stopped. `None`: it
    /// was refused, which the observer was told.
    ///
    /// # Errors
    /// The operating system gave no runtime.
    pub fn run_to_end(
        &self,
        program: ProgramText,
        sender: &str,
        stop: impl Future<Output = ()>,
    ) -> io::Result<Option<TaskEnd>> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        runtime.block_on(async {
            let Ok(_) = self.supervisor.submit(program, sender).await else {
                return Ok(None);
            };
            tokio::select! {
                end = self.supervisor.ended() => Ok(end),
                () = stop => {
                    self.supervisor.stop();
                    Ok(self.supervisor.ended().await)
                }
            }
        })
    }

    /// Ends what runs, in order: motion, pump, recording. Programs must have ended. True when the recording was written
    /// to its end.
    pub fn shut_down(self) -> bool {
        match self.clock {
            ClockDriver::Real(thread, world) => {
                drop(thread.stop());
                if let Some(world) = world {
                    world.stop();
                }
            }
            ClockDriver::Virtual(pacer) => drop(pacer),
        }
        self.robot.pump();
        self.pump.stop();
        let Some(recorder) = self.recorder else {
            return true;
        };
        match recorder.finish() {
            Ok(totals) => {
                tracing::debug!(?totals, "recording finished");
                true
            }
            // Said when it happened; the recording is cut short, the program's result stands.
            Err(_) => false,
        }
    }
}
