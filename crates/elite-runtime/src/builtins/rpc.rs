//! Manual 7.2: remote calls. A handle answers to any method name; the call waits for the answer, at most 10 s.

use std::rc::Rc;

use elite_lang::{ExceptionKind, MethodHandler, NativeCall, NativeContext, Unwind, Value};
use io_bus::xmlrpc::codec::DEPTH_MAX;
use io_bus::xmlrpc::{RpcClient, RpcUrl, RpcValue};
use messages::text;

use super::call::Call;
use super::declare::{Builtin, Category::Rpc, Parameter, ParameterType, phrase};
use crate::external::call_external;
use crate::task::TaskContext;

const TYPE: Parameter = Parameter::required(
    "type",
    ParameterType::Word(&["xmlrpc"]),
    phrase("protocol", "协议"),
);
const URL: Parameter = Parameter::required(
    "url",
    ParameterType::Text,
    phrase(
        "\"ip:port\", which means the path /RPC2, or \"http://ip:port/path\"",
        "\"ip:port\"（路径为 /RPC2）或 \"http://ip:port/path\"",
    ),
);

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[Builtin::new(
    Rpc,
    "7.2.1",
    "rpc_factory",
    &[TYPE, URL],
    phrase(
        "a handle; calling any of its methods calls the server's",
        "句柄；调用其任何方法即调用服务器的同名方法",
    ),
    phrase(
        "Makes a handle for remote calls; connects at the first call.",
        "创建远程调用句柄；首次调用时连接。",
    ),
    rpc_factory,
)];

fn rpc_factory(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.word(0)?;
    let text = call.text(1)?;
    let url: RpcUrl = match text.parse() {
        Ok(url) => url,
        Err(error) => {
            return Err(call.error(
                ExceptionKind::ValueError,
                text!(
                    "rpc_factory(): url {error}",
                    "rpc_factory()：参数 url {error}"
                ),
            ));
        }
    };
    call.check_net()?;
    let context = call.shared_context();
    let (host, port) = url.host_and_port();
    context.has_stand_in(host, port);
    let stand_ins = context.extras().stand_ins.clone();
    let client = Rc::new(RpcClient::new(url).with_simulated_peers(stand_ins));
    let remote = MethodHandler::with(Remote { context, client }, Remote::call);
    Ok(call.native().object_with_any_method("rpc", remote))
}

/// A server that is asked.
struct Remote {
    context: Rc<TaskContext>,
    client: Rc<RpcClient>,
}

impl NativeContext for Remote {}

impl Remote {
    fn call(
        &self,
        native: &mut NativeCall<'_>,
        method: &str,
        args: &[Value],
    ) -> Result<Value, Unwind> {
        let arguments = args.iter().map(|value| to_rpc(native, method, value, 0));
        let arguments: Vec<RpcValue> = arguments.collect::<Result<_, _>>()?;
        let (client, name) = (Rc::clone(&self.client), method.to_owned());
        call_external(&self.context, native, method, args, |native| {
            let job = async move { client.call(&name, &arguments).await };
            match super::call::wait_for_future(&self.context, native, method, job)? {
                Ok(value) => native.recurse(|_| Ok(from_rpc(value))),
                Err(error) => Err(native.raise(
                    ExceptionKind::RuntimeError,
                    text!("{method}(): {error}", "{method}()：{error}"),
                )),
            }
        })
    }
}

/// A value of a script as it goes over the line; `method` is named where it cannot.
///
/// # Errors
/// `TypeError`, `ValueError`.
pub fn to_rpc(
    native: &mut NativeCall<'_>,
    method: &str,
    value: &Value,
    depth: usize,
) -> Result<RpcValue, Unwind> {
    if depth > DEPTH_MAX {
        let text = text!(
            "{method}(): an argument is nested deeper than {DEPTH_MAX}",
            "{method}()：参数嵌套超过 {DEPTH_MAX} 层"
        );
        return Err(native.raise(ExceptionKind::ValueError, text));
    }
    let simple = match value {
        Value::None => Some(RpcValue::Nil),
        Value::Bool(level) => Some(RpcValue::Bool(*level)),
        Value::Int(n) => Some(RpcValue::Int(*n)),
        Value::Float(x) => Some(RpcValue::Double(*x)),
        other => match (other.as_str(), other.as_bytes()) {
            (Some(text), _) => Some(RpcValue::Text(text.to_owned())),
            (_, Some(bytes)) => Some(RpcValue::Bytes(bytes)),
            _ => None,
        },
    };
    if let Some(simple) = simple {
        return Ok(simple);
    }
    native.recurse(|native| containing(native, method, value, depth))
}

/// Converts a list, tuple or dict for [`to_rpc`], entry by entry.
fn containing(
    native: &mut NativeCall<'_>,
    method: &str,
    value: &Value,
    depth: usize,
) -> Result<RpcValue, Unwind> {
    if let Some(items) = value.as_items() {
        let items = items
            .iter()
            .map(|item| to_rpc(native, method, item, depth + 1));
        return Ok(RpcValue::Array(items.collect::<Result<_, _>>()?));
    }
    if let Some(entries) = value.as_entries() {
        let mut members = Vec::new();
        for (key, value) in entries {
            let Some(name) = key.as_str().map(str::to_owned) else {
                let text = text!(
                    "{method}(): the keys of a dictionary must be texts, not {}",
                    "{method}()：字典的键必须是文本，不能是 {}",
                    key.type_name()
                );
                return Err(native.raise(ExceptionKind::TypeError, text));
            };
            members.push((name, to_rpc(native, method, &value, depth + 1)?));
        }
        return Ok(RpcValue::Struct(members));
    }
    let text = text!(
        "{method}(): {} cannot be sent; allowed are None, bool, int, float, str, bytes, list, tuple and dict",
        "{method}()：{} 不能发送；允许 None、bool、int、float、str、bytes、list、tuple 和 dict",
        value.type_name()
    );
    Err(native.raise(ExceptionKind::TypeError, text))
}

/// What came over the line as a value of a script.
pub fn from_rpc(value: RpcValue) -> Value {
    match value {
        RpcValue::Nil => Value::None,
        RpcValue::Bool(level) => Value::Bool(level),
        RpcValue::Int(n) => Value::Int(n),
        RpcValue::Double(x) => Value::Float(x),
        RpcValue::Text(text) => Value::str(text),
        RpcValue::Bytes(bytes) => Value::bytes(bytes),
        RpcValue::Array(items) => Value::list(items.into_iter().map(from_rpc).collect()),
        RpcValue::Struct(members) => Value::dict_of(
            members
                .into_iter()
                .map(|(name, value)| (name, from_rpc(value))),
        ),
    }
}
