//! `abc`: abstract classes, which refuse instances while methods are missing and know classes as theirs that are not
//! derived from them. What has been found out about a class is kept, as in CPython: that it is one for ever, that it is
//! none until the next `register` of any class.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::{Rc, Weak};

use super::collections::missing_arguments;
use super::define::{ModuleBuilder, instance};
use crate::builtins::{Args, Builtin};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::data::no_values;
use crate::value::function::WrappedFunction;
use crate::value::symbol::known;
use crate::value::weak::WeakList;
use crate::value::{Class, Dict, R, Value, ValueVec};

const DATA: &str = "_abc_data";
const FULL_DATA: &str = "abc._abc_data";
/// Classes up to which a list is not searched for those that are gone.
const LEAST: usize = 32;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.class(DATA, None, &[]);
    let type_ = module.core().types.type_.clone();
    let metaclass = module.derived_class(
        "ABCMeta",
        &type_,
        &[
            ("register", "subclass", register),
            ("__instancecheck__", "instance", |ev, args| {
                has_instance(ev, class_argument(ev, &args[0])?, &args[1]).map(Value::Bool)
            }),
            ("__subclasscheck__", "subclass", |ev, args| {
                has_subclass(ev, class_argument(ev, &args[0])?, &args[1]).map(Value::Bool)
            }),
        ],
    )?;
    let new = Builtin::raw("__new__", make);
    metaclass.set(
        known::NEW,
        Value::StaticMethod(WrappedFunction::around(new)),
    );
    let attrs = vec![
        (known::MODULE, Value::str("abc")),
        (known::SLOTS, Value::tuple(Vec::new())),
    ];
    let abc = module.ev.make_class("ABC", &[], attrs)?;
    abc.set_metaclass(metaclass);
    let abc = Value::Class(abc);
    set_missing(module.ev, &abc, ValueVec::default())?;
    module.value("ABC", abc);
    module.functions(&[
        ("abstractmethod", "funcobj", |ev, args| {
            mark_abstract(ev, &args[0])
        }),
        ("abstractclassmethod", "callable", |ev, args| {
            let function = mark_abstract(ev, &args[0])?;
            Ok(Value::ClassMethod(WrappedFunction::around(function)))
        }),
        ("abstractstaticmethod", "callable", |ev, args| {
            let function = mark_abstract(ev, &args[0])?;
            Ok(Value::StaticMethod(WrappedFunction::around(function)))
        }),
        ("abstractproperty", "fget? fset? fdel? doc?", |ev, args| {
            let given = |value: &Value| value.if_given().cloned().unwrap_or(Value::None);
            let mut parts: Vec<Value> = args.iter().map(given).collect();
            if !parts[0].is_none() {
                parts[0] = mark_abstract(ev, &parts[0])?;
            }
            let property = Value::Class(ev.core.types.property.clone());
            ev.call(&property, &mut parts, &[])
        }),
        ("update_abstractmethods", "cls", |ev, args| {
            update(ev, &args[0])
        }),
        ("get_cache_token", "", |ev, _| {
            Ok(Value::Int(ev.core.abc_registrations.get() as i64))
        }),
        ("_has_method", "cls name /", |ev, args| {
            let (class, Value::Str(name)) = (class_argument(ev, &args[0])?, &args[1]) else {
                return Err(ev.type_error("_has_method() argument 2 must be str"));
            };
            let name = *ev.temp_symbol(name.as_str())?;
            // What every object has by nature is looked at nowhere else.
            let found = class.lookup(name);
            let has = found.map_or(name == known::HASH, |found| !found.is_none());
            Ok(Value::Bool(has))
        }),
    ]);
    Ok(())
}

/// What an abstract class knows of others.
#[derive(Default)]
struct AbcRegistry {
    registered: WeakList<Class>,
    derived: WeakClassSet,
    /// Classes that are not derived, as long as no more classes have been registered anywhere.
    others: WeakClassSet,
    others_since: Cell<usize>,
}

no_values!(AbcRegistry);

/// Classes that are not kept alive.
#[derive(Default)]
struct WeakClassSet {
    classes: RefCell<HashMap<*const Class, Weak<Class>>>,
    limit: Cell<usize>,
}

impl WeakClassSet {
    fn has(&self, class: &Rc<Class>) -> bool {
        self.classes.borrow().contains_key(&Rc::as_ptr(class))
    }

    fn add(&self, ev: &Evaluator<'_>, class: &Rc<Class>) -> R<()> {
        let mut classes = self.classes.borrow_mut();
        if classes.len() >= self.limit.get().max(LEAST) {
            let looked_at = classes.len();
            classes.retain(|_, class| class.strong_count() > 0);
            self.limit.set(classes.len() * 2);
            ev.charge(looked_at * WORK_PER_VALUE)?;
        }
        classes.insert(Rc::as_ptr(class), Rc::downgrade(class));
        Ok(())
    }

    fn clear(&self) {
        self.classes.borrow_mut().clear();
    }
}

fn class_argument<'v>(ev: &Evaluator<'_>, value: &'v Value) -> R<&'v Rc<Class>> {
    match value {
        Value::Class(class) => Ok(class),
        other => {
            let name = ev.core.types.name_of(other);
            Err(ev.type_error(format!("a class is needed, not '{name}'")))
        }
    }
}

/// Runs `inner` on what an abstract class knows.
fn with_known<O>(
    ev: &Evaluator<'_>,
    class: &Rc<Class>,
    inner: impl FnOnce(&AbcRegistry) -> R<O>,
) -> R<O> {
    let found = class.own_attrs().get(known::ABC_IMPL).cloned();
    let data = match found {
        Some(Value::Instance(data)) if data.object::<AbcRegistry>().is_some() => {
            Value::Instance(data)
        }
        _ => {
            let data = instance(ev, FULL_DATA, AbcRegistry::default())?;
            class.set(known::ABC_IMPL, data.clone());
            data
        }
    };
    match &data {
        Value::Instance(data) if let Some(known) = data.object::<AbcRegistry>() => inner(known),
        _ => Err(ev.type_error("_abc_impl is set to a wrong type")),
    }
}

/// `ABCMeta.__new__(metaclass, name, bases, names, **keywords)`: the class, and which of its methods are missing.
fn make(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let needed = ["'mcls'", "'name'", "'bases'", "'namespace'"];
    let missing = &needed[args.positional.len().min(needed.len())..];
    if !missing.is_empty() {
        let text = format!("ABCMeta.__new__() {}", missing_arguments(missing));
        return Err(ev.type_error(text));
    }
    let [metaclass, rest @ ..] = &*args.positional else {
        return Ok(Value::None); // There are four.
    };
    let metaclass = class_argument(ev, metaclass)?;
    let made = ev.new_class(metaclass, rest, args.keywords, args.caller.as_ref())?;
    let (Value::Class(class), [_, _, names]) = (&made, rest) else {
        return Ok(made);
    };
    let mut missing = ValueVec::default();
    if let Value::Dict(names) = ev.unwrap_builtin(names) {
        add_abstract(ev, &names, &mut missing)?;
    }
    add_inherited(ev, class, &mut missing)?;
    set_missing(ev, &made, missing)?;
    class.set(
        known::ABC_IMPL,
        instance(ev, FULL_DATA, AbcRegistry::default())?,
    );
    Ok(made)
}

/// `update_abstractmethods(cls)`
fn update(ev: &Evaluator<'_>, value: &Value) -> R {
    if ev
        .attribute_or_none(value, known::ABSTRACT_METHODS)?
        .is_none()
    {
        return Ok(value.clone());
    }
    let class = class_argument(ev, value)?;
    let mut missing = ValueVec::default();
    if let Value::Dict(names) = ev.attribute(value, known::DICT)? {
        add_abstract(ev, &names, &mut missing)?;
    }
    add_inherited(ev, class, &mut missing)?;
    set_missing(ev, value, missing)?;
    Ok(value.clone())
}

/// Appends the names of what is abstract among these.
fn add_abstract(ev: &Evaluator<'_>, names: &Dict, missing: &mut ValueVec) -> R<()> {
    for (_, name, value) in ev.collect_entries(names)? {
        if is_abstract(ev, &value)? {
            missing.push(name);
        }
    }
    Ok(())
}

/// Appends the names of what is abstract in a base, and still in the class.
fn add_inherited(ev: &Evaluator<'_>, class: &Rc<Class>, missing: &mut ValueVec) -> R<()> {
    let value = Value::Class(class.clone());
    for base in class.bases().iter() {
        let inherited = Value::Class(base.clone());
        let Some(names) = ev.attribute_or_none(&inherited, known::ABSTRACT_METHODS)? else {
            continue;
        };
        for name in ev.collect(&names)? {
            ev.charge(WORK_PER_VALUE)?;
            let Value::Str(text) = &name else {
                continue;
            };
            let symbol = ev.temp_symbol(text.as_str())?;
            if let Some(found) = ev.attribute_or_none(&value, *symbol)?
                && is_abstract(ev, &found)?
            {
                missing.push(name);
            }
        }
    }
    Ok(())
}

fn set_missing(ev: &Evaluator<'_>, class: &Value, missing: ValueVec) -> R<()> {
    let frozenset = Value::Class(ev.core.types.frozenset.clone());
    let missing = ev.call1(&frozenset, missing.into_list())?;
    ev.set_attribute(class, known::ABSTRACT_METHODS, missing)
}

/// A function, marked as an abstract one.
fn mark_abstract(ev: &Evaluator<'_>, function: &Value) -> R {
    ev.set_attribute(function, known::IS_ABSTRACT, Value::Bool(true))?;
    Ok(function.clone())
}

fn is_abstract(ev: &Evaluator<'_>, value: &Value) -> R<bool> {
    match ev.attribute_or_none(value, known::IS_ABSTRACT)? {
        Some(answer) => ev.truth(&answer),
        None => Ok(false),
    }
}

/// `cls.register(subclass)`
fn register(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let class = class_argument(ev, &args[0])?;
    let Value::Class(other) = &args[1] else {
        return Err(ev.type_error("Can only register classes"));
    };
    if ev.is_subclass(other, &args[0])? {
        return Ok(args[1].clone());
    }
    if ev.is_subclass(class, &args[1])? {
        let text = "Refusing to create an inheritance cycle";
        return Err(ev.raise(ExceptionKind::RuntimeError, text));
    }
    with_known(ev, class, |known| {
        known.registered.push(other);
        Ok(())
    })?;
    let registered = &ev.core.abc_registrations;
    registered.set(registered.get() + 1);
    Ok(args[1].clone())
}

/// `isinstance(value, class)`
fn has_instance(ev: &Evaluator<'_>, class: &Rc<Class>, value: &Value) -> R<bool> {
    let own = ev.core.types.of(value);
    let said = match value {
        // Objects may say that they are of another class.
        Value::Instance(_) if own.is_script => ev.attribute(value, known::CLASS)?,
        _ => Value::Class(own.clone()),
    };
    let is_own = matches!(&said, Value::Class(said) if Rc::ptr_eq(said, own));
    let answer = with_known(ev, class, |known| {
        Ok(match &said {
            Value::Class(said) if known.derived.has(said) => Some(true),
            _ if is_own && is_known_unrelated(ev, known, own) => Some(false),
            _ => None,
        })
    })?;
    if let Some(answer) = answer {
        return Ok(answer);
    }
    let check = ev.attribute(&Value::Class(class.clone()), known::SUBCLASS_CHECK)?;
    let asked = |class: Value| {
        let answer = ev.call1(&check, class)?;
        ev.truth(&answer)
    };
    Ok(asked(said)? || !is_own && asked(Value::Class(own.clone()))?)
}

/// Whether a class is known not to be derived.
fn is_known_unrelated(ev: &Evaluator<'_>, known: &AbcRegistry, other: &Rc<Class>) -> bool {
    let now = ev.core.abc_registrations.get();
    if known.others_since.replace(now) != now {
        known.others.clear();
    }
    known.others.has(other)
}

/// `issubclass(other, class)`
fn has_subclass(ev: &Evaluator<'_>, class: &Rc<Class>, other: &Value) -> R<bool> {
    let Value::Class(other) = other else {
        return Err(ev.type_error("issubclass() arg 1 must be a class"));
    };
    let answer = with_known(ev, class, |known| {
        Ok(match known.derived.has(other) {
            true => Some(true),
            false => is_known_unrelated(ev, known, other).then_some(false),
        })
    })?;
    if let Some(answer) = answer {
        return Ok(answer);
    }
    let answer = ev.with_native_depth(|| find_out(ev, class, other))?;
    with_known(ev, class, |known| match answer {
        true => known.derived.add(ev, other),
        false => known.others.add(ev, other),
    })?;
    Ok(answer)
}

/// Whether a class counts as derived: the hook says so, it is, or one that is registered or derived knows it.
fn find_out(ev: &Evaluator<'_>, class: &Rc<Class>, other: &Rc<Class>) -> R<bool> {
    let hook = ev.attribute(&Value::Class(class.clone()), known::SUBCLASS_HOOK)?;
    match ev.call1(&hook, Value::Class(other.clone()))? {
        Value::Bool(answer) => return Ok(answer),
        Value::NotImplemented => {}
        _ => {
            let text = "__subclasshook__ must return either False, True, or NotImplemented";
            return Err(ev.raise(ExceptionKind::AssertionError, text));
        }
    }
    if other.is_subclass_of(class) {
        return Ok(true);
    }
    let mut known = Vec::new();
    with_known(ev, class, |own| {
        own.registered
            .for_each_alive(|class| known.push(class.clone()));
        Ok(())
    })?;
    known.extend(class.subclasses());
    for known in known {
        ev.charge(WORK_PER_VALUE)?;
        if ev.is_subclass(other, &Value::Class(known))? {
            return Ok(true);
        }
    }
    Ok(false)
}
