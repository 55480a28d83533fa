//! `_socket`: TCP sockets of the host. Every operation that cannot be served at once parks the script thread, so the
//! others go on; timeouts are in the host's time. `socket` is a script on top.

use std::cell::{Cell, RefCell};
use std::io;
use std::net::{Shutdown, SocketAddr};
use std::rc::Rc;

use super::define::{MethodDef, ModuleBuilder, instance, with_data};
use super::system::os_error;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::host::{Capability, HostSocket, Interest, ThreadId};
use crate::value::bytes::BytesRef;
use crate::value::data::no_values;
use crate::value::{Bytes, R, Unwind, Value};

/// Most bytes one `recv` returns.
const RECEIVE_MAX: usize = 16 << 20;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    let constructor = |ev: &Evaluator<'_>, _: &mut [Value]| {
        super::system::require(ev, Capability::Network, "sockets")?;
        let socket = ev
            .core
            .host
            .open_socket()
            .map_err(|error| os_error(ev, &error))?;
        make(ev, socket)
    };
    module.class("Socket", Some(("", constructor)), METHODS);
    Ok(())
}

/// The data of a socket.
struct Socket {
    host: RefCell<Option<Rc<dyn HostSocket>>>,
    /// Seconds an operation may wait; None for ever.
    timeout: Cell<Option<f64>>,
}

no_values!(Socket);

fn make(ev: &Evaluator<'_>, socket: Rc<dyn HostSocket>) -> R {
    let socket = Socket {
        host: RefCell::new(Some(socket)),
        timeout: Cell::new(None),
    };
    instance(ev, "_socket.Socket", Rc::new(socket))
}

fn closed_error(ev: &Evaluator<'_>) -> Unwind {
    ev.raise_args(
        ExceptionKind::OSError,
        vec![Value::Int(9), Value::str("Bad file descriptor")],
    )
}

/// The socket behind a receiver, with its timeout.
fn open(ev: &Evaluator<'_>, receiver: &Value) -> R<(Rc<dyn HostSocket>, Option<f64>)> {
    with_data(ev, receiver, |socket: &Rc<Socket>| {
        let host = socket.host.borrow().clone();
        host.map(|host| (host, socket.timeout.get()))
            .ok_or_else(|| closed_error(ev))
    })
}

/// Does an operation as soon as it can be done, at most until `deadline`.
fn wait_for<T>(
    ev: &Evaluator<'_>,
    socket: &dyn HostSocket,
    interest: Interest,
    timeout: Option<f64>,
    mut operation: impl FnMut() -> io::Result<T>,
) -> R<T> {
    let deadline = timeout.map(|seconds| ev.core.host.monotonic() + seconds);
    loop {
        match operation() {
            Ok(done) => return Ok(done),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                if timeout == Some(0.0) {
                    let text = Value::str("Resource temporarily unavailable");
                    return Err(
                        ev.raise_args(ExceptionKind::BlockingIOError, vec![Value::Int(11), text])
                    );
                }
                if deadline.is_some_and(|deadline| ev.core.host.monotonic() >= deadline) {
                    return Err(ev.raise(ExceptionKind::TimeoutError, "timed out"));
                }
                super::thread::check_may_wait(ev)?;
                socket.watch(ThreadId(ev.core.thread.get()), interest);
                super::thread::park(ev, deadline)?;
            }
            Err(error) => return Err(os_error(ev, &error)),
        }
    }
}

fn address(socket: SocketAddr) -> Value {
    Value::tuple(vec![
        Value::str(socket.ip().to_string()),
        Value::Int(i64::from(socket.port())),
    ])
}

/// The pair (host, port) of an argument.
fn pair(ev: &Evaluator<'_>, value: &Value, method: &str) -> R<(String, u16)> {
    let Value::Tuple(items) = ev.unwrap_builtin(value) else {
        let name = ev.core.types.name_of(value);
        return Err(ev.type_error(format!(
            "{method}(): AF_INET address must be tuple, not {name}"
        )));
    };
    let [host, port] = items.items() else {
        return Err(ev.type_error(format!(
            "{method}(): AF_INET address must be a pair (host, port)"
        )));
    };
    let Value::Str(host) = ev.unwrap_builtin(host) else {
        return Err(ev.type_error(
            "str, bytes or bytearray expected, not ".to_owned() + &ev.core.types.name_of(host),
        ));
    };
    let Ok(port) = u16::try_from(ev.index(port)?) else {
        return Err(ev.raise(
            ExceptionKind::OverflowError,
            format!("{method}(): port must be 0-65535."),
        ));
    };
    Ok((host.as_str().to_owned(), port))
}

fn data_of(ev: &Evaluator<'_>, value: &Value) -> R<BytesRef> {
    ev.bytes_like(value).ok_or_else(|| {
        let name = ev.core.types.name_of(value);
        ev.type_error(format!("a bytes-like object is required, not '{name}'"))
    })
}

const METHODS: &[MethodDef] = &[
    ("connect", "address /", |ev, args| {
        let (host, port) = pair(ev, &args[1], "connect")?;
        let (socket, timeout) = open(ev, &args[0])?;
        socket
            .connect(&host, port)
            .map_err(|error| os_error(ev, &error))?;
        wait_for(ev, &*socket, Interest::Connect, timeout, || {
            socket.connect_result()
        })?;
        Ok(Value::None)
    }),
    ("bind", "address /", |ev, args| {
        let (host, port) = pair(ev, &args[1], "bind")?;
        let (socket, _) = open(ev, &args[0])?;
        socket
            .bind(&host, port)
            .map_err(|error| os_error(ev, &error))?;
        Ok(Value::None)
    }),
    ("listen", "backlog? /", |ev, args| {
        let backlog = args[1]
            .if_given()
            .map_or(Ok(128), |value| ev.index(value))?;
        let (socket, _) = open(ev, &args[0])?;
        socket
            .listen(backlog.clamp(0, 1024) as u32)
            .map_err(|error| os_error(ev, &error))?;
        Ok(Value::None)
    }),
    ("accept", "", |ev, args| {
        let (socket, timeout) = open(ev, &args[0])?;
        let (accepted, from) = wait_for(ev, &*socket, Interest::Read, timeout, || socket.accept())?;
        Ok(Value::tuple(vec![make(ev, accepted)?, address(from)]))
    }),
    ("recv", "bufsize /", |ev, args| {
        let size = ev.index(&args[1])?;
        let Ok(size) = usize::try_from(size) else {
            return Err(ev.value_error("negative buffersize in recv"));
        };
        let (socket, timeout) = open(ev, &args[0])?;
        let mut buffer = vec![0; size.min(RECEIVE_MAX)];
        let count = wait_for(ev, &*socket, Interest::Read, timeout, || {
            socket.read(&mut buffer)
        })?;
        buffer.truncate(count);
        Ok(Value::Bytes(Rc::new(Bytes::new(buffer))))
    }),
    ("send", "data /", |ev, args| {
        let data = data_of(ev, &args[1])?;
        let (socket, timeout) = open(ev, &args[0])?;
        let count = wait_for(ev, &*socket, Interest::Write, timeout, || {
            socket.write(&data)
        })?;
        Ok(Value::Int(count as i64))
    }),
    ("sendall", "data /", |ev, args| {
        let data = data_of(ev, &args[1])?;
        let (socket, timeout) = open(ev, &args[0])?;
        let deadline = timeout.map(|seconds| ev.core.host.monotonic() + seconds);
        let mut sent = 0;
        while sent < data.len() {
            let left = deadline.map(|deadline| (deadline - ev.core.host.monotonic()).max(0.0));
            let left = if timeout == Some(0.0) { timeout } else { left };
            sent += wait_for(ev, &*socket, Interest::Write, left, || {
                socket.write(&data[sent..])
            })?;
            ev.safepoint()?;
        }
        Ok(Value::None)
    }),
    ("shutdown", "how /", |ev, args| {
        let how = match ev.index(&args[1])? {
            0 => Shutdown::Read,
            1 => Shutdown::Write,
            2 => Shutdown::Both,
            other => {
                return Err(ev.value_error(format!(
                    "shutdown(): how is {other}; 0, 1 and 2 are allowed"
                )));
            }
        };
        let (socket, _) = open(ev, &args[0])?;
        socket.shutdown(how).map_err(|error| os_error(ev, &error))?;
        Ok(Value::None)
    }),
    ("close", "", |ev, args| {
        let socket = with_data(ev, &args[0], |socket: &Rc<Socket>| Ok(socket.host.take()))?;
        if let Some(socket) = socket {
            socket.close();
        }
        Ok(Value::None)
    }),
    ("closed", "", |ev, args| {
        with_data(ev, &args[0], |socket: &Rc<Socket>| {
            Ok(Value::Bool(socket.host.borrow().is_none()))
        })
    }),
    ("settimeout", "value /", |ev, args| {
        let timeout = match &args[1] {
            Value::None => None,
            value => Some(ev.to_f64(value)?),
        };
        if timeout.is_some_and(|seconds| seconds < 0.0 || seconds.is_nan()) {
            return Err(ev.value_error("Timeout value out of range"));
        }
        with_data(ev, &args[0], |socket: &Rc<Socket>| {
            socket.timeout.set(timeout);
            Ok(Value::None)
        })
    }),
    ("gettimeout", "", |ev, args| {
        with_data(ev, &args[0], |socket: &Rc<Socket>| {
            Ok(socket.timeout.get().map_or(Value::None, Value::Float))
        })
    }),
    ("setnodelay", "on /", |ev, args| {
        let on = ev.truth(&args[1])?;
        let (socket, _) = open(ev, &args[0])?;
        socket
            .set_nodelay(on)
            .map_err(|error| os_error(ev, &error))?;
        Ok(Value::None)
    }),
    ("getsockname", "", |ev, args| {
        let (socket, _) = open(ev, &args[0])?;
        // A socket without an address has the empty one, as on Linux.
        Ok(match socket.local_address() {
            Ok(own) => address(own),
            Err(_) => Value::tuple(vec![Value::str("0.0.0.0"), Value::Int(0)]),
        })
    }),
    ("getpeername", "", |ev, args| {
        let (socket, _) = open(ev, &args[0])?;
        socket
            .peer_address()
            .map(address)
            .map_err(|error| os_error(ev, &error))
    }),
];
