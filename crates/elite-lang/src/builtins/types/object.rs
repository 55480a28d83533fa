//! `object`, `type`, and what every object can do by nature.

use std::rc::Rc;

use elite_syntax::ast::CompareOp;

use super::{methods, raw_constructor, raw_method, wrong_receiver};
use crate::builtins::Args;
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::ops::hash::address_hash;
use crate::value::function::WrappedFunction;
use crate::value::instance::InstancePayload;
use crate::value::symbol::{TempSymbol, known};
use crate::value::{Instance, R, Value, ValueVec};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    raw_constructor(&types.object, |ev, args| {
        if !args.positional.is_empty() || !args.keywords.is_empty() {
            return Err(ev.type_error("object() takes no arguments"));
        }
        let class = ev.core.types.object.clone();
        Ok(Value::Instance(Instance::new(class, InstancePayload::None)))
    });
    raw_constructor(&types.none, |ev, args| {
        singleton(ev, args, "NoneType", Value::None)
    });
    raw_constructor(&types.ellipsis, |ev, args| {
        singleton(ev, args, "EllipsisType", Value::Ellipsis)
    });
    raw_constructor(&types.not_implemented, |ev, args| {
        singleton(ev, args, "NotImplementedType", Value::NotImplemented)
    });
    raw_constructor(&types.type_, type_of);
    methods(
        core,
        &types.type_,
        &[
            ("mro", "", |ev, args| {
                let order = ev.attribute(&args[0], known::MRO)?;
                ev.collect(&order).map(ValueVec::into_list)
            }),
            ("__subclasses__", "", |ev, args| match &args[0] {
                Value::Class(class) => Ok(Value::list(
                    class.subclasses().into_iter().map(Value::Class).collect(),
                )),
                other => {
                    let name = ev.core.types.name_of(other);
                    Err(ev.type_error(format!(
                        "descriptor '__subclasses__' for 'type' objects doesn't apply to a '{name}' object"
                    )))
                }
            }),
        ],
    );
    raw_method(core, &types.type_, "__call__", |ev, args| {
        let Some((class, rest)) = args.positional.split_first_mut() else {
            return Err(ev.type_error("descriptor '__call__' of 'type' object needs an argument"));
        };
        match class {
            Value::Class(class) => ev.instantiate(&class.clone(), rest, args.keywords, None),
            other => Err(wrong_receiver(ev, "type", other)),
        }
    });
    methods(
        core,
        &types.type_,
        &[
            ("__setattr__", "name value /", |ev, args| {
                let name = name_of(ev, &args[1])?;
                match &args[0] {
                    Value::Class(class) if class.is_script => {
                        ev.plain_set_class_attribute(&args[0], class, *name, args[2].clone())?;
                    }
                    other => ev.set_attribute(other, *name, args[2].clone())?,
                }
                Ok(Value::None)
            }),
            ("__delattr__", "name /", |ev, args| {
                let name = name_of(ev, &args[1])?;
                match &args[0] {
                    Value::Class(class) if class.is_script => {
                        ev.plain_delete_class_attribute(&args[0], class, *name)?;
                    }
                    other => ev.delete_attribute(other, *name)?,
                }
                Ok(Value::None)
            }),
            ("__instancecheck__", "instance /", |ev, args| {
                match &args[0] {
                    Value::Class(class) => Ok(Value::Bool(
                        ev.core.types.of(&args[1]).is_subclass_of(class),
                    )),
                    other => Err(wrong_receiver(ev, "type", other)),
                }
            }),
            ("__subclasscheck__", "subclass /", |ev, args| {
                match (&args[0], &args[1]) {
                    (Value::Class(class), Value::Class(other)) => {
                        Ok(Value::Bool(other.is_subclass_of(class)))
                    }
                    (Value::Class(_), _) => {
                        Err(ev.type_error("issubclass() arg 1 must be a class"))
                    }
                    (other, _) => Err(wrong_receiver(ev, "type", other)),
                }
            }),
        ],
    );
    let prepare = crate::builtins::Builtin::raw("__prepare__", |_, _| {
        Ok(Value::Dict(Rc::new(crate::value::Dict::new())))
    });
    types.type_.set(
        core.symbols.intern("__prepare__"),
        Value::StaticMethod(WrappedFunction::around(prepare)),
    );
    install_natural(core);
}

/// What changes an object is not for classes: `type` has its own.
fn refuse_class(ev: &Evaluator<'_>, value: &Value, method: &str) -> R<()> {
    if let Value::Class(_) = value {
        let name = ev.core.types.name_of(value);
        let text = format!("can't apply this {method} to {name} object");
        return Err(ev.type_error(text));
    }
    Ok(())
}

/// The only value of a type.
fn singleton(ev: &Evaluator<'_>, args: &Args<'_>, name: &str, value: Value) -> R {
    match args.positional.is_empty() && args.keywords.is_empty() {
        true => Ok(value),
        false => Err(ev.type_error(format!("{name} takes no arguments"))),
    }
}

/// What every object has unless its class says otherwise. These are not found by lookups of special methods, only
/// when a script names them: `super().__init__()`, `object.__setattr__(self, name, to_value)`.
fn install_natural(core: &Rc<InterpreterState>) {
    let natural = &core.types.natural;
    raw_method(core, natural, "__init__", |ev, args| {
        let excess = args.positional.len() > 1 || !args.keywords.is_empty();
        match args.positional.first() {
            Some(Value::Instance(instance)) if excess => ev.check_no_arguments(&instance.class),
            _ => Ok(()),
        }?;
        Ok(Value::None)
    });
    raw_method(core, natural, "__init_subclass__", |ev, args| {
        if args.keywords.is_empty() {
            return Ok(Value::None);
        }
        let name = match args.positional.first() {
            Some(Value::Class(class)) => ev.qualname_of(class),
            _ => "object".to_owned(),
        };
        let text = format!("{name}.__init_subclass__() takes no keyword arguments");
        Err(ev.type_error(text))
    });
    raw_method(core, natural, "__subclasshook__", |_, _| {
        Ok(Value::NotImplemented)
    });
    let new = crate::builtins::Builtin::raw("__new__", |ev, args| {
        let object = ev.core.types.object.clone();
        ev.new_by(&object, args.positional, args.keywords)
    });
    natural.set(
        known::NEW,
        Value::StaticMethod(WrappedFunction::around(new)),
    );
    methods(
        core,
        natural,
        &[
            ("__str__", "", |ev, args| {
                // The text is that of the `__repr__` that the object has, whatever that gives when it is a script's.
                match ev.core.types.of(&args[0]).lookup(known::REPR) {
                    Some(method @ Value::Function(_)) => {
                        ev.call_method_value(&method, &args[0], &mut [])
                    }
                    _ => ev.repr_value(&args[0]),
                }
            }),
            ("__repr__", "", |ev, args| {
                ev.new_str(ev.bare_repr(&args[0]))
            }),
            ("__format__", "spec /", |ev, args| {
                super::check_spec(ev, &args[1])?;
                if ev.truth(&args[1])? {
                    let name = ev.core.types.name_of(&args[0]);
                    return Err(ev.type_error(format!(
                        "unsupported format string passed to {name}.__format__"
                    )));
                }
                ev.str_value(&args[0])
            }),
            ("__hash__", "", |_, args| {
                Ok(Value::Int(
                    address_hash(args[0].address().unwrap_or(0)) as i64
                ))
            }),
            ("__eq__", "other /", |_, args| {
                Ok(identity(&args[0], &args[1], true))
            }),
            ("__ne__", "other /", |ev, args| {
                let equal = ev.compare(CompareOp::Eq, &args[0], &args[1])?;
                ev.truth(&equal).map(|equal| Value::Bool(!equal))
            }),
            ("__lt__", "other /", |_, _| Ok(Value::NotImplemented)),
            ("__le__", "other /", |_, _| Ok(Value::NotImplemented)),
            ("__gt__", "other /", |_, _| Ok(Value::NotImplemented)),
            ("__ge__", "other /", |_, _| Ok(Value::NotImplemented)),
            ("__getattribute__", "name /", |ev, args| {
                let name = name_of(ev, &args[1])?;
                let found = match &args[0] {
                    Value::Instance(instance) => {
                        ev.plain_instance_attribute(&args[0], instance, *name)?
                    }
                    other => ev.attribute_or_none(other, *name)?,
                };
                found.ok_or_else(|| {
                    let (class, name) =
                        (ev.core.types.name_of(&args[0]), ev.core.symbols.name(*name));
                    ev.raise(
                        ExceptionKind::AttributeError,
                        format!("'{class}' object has no attribute '{name}'"),
                    )
                })
            }),
            ("__setattr__", "name value /", |ev, args| {
                refuse_class(ev, &args[0], "__setattr__")?;
                let name = name_of(ev, &args[1])?;
                match &args[0] {
                    Value::Instance(instance) => ev
                        .plain_set_attribute(&args[0], instance, *name, args[2].clone())
                        .map(|()| Value::None),
                    other => ev
                        .set_attribute(other, *name, args[2].clone())
                        .map(|()| Value::None),
                }
            }),
            ("__delattr__", "name /", |ev, args| {
                refuse_class(ev, &args[0], "__delattr__")?;
                let name = name_of(ev, &args[1])?;
                match &args[0] {
                    Value::Instance(instance) => ev
                        .plain_delete_attribute(&args[0], instance, *name)
                        .map(|()| Value::None),
                    other => ev.delete_attribute(other, *name).map(|()| Value::None),
                }
            }),
            ("__dir__", "", |ev, args| {
                crate::builtins::scope::attribute_names(ev, &args[0]).map(ValueVec::into_list)
            }),
            ("__getstate__", "", |ev, args| ev.state_of(&args[0])),
            ("__sizeof__", "", |_, _| {
                Ok(Value::Int(size_of::<Instance>() as i64))
            }),
        ],
    );
}

impl Evaluator<'_> {
    /// What `object.__getstate__` gives: the attributes of an instance, in a pair with those of its slots if it has
    /// some.
    fn state_of(&self, value: &Value) -> R {
        let Value::Instance(instance) = value else {
            return Ok(Value::None);
        };
        let dict = match self.attribute_or_none(value, known::DICT)? {
            Some(Value::Dict(dict)) if !dict.is_empty() => Value::Dict(dict),
            _ => Value::None,
        };
        let slots = crate::value::Dict::new();
        for class in instance.class.mro() {
            for name in class.own_slots() {
                self.charge(crate::limits::yielding::WORK_PER_VALUE)?;
                if let Some(found) = instance.get(name, &self.core.symbols) {
                    self.dict_set(&slots, self.core.symbols.to_value(name), found)?;
                }
            }
        }
        if slots.is_empty() {
            return Ok(dict);
        }
        let pair = Value::pair(dict, Value::Dict(Rc::new(slots)));
        self.core.gc_track(&pair);
        Ok(pair)
    }
}

fn identity(a: &Value, b: &Value, equal: bool) -> Value {
    if a.is(b) == equal {
        Value::Bool(true)
    } else {
        Value::NotImplemented
    }
}

fn name_of<'e>(ev: &'e Evaluator<'_>, name: &Value) -> R<TempSymbol<'e>> {
    match name {
        Value::Str(text) => ev.temp_symbol(text.as_str()),
        other => {
            let name = ev.core.types.name_of(other);
            Err(ev.type_error(format!("attribute name must be string, not '{name}'")))
        }
    }
}

/// `type(to_value)`, or `type(name, bases, dict)`.
fn type_of(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    match &*args.positional {
        [value] => Ok(Value::Class(ev.core.types.of(value).clone())),
        [_, _, _] => {
            let (type_, caller) = (&ev.core.types.type_, args.caller.as_ref());
            ev.new_class(type_, args.positional, args.keywords, caller)
        }
        _ => Err(ev.type_error("type() takes 1 or 3 arguments")),
    }
}
