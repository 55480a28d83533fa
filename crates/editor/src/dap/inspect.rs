//! What a held program is asked: its calls, its variables, texts to evaluate. Runs on the program's thread.

use elite_lang::ThreadId;
use elite_lang::Value;
use elite_lang::debug::{ChildFilter, ChildValue, PausedProgram};
use messages::{Language, Text, text};
use serde::Deserialize;
use serde_json::{Value as Json, json};

use super::bodies::{
    ExceptionInfo, Scope, ScopesResponse, ShownValue, StackFrame, StackTraceResponse, ThreadRow,
    ThreadsResponse, ValueParts, Variable, VariablesResponse, body_of,
};
use super::probe::Probe;
use super::robot_scope::{RobotVariable, items};
use super::run_channel::RequestId;
use super::run_position::Intervention;
use super::session::thread_of;

/// Most things that are listed at once.
const PAGE_MAX: usize = 10_000;
/// Most references that are given out while a program is held.
const REFERENCES_MAX: usize = 1_000_000;
/// Longest text that is copied.
const COPY_MAX: usize = 1 << 20;
/// The call whose variables are the globals, whatever is running.
pub(super) const GLOBALS: usize = usize::MAX;

/// What a number stands for that the client was given.
#[derive(Clone)]
pub(super) enum ReferenceTarget {
    Locals {
        thread: u32,
        call: usize,
    },
    Globals,
    Arm,
    Parts(RobotVariable),
    Value {
        value: Value,
        thread: u32,
        call: usize,
        /// An expression for it.
        path: Option<String>,
    },
}

/// The numbers that the client was given since the program was held.
#[derive(Default)]
pub(crate) struct ReferenceTable {
    calls: Vec<(u32, usize)>,
    referred: Vec<ReferenceTarget>,
}

impl ReferenceTable {
    pub(crate) fn clear(&mut self) {
        let old = std::mem::take(self);
        drop(old);
    }

    fn refer(&mut self, what: ReferenceTarget) -> usize {
        if self.referred.len() >= REFERENCES_MAX {
            return 0;
        }
        self.referred.push(what);
        self.referred.len()
    }

    fn call(&mut self, thread: u32, call: usize) -> usize {
        let known = self.calls.iter().position(|known| *known == (thread, call));
        let index = known.unwrap_or_else(|| {
            self.calls.push((thread, call));
            self.calls.len() - 1
        });
        index + 1
    }
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct InspectArguments {
    pub(super) thread_id: Option<u64>,
    pub(super) start_frame: usize,
    pub(super) levels: usize,
    pub(super) frame_id: Option<usize>,
    pub(super) variables_reference: usize,
    pub(super) filter: String,
    pub(super) start: usize,
    pub(super) count: usize,
    pub(super) name: String,
    pub(super) value: String,
    pub(super) expression: String,
    pub(super) context: String,
}

impl Probe {
    /// The answer to a request about the held program; None: it comes later.
    pub(super) fn answer(
        &self,
        halt: &PausedProgram<'_>,
        holder: Option<ThreadId>,
        request: &RequestId,
        command: &str,
        arguments: &Json,
        language: Language,
    ) -> Option<Result<Json, Text>> {
        let asked: InspectArguments = match serde_json::from_value(arguments.clone()) {
            Ok(asked) => asked,
            Err(error) => return Some(Err(text!("{command}: {error}", "{command}：{error}"))),
        };
        match command {
            "evaluate" | "setExpression" | "setVariable" => {
                let done = match command {
                    "evaluate" => self.evaluated(halt, holder, request, &asked),
                    "setVariable" => self.set_variable(halt, holder, request, &asked),
                    _ => self.set_expression(halt, holder, request, &asked),
                };
                done.transpose()
            }
            "threads" => Some(Ok(self.threads_body(language))),
            "stackTrace" => Some(self.stack_trace(halt, &asked)),
            "scopes" => Some(self.scopes(halt, &asked, language)),
            "variables" => Some(self.variables(halt, &asked)),
            "exceptionInfo" => Some(self.exception_info(&asked, language)),
            "back" => Some(self.back(halt, &asked)),
            "frameStart" => Some(self.frame_start(halt, &asked)),
            _ => Some(Err(text!(
                "{command} is not known here",
                "此处没有 {command}"
            ))),
        }
    }

    fn threads_body(&self, language: Language) -> Json {
        let row = |number: u32| ThreadRow::new(number, language);
        let mut threads: Vec<ThreadRow> = self.threads().iter().map(|(n, _)| row(*n)).collect();
        if threads.is_empty() {
            threads.push(row(0));
        }
        body_of(&ThreadsResponse { threads })
    }

    /// The thread that the client means; the held one where it names none.
    fn number_of(&self, asked: &InspectArguments) -> Result<u32, Text> {
        let Some(id) = asked.thread_id else {
            return Ok(self.held.get());
        };
        let threads: Vec<u32> = self.threads().into_iter().map(|(n, _)| n).collect();
        thread_of(id, &threads)
    }

    fn stack_trace(
        &self,
        halt: &PausedProgram<'_>,
        asked: &InspectArguments,
    ) -> Result<Json, Text> {
        let number = self.number_of(asked)?;
        let Some(thread) = self.thread(number) else {
            return Ok(body_of(&StackTraceResponse::default()));
        };
        let calls = halt.calls(thread);
        let levels = match asked.levels {
            0 => PAGE_MAX,
            levels => levels,
        };
        let mut table = self.table.borrow_mut();
        let page = calls
            .iter()
            .enumerate()
            .skip(asked.start_frame)
            .take(levels);
        let frames = page.map(|(index, call)| {
            let end = call.site.file.position(call.site.span.end);
            StackFrame {
                id: table.call(number, index),
                name: call.function.to_string(),
                line: call.site.line,
                column: call.site.column,
                end_line: end.line,
                end_column: end.column,
                can_restart: true,
            }
        });
        let response = StackTraceResponse {
            stack_frames: frames.collect(),
            total_frames: calls.len(),
        };
        Ok(body_of(&response))
    }

    /// The call that the client means; the innermost one of the held thread where it names none.
    pub(super) fn call_of(
        &self,
        halt: &PausedProgram<'_>,
        asked: &InspectArguments,
    ) -> Result<(u32, usize), Text> {
        let held = self.held.get();
        // At the end of a program there is no call whose number could be given.
        let has_calls = || {
            self.thread(held)
                .is_some_and(|thread| !halt.calls(thread).is_empty())
        };
        let id = match asked.frame_id {
            None => return Ok((held, 0)),
            Some(0) if !has_calls() => return Ok((held, 0)),
            Some(id) => id,
        };
        let table = self.table.borrow();
        let index = id.checked_sub(1);
        let known = index.and_then(|index| table.calls.get(index).copied());
        known.ok_or_else(|| {
            text!(
                "frameId {id}: there is no such call; \
                 stackTrace gives the numbers of those that there are while the program is held",
                "frameId {id}：没有这个调用；程序停住时 stackTrace 给出已有调用的编号"
            )
        })
    }

    fn scopes(
        &self,
        halt: &PausedProgram<'_>,
        asked: &InspectArguments,
        language: Language,
    ) -> Result<Json, Text> {
        let (thread, call) = self.call_of(halt, asked)?;
        let id = self.thread(thread).unwrap_or(ThreadId(0));
        let mut scopes = Vec::new();
        let mut table = self.table.borrow_mut();
        let mut add = |name: Text, presentation_hint, target| {
            scopes.push(Scope {
                name: name.in_language(language).to_owned(),
                presentation_hint,
                variables_reference: table.refer(target),
                expensive: false,
            });
        };
        if !halt.has_globals_only(id, call) {
            let locals = ReferenceTarget::Locals { thread, call };
            add(text!("Locals", "局部变量"), Some("locals"), locals);
        }
        add(text!("Globals", "全局变量"), None, ReferenceTarget::Globals);
        add(text!("Arm", "手臂"), None, ReferenceTarget::Arm);
        Ok(body_of(&ScopesResponse { scopes }))
    }

    pub(super) fn referred(&self, reference: usize) -> Result<ReferenceTarget, Text> {
        let table = self.table.borrow();
        let index = reference.checked_sub(1);
        let known = index.and_then(|index| table.referred.get(index).cloned());
        known.ok_or_else(|| {
            text!(
                "variablesReference {reference}: there are no such variables; \
                 scopes, variables and evaluate give the numbers \
                 of those that there are while the program is held",
                "variablesReference {reference}：没有这些变量；程序停住时 scopes、variables 和 evaluate 给出已有变量的编号"
            )
        })
    }

    fn variables(&self, halt: &PausedProgram<'_>, asked: &InspectArguments) -> Result<Json, Text> {
        let count = match asked.count {
            0 => PAGE_MAX,
            count => count.min(PAGE_MAX),
        };
        let page = |all: Vec<(String, Value)>, thread: u32, call: usize| -> Vec<Variable> {
            let page = all.into_iter().skip(asked.start).take(count);
            page.map(|(name, value)| {
                let path = Some(name.clone());
                self.variable(halt, name, value, thread, call, path)
            })
            .collect()
        };
        let variables = match self.referred(asked.variables_reference)? {
            ReferenceTarget::Locals { thread, call } => {
                let id = self.thread(thread).unwrap_or(ThreadId(0));
                page(halt.locals(id, call), thread, call)
            }
            ReferenceTarget::Globals => page(halt.globals(), self.held.get(), GLOBALS),
            ReferenceTarget::Arm => {
                let state = self.task.state();
                let items = items(&state, &self.way());
                let page = items.into_iter().skip(asked.start).take(count);
                page.map(|item| self.arm_variable(item)).collect()
            }
            ReferenceTarget::Parts(item) => {
                let parts = item.parts.iter().enumerate();
                let page = parts.skip(asked.start).take(count);
                let part = |(index, text): (usize, &String)| {
                    let value = ShownValue::text(text.clone());
                    value.named(format!("[{index}]"), None).read_only()
                };
                page.map(part).collect()
            }
            ReferenceTarget::Value {
                value,
                thread,
                call,
                path,
            } => {
                let which = match asked.filter.as_str() {
                    "indexed" => ChildFilter::Indexed,
                    "named" => ChildFilter::Named,
                    _ => ChildFilter::Both,
                };
                let children = halt.children(&value, which, asked.start, count);
                let shown = children.into_iter().map(|child| {
                    let ChildValue {
                        name,
                        suffix,
                        value,
                    } = child;
                    let path = match (&path, suffix) {
                        (Some(path), Some(suffix)) => Some(format!("{path}{suffix}")),
                        _ => None,
                    };
                    self.variable(halt, name, value, thread, call, path)
                });
                shown.collect()
            }
        };
        Ok(body_of(&VariablesResponse { variables }))
    }

    fn arm_variable(&self, item: RobotVariable) -> Variable {
        let (name, text) = (item.name.clone(), item.text.clone());
        let count = item.parts.len();
        let reference = match count {
            0 => 0,
            _ => self.table.borrow_mut().refer(ReferenceTarget::Parts(item)),
        };
        let value = ShownValue {
            text,
            parts: ValueParts {
                variables_reference: reference,
                indexed_variables: Some(count),
                ..ValueParts::default()
            },
        };
        value.named(name, None).read_only()
    }

    fn variable(
        &self,
        halt: &PausedProgram<'_>,
        name: String,
        value: Value,
        thread: u32,
        call: usize,
        path: Option<String>,
    ) -> Variable {
        let shown = self.shown_value(halt, value, thread, call, path.clone());
        shown.named(name, path)
    }

    pub(super) fn shown_value(
        &self,
        halt: &PausedProgram<'_>,
        value: Value,
        thread: u32,
        call: usize,
        path: Option<String>,
    ) -> ShownValue {
        let shown = self.task.without_motion(|| halt.show(&value));
        let reference = match shown.indexed + shown.named {
            0 => 0,
            _ => self.table.borrow_mut().refer(ReferenceTarget::Value {
                value,
                thread,
                call,
                path,
            }),
        };
        ShownValue {
            text: shown.text,
            parts: ValueParts {
                type_name: Some(shown.type_name),
                variables_reference: reference,
                indexed_variables: Some(shown.indexed),
                named_variables: Some(shown.named),
            },
        }
    }

    /// The body of an evaluation that has ended later.
    pub(super) fn shown(
        &self,
        halt: &PausedProgram<'_>,
        ended: Result<Option<Value>, Text>,
    ) -> Result<Json, Text> {
        let value = ended.map_err(last_line)?;
        let shown = match value {
            None => ShownValue::default(),
            Some(value) => self.shown_value(halt, value, self.held.get(), 0, None),
        };
        Ok(shown.evaluated())
    }

    fn evaluated(
        &self,
        halt: &PausedProgram<'_>,
        holder: Option<ThreadId>,
        request: &RequestId,
        asked: &InspectArguments,
    ) -> Result<Option<Json>, Text> {
        let (number, call) = self.call_of(halt, asked)?;
        let thread = self.thread(number).unwrap_or(ThreadId(0));
        let text = asked.expression.trim();
        if asked.context == "repl" {
            let what = Intervention {
                moment: self.position(halt).moment,
                thread: number,
                call,
                text: text.to_owned(),
                // A recorded arm does what it did, and that of a running server is held.
                may_move: !self.task.is_rerun() && !self.link.is_attached,
            };
            let Some(ended) = self.execute(halt, holder, &what, request) else {
                return Ok(None);
            };
            return match ended {
                Err(report) => Err(report),
                ended => self.shown(halt, ended).map(Some),
            };
        }
        let value = self.evaluate(halt, thread, call, text).map_err(last_line)?;
        let Some(value) = value else {
            return Err(text!(
                "only the debug console takes statements",
                "只有调试控制台接受语句"
            ));
        };
        if asked.context == "clipboard" {
            let text = self
                .task
                .without_motion(|| halt.whole_text(&value, COPY_MAX));
            return Ok(Some(ShownValue::text(text).evaluated()));
        }
        let path = Some(format!("({text})"));
        let shown = self.shown_value(halt, value, number, call, path);
        Ok(Some(shown.evaluated()))
    }

    fn exception_info(&self, asked: &InspectArguments, language: Language) -> Result<Json, Text> {
        self.number_of(asked)?;
        let why = self
            .exception()
            .ok_or(text!("no exception was raised", "没有引发异常"))?;
        Ok(body_of(&ExceptionInfo {
            exception_id: why
                .description
                .map(|text| text.in_language(language).to_owned()),
            description: why.text.map(|text| text.in_language(language).to_owned()),
            break_mode: "always",
        }))
    }

    /// The statement before the one at which a thread stands: of the same call, else the one that made the call.
    fn back(&self, halt: &PausedProgram<'_>, asked: &InspectArguments) -> Result<Json, Text> {
        let number = self.number_of(asked)?;
        let thread = self.thread(number);
        let calls = thread.map(|thread| halt.calls(thread)).unwrap_or_default();
        let position = self.position(halt);
        let tick = match calls.first() {
            // The thread is over: its last statement.
            None => position.tick,
            // The thread is held within a statement: the beginning of that statement.
            Some(call) if self.is_within.get() => call.statement_number,
            Some(call) if call.previous_number > 0 => call.previous_number,
            _ => calls.get(1).map_or(0, |caller| caller.statement_number),
        };
        Ok(json!({"tick": tick, "moment": position.moment, "ticks": position.tick}))
    }

    fn frame_start(
        &self,
        halt: &PausedProgram<'_>,
        asked: &InspectArguments,
    ) -> Result<Json, Text> {
        let (number, call) = self.call_of(halt, asked)?;
        let thread = self.thread(number).unwrap_or(ThreadId(0));
        let calls = halt.calls(thread);
        let call = calls
            .get(call)
            .ok_or(text!("there is no such call any more", "已没有这个调用"))?;
        Ok(json!({"tick": call.first}))
    }
}

/// The last line of a report, which says what was wrong.
pub(super) fn last_line(report: Text) -> Text {
    let [english, chinese] = [Language::English, Language::Chinese].map(|language| {
        let report = report.in_language(language);
        let last = report.trim_end().lines().last();
        last.unwrap_or(report).to_owned()
    });
    Text::new(english, chinese)
}
