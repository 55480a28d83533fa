//! The monotonic clock, and sleeping until a moment of it.

use std::time::Duration;

/// Time of the monotonic clock, which counts from some moment that does not change while the process runs. On Linux
/// that is the same for all processes.
pub fn now() -> Duration {
    imp::now()
}

/// Sleeps until the clock shows this, on Linux with an absolute deadline, so that no time is lost between asking and
/// sleeping.
pub fn sleep_until(deadline: Duration) {
    imp::sleep_until(deadline);
}

#[cfg(target_os = "linux")]
mod imp {
    use std::time::Duration;

    use nix::errno::Errno;
    use nix::sys::time::TimeSpec;
    use nix::time::{ClockId, ClockNanosleepFlags, clock_gettime, clock_nanosleep};

    pub(super) fn now() -> Duration {
        // The clock exists on every Linux; a failure would read as "no time has passed" and make cycles short, not
        // unsafe.
        clock_gettime(ClockId::CLOCK_MONOTONIC).map_or(Duration::ZERO, Duration::from)
    }

    pub(super) fn sleep_until(deadline: Duration) {
        let request = TimeSpec::from_duration(deadline);
        let flags = ClockNanosleepFlags::TIMER_ABSTIME;
        // Interrupted by a signal: sleep on, the deadline is absolute.
        while clock_nanosleep(ClockId::CLOCK_MONOTONIC, flags, &request) == Err(Errno::EINTR) {}
    }
}

#[cfg(not(target_os = "linux"))]
mod imp {
    use std::sync::LazyLock;
    use std::time::{Duration, Instant};

    static START: LazyLock<Instant> = LazyLock::new(Instant::now);

    pub(super) fn now() -> Duration {
        START.elapsed()
    }

    pub(super) fn sleep_until(deadline: Duration) {
        std::thread::sleep(deadline.saturating_sub(now()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_wakes_before_the_deadline() {
        let deadline = now() + Duration::from_millis(5);
        sleep_until(deadline);
        assert!(now() >= deadline);
        // One that has passed is no wait.
        sleep_until(Duration::ZERO);
    }
}
