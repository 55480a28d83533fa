//! Builtins that ask somebody else: what they answer is noted, or comes from the recording.
//!
//! Of calls that answer at once as they did before, with the same arguments, nothing is noted: a program that asks for
//! a register a thousand times a second has one note for each change.

use std::collections::HashMap;

use elite_lang::{ExceptionKind, NativeCall, Unwind, Value};
use messages::text;

use super::rerun::RecordedAnswer;
use super::{ANSWER_BYTES_MAX, CallOutcome, ExternalInputKind, RecordedCall};
use crate::builtins::rpc::{from_rpc, to_rpc};
use crate::task::{TaskContext, Wait};

/// Calls whose answers are remembered, and the longest answer and arguments of them, bytes.
const KNOWN_MAX: usize = 1024;
const KNOWN_BYTES_MAX: usize = 256;

/// The latest answers of calls that answer at once.
#[derive(Default)]
pub(crate) struct AnswerCache(HashMap<String, CallOutcome>);

impl AnswerCache {
    fn note(&mut self, key: Option<String>, answer: &CallOutcome) {
        let Some(key) = key.filter(|_| bytes(answer) <= KNOWN_BYTES_MAX) else {
            return;
        };
        if self.0.len() < KNOWN_MAX || self.0.contains_key(&key) {
            self.0.insert(key, answer.clone());
        }
    }
}

/// Runs a call of a builtin whose answer comes from elsewhere; where a run is repeated, the recording answers.
pub(crate) fn call_external(
    context: &TaskContext,
    native: &mut NativeCall<'_>,
    function: &str,
    arguments: &[Value],
    run: impl FnOnce(&mut NativeCall<'_>) -> Result<Value, Unwind>,
) -> Result<Value, Unwind> {
    if context.is_aside() {
        // A question of a debugger is no part of the run.
        return match context.repeat() {
            None => run(native),
            Some(_) => Err(native.raise(
                ExceptionKind::RuntimeError,
                text!(
                    "{function}(): nobody is there to ask, the run is repeated from a recording",
                    "{function}()：无人可问，运行是按记录重复的"
                ),
            )),
        };
    }
    if let Some(repeat) = context.repeat().cloned() {
        let number = context.next_call();
        let key = key(function, arguments);
        let answered = repeat.recorded_answer(context.program(), number, function);
        return match answered {
            RecordedAnswer::AsBefore => {
                match key.and_then(|key| context.memo().0.get(&key).cloned()) {
                    Some(answer) => apply_recorded(context, native, &answer),
                    None => wait_forever(context, native),
                }
            }
            RecordedAnswer::So(call) => {
                for turn in &call.waits {
                    let token = context.register_wait(Wait::Recorded(*turn));
                    native.wait(token)?;
                }
                if call.waits.is_empty() {
                    context.memo().note(key, &call.answer);
                }
                apply_recorded(context, native, &call.answer)
            }
        };
    }
    if context.witness().is_none() {
        return run(native);
    }
    let number = context.next_call();
    context.log_waits();
    let key = key(function, arguments);
    let result = run(native);
    let waits = context.take_waits();
    let answer = match &result {
        Ok(value) => match to_rpc(native, function, value, 0) {
            Ok(value) => Some(CallOutcome::Value(value)),
            Err(_) => None,
        },
        Err(Unwind::Stop) => Some(CallOutcome::Stopped),
        Err(Unwind::Exception(exception)) => {
            let value = Value::Instance(exception.clone());
            let text = native.str(&value)?;
            let kind = value.type_name().to_string();
            Some(CallOutcome::Raised { kind, text })
        }
    };
    let Some(answer) = answer.filter(|answer| bytes(answer) <= ANSWER_BYTES_MAX) else {
        let text = text!(
            "an answer of {function}() is longer than {ANSWER_BYTES_MAX} bytes",
            "{function}() 的一个回答超过 {ANSWER_BYTES_MAX} 字节"
        );
        context.note(ExternalInputKind::Unrecorded(text));
        return result;
    };
    if waits.is_empty() {
        let is_known = |known: &CallOutcome| is_same(known, &answer);
        let mut memo = context.memo();
        if key
            .as_ref()
            .is_some_and(|key| memo.0.get(key).is_some_and(is_known))
        {
            return result;
        }
        memo.note(key, &answer);
    }
    context.note(ExternalInputKind::Call(RecordedCall {
        number,
        function: function.to_owned(),
        waits,
        answer,
    }));
    result
}

/// The call has not ended in the recording.
fn wait_forever(context: &TaskContext, native: &mut NativeCall<'_>) -> Result<Value, Unwind> {
    let token = context.register_wait(Wait::Never);
    native.wait(token)?;
    Ok(Value::None)
}

fn apply_recorded(
    context: &TaskContext,
    native: &mut NativeCall<'_>,
    answer: &CallOutcome,
) -> Result<Value, Unwind> {
    match answer {
        CallOutcome::Value(value) => Ok(from_rpc(value.clone())),
        CallOutcome::Stopped => wait_forever(context, native),
        CallOutcome::Raised { kind, text } => {
            let kinds = ExceptionKind::ALL.iter();
            let known = kinds.copied().find(|known| known.name() == kind);
            // Builtins raise Python's own exceptions; another one comes from a file that is not ours.
            let kind = known.unwrap_or(ExceptionKind::RuntimeError);
            Err(native.raise(kind, text.clone()))
        }
    }
}

/// A name for a call and its arguments, where they are few and plain.
fn key(function: &str, arguments: &[Value]) -> Option<String> {
    use std::fmt::Write as _;
    let mut key = function.to_owned();
    for argument in arguments {
        // Writing into a text does not fail.
        let _ = match argument {
            Value::None => write!(key, ",None"),
            Value::Bool(level) => write!(key, ",{level}"),
            Value::Int(number) => write!(key, ",{number}"),
            Value::Float(number) => write!(key, ",{:x}", number.to_bits()),
            Value::Unbound => write!(key, ","),
            other => match other.as_str() {
                Some(text) => write!(key, ",{text:?}"),
                None => return None,
            },
        };
    }
    (key.len() <= KNOWN_BYTES_MAX).then_some(key)
}

/// Equal, numbers bit for bit.
fn is_same(a: &CallOutcome, b: &CallOutcome) -> bool {
    // NaN is written as itself, and differs from nothing then.
    a == b || format!("{a:?}") == format!("{b:?}")
}

/// About how many bytes an answer takes in a recording.
fn bytes(answer: &CallOutcome) -> usize {
    use io_bus::xmlrpc::RpcValue as V;
    fn of(value: &V) -> usize {
        8 + match value {
            V::Text(text) => text.len(),
            V::Bytes(bytes) => 2 * bytes.len(),
            V::Array(items) => items.iter().map(of).sum(),
            V::Struct(members) => members
                .iter()
                .map(|(name, value)| name.len() + of(value))
                .sum(),
            V::Nil | V::Bool(_) | V::Int(_) | V::Double(_) => 16,
        }
    }
    match answer {
        CallOutcome::Value(value) => of(value),
        CallOutcome::Raised { kind, text } => kind.len() + text.len(),
        CallOutcome::Stopped => 0,
    }
}
