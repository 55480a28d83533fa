//! How native modules are put together: functions, values, classes with data in Rust.

use std::rc::Rc;

use crate::builtins::types::{install_next, joins};
use crate::builtins::{BoundFn, Builtin, BuiltinBody, RawFn, Signature, is_slot, quick};
use crate::eval::{Evaluator, InterpreterState};
use crate::value::class::BuiltinBase;
use crate::value::data::{Contents, NativeData};
use crate::value::function::WrappedFunction;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Class, Instance, Module, R, Value};

/// Fills one module.
pub struct ModuleBuilder<'b, 'y> {
    /// What runs the import.
    pub ev: &'b Evaluator<'y>,
    module: &'b Module,
}

/// A function or method: name, signature (see `Signature::parse`), body.
pub type MethodDef = (&'static str, &'static str, BoundFn);

impl<'b, 'y> ModuleBuilder<'b, 'y> {
    /// A builder for a module.
    pub fn new(ev: &'b Evaluator<'y>, module: &'b Module) -> Self {
        ModuleBuilder { ev, module }
    }

    /// What all modules share.
    pub fn core(&self) -> &Rc<InterpreterState> {
        &self.ev.core
    }

    /// A name with its value.
    pub fn value(&self, name: &str, value: Value) {
        self.module
            .namespace
            .set(self.core().symbols.intern(name), value);
    }

    /// Functions with bound arguments.
    pub fn functions(&self, list: &[MethodDef]) {
        // The module that scripts see: `_time` is the inner part of `time`.
        let module: Rc<str> = self.module.name.trim_start_matches('_').into();
        for (name, signature, body) in list {
            let function = Builtin::of_module(self.core(), &module, name, signature, *body);
            self.value(name, function);
        }
    }

    /// Another name for what a name stands for.
    pub fn alias(&self, alias: &str, name: &str) {
        let symbols = &self.core().symbols;
        if let Some(value) = self.module.namespace.get(symbols.intern(name)) {
            self.value(alias, value);
        }
    }

    /// A function that takes its arguments as they come.
    pub fn raw(&self, name: &'static str, body: RawFn) {
        self.value(name, Builtin::raw(name, body));
    }

    /// A class whose instances carry data in Rust, under its name in the module. Without a constructor scripts cannot
    /// make instances.
    pub fn class(
        &self,
        name: &'static str,
        constructor: Option<(&str, BoundFn)>,
        methods: &[MethodDef],
    ) -> Rc<Class> {
        let class = self.new_class(name, BuiltinBase::Native);
        if let Some((signature, body)) = constructor {
            class
                .constructor
                .put(Builtin::bound(self.core(), name, signature, body));
        }
        for (method, signature, body) in methods {
            let builtin = self.builtin(name, method, &format!("self {signature}"), *body);
            class.set(self.core().symbols.intern(method), builtin);
        }
        class
    }

    /// A class as a `class` statement makes it, extending a builtin type, with methods in Rust: its instances take
    /// attributes and scripts derive from it as from one of their own.
    pub fn derived_class(
        &self,
        name: &'static str,
        base: &Rc<Class>,
        methods: &[MethodDef],
    ) -> R<Rc<Class>> {
        let home = self.module.name.trim_start_matches('_');
        let attrs = vec![(known::MODULE, Value::str(home))];
        let class = self
            .ev
            .make_class(name, &[Value::Class(base.clone())], attrs)?;
        for (method, signature, body) in methods {
            let builtin = self.builtin(name, method, &format!("self {signature}"), *body);
            class.set(self.core().symbols.intern(method), builtin);
        }
        if methods.iter().any(|(name, ..)| *name == "__eq__") {
            class.set(known::HASH, Value::None);
        }
        self.value(name, Value::Class(class.clone()));
        Ok(class)
    }

    /// A method that takes its arguments as they come; the receiver is the first one.
    pub fn raw_method(&self, class: &Class, owner: &'static str, name: &'static str, body: RawFn) {
        let builtin = Builtin {
            name,
            owner: Some(owner),
            module: None,
            signature: Signature::default(),
            body: BuiltinBody::Raw(body),
            stores_args: true,
            fast_path: None,
            sequence_op: None,
            is_slot: is_slot(Some(owner), name),
        };
        class.set(
            self.core().symbols.intern(name),
            Value::Builtin(Rc::new(builtin)),
        );
    }

    fn new_class(&self, name: &'static str, base: BuiltinBase) -> Rc<Class> {
        let core = self.core();
        let object = core.types.object.clone();
        let class = Class::new(name, base, vec![object.clone()], vec![object], false);
        core.note_class(&class);
        class.set(known::MODULE, Value::str(&*self.module.name));
        class.is_c_type.set(true);
        self.value(name, Value::Class(class.clone()));
        class
    }

    fn builtin(
        &self,
        owner: &'static str,
        name: &'static str,
        signature: &str,
        body: BoundFn,
    ) -> Value {
        Value::Builtin(Rc::new(Builtin {
            name,
            owner: Some(owner),
            module: None,
            signature: Signature::parse(signature, &self.core().symbols),
            body: BuiltinBody::Bound(body),
            stores_args: true,
            fast_path: quick::find(Some(owner), None, name),
            sequence_op: joins(owner, name),
            is_slot: is_slot(Some(owner), name),
        }))
    }

    /// A class of iterators (`Iter::Native`).
    pub fn iterator_class(
        &self,
        name: &'static str,
        constructor: Option<(&str, BoundFn)>,
    ) -> Rc<Class> {
        let class = self.new_class(name, BuiltinBase::Iterator);
        if let Some((signature, body)) = constructor {
            class
                .constructor
                .put(Builtin::bound(self.core(), name, signature, body));
        }
        install_next(self.core(), &class);
        class
    }

    /// Like `iterator_class`, with a constructor that takes its arguments as they come.
    pub fn raw_iterator_class(&self, name: &'static str, constructor: RawFn) -> Rc<Class> {
        let class = self.iterator_class(name, None);
        class.constructor.put(Builtin::raw(name, constructor));
        class
    }

    /// One more method of a class of this module.
    pub fn method(&self, class: &Class, name: &'static str, signature: &str, body: BoundFn) {
        let builtin = self.builtin("object", name, &format!("self {signature}"), body);
        class.set(self.core().symbols.intern(name), builtin);
    }

    /// A class method of a class of this module; the class is its first argument.
    pub fn class_method(&self, class: &Class, name: &'static str, signature: &str, body: BoundFn) {
        let builtin = self.builtin("type", name, &format!("cls {signature}"), body);
        class.set(
            self.core().symbols.intern(name),
            Value::ClassMethod(WrappedFunction::around(builtin)),
        );
    }

    /// A read-only attribute of a class.
    pub fn property(&self, class: &Class, name: &'static str, get: BoundFn) {
        let get = Builtin::bound(self.core(), name, "self", get);
        let none = || Value::None;
        let property = crate::value::function::Property::of(get, none(), none(), none());
        class.set(
            self.core().symbols.intern(name),
            Value::Property(Rc::new(property)),
        );
    }
}

/// A class of a native module: `_collections.deque`.
pub fn native_class(ev: &Evaluator<'_>, class: &str) -> R<Rc<Class>> {
    let (module, name) = class.split_once('.').unwrap_or(("", class));
    if let Value::Module(module) = ev.import(module)?
        && let Some(Value::Class(class)) = module.namespace.get(ev.core.symbols.intern(name))
    {
        return Ok(class);
    }
    Err(ev.type_error(format!("{class} is not a class")))
}

/// An instance of a class of a native module.
pub fn instance(ev: &Evaluator<'_>, class: &str, data: impl Contents) -> R {
    Ok(Value::Instance(Instance::new(
        native_class(ev, class)?,
        InstancePayload::Object(NativeData::new(data)),
    )))
}

/// Runs `inner` on the Rust data of a receiver, which may be an instance of a subclass.
pub fn with_data<T: 'static, O>(
    ev: &Evaluator<'_>,
    receiver: &Value,
    inner: impl FnOnce(&T) -> R<O>,
) -> R<O> {
    let plain = ev.unwrap_builtin(receiver);
    let data = match &plain {
        Value::Instance(instance) => instance.object::<T>(),
        _ => None,
    };
    match data {
        Some(data) => inner(data),
        None => {
            let name = ev.core.types.name_of(&plain);
            Err(ev.type_error(format!("this method cannot be used on a '{name}' object")))
        }
    }
}
