//! Commands that end when the arm stands: stop, pause, power off.

use motion_api::CommandId;

use crate::constants::WAITING_COMMANDS;

/// What a waiting command is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RestCommand {
    /// A stop.
    Stop,
    /// A pause; a resume ends it too.
    Pause,
    /// Power off: done when the arm stands.
    PowerOff,
}

/// A short list in the order of arrival.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RestCommands {
    list: [Option<(CommandId, RestCommand)>; WAITING_COMMANDS],
    count: usize,
}

impl RestCommands {
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    pub(crate) fn is_full(&self) -> bool {
        self.count == WAITING_COMMANDS
    }

    /// True when the arm is to be powered off once it stands.
    pub(crate) fn contains(&self, kind: RestCommand) -> bool {
        self.list.iter().flatten().any(|(_, k)| *k == kind)
    }

    /// Adds a command. The caller has checked that there is room.
    pub(crate) fn add(&mut self, id: CommandId, kind: RestCommand) {
        if let Some(free) = self.list.iter_mut().find(|slot| slot.is_none()) {
            *free = Some((id, kind));
            self.count += 1;
        }
    }

    /// Removes the oldest command that `matches`.
    pub(crate) fn take(&mut self, matches: impl Fn(RestCommand) -> bool) -> Option<CommandId> {
        let (id, _) = self
            .list
            .iter_mut()
            .filter(|slot| slot.is_some_and(|(_, kind)| matches(kind)))
            .min_by_key(|slot| slot.map(|(id, _)| id))?
            .take()?;
        self.count -= 1;
        Some(id)
    }
}
