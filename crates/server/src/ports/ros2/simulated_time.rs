//! The virtual clock in the hands of the node: time passes as fast as `/clock` is followed, or at a factor.

use elite_runtime::Robot;
use tokio::time::{Duration, Instant, sleep_until};

/// Simulated seconds a second at most where no factor is given.
const FACTOR_MAX: f64 = 100.0;
/// Samples that may be on their way to the node.
const AHEAD_MAX: u32 = 8;
/// While the node is this far behind, time is looked after again so soon.
const LOOK_AGAIN: Duration = Duration::from_millis(1);
/// Time that was not used by then is not made up for.
const BEHIND_MAX: Duration = Duration::from_millis(50);

/// Drives the virtual clock as long as it lives.
pub(super) struct SimulatedTime<'a> {
    robot: &'a Robot,
    /// Wall time of a cycle.
    interval: Duration,
    due: Instant,
    ahead: u32,
}

impl<'a> SimulatedTime<'a> {
    /// From now on time passes here, with `factor` seconds a second.
    pub(super) fn begin(robot: &'a Robot, factor: Option<f64>) -> Self {
        robot.timeline().set_driven(true);
        let step = robot.state().step_time;
        Self {
            robot,
            interval: Duration::from_secs_f64(step / factor.unwrap_or(FACTOR_MAX)),
            due: Instant::now(),
            ahead: 0,
        }
    }

    /// A sample goes to the node.
    pub(super) const fn sent(&mut self) {
        self.ahead += 1;
    }

    /// The node has published so many.
    pub(super) const fn shown(&mut self, samples: u32) {
        self.ahead = self.ahead.saturating_sub(samples);
    }

    /// One cycle, when it is due and the node keeps up. Nothing is lost when this is dropped before it returns.
    pub(super) async fn pass(&mut self) {
        if self.ahead >= AHEAD_MAX {
            return tokio::time::sleep(LOOK_AGAIN).await;
        }
        sleep_until(self.due).await;
        let now = Instant::now();
        if now.duration_since(self.due) > BEHIND_MAX {
            self.due = now;
        }
        self.due += self.interval;
        if self.robot.timeline().advance() {
            self.robot.pump();
        } else {
            // Nothing is recorded at the moment, or the clock has ended.
            tokio::time::sleep(LOOK_AGAIN).await;
        }
    }
}

impl Drop for SimulatedTime<'_> {
    fn drop(&mut self) {
        self.robot.timeline().set_driven(false);
    }
}
