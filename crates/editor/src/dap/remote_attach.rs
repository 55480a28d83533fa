//! A client that attaches to a controller that serves elsewhere: what it says goes there, what comes from there goes to
//! it.
//!
//! Owns what of a session has happened before: the client was greeted here, and what it asked for is said there again.

use std::sync::mpsc::SyncSender;

use messages::{Text, text};
use serde_json::{Value as Json, json};

use super::run_channel::{RequestId, SessionEvent};
use super::session::DapSession;

/// Numbers of requests of our own; clients count from 1.
const FIRST_OWN: i64 = 1 << 48;

/// Sender for messages from the controller elsewhere.
pub struct RemoteSender(SyncSender<SessionEvent>);

impl RemoteSender {
    pub(crate) fn new(notes: SyncSender<SessionEvent>) -> Self {
        Self(notes)
    }

    /// A message; false when nobody is there any more.
    pub fn message(&self, message: Json) -> bool {
        self.0.send(SessionEvent::Remote(message)).is_ok()
    }

    /// Nothing more comes, for this reason if it is one worth telling.
    pub fn gone(&self, reason: Option<String>) {
        // Whoever is gone as well needs no word.
        let _ = self.0.send(SessionEvent::Gone(reason));
    }
}

/// Takes messages to there; false when it takes none any more.
pub type RemoteSink = Box<dyn Fn(&Json) -> bool>;

/// Connects to a controller with the arguments of `attach`; a sentence where that fails.
pub type ConnectFn<'l> = dyn Fn(&Json, RemoteSender) -> Result<RemoteSink, Text> + 'l;

impl DapSession<'_> {
    /// `attach`: everything goes there from now on. None: the answer comes from there.
    pub(super) fn attach_elsewhere(
        &mut self,
        request: &RequestId,
        arguments: &Json,
    ) -> Option<Result<Json, Text>> {
        if self.launched.is_some() {
            return Some(Err(text!("a program was launched already", "已启动了程序")));
        }
        let Some(attach) = self.attach else {
            return Some(Err(text!(
                "there is nothing to attach to here",
                "此处没有可连接的对象"
            )));
        };
        let outbox = match attach(arguments, RemoteSender::new(self.events.clone())) {
            Ok(outbox) => outbox,
            Err(error) => return Some(Err(error)),
        };
        let mut number = FIRST_OWN;
        let mut own = |command: &str, arguments: Json| {
            number += 1;
            let message = json!({"seq": number, "type": "request", "command": command, "arguments": arguments});
            outbox(&message)
        };
        own("initialize", self.greeting.clone());
        for wanted in &self.wanted_sources {
            own("setBreakpoints", wanted.arguments.clone());
        }
        for (command, wanted) in &self.wanted_others {
            own(command, wanted.clone());
        }
        let (seq, command) = request;
        outbox(&json!({"seq": seq, "type": "request", "command": command, "arguments": arguments}));
        self.outbox = Some(outbox);
        None
    }

    /// A message from there.
    pub(super) fn take_remote(&mut self, message: Json) {
        let is_own = message
            .get("request_seq")
            .and_then(Json::as_i64)
            .is_some_and(|number| number > FIRST_OWN);
        let is_greeting = message.get("event").and_then(Json::as_str) == Some("initialized");
        if is_own || is_greeting || !message.is_object() {
            return;
        }
        let is_end = message.get("type").and_then(Json::as_str) == Some("response")
            && message.get("command").and_then(Json::as_str) == Some("disconnect");
        self.send(message);
        if is_end {
            self.is_done = true;
        }
    }
}
