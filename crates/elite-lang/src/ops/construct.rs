//! Making instances, and the computed attributes of functions, exceptions and other builtin values.

use std::rc::Rc;

use crate::errors::ExceptionKind;
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
                let is_instance = self.core.types.of(&object).is_subclass_of(class);
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
                return Err(self.init_returned(&result));
            }
        }
        Ok(object)
    }

    /// The error for an `__init__` that returned a value.
    #[cold]
    pub fn init_returned(&self, result: &Value) -> crate::value::Raised {
        let name = self.core.types.name_of(result);
        self.type_error(format!("__init__() should return None, not '{name}'"))
    }

    /// `object.__new__(class, …)`: for builtin types and their subclasses, what the builtin's own `__new__` does.
    pub fn new_object(&self, class: &Rc<Class>, args: &[Value], keywords: &[(Symbol, Value)]) -> R {
        if !class.is_script && class.base != Base::Object {
            return self.instantiate(class, &mut args.to_vec(), keywords, None);
        }
        let plain = class.base == Base::Object && class.lookup(known::NEW).is_none();
        let takes_none = plain && class.lookup(known::INIT).is_none();
        if takes_none && (!args.is_empty() || !keywords.is_empty()) {
            return Err(self.type_error(format!("{}() takes no arguments", class.name())));
        }
        self.allocate(class, args, keywords)
    }

    /// An instance before `__init__`. Subclasses of builtin types get the value they extend from the arguments.
    pub fn allocate(&self, class: &Rc<Class>, args: &[Value], keywords: &[(Symbol, Value)]) -> R {
        let payload = match class.base {
            Base::Object => Payload::None,
            Base::Type => return self.new_class(class, args, keywords),
            Base::Exception if self.is_group_class(class) => {
                return self.new_group(class, args).map(Value::Instance);
            }
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
        let is = |kind| class.is_subclass_of(self.core.types.exception(kind));
        let named: &[&str] = if is(ExceptionKind::ImportError) {
            &["name", "path"]
        } else if is(ExceptionKind::NameError) {
            &["name"]
        } else if is(ExceptionKind::AttributeError) {
            &["name", "obj"]
        } else {
            &[]
        };
        let mut attributes: Vec<(Symbol, Value)> = Vec::new();
        for (name, value) in keywords {
            let text = self.core.symbols.name(*name);
            if named.is_empty() {
                return Err(
                    self.type_error(format!("{}() takes no keyword arguments", class.name()))
                );
            }
            if !named.contains(&&*text) {
                return Err(self.type_error(format!(
                    "'{text}' is an invalid keyword argument for {}()",
                    class.name()
                )));
            }
            attributes.push((*name, value.clone()));
        }
        if self.is_group_class(class) {
            return self.new_group(class, &args).map(Value::Instance);
        }
        let (class, args) = match os_error_kind(&args) {
            Some(kind) if Rc::ptr_eq(class, self.core.types.exception(ExceptionKind::OSError)) => {
                (self.core.types.exception(kind), args)
            }
            _ => (class, args),
        };
        let parts =
            if is(ExceptionKind::UnicodeDecodeError) || is(ExceptionKind::UnicodeEncodeError) {
                self.check_unicode_error(&args)?;
                ["encoding", "object", "start", "end", "reason"].as_slice()
            } else {
                &[]
            };
        let mut args = args;
        if is(ExceptionKind::OSError) && args.len() >= 3 {
            // The file name is no argument.
            attributes.push((self.core.symbols.intern("filename"), args[2].clone()));
            if let Some(second) = args.get(4) {
                attributes.push((self.core.symbols.intern("filename2"), second.clone()));
            }
            args.truncate(2);
        }
        for (name, value) in parts.iter().zip(&args) {
            attributes.push((self.core.symbols.intern(name), value.clone()));
        }
        let state = ExceptionState::with_args(Value::tuple(args));
        let instance = Instance::new(class.clone(), Payload::Exception(Box::new(state)));
        for (name, value) in attributes {
            instance.set(name, value, &self.core.symbols);
        }
        Ok(Value::Instance(instance))
    }

    fn check_unicode_error(&self, args: &[Value]) -> R<()> {
        match args {
            [
                Value::Str(_),
                _,
                Value::Int(_),
                Value::Int(_),
                Value::Str(_),
            ] => Ok(()),
            [_, _, _, _, _] => Err(self.type_error(
                "argument types must be: encoding str, object, start int, end int, reason str",
            )),
            _ => Err(self.type_error(format!(
                "function takes exactly 5 arguments ({} given)",
                args.len()
            ))),
        }
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
        if let Some(group) = state.group.get() {
            match &*self.core.symbols.name(name) {
                "message" => return Some(group.message.clone()),
                "exceptions" => return Some(group.exceptions.clone()),
                _ => {}
            }
        }
        Some(match name {
            known::ARGS => state.args(),
            known::CAUSE => or_none(&state.cause.borrow()),
            known::CONTEXT => or_none(&state.context.borrow()),
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
        let chained = |place: &std::cell::RefCell<Value>| {
            *place.borrow_mut() = if new.is_none() {
                Value::Unbound
            } else {
                new.clone()
            };
        };
        if state.group.get().is_some()
            && matches!(&*self.core.symbols.name(name), "message" | "exceptions")
        {
            return Err(self.raise(ExceptionKind::AttributeError, "readonly attribute"));
        }
        match name {
            known::ARGS => state.set_args(Value::tuple(self.collect(new)?)),
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
            known::CONTEXT => chained(&state.context),
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
        let object = Instance::new(self.core.types.traceback.clone(), Payload::None);
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
            known::KWDEFAULTS => {
                let defaults = &function.keyword_defaults;
                if defaults.iter().all(Value::is_unbound) {
                    return Some(Value::None);
                }
                let dict = crate::value::Dict::new();
                let params = &function.code.params;
                let names = &params.names[params.positional..];
                for (name, value) in names.iter().zip(defaults.iter()) {
                    if !value.is_unbound() {
                        dict.set_interned(self.core.symbols.value(*name), value.clone());
                    }
                }
                Value::Dict(Rc::new(dict))
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
            *function.defaults.borrow_mut() = defaults.into();
            return Ok(());
        }
        if new.holds_values() {
            self.core.note_function(function);
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
            (Value::LongRange(range), known::START) => Value::bigint(range.start.clone()),
            (Value::LongRange(range), known::STOP) => Value::bigint(range.stop.clone()),
            (Value::LongRange(range), known::STEP) => Value::bigint(range.step.clone()),
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
            (Value::Super(sup), known::THISCLASS) => Value::Class(sup.class.clone()),
            (Value::Super(sup), known::SELF) => sup.receiver.clone(),
            (
                Value::StaticMethod(function) | Value::ClassMethod(function),
                known::NAME | known::QUALNAME | known::DOC | known::MODULE,
            ) => return self.attribute_or_none(function, name),
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

/// The more exact type `OSError(errno, text)` makes.
fn os_error_kind(args: &[Value]) -> Option<ExceptionKind> {
    let [Value::Int(errno), _, ..] = args else {
        return None;
    };
    Some(match errno {
        1 | 13 => ExceptionKind::PermissionError,
        2 => ExceptionKind::FileNotFoundError,
        3 => ExceptionKind::ProcessLookupError,
        4 => ExceptionKind::InterruptedError,
        10 => ExceptionKind::ChildProcessError,
        11 | 114 | 115 => ExceptionKind::BlockingIOError,
        17 => ExceptionKind::FileExistsError,
        20 => ExceptionKind::NotADirectoryError,
        21 => ExceptionKind::IsADirectoryError,
        32 | 108 => ExceptionKind::BrokenPipeError,
        103 => ExceptionKind::ConnectionAbortedError,
        104 => ExceptionKind::ConnectionResetError,
        110 => ExceptionKind::TimeoutError,
        111 => ExceptionKind::ConnectionRefusedError,
        _ => return None,
    })
}
