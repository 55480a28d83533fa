//! Objects of the embedder with methods and attributes of their own, as a test finds `test`.

use crate::builtins::Builtin;
use crate::eval::InterpreterState;
use crate::native::{NativeCall, NativeFunction};
use crate::value::class::BuiltinBase;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Class, Instance, Symbol, Unwind, Value};

impl NativeCall<'_> {
    /// An object whose attributes are functions of the embedder and other values.
    pub fn object(
        &self,
        class_name: &str,
        methods: Vec<NativeFunction>,
        attributes: Vec<(&str, Value)>,
    ) -> Value {
        object(&self.ev.core, class_name, methods, attributes)
    }
}

impl NativeCall<'_> {
    /// The names of an exception's class and of those it is derived from; none for the stop of the thread.
    pub fn ancestors(&self, raised: &Unwind) -> Vec<String> {
        match raised {
            Unwind::Exception(exception) => {
                let classes = exception.class.mro();
                classes
                    .iter()
                    .map(|class| class.name().to_string())
                    .collect()
            }
            Unwind::Stop => Vec::new(),
        }
    }

    /// Adds an item to a list; anything else stays as it is.
    pub fn append(&self, list: &Value, item: Value) {
        if let Value::List(list) = list {
            list.push(item);
        }
    }
}

/// An object whose attributes are functions of the embedder and other values, for callers that have no call of a
/// native.
pub(crate) fn object(
    core: &InterpreterState,
    class_name: &str,
    methods: Vec<NativeFunction>,
    attributes: Vec<(&str, Value)>,
) -> Value {
    let ancestor = core.types.object.clone();
    let class = Class::new(
        class_name,
        BuiltinBase::Object,
        vec![ancestor.clone()],
        vec![ancestor],
        false,
    );
    if !attributes.is_empty() {
        let name: Box<str> = class_name.into();
        let shown: Vec<Symbol> = attributes
            .iter()
            .map(|(name, _)| core.symbols.intern(name))
            .collect();
        let repr = Builtin::closure("__repr__", Vec::new(), move |ev, _, args| {
            let object = args.positional.first().cloned().unwrap_or_default();
            let mut parts = Vec::new();
            for symbol in &shown {
                let value = ev.attribute(&object, *symbol)?;
                parts.push(format!(
                    "{}={}",
                    ev.core.symbols.name(*symbol),
                    ev.repr(&value)?
                ));
            }
            Ok(Value::str(format!("{name}({})", parts.join(", "))))
        });
        class.set(known::REPR, repr);
    }
    let instance = Instance::new(class, InstancePayload::None);
    for method in methods {
        let name = core.symbols.intern(method.name);
        instance.set(name, Builtin::native(core, method), &core.symbols);
    }
    for (name, value) in attributes {
        instance.set(core.symbols.intern(name), value, &core.symbols);
    }
    Value::Instance(instance)
}
