//! Jogging by hand: speeds and commands of each axis, and the sign of life without which what is held comes to rest.
//!
//! Pure: who holds something says what time it is.

use std::time::{Duration, Instant};

use kinematics::{JointPositions, JointSpeeds, Pose};
use motion_api::online::FreedriveFrame;
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionCommand, OnlineCommand, RobotState,
};
use serde::Deserialize;

/// What is held ends so long after the last sign of life.
pub const SIGN_OF_LIFE: Duration = Duration::from_millis(150);

/// Fastest jog of a joint, rad/s: with [`JOINT_ACCELERATION`] it stands well within 150 ms of its end.
const JOINT_SPEED: f64 = 0.6;
/// rad/s².
const JOINT_ACCELERATION: f64 = 10.0;
/// Fastest jog of the TCP, m/s and rad/s.
const TCP_SPEED: (f64, f64) = (0.25, 0.6);
/// m/s² and rad/s².
const TCP_ACCELERATION: (f64, f64) = (4.0, 10.0);
/// Speed and acceleration of a move to a place, rad/s and rad/s².
const MOVE: (f64, f64) = (0.6, 1.5);

/// What is jogged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum JogAxis {
    J1,
    J2,
    J3,
    J4,
    J5,
    J6,
    X,
    Y,
    Z,
    Rx,
    Ry,
    Rz,
}

/// Whose axes those of the TCP are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JogFrame {
    /// The base's.
    #[default]
    Base,
    /// The tool's.
    Tool,
}

/// What is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HoldToRun {
    /// A joint or an axis at a share of its speed.
    Jog {
        /// Joint or axis that moves.
        axis: JogAxis,
        /// Frame of the axes.
        frame: JogFrame,
        /// Share of the speed, -1 to 1.
        speed: f64,
    },
    /// A move to joint positions.
    MoveTo {
        /// Target of each joint, rad.
        joints: [f64; 6],
        /// Share of the speed.
        speed: f64,
    },
    /// The arm follows the hand.
    Freedrive,
}

impl HoldToRun {
    /// The command that begins it, from the state now.
    pub fn begin(&self, state: &RobotState) -> CommandKind {
        match *self {
            Self::Jog { axis, frame, speed } => jog(axis, frame, speed, state),
            Self::MoveTo { joints, speed } => CommandKind::Motion(MotionCommand::MoveJ {
                target: JointPositions(joints),
                acceleration: MOVE.1,
                speed: MOVE.0 * speed,
                duration: 0.0,
                radius: 0.0,
            }),
            Self::Freedrive => CommandKind::Online(OnlineCommand::Freedrive {
                free_axes: [true; 6],
                frame: FreedriveFrame::Base,
            }),
        }
    }

    /// The command that it needs again and again: along the tool's axes, which turn with the tool.
    pub fn again(&self, state: &RobotState) -> Option<CommandKind> {
        match self {
            Self::Jog {
                axis,
                frame: JogFrame::Tool,
                ..
            } if *axis as u8 >= JogAxis::Rx as u8 => None,
            Self::Jog {
                frame: JogFrame::Tool,
                axis,
                ..
            } if *axis as u8 >= JogAxis::X as u8 => Some(self.begin(state)),
            _ => None,
        }
    }

    /// The command that ends it. `id` is that of the command that began it.
    pub const fn end(&self, id: CommandId) -> CommandKind {
        match self {
            Self::Jog { axis, .. } if *axis as u8 >= JogAxis::X as u8 => {
                CommandKind::Online(OnlineCommand::StopL {
                    acceleration: TCP_ACCELERATION.0,
                })
            }
            Self::Jog { .. } => CommandKind::Online(OnlineCommand::StopJ {
                acceleration: JOINT_ACCELERATION,
            }),
            Self::MoveTo { .. } => CommandKind::Machine(MachineCommand::Stop { only: id }),
            Self::Freedrive => CommandKind::Online(OnlineCommand::EndFreedrive),
        }
    }

    /// True for what ends by itself.
    pub const fn ends_by_itself(&self) -> bool {
        matches!(self, Self::MoveTo { .. })
    }
}

fn jog(axis: JogAxis, frame: JogFrame, speed: f64, state: &RobotState) -> CommandKind {
    let number = axis as usize;
    let Some(tcp_axis) = number.checked_sub(JogAxis::X as usize) else {
        let mut speeds = JointSpeeds::ZERO;
        speeds[number] = speed * JOINT_SPEED;
        return CommandKind::Online(OnlineCommand::SpeedJ {
            speeds,
            acceleration: JOINT_ACCELERATION,
            duration: None,
        });
    };
    let is_turn = tcp_axis >= 3;
    let fastest = if is_turn { TCP_SPEED.1 } else { TCP_SPEED.0 };
    let mut along = along_axis(tcp_axis % 3, speed * fastest);
    if frame == JogFrame::Tool {
        let tool = Pose::from_rpy(&state.target_tcp_pose);
        let turned = tool.rotate(along.into());
        along = turned.into();
    }
    let mut twist = [0.0; 6];
    let first = if is_turn { 3 } else { 0 };
    twist[first..first + 3].copy_from_slice(&along);
    CommandKind::Online(OnlineCommand::SpeedL {
        speed: twist,
        acceleration: TCP_ACCELERATION.0,
        rotation_acceleration: TCP_ACCELERATION.1,
        duration: None,
    })
}

fn along_axis(axis: usize, length: f64) -> [f64; 3] {
    core::array::from_fn(|k| if k == axis { length } else { 0.0 })
}

/// What a page holds, and when it was last heard of.
#[derive(Clone, Copy, Debug, Default)]
pub struct HoldToRunState {
    held: Option<(HoldToRun, CommandId, Instant)>,
}

impl HoldToRunState {
    /// Something is held from `now` on.
    pub fn begin(&mut self, held: HoldToRun, id: CommandId, now: Instant) {
        self.held = Some((held, id, now));
    }

    /// A sign of life.
    pub fn alive(&mut self, now: Instant) {
        if let Some((.., last)) = &mut self.held {
            *last = now;
        }
    }

    /// What is held.
    pub const fn held(&self) -> Option<(HoldToRun, CommandId)> {
        match self.held {
            Some((held, id, _)) => Some((held, id)),
            None => None,
        }
    }

    /// When it ends unless there is a sign of life before.
    pub fn deadline(&self) -> Option<Instant> {
        self.held.map(|(.., last)| last + SIGN_OF_LIFE)
    }

    /// Ends the motion that is held, if there is one: the command that stops it.
    pub fn end(&mut self) -> Option<CommandKind> {
        let (held, id, _) = self.held.take()?;
        Some(held.end(id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::RpyPose;

    fn state() -> RobotState {
        let mut state = RobotState::at_start(JointPositions::ZERO, 0.004);
        // Upside down: the tool's z points down, its x along the base's.
        state.target_tcp_pose =
            RpyPose::from_array([0.4, 0.0, 0.3, std::f64::consts::PI, 0.0, 0.0]);
        state
    }

    #[test]
    fn axes_of_the_tool_turn_with_it() {
        let jog = |axis, frame| {
            let held = HoldToRun::Jog {
                axis,
                frame,
                speed: 1.0,
            };
            match held.begin(&state()) {
                CommandKind::Online(OnlineCommand::SpeedL { speed, .. }) => {
                    speed.map(|x| (x * 1e6).round() / 1e6)
                }
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(
            jog(JogAxis::Z, JogFrame::Base),
            [0.0, 0.0, 0.25, 0.0, 0.0, 0.0]
        );
        assert_eq!(jog(JogAxis::Z, JogFrame::Tool)[2], -0.25);
        assert_eq!(jog(JogAxis::Ry, JogFrame::Tool)[4], -0.6);
        assert_eq!(jog(JogAxis::Rx, JogFrame::Tool)[3], 0.6);
    }

    #[test]
    fn a_joint_is_jogged_alone_and_stopped_as_a_joint() {
        let held = HoldToRun::Jog {
            axis: JogAxis::J6,
            frame: JogFrame::Base,
            speed: -0.5,
        };
        let CommandKind::Online(OnlineCommand::SpeedJ { speeds, .. }) = held.begin(&state()) else {
            panic!("a joint");
        };
        assert_eq!(speeds.0, [0.0, 0.0, 0.0, 0.0, 0.0, -0.3]);
        assert!(matches!(
            held.end(CommandId(3)),
            CommandKind::Online(OnlineCommand::StopJ { .. })
        ));
        assert_eq!(held.again(&state()), None);
    }

    #[test]
    fn without_a_sign_of_life_it_ends_after_150_ms() {
        let mut jogging = HoldToRunState::default();
        let start = Instant::now();
        assert_eq!((jogging.deadline(), jogging.end()), (None, None));
        jogging.begin(HoldToRun::Freedrive, CommandId(1), start);
        assert_eq!(jogging.deadline(), Some(start + SIGN_OF_LIFE));
        let later = start + Duration::from_millis(100);
        jogging.alive(later);
        assert_eq!(jogging.deadline(), Some(start + Duration::from_millis(250)));
        assert_eq!(
            jogging.end(),
            Some(CommandKind::Online(OnlineCommand::EndFreedrive))
        );
        assert_eq!(jogging.held(), None);
    }

    #[test]
    fn from_the_fastest_jog_the_arm_stands_within_the_time_of_a_sign_of_life() {
        // With the rise of the acceleration, 40 ms at most, on top.
        let ways = [
            (JOINT_SPEED, JOINT_ACCELERATION),
            (TCP_SPEED.0, TCP_ACCELERATION.0),
            (TCP_SPEED.1, TCP_ACCELERATION.1),
        ];
        for (speed, acceleration) in ways {
            let rest = Duration::from_secs_f64(speed / acceleration + 0.04);
            assert!(rest < SIGN_OF_LIFE, "{rest:?}");
        }
    }
}
