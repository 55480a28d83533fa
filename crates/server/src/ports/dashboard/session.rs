//! One client of the dashboard, over any duplex stream: a line in, a reply out.

use std::io;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};

use super::codec::{
    Command, GREETING, LINE_BYTES_MAX, encode, help, mistake, needs_remote_control, parse, percent,
    robot_mode_word, status,
};
use super::{Dashboard, Order};
use crate::ports::ClientId;
use crate::ports::description::{CONTROLLER_VERSION, TaskStatus};
use crate::ports::lines::{Line, LineFramer};
use motion_api::RobotMode;

/// What is read at once.
const READ_BYTES: usize = 4096;

/// Serves one client until it leaves or says so.
///
/// # Errors
/// The connection broke.
pub async fn serve(
    mut stream: impl AsyncRead + AsyncWrite + Unpin,
    client: ClientId,
    dashboard: &impl Dashboard,
) -> io::Result<()> {
    stream.write_all(&encode(GREETING)).await?;
    let mut framer = LineFramer::new(LINE_BYTES_MAX);
    let mut lines = Vec::new();
    let mut buffer = vec![0; READ_BYTES];
    loop {
        let count = stream.read(&mut buffer).await?;
        if count == 0 {
            return Ok(());
        }
        framer.push(&buffer[..count], &mut lines);
        for line in lines.drain(..) {
            let (reply, closes) = match line {
                Line::Text(text) => answer(&text, client, dashboard).await,
                Line::TooLong => (
                    format!("The line is longer than {} KiB.", LINE_BYTES_MAX / 1024),
                    false,
                ),
            };
            stream.write_all(&encode(&reply)).await?;
            if closes {
                return stream.shutdown().await;
            }
        }
    }
}

/// The reply to a line, and whether the connection ends with it.
async fn answer(line: &str, client: ClientId, dashboard: &impl Dashboard) -> (String, bool) {
    let command = match parse(line) {
        Ok(command) => command,
        Err(found) => return (mistake(line, &found), false),
    };
    if let Some(word) = command.word_needing_remote_control()
        && !dashboard.remote_control()
    {
        return (needs_remote_control(word), false);
    }
    tracing::debug!(%client, ?command, "dashboard");
    let closes = matches!(command, Command::Quit | Command::Reboot | Command::Shutdown);
    let reply = match question(&command, dashboard) {
        Some(reply) => reply,
        None => carry_out(command, dashboard).await,
    };
    (reply, closes)
}

/// The reply to a command that changes nothing.
fn question(command: &Command, dashboard: &impl Dashboard) -> Option<String> {
    let state = || dashboard.state();
    let task = || dashboard.task_status();
    Some(match command {
        Command::Echo => "Hello ELITE ROBOTS.".to_owned(),
        Command::SafetyMode => format!("Safety mode: {}", state().safety_mode.name()),
        Command::SafetyStatus => format!("Safety status: {}", state().safety_mode.name()),
        Command::RobotMode => format!("robotMode: {}", robot_mode_word(state().robot_mode)),
        Command::Status => {
            let state = state();
            status(
                state.robot_mode,
                state.safety_mode,
                task(),
                state.target_speed_fraction,
            )
        }
        Command::Speed => format!("speed: {}", percent(state().target_speed_fraction)),
        Command::Version => CONTROLLER_VERSION.map(|part| part.to_string()).join("."),
        Command::RobotType => dashboard.description().name.clone(),
        // A simulated arm has no plate to read these from.
        Command::SerialNumber => format!("SIM-{}", dashboard.description().robot_type),
        Command::RobotId => "1".to_owned(),
        Command::TaskPath => format!(
            "Relative path:{}",
            dashboard.loaded_task().unwrap_or_default()
        ),
        Command::TaskStatus => format!("Task is {}", task().name()),
        Command::TaskIsRunning => match task() {
            TaskStatus::Running => "Task is running".to_owned(),
            TaskStatus::Stopped | TaskStatus::Paused => "Task is not running".to_owned(),
        },
        // Tasks are files: what is loaded is what is on disk.
        Command::TaskIsSaved => "Task is saved".to_owned(),
        Command::ConfigurationPath => format!(
            "configuration: Relative path:{}",
            dashboard.loaded_configuration().unwrap_or_default()
        ),
        Command::ConfigurationIsModified => "configuration is not modified".to_owned(),
        Command::RemoteControl => dashboard.remote_control().to_string(),
        Command::Help(names) => help(names),
        Command::Quit => "Disconnected".to_owned(),
        _ => return None,
    })
}

/// Does what the command says and gives its reply.
async fn carry_out(command: Command, dashboard: &impl Dashboard) -> String {
    let (order, reply) = match command {
        Command::Power(true) => (Order::PowerOn, "Powering on".to_owned()),
        Command::Power(false) => (Order::PowerOff, "Powering off".to_owned()),
        Command::BrakeRelease if dashboard.state().robot_mode == RobotMode::Running => {
            return "Brake is released.".to_owned();
        }
        Command::BrakeRelease => (Order::ReleaseBrakes, "Brake Releasing".to_owned()),
        Command::CloseSafetyDialog => {
            (Order::CloseSafetyDialog, "closing safety dialog".to_owned())
        }
        Command::UnlockProtectiveStop => (
            Order::UnlockProtectiveStop,
            "Protective stop unlocking...".to_owned(),
        ),
        Command::RestartSafetyBoard => (
            Order::RestartSafetyBoard,
            "Restarting safety board".to_owned(),
        ),
        Command::ClearAlarms => (Order::UnlockProtectiveStop, "clear alarm".to_owned()),
        Command::SetSpeed(percent) => (
            Order::SetSpeed(f64::from(percent) / 100.0),
            format!("Setting speed: {percent}"),
        ),
        Command::Log(text) => (Order::Log(text), "Log has been added.".to_owned()),
        Command::ShowPopup(text) => {
            let reply = format!("Showing popup with text:{text}");
            (Order::ShowPopup(text), reply)
        }
        Command::ClosePopup => (Order::ClosePopup, "Closing popup".to_owned()),
        Command::SetRemoteControl(on) => {
            let reply = format!("Remote control is {}", if on { "on" } else { "off" });
            (Order::RemoteControl(on), reply)
        }
        // The SDK wants this also when nothing runs.
        Command::Stop => (Order::Stop, "Stopping task".to_owned()),
        Command::Pause if dashboard.task_status() != TaskStatus::Running => {
            return "Failed to execute: pause".to_owned();
        }
        Command::Pause => (Order::Pause, "Pausing task".to_owned()),
        Command::Reboot => (Order::Reboot, "Rebooting".to_owned()),
        Command::Shutdown => (Order::Shutdown, "Shutting down".to_owned()),
        other => return attempt(other, dashboard).await,
    };
    dashboard.order(order).await;
    reply
}

/// Does what may fail.
async fn attempt(command: Command, dashboard: &impl Dashboard) -> String {
    match command {
        Command::Play => {
            if dashboard.plays_loaded_task() {
                return "Failed to execute: play".to_owned();
            }
            match dashboard.play().await {
                Ok(()) => "Starting task".to_owned(),
                Err(reason) => format!("Failed to execute: play ({reason})"),
            }
        }
        Command::LoadTask(path) => match dashboard.load_task(&path).await {
            Ok(()) => format!("Loaded task: {path}"),
            Err(reason) => format!("Failed to load the task: {reason}"),
        },
        Command::LoadConfiguration(path) => match dashboard.load_configuration(&path).await {
            Ok(()) => format!("Loading Configuration : {path}"),
            Err(reason) => format!("Failed to load the configuration: {reason}"),
        },
        Command::GetVariable(name) => match dashboard.variable(&name).await {
            Ok(value) => value,
            Err(reason) => format!("Error: {reason}"),
        },
        Command::SetVariable(name, value) => match dashboard.set_variable(&name, &value).await {
            Ok(()) => format!("{name}, {value}"),
            Err(reason) => format!("Error: {reason}"),
        },
        // Every other command was answered above.
        other => format!("Failed to execute: {other:?}"),
    }
}

#[cfg(test)]
mod tests;
