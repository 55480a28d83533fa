//! Manual chapter 2: interpreter mode as programs see it.
//!
//! `interpreter_mode()` executes the statements of port 30020 itself, in the scope of its caller, and waits when there
//! are none. The queue, and what ports see of it, is `crate::interpreter`'s.

use elite_lang::{ExceptionKind, Unwind, Value};
use messages::text;
use motion_api::ThreadNumber;

use super::call::Call;
use super::declare::{
    Builtin, Category, Parameter, ParameterDefault, ParameterType, Phrase, phrase,
};
use crate::external::ExternalInputKind;
use crate::interpreter::NextAction;
use crate::message::Message;
use crate::message::{InterpreterEvent, Severity};
use crate::panel::Operator;
use crate::task::Wait;

/// Statements of interpreter mode that are executed before other threads, stop and pause have their turn. A statement
/// that calls or loops passes safepoints of its own; this bound is for long runs of simple ones.
const STATEMENTS_PER_TURN: u32 = 32;

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "interpreter_mode",
        section: "2.3",
        category: Category::Interpreter,
        summary: phrase(
            "Executes statements from port 30020, in the caller's scope, until \
             end_interpreter(). Main thread only.",
            "在调用者的作用域中执行来自端口 30020 的语句，直到 \
             end_interpreter()。只能在主线程中调用。",
        ),
        params: &[
            switch(
                "clearQueueOnEnter",
                phrase(
                    "True: throw away what was queued before; False: execute it",
                    "True：丢弃此前排队的语句；False：继续执行它们",
                ),
            ),
            switch(
                "clearOnEnd",
                phrase(
                    "True: injected functions are removed at the end; False: they stay until the \
                     program ends",
                    "True：退出时删除注入的函数；False：保留到程序结束",
                ),
            ),
        ],
        returns: phrase(
            "nothing; returns after end_interpreter()",
            "无返回值；end_interpreter() 之后返回",
        ),
        waits: true,
        run: Some(interpreter_mode),
    },
    Builtin {
        name: "end_interpreter",
        section: "2.4",
        category: Category::Interpreter,
        summary: phrase(
            "Leaves interpreter mode once the running statement has ended.",
            "正在执行的语句结束后退出解释器模式。",
        ),
        params: &[],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(end_interpreter),
    },
    Builtin {
        name: "clear_interpreter",
        section: "2.5",
        category: Category::Interpreter,
        summary: phrase("Removes the injected functions.", "删除注入的函数。"),
        params: &[],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(clear_interpreter),
    },
];

const fn switch(name: &'static str, meaning: Phrase) -> Parameter {
    Parameter {
        name,
        aliases: &[],
        kind: ParameterType::Boolean,
        default: ParameterDefault::Boolean(true),
        unit: "",
        meaning,
    }
}

fn interpreter_mode(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (clear_queue, clear_on_end) = (call.boolean(0)?, call.boolean(1)?);
    let interpreter = call.context().interpreter();
    if call.origin().thread != ThreadNumber(0) {
        let text = text!(
            "interpreter_mode() can only be called in the main thread",
            "interpreter_mode() 只能在主线程中调用"
        );
        return Err(call.error(ExceptionKind::RuntimeError, text));
    }
    // A thread of the program's own may end the mode; without one the program would wait for ever.
    let is_left_alone = !call.context().has_other_threads();
    if call.context().panel().operator() == Operator::Absent && is_left_alone {
        let text = text!(
            "interpreter_mode(): nobody can send statements here, there is no port 30020; run the program on a \
                    server (eliteserver serve)",
            "interpreter_mode()：这里无法接收语句，没有 30020 端口；请在服务器上运行程序（eliteserver serve）"
        );
        return Err(call.error(ExceptionKind::RuntimeError, text));
    }
    if !interpreter.enter(clear_queue) {
        let text = text!(
            "interpreter_mode() cannot be called inside interpreter mode",
            "interpreter_mode() 不能在解释器模式中调用"
        );
        return Err(call.error(ExceptionKind::RuntimeError, text));
    }
    let observer = call.context().observer();
    observer.interpreter(&InterpreterEvent::Entered);
    let executed = execute_statements(call);
    // The mode is over even when a statement failed or the task is being stopped.
    // What a task leaves that ends goes with the task.
    interpreter.leave(clear_on_end && executed.is_ok());
    if clear_on_end {
        clear(call, false);
    }
    observer.interpreter(&InterpreterEvent::Left);
    executed?;
    Ok(Value::None)
}

fn execute_statements(call: &mut Call<'_, '_>) -> Result<(), Unwind> {
    let (interpreter, observer) = (call.context().interpreter(), call.context().observer());
    let mut executed = 0_u32;
    loop {
        match task_memory::uncounted(|| interpreter.next()) {
            NextAction::End => return Ok(()),
            NextAction::Nothing => call.wait(Wait::Statement)?,
            NextAction::Statement(id, statement) => {
                let text = statement.file().text();
                let lost = text!(
                    "it was given statements at the interpreter port",
                    "它在解释器端口收到了语句"
                );
                call.context().note(ExternalInputKind::Unrecorded(lost));
                observer.interpreter(&InterpreterEvent::Executing { id: id.0, text });
                let result = call.native().run_statement(&statement);
                task_memory::uncounted(|| {
                    // The statement was compiled on the port's thread, so its memory was never counted as the task's.
                    drop(statement);
                    interpreter.finish();
                });
                result?;
                executed += 1;
                if executed.is_multiple_of(STATEMENTS_PER_TURN) {
                    call.wait(Wait::Turn)?;
                }
            }
        }
    }
}

fn end_interpreter(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    if !call.context().interpreter().request_end() {
        let origin = call.origin();
        let text = text!(
            "end_interpreter(): interpreter mode is not active, nothing ends",
            "end_interpreter()：解释器模式未启用，没有可结束的"
        );
        let message = Message::log(Severity::Warning, origin, text);
        call.context().observer().message(&message);
    }
    Ok(Value::None)
}

fn clear_interpreter(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    clear(call, true);
    Ok(Value::None)
}

fn clear(call: &mut Call<'_, '_>, queue: bool) {
    call.native().clear_statements();
    let id = call.context().interpreter().finish_clear(queue);
    let event = InterpreterEvent::Cleared { id: id.0 };
    call.context().observer().interpreter(&event);
}
