//! Making instances, and the computed attributes of functions, exceptions and other builtin values.

use std::rc::Rc;

use crate::eval::{Evaluator, Frame};
use crate::value::attrs::AttrMap;
use crate::value::class::Base;
use crate::value::exception::ExceptionState;
use crate::value::instance::Payload;
use crate::value::symbol::known;
use crate::value::{Class, Function, Instance, R, Symbol, Value};

impl Evaluator<'_> {
    /// Calls a class.
    pub fn instantiate(
        &self,
        class: &Rc<Class>,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
        caller: Option<&mut Frame<'_>>,
    ) -> R {
        if !class.is_script {
            let constructor = class.constructor.borrow().clone();
            if !constructor.is_unbound() {
                return self.call_from(&constructor, args, keywords, caller);
            }
            if class.base == Base::Exception {
                return self.new_exception(class, args.to_vec(), keywords);
            }
        }
        self.instantiate_script_class(class, args, keywords)
    }

    fn instantiate_script_class(
        &self,
        class: &Rc<Class>,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
    ) -> R {
        let new = if class.is_script {
            class.lookup(known::NEW)
        } else {
            None
        };
        let init = class.lookup(known::INIT);
        let object = match &new {
            Some(new) => {
                let new = if let Value::StaticMethod(function) = new {
                    function
                } else {
                    new
                };
                let mut all = vec![Value::Class(class.clone())];
                all.extend_from_slice(args);
                let object = self.call(new, &mut all, keywords)?;
                let is_instance = matches!(&object, Value::Instance(instance) if instance.class.is_subclass_of(class));
                if !is_instance {
                    return Ok(object);
                }
                object
            }
            None => {
                let needs_args = init.is_none() && matches!(class.base, Base::Object);
                if needs_args && (!args.is_empty() || !keywords.is_empty()) {
                    return Err(self.type_error(format!("{}() takes no arguments", class.name())));
                }
                self.allocate(class, args, keywords)?
            }
        };
        if let Some(init) = init {
            let result = match &init {
                Value::Function(_) | Value::Builtin(_) => {
                    crate::builtins::with_first(object.clone(), args, |all| {
                        self.call(&init, all, keywords)
                    })?
                }
                _ => {
                    let bound = self.bind_attribute(&init, &object, class)?;
                    self.call(&bound, args, keywords)?
                }
            };
            if !result.is_none() {
                let name = self.core.types.name_of(&result);
                return Err(self.type_error(format!("__init__() should return None, not '{name}'")));
            }
        }
        Ok(object)
    }

    /// An instance before `__init__`. Subclasses of builtin types get the value they extend from the arguments.
    pub fn allocate(&self, class: &Rc<Class>, args: &[Value], keywords: &[(Symbol, Value)]) -> R {
        let payload = match class.base {
            Base::Object => Payload::None,
            Base::Exception => Payload::Exception(Box::new(ExceptionState::with_args(
                Value::tuple(args.to_vec()),
            ))),
            _ => return self.allocate_extended(class, args, keywords),
        };
        Ok(Value::Instance(Instance::new(class.clone(), payload)))
    }

    fn allocate_extended(
        &self,
        class: &Rc<Class>,
        args: &[Value],
        keywords: &[(Symbol, Value)],
    ) -> R {
        let Some(builtin) = class.ancestors().iter().find(|class| !class.is_script) else {
            let name = class.name();
            return Err(self.type_error(format!("cannot create '{name}' instances")));
        };
        let constructor = builtin.constructor.borrow().clone();
        // Mutable containers are filled by `__init__`; immutable values take the arguments now.
        let is_mutable = matches!(
            class.base,
            Base::List | Base::Dict | Base::Set | Base::ByteArray | Base::Native
        );
        let made = if is_mutable && class.lookup(known::INIT).is_some() {
            self.call(&constructor, &mut [], &[])?
        } else {
            self.call(&constructor, &mut args.to_vec(), keywords)?
        };
        let payload = Payload::Value(std::cell::RefCell::new(made));
        Ok(Value::Instance(Instance::new(class.clone(), payload)))
    }

    fn new_exception(
        &self,
        class: &Rc<Class>,
        args: Vec<Value>,
        keywords: &[(Symbol, Value)],
    ) -> R {
        if !keywords.is_empty() {
            return Err(self.type_error(format!("{}() takes no keyword arguments", class.name())));
        }
        let state = ExceptionState::with_args(Value::tuple(args));
        Ok(Value::Instance(Instance::new(
            class.clone(),
            Payload::Exception(Box::new(state)),
        )))
    }

    /// Attributes that exceptions have by nature.
    pub fn exception_attribute(
        &self,
        instance: &Rc<Instance>,
        state: &ExceptionState,
        name: Symbol,
    ) -> Option<Value> {
        let or_none = |value: &Value| {
            if value.is_unbound() {
                Value::None
            } else {
                value.clone()
            }
        };
        Some(match name {
            known::ARGS => state.args(),
            known::CAUSE => or_none(&state.cause.borrow()),
            known::CONTEXT => or_none(&state.context.borrow()),
            known::SUPPRESS_CONTEXT => Value::Bool(state.suppress_context.get()),
            known::TRACEBACK => Value::None,
            known::VALUE => {
                let stop = self
                    .core
                    .types
                    .exception(crate::errors::ExceptionKind::StopIteration);
                if !instance.class.is_subclass_of(stop) {
                    return None;
                }
                first_argument(state)
            }
            known::CODE => {
                let exit = self
                    .core
                    .types
                    .exception(crate::errors::ExceptionKind::SystemExit);
                if !instance.class.is_subclass_of(exit) {
                    return None;
                }
                first_argument(state)
            }
            _ => return self.os_error_attribute(instance, state, name),
        })
    }

    fn os_error_attribute(
        &self,
        instance: &Rc<Instance>,
        state: &ExceptionState,
        name: Symbol,
    ) -> Option<Value> {
        let os_error = self
            .core
            .types
            .exception(crate::errors::ExceptionKind::OSError);
        if !instance.class.is_subclass_of(os_error) {
            return None;
        }
        let index = match &*self.core.symbols.name(name) {
            "errno" => 0,
            "strerror" => 1,
            "filename" => 2,
            _ => return None,
        };
        let Value::Tuple(args) = state.args() else {
            return None;
        };
        let enough = args.items().len() >= 2;
        Some(
            args.items()
                .get(index)
                .filter(|_| enough)
                .cloned()
                .unwrap_or(Value::None),
        )
    }

    /// Sets attributes that exceptions have by nature; false if `name` is none of them.
    pub fn set_exception_attribute(
        &self,
        state: &ExceptionState,
        name: Symbol,
        new: &Value,
    ) -> R<bool> {
        let chained = |place: &std::cell::RefCell<Value>| {
            *place.borrow_mut() = if new.is_none() {
                Value::Unbound
            } else {
                new.clone()
            };
        };
        match name {
            known::ARGS => state.set_args(Value::tuple(self.collect(new)?)),
            known::CAUSE => {
                chained(&state.cause);
                state.suppress_context.set(true);
            }
            known::CONTEXT => chained(&state.context),
            known::SUPPRESS_CONTEXT => state.suppress_context.set(self.truth(new)?),
            known::TRACEBACK => {}
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Attributes that functions have by nature.
    pub fn function_attribute(&self, function: &Rc<Function>, name: Symbol) -> Option<Value> {
        Some(match name {
            known::NAME => Value::str(&*function.code.name),
            known::QUALNAME => Value::str(&*function.code.qualname),
            known::DOC => function.code.doc.as_deref().map_or(Value::None, Value::str),
            known::MODULE => Value::str("__main__"),
            known::DEFAULTS => {
                let defaults = function.defaults.borrow();
                if defaults.is_empty() {
                    Value::None
                } else {
                    Value::tuple(defaults.to_vec())
                }
            }
            known::DICT | known::ANNOTATIONS => {
                let dict = crate::value::Dict::new();
                if name == known::DICT
                    && let Some(attrs) = &*function.attrs.borrow()
                {
                    for (name, value) in attrs.iter() {
                        dict.set_interned(self.core.symbols.value(name), value.clone());
                    }
                }
                Value::Dict(Rc::new(dict))
            }
            _ => return None,
        })
    }

    /// `function.name = new`
    pub fn set_function_attribute(
        &self,
        function: &Rc<Function>,
        name: Symbol,
        new: Value,
    ) -> R<()> {
        if name == known::DEFAULTS {
            let defaults = if new.is_none() {
                Vec::new()
            } else {
                self.collect(&new)?
            };
            *function.defaults.borrow_mut() = defaults.into();
            return Ok(());
        }
        let mut attrs = function.attrs.borrow_mut();
        let old = attrs
            .get_or_insert_with(|| Box::new(AttrMap::default()))
            .insert(name, new);
        drop(attrs);
        drop(old);
        Ok(())
    }

    /// Attributes of builtin values that are computed when asked for.
    pub fn computed_attribute(&self, value: &Value, name: Symbol) -> R<Option<Value>> {
        Ok(Some(match (value, name) {
            (Value::Int(_) | Value::BigInt(_) | Value::Float(_), known::REAL)
            | (Value::Int(_) | Value::BigInt(_), known::NUMERATOR) => value.clone(),
            (Value::Bool(flag), known::REAL | known::NUMERATOR) => Value::Int(i64::from(*flag)),
            (Value::Int(_) | Value::BigInt(_) | Value::Bool(_), known::IMAG) => Value::Int(0),
            (Value::Int(_) | Value::BigInt(_) | Value::Bool(_), known::DENOMINATOR) => {
                Value::Int(1)
            }
            (Value::Float(_), known::IMAG) => Value::Float(0.0),
            (Value::Complex(complex), known::REAL) => Value::Float(complex.0),
            (Value::Complex(complex), known::IMAG) => Value::Float(complex.1),
            (Value::Range(range), known::START) => Value::Int(range.start),
            (Value::Range(range), known::STOP) => Value::Int(range.stop),
            (Value::Range(range), known::STEP) => Value::Int(range.step),
            (Value::Slice(slice), known::START) => slice.start.clone(),
            (Value::Slice(slice), known::STOP) => slice.stop.clone(),
            (Value::Slice(slice), known::STEP) => slice.step.clone(),
            (Value::BoundMethod(method), known::SELF) => method.receiver.clone(),
            (Value::BoundMethod(method), known::FUNC) => method.function.clone(),
            (
                Value::BoundMethod(method),
                known::NAME | known::QUALNAME | known::DOC | known::MODULE,
            ) => {
                return self.attribute_or_none(&method.function, name);
            }
            (Value::Builtin(builtin), known::NAME) => Value::str(builtin.name),
            (Value::Builtin(builtin), known::QUALNAME) => Value::str(&*builtin.label()),
            (Value::Generator(generator), known::NAME) => {
                Value::str(&*generator.function.code.name)
            }
            (Value::Generator(generator), known::QUALNAME) => {
                Value::str(&*generator.function.code.qualname)
            }
            (Value::Property(property), known::FGET) => property.get.clone(),
            (Value::Property(property), known::FSET) => property.set.clone(),
            (Value::Property(property), known::FDEL) => property.delete.clone(),
            (Value::Property(property), known::DOC) => property.doc.clone(),
            (
                Value::StaticMethod(function) | Value::ClassMethod(function),
                known::FUNC | known::WRAPPED,
            ) => (**function).clone(),
            _ => return Ok(None),
        }))
    }
}

fn first_argument(state: &ExceptionState) -> Value {
    match state.args() {
        Value::Tuple(args) => args.items().first().cloned().unwrap_or(Value::None),
        _ => Value::None,
    }
}
