//! Port 29999, the dashboard: one-line commands, one reply each.
//!
//! Owns words, replies and clients. Tasks, power and variables are behind [`DashboardBackend`].

pub mod codec;
pub mod session;

use std::sync::Arc;

use io_bus::ControlMode;
use messages::Text;
use motion_api::RobotState;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::ports::description::{RobotDescription, TaskStatus};
use crate::ports::listen::{PortMeter, serve_sessions};

/// Something to be done that has no answer of its own; clients watch the modes.
#[derive(Clone, Debug, PartialEq)]
pub enum DashboardOrder {
    /// Arm power on: power off → idle.
    PowerOn,
    /// Arm power off.
    PowerOff,
    /// Idle → running; from power off, by way of power on.
    ReleaseBrakes,
    /// Leave a protective stop.
    UnlockProtectiveStop,
    /// Clear a safety fault.
    RestartSafetyBoard,
    /// The speed slider, 0 to 1.
    SetSpeed(f64),
    /// Control for somebody.
    Control(ControlMode),
    /// A line for the log.
    Log(String),
    /// Show a popup.
    ShowPopup(String),
    /// Close the popup that is shown, if one is.
    ClosePopup,
    /// Close the safety dialog, if one is shown.
    CloseSafetyDialog,
    /// Pause the running task.
    Pause,
    /// Stop the task that runs or is paused, if one is.
    Stop,
    /// End the controller and start it again.
    Reboot,
    /// End the controller.
    Shutdown,
}

/// What this port asks of the controller. Errors are one sentence without a line break.
pub trait DashboardBackend: Send + Sync + 'static {
    /// The latest snapshot.
    fn state(&self) -> RobotState;
    /// What the main task is doing.
    fn task_status(&self) -> TaskStatus;
    /// The arm; the same values every time.
    fn description(&self) -> &RobotDescription;
    /// Who controls the robot.
    fn control(&self) -> ControlMode;
    /// The task that is loaded, as its name was given.
    fn loaded_task(&self) -> Option<String>;
    /// The configuration that is loaded, as its name was given.
    fn loaded_configuration(&self) -> Option<String>;
    /// Carries out an order; returns when it is on its way.
    fn order(&self, order: DashboardOrder) -> impl Future<Output = ()> + Send;
    /// Loads a task by its path in the task folder.
    fn load_task(&self, path: &str) -> impl Future<Output = Result<(), String>> + Send;
    /// Loads a configuration by its path in the task folder.
    fn load_configuration(&self, path: &str) -> impl Future<Output = Result<(), String>> + Send;
    /// True while the loaded task runs, started by [`play`](Self::play).
    fn plays_loaded_task(&self) -> bool;
    /// Starts the loaded task in the place of whatever runs, or lets a paused one go on.
    fn play(&self) -> impl Future<Output = Result<(), Text>> + Send;
    /// A global variable of the task, as a script would print it.
    fn variable(&self, name: &str) -> impl Future<Output = Result<String, String>> + Send;
    /// Sets a global variable of the task from the text of a value.
    fn set_variable(
        &self,
        name: &str,
        value: &str,
    ) -> impl Future<Output = Result<(), String>> + Send;
}

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve<D: DashboardBackend>(
    listener: TcpListener,
    dashboard: Arc<D>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    let session = |stream, client, dashboard: Arc<D>| async move {
        session::serve(stream, client, &*dashboard).await
    };
    serve_sessions(listener, meter, shutdown, dashboard, session).await;
}
