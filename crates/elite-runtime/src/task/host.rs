//! What the language asks of its surroundings: output, clock and random numbers, all of them the task's.

use std::cell::Cell;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use elite_lang::{Host, ThreadId};
use motion_api::{Origin, ProgramId, ThreadNumber};

use crate::message::{Message, Observer};
use crate::robot::Robot;

/// 2026-01-01T00:00:00Z, where simulated time begins.
pub(crate) const VIRTUAL_EPOCH_S: f64 = 1_767_225_600.0;

/// The surroundings of one task.
pub(crate) struct TaskHost {
    pub robot: Arc<Robot>,
    pub observer: Arc<dyn Observer>,
    pub program: ProgramId,
    pub random_state: Cell<u64>,
}

impl Host for TaskHost {
    fn print(&self, thread: ThreadId, text: &str) {
        let origin = Origin {
            program: self.program,
            thread: ThreadNumber(thread.0),
            line: 0,
        };
        self.observer.message(&Message::Print {
            origin,
            text: text.to_owned(),
        });
    }

    fn unix_time(&self) -> f64 {
        if self.robot.timeline().is_virtual() {
            VIRTUAL_EPOCH_S + self.robot.state().time
        } else {
            SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .map_or(0.0, |d| d.as_secs_f64())
        }
    }

    fn monotonic(&self) -> f64 {
        self.robot.state().time
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
