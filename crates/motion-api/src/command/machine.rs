//! Commands of the robot state machine: stops, pauses, power and brakes.

use crate::CommandId;

/// What stops the arm, lets it go on, or changes its robot mode or safety mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MachineCommand {
    /// Decelerates on the path and ends the running motion as aborted. A robot at rest stays at rest.
    Stop {
        /// Only if this command is the one running; [`CommandId::NONE`] stops whatever runs.
        only: CommandId,
    },
    /// Decelerates on the path and holds there until `Resume`.
    Pause,
    /// Goes on after `Pause`.
    Resume,
    /// Arm power on: power off → idle.
    PowerOn,
    /// Arm power off; the arm decelerates first.
    PowerOff,
    /// Brakes released: idle → running.
    ReleaseBrakes,
    /// Leaves a protective stop.
    UnlockProtectiveStop,
    /// A protective stop without a reason of the arm's own: somebody wants to see what follows from one.
    ProtectiveStop,
    /// Clears a safety fault.
    RestartSafetyBoard,
    /// The emergency stop button of the pendant: the arm brakes and loses its power.
    EmergencyStop {
        /// Pressed, or released again.
        pressed: bool,
    },
}

impl MachineCommand {
    /// The name used in the recording and in messages: the script function's where there is one.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Stop { .. } => "stop",
            Self::Pause => "pause",
            Self::Resume => "resume",
            Self::PowerOn => "power_on",
            Self::PowerOff => "power_off",
            Self::ReleaseBrakes => "release_brakes",
            Self::UnlockProtectiveStop => "unlock_protective_stop",
            Self::ProtectiveStop => "protective_stop",
            Self::RestartSafetyBoard => "restart_safety_board",
            Self::EmergencyStop { .. } => "emergency_stop",
        }
    }

    /// True for what stops the arm or lets it go on, without power or brakes being switched on: a
    /// [reserved slot](crate::CommandKind::uses_reserved_slot) is kept for it.
    pub const fn stops_or_resumes(&self) -> bool {
        matches!(
            self,
            Self::Stop { .. }
                | Self::Pause
                | Self::Resume
                | Self::PowerOff
                | Self::EmergencyStop { .. }
        )
    }

    /// True for what switches power, brakes or the safety board.
    pub const fn switches_power(&self) -> bool {
        matches!(
            self,
            Self::PowerOn | Self::PowerOff | Self::ReleaseBrakes | Self::RestartSafetyBoard
        )
    }
}
