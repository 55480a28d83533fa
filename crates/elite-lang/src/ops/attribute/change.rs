//! Setting and deleting attributes.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::class::BuiltinBase;
use crate::value::symbol::known;
use crate::value::{Class, Dict, Instance, R, Symbol, Unwind, Value};

/// Whether what extends this builtin type has parts of it that are for reading only.
fn has_parts(base: BuiltinBase) -> bool {
    matches!(
        base,
        BuiltinBase::StaticMethod
            | BuiltinBase::ClassMethod
            | BuiltinBase::Super
            | BuiltinBase::Property
    )
}

impl Evaluator<'_> {
    /// `to_value.name = new`
    pub fn set_attribute(&self, value: &Value, name: Symbol, new: Value) -> R<()> {
        match value {
            Value::Instance(instance) => {
                let class = &instance.class;
                if let Some(custom) = class.lookup(known::SETATTR) {
                    let name = self.core.symbols.to_value(name);
                    return self
                        .call_method_value(&custom, value, &mut [name, new])
                        .map(|_| ());
                }
                self.plain_set_attribute(value, instance, name, new)
            }
            Value::Class(class) if class.is_script => {
                if class.meta_method(known::SETATTR).is_some() {
                    let text = self.core.symbols.to_value(name);
                    return self
                        .special(value, known::SETATTR, &mut [text, new])
                        .map(|_| ());
                }
                self.plain_set_class_attribute(value, class, name, new)
            }
            Value::Class(class) => {
                let (name, class) = (self.core.symbols.name(name), class.name());
                Err(self.type_error(format!(
                    "cannot set '{name}' attribute of immutable type '{class}'"
                )))
            }
            Value::Module(_) if name == known::DICT => {
                Err(self.raise(ExceptionKind::AttributeError, "readonly attribute"))
            }
            Value::Module(module) => {
                self.core.symbols.mark_used(name);
                module.namespace.set(name, new);
                self.sweep_names_if_due()?;
                Ok(())
            }
            _ if name == known::CLASS => Err(self.class_assignment_error(&new)),
            Value::StaticMethod(wrapped) | Value::ClassMethod(wrapped) => {
                if let Some(refused) = self.refused_by_type(value, name) {
                    return Err(refused);
                }
                if name == known::DICT {
                    let Value::Dict(dict) = self.unwrap_builtin(&new) else {
                        let name = self.core.types.name_of(&new);
                        return Err(self.type_error(format!(
                            "__dict__ must be set to a dictionary, not a '{name}'"
                        )));
                    };
                    wrapped.attrs.put(Some(Value::Dict(dict)));
                    return Ok(());
                }
                let dict = self.wrapped_dict(wrapped)?;
                if new.can_hold_values() {
                    self.core.gc_track(&Value::Dict(dict.clone()));
                }
                self.dict_set(&dict, self.core.symbols.to_value(name), new)
            }
            Value::Function(function) => self.set_function_attribute(function, name, new),
            Value::Generator(generator) if matches!(name, known::NAME | known::QUALNAME) => {
                self.rename_generator(generator, name, new)
            }
            Value::Property(property) if name == known::DOC => {
                property.doc.put(new);
                Ok(())
            }
            Value::Property(_) if matches!(name, known::FGET | known::FSET | known::FDEL) => {
                Err(self.raise(ExceptionKind::AttributeError, "readonly attribute"))
            }
            Value::Code(_) if self.attribute_or_none(value, name)?.is_some() => {
                Err(self.raise(ExceptionKind::AttributeError, "readonly attribute"))
            }
            Value::Cell(cell) if &*self.core.symbols.name(name) == "cell_contents" => {
                if new.can_hold_values() {
                    self.core.note_cell(cell);
                }
                drop(cell.replace(new));
                Ok(())
            }
            _ => Err(self.cannot_set(value, name)),
        }
    }

    /// Python's `type.__setattr__`.
    pub fn plain_set_class_attribute(
        &self,
        value: &Value,
        class: &Rc<Class>,
        name: Symbol,
        new: Value,
    ) -> R<()> {
        let refusal = |name: &str| {
            let class = self.core.types.name_of(value);
            format!("property '{name}' of '{class}' object has no setter")
        };
        let Some(new) = self.set_through(class.meta_method(name), value, name, new, refusal)?
        else {
            return Ok(());
        };
        if self.set_part_of_class(class, name, &new)?.is_some() {
            return Ok(());
        }
        self.core.symbols.mark_used(name);
        class.set(name, new);
        self.sweep_names_if_due()?;
        Ok(())
    }

    /// Python's `type.__delattr__`.
    pub fn plain_delete_class_attribute(
        &self,
        value: &Value,
        class: &Class,
        name: Symbol,
    ) -> R<()> {
        self.keep_part_of_class(class, name)?;
        match class.remove(name) {
            true => Ok(()),
            false => Err(self.cannot_delete(value, name)),
        }
    }

    /// Hands a value to what the class has under the name of an attribute, if that takes values: a property, or an
    /// object with `__set__`. Otherwise the value comes back. `refusal` is what a property without a setter says.
    fn set_through(
        &self,
        found: Option<Value>,
        value: &Value,
        name: Symbol,
        new: Value,
        refusal: impl FnOnce(&str) -> String,
    ) -> R<Option<Value>> {
        match found {
            Some(Value::Property(property)) => {
                if property.set.is_none() {
                    if let Some(refused) = self.refused_by_type(value, name) {
                        return Err(refused);
                    }
                    let message = refusal(&property.name_or(&self.core.symbols.name(name)));
                    return Err(self.raise(ExceptionKind::AttributeError, message));
                }
                self.call(&property.set, &mut [value.clone(), new], &[])?;
                Ok(None)
            }
            Some(Value::Instance(descriptor)) => match descriptor.class.lookup(known::SET) {
                Some(set) => {
                    let descriptor = Value::Instance(descriptor);
                    self.call_method_value(&set, &descriptor, &mut [value.clone(), new])?;
                    Ok(None)
                }
                None if descriptor.class.lookup(known::DELETE).is_some() => {
                    Err(self.raise(ExceptionKind::AttributeError, "__set__"))
                }
                None => Ok(Some(new)),
            },
            _ => Ok(Some(new)),
        }
    }

    #[cold]
    pub(super) fn class_assignment_error(&self, new: &Value) -> Unwind {
        if matches!(new, Value::Class(_)) {
            return self.type_error("assignment to __class__ is not supported");
        }
        let found = self.core.types.name_of(new);
        self.type_error(format!(
            "__class__ must be set to a class, not '{found}' object"
        ))
    }

    /// What objects without a dictionary say of setting an attribute.
    #[cold]
    fn cannot_set(&self, value: &Value, name: Symbol) -> Unwind {
        if let Some(refused) = self.refused_by_type(value, name) {
            return refused;
        }
        let class = self.core.types.name_of(value);
        let text = self.core.symbols.name(name);
        let exists = match value {
            // Whatever `__getattr__` would say of it.
            Value::Instance(instance) => {
                instance.class.lookup(name).is_some()
                    || self.core.types.natural.lookup(name).is_some()
            }
            _ => self
                .attribute_or_none(value, name)
                .is_ok_and(|found| found.is_some()),
        };
        let message = if exists {
            format!("'{class}' object attribute '{text}' is read-only")
        } else {
            format!("'{class}' object has no attribute '{text}'")
        };
        self.raise(ExceptionKind::AttributeError, message)
    }

    /// Python's `object.__setattr__`.
    pub fn plain_set_attribute(
        &self,
        value: &Value,
        instance: &Rc<Instance>,
        name: Symbol,
        new: Value,
    ) -> R<()> {
        if !instance.noted.get() && new.can_hold_values() {
            self.core.note_instance(instance);
        }
        let class = &instance.class;
        let refusal = |name: &str| {
            let class = self.qualname_of(class);
            format!("property '{name}' of '{class}' object has no setter")
        };
        let Some(new) = self.set_through(class.lookup(name), value, name, new, refusal)? else {
            return Ok(());
        };
        if let Some(state) = instance.exception()
            && self.set_exception_attribute(state, name, &new)?
        {
            return Ok(());
        }
        if name == known::CLASS {
            return Err(self.class_assignment_error(&new));
        }
        if !class.is_script && instance.exception().is_none() {
            return Err(self.cannot_set(value, name));
        }
        if has_parts(class.base)
            && let Some(refused) = self.refused_by_type(value, name)
        {
            return Err(refused);
        }
        if name == known::DICT && class.base == BuiltinBase::Module {
            return Err(self.raise(ExceptionKind::AttributeError, "readonly attribute"));
        }
        if name == known::DICT && class.has_dict() {
            let Value::Dict(dict) = self.unwrap_builtin(&new) else {
                let name = self.core.types.name_of(&new);
                return Err(self.type_error(format!(
                    "__dict__ must be set to a dictionary, not a '{name}'"
                )));
            };
            instance.set_dict(dict, &self.core.symbols);
            return Ok(());
        }
        if !class.takes_attribute(name) {
            return Err(self.cannot_set(value, name));
        }
        if let Some(dict) = instance.dict_if_any() {
            self.grow_dict(&dict)?;
        }
        instance.set(name, new, &self.core.symbols);
        self.sweep_names_if_due()?;
        Ok(())
    }

    /// `del to_value.name`
    pub fn delete_attribute(&self, value: &Value, name: Symbol) -> R<()> {
        match value {
            Value::Instance(instance) => {
                if let Some(custom) = instance.class.lookup(known::DELATTR) {
                    let name = self.core.symbols.to_value(name);
                    return self
                        .call_method_value(&custom, value, &mut [name])
                        .map(|_| ());
                }
                self.plain_delete_attribute(value, instance, name)
            }
            Value::Class(class) if class.meta_method(known::DELATTR).is_some() => {
                let name = self.core.symbols.to_value(name);
                self.special(value, known::DELATTR, &mut [name]).map(|_| ())
            }
            Value::Class(class) if class.is_script => {
                self.plain_delete_class_attribute(value, class, name)
            }
            Value::Module(module) if module.namespace.get(name).is_some() => {
                module.namespace.set(name, Value::Unbound);
                Ok(())
            }
            Value::Cell(cell) if &*self.core.symbols.name(name) == "cell_contents" => {
                drop(cell.take());
                Ok(())
            }
            Value::StaticMethod(wrapped) | Value::ClassMethod(wrapped) => {
                if let Some(refused) = self.refused_by_type(value, name) {
                    return Err(refused);
                }
                let dict = self.wrapped_dict(wrapped)?;
                match self.dict_remove(&dict, &self.core.symbols.to_value(name))? {
                    Some(_) => Ok(()),
                    None => Err(self.attribute_error(value, name)),
                }
            }
            Value::Function(function) if self.delete_function_attribute(function, name)? => Ok(()),
            Value::Function(function) => {
                let removed = function
                    .attrs
                    .with_mut(|attrs| attrs.as_mut()?.remove(name));
                if removed.is_some() {
                    Ok(())
                } else {
                    Err(self.attribute_error(value, name))
                }
            }
            _ => Err(self.cannot_delete(value, name)),
        }
    }

    #[cold]
    fn no_attribute(&self, value: &Value, name: Symbol) -> Unwind {
        let (class, name) = (self.core.types.name_of(value), self.core.symbols.name(name));
        let text = format!("'{class}' object has no attribute '{name}'");
        self.raise(ExceptionKind::AttributeError, text)
    }

    /// What is said of deleting an attribute that is not there or stays: objects without a dictionary know those of
    /// their class.
    #[cold]
    fn cannot_delete(&self, value: &Value, name: Symbol) -> Unwind {
        if name == known::CLASS && !matches!(value, Value::Class(_)) {
            return self.type_error("can't delete __class__ attribute");
        }
        match value {
            Value::Class(class) if !class.is_script => {
                let (name, class) = (self.core.symbols.name(name), class.type_name());
                self.type_error(format!(
                    "cannot set '{name}' attribute of immutable type '{class}'"
                ))
            }
            Value::Class(_) | Value::Function(_) => self.attribute_error(value, name),
            Value::Module(_) => self.no_attribute(value, name),
            Value::Instance(instance) if instance.class.base == BuiltinBase::Module => {
                self.no_attribute(value, name)
            }
            Value::Instance(instance) if instance.exception().is_some() => {
                let text = self.core.symbols.name(name);
                match &*text {
                    "__dict__" => self.type_error("cannot delete __dict__"),
                    "args" | "__cause__" | "__context__" | "__traceback__" => {
                        self.type_error(format!("{text} may not be deleted"))
                    }
                    _ => self.attribute_error(value, name),
                }
            }
            Value::Instance(instance)
                if instance.class.is_script && instance.class.takes_attribute(name) =>
            {
                self.attribute_error(value, name)
            }
            _ => self.cannot_set(value, name),
        }
    }

    /// Python's `object.__delattr__`.
    pub fn plain_delete_attribute(
        &self,
        value: &Value,
        instance: &Rc<Instance>,
        name: Symbol,
    ) -> R<()> {
        match instance.class.lookup(name) {
            Some(Value::Property(property)) => {
                if property.delete.is_none() {
                    if let Some(refused) = self.refused_by_type(value, name) {
                        return Err(refused);
                    }
                    let (name, class) = (
                        self.core.symbols.name(name),
                        self.qualname_of(&instance.class),
                    );
                    let message = format!("property '{name}' of '{class}' object has no deleter");
                    return Err(self.raise(ExceptionKind::AttributeError, message));
                }
                return self.call1(&property.delete, value.clone()).map(|_| ());
            }
            Some(Value::Instance(descriptor)) => {
                if let Some(delete) = descriptor.class.lookup(known::DELETE) {
                    let descriptor = Value::Instance(descriptor);
                    return self
                        .call_method_value(&delete, &descriptor, &mut [value.clone()])
                        .map(|_| ());
                }
                if descriptor.class.lookup(known::SET).is_some() {
                    return Err(self.raise(ExceptionKind::AttributeError, "__delete__"));
                }
            }
            _ => {}
        }
        let has_dict = instance.class.is_script && instance.class.has_dict();
        if name == known::DICT && has_dict && instance.exception().is_none() {
            instance.set_dict(Rc::new(Dict::new()), &self.core.symbols);
            return Ok(());
        }
        if instance.remove(name, &self.core.symbols) {
            Ok(())
        } else if instance.class.has_slot(name) {
            // A slot that is empty says no more than its name.
            let name = self.core.symbols.name(name);
            Err(self.raise(ExceptionKind::AttributeError, name.to_string()))
        } else {
            Err(self.cannot_delete(value, name))
        }
    }
}
