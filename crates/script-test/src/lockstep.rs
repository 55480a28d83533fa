//! Two programs on one arm, under one virtual clock, the same on every machine: the test and the program it looks at.
//!
//! They take turns. In every cycle the program runs first, until it waits, then the test; then the cycle passes. While
//! the test has nothing to do the program passes cycles alone. Each runs on a thread of its own, but never both at
//! once, except that a program which has just been started comes to its first wait while the test stands still. Owns
//! the turns; what a cycle does is the inner timeline's.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{self, ThreadId};
use std::time::Duration;

use motion_api::Timeline;
use parking_lot::{Condvar, Mutex};

/// What is done before every cycle, given its number.
type CycleHook = Box<dyn Fn(u64) + Send + Sync>;

/// The timeline that two tasks drive.
pub(crate) struct LockstepTimeline {
    inner: Arc<dyn Timeline>,
    state: Mutex<LockstepState>,
    changed: Condvar,
    before: OnceLock<CycleHook>,
    /// Cycles so far.
    cycles: AtomicU64,
    /// A program is there beside the test.
    has_company: Arc<AtomicBool>,
}

#[derive(Default)]
struct LockstepState {
    test: Option<ThreadId>,
    program: Option<ThreadId>,
    /// Programs that have come so far.
    arrivals: u64,
    /// The program waits for the next cycle, and for its turn in it.
    program_waits: bool,
    turn: ActiveTask,
    /// The test has nothing to do before this cycle.
    rests_until: u64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum ActiveTask {
    #[default]
    Test,
    Program,
}

impl LockstepTimeline {
    /// Nobody takes part yet; who comes first is the test.
    pub(crate) fn new(inner: Arc<dyn Timeline>) -> Self {
        Self {
            inner,
            state: Mutex::default(),
            changed: Condvar::new(),
            before: OnceLock::new(),
            cycles: AtomicU64::new(0),
            has_company: Arc::default(),
        }
    }

    /// Says what is done before every cycle; only the first call counts.
    pub(crate) fn do_before_cycles(&self, act: CycleHook) {
        let _ = self.before.set(act);
    }

    /// Cycles so far.
    pub(crate) fn cycles(&self) -> u64 {
        self.cycles.load(Ordering::Acquire)
    }

    /// True while a program is there beside the test.
    pub(crate) fn program_flag(&self) -> &Arc<AtomicBool> {
        &self.has_company
    }

    /// Number of programs that have come so far.
    pub(crate) fn programs_joined(&self) -> u64 {
        self.state.lock().arrivals
    }

    /// Waits until more programs have come than `before`; false when `patience` was over first.
    pub(crate) fn wait_for_program(&self, before: u64, patience: Duration) -> bool {
        let mut state = self.state.lock();
        self.changed
            .wait_while_for(&mut state, |state| state.arrivals <= before, patience);
        state.arrivals > before
    }

    /// Waits until a program that was started waits for its turn, or is gone; false when `patience` was over first.
    pub(crate) fn wait_until_program_blocks(&self, patience: Duration) -> bool {
        let mut state = self.state.lock();
        let runs = |state: &mut LockstepState| state.program.is_some() && !state.program_waits;
        self.changed.wait_while_for(&mut state, runs, patience);
        state.program.is_none() || state.program_waits
    }

    fn run_cycle(&self) -> bool {
        if let Some(before) = self.before.get() {
            before(self.cycles() + 1);
        }
        let passed = self.inner.advance();
        if passed {
            self.cycles.fetch_add(1, Ordering::AcqRel);
        }
        passed
    }

    /// The test has done its part of the cycle.
    fn test_advances(&self) -> bool {
        let mut state = self.state.lock();
        // A program that has just been started comes to its first wait before time passes.
        while state.program.is_some() && !state.program_waits {
            self.changed.wait(&mut state);
        }
        drop(state);
        if !self.run_cycle() {
            return false;
        }
        let mut state = self.state.lock();
        if state.program.is_some() {
            state.program_waits = false;
            state.turn = ActiveTask::Program;
            self.changed.notify_all();
            while state.turn == ActiveTask::Program && state.program.is_some() {
                self.changed.wait(&mut state);
            }
        }
        state.turn = ActiveTask::Test;
        true
    }

    /// The program has done its part of the cycle.
    fn program_advances(&self) -> bool {
        let mut state = self.state.lock();
        let rests = state.turn == ActiveTask::Program && self.cycles() < state.rests_until;
        if state.test.is_none() || rests {
            drop(state);
            return self.run_cycle();
        }
        state.program_waits = true;
        state.turn = ActiveTask::Test;
        self.changed.notify_all();
        while state.turn == ActiveTask::Test && state.test.is_some() {
            self.changed.wait(&mut state);
        }
        state.program_waits = false;
        let is_alone = state.test.is_none();
        drop(state);
        // With the test gone nobody else passes the cycle that was waited for.
        !is_alone || self.run_cycle()
    }
}

impl Timeline for LockstepTimeline {
    fn is_virtual(&self) -> bool {
        true
    }

    fn advance(&self) -> bool {
        let own = thread::current().id();
        let is_program = self.state.lock().program == Some(own);
        match is_program {
            true => self.program_advances(),
            false => self.test_advances(),
        }
    }

    fn set_driven(&self, on: bool) {
        let own = thread::current().id();
        let mut state = self.state.lock();
        match on {
            true if state.test.is_none() => {
                state.test = Some(own);
                state.turn = ActiveTask::Test;
            }
            true => {
                state.program = Some(own);
                state.arrivals += 1;
                state.program_waits = false;
                self.has_company.store(true, Ordering::Release);
            }
            false if state.program == Some(own) => {
                state.program = None;
                state.program_waits = false;
                state.turn = ActiveTask::Test;
                self.has_company.store(false, Ordering::Release);
            }
            false => state.test = None,
        }
        self.changed.notify_all();
        drop(state);
        self.inner.set_driven(on);
    }

    fn idle_until(&self, cycle: u64) {
        let mut state = self.state.lock();
        if state.test == Some(thread::current().id()) {
            state.rests_until = cycle;
        }
    }

    fn has_ended(&self) -> bool {
        self.inner.has_ended()
    }
}
