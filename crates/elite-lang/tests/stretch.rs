//! How long a program that is stopped works between two safepoints, by the processor's time of its thread.
#![allow(clippy::unwrap_used, clippy::expect_used)] // a test

use std::time::Duration;

use elite_lang::{Resume, ResumeOutcome};
use nix::time::{ClockId, clock_gettime};

use crate::support::Task;

/// The longest work between two safepoints; without optimisation all of it is slower by more than an order of
/// magnitude.
pub const STRETCH_MAX: Duration =
    Duration::from_millis(if cfg!(debug_assertions) { 32 } else { 5 });
/// How often something must take too long before it counts: the machine does other things, too.
pub const TRIES: usize = 3;
/// Safepoints after which a program is stopped.
const TURNS: usize = 12;

fn time_of_processor() -> Duration {
    match clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID) {
        Ok(time) => time.into(),
        Err(error) => panic!("no clock of the thread: {error}"),
    }
}

/// The longest work between two safepoints of a program that is stopped after some turns behind the line `go`, and ends
/// within so many more.
pub fn longest(task: &Task, program: &str, most_after_stop: usize) -> Duration {
    task.host.output.take();
    let mut thread = task.spawn(program);
    let (mut longest, mut turns) = (Duration::ZERO, 0);
    loop {
        let has_begun = !task.host.output.borrow().is_empty();
        let fuel = if has_begun { 1 } else { 1 << 20 };
        let before = time_of_processor();
        let step = match turns < TURNS {
            true => thread.resume(Resume::Continue, fuel),
            false => thread.resume(Resume::Stop, 0),
        };
        let stretch = time_of_processor() - before;
        if has_begun {
            longest = longest.max(stretch);
            turns += 1;
        }
        assert!(
            turns.saturating_sub(TURNS) < most_after_stop,
            "a stop does not end it"
        );
        match step {
            ResumeOutcome::OutOfFuel | ResumeOutcome::Waiting(_) | ResumeOutcome::Parked { .. } => {
            }
            ResumeOutcome::Done(_) | ResumeOutcome::Failed(_) | ResumeOutcome::Stopped => {
                return longest;
            }
        }
    }
}
