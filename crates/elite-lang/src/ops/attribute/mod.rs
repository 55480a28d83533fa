//! Attributes: lookup through instances and classes, descriptors.

mod bases;
mod change;
mod class;

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::stmt::layout;
use crate::value::class::BuiltinBase;
use crate::value::function::Super;
use crate::value::symbol::known;
use crate::value::{BoundMethod, Class, Instance, Module, R, Symbol, Unwind, Value};

impl Evaluator<'_> {
    /// `to_value.name`
    pub fn attribute(&self, value: &Value, name: Symbol) -> R {
        match self.find_attribute(value, name)? {
            Some(found) => Ok(found),
            None => Err(self.attribute_error(value, name)),
        }
    }

    /// Like `attribute`, for what an object may have or not: None if there is no such attribute, also if a
    /// `__getattr__` of a script says so.
    pub fn attribute_or_none(&self, value: &Value, name: Symbol) -> R<Option<Value>> {
        match self.find_attribute(value, name) {
            Err(raised) if self.is_kind(&raised, ExceptionKind::AttributeError) => Ok(None),
            found => found,
        }
    }

    /// The attribute, None where nothing has it; what script code raises that is asked for it comes out as it is.
    pub fn find_attribute(&self, value: &Value, name: Symbol) -> R<Option<Value>> {
        match value {
            Value::Instance(instance) => self.instance_attribute(value, instance, name),
            Value::Class(class) => self.class_attribute(value, class, name),
            Value::Module(module) => match name {
                known::NAME if !Rc::ptr_eq(&module.namespace, &self.core.builtins) => {
                    let own = module.namespace.get(name);
                    Ok(own.or_else(|| Some(Value::str(&*module.name))))
                }
                known::NAME => Ok(Some(Value::str(&*module.name))),
                known::DICT => Ok(Some(Value::Dict(match &*module.name {
                    "__main__" => self.globals_dict(),
                    _ => self.namespace_dict(&module.namespace),
                }))),
                known::CLASS => Ok(Some(Value::Class(self.core.types.module.clone()))),
                _ => match module.namespace.get(name) {
                    Some(found) => Ok(Some(found)),
                    None if name == known::DOC => Ok(Some(Value::None)),
                    None if self.core.symbols.name(name).starts_with("__")
                        && let Some(found) = self.builtin_attribute(value, name)? =>
                    {
                        Ok(Some(found))
                    }
                    None => match module.namespace.get(known::GETATTR) {
                        Some(custom) => {
                            let text = self.core.symbols.to_value(name);
                            self.call1(&custom, text).map(Some)
                        }
                        None => Ok(None),
                    },
                },
            },
            Value::Super(sup) => {
                if name == known::CLASS {
                    return Ok(Some(Value::Class(self.core.types.super_.clone())));
                }
                match self.super_attribute(sup, name)? {
                    Some(found) => Ok(Some(found)),
                    None => self.builtin_attribute(value, name),
                }
            }
            Value::Function(function) => {
                let own = function
                    .attrs
                    .borrow()
                    .as_ref()
                    .and_then(|attrs| attrs.get(name).cloned());
                match own {
                    Some(found) => Ok(Some(found)),
                    None => match self.function_attribute(function, name)? {
                        Some(found) => Ok(Some(found)),
                        None => self.builtin_attribute(value, name),
                    },
                }
            }
            Value::StaticMethod(wrapped) | Value::ClassMethod(wrapped) => {
                if name == known::DICT {
                    return self.wrapped_dict(wrapped).map(Value::Dict).map(Some);
                }
                match wrapped.attrs.get() {
                    Some(Value::Dict(dict)) if !matches!(name, known::FUNC | known::WRAPPED) => {
                        match dict.get_str(&self.core.symbols.name(name)) {
                            Some(found) => Ok(Some(found)),
                            None => self.builtin_attribute(value, name),
                        }
                    }
                    _ => self.builtin_attribute(value, name),
                }
            }
            _ => self.builtin_attribute(value, name),
        }
    }

    /// What `super()` finds in the classes behind its own; None where nothing has it.
    pub fn super_attribute(&self, sup: &Super, name: Symbol) -> R<Option<Value>> {
        if sup.receiver.is_unbound() {
            return Ok(None);
        }
        if matches!(name, known::THISCLASS | known::SELF | known::SELF_CLASS) {
            return Ok(None);
        }
        match sup.receiver_class.lookup_after(&sup.class, name) {
            Some(found) => self
                .bind_attribute(&found, &sup.receiver, &sup.receiver_class)
                .map(Some),
            None if name == known::NEW => Ok(Some(self.new_of(&sup.class))),
            None => self.object_attribute(&sup.receiver, &sup.receiver_class, name),
        }
    }

    /// Attributes of values of builtin types: methods of their class, and a few that are computed.
    fn builtin_attribute(&self, value: &Value, name: Symbol) -> R<Option<Value>> {
        let class = self.core.types.of(value);
        if let Some(found) = self.computed_attribute(value, name)? {
            return Ok(Some(found));
        }
        match (class.lookup(name), value) {
            (Some(found), _) => self.bind_attribute(&found, value, class).map(Some),
            // What a method does not have itself is looked up in its function.
            (None, Value::BoundMethod(method)) if name != known::CLASS && !method.is_builtin() => {
                self.with_native_depth(|| self.find_attribute(&method.function, name))
            }
            (None, _) => self.object_attribute(value, class, name),
        }
    }

    /// Attributes that everything has.
    fn object_attribute(&self, value: &Value, class: &Rc<Class>, name: Symbol) -> R<Option<Value>> {
        Ok(match name {
            known::CLASS => Some(Value::Class(class.clone())),
            known::DOC => Some(Value::None),
            known::DICT => match value {
                Value::Instance(instance) => {
                    let class = &instance.class;
                    let has_one = match class.is_script {
                        true => class.has_dict(),
                        false => layout::has_dict(class),
                    };
                    has_one.then(|| Value::Dict(instance.dict(&self.core.symbols)))
                }
                _ => None,
            },
            known::WEAKREF if class.is_script && layout::is_weakly_referable(class) => {
                Some(Value::None)
            }
            known::NEW => Some(self.new_of(class)),
            _ => match self.core.types.natural.lookup(name) {
                Some(found) => Some(self.bind_attribute(&found, value, class)?),
                None => None,
            },
        })
    }

    fn instance_attribute(
        &self,
        value: &Value,
        instance: &Rc<Instance>,
        name: Symbol,
    ) -> R<Option<Value>> {
        let class = &instance.class;
        if class.is_script
            && let Some(custom) = class.lookup(known::GETATTRIBUTE)
        {
            return self.by_getattr_method(&custom, value, class, name);
        }
        match self.plain_instance_attribute(value, instance, name) {
            Ok(None) => {}
            Err(raised) if self.is_kind(&raised, ExceptionKind::AttributeError) => {
                // An AttributeError of a property falls back to `__getattr__`, too.
                return match class.lookup(known::GETATTR) {
                    Some(custom) => self
                        .call_method_value(&custom, value, &mut [self.core.symbols.to_value(name)])
                        .map(Some),
                    None => Err(raised),
                };
            }
            found => return found,
        }
        match class.lookup(known::GETATTR) {
            Some(custom) => self
                .call_method_value(&custom, value, &mut [self.core.symbols.to_value(name)])
                .map(Some),
            None => Ok(None),
        }
    }

    fn by_getattr_method(
        &self,
        custom: &Value,
        value: &Value,
        class: &Rc<Class>,
        name: Symbol,
    ) -> R<Option<Value>> {
        match self.call_method_value(custom, value, &mut [self.core.symbols.to_value(name)]) {
            Err(raised) if self.is_kind(&raised, ExceptionKind::AttributeError) => {
                match class.lookup(known::GETATTR) {
                    Some(custom) => self
                        .call_method_value(&custom, value, &mut [self.core.symbols.to_value(name)])
                        .map(Some),
                    None => Err(raised),
                }
            }
            other => other.map(Some),
        }
    }

    /// Python's `object.__getattribute__`.
    pub fn plain_instance_attribute(
        &self,
        value: &Value,
        instance: &Rc<Instance>,
        name: Symbol,
    ) -> R<Option<Value>> {
        let class = &instance.class;
        let found = class.lookup(name);
        if let Some(found) = &found
            && self.is_data_descriptor(found)
        {
            // A descriptor that only sets does not hide what the instance holds under its name.
            if let Value::Instance(descriptor) = found
                && descriptor.class.lookup(known::GET).is_none()
                && let Some(own) = instance.get(name, &self.core.symbols)
            {
                return Ok(Some(own));
            }
            if let Value::Property(property) = found
                && property.get.is_none()
            {
                let (name, class) = (
                    property.name_or(&self.core.symbols.name(name)),
                    self.qualname_of(class),
                );
                let message = format!("property '{name}' of '{class}' object has no getter");
                return Err(self.raise(ExceptionKind::AttributeError, message));
            }
            return self.bind_attribute(found, value, class).map(Some);
        }
        if let Some(own) = instance.get(name, &self.core.symbols) {
            return Ok(Some(own));
        }
        if let Some(found) = found {
            return self.bind_attribute(&found, value, class).map(Some);
        }
        if let Some(state) = instance.exception()
            && let Some(found) = self.exception_attribute(instance, state, name)
        {
            return Ok(Some(found));
        }
        if let Some(extended) = instance.builtin_value()
            && let Some(found) = self.computed_attribute(&extended, name)?
        {
            return Ok(Some(found));
        }
        self.object_attribute(value, class, name)
    }

    /// Whether an attribute of a class takes precedence over one of the instance.
    pub fn is_data_descriptor(&self, value: &Value) -> bool {
        match value {
            Value::Property(_) => true,
            Value::Instance(instance) => {
                instance.class.lookup(known::SET).is_some()
                    || instance.class.lookup(known::DELETE).is_some()
            }
            _ => false,
        }
    }

    /// What an attribute found in the class of `receiver` means for it: functions become bound methods, properties
    /// are read.
    pub fn bind_attribute(&self, found: &Value, receiver: &Value, class: &Rc<Class>) -> R {
        match found {
            Value::Function(_) => Ok(self.bind_method(found, receiver)),
            Value::Builtin(builtin) if builtin.owner.is_some() => {
                if class.is_script && !matches!(receiver, Value::Class(_)) {
                    self.check_descriptor_receiver(builtin, receiver)?;
                }
                Ok(self.bind_method(found, receiver))
            }
            Value::Property(property) => {
                if property.get.is_none() {
                    return Err(self.raise(ExceptionKind::AttributeError, "unreadable attribute"));
                }
                self.call1(&property.get, receiver.clone())
            }
            Value::StaticMethod(function) => Ok((**function).clone()),
            Value::ClassMethod(function) => {
                self.bind_to_class(function, &Value::Class(class.clone()))
            }
            Value::Super(sup) if sup.receiver.is_unbound() => {
                self.make_super(&Value::Class(sup.class.clone()), receiver)
            }
            Value::Instance(descriptor) => match descriptor.class.lookup(known::GET) {
                Some(get) => self.call_method_value(
                    &get,
                    found,
                    &mut [receiver.clone(), Value::Class(class.clone())],
                ),
                None => Ok(found.clone()),
            },
            _ => Ok(found.clone()),
        }
    }

    fn bind_method(&self, function: &Value, receiver: &Value) -> Value {
        let (function, receiver) = (function.clone(), receiver.clone());
        Value::BoundMethod(Rc::new(BoundMethod { receiver, function }))
    }

    /// What a class method is as an attribute of a class: what it wraps, asked as one of the class if it is a
    /// descriptor itself.
    #[inline]
    pub fn bind_to_class(&self, function: &Value, class: &Value) -> R {
        match function {
            Value::Function(_) => Ok(self.bind_method(function, class)),
            _ => self.get_for_class(function, class),
        }
    }

    #[inline(never)]
    fn get_for_class(&self, function: &Value, class: &Value) -> R {
        match function {
            Value::Property(property) if !property.get.is_none() => {
                self.call1(&property.get, class.clone())
            }
            Value::StaticMethod(inner) => Ok(Value::clone(inner)),
            Value::ClassMethod(inner) => {
                self.with_native_depth(|| self.bind_to_class(inner, class))
            }
            Value::Instance(descriptor) if let Some(get) = descriptor.class.lookup(known::GET) => {
                let mut args = [class.clone(), class.clone()];
                self.call_method_value(&get, function, &mut args)
            }
            _ => Ok(self.bind_method(function, class)),
        }
    }

    fn class_attribute(&self, value: &Value, class: &Rc<Class>, name: Symbol) -> R<Option<Value>> {
        if let Some(part) = self.part_of_class(value, class, name)? {
            return Ok(Some(part));
        }
        let metaclass = self.core.types.of(value).clone();
        let of_metaclass = class.meta_method(name);
        if let Some(found) = &of_metaclass
            && self.is_data_descriptor(found)
        {
            return self.bind_attribute(found, value, &metaclass).map(Some);
        }
        if let Some(found) = class.lookup(name) {
            return Ok(Some(match &found {
                Value::StaticMethod(function) => (**function).clone(),
                Value::ClassMethod(function) => self.bind_to_class(function, value)?,
                Value::Instance(descriptor) => match descriptor.class.lookup(known::GET) {
                    Some(get) => {
                        self.call_method_value(&get, &found, &mut [Value::None, value.clone()])?
                    }
                    None => found,
                },
                Value::Property(_) => self.shown_property(class, name).unwrap_or(found),
                _ => found,
            }));
        }
        match metaclass.lookup(name) {
            Some(_) if matches!(name, known::DOC | known::MODULE) => Ok(Some(Value::None)),
            // What every object has comes before what `type` has for classes.
            Some(Value::Builtin(_)) if let Some(found) = self.core.types.natural.lookup(name) => {
                Ok(Some(found))
            }
            Some(found) => self.bind_attribute(&found, value, &metaclass).map(Some),
            None if let Some(found) = self.descriptor(class, name)? => Ok(Some(found)),
            None if class.meta_method(known::GETATTR).is_some()
                && self.core.types.natural.lookup(name).is_none() =>
            {
                let text = self.core.symbols.to_value(name);
                self.special(value, known::GETATTR, &mut [text])
            }
            None => Ok(match name {
                known::DOC => Some(Value::None),
                known::ANNOTATIONS if class.is_script => {
                    Some(Value::Dict(Rc::new(crate::value::Dict::new())))
                }
                known::NEW => Some(self.new_of(class)),
                known::MODULE => Some(Value::str(if class.is_script {
                    "__main__"
                } else {
                    "builtins"
                })),
                _ => self
                    .core
                    .types
                    .natural
                    .lookup(name)
                    .map(|found| match found {
                        Value::StaticMethod(function) => (*function).clone(),
                        other => other,
                    }),
            }),
        }
    }

    /// What a module is called at present; None if it has no name that is a text.
    fn name_of_module(&self, module: &Module) -> Option<Rc<str>> {
        if elite_syntax::python_names::is_bundled_module(&module.name) {
            return Some(module.name.clone());
        }
        match module.namespace.get(known::NAME) {
            Some(Value::Str(name)) => Some(name.as_str().into()),
            _ => None,
        }
    }

    /// The error for an attribute that is not there, with a suggestion.
    #[cold]
    pub fn attribute_error(&self, value: &Value, name: Symbol) -> Unwind {
        let name = self.core.symbols.name(name);
        let message = match value {
            Value::Class(class) => {
                format!("type object '{}' has no attribute '{name}'", class.name())
            }
            Value::Module(module) => match self.name_of_module(module) {
                Some(module) => format!("module '{module}' has no attribute '{name}'"),
                None => format!("module has no attribute '{name}'"),
            },
            Value::Instance(instance) if instance.class.base == BuiltinBase::Module => {
                match instance.get(known::NAME, &self.core.symbols) {
                    Some(Value::Str(module)) => {
                        format!("module '{}' has no attribute '{name}'", module.as_str())
                    }
                    _ => format!("module has no attribute '{name}'"),
                }
            }
            Value::BoundMethod(method) if !method.is_builtin() => format!(
                "'{}' object has no attribute '{name}'",
                self.core.types.name_of(&method.function)
            ),
            other => format!(
                "'{}' object has no attribute '{name}'",
                self.core.types.name_of(other)
            ),
        };
        let raised = self.raise(ExceptionKind::AttributeError, message);
        if let Unwind::Exception(exception) = &raised {
            let set = |attribute: &str, new: Value| {
                let attribute = self.core.symbols.intern(attribute);
                exception.set(attribute, new, &self.core.symbols);
            };
            set("name", Value::str(&*name));
            set("obj", value.clone());
        }
        raised
    }
}
