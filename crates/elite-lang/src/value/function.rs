//! Functions of scripts and what wraps them: bound methods, properties, `super`.

use std::cell::Cell;
use std::rc::Rc;

use super::attrs::AttrMap;
use super::symbol::known;
use super::{CellVar, Class, ScriptCell, Value};
use crate::eval::code::Code;
use crate::limits::deferred_drop;

/// A function: code, defaults and the variables it shares with functions around it.
pub struct Function {
    /// What runs.
    pub code: Rc<Code>,
    /// Defaults of the last positional parameters.
    pub defaults: ScriptCell<Rc<[Value]>>,
    /// Defaults of the keyword-only parameters, `Unbound` where there is none.
    pub keyword_defaults: Box<[Value]>,
    /// Defaults of the keyword-only parameters as a dictionary, once a script has asked for it or set it.
    pub keyword_defaults_dict: ScriptCell<Option<Value>>,
    /// `__annotations__`; None until there are any.
    pub annotations: ScriptCell<Option<Value>>,
    /// Cells of outer functions.
    pub closure: Box<[Rc<CellVar>]>,
    /// Attributes set by scripts, and what `__name__` and the like were changed to.
    pub attrs: ScriptCell<Option<Box<AttrMap>>>,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

impl Function {
    /// A function without defaults.
    pub fn without_defaults(code: Rc<Code>, closure: Box<[Rc<CellVar>]>) -> Rc<Self> {
        let defaults = ScriptCell::new(Rc::from([]));
        Rc::new(Function {
            code,
            defaults,
            keyword_defaults: Box::default(),
            keyword_defaults_dict: ScriptCell::default(),
            annotations: ScriptCell::default(),
            closure,
            attrs: ScriptCell::default(),
            noted: Cell::new(false),
            old: Cell::new(false),
        })
    }

    /// `__qualname__`, which scripts may have changed.
    pub fn qualname(&self) -> Rc<str> {
        match self
            .attrs
            .borrow()
            .as_ref()
            .and_then(|attrs| attrs.get(known::QUALNAME))
        {
            Some(Value::Str(text)) => text.as_str().into(),
            _ => self.code.qualname.clone(),
        }
    }
}

impl Drop for Function {
    fn drop(&mut self) {
        if let Some(attrs) = self.attrs.get_mut() {
            deferred_drop::drop_values(&mut attrs.take_values());
        }
        // Shared ones are dropped by the last who has them.
        if let Some(defaults) = Rc::get_mut(self.defaults.get_mut()) {
            deferred_drop::drop_slice(defaults);
        }
        deferred_drop::drop_slice(&mut self.keyword_defaults);
        for held in [&mut self.keyword_defaults_dict, &mut self.annotations] {
            if let Some(value) = held.get_mut() {
                deferred_drop::drop_value(value);
            }
        }
    }
}

/// A function with its first argument.
pub struct BoundMethod {
    /// The object before the dot.
    pub receiver: Value,
    /// What is called, with the receiver first.
    pub function: Value,
}

impl BoundMethod {
    /// Whether it is a method of a builtin type, which is of another type in CPython than what a script has bound.
    #[inline]
    pub fn is_builtin(&self) -> bool {
        matches!(&self.function, Value::Builtin(builtin) if builtin.owner.is_some())
    }
}

impl Drop for BoundMethod {
    fn drop(&mut self) {
        deferred_drop::drop_each([&mut self.receiver, &mut self.function]);
    }
}

/// What a static or class method wraps: usually a function.
pub struct WrappedFunction {
    function: Value,
    /// `__dict__`; None until a script asks for it or sets an attribute.
    pub attrs: ScriptCell<Option<Value>>,
}

impl WrappedFunction {
    /// For a static or class method around a value.
    pub fn around(function: Value) -> Rc<Self> {
        let attrs = ScriptCell::default();
        Rc::new(WrappedFunction { function, attrs })
    }
}

impl std::ops::Deref for WrappedFunction {
    type Target = Value;

    #[inline]
    fn deref(&self) -> &Value {
        &self.function
    }
}

impl Drop for WrappedFunction {
    fn drop(&mut self) {
        // Methods may be wrapped again and again, so a chain of them is taken apart without recursion.
        deferred_drop::drop_value(&mut self.function);
        if let Some(attrs) = self.attrs.get_mut() {
            deferred_drop::drop_value(attrs);
        }
    }
}

/// A property; parts that are missing are `None`.
#[allow(missing_docs)]
pub struct Property {
    pub get: Value,
    pub set: Value,
    pub delete: Value,
    pub doc: ScriptCell<Value>,
    /// The documentation is the getter's.
    pub is_getters_doc: bool,
    /// What it is called in its class, `Unbound` until a class tells it.
    pub name: ScriptCell<Value>,
}

impl Property {
    /// A property of the interpreter's own.
    pub fn of(get: Value, set: Value, delete: Value, doc: Value) -> Self {
        Property {
            get,
            set,
            delete,
            doc: ScriptCell::new(doc),
            is_getters_doc: false,
            name: ScriptCell::default(),
        }
    }

    /// The property's own name, or the one it was asked by.
    pub fn name_or(&self, asked: &str) -> String {
        match &*self.name.borrow() {
            Value::Str(own) => own.as_str().to_owned(),
            _ => asked.to_owned(),
        }
    }
}

impl Drop for Property {
    fn drop(&mut self) {
        deferred_drop::drop_each([
            &mut self.get,
            &mut self.set,
            &mut self.delete,
            self.doc.get_mut(),
        ]);
    }
}

/// A `super()` object: looks attributes up in the classes after `class`.
pub struct Super {
    /// Lookup starts after this class.
    pub class: Rc<Class>,
    /// The object methods are bound to: an instance or, in class methods, a class. `Unbound` if there is none yet.
    pub receiver: Value,
    /// The class whose resolution order is followed.
    pub receiver_class: Rc<Class>,
}

impl Drop for Super {
    fn drop(&mut self) {
        deferred_drop::drop_value(&mut self.receiver);
    }
}
