//! A program that is ahead of the arm: motions whose calls have returned before they ended, and what waits for them.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use motion_api::{CommandId, CommandKind, OnlineCommand, ThreadNumber};

use super::TaskContext;
use crate::task::deferred::{DeferredEffects, Effect};

/// How far the threads of a task are ahead of the arm.
#[derive(Default)]
pub(super) struct AheadOfArm {
    /// Motions whose calls have returned before they ended, each with its thread.
    queued_motions: RefCell<Vec<(ThreadNumber, CommandId)>>,
    /// Motions of threads that have ended, on their way to their blends.
    left_behind: RefCell<Vec<CommandId>>,
    /// The latest command that moves the arm on when its call has returned, and whose it is.
    steering: Cell<Option<(ThreadNumber, CommandId)>>,
    /// Changes of points that wait for the blend zone of a motion: which, and how many so far.
    changes: Cell<(CommandId, usize)>,
    /// Messages and flags that are shown when the arm has caught up.
    deferred: RefCell<DeferredEffects>,
    /// The last change of an output register by each thread that was ahead of the arm.
    register_changes: RefCell<BTreeMap<ThreadNumber, CommandId>>,
}

impl TaskContext {
    /// Keeps a motion whose call returns before the motion has ended.
    pub fn add_queued_motion(&self, id: CommandId) {
        let mut ahead = self.ahead.queued_motions.borrow_mut();
        ahead.retain(|(_, id)| {
            let has_ended = self.robot.has_ended(*id);
            if has_ended {
                // Nobody asks for the outcome of such a command.
                self.robot.forget(*id);
            }
            !has_ended
        });
        ahead.push((self.running.get().number, id));
    }

    /// Counts a change of a point that is sent ahead of the arm; how many there are now for that motion.
    pub fn count_change_ahead(&self, motion: CommandId) -> usize {
        let (of, count) = self.ahead.changes.get();
        let count = if of == motion { count + 1 } else { 1 };
        self.ahead.changes.set((motion, count));
        count
    }

    /// Shows something: now, or, where the running thread is ahead of the arm, when that enters the blend zone of the
    /// thread's last motion. False when as much waits for that as may.
    pub fn show(&self, effect: &Effect) -> bool {
        // What waits for a motion that has just ended comes first.
        self.show_due_effects();
        let motion = self.last_ahead();
        let Some(motion) = motion.filter(|motion| !self.robot.has_ended(*motion)) else {
            effect.show(&*self.observer, &self.panel);
            return true;
        };
        let mut deferred = self.ahead.deferred.borrow_mut();
        if deferred.is_full(motion) {
            return false;
        }
        deferred.add(self.running.get().number, motion, effect);
        true
    }

    /// Shows what waits for motions that have ended.
    pub fn show_due_effects(&self) {
        self.show_effects_if(|motion| self.robot.has_ended(motion));
    }

    /// Shows what waits for motions that are `over`.
    pub fn show_effects_if(&self, over: impl Fn(CommandId) -> bool) {
        let show = |effect: &Effect| effect.show(&*self.observer, &self.panel);
        self.ahead.deferred.borrow_mut().show_if(over, show);
    }

    /// A thread is stopped before the arm has caught up with it.
    pub fn drop_effects(&self, thread: ThreadNumber) {
        self.ahead.deferred.borrow_mut().drop_of(thread);
    }

    /// Level of a flag as the running thread sees it.
    pub fn flag(&self, number: u8) -> bool {
        let own = self
            .ahead
            .deferred
            .borrow()
            .flag(self.running.get().number, number);
        own.unwrap_or_else(|| self.panel.flag(number))
    }

    /// The running thread has changed an output register ahead of the arm.
    pub fn note_register_change(&self, id: CommandId) {
        let number = self.running.get().number;
        self.ahead.register_changes.borrow_mut().insert(number, id);
    }

    /// The running thread's last change of an output register that was ahead of the arm, told once.
    pub fn take_register_change(&self) -> Option<CommandId> {
        let number = self.running.get().number;
        self.ahead.register_changes.borrow_mut().remove(&number)
    }

    /// A thread has ended whose last motions are still on their way to their blends.
    pub fn leave_ahead(&self, thread: ThreadNumber) {
        let left = self.take_ahead(thread);
        self.ahead.left_behind.borrow_mut().extend(left);
    }

    /// The first motion on its way whose thread has ended: the next one waits for its call, which nobody waits for any
    /// more.
    pub fn first_left_behind(&self) -> Option<CommandId> {
        let mut left = self.ahead.left_behind.borrow_mut();
        left.retain(|id| {
            let has_ended = self.robot.has_ended(*id);
            if has_ended {
                self.robot.forget(*id);
            }
            !has_ended
        });
        left.first().copied()
    }

    /// A command of the running thread moves the arm on when its call has returned, until something ends it.
    pub fn note_steering(&self, kind: &CommandKind, id: CommandId) {
        let steers = matches!(
            kind,
            CommandKind::Online(
                OnlineCommand::ServoJ { .. }
                    | OnlineCommand::SpeedJ { .. }
                    | OnlineCommand::SpeedL { .. }
            )
        );
        if steers {
            self.ahead
                .steering
                .set(Some((self.running.get().number, id)));
        }
    }

    /// The command with which a thread that ends moves the arm on.
    pub fn take_steering(&self, thread: ThreadNumber) -> Option<CommandId> {
        let (number, id) = self.ahead.steering.get()?;
        (number == thread).then(|| {
            self.ahead.steering.set(None);
            id
        })
    }

    /// The last of the running thread's motions whose calls have returned before they ended.
    pub fn last_ahead(&self) -> Option<CommandId> {
        let running = self.running.get().number;
        let ahead = self.ahead.queued_motions.borrow();
        let mut own = ahead.iter().filter(|(thread, _)| *thread == running);
        own.next_back().map(|(_, id)| *id)
    }

    /// The first of these motions, if it has ended: somebody has waited for that.
    pub fn take_ended_ahead(&self) -> Option<CommandId> {
        let running = self.running.get().number;
        let mut ahead = self.ahead.queued_motions.borrow_mut();
        let first = ahead.iter().position(|(thread, _)| *thread == running)?;
        let (_, id) = ahead[first];
        self.robot.has_ended(id).then(|| ahead.remove(first).1)
    }

    /// Whether a motion is one whose call has returned already.
    pub fn is_queued_motion(&self, id: CommandId) -> bool {
        self.ahead
            .queued_motions
            .borrow()
            .iter()
            .any(|(_, other)| *other == id)
            || self.ahead.left_behind.borrow().contains(&id)
    }

    /// The motions of a thread that is stopped.
    pub fn take_ahead(&self, thread: ThreadNumber) -> Vec<CommandId> {
        let mut ahead = self.ahead.queued_motions.borrow_mut();
        let (own, others): (Vec<_>, Vec<_>) = ahead.drain(..).partition(|(t, _)| *t == thread);
        *ahead = others;
        own.into_iter().map(|(_, id)| id).collect()
    }
}
