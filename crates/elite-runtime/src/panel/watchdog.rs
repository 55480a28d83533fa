//! Watched RTSI inputs: what happens when one is set too rarely (manual 9.5.6). Pure; times are simulated seconds.
//!
//! A watch counts from the call, bites when the input was not set for one period and one control cycle, and bites again
//! only after the input was set or the task went on (protocol: RTSI, watchdog; the tolerance is not established there).

use std::collections::BTreeMap;

/// What a watchdog does to the task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WatchdogAction {
    /// Nothing, apart from a warning.
    Ignore,
    /// Holds the program.
    Pause,
    /// Ends the program.
    Stop,
}

impl WatchdogAction {
    /// The action of that name in scripts.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "ignore" => Some(Self::Ignore),
            "pause" => Some(Self::Pause),
            "stop" => Some(Self::Stop),
            _ => None,
        }
    }
}

/// True for the names of RTSI input variables (protocol: RTSI, inputs).
pub fn is_rtsi_input(name: &str) -> bool {
    const NAMED: [&str; 15] = [
        "speed_slider_mask",
        "speed_slider_fraction",
        "standard_digital_output_mask",
        "standard_digital_output",
        "configurable_digital_output_mask",
        "configurable_digital_output",
        "tool_digital_output_mask",
        "tool_digital_output",
        "standard_analog_output_mask",
        "standard_analog_output_type",
        "standard_analog_output_0",
        "standard_analog_output_1",
        "external_force_torque",
        "input_bit_registers0_to_31",
        "input_bit_registers32_to_63",
    ];
    let numbered = |prefix: &str, from: u32, to: u32| {
        let number = name.strip_prefix(prefix).and_then(|n| n.parse().ok());
        // The number as it is printed: neither `+7` nor `07` is a name.
        number.is_some_and(|n: u32| n >= from && n < to && name == format!("{prefix}{n}"))
    };
    NAMED.contains(&name)
        || numbered("input_bit_register", 64, 128)
        || numbered("input_int_register", 0, 48)
        || numbered("input_double_register", 0, 48)
}

#[derive(Clone, Copy, Debug)]
struct Watch {
    period: f64,
    action: WatchdogAction,
    last_set: f64,
    has_fired: bool,
}

/// The watches of the running task, by variable.
#[derive(Debug, Default)]
pub struct Watchdogs {
    watches: BTreeMap<String, Watch>,
}

impl Watchdogs {
    /// Watches `variable` from `now` on; replaces the watch it had.
    pub fn watch(&mut self, variable: &str, frequency_hz: f64, action: WatchdogAction, now: f64) {
        let watch = Watch {
            period: 1.0 / frequency_hz,
            action,
            last_set: now,
            has_fired: false,
        };
        self.watches.insert(variable.to_owned(), watch);
    }

    /// The variable was set.
    pub fn was_set(&mut self, variable: &str, now: f64) {
        if let Some(watch) = self.watches.get_mut(variable) {
            watch.last_set = now;
            watch.has_fired = false;
        }
    }

    /// Starts every period anew: the task goes on after a pause.
    pub fn restart(&mut self, now: f64) {
        for watch in self.watches.values_mut() {
            watch.last_set = now;
            watch.has_fired = false;
        }
    }

    /// The watches that bite now, each once.
    pub fn expired(&mut self, now: f64, step_time: f64) -> Vec<(String, WatchdogAction)> {
        let mut bites = Vec::new();
        for (variable, watch) in &mut self.watches {
            // A thousandth of a cycle keeps rounding of the sum from biting a cycle early.
            let late = now - watch.last_set > watch.period + step_time * 1.001;
            if late && !watch.has_fired {
                watch.has_fired = true;
                bites.push((variable.clone(), watch.action));
            }
        }
        bites
    }

    /// True when nothing is watched.
    pub fn is_empty(&self) -> bool {
        self.watches.is_empty()
    }

    /// The task has ended: nothing is watched any more.
    pub fn clear(&mut self) {
        self.watches.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.004;

    #[test]
    fn it_bites_once_a_cycle_after_the_period_and_again_after_the_input_was_set() {
        let mut dogs = Watchdogs::default();
        dogs.watch("speed_slider_mask", 10.0, WatchdogAction::Pause, 1.0);
        assert!(dogs.expired(1.104, STEP).is_empty());
        let bite = [("speed_slider_mask".to_owned(), WatchdogAction::Pause)];
        assert_eq!(dogs.expired(1.108, STEP), bite);
        assert!(dogs.expired(2.0, STEP).is_empty(), "once");
        dogs.was_set("speed_slider_mask", 2.0);
        assert!(dogs.expired(2.1, STEP).is_empty());
        assert_eq!(dogs.expired(2.2, STEP), bite);
        dogs.restart(3.0);
        assert_eq!(dogs.expired(3.2, STEP), bite);
        dogs.clear();
        assert!(dogs.expired(9.0, STEP).is_empty());
    }

    #[test]
    fn an_input_set_often_enough_never_bites() {
        let mut dogs = Watchdogs::default();
        dogs.watch("x", 10.0, WatchdogAction::Stop, 0.0);
        for cycle in 1..1000 {
            let now = f64::from(cycle) * STEP;
            if cycle % 25 == 0 {
                dogs.was_set("x", now);
            }
            dogs.was_set("y", now);
            assert!(dogs.expired(now, STEP).is_empty(), "cycle {cycle}");
        }
    }
}
