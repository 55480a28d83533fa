//! What refers to what: the counted references the search for cycles knows of.
//!
//! A reference it does not know of (what a generator with a native stack holds beyond its variables, data of the
//! library other than deques and the iterators of `itertools`) keeps its object alive, so a search errs towards
//! keeping. One it knows of must be reported exactly as often as it is counted.

use std::cell::Cell;
use std::rc::Rc;

use crate::value::{Iter, Value};

/// Entries of a container that are visited at once.
pub(super) const TRAVERSE_CHUNK: usize = 1024;

/// Counted references to what a value stands for; None for what the search does not follow.
pub(super) fn references(value: &Value) -> Option<usize> {
    Some(match value {
        Value::List(rc) => Rc::strong_count(rc),
        Value::Tuple(rc) => Rc::strong_count(rc),
        Value::Dict(rc) => Rc::strong_count(rc),
        Value::DictView(rc) => Rc::strong_count(rc),
        Value::Set(rc) | Value::FrozenSet(rc) => Rc::strong_count(rc),
        Value::Instance(rc) => Rc::strong_count(rc),
        Value::Cell(rc) => Rc::strong_count(rc),
        Value::Function(rc) => Rc::strong_count(rc),
        Value::BoundMethod(rc) => Rc::strong_count(rc),
        Value::Iter(rc) => Rc::strong_count(rc),
        Value::Generator(rc) => Rc::strong_count(rc),
        Value::Property(rc) => Rc::strong_count(rc),
        Value::StaticMethod(rc) | Value::ClassMethod(rc) => Rc::strong_count(rc),
        Value::Super(rc) => Rc::strong_count(rc),
        Value::Code(rc) => Rc::strong_count(rc),
        Value::Slice(rc) => Rc::strong_count(rc),
        // Builtin types stay as long as the interpreter.
        Value::Class(rc) if rc.is_script => Rc::strong_count(rc),
        Value::Builtin(rc) if !rc.captured().is_empty() => Rc::strong_count(rc),
        Value::Class(_) | Value::Module(_) | Value::Builtin(_) => return None,
        Value::Unbound
        | Value::None
        | Value::Ellipsis
        | Value::NotImplemented
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Float(_)
        | Value::BigInt(_)
        | Value::Complex(_)
        | Value::Str(_)
        | Value::Bytes(_)
        | Value::ByteArray(_)
        | Value::Range(_)
        | Value::LongRange(_) => return None,
    })
}

/// Where a value keeps whether a search has found it in use; None for kinds that do not.
pub(super) fn age_of(value: &Value) -> Option<&Cell<bool>> {
    Some(match value {
        Value::List(rc) => &rc.gc_old,
        Value::Tuple(rc) => &rc.old,
        Value::Dict(rc) => &rc.old,
        Value::Set(rc) | Value::FrozenSet(rc) => &rc.old,
        Value::Instance(rc) => &rc.old,
        Value::Cell(rc) => &rc.old,
        Value::Function(rc) => &rc.old,
        Value::Class(rc) => &rc.old,
        Value::Generator(rc) => &rc.old,
        _ => return None,
    })
}

/// Whether a value is a short tuple of values that hold no others: the commonest of all, and never part of a cycle.
pub(super) fn is_leaf(value: &Value) -> bool {
    match value {
        Value::Tuple(tuple) => {
            tuple.items().len() <= 16 && !tuple.items().iter().any(Value::can_hold_values)
        }
        _ => false,
    }
}

/// Whether taking a value apart may run script code.
pub(super) fn has_finalizer(value: &Value) -> bool {
    matches!(value, Value::Generator(generator) if generator.has_stack())
}

/// Runs `each` on what a value refers to directly, from entry `from` of a container on; where to go on if it has more
/// entries than a part. What is in use right now is left out, so its parts are kept.
pub(super) fn visit(value: &Value, from: usize, each: &mut dyn FnMut(&Value)) -> Option<usize> {
    let more = match value {
        Value::List(list) => list.visit(from, TRAVERSE_CHUNK, each),
        Value::Tuple(tuple) => {
            let items = tuple.items();
            items.iter().skip(from).take(TRAVERSE_CHUNK).for_each(each);
            items.len() > from + TRAVERSE_CHUNK
        }
        Value::Dict(dict) => dict.visit(from, TRAVERSE_CHUNK, each),
        Value::Set(set) | Value::FrozenSet(set) => set.visit(from, TRAVERSE_CHUNK, each),
        _ => {
            visit_small(value, each);
            false
        }
    };
    more.then_some(from + TRAVERSE_CHUNK)
}

fn visit_small(value: &Value, each: &mut dyn FnMut(&Value)) {
    match value {
        Value::DictView(view) => each(&Value::Dict(view.dict.clone())),
        Value::Instance(instance) => {
            each(&Value::Class(instance.class.clone()));
            instance.visit(each);
        }
        Value::Cell(cell) => {
            if let Some(held) = cell.value.try_borrow() {
                each(&held);
            }
        }
        Value::Function(function) => {
            for cell in &function.closure {
                each(&Value::Cell(cell.clone()));
            }
            function.keyword_defaults.iter().for_each(&mut *each);
            for held in [&function.keyword_defaults_dict, &function.annotations] {
                if let Some(held) = held.try_borrow() {
                    held.iter().for_each(&mut *each);
                }
            }
            if function.code.refs.is_traced() {
                each(&Value::Code(function.code.clone()));
            }
            if let Some(attrs) = function.attrs.try_borrow()
                && let Some(attrs) = &*attrs
            {
                attrs.iter().for_each(|(_, value)| each(value));
            }
            // Defaults that a call has borrowed are counted once, however many share them.
            if let Some(defaults) = function.defaults.try_borrow()
                && Rc::strong_count(&defaults) == 1
            {
                defaults.iter().for_each(each);
            }
        }
        Value::BoundMethod(method) => {
            each(&method.receiver);
            each(&method.function);
        }
        Value::Iter(iter) => visit_iterator(iter, each),
        Value::Generator(generator) => generator.visit(each),
        Value::Property(property) => {
            for part in [&property.get, &property.set, &property.delete] {
                each(part);
            }
            if let Some(doc) = property.doc.try_borrow() {
                each(&doc);
            }
        }
        Value::StaticMethod(wrapped) | Value::ClassMethod(wrapped) => {
            each(wrapped);
            if let Some(attrs) = wrapped.attrs.try_borrow()
                && let Some(attrs) = &*attrs
            {
                each(attrs);
            }
        }
        Value::Super(parent) => {
            each(&parent.receiver);
            each(&Value::Class(parent.class.clone()));
            each(&Value::Class(parent.receiver_class.clone()));
        }
        Value::Slice(slice) => {
            for part in [&slice.start, &slice.stop, &slice.step] {
                each(part);
            }
        }
        Value::Code(code) => code.refs.visit(each),
        Value::Class(class) => class.visit(each),
        Value::Builtin(builtin) => builtin.captured().iter().for_each(each),
        _ => {}
    }
}

fn visit_iterator(iter: &Iter, each: &mut dyn FnMut(&Value)) {
    match iter {
        Iter::List { list, .. } => {
            if let Some(list) = list.try_borrow()
                && let Some(list) = &*list
            {
                each(&Value::List(list.clone()));
            }
        }
        Iter::ListReversed { list, .. } => each(&Value::List(list.clone())),
        Iter::Tuple { tuple, .. } => each(&Value::Tuple(tuple.clone())),
        Iter::Dict { dict, .. } => each(&Value::Dict(dict.clone())),
        Iter::Set { set, .. } => each(&Value::Set(set.clone())),
        Iter::Sequence { object, .. } => each(object),
        Iter::Callable {
            function, sentinel, ..
        } => {
            each(function);
            each(sentinel);
        }
        Iter::Map { function, sources } => {
            each(function);
            sources.iter().for_each(each);
        }
        Iter::Filter { function, source } => {
            each(function);
            each(source);
        }
        Iter::Zip { sources, .. } => sources.iter().for_each(each),
        Iter::Enumerate { source, .. } => each(source),
        Iter::Native(native) => native.steps.visit(each),
        Iter::Str { .. } | Iter::Bytes { .. } | Iter::Range { .. } => {}
    }
}

/// Empties what can be emptied; a cycle always goes through one such object.
pub(super) fn clear_references(value: &Value) {
    match value {
        Value::List(list) => {
            drop(list.replace_all(Vec::new()));
        }
        Value::Dict(dict) => dict.clear(),
        Value::Set(set) => set.clear(),
        Value::Instance(instance) => instance.dismantle(),
        Value::Cell(cell) => drop(cell.take()),
        Value::Function(function) => {
            let attrs = function.attrs.take();
            let defaults = function.defaults.replace(Rc::from([]));
            drop((attrs, defaults));
        }
        Value::Class(class) => class.dismantle(),
        Value::Generator(generator) => generator.end(),
        _ => {}
    }
}
