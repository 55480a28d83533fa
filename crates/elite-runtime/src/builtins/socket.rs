//! Manual 7.1: TCP client sockets by name.
//!
//! Reads give what the manual says for a failure (False, 0, nan, -1, empty text) instead of raising; arguments outside
//! their range raise. A socket lives until it is closed or its task ends.

use std::rc::Rc;

use elite_lang::{ExceptionKind, Unwind, Value};
use io_bus::{PeerStream, ScriptSocket};

use super::call::Call;
use super::declare::{
    Builtin, Category::Socket, Parameter, ParameterDefault, ParameterType, Range,
};
use crate::value_text::compact_text;

/// Most sockets of one task.
const SOCKETS_MAX: usize = 32;

/// Longest text that is made of a value that is none, characters; far more than one call sends.
const SENT_CHARS_MAX: usize = 1 << 24;

/// The name of a socket without one (manual 7.1.1).
const DEFAULT_NAME: &str = "socket_0";

const NAME: Parameter = Parameter::required(
    "socket_name",
    ParameterType::Text,
    "name of the connection; empty means socket_0",
)
.or(ParameterDefault::Text(DEFAULT_NAME));
const TIMEOUT: Parameter = Parameter::required(
    "timeout",
    ParameterType::Number(Range::Any),
    "0 or less waits for ever",
)
.or(ParameterDefault::Number(2.0))
.in_unit("s");
const NUMBER: Parameter = Parameter::required("number", ParameterType::Integer(1, 30), "how many");
const BYTES: Parameter = Parameter::required("number", ParameterType::Integer(1, 512), "how many");
const ADDRESS: Parameter = Parameter::required(
    "address",
    ParameterType::Text,
    "address or name of the server",
);
const PORT: Parameter = Parameter::required(
    "port",
    ParameterType::Integer(1, 65535),
    "TCP port of the server",
);
const VAR_NAME: Parameter =
    Parameter::required("var_name", ParameterType::Text, "name of the variable");
const SET_NAME: Parameter =
    Parameter::required("name", ParameterType::Text, "name of the variable");
const SET_VALUE: Parameter = Parameter::required(
    "value",
    ParameterType::Integer(i64::MIN, i64::MAX),
    "its value",
);
const PREFIX: Parameter =
    Parameter::required("prefix", ParameterType::Text, "text before the wanted part")
        .or(ParameterDefault::Text(""));
const SUFFIX: Parameter =
    Parameter::required("suffix", ParameterType::Text, "text after the wanted part")
        .or(ParameterDefault::Text(""));
const BYTE_LIST: Parameter = Parameter::required(
    "value",
    ParameterType::Custom("list[int]"),
    "bytes, 0 to 255 each",
);
const BYTE: Parameter = Parameter::required(
    "value",
    ParameterType::Custom("int or str"),
    "a number, of which the low 8 bits are sent, or one ASCII character",
);
const INT: Parameter = Parameter::required(
    "value",
    ParameterType::Integer(i32::MIN as i64, i32::MAX as i64),
    "the number",
);
const LINE: Parameter = Parameter::required("str", ParameterType::Text, "the text");
const LINEFEED: Parameter = Parameter::required(
    "linefeed_type",
    ParameterType::Integer(0, 2),
    "0 \\n, 1 \\r, 2 \\r\\n",
)
.or(ParameterDefault::Integer(0));
const ANYTHING: Parameter =
    Parameter::required("str", ParameterType::Printable, "sent as str() shows it");

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Socket,
        "7.1.1",
        "socket_open",
        &[ADDRESS, PORT, NAME],
        "bool, True when connected",
        "Connects to a server, within 2 s; a connection that still stands is kept.",
        socket_open,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.2",
        "socket_close",
        &[NAME],
        "nothing",
        "Closes a connection.",
        socket_close,
    ),
    Builtin::new(
        Socket,
        "7.1.3",
        "socket_is_connected",
        &[NAME],
        "bool",
        "Whether the connection stands.",
        socket_is_connected,
    ),
    Builtin::new(
        Socket,
        "7.1.4",
        "socket_get_var",
        &[VAR_NAME, NAME],
        "int of 32 bits, 0 when it fails",
        "Asks the server for an integer: GET name, answered by name value, within 2 s.",
        socket_get_var,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.5",
        "socket_read_ascii_float",
        &[NUMBER, NAME, TIMEOUT],
        "list: how many came, then the numbers, nan where none came",
        "Reads numbers in parentheses, apart by commas or blanks.",
        socket_read_ascii_float,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.6",
        "socket_read_binary_integer",
        &[NUMBER, NAME, TIMEOUT],
        "list: how many came, then the integers, -1 where none came",
        "Reads integers of 32 bits in network byte order.",
        socket_read_binary_integer,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.7",
        "socket_read_byte_list",
        &[BYTES, NAME, TIMEOUT],
        "list: how many came, then the bytes, -1 where none came",
        "Reads bytes.",
        socket_read_byte_list,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.8",
        "socket_send_byte_list",
        &[BYTE_LIST, NAME],
        "int, bytes sent",
        "Sends bytes.",
        socket_send_byte_list,
    ),
    Builtin::new(
        Socket,
        "7.1.9",
        "socket_read_string",
        &[NAME, PREFIX, SUFFIX, TIMEOUT],
        "str, empty when it fails; at most 2047 bytes",
        "Reads the text between prefix and suffix; the rest stays for the next call.",
        socket_read_string,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.10",
        "socket_send_byte",
        &[BYTE, NAME],
        "bool, True when sent",
        "Sends one byte.",
        socket_send_byte,
    ),
    Builtin::new(
        Socket,
        "7.1.11",
        "socket_send_int",
        &[INT, NAME],
        "bool, True when sent",
        "Sends an integer of 32 bits in network byte order.",
        socket_send_int,
    ),
    Builtin::new(
        Socket,
        "7.1.12",
        "socket_send_line",
        &[LINE, LINEFEED, NAME],
        "bool, True when sent",
        "Sends a text and a line end.",
        socket_send_line,
    ),
    Builtin::new(
        Socket,
        "7.1.13",
        "socket_send_string",
        &[ANYTHING, NAME],
        "bool, True when sent",
        "Sends a text, or another value in the form of to_str().",
        socket_send_string,
    ),
    Builtin::new(
        Socket,
        "7.1.14",
        "socket_set_var",
        &[SET_NAME, SET_VALUE, NAME],
        "nothing",
        "Sends SET name value.",
        socket_set_var,
    ),
];

fn name(call: &mut Call<'_, '_>, index: usize) -> Result<String, Unwind> {
    let name = call.text(index)?;
    Ok(if name.is_empty() {
        DEFAULT_NAME.to_owned()
    } else {
        name
    })
}

/// The socket with the name in argument `index`, if it was opened.
fn socket(call: &mut Call<'_, '_>, index: usize) -> Result<Option<Rc<ScriptSocket>>, Unwind> {
    call.check_net()?;
    let name = name(call, index)?;
    Ok(call.context().sockets().borrow().get(&name).cloned())
}

fn socket_open(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.check_net()?;
    let address = call.text(0)?;
    let port = u16::try_from(call.integer(1)?).unwrap_or_default();
    let name = name(call, 2)?;
    let sockets = call.context().sockets();
    let known = sockets.borrow().get(&name).cloned();
    if known.is_some_and(|socket| socket.is_connected()) {
        return Ok(Value::Bool(true));
    }
    sockets.borrow_mut().remove(&name);
    if sockets.borrow().len() >= SOCKETS_MAX {
        let text = format!(
            "socket_open(): {SOCKETS_MAX} sockets are open already, more are not allowed; close one with socket_close()"
        );
        return Err(call.error(ExceptionKind::RuntimeError, text));
    }
    let opened = match call.context().stand_in(&address, port) {
        Some(stream) => stream
            .and_then(PeerStream::local)
            .map(ScriptSocket::from_stream),
        None => call.wait_for_future(async move { ScriptSocket::open(&address, port).await })?,
    };
    Ok(Value::Bool(match opened {
        Ok(socket) => {
            sockets.borrow_mut().insert(name, Rc::new(socket));
            true
        }
        Err(_refused) => false,
    }))
}

fn socket_close(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.check_net()?;
    let name = name(call, 0)?;
    call.context().sockets().borrow_mut().remove(&name);
    Ok(Value::None)
}

fn socket_is_connected(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let socket = socket(call, 0)?;
    Ok(Value::Bool(
        socket.is_some_and(|socket| socket.is_connected()),
    ))
}

fn socket_get_var(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let variable = call.text(0)?;
    let Some(socket) = socket(call, 1)? else {
        return Ok(Value::Int(0));
    };
    let value = call.wait_for_future(async move { socket.query_var(&variable).await })?;
    Ok(Value::Int(value.into()))
}

/// `[how many came, value, …]`, always `wanted` values, filled up with `missing`.
fn counted(values: impl ExactSizeIterator<Item = Value>, wanted: usize, missing: Value) -> Value {
    let mut list = vec![Value::Int(values.len() as i64)];
    list.extend(values);
    list.resize(wanted + 1, missing);
    Value::list(list)
}

/// How many values are wanted; at most 512, so that it fits anything.
fn wanted(call: &mut Call<'_, '_>) -> Result<usize, Unwind> {
    Ok(usize::try_from(call.integer(0)?).unwrap_or_default())
}

fn socket_read_ascii_float(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (wanted, patience) = (wanted(call)?, call.patience(2)?);
    let numbers = match socket(call, 1)? {
        Some(socket) => {
            call.wait_for_future(async move { socket.read_floats(wanted, patience).await })?
        }
        None => Vec::new(),
    };
    Ok(counted(
        numbers.into_iter().map(Value::Float),
        wanted,
        Value::Float(f64::NAN),
    ))
}

fn socket_read_binary_integer(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (wanted, patience) = (wanted(call)?, call.patience(2)?);
    let integers = match socket(call, 1)? {
        Some(socket) => {
            call.wait_for_future(async move { socket.read_integers(wanted, patience).await })?
        }
        None => Vec::new(),
    };
    let values = integers.into_iter().map(|n| Value::Int(n.into()));
    Ok(counted(values, wanted, Value::Int(-1)))
}

fn socket_read_byte_list(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (wanted, patience) = (wanted(call)?, call.patience(2)?);
    let bytes = match socket(call, 1)? {
        Some(socket) => {
            call.wait_for_future(async move { socket.read_bytes(wanted, patience).await })?
        }
        None => Vec::new(),
    };
    let values = bytes.into_iter().map(|b| Value::Int(b.into()));
    Ok(counted(values, wanted, Value::Int(-1)))
}

fn socket_read_string(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (prefix, suffix, patience) = (call.text(1)?, call.text(2)?, call.patience(3)?);
    let Some(socket) = socket(call, 0)? else {
        return Ok(Value::str(""));
    };
    let text =
        call.wait_for_future(async move { socket.read_text(&prefix, &suffix, patience).await })?;
    Ok(Value::str(text))
}

/// Sends to the socket named in argument `index`; how many bytes went.
fn send(call: &mut Call<'_, '_>, index: usize, bytes: Vec<u8>) -> Result<usize, Unwind> {
    match socket(call, index)? {
        Some(socket) => call.wait_for_future(async move { socket.send(&bytes).await }),
        None => Ok(0),
    }
}

/// Sends to the socket named in argument `index`; `True` when every byte went.
fn send_all(call: &mut Call<'_, '_>, index: usize, bytes: Vec<u8>) -> Result<Value, Unwind> {
    let length = bytes.len();
    // Nothing to send to a socket that is not connected is a failure too.
    let connected = socket(call, index)?.is_some_and(|socket| socket.is_connected());
    Ok(Value::Bool(
        connected && send(call, index, bytes)? == length,
    ))
}

fn socket_send_byte_list(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let Some(items) = call.required(0).as_items() else {
        return Err(call.not_this_type(0, "a list of bytes (0 to 255)"));
    };
    let mut bytes = Vec::with_capacity(items.len());
    for item in items {
        match item.as_i64().map(u8::try_from) {
            Some(Ok(byte)) => bytes.push(byte),
            _ => {
                let shown = call.native().repr(&item)?;
                return Err(call.not_allowed(0, "a list of integers from 0 to 255", shown));
            }
        }
    }
    Ok(Value::Int(send(call, 1, bytes)? as i64))
}

fn socket_send_byte(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let value = call.required(0);
    let byte = match value.as_str().map(str::as_bytes) {
        Some([byte]) => *byte,
        Some(_) => {
            let shown = call.native().repr(&value)?;
            return Err(call.not_allowed(0, "one ASCII character or an integer", shown));
        }
        None => match value.as_i64() {
            // The low 8 bits, as the manual says.
            Some(number) => number as u8,
            None => return Err(call.not_this_type(0, "one ASCII character or an integer")),
        },
    };
    send_all(call, 1, vec![byte])
}

fn socket_send_int(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    // The declared range is that of 32 bits.
    let value = i32::try_from(call.integer(0)?).unwrap_or_default();
    send_all(call, 1, value.to_be_bytes().into())
}

fn socket_send_line(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let end = match call.integer(1)? {
        0 => "\n",
        1 => "\r",
        _ => "\r\n",
    };
    let line = call.text(0)? + end;
    send_all(call, 2, line.into())
}

fn socket_send_string(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let value = call.required(0);
    // Lists and numbers are written by the rules of `to_str`, everything else by those of Python's `str`.
    let text = match compact_text(&value, SENT_CHARS_MAX) {
        Some(text) => text,
        None => call.native().str(&value)?.to_string(),
    };
    send_all(call, 1, text.into())
}

fn socket_set_var(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (name, value) = (call.text(0)?, call.integer(1)?);
    send(call, 2, format!("SET {name} {value}\n").into())?;
    Ok(Value::None)
}
