//! What outlives programs and what people see and answer: flags, popups, watched RTSI inputs, the task's global
//! variables.
//!
//! Shared by the task's thread and the ports, so everything is behind short locks and bounded. Owns no clock: who sets
//! something that ages says the simulated time. A task that waits for people is woken through [`Panel::news`].

mod answers;
mod popups;
mod variables;
mod watchdog;

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{Notify, oneshot};

pub use answers::Answer;
use answers::Answers;
pub use popups::{POPUPS_MAX, Popup, PopupId, PopupStyle, Popups};
pub use variables::{VARIABLE_PERIOD, VariableValue, Variables};
pub use watchdog::{WatchdogAction, Watchdogs, is_rtsi_input};

/// Number of internal flags (manual 9.5.2).
pub const FLAGS: u8 = 32;

/// Who answers blocking popups.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Operator {
    /// People or ports: a blocking popup waits until somebody closes it.
    #[default]
    Present,
    /// Nobody is there (`eliteserver run`): a popup is shown and closed at once.
    Absent,
}

/// The panel of one controller.
#[derive(Debug, Default)]
pub struct Panel {
    /// Bit n is flag n. All low when the controller starts (our choice; the manual does not say).
    flags: AtomicU32,
    operator: Operator,
    /// The line at which a thread was when it had computed for a slice without waiting.
    computing_line: AtomicU32,
    popups: Mutex<Popups>,
    watchdogs: Mutex<Watchdogs>,
    variables: Mutex<Variables>,
    answers: Mutex<Answers>,
    news: Arc<Notify>,
}

impl Panel {
    /// A panel with everything low and empty.
    pub fn new(operator: Operator) -> Self {
        Self {
            operator,
            ..Self::default()
        }
    }

    /// The line at which a script thread was last seen computing without waiting; 0 before it was.
    pub fn computing_line(&self) -> u32 {
        self.computing_line.load(Ordering::Relaxed)
    }

    pub(crate) fn set_computing_line(&self, line: u32) {
        self.computing_line.store(line, Ordering::Relaxed);
    }

    /// Level of flag `n`; flags beyond the last are low.
    pub fn flag(&self, n: u8) -> bool {
        n < FLAGS && self.flags.load(Ordering::Relaxed) & (1 << n) != 0
    }

    /// Sets flag `n`; flags beyond the last do not exist.
    pub fn set_flag(&self, n: u8, level: bool) {
        if n >= FLAGS {
            return;
        }
        // One atomic step, so that two writers of different flags never undo each other.
        if level {
            self.flags.fetch_or(1 << n, Ordering::Relaxed);
        } else {
            self.flags.fetch_and(!(1 << n), Ordering::Relaxed);
        }
    }

    /// Who answers popups.
    pub const fn operator(&self) -> Operator {
        self.operator
    }

    /// Shows a popup; the oldest that nobody waits for makes room when there are too many.
    pub fn open_popup(&self, popup: Popup) -> PopupId {
        locked(&self.popups).open(popup)
    }

    /// Closes one popup and lets a program that waits for it go on. False when it is not open.
    pub fn close_popup(&self, id: PopupId) -> bool {
        let closed = locked(&self.popups).close(id);
        self.news.notify_one();
        closed
    }

    /// Closes the popup on top: the newest.
    pub fn close_newest_popup(&self) -> Option<Popup> {
        let closed = locked(&self.popups).close_newest();
        self.news.notify_one();
        closed
    }

    /// Every open popup, oldest first.
    pub fn popups(&self) -> Vec<(PopupId, Popup)> {
        locked(&self.popups).all()
    }

    /// True while the popup is open.
    pub fn is_popup_open(&self, id: PopupId) -> bool {
        locked(&self.popups).is_open(id)
    }

    /// True when RTSI inputs are watched.
    pub fn has_watchdogs(&self) -> bool {
        !locked(&self.watchdogs).is_empty()
    }

    /// An RTSI client has set an input variable at the simulated time `now`, s: its watchdog starts anew.
    pub fn rtsi_input_was_set(&self, variable: &str, now: f64) {
        locked(&self.watchdogs).was_set(variable, now);
    }

    pub(crate) fn with_watchdogs<T>(&self, act: impl FnOnce(&mut Watchdogs) -> T) -> T {
        act(&mut locked(&self.watchdogs))
    }

    /// The global variables of the newest task, by name, as last published.
    pub fn variables(&self) -> Vec<(String, VariableValue)> {
        locked(&self.variables).all()
    }

    pub(crate) fn with_variables<T>(&self, act: impl FnOnce(&mut Variables) -> T) -> T {
        act(&mut locked(&self.variables))
    }

    /// Hears what the secondary program of this name is worth.
    pub(crate) fn expect_answer(&self, name: &str) -> oneshot::Receiver<Answer> {
        locked(&self.answers).expect(name)
    }

    /// Forgets who waits for the answer of a program.
    pub(crate) fn forget_answer(&self, name: &str) {
        drop(self.take_answer(name));
    }

    /// Takes the sender for the answer of a secondary program, if somebody waits for that.
    pub(crate) fn take_answer(&self, name: &str) -> Option<oneshot::Sender<Answer>> {
        locked(&self.answers).take(name)
    }

    /// Wakes a task that waits for the outside. One permit is kept, so that news between a look and a wait is not lost.
    pub fn news(&self) -> &Arc<Notify> {
        &self.news
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Every change under these locks is complete before anything that could panic.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
        #[test]
        fn flags_are_independent_of_each_other(writes in proptest::collection::vec((0_u8..40, any::<bool>()), 0..60)) {
            let panel = Panel::default();
            let mut expected = [false; 64];
            for (n, level) in writes {
                panel.set_flag(n, level);
                expected[n as usize] = level && n < FLAGS;
            }
            for n in 0..40_u8 {
                prop_assert_eq!(panel.flag(n), expected[n as usize]);
            }
        }
    }

    #[test]
    fn flags_set_from_several_threads_at_once_are_all_kept() {
        let panel = Panel::default();
        std::thread::scope(|scope| {
            for n in 0..FLAGS {
                let panel = &panel;
                scope.spawn(move || {
                    for _ in 0..200 {
                        panel.set_flag(n, false);
                        panel.set_flag(n, true);
                        assert!(panel.flag(n), "nobody else writes this flag");
                    }
                });
            }
        });
        assert!((0..FLAGS).all(|n| panel.flag(n)));
    }
}
