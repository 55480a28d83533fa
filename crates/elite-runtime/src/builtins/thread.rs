//! Manual 9.1: script threads.

use elite_lang::{ExceptionKind, Unwind, Value};
use motion_api::ThreadNumber;

use super::call::Call;
use super::declare::{Builtin, Category, Parameter, ParameterDefault, ParameterType};
use crate::task::{ThreadLookup, Wait};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "start_thread",
        section: "9.1.1",
        category: Category::Thread,
        summary: "Runs a function in a new script thread.",
        params: &[
            Parameter {
                name: "function",
                aliases: &["fundef"],
                kind: ParameterType::Function,
                default: ParameterDefault::Required,
                unit: "",
                meaning: "what the thread runs",
            },
            Parameter {
                name: "args",
                aliases: &["arg"],
                kind: ParameterType::Arguments,
                default: ParameterDefault::EmptyTuple,
                unit: "",
                meaning: "positional arguments",
            },
            Parameter {
                name: "detach_mode",
                aliases: &[],
                kind: ParameterType::Boolean,
                default: ParameterDefault::Boolean(true),
                unit: "",
                meaning: "True: the thread's entry is given back when it ends; False: when it is joined. Joining \
                          works either way",
            },
        ],
        returns: "the thread's handle, an int from 1",
        waits: false,
        run: Some(start_thread),
    },
    Builtin {
        name: "join_thread",
        section: "9.1.2",
        category: Category::Thread,
        summary: "Waits until a script thread has ended.",
        params: &[HANDLE],
        returns: "nothing",
        waits: true,
        run: Some(join_thread),
    },
    Builtin {
        name: "stop_thread",
        section: "9.1.3",
        category: Category::Thread,
        summary: "Stops a script thread; its finally and with blocks still run.",
        params: &[HANDLE],
        returns: "nothing",
        waits: false,
        run: Some(stop_thread),
    },
];

const HANDLE: Parameter = Parameter {
    name: "thread_id",
    aliases: &[],
    kind: ParameterType::ThreadHandle,
    default: ParameterDefault::Required,
    unit: "",
    meaning: "handle from start_thread; 0 means no thread and is accepted",
};

fn start_thread(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    // Statements that name it are discarded at the port; this one came by way of a function of the program.
    if call.origin().thread == ThreadNumber(0) && call.context().interpreter().is_executing() {
        let text = "start_thread() is not supported in interpreter mode";
        return Err(call.error(ExceptionKind::RuntimeError, text));
    }
    let function = call.required(0);
    if !function.is_callable() {
        let text = format!(
            "start_thread(): function must be a function, not {}",
            function.type_name()
        );
        return Err(call.error(ExceptionKind::TypeError, text));
    }
    let args = match call.given(1).cloned() {
        None => Vec::new(),
        Some(value) => match value.as_items() {
            Some(items) => items,
            None => {
                let text = format!(
                    "start_thread(): args must be a tuple or a list, not {}",
                    value.type_name()
                );
                return Err(call.error(ExceptionKind::TypeError, text));
            }
        },
    };
    // Joining works on detached threads too (the vendor's control script relies on it), so the mode changes nothing
    // that a program could see; it is still checked for its type.
    call.boolean(2)?;
    let node = call.native().node();
    match call.context().start_thread(function, args, node) {
        Ok(number) => Ok(Value::Int(i64::from(number.0))),
        Err(refused) => Err(call.error(
            ExceptionKind::RuntimeError,
            format!("start_thread(): {refused}"),
        )),
    }
}

fn join_thread(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let Some(number) = handle(call, "join_thread")? else {
        return Ok(Value::None);
    };
    if number == call.origin().thread {
        let text = format!(
            "join_thread(): thread {} cannot wait for its own end",
            number.0
        );
        return Err(call.error(ExceptionKind::RuntimeError, text));
    }
    call.wait(Wait::Thread(number))?;
    Ok(Value::None)
}

fn stop_thread(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let Some(number) = handle(call, "stop_thread")? else {
        return Ok(Value::None);
    };
    let own = number == call.origin().thread;
    call.context().request_thread_stop(number);
    // A thread is stopped between two slices: what the caller does next finds its motion braked.
    call.wait(if own { Wait::Never } else { Wait::Turn })?;
    Ok(Value::None)
}

/// The thread a handle names, `None` when there is nothing to do: handle 0, or a thread that has ended.
fn handle(call: &mut Call<'_, '_>, function: &str) -> Result<Option<ThreadNumber>, Unwind> {
    let value = call.required(0);
    let Some(number) = value.as_i64() else {
        let text = format!(
            "{function}(): thread_id must be a handle from start_thread, not {}",
            value.type_name()
        );
        return Err(call.error(ExceptionKind::TypeError, text));
    };
    if number == 0 {
        return Ok(None);
    }
    match u32::try_from(number).map(|n| (n, call.context().find_thread(ThreadNumber(n)))) {
        Ok((n, ThreadLookup::Running)) => Ok(Some(ThreadNumber(n))),
        Ok((_, ThreadLookup::Ended)) => Ok(None),
        Ok((_, ThreadLookup::Unknown)) | Err(_) => {
            let text =
                format!("{function}(): thread_id {number} was never returned by start_thread");
            Err(call.error(ExceptionKind::ValueError, text))
        }
    }
}
