//! What may be asked of the arm when: one table of admission classes of commands and of what the arm is doing.
//!
//! Owns the table and the finding of its row and columns. Whether the numbers of a command can be used is found where
//! it is carried out; what it then does is there, too. Commands that are in no class may come at any time.

use motion_api::{
    Command, CommandId, CommandKind, OnlineCommand, Origin, OverlayCommand, Refusal, SettingCommand,
};

use crate::cycle::{ControlLoop, Generator};
use crate::modes::conveyor::ConveyorTracking;
use crate::modes::is_setpoint_at_rest;
use crate::waiting::RestCommand;

/// What happens to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Admission {
    /// The command is carried out now; its kind decides whether it replaces, joins or changes what moves the arm.
    Accept,
    /// The command waits until the arm has come to rest, and makes the arm do so.
    WaitForRest,
    /// The command is not carried out.
    Refuse(RefusalCause),
}

/// The reason for which a command is not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RefusalCause {
    /// Power, brakes or a stop of the safety system.
    NotReady,
    /// Something else moves the arm, or is about to.
    Busy,
    /// The arm is led by hand.
    HandGuided,
    /// A conveyor is tracked.
    ConveyorTracking,
    /// Force mode is on.
    InForceMode,
    /// Offsets of the path count.
    PathOffset,
    /// A turntable is tracked that carries the TCP but does not turn it.
    NonRotatingTurntable,
}

/// Commands that the same rules of admission are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AdmissionClass {
    /// Planned motions and their points.
    Move,
    /// servoj, trajectories, speedj, speedl.
    Online,
    /// freedrive.
    Freedrive,
    /// Force mode.
    ForceMode,
    /// Belts and turntables.
    Conveyor,
    /// Offsets of the path.
    Offset,
    /// The TCP.
    Tool,
}

/// What moves the arm. Exactly one applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ArmActivity {
    /// The arm cannot move: power, brakes or a stop of the safety system.
    Unavailable,
    /// Nothing moves the arm: it stands.
    Idle,
    /// A planned motion whose call has not returned, or one that is planned.
    PathActive,
    /// A planned motion whose sender, which is this one, was told that the next may follow.
    PathReadyForNext,
    /// The end of a planned motion whose call has returned.
    PathFinishing,
    /// A planned motion that was stopped.
    PathStopping,
    /// servoj, speedj or speedl of another thread whose call has not returned.
    OnlineOfOtherThread,
    /// servoj, speedj or speedl of the sender's own thread whose call has not returned.
    OnlineOfSender,
    /// servoj, speedj or speedl of any thread whose call has returned.
    OnlineCallReturned,
    /// servoj, speedj or speedl at rest.
    OnlineAtRest,
    /// The end of a servoj, speedj or speedl, or of leading by hand.
    OnlineStopping,
    /// A belt that is being left.
    ConveyorStopping,
    /// A hand, because a program said so.
    HandGuided,
    /// A hand, because an input is high.
    FreedriveByInput,
}

/// What is laid over that. Any of them may apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Overlay {
    Conveyor,
    NonRotatingTurntable,
    ForceMode,
    Offset,
}

use Admission::{Accept, Refuse, WaitForRest};

const WAIT: Admission = WaitForRest;
const NOT_READY: Admission = Refuse(RefusalCause::NotReady);
const BUSY: Admission = Refuse(RefusalCause::Busy);
const LED: Admission = Refuse(RefusalCause::HandGuided);
const TRACKING: Admission = Refuse(RefusalCause::ConveyorTracking);
const FORCE: Admission = Refuse(RefusalCause::InForceMode);
const OFFSET: Admission = Refuse(RefusalCause::PathOffset);
const NON_ROTATING_TURNTABLE: Admission = Refuse(RefusalCause::NonRotatingTurntable);

/// The classes, in the order of the columns of both tables.
const ADMISSION_CLASSES: [AdmissionClass; 7] = [
    AdmissionClass::Move,
    AdmissionClass::Online,
    AdmissionClass::Freedrive,
    AdmissionClass::ForceMode,
    AdmissionClass::Conveyor,
    AdmissionClass::Offset,
    AdmissionClass::Tool,
];

/// What applies to each class, in their order, while the arm does something.
#[rustfmt::skip]
const ACTIVITY_RULES: [(ArmActivity, [Admission; 7]); 14] = [
    //                                  Move       Online     Freedrive  ForceMode  Conveyor   Offset     Tool
    (ArmActivity::Unavailable,         [NOT_READY, NOT_READY, NOT_READY, NOT_READY, NOT_READY, NOT_READY, Accept]),
    (ArmActivity::Idle,                [Accept,    Accept,    Accept,    Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::PathActive,          [BUSY,      BUSY,      BUSY,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::PathReadyForNext,    [Accept,    BUSY,      BUSY,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::PathFinishing,       [Accept,    WAIT,      WAIT,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::PathStopping,        [WAIT,      WAIT,      WAIT,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::OnlineOfOtherThread, [BUSY,      BUSY,      BUSY,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::OnlineOfSender,      [BUSY,      Accept,    BUSY,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::OnlineCallReturned,  [WAIT,      Accept,    BUSY,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::OnlineAtRest,        [WAIT,      Accept,    Accept,    Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::OnlineStopping,      [WAIT,      Accept,    WAIT,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::ConveyorStopping,    [WAIT,      WAIT,      WAIT,      Accept,    Accept,    Accept,    Accept]),
    (ArmActivity::HandGuided,          [BUSY,      BUSY,      Accept,    BUSY,      LED,       LED,       Accept]),
    (ArmActivity::FreedriveByInput,    [LED,       LED,       Accept,    LED,       LED,       LED,       Accept]),
];

/// What applies to each class, in their order, while something is laid over what the arm does.
#[rustfmt::skip]
const OVERLAY_RULES: [(Overlay, [Admission; 7]); 4] = [
    //                               Move    Online  Freedrive  ForceMode  Conveyor  Offset    Tool
    (Overlay::Conveyor,             [Accept, Accept, TRACKING,  TRACKING,  TRACKING, TRACKING, Accept]),
    (Overlay::NonRotatingTurntable, [Accept, Accept, TRACKING,  TRACKING,  TRACKING, TRACKING, NON_ROTATING_TURNTABLE]),
    (Overlay::ForceMode,            [Accept, Accept, FORCE,     Accept,    FORCE,    FORCE,    Accept]),
    (Overlay::Offset,               [Accept, Accept, OFFSET,    OFFSET,    OFFSET,   Accept,   OFFSET]),
];

impl AdmissionClass {
    /// The class of a command; `None` for what may come at any time.
    const fn of(kind: &CommandKind) -> Option<Self> {
        match kind {
            CommandKind::Motion(_) => Some(Self::Move),
            CommandKind::Online(online) => match online {
                OnlineCommand::ServoJ { .. }
                | OnlineCommand::FollowPoints { .. }
                | OnlineCommand::SpeedJ { .. }
                | OnlineCommand::SpeedL { .. } => Some(Self::Online),
                OnlineCommand::Freedrive { .. } => Some(Self::Freedrive),
                OnlineCommand::StopJ { .. }
                | OnlineCommand::StopL { .. }
                | OnlineCommand::EndFreedrive => None,
            },
            CommandKind::Overlay(overlay) => match overlay {
                OverlayCommand::ForceMode { .. } => Some(Self::ForceMode),
                OverlayCommand::TrackConveyorLinear { .. }
                | OverlayCommand::TrackConveyorCircular { .. } => Some(Self::Conveyor),
                OverlayCommand::PathOffsetEnable => Some(Self::Offset),
                OverlayCommand::EndForceMode
                | OverlayCommand::StopConveyorTracking
                | OverlayCommand::PathOffsetDisable { .. }
                | OverlayCommand::PathOffsetSet { .. }
                | OverlayCommand::PathOffsetFilter(_)
                | OverlayCommand::PathOffsetMax { .. } => None,
            },
            CommandKind::Setting(SettingCommand::SetTcp(_)) => Some(Self::Tool),
            CommandKind::Machine(_) | CommandKind::Sensing(_) | CommandKind::Setting(_) => None,
        }
    }

    fn admission_in(self, row: &[Admission; 7]) -> Admission {
        let mut rules = ADMISSION_CLASSES.iter().zip(row);
        let found = rules.find(|(class, _)| **class == self);
        found.map_or(Accept, |(_, rule)| *rule)
    }
}

impl ControlLoop {
    /// What happens to a command now.
    pub(crate) fn admission(&self, command: &Command) -> Admission {
        let Some(class) = AdmissionClass::of(&command.kind) else {
            return Accept;
        };
        let over = OVERLAY_RULES
            .iter()
            .filter(|(over, _)| self.is_overlay_active(*over));
        for (_, row) in over {
            if let rule @ Refuse(_) = class.admission_in(row) {
                return rule;
            }
        }
        let doing = self.activity(command.origin);
        let mut columns = ACTIVITY_RULES.iter();
        let found = columns.find(|(column, _)| *column == doing);
        let rule = found.map_or(Accept, |(_, row)| class.admission_in(row));
        match rule {
            // Only one waits.
            WaitForRest if self.deferred.is_some() => BUSY,
            rule => rule,
        }
    }

    fn is_overlay_active(&self, over: Overlay) -> bool {
        let table = |t: &ConveyorTracking| t.carries_without_turning();
        match over {
            Overlay::Conveyor => self.tracking.as_ref().is_some_and(|t| !table(t)),
            Overlay::NonRotatingTurntable => self.tracking.as_ref().is_some_and(table),
            Overlay::ForceMode => self.force.is_active(),
            Overlay::Offset => self.path_offset.is_on(),
        }
    }

    fn activity(&self, sender: Origin) -> ArmActivity {
        let caller = |origin: Origin| (origin.program, origin.thread);
        let is_senders = |origin| caller(origin) == caller(sender);
        if self.machine.check_ready().is_err() || self.rest_commands.contains(RestCommand::PowerOff)
        {
            return ArmActivity::Unavailable;
        }
        match &self.generator {
            _ if self.pending_motion.is_some() || self.deferred.is_some() => {
                ArmActivity::PathActive
            }
            Generator::Hold
                if self
                    .tracking
                    .as_ref()
                    .is_some_and(ConveyorTracking::is_stopping) =>
            {
                ArmActivity::ConveyorStopping
            }
            Generator::Hold => ArmActivity::Idle,
            Generator::Stop(_) => ArmActivity::Unavailable,
            Generator::Path(motion) => {
                let is_told = self.queue.last();
                let is_told =
                    is_told.is_some_and(|leg| leg.is_ready_for_next_sent && is_senders(leg.origin));
                match (motion.is_stopping, self.queue.unfinished_count()) {
                    (true, _) => ArmActivity::PathStopping,
                    (false, 0) => ArmActivity::PathFinishing,
                    (false, _) if is_told => ArmActivity::PathReadyForNext,
                    (false, _) => ArmActivity::PathActive,
                }
            }
            Generator::Online(online) if online.is_stopping => ArmActivity::OnlineStopping,
            Generator::Online(online) if online.is_led_by_hand() => match online.id {
                CommandId::NONE => ArmActivity::FreedriveByInput,
                _ => ArmActivity::HandGuided,
            },
            Generator::Online(online)
                if online.has_ended() && is_setpoint_at_rest(&self.target) =>
            {
                ArmActivity::OnlineAtRest
            }
            Generator::Online(online) if online.has_ended() => ArmActivity::OnlineCallReturned,
            Generator::Online(online) if is_senders(online.origin) => ArmActivity::OnlineOfSender,
            Generator::Online(_) => ArmActivity::OnlineOfOtherThread,
        }
    }

    /// The refusal of a command, with what there is to say about it.
    pub(crate) fn refusal(&self, why: RefusalCause) -> Refusal {
        match why {
            RefusalCause::NotReady => match self.machine.check_ready() {
                Err(refusal) => refusal,
                // The machine is ready, so the command came while the arm is about to lose its power.
                Ok(()) => Refusal::StillMoving,
            },
            RefusalCause::Busy => Refusal::Busy {
                running: match self.deferred {
                    Some(deferred) => deferred.id,
                    None => self.running_command(),
                },
            },
            RefusalCause::HandGuided => Refusal::HandGuided,
            RefusalCause::ConveyorTracking => Refusal::ConveyorTracking,
            RefusalCause::InForceMode => Refusal::InForceMode,
            RefusalCause::PathOffset => Refusal::PathOffset,
            RefusalCause::NonRotatingTurntable => Refusal::NonRotatingTurntable,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_each_column_once_and_nothing_moves_an_arm_that_cannot_move() {
        for (k, (column, row)) in ACTIVITY_RULES.iter().enumerate() {
            assert!(
                !ACTIVITY_RULES[..k]
                    .iter()
                    .any(|(before, _)| before == column)
            );
            if *column == ArmActivity::Unavailable {
                assert!(row[..6].iter().all(|rule| *rule == NOT_READY));
            }
        }
        for (k, class) in ADMISSION_CLASSES.iter().enumerate() {
            assert!(!ADMISSION_CLASSES[..k].contains(class));
        }
    }

    #[test]
    fn what_is_laid_over_a_motion_excludes_everything_else_of_its_kind() {
        for (over, row) in OVERLAY_RULES {
            for (class, own) in [
                (AdmissionClass::Conveyor, Overlay::Conveyor),
                (AdmissionClass::Offset, Overlay::Offset),
                (AdmissionClass::ForceMode, Overlay::ForceMode),
            ] {
                let is_free = class.admission_in(&row) == Accept;
                let is_its_own = over == own && class != AdmissionClass::Conveyor;
                assert_eq!(is_free, is_its_own, "{class:?} {over:?}");
            }
        }
    }
}
