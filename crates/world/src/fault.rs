//! What goes wrong, from when to when.

use crate::description::{FaultDescription as Plan, FaultKind, Trigger};
use crate::edges::Edge;
use crate::machine_fault::MachineFault;
use motion_api::IoPoint;
use motion_api::{PointLevels, PointSet};

/// A fault of the description or of a test.
#[derive(Clone, Debug)]
pub(crate) struct Fault {
    pub(crate) plan: Plan,
    edge: Edge,
    /// When it began, s.
    since: Option<f64>,
    has_been: bool,
}

/// What a fault does in one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FaultPhase {
    /// No fault acts.
    Absent,
    /// The first cycle of the fault.
    Begins,
    /// A cycle between the first and the last.
    Lasts,
    /// The cycle after the last.
    Ends,
}

impl Fault {
    pub(crate) fn new(plan: Plan) -> Self {
        Self {
            plan,
            edge: Edge::default(),
            since: None,
            has_been: false,
        }
    }

    /// What it does in this cycle.
    pub(crate) fn advance(
        &mut self,
        outputs: &PointLevels,
        inputs: &PointLevels,
        time: f64,
    ) -> FaultPhase {
        let is_due = match self.plan.when {
            Trigger::Time(at) => !self.has_been && time + 1e-9 >= at,
            when => self.edge.rises(&when, outputs, inputs),
        };
        if is_due && self.since.is_none() {
            (self.since, self.has_been) = (Some(time), true);
            return FaultPhase::Begins;
        }
        let Some(since) = self.since else {
            return FaultPhase::Absent;
        };
        match self.plan.duration {
            Some(duration) if time + 1e-9 >= since + duration => {
                self.since = None;
                FaultPhase::Ends
            }
            _ => FaultPhase::Lasts,
        }
    }

    pub(crate) fn lasts(&self) -> bool {
        self.since.is_some()
    }
}

/// How a machine of this name is impaired.
pub(crate) fn of_machine(faults: &[Fault], name: &str) -> MachineFault {
    let lasting = faults.iter().filter(|fault| fault.lasts());
    lasting.fold(MachineFault::None, |worst, fault| match &fault.plan.what {
        FaultKind::Blocked(machine) if machine == name => MachineFault::Blocked,
        FaultKind::Slow(machine) if machine == name && worst == MachineFault::None => {
            MachineFault::Slow
        }
        _ => worst,
    })
}

/// Whether a gripper of this name leaks.
pub(crate) fn leaks(faults: &[Fault], name: &str) -> bool {
    faults.iter().any(|fault| {
        fault.lasts() && matches!(&fault.plan.what, FaultKind::Leak(gripper) if gripper == name)
    })
}

/// Inputs that are stuck, and those that are open.
pub(crate) fn of_inputs(faults: &[Fault]) -> (PointSet, PointSet) {
    let (mut stuck, mut open) = (PointSet::default(), PointSet::default());
    for fault in faults.iter().filter(|fault| fault.lasts()) {
        match fault.plan.what {
            FaultKind::Stuck(point) => _ = stuck.insert(point),
            FaultKind::Open(point) => _ = open.insert(point),
            _ => {}
        }
    }
    (stuck, open)
}

/// Inputs with their faults; `before` are those of the cycle before.
pub(crate) fn impair(
    inputs: &mut PointLevels,
    before: &PointLevels,
    stuck: &PointSet,
    open: &PointSet,
) {
    inputs.digital = inputs.digital & !stuck.digital | before.digital & stuck.digital;
    inputs.digital &= !open.digital;
    for k in 0..2 {
        inputs.booleans[k] =
            inputs.booleans[k] & !stuck.booleans[k] | before.booleans[k] & stuck.booleans[k];
        inputs.booleans[k] &= !open.booleans[k];
    }
    for port in 0..3_u8 {
        let point = IoPoint::Analog(port);
        if stuck.contains(point) {
            inputs.set_ratio(point, before.ratio(point));
        }
        if open.contains(point) {
            inputs.set_ratio(point, 0.0);
        }
    }
}
