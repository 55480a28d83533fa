//! The robot as a program sees it that has just set something: the state of the latest cycle with what waits in the
//! ring.
//!
//! Settings take no simulated time: the caller goes on in this cycle, and the motion thread takes the command in the
//! next one. So whoever asks in between is answered from here, and what the motion thread would refuse is refused here.
//! It has the last word all the same: what others do in between may be refused there, which is logged. Owns no command;
//! `robot` keeps those.

use kinematics::{Pose, RpyPose, Wrench};
use motion_api::form::check_tick_count;
use motion_api::{
    Command, CommandId, CommandKind, EncoderRange, MachineCommand, MotionMode, OnlineCommand,
    Outcome, OverlayCommand, Refusal, RobotMode, RobotState, SafetyMode, SensingCommand,
    SettingCommand,
};

/// What the state of a cycle does not tell: as of the command that was sent last, whether or not a cycle has taken it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CommandedModes {
    /// A conveyor is tracked.
    is_tracking: bool,
    /// The tracked conveyor is a turntable, and the tool does not turn with it.
    keeps_the_tool: bool,
    /// Path offsets count.
    has_offsets: bool,
    /// The counts of the encoders come from the program.
    counts_from_program: [bool; 2],
    /// The latest command that began or ended force mode: an older command may end later.
    force: CommandId,
    /// The latest command that began or ended freedrive: an older command may end later.
    hand: CommandId,
}

impl CommandedModes {
    /// A command was sent.
    pub fn note(&mut self, command: &Command) {
        let id = command.id;
        match command.kind {
            CommandKind::Overlay(OverlayCommand::TrackConveyorLinear { .. }) => {
                (self.is_tracking, self.keeps_the_tool) = (true, false);
            }
            CommandKind::Overlay(OverlayCommand::TrackConveyorCircular { rotate_tool, .. }) => {
                (self.is_tracking, self.keeps_the_tool) = (true, !rotate_tool);
            }
            CommandKind::Overlay(OverlayCommand::StopConveyorTracking) => self.is_tracking = false,
            CommandKind::Overlay(OverlayCommand::PathOffsetEnable) => self.has_offsets = true,
            CommandKind::Overlay(OverlayCommand::PathOffsetDisable { .. }) => {
                self.has_offsets = false
            }
            CommandKind::Machine(MachineCommand::PowerOff) => self.record_stop(),
            CommandKind::Machine(MachineCommand::Stop { only }) if only == CommandId::NONE => {
                self.record_stop();
                (self.force, self.hand) = (id, id);
            }
            CommandKind::Setting(SettingCommand::EncoderEnableSetTickCount { encoder, .. }) => {
                self.count(encoder, true)
            }
            CommandKind::Setting(SettingCommand::EncoderEnablePulseDecode { encoder, .. }) => {
                self.count(encoder, false)
            }
            CommandKind::Overlay(
                OverlayCommand::ForceMode { .. } | OverlayCommand::EndForceMode,
            ) => self.force = id,
            CommandKind::Online(OnlineCommand::Freedrive { .. } | OnlineCommand::EndFreedrive) => {
                self.hand = id
            }
            _ => {}
        }
    }

    /// A command has ended.
    pub fn record_end(&mut self, kind: &CommandKind, outcome: &Outcome) {
        let begins_tracking = matches!(
            kind,
            CommandKind::Overlay(
                OverlayCommand::TrackConveyorLinear { .. }
                    | OverlayCommand::TrackConveyorCircular { .. }
            )
        );
        // Refused because a conveyor is tracked already: that goes on.
        if begins_tracking
            && matches!(outcome, Outcome::Refused(refusal) if *refusal != Refusal::ConveyorTracking)
        {
            self.is_tracking = false;
        }
        if *kind == CommandKind::Overlay(OverlayCommand::PathOffsetEnable)
            && matches!(outcome, Outcome::Refused(_))
        {
            self.has_offsets = false;
        }
    }

    /// A protective or an emergency stop has ended everything that moves.
    pub fn record_stop(&mut self) {
        self.is_tracking = false;
        self.has_offsets = false;
    }

    fn count(&mut self, encoder: u8, from_program: bool) {
        if let Some(source) = self.counts_from_program.get_mut(usize::from(encoder)) {
            *source = from_program;
        }
    }
}

/// The robot as its next cycle will find it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PredictedState {
    /// The state of the latest cycle with the settings of the next one. What is measured stays as it was measured.
    pub state: RobotState,
    lasting: CommandedModes,
    is_led_by_hand: bool,
    /// A motion whose call has not returned.
    running: Option<CommandId>,
}

impl PredictedState {
    pub fn new(state: RobotState, lasting: CommandedModes) -> Self {
        // A stream that holds its speed moves the arm although its call has returned.
        let streams = matches!(
            state.motion_mode,
            MotionMode::SpeedJ | MotionMode::SpeedL | MotionMode::ServoJ
        );
        let moves = state.target_qd.max_abs() > 0.0;
        Self {
            is_led_by_hand: state.motion_mode == MotionMode::Freedrive,
            running: (streams && moves).then_some(state.command_id),
            state,
            lasting,
        }
    }

    /// Adds a command that has not ended; older ones were added before.
    pub fn add(&mut self, command: &Command) {
        let state = &mut self.state;
        let (is_last_of_force, is_last_of_hand) = (
            command.id == self.lasting.force,
            command.id == self.lasting.hand,
        );
        match command.kind {
            CommandKind::Setting(SettingCommand::SetTcp(tcp)) => set_tcp(state, tcp),
            CommandKind::Setting(SettingCommand::SetPayload(payload)) => state.payload = payload,
            CommandKind::Setting(SettingCommand::SetGravity(gravity)) => state.gravity = gravity,
            CommandKind::Setting(SettingCommand::SetSpeedFraction(fraction)) => {
                state.target_speed_fraction = fraction
            }
            CommandKind::Sensing(SensingCommand::SetCollisionDetection(enabled)) => {
                state.collision_detection = enabled
            }
            CommandKind::Sensing(SensingCommand::SetCollisionSensitivity(ratio)) => {
                state.collision_sensitivity = ratio.into();
            }
            CommandKind::Sensing(SensingCommand::ZeroFtSensor) => state.tcp_force = [0.0; 6],
            CommandKind::Setting(SettingCommand::EncoderEnableSetTickCount { encoder, range }) => {
                set_counter(state, encoder, range, range.wrap_count(0.0));
            }
            CommandKind::Setting(SettingCommand::EncoderEnablePulseDecode { encoder, .. }) => {
                set_counter(state, encoder, EncoderRange::Signed32, 0.0);
            }
            CommandKind::Setting(SettingCommand::EncoderSetTickCount { encoder, count }) => {
                if let Some(shown) = state.encoder_counts.get_mut(usize::from(encoder)) {
                    *shown = count;
                }
            }
            CommandKind::Overlay(OverlayCommand::ForceMode { .. }) if is_last_of_force => {
                state.force_mode = true
            }
            CommandKind::Overlay(OverlayCommand::EndForceMode) if is_last_of_force => {
                state.force_mode = false
            }
            CommandKind::Online(OnlineCommand::Freedrive { .. }) if is_last_of_hand => {
                self.is_led_by_hand = true
            }
            CommandKind::Online(OnlineCommand::EndFreedrive) if is_last_of_hand => {
                self.is_led_by_hand = false
            }
            CommandKind::Machine(MachineCommand::Stop { only }) => {
                // What follows a stopped motion waits until the arm stands.
                let is_stopped = |id: &CommandId| only == CommandId::NONE || *id == only;
                self.running = self.running.filter(|id| !is_stopped(id));
                if only == CommandId::NONE {
                    state.force_mode &= !is_last_of_force;
                    self.is_led_by_hand &= !is_last_of_hand;
                }
            }
            kind if kind.starts_motion() && !kind.is_light() => self.running = Some(command.id),
            _ => {}
        }
    }

    /// Whether the motion thread would take a command that takes no time.
    ///
    /// # Errors
    /// What it would answer.
    pub fn check(&self, kind: &CommandKind) -> Result<(), Refusal> {
        kind.validate()?;
        match *kind {
            CommandKind::Setting(SettingCommand::SetTcp(_))
                if self.lasting.is_tracking && self.lasting.keeps_the_tool =>
            {
                Err(Refusal::NonRotatingTurntable)
            }
            CommandKind::Setting(SettingCommand::SetTcp(_)) if self.lasting.has_offsets => {
                Err(Refusal::PathOffset)
            }
            CommandKind::Setting(SettingCommand::EncoderSetTickCount { encoder, count }) => {
                let encoder = usize::from(encoder);
                let sources = self.lasting.counts_from_program;
                let is_from_program = sources.get(encoder).is_some_and(|source| *source);
                let number = self.state.encoder_ranges.get(encoder);
                let range = number.and_then(|number| EncoderRange::from_number(*number));
                check_tick_count(is_from_program, range.unwrap_or_default(), count)
            }
            CommandKind::Overlay(OverlayCommand::ForceMode { .. }) => {
                self.check_ready()?;
                if self.lasting.is_tracking {
                    return Err(Refusal::ConveyorTracking);
                }
                if self.is_led_by_hand {
                    let running = self.state.command_id;
                    return Err(Refusal::Busy { running });
                }
                Ok(())
            }
            CommandKind::Online(OnlineCommand::Freedrive { .. }) => {
                self.check_ready()?;
                if self.state.force_mode {
                    return Err(Refusal::InForceMode);
                }
                match self.running {
                    Some(running) => Err(Refusal::Busy { running }),
                    None => Ok(()),
                }
            }
            CommandKind::Overlay(
                OverlayCommand::TrackConveyorLinear { .. }
                | OverlayCommand::TrackConveyorCircular { .. }
                | OverlayCommand::PathOffsetEnable,
            ) => {
                self.check_ready()?;
                if self.lasting.is_tracking {
                    return Err(Refusal::ConveyorTracking);
                }
                if self.state.force_mode {
                    return Err(Refusal::InForceMode);
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn check_ready(&self) -> Result<(), Refusal> {
        let (robot_mode, safety_mode) = (self.state.robot_mode, self.state.safety_mode);
        let may_move = safety_mode.allows_motion() || safety_mode == SafetyMode::SafeguardStop;
        if robot_mode == RobotMode::Running && may_move {
            return Ok(());
        }
        Err(Refusal::NotReady {
            robot_mode,
            safety_mode,
        })
    }
}

/// What was foreseen last, so that a program that asks after each of its settings pays for the new ones only: where a
/// cycle is long in coming, hundreds wait.
#[derive(Debug, Default)]
pub(crate) struct PredictionCache {
    last: Option<Box<CachedPrediction>>,
}

/// What was foreseen, and of what.
#[derive(Debug)]
struct CachedPrediction {
    of: PredictionKey,
    /// The youngest command in the prediction.
    newest: CommandId,
    foreseen: PredictedState,
}

/// What commands are laid over. As long as it is the same, only younger commands are to be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PredictionKey {
    /// The cycle of the state.
    pub cycle: u64,
    /// Commands that had ended by this cycle are in the state already.
    pub ended_by: u64,
    /// How often a command has ended, been closed, or entered behind a younger one.
    pub changes: u64,
}

impl PredictionCache {
    /// The youngest command in what was foreseen last.
    pub fn newest(&self) -> CommandId {
        self.last
            .as_ref()
            .map_or(CommandId::NONE, |kept| kept.newest)
    }

    /// The robot with the commands that are under way over the state. `commands` shows those younger than the given
    /// one, in their order.
    pub fn of<'a, I: Iterator<Item = &'a Command>>(
        &mut self,
        of: PredictionKey,
        state: &RobotState,
        lasting: CommandedModes,
        commands: impl FnOnce(CommandId) -> I,
    ) -> PredictedState {
        let last_of = |lasting: &CommandedModes| (lasting.force, lasting.hand);
        let kept = self.last.as_mut().filter(|kept| {
            // Older commands about force and freedrive count no more once there is a younger one.
            kept.of == of && last_of(&kept.foreseen.lasting) == last_of(&lasting)
        });
        let kept = match kept {
            Some(kept) => {
                kept.foreseen.lasting = lasting;
                kept
            }
            None => {
                let fresh = CachedPrediction {
                    of,
                    newest: CommandId::NONE,
                    foreseen: PredictedState::new(*state, lasting),
                };
                match &mut self.last {
                    Some(kept) => {
                        **kept = fresh;
                        kept
                    }
                    empty => empty.insert(Box::new(fresh)),
                }
            }
        };
        for command in commands(kept.newest) {
            kept.foreseen.add(command);
            kept.newest = command.id;
        }
        kept.foreseen
    }
}

fn set_counter(state: &mut RobotState, encoder: u8, range: EncoderRange, count: f64) {
    let encoder = usize::from(encoder);
    if let (Some(number), Some(shown)) = (
        state.encoder_ranges.get_mut(encoder),
        state.encoder_counts.get_mut(encoder),
    ) {
        (*number, *shown) = (range.number(), count);
    }
}

/// Everything about the TCP of a state, about another one.
fn set_tcp(state: &mut RobotState, tcp: RpyPose) {
    let before_from_after = Pose::from_rpy(&state.tcp_offset).inverse() * Pose::from_rpy(&tcp);
    let speeds = [
        (&mut state.target_tcp_speed, &state.target_tcp_pose),
        (&mut state.actual_tcp_speed, &state.actual_tcp_pose),
    ];
    for (speed, pose) in speeds {
        let [x, y, z, rx, ry, rz] = *speed;
        let arm = Pose::from_rpy(pose).rotate(before_from_after.translation);
        // The new point moves by the angular speed times the way to it besides.
        let around = [
            ry * arm.z - rz * arm.y,
            rz * arm.x - rx * arm.z,
            rx * arm.y - ry * arm.x,
        ];
        *speed = [x + around[0], y + around[1], z + around[2], rx, ry, rz];
    }
    let poses = [
        &mut state.target_tcp_pose,
        &mut state.actual_tcp_pose,
        &mut state.target_waypoint,
    ];
    for pose in poses {
        *pose = (Pose::from_rpy(pose) * before_from_after).to_rpy();
    }
    let after_from_before = before_from_after.inverse();
    for wrench in [&mut state.tcp_force, &mut state.raw_wrench] {
        let about_after = Wrench::from_array(*wrench).transformed_by(&after_from_before);
        *wrench = about_after.to_array();
    }
    state.tcp_offset = tcp;
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::JointPositions;
    use motion_api::Origin;
    use std::cell::Cell;

    #[test]
    fn each_setting_that_waits_is_laid_over_the_state_once() {
        let state = RobotState::at_start(JointPositions::ZERO, 0.004);
        let basis = PredictionKey {
            cycle: 7,
            ended_by: u64::MAX,
            changes: 3,
        };
        let laid = Cell::new(0);
        let mut waiting = Vec::new();
        let mut foresight = PredictionCache::default();
        let mut ask = |basis: PredictionKey, waiting: &[Command]| {
            let foreseen = foresight.of(basis, &state, CommandedModes::default(), |after| {
                let younger = waiting.iter().filter(move |command| command.id > after);
                younger.inspect(|_| laid.set(laid.get() + 1))
            });
            foreseen.state.target_speed_fraction
        };
        for id in 1..=512_u32 {
            let fraction = 1.0 / f64::from(id);
            waiting.push(Command {
                id: CommandId(u64::from(id)),
                origin: Origin::default(),
                kind: CommandKind::Setting(SettingCommand::SetSpeedFraction(fraction)),
            });
            assert_eq!(ask(basis, &waiting), fraction);
        }
        assert_eq!(laid.get(), 512);
        // A cycle later, and when one has ended, they are laid over another state.
        for changed in [
            PredictionKey { cycle: 8, ..basis },
            PredictionKey {
                changes: 4,
                ..basis
            },
        ] {
            laid.set(0);
            ask(changed, &waiting);
            assert_eq!(laid.get(), 512);
        }
    }
}
