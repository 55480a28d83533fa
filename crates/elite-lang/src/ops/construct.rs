//! Making instances.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, Frame};
use crate::value::class::BuiltinBase;
use crate::value::exception::ExceptionState;
use crate::value::function::WrappedFunction;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{BoundMethod, Class, Instance, R, Symbol, Value};

/// What an instance of a class derived from a builtin type is.
fn builtin_payload(value: Value) -> InstancePayload {
    InstancePayload::Value(crate::value::ScriptCell::new(value))
}

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
            let constructor = class.constructor.get();
            if !constructor.is_unbound() {
                return self.call_from(&constructor, args, keywords, caller);
            }
            if class.base == BuiltinBase::Exception {
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
                let needs_args = init.is_none() && matches!(class.base, BuiltinBase::Object);
                if needs_args && (!args.is_empty() || !keywords.is_empty()) {
                    return Err(self.type_error(format!("{}() takes no arguments", class.name())));
                }
                self.allocate(class, args, keywords)?
            }
        };
        if let Some(init) = init {
            let result = match &init {
                Value::Function(_) | Value::Builtin(_) => {
                    self.with_first(object.clone(), args, |all| self.call(&init, all, keywords))?
                }
                _ => {
                    let bound = self.bind_attribute(&init, &object, class)?;
                    self.call(&bound, args, keywords)?
                }
            };
            if !result.is_none() {
                return Err(self.init_result_error(&result));
            }
        }
        Ok(object)
    }

    /// The error for an `__init__` that returned a value.
    #[cold]
    pub fn init_result_error(&self, result: &Value) -> crate::value::Unwind {
        let name = self.core.types.name_of(result);
        self.type_error(format!("__init__() should return None, not '{name}'"))
    }

    /// `__new__` of a builtin type, as an attribute of it and of the classes derived from it.
    pub fn new_of(&self, class: &Rc<Class>) -> Value {
        let line = class.mro();
        let owner = line.iter().find(|class| !class.is_script).unwrap_or(class);
        if owner.base == BuiltinBase::Object {
            return match self.core.types.natural.lookup(known::NEW) {
                Some(Value::StaticMethod(function)) => (*function).clone(),
                found => found.unwrap_or_default(),
            };
        }
        let function = crate::builtins::Builtin::raw("__new__", |ev, args| {
            match args.positional.split_first() {
                Some((Value::Class(owner), rest)) => ev.new_by(owner, rest, args.keywords),
                _ => Err(ev.type_error("__new__() needs a class")),
            }
        });
        let receiver = Value::Class(owner.clone());
        Value::BoundMethod(Rc::new(BoundMethod { receiver, function }))
    }

    /// `owner.__new__(class, …)` for a builtin type `owner`.
    pub fn new_by(&self, owner: &Rc<Class>, args: &[Value], keywords: &[(Symbol, Value)]) -> R {
        let name = owner.name();
        let (class, rest) = match args.split_first() {
            Some((Value::Class(class), rest)) => (class, rest),
            Some((other, _)) => {
                let found = self.core.types.name_of(other);
                return Err(self.type_error(format!(
                    "{name}.__new__(X): X is not a type object ({found})"
                )));
            }
            None => return Err(self.type_error(format!("{name}.__new__(): not enough arguments"))),
        };
        let wanted = class.name();
        if !class.is_subclass_of(owner) {
            return Err(self.type_error(format!(
                "{name}.__new__({wanted}): {wanted} is not a subtype of {name}"
            )));
        }
        let line = class.mro();
        let builtin = line.iter().find(|class| !class.is_script).unwrap_or(owner);
        let is_same = builtin.base == owner.base || builtin.base == BuiltinBase::Native;
        if !is_same {
            // CPython names the first class of the line whose `__new__` is not a script's.
            let own = match class.is_script && class.lookup(known::NEW).is_some() {
                true => builtin.name(),
                false => wanted.clone(),
            };
            return Err(self.type_error(format!(
                "{name}.__new__({wanted}) is not safe, use {own}.__new__()"
            )));
        }
        if owner.base == BuiltinBase::Object && (!rest.is_empty() || !keywords.is_empty()) {
            if class.is_script && class.lookup(known::NEW).is_some() {
                return Err(self.type_error(
                    "object.__new__() takes exactly one argument (the type to instantiate)",
                ));
            }
            if class.lookup(known::INIT).is_none() && class.base == BuiltinBase::Object {
                return Err(self.type_error(format!("{wanted}() takes no arguments")));
            }
        }
        // What fills these is `__init__`.
        match class.base {
            BuiltinBase::List | BuiltinBase::Dict | BuiltinBase::Set | BuiltinBase::ByteArray
                if !class.is_script =>
            {
                self.new_object(class, &[], &[])
            }
            _ => self.new_object(class, rest, keywords),
        }
    }

    /// `object.__init__` with arguments: an error unless `__new__` of a script may have taken them.
    pub fn check_no_arguments(&self, class: &Rc<Class>) -> R<()> {
        let is_plain = matches!(
            class.base,
            BuiltinBase::Object
                | BuiltinBase::Int
                | BuiltinBase::Float
                | BuiltinBase::Str
                | BuiltinBase::Tuple
                | BuiltinBase::Complex
        );
        if is_plain && class.lookup(known::INIT).is_some() {
            let text = "object.__init__() takes exactly one argument (the instance to initialize)";
            return Err(self.type_error(text));
        }
        if class.base == BuiltinBase::Object && class.lookup(known::NEW).is_none() {
            let name = class.name();
            return Err(self.type_error(format!("{name}() takes no arguments")));
        }
        Ok(())
    }

    /// `object.__new__(class, …)`: for builtin types and their subclasses, what the builtin's own `__new__` does.
    pub fn new_object(&self, class: &Rc<Class>, args: &[Value], keywords: &[(Symbol, Value)]) -> R {
        if !class.is_script && class.base != BuiltinBase::Object {
            return self.instantiate(class, &mut args.to_vec(), keywords, None);
        }
        let plain = class.base == BuiltinBase::Object && class.lookup(known::NEW).is_none();
        let takes_none = plain && class.lookup(known::INIT).is_none();
        if takes_none && (!args.is_empty() || !keywords.is_empty()) {
            return Err(self.type_error(format!("{}() takes no arguments", class.name())));
        }
        self.allocate(class, args, keywords)
    }

    /// An instance before `__init__`. Subclasses of builtin types get the value they extend from the arguments.
    pub fn allocate(&self, class: &Rc<Class>, args: &[Value], keywords: &[(Symbol, Value)]) -> R {
        let payload = match class.base {
            BuiltinBase::Object if class.is_abstract() => return Err(self.abstract_error(class)),
            BuiltinBase::Object => InstancePayload::None,
            BuiltinBase::Type => return self.new_class(class, args, keywords, None),
            // `__init__` makes its attributes.
            BuiltinBase::Module => InstancePayload::None,
            // `__init__` says what they wrap, and where a `super` looks.
            BuiltinBase::StaticMethod => {
                builtin_payload(Value::StaticMethod(WrappedFunction::around(Value::None)))
            }
            BuiltinBase::ClassMethod => {
                builtin_payload(Value::ClassMethod(WrappedFunction::around(Value::None)))
            }
            BuiltinBase::Super => {
                let nowhere = &Value::Class(self.core.types.object.clone());
                builtin_payload(self.make_super(nowhere, &Value::Unbound)?)
            }
            BuiltinBase::Exception if self.is_group_class(class) => {
                return self.new_group(class, args).map(Value::Instance);
            }
            BuiltinBase::Exception => InstancePayload::Exception(Box::new(
                ExceptionState::with_args(Value::tuple(args.to_vec())),
            )),
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
        let line = class.mro();
        let Some(builtin) = line.iter().find(|class| !class.is_script) else {
            let name = class.name();
            return Err(self.type_error(format!("cannot create '{name}' instances")));
        };
        let constructor = builtin.constructor.get();
        if constructor.is_unbound() {
            let text = format!("cannot create '{}' instances", class.type_name());
            return Err(self.type_error(text));
        }
        // Mutable containers are filled by `__init__`; immutable values take the arguments now.
        let is_mutable = matches!(
            class.base,
            BuiltinBase::List
                | BuiltinBase::Dict
                | BuiltinBase::Set
                | BuiltinBase::ByteArray
                | BuiltinBase::Native
                | BuiltinBase::Property
        );
        let made = if is_mutable && class.lookup(known::INIT).is_some() {
            self.call(&constructor, &mut [], &[])?
        } else {
            self.call(&constructor, &mut args.to_vec(), keywords)?
        };
        let payload = builtin_payload(self.unwrap_builtin(&made));
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
        let instance = Instance::new(class.clone(), InstancePayload::Exception(Box::new(state)));
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
