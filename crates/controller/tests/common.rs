//! A controller that runs programs and keeps what they print.

#![allow(clippy::unwrap_used, reason = "test helpers fail by panicking")]

use std::sync::{Arc, Mutex};

use controller::{Controller, Manner, Prepared, RobotConfig};
use elite_lang::TaskNode;
use elite_runtime::ProgramText;
use elite_runtime::message::{InterpreterEvent, Message, Observer};
use elite_runtime::panel::VariableValue;
use motion_api::{Frame, ProgramId, ThreadNumber};

/// Keeps what is printed.
#[derive(Default)]
pub struct Prints(pub Mutex<String>);

impl Observer for Prints {
    fn message(&self, message: &Message) {
        if let Message::Print { text, .. } = message {
            self.0.lock().unwrap().push_str(text);
        }
    }
    fn program_started(&self, _: ProgramId, _: &str, _: &str) {}
    fn program_runs(&self, _: ProgramId, _: &str) {}
    fn line_changed(&self, _: ProgramId, _: ThreadNumber, _: u32, _: Option<&TaskNode>) {}
    fn program_ended(&self, _: ProgramId) {}
    fn variable_changed(&self, _: ProgramId, _: &str, _: &VariableValue) {}
    fn interpreter(&self, _: &InterpreterEvent<'_>) {}
    fn cycle_ended(&self, _: &Frame) {}
    fn hurry(&self) {}
}

pub fn started(config: &RobotConfig) -> (Controller, Arc<Prints>) {
    let prints = Arc::new(Prints::default());
    let prepared = Prepared::new(config, Manner::alone()).unwrap();
    (prepared.start(prints.clone()).unwrap(), prints)
}

pub fn program(text: &str) -> ProgramText {
    ProgramText {
        name: "test.script".to_owned(),
        text: text.to_owned(),
    }
}
