//! `_operator`: the getters and callers of `operator`, which sorting calls for every item. The rest is a script.

use std::rc::Rc;

use super::define::{ModuleBuilder, native_class, with_data};
use crate::builtins::Args;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::data::{Contents, NativeData};
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Class, Instance, R, ScriptCell, Symbol, Value};

/// What a getter takes from an object or calls with it.
struct GetterSpec {
    /// The keys, the names, or the name of a method and the arguments by position.
    values: ScriptCell<Vec<Value>>,
    /// The arguments by name, each with the text of its name: symbols that only this knew would be given up.
    named: ScriptCell<Vec<(Value, Value)>>,
}

impl Contents for GetterSpec {
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        if let Some(values) = self.values.try_borrow() {
            values.iter().for_each(&mut *each);
        }
        if let Some(named) = self.named.try_borrow() {
            named.iter().for_each(|(_, value)| each(value));
        }
    }

    fn clear(&self, held: &mut Vec<Value>) {
        held.append(&mut self.values.take());
        held.extend(self.named.take().into_iter().map(|(_, value)| value));
    }

    fn take(&mut self, held: &mut Vec<Value>) {
        self.clear(held);
    }
}

const ITEMS: &str = "itemgetter";
const ATTRIBUTES: &str = "attrgetter";
const METHOD: &str = "methodcaller";

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("_row", "value /", row),
        ("length_hint", "obj default? /", length_hint),
        ("countOf", "a b /", count_of),
        ("indexOf", "a b /", index_of),
    ]);
    let items = module.class(ITEMS, None, &[]);
    let attributes = module.class(ATTRIBUTES, None, &[]);
    let method = module.class(METHOD, None, &[]);
    for class in [&items, &attributes, &method] {
        class.set(known::MODULE, Value::str("operator"));
    }
    for (class, name, make) in [
        (&items, ITEMS, make_items as crate::builtins::RawFn),
        (&attributes, ATTRIBUTES, make_attributes),
        (&method, METHOD, make_method),
    ] {
        class
            .constructor
            .put(crate::builtins::Builtin::raw(name, make));
    }
    module.raw_method(&items, ITEMS, "__call__", |ev, args| {
        let (asked, object) = parts(ev, ITEMS, args)?;
        get_each(ev, &asked, |key| ev.item(&object, key))
    });
    module.raw_method(&attributes, ATTRIBUTES, "__call__", |ev, args| {
        let (asked, object) = parts(ev, ATTRIBUTES, args)?;
        get_each(ev, &asked, |path| follow_path(ev, &object, path))
    });
    module.raw_method(&method, METHOD, "__call__", |ev, args| {
        let (asked, object) = parts(ev, METHOD, args)?;
        let mut given = asked.values.get();
        let name = given.first().cloned().unwrap_or_default();
        let method = along_one(ev, &object, &name)?;
        by_name(ev, &asked.named.get(), |keywords| {
            ev.call(&method, given.get_mut(1..).unwrap_or_default(), keywords)
        })
    });
    for (class, owner) in [
        (&items, ITEMS),
        (&attributes, ATTRIBUTES),
        (&method, METHOD),
    ] {
        module.raw_method(class, owner, "__repr__", |ev, args| {
            getter_repr(ev, &args.positional[0])
        });
        module.raw_method(class, owner, "__reduce__", |ev, args| {
            getter_reduce(ev, &args.positional[0])
        });
    }
    Ok(())
}

/// What can be joined to another: the value itself.
fn row(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let types = &ev.core.types;
    let is_joined = match ev.unwrap_builtin(&args[0]) {
        Value::Dict(_) | Value::Range(_) | Value::LongRange(_) => false,
        _ => types.of(&args[0]).lookup(known::GETITEM).is_some(),
    };
    if !is_joined {
        let name = types.name_of(&args[0]);
        return Err(ev.type_error(format!("'{name}' object can't be concatenated")));
    }
    Ok(args[0].clone())
}

fn length_hint(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let default = args[1]
        .if_given()
        .map_or(Ok(0), |default| match ev.unwrap_builtin(default) {
            Value::Int(_) | Value::BigInt(_) | Value::Bool(_) => ev.index(default),
            _ => {
                let name = ev.core.types.name_of(default);
                let text = format!("'{name}' object cannot be interpreted as an integer");
                Err(ev.type_error(text))
            }
        })?;
    let hint = ev.length_hint(&args[0])?;
    Ok(Value::Int(hint.unwrap_or(default)))
}

fn index_of(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let items = items_of(ev, &args[0])?;
    let mut index = 0;
    while let Some(item) = ev.next_at_safepoint(&items)? {
        ev.charge(WORK_PER_VALUE)?;
        if item.is(&args[1]) || ev.equal(&item, &args[1])? {
            return Ok(Value::Int(index));
        }
        index += 1;
    }
    Err(ev.value_error("sequence.index(x): x not in sequence"))
}

fn count_of(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let items = items_of(ev, &args[0])?;
    let mut count = 0;
    while let Some(item) = ev.next_at_safepoint(&items)? {
        ev.charge(WORK_PER_VALUE)?;
        count += i64::from(item.is(&args[1]) || ev.equal(&item, &args[1])?);
    }
    Ok(Value::Int(count))
}

fn items_of(ev: &Evaluator<'_>, value: &Value) -> R {
    ev.iter_or(value, || {
        let name = ev.core.types.name_of(value);
        format!("argument of type '{name}' is not iterable")
    })
}

fn make_items(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    check(ev, ITEMS, args)?;
    new_getter(ev, ITEMS, args)
}

fn make_attributes(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    check(ev, ATTRIBUTES, args)?;
    let is_text = |value: &Value| matches!(ev.unwrap_builtin(value), Value::Str(_));
    for name in &*args.positional {
        ev.charge(WORK_PER_VALUE)?;
        if !is_text(name) {
            return Err(ev.type_error("attribute name must be a string"));
        }
    }
    new_getter(ev, ATTRIBUTES, args)
}

fn make_method(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    match args.positional.first().map(|name| ev.unwrap_builtin(name)) {
        None => Err(ev.type_error("methodcaller needs at least one argument, the method name")),
        Some(Value::Str(_)) => new_getter(ev, METHOD, args),
        Some(_) => Err(ev.type_error("method name must be a string")),
    }
}

/// Refuses arguments by name and a call without arguments.
fn check(ev: &Evaluator<'_>, name: &str, args: &Args<'_>) -> R<()> {
    if !args.keywords.is_empty() {
        return Err(ev.type_error(format!("{name}() takes no keyword arguments")));
    }
    if args.positional.is_empty() {
        return Err(ev.type_error(format!("{name} expected 1 argument, got 0")));
    }
    Ok(())
}

fn new_getter(ev: &Evaluator<'_>, name: &str, args: &mut Args<'_>) -> R {
    let mut named = ev.try_with_capacity(args.keywords.len())?;
    for (name, value) in args.keywords {
        ev.charge(WORK_PER_VALUE)?;
        named.push((ev.core.symbols.to_value(*name), value.clone()));
    }
    let asked = GetterSpec {
        values: ScriptCell::new(ev.take_all(args.positional)?),
        named: ScriptCell::new(named),
    };
    let class = native_class(ev, &format!("_operator.{name}"))?;
    let data = NativeData::new(Rc::new(asked));
    let made = Value::Instance(Instance::new(class, InstancePayload::Object(data)));
    ev.core.gc_track(&made);
    Ok(made)
}

/// What a call asks for, and of what.
fn parts(ev: &Evaluator<'_>, name: &str, args: &mut Args<'_>) -> R<(Rc<GetterSpec>, Value)> {
    let [receiver, object] = &mut *args.positional else {
        if args.keywords.is_empty() {
            let given = args.positional.len().saturating_sub(1);
            return Err(ev.type_error(format!("{name} expected 1 argument, got {given}")));
        }
        return Err(ev.type_error(format!("{name}() takes no keyword arguments")));
    };
    if !args.keywords.is_empty() {
        return Err(ev.type_error(format!("{name}() takes no keyword arguments")));
    }
    let asked = with_data(ev, receiver, |asked: &Rc<GetterSpec>| Ok(asked.clone()))?;
    Ok((asked, std::mem::take(object)))
}

/// What `get` gives for each of what is asked for: one value, or a tuple of several.
fn get_each(ev: &Evaluator<'_>, asked: &GetterSpec, get: impl Fn(&Value) -> R) -> R {
    let count = asked.values.borrow().len();
    let value = |at: usize| asked.values.borrow().get(at).cloned().unwrap_or_default();
    if count == 1 {
        return get(&value(0));
    }
    let mut all = ev.try_with_capacity(count)?;
    for at in 0..count {
        ev.charge(WORK_PER_VALUE)?;
        all.push(get(&value(at))?);
    }
    Ok(Value::tuple(all))
}

/// The attribute at the end of a path with dots.
fn follow_path(ev: &Evaluator<'_>, object: &Value, path: &Value) -> R {
    let Value::Str(text) = ev.unwrap_builtin(path) else {
        return Ok(Value::None);
    };
    let mut at = object.clone();
    for name in text.as_str().split('.') {
        ev.charge(WORK_PER_VALUE)?;
        at = ev.attribute(&at, *ev.temp_symbol(name)?)?;
    }
    Ok(at)
}

fn along_one(ev: &Evaluator<'_>, object: &Value, name: &Value) -> R {
    match ev.unwrap_builtin(name) {
        Value::Str(text) => ev.attribute(object, *ev.temp_symbol(text.as_str())?),
        _ => Ok(Value::None),
    }
}

fn getter_repr(ev: &Evaluator<'_>, receiver: &Value) -> R {
    let asked = with_data(ev, receiver, |asked: &Rc<GetterSpec>| Ok(asked.clone()))?;
    let mut text = format!("{}(", class_of(ev, receiver).type_name());
    ev.with_native_depth(|| {
        let mut gap = "";
        for value in asked.values.get() {
            let shown = ev.repr(&value)?;
            ev.grow(&mut text, gap.len() + shown.len())?;
            text.push_str(gap);
            ev.push_text(&mut text, &shown)?;
            gap = ", ";
        }
        for (name, value) in asked.named.get() {
            let shown = format!("{gap}{}={}", ev.str(&name)?, ev.repr(&value)?);
            ev.push_text(&mut text, &shown)?;
        }
        Ok(Value::None)
    })?;
    text.push(')');
    ev.new_str(text)
}

/// What makes the same again, with which arguments; arguments by name are in what makes it.
fn getter_reduce(ev: &Evaluator<'_>, receiver: &Value) -> R {
    let asked = with_data(ev, receiver, |asked: &Rc<GetterSpec>| Ok(asked.clone()))?;
    let class = Value::Class(class_of(ev, receiver));
    let (mut values, named) = (asked.values.get(), asked.named.get());
    if named.is_empty() {
        return Ok(Value::pair(class, Value::tuple(values)));
    }
    let partial = ev.attribute(&ev.import("functools")?, ev.core.symbols.intern("partial"))?;
    let rest = values.split_off(1);
    let name = values.pop().unwrap_or_default();
    let maker = by_name(ev, &named, |keywords| {
        ev.call(&partial, &mut [class, name], keywords)
    })?;
    Ok(Value::pair(maker, Value::tuple(rest)))
}

/// Calls something with arguments by name.
fn by_name(
    ev: &Evaluator<'_>,
    named: &[(Value, Value)],
    call: impl FnOnce(&[(Symbol, Value)]) -> R,
) -> R {
    let (mut names, mut keywords) = (
        ev.try_with_capacity(named.len())?,
        ev.try_with_capacity(named.len())?,
    );
    for (name, value) in named {
        if let Value::Str(name) = name {
            let name = ev.temp_symbol(name.as_str())?;
            keywords.push((*name, value.clone()));
            names.push(name);
        }
        ev.charge(WORK_PER_VALUE)?;
    }
    call(&keywords)
}

fn class_of(ev: &Evaluator<'_>, value: &Value) -> Rc<Class> {
    ev.core.types.of(value).clone()
}
