//! Rising edges of points.

use crate::description::Trigger;
use crate::levels::Levels;

/// The level that a trigger's point had. High before the first cycle: a point that is true from the beginning has no edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    was_high: bool,
}

impl Default for Edge {
    fn default() -> Self {
        Self { was_high: true }
    }
}

impl Edge {
    /// Whether the trigger's point rises in this cycle; never for a time.
    pub(crate) fn rises(&mut self, trigger: &Trigger, outputs: &Levels, inputs: &Levels) -> bool {
        let is_high = match trigger {
            Trigger::Time(_) => return false,
            Trigger::Output(point) => outputs.level(*point),
            Trigger::Input(point) => inputs.level(*point),
        };
        let rises = is_high && !self.was_high;
        self.was_high = is_high;
        rises
    }
}
