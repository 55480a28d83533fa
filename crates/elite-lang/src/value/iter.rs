//! Iterators over builtin values and the lazy builtins (`map`, `zip`, …). Stepping them is in `ops::iterate`.

use std::cell::Cell;
use std::rc::Rc;

use super::dict::ViewKind;
use super::{Bytes, Class, Dict, List, R, ScriptCell, Set, Str, Tuple, Value};
use crate::eval::Evaluator;
use crate::limits::deferred_drop;

/// An iterator. What can run script code while stepping keeps nothing borrowed meanwhile.
pub enum Iter {
    /// Over a list; emptied at its end, so that later growth does not revive it.
    List {
        list: ScriptCell<Option<Rc<List>>>,
        index: Cell<usize>,
    },
    /// Over a tuple.
    Tuple {
        tuple: Rc<Tuple>,
        index: Cell<usize>,
    },
    /// Over the characters of a string; `offset` is in bytes.
    Str { text: Rc<Str>, offset: Cell<usize> },
    /// Over bytes.
    Bytes {
        bytes: Rc<Bytes>,
        index: Cell<usize>,
    },
    /// Over a range.
    Range {
        next: Cell<i64>,
        step: i64,
        left: Cell<u64>,
    },
    /// Over a dictionary; the keys must not change meanwhile.
    Dict {
        dict: Rc<Dict>,
        kind: ViewKind,
        position: Cell<usize>,
        length: Cell<usize>,
        reversed: bool,
    },
    /// Over a set; the elements must not change meanwhile.
    Set {
        set: Rc<Set>,
        position: Cell<usize>,
        length: Cell<usize>,
    },
    /// Backwards over a list.
    ListReversed { list: Rc<List>, index: Cell<usize> },
    /// By `__getitem__` from 0 on, or backwards from the end.
    Sequence {
        object: Value,
        index: Cell<i64>,
        reversed: bool,
        done: Cell<bool>,
    },
    /// Calls until the sentinel is returned.
    Callable {
        function: Value,
        sentinel: Value,
        done: Cell<bool>,
    },
    /// `map`
    Map {
        function: Value,
        sources: Vec<Value>,
    },
    /// `filter`
    Filter { function: Value, source: Value },
    /// `zip`
    Zip { sources: Vec<Value>, strict: bool },
    /// `enumerate`
    Enumerate {
        source: Value,
        count: ScriptCell<Value>,
    },
    /// An iterator of the library, with its own name.
    Native(NativeIter),
}

/// What an iterator of the library does, and which values it holds: what it does not tell, nothing finds.
pub trait LibraryIterator {
    /// The next value; None ends it.
    fn next(&self, ev: &Evaluator<'_>) -> R<Option<Value>>;

    /// Runs `each` on the values it holds, for the search for cycles.
    fn visit(&self, each: &mut dyn FnMut(&Value));

    /// Gives the values it holds away; it is at its end then.
    fn clear(&self, held: &mut Vec<Value>);

    /// Another one that stands where this one stands, over what `each` makes of the values this one holds; None if it
    /// cannot be copied.
    fn copy_with(
        &self,
        _ev: &Evaluator<'_>,
        _each: &dyn Fn(&Value) -> R,
    ) -> R<Option<Box<dyn LibraryIterator>>> {
        Ok(None)
    }

    /// The `repr` of the iterator, if it has one of its own.
    fn repr(&self, _ev: &Evaluator<'_>) -> R<Option<String>> {
        Ok(None)
    }
}

/// An iterator of the library.
pub struct NativeIter {
    /// The type of the iterator.
    pub class: Rc<Class>,
    /// What the iterator does.
    pub steps: Box<dyn LibraryIterator>,
}

impl NativeIter {
    /// An iterator of this type.
    pub fn new(class: Rc<Class>, steps: impl LibraryIterator + 'static) -> Self {
        NativeIter {
            class,
            steps: Box::new(steps),
        }
    }
}

impl Iter {
    /// Another iterator over the same characters, bytes, numbers, dictionary or set, which stands where this one
    /// stands; None for other kinds.
    pub fn copy(&self) -> Option<Iter> {
        Some(match self {
            Iter::Str { text, offset } => Iter::Str {
                text: text.clone(),
                offset: offset.clone(),
            },
            Iter::Bytes { bytes, index } => Iter::Bytes {
                bytes: bytes.clone(),
                index: index.clone(),
            },
            Iter::Range { next, step, left } => Iter::Range {
                next: next.clone(),
                step: *step,
                left: left.clone(),
            },
            Iter::Dict {
                dict,
                kind,
                position,
                length,
                reversed,
            } => Iter::Dict {
                dict: dict.clone(),
                kind: *kind,
                position: position.clone(),
                length: length.clone(),
                reversed: *reversed,
            },
            Iter::Set {
                set,
                position,
                length,
            } => Iter::Set {
                set: set.clone(),
                position: position.clone(),
                length: length.clone(),
            },
            _ => return None,
        })
    }

    /// The name of its type.
    pub fn type_name(&self) -> Rc<str> {
        let name = match self {
            Iter::List { .. } => "list_iterator",
            Iter::Tuple { .. } => "tuple_iterator",
            Iter::Str { .. } => "str_iterator",
            Iter::Bytes { .. } => "bytes_iterator",
            Iter::Range { .. } => "range_iterator",
            Iter::Dict {
                kind: ViewKind::Keys,
                reversed: false,
                ..
            } => "dict_keyiterator",
            Iter::Dict {
                kind: ViewKind::Values,
                reversed: false,
                ..
            } => "dict_valueiterator",
            Iter::Dict {
                kind: ViewKind::Items,
                reversed: false,
                ..
            } => "dict_itemiterator",
            Iter::Dict {
                kind: ViewKind::Keys,
                ..
            } => "dict_reversekeyiterator",
            Iter::Dict {
                kind: ViewKind::Values,
                ..
            } => "dict_reversevalueiterator",
            Iter::Dict { .. } => "dict_reverseitemiterator",
            Iter::Set { .. } => "set_iterator",
            Iter::ListReversed { .. } => "list_reverseiterator",
            Iter::Sequence {
                reversed: false, ..
            } => "iterator",
            Iter::Sequence { .. } => "reversed",
            Iter::Callable { .. } => "callable_iterator",
            Iter::Map { .. } => "map",
            Iter::Filter { .. } => "filter",
            Iter::Zip { .. } => "zip",
            Iter::Enumerate { .. } => "enumerate",
            Iter::Native(native) => return native.class.type_name(),
        };
        name.into()
    }
}

impl Drop for Iter {
    fn drop(&mut self) {
        match self {
            // The kinds below consist of one container, or of nothing that holds values.
            Iter::List { .. }
            | Iter::Tuple { .. }
            | Iter::Str { .. }
            | Iter::Bytes { .. }
            | Iter::Range { .. }
            | Iter::Dict { .. }
            | Iter::Set { .. }
            | Iter::ListReversed { .. } => {}
            Iter::Sequence { object, .. } => deferred_drop::drop_value(object),
            Iter::Callable {
                function, sentinel, ..
            } => deferred_drop::drop_each([function, sentinel]),
            Iter::Map { function, sources } => {
                deferred_drop::drop_value(function);
                deferred_drop::drop_values(sources);
            }
            Iter::Filter { function, source } => deferred_drop::drop_each([function, source]),
            Iter::Zip { sources, .. } => deferred_drop::drop_values(sources),
            Iter::Enumerate { source, .. } => deferred_drop::drop_value(source),
            Iter::Native(native) => {
                let mut held = Vec::new();
                native.steps.clear(&mut held);
                deferred_drop::drop_values(&mut held);
            }
        }
    }
}
