//! The double-ended queue.

use std::cell::Cell;
use std::collections::VecDeque;
use std::rc::Rc;

use elite_syntax::ast::CompareOp;

use crate::builtins::types::insertion_place;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::deferred_drop;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::stdlib::define::{MethodDef, ModuleBuilder, instance, native_class, with_data};
use crate::value::data::Contents;
use crate::value::int::Int;
use crate::value::iter::{LibraryIterator, NativeIter};
use crate::value::{Iter, R, ScriptCell, Unwind, Value, ValueVec};

/// Items that are copied between two safepoints.
const COPY_CHUNK: usize = 4096;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    let class = module.class(
        "deque",
        Some(("iterable? maxlen?", |ev, args| {
            let made = make(ev, Vec::new(), None)?;
            init(ev, &made, &args[0], &args[1])?;
            Ok(made)
        })),
        METHODS,
    );
    // CPython names the public module `collections`, although the type is made elsewhere.
    class.set(
        crate::value::symbol::known::MODULE,
        Value::str("collections"),
    );
    class.set(crate::value::symbol::known::HASH, Value::None);
    for name in ["_deque_iterator", "_deque_reverse_iterator"] {
        module.iterator_class(name, None);
    }
    module.property(&class, "maxlen", |ev, args| {
        with_data(ev, &args[0], |deque: &Rc<Deque>| Ok(deque.maxlen_value()))
    });
    Ok(())
}

/// The data of a deque.
#[derive(Default)]
struct Deque {
    items: ScriptCell<VecDeque<Value>>,
    maxlen: Cell<Option<usize>>,
    /// Counts changes of length, so that iterators notice.
    generation: Cell<u64>,
}

impl Deque {
    fn maxlen_value(&self) -> Value {
        match self.maxlen.get() {
            Some(most) => Value::Int(i64::try_from(most).unwrap_or(i64::MAX)),
            None => Value::None,
        }
    }

    /// Makes room for `more` items; a bounded deque at its bound needs room for one.
    fn grow(&self, ev: &Evaluator<'_>, more: usize) -> R<()> {
        ev.grow_held(&self.items, more)
    }

    fn changed(&self) {
        self.generation.set(self.generation.get() + 1);
    }

    /// Adds at one end; what does not fit any more leaves at the other one.
    #[inline(always)]
    fn push(&self, value: Value, left: bool) {
        let left_over = self.items.with_mut(|items| {
            if left {
                items.push_front(value);
            } else {
                items.push_back(value);
            }
            match self.maxlen.get() {
                Some(most) if items.len() > most && left => items.pop_back(),
                Some(most) if items.len() > most => items.pop_front(),
                _ => None,
            }
        });
        self.changed();
        drop(left_over);
    }

    #[inline(always)]
    fn pop(&self, left: bool) -> Option<Value> {
        let popped = self.items.with_mut(|items| match left {
            true => items.pop_front(),
            false => items.pop_back(),
        })?;
        self.changed();
        Some(popped)
    }

    /// Removes everything; the items are dropped when the deque is free again.
    fn empty(&self) {
        let old = self.items.take();
        self.changed();
        drop(old);
    }

    fn get(&self, index: usize) -> Option<Value> {
        self.items.borrow().get(index).cloned()
    }

    /// The items, some at a time.
    fn to_vec(&self, ev: &Evaluator<'_>) -> R<Vec<Value>> {
        let mut out = ev.try_with_capacity(self.len())?;
        loop {
            let some = {
                let items = self.items.borrow();
                let end = items.len().min(out.len() + COPY_CHUNK);
                let from = out.len().min(end);
                out.extend(items.range(from..end).cloned());
                end - from
            };
            if some == 0 {
                return Ok(out);
            }
            ev.charge(some * WORK_PER_VALUE)?;
        }
    }

    fn len(&self) -> usize {
        self.items.borrow().len()
    }
}

impl Drop for Deque {
    fn drop(&mut self) {
        let mut items: Vec<Value> = std::mem::take(self.items.get_mut()).into();
        deferred_drop::drop_values(&mut items);
    }
}

fn make(ev: &Evaluator<'_>, items: Vec<Value>, maxlen: Option<usize>) -> R {
    let deque = Deque::default();
    deque.items.put(items.into());
    deque.maxlen.set(maxlen);
    deque.changed();
    instance(ev, "_collections.deque", Rc::new(deque))
}

/// A deque of the class and with the bound of another one.
fn alike(ev: &Evaluator<'_>, old: &Value, items: Vec<Value>) -> R {
    let maxlen = data(ev, old)?.maxlen.get();
    let class = ev.core.types.of(old).clone();
    if !class.is_script {
        return make(ev, items, maxlen);
    }
    let items = Value::list(items);
    match maxlen {
        // A class of a script may take no bound.
        None => ev.call1(&Value::Class(class), items),
        Some(_) => {
            let bound = data(ev, old)?.maxlen_value();
            ev.call(&Value::Class(class), &mut [items, bound], &[])
        }
    }
}

impl Contents for Deque {
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        if let Some(items) = self.items.try_borrow() {
            items.iter().for_each(each);
        }
    }

    fn clear(&self, _: &mut Vec<Value>) {
        self.empty();
    }

    fn take(&mut self, held: &mut Vec<Value>) {
        *held = std::mem::take(self.items.get_mut()).into();
    }
}

/// Tells the search for cycles that the deque has got a value which can hold others.
fn note(ev: &Evaluator<'_>, receiver: &Value, item: &Value) {
    if let Value::Instance(instance) = receiver
        && !instance.noted.get()
        && item.can_hold_values()
    {
        ev.core.note_instance(instance);
    }
}

/// The data behind a receiver.
fn data(ev: &Evaluator<'_>, receiver: &Value) -> R<Rc<Deque>> {
    with_data(ev, receiver, |deque: &Rc<Deque>| Ok(deque.clone()))
}

fn init(ev: &Evaluator<'_>, receiver: &Value, iterable: &Value, maxlen: &Value) -> R<()> {
    let deque = data(ev, receiver)?;
    let most = match maxlen.if_given() {
        None | Some(Value::None) => None,
        Some(value) => {
            let Some(most) = Int::of(&ev.unwrap_builtin(value)) else {
                return Err(ev.type_error("an integer is required"));
            };
            match usize::try_from(ev.index(&most.into_value())?) {
                Ok(most) => Some(most),
                Err(_) => return Err(ev.value_error("maxlen must be non-negative")),
            }
        }
    };
    deque.maxlen.set(most);
    deque.empty();
    match iterable.if_given() {
        Some(iterable) => extend(ev, &deque, iterable, false),
        None => Ok(()),
    }
}

fn extend(ev: &Evaluator<'_>, deque: &Deque, iterable: &Value, left: bool) -> R<()> {
    // What it holds is collected first, so that a deque can extend itself.
    let own = data(ev, iterable).is_ok_and(|other| std::ptr::eq(&*other, deque));
    if own {
        for item in deque.to_vec(ev)? {
            ev.charge(WORK_PER_VALUE)?;
            deque.grow(ev, 1)?;
            deque.push(item, left);
        }
    } else {
        let iterator = ev.iter(iterable)?;
        while let Some(item) = ev.next_at_safepoint(&iterator)? {
            deque.grow(ev, 1)?;
            deque.push(item, left);
        }
    }
    Ok(())
}

fn position(ev: &Evaluator<'_>, deque: &Deque, index: &Value) -> R<usize> {
    if !ev.has_index(index) {
        let name = ev.core.types.name_of(index);
        let text = format!("sequence index must be integer, not '{name}'");
        return Err(ev.type_error(text));
    }
    let index = ev.sized_index(index, ExceptionKind::IndexError)?;
    ev.place(index, deque.len())
        .ok_or_else(|| ev.raise(ExceptionKind::IndexError, "deque index out of range"))
}

fn mutated_error(ev: &Evaluator<'_>) -> Unwind {
    ev.raise(
        ExceptionKind::RuntimeError,
        "deque mutated during iteration",
    )
}

/// An iterator over a deque, from either end.
struct DequeIter {
    /// The deque as scripts know it; `Unbound` once it has been given away.
    object: ScriptCell<Value>,
    deque: Rc<Deque>,
    reversed: bool,
    next: Cell<usize>,
    generation: u64,
}

impl LibraryIterator for DequeIter {
    fn next(&self, ev: &Evaluator<'_>) -> R<Option<Value>> {
        if self.deque.generation.get() != self.generation {
            return Err(mutated_error(ev));
        }
        let items = self.deque.items.borrow();
        let at = self.next.get();
        self.next.set(at + 1);
        let at = match self.reversed {
            true => items.len().wrapping_sub(at + 1),
            false => at,
        };
        Ok(items.get(at).cloned())
    }

    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        if let Some(object) = self.object.try_borrow() {
            each(&object);
        }
    }

    fn clear(&self, held: &mut Vec<Value>) {
        held.push(self.object.replace(Value::Unbound));
    }

    fn copy_with(
        &self,
        _: &Evaluator<'_>,
        each: &dyn Fn(&Value) -> R,
    ) -> R<Option<Box<dyn LibraryIterator>>> {
        let object = each(&self.object.get())?;
        let Some(deque) = shared(&object).cloned() else {
            return Ok(None);
        };
        Ok(Some(Box::new(DequeIter {
            generation: deque.generation.get(),
            deque,
            reversed: self.reversed,
            next: self.next.clone(),
            object: ScriptCell::new(object),
        })))
    }
}

fn iterator(ev: &Evaluator<'_>, object: &Value, reversed: bool) -> R {
    let class = native_class(
        ev,
        if reversed {
            "_collections._deque_reverse_iterator"
        } else {
            "_collections._deque_iterator"
        },
    )?;
    let deque = data(ev, object)?;
    let walk = DequeIter {
        object: ScriptCell::new(object.clone()),
        reversed,
        next: Cell::new(0),
        generation: deque.generation.get(),
        deque,
    };
    Ok(Value::Iter(Rc::new(Iter::Native(NativeIter::new(
        class, walk,
    )))))
}

fn find(ev: &Evaluator<'_>, deque: &Deque, wanted: &Value) -> R<Option<usize>> {
    let generation = deque.generation.get();
    let mut index = 0;
    while let Some(item) = deque.get(index) {
        ev.charge(WORK_PER_VALUE)?;
        if ev.equal(&item, wanted)? {
            return Ok(Some(index));
        }
        if deque.generation.get() != generation {
            return Err(mutated_error(ev));
        }
        index += 1;
    }
    Ok(None)
}

/// Compares two deques like lists.
fn compare(ev: &Evaluator<'_>, args: &[Value], op: CompareOp) -> R {
    let own = data(ev, &args[0])?;
    let Ok(other) = data(ev, &args[1]) else {
        return Ok(Value::NotImplemented);
    };
    let (own, other) = (Value::list(own.to_vec(ev)?), Value::list(other.to_vec(ev)?));
    ev.with_native_depth(|| ev.compare(op, &own, &other))
}

const METHODS: &[MethodDef] = &[
    ("__init__", "iterable? maxlen?", |ev, args| {
        init(ev, &args[0], &args[1], &args[2]).map(|()| Value::None)
    }),
    ("append", "item /", |ev, args| {
        let deque = data(ev, &args[0])?;
        note(ev, &args[0], &args[1]);
        deque.grow(ev, 1)?;
        deque.push(std::mem::take(&mut args[1]), false);
        Ok(Value::None)
    }),
    ("appendleft", "item /", |ev, args| {
        let deque = data(ev, &args[0])?;
        note(ev, &args[0], &args[1]);
        deque.grow(ev, 1)?;
        deque.push(std::mem::take(&mut args[1]), true);
        Ok(Value::None)
    }),
    ("pop", "", |ev, args| pop(ev, &args[0], false)),
    ("popleft", "", |ev, args| pop(ev, &args[0], true)),
    ("extend", "iterable /", |ev, args| {
        note(ev, &args[0], &args[1]);
        extend(ev, &*data(ev, &args[0])?, &args[1], false).map(|()| Value::None)
    }),
    ("extendleft", "iterable /", |ev, args| {
        note(ev, &args[0], &args[1]);
        extend(ev, &*data(ev, &args[0])?, &args[1], true).map(|()| Value::None)
    }),
    ("clear", "", |ev, args| {
        let deque = data(ev, &args[0])?;
        deque.empty();
        Ok(Value::None)
    }),
    ("copy", "", |ev, args| {
        let deque = data(ev, &args[0])?;
        alike(ev, &args[0], deque.to_vec(ev)?)
    }),
    ("__copy__", "", |ev, args| {
        let deque = data(ev, &args[0])?;
        alike(ev, &args[0], deque.to_vec(ev)?)
    }),
    ("rotate", "n? /", |ev, args| {
        let steps = args[1].if_given().map_or(Ok(1), |n| ev.index(n))?;
        let deque = data(ev, &args[0])?;
        let length = deque.len() as i64;
        if length > 0 {
            let steps = steps.rem_euclid(length) as usize;
            deque.items.with_mut(|items| items.rotate_right(steps));
            deque.changed();
        }
        Ok(Value::None)
    }),
    ("reverse", "", |ev, args| {
        let deque = data(ev, &args[0])?;
        deque
            .items
            .with_mut(|items| items.make_contiguous().reverse());
        Ok(Value::None)
    }),
    ("count", "item /", |ev, args| {
        let deque = data(ev, &args[0])?;
        let generation = deque.generation.get();
        let (mut index, mut count) = (0, 0);
        while let Some(item) = deque.get(index) {
            ev.charge(WORK_PER_VALUE)?;
            count += i64::from(ev.equal(&item, &args[1])?);
            if deque.generation.get() != generation {
                return Err(mutated_error(ev));
            }
            index += 1;
        }
        Ok(Value::Int(count))
    }),
    ("index", "item start? stop? /", |ev, args| {
        let deque = data(ev, &args[0])?;
        let generation = deque.generation.get();
        let bound = |value: &Value, default: i64| match value.if_given() {
            None => Ok(default),
            Some(value) if ev.has_index(value) => ev.clamped_index(value),
            Some(_) => {
                let text = "slice indices must be integers or have an __index__ method";
                Err(ev.type_error(text))
            }
        };
        let (start, stop) = (bound(&args[2], 0)?, bound(&args[3], i64::MAX)?);
        let length = deque.len();
        let places = insertion_place(start, length)..insertion_place(stop, length);
        for index in places {
            let Some(item) = deque.get(index) else { break };
            ev.charge(WORK_PER_VALUE)?;
            if ev.equal(&item, &args[1])? {
                return Ok(Value::Int(index as i64));
            }
            if deque.generation.get() != generation {
                return Err(mutated_error(ev));
            }
        }
        let text = format!("{} is not in deque", ev.repr(&args[1])?);
        Err(ev.value_error(text))
    }),
    ("insert", "index item /", |ev, args| {
        let deque = data(ev, &args[0])?;
        if deque.maxlen.get().is_some_and(|most| deque.len() >= most) {
            return Err(ev.raise(
                ExceptionKind::IndexError,
                "deque already at its maximum size",
            ));
        }
        note(ev, &args[0], &args[2]);
        // What is beyond an end is so by the length before the index is asked, as in CPython.
        let before = deque.len() as i64;
        let index = ev.index(&args[1])?;
        let item = std::mem::take(&mut args[2]);
        deque.grow(ev, 1)?;
        deque.items.with_mut(|items| {
            let place = match index {
                index if index >= before => items.len(),
                index if index <= -before => 0,
                index => insertion_place(index, items.len()),
            };
            items.insert(place, item);
        });
        deque.changed();
        Ok(Value::None)
    }),
    ("remove", "item /", |ev, args| {
        let deque = data(ev, &args[0])?;
        let generation = deque.generation.get();
        let mut index = 0;
        while let Some(item) = deque.get(index) {
            ev.charge(WORK_PER_VALUE)?;
            let equal = ev.equal(&item, &args[1])?;
            if deque.generation.get() != generation {
                let text = "deque mutated during remove().";
                return Err(ev.raise(ExceptionKind::IndexError, text));
            }
            if equal {
                let removed = deque.items.with_mut(|items| items.remove(index));
                deque.changed();
                drop(removed);
                return Ok(Value::None);
            }
            index += 1;
        }
        let text = format!("{} is not in deque", ev.repr(&args[1])?);
        Err(ev.value_error(text))
    }),
    ("__len__", "", |ev, args| {
        Ok(Value::Int(data(ev, &args[0])?.len() as i64))
    }),
    ("__bool__", "", |ev, args| {
        Ok(Value::Bool(data(ev, &args[0])?.len() > 0))
    }),
    ("__getitem__", "index /", |ev, args| {
        let deque = data(ev, &args[0])?;
        let at = position(ev, &deque, &args[1])?;
        Ok(deque.get(at).unwrap_or_default())
    }),
    ("__setitem__", "index value /", |ev, args| {
        let deque = data(ev, &args[0])?;
        let at = position(ev, &deque, &args[1])?;
        note(ev, &args[0], &args[2]);
        let value = std::mem::take(&mut args[2]);
        let old = deque.items.with_mut(|items| match items.get_mut(at) {
            Some(place) => std::mem::replace(place, value),
            None => value,
        });
        drop(old);
        Ok(Value::None)
    }),
    ("__delitem__", "index /", |ev, args| {
        let deque = data(ev, &args[0])?;
        let at = position(ev, &deque, &args[1])?;
        let removed = deque.items.with_mut(|items| items.remove(at));
        deque.changed();
        drop(removed);
        Ok(Value::None)
    }),
    ("__contains__", "item /", |ev, args| {
        let deque = data(ev, &args[0])?;
        Ok(Value::Bool(find(ev, &deque, &args[1])?.is_some()))
    }),
    ("__iter__", "", |ev, args| iterator(ev, &args[0], false)),
    ("__reversed__", "", |ev, args| iterator(ev, &args[0], true)),
    ("__eq__", "other /", |ev, args| {
        compare(ev, args, CompareOp::Eq)
    }),
    ("__lt__", "other /", |ev, args| {
        compare(ev, args, CompareOp::Lt)
    }),
    ("__le__", "other /", |ev, args| {
        compare(ev, args, CompareOp::Le)
    }),
    ("__gt__", "other /", |ev, args| {
        compare(ev, args, CompareOp::Gt)
    }),
    ("__ge__", "other /", |ev, args| {
        compare(ev, args, CompareOp::Ge)
    }),
    ("__add__", "other /", |ev, args| {
        let own = data(ev, &args[0])?;
        let Ok(other) = data(ev, &args[1]) else {
            let name = ev.core.types.name_of(&args[1]);
            return Err(ev.type_error(format!(
                "can only concatenate deque (not \"{name}\") to deque"
            )));
        };
        let sum = alike(ev, &args[0], own.to_vec(ev)?)?;
        extend(
            ev,
            &*data(ev, &sum)?,
            &Value::list(other.to_vec(ev)?),
            false,
        )?;
        Ok(sum)
    }),
    ("__iadd__", "other /", |ev, args| {
        note(ev, &args[0], &args[1]);
        extend(ev, &*data(ev, &args[0])?, &args[1], false)?;
        Ok(std::mem::take(&mut args[0]))
    }),
    ("__mul__", "n /", |ev, args| {
        let items = repeated(ev, args)?;
        repeat_into(ev, alike(ev, &args[0], Vec::new())?, items)
    }),
    ("__rmul__", "n /", |ev, args| {
        let items = repeated(ev, args)?;
        repeat_into(ev, alike(ev, &args[0], Vec::new())?, items)
    }),
    ("__imul__", "n /", |ev, args| {
        let items = repeated(ev, args)?;
        data(ev, &args[0])?.empty();
        repeat_into(ev, std::mem::take(&mut args[0]), items)
    }),
    ("__repr__", "", |ev, args| {
        let deque = data(ev, &args[0])?;
        let name = ev.core.types.of(&args[0]).name();
        let items = Value::list(deque.to_vec(ev)?);
        let items = ev.with_native_depth(|| ev.repr(&items))?;
        Ok(Value::str(match deque.maxlen.get() {
            Some(most) => format!("{name}({items}, maxlen={most})"),
            None => format!("{name}({items})"),
        }))
    }),
];

/// The items of a deque so many times over.
fn repeated(ev: &Evaluator<'_>, args: &[Value]) -> R<ValueVec> {
    let times = ev.sized_index(&args[1], ExceptionKind::OverflowError)?;
    let times = usize::try_from(times).unwrap_or(0);
    let items = data(ev, &args[0])?.to_vec(ev)?;
    let count = items.len().saturating_mul(times);
    ev.check_allocation(count.saturating_mul(2 * size_of::<Value>()))?;
    ev.repeat_values(items.into(), times)
}

fn repeat_into(ev: &Evaluator<'_>, receiver: Value, items: ValueVec) -> R {
    let deque = data(ev, &receiver)?;
    for item in items {
        ev.charge(WORK_PER_VALUE)?;
        deque.grow(ev, 1)?;
        deque.push(item, false);
    }
    Ok(receiver)
}

fn pop(ev: &Evaluator<'_>, receiver: &Value, left: bool) -> R {
    match data(ev, receiver)?.pop(left) {
        Some(item) => Ok(item),
        None => Err(ev.raise(ExceptionKind::IndexError, "pop from an empty deque")),
    }
}

/// The data of a deque, if this is one.
fn at_once(receiver: &Value) -> Option<&Deque> {
    shared(receiver).map(|deque| &**deque)
}

#[inline]
fn shared(receiver: &Value) -> Option<&Rc<Deque>> {
    match receiver {
        Value::Instance(instance) => instance.object::<Rc<Deque>>(),
        _ => None,
    }
}

/// `append` or `appendleft` where there is room, and the deque is noted already if it has to be.
pub fn push_at_once(args: &[&Value], left: bool) -> Option<Value> {
    let [receiver @ Value::Instance(instance), item] = args else {
        return None;
    };
    let deque = at_once(receiver)?;
    if item.can_hold_values() && !instance.noted.get() {
        return None;
    }
    // SAFETY: two numbers are read.
    #[allow(unsafe_code)]
    let items = unsafe { deque.items.get_unguarded() }?;
    if items.len() == items.capacity() {
        return None;
    }
    deque.push((*item).clone(), left);
    Some(Value::None)
}

/// `pop` or `popleft` of a deque that is not empty.
pub fn pop_at_once(args: &[&Value], left: bool) -> Option<Value> {
    let [receiver] = args else { return None };
    let deque = at_once(receiver)?;
    deque.pop(left)
}
