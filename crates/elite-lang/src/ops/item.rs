//! Items and slices: `value[index]`, assigning to them, deleting them.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::symbol::known;
use crate::value::{Bytes, List, LongRange, R, Raised, Range, Slice, Str, Value};

/// A slice with the length of its sequence worked in (Python's `slice.indices`).
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// First index.
    pub start: i64,
    /// End, exclusive in the direction of `step`.
    pub stop: i64,
    /// Never 0.
    pub step: i64,
}

impl Bounds {
    /// Number of indices.
    pub fn len(&self) -> usize {
        Range {
            start: self.start,
            stop: self.stop,
            step: self.step,
        }
        .len() as usize
    }

    /// The indices.
    pub fn indices(self) -> impl Iterator<Item = usize> {
        (0..self.len() as i64).map(move |i| (self.start + i * self.step) as usize)
    }
}

impl Evaluator<'_> {
    /// The bounds of a slice of a sequence of `length` items.
    pub fn bounds(&self, slice: &Slice, length: usize) -> R<Bounds> {
        let length = length as i64;
        let step = if slice.step.is_none() {
            1
        } else {
            self.slice_index(&slice.step)?
        };
        if step == 0 {
            return Err(self.value_error("slice step cannot be zero"));
        }
        let step = step.max(-i64::MAX);
        let (lowest, highest) = if step > 0 {
            (0, length)
        } else {
            (-1, length - 1)
        };
        let bound = |value: &Value, default: i64| -> R<i64> {
            if value.is_none() {
                return Ok(default);
            }
            let index = self.slice_index(value)?;
            let index = if index < 0 {
                index.saturating_add(length)
            } else {
                index
            };
            Ok(index.clamp(lowest, highest))
        };
        let (first, last) = if step > 0 {
            (lowest, highest)
        } else {
            (highest, lowest)
        };
        Ok(Bounds {
            start: bound(&slice.start, first)?,
            stop: bound(&slice.stop, last)?,
            step,
        })
    }

    /// Refuses what is no bound of a slice; a bound may be omitted.
    pub fn check_slice_index(&self, value: &Value) -> R<()> {
        if value.is_unbound() || value.is_none() {
            return Ok(());
        }
        self.slice_index(value).map(|_| ())
    }

    fn slice_index(&self, value: &Value) -> R<i64> {
        self.clamped_index(value).map_err(|raised| {
            if self.is_kind(&raised, ExceptionKind::TypeError)
                && !matches!(value, Value::Instance(_))
            {
                return self.type_error(
                    "slice indices must be integers or None or have an __index__ method",
                );
            }
            raised
        })
    }

    /// The place `index` means in a sequence of `length` items; None if out of range.
    #[inline]
    fn place(&self, index: i64, length: usize) -> Option<usize> {
        let index = if index < 0 {
            index + length as i64
        } else {
            index
        };
        usize::try_from(index).ok().filter(|index| *index < length)
    }

    /// `value[index]`
    #[inline]
    pub fn item(&self, value: &Value, index: &Value) -> R {
        if let (Value::List(list), Value::Int(at)) = (value, index) {
            let items = list.borrow();
            return match self
                .place(*at, items.len())
                .and_then(|place| items.get(place))
            {
                Some(item) => Ok(item.clone()),
                None => Err(self.index_error("list")),
            };
        }
        self.item_of(value, index)
    }

    /// `value[index]` where that runs no script code and is no error; None otherwise.
    #[inline]
    pub fn item_at_once(&self, value: &Value, index: &Value) -> Option<Value> {
        match (value, index) {
            (Value::List(list), Value::Int(at)) => {
                let items = list.borrow();
                items.get(self.place(*at, items.len())?).cloned()
            }
            (Value::Tuple(tuple), Value::Int(at)) => {
                let items = tuple.items();
                items.get(self.place(*at, items.len())?).cloned()
            }
            (Value::Dict(dict), Value::Str(_) | Value::Int(_)) => {
                match dict.find(crate::ops::hash::quick_hash(index)?, index) {
                    crate::value::dict::Found::At(at) => Some(dict.value_at(at)),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    #[cold]
    fn index_error(&self, what: &str) -> Raised {
        self.raise(
            ExceptionKind::IndexError,
            format!("{what} index out of range"),
        )
    }

    #[cold]
    fn index_type_error(&self, what: &str, index: &Value) -> Raised {
        let name = self.core.types.name_of(index);
        match what {
            "string" => self.type_error(format!("string indices must be integers, not '{name}'")),
            "byte" => self.type_error(format!(
                "byte indices must be integers or slices, not {name}"
            )),
            _ => self.type_error(format!(
                "{what} indices must be integers or slices, not {name}"
            )),
        }
    }

    fn sequence_index(&self, index: &Value, what: &str) -> R<i64> {
        match index {
            Value::Int(_) | Value::Bool(_) | Value::BigInt(_) | Value::Instance(_) => {}
            _ => return Err(self.index_type_error(what, index)),
        }
        if let Value::Instance(instance) = index
            && instance.extended().is_none()
            && instance.class.lookup(known::INDEX).is_none()
        {
            return Err(self.index_type_error(what, index));
        }
        match self.index(index) {
            Err(raised) if self.is_kind(&raised, ExceptionKind::OverflowError) => Err(self.raise(
                ExceptionKind::IndexError,
                "cannot fit 'int' into an index-sized integer",
            )),
            other => other,
        }
    }

    fn item_of(&self, value: &Value, index: &Value) -> R {
        if let Value::Dict(dict) = value {
            return match self.dict_get(dict, index)? {
                Some(value) => Ok(value),
                None => Err(self.key_error(index)),
            };
        }
        if let (Value::Slice(slice), false) =
            (index, matches!(value, Value::Instance(_) | Value::Class(_)))
        {
            return self.slice_of(value, slice);
        }
        match value {
            Value::List(list) => {
                let at = self.sequence_index(index, "list")?;
                let items = list.borrow();
                match self.place(at, items.len()) {
                    Some(place) => Ok(items[place].clone()),
                    None => Err(self.index_error("list")),
                }
            }
            Value::Tuple(tuple) => {
                let at = self.sequence_index(index, "tuple")?;
                match self.place(at, tuple.items().len()) {
                    Some(place) => Ok(tuple.items()[place].clone()),
                    None => Err(self.index_error("tuple")),
                }
            }
            Value::Str(text) => {
                let at = self.sequence_index(index, "string")?;
                match self.place(at, text.len()) {
                    Some(place) => Ok(self.char_at(text, place)),
                    None => Err(self.index_error("string")),
                }
            }
            Value::Bytes(_) | Value::ByteArray(_) => {
                let is_bytes = matches!(value, Value::Bytes(_));
                let at = self.sequence_index(index, if is_bytes { "byte" } else { "bytearray" })?;
                let byte = match value {
                    Value::Bytes(bytes) => self
                        .place(at, bytes.data().len())
                        .map(|place| bytes.data()[place]),
                    Value::ByteArray(bytes) => {
                        let data = bytes.data.borrow();
                        self.place(at, data.len()).map(|place| data[place])
                    }
                    _ => None,
                };
                let error = || {
                    if is_bytes {
                        "index out of range"
                    } else {
                        "bytearray index out of range"
                    }
                };
                byte.map(|byte| Value::Int(i64::from(byte)))
                    .ok_or_else(|| self.raise(ExceptionKind::IndexError, error()))
            }
            Value::Range(range) => {
                let at = match self.sequence_index(index, "range") {
                    Err(raised) if self.is_kind(&raised, ExceptionKind::IndexError) => {
                        return Err(self.range_index_error());
                    }
                    place => place?,
                };
                match self.place(at, range.len() as usize) {
                    Some(place) => Ok(Value::Int(range.at(place as u64))),
                    None => Err(self.range_index_error()),
                }
            }
            Value::LongRange(range) => {
                let index = match self.sequence_index(index, "range") {
                    // Further than 64 bits reach.
                    Err(raised) if self.is_kind(&raised, ExceptionKind::IndexError) => {
                        self.to_int(index)?.to_big()
                    }
                    place => place?.into(),
                };
                match range.at(&index) {
                    Some(value) => Ok(Value::bigint(value)),
                    None => Err(self.range_index_error()),
                }
            }
            Value::Instance(instance) => match instance.class.lookup(known::GETITEM) {
                Some(method) => self.call_method_value(&method, value, &mut [index.clone()]),
                None => Err(self.not_subscriptable(value)),
            },
            Value::Class(class) if class.meta_method(known::GETITEM).is_some() => self
                .special(value, known::GETITEM, &mut [index.clone()])?
                .ok_or_else(|| self.not_subscriptable(value)),
            Value::Class(class) => match class.lookup(known::CLASS_GETITEM) {
                Some(method) => {
                    let bound = self.bind_attribute(&method, value, class)?;
                    let function = match &bound {
                        Value::Function(_) => {
                            return self.call(&bound, &mut [value.clone(), index.clone()], &[]);
                        }
                        other => other,
                    };
                    self.call1(function, index.clone())
                }
                None if !class.is_script && is_generic(&class.name()) => Ok(value.clone()),
                None => {
                    let name = class.name();
                    Err(self.type_error(format!("type '{name}' is not subscriptable")))
                }
            },
            _ => Err(self.not_subscriptable(value)),
        }
    }

    #[cold]
    fn range_index_error(&self) -> Raised {
        self.raise(ExceptionKind::IndexError, "range object index out of range")
    }

    #[cold]
    fn not_subscriptable(&self, value: &Value) -> Raised {
        let name = self.core.types.name_of(value);
        self.type_error(format!("'{name}' object is not subscriptable"))
    }

    /// Character number `place`, which exists.
    fn char_at(&self, text: &Str, place: usize) -> Value {
        if text.is_ascii() {
            return self
                .core
                .char_value(char::from(text.as_str().as_bytes()[place]));
        }
        let c = text.as_str().chars().nth(place);
        c.map_or_else(|| self.core.empty_str.clone(), |c| self.core.char_value(c))
    }

    fn slice_of(&self, value: &Value, slice: &Slice) -> R {
        Ok(match value {
            Value::List(list) => {
                let bounds = self.bounds(slice, list.len())?;
                let items = list.borrow();
                Value::list(pick(&items, bounds))
            }
            Value::Tuple(tuple) => {
                let bounds = self.bounds(slice, tuple.items().len())?;
                if bounds.step == 1 && bounds.len() == tuple.items().len() {
                    return Ok(value.clone());
                }
                Value::tuple(pick(tuple.items(), bounds))
            }
            Value::Str(text) => {
                let bounds = self.bounds(slice, text.len())?;
                self.slice_text(text, bounds)
            }
            Value::Bytes(bytes) => {
                let bounds = self.bounds(slice, bytes.data().len())?;
                Value::Bytes(Rc::new(Bytes::new(pick(bytes.data(), bounds))))
            }
            Value::ByteArray(bytes) => {
                let data = bytes.data.borrow();
                let bounds = self.bounds(slice, data.len())?;
                Value::ByteArray(Rc::new(crate::value::ByteArray::new(pick(&data, bounds))))
            }
            Value::Range(range) if !matches!(slice.step, Value::BigInt(_)) => {
                let bounds = self.bounds(slice, range.len() as usize)?;
                let at = |index: i64| {
                    i128::from(range.start) + i128::from(index) * i128::from(range.step)
                };
                let step = i128::from(range.step) * i128::from(bounds.step);
                Value::range(at(bounds.start).into(), at(bounds.stop).into(), step.into())
            }
            Value::Range(_) | Value::LongRange(_) => {
                let Some(range) = LongRange::of(value) else {
                    return Err(self.not_subscriptable(value));
                };
                let bound = |value: &Value| -> R<Option<num_bigint::BigInt>> {
                    if value.is_none() {
                        return Ok(None);
                    }
                    // For what is no index, the message slices have.
                    self.slice_index(value)?;
                    Ok(Some(self.to_int(value)?.to_big()))
                };
                let step = bound(&slice.step)?.unwrap_or(1.into());
                if step == num_bigint::BigInt::ZERO {
                    return Err(self.value_error("slice step cannot be zero"));
                }
                range.slice(bound(&slice.start)?, bound(&slice.stop)?, step)
            }
            _ => return Err(self.not_subscriptable(value)),
        })
    }

    fn slice_text(&self, text: &Rc<Str>, bounds: Bounds) -> Value {
        let length = bounds.len();
        if length == 0 {
            return self.core.empty_str.clone();
        }
        if bounds.step == 1 {
            if length == text.len() {
                return Value::Str(text.clone());
            }
            let part = text.slice(bounds.start as usize, bounds.stop as usize);
            return Value::Str(Rc::new(Str::counted(part, length)));
        }
        let picked: String = if text.is_ascii() {
            bounds
                .indices()
                .map(|index| char::from(text.as_str().as_bytes()[index]))
                .collect()
        } else {
            let chars: Vec<char> = text.as_str().chars().collect();
            bounds.indices().map(|index| chars[index]).collect()
        };
        Value::Str(Rc::new(Str::counted(picked, length)))
    }

    /// `value[index] = item`
    #[inline(always)] // one call site is the hot path of loops over lists
    pub fn set_item(&self, value: &Value, index: &Value, item: Value) -> R<()> {
        if let (Value::List(list), Value::Int(at)) = (value, index) {
            if !list.noted.get() && item.holds_values() {
                self.core.note_list(list);
            }
            let mut items = list.borrow_mut();
            if let Some(place) = self.place(*at, items.len()) {
                let old = std::mem::replace(&mut items[place], item);
                drop(items);
                drop(old);
                return Ok(());
            }
            return Err(self.assignment_error("list"));
        }
        self.set_item_of(value, index, item)
    }

    #[cold]
    fn assignment_error(&self, what: &str) -> Raised {
        self.raise(
            ExceptionKind::IndexError,
            format!("{what} assignment index out of range"),
        )
    }

    fn set_item_of(&self, value: &Value, index: &Value, item: Value) -> R<()> {
        match value {
            Value::Dict(dict) => {
                if !dict.noted.get() && item.holds_values() {
                    self.core.note_dict(dict);
                }
                self.dict_set(dict, index.clone(), item)
            }
            Value::List(list) => match index {
                Value::Slice(slice) => self.set_list_slice(list, slice, &item),
                _ => {
                    let at = Value::Int(self.sequence_index(index, "list")?);
                    self.set_item(value, &at, item)
                }
            },
            Value::ByteArray(bytes) => {
                if let Value::Slice(slice) = index {
                    let new = match self.bytes_like(&item) {
                        Some(new) => new,
                        None => self.collect_bytes(&item)?,
                    };
                    let bounds = self.bounds(slice, bytes.data.borrow().len())?;
                    let done = self.replace_slice(&mut bytes.data.borrow_mut(), bounds, new);
                    bytes.account();
                    return done;
                }
                let at = self.sequence_index(index, "bytearray")?;
                let byte = self.byte(&item)?;
                let mut data = bytes.data.borrow_mut();
                match self.place(at, data.len()) {
                    Some(place) => data[place] = byte,
                    None => {
                        return Err(
                            self.raise(ExceptionKind::IndexError, "bytearray index out of range")
                        );
                    }
                }
                Ok(())
            }
            Value::Instance(instance) => match instance.class.lookup(known::SETITEM) {
                Some(method) => self
                    .call_method_value(&method, value, &mut [index.clone(), item])
                    .map(|_| ()),
                None => Err(self.no_item_assignment(value, "assignment")),
            },
            _ => Err(self.no_item_assignment(value, "assignment")),
        }
    }

    /// A value as one byte.
    pub fn byte(&self, value: &Value) -> R<u8> {
        let error = || self.value_error("byte must be in range(0, 256)");
        u8::try_from(self.index(value)?).map_err(|_| error())
    }

    /// The bytes an iterable of integers gives.
    pub fn collect_bytes(&self, iterable: &Value) -> R<Vec<u8>> {
        self.collect(iterable)?
            .iter()
            .map(|item| self.byte(item))
            .collect()
    }

    #[cold]
    fn no_item_assignment(&self, value: &Value, what: &str) -> Raised {
        let name = self.core.types.name_of(value);
        // CPython has two words for it, one for types with other item methods.
        let lacking = matches!(
            value,
            Value::None
                | Value::Bool(_)
                | Value::Int(_)
                | Value::BigInt(_)
                | Value::Float(_)
                | Value::Complex(_)
                | Value::Function(_)
                | Value::Builtin(_)
                | Value::Generator(_)
                | Value::Iter(_)
        );
        let not = if what == "deletion" && !lacking {
            "doesn't"
        } else {
            "does not"
        };
        self.type_error(format!("'{name}' object {not} support item {what}"))
    }

    fn set_list_slice(&self, list: &List, slice: &Slice, item: &Value) -> R<()> {
        let new = self.collect(item).map_err(|raised| {
            if self.is_kind(&raised, ExceptionKind::TypeError)
                && !matches!(item, Value::Instance(_))
            {
                let extended = !matches!(slice.step, Value::None | Value::Int(1));
                return self.type_error(if extended {
                    "must assign iterable to extended slice"
                } else {
                    "can only assign an iterable"
                });
            }
            raised
        })?;
        let bounds = self.bounds(slice, list.len())?;
        let mut items = list.borrow_mut();
        self.replace_slice(&mut items, bounds, new)?;
        drop(items);
        list.account();
        Ok(())
    }

    fn replace_slice<T>(&self, items: &mut Vec<T>, bounds: Bounds, new: Vec<T>) -> R<()> {
        if bounds.step == 1 {
            let start = bounds.start as usize;
            let end = (bounds.stop.max(bounds.start)) as usize;
            items.splice(start..end, new);
            return Ok(());
        }
        let length = bounds.len();
        if new.len() != length {
            let given = new.len();
            let text = format!(
                "attempt to assign sequence of size {given} to extended slice of size {length}"
            );
            return Err(self.value_error(text));
        }
        for (index, item) in bounds.indices().zip(new) {
            items[index] = item;
        }
        Ok(())
    }

    /// `del value[index]`
    pub fn delete_item(&self, value: &Value, index: &Value) -> R<()> {
        match value {
            Value::Dict(dict) => match self.dict_remove(dict, index)? {
                Some(_) => Ok(()),
                None => Err(self.key_error(index)),
            },
            Value::List(list) => {
                if let Value::Slice(slice) = index {
                    let bounds = self.bounds(slice, list.len())?;
                    let removed = remove_slice(&mut list.borrow_mut(), bounds);
                    drop(removed);
                    return Ok(());
                }
                let at = self.sequence_index(index, "list")?;
                let mut items = list.borrow_mut();
                let Some(place) = self.place(at, items.len()) else {
                    return Err(self.assignment_error("list"));
                };
                let removed = items.remove(place);
                drop(items);
                drop(removed);
                Ok(())
            }
            Value::ByteArray(bytes) => {
                let mut data = bytes.data.borrow_mut();
                if let Value::Slice(slice) = index {
                    let bounds = self.bounds(slice, data.len())?;
                    remove_slice(&mut data, bounds);
                    return Ok(());
                }
                let at = self.sequence_index(index, "bytearray")?;
                match self.place(at, data.len()) {
                    Some(place) => data.remove(place),
                    None => {
                        return Err(
                            self.raise(ExceptionKind::IndexError, "bytearray index out of range")
                        );
                    }
                };
                Ok(())
            }
            Value::Instance(instance) => match instance.class.lookup(known::DELITEM) {
                Some(method) => self
                    .call_method_value(&method, value, &mut [index.clone()])
                    .map(|_| ()),
                None => Err(self.no_item_assignment(value, "deletion")),
            },
            _ => Err(self.no_item_assignment(value, "deletion")),
        }
    }
}

/// Builtin types that can be written with type arguments (`list[int]`); the arguments mean nothing when running.
fn is_generic(name: &str) -> bool {
    matches!(
        name,
        "list" | "tuple" | "dict" | "set" | "frozenset" | "type" | "deque" | "defaultdict"
    )
}

fn pick<T: Clone>(items: &[T], bounds: Bounds) -> Vec<T> {
    if bounds.step == 1 {
        let end = bounds.stop.max(bounds.start) as usize;
        return items[bounds.start as usize..end].to_vec();
    }
    bounds.indices().map(|index| items[index].clone()).collect()
}

fn remove_slice<T>(items: &mut Vec<T>, bounds: Bounds) -> Vec<T> {
    if bounds.step == 1 {
        let end = bounds.stop.max(bounds.start) as usize;
        return items.drain(bounds.start as usize..end).collect();
    }
    let mut indices: Vec<usize> = bounds.indices().collect();
    indices.sort_unstable();
    let mut removed = Vec::with_capacity(indices.len());
    let mut kept = Vec::with_capacity(items.len() - indices.len());
    let mut next = indices.into_iter().peekable();
    for (index, item) in std::mem::take(items).into_iter().enumerate() {
        if next.next_if_eq(&index).is_some() {
            removed.push(item)
        } else {
            kept.push(item)
        }
    }
    *items = kept;
    removed
}
