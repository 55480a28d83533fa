//! Tells the gate what becomes of programs, and passes everything on.

use std::sync::{Arc, OnceLock};

use elite_lang::TaskNode;
use elite_runtime::message::{InterpreterEvent, Message, Observer};
use elite_runtime::panel::VariableValue;
use motion_api::{Frame, ProgramId, ThreadNumber};

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
    fn message(&self, message: &Message) {
        self.next.message(message);
    }

    fn program_started(&self, program: ProgramId, name: &str, text: &str) {
        self.next.program_started(program, name, text);
    }

    fn program_runs(&self, program: ProgramId, text: &str) {
        self.next.program_runs(program, text);
    }

    fn line_changed(
        &self,
        program: ProgramId,
        thread: ThreadNumber,
        line: u32,
        node: Option<&TaskNode>,
    ) {
        self.next.line_changed(program, thread, line, node);
    }

    fn program_ended(&self, program: ProgramId) {
        self.next.program_ended(program);
        if let Some(gate) = self.gate.get() {
            gate.task_ended();
        }
    }

    fn variable_changed(&self, program: ProgramId, name: &str, value: &VariableValue) {
        self.next.variable_changed(program, name, value);
    }

    fn interpreter(&self, event: &InterpreterEvent<'_>) {
        self.next.interpreter(event);
    }

    fn cycle_ended(&self, frame: &Frame) {
        self.next.cycle_ended(frame);
    }

    fn hurry(&self) {
        self.next.hurry();
        if let Some(gate) = self.gate.get() {
            gate.hurry();
        }
    }
}
