//! Rising edges of points.

use crate::description::Trigger;
use motion_api::PointLevels;

/// The level that a trigger's point had in the cycle before.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Edge {
    /// `None` before the first cycle: outputs were low then, and an input that is high from the beginning has no edge.
    was_high: Option<bool>,
}

impl Edge {
    /// Whether the trigger's point rises in this cycle; never for a time.
    pub(crate) fn rises(
        &mut self,
        trigger: &Trigger,
        outputs: &PointLevels,
        inputs: &PointLevels,
    ) -> bool {
        let (is_high, at_first) = match trigger {
            Trigger::Time(_) => return false,
            Trigger::Output(point) => (outputs.level(*point), false),
            Trigger::Input(point) => (inputs.level(*point), true),
        };
        let was_high = self.was_high.replace(is_high).unwrap_or(at_first);
        is_high && !was_high
    }
}
