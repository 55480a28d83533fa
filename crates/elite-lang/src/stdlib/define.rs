//! How native modules are put together: functions, values, classes with data in Rust.

use std::rc::Rc;

use crate::builtins::{BoundFn, Builtin, BuiltinBody, RawFn, Signature};
use crate::eval::{Core, Evaluator};
use crate::value::class::Base;
use crate::value::instance::Payload;
use crate::value::symbol::known;
use crate::value::{Class, Instance, Module, R, Value};

/// Fills one module.
pub struct Builder<'b, 'y> {
    /// What runs the import.
    pub ev: &'b Evaluator<'y>,
    module: &'b Module,
}

/// A function or method: name, signature (see `Signature::parse`), body.
pub type Entry = (&'static str, &'static str, BoundFn);

impl<'b, 'y> Builder<'b, 'y> {
    /// A builder for a module.
    pub fn new(ev: &'b Evaluator<'y>, module: &'b Module) -> Self {
        Builder { ev, module }
    }

    /// What all modules share.
    pub fn core(&self) -> &Rc<Core> {
        &self.ev.core
    }

    /// A name with its value.
    pub fn value(&self, name: &str, value: Value) {
        self.module
            .namespace
            .set(self.core().symbols.intern(name), value);
    }

    /// Functions with bound arguments.
    pub fn functions(&self, list: &[Entry]) {
        // The module that scripts see: `_time` is the inner part of `time`.
        let module: Rc<str> = self.module.name.trim_start_matches('_').into();
        for (name, signature, body) in list {
            let function = Builtin::of_module(self.core(), &module, name, signature, *body);
            self.value(name, function);
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
        methods: &[Entry],
    ) -> Rc<Class> {
        let core = self.core();
        let object = core.types.object.clone();
        let class = Class::new(
            name,
            Base::Native,
            vec![object.clone()],
            vec![object],
            false,
        );
        core.classes.borrow_mut().push(Rc::downgrade(&class));
        class.set(known::MODULE, Value::str(&*self.module.name));
        if let Some((signature, body)) = constructor {
            *class.constructor.borrow_mut() = Builtin::bound(core, name, signature, body);
        }
        for (method, signature, body) in methods {
            let signature = Signature::parse(&format!("self {signature}"), &core.symbols);
            let body = BuiltinBody::Bound(*body);
            let builtin = Builtin {
                name: method,
                owner: Some(name),
                module: None,
                signature,
                body,
            };
            class.set(
                core.symbols.intern(method),
                Value::Builtin(Rc::new(builtin)),
            );
        }
        self.value(name, Value::Class(class.clone()));
        class
    }

    /// A read-only attribute of a class.
    pub fn property(&self, class: &Class, name: &'static str, get: BoundFn) {
        let get = Builtin::bound(self.core(), name, "self", get);
        let none = || Value::None;
        let property = crate::value::function::Property {
            get,
            set: none(),
            delete: none(),
            doc: none(),
        };
        class.set(
            self.core().symbols.intern(name),
            Value::Property(Rc::new(property)),
        );
    }
}

/// An instance of a class of a native module.
pub fn instance(ev: &Evaluator<'_>, class: &str, data: impl std::any::Any) -> R {
    let (module, name) = class.split_once('.').unwrap_or(("", class));
    let Value::Module(module) = ev.import(module)? else {
        return Err(ev.type_error(format!("{class} is not a class")));
    };
    match module.namespace.get(ev.core.symbols.intern(name)) {
        Some(Value::Class(class)) => Ok(Value::Instance(Instance::new(
            class,
            Payload::Object(Box::new(data)),
        ))),
        _ => Err(ev.type_error(format!("{class} is not a class"))),
    }
}

/// Runs `inner` on the Rust data of a receiver, which may be an instance of a subclass.
pub fn with_data<T: 'static, O>(
    ev: &Evaluator<'_>,
    receiver: &Value,
    inner: impl FnOnce(&T) -> R<O>,
) -> R<O> {
    let plain = ev.plain(receiver);
    match &plain {
        Value::Instance(instance) if instance.object::<T>().is_some() => {
            match instance.object::<T>() {
                Some(data) => inner(data),
                None => Err(ev.type_error("wrong receiver")),
            }
        }
        other => {
            let name = ev.core.types.name_of(other);
            Err(ev.type_error(format!("this method cannot be used on a '{name}' object")))
        }
    }
}
