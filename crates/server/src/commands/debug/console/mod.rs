//! `eliteserver debug FILE`: the debugger at a terminal, forwards and backwards.
//!
//! Owns the prompt and what is shown. What orders mean is the engine's business (`engine`), which editors use as well;
//! how they are typed is `orders`'.

mod engine;
mod orders;

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::{IsTerminal, Write, stdin, stdout};
use std::path::Path;
use std::rc::Rc;

use messages::{Language, Text, text};
use serde_json::{Value as Json, json};

use super::launch::LaunchRequest;
use crate::cli::DebugArgs;
use crate::command::{CommandResult, CommandStatus};
use crate::commands::line_input::{CompletionNames, InputLine, LineCommands, LineSource};
use crate::language::{self, shown};
use crate::ports::escape::EscapedLine;
use engine::{DebugEngine, EngineEvent};
use orders::{ORDERS, Order, Stop, WORDS, parse};

/// Lines shown before and after the one where the program is.
const AROUND: u32 = 5;
/// Variables of a scope that are shown.
const VARIABLES_MAX: usize = 200;

/// Debugs a program at the terminal, or with orders from a pipe. Exit status: 0 left, 2 the program cannot be started.
pub(super) fn console(args: &DebugArgs, file: &str) -> CommandResult {
    let request = LaunchRequest::from_args(args, Path::new(file));
    let request = request?;
    let mut engine = DebugEngine::start(move |_| request.target())?;
    begin(&mut engine)?;
    let names: BTreeSet<String> = elite_runtime::builtins::names()
        .map(str::to_owned)
        .collect();
    let names: CompletionNames = Rc::new(RefCell::new(names));
    let own = LineCommands {
        history: "debug_history",
        orders: WORDS.iter().map(|word| (*word).to_owned()).collect(),
    };
    let is_terminal = stdin().is_terminal() && stdout().is_terminal();
    let mut lines = LineSource::open(is_terminal, &names, own);
    let mut console = Console {
        engine,
        is_terminal: lines.is_terminal(),
        text: Vec::new(),
        path: file.to_owned(),
        stops: Vec::new(),
        last_number: 0,
        thread: 1,
        frame: None,
        step: 0.004,
        phase: Phase::Running,
        last: Order::Nothing,
    };
    if console.is_terminal {
        show(language::pick(
            "The debugger. help lists the orders, quit leaves; an empty line repeats the last step.",
            "调试器。help 列出命令，quit 退出；空行重复上一步。",
        ));
    }
    console.wait();
    console.load_text();
    console.show_place();
    console.run(&mut lines);
    Ok(CommandStatus::Success)
}

/// Launches the program, held before its first statement.
fn begin(engine: &mut DebugEngine) -> Result<(), Text> {
    let locale = language::pick("en", "zh");
    let about = json!({"adapterID": "eliteserver", "locale": locale});
    engine.ask("initialize", about)?;
    let stops = json!({"stopOnEntry": true, "stopAtEnd": true});
    let launched = engine.send("launch", stops)?;
    let filters = json!({"filters": ["uncaught"]});
    // Refused where the launch was; the answer to that says why.
    let _ = engine.ask("setExceptionBreakpoints", filters);
    let _ = engine.ask("configurationDone", json!({}));
    engine.answer(launched).map(drop)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    Running,
    Held,
    Over,
}

/// Something the program stops for.
struct ActiveStop {
    number: usize,
    stop: Stop,
}

struct Console {
    engine: DebugEngine,
    is_terminal: bool,
    text: Vec<String>,
    path: String,
    stops: Vec<ActiveStop>,
    last_number: usize,
    /// Where the program is held.
    thread: u64,
    frame: Option<(u64, u32)>,
    /// Length of a cycle, s.
    step: f64,
    phase: Phase,
    last: Order,
}

impl Console {
    fn run(&mut self, lines: &mut LineSource) {
        loop {
            let line = match lines.next("(debug) ") {
                InputLine::Text(text) => text,
                InputLine::Interrupt => continue,
                InputLine::TooLong => {
                    show(language::pick("  that line is too long", "  该行太长"));
                    continue;
                }
                InputLine::Broken(error) => {
                    show_text(&text!(
                        "  no more lines can be read: {error}",
                        "  无法继续读取输入：{error}"
                    ));
                    return self.leave();
                }
                InputLine::End => return self.leave(),
            };
            if !self.is_terminal && !line.trim().is_empty() {
                show(&format!("(debug) {}", EscapedLine(line.trim())));
            }
            let order = match parse(&line) {
                Ok(Order::Nothing) if self.is_terminal => self.last.clone(),
                Ok(order) => order,
                Err(error) => {
                    show(&format!("  {}", shown(&error)));
                    continue;
                }
            };
            if order == Order::Quit {
                return self.leave();
            }
            self.last = match &order {
                Order::Go(_) => order.clone(),
                _ => Order::Nothing,
            };
            if let Err(error) = self.carry_out(order) {
                show(&format!("  {}", shown(&error)));
            }
            if self.phase == Phase::Running {
                // The engine has gone.
                return;
            }
        }
    }

    fn leave(&mut self) {
        // It ends with its client, whatever it answers.
        let _ = self.engine.ask("disconnect", json!({}));
    }

    fn carry_out(&mut self, order: Order) -> Result<(), Text> {
        match order {
            Order::Nothing | Order::Quit => Ok(()),
            Order::Help => {
                let width = ORDERS.iter().map(|(order, ..)| order.len()).max();
                for (order, what) in ORDERS {
                    let width = width.unwrap_or(0);
                    show(&format!("  {order:<width$}  {}", shown(what)));
                }
                Ok(())
            }
            Order::Breaks => {
                if self.stops.is_empty() {
                    show(language::pick(
                        "  the program stops for nothing",
                        "  没有停止条件",
                    ));
                }
                for stop in &self.stops {
                    show(&format!(
                        "  {}: {}",
                        stop.number,
                        shown(&described(&stop.stop))
                    ));
                }
                Ok(())
            }
            Order::Break(stop) => {
                self.last_number += 1;
                let number = self.last_number;
                let about = described(&stop);
                self.stops.push(ActiveStop { number, stop });
                if let Err(error) = self.tell_stops() {
                    self.stops.pop();
                    // What was there before is right.
                    let _ = self.tell_stops();
                    return Err(error);
                }
                show(&format!("  {number}: {}", shown(&about)));
                Ok(())
            }
            Order::Delete(number) => {
                let before = self.stops.len();
                self.stops
                    .retain(|stop| number.is_some_and(|number| stop.number != number));
                if let Some(number) = number.filter(|_| self.stops.len() == before) {
                    return Err(text!(
                        "there is no {number}; break lists what there is",
                        "没有 {number}；break 列出已有的停止条件"
                    ));
                }
                self.tell_stops()
            }
            Order::Go(request) => self.go(request, json!({"threadId": self.thread})),
            Order::Until(stop) => self.go_until(stop, "continue"),
            Order::BackUntil(stop) => self.go_until(stop, "reverseContinue"),
            Order::GotoCycle(cycle) => self.go("gotoCycle", json!({"cycle": cycle})),
            Order::GotoTime(time) => {
                // As far as a cycle has begun at that time.
                let cycle = (time / self.step).round() as u64;
                self.go("gotoCycle", json!({"cycle": cycle}))
            }
            Order::Print(expression) => {
                let value = self.evaluate(&expression, "hover")?;
                show(&format!("  {value}"));
                Ok(())
            }
            Order::Statement(statement) => {
                let value = self.evaluate(&statement, "repl")?;
                self.drain();
                if !value.is_empty() {
                    show(&format!("  {value}"));
                }
                Ok(())
            }
            Order::Where => self.show_calls(),
            Order::List(line) => {
                let here = self.frame.map_or(1, |(_, line)| line);
                self.list(line.unwrap_or(here));
                Ok(())
            }
            Order::Scope(name) => self.show_scope(name),
            Order::Restart => {
                self.phase = Phase::Running;
                self.engine.ask("restart", json!({}))?;
                self.wait();
                self.show_place();
                Ok(())
            }
        }
    }

    /// Tells the engine what the program is to stop for.
    fn tell_stops(&mut self) -> Result<(), Text> {
        self.tell_stops_and(None)
    }

    fn tell_stops_and(&mut self, one_more: Option<&Stop>) -> Result<(), Text> {
        let (mut lines, mut functions, mut arm) = (Vec::new(), Vec::new(), Vec::new());
        for stop in self.stops.iter().map(|stop| &stop.stop).chain(one_more) {
            match stop {
                Stop::Line(line, condition) => {
                    lines.push(json!({"line": line, "condition": condition}));
                }
                Stop::Function(name, condition) => {
                    functions.push(json!({"name": name, "condition": condition}));
                }
                Stop::Arm(condition) => arm.push(json!({"dataId": condition})),
            }
        }
        let source = json!({"path": self.path});
        for (request, arguments) in [
            (
                "setBreakpoints",
                json!({"source": source, "breakpoints": without_nulls(lines)}),
            ),
            (
                "setFunctionBreakpoints",
                json!({"breakpoints": without_nulls(functions)}),
            ),
            ("setDataBreakpoints", json!({"breakpoints": arm})),
        ] {
            let answer = self.engine.ask(request, arguments)?;
            let bound = answer.get("breakpoints").and_then(Json::as_array);
            for breakpoint in bound.into_iter().flatten() {
                if breakpoint.get("verified") != Some(&json!(true)) {
                    let why = breakpoint.get("message").and_then(Json::as_str);
                    return Err(match why {
                        Some(why) => Text::verbatim(why.to_owned()),
                        None => text!("there is no such place", "没有这个位置"),
                    });
                }
            }
        }
        Ok(())
    }

    fn go_until(&mut self, stop: Stop, request: &str) -> Result<(), Text> {
        let told = self.tell_stops_and(Some(&stop));
        let gone = told.and_then(|()| self.go(request, json!({"threadId": self.thread})));
        self.tell_stops()?;
        gone
    }

    /// Lets the program go on until it is held again.
    fn go(&mut self, request: &str, arguments: Json) -> Result<(), Text> {
        if self.phase == Phase::Over {
            return Err(text!(
                "the program has ended; restart runs it anew",
                "程序已结束；restart 重新运行"
            ));
        }
        self.engine.ask(request, arguments)?;
        self.phase = Phase::Running;
        self.wait();
        self.show_place();
        Ok(())
    }

    /// Shows what the program prints until it is held, or has ended.
    fn wait(&mut self) {
        while self.phase == Phase::Running {
            match self.engine.event() {
                EngineEvent::Event(name, body) => self.hear(&name, &body),
                EngineEvent::Interrupt => {
                    // Whether it is running still is told by what comes.
                    let _ = self.engine.send("pause", json!({"threadId": self.thread}));
                }
                EngineEvent::Gone => return,
            }
        }
    }

    /// Shows what a statement has printed.
    fn drain(&mut self) {
        while let Some(event) = self.engine.waiting_event() {
            if let EngineEvent::Event(name, body) = event {
                self.hear(&name, &body);
            }
        }
    }

    fn hear(&mut self, name: &str, body: &Json) {
        let text = |key: &str| body.get(key).and_then(Json::as_str).unwrap_or_default();
        match name {
            "output" => {
                let mut out = stdout().lock();
                // Whoever reads may have seen enough.
                let _ = out
                    .write_all(text("output").as_bytes())
                    .and_then(|()| out.flush());
            }
            "stopped" => {
                self.phase = Phase::Held;
                let thread = body.get("threadId").and_then(Json::as_u64);
                self.thread = thread.unwrap_or(1);
                let cycle = body.get("cycle").and_then(Json::as_u64).unwrap_or(0);
                let reason = match (text("reason"), text("description")) {
                    ("step" | "goto", "") => Text::verbatim(""),
                    (reason, "") => text!(": {}", "：{}", reason_text(reason)),
                    ("pause", what) => text!(": {what}", "：{what}"),
                    (reason, what) => text!(": {}: {what}", "：{}：{what}", reason_text(reason)),
                };
                self.frame = None;
                if let Ok(step) = self.evaluate("get_steptime()", "hover") {
                    self.step = step.parse().unwrap_or(self.step);
                }
                let time = cycle as f64 * self.step;
                show_text(&text!(
                    "held in cycle {cycle}, {time:.3} s{reason}",
                    "停在第 {cycle} 个周期，{time:.3} s{reason}"
                ));
                // The sentence of a stop has been said as output.
                let stop = Text::fixed("protective stop", "保护性停止");
                let is_stop = [Language::English, Language::Chinese]
                    .map(|language| stop.in_language(language))
                    .contains(&text("description"));
                if !text("text").is_empty() && !is_stop {
                    show(text("text"));
                }
            }
            "exited" => {
                let code = body.get("exitCode").and_then(Json::as_i64).unwrap_or(0);
                show_text(&text!(
                    "the program has ended, status {code}",
                    "程序已结束，状态 {code}"
                ));
            }
            "terminated" => self.phase = Phase::Over,
            _ => {}
        }
    }

    fn evaluate(&mut self, expression: &str, context: &str) -> Result<String, Text> {
        let mut arguments = json!({"expression": expression, "context": context});
        if let (Some((frame, _)), Json::Object(fields)) = (self.frame, &mut arguments) {
            fields.insert("frameId".to_owned(), json!(frame));
        }
        let answer = self.engine.ask("evaluate", arguments)?;
        let result = answer.get("result").and_then(Json::as_str);
        Ok(result.unwrap_or_default().to_owned())
    }

    fn frames(&mut self) -> Result<Vec<Json>, Text> {
        let asked = json!({"threadId": self.thread});
        let answer = self.engine.ask("stackTrace", asked)?;
        let frames = answer.get("stackFrames").and_then(Json::as_array);
        Ok(frames.cloned().unwrap_or_default())
    }

    /// The statement where the program is.
    fn show_place(&mut self) {
        if self.phase != Phase::Held {
            return;
        }
        let Ok(frames) = self.frames() else { return };
        let Some(frame) = frames.first() else { return };
        let line = frame.get("line").and_then(Json::as_u64).unwrap_or(0) as u32;
        let id = frame.get("id").and_then(Json::as_u64).unwrap_or(0);
        self.frame = Some((id, line));
        show(&self.numbered(line, true));
    }

    fn show_calls(&mut self) -> Result<(), Text> {
        for frame in self.frames()? {
            let line = frame.get("line").and_then(Json::as_u64).unwrap_or(0);
            let name = frame.get("name").and_then(Json::as_str).unwrap_or_default();
            let line = line as u32;
            let text = self.line(line).trim();
            show_text(&text!(
                "  {}, line {line}: {text}",
                "  {}，第 {line} 行：{text}",
                EscapedLine(name)
            ));
        }
        Ok(())
    }

    fn show_scope(&mut self, name: &str) -> Result<(), Text> {
        let Some((frame, _)) = self.frame else {
            return Err(text!("the program is not held", "程序没有停住"));
        };
        let answer = self.engine.ask("scopes", json!({"frameId": frame}))?;
        let scopes = answer.get("scopes").and_then(Json::as_array);
        let of = |wanted: &str| {
            let mut scopes = scopes.into_iter().flatten();
            let scope = scopes.find(|scope| scope.get("name") == Some(&json!(wanted)))?;
            scope.get("variablesReference").and_then(Json::as_u64)
        };
        // At the top level of a program its variables are the globals.
        let reference = of(name).or_else(|| of("Globals"));
        let asked = json!({"variablesReference": reference, "count": VARIABLES_MAX});
        let answer = self.engine.ask("variables", asked)?;
        let variables = answer.get("variables").and_then(Json::as_array);
        for variable in variables.into_iter().flatten() {
            let text = |key: &str| variable.get(key).and_then(Json::as_str).unwrap_or_default();
            let (name, value) = (EscapedLine(text("name")), EscapedLine(text("value")));
            show(&format!("  {name} = {value}"));
        }
        Ok(())
    }

    fn load_text(&mut self) {
        let asked =
            json!({"source": {"path": self.path, "sourceReference": 1}, "sourceReference": 1});
        let Ok(answer) = self.engine.ask("source", asked) else {
            return;
        };
        let text = answer
            .get("content")
            .and_then(Json::as_str)
            .unwrap_or_default();
        self.text = text.lines().map(str::to_owned).collect();
        // A program of a recording is known by the name that its frames give.
        if let Ok(frames) = self.frames()
            && let Some(path) = frames
                .first()
                .and_then(|frame| frame.pointer("/source/path"))
                .and_then(Json::as_str)
        {
            self.path = path.to_owned();
        }
    }

    fn list(&self, line: u32) {
        let here = self.frame.map_or(0, |(_, line)| line);
        let last = u32::try_from(self.text.len()).unwrap_or(u32::MAX);
        for number in line.saturating_sub(AROUND).max(1)..=line.saturating_add(AROUND).min(last) {
            show(&self.numbered(number, number == here));
        }
    }

    fn line(&self, number: u32) -> &str {
        let index = usize::try_from(number).ok().and_then(|n| n.checked_sub(1));
        index
            .and_then(|index| self.text.get(index))
            .map_or("", String::as_str)
    }

    fn numbered(&self, number: u32, is_here: bool) -> String {
        let mark = if is_here { "→" } else { " " };
        let text = EscapedLine(self.line(number)).to_string();
        format!("{mark} {number:4}  {text}").trim_end().to_owned()
    }
}

fn described(stop: &Stop) -> Text {
    let with = |place: Text, condition: &Option<String>| match condition {
        Some(condition) => text!("{place} if {condition}", "{place} if {condition}"),
        None => place,
    };
    match stop {
        Stop::Line(line, condition) => with(text!("line {line}", "第 {line} 行"), condition),
        Stop::Function(name, condition) => with(Text::verbatim(format!("{name}()")), condition),
        Stop::Arm(condition) => text!("when {condition}", "当 {condition}"),
    }
}

/// The reason for a stop in words, from the identifier that the debug adapter protocol has for it.
fn reason_text(reason: &str) -> Text {
    match reason {
        "entry" => text!("before the first statement", "第一条语句之前"),
        "data breakpoint" => text!("the condition is true", "条件成立"),
        "breakpoint" => text!("breakpoint", "断点"),
        "function breakpoint" => text!("function breakpoint", "断点"),
        "exception" => text!("exception", "异常"),
        "pause" => text!("pause", "暂停"),
        "end" => text!("end", "结束"),
        other => Text::verbatim(other.to_owned()),
    }
}

fn without_nulls(breakpoints: Vec<Json>) -> Vec<Json> {
    let cleaned = breakpoints.into_iter().map(|mut breakpoint| {
        if let Json::Object(fields) = &mut breakpoint {
            fields.retain(|_, value| !value.is_null());
        }
        breakpoint
    });
    cleaned.collect()
}

/// A text of the answer, in the language of this process.
fn show_text(text: &Text) {
    show(text.in_language(language::chosen()));
}

/// A line of the answer. Whoever reads may have seen enough.
fn show(line: &str) {
    let mut out = stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
