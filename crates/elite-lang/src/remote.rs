//! Objects of the embedder that answer to any method name, as handles of remote calls do.

use std::rc::Rc;

use crate::builtins::Builtin;
use crate::errors::ExceptionKind;
use crate::native::NativeCall;
use crate::value::class::Base;
use crate::value::instance::Payload;
use crate::value::symbol::known;
use crate::value::{Class, Instance, R, Value};

/// What a call of any method does, given its name and its positional arguments.
pub type AnyMethod = Rc<dyn Fn(&mut NativeCall<'_>, &str, &[Value]) -> R>;

impl NativeCall<'_> {
    /// An object of a class of its own whose methods, all names but `__special__` ones, are `call`.
    pub fn object_with_any_method(&self, class_name: &str, call: AnyMethod) -> Value {
        let core = &self.ev.core;
        let object = core.types.object.clone();
        let class = Class::new(
            class_name,
            Base::Object,
            vec![object.clone()],
            vec![object],
            false,
        );
        let getattr = Builtin::closure("__getattr__", Vec::new(), move |ev, _, args| {
            let name = args.positional.last().and_then(Value::as_str);
            let name = name.unwrap_or_default().to_owned();
            if name.starts_with("__") {
                let text = format!("a remote object has no attribute '{name}'");
                return Err(ev.raise(ExceptionKind::AttributeError, text));
            }
            let call = Rc::clone(&call);
            Ok(Builtin::closure(
                "remote method",
                Vec::new(),
                move |ev, _, args| {
                    if !args.keywords.is_empty() {
                        let text = format!(
                            "{name}() takes no keyword arguments: remote calls have only positions"
                        );
                        return Err(ev.raise(ExceptionKind::TypeError, text));
                    }
                    let mut native = NativeCall {
                        ev,
                        args: &[],
                        caller: None,
                    };
                    call(&mut native, &name, args.positional)
                },
            ))
        });
        class.set(known::GETATTR, getattr);
        Value::Instance(Instance::new(class, Payload::None))
    }
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
            Value::ByteArray(bytes) => Some(bytes.borrow().clone()),
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
