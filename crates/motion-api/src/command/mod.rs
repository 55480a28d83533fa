//! What scripts and ports ask of the motion thread.
//!
//! A command is checked for form (numbers finite, ranges of the manual) before it enters the ring; whether the arm can
//! do it is decided on the other side and comes back as an [`Outcome`](crate::Outcome).
//!
//! Commands come in families, one type and one file each. A family is what one part of the control loop carries out:
//! whoever has a [`MotionCommand`] need not say what becomes of a digital output.

mod machine;
mod motion;
mod online;
mod overlay;
mod sensing;
mod setting;

use core::fmt;

pub use machine::MachineCommand;
pub use motion::MotionCommand;
pub use online::OnlineCommand;
pub use overlay::OverlayCommand;
pub use sensing::SensingCommand;
pub use setting::SettingCommand;

/// Number of a command, in the order in which commands entered the ring, from 1. 0 means "none".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CommandId(pub u64);

impl CommandId {
    /// No command.
    pub const NONE: Self = Self(0);
}

/// Number of a program, in the order in which programs were started, from 1. 0 means "no program" (a port).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ProgramId(pub u32);

/// Number of a script thread inside its task; the main thread is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ThreadNumber(pub u32);

/// The statement from which a command came: program, thread and line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// The program, 0 when a port and not a program asked.
    pub program: ProgramId,
    /// The script thread that called.
    pub thread: ThreadNumber,
    /// Line of the call, from 1; 0 when there is none.
    pub line: u32,
}

/// A numbered request with its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Number in the ring's order.
    pub id: CommandId,
    /// The statement that the command came from.
    pub origin: Origin,
    /// What is asked.
    pub kind: CommandKind,
}

/// The requests, by family.
#[derive(Clone, Copy, PartialEq)]
pub enum CommandKind {
    /// A planned motion.
    Motion(MotionCommand),
    /// An online mode, or coming to rest from one.
    Online(OnlineCommand),
    /// Something that is laid over a motion.
    Overlay(OverlayCommand),
    /// A stop, a pause, power or brakes.
    Machine(MachineCommand),
    /// The force sensor, wrenches from outside, collision detection.
    Sensing(SensingCommand),
    /// Tool, payload, speed, inputs and outputs, encoders.
    Setting(SettingCommand),
}

/// Shows the command and not its family, which says nothing more: messages about reruns quote this form.
impl fmt::Debug for CommandKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Motion(command) => command.fmt(f),
            Self::Online(command) => command.fmt(f),
            Self::Overlay(command) => command.fmt(f),
            Self::Machine(command) => command.fmt(f),
            Self::Sensing(command) => command.fmt(f),
            Self::Setting(command) => command.fmt(f),
        }
    }
}

impl CommandKind {
    /// The name used in the recording and in messages: the script function's where there is one.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Motion(command) => command.name(),
            Self::Online(command) => command.name(),
            Self::Overlay(command) => command.name(),
            Self::Machine(command) => command.name(),
            Self::Sensing(command) => command.name(),
            Self::Setting(command) => command.name(),
        }
    }

    /// True for what stops the arm or lets it go on, and for what tells that a program runs no more. Places in the ring
    /// are kept for these, so that no flood of other commands can keep them out.
    pub const fn uses_reserved_slot(&self) -> bool {
        match self {
            Self::Online(command) => command.ends_motion(),
            Self::Overlay(command) => command.ends_motion(),
            Self::Machine(command) => command.stops_or_resumes(),
            Self::Setting(command) => command.tells_program_state(),
            Self::Motion(_) | Self::Sensing(_) => false,
        }
    }

    /// True for what costs the cycle next to nothing: settings, and modes that begin or end without a plan.
    pub const fn is_light(&self) -> bool {
        match self {
            Self::Motion(_) => false,
            Self::Online(command) => matches!(
                command,
                OnlineCommand::Freedrive { .. } | OnlineCommand::EndFreedrive
            ),
            Self::Machine(command) => !command.switches_power(),
            Self::Overlay(_) | Self::Sensing(_) | Self::Setting(_) => true,
        }
    }

    /// True for commands from which on the arm moves, or may move.
    pub const fn starts_motion(&self) -> bool {
        match self {
            Self::Motion(_) => true,
            Self::Online(command) => command.starts_motion(),
            Self::Overlay(command) => command.starts_motion(),
            Self::Machine(_) | Self::Sensing(_) | Self::Setting(_) => false,
        }
    }

    /// True for commands that move the arm along a planned path and so exclude one another.
    pub const fn is_motion(&self) -> bool {
        matches!(self, Self::Motion(_))
    }
}

impl From<MotionCommand> for CommandKind {
    fn from(command: MotionCommand) -> Self {
        Self::Motion(command)
    }
}

impl From<OnlineCommand> for CommandKind {
    fn from(command: OnlineCommand) -> Self {
        Self::Online(command)
    }
}

impl From<OverlayCommand> for CommandKind {
    fn from(command: OverlayCommand) -> Self {
        Self::Overlay(command)
    }
}

impl From<MachineCommand> for CommandKind {
    fn from(command: MachineCommand) -> Self {
        Self::Machine(command)
    }
}

impl From<SensingCommand> for CommandKind {
    fn from(command: SensingCommand) -> Self {
        Self::Sensing(command)
    }
}

impl From<SettingCommand> for CommandKind {
    fn from(command: SettingCommand) -> Self {
        Self::Setting(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_shown_without_its_family() {
        let stop = CommandKind::from(MachineCommand::Stop { only: CommandId(7) });
        assert_eq!(format!("{stop:?}"), "Stop { only: CommandId(7) }");
        let slower = CommandKind::from(SettingCommand::SetSpeedFraction(0.5));
        assert_eq!(format!("{slower:?}"), "SetSpeedFraction(0.5)");
    }

    #[test]
    fn a_family_costs_no_room_in_the_ring() {
        assert_eq!(size_of::<CommandKind>(), size_of::<OverlayCommand>());
    }
}
