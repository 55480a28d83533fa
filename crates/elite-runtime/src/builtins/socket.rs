//! Manual 7.1: TCP client sockets by name.
//!
//! Reads give what the manual says for a failure (False, 0, nan, -1, empty text) instead of raising; arguments outside
//! their range raise. A socket lives until it is closed or its task ends.

use std::rc::Rc;

use elite_lang::{ExceptionKind, Unwind, Value};
use io_bus::{PeerStream, ScriptSocket};
use messages::text;

use super::call::Call;
use super::declare::{
    Builtin, Category::Socket, Parameter, ParameterDefault, ParameterType, Range, phrase,
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
    phrase(
        "name of the connection; empty means socket_0",
        "连接名称；空表示 socket_0",
    ),
)
.or(ParameterDefault::Text(DEFAULT_NAME));
const TIMEOUT: Parameter = Parameter::required(
    "timeout",
    ParameterType::Number(Range::Any),
    phrase("0 or less waits for ever", "不大于 0 时一直等待"),
)
.or(ParameterDefault::Number(2.0))
.in_unit("s");
const NUMBER: Parameter = Parameter::required(
    "number",
    ParameterType::Integer(1, 30),
    phrase("how many", "数量"),
);
const BYTES: Parameter = Parameter::required(
    "number",
    ParameterType::Integer(1, 512),
    phrase("how many", "数量"),
);
const ADDRESS: Parameter = Parameter::required(
    "address",
    ParameterType::Text,
    phrase("address or name of the server", "服务器的地址或名称"),
);
const PORT: Parameter = Parameter::required(
    "port",
    ParameterType::Integer(1, 65535),
    phrase("TCP port of the server", "服务器的 TCP 端口"),
);
const VAR_NAME: Parameter = Parameter::required(
    "var_name",
    ParameterType::Text,
    phrase("name of the variable", "变量名"),
);
const SET_NAME: Parameter = Parameter::required(
    "name",
    ParameterType::Text,
    phrase("name of the variable", "变量名"),
);
const SET_VALUE: Parameter = Parameter::required(
    "value",
    ParameterType::Integer(i64::MIN, i64::MAX),
    phrase("its value", "其值"),
);
const PREFIX: Parameter = Parameter::required(
    "prefix",
    ParameterType::Text,
    phrase("text before the wanted part", "所需部分之前的文本"),
)
.or(ParameterDefault::Text(""));
const SUFFIX: Parameter = Parameter::required(
    "suffix",
    ParameterType::Text,
    phrase("text after the wanted part", "所需部分之后的文本"),
)
.or(ParameterDefault::Text(""));
const BYTE_LIST: Parameter = Parameter::required(
    "value",
    ParameterType::Custom("list[int]"),
    phrase("bytes, 0 to 255 each", "字节，每个 0 到 255"),
);
const BYTE: Parameter = Parameter::required(
    "value",
    ParameterType::Custom("int or str"),
    phrase(
        "a number, of which the low 8 bits are sent, or one ASCII character",
        "一个数（发送其低 8 位）或一个 ASCII 字符",
    ),
);
const INT: Parameter = Parameter::required(
    "value",
    ParameterType::Integer(i32::MIN as i64, i32::MAX as i64),
    phrase("the number", "数"),
);
const LINE: Parameter = Parameter::required("str", ParameterType::Text, phrase("the text", "文本"));
const LINEFEED: Parameter = Parameter::required(
    "linefeed_type",
    ParameterType::Integer(0, 2),
    phrase("0 \\n, 1 \\r, 2 \\r\\n", "0 为 \\n，1 为 \\r，2 为 \\r\\n"),
)
.or(ParameterDefault::Integer(0));
const ANYTHING: Parameter = Parameter::required(
    "str",
    ParameterType::Printable,
    phrase("sent as str() shows it", "按 str() 的形式发送"),
);

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Socket,
        "7.1.1",
        "socket_open",
        &[ADDRESS, PORT, NAME],
        phrase("bool, True when connected", "bool，已连接为 True"),
        phrase(
            "Connects to a server, within 2 s; a connection that still stands is kept.",
            "在 2 秒内连接服务器；仍然有效的连接会保留。",
        ),
        socket_open,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.2",
        "socket_close",
        &[NAME],
        phrase("nothing", "无返回值"),
        phrase("Closes a connection.", "关闭连接。"),
        socket_close,
    ),
    Builtin::new(
        Socket,
        "7.1.3",
        "socket_is_connected",
        &[NAME],
        phrase("bool", "bool"),
        phrase("Whether the connection stands.", "连接是否有效。"),
        socket_is_connected,
    ),
    Builtin::new(
        Socket,
        "7.1.4",
        "socket_get_var",
        &[VAR_NAME, NAME],
        phrase("int of 32 bits, 0 when it fails", "32 位 int，失败时为 0"),
        phrase(
            "Asks the server for an integer: GET name, answered by name value, within 2 s.",
            "向服务器询问整数：发送 GET 名称，2 秒内以“名称 值”应答。",
        ),
        socket_get_var,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.5",
        "socket_read_ascii_float",
        &[NUMBER, NAME, TIMEOUT],
        phrase(
            "list: how many came, then the numbers, nan where none came",
            "list：先是收到的个数，后是各数，未收到处为 nan",
        ),
        phrase(
            "Reads numbers in parentheses, apart by commas or blanks.",
            "读取括号内以逗号或空格分隔的数。",
        ),
        socket_read_ascii_float,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.6",
        "socket_read_binary_integer",
        &[NUMBER, NAME, TIMEOUT],
        phrase(
            "list: how many came, then the integers, -1 where none came",
            "list：先是收到的个数，后是各整数，未收到处为 -1",
        ),
        phrase(
            "Reads integers of 32 bits in network byte order.",
            "读取网络字节序的 32 位整数。",
        ),
        socket_read_binary_integer,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.7",
        "socket_read_byte_list",
        &[BYTES, NAME, TIMEOUT],
        phrase(
            "list: how many came, then the bytes, -1 where none came",
            "list：先是收到的个数，后是各字节，未收到处为 -1",
        ),
        phrase("Reads bytes.", "读取字节。"),
        socket_read_byte_list,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.8",
        "socket_send_byte_list",
        &[BYTE_LIST, NAME],
        phrase("int, bytes sent", "int，已发送的字节数"),
        phrase("Sends bytes.", "发送字节。"),
        socket_send_byte_list,
    ),
    Builtin::new(
        Socket,
        "7.1.9",
        "socket_read_string",
        &[NAME, PREFIX, SUFFIX, TIMEOUT],
        phrase(
            "str, empty when it fails; at most 2047 bytes",
            "str，失败时为空；最多 2047 字节",
        ),
        phrase(
            "Reads the text between prefix and suffix; the rest stays for the next call.",
            "读取前缀与后缀之间的文本；其余留给下次调用。",
        ),
        socket_read_string,
    )
    .waiting(),
    Builtin::new(
        Socket,
        "7.1.10",
        "socket_send_byte",
        &[BYTE, NAME],
        phrase("bool, True when sent", "bool，已发送为 True"),
        phrase("Sends one byte.", "发送一个字节。"),
        socket_send_byte,
    ),
    Builtin::new(
        Socket,
        "7.1.11",
        "socket_send_int",
        &[INT, NAME],
        phrase("bool, True when sent", "bool，已发送为 True"),
        phrase(
            "Sends an integer of 32 bits in network byte order.",
            "以网络字节序发送 32 位整数。",
        ),
        socket_send_int,
    ),
    Builtin::new(
        Socket,
        "7.1.12",
        "socket_send_line",
        &[LINE, LINEFEED, NAME],
        phrase("bool, True when sent", "bool，已发送为 True"),
        phrase("Sends a text and a line end.", "发送文本和换行。"),
        socket_send_line,
    ),
    Builtin::new(
        Socket,
        "7.1.13",
        "socket_send_string",
        &[ANYTHING, NAME],
        phrase("bool, True when sent", "bool，已发送为 True"),
        phrase(
            "Sends a text, or another value in the form of to_str().",
            "发送文本，或按 to_str() 的形式发送其他值。",
        ),
        socket_send_string,
    ),
    Builtin::new(
        Socket,
        "7.1.14",
        "socket_set_var",
        &[SET_NAME, SET_VALUE, NAME],
        phrase("nothing", "无返回值"),
        phrase("Sends SET name value.", "发送 SET 名称 值。"),
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
        let text = text!(
            "socket_open(): {SOCKETS_MAX} sockets are open already, more are not allowed; close one with \
             socket_close()",
            "socket_open()：已打开 {SOCKETS_MAX} 个连接，不能再多；请用 socket_close() 关闭一个"
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
        return Err(call.not_this_type(
            0,
            &text!("a list of bytes (0 to 255)", "字节（0 到 255）的列表"),
        ));
    };
    let mut bytes = Vec::with_capacity(items.len());
    for item in items {
        match item.as_i64().map(u8::try_from) {
            Some(Ok(byte)) => bytes.push(byte),
            _ => {
                let shown = call.native().repr(&item)?;
                return Err(call.not_allowed(
                    0,
                    &text!("a list of integers from 0 to 255", "0 到 255 的整数的列表"),
                    shown,
                ));
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
            return Err(call.not_allowed(
                0,
                &text!("one ASCII character or an integer", "一个 ASCII 字符或整数"),
                shown,
            ));
        }
        None => match value.as_i64() {
            // The low 8 bits, as the manual says.
            Some(number) => number as u8,
            None => {
                return Err(call.not_this_type(
                    0,
                    &text!("one ASCII character or an integer", "一个 ASCII 字符或整数"),
                ));
            }
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
