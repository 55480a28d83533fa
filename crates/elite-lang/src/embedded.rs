//! Objects of the embedder with methods and attributes of their own, as a test finds `test`.

use crate::builtins::Builtin;
use crate::eval::Core;
use crate::native::{NativeCall, NativeFunction};
use crate::value::class::Base;
use crate::value::instance::Payload;
use crate::value::{Class, Instance, Value};

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

/// The same outside of a call.
pub(crate) fn object(
    core: &Core,
    class_name: &str,
    methods: Vec<NativeFunction>,
    attributes: Vec<(&str, Value)>,
) -> Value {
    let ancestor = core.types.object.clone();
    let class = Class::new(
        class_name,
        Base::Object,
        vec![ancestor.clone()],
        vec![ancestor],
        false,
    );
    let instance = Instance::new(class, Payload::None);
    for method in methods {
        let name = core.symbols.intern(method.name);
        instance.set(name, Builtin::native(core, method), &core.symbols);
    }
    for (name, value) in attributes {
        instance.set(core.symbols.intern(name), value, &core.symbols);
    }
    Value::Instance(instance)
}
