//! The robot's clock, as a recording needs it: its times only grow, also when it begins anew.

use tokio::time::Instant;

/// Times of the robot's clock as times that only grow, counted from the first.
pub(super) struct Clock {
    pub(super) begin: f64,
    step_time: f64,
    pub(super) now: f64,
    pub(super) cycle: u64,
    /// When the last cycle came, to go on from if the robot's clock begins anew.
    came: Instant,
    is_anew: bool,
}

impl Clock {
    pub(super) fn new(begin: f64, step_time: f64) -> Self {
        Self {
            begin,
            step_time,
            now: 0.0,
            cycle: 0,
            came: Instant::now(),
            is_anew: false,
        }
    }

    /// The connection was gone: the controller may have been, too.
    pub(super) fn begin_anew(&mut self) {
        self.is_anew = true;
    }

    /// Time and number of the cycle with this time stamp, and how many are missing before it; `None` if it is not after
    /// the last.
    pub(super) fn cycle_at(&mut self, timestamp: f64) -> Option<u64> {
        if !timestamp.is_finite() {
            return None;
        }
        let gone = self.came.elapsed().as_secs_f64();
        if self.is_anew && (timestamp - self.begin - self.now - gone).abs() > 1.0 {
            // Another clock: the time that has passed here stands for it.
            self.begin = timestamp - self.now - gone;
        }
        self.is_anew = false;
        let now = timestamp - self.begin + self.step_time;
        let steps = ((now - self.now) / self.step_time).round();
        if steps < 1.0 {
            return None;
        }
        self.came = Instant::now();
        self.now = now;
        self.cycle += steps as u64;
        Some(steps as u64 - 1)
    }
}
