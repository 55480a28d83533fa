//! `_process`: other processes and signals. `subprocess`, `signal` and parts of `os` are scripts on top.
//!
//! Nothing here is reached without the permission `process`. Signals that a program sends to itself never reach the
//! controller: they are delivered to the handlers of the program, on its main thread.

use std::io;
use std::rc::Rc;

use super::define::{MethodDef, ModuleBuilder, instance, with_data};
use super::files::FileBuffer as FileStream;
use super::system::{os_error, os_error_about, require};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::host::process::{HostProcess, HostProcesses, OutputStream, ProcessCommand, StdioTarget};
use crate::host::{Capability, ThreadId};
use crate::value::data::no_values;
use crate::value::{Bytes, R, Value};

/// Most bytes taken from a pipe at once.
const READ_MAX: usize = 1 << 20;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("identity", "what /", |ev, args| {
            let what = ev.str(&args[0])?;
            let numbers = processes(ev, &what)?.identity();
            let numbers = numbers.map(|number| Value::Int(i64::from(number)));
            Ok(Value::tuple(numbers.to_vec()))
        }),
        ("kill", "process signal group /", |ev, args| {
            let host = processes(ev, "os.kill")?;
            let number = |value| -> R<i32> {
                i32::try_from(ev.index(value)?).map_err(|_| {
                    ev.raise(
                        ExceptionKind::OverflowError,
                        "signed integer is out of range",
                    )
                })
            };
            let (process, signal) = (number(&args[0])?, number(&args[1])?);
            let sent = if ev.truth(&args[2])? {
                host.signal_group(process, signal)
            } else {
                host.signal(process, signal)
            };
            sent.map(|()| Value::None)
                .map_err(|error| os_error(ev, &error))
        }),
        ("interrupt", "function args /", |ev, args| {
            require(ev, Capability::Processes, "signals")?;
            let args_of_call = ev.collect(&args[1])?;
            ev.core.interrupt_main(args[0].clone(), args_of_call.into());
            Ok(Value::None)
        }),
        ("is_main", "", |ev, _| {
            Ok(Value::Bool(ev.core.is_main_thread()))
        }),
        ("pause", "", |ev, _| {
            require(ev, Capability::Processes, "signal.pause")?;
            super::thread::park(ev, None).map(|()| Value::None)
        }),
        (
            "spawn",
            "words folder environment input output errors /",
            spawn,
        ),
    ]);
    module.class("Process", None, METHODS);
    Ok(())
}

// What the host has started.
no_values!(Rc<dyn HostProcess>);

fn processes<'e>(ev: &'e Evaluator<'_>, what: &str) -> R<&'e dyn HostProcesses> {
    require(ev, Capability::Processes, what)?;
    ev.core
        .host
        .processes()
        .ok_or_else(|| ev.raise(ExceptionKind::OSError, "this host has no processes"))
}

fn text(ev: &Evaluator<'_>, value: &Value) -> R<String> {
    match value.as_str() {
        Some(text) if text.contains('\0') => Err(ev.value_error("embedded null byte")),
        Some(text) => Ok(text.to_owned()),
        None => {
            let name = ev.core.types.name_of(value);
            Err(ev.type_error(format!(
                "expected str, bytes or os.PathLike object, not {name}"
            )))
        }
    }
}

/// A standard stream: one of the words of `subprocess`, or an open file.
fn stream(ev: &Evaluator<'_>, value: &Value) -> R<StdioTarget> {
    Ok(match value.as_str() {
        Some("pipe") => StdioTarget::Pipe,
        Some("null") => StdioTarget::Null,
        Some("output") => StdioTarget::WithOutput,
        Some(_) => StdioTarget::Inherit,
        None => {
            let file = with_data(ev, value, |file: &Rc<FileStream>| Ok(file.clone()))?;
            file.flush(ev)?;
            let copy = file.host(ev)?.duplicate();
            StdioTarget::File(copy.map_err(|error| os_error(ev, &error))?)
        }
    })
}

fn spawn(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let host = processes(ev, "subprocess")?;
    let words = ev.collect(&args[0])?;
    let words: Vec<String> = words.iter().map(|word| text(ev, word)).collect::<R<_>>()?;
    if words.is_empty() {
        return Err(ev.raise(ExceptionKind::IndexError, "list index out of range"));
    }
    let environment = match &args[2] {
        Value::Dict(dict) => {
            let entries = dict.entries().into_iter();
            let pairs = entries.map(|(_, key, value)| Ok((text(ev, &key)?, text(ev, &value)?)));
            Some(pairs.collect::<R<_>>()?)
        }
        _ => None,
    };
    let folder = match &args[1] {
        Value::None => None,
        value => Some(text(ev, value)?),
    };
    let command = ProcessCommand {
        words,
        folder,
        environment,
        input: stream(ev, &args[3])?,
        output: stream(ev, &args[4])?,
        errors: stream(ev, &args[5])?,
    };
    let name = command.words[0].clone();
    let process = host.spawn(command);
    let process = process.map_err(|error| os_error_about(ev, &error, &[Value::str(name)]))?;
    instance(ev, "_process.Process", process)
}

fn with_process(
    ev: &Evaluator<'_>,
    args: &[Value],
    inner: impl FnOnce(&dyn HostProcess) -> io::Result<Value>,
) -> R {
    let process = with_data(ev, &args[0], |process: &Rc<dyn HostProcess>| {
        Ok(process.clone())
    })?;
    match inner(&*process) {
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(Value::None),
        result => result.map_err(|error| os_error(ev, &error)),
    }
}

const METHODS: &[MethodDef] = &[
    ("number", "", |ev, args| {
        with_process(ev, args, |process| {
            Ok(Value::Int(i64::from(process.number())))
        })
    }),
    ("ended", "", |ev, args| {
        with_process(ev, args, |process| {
            let code = process
                .exit_status()
                .map(|code| Value::Int(i64::from(code)));
            Ok(code.unwrap_or(Value::None))
        })
    }),
    ("signal", "signal /", |ev, args| {
        let signal = ev.index(&args[1])?;
        with_process(ev, args, |process| {
            let signal = i32::try_from(signal).unwrap_or(-1);
            process.signal(signal).map(|()| Value::None)
        })
    }),
    // Bytes that are there; None while there are none, empty at the end.
    ("read", "errors most /", |ev, args| {
        let stream = if ev.truth(&args[1])? {
            OutputStream::Errors
        } else {
            OutputStream::Output
        };
        let most = usize::try_from(ev.clamped_index(&args[2])?).unwrap_or(READ_MAX);
        let most = most.min(READ_MAX);
        ev.check_allocation(most)?;
        with_process(ev, args, |process| {
            let data = process.read(stream, most)?;
            Ok(Value::Bytes(Rc::new(Bytes::new(data))))
        })
    }),
    // How many bytes were taken; None while there is no room.
    ("write", "data start /", |ev, args| {
        let Some(data) = ev.bytes_like(&args[1]) else {
            let name = ev.core.types.name_of(&args[1]);
            return Err(ev.type_error(format!("a bytes-like object is required, not '{name}'")));
        };
        let start = usize::try_from(ev.index(&args[2])?).unwrap_or(0);
        let rest = data.get(start..).unwrap_or_default();
        with_process(ev, args, |process| {
            process.write(rest).map(|count| Value::Int(count as i64))
        })
    }),
    ("close_input", "", |ev, args| {
        with_process(ev, args, |process| {
            process.close_input();
            Ok(Value::None)
        })
    }),
    ("news", "", |ev, args| {
        with_process(ev, args, |process| Ok(Value::Int(process.news() as i64)))
    }),
    // Waits until there are more news than `seen`, or the time has come.
    ("wait", "seen until /", |ev, args| {
        let (seen, until) = (ev.index(&args[1])?, args[2].as_f64());
        let process = with_data(ev, &args[0], |process: &Rc<dyn HostProcess>| {
            Ok(process.clone())
        })?;
        super::thread::check_may_wait(ev)?;
        if process.news() as i64 == seen {
            process.watch(ThreadId(ev.core.thread.get()));
            super::thread::park(ev, until)?;
        }
        Ok(Value::None)
    }),
];
