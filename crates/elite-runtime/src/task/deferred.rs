//! What a program lets people and other threads see before the arm has caught up with it: messages and flags.
//!
//! A thread whose last motion is still on its way to its blend zone need not wait to say something, and says nothing
//! too early: its message is shown, and its flag set, in the cycle in which the zone is entered, when outputs change as
//! well (`Call::change`). The thread itself reads its flags at once.

use motion_api::{CommandId, ThreadNumber};

use crate::message::{Message, Observer};
use crate::panel::Panel;

/// Effects that may wait for one motion; for a further one the program waits until the arm is there.
const EFFECTS_OF_MOTION: usize = 16;

/// What is seen.
#[derive(Clone, Debug)]
pub(crate) enum Effect {
    /// A log line.
    Message(Message),
    /// A level of a flag.
    Flag { number: u8, level: bool },
}

impl Effect {
    /// Makes it seen.
    pub fn show(&self, observer: &dyn Observer, panel: &Panel) {
        match self {
            Self::Message(message) => observer.message(message),
            Self::Flag { number, level } => panel.set_flag(*number, *level),
        }
    }
}

struct DeferredEffect {
    thread: ThreadNumber,
    /// The motion whose end it waits for.
    motion: CommandId,
    effect: Effect,
}

/// Effects that wait, in the order in which the program asked for them.
#[derive(Default)]
pub(super) struct DeferredEffects(Vec<DeferredEffect>);

impl DeferredEffects {
    /// Whether as many wait for the motion as may.
    pub fn is_full(&self, motion: CommandId) -> bool {
        self.0.iter().filter(|next| next.motion == motion).count() >= EFFECTS_OF_MOTION
    }

    /// Keeps an effect until `motion` ends. It outlives the call that asked for it.
    pub fn add(&mut self, thread: ThreadNumber, motion: CommandId, effect: &Effect) {
        task_memory::uncounted(|| {
            self.0.push(DeferredEffect {
                thread,
                motion,
                effect: effect.clone(),
            });
        });
    }

    /// The level that a thread has given to a flag and that waits.
    pub fn flag(&self, thread: ThreadNumber, number: u8) -> Option<bool> {
        let mut own = self.0.iter().rev().filter(|next| next.thread == thread);
        own.find_map(|next| match next.effect {
            Effect::Flag { number: n, level } if n == number => Some(level),
            _ => None,
        })
    }

    /// Shows those whose motions `have_ended`.
    pub fn show_if(&mut self, have_ended: impl Fn(CommandId) -> bool, show: impl Fn(&Effect)) {
        if self.0.is_empty() {
            return;
        }
        task_memory::uncounted(|| {
            self.0.retain(|next| {
                let is_due = have_ended(next.motion);
                if is_due {
                    show(&next.effect);
                }
                !is_due
            });
        });
    }

    /// Gives up those of a thread that is stopped: it would not have come to them.
    pub fn drop_of(&mut self, thread: ThreadNumber) {
        task_memory::uncounted(|| self.0.retain(|next| next.thread != thread));
    }
}
