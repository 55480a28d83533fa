//! A controller that runs programs and keeps what they print.

#![allow(clippy::unwrap_used, reason = "test helpers fail by panicking")]

use std::sync::Arc;

use controller::{Controller, ControllerConfig, PreparedController, StartOptions};
use elite_runtime::ProgramText;
use elite_runtime::message::{Message, Observer};
use parking_lot::Mutex;

/// Keeps what is printed.
#[derive(Default)]
pub struct Prints(pub Mutex<String>);

impl Observer for Prints {
    fn message(&self, message: &Message) {
        if let Message::Print { text, .. } = message {
            self.0.lock().push_str(text);
        }
    }
}

pub fn started(config: &ControllerConfig) -> (Controller, Arc<Prints>) {
    let prints = Arc::new(Prints::default());
    let prepared = PreparedController::new(config, StartOptions::for_single_run()).unwrap();
    (prepared.start(prints.clone()).unwrap(), prints)
}

pub fn program(text: &str) -> ProgramText {
    ProgramText {
        name: "test.script".to_owned(),
        text: text.to_owned(),
    }
}
