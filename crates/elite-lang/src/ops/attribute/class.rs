//! What every class has by nature, CPython's `type_getsets` and `type_members`: what they say, and what may be put
//! there.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::stmt::layout::best_base;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::dict::REHASH_CHUNK;
use crate::value::symbol::known;
use crate::value::{Class, Dict, R, Symbol, Unwind, Value, ValueVec};

impl Evaluator<'_> {
    /// A part of a class that hides whatever its attributes have under that name.
    pub(super) fn part_of_class(
        &self,
        value: &Value,
        class: &Rc<Class>,
        name: Symbol,
    ) -> R<Option<Value>> {
        let all =
            |classes: Vec<Rc<Class>>| Value::tuple(classes.into_iter().map(Value::Class).collect());
        Ok(Some(match name {
            known::NAME => Value::str(&*class.name()),
            known::QUALNAME => Value::str(&*class.qualname()),
            known::CLASS => Value::Class(self.core.types.of(value).clone()),
            known::BASES => all(class.bases().to_vec()),
            known::BASE => best_base(&class.bases()).map_or(Value::None, Value::Class),
            known::MRO => all(class.mro()),
            known::DICT => Value::Dict(Rc::new(self.dict_of_class(class)?)),
            _ => return Ok(None),
        }))
    }

    /// `__dict__` of a class: its attributes, and behind those that are written what it adds to its instances.
    fn dict_of_class(&self, class: &Rc<Class>) -> R<Dict> {
        let mut added = match class.is_script {
            true => self.member_descriptors(class)?,
            false => Vec::new(),
        };
        let dict = Dict::new();
        let (mut from, mut more) = (0, true);
        while more || !added.is_empty() {
            let mut entries = ValueVec::default();
            let count = match class.body_attr_count() {
                own if from < own => REHASH_CHUNK.min(own - from),
                _ => REHASH_CHUNK,
            };
            if from == class.body_attr_count() {
                std::mem::take(&mut added)
                    .into_iter()
                    .for_each(|part| entries.push(part));
            }
            more = class.own_attrs().entries_chunk(from, count, &mut entries);
            from += count;
            for (name, value) in entries {
                self.dict_set(&dict, self.core.symbols.to_value(name), value)?;
                self.charge(3 * WORK_PER_VALUE)?;
            }
        }
        Ok(dict)
    }

    /// Puts a value into a part of a class; None if the name is that of an attribute.
    pub(super) fn set_part_of_class(
        &self,
        class: &Rc<Class>,
        name: Symbol,
        new: &Value,
    ) -> R<Option<()>> {
        match name {
            known::NAME => {
                let text = self.name_for(class, "__name__", new)?;
                class.set_name(&text);
            }
            known::QUALNAME => {
                let text = self.name_for(class, "__qualname__", new)?;
                class.set_qualname(&text);
            }
            known::BASES => self.set_bases(class, new)?,
            known::CLASS => return Err(self.class_assignment_error(new)),
            known::ABSTRACT_METHODS => {
                class.set_abstract(self.truth(new)?);
                return Ok(None);
            }
            _ => return self.refuse_part_of_class(name).map(|()| None),
        }
        Ok(Some(()))
    }

    /// Refuses to delete what every class has.
    pub(super) fn keep_part_of_class(&self, class: &Class, name: Symbol) -> R<()> {
        if let known::NAME | known::QUALNAME | known::MODULE | known::BASES | known::DOC = name {
            let (name, class) = (self.core.symbols.name(name), class.name());
            let text = format!("cannot delete '{name}' attribute of immutable type '{class}'");
            return Err(self.type_error(text));
        }
        if name == known::ABSTRACT_METHODS {
            class.set_abstract(false);
        }
        self.refuse_part_of_class(name)
    }

    /// What is said of an instance of a class whose methods are missing.
    #[cold]
    pub fn abstract_error(&self, class: &Class) -> Unwind {
        let names = class.own_attrs().get(known::ABSTRACT_METHODS).cloned();
        let names = match names.map_or(Ok(ValueVec::default()), |names| self.collect(&names)) {
            Ok(names) => names,
            Err(raised) => return raised,
        };
        let of_name = |name: &Value| match name {
            Value::Str(text) => text.as_str().to_owned(),
            _ => String::new(),
        };
        let mut names: Vec<String> = names.iter().map(of_name).collect();
        names.sort_unstable();
        let plural = if names.len() > 1 { "s" } else { "" };
        self.type_error(format!(
            "Can't instantiate abstract class {} with abstract method{plural} {}",
            class.name(),
            names.join(", ")
        ))
    }

    /// Refuses what nothing can be put into.
    fn refuse_part_of_class(&self, name: Symbol) -> R<()> {
        let text = match name {
            known::DICT => "attribute '__dict__' of 'type' objects is not writable",
            known::BASE | known::MRO => "readonly attribute",
            _ => return Ok(()),
        };
        Err(self.raise(ExceptionKind::AttributeError, text))
    }

    fn name_for(&self, class: &Class, part: &str, new: &Value) -> R<Rc<str>> {
        let Value::Str(text) = self.unwrap_builtin(new) else {
            let (class, found) = (class.name(), self.core.types.name_of(new));
            let text = format!("can only assign string to {class}.{part}, not '{found}'");
            return Err(self.type_error(text));
        };
        self.check_name(text.as_str())?;
        if part == "__name__" && text.as_str().contains('\0') {
            return Err(self.value_error("type name must not contain null characters"));
        }
        Ok(text.as_str().into())
    }

    /// `__qualname__` as the body of a class has it.
    pub fn take_qualname(&self, class: &Class, found: &Value) -> R<()> {
        let Value::Str(text) = self.unwrap_builtin(found) else {
            let found = self.core.types.name_of(found);
            let text = format!("type __qualname__ must be a str, not {found}");
            return Err(self.type_error(text));
        };
        self.check_name(text.as_str())?;
        class.set_qualname(text.as_str());
        Ok(())
    }
}
