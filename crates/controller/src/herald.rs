//! Tells the gate what becomes of programs, and passes everything on.

use elite_runtime::message::Observer;
use motion_api::ProgramId;
use std::sync::{Arc, OnceLock};

use crate::gate::Gate;

/// Tells the gate what becomes of programs.
pub(crate) struct Herald {
    gate: OnceLock<Arc<Gate>>,
    next: Arc<dyn Observer>,
}

impl Herald {
    /// Tells `next` everything; the gate is not there yet.
    pub(crate) fn new(next: Arc<dyn Observer>) -> Self {
        Self {
            gate: OnceLock::new(),
            next,
        }
    }

    /// The gate is there. Set once, before a program can run.
    pub(crate) fn connect(&self, gate: &Arc<Gate>) {
        let _ = self.gate.set(gate.clone());
    }
}

impl Observer for Herald {
    fn next(&self) -> Option<&dyn Observer> {
        Some(&*self.next)
    }

    fn program_ended(&self, program: ProgramId) {
        self.next.program_ended(program);
        if let Some(gate) = self.gate.get() {
            gate.task_ended();
        }
    }

    fn hurry(&self) {
        self.next.hurry();
        if let Some(gate) = self.gate.get() {
            gate.hurry();
        }
    }
}
