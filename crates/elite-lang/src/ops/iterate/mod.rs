//! The iterator protocol.

mod lazy;

use std::cell::Cell;
use std::rc::Rc;

use crate::builtins::types::range::long_range_iterator;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::generator::{GeneratorInput, StepResult};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::ops::dict::WORK_PER_SLOT;
use crate::value::dict::{REHASH_CHUNK, ScanResult, ViewKind};
use crate::value::int::Int;
use crate::value::symbol::known;
use crate::value::{Iter, R, ScriptCell, Unwind, Value, ValueVec};

impl Evaluator<'_> {
    /// Python's `iter(value)`.
    pub fn iter(&self, value: &Value) -> R {
        let iter = match value {
            Value::List(list) => Iter::List {
                list: ScriptCell::new(Some(list.clone())),
                index: Cell::new(0),
            },
            Value::Tuple(tuple) => Iter::Tuple {
                tuple: tuple.clone(),
                index: Cell::new(0),
            },
            Value::Str(text) => Iter::Str {
                text: text.clone(),
                offset: Cell::new(0),
            },
            Value::Range(range) => Iter::Range {
                next: Cell::new(range.start),
                step: range.step,
                left: Cell::new(range.len()),
            },
            Value::LongRange(range) => long_range_iterator(self, range),
            Value::Dict(dict) => dict_iter(dict, ViewKind::Keys, false),
            Value::DictView(view) => dict_iter(&view.dict, view.kind, false),
            Value::Set(set) | Value::FrozenSet(set) => Iter::Set {
                set: set.clone(),
                position: Cell::new(0),
                length: Cell::new(set.len()),
            },
            Value::Bytes(bytes) => Iter::Bytes {
                bytes: bytes.clone(),
                index: Cell::new(0),
            },
            Value::ByteArray(_) => Iter::Sequence {
                object: value.clone(),
                index: Cell::new(0),
                reversed: false,
                done: Cell::new(false),
            },
            Value::Iter(_) | Value::Generator(_) => return Ok(value.clone()),
            Value::Instance(instance) => return self.instance_iter(value, instance),
            Value::Class(class) if class.metaclass().is_some() => {
                return match self.special(value, known::ITER, &mut [])? {
                    Some(iterator) => Ok(iterator),
                    None => Err(self.not_iterable(value)),
                };
            }
            _ => return Err(self.not_iterable(value)),
        };
        Ok(Value::Iter(Rc::new(iter)))
    }

    fn instance_iter(&self, value: &Value, instance: &crate::value::Instance) -> R {
        match instance.class.lookup(known::ITER) {
            Some(Value::None) => Err(self.not_iterable(value)),
            Some(method) => {
                let iterator = self.call_method_value(&method, value, &mut [])?;
                let steps = match &iterator {
                    Value::Iter(_) | Value::Generator(_) => true,
                    other => self.core.types.of(other).lookup(known::NEXT).is_some(),
                };
                if steps {
                    return Ok(iterator);
                }
                let name = self.core.types.name_of(&iterator);
                Err(self.type_error(format!("iter() returned non-iterator of type '{name}'")))
            }
            None => {
                if let Some(extended) = instance.builtin_value()
                    && crate::value::int::Int::of(&extended).is_none()
                    && !matches!(extended, Value::Float(_) | Value::Complex(_))
                {
                    return self.iter(&extended);
                }
                // Items alone make a class of the script a sequence, not one of the library.
                if instance.class.is_c_type.get() || instance.class.lookup(known::GETITEM).is_none()
                {
                    return Err(self.not_iterable(value));
                }
                let (object, done) = (value.clone(), Cell::new(false));
                Ok(Value::Iter(Rc::new(Iter::Sequence {
                    object,
                    index: Cell::new(0),
                    reversed: false,
                    done,
                })))
            }
        }
    }

    /// An iterator over a value; a type error on the way to one says `message` instead.
    pub fn iter_or(&self, value: &Value, message: impl FnOnce() -> String) -> R {
        self.iter(value).map_err(
            |raised| match self.is_kind(&raised, ExceptionKind::TypeError) {
                true => self.type_error(message()),
                false => raised,
            },
        )
    }

    /// Whether a value's type has what iteration asks for, `__iter__` or `__getitem__`, whatever comes of it.
    pub fn has_iteration(&self, value: &Value) -> bool {
        match value {
            Value::Instance(instance) => {
                let has = |name| instance.class.lookup(name).is_some();
                let has_items = has(known::GETITEM) && !instance.class.is_c_type.get();
                has(known::ITER) || has_items || self.is_container(&self.unwrap_builtin(value))
            }
            Value::Class(class) if class.metaclass().is_some() => {
                self.core.types.of(value).lookup(known::ITER).is_some()
            }
            other => self.is_container(other),
        }
    }

    fn is_container(&self, value: &Value) -> bool {
        !matches!(value, Value::Instance(_)) && self.iter(value).is_ok()
    }

    #[cold]
    fn not_iterable(&self, value: &Value) -> Unwind {
        let name = self.core.types.name_of(value);
        self.type_error(format!("'{name}' object is not iterable"))
    }

    /// The next value of an iterator; None at its end.
    #[inline]
    pub fn next(&self, iterator: &Value) -> R<Option<Value>> {
        match iterator {
            Value::Iter(iter) => self.next_of(iter).or_else(|raised| self.at_end(raised)),
            Value::Generator(generator) => {
                match self.step_generator(generator, GeneratorInput::Send(Value::None)) {
                    Ok(StepResult::Yielded(value)) => Ok(Some(value)),
                    Ok(StepResult::Returned(_)) => Ok(None),
                    Err(raised) => Err(self.generator_error(raised)),
                }
            }
            _ => self.next_by_method(iterator),
        }
    }

    /// The next value for an iterator that hands on what its source does, the end as well: a `StopIteration` with its
    /// value stays an exception.
    pub fn next_with_end(&self, iterator: &Value) -> R<Option<Value>> {
        match iterator {
            Value::Iter(iter) => self.next_of(iter),
            Value::Generator(generator) => {
                match self.step_generator(generator, GeneratorInput::Send(Value::None)) {
                    Ok(StepResult::Yielded(value)) => Ok(Some(value)),
                    Ok(StepResult::Returned(Value::None)) => Ok(None),
                    Ok(StepResult::Returned(value)) => self.stop_iteration(value).map(Some),
                    Err(raised) => Err(self.generator_error(raised)),
                }
            }
            _ => match self.core.types.of(iterator).lookup(known::NEXT) {
                Some(method) => {
                    let value = self.call_method_value(&method, iterator, &mut [])?;
                    Ok(Some(value))
                }
                None => self.next_by_method(iterator),
            },
        }
    }

    /// A `StopIteration` of script code within an iterator is its end.
    #[cold]
    pub(super) fn at_end<T>(&self, raised: Unwind) -> R<Option<T>> {
        match self.is_kind(&raised, ExceptionKind::StopIteration) {
            true => Ok(None),
            false => Err(raised),
        }
    }

    /// A `StopIteration` that leaves a generator is an error of the script (PEP 479).
    #[cold]
    pub fn generator_error(&self, raised: Unwind) -> Unwind {
        if !self.is_kind(&raised, ExceptionKind::StopIteration) {
            return raised;
        }
        let error = self.raise(
            ExceptionKind::RuntimeError,
            "generator raised StopIteration",
        );
        if let (Unwind::Exception(error), Unwind::Exception(cause)) = (&error, raised)
            && let Some(state) = error.exception()
        {
            state.cause.put(Value::Instance(cause.clone()));
            state.context.put(Value::Instance(cause));
        }
        error
    }

    fn next_by_method(&self, iterator: &Value) -> R<Option<Value>> {
        let Some(method) = self.core.types.of(iterator).lookup(known::NEXT) else {
            let name = self.core.types.name_of(iterator);
            return Err(self.type_error(format!("'{name}' object is not an iterator")));
        };
        match self.call_method_value(&method, iterator, &mut []) {
            Ok(value) => Ok(Some(value)),
            Err(raised) if self.is_kind(&raised, ExceptionKind::StopIteration) => Ok(None),
            Err(raised) => Err(raised),
        }
    }

    fn next_of(&self, iter: &Iter) -> R<Option<Value>> {
        Ok(match iter {
            Iter::List { list, index } => {
                let at = index.get();
                let item = list.borrow().as_ref().and_then(|list| list.get(at));
                match item {
                    Some(_) => index.set(at + 1),
                    None => drop(list.take()),
                }
                item
            }
            Iter::Tuple { tuple, index } => {
                let item = tuple.items().get(index.get()).cloned();
                index.set(index.get() + 1);
                item
            }
            Iter::Str { text, offset } => {
                let c = text.as_str()[offset.get()..].chars().next();
                c.map(|c| {
                    offset.set(offset.get() + c.len_utf8());
                    self.core.char_value(c)
                })
            }
            Iter::Bytes { bytes, index } => {
                let item = bytes
                    .data()
                    .get(index.get())
                    .map(|byte| Value::Int(i64::from(*byte)));
                index.set(index.get() + 1);
                item
            }
            Iter::Range { next, step, left } => {
                let count = left.get();
                if count == 0 {
                    return Ok(None);
                }
                left.set(count - 1);
                let value = next.get();
                next.set(value.wrapping_add(*step));
                Some(Value::Int(value))
            }
            Iter::Dict {
                dict,
                kind,
                position,
                length,
                reversed,
            } => loop {
                if dict.len() != length.get() {
                    if length.get() == usize::MAX {
                        return Ok(None);
                    }
                    length.set(usize::MAX);
                    let message = "dictionary changed size during iteration";
                    return Err(self.raise(ExceptionKind::RuntimeError, message));
                }
                let sought = match *reversed {
                    true => dict.previous_entry(position.get()),
                    false => dict.next_entry(position.get()),
                };
                match sought {
                    ScanResult::Found((at, key, value)) => {
                        position.set(at);
                        break Some(match kind {
                            ViewKind::Keys => key,
                            ViewKind::Values => value,
                            ViewKind::Items => Value::pair(key, value),
                        });
                    }
                    ScanResult::Continue(at) => position.set(at),
                    ScanResult::End => break None,
                }
                self.charge(REHASH_CHUNK * WORK_PER_SLOT)?;
            },
            Iter::Set {
                set,
                position,
                length,
            } => loop {
                if set.len() != length.get() {
                    length.set(usize::MAX);
                    return Err(self.raise(
                        ExceptionKind::RuntimeError,
                        "Set changed size during iteration",
                    ));
                }
                match set.next_element(position.get()) {
                    ScanResult::Found((at, _, key)) => {
                        position.set(at);
                        break Some(key);
                    }
                    ScanResult::Continue(at) => position.set(at),
                    ScanResult::End => break None,
                }
                self.charge(REHASH_CHUNK * WORK_PER_SLOT)?;
            },
            _ => return self.deeper(|| self.next_lazy(iter)),
        })
    }

    /// The next item of an iterator whose items are pairs, without a tuple; None for any other iterator.
    #[inline]
    pub fn next_pair(&self, iter: &Iter) -> R<Option<Option<(Value, Value)>>> {
        match iter {
            Iter::Enumerate { source, count } if let Some(item) = next_at_once(source) => {
                let Some(item) = item else {
                    return Ok(Some(None));
                };
                let number = match &*count.borrow() {
                    Value::Int(number) => number.checked_add(1).map(|next| (*number, next)),
                    _ => None,
                };
                match number {
                    Some((number, following)) => {
                        count.put(Value::Int(following));
                        Ok(Some(Some((Value::Int(number), item))))
                    }
                    None => self.number_far(count, item).map(Some),
                }
            }
            Iter::Zip {
                sources,
                strict: false,
            } if let [first, second] = &sources[..]
                && is_at_once(first)
                && is_at_once(second) =>
            {
                let Some(first) = next_at_once(first).flatten() else {
                    return Ok(Some(None));
                };
                let second = next_at_once(second).flatten();
                Ok(Some(second.map(|second| (first, second))))
            }
            Iter::Dict {
                dict,
                kind: ViewKind::Items,
                position,
                length,
                reversed: false,
            } if dict.len() == length.get() => Ok(match dict.next_entry(position.get()) {
                ScanResult::Found((at, key, value)) => {
                    position.set(at);
                    Some(Some((key, value)))
                }
                ScanResult::Continue(_) => None,
                ScanResult::End => Some(None),
            }),
            Iter::Enumerate { .. } => self.pair_or_end(iter).map(Some),
            Iter::Zip {
                sources,
                strict: false,
            } if sources.len() == 2 => self.pair_or_end(iter).map(Some),
            _ => Ok(None),
        }
    }

    /// All items of an iterable.
    pub fn collect(&self, iterable: &Value) -> R<ValueVec> {
        match iterable {
            Value::List(list) => {
                let mut items = ValueVec::from(self.try_with_capacity(list.len())?);
                self.copy_list(list, &mut items)?;
                return Ok(items);
            }
            Value::Tuple(tuple) => {
                let mut items = ValueVec::from(self.try_with_capacity(tuple.items().len())?);
                self.copy_values(tuple.items(), &mut items)?;
                return Ok(items);
            }
            Value::Dict(dict) => {
                let mut keys = ValueVec::from(self.try_with_capacity(dict.len())?);
                let (mut from, mut some) = (Some(0), Vec::new());
                while let Some(place) = from {
                    from = dict.entries_from(place, REHASH_CHUNK, &mut some);
                    self.charge(some.len() * WORK_PER_VALUE)?;
                    keys.extend(some.drain(..).map(|(_, key, _)| key));
                }
                return Ok(keys);
            }
            Value::Range(range) => {
                let length = range.len();
                let mut items: ValueVec = self
                    .try_with_capacity(usize::try_from(length).unwrap_or(usize::MAX))?
                    .into();
                for index in 0..length {
                    self.charge(WORK_PER_VALUE / 2)?;
                    items.push(Value::Int(range.at(index)));
                }
                return Ok(items);
            }
            _ => {}
        }
        let iterator = self.iter(iterable)?;
        self.ask_length(iterable)?;
        self.drain(&iterator)
    }

    /// Asks an object of the script how many items it has, as CPython does before it collects them.
    pub fn ask_length(&self, iterable: &Value) -> R<()> {
        let is_of_script = match iterable {
            Value::Instance(_) => true,
            Value::Iter(iter) => matches!(&**iter, Iter::Sequence { .. }),
            _ => false,
        };
        if is_of_script {
            self.length_hint(iterable)?;
        }
        Ok(())
    }

    /// What an iterator has left, as natives of CPython make a list of it: that is asked for its length, not what it is
    /// from.
    pub fn collect_rest(&self, iterator: &Value) -> R<ValueVec> {
        self.ask_length(iterator)?;
        self.drain(iterator)
    }

    /// How many items something says that it has or may have; None if it does not say. Errors of type say nothing.
    pub fn length_hint(&self, iterable: &Value) -> R<Option<i64>> {
        let class = self.core.types.of(iterable);
        let is_type_error = |raised: &Unwind| self.is_kind(raised, ExceptionKind::TypeError);
        if class.lookup(known::LEN).is_some() {
            match self.len(iterable) {
                Err(raised) if is_type_error(&raised) => {}
                length => return length.map(|length| Some(length as i64)),
            }
        }
        let hint = match self.special(iterable, known::LENGTH_HINT, &mut []) {
            Ok(Some(Value::NotImplemented) | None) => return Ok(None),
            Ok(Some(hint)) => hint,
            Err(raised) if is_type_error(&raised) => return Ok(None),
            Err(raised) => return Err(raised),
        };
        let plain = self.unwrap_builtin(&hint);
        if Int::of(&plain).is_none() {
            let name = self.core.types.name_of(&hint);
            let text = format!("__length_hint__ must be an integer, not {name}");
            return Err(self.type_error(text));
        }
        match self.index(&plain)? {
            ..0 => Err(self.value_error("__length_hint__() should return >= 0")),
            length => Ok(Some(length)),
        }
    }

    /// All items of an iterable; a type error on the way to an iterator says `message` instead.
    pub fn collect_or(&self, iterable: &Value, message: impl FnOnce() -> String) -> R<ValueVec> {
        match iterable {
            Value::List(_) | Value::Tuple(_) | Value::Dict(_) | Value::Range(_) => {
                self.collect(iterable)
            }
            _ => {
                let iterator = self.iter_or(iterable, message)?;
                self.ask_length(iterable)?;
                self.drain(&iterator)
            }
        }
    }

    /// All remaining values of an iterator.
    pub fn drain(&self, iterator: &Value) -> R<ValueVec> {
        let mut items = ValueVec::default();
        while let Some(value) = self.next_at_safepoint(iterator)? {
            if items.len() == items.capacity() {
                self.grow(&mut *items, 1)?;
            }
            self.check_memory()?;
            items.push(value);
        }
        Ok(items)
    }
}

/// Whether stepping an iterator is no more than taking the next item of a list, a tuple or a range.
#[inline]
fn is_at_once(iterator: &Value) -> bool {
    match iterator {
        Value::Iter(iter) => matches!(
            &**iter,
            Iter::List { .. } | Iter::Tuple { .. } | Iter::Range { .. }
        ),
        _ => false,
    }
}

/// The next item of such an iterator, None at its end; None for any other iterator.
#[inline]
fn next_at_once(iterator: &Value) -> Option<Option<Value>> {
    let Value::Iter(iter) = iterator else {
        return None;
    };
    match &**iter {
        Iter::List { list, index } => {
            let at = index.get();
            let item = list.borrow().as_ref().and_then(|list| list.get(at));
            match item {
                Some(_) => index.set(at + 1),
                None => drop(list.take()),
            }
            Some(item)
        }
        Iter::Tuple { tuple, index } => {
            let item = tuple.items().get(index.get()).cloned();
            index.set(index.get() + 1);
            Some(item)
        }
        Iter::Range { next, step, left } => {
            let count = left.get();
            if count == 0 {
                return Some(None);
            }
            left.set(count - 1);
            let value = next.get();
            next.set(value.wrapping_add(*step));
            Some(Some(Value::Int(value)))
        }
        _ => None,
    }
}

/// An iterator over a dictionary.
pub fn dict_iter(dict: &Rc<crate::value::Dict>, kind: ViewKind, reversed: bool) -> Iter {
    let position = Cell::new(if reversed { usize::MAX } else { 0 });
    Iter::Dict {
        dict: dict.clone(),
        kind,
        position,
        length: Cell::new(dict.len()),
        reversed,
    }
}
