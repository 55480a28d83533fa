//! Commands out of the ring and what each of them sets off.
//!
//! Owns the rule when a command is taken: while there is room for all its consequences, and at most a fixed number in a
//! cycle. The costly part of a plan is not done here but once a cycle in `plan_on`.

use kinematics::{JointPositions, Payload, RpyPose};
pub(crate) use motion_api::form::bad_value;
use motion_api::{
    Command, CommandId, CommandKind, DigitalBank, IoChange, MachineCommand, MotionCommand,
    MotionMode, OnlineCommand, Outcome, OverlayCommand, Refusal, SensingCommand, SettingCommand,
    StopReason, phrase,
};

use crate::allowed::Admission;
use crate::constants::{COMMANDS_PER_CYCLE, MOTION_COMMAND_WEIGHT};
use crate::cycle::{ControlLoop, Generator};
use crate::load_model::LoadModel;
use crate::path::ArcOrientation;
use crate::plan::{CartesianPlanner, MotionRequest, PlanningContext, plan_movej};
use crate::stopping::StopCause;
use crate::tool::Tool;
use crate::upcoming::PlanState;
use crate::waiting::RestCommand;

/// Whether a command ends at once, and how.
pub(crate) type CommandResult = Result<Completion, Refusal>;

pub(crate) enum Completion {
    Immediate,
    Deferred,
}

impl ControlLoop {
    /// Takes commands from the ring.
    pub(crate) fn take_commands(&mut self) {
        let mut left = COMMANDS_PER_CYCLE;
        while left > 0 {
            let under_way = self.rest_commands.count()
                + self.zone_changes.count()
                + self.queue.unfinished_count()
                + usize::from(self.running_command() != CommandId::NONE)
                + usize::from(self.deferred.is_some());
            if self.rest_commands.is_full() || !self.out.has_room(under_way) {
                return;
            }
            let Some(command) = self.next_command() else {
                return;
            };
            let share = match command.kind.is_light() {
                true => 1,
                false => MOTION_COMMAND_WEIGHT,
            };
            left = left.saturating_sub(share);
            match self.admit(&command) {
                Ok(Completion::Immediate) => self.out.report_end(command.id, Outcome::Done),
                Ok(Completion::Deferred) => {}
                Err(refusal) => self.out.report_end(command.id, Outcome::Refused(refusal)),
            }
        }
    }

    fn admit(&mut self, command: &Command) -> CommandResult {
        command.kind.validate()?;
        match self.admission(command) {
            Admission::Refuse(why) => Err(self.refusal(why)),
            // What has to wait has waited.
            Admission::Accept | Admission::WaitForRest => self.dispatch(command),
        }
    }

    /// Each command by its family.
    fn dispatch(&mut self, command: &Command) -> CommandResult {
        match &command.kind {
            CommandKind::Motion(motion) => self.execute_move(command, motion),
            CommandKind::Online(online) => self.execute_online_command(command, online),
            CommandKind::Overlay(overlay) => self.execute_overlay_command(command, overlay),
            CommandKind::Machine(machine) => self.execute_machine_command(command.id, machine),
            CommandKind::Sensing(sensing) => self.execute_sensing_command(sensing),
            CommandKind::Setting(setting) => self.execute_setting(command.id, setting),
        }
    }

    /// Planned motions.
    fn execute_move(&mut self, command: &Command, motion: &MotionCommand) -> CommandResult {
        let wish = |speed, acceleration, duration, radius| MotionRequest {
            speed,
            acceleration,
            duration,
            radius,
            is_process_move: matches!(motion, MotionCommand::MoveP { .. }),
        };
        match *motion {
            MotionCommand::MoveJ {
                target,
                acceleration,
                speed,
                duration,
                radius,
            } => self.movej(
                command,
                &target,
                &wish(speed, acceleration, duration, radius),
            ),
            MotionCommand::MoveL {
                target,
                acceleration,
                speed,
                duration,
                radius,
            } => {
                let wish = wish(speed, acceleration, duration, radius);
                self.line(command, MotionMode::MoveL, &target, &wish)
            }
            MotionCommand::MoveP {
                target,
                acceleration,
                speed,
                radius,
            } => {
                let wish = wish(speed, acceleration, 0.0, radius);
                self.line(command, MotionMode::MoveP, &target, &wish)
            }
            MotionCommand::MoveC {
                via,
                target,
                acceleration,
                speed,
                radius,
                fixed,
            } => {
                let orientation = if fixed {
                    ArcOrientation::WithTheArc
                } else {
                    ArcOrientation::ToTheTarget
                };
                let wish = wish(speed, acceleration, 0.0, radius);
                self.arc(command, (&via, &target), orientation, &wish)
            }
            MotionCommand::MoveMl { count, interval } => self.moveml(command, count, interval),
        }
    }

    fn movej(
        &mut self,
        command: &Command,
        target: &JointPositions,
        wish: &MotionRequest,
    ) -> CommandResult {
        self.check_target(target)?;
        let start = self.next_start();
        let mut cells = core::mem::take(&mut self.pending_limits);
        let planned = plan_movej(&start, target, wish, &self.arm(), &mut cells);
        self.pending_limits = cells;
        let (leg, warnings) = planned?;
        let who = (command.id, command.origin);
        self.enqueue_motion(who, MotionMode::MoveJ, PlanState::Ready(leg, warnings));
        Ok(Completion::Deferred)
    }

    fn line(
        &mut self,
        command: &Command,
        mode: MotionMode,
        target: &RpyPose,
        wish: &MotionRequest,
    ) -> CommandResult {
        self.check_target_pose(target)?;
        let start = self.next_start();
        let planner = CartesianPlanner::line(&start, target, wish, &self.arm())?;
        self.begin_to_plan(command, mode, planner);
        Ok(Completion::Deferred)
    }

    fn arc(
        &mut self,
        command: &Command,
        (via, target): (&RpyPose, &RpyPose),
        orientation: ArcOrientation,
        wish: &MotionRequest,
    ) -> CommandResult {
        self.check_target_pose(via)?;
        self.check_target_pose(target)?;
        let start = self.next_start();
        let planner = CartesianPlanner::arc(&start, (via, target), orientation, wish, &self.arm())?;
        self.begin_to_plan(command, MotionMode::MoveC, planner);
        Ok(Completion::Deferred)
    }

    /// Online modes, leading by hand, and coming to rest from them.
    fn execute_online_command(
        &mut self,
        command: &Command,
        online: &OnlineCommand,
    ) -> CommandResult {
        match *online {
            OnlineCommand::ServoJ {
                target,
                duration,
                lookahead,
                gain,
            } => self.servoj(command, &target, duration, lookahead, gain),
            OnlineCommand::FollowPoints { count, interval } => {
                self.follow_points(command, count, interval)
            }
            OnlineCommand::SpeedJ {
                speeds,
                acceleration,
                duration,
            } => self.speedj(command, &speeds, acceleration, duration),
            OnlineCommand::SpeedL {
                speed,
                acceleration,
                rotation_acceleration,
                duration,
            } => self.speedl(
                command,
                speed,
                [acceleration, rotation_acceleration],
                duration,
            ),
            OnlineCommand::StopJ { acceleration } => self.stopj(command, acceleration),
            OnlineCommand::StopL { acceleration } => self.stopl(command, acceleration),
            OnlineCommand::Freedrive { free_axes, frame } => {
                self.freedrive(command, free_axes, frame)
            }
            OnlineCommand::EndFreedrive => Ok(self.end_freedrive(command.id)),
        }
    }

    /// What is laid over motions: force mode, belts, offsets of the path.
    fn execute_overlay_command(
        &mut self,
        command: &Command,
        overlay: &OverlayCommand,
    ) -> CommandResult {
        match *overlay {
            OverlayCommand::ForceMode {
                frame,
                selection,
                wrench,
                mode,
                speed_limits,
            } => self.force_mode(&frame, selection, wrench, mode, speed_limits),
            OverlayCommand::EndForceMode => Ok(self.end_force_mode(command.id)),
            OverlayCommand::TrackConveyorLinear {
                direction,
                ticks_per_meter,
                encoder,
            } => self.track_linear(direction, ticks_per_meter, encoder),
            OverlayCommand::TrackConveyorCircular {
                center,
                ticks_per_revolution,
                rotate_tool,
                encoder,
            } => self.track_circular(&center, ticks_per_revolution, rotate_tool, encoder),
            OverlayCommand::StopConveyorTracking => Ok(self.stop_tracking(command.id)),
            OverlayCommand::PathOffsetEnable => self.path_offset_enable(),
            OverlayCommand::PathOffsetDisable { acceleration } => {
                self.path_offset_disable(command, acceleration)
            }
            OverlayCommand::PathOffsetSet { offset, axes } => self.path_offset_set(&offset, axes),
            OverlayCommand::PathOffsetFilter(share) => self.path_offset_filter(share),
            OverlayCommand::PathOffsetMax {
                translation,
                rotation,
            } => self.path_offset_max(translation, rotation),
        }
    }

    /// Stops, power and brakes.
    fn execute_machine_command(
        &mut self,
        id: CommandId,
        machine: &MachineCommand,
    ) -> CommandResult {
        match *machine {
            MachineCommand::Stop { only } => Ok(self.stop(id, only)),
            MachineCommand::Pause => {
                self.is_paused = true;
                self.rest_commands.add(id, RestCommand::Pause);
                Ok(Completion::Deferred)
            }
            MachineCommand::Resume => {
                self.is_paused = false;
                while let Some(id) = self.rest_commands.take(|kind| kind == RestCommand::Pause) {
                    self.out.report_end(id, Outcome::Done);
                }
                Ok(Completion::Immediate)
            }
            MachineCommand::PowerOn => {
                self.machine.power_on()?;
                Ok(Completion::Immediate)
            }
            MachineCommand::PowerOff => {
                self.drop_zone_changes(CommandId::NONE, Outcome::Aborted);
                self.stop_for(StopCause::PowerOff);
                self.rest_commands.add(id, RestCommand::PowerOff);
                Ok(Completion::Deferred)
            }
            MachineCommand::ReleaseBrakes => {
                self.machine.release_brakes()?;
                Ok(Completion::Immediate)
            }
            MachineCommand::UnlockProtectiveStop => {
                if !self.is_at_rest() && self.machine.stop_reason().is_some() {
                    return Err(Refusal::StillMoving);
                }
                self.machine.unlock();
                Ok(Completion::Immediate)
            }
            MachineCommand::ProtectiveStop => {
                self.stop_on_request();
                Ok(Completion::Immediate)
            }
            MachineCommand::RestartSafetyBoard => {
                if !self.is_at_rest() {
                    return Err(Refusal::StillMoving);
                }
                self.machine.restart_safety();
                Ok(Completion::Immediate)
            }
            MachineCommand::EmergencyStop { pressed } => {
                self.begin_emergency_stop_if(|machine| machine.press_emergency_stop(pressed));
                Ok(Completion::Immediate)
            }
        }
    }

    /// The force sensor, force mode and collision detection.
    fn execute_sensing_command(&mut self, sensing: &SensingCommand) -> CommandResult {
        match *sensing {
            SensingCommand::SetForceGain(gain) => self.set_force_gain(gain),
            SensingCommand::SetForceDamping(damping) => self.set_force_damping(damping),
            SensingCommand::SetExternalWrench(wrench) => self.set_external_wrench(wrench),
            SensingCommand::Push {
                wrench,
                in_tool_axes,
                duration,
                replaces,
            } => self.push(wrench, in_tool_axes, duration, replaces),
            SensingCommand::FtRtsiInput {
                enabled,
                mass,
                measuring_offset,
                cog,
            } => self.ft_rtsi_input(enabled, mass, measuring_offset, cog),
            SensingCommand::ZeroFtSensor => {
                self.sensor.zero();
                Ok(Completion::Immediate)
            }
            SensingCommand::SetCollisionDetection(enabled) => {
                self.collision.is_enabled = enabled;
                Ok(Completion::Immediate)
            }
            SensingCommand::SetCollisionSensitivity(ratio) => {
                if !self.collision.set_sensitivity(ratio) {
                    return Err(bad_value(
                        phrase!("ratio"),
                        f64::from(ratio),
                        phrase!("10 to 100", "10 到 100"),
                    ));
                }
                Ok(Completion::Immediate)
            }
        }
    }

    /// Tool, payload, inputs and outputs, speed and encoders.
    fn execute_setting(&mut self, id: CommandId, setting: &SettingCommand) -> CommandResult {
        match *setting {
            SettingCommand::SetTcp(tcp) => {
                self.set_tcp(tcp);
                Ok(Completion::Immediate)
            }
            SettingCommand::SetPayload(payload) => {
                self.set_payload(payload);
                Ok(Completion::Immediate)
            }
            SettingCommand::SetStandardDigitalOut { index, level } => {
                if index >= 16 {
                    let value = f64::from(index);
                    return Err(bad_value(
                        phrase!("the index of the output", "输出的序号"),
                        value,
                        phrase!("0 to 15", "0 到 15"),
                    ));
                }
                let bank = DigitalBank::Standard;
                self.io.apply(&IoChange::digital_out(bank, index, level));
                Ok(Completion::Immediate)
            }
            SettingCommand::SetIo(change) => {
                self.set_io(&change);
                Ok(Completion::Immediate)
            }
            SettingCommand::SetIoAtZone { motion, change } => {
                self.set_io_at_zone(id, motion, change)
            }
            SettingCommand::SetGravity(gravity) => self.set_gravity(gravity),
            SettingCommand::SetDigitalInput { index, level } => self.set_input(index, level),
            SettingCommand::SetSpeedFraction(fraction) => {
                if !(0.0..=1.0).contains(&fraction) {
                    return Err(bad_value(
                        phrase!("the speed fraction", "速度比例"),
                        fraction,
                        phrase!("0 to 1", "0 到 1"),
                    ));
                }
                self.speed_fraction = fraction;
                Ok(Completion::Immediate)
            }
            SettingCommand::EncoderEnableSetTickCount { encoder, range } => {
                self.count_by_program(encoder, range)
            }
            SettingCommand::EncoderSetTickCount { encoder, count } => {
                self.set_tick_count(encoder, count)
            }
            SettingCommand::EncoderEnablePulseDecode {
                encoder,
                decoding,
                channel_a,
                channel_b,
            } => self.decode_pulses(encoder, decoding, channel_a, channel_b),
        }
    }

    fn begin_to_plan(&mut self, command: &Command, mode: MotionMode, planner: CartesianPlanner) {
        self.pending_limits.clear();
        let who = (command.id, command.origin);
        self.enqueue_motion(who, mode, PlanState::Cartesian(planner));
    }

    pub(crate) fn arm(&self) -> PlanningContext<'_> {
        PlanningContext {
            model: &self.model,
            flange_from_tcp: self.tool.flange_from_tcp(),
            limits: self.planning_limits(),
            dynamics: self.load.dynamics(),
            planes: (!self.has_no_planes()).then(|| (&self.safety, self.plane_switches())),
        }
    }

    fn stop(&mut self, id: CommandId, only: CommandId) -> Completion {
        let is_concerned =
            only == CommandId::NONE || only == self.running_command() || self.is_under_way(only);
        if !is_concerned {
            return Completion::Immediate;
        }
        self.is_paused = false;
        self.drop_zone_changes(only, Outcome::Aborted);
        self.stop_for(match only {
            CommandId::NONE => StopCause::Stop,
            _ => StopCause::StopOfOneMotion,
        });
        self.rest_commands.add(id, RestCommand::Stop);
        Completion::Deferred
    }

    /// What moves the TCP by its velocity goes on with the new one; paths keep the one that they were planned with.
    fn set_tcp(&mut self, tcp: RpyPose) {
        self.tool = Tool::new(tcp);
        self.slow_down_for_tool();
        if let Generator::Online(mut online) = self.generator {
            online.change_tcp(&self.online_arm(), &self.target);
            self.generator = Generator::Online(online);
        }
    }

    /// Changes inputs, outputs, registers, or how they are configured.
    pub(crate) fn set_io(&mut self, change: &IoChange) {
        self.io.apply(change);
        if let IoChange::ProgramRunning(_) = change {
            self.path_offset.stop();
            self.path_offset.reset_settings();
        }
    }

    fn set_payload(&mut self, payload: Payload) {
        let gravity = *self.load.gravity();
        self.set_load(LoadModel::new(&self.model, payload, gravity));
    }

    /// The plant has the gravity that the controller is told, and its payload unless another one is known to hang
    /// there.
    pub(crate) fn set_load(&mut self, load: LoadModel) {
        self.actual
            .plant
            .set_controller_model(load.dynamics(), load.gravity());
        self.load = load;
        self.collision.reset();
    }

    /// Number of the stop reason for the snapshot, 0 without one.
    pub(crate) fn stop_code(&self) -> u64 {
        self.machine
            .stop_reason()
            .as_ref()
            .map_or(0, |reason: &StopReason| u64::from(reason.code()))
    }
}
