//! Who makes time pass: the trait through which scripts wait without knowing which clock runs.

/// A length of simulated time in seconds; finite and not negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Seconds(f64);

impl Seconds {
    /// `None` for NaN, infinite or negative values.
    pub fn new(seconds: f64) -> Option<Self> {
        (seconds.is_finite() && seconds >= 0.0).then_some(Self(seconds))
    }

    /// The plain number.
    pub const fn get(self) -> f64 {
        self.0
    }

    /// How many whole cycles of `step` cover this time: 0 for 0, otherwise at least 1.
    pub fn cycles(self, step: Seconds) -> u64 {
        // A sleep of exactly n cycles must not become n + 1 through rounding of the quotient.
        (self.0 / step.0 - 1e-9).ceil().max(0.0) as u64
    }
}

/// The clock that runs the cycle.
pub trait Timeline: Send + Sync {
    /// True when simulated time only passes through [`advance`](Self::advance).
    fn is_virtual(&self) -> bool;

    /// Runs one cycle on the calling thread and returns true; does nothing and returns false when the clock runs by
    /// itself, when no cycle will ever run again, and when a virtual clock is held up by the recording just now.
    fn advance(&self) -> bool;

    /// Says that a task drives the timeline from now on (`true`) or no longer does (`false`). Calls are counted. While
    /// nobody drives it, a virtual timeline of a server goes on at wall pace.
    fn set_driven(&self, on: bool);

    /// Says that whoever drives from this thread has nothing to do before the cycle with this number: where several
    /// take turns, it need not be asked in between.
    fn idle_until(&self, _cycle: u64) {}

    /// True when no cycle will ever run again: the clock was stopped, or a fault has ended it. Nobody may wait for it
    /// then.
    fn has_ended(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::Seconds;
    use proptest::prelude::*;

    fn seconds(s: f64) -> Seconds {
        Seconds::new(s).unwrap()
    }

    #[test]
    fn a_sleep_of_whole_cycles_takes_that_many() {
        for step in [0.001, 0.004, 0.008] {
            for n in [1, 3, 125, 250, 15_000] {
                assert_eq!(seconds(step * f64::from(n)).cycles(seconds(step)), n as u64);
            }
        }
        assert_eq!(seconds(0.0).cycles(seconds(0.004)), 0);
        assert_eq!(seconds(0.0041).cycles(seconds(0.004)), 2);
    }

    proptest! {
        #[test]
        fn cycles_cover_the_time_and_no_more(time in 1e-6..1e4_f64, step in 0.001..0.008_f64) {
            let cycles = seconds(time).cycles(seconds(step)) as f64;
            prop_assert!(cycles * step >= time - 1e-8 * step);
            prop_assert!((cycles - 1.0) * step < time);
        }
    }

    #[test]
    fn negative_and_infinite_times_are_no_times() {
        assert_eq!(Seconds::new(-1.0), None);
        assert_eq!(Seconds::new(f64::NAN), None);
        assert_eq!(Seconds::new(f64::INFINITY), None);
    }
}
