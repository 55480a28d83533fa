//! A session: requests of the client in, responses and events out, and the run between them.
//!
//! Owns what the client was told and what it asked for. Everything about a held program is answered on the program's
//! own thread (`inspect`); here is what goes on between runs: launching, breakpoints, going back.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::Duration;

use elite_runtime::{ProgramText, TaskEnd};
use elite_syntax::SourceFile;
use elite_syntax::{BreakpointLocation, breakpoint_locations};
use messages::{Language, Text, text};
use serde_json::{Value as Json, json};
use supervision::ThreadSupervisor;

use super::attached_session::Attachment;
use super::bodies::{StoppedEvent, ThreadRow, ThreadsResponse, body_of};
use super::breakpoints::{Breakpoints, expression, same_path};
use super::remote_attach::{ConnectFn, RemoteSink};
use super::reverse::ReverseState;
use super::run::{Run, RunStart, RunTarget};
use super::run_channel::{
    Purpose, RequestId, ResumeMode, RunCommand, RunEvent, SessionEvent, SuspendReason,
};
use super::run_position::{Intervention, Position};
use super::stream::{DapInput, MessageSink};

/// A run that was given up has so long to end when the session does.
const LEAVING_MAX: Duration = Duration::from_secs(5);

/// The breakpoints that the client wants in one text.
#[derive(Clone)]
pub(super) struct WantedSource {
    /// The file as the client names it.
    pub(super) path: PathBuf,
    /// Arguments of the request.
    pub(super) arguments: Json,
    /// The numbers that the client knows them by, in the order of the request.
    pub(super) ids: Vec<Option<u64>>,
}

/// Makes a robot and a program from the arguments of `launch`; a sentence where they are no good.
pub type Launch<'l> = dyn Fn(&Json) -> Result<RunTarget, Text> + 'l;

/// The program that was launched.
pub(super) struct LaunchedProgram {
    /// Text of the program.
    pub program: ProgramText,
    /// Source of the run; none where another controller runs the program.
    what: Option<RunTarget>,
    pub path: PathBuf,
    pub places: Vec<BreakpointLocation>,
    /// The text on the disk is the one that runs.
    pub(super) is_on_disk: bool,
    stop_on_entry: bool,
    stop_at_end: bool,
    /// The program is launched without debugging (`noDebug`).
    pub(super) is_free: bool,
}

impl LaunchedProgram {
    /// A program that runs elsewhere.
    pub(super) fn of_another(program: ProgramText, places: Vec<BreakpointLocation>) -> Self {
        Self {
            path: same_path(program.name.as_ref()),
            program,
            what: None,
            places,
            is_on_disk: false,
            stop_on_entry: false,
            stop_at_end: false,
            is_free: false,
        }
    }
}

/// What the program does, as far as the client knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProgramPhase {
    /// The program has not begun.
    Before,
    /// The program runs.
    Running,
    /// A run is being repeated; the client believes that it runs.
    Repeating,
    /// The program is held.
    Suspended,
    /// The program has ended.
    Over,
}

/// A session with one client.
pub(crate) struct DapSession<'s> {
    pub(super) out: &'s mut dyn MessageSink,
    pub(super) launch: &'s Launch<'s>,
    pub(super) faults: ThreadSupervisor,
    pub(super) events: SyncSender<SessionEvent>,
    pub(super) seq: i64,
    pub(super) phase: ProgramPhase,
    pub(super) launched: Option<LaunchedProgram>,
    pub(super) run: Option<Run>,
    given_up: Vec<supervision::ThreadHandle<()>>,
    pub(super) generation: u64,
    pub(super) position: Position,
    pub(super) thread: u32,
    pub(super) breakpoints: Breakpoints,
    pub(super) last_id: u64,
    pub(super) interventions: Vec<Intervention>,
    /// Number of the program's outputs that the client has seen.
    seen: u64,
    pub(super) backwards: Option<ReverseState>,
    /// Where a breakpoint held last before the present place, if that is known.
    pub(super) last_met: Option<Option<(Position, SuspendReason)>>,
    /// Lines and columns begin at 0 where the client counts so.
    pub(super) first_line: i64,
    pub(super) first_column: i64,
    pub(super) wanted_sources: Vec<WantedSource>,
    /// The latest of each other kind of breakpoints, for a controller elsewhere that is attached to afterwards.
    pub(super) wanted_others: BTreeMap<String, Json>,
    configured: bool,
    pub(super) is_done: bool,
    exit_code: i64,
    /// How `attach` finds a controller elsewhere.
    pub(super) attach: Option<&'s ConnectFn<'s>>,
    /// Everything goes there, once it has.
    pub(super) outbox: Option<RemoteSink>,
    /// `initialize` has come, with these arguments.
    is_greeted: bool,
    pub(super) greeting: Json,
    /// The language of the client: that of its locale.
    pub(super) language: Language,
    /// The threads of the held program.
    pub(super) threads: Vec<u32>,
    /// Requests that the held program has not answered yet.
    asked: Vec<RequestId>,
    /// What it is attached to, if it is.
    pub(super) attachment: Option<Attachment>,
    /// `launch`, until it is answered.
    launch_request: Option<(i64, String)>,
}

impl<'s> DapSession<'s> {
    pub(crate) fn new(
        out: &'s mut dyn MessageSink,
        launch: &'s Launch<'s>,
        events: SyncSender<SessionEvent>,
    ) -> Self {
        let breakpoints = Breakpoints {
            uncaught: true,
            ..Breakpoints::default()
        };
        Self {
            out,
            launch,
            faults: ThreadSupervisor::default(),
            events,
            seq: 0,
            phase: ProgramPhase::Before,
            launched: None,
            run: None,
            given_up: Vec::new(),
            generation: 0,
            position: Position::default(),
            thread: 0,
            breakpoints,
            last_id: 0,
            interventions: Vec::new(),
            seen: 0,
            backwards: None,
            last_met: None,
            first_line: 1,
            first_column: 1,
            wanted_sources: Vec::new(),
            wanted_others: BTreeMap::new(),
            configured: false,
            is_done: false,
            exit_code: 0,
            attach: None,
            outbox: None,
            is_greeted: false,
            greeting: json!({}),
            language: Language::English,
            threads: Vec::new(),
            asked: Vec::new(),
            attachment: None,
            launch_request: None,
        }
    }

    /// Takes what has come in.
    pub(crate) fn handle_event(&mut self, note: SessionEvent) {
        match note {
            SessionEvent::Run(generation, event) => self.handle_run_event(generation, *event),
            SessionEvent::Begun(begun) => self.program_begun(begun.map(|begun| *begun)),
            SessionEvent::Remote(message) => self.take_remote(message),
            SessionEvent::Said(category, text) => self.output(category, &text, 0),
            SessionEvent::Gone(reason) => {
                if let Some(reason) = reason {
                    tracing::warn!("{reason}");
                }
                self.is_done = true;
            }
            SessionEvent::Client(DapInput::Garbage(why)) => {
                let text = text!("a message is no JSON: {why}\n", "消息不是 JSON：{why}\n");
                self.output("important", &text, 0);
            }
            SessionEvent::Client(DapInput::Message(message)) => match &self.outbox {
                Some(outbox) => {
                    if !outbox(&message) {
                        let text = text!(
                            "the controller takes nothing any more\n",
                            "控制器不再接收任何内容\n"
                        );
                        self.output("important", &text, 0);
                        self.is_done = true;
                    }
                }
                None => self.take_message(&message),
            },
        }
    }

    fn take_message(&mut self, message: &Json) {
        let seq = message.get("seq").and_then(Json::as_i64).unwrap_or(0);
        match message.get("type").and_then(Json::as_str) {
            Some("request") => {}
            // Nothing is asked of the client.
            Some("response" | "event") => return,
            _ => {
                let command = message.get("command").and_then(Json::as_str);
                let result = Err(text!(
                    "a message that is no request; allowed is \"type\": \"request\"",
                    "消息不是请求；应为 \"type\": \"request\""
                ));
                return self.respond(&(seq, command.unwrap_or_default().to_owned()), result);
            }
        }
        let Some(command) = message.get("command").and_then(Json::as_str) else {
            let result = Err(text!("a request without a command", "没有 command 的请求"));
            return self.respond(&(seq, String::new()), result);
        };
        let arguments = match message.get("arguments") {
            None | Some(Json::Null) => json!({}),
            Some(given) => given.clone(),
        };
        let request = (seq, command.to_owned());
        if let Some(result) = self.request(&request, &arguments) {
            self.respond(&request, result);
        }
        self.after_response(command);
    }

    /// What follows a response.
    fn after_response(&mut self, command: &str) {
        match command {
            "initialize" => self.event("initialized", json!({})),
            "disconnect" => self.is_done = true,
            _ => {}
        }
    }

    /// Whether a request can be one of this session at all, now.
    fn may_be_asked(&self, command: &str, arguments: &Json) -> Result<(), Text> {
        if !self.is_greeted && !matches!(command, "initialize" | "disconnect") {
            return Err(text!(
                "{command} came before initialize, which begins a session",
                "{command} 早于 initialize，而会话由后者开始"
            ));
        }
        super::arguments::check(command, arguments)?;
        let text = |key: &str| {
            arguments
                .get(key)
                .and_then(Json::as_str)
                .unwrap_or_default()
        };
        // Only the console takes statements, which change the program.
        match command {
            "evaluate" if text("context") != "repl" => expression(
                &Text::fixed("expression", "expression "),
                text("expression"),
            )
            .map_err(|error| {
                text!(
                    "evaluate: {error}; only the debug console takes statements",
                    "evaluate：{error}；只有调试控制台接受语句"
                )
            }),
            "setVariable" | "setExpression" => {
                expression(&Text::fixed("value", "value "), text("value"))
                    .map_err(|error| text!("{command}: {error}", "{command}：{error}"))
            }
            _ => Ok(()),
        }
    }

    /// The body of the response; None where it comes later.
    fn request(&mut self, request: &(i64, String), arguments: &Json) -> Option<Result<Json, Text>> {
        if let Err(error) = self.may_be_asked(&request.1, arguments) {
            return Some(Err(error));
        }
        if let Some(result) = self.attached_request(request, arguments) {
            return result;
        }
        if matches!(
            request.1.as_str(),
            "setFunctionBreakpoints" | "setExceptionBreakpoints" | "setDataBreakpoints"
        ) {
            let wanted = arguments.clone();
            self.wanted_others.insert(request.1.clone(), wanted);
        }
        Some(match request.1.as_str() {
            "initialize" => Ok(self.initialize(arguments)),
            "launch" => {
                if let Err(error) = self.launch_program(arguments) {
                    return Some(Err(error));
                }
                // Answered when the client has said what it wants the program to be held for.
                self.launch_request = Some(request.clone());
                self.begin_if_ready();
                return None;
            }
            "attach" => return self.attach_elsewhere(request, arguments),
            "configurationDone" => {
                self.configured = true;
                self.respond(request, Ok(json!({})));
                self.begin_if_ready();
                return None;
            }
            "setBreakpoints" => self.set_source_breakpoints(arguments),
            "setFunctionBreakpoints" => self.set_function_breakpoints(arguments),
            "setExceptionBreakpoints" => self.set_exception_breakpoints(arguments),
            "dataBreakpointInfo" => Ok(self.data_breakpoint_info(arguments)),
            "setDataBreakpoints" => self.set_data_breakpoints(arguments),
            "breakpointLocations" => self.breakpoint_locations(arguments),
            "source" => self.source(),
            "loadedSources" => {
                let sources: Vec<Json> = self.launched.iter().map(|_| self.source_body()).collect();
                Ok(json!({ "sources": sources }))
            }
            "threads" if self.phase != ProgramPhase::Suspended => Ok(body_of(&ThreadsResponse {
                threads: vec![ThreadRow::new(0, self.language)],
            })),
            "continue" | "next" | "stepIn" | "stepOut" | "nextNode" => {
                self.go(&request.1, arguments)
            }
            "pause" => self.pause(),
            "stepBack" | "restartFrame" => return self.begin_back(request, arguments),
            "reverseContinue" => self.reverse_continue(arguments),
            "gotoCycle" => self.go_to_cycle(arguments),
            "restart" => self.restart(arguments),
            "terminate" if self.launched.is_none() => {
                Err(text!("no program was launched", "没有启动程序"))
            }
            "terminate"
                if let (Some(run), ProgramPhase::Running | ProgramPhase::Suspended) =
                    (&self.run, self.phase) =>
            {
                run.stop();
                // What is asked of it meanwhile has no answer; the end of the program follows.
                self.phase = ProgramPhase::Running;
                Ok(json!({}))
            }
            "terminate" => {
                self.end_run();
                self.respond(request, Ok(json!({})));
                self.tell_end(None);
                return None;
            }
            "disconnect" => {
                self.end_run();
                Ok(json!({}))
            }
            "threads" | "stackTrace" | "scopes" | "variables" | "evaluate" | "setVariable"
            | "setExpression" | "exceptionInfo" => return self.ask(request, arguments),
            other => Err(text!(
                "the request {other:?} is not known here",
                "此处没有请求 {other:?}"
            )),
        })
    }

    fn initialize(&mut self, arguments: &Json) -> Json {
        let is_zero = |key: &str| arguments.get(key).and_then(Json::as_bool) == Some(false);
        self.first_line = i64::from(!is_zero("linesStartAt1"));
        self.first_column = i64::from(!is_zero("columnsStartAt1"));
        let locale = arguments.get("locale").and_then(Json::as_str);
        self.language = locale.map_or(Language::English, Language::of_locale);
        self.greeting = arguments.clone();
        self.is_greeted = true;
        super::capabilities::capabilities()
    }

    fn launch_program(&mut self, arguments: &Json) -> Result<(), Text> {
        if self.launched.is_some() {
            return Err(text!(
                "a program was launched already; restart runs it again",
                "已启动了程序；restart 重新运行它"
            ));
        }
        let what = (self.launch)(arguments)?;
        let flag = |key: &str| arguments.get(key).and_then(Json::as_bool) == Some(true);
        let file = SourceFile::new(what.program.name.clone(), what.program.text.clone());
        let on_disk = kinematics::text_file::read_text_file(Path::new(&what.program.name));
        self.launched = Some(LaunchedProgram {
            is_on_disk: on_disk.is_ok_and(|text| text == what.program.text),
            path: same_path(what.program.name.as_ref()),
            program: what.program.clone(),
            places: breakpoint_locations(&file),
            stop_on_entry: flag("stopOnEntry") && !flag("noDebug"),
            stop_at_end: flag("stopAtEnd") && !flag("noDebug"),
            is_free: flag("noDebug"),
            what: Some(what),
        });
        Ok(())
    }

    fn begin_if_ready(&mut self) {
        if !self.configured || self.launched.is_none() {
            return;
        }
        let Some(request) = self.launch_request.take() else {
            return;
        };
        self.bind_sources();
        let stop_on_entry = self.launched.as_ref().is_some_and(|l| l.stop_on_entry);
        self.respond(&request, Ok(json!({})));
        let name = self.launched.as_ref().map(|l| l.program.name.clone());
        self.event("process", json!({"name": name, "startMethod": "launch"}));
        self.start(Purpose::Run { stop_on_entry });
        self.phase = ProgramPhase::Running;
    }

    /// Gives the present run up and starts the next one.
    pub(super) fn start(&mut self, purpose: Purpose) {
        self.drop_run();
        self.generation += 1;
        let Some(launched) = &self.launched else {
            return;
        };
        let Some(what) = &launched.what else {
            return;
        };
        let start = RunStart {
            generation: self.generation,
            purpose,
            interventions: self.interventions.clone(),
            stop_at_end: launched.stop_at_end,
            seen: self.seen,
            breakpoints: Arc::new(match launched.is_free {
                true => Breakpoints::default(),
                false => self.breakpoints.clone(),
            }),
            events: self.events.clone(),
        };
        match Run::start(&self.faults, what, start) {
            Ok(run) => self.run = Some(run),
            Err(error) => {
                let text = text!(
                    "cannot start a thread: {error}\n",
                    "无法启动线程：{error}\n"
                );
                self.output("stderr", &text, 0);
                self.tell_end(None);
            }
        }
    }

    /// Lets the present run end by itself. What it was asked and has not answered is refused.
    fn drop_run(&mut self) {
        for request in std::mem::take(&mut self.asked) {
            let error = text!(
                "{}: the program went on before it had answered",
                "{}：程序在回答之前已继续运行",
                request.1
            );
            self.respond(&request, Err(error));
        }
        if let Some(run) = self.run.take() {
            self.given_up.extend(run.give_up());
        }
        self.given_up
            .retain(|handle| !handle.end_signal().is_ended());
    }

    fn end_run(&mut self) {
        if let Some(request) = self.launch_request.take() {
            let error = text!(
                "launch: the session ended before configurationDone",
                "launch：会话在 configurationDone 之前结束"
            );
            self.respond(&request, Err(error));
        }
        self.drop_run();
        self.generation += 1;
    }

    /// The session is over: what it started ends with it.
    pub(crate) fn leave(&mut self, drain: &mut dyn FnMut()) {
        self.end_run();
        let until = std::time::Instant::now() + LEAVING_MAX;
        while std::time::Instant::now() < until
            && self
                .given_up
                .iter()
                .any(|handle| !handle.end_signal().is_ended())
        {
            drain();
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Lets a held program go on.
    fn go(&mut self, command: &str, arguments: &Json) -> Result<Json, Text> {
        self.must_be_held()?;
        let go = self.resume_mode_of(command, arguments)?;
        if let Some(run) = &self.run {
            // A program that has ended meanwhile takes no order; its end is told.
            run.order(RunCommand::Go(go));
        }
        self.phase = ProgramPhase::Running;
        Ok(match go {
            ResumeMode::Free => json!({"allThreadsContinued": true}),
            _ => json!({}),
        })
    }

    /// How a request lets the program go on.
    pub(super) fn resume_mode_of(
        &self,
        command: &str,
        arguments: &Json,
    ) -> Result<ResumeMode, Text> {
        let thread = self.thread_of(arguments)?;
        Ok(match command {
            "next" => ResumeMode::Next(thread),
            "stepIn" => ResumeMode::StepIn(thread),
            "stepOut" => ResumeMode::Out(thread),
            "nextNode" => ResumeMode::Node(thread),
            _ => ResumeMode::Free,
        })
    }

    /// The thread that a request names; the one that is held where it names none.
    pub(super) fn thread_of(&self, arguments: &Json) -> Result<u32, Text> {
        match arguments.get("threadId").and_then(Json::as_u64) {
            None => Ok(self.thread),
            Some(id) => thread_of(id, &self.threads),
        }
    }

    pub(super) fn must_be_held(&self) -> Result<(), Text> {
        match self.phase {
            ProgramPhase::Suspended => Ok(()),
            ProgramPhase::Before => Err(text!("no program was launched", "没有启动程序")),
            ProgramPhase::Running | ProgramPhase::Repeating => {
                Err(text!("the program is running", "程序正在运行"))
            }
            ProgramPhase::Over => Err(text!("the program has ended", "程序已结束")),
        }
    }

    fn pause(&mut self) -> Result<Json, Text> {
        match (self.phase, &self.run) {
            (ProgramPhase::Running, Some(run)) => {
                run.pause();
                Ok(json!({}))
            }
            (ProgramPhase::Repeating | ProgramPhase::Suspended, _) => Ok(json!({})),
            _ => Err(text!("no program is running", "没有程序在运行")),
        }
    }

    /// Hands a question on to the held program.
    fn ask(&mut self, request: &(i64, String), arguments: &Json) -> Option<Result<Json, Text>> {
        if let Err(error) = self.must_be_held() {
            return Some(Err(error));
        }
        self.order(request, request.1.clone(), arguments)
    }

    /// Asks the held program; None: the answer comes later.
    pub(super) fn order(
        &mut self,
        request: &RequestId,
        command: String,
        arguments: &Json,
    ) -> Option<Result<Json, Text>> {
        let order = RunCommand::Ask {
            request: request.clone(),
            command,
            arguments: arguments.clone(),
            language: self.language,
        };
        match &self.run {
            Some(run) if run.order(order) => {
                self.asked.push(request.clone());
                None
            }
            _ => Some(Err(text!(
                "{}: the program takes no questions just now",
                "{}：程序此刻不接受提问",
                request.1
            ))),
        }
    }

    /// Takes what the run tells.
    pub(crate) fn handle_run_event(&mut self, generation: u64, event: RunEvent) {
        if generation != self.generation {
            return;
        }
        match event {
            RunEvent::Stopped {
                thread,
                threads,
                why,
                position,
                last,
            } => {
                self.last_met = last;
                self.threads = threads;
                self.stopped(thread, why, position);
            }
            RunEvent::Continued => self.continued(),
            RunEvent::Answer { request, result } => {
                // Whoever was refused meanwhile has its answer.
                if let Some(request) = self.asked_as(&request) {
                    self.answered(&request, result);
                }
            }
            RunEvent::Changed(what) => {
                // What was done at later places belongs to a run that is given up now.
                self.interventions
                    .retain(|known| known.moment <= what.moment);
                self.interventions.push(what);
                // From here on the program goes another way: what it says is new.
                if let Some(run) = &self.run {
                    self.seen = run.forget_what_follows();
                }
            }
            RunEvent::Output {
                category,
                text,
                line,
            } => self.output(category, &text, line),
            RunEvent::Said(number, category, text, line) => {
                self.seen = self.seen.max(number);
                self.output(category, &text, line);
            }
            RunEvent::Thread { number, is_there } => {
                let reason = if is_there { "started" } else { "exited" };
                let id = u64::from(number) + 1;
                self.event("thread", json!({"reason": reason, "threadId": id}));
            }
            RunEvent::Scanned(found) => self.scanned(found),
            RunEvent::Raised { moment, why } => self.show_exception(moment, why),
            RunEvent::Ended(end) => self.ended(end),
        }
    }

    pub(super) fn stopped(&mut self, thread: u32, why: SuspendReason, position: Position) {
        self.phase = ProgramPhase::Suspended;
        self.position = position;
        self.thread = thread;
        let event = StoppedEvent {
            reason: why.reason,
            thread_id: u64::from(thread) + 1,
            all_threads_stopped: true,
            hit_breakpoint_ids: why.ids,
            cycle: position.cycle,
            statement: position.tick,
            description: why
                .description
                .map(|text| text.in_language(self.language).to_owned()),
            text: why
                .text
                .map(|text| text.in_language(self.language).to_owned()),
        };
        self.event("stopped", body_of(&event));
    }

    /// The request of this session that the program has answered; None where it was refused meanwhile.
    pub(super) fn own_asked(&mut self, request: &RequestId) -> Option<RequestId> {
        let index = self.asked.iter().position(|asked| asked == request)?;
        Some(self.asked.remove(index))
    }

    fn answered(&mut self, request: &(i64, String), result: Result<Json, Text>) {
        if self.is_own_question(request) {
            return self.go_back(request, result);
        }
        let result = result.map(|body| self.with_source(&request.1, body));
        self.respond(request, result);
    }

    /// Frames name the text they are in, and count lines as the client does.
    fn with_source(&self, command: &str, mut body: Json) -> Json {
        if command != "stackTrace" {
            return body;
        }
        let source = self.source_body();
        let frames = body.get_mut("stackFrames").and_then(Json::as_array_mut);
        for frame in frames.into_iter().flatten().filter_map(Json::as_object_mut) {
            frame.insert("source".to_owned(), source.clone());
            for (key, first) in [
                ("line", self.first_line),
                ("endLine", self.first_line),
                ("column", self.first_column),
                ("endColumn", self.first_column),
            ] {
                if let Some(number) = frame.get(key).and_then(Json::as_i64) {
                    frame.insert(key.to_owned(), json!(number - 1 + first));
                }
            }
        }
        body
    }

    fn ended(&mut self, end: Option<TaskEnd>) {
        self.exit_code = match end {
            Some(TaskEnd::Finished) => 0,
            Some(TaskEnd::NotCompiled) => 2,
            _ => 1,
        };
        self.drop_run();
        self.tell_end(Some(self.exit_code));
    }

    pub(super) fn tell_end(&mut self, code: Option<i64>) {
        if self.phase == ProgramPhase::Over {
            return;
        }
        self.phase = ProgramPhase::Over;
        if let Some(code) = code {
            self.event("exited", json!({"exitCode": code}));
        }
        self.event("terminated", json!({}));
    }

    /// Runs the program anew, from its beginning.
    fn restart(&mut self, arguments: &Json) -> Result<Json, Text> {
        if self.launched.is_none() {
            return Err(text!("no program was launched", "没有启动程序"));
        }
        // The text may have changed on the disk meanwhile.
        let again = arguments.get("arguments").filter(|given| given.is_object());
        if let Some(given) = again {
            let before = self.launched.take();
            if let Err(error) = self.launch_program(given) {
                self.launched = before;
                return Err(error);
            }
            self.bind_sources();
        }
        self.interventions.clear();
        self.seen = 0;
        let stop_on_entry = self.launched.as_ref().is_some_and(|l| l.stop_on_entry);
        self.start(Purpose::Run { stop_on_entry });
        self.phase = ProgramPhase::Running;
        Ok(json!({}))
    }
}

/// The thread with this number of the protocol, among those that there are; a program at its end still has its main
/// one.
pub(super) fn thread_of(id: u64, threads: &[u32]) -> Result<u32, Text> {
    let number = id
        .checked_sub(1)
        .and_then(|number| u32::try_from(number).ok());
    let main = [0];
    let threads = if threads.is_empty() { &main } else { threads };
    match number.filter(|number| threads.contains(number)) {
        Some(number) => Ok(number),
        None => {
            let known: Vec<String> = threads
                .iter()
                .map(|n| (u64::from(*n) + 1).to_string())
                .collect();
            Err(text!(
                "threadId {id}: there is no such thread; the program has {}",
                "threadId {id}：没有这个线程；程序有 {}",
                known.join(", ")
            ))
        }
    }
}
