//! `int | str`: unions of types, for `isinstance`, `issubclass` and annotations.

use std::rc::Rc;

use super::methods;
use crate::eval::{Evaluator, InterpreterState};
use crate::value::data::{Contents, NativeData};
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Instance, R, Value};

/// The types of a union, each once, in the order written; None stands for its type.
pub struct UnionType(Vec<Value>);

impl Contents for UnionType {
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        self.0.iter().for_each(each);
    }

    fn clear(&self, _: &mut Vec<Value>) {}

    fn take(&mut self, held: &mut Vec<Value>) {
        *held = std::mem::take(&mut self.0);
    }
}

pub(super) fn install(core: &Rc<InterpreterState>) {
    let class = &core.types.union;
    class.set(known::MODULE, Value::str("types"));
    class.is_c_type.set(true);
    methods(
        core,
        class,
        &[
            ("__repr__", "", |ev, args| {
                let mut names = Vec::new();
                for member in members(&args[0]).unwrap_or_default() {
                    names.push(match member {
                        Value::Class(class) => {
                            format!("{}{}", ev.module_prefix(class), ev.qualname_of(class))
                        }
                        other => ev.repr(other)?,
                    });
                }
                Ok(Value::str(names.join(" | ")))
            }),
            ("__eq__", "other /", |_, args| {
                let (Some(a), Some(b)) = (members(&args[0]), members(&args[1])) else {
                    return Ok(Value::NotImplemented);
                };
                let within = |a: &[Value], b: &[Value]| a.iter().all(|x| b.iter().any(|y| x.is(y)));
                Ok(Value::Bool(within(a, b) && within(b, a)))
            }),
            ("__getitem__", "key /", |ev, args| {
                let shown = ev.repr(&args[0])?;
                Err(ev.type_error(format!("{shown} is not a generic class")))
            }),
            ("__hash__", "", |_, args| {
                let addresses = members(&args[0]).unwrap_or_default().iter();
                // The order does not count.
                let sum = addresses.fold(0, |sum: i64, member| {
                    sum.wrapping_add(member.address().unwrap_or(1) as i64)
                });
                Ok(Value::Int(sum))
            }),
        ],
    );
}

/// The members of a union; None if the value is no union.
pub fn members(value: &Value) -> Option<&[Value]> {
    match value {
        Value::Instance(instance) => instance.object::<UnionType>().map(|union| &union.0[..]),
        _ => None,
    }
}

impl Evaluator<'_> {
    /// The types of a union as a tuple; None if the value is no union.
    pub fn union_types(&self, value: &Value) -> Option<Value> {
        let types = members(value)?.iter().map(|member| self.union_type(member));
        Some(Value::tuple(types.collect()))
    }

    fn union_type(&self, member: &Value) -> Value {
        match member {
            Value::None => Value::Class(self.core.types.none.clone()),
            other => other.clone(),
        }
    }

    /// `a | b` of types, unions and None; None if that is no union.
    pub fn union(&self, a: &Value, b: &Value) -> R<Option<Value>> {
        let is_part = |value: &Value| {
            matches!(value, Value::Class(_) | Value::None) || members(value).is_some()
        };
        if !is_part(a) || !is_part(b) || a.is_none() && b.is_none() {
            return Ok(None);
        }
        let mut all: Vec<Value> = Vec::new();
        for value in [a, b] {
            for member in members(value).unwrap_or(std::slice::from_ref(value)) {
                if !all.iter().any(|other| other.is(member)) {
                    all.push(member.clone());
                }
            }
        }
        if let [single] = &all[..] {
            return Ok(Some(single.clone()));
        }
        let types = all.iter().map(|member| self.union_type(member));
        let args = Value::tuple(types.collect());
        let class = self.core.types.union.clone();
        let union = Instance::new(
            class,
            InstancePayload::Object(NativeData::new(UnionType(all))),
        );
        let name = self.core.symbols.intern("__args__");
        union.set(name, args, &self.core.symbols);
        Ok(Some(Value::Instance(union)))
    }
}
