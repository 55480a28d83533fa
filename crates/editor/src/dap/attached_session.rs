//! A session with a client that has attached to a controller that serves. The program is another's: it goes forward
//! only, and goes on when the client leaves. Who looks on may ask, who drives may hold it and change its variables.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender};

use elite_runtime::ProgramText;
use elite_syntax::SourceFile;
use elite_syntax::breakpoint_locations;
use messages::{Text, text};
use serde_json::{Value as Json, json};

use super::hub::{DebugHub, ProgramStarted};
use super::run::Run;
use super::run_channel::{RequestId, RunCommand, SessionEvent};
use super::session::{DapSession, LaunchedProgram, ProgramPhase};
use super::stream::{DapInput, MessageSink};

/// What may wait for a session.
const NOTES_MAX: usize = 1024;
/// Questions whose answers are due.
const ASKS_MAX: usize = 256;

/// What an attached session is attached to.
pub(crate) struct Attachment {
    pub hub: Arc<DebugHub>,
    /// Number of the client in the hub; 0 before `attach`.
    pub client: u32,
    /// The client has shown the token.
    is_trusted: bool,
    drives: bool,
    asks: BTreeMap<i64, RequestId>,
    last_ask: i64,
}

impl Attachment {
    /// Whether this client drives the program.
    pub fn drives(&self) -> bool {
        self.drives && self.client > 0
    }
}

/// The end of an attached session where messages go in.
#[derive(Clone)]
pub struct SessionSender(SyncSender<SessionEvent>);

impl SessionSender {
    /// A message of the client; false where too many wait, or nobody takes them any more.
    pub fn message(&self, text: &str) -> bool {
        let message = match serde_json::from_str(text) {
            Ok(message) => DapInput::Message(message),
            Err(error) => DapInput::Garbage(error.to_string()),
        };
        self.0.try_send(SessionEvent::Client(message)).is_ok()
    }

    /// Something for people: what programs print, and the log.
    pub fn output(&self, category: &'static str, text: Text) {
        // Who is behind misses some.
        let _ = self.0.try_send(SessionEvent::Said(category, text));
    }

    /// The client has gone.
    pub fn gone(&self) {
        // Where there is no room the session ends with its output.
        let _ = self.0.try_send(SessionEvent::Gone(None));
    }
}

/// A session that is not served yet.
pub struct AttachedSession {
    notes: Receiver<SessionEvent>,
    sender: SyncSender<SessionEvent>,
    hub: Arc<DebugHub>,
    is_trusted: bool,
}

impl AttachedSession {
    /// A session of a client that has shown the token, or not, and where its messages go in.
    pub fn new(hub: Arc<DebugHub>, is_trusted: bool) -> (Self, SessionSender) {
        let (sender, notes) = std::sync::mpsc::sync_channel(NOTES_MAX);
        let inlet = SessionSender(sender.clone());
        let session = Self {
            notes,
            sender,
            hub,
            is_trusted,
        };
        (session, inlet)
    }

    /// Serves the client until it leaves, on the calling thread.
    pub fn serve(self, out: &mut dyn MessageSink) {
        let launch = |_: &Json| {
            Err(text!(
                "this controller serves: attach to it",
                "此控制器在提供服务：请连接到它"
            ))
        };
        let mut session = DapSession::new(out, &launch, self.sender);
        session.attachment = Some(Attachment {
            hub: self.hub,
            client: 0,
            is_trusted: self.is_trusted,
            drives: false,
            asks: BTreeMap::new(),
            last_ask: 0,
        });
        while !session.is_done {
            // The session itself holds a sender, so that this does not fail.
            match self.notes.recv() {
                Ok(note) => session.handle_event(note),
                Err(_) => break,
            }
        }
        session.detach();
    }
}

impl DapSession<'_> {
    /// The answer to a request, where it is another than that of a launched session.
    pub(super) fn attached_request(
        &mut self,
        request: &RequestId,
        arguments: &Json,
    ) -> Option<Option<Result<Json, Text>>> {
        self.attachment.as_ref()?;
        let command = request.1.as_str();
        let drives_only = matches!(
            command,
            "setBreakpoints"
                | "setFunctionBreakpoints"
                | "setExceptionBreakpoints"
                | "setDataBreakpoints"
                | "continue"
                | "next"
                | "stepIn"
                | "stepOut"
                | "nextNode"
                | "pause"
                | "evaluate"
                | "setVariable"
                | "setExpression"
        );
        let (client, drives) = match &self.attachment {
            Some(attachment) => (attachment.client, attachment.drives),
            None => (0, false),
        };
        if drives_only && client > 0 && !drives {
            let error = text!(
                "this debugger only looks on; attach with \"drive\": true to drive",
                "此调试器只旁观；要控制请以 \"drive\": true 连接"
            );
            return Some(Some(Err(error)));
        }
        let nothing = |()| json!({});
        Some(Some(match command {
            "attach" => self.attach(arguments).map(nothing),
            "launch" => Err(text!(
                "this controller serves: attach to it",
                "此控制器在提供服务：请连接到它"
            )),
            "stepBack" | "reverseContinue" | "gotoCycle" | "restartFrame" => Err(text!(
                "{command}: a program on a running server goes forward only; open its recording to go back",
                "{command}：运行中服务器上的程序只能前进；要后退请打开其记录"
            )),
            "restart" | "terminate" => Err(text!(
                "{command}: programs are started and stopped at the server's ports; disconnect leaves it running",
                "{command}：程序由服务器的端口启动和停止；disconnect 会让它继续运行"
            )),
            "configurationDone" => Ok(json!({})),
            "disconnect" => {
                self.detach();
                Ok(json!({}))
            }
            "continue" => self
                .go_on(command, arguments)
                .map(|()| json!({"allThreadsContinued": true})),
            "next" | "stepIn" | "stepOut" | "nextNode" => {
                self.go_on(command, arguments).map(nothing)
            }
            "pause" if self.run.is_none() => Err(self.not_watched()),
            "stackTrace" | "scopes" | "variables" | "evaluate" | "setVariable"
            | "setExpression" | "exceptionInfo" => {
                return Some(self.ask_attached(request, arguments));
            }
            "threads" if self.phase == ProgramPhase::Suspended => {
                return Some(self.ask_attached(request, arguments));
            }
            _ => return None,
        }))
    }

    fn not_watched(&self) -> Text {
        match &self.launched {
            None => text!("no program is running", "没有程序在运行"),
            Some(_) => text!(
                "this program had begun before anybody attached, so it has no places to be held at; \
                 start it again to debug it, pause it at the server's ports, \
                 or start the server with --attachable",
                "此程序在有人连接之前已开始，因此没有可停住的位置；请重新启动程序来调试，\
                 在服务器的端口暂停它，或以 --attachable 启动服务器"
            ),
        }
    }

    fn attach(&mut self, arguments: &Json) -> Result<(), Text> {
        let wants = arguments.get("drive").and_then(Json::as_bool);
        let events = self.events.clone();
        let attachment = self
            .attachment
            .as_mut()
            .ok_or(text!("there is nothing to attach to", "没有可连接的对象"))?;
        if attachment.client > 0 {
            return Err(text!("this debugger is attached already", "此调试器已连接"));
        }
        let drives = wants.unwrap_or(true);
        if drives && !attachment.is_trusted {
            return Err(text!(
                "who drives has to show the token of the server; with \"drive\": false this debugger looks on",
                "要控制必须出示服务器的令牌；以 \"drive\": false 连接可旁观"
            ));
        }
        let (client, begun) = attachment.hub.join(events, drives)?;
        (attachment.client, attachment.drives) = (client, drives);
        let hub = attachment.hub.clone();
        let cannot = json!({
            "supportsStepBack": false,
            "supportsRestartFrame": false,
            "supportsRestartRequest": false,
            "supportTerminateDebuggee": false,
            "supportsTerminateRequest": false,
            "supportsGotoCycleRequest": false,
        });
        self.event("capabilities", json!({ "capabilities": cannot }));
        if drives {
            hub.set_breakpoints(Arc::new(self.breakpoints.clone()));
        }
        self.program_begun(begun);
        Ok(())
    }

    /// What the program was asked and has not answered is refused: it runs, and may never be held again.
    fn refuse_asked(&mut self) {
        let Some(attachment) = &mut self.attachment else {
            return;
        };
        for (_, request) in std::mem::take(&mut attachment.asks) {
            let error = text!(
                "{}: the program went on before it had answered",
                "{}：程序在回答之前已继续运行",
                request.1
            );
            self.respond(&request, Err(error));
        }
    }

    /// A program begins, or the one that ran has ended.
    pub(super) fn program_begun(&mut self, begun: Option<ProgramStarted>) {
        self.refuse_asked();
        self.run = None;
        self.launched = None;
        self.phase = ProgramPhase::Before;
        let Some(begun) = begun else {
            self.output(
                "console",
                &text!("no program is running\n", "没有程序在运行\n"),
                0,
            );
            return;
        };
        let program = ProgramText {
            name: begun.name.to_string(),
            text: begun.text.to_string(),
        };
        let file = SourceFile::new(program.name.clone(), program.text.clone());
        self.generation = begun.generation;
        self.launched = Some(LaunchedProgram::of_another(
            program,
            breakpoint_locations(&file),
        ));
        self.phase = ProgramPhase::Running;
        let name = begun.name.to_string();
        self.event("process", json!({"name": name, "startMethod": "attach"}));
        match begun.watched {
            Some(watched) => self.run = Some(Run::attached(watched.link, watched.orders)),
            None => {
                let text = self.not_watched();
                self.output("important", &text!("{text}\n", "{text}\n"), 0);
            }
        }
        // Those of the program before are no places of this one.
        self.breakpoints.places.clear();
        self.bind_sources();
        self.changed();
        if let Some(attachment) = self.attachment.as_ref().filter(|a| a.drives()) {
            attachment.hub.mark_ready(self.generation);
        }
        if let Some(held) = begun.held {
            self.threads = held.threads;
            self.stopped(held.thread, held.why, held.position);
        }
    }

    fn go_on(&mut self, command: &str, arguments: &Json) -> Result<(), Text> {
        if self.run.is_none() {
            return Err(self.not_watched());
        }
        self.must_be_held()?;
        let go = self.resume_mode_of(command, arguments)?;
        let attachment = self
            .attachment
            .as_ref()
            .ok_or(text!("there is nothing to attach to", "没有可连接的对象"))?;
        attachment.hub.go(attachment.client, go)?;
        self.phase = ProgramPhase::Running;
        Ok(())
    }

    /// The driver has let the program go on.
    pub(super) fn continued(&mut self) {
        self.phase = ProgramPhase::Running;
        self.refuse_asked();
        let thread = u64::from(self.thread) + 1;
        self.event(
            "continued",
            json!({"threadId": thread, "allThreadsContinued": true}),
        );
    }

    fn ask_attached(
        &mut self,
        request: &RequestId,
        arguments: &Json,
    ) -> Option<Result<Json, Text>> {
        if self.run.is_none() {
            return Some(Err(self.not_watched()));
        }
        if let Err(error) = self.must_be_held() {
            return Some(Err(error));
        }
        let Some(attachment) = &mut self.attachment else {
            return Some(Err(text!(
                "there is nothing to attach to",
                "没有可连接的对象"
            )));
        };
        if attachment.asks.len() >= ASKS_MAX {
            return Some(Err(text!(
                "{ASKS_MAX} questions wait for an answer already",
                "已有 {ASKS_MAX} 个问题在等待回答"
            )));
        }
        attachment.last_ask = (attachment.last_ask + 1) & 0x7fff_ffff;
        let number = attachment.last_ask;
        attachment.asks.insert(number, request.clone());
        let order = RunCommand::Ask {
            request: (
                i64::from(attachment.client) << 32 | number,
                request.1.clone(),
            ),
            command: request.1.clone(),
            arguments: arguments.clone(),
            language: self.language,
        };
        if self.run.as_ref().is_some_and(|run| run.order(order)) {
            return None;
        }
        attachment.asks.remove(&number);
        Some(Err(text!(
            "{}: the program takes no questions just now",
            "{}：程序此刻不接受提问",
            request.1
        )))
    }

    /// To which request of the client an answer is; None where that was refused meanwhile.
    pub(super) fn asked_as(&mut self, request: &RequestId) -> Option<RequestId> {
        match &mut self.attachment {
            Some(attachment) => attachment.asks.remove(&(request.0 & 0xffff_ffff)),
            None => self.own_asked(request),
        }
    }

    fn detach(&mut self) {
        self.refuse_asked();
        if let Some(attachment) = &mut self.attachment
            && attachment.client > 0
        {
            attachment.hub.leave(attachment.client);
            attachment.client = 0;
        }
        self.run = None;
    }
}
