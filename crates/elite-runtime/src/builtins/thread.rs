//! Manual 9.1: script threads.

use elite_lang::{ExceptionKind, Unwind, Value};
use messages::text;
use motion_api::ThreadNumber;

use super::call::Call;
use super::declare::{Builtin, Category, Parameter, ParameterDefault, ParameterType, phrase};
use crate::task::{ThreadLookup, Wait};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "start_thread",
        section: "9.1.1",
        category: Category::Thread,
        summary: phrase(
            "Runs a function in a new script thread.",
            "在新的脚本线程中运行函数。",
        ),
        params: &[
            Parameter {
                name: "function",
                aliases: &["fundef"],
                kind: ParameterType::Function,
                default: ParameterDefault::Required,
                unit: "",
                meaning: phrase("what the thread runs", "线程执行的函数"),
            },
            Parameter {
                name: "args",
                aliases: &["arg"],
                kind: ParameterType::Arguments,
                default: ParameterDefault::EmptyTuple,
                unit: "",
                meaning: phrase("positional arguments", "位置参数"),
            },
            Parameter {
                name: "detach_mode",
                aliases: &[],
                kind: ParameterType::Boolean,
                default: ParameterDefault::Boolean(true),
                unit: "",
                meaning: phrase(
                    "True: the thread's entry is given back when it ends; False: when it is \
                     joined. Joining works either way",
                    "True：线程结束时释放其记录；False：join 时释放。两种情况下都可以 join",
                ),
            },
        ],
        returns: phrase(
            "the thread's handle, an int from 1",
            "线程句柄，从 1 开始的 int",
        ),
        waits: false,
        run: Some(start_thread),
    },
    Builtin {
        name: "join_thread",
        section: "9.1.2",
        category: Category::Thread,
        summary: phrase(
            "Waits until a script thread has ended.",
            "等待脚本线程结束。",
        ),
        params: &[HANDLE],
        returns: phrase("nothing", "无返回值"),
        waits: true,
        run: Some(join_thread),
    },
    Builtin {
        name: "stop_thread",
        section: "9.1.3",
        category: Category::Thread,
        summary: phrase(
            "Stops a script thread; its finally and with blocks still run.",
            "停止脚本线程；其 finally 和 with 块仍会执行。",
        ),
        params: &[HANDLE],
        returns: phrase("nothing", "无返回值"),
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
    meaning: phrase(
        "handle from start_thread; 0 means no thread and is accepted",
        "start_thread 返回的句柄；0 表示没有线程，可以接受",
    ),
};

fn start_thread(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    // Statements that name it are discarded at the port; this one came by way of a function of the program.
    if call.origin().thread == ThreadNumber(0) && call.context().interpreter().is_executing() {
        let text = text!(
            "start_thread() is not supported in interpreter mode",
            "解释器模式不支持 start_thread()"
        );
        return Err(call.error(ExceptionKind::RuntimeError, text));
    }
    let function = call.required(0);
    if !function.is_callable() {
        let text = text!(
            "start_thread(): function must be a function, not {}",
            "start_thread()：function 必须是函数，不能是 {}",
            function.type_name()
        );
        return Err(call.error(ExceptionKind::TypeError, text));
    }
    let args = match call.given(1).cloned() {
        None => Vec::new(),
        Some(value) => match value.as_items() {
            Some(items) => items,
            None => {
                let text = text!(
                    "start_thread(): args must be a tuple or a list, not {}",
                    "start_thread()：args 必须是元组或列表，不能是 {}",
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
            text!("start_thread(): {refused}", "start_thread()：{refused}"),
        )),
    }
}

fn join_thread(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let Some(number) = handle(call, "join_thread")? else {
        return Ok(Value::None);
    };
    if number == call.origin().thread {
        let text = text!(
            "join_thread(): thread {} cannot wait for its own end",
            "join_thread()：线程 {} 不能等待自身结束",
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
        let text = text!(
            "{function}(): thread_id must be a handle from start_thread, not {}",
            "{function}()：thread_id 必须是 start_thread 返回的句柄，不能是 {}",
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
            let text = text!(
                "{function}(): thread_id {number} was never returned by start_thread",
                "{function}()：start_thread 从未返回过 thread_id {number}"
            );
            Err(call.error(ExceptionKind::ValueError, text))
        }
    }
}
