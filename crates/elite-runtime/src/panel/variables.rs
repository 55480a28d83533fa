//! The variable monitor: every name a task declares `global`, its type and its value (manual 1.2.2).
//!
//! Pure. A name is published when it changes, at most ten times a second of simulated time; what changed in between is
//! published with its newest value when the time has come.

use std::collections::BTreeMap;

/// Shortest simulated time between two publications of one name, s.
pub const VARIABLE_PERIOD: f64 = 0.1;

/// Most names that are watched.
const NAMES_MAX: usize = 1000;

/// Type and value as people read them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VariableValue {
    /// The type's name, as `type(x).__name__`.
    pub type_name: String,
    /// The value, as `repr(x)`; long ones are cut.
    pub value: String,
}

#[derive(Debug)]
struct PublishedVariable {
    shown: VariableValue,
    published_at: f64,
}

/// What has been published of the running task.
#[derive(Debug, Default)]
pub struct Variables {
    published: BTreeMap<String, PublishedVariable>,
}

impl Variables {
    /// A task begins: nothing is known.
    pub fn clear(&mut self) {
        self.published.clear();
    }

    /// True when a change of the name may be published at `now`.
    pub fn is_due(&self, name: &str, now: f64) -> bool {
        match self.published.get(name) {
            // A thousandth of the period keeps rounding from costing a cycle.
            Some(entry) => now - entry.published_at >= VARIABLE_PERIOD * 0.999,
            None => self.published.len() < NAMES_MAX,
        }
    }

    /// Takes the value that a due name has now. True when it is news.
    pub fn publish(&mut self, name: &str, value: &VariableValue, now: f64) -> bool {
        if self.published.get(name).is_some_and(|e| e.shown == *value) {
            return false;
        }
        let entry = PublishedVariable {
            shown: value.clone(),
            published_at: now,
        };
        self.published.insert(name.to_owned(), entry);
        true
    }

    /// Everything published, by name.
    pub fn all(&self) -> Vec<(String, VariableValue)> {
        let entries = self.published.iter();
        entries.map(|(n, e)| (n.clone(), e.shown.clone())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn int(n: u32) -> VariableValue {
        VariableValue {
            type_name: "int".to_owned(),
            value: n.to_string(),
        }
    }

    #[test]
    fn a_name_that_changes_every_cycle_is_published_ten_times_a_second() {
        let mut variables = Variables::default();
        let mut published = Vec::new();
        for cycle in 0..250_u32 {
            let now = f64::from(cycle) * 0.004;
            if variables.is_due("n", now) && variables.publish("n", &int(cycle), now) {
                published.push(cycle);
            }
        }
        assert_eq!(published, [0, 25, 50, 75, 100, 125, 150, 175, 200, 225]);
    }

    #[test]
    fn a_name_that_does_not_change_is_published_once() {
        let mut variables = Variables::default();
        assert!(variables.publish("n", &int(1), 0.0));
        assert!(!variables.publish("n", &int(1), 5.0));
        assert!(
            variables.is_due("n", 5.0),
            "a change now would be news at once"
        );
        assert_eq!(variables.all(), [("n".to_owned(), int(1))]);
    }
}
