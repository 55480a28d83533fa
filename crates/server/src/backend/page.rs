//! What the pendant page asks of the controller: its orders go the way of every other port's.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use controller::ControllerConfig;
use controller::cell_world::WorldOrder;
use controller::options::Permission;
use elite_runtime::message::Message;
use elite_runtime::panel::PopupId;
use elite_runtime::task_folder::TaskFolder;
use elite_runtime::{CompilePool, ProgramText, TaskState};
use kinematics::{JointPositions, Pose, RpyPose};
use messages::{Localized, Text, text};
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionMode, OnlineCommand, Origin, Outcome,
    SensingCommand, SettingCommand,
};
use pendant::jog::JogFrame;
use pendant::{PageOrder, SceneMeshes};
use recorder::Recording;
use serde_json::{Value, json};
use tokio::sync::broadcast;

use super::{LOOK_AGAIN, PortBackend};
use crate::ports::dashboard::DashboardBackend as _;
use crate::ports::http::page::{PageBackend, ShownProgram};
use crate::ports::http::{HttpBackend as _, SetInputsError, io};

/// Who wants a program to run, in messages.
const SENDER: &str = "the pendant page";

/// The answer to an order waits so long for what the arm says to it. What takes longer has begun.
const ANSWERED_WITHIN: Duration = Duration::from_millis(300);

/// Links may overlap so much, m: their shapes are rounder than they are.
const OVERLAP_MAX: f64 = 0.015;

impl PageBackend for PortBackend {
    fn read_only(&self) -> Option<Text> {
        None
    }

    fn debuggers(&self) -> Option<&Arc<editor::dap::DebugHub>> {
        Some(&self.debuggers)
    }

    fn scene(&self) -> Value {
        let mut scene = self.scene.description.clone();
        let description = &self.description;
        let limits = |end: fn(&(f64, f64)) -> f64| -> Value {
            description.position_limits.iter().map(end).collect()
        };
        scene["position_min"] = limits(|range| range.0);
        scene["position_max"] = limits(|range| range.1);
        scene["speed_max"] = json!(description.speed_limits);
        scene["home"] = json!(self.home);
        scene
    }

    fn meshes(&self) -> &SceneMeshes {
        &self.scene.meshes
    }

    fn about(&self) -> Value {
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "robot": self.description.name,
            "step_time": self.robot.state().step_time,
            "remote_control": *self.control.borrow() == io_bus::ControlMode::Remote,
            "recording": self.recording.is_some(),
        })
    }

    fn place(&self) -> (u32, u32) {
        let (line, node) = self.feed.place();
        (line, node.map_or(0, |node| node.number))
    }

    fn program_number(&self) -> u32 {
        self.supervisor.status().program.0
    }

    fn program(&self, number: u32) -> Option<ShownProgram> {
        self.feed.program(number)
    }

    fn subscribe_messages(
        &self,
    ) -> (
        broadcast::Receiver<controller::LogLine>,
        Option<broadcast::Receiver<Message>>,
    ) {
        let alarms = self.announcer.subscribe_alarms();
        (self.log_lines.subscribe(), Some(alarms))
    }

    fn world(&self) -> Option<Arc<str>> {
        let (world, watch) = self.world.as_ref()?;
        Some(watch.lock().look(world))
    }

    async fn order(&self, order: PageOrder) -> Result<Value, Text> {
        tracing::debug!(?order, "page");
        match order {
            PageOrder::PowerOn => self.request_outcome(MachineCommand::PowerOn).await,
            PageOrder::PowerOff => {
                self.supervisor.stop();
                self.request_outcome(MachineCommand::PowerOff).await
            }
            PageOrder::BrakeRelease => self.request_outcome(MachineCommand::ReleaseBrakes).await,
            PageOrder::Unlock => {
                self.request_outcome(MachineCommand::UnlockProtectiveStop)
                    .await
            }
            PageOrder::RestartSafety => {
                self.request_outcome(MachineCommand::RestartSafetyBoard)
                    .await
            }
            PageOrder::EmergencyStop { pressed } => {
                self.request_outcome(MachineCommand::EmergencyStop { pressed })
                    .await
            }
            PageOrder::Speed { fraction } => {
                self.request_outcome(SettingCommand::SetSpeedFraction(fraction))
                    .await
            }
            PageOrder::Push {
                wrench,
                duration,
                frame,
            } => {
                let push = CommandKind::Sensing(SensingCommand::Push {
                    wrench,
                    in_tool_axes: frame == JogFrame::Tool,
                    duration,
                    replaces: true,
                });
                self.request_outcome(push).await
            }
            PageOrder::Play => self.play().await.map(|()| Value::Null),
            PageOrder::Pause => {
                self.supervisor.pause();
                Ok(Value::Null)
            }
            PageOrder::Stop => {
                self.stop_everything();
                Ok(Value::Null)
            }
            PageOrder::Step => {
                if self.supervisor.status().state != TaskState::Paused {
                    return Err(text!(
                        "no program is held; pause it first",
                        "没有停住的程序；请先暂停"
                    ));
                }
                self.hold_at_next_line();
                self.supervisor.resume();
                Ok(Value::Null)
            }
            PageOrder::Run { name, text, step } => self.run(ProgramText { name, text }, step).await,
            PageOrder::RunTask { name } => {
                let task = self.task_folder.task(&name);
                let task = task.map_err(|error| Text::of(&error))?;
                let (name, text) = (task.name, task.text);
                self.run(ProgramText { name, text }, false).await
            }
            PageOrder::ClosePopup { popup, stop } => {
                if stop {
                    // First, so that the program does not go on behind the popup.
                    self.supervisor.stop();
                }
                let is_closed = self.supervisor.panel().close_popup(PopupId(popup));
                match is_closed || stop {
                    true => Ok(Value::Null),
                    false => Err(text!("popup {popup} is not open", "弹窗 {popup} 没有打开")),
                }
            }
            PageOrder::Inputs { values } => {
                self.set_points(io::inputs(&values, &self.robot.state().io_config))
            }
            PageOrder::PlacePart { part, pose } => self.place_part(&part, pose),
            PageOrder::Outputs { values } => {
                self.set_points(io::outputs(&values, &self.robot.state().io_config))
            }
            PageOrder::Jog { .. }
            | PageOrder::MoveTo { .. }
            | PageOrder::Freedrive
            | PageOrder::Release => Err(text!(
                "what is held is held by a page",
                "按住的动作由页面保持"
            )),
        }
    }

    fn sentence(&self, about: &impl Localized) -> Text {
        self.robot.sentence(about)
    }

    fn begin_hold(&self, command: CommandKind) -> Result<CommandId, Text> {
        let asked = self.robot.request(Origin::default(), command);
        asked.map_err(|full| {
            text!(
                "{} was not begun: {full}",
                "没有开始 {}：{full}",
                command.name()
            )
        })
    }

    fn end_hold(&self, command: CommandKind) {
        self.supervisor.command(command);
    }

    fn outcome(&self, id: CommandId) -> Option<Outcome> {
        self.robot.take_outcome(id)
    }

    fn forget(&self, id: CommandId) {
        self.robot.forget(id);
    }

    fn reach(&self, pose: [f64; 6]) -> Result<[f64; 6], Text> {
        if pose.iter().any(|x| !x.is_finite()) {
            return Err(text!(
                "a pose has six finite numbers",
                "位姿需要六个有限的数"
            ));
        }
        let state = self.robot.state();
        let base_from_tcp = Pose::from_rpy(&RpyPose::from_array(pose));
        let flange_from_tcp = Pose::from_rpy(&state.tcp_offset);
        let model = self.robot.model();
        let found = model.inverse_nearest(&base_from_tcp, &flange_from_tcp, &state.target_q);
        found
            .map(|joints| joints.0)
            .ok_or_else(|| text!("the pose is out of reach", "位姿不可达"))
    }

    fn check_joint_target(&self, joints: [f64; 6]) -> Result<[f64; 6], Text> {
        let limits = self.description.position_limits.iter().enumerate();
        for ((joint, (min, max)), q) in limits.zip(joints) {
            if !(*min..=*max).contains(&q) {
                return Err(text!(
                    "joint {} would stand at {q:.4} rad, allowed is {min:.4} to {max:.4} rad",
                    "关节 {} 将位于 {q:.4} rad，允许 {min:.4} 到 {max:.4} rad",
                    joint + 1
                ));
            }
        }
        let model = self.robot.model();
        let frames = model.forward(&JointPositions(joints));
        match model.collision().self_distance(&frames) {
            Some(near) if near.distance < -OVERLAP_MAX => Err(text!(
                "{} and {} of the arm would touch",
                "机械臂的{}和{}会相碰",
                kinematics::collision::link_name(near.links.0),
                kinematics::collision::link_name(near.links.1)
            )),
            _ => Ok(joints),
        }
    }

    fn tasks(&self) -> Option<(&TaskFolder, &Path)> {
        Some((&self.task_folder, &self.task_dir))
    }

    fn recording(&self) -> Result<Recording, Text> {
        let Some(path) = &self.recording_path else {
            return Err(text!(
                "this server records nothing, so there is nothing to look through",
                "此服务器没有记录，没有内容可查"
            ));
        };
        Recording::open(path).map_err(|error| Text::of(&error))
    }

    fn rehearsal(&self) -> Result<ControllerConfig, Text> {
        let state = self.robot.state();
        Ok(ControllerConfig {
            home: state.target_q,
            tcp: state.tcp_offset,
            payload: state.payload,
            allow: BTreeSet::from([Permission::NetPlayed]),
            ..self.settings.clone()
        })
    }

    fn compile_pool(&self) -> &CompilePool {
        self.supervisor.compile_pool()
    }
}

impl PortBackend {
    /// Puts a part somewhere, at rest, while no program could be surprised by it.
    fn place_part(&self, part: &str, pose: [f64; 6]) -> Result<Value, Text> {
        let Some((world, _)) = &self.world else {
            return Err(text!("the cell has no parts", "单元中没有工件"));
        };
        if self.supervisor.status().state != TaskState::Stopped {
            let text = text!(
                "a program runs; stop it before a part is placed by hand",
                "程序正在运行；请先停止程序，再手动放置工件"
            );
            return Err(text);
        }
        let order = WorldOrder::Place {
            name: part.to_owned(),
            pose,
        };
        world.order(order).map_err(|error| Text::of(&error))?;
        tracing::info!(part, "page: a part was placed by hand");
        Ok(Value::Null)
    }

    /// Sets inputs or outputs that were read from an order.
    fn set_points(&self, changes: Result<io::IoChanges, io::InputError>) -> Result<Value, Text> {
        let changes = changes.map_err(|error| Text::of(&error))?;
        match self.set_inputs(&changes) {
            Ok(()) => Ok(Value::Null),
            Err(SetInputsError::ReadOnly(reason) | SetInputsError::Unavailable(reason)) => {
                Err(reason)
            }
        }
    }

    /// Asks the arm for something and says how that went, as far as it is known soon.
    async fn request_outcome(&self, command: impl Into<CommandKind>) -> Result<Value, Text> {
        let id = self.begin_hold(command.into())?;
        let patience = tokio::time::Instant::now() + ANSWERED_WITHIN;
        loop {
            match self.robot.take_outcome(id) {
                Some(Outcome::Refused(refusal)) => return Err(self.robot.sentence(&refusal)),
                Some(_) => return Ok(Value::Null),
                None if tokio::time::Instant::now() >= patience => {
                    self.robot.forget(id);
                    return Ok(json!("begun"));
                }
                None => tokio::time::sleep(LOOK_AGAIN).await,
            }
        }
    }

    async fn run(&self, program: ProgramText, steps: bool) -> Result<Value, Text> {
        if steps {
            self.hold_at_next_line();
        }
        let started = self.supervisor.submit(program, SENDER).await;
        let id = started.map_err(|error| Text::of(&error))?;
        Ok(json!({"program": id.0}))
    }

    fn hold_at_next_line(&self) {
        let supervisor = self.supervisor.clone();
        self.feed.at_next_line(Box::new(move || supervisor.pause()));
    }

    fn stop_everything(&self) {
        self.supervisor.stop();
        if self.robot.state().motion_mode == MotionMode::Freedrive {
            self.supervisor
                .command(CommandKind::Online(OnlineCommand::EndFreedrive));
        }
        let only = CommandId::NONE;
        self.supervisor
            .command(CommandKind::Machine(MachineCommand::Stop { only }));
    }
}
