//! `Counter`: a dictionary of how often things were counted.

use std::rc::Rc;

use elite_syntax::ast::{BinaryOp, CompareOp};

use super::{DictReceiver, call_class, is_a, is_builtin, new_instance};
use crate::builtins::{Args, Builtin, RawFn};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::stdlib::define::{MethodDef, ModuleBuilder, native_class};
use crate::value::symbol::known;
use crate::value::{Class, Dict, R, Value, ValueVec};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    let dict = &module.core().types.dict.clone();
    let class = module.derived_class("Counter", dict, METHODS)?;
    let raw: [(&'static str, RawFn); 3] = [
        ("__init__", |ev, args| {
            let (receiver, source) = arguments(ev, "__init__", args)?;
            // By the `update` of its class, which may be one of a script.
            let update = ev.attribute(&receiver, ev.core.symbols.intern("update"))?;
            let mut given: Vec<Value> = source.into_iter().collect();
            ev.call(&update, &mut given, args.keywords)?;
            Ok(Value::None)
        }),
        ("update", |ev, args| {
            change(ev, "update", BinaryOp::Add, args)
        }),
        ("subtract", |ev, args| {
            change(ev, "subtract", BinaryOp::Sub, args)
        }),
    ];
    for (name, body) in raw {
        module.raw_method(&class, "Counter", name, body);
    }
    module.class_method(&class, "fromkeys", "iterable v?", |ev, _| {
        let text = "Counter.fromkeys() is undefined.  Use Counter(iterable) instead.";
        Err(ev.raise(ExceptionKind::NotImplementedError, text))
    });
    Ok(())
}

/// The receiver and the only positional argument of `Counter.function`; None is the same as nothing.
fn arguments(ev: &Evaluator<'_>, function: &str, args: &mut Args<'_>) -> R<(Value, Option<Value>)> {
    match &*args.positional {
        [receiver] => Ok((receiver.clone(), None)),
        [receiver, source] => {
            let source = (!source.is_none()).then(|| source.clone());
            Ok((receiver.clone(), source))
        }
        [] => Err(ev.type_error(format!(
            "Counter.{function}() missing 1 required positional argument: 'self'"
        ))),
        more => Err(ev.type_error(format!(
            "Counter.{function}() takes from 1 to 2 positional arguments but {} were given",
            more.len()
        ))),
    }
}

/// `update` and `subtract`: counts of a mapping, or one for each item; then those given by name.
fn change(ev: &Evaluator<'_>, function: &'static str, op: BinaryOp, args: &mut Args<'_>) -> R {
    let (receiver, source) = arguments(ev, function, args)?;
    let own = DictReceiver::of(ev, &receiver)?;
    let direct = own.plain && is_builtin(&own.class, ev.core.symbols.intern("get"));
    let add = |key: Value, count: &Value| {
        if direct {
            return add_direct(ev, &own, op, key, count);
        }
        let get = ev.attribute(&receiver, ev.core.symbols.intern("get"))?;
        let before = ev.call(&get, &mut [key.clone(), Value::Int(0)], &[])?;
        own.set(ev, key, combine_counts(ev, op, &before, count)?)
    };
    let add_all = |counts: Rc<Dict>| {
        if op == BinaryOp::Add && own.dict.is_empty() {
            // The counts as they are, whatever they are.
            return own.update(ev, &Value::Dict(counts));
        }
        for (_, key, count) in ev.collect_entries(&counts)? {
            ev.charge(WORK_PER_VALUE)?;
            add(key, &count)?;
        }
        Ok(())
    };
    ev.core.gc_track(&receiver);
    if let Some(source) = source {
        match mapping(ev, &source)? {
            Some(counts) => add_all(counts)?,
            None => {
                let items = ev.iter(&source)?;
                while let Some(item) = ev.next_at_safepoint(&items)? {
                    add(item, &Value::Int(1))?;
                }
            }
        }
    }
    if !args.keywords.is_empty() {
        let named = Dict::new();
        for (name, count) in args.keywords {
            ev.dict_set(&named, ev.core.symbols.to_value(*name), count.clone())?;
        }
        add_all(Rc::new(named))?;
    }
    Ok(Value::None)
}

/// A count with another one added to it or taken away.
fn combine_counts(ev: &Evaluator<'_>, op: BinaryOp, before: &Value, by: &Value) -> R {
    match op {
        BinaryOp::Add => ev.binary(op, by, before),
        _ => ev.binary(op, before, by),
    }
}

fn add_direct(
    ev: &Evaluator<'_>,
    own: &DictReceiver<'_>,
    op: BinaryOp,
    key: Value,
    count: &Value,
) -> R<()> {
    let hash = ev.hash(&key)?;
    let before = match ev.dict_find_hashed(&own.dict, hash, &key)? {
        Some(at) => own.dict.value_at(at),
        None => Value::Int(0),
    };
    let after = combine_counts(ev, op, &before, count)?;
    ev.dict_set_hashed(&own.dict, hash, key, after)
}

/// The entries of an object that says it is a mapping.
fn mapping(ev: &Evaluator<'_>, source: &Value) -> R<Option<Rc<Dict>>> {
    if ev.iterates_as_builtin(source)
        && let Value::Dict(dict) = ev.unwrap_builtin(source)
    {
        return Ok(Some(dict));
    }
    if !matches!(source, Value::Instance(_)) {
        return Ok(None);
    }
    let module = ev.import("collections.abc")?;
    let class = ev.attribute(&module, ev.core.symbols.intern("Mapping"))?;
    if !ev.is_instance(source, &class)? {
        return Ok(None);
    }
    let taken = Dict::new();
    ev.dict_update_from(&taken, source)?;
    Ok(Some(Rc::new(taken)))
}

/// The class itself.
fn counter(ev: &Evaluator<'_>) -> R<Rc<Class>> {
    native_class(ev, "_collections.Counter")
}

/// How often `key` was counted.
fn count_of(ev: &Evaluator<'_>, own: &DictReceiver<'_>, hash: u64, key: &Value) -> R {
    match ev.dict_find_hashed(&own.dict, hash, key)? {
        Some(at) => Ok(own.dict.value_at(at)),
        None if is_builtin(&own.class, known::MISSING) => Ok(Value::Int(0)),
        None => ev.item(own.receiver, key),
    }
}

/// Whether `op` holds between the counts of all things either has counted; None beside what is no counter.
fn all_counts(ev: &Evaluator<'_>, args: &[Value], op: CompareOp) -> R<Option<bool>> {
    if !is_a(&args[1], &*counter(ev)?) {
        return Ok(None);
    }
    let (one, two) = (
        DictReceiver::of(ev, &args[0])?,
        DictReceiver::of(ev, &args[1])?,
    );
    for side in [&one, &two] {
        for (hash, key, _) in ev.collect_entries(&side.dict)? {
            ev.charge(2 * WORK_PER_VALUE)?;
            let (a, b) = (
                count_of(ev, &one, hash, &key)?,
                count_of(ev, &two, hash, &key)?,
            );
            if !ev.compare_truth(op, &a, &b)? {
                return Ok(Some(false));
            }
        }
    }
    Ok(Some(true))
}

fn compare_counts(ev: &Evaluator<'_>, args: &[Value], op: CompareOp) -> R {
    Ok(all_counts(ev, args, op)?.map_or(Value::NotImplemented, Value::Bool))
}

/// Whether `op` holds between all counts and some are not equal: the strict orders (`<`, `>`).
fn strictly(ev: &Evaluator<'_>, args: &[Value], op: CompareOp) -> R {
    Ok(match all_counts(ev, args, op)? {
        None => Value::NotImplemented,
        Some(false) => Value::Bool(false),
        Some(true) => Value::Bool(all_counts(ev, args, CompareOp::Eq)? == Some(false)),
    })
}

/// How two counts become one.
#[derive(Clone, Copy, PartialEq)]
enum CountMerge {
    Sum,
    Difference,
    Most,
    Least,
}

impl CountMerge {
    fn of(self, ev: &Evaluator<'_>, a: &Value, b: &Value) -> R {
        match self {
            CountMerge::Sum => ev.binary(BinaryOp::Add, a, b),
            CountMerge::Difference => ev.binary(BinaryOp::Sub, a, b),
            CountMerge::Most => Ok(if ev.less(a, b)? { b } else { a }.clone()),
            CountMerge::Least => Ok(if ev.less(a, b)? { a } else { b }.clone()),
        }
    }
}

fn is_positive(ev: &Evaluator<'_>, count: &Value) -> R<bool> {
    ev.compare_truth(CompareOp::Gt, count, &Value::Int(0))
}

/// A new counter of the positive counts.
fn merge_new(ev: &Evaluator<'_>, args: &[Value], how: CountMerge) -> R {
    let class = counter(ev)?;
    if !is_a(&args[1], &class) {
        return Ok(Value::NotImplemented);
    }
    let (one, two) = (
        DictReceiver::of(ev, &args[0])?,
        DictReceiver::of(ev, &args[1])?,
    );
    let result = Dict::new();
    for (hash, key, count) in ev.collect_entries(&one.dict)? {
        ev.charge(2 * WORK_PER_VALUE)?;
        let count = how.of(ev, &count, &count_of(ev, &two, hash, &key)?)?;
        if is_positive(ev, &count)? {
            ev.dict_set_hashed(&result, hash, key, count)?;
        }
    }
    if how != CountMerge::Least {
        for (hash, key, count) in ev.collect_entries(&two.dict)? {
            ev.charge(2 * WORK_PER_VALUE)?;
            if ev.dict_find_hashed(&one.dict, hash, &key)?.is_some() {
                continue;
            }
            let count = match how {
                CountMerge::Difference => ev.binary(BinaryOp::Sub, &Value::Int(0), &count)?,
                _ => count,
            };
            if is_positive(ev, &count)? {
                ev.dict_set_hashed(&result, hash, key, count)?;
            }
        }
    }
    Ok(gc_track_result(ev, new_instance(&class, result)))
}

fn gc_track_result(ev: &Evaluator<'_>, made: Value) -> Value {
    ev.core.gc_track(&made);
    made
}

/// Combines the counts of the argument into the receiver. What has counts is walked through as it stands: `c -= c`
/// empties it.
fn merge_in_place(ev: &Evaluator<'_>, args: &[Value], how: CountMerge) -> R {
    let own = DictReceiver::of(ev, &args[0])?;
    let set = |hash: u64, key: Value, theirs: &Value| {
        let mine = count_of(ev, &own, hash, &key)?;
        let count = how.of(ev, &mine, theirs)?;
        own.set(ev, key, count)
    };
    match ev.unwrap_builtin(&args[1]) {
        _ if how == CountMerge::Least => {
            for (hash, key, _) in ev.collect_entries(&own.dict)? {
                ev.charge(2 * WORK_PER_VALUE)?;
                let theirs = ev.item(&args[1], &key)?;
                set(hash, key, &theirs)?;
            }
        }
        Value::Dict(others) => {
            for (hash, key, count) in ev.collect_entries(&others)? {
                ev.charge(2 * WORK_PER_VALUE)?;
                // What has counts may be the receiver.
                let theirs = match ev.dict_find_hashed(&others, hash, &key)? {
                    Some(at) => others.value_at(at),
                    None => count,
                };
                set(hash, key, &theirs)?;
            }
        }
        _ => {
            let items = ev.attribute(&args[1], ev.core.symbols.intern("items"))?;
            let items = ev.call(&items, &mut [], &[])?;
            let iterator = ev.iter(&items)?;
            while let Some(item) = ev.next_at_safepoint(&iterator)? {
                let mut pair = ev.unpack_exact(&item, 2)?.into_iter();
                let (key, count) = (
                    pair.next().unwrap_or_default(),
                    pair.next().unwrap_or_default(),
                );
                set(ev.hash(&key)?, key, &count)?;
            }
        }
    }
    for (_, key, count) in ev.collect_entries(&own.dict)? {
        ev.charge(WORK_PER_VALUE)?;
        if !is_positive(ev, &count)? {
            ev.delete_item(&args[0], &key)?;
        }
    }
    Ok(args[0].clone())
}

/// Keys with their counts, the highest first; equal ones as they came.
/// All that was counted, what came most often first.
fn by_count(ev: &Evaluator<'_>, own: &DictReceiver<'_>) -> R<ValueVec> {
    let mut pairs = ValueVec::from(ev.try_with_capacity(own.dict.len())?);
    for (_, key, count) in ev.collect_entries(&own.dict)? {
        pairs.push(Value::pair(key, count));
        ev.charge(4 * WORK_PER_VALUE)?;
    }
    ev.sort(&mut pairs, Some(&second()), true)?;
    Ok(pairs)
}

/// The function that gives the count of a pair.
fn second() -> Value {
    Builtin::raw("count", |ev, args| match args.positional {
        [pair] => ev.item(pair, &Value::Int(1)),
        _ => Ok(Value::None),
    })
}

/// `most_common`: some of them as `heapq.nlargest` has them.
fn most_common(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let Some(n) = args[1].if_given().filter(|n| !n.is_none()) else {
        return Ok(by_count(ev, &DictReceiver::of(ev, &args[0])?)?.into_list());
    };
    let name = |name| ev.core.symbols.intern(name);
    let nlargest = ev.attribute(&ev.import("heapq")?, name("nlargest"))?;
    let items = ev.attribute(&args[0], name("items"))?;
    let items = ev.call(&items, &mut [], &[])?;
    let key = [(name("key"), second())];
    ev.call(&nlargest, &mut [n.clone(), items], &key)
}

const METHODS: &[MethodDef] = &[
    ("__missing__", "key /", |_, _| Ok(Value::Int(0))),
    ("most_common", "n?", most_common),
    ("elements", "", |ev, args| {
        let module = ev.import("itertools")?;
        let of = |name| ev.attribute(&module, ev.core.symbols.intern(name));
        let items = ev.attribute(&args[0], ev.core.symbols.intern("items"))?;
        let items = ev.call(&items, &mut [], &[])?;
        let rows = ev.call(&of("starmap")?, &mut [of("repeat")?, items], &[])?;
        let chained = ev.attribute(&of("chain")?, ev.core.symbols.intern("from_iterable"))?;
        ev.call1(&chained, rows)
    }),
    ("total", "", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        let mut sum = Value::Int(0);
        for (_, _, count) in ev.collect_entries(&own.dict)? {
            ev.charge(WORK_PER_VALUE)?;
            sum = ev.binary(BinaryOp::Add, &sum, &count)?;
        }
        Ok(sum)
    }),
    ("copy", "", copy),
    ("__copy__", "", copy),
    ("__delitem__", "elem", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        ev.dict_remove(&own.dict, &args[1]).map(|_| Value::None)
    }),
    ("__repr__", "", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        let name = own.name();
        if own.dict.is_empty() {
            return Ok(Value::str(format!("{name}()")));
        }
        let shown = match by_count(ev, &own) {
            Ok(pairs) => {
                let shown = Dict::new();
                ev.dict_update_from(&shown, &pairs.into_list())?;
                Value::Dict(Rc::new(shown))
            }
            // Counts without an order stand as they came.
            Err(raised) if ev.is_kind(&raised, ExceptionKind::TypeError) => {
                Value::Dict(own.dict.clone())
            }
            Err(raised) => return Err(raised),
        };
        Ok(Value::str(format!("{name}({})", ev.repr(&shown)?)))
    }),
    ("__eq__", "other", |ev, args| {
        compare_counts(ev, args, CompareOp::Eq)
    }),
    ("__ne__", "other", |ev, args| {
        let equal = all_counts(ev, args, CompareOp::Eq)?;
        Ok(equal.map_or(Value::NotImplemented, |equal| Value::Bool(!equal)))
    }),
    ("__le__", "other", |ev, args| {
        compare_counts(ev, args, CompareOp::Le)
    }),
    ("__ge__", "other", |ev, args| {
        compare_counts(ev, args, CompareOp::Ge)
    }),
    ("__lt__", "other", |ev, args| {
        strictly(ev, args, CompareOp::Le)
    }),
    ("__gt__", "other", |ev, args| {
        strictly(ev, args, CompareOp::Ge)
    }),
    ("__add__", "other", |ev, args| {
        merge_new(ev, args, CountMerge::Sum)
    }),
    ("__sub__", "other", |ev, args| {
        merge_new(ev, args, CountMerge::Difference)
    }),
    ("__or__", "other", |ev, args| {
        merge_new(ev, args, CountMerge::Most)
    }),
    ("__and__", "other", |ev, args| {
        merge_new(ev, args, CountMerge::Least)
    }),
    ("__iadd__", "other", |ev, args| {
        merge_in_place(ev, args, CountMerge::Sum)
    }),
    ("__isub__", "other", |ev, args| {
        merge_in_place(ev, args, CountMerge::Difference)
    }),
    ("__ior__", "other", |ev, args| {
        merge_in_place(ev, args, CountMerge::Most)
    }),
    ("__iand__", "other", |ev, args| {
        merge_in_place(ev, args, CountMerge::Least)
    }),
    ("__pos__", "", |ev, args| unary_counts(ev, args, false)),
    ("__neg__", "", |ev, args| unary_counts(ev, args, true)),
];

fn copy(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let class = DictReceiver::of(ev, &args[0])?.class;
    call_class(ev, &class, &mut [args[0].clone()])
}

/// The positive counts, or the negative ones turned round.
fn unary_counts(ev: &Evaluator<'_>, args: &[Value], turned: bool) -> R {
    let nothing = new_instance(&counter(ev)?, Dict::new());
    match turned {
        false => merge_new(ev, &[args[0].clone(), nothing], CountMerge::Sum),
        true => merge_new(ev, &[nothing, args[0].clone()], CountMerge::Difference),
    }
}
