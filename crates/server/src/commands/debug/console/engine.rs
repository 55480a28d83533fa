//! The debugger's engine in this process, asked and heard as any of its clients: in messages of the Debug Adapter
//! Protocol over two pipes. What a person can do here and an editor there is one thing.

use std::collections::{BTreeMap, VecDeque};
use std::io::{self, BufReader, PipeReader, PipeWriter};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use editor::dap::stream::{self, DapInput};
use editor::dap::{RunTarget, serve_attaching};
use messages::{Text, text};
use platform::signals::TerminationSignals;
use serde_json::{Value as Json, json};
use supervision::{ThreadRole, ThreadSupervisor};

/// Messages that may wait; the engine is held up beyond.
const WAITING_MAX: usize = 1024;

/// What the console hears.
pub(super) enum EngineEvent {
    /// An event of the protocol: its name and its body.
    Event(String, Json),
    /// Ctrl-C.
    Interrupt,
    /// The engine has gone, or the process is told to end.
    Gone,
}

/// What arrives from the engine and from the signals of the process.
enum EngineInput {
    Message(Json),
    Interrupt,
    Gone,
}

/// The engine.
pub(super) struct DebugEngine {
    input: PipeWriter,
    heard: Receiver<EngineInput>,
    waiting: VecDeque<EngineEvent>,
    /// Answers to requests that nobody has waited for yet, by the number of the request.
    answers: BTreeMap<i64, Json>,
    seq: i64,
}

impl DebugEngine {
    /// Starts it; `launch` makes a robot and a program of the arguments of `launch`.
    pub(super) fn start(
        launch: impl Fn(&Json) -> Result<RunTarget, Text> + Send + Sync + 'static,
    ) -> io::Result<Self> {
        let (of_console, input) = io::pipe()?;
        let (answers, mut output) = io::pipe()?;
        let faults = ThreadSupervisor::default();
        faults.start(ThreadRole::Service, "debug engine", move || {
            // The console notices the end of the pipe.
            let _ = serve_attaching(BufReader::new(of_console), &mut output, &launch, None);
        })?;
        let (sender, heard) = sync_channel(WAITING_MAX);
        let of_signals = sender.clone();
        faults.start(ThreadRole::Service, "debug answers", move || {
            hear(answers, &sender);
        })?;
        let mut signals = TerminationSignals::listen()?;
        faults.start(ThreadRole::Service, "debug signals", move || {
            while let Some(name) = signals.wait() {
                let news = match name {
                    "SIGINT" => EngineInput::Interrupt,
                    _ => EngineInput::Gone,
                };
                if of_signals.send(news).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self {
            input,
            heard,
            waiting: VecDeque::new(),
            answers: BTreeMap::new(),
            seq: 0,
        })
    }

    /// Sends a request, and gives back its number.
    pub(super) fn send(&mut self, command: &str, arguments: Json) -> Result<i64, Text> {
        self.seq += 1;
        let message =
            json!({"type": "request", "seq": self.seq, "command": command, "arguments": arguments});
        stream::write(&mut self.input, &message).map_err(|error| Text::of(&error))?;
        Ok(self.seq)
    }

    /// Sends a request and waits for what is answered.
    pub(super) fn ask(&mut self, command: &str, arguments: Json) -> Result<Json, Text> {
        let number = self.send(command, arguments)?;
        self.answer(number)
    }

    /// Waits for the answer to a request; events wait for [`Self::event`], answers to others until they are asked for.
    pub(super) fn answer(&mut self, number: i64) -> Result<Json, Text> {
        loop {
            if let Some(answer) = self.answers.remove(&number) {
                return result_of(answer);
            }
            match self.heard.recv() {
                Ok(EngineInput::Message(message)) => {
                    let is_answer = message.get("type").and_then(Json::as_str) == Some("response");
                    match message.get("request_seq").and_then(Json::as_i64) {
                        Some(request) if is_answer => _ = self.answers.insert(request, message),
                        _ => self.waiting.extend(event_of(message)),
                    }
                }
                Ok(EngineInput::Interrupt) => self.waiting.push_back(EngineEvent::Interrupt),
                Ok(EngineInput::Gone) | Err(_) => {
                    self.waiting.push_back(EngineEvent::Gone);
                    return Err(text!("the debugger has ended", "调试器已结束"));
                }
            }
        }
    }

    /// An event that has come; none if there is none yet.
    pub(super) fn waiting_event(&mut self) -> Option<EngineEvent> {
        self.waiting.pop_front()
    }

    /// Waits for the next event.
    pub(super) fn event(&mut self) -> EngineEvent {
        loop {
            if let Some(event) = self.waiting.pop_front() {
                return event;
            }
            match self.heard.recv() {
                Ok(EngineInput::Message(message)) => self.waiting.extend(event_of(message)),
                Ok(EngineInput::Interrupt) => return EngineEvent::Interrupt,
                Ok(EngineInput::Gone) | Err(_) => return EngineEvent::Gone,
            }
        }
    }
}

fn hear(answers: PipeReader, sender: &SyncSender<EngineInput>) {
    let mut answers = BufReader::new(answers);
    loop {
        let news = match stream::read(&mut answers) {
            Ok(Some(DapInput::Message(message))) => EngineInput::Message(message),
            Ok(Some(DapInput::Garbage(_)) | None) | Err(_) => EngineInput::Gone,
        };
        let is_last = matches!(news, EngineInput::Gone);
        if sender.send(news).is_err() || is_last {
            return;
        }
    }
}

fn event_of(message: Json) -> Option<EngineEvent> {
    let name = message.get("event").and_then(Json::as_str)?.to_owned();
    let body = message.get("body").cloned().unwrap_or_default();
    Some(EngineEvent::Event(name, body))
}

fn result_of(message: Json) -> Result<Json, Text> {
    let text = |key: &str| message.get(key).and_then(Json::as_str);
    match message.get("success").and_then(Json::as_bool) {
        Some(true) => Ok(message.get("body").cloned().unwrap_or_default()),
        _ => Err(match text("message") {
            Some(message) => Text::verbatim(message.to_owned()),
            None => text!("refused", "被拒绝"),
        }),
    }
}
