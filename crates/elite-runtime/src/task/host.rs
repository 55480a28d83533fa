//! What the language asks of its surroundings: output, clock and random numbers, all of them the task's.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::{SystemTime, UNIX_EPOCH};

use elite_lang::{Host, ScriptThread, ThreadId};
use motion_api::ThreadNumber;

use super::context::TaskContext;
use crate::message::Message;

/// 2026-01-01T00:00:00Z, where simulated time begins.
const VIRTUAL_EPOCH_S: f64 = 1_767_225_600.0;

/// The surroundings of one task.
pub(crate) struct TaskHost {
    context: Rc<TaskContext>,
    random_state: Cell<u64>,
    woken: RefCell<Vec<ThreadId>>,
    started: RefCell<Vec<(ThreadNumber, ScriptThread)>>,
}

impl TaskHost {
    /// Random numbers follow from `seed`.
    pub fn new(context: Rc<TaskContext>, seed: u64) -> Self {
        Self {
            context,
            random_state: Cell::new(seed),
            woken: RefCell::default(),
            started: RefCell::default(),
        }
    }

    /// Threads that the program has started through the language since the last call, with their numbers.
    pub fn take_started(&self) -> Vec<(ThreadNumber, ScriptThread)> {
        self.started.take()
    }

    /// Threads that became ready since the last call, in the order in which they did.
    pub fn take_woken(&self) -> Vec<ThreadId> {
        self.woken.take()
    }
}

impl Host for TaskHost {
    fn print(&self, _thread: ThreadId, text: &str) {
        let origin = self.context.origin(0);
        let text = text.to_owned();
        self.context
            .observer()
            .message(&Message::Print { origin, text });
    }

    fn start(&self, thread: ScriptThread) -> Result<(), String> {
        let number = self
            .context
            .take_number()
            .map_err(|refused| refused.to_string())?;
        self.started.borrow_mut().push((number, thread));
        Ok(())
    }

    fn may_wait(&self) -> Result<(), String> {
        if self.context.is_secondary() {
            return Err("a secondary program may not wait".to_owned());
        }
        Ok(())
    }

    fn wake(&self, thread: ThreadId) {
        self.woken.borrow_mut().push(thread);
    }

    fn unix_time(&self) -> f64 {
        if self.context.robot().timeline().is_virtual() {
            VIRTUAL_EPOCH_S + self.context.robot().state().time
        } else {
            SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .map_or(0.0, |d| d.as_secs_f64())
        }
    }

    fn monotonic(&self) -> f64 {
        self.context.robot().state().time
    }

    fn random_u64(&self) -> u64 {
        // SplitMix64 (Steele, Lea, Flood 2014): one addition and a mix, every seed is good.
        let state = self.random_state.get().wrapping_add(0x9e37_79b9_7f4a_7c15);
        self.random_state.set(state);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}
