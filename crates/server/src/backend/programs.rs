//! What port 30001 asks of the controller: programs, orders, states; and what the sender of a program is told.

use std::sync::Arc;

use elite_runtime::{ProgramText, TaskState};
use elite_syntax::SourceFile;
use io_bus::ControlMode;
use messages::Text;
use motion_api::{CycleFrame, MachineCommand, ProgramId, SettingCommand};
use tokio::sync::watch;

use super::{PortBackend, unix_millis};
use crate::ports::ClientId;
use crate::ports::description::{RobotDescription, ToolSerial};
use crate::ports::primary::framing::{ControlPhrase, ProgramKind, ReceivedProgram};
use crate::ports::primary::{self, Submission};
use crate::ports::sample::Sample;
use crate::sent_file::SentFile;
use wire::primary::{Exception, ExceptionSource};

/// Name of programs that are one line outside a block.
const LINE_NAME: &str = "line";

/// Senders of so many programs are remembered.
const SENDERS_KEPT: usize = 8;

impl primary::PrimaryBackend for PortBackend {
    fn beats(&self) -> watch::Receiver<Option<Arc<Sample>>> {
        self.feed.beats().subscribe()
    }

    fn sample(&self) -> Sample {
        self.feed.sample(&CycleFrame {
            state: self.robot.state(),
            registers: self.robot.registers().images(),
        })
    }

    fn description(&self) -> &RobotDescription {
        &self.description
    }

    fn tool_serial(&self) -> Option<ToolSerial> {
        let settings = self.fieldbus.tool_serial.settings()?;
        Some(ToolSerial {
            baud_rate: settings.baud_rate,
            parity: settings.parity.into(),
            stop_bits: settings.stop_bits.into(),
            modbus_rtu: settings.modbus_rtu,
            for_daemon: settings.is_daemon_owned,
        })
    }

    async fn closed_to_clients(&self) {
        let mut control = self.control.subscribe();
        // The sender lives as long as this.
        let _ = control.wait_for(|mode| *mode == ControlMode::Local).await;
    }

    fn unix_millis(&self) -> u64 {
        unix_millis()
    }

    async fn is_whole_program(&self, text: String) -> bool {
        self.compiles(text).await
    }

    async fn submit(&self, submission: Submission) {
        let kind = submission.program.kind;
        let (program, presets) = match SentFile::behind(&submission.program.text) {
            Some(file) => file,
            None => {
                let name = name_of(&submission.program);
                let text = submission.program.text;
                (ProgramText { name, text }, Vec::new())
            }
        };
        if !self.takes_programs() {
            self.refuse(format!(
                "RuntimeError: program \"{}\" was refused: remote control is off",
                program.name
            ));
            return;
        }
        if kind == ProgramKind::Line
            && self.supervisor.status().state != TaskState::Stopped
            && let Some(name) = self.undefined_name(&program.text).await
        {
            self.refuse(format!(
                "NameError: {name}, so the line was not run, and the program that runs goes on. A def block that is \
                 sent runs by itself: a line behind it would take its place"
            ));
            return;
        }
        // A refusal has been told to everybody by the supervisor.
        let sender = submission.sender;
        let (called, presets) = (sender.to_string(), presets.into());
        let submitted = self.supervisor.submit_with(program, &called, presets).await;
        if let Ok(id) = submitted {
            let mut sent = self.sent.lock();
            sent.truncate(SENDERS_KEPT - 1);
            sent.insert(0, (id, sender));
        }
    }

    fn preempt(&self, phrase: ControlPhrase) {
        if !self.takes_programs() && phrase != ControlPhrase::PowerOff {
            return;
        }
        match phrase {
            ControlPhrase::StopTask | ControlPhrase::PowerOff => self.supervisor.stop(),
            ControlPhrase::PauseTask => self.supervisor.pause(),
            _ => {}
        }
    }

    async fn control(&self, client: ClientId, phrase: ControlPhrase) {
        tracing::info!(%client, ?phrase, "control phrase");
        let task_only = matches!(
            phrase,
            ControlPhrase::StopTask | ControlPhrase::PauseTask | ControlPhrase::ResumeTask
        );
        // Local control mode refuses these phrases here and on the dashboard alike.
        if task_only && !self.takes_programs() {
            let phrase = match phrase {
                ControlPhrase::StopTask => "stop task",
                ControlPhrase::PauseTask => "pause task",
                _ => "resume task",
            };
            self.refuse(format!(
                "RuntimeError: \"{phrase}\" was refused: remote control is off"
            ));
            return;
        }
        match phrase {
            ControlPhrase::StopTask => self.supervisor.stop(),
            ControlPhrase::PauseTask => self.supervisor.pause(),
            ControlPhrase::ResumeTask => self.supervisor.resume(),
            ControlPhrase::ClosePopup => {
                if self.supervisor.panel().close_newest_popup().is_none() {
                    tracing::info!(%client, "close popup: none is open");
                }
            }
            ControlPhrase::PowerOn => self.send_when_room(MachineCommand::PowerOn).await,
            ControlPhrase::PowerOff => {
                self.supervisor.stop();
                self.send_when_room(MachineCommand::PowerOff).await;
            }
            ControlPhrase::ReleaseBrakes => self.release_brakes().await,
            ControlPhrase::UnlockProtectiveStop => {
                self.send_when_room(MachineCommand::UnlockProtectiveStop)
                    .await
            }
            ControlPhrase::RestartSafetyBoard => {
                self.send_when_room(MachineCommand::RestartSafetyBoard)
                    .await
            }
            ControlPhrase::SetSpeed(fraction) => {
                self.send_when_room(SettingCommand::SetSpeedFraction(fraction))
                    .await;
            }
        }
    }
}

impl PortBackend {
    /// What is said of the first name in the text that nothing has: the line would fail when it has taken the place of
    /// what runs.
    async fn undefined_name(&self, text: &str) -> Option<Text> {
        let (known, text) = (self.known.clone(), text.to_owned());
        let pool = self.supervisor.compile_pool();
        let checking = pool.run(text.len(), move || {
            let findings = elite_syntax::check(SourceFile::new(LINE_NAME, text), &known);
            let mut findings = findings.into_iter();
            findings.find(|finding| finding.code == "undefined-name")
        });
        Some(checking.await.ok()??.message)
    }

    /// Tells whoever sent a program that another took its place, unless that was its sender, too.
    pub(super) fn announce_replacement(&self, program: ProgramId, text: &str) {
        let sent = self.sent.lock();
        let Some((_, sender)) = sent.iter().find(|(id, _)| *id == program) else {
            return;
        };
        if text.contains(&format!(" from {sender} ")) {
            return;
        }
        let exception = Exception::Script {
            line: 1,
            column: 1,
            text: format!("RuntimeError: {text}"),
        };
        let (client, source) = (sender.client, ExceptionSource::Controller);
        self.hub
            .announce_to(client, unix_millis(), source, &exception);
    }
}

/// `first_light` of `def first_light():`.
fn name_of(program: &ReceivedProgram) -> String {
    let head = program.text.trim_start();
    let rest = match program.kind {
        ProgramKind::Main => head.strip_prefix("def"),
        ProgramKind::Secondary => head.strip_prefix("sec"),
        ProgramKind::Line => None,
    };
    // A name of the language, or none: it is shown in messages, the log and the recording.
    let is_name = |name: &str| name.chars().all(|c| c == '_' || c.is_alphanumeric());
    rest.and_then(|rest| rest.split('(').next())
        .map(str::trim)
        .filter(|name| !name.is_empty() && name.len() <= 100 && is_name(name))
        .unwrap_or(LINE_NAME)
        .to_owned()
}
