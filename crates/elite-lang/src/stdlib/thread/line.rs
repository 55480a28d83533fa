//! A line of script threads that wait for the same thing.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use super::park;
use crate::eval::Evaluator;
use crate::host::ThreadId;
use crate::value::R;

/// Threads in the order of their coming.
#[derive(Default)]
pub(super) struct WaitQueue {
    places: RefCell<VecDeque<Waiter>>,
}

struct Waiter {
    thread: u64,
    /// Set when it is this one's turn.
    called: Rc<Cell<bool>>,
}

impl WaitQueue {
    /// How many wait.
    pub fn len(&self) -> usize {
        self.places.borrow().len()
    }

    /// The numbers of those that wait.
    pub fn threads(&self) -> Vec<u64> {
        let places = self.places.borrow();
        places.iter().map(|place| place.thread).collect()
    }

    /// Waits in the line until it is the running thread's turn, at most until `deadline`; whether it is. A thread that
    /// is stopped after it was called does `instead` what its turn was for.
    pub fn wait(
        &self,
        ev: &Evaluator<'_>,
        deadline: Option<f64>,
        instead: impl FnOnce(),
    ) -> R<bool> {
        let called = Rc::new(Cell::new(false));
        self.places.borrow_mut().push_back(Waiter {
            thread: ev.core.thread.get(),
            called: called.clone(),
        });
        loop {
            let parked = park(ev, deadline);
            let is_over = || deadline.is_some_and(|end| ev.core.host.monotonic() >= end);
            match parked {
                Err(raised) => {
                    self.leave(&called);
                    if called.get() {
                        instead();
                    }
                    return Err(raised);
                }
                Ok(()) if called.get() => return Ok(true),
                Ok(()) if is_over() => {
                    self.leave(&called);
                    return Ok(false);
                }
                Ok(()) => {}
            }
        }
    }

    fn leave(&self, called: &Rc<Cell<bool>>) {
        let mut places = self.places.borrow_mut();
        places.retain(|place| !Rc::ptr_eq(&place.called, called));
    }

    /// Calls the thread that has waited longest; which that is.
    pub fn notify_one(&self, ev: &Evaluator<'_>) -> Option<u64> {
        let place = self.places.borrow_mut().pop_front()?;
        place.called.set(true);
        ev.core.host.wake(ThreadId(place.thread));
        Some(place.thread)
    }

    /// Calls at most so many.
    pub fn wake_some(&self, ev: &Evaluator<'_>, count: usize) {
        for _ in 0..count.min(self.len()) {
            self.notify_one(ev);
        }
    }
}
