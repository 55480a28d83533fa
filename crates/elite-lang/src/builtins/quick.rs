//! What builtin functions and methods answer at once: no script code runs, nothing is raised, nothing takes long. Their
//! arguments are only looked at, where they lie; whatever needs more goes the usual way (`call`), as if nobody had
//! asked here.

use std::rc::Rc;

use super::{Builtin, short};
use crate::eval::Evaluator;
use crate::eval::expr::attribute::CachedLookup;
use crate::eval::words::PairOf;
use crate::ops::hash::quick_hash;
use crate::ops::unicode;
use crate::stdlib::collections::deque;
use crate::stdlib::heap;
use crate::value::dict::KeySearch;
use crate::value::int::from_f64;
use crate::value::{BoundMethod, List, Value};

/// The answer of a builtin to these arguments by position (the receiver is the first one), if it has one at once.
#[derive(Clone, Copy)]
pub struct FastPath(fn(&Evaluator<'_>, &[&Value]) -> PairOf<Option<Value>>);

impl FastPath {
    /// Asks for it.
    #[inline(always)]
    pub fn ask(self, ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
        (self.0)(ev, args).whole()
    }
}

/// Makes a `FastPath` of a function that answers with an `Option`: the answer is packed into registers.
macro_rules! quick {
    ($answer:expr) => {
        FastPath(|ev, args| {
            let answer: fn(&Evaluator<'_>, &[&Value]) -> Option<Value> = $answer;
            PairOf::pack(answer(ev, args))
        })
    };
}

/// Longest list whose items are moved up at once, and longest name that is looked for.
const FAST_LEN_MAX: usize = 64;

/// The quick answers of a builtin: a method of a type, a function of a module, or a global one.
pub fn find(owner: Option<&str>, module: Option<&str>, name: &str) -> Option<FastPath> {
    Some(match (owner, module, name) {
        (None, None, "abs") => quick!(abs),
        (None, None, "bool") => quick!(truth),
        (None, None, "chr") => quick!(chr),
        (None, None, "float") => quick!(float),
        (None, None, "getattr") => quick!(attribute),
        (None, None, "int") => quick!(int),
        (None, None, "str") => quick!(short::str),
        (None, None, "isinstance") => quick!(is_instance),
        (None, None, "len") => quick!(len),
        (None, None, "max") => quick!(max),
        (None, None, "min") => quick!(min),
        (None, None, "ord") => quick!(ord),
        (Some("dict"), None, "get") => quick!(get),
        (Some("list"), None, "append") => quick!(append),
        (Some("list"), None, "pop") => quick!(pop),
        (Some("set"), None, "add") => quick!(add),
        (Some("str"), None, "endswith") => quick!(short::endswith),
        (Some("str"), None, "find") => quick!(short::find),
        (Some("str"), None, "isalnum") => {
            quick!(|_, args| short::all(args, unicode::is_alphanumeric))
        }
        (Some("str"), None, "isalpha") => quick!(|_, args| short::all(args, unicode::is_letter)),
        (Some("str"), None, "isdigit") => {
            quick!(|_, args| short::all(args, |c| c.is_ascii_digit()))
        }
        (Some("str"), None, "isspace") => quick!(short::is_space),
        (Some("str"), None, "join") => quick!(short::join),
        (Some("str"), None, "lower") => quick!(short::lower),
        (Some("str"), None, "lstrip") => quick!(short::lstrip),
        (Some("str"), None, "replace") => quick!(short::replace),
        (Some("str"), None, "rstrip") => quick!(short::rstrip),
        (Some("str"), None, "split") => quick!(short::split),
        (Some("str"), None, "startswith") => quick!(short::startswith),
        (Some("str"), None, "strip") => quick!(short::strip),
        (Some("str"), None, "upper") => quick!(short::upper),
        (Some("deque"), None, "append") => quick!(|_, args| deque::push_at_once(args, false)),
        (Some("deque"), None, "appendleft") => quick!(|_, args| deque::push_at_once(args, true)),
        (Some("deque"), None, "pop") => quick!(|_, args| deque::pop_at_once(args, false)),
        (Some("deque"), None, "popleft") => quick!(|_, args| deque::pop_at_once(args, true)),
        (None, Some("heapq"), "heappop") => quick!(heap::pop_at_once),
        (None, Some("heapq"), "heappush") => quick!(heap::push_at_once),
        (None, Some("math"), "atan2") => quick!(|_, args| two_floats(args, f64::atan2)),
        (None, Some("math"), "cos") => quick!(|_, args| one_float(args, f64::cos)),
        (None, Some("math"), "exp") => quick!(|_, args| one_float(args, f64::exp)),
        (None, Some("math"), "fabs") => quick!(|_, args| one_float(args, f64::abs)),
        (None, Some("math"), "sin") => quick!(|_, args| one_float(args, f64::sin)),
        (None, Some("math"), "sqrt") => quick!(|_, args| one_float(args, f64::sqrt)),
        (None, Some("math"), "tan") => quick!(|_, args| one_float(args, f64::tan)),
        (None, Some("math"), "floor") => quick!(|_, args| rounded(args, f64::floor)),
        (None, Some("math"), "ceil") => quick!(|_, args| rounded(args, f64::ceil)),
        _ => return None,
    })
}

impl Builtin {
    /// What a call of a value is answered with at once; None if that is no builtin, or one that takes its time.
    #[inline]
    pub fn quick_of(callee: &Value) -> Option<FastPath> {
        match callee {
            Value::Builtin(builtin) => builtin.fast_path,
            Value::Class(class) if !class.is_script && class.metaclass().is_none() => {
                match &*class.constructor.borrow() {
                    Value::Builtin(builtin) => builtin.fast_path,
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

fn abs(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Float(float)] => Some(Value::Float(float.abs())),
        [Value::Int(int)] => int.checked_abs().map(Value::Int),
        _ => None,
    }
}

fn truth(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let truth = match args {
        [Value::Bool(flag)] => *flag,
        [Value::None] => false,
        [Value::Int(int)] => *int != 0,
        [Value::Float(float)] => *float != 0.0,
        [Value::Str(text)] => !text.is_empty(),
        _ => return None,
    };
    Some(Value::Bool(truth))
}

fn chr(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Int(code)] => ev.core.ascii.get(usize::try_from(*code).ok()?).cloned(),
        _ => None,
    }
}

fn ord(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Str(text)] => match text.as_str().as_bytes() {
            [byte] => Some(Value::Int(i64::from(*byte))),
            _ => None,
        },
        _ => None,
    }
}

fn float(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Float(float)] => Some(Value::Float(*float)),
        [Value::Int(int)] => Some(Value::Float(*int as f64)),
        [Value::Str(text)] => short::float(text).map(Value::Float),
        _ => None,
    }
}

fn int(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Int(int)] => Some(Value::Int(*int)),
        [Value::Bool(flag)] => Some(Value::Int(i64::from(*flag))),
        [Value::Float(float)] if float.abs() < 9.0e18 => Some(from_f64(*float)),
        [Value::Str(text)] => short::int(text).map(Value::Int),
        _ => None,
    }
}

fn is_instance(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [value, Value::Class(class)] if class.metaclass().is_none() => {
            let own = ev.core.types.of(value);
            // Objects of scripts may say that they are of another class.
            match own.is_subclass_of(class) {
                false if own.is_script => None,
                is => Some(Value::Bool(is)),
            }
        }
        _ => None,
    }
}

fn len(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let length = match args {
        [Value::List(list)] => list.len(),
        [Value::Str(text)] => text.len(),
        [Value::Dict(dict)] => dict.len(),
        [Value::Tuple(tuple)] => tuple.items().len(),
        [Value::Set(set)] => set.len(),
        _ => return None,
    };
    Some(Value::Int(length as i64))
}

/// The greater of two numbers of one type; the first one if neither is.
fn max(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Int(a), Value::Int(b)] => Some(Value::Int(*if b > a { b } else { a })),
        [Value::Float(a), Value::Float(b)] => Some(Value::Float(*if b > a { b } else { a })),
        _ => None,
    }
}

/// The lesser of two numbers of one type; the first one if neither is.
fn min(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::Int(a), Value::Int(b)] => Some(Value::Int(*if b < a { b } else { a })),
        [Value::Float(a), Value::Float(b)] => Some(Value::Float(*if b < a { b } else { a })),
        _ => None,
    }
}

fn get(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let (dict, key, default) = match args {
        [Value::Dict(dict), key] => (dict, *key, &Value::None),
        [Value::Dict(dict), key, default] => (dict, *key, *default),
        _ => return None,
    };
    let found = dict.get_fast(quick_hash(key)?, key)?;
    Some(found.unwrap_or_else(|| default.clone()))
}

/// An attribute in a slot of an instance, or a method of its class.
fn attribute(ev: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let [receiver @ Value::Instance(instance), Value::Str(name)] = args else {
        return None;
    };
    if instance.in_dict.get() || name.is_empty() || name.as_str().len() > FAST_LEN_MAX {
        return None;
    }
    let name = ev.core.symbols.find_text(name)?;
    let class = &instance.class;
    match ev.core.lookup_cache.about(class, name)? {
        CachedLookup::Slot(slot) => instance.slot(slot as usize),
        CachedLookup::Method(location) => Some(Value::BoundMethod(Rc::new(BoundMethod {
            receiver: (*receiver).clone(),
            function: Value::Function(class.function_at(location)?),
        }))),
        CachedLookup::Plain(location) => Some(class.at(location)),
        CachedLookup::Property(_)
        | CachedLookup::Quick(_)
        | CachedLookup::Static(_)
        | CachedLookup::Other => None,
    }
}

/// The element is there already, or there is room for it and the set is noted if it has to be.
fn add(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let [Value::Set(set), item] = args else {
        return None;
    };
    let hash = quick_hash(item)?;
    match set.find(hash, item) {
        KeySearch::At(_) => Some(Value::None),
        KeySearch::Nowhere
            if (set.noted.get() || !item.can_hold_values()) && set.growth(1) == 0 =>
        {
            set.append(hash, (*item).clone());
            Some(Value::None)
        }
        KeySearch::Nowhere | KeySearch::Ask(..) => None,
    }
}

/// Whether a container has an item, if that takes no code of a script and is soon said.
#[inline]
pub fn contains(container: &Value, item: &Value) -> Option<bool> {
    let found = match container {
        Value::Dict(dict) => return dict.contains_fast(quick_hash(item)?, item),
        Value::Set(set) | Value::FrozenSet(set) => set.find(quick_hash(item)?, item),
        _ => return None,
    };
    match found {
        KeySearch::At(_) => Some(true),
        KeySearch::Nowhere => Some(false),
        KeySearch::Ask(..) => None,
    }
}

/// There is room, and the list is noted already if it has to be.
fn append(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let [Value::List(list), item] = args else {
        return None;
    };
    if item.can_hold_values() && !list.gc_tracked.get() {
        return None;
    }
    list.push_within((*item).clone()).then_some(Value::None)
}

fn pop(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    match args {
        [Value::List(list)] => list.change(Vec::pop),
        [Value::List(list), Value::Int(index)] => take(list, *index),
        _ => None,
    }
}

fn take(list: &List, index: i64) -> Option<Value> {
    list.change(|items| {
        let from_start = if index < 0 {
            index + items.len() as i64
        } else {
            index
        };
        let place = usize::try_from(from_start).ok()?;
        (place < items.len() && items.len() - place <= FAST_LEN_MAX).then(|| items.remove(place))
    })
}

/// A function of a float that has no error for this one.
#[inline(always)]
fn one_float(args: &[&Value], function: fn(f64) -> f64) -> Option<Value> {
    match args {
        [Value::Float(x)] => finite(function(*x)),
        _ => None,
    }
}

#[inline(always)]
fn two_floats(args: &[&Value], function: fn(f64, f64) -> f64) -> Option<Value> {
    match args {
        [Value::Float(x), Value::Float(y)] => finite(function(*x, *y)),
        _ => None,
    }
}

/// What is not finite may be an error.
#[inline(always)]
fn finite(result: f64) -> Option<Value> {
    result.is_finite().then_some(Value::Float(result))
}

#[inline(always)]
fn rounded(args: &[&Value], function: fn(f64) -> f64) -> Option<Value> {
    match args {
        [Value::Float(x)] if x.abs() < 9.0e18 => Some(from_f64(function(*x))),
        [Value::Int(x)] => Some(Value::Int(*x)),
        _ => None,
    }
}
