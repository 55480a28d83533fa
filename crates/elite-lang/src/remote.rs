//! Objects of the embedder that answer to any method name, as handles of remote calls do.

use std::rc::Rc;

use crate::builtins::Builtin;
use crate::builtins::EMBEDDER;
use crate::errors::ExceptionKind;
use crate::native::{NativeCall, NativeContext};
use crate::value::class::BuiltinBase;
use crate::value::data::{NativeData, no_values};
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Class, Instance, R, Value};

/// What a call of any method does, given its name and its positional arguments. It holds no values.
#[derive(Clone)]
pub struct MethodHandler(Rc<MethodHandlerFn>);

type MethodHandlerFn = dyn Fn(&mut NativeCall<'_>, &str, &[Value]) -> R;

no_values!(MethodHandler);

impl MethodHandler {
    /// A function with a context.
    pub fn with<C: NativeContext>(
        context: C,
        body: impl Fn(&C, &mut NativeCall<'_>, &str, &[Value]) -> R + Send + 'static,
    ) -> Self {
        MethodHandler(Rc::new(move |call, name, args| {
            body(&context, call, name, args)
        }))
    }
}

impl NativeCall<'_> {
    /// An object of a class of its own whose methods, all names but `__special__` ones, are `call`.
    pub fn object_with_any_method(&self, class_name: &str, call: MethodHandler) -> Value {
        let core = &self.ev.core;
        let object = core.types.object.clone();
        let class = Class::new(
            class_name,
            BuiltinBase::Object,
            vec![object.clone()],
            vec![object.clone()],
            false,
        );
        let call = Instance::new(object, InstancePayload::Object(NativeData::new(call)));
        let held = vec![Value::Instance(call)];
        let getattr = Builtin::closure("__getattr__", held, |ev, held, args| {
            let name = args.positional.last().and_then(Value::as_str);
            let name = name.unwrap_or_default().to_owned();
            if name.starts_with("__") {
                let text = format!("a remote object has no attribute '{name}'");
                return Err(ev.raise(ExceptionKind::AttributeError, text));
            }
            Ok(method(name, held.to_vec()))
        });
        class.set(known::GETATTR, getattr);
        Value::Instance(Instance::new(class, InstancePayload::None))
    }
}

/// The method of this name; what its calls do is held.
fn method(name: String, held: Vec<Value>) -> Value {
    Builtin::closure("remote method", held, move |ev, held, args| {
        if !args.keywords.is_empty() {
            let text =
                format!("{name}() takes no keyword arguments: remote calls have only positions");
            return Err(ev.raise(ExceptionKind::TypeError, text));
        }
        let mut native = NativeCall {
            ev,
            args: &[],
            caller: None,
        };
        match held {
            [Value::Instance(held)] if let Some(call) = held.object::<MethodHandler>() => {
                ev.with_stack(EMBEDDER, || (call.0)(&mut native, &name, args.positional))
            }
            _ => Ok(Value::None),
        }
    })
}

impl Value {
    /// Bytes.
    pub fn bytes(data: Vec<u8>) -> Value {
        Value::Bytes(Rc::new(crate::value::Bytes::new(data)))
    }

    /// The data of bytes or a bytearray.
    pub fn as_bytes(&self) -> Option<Vec<u8>> {
        match self {
            Value::Bytes(bytes) => Some(bytes.data().to_vec()),
            Value::ByteArray(bytes) => Some(bytes.borrow().to_vec()),
            _ => None,
        }
    }

    /// Keys and values of a dictionary, in order.
    pub fn as_entries(&self) -> Option<Vec<(Value, Value)>> {
        match self {
            Value::Dict(dict) => {
                let entries = dict.entries().into_iter();
                Some(entries.map(|(_, key, value)| (key, value)).collect())
            }
            _ => None,
        }
    }
}
