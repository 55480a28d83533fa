//! Attributes that are computed when they are asked for: of functions, exceptions and other builtin values.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::attrs::AttrMap;
use crate::value::exception::ExceptionState;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Function, Instance, R, ScriptCell, Symbol, Value};

impl Evaluator<'_> {
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
        if let Some(group) = state.group.get() {
            match &*self.core.symbols.name(name) {
                "message" => return Some(group.message.clone()),
                "exceptions" => return Some(group.exceptions.clone()),
                _ => {}
            }
        }
        Some(match name {
            known::ARGS => state.args(),
            known::CAUSE => or_none(&state.cause.get()),
            known::CONTEXT => or_none(&state.context.get()),
            known::SUPPRESS_CONTEXT => Value::Bool(state.suppress_context.get()),
            known::TRACEBACK => self.traceback_object(state),
            known::VALUE => {
                let stop = self.core.types.exception(ExceptionKind::StopIteration);
                if !instance.class.is_subclass_of(stop) {
                    return None;
                }
                first_argument(state)
            }
            known::CODE => {
                let exit = self.core.types.exception(ExceptionKind::SystemExit);
                if !instance.class.is_subclass_of(exit) {
                    return None;
                }
                match state.args() {
                    Value::Tuple(args) if args.items().len() > 1 => Value::Tuple(args),
                    _ => first_argument(state),
                }
            }
            _ if &*self.core.symbols.name(name) == "msg" => {
                let import = self.core.types.exception(ExceptionKind::ImportError);
                if !instance.class.is_subclass_of(import) {
                    return None;
                }
                first_argument(state)
            }
            _ if matches!(&*self.core.symbols.name(name), "name" | "path" | "obj") => {
                let has = |kind| {
                    instance
                        .class
                        .is_subclass_of(self.core.types.exception(kind))
                };
                let known = match &*self.core.symbols.name(name) {
                    "name" => {
                        has(ExceptionKind::ImportError)
                            || has(ExceptionKind::NameError)
                            || has(ExceptionKind::AttributeError)
                    }
                    "path" => has(ExceptionKind::ImportError),
                    _ => has(ExceptionKind::AttributeError),
                };
                return known.then_some(Value::None);
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
        let os_error = self.core.types.exception(ExceptionKind::OSError);
        if !instance.class.is_subclass_of(os_error) {
            return None;
        }
        let index = match &*self.core.symbols.name(name) {
            "errno" => 0,
            "strerror" => 1,
            "filename" | "filename2" => 2,
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
        let chained = |place: &ScriptCell<Value>| {
            place.put(match new {
                Value::None => Value::Unbound,
                new => new.clone(),
            });
        };
        if state.group.get().is_some()
            && matches!(&*self.core.symbols.name(name), "message" | "exceptions")
        {
            return Err(self.raise(ExceptionKind::AttributeError, "readonly attribute"));
        }
        match name {
            known::ARGS => state.set_args(self.collect(new)?.into_tuple()),
            known::CAUSE | known::CONTEXT if !self.is_exception_or_none(new) => {
                let what = if name == known::CAUSE {
                    "cause"
                } else {
                    "context"
                };
                return Err(self.type_error(format!(
                    "exception {what} must be None or derive from BaseException"
                )));
            }
            known::CAUSE => {
                chained(&state.cause);
                state.suppress_context.set(true);
            }
            known::CONTEXT => state.context.put(new.clone()),
            known::SUPPRESS_CONTEXT => state.suppress_context.set(self.truth(new)?),
            known::TRACEBACK => {}
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// What `__traceback__` and `__exit__` get: an object that only tells that there is one, and its last line.
    pub fn traceback_object(&self, state: &ExceptionState) -> Value {
        let traceback = state.traceback();
        let Some(place) = traceback.last() else {
            return Value::None;
        };
        let line = place.code.file.position(place.span.start).line;
        let object = Instance::new(self.core.types.traceback.clone(), InstancePayload::None);
        let symbols = &self.core.symbols;
        object.set(
            symbols.intern("tb_lineno"),
            Value::Int(i64::from(line)),
            symbols,
        );
        object.set(symbols.intern("tb_next"), Value::None, symbols);
        Value::Instance(object)
    }

    fn is_exception_or_none(&self, value: &Value) -> bool {
        match value {
            Value::None => true,
            Value::Instance(instance) => instance.exception().is_some(),
            _ => false,
        }
    }

    /// Attributes that functions have by nature.
    pub fn function_attribute(&self, function: &Rc<Function>, name: Symbol) -> R<Option<Value>> {
        Ok(Some(match name {
            known::NAME => Value::str(&*function.code.name),
            known::QUALNAME => Value::str(&*function.code.qualname),
            known::DOC => function.code.doc.as_deref().map_or(Value::None, Value::str),
            known::MODULE => self.module_of(&function.code),
            known::DEFAULTS => {
                let defaults = function.defaults.borrow();
                if defaults.is_empty() {
                    Value::None
                } else {
                    Value::tuple(defaults.to_vec())
                }
            }
            known::KWDEFAULTS => self.keyword_defaults_dict(function),
            known::ANNOTATIONS => {
                let known = function.annotations.get();
                known.unwrap_or_else(|| {
                    let dict = Value::Dict(Rc::new(crate::value::Dict::new()));
                    function.annotations.put(Some(dict.clone()));
                    dict
                })
            }
            known::DICT => {
                let dict = self.dict_of_attributes(|from, count, out| {
                    let attrs = function.attrs.borrow();
                    let more = attrs
                        .as_ref()
                        .is_some_and(|attrs| attrs.entries_chunk(from, count, out));
                    out.retain(|(name, _)| !is_by_nature(*name));
                    more
                })?;
                Value::Dict(Rc::new(dict))
            }
            _ => return Ok(self.made_of(function, &self.core.symbols.name(name))),
        }))
    }

    /// `function.name = new`
    pub fn set_function_attribute(
        &self,
        function: &Rc<Function>,
        name: Symbol,
        new: Value,
    ) -> R<()> {
        if matches!(name, known::NAME | known::QUALNAME) && !matches!(new, Value::Str(_)) {
            let name = self.core.symbols.name(name);
            return Err(self.type_error(format!("{name} must be set to a string object")));
        }
        if name == known::DEFAULTS {
            let defaults = match &new {
                Value::None => Vec::new(),
                Value::Tuple(tuple) => tuple.items().to_vec(),
                _ => return Err(self.type_error("__defaults__ must be set to a tuple object")),
            };
            self.core.note_function(function);
            function.defaults.put(defaults.into());
            return Ok(());
        }
        match name {
            known::KWDEFAULTS => {
                let defaults = match &new {
                    Value::None | Value::Dict(_) => new,
                    _ => return Err(self.type_error("__kwdefaults__ must be set to a dict object")),
                };
                self.core.note_function(function);
                function.keyword_defaults_dict.put(Some(defaults));
                return Ok(());
            }
            known::ANNOTATIONS => {
                let annotations = match &new {
                    Value::None => None,
                    Value::Dict(_) => Some(new),
                    _ => {
                        let text = "__annotations__ must be set to a dict object";
                        return Err(self.type_error(text));
                    }
                };
                self.core.note_function(function);
                function.annotations.put(annotations);
                return Ok(());
            }
            known::DICT => return self.set_function_dict(function, &new),
            _ => {}
        }
        let text = self.core.symbols.name(name);
        if &*text == "__code__" {
            return Err(self.raise(
                ExceptionKind::AttributeError,
                "__code__ of a function cannot be replaced",
            ));
        }
        if self.made_of(function, &text).is_some() {
            return Err(self.raise(ExceptionKind::AttributeError, "readonly attribute"));
        }
        if new.can_hold_values() {
            self.core.note_function(function);
        }
        self.core.symbols.mark_used(name);
        if function.attrs.borrow().is_none() {
            self.core.functions_with_attrs.push(function);
        }
        let old = function.attrs.with_mut(|attrs| {
            let attrs = attrs.get_or_insert_with(|| Box::new(AttrMap::default()));
            attrs.insert(name, new)
        });
        drop(old);
        self.sweep_names_if_due()?;
        Ok(())
    }

    /// `function.__dict__ = new`: its own attributes are those of the dictionary.
    fn set_function_dict(&self, function: &Rc<Function>, new: &Value) -> R<()> {
        let Value::Dict(dict) = new else {
            let name = self.core.types.name_of(new);
            return Err(self.type_error(format!(
                "__dict__ must be set to a dictionary, not a '{name}'"
            )));
        };
        let own: Vec<Symbol> = match &*function.attrs.borrow() {
            Some(attrs) => attrs
                .names()
                .iter()
                .copied()
                .filter(|name| !is_by_nature(*name))
                .collect(),
            None => Vec::new(),
        };
        for name in own {
            drop(
                function
                    .attrs
                    .with_mut(|attrs| attrs.as_mut()?.remove(name)),
            );
        }
        for (_, key, value) in self.collect_entries(dict)? {
            self.charge(WORK_PER_VALUE)?;
            if let Value::Str(text) = &key {
                let name = self.core.symbols.intern_used(text.as_str());
                self.set_function_attribute(function, name, value)?;
            }
        }
        Ok(())
    }

    /// `del function.name` for what it has by nature; false if `name` is none of it.
    pub fn delete_function_attribute(&self, function: &Rc<Function>, name: Symbol) -> R<bool> {
        match name {
            known::DEFAULTS => function.defaults.put(Vec::new().into()),
            known::KWDEFAULTS => {
                function.keyword_defaults_dict.put(Some(Value::None));
            }
            known::ANNOTATIONS => function.annotations.put(None),
            known::NAME | known::QUALNAME => {
                let name = self.core.symbols.name(name);
                return Err(self.type_error(format!("{name} must be set to a string object")));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// `__module__` of what some code defines.
    pub fn module_of(&self, code: &crate::eval::code::Code) -> Value {
        let own = match code.refs.home() {
            Some(home) => return home.get_str("__name__").unwrap_or(Value::None),
            None => code.module.as_ref().and_then(std::rc::Weak::upgrade),
        };
        let name = own.and_then(|namespace| namespace.get(known::NAME));
        name.unwrap_or_else(|| self.core.symbols.to_value(known::MAIN))
    }

    /// What a class body in some code finds under `__name__`, which is its `__module__`.
    pub fn name_for_class(&self, code: &crate::eval::code::Code) -> R {
        let Some(home) = code.refs.home() else {
            return Ok(self.module_of(code));
        };
        let builtins = || match self.builtins_in(&home) {
            Some(own) if !Rc::ptr_eq(&own, &self.builtins_dict()) => own.get_str("__name__"),
            _ => Some(self.core.name_of_builtins.value.get()),
        };
        home.get_str("__name__").or_else(builtins).ok_or_else(|| {
            let text = "name '__name__' is not defined".to_owned();
            self.raise_about(ExceptionKind::NameError, text, "__name__")
        })
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
            (Value::LongRange(range), known::START) => Value::bigint(range.start.clone()),
            (Value::LongRange(range), known::STOP) => Value::bigint(range.stop.clone()),
            (Value::LongRange(range), known::STEP) => Value::bigint(range.step.clone()),
            (Value::Slice(slice), known::START) => slice.start.clone(),
            (Value::Slice(slice), known::STOP) => slice.stop.clone(),
            (Value::Slice(slice), known::STEP) => slice.step.clone(),
            (Value::BoundMethod(method), known::SELF) => method.receiver.clone(),
            (Value::BoundMethod(method), known::FUNC) if !method.is_builtin() => {
                method.function.clone()
            }
            (Value::BoundMethod(method), known::OBJCLASS)
                if let Value::Builtin(builtin) = &method.function
                    && builtin.is_slot =>
            {
                return self.descriptor_owner(builtin);
            }
            (Value::Builtin(builtin), known::OBJCLASS) if builtin.owner.is_some() => {
                return self.descriptor_owner(builtin);
            }
            (Value::BoundMethod(method), known::QUALNAME)
                if let Value::Builtin(builtin) = &method.function
                    && builtin.owner.is_some()
                    && !builtin.is_slot =>
            {
                let class = match &method.receiver {
                    Value::Class(class) => class,
                    receiver => self.core.types.of(receiver),
                };
                Value::str(format!("{}.{}", self.qualname_of(class), builtin.name))
            }
            (Value::BoundMethod(method), known::MODULE) if method.is_builtin() => {
                let is_slot = matches!(&method.function, Value::Builtin(own) if own.is_slot);
                return Ok((!is_slot).then_some(Value::None));
            }
            (
                Value::BoundMethod(method),
                known::NAME | known::QUALNAME | known::DOC | known::MODULE,
            ) => {
                return self.with_native_depth(|| self.find_attribute(&method.function, name));
            }
            (Value::Builtin(builtin), known::NAME) => Value::str(builtin.name),
            (Value::Builtin(builtin), known::SELF | known::MODULE) if builtin.owner.is_none() => {
                return self.module_of_builtin(builtin, name);
            }
            (Value::Builtin(builtin), known::QUALNAME) => Value::str(&*builtin.label()),
            (Value::Generator(generator), known::NAME) => generator.name(),
            (Value::Generator(generator), known::QUALNAME) => generator.qualname(),
            (Value::Property(property), known::FGET) => property.get.clone(),
            (Value::Property(property), known::FSET) => property.set.clone(),
            (Value::Property(property), known::FDEL) => property.delete.clone(),
            (Value::Property(property), known::DOC) => property.doc.get(),
            (Value::Super(sup), known::THISCLASS) => Value::Class(sup.class.clone()),
            (Value::Super(sup), known::SELF | known::SELF_CLASS) if sup.receiver.is_unbound() => {
                Value::None
            }
            (Value::Super(sup), known::SELF) => sup.receiver.clone(),
            (Value::Super(sup), known::SELF_CLASS) => Value::Class(sup.receiver_class.clone()),
            (
                Value::StaticMethod(function) | Value::ClassMethod(function),
                known::NAME | known::QUALNAME | known::DOC | known::MODULE | known::ANNOTATIONS,
            ) => return self.with_native_depth(|| self.find_attribute(function, name)),
            (
                Value::StaticMethod(function) | Value::ClassMethod(function),
                known::FUNC | known::WRAPPED,
            ) => (**function).clone(),
            (
                Value::Generator(_)
                | Value::Code(_)
                | Value::Cell(_)
                | Value::Property(_)
                | Value::StaticMethod(_)
                | Value::ClassMethod(_),
                _,
            ) => return self.inner_attribute(value, name),
            _ => return Ok(None),
        }))
    }
}

/// Names of attributes that every function has, beside those in its `__dict__`.
fn is_by_nature(name: Symbol) -> bool {
    matches!(
        name,
        known::NAME | known::QUALNAME | known::DOC | known::MODULE
    )
}

fn first_argument(state: &ExceptionState) -> Value {
    match state.args() {
        Value::Tuple(args) => args.items().first().cloned().unwrap_or(Value::None),
        _ => Value::None,
    }
}
