//! What may be asked of the arm when: one table of families of commands and of what the arm is doing.
//!
//! Owns the table and the finding of its row and columns. Whether the numbers of a command can be used is found where it is
//! carried out; what it then does is there, too. Commands that are in no family may come at any time.

use motion_api::{Command, CommandId, CommandKind, Origin, Refusal};

use crate::cycle::{Cycle, Generator};
use crate::modes::conveyor::Tracking;
use crate::modes::stands;
use crate::waiting::WaitingFor;

/// What happens to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// It is carried out now; what moves the arm is replaced, joined or changed by it, as it says.
    Act,
    /// It waits until the arm has come to rest, which it is made to.
    Queue,
    /// It is not carried out.
    Refuse(Why),
}

/// Why it is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Why {
    /// Power, brakes or a stop of the safety system.
    NotReady,
    /// Something else moves the arm, or is about to.
    Busy,
    /// The arm is led by hand.
    Led,
    /// A conveyor is tracked.
    Tracking,
    /// Force mode is on.
    InForceMode,
    /// Offsets of the path count.
    PathOffset,
    /// A turntable is tracked that carries the TCP but does not turn it.
    TurnsAboutTheTcp,
}

/// Commands that the same rules are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    /// Planned motions and their points.
    Move,
    /// servoj, speedj, speedl.
    Steer,
    /// freedrive.
    Hand,
    /// Force mode.
    Press,
    /// Belts and turntables.
    Follow,
    /// Offsets of the path.
    Offset,
    /// The TCP.
    Tool,
}

/// What moves the arm. Exactly one applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Doing {
    /// It cannot move.
    Nothing,
    /// Nothing does: it stands.
    Standing,
    /// A planned motion whose call has not returned, or one that is planned.
    Moving,
    /// A planned motion whose sender, which is this one, was told that the next may follow.
    Told,
    /// The end of a planned motion whose call has returned.
    Leaving,
    /// A planned motion that was stopped.
    Halting,
    /// servoj, speedj or speedl of another thread whose call has not returned.
    Steered,
    /// The same of this thread.
    Steering,
    /// The same of anybody, its call returned.
    Coasting,
    /// The same at rest.
    SteeredToRest,
    /// The end of one of those, or of leading by hand.
    ComingToRest,
    /// A belt that is being left.
    LeavingTheBelt,
    /// A hand, because a program said so.
    Led,
    /// A hand, because an input is high.
    LedByInput,
}

/// What is laid over that. Any of them may apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Over {
    Belt,
    TableThatDoesNotTurn,
    Force,
    Offset,
}

use Rule::{Act, Queue, Refuse};

const NOT_READY: Rule = Refuse(Why::NotReady);
const BUSY: Rule = Refuse(Why::Busy);
const LED: Rule = Refuse(Why::Led);
const TRACKING: Rule = Refuse(Why::Tracking);
const FORCE: Rule = Refuse(Why::InForceMode);
const OFFSET: Rule = Refuse(Why::PathOffset);
const TURNS: Rule = Refuse(Why::TurnsAboutTheTcp);

/// Families.
const ROWS: [Family; 7] = [
    Family::Move,
    Family::Steer,
    Family::Hand,
    Family::Press,
    Family::Follow,
    Family::Offset,
    Family::Tool,
];

/// What applies to each family, in their order, while the arm does something.
#[rustfmt::skip]
const DOING: [(Doing, [Rule; 7]); 14] = [
    //                       Move       Steer      Hand       Press      Follow     Offset     Tool
    (Doing::Nothing,       [NOT_READY, NOT_READY, NOT_READY, NOT_READY, NOT_READY, NOT_READY, Act]),
    (Doing::Standing,      [Act,       Act,       Act,       Act,       Act,       Act,       Act]),
    (Doing::Moving,        [BUSY,      BUSY,      BUSY,      Act,       Act,       Act,       Act]),
    (Doing::Told,          [Act,       BUSY,      BUSY,      Act,       Act,       Act,       Act]),
    (Doing::Leaving,       [Act,       Queue,     Queue,     Act,       Act,       Act,       Act]),
    (Doing::Halting,       [Queue,     Queue,     Queue,     Act,       Act,       Act,       Act]),
    (Doing::Steered,       [BUSY,      BUSY,      BUSY,      Act,       Act,       Act,       Act]),
    (Doing::Steering,      [BUSY,      Act,       BUSY,      Act,       Act,       Act,       Act]),
    (Doing::Coasting,      [Queue,     Act,       BUSY,      Act,       Act,       Act,       Act]),
    (Doing::SteeredToRest, [Queue,     Act,       Act,       Act,       Act,       Act,       Act]),
    (Doing::ComingToRest,  [Queue,     Act,       Queue,     Act,       Act,       Act,       Act]),
    (Doing::LeavingTheBelt,[Queue,     Queue,     Queue,     Act,       Act,       Act,       Act]),
    (Doing::Led,           [BUSY,      BUSY,      Act,       BUSY,      LED,       LED,       Act]),
    (Doing::LedByInput,    [LED,       LED,       Act,       LED,       LED,       LED,       Act]),
];

/// The same while something is laid over what the arm does.
#[rustfmt::skip]
const OVER: [(Over, [Rule; 7]); 4] = [
    //                              Move Steer Hand     Press     Follow    Offset    Tool
    (Over::Belt,                 [Act, Act, TRACKING, TRACKING, TRACKING, TRACKING, Act]),
    (Over::TableThatDoesNotTurn, [Act, Act, TRACKING, TRACKING, TRACKING, TRACKING, TURNS]),
    (Over::Force,                [Act, Act, FORCE,    Act,      FORCE,    FORCE,    Act]),
    (Over::Offset,               [Act, Act, OFFSET,   OFFSET,   OFFSET,   Act,      OFFSET]),
];

impl Family {
    const fn of(kind: &CommandKind) -> Option<Self> {
        Some(match kind {
            CommandKind::MoveJ { .. }
            | CommandKind::MoveL { .. }
            | CommandKind::MoveC { .. }
            | CommandKind::MoveP { .. }
            | CommandKind::MoveMl { .. } => Self::Move,
            CommandKind::ServoJ { .. }
            | CommandKind::SpeedJ { .. }
            | CommandKind::SpeedL { .. } => Self::Steer,
            CommandKind::Freedrive { .. } => Self::Hand,
            CommandKind::ForceMode { .. } => Self::Press,
            CommandKind::TrackConveyorLinear { .. } | CommandKind::TrackConveyorCircular { .. } => {
                Self::Follow
            }
            CommandKind::PathOffsetEnable => Self::Offset,
            CommandKind::SetTcp(_) => Self::Tool,
            _ => return None,
        })
    }

    fn rule(self, row: &[Rule; 7]) -> Rule {
        let mut rules = ROWS.iter().zip(row);
        let found = rules.find(|(family, _)| **family == self);
        found.map_or(Act, |(_, rule)| *rule)
    }
}

impl Cycle {
    /// What happens to a command now.
    pub(crate) fn rule(&self, command: &Command) -> Rule {
        let Some(family) = Family::of(&command.kind) else {
            return Act;
        };
        let over = OVER.iter().filter(|(over, _)| self.is_under(*over));
        for (_, row) in over {
            if let rule @ Refuse(_) = family.rule(row) {
                return rule;
            }
        }
        let doing = self.doing(command.origin);
        let mut columns = DOING.iter();
        let found = columns.find(|(column, _)| *column == doing);
        let rule = found.map_or(Act, |(_, row)| family.rule(row));
        match rule {
            // Only one waits.
            Queue if self.deferred.is_some() => BUSY,
            rule => rule,
        }
    }

    fn is_under(&self, over: Over) -> bool {
        let table = |t: &Tracking| t.carries_without_turning();
        match over {
            Over::Belt => self.tracking.as_ref().is_some_and(|t| !table(t)),
            Over::TableThatDoesNotTurn => self.tracking.as_ref().is_some_and(table),
            Over::Force => self.force.is_at_work(),
            Over::Offset => self.path_offset.is_on(),
        }
    }

    fn doing(&self, sender: Origin) -> Doing {
        let caller = |origin: Origin| (origin.program, origin.thread);
        let is_senders = |origin| caller(origin) == caller(sender);
        if self.machine.check_ready().is_err() || self.waiting.includes(WaitingFor::PowerOff) {
            return Doing::Nothing;
        }
        match &self.generator {
            _ if self.upcoming.is_some() || self.deferred.is_some() => Doing::Moving,
            Generator::Hold if self.tracking.as_ref().is_some_and(Tracking::is_stopping) => {
                Doing::LeavingTheBelt
            }
            Generator::Hold => Doing::Standing,
            Generator::Brake(_) => Doing::Nothing,
            Generator::Path(motion) => {
                let is_told = self.queue.last();
                let is_told = is_told.is_some_and(|leg| leg.is_told && is_senders(leg.origin));
                match (motion.is_stopping, self.queue.open_count()) {
                    (true, _) => Doing::Halting,
                    (false, 0) => Doing::Leaving,
                    (false, _) if is_told => Doing::Told,
                    (false, _) => Doing::Moving,
                }
            }
            Generator::Online(online) if online.is_stopping => Doing::ComingToRest,
            Generator::Online(online) if online.is_led_by_hand() => match online.id {
                CommandId::NONE => Doing::LedByInput,
                _ => Doing::Led,
            },
            Generator::Online(online) if online.has_ended() && stands(&self.target) => {
                Doing::SteeredToRest
            }
            Generator::Online(online) if online.has_ended() => Doing::Coasting,
            Generator::Online(online) if is_senders(online.origin) => Doing::Steering,
            Generator::Online(_) => Doing::Steered,
        }
    }

    /// The refusal of a command, with what there is to say about it.
    pub(crate) fn refusal(&self, why: Why) -> Refusal {
        match why {
            Why::NotReady => match self.machine.check_ready() {
                Err(refusal) => refusal,
                // It is about to lose its power.
                Ok(()) => Refusal::StillMoving,
            },
            Why::Busy => Refusal::Busy {
                running: match self.deferred {
                    Some(deferred) => deferred.id,
                    None => self.running(),
                },
            },
            Why::Led => Refusal::LedByHand,
            Why::Tracking => Refusal::Tracking,
            Why::InForceMode => Refusal::InForceMode,
            Why::PathOffset => Refusal::PathOffset,
            Why::TurnsAboutTheTcp => Refusal::TurnsAboutTheTcp,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_each_column_once_and_nothing_moves_an_arm_that_cannot_move() {
        for (k, (column, row)) in DOING.iter().enumerate() {
            assert!(!DOING[..k].iter().any(|(before, _)| before == column));
            if *column == Doing::Nothing {
                assert!(row[..6].iter().all(|rule| *rule == NOT_READY));
            }
        }
        for (k, family) in ROWS.iter().enumerate() {
            assert!(!ROWS[..k].contains(family));
        }
    }

    #[test]
    fn what_is_laid_over_a_motion_excludes_everything_else_of_its_kind() {
        for (over, row) in OVER {
            for (family, own) in [
                (Family::Follow, Over::Belt),
                (Family::Offset, Over::Offset),
                (Family::Press, Over::Force),
            ] {
                let is_free = family.rule(&row) == Act;
                let is_its_own = over == own && family != Family::Follow;
                assert_eq!(is_free, is_its_own, "{family:?} {over:?}");
            }
        }
    }
}
