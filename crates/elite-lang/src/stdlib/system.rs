//! `_system`: what the host lets programs know and do beyond themselves.

use std::io;

use super::define::ModuleBuilder;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::host::Capability;
use crate::value::{R, Unwind, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("require", "word what /", |ev, args| {
            let access = access(ev, &args[0])?;
            let what = ev.str(&args[1])?;
            require(ev, access, &what).map(|()| Value::None)
        }),
        ("environment", "", |ev, _| {
            require(ev, Capability::Environment, "environment variables")?;
            let entries = ev.core.host.environment();
            Ok(Value::dict_of(
                entries
                    .into_iter()
                    .map(|(name, value)| (name, Value::str(value))),
            ))
        }),
        ("random_bytes", "count /", |ev, args| {
            let Ok(count) = usize::try_from(ev.index(&args[0])?) else {
                return Err(ev.value_error("negative argument not allowed"));
            };
            ev.check_allocation(count)?;
            let bytes = (0..count)
                .map(|_| ev.core.host.random_u64() as u8)
                .collect();
            Ok(Value::Bytes(std::rc::Rc::new(crate::value::Bytes::new(
                bytes,
            ))))
        }),
        ("modules", "", |ev, _| {
            Ok(Value::Dict(ev.core.module_table.clone()))
        }),
        ("module_names", "", |_, _| {
            Ok(Value::list(
                elite_syntax::python_names::module_names()
                    .map(Value::str)
                    .collect(),
            ))
        }),
        ("recursion_limit", "", |ev, _| {
            Ok(Value::Int(i64::from(ev.core.limits.call_depth)))
        }),
        ("exception", "", |ev, _| {
            Ok(ev.handled_exception().map_or(Value::None, Value::Instance))
        }),
        ("host_write", "text /", |ev, args| {
            let text = ev.str(&args[0])?;
            ev.core
                .host
                .print(crate::host::ThreadId(ev.core.thread.get()), &text);
            Ok(Value::None)
        }),
    ]);
    Ok(())
}

fn access(ev: &Evaluator<'_>, word: &Value) -> R<Capability> {
    let all = [
        Capability::Files,
        Capability::Processes,
        Capability::Environment,
        Capability::Network,
    ];
    let found = all
        .into_iter()
        .find(|access| word.as_str() == Some(access.word()));
    found.ok_or_else(|| ev.value_error("no such permission"))
}

/// Raises `PermissionError` unless the host permits `access`.
pub(super) fn require(ev: &Evaluator<'_>, access: Capability, what: &str) -> R<()> {
    if ev.core.host.permits(access) {
        return Ok(());
    }
    let text = format!(
        "scripts may not use {what}; start the controller with --allow {}",
        access.word()
    );
    Err(ev.raise(ExceptionKind::PermissionError, text))
}

/// An exception for what the system said.
pub(super) fn os_error(ev: &Evaluator<'_>, error: &io::Error) -> Unwind {
    use io::ErrorKind as Io;
    let kind = match error.kind() {
        Io::ConnectionRefused => ExceptionKind::ConnectionRefusedError,
        Io::ConnectionReset => ExceptionKind::ConnectionResetError,
        Io::ConnectionAborted => ExceptionKind::ConnectionAbortedError,
        Io::BrokenPipe => ExceptionKind::BrokenPipeError,
        Io::PermissionDenied => ExceptionKind::PermissionError,
        Io::TimedOut => ExceptionKind::TimeoutError,
        Io::WouldBlock => ExceptionKind::BlockingIOError,
        Io::NotFound => ExceptionKind::FileNotFoundError,
        Io::AlreadyExists => ExceptionKind::FileExistsError,
        Io::NotADirectory => ExceptionKind::NotADirectoryError,
        Io::IsADirectory => ExceptionKind::IsADirectoryError,
        _ => match error.raw_os_error() {
            Some(3) => ExceptionKind::ProcessLookupError,
            Some(10) => ExceptionKind::ChildProcessError,
            _ => ExceptionKind::OSError,
        },
    };
    let text = error.to_string();
    match error.raw_os_error() {
        Some(number) => {
            let text = text.split(" (os error").next().unwrap_or("").to_owned();
            ev.raise_args(kind, vec![Value::Int(i64::from(number)), Value::str(text)])
        }
        None => ev.raise(kind, text),
    }
}

/// An exception for what the system said about a file, or about two.
pub(super) fn os_error_about(ev: &Evaluator<'_>, error: &io::Error, names: &[Value]) -> Unwind {
    let raised = os_error(ev, error);
    if let Unwind::Exception(exception) = &raised {
        for (attribute, name) in ["filename", "filename2"].iter().zip(names) {
            let attribute = ev.core.symbols.intern(attribute);
            exception.set(attribute, name.clone(), &ev.core.symbols);
        }
    }
    raised
}
