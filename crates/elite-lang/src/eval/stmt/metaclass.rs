//! Metaclasses: which one a `class` statement uses, its `__prepare__`, and `type.__new__`.

use std::rc::Rc;

use super::define::ATTRIBUTE;
use crate::eval::{Evaluator, Frame};
use crate::value::class::BuiltinBase;
use crate::value::symbol::known;
use crate::value::{Class, Dict, R, Symbol, Value};

const CONFLICT: &str = "metaclass conflict: the metaclass of a derived class must be a (non-strict) subclass of the \
    metaclasses of all its bases";

impl Evaluator<'_> {
    /// What makes a class with these bases and keywords; None for `type`, which needs no call.
    pub fn metaclass_of(&self, bases: &[Value], keywords: &[(Symbol, Value)]) -> R<Option<Value>> {
        let given = keywords.iter().find(|(name, _)| *name == known::METACLASS);
        let given = match given.map(|(_, value)| value) {
            Some(Value::Class(class)) if class.base == BuiltinBase::Type => class.clone(),
            // Anything that can be called may stand there.
            Some(other) => return Ok(Some(other.clone())),
            None => match bases.first() {
                None | Some(Value::Class(_)) => self.core.types.type_.clone(),
                // What is no class is asked for one by its own.
                Some(other) => self.core.types.of(other).clone(),
            },
        };
        let winner = self.most_derived(given, bases)?;
        let plain = Rc::ptr_eq(&winner, &self.core.types.type_);
        Ok((!plain).then_some(Value::Class(winner)))
    }

    /// The most derived of a metaclass and those of the bases.
    fn most_derived(&self, mut winner: Rc<Class>, bases: &[Value]) -> R<Rc<Class>> {
        for base in bases {
            let other = self.core.types.of(base);
            if other.is_subclass_of(&winner) {
                winner = other.clone();
            } else if !winner.is_subclass_of(other) {
                return Err(self.type_error(CONFLICT));
            }
        }
        Ok(winner)
    }

    /// What `__prepare__` of the metaclass returns: a dictionary with names for the body, or an object that sees the
    /// names as they are bound; None without one.
    pub fn prepared_namespace(
        &self,
        metaclass: &Value,
        name: &str,
        bases: &[Value],
        keywords: &[(Symbol, Value)],
    ) -> R {
        let prepare = self.core.symbols.intern("__prepare__");
        let Some(prepare) = self.attribute_or_none(metaclass, prepare)? else {
            return Ok(Value::None);
        };
        let mut args = [Value::str(name), Value::tuple(bases.to_vec())];
        match self.call(&prepare, &mut args, keywords)? {
            dict @ Value::Dict(_) => Ok(dict),
            Value::Instance(instance) if instance.class.lookup(known::SETITEM).is_some() => {
                Ok(Value::Instance(instance))
            }
            other => {
                let (owner, found) = (self.label(metaclass), self.core.types.name_of(&other));
                Err(self.type_error(format!(
                    "{owner}.__prepare__() must return a mapping, not {found}"
                )))
            }
        }
    }

    /// The names a prepared dictionary puts into the body before it runs.
    pub fn prepared_names(&self, prepared: &Value) -> R<Vec<(Symbol, Value)>> {
        match prepared {
            Value::Dict(dict) => self.named_attrs(dict),
            _ => Ok(Vec::new()),
        }
    }

    fn label(&self, metaclass: &Value) -> Rc<str> {
        match metaclass {
            Value::Class(class) => class.name(),
            _ => "<metaclass>".into(),
        }
    }

    fn named_attrs(&self, dict: &Dict) -> R<Vec<(Symbol, Value)>> {
        let mut named = Vec::new();
        for (_, key, value) in self.collect_entries(dict)? {
            if let Value::Str(text) = self.unwrap_builtin(&key) {
                named.push((self.intern_name(text.as_str())?, value));
            }
            self.charge(ATTRIBUTE)?;
        }
        Ok(named)
    }

    /// Calls a metaclass with what the body of a class has made. `cell` holds `__class__` for its methods; the
    /// class is put into it by `type.__new__`.
    pub fn call_metaclass(
        &self,
        metaclass: &Value,
        name: &str,
        bases: &[Value],
        attrs: Vec<(Symbol, Value)>,
        cell: Option<Value>,
        keywords: &[(Symbol, Value)],
    ) -> R {
        let dict = Dict::new();
        for (name, value) in attrs {
            self.dict_set(&dict, self.core.symbols.to_value(name), value)?;
            self.charge(ATTRIBUTE)?;
        }
        if let Some(cell) = cell {
            dict.set_interned(self.core.symbols.to_value(known::CLASSCELL), cell);
        }
        let mut args = [
            Value::str(name),
            Value::tuple(bases.to_vec()),
            Value::Dict(Rc::new(dict)),
        ];
        self.call(metaclass, &mut args, keywords)
    }

    /// `type.__new__(metaclass, name, bases, dict)`; a class whose names do not say from which module it is belongs to
    /// that of the caller.
    pub fn new_class(
        &self,
        metaclass: &Rc<Class>,
        args: &[Value],
        keywords: &[(Symbol, Value)],
        caller: Option<&Frame<'_>>,
    ) -> R {
        let [name, bases, dict] = args else {
            return Err(self.type_error(format!(
                "type.__new__() takes exactly 3 arguments ({} given)",
                args.len()
            )));
        };
        let wrong = |number: u8, wanted: &str, found: &Value| {
            let found = self.core.types.name_of(found);
            let text = format!("type.__new__() argument {number} must be {wanted}, not {found}");
            self.type_error(text)
        };
        let Value::Str(name) = self.unwrap_builtin(name) else {
            return Err(wrong(1, "str", name));
        };
        let Value::Tuple(bases) = self.unwrap_builtin(bases) else {
            return Err(wrong(2, "tuple", bases));
        };
        let Value::Dict(dict) = self.unwrap_builtin(dict) else {
            return Err(wrong(3, "dict", dict));
        };
        let winner = self.most_derived(metaclass.clone(), bases.items())?;
        if !Rc::ptr_eq(&winner, metaclass)
            && let Some(Value::StaticMethod(new)) = winner.lookup(known::NEW)
        {
            let mut all = vec![Value::Class(winner)];
            all.extend_from_slice(args);
            return self.call(&new, &mut all, keywords);
        }
        let held = self.pause_sweep();
        let mut attrs = self.named_attrs(&dict)?;
        let cell = attrs.iter().position(|(name, _)| *name == known::CLASSCELL);
        let cell = cell.map(|index| attrs.remove(index).1);
        if !attrs.iter().any(|(name, _)| *name == known::MODULE) {
            let code = caller.map(|frame| &*frame.function.code);
            let module = match code.map(|code| (code, code.refs.home())) {
                // What is called so in the dictionary that the caller's names are in, whatever its builtins are called.
                Some((_, Some(home))) => {
                    let none = || self.core.name_of_builtins.value.get();
                    home.get_str("__name__").unwrap_or_else(none)
                }
                Some((code, None)) => self.module_of(code),
                None => self.core.symbols.to_value(known::MAIN),
            };
            attrs.push((known::MODULE, module));
        }
        let class = self.make_class(name.as_str(), bases.items(), attrs)?;
        drop(held);
        self.sweep_names_if_due()?;
        if !Rc::ptr_eq(&winner, &self.core.types.type_) {
            class.set_metaclass(winner);
        }
        if let Some(Value::Cell(cell)) = cell {
            drop(cell.replace(Value::Class(class.clone())));
        }
        self.finish_class(&class, keywords)?;
        Ok(Value::Class(class))
    }
}
