//! What script threads wait for.

use std::collections::BTreeMap;

use super::jobs::JobId;
use elite_lang::WaitToken;
use motion_api::{CommandId, ThreadNumber};

use crate::panel::PopupId;

/// One reason to wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wait {
    /// The end of a command.
    Command(CommandId),
    /// The end of a motion, or that the next one may follow it.
    Motion(CommandId),
    /// The end of a motion, or that the next one is due.
    Due(CommandId),
    /// The beginning of a cycle with at least this number.
    Cycle(u64),
    /// The beginning of a cycle with at least this number, or the end of the program beside this one.
    CycleOrProgramEnd(u64),
    /// The end of a script thread.
    Thread(ThreadNumber),
    /// The result of a job outside.
    Job(JobId),
    /// The next turn: over at once, after the other ready threads.
    Turn,
    /// A popup that somebody has to close.
    Popup(PopupId),
    /// A statement of interpreter mode, or its end.
    Statement,
    /// The turn of the task in which a wait on the outside was over when it was recorded.
    Recorded(u64),
    /// The end of the task.
    Never,
}

impl Wait {
    /// True when people or other programs end it: simulated time then keeps wall pace.
    pub const fn is_external(self) -> bool {
        matches!(
            self,
            Self::Popup(_) | Self::Statement | Self::Job(_) | Self::Recorded(_)
        )
    }
}

/// Registered waits by token.
#[derive(Default)]
pub(crate) struct WaitTable {
    last: u64,
    open: BTreeMap<u64, Wait>,
}

impl WaitTable {
    /// Registers a wait.
    pub fn register(&mut self, wait: Wait) -> WaitToken {
        self.last += 1;
        self.open.insert(self.last, wait);
        WaitToken(self.last)
    }

    /// What the token stands for. A token nobody registered would never end; it is treated so.
    pub fn get(&self, token: WaitToken) -> Wait {
        self.open.get(&token.0).copied().unwrap_or(Wait::Never)
    }

    /// Forgets a wait that is over.
    pub fn remove(&mut self, token: WaitToken) {
        self.open.remove(&token.0);
    }
}
