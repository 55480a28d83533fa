//! The servers that a test plays, as functions of `test`: what they are given, what they note down, what they answer.

use std::collections::BTreeMap;

use elite_lang::{ExceptionKind, NativeCall, Unwind, Value};
use elite_runtime::builtins::rpc::{from_rpc, to_rpc};
use io_bus::xmlrpc::codec::{RpcFault, RpcValue, decode_call, encode_response};
use messages::text;

use crate::simulated_peers::{
    ModbusDevice, ModbusRequest, ReceivedMessage, ReplySource, ServerKind, http_body,
};
use crate::test_object::{CallContext, argument_error, raise};

type NativeResult<T = Value> = Result<T, Unwind>;

/// Code of the fault that a call ends with which the test does not answer; our choice.
const FAULT: i64 = 1;
/// Answers and functions that one server takes.
const ANSWERS_MAX: usize = 10_000;

/// What the test's side of a server is.
pub(crate) struct SimulatedServer {
    /// The list that the test sees as `received`.
    received: Value,
    answers: ReplyTable,
}

enum ReplyTable {
    /// Answers by the number of the message.
    Socket(Vec<Value>),
    /// Answers by the name of the method.
    Rpc(BTreeMap<String, Value>),
    /// The tables answer.
    Modbus,
}

fn port(call: &NativeCall<'_>) -> NativeResult<u16> {
    let Some(given) = call.arg(0) else {
        return Ok(0);
    };
    let port = given.as_i64().filter(|_| !matches!(given, Value::Bool(_)));
    match port.and_then(|port| u16::try_from(port).ok()) {
        Some(port) => Ok(port),
        None => {
            let shown = call.repr(given)?;
            let text = text!(
                "port is {shown}; allowed are whole numbers from 0 to 65535, 0 is any",
                "port 为 {shown}；允许 0 到 65535 的整数，0 为任意端口"
            );
            Err(argument_error(call, &text))
        }
    }
}

fn bytes_of(value: &Value) -> Option<Vec<u8>> {
    let text = value.as_str().map(|text| text.as_bytes().to_vec());
    text.or_else(|| value.as_bytes())
}

/// The object of a server that was opened.
fn opened(
    site: &CallContext,
    call: &NativeCall<'_>,
    port: u16,
    kind: ServerKind,
    answers: ReplyTable,
) -> NativeResult {
    let opened = site.bench.peers.open(port, kind);
    let (_, port) = opened.map_err(|sentence| argument_error(call, &sentence))?;
    let received = Value::list(Vec::new());
    site.served.borrow_mut().push(SimulatedServer {
        received: received.clone(),
        answers,
    });
    let attributes = vec![("port", Value::Int(port.into())), ("received", received)];
    Ok(call.object("server", Vec::new(), attributes))
}

/// `test.socket_server(port, answers)`
pub(crate) fn socket_server(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let port = port(call)?;
    let given = match call.arg(1).cloned() {
        None => Vec::new(),
        // One answer is as good as a list of one.
        Some(one) if bytes_of(&one).is_some() || one.is_callable() => vec![one],
        Some(many) => call.items(&many)?,
    };
    if given.len() > ANSWERS_MAX {
        let text = text!(
            "{} answers, at most {ANSWERS_MAX} are taken",
            "{} 个回答，最多 {ANSWERS_MAX} 个",
            given.len()
        );
        return Err(argument_error(call, &text));
    }
    let mut answers = Vec::new();
    for (number, answer) in given.iter().enumerate() {
        answers.push(match bytes_of(answer) {
            Some(bytes) => ReplySource::Bytes(bytes),
            None if answer.is_callable() => ReplySource::Ask,
            None => {
                let text = text!(
                    "answers[{number}] must be a text, bytes, or a function of the message, not {}",
                    "answers[{number}] 应为字符串、bytes 或以消息为参数的函数，不能是 {}",
                    answer.type_name()
                );
                return Err(raise(call, ExceptionKind::TypeError, &text));
            }
        });
    }
    opened(
        site,
        call,
        port,
        ServerKind::Socket(answers),
        ReplyTable::Socket(given),
    )
}

/// `test.rpc_server(port, functions)`
pub(crate) fn rpc_server(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let port = port(call)?;
    let mut functions = BTreeMap::new();
    if let Some(given) = call.arg(1) {
        let Some(entries) = given.as_entries() else {
            let text = text!(
                "functions must be a dict from names to functions or values, not {}",
                "functions 应为由名称到函数或值的 dict，不能是 {}",
                given.type_name()
            );
            return Err(raise(call, ExceptionKind::TypeError, &text));
        };
        for (name, function) in entries {
            match name.as_str() {
                Some(name) => functions.insert(name.to_owned(), function),
                None => {
                    let text = text!(
                        "a name in functions is {}, not a text",
                        "functions 中的一个名称为 {}，不是字符串",
                        name.type_name()
                    );
                    return Err(raise(call, ExceptionKind::TypeError, &text));
                }
            };
        }
    }
    opened(
        site,
        call,
        port,
        ServerKind::Rpc,
        ReplyTable::Rpc(functions),
    )
}

/// `test.modbus_device(port, registers, coils)`
pub(crate) fn modbus_device(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let port = port(call)?;
    let registers = table(call, 1, "registers", |value| {
        let number = value.as_i64().filter(|_| !matches!(value, Value::Bool(_)));
        number.and_then(|number| u16::try_from(number).ok())
    })?;
    let coils = table(call, 2, "coils", |value| match value {
        Value::Bool(level) => Some(*level),
        Value::Int(0) => Some(false),
        Value::Int(1) => Some(true),
        _ => None,
    })?;
    let device = ModbusDevice { coils, registers };
    opened(
        site,
        call,
        port,
        ServerKind::Modbus(device),
        ReplyTable::Modbus,
    )
}

/// Values by address: a dict, or a list that begins at address 0.
fn table<T>(
    call: &NativeCall<'_>,
    index: usize,
    name: &str,
    fits: impl Fn(&Value) -> Option<T>,
) -> NativeResult<BTreeMap<u16, T>> {
    let Some(given) = call.arg(index) else {
        return Ok(BTreeMap::new());
    };
    let entries = match given.as_entries() {
        Some(entries) => entries,
        None => {
            let items = call.items(given)?;
            let at = (0..).map(Value::Int);
            at.zip(items).collect()
        }
    };
    let mut table = BTreeMap::new();
    for (address, value) in entries {
        let at = address.as_i64().and_then(|at| u16::try_from(at).ok());
        let (Some(at), Some(value)) = (at, fits(&value)) else {
            let (address, value) = (call.repr(&address)?, call.repr(&value)?);
            let allowed = match name {
                "coils" => text!("True or False", "True 或 False"),
                _ => text!("a whole number from 0 to 65535", "0 到 65535 的整数"),
            };
            let text = text!(
                "{name}[{address}] is {value}; addresses are whole numbers from 0 to 65535, a value is {allowed}",
                "{name}[{address}] 为 {value}；地址为 0 到 65535 的整数，值应为{allowed}"
            );
            return Err(argument_error(call, &text));
        };
        table.insert(at, value);
    }
    Ok(table)
}

/// Notes down what has come to the servers, and answers what only the test can.
pub(crate) fn answer(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult<()> {
    loop {
        let arrived = site.bench.peers.take_arrived();
        if arrived.is_empty() {
            return Ok(());
        }
        for arrived in arrived {
            take(site, call, &arrived)?;
        }
    }
}

/// What is to be done about a message, found out while the table of servers is borrowed.
enum PendingReply {
    Nothing,
    Socket(Value),
    Rpc(String, Vec<RpcValue>, Option<Value>),
    NoCall,
}

fn take(
    site: &CallContext,
    call: &mut NativeCall<'_>,
    arrived: &ReceivedMessage,
) -> NativeResult<()> {
    let data = &arrived.data;
    let as_text = match String::from_utf8(data.clone()) {
        Ok(text) => Value::str(text),
        Err(_) => Value::bytes(data.clone()),
    };
    let (received, noted, task) = {
        let served = site.served.borrow();
        let Some(server) = served.get(arrived.whom.server) else {
            return Ok(());
        };
        let (noted, task) = match &server.answers {
            ReplyTable::Socket(answers) => match answers.get(arrived.number) {
                Some(function) if arrived.asks => (as_text, PendingReply::Socket(function.clone())),
                _ => (as_text, PendingReply::Nothing),
            },
            ReplyTable::Rpc(functions) => {
                let body = String::from_utf8_lossy(http_body(data));
                match decode_call(&body) {
                    Ok((method, arguments)) => {
                        let values = arguments.iter().cloned().map(from_rpc);
                        let items =
                            vec![Value::str(method.as_str()), Value::list(values.collect())];
                        let function = functions.get(&method).cloned();
                        (
                            Value::tuple(items),
                            PendingReply::Rpc(method, arguments, function),
                        )
                    }
                    Err(_) => (Value::str(&*body), PendingReply::NoCall),
                }
            }
            ReplyTable::Modbus => {
                let noted = ModbusRequest::of_message(data).map_or(Value::None, |asked| {
                    let values = asked.values.iter().map(|value| i64::from(*value));
                    let values: Vec<i64> = values.collect();
                    Value::tuple(vec![
                        Value::Int(asked.function.into()),
                        Value::Int(asked.address.into()),
                        Value::list_of_i64(&values),
                    ])
                });
                (noted, PendingReply::Nothing)
            }
        };
        (server.received.clone(), noted, task)
    };
    call.append(&received, noted.clone());
    match task {
        PendingReply::Nothing => {}
        PendingReply::Socket(function) => {
            let answered = call.call_value(&function, &[noted]);
            if answered.is_err() {
                site.bench.peers.hang_up(arrived.whom);
            }
            let answered = answered?;
            let bytes = match (answered.is_none(), bytes_of(&answered)) {
                // Nothing is to be answered.
                (true, _) => Vec::new(),
                (false, Some(bytes)) => bytes,
                (false, None) => {
                    let text = text!(
                        "the answer to message {} must be a text, bytes or None, not {}",
                        "对第 {} 条消息的回答应为字符串、bytes 或 None，不能是 {}",
                        arrived.number,
                        answered.type_name()
                    );
                    site.bench.peers.hang_up(arrived.whom);
                    return Err(raise(call, ExceptionKind::TypeError, &text));
                }
            };
            site.bench.peers.reply(arrived.whom, &bytes);
        }
        PendingReply::Rpc(method, arguments, function) => {
            let arguments: Vec<Value> = arguments.into_iter().map(from_rpc).collect();
            let answer = match function {
                None => Err(fault(format!("there is no method {method}"))),
                Some(function) if function.is_callable() => {
                    match call.call_value(&function, &arguments) {
                        Ok(value) => Ok(value),
                        Err(Unwind::Stop) => return Err(Unwind::Stop),
                        // An error of the server is the caller's to see.
                        Err(raised) => {
                            let report = call.report(&raised);
                            let text = report.map_or_else(String::new, |error| error.to_string());
                            Err(fault(text))
                        }
                    }
                }
                Some(value) => Ok(value),
            };
            let answer = match answer {
                Ok(value) => Ok(to_rpc(call, &method, &value, 0)?),
                Err(fault) => Err(fault),
            };
            respond(site, arrived, &answer);
        }
        PendingReply::NoCall => {
            let sentence = "the call is no XML-RPC".to_owned();
            respond(site, arrived, &Err(fault(sentence)));
        }
    }
    Ok(())
}

fn fault(text: String) -> RpcFault {
    RpcFault { code: FAULT, text }
}

fn respond(site: &CallContext, arrived: &ReceivedMessage, answer: &Result<RpcValue, RpcFault>) {
    let body = encode_response(answer);
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: text/xml\r\nContent-Length: {}\r\n\r\n",
        body.len()
    );
    let response = [head.as_bytes(), body.as_bytes()].concat();
    site.bench.peers.reply(arrived.whom, &response);
}
