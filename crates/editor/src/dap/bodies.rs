//! Bodies of responses and events, in the form of the Debug Adapter Protocol. Lines and columns count as the client
//! does.

use messages::{Language, text};
use serde::Serialize;
use serde_json::Value as Json;

/// A body as a message carries it.
pub(super) fn body_of(body: &impl Serialize) -> Json {
    // Structs with text keys and finite numbers always have a form in JSON.
    serde_json::to_value(body).unwrap_or_default()
}

/// A breakpoint as the debugger has bound it, or why it has not.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct BoundBreakpoint {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) id: Option<u64>,
    verified: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<String>,
}

impl BoundBreakpoint {
    /// A breakpoint that is in force without a place in the text: on a function, or on a value of the arm.
    pub(super) fn verified(id: u64) -> Self {
        Self {
            id: Some(id),
            verified: true,
            ..Self::default()
        }
    }

    /// A breakpoint that is in force at a statement.
    pub(super) fn at(id: u64, place: SourcePlace) -> Self {
        Self {
            line: Some(place.line),
            column: Some(place.column),
            ..Self::verified(id)
        }
    }

    /// A breakpoint that is not in force; the message says why.
    pub(super) fn refused(id: Option<u64>, message: impl Into<String>) -> Self {
        Self {
            id,
            message: Some(message.into()),
            ..Self::default()
        }
    }
}

/// Response to `setBreakpoints` and its siblings.
#[derive(Debug, Serialize)]
pub(super) struct BreakpointsResponse {
    pub(super) breakpoints: Vec<BoundBreakpoint>,
}

/// Event `breakpoint`.
#[derive(Debug, Serialize)]
pub(super) struct BreakpointEvent {
    pub(super) reason: &'static str,
    pub(super) breakpoint: BoundBreakpoint,
}

/// A place in a text.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct SourcePlace {
    pub(super) line: i64,
    pub(super) column: i64,
}

/// Response to `breakpointLocations`.
#[derive(Debug, Serialize)]
pub(super) struct LocationsResponse {
    pub(super) breakpoints: Vec<SourcePlace>,
}

/// Response to `dataBreakpointInfo`.
#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DataBreakpointInfo {
    /// `null` where no breakpoint can be on it.
    pub(super) data_id: Option<String>,
    pub(super) description: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) access_types: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) can_persist: Option<bool>,
}

/// A thread of the program.
#[derive(Debug, Serialize)]
pub(super) struct ThreadRow {
    pub(super) id: u64,
    pub(super) name: String,
}

impl ThreadRow {
    /// The thread of a number of the language: 0 is the main program, and secondary programs have the highest bit. A
    /// client knows it by the next number, because 0 is none.
    pub(super) fn new(number: u32, language: Language) -> Self {
        let name = match number {
            0 => text!("main program", "主程序"),
            n if n >= 1 << 31 => text!("secondary program", "次要程序"),
            n => text!("thread {n}", "线程 {n}"),
        };
        Self {
            id: u64::from(number) + 1,
            name: name.in_language(language).to_owned(),
        }
    }
}

/// Response to `threads`.
#[derive(Debug, Serialize)]
pub(super) struct ThreadsResponse {
    pub(super) threads: Vec<ThreadRow>,
}

/// A call under way.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct StackFrame {
    pub(super) id: usize,
    pub(super) name: String,
    pub(super) line: u32,
    pub(super) column: u32,
    pub(super) end_line: u32,
    pub(super) end_column: u32,
    pub(super) can_restart: bool,
}

/// Response to `stackTrace`.
#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct StackTraceResponse {
    pub(super) stack_frames: Vec<StackFrame>,
    pub(super) total_frames: usize,
}

/// A group of variables.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Scope {
    pub(super) name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) presentation_hint: Option<&'static str>,
    pub(super) variables_reference: usize,
    pub(super) expensive: bool,
}

/// Response to `scopes`.
#[derive(Debug, Serialize)]
pub(super) struct ScopesResponse {
    pub(super) scopes: Vec<Scope>,
}

/// What a value consists of, for whoever wants to open it.
#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ValueParts {
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    pub(super) type_name: Option<String>,
    /// 0: it has no parts.
    pub(super) variables_reference: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) indexed_variables: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) named_variables: Option<usize>,
}

/// A value and its text. `evaluate` calls the text a result, everything else a value.
#[derive(Debug, Default)]
pub(super) struct ShownValue {
    pub(super) text: String,
    pub(super) parts: ValueParts,
}

impl ShownValue {
    /// A text without parts.
    pub(super) fn text(text: String) -> Self {
        Self {
            text,
            ..Self::default()
        }
    }

    /// Response to `evaluate`.
    pub(super) fn evaluated(self) -> Json {
        body_of(&EvaluateResponse {
            result: self.text,
            parts: self.parts,
        })
    }

    /// Response to `setVariable` and `setExpression`.
    pub(super) fn assigned(self) -> Json {
        body_of(&AssignResponse {
            value: self.text,
            parts: self.parts,
        })
    }

    /// A variable with this value; `path` is an expression that evaluates to it.
    pub(super) fn named(self, name: String, path: Option<String>) -> Variable {
        Variable {
            name,
            value: self.text,
            parts: self.parts,
            evaluate_name: path,
            presentation_hint: None,
        }
    }
}

#[derive(Debug, Serialize)]
struct EvaluateResponse {
    result: String,
    #[serde(flatten)]
    parts: ValueParts,
}

#[derive(Debug, Serialize)]
struct AssignResponse {
    value: String,
    #[serde(flatten)]
    parts: ValueParts,
}

/// A variable, or a part of a value.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Variable {
    name: String,
    value: String,
    #[serde(flatten)]
    parts: ValueParts,
    #[serde(skip_serializing_if = "Option::is_none")]
    evaluate_name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    presentation_hint: Option<PresentationHint>,
}

impl Variable {
    /// A copy of the variable that tells the client not to offer a change.
    pub(super) fn read_only(self) -> Self {
        Self {
            presentation_hint: Some(PresentationHint {
                attributes: ["readOnly"],
            }),
            ..self
        }
    }
}

#[derive(Debug, Serialize)]
struct PresentationHint {
    attributes: [&'static str; 1],
}

/// Response to `variables`.
#[derive(Debug, Serialize)]
pub(super) struct VariablesResponse {
    pub(super) variables: Vec<Variable>,
}

/// Response to `exceptionInfo`.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ExceptionInfo {
    pub(super) exception_id: Option<String>,
    pub(super) description: Option<String>,
    pub(super) break_mode: &'static str,
}

/// Event `stopped`, with the cycle and the number of the statement beside what the protocol has.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct StoppedEvent {
    pub(super) reason: &'static str,
    pub(super) thread_id: u64,
    pub(super) all_threads_stopped: bool,
    pub(super) hit_breakpoint_ids: Vec<u64>,
    pub(super) cycle: u64,
    pub(super) statement: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) description: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) text: Option<String>,
}

/// Event `output`.
#[derive(Debug, Serialize)]
pub(super) struct OutputEvent<'t> {
    pub(super) category: &'t str,
    pub(super) output: &'t str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) source: Option<Json>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) line: Option<i64>,
}
