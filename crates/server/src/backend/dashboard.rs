//! What the dashboard asks of the controller: power, tasks from the task folder, configurations, remote control.

use std::time::Duration;

use elite_runtime::message::{Message, Observer, Severity};
use elite_runtime::panel::Popup;
use elite_runtime::{ProgramText, TaskState};
use io_bus::ControlMode;
use kinematics::{Payload, RpyPose};
use messages::{Text, text};
use motion_api::{
    CommandKind, MachineCommand, Origin, ProgramId, RobotMode, RobotState, SettingCommand,
};
use serde::Deserialize;
use supervision::ThreadRole;
use tokio::time::timeout;

use super::{LOOK_AGAIN, PortBackend, shipped_tasks};
use crate::ports::dashboard::{DashboardBackend, DashboardOrder};
use crate::ports::description::{RobotDescription, TaskStatus};
use crate::ports::escape::{EscapedLine, EscapedText};

/// The configuration that is always there: the settings with which the server was started.
const DEFAULT_CONFIGURATION: &str = "default.configuration";

/// Who wants a program to run, in messages.
const SENDER: &str = "the dashboard";

/// A reply waits no longer than this for a cycle that takes its command.
const TAKEN_WITHIN: Duration = Duration::from_millis(100);

/// Lines of clients that are logged in a burst; after that, one is logged each [`LOG_INTERVAL`].
const LOG_BURST: u32 = 100;
/// Time between two logged lines of clients once [`LOG_BURST`] is used up.
const LOG_INTERVAL: Duration = Duration::from_millis(10);

/// When lines of clients are written (the generic cell rate algorithm).
#[derive(Debug, Default)]
pub(super) struct LogRateLimit {
    /// When everything so far would have been due at the steady rate.
    due: Option<tokio::time::Instant>,
}

impl LogRateLimit {
    /// Time when the next line may be written.
    fn next(&mut self, now: tokio::time::Instant) -> tokio::time::Instant {
        let due = self.due.map_or(now, |due| due.max(now));
        self.due = Some(due + LOG_INTERVAL);
        due.checked_sub(LOG_INTERVAL * LOG_BURST).unwrap_or(now)
    }
}

/// What was loaded by name.
#[derive(Debug, Default)]
pub(super) struct LoadedFiles {
    task: Option<String>,
    configuration: Option<String>,
}

/// A configuration file: TOML, our own; the vendor's format is not known. What is missing stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Configuration {
    /// TCP relative to the flange: m, rad.
    pub(super) tcp: Option<[f64; 6]>,
    /// Mass in kg and centre of gravity in m.
    pub(super) payload: Option<[f64; 4]>,
    /// The speed slider, 0 to 1.
    pub(super) speed: Option<f64>,
}

impl DashboardBackend for PortBackend {
    fn state(&self) -> RobotState {
        self.robot.state()
    }

    fn task_status(&self) -> TaskStatus {
        self.feed.task_status()
    }

    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn control(&self) -> ControlMode {
        *self.control.borrow()
    }

    fn loaded_task(&self) -> Option<String> {
        self.loaded.lock().task.clone()
    }

    fn loaded_configuration(&self) -> Option<String> {
        self.loaded.lock().configuration.clone()
    }

    async fn order(&self, order: DashboardOrder) {
        match order {
            DashboardOrder::PowerOn => self.send_and_wait_taken(MachineCommand::PowerOn).await,
            DashboardOrder::PowerOff => {
                self.supervisor.stop();
                self.send_and_wait_taken(MachineCommand::PowerOff).await;
            }
            DashboardOrder::ReleaseBrakes => self.release_brakes().await,
            DashboardOrder::UnlockProtectiveStop => {
                self.send_and_wait_taken(MachineCommand::UnlockProtectiveStop)
                    .await
            }
            DashboardOrder::RestartSafetyBoard => {
                self.send_and_wait_taken(MachineCommand::RestartSafetyBoard)
                    .await
            }
            DashboardOrder::SetSpeed(fraction) => {
                self.send_and_wait_taken(SettingCommand::SetSpeedFraction(fraction))
                    .await
            }
            DashboardOrder::Control(mode) => self.set_control(mode),
            DashboardOrder::Log(text) => {
                // No line is lost: whoever writes faster than that waits for its reply.
                let due = self.log_pace.lock().next(tokio::time::Instant::now());
                tokio::time::sleep_until(due).await;
                let text = Text::verbatim(EscapedText(&text).to_string());
                let message = Message::log(Severity::Info, Origin::default(), text);
                self.announcer.message(&message);
            }
            DashboardOrder::ShowPopup(text) => {
                tracing::info!("popup: {}", EscapedLine(&text));
                self.supervisor.panel().open_popup(Popup {
                    title: "Popup".to_owned(),
                    text,
                    ..Popup::default()
                });
            }
            // A popup that a program waits for is closed as well: that is how it is answered.
            DashboardOrder::ClosePopup => drop(self.supervisor.panel().close_newest_popup()),
            // No dialog is ever open: what it would say is in the log and on port 30001.
            DashboardOrder::CloseSafetyDialog => {}
            DashboardOrder::Pause => self.supervisor.pause(),
            DashboardOrder::Stop => self.supervisor.stop(),
            DashboardOrder::Reboot => self.lifetime.reboot(),
            DashboardOrder::Shutdown => self.lifetime.shut_down(),
        }
    }

    async fn load_task(&self, path: &str) -> Result<(), String> {
        let (task, is_shipped) =
            shipped_tasks::task(&self.task_folder, path).map_err(|e| e.to_string())?;
        let shipped = is_shipped.then_some(&*task.text);
        self.variables.lock().load(&self.task_folder, path, shipped);
        self.loaded.lock().task = Some(path.to_owned());
        Ok(())
    }

    async fn load_configuration(&self, path: &str) -> Result<(), String> {
        let configuration = match self.task_folder.file(path) {
            Ok(text) => parse_configuration(path, &text)?,
            Err(_) if path == DEFAULT_CONFIGURATION => self.start_configuration,
            Err(error) => return Err(error.to_string()),
        };
        if let Some(tcp) = configuration.tcp {
            let tcp = RpyPose::from_array(tcp);
            self.send_and_wait_taken(SettingCommand::SetTcp(tcp)).await;
        }
        if let Some([mass, cog @ ..]) = configuration.payload {
            let payload = Payload {
                mass,
                cog: cog.into(),
                ..Payload::default()
            };
            self.send_and_wait_taken(SettingCommand::SetPayload(payload))
                .await;
        }
        if let Some(fraction) = configuration.speed {
            self.send_and_wait_taken(SettingCommand::SetSpeedFraction(fraction))
                .await;
        }
        self.loaded.lock().configuration = Some(path.to_owned());
        Ok(())
    }

    fn plays_loaded_task(&self) -> bool {
        let status = self.supervisor.status();
        let loaded = self.loaded_task();
        let played = self.last_played.lock();
        let is_it = |(id, name): &(ProgramId, String)| {
            *id == status.program && Some(name) == loaded.as_ref()
        };
        status.state == TaskState::Running && played.as_ref().is_some_and(is_it)
    }

    async fn play(&self) -> Result<(), Text> {
        if self.supervisor.status().state == TaskState::Paused {
            self.supervisor.resume();
            return Ok(());
        }
        let Some(name) = self.loaded_task() else {
            return Err(text!("no task is loaded", "没有载入任务"));
        };
        let (task, _) =
            shipped_tasks::task(&self.task_folder, &name).map_err(|error| Text::of(&error))?;
        self.take_variables();
        let beginning = self.variables.lock().beginning(task.text);
        let program = ProgramText {
            name: task.name,
            text: beginning.text,
        };
        let presets = beginning.presets.into();
        let started = self.supervisor.submit_with(program, SENDER, presets).await;
        let id = started.map_err(|error| Text::of(&error))?;
        self.variables.lock().runs(id);
        // The program may be over already.
        self.take_variables();
        *self.last_played.lock() = Some((id, name));
        Ok(())
    }

    /// While a program runs the values are its own; else those that the next one begins with.
    async fn variable(&self, name: &str) -> Result<String, String> {
        self.take_variables();
        let of_program = || {
            let variables = self.supervisor.panel().variables();
            let found = variables.into_iter().find(|(known, _)| known == name);
            found.map(|(_, variable)| variable.value)
        };
        let kept = || self.variables.lock().value(name);
        let found = match self.supervisor.status().state {
            TaskState::Stopped => kept().or_else(of_program),
            TaskState::Running | TaskState::Paused => of_program().or_else(kept),
        };
        found.ok_or_else(|| format!("variable {name} is undefined"))
    }

    async fn set_variable(&self, name: &str, value: &str) -> Result<(), String> {
        if self.supervisor.status().state != TaskState::Stopped {
            return Err(format!(
                "variable {name} cannot be set while a program runs: stop it first, or send a sec program to port 30001"
            ));
        }
        self.take_variables();
        let variables = self.supervisor.panel().variables();
        let was_seen = variables.iter().any(|(known, _)| known == name);
        self.variables
            .lock()
            .set(&self.task_folder, name, value, was_seen)
    }
}

impl PortBackend {
    /// Takes the last values of the task's variables once its program has ended.
    pub(crate) fn take_variables(&self) {
        let Some(program) = self.variables.lock().running() else {
            return;
        };
        let status = self.supervisor.status();
        if status.program != program || status.state == TaskState::Stopped {
            let last = self.announcer.values_of(program);
            self.variables.lock().take(&self.task_folder, &last);
        }
    }
}

/// Longest wait for power before the brakes are released.
const POWERED_WITHIN: Duration = Duration::from_secs(30);
/// Longest wait until the controller reports that power is being switched on; power itself takes up to
/// [`POWERED_WITHIN`].
const SWITCHED_ON_WITHIN: Duration = Duration::from_secs(1);

impl PortBackend {
    /// Releases the brakes; without power, as soon as the power that is switched on then has come. Clients watch the
    /// mode.
    pub(super) async fn release_brakes(&self) {
        if self.robot.state().robot_mode != RobotMode::PowerOff {
            return self
                .send_and_wait_taken(MachineCommand::ReleaseBrakes)
                .await;
        }
        self.send_and_wait_taken(MachineCommand::PowerOn).await;
        let (robot, ends) = (self.robot.clone(), self.lifetime.token().clone());
        self.faults
            .spawn(ThreadRole::Service, "brakes", async move {
                let powered = async {
                    let begun = tokio::time::Instant::now();
                    loop {
                        match robot.state().robot_mode {
                            RobotMode::Idle => break true,
                            // Switched off again, or never on; or released by somebody else.
                            RobotMode::PowerOff if begun.elapsed() > SWITCHED_ON_WITHIN => {
                                break false;
                            }
                            RobotMode::Running => break false,
                            _ => tokio::time::sleep(LOOK_AGAIN).await,
                        }
                    }
                };
                let powered = ends.run_until_cancelled(timeout(POWERED_WITHIN, powered));
                if let Some(Ok(true)) = powered.await
                    && let Err(full) = robot.send(Origin::default(), MachineCommand::ReleaseBrakes)
                {
                    tracing::warn!("the brakes were not released: {full}");
                }
            });
    }

    /// Gives the robot a command and returns when a cycle has taken it, so that what a client asks next, in the next
    /// line or on another port, is already answered by a state with it.
    pub(super) async fn send_and_wait_taken(&self, command: impl Into<CommandKind>) {
        let before = self.robot.state().cycle;
        self.send_when_room(command).await;
        let patience = tokio::time::Instant::now() + TAKEN_WITHIN;
        // The cycle that runs now may have looked at its commands already.
        while self.robot.state().cycle < before + 2 && tokio::time::Instant::now() < patience {
            tokio::time::sleep(LOOK_AGAIN).await;
        }
    }
}

fn parse_configuration(name: &str, text: &str) -> Result<Configuration, String> {
    let wrong = |what: String| format!("{name}: {what}");
    let configuration: Configuration =
        toml::from_str(text).map_err(|e| wrong(e.message().replace('\n', ", ")))?;
    let numbers = [
        configuration.tcp.unwrap_or_default().as_slice(),
        configuration.payload.unwrap_or_default().as_slice(),
    ]
    .concat();
    if let Some(number) = numbers.iter().find(|x| !x.is_finite()) {
        return Err(wrong(format!("{number} is not a finite number")));
    }
    if let Some(speed) = configuration.speed
        && !(0.0..=1.0).contains(&speed)
    {
        return Err(wrong(format!("speed is {speed}, allowed is 0 to 1")));
    }
    Ok(configuration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_clients_come_in_a_burst_and_then_at_a_steady_rate() {
        let now = tokio::time::Instant::now();
        let mut pace = LogRateLimit::default();
        let dues: Vec<_> = (0..300).map(|_| pace.next(now)).collect();
        assert!(dues[..=LOG_BURST as usize].iter().all(|due| *due <= now));
        assert_eq!(dues[299], now + LOG_INTERVAL * 199);
    }

    #[test]
    fn a_configuration_sets_what_it_names_and_says_what_is_wrong() {
        let text = "tcp = [0, 0, 0.1, 0, 0, 0]\nspeed = 0.5";
        let read = parse_configuration("a", text).unwrap();
        assert_eq!(read.tcp, Some([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]));
        assert_eq!(read.payload, None);
        for (text, part) in [
            ("speed = 2", "allowed is 0 to 1"),
            ("payload = [1]", "length"),
            ("tcp = [0, 0, nan, 0, 0, 0]", "finite"),
            ("gravity = 1", "unknown field"),
            ("speed =", ""),
        ] {
            let error = parse_configuration("a.configuration", text).unwrap_err();
            assert!(error.starts_with("a.configuration: "), "{error}");
            assert!(error.contains(part) && !error.contains('\n'), "{error}");
        }
    }
}
