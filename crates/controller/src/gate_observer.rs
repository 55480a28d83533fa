//! Tells the gate what becomes of programs, and passes everything on.

use elite_runtime::message::Observer;
use motion_api::ProgramId;
use std::sync::{Arc, OnceLock};

use crate::cycle_gate::CycleGate;

/// Tells the gate what becomes of programs.
pub(crate) struct GateObserver {
    gate: OnceLock<Arc<CycleGate>>,
    next: Arc<dyn Observer>,
}

impl GateObserver {
    /// Tells `next` everything; the gate is not there yet.
    pub(crate) fn new(next: Arc<dyn Observer>) -> Self {
        Self {
            gate: OnceLock::new(),
            next,
        }
    }

    /// The gate is there. Set once, before a program can run.
    pub(crate) fn connect(&self, gate: &Arc<CycleGate>) {
        let _ = self.gate.set(gate.clone());
    }
}

impl Observer for GateObserver {
    fn next(&self) -> Option<&dyn Observer> {
        Some(&*self.next)
    }

    fn program_ended(&self, program: ProgramId) {
        self.next.program_ended(program);
        if let Some(gate) = self.gate.get() {
            gate.task_ended();
        }
    }

    fn release_backpressure(&self) {
        self.next.release_backpressure();
        if let Some(gate) = self.gate.get() {
            gate.hurry();
        }
    }
}
