//! A virtual clock that passes only as many cycles as somebody allows: how a program is stepped.
//!
//! Owns the count of allowed cycles and the meeting of two threads: the task, which asks for a cycle at a time, and
//! whoever allows them, who learns when all are used and the task waits for more. What a cycle does is the inner
//! timeline's.

use std::sync::Arc;
use std::time::Duration;

use motion_api::Timeline;
use parking_lot::{Condvar, Mutex};

/// A door before a virtual timeline.
pub struct CycleGate {
    inner: Arc<dyn Timeline>,
    state: Mutex<GateState>,
    changed: Condvar,
}

struct GateState {
    allowed: CycleBudget,
    /// Cycles that the task has used so far.
    used: u64,
    /// The task stands before the door.
    waits: bool,
    /// The task is to look round once without a cycle.
    hurried: bool,
    /// The task has ended.
    over: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum CycleBudget {
    Cycles(u64),
    Any,
}

/// What the gate sees of the task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GateStatus {
    /// The task stands before the gate, and every cycle it was allowed is used.
    pub waits: bool,
    /// The task has ended, or is about to leave.
    pub over: bool,
    /// Cycles that it has used so far.
    pub used: u64,
}

impl CycleGate {
    /// A closed gate.
    pub fn new(inner: Arc<dyn Timeline>) -> Self {
        Self {
            inner,
            state: Mutex::new(GateState {
                allowed: CycleBudget::Cycles(0),
                used: 0,
                waits: false,
                hurried: false,
                over: false,
            }),
            changed: Condvar::new(),
        }
    }

    /// Allows exactly this many cycles from now on.
    pub fn allow(&self, cycles: u64) {
        let mut state = self.state.lock();
        state.allowed = CycleBudget::Cycles(cycles);
        if cycles > 0 {
            state.waits = false;
        }
        self.changed.notify_all();
    }

    /// Allows any number of cycles.
    pub fn open(&self) {
        let mut state = self.state.lock();
        state.allowed = CycleBudget::Any;
        state.waits = false;
        self.changed.notify_all();
    }

    /// Takes back what is allowed and not used; how many cycles that were.
    pub fn revoke(&self) -> u64 {
        let mut state = self.state.lock();
        let left = match state.allowed {
            CycleBudget::Cycles(left) => left,
            CycleBudget::Any => 0,
        };
        state.allowed = CycleBudget::Cycles(0);
        state.waits = false;
        left
    }

    /// Has a task that stands before the door look round for what it was told.
    pub fn hurry(&self) {
        self.state.lock().hurried = true;
        self.changed.notify_all();
    }

    /// A task is about to begin; the gate is closed.
    pub fn task_begins(&self) {
        let mut state = self.state.lock();
        state.allowed = CycleBudget::Cycles(0);
        (state.waits, state.hurried, state.over) = (false, false, false);
    }

    /// Tells whoever watches that the task has ended.
    pub fn task_ended(&self) {
        self.state.lock().over = true;
        self.changed.notify_all();
    }

    /// Waits until the task stands before the door, has ended, or `patience` is over.
    pub fn wait_for_task(&self, patience: Duration) -> GateStatus {
        let mut state = self.state.lock();
        if !state.waits && !state.over {
            self.changed.wait_for(&mut state, patience);
        }
        GateStatus {
            waits: state.waits,
            over: state.over,
            used: state.used,
        }
    }

    /// One cycle on the calling thread, past the door: for when no task runs.
    pub fn advance_ungated(&self) -> bool {
        self.inner.advance()
    }
}

impl Timeline for CycleGate {
    fn is_virtual(&self) -> bool {
        self.inner.is_virtual()
    }

    fn advance(&self) -> bool {
        let mut state = self.state.lock();
        if state.allowed == CycleBudget::Cycles(0) {
            if !state.hurried {
                state.waits = true;
                self.changed.notify_all();
            }
            while state.allowed == CycleBudget::Cycles(0) && !state.hurried {
                self.changed.wait(&mut state);
            }
        }
        if std::mem::take(&mut state.hurried) {
            state.waits = false;
            return false;
        }
        drop(state);
        // A cycle that the recording holds up is still allowed.
        if !self.inner.advance() {
            return false;
        }
        let mut state = self.state.lock();
        state.used += 1;
        if let CycleBudget::Cycles(left) = &mut state.allowed {
            *left = left.saturating_sub(1);
        }
        true
    }

    fn set_driven(&self, on: bool) {
        self.inner.set_driven(on);
    }

    fn has_ended(&self) -> bool {
        self.inner.has_ended()
    }
}
