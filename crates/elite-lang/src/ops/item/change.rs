//! Assigning to items and slices, deleting them.

use super::slice::{SliceArgs, SliceBounds};
use crate::builtins::types::bytes;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::ops::hash::quick_hash;
use crate::value::symbol::known;
use crate::value::{ByteArray, List, R, Slice, Unwind, Value, ValueVec};

impl Evaluator<'_> {
    /// `value[index] = item`
    #[inline(always)] // one call site is the hot path of loops over lists
    pub fn set_item(&self, value: &Value, index: &Value, item: Value) -> R<()> {
        if let (Value::List(list), Value::Int(at)) = (value, index) {
            if !list.gc_tracked.get() && item.can_hold_values() {
                self.core.gc_track_list(list);
            }
            let old = list.change(|items| match self.place(*at, items.len()) {
                Some(place) => Ok(std::mem::replace(&mut items[place], item)),
                None => Err(item),
            });
            return match old {
                Ok(old) => {
                    old.drop_inline();
                    Ok(())
                }
                Err(_) => Err(self.assignment_error("list")),
            };
        }
        self.set_item_of(value, index, item)
    }

    #[cold]
    fn assignment_error(&self, what: &str) -> Unwind {
        self.raise(
            ExceptionKind::IndexError,
            format!("{what} assignment index out of range"),
        )
    }

    fn set_item_of(&self, value: &Value, index: &Value, item: Value) -> R<()> {
        if item.can_hold_values() || index.can_hold_values() {
            self.core.gc_track(value);
        }
        match value {
            Value::Dict(dict) => match quick_hash(index) {
                // Most often the key is there already, or there is room for it.
                Some(hash) => match dict.set_fast(hash, index, item) {
                    Ok(old) => {
                        old.drop_inline();
                        Ok(())
                    }
                    Err(item) => self.dict_set_hashed(dict, hash, index.clone(), item),
                },
                None => self.dict_set(dict, index.clone(), item),
            },
            Value::List(list) => match index {
                Value::Slice(slice) => self.set_list_slice(list, slice, &item),
                _ => {
                    let at = Value::Int(self.sequence_index(index, "list")?);
                    self.set_item(value, &at, item)
                }
            },
            Value::ByteArray(bytes) => {
                if let Value::Slice(slice) = index {
                    if !matches!(item, Value::ByteArray(_)) {
                        // CPython asks once before it makes a bytearray of the new value, and once more after.
                        self.slice_indices(slice)?;
                    }
                    if self.is_number_or_text(&item) {
                        return Err(self.type_error(
                            "can assign only bytes, buffers, or iterables of ints in range(0, 256)",
                        ));
                    }
                    let new = bytes::of_object(self, &item, "bytearray")?;
                    let indices = self.slice_indices(slice)?;
                    if new.is_empty() {
                        // With a step as well: CPython takes the bytes out.
                        return self.delete_bytes(bytes, indices);
                    }
                    self.grow_bytes(bytes, new.len())?;
                    let done =
                        bytes.change(|data| replace_slice(data, indices.resolve(data.len()), new));
                    return done
                        .map(|_| ())
                        .map_err(|refused| self.wrong_size(&refused, "bytes"));
                }
                let at = self.sequence_index(index, "bytearray")?;
                let byte = self.byte(&item)?;
                let set = bytes.change(|data| {
                    let place = self.place(at, data.len())?;
                    data[place] = byte;
                    Some(())
                });
                set.ok_or_else(|| {
                    self.raise(ExceptionKind::IndexError, "bytearray index out of range")
                })
            }
            Value::Instance(instance) => match instance.class.lookup(known::SETITEM) {
                Some(method) => self
                    .call_method_value(&method, value, &mut [index.clone(), item])
                    .map(|_| ()),
                // One of both makes a class take either, as far as CPython sees from outside.
                None if instance.class.lookup(known::DELITEM).is_some() => {
                    Err(self.raise(ExceptionKind::AttributeError, "__setitem__"))
                }
                None => Err(self.no_item_assignment(value, index, false)),
            },
            _ => Err(self.no_item_assignment(value, index, false)),
        }
    }

    fn is_number_or_text(&self, value: &Value) -> bool {
        match value {
            Value::Str(_) | Value::Float(_) | Value::Complex(_) => true,
            Value::Instance(instance) => [known::INDEX, known::FLOAT]
                .iter()
                .any(|name| instance.class.lookup(*name).is_some()),
            other => crate::value::int::Int::of(other).is_some(),
        }
    }

    /// A value as one byte.
    pub fn byte(&self, value: &Value) -> R<u8> {
        u8::try_from(self.clamped_index(value)?)
            .map_err(|_| self.value_error("byte must be in range(0, 256)"))
    }

    /// The bytes an iterable of integers gives.
    pub fn collect_bytes(&self, iterable: &Value) -> R<Vec<u8>> {
        self.collect_as(iterable, |item| self.byte(item))
    }

    /// What `byte` makes of each item, asked as soon as the item is there: asking may change what comes next.
    pub fn collect_as(&self, iterable: &Value, byte: impl Fn(&Value) -> R<u8>) -> R<Vec<u8>> {
        let iterator = self.iter(iterable)?;
        let mut data = Vec::new();
        while let Some(item) = self.next_at_safepoint(&iterator)? {
            self.grow(&mut data, 1)?;
            data.push(byte(&item)?);
        }
        Ok(data)
    }

    /// The error for a type whose items cannot be changed.
    #[cold]
    fn no_item_assignment(&self, value: &Value, index: &Value, is_deletion: bool) -> Unwind {
        let name = self.core.types.name_of(value);
        // CPython asks a sequence for an item by a number, which must fit, and has other words then. Objects of a
        // script's class count as sequences here, those of builtin classes do not.
        let plain = match value {
            Value::Instance(_) => value.clone(),
            other => self.unwrap_builtin(other),
        };
        let is_of_script = matches!(&plain, Value::Instance(instance)
            if instance.class.is_script && !instance.class.is_c_type.get());
        let is_sequence = is_of_script
            || matches!(
                plain,
                Value::Str(_)
                    | Value::Bytes(_)
                    | Value::Tuple(_)
                    | Value::Range(_)
                    | Value::LongRange(_)
                    | Value::Set(_)
                    | Value::FrozenSet(_)
                    | Value::DictView(_)
            );
        let is_by_number = is_sequence && self.has_index(index);
        if is_by_number && let Err(raised) = self.sized_index(index, ExceptionKind::IndexError) {
            return raised;
        }
        self.type_error(match (is_deletion, is_by_number) {
            (false, _) => format!("'{name}' object does not support item assignment"),
            (true, true) => format!("'{name}' object doesn't support item deletion"),
            (true, false) => format!("'{name}' object does not support item deletion"),
        })
    }

    fn set_list_slice(&self, list: &List, slice: &Slice, item: &Value) -> R<()> {
        // The order is CPython's: the indices, the length, the new items; then what is left of the old ones.
        let indices = self.slice_indices(slice)?;
        let before = indices.resolve(list.len());
        let refusal = || {
            match slice.step {
                Value::None | Value::Int(1) => "can only assign an iterable",
                _ => "must assign iterable to extended slice",
            }
            .to_owned()
        };
        let new = match item {
            Value::Instance(_) => self.collect_rest(&self.iter_or(item, refusal)?)?,
            _ => self.collect_or(item, refusal)?,
        };
        self.grow_list(list, new.len())?;
        let done = list.change(|items| {
            let bounds = match before.step {
                1 => before.clamp_to(items.len()),
                _ => indices.resolve(items.len()),
            };
            replace_slice(items, bounds, new.into())
        });
        match done {
            Ok(old) => {
                drop(ValueVec::from(old));
                Ok(())
            }
            Err(refused) => Err(self.wrong_size(&refused, "sequence")),
        }
    }

    #[cold]
    fn wrong_size<T>(&self, refused: &SizeMismatch<T>, what: &str) -> Unwind {
        let (given, length) = (refused.new.len(), refused.length);
        self.value_error(format!(
            "attempt to assign {what} of size {given} to extended slice of size {length}"
        ))
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
                    let indices = self.slice_indices(slice)?;
                    let within = |length| indices.resolve(length);
                    let old = list.change(|items| remove_slice(items, within(items.len())));
                    drop(ValueVec::from(old));
                    return Ok(());
                }
                let at = self.sequence_index(index, "list")?;
                match self.list_remove(list, at) {
                    Some(removed) => {
                        drop(removed);
                        Ok(())
                    }
                    None => Err(self.assignment_error("list")),
                }
            }
            Value::ByteArray(bytes) => {
                if let Value::Slice(slice) = index {
                    return self.delete_bytes(bytes, self.slice_indices(slice)?);
                }
                let at = self.sequence_index(index, "bytearray")?;
                match bytes::remove_byte(bytes, |length| self.place(at, length)) {
                    Some(_) => Ok(()),
                    None => {
                        Err(self.raise(ExceptionKind::IndexError, "bytearray index out of range"))
                    }
                }
            }
            Value::Instance(instance) => match instance.class.lookup(known::DELITEM) {
                Some(method) => self
                    .call_method_value(&method, value, &mut [index.clone()])
                    .map(|_| ()),
                None if instance.class.lookup(known::SETITEM).is_some() => {
                    Err(self.raise(ExceptionKind::AttributeError, "__delitem__"))
                }
                None => Err(self.no_item_assignment(value, index, true)),
            },
            _ => Err(self.no_item_assignment(value, index, true)),
        }
    }

    /// Takes the bytes of a slice out.
    fn delete_bytes(&self, bytes: &ByteArray, indices: SliceArgs) -> R<()> {
        if let Some(range) = plain(indices, bytes.len())
            && range.start == 0
        {
            self.grow_bytes(bytes, 0)?;
            bytes.cut_front(range.end);
            return Ok(());
        }
        self.grow_bytes(bytes, 0)?;
        bytes.change(|data| remove_slice(data, indices.resolve(data.len())));
        Ok(())
    }
}

/// The places of a slice without a step.
fn plain(indices: SliceArgs, length: usize) -> Option<std::ops::Range<usize>> {
    let bounds = indices.resolve(length);
    let end = bounds.stop.max(bounds.start) as usize;
    (bounds.step == 1).then_some(bounds.start as usize..end)
}

/// Items that do not fit an extended slice of so many places.
struct SizeMismatch<T> {
    new: Vec<T>,
    length: usize,
}

/// Puts items in the place of a slice; gives back those that were there.
fn replace_slice<T>(
    items: &mut Vec<T>,
    bounds: SliceBounds,
    new: Vec<T>,
) -> Result<Vec<T>, SizeMismatch<T>> {
    if bounds.step == 1 {
        let start = bounds.start as usize;
        let end = (bounds.stop.max(bounds.start)) as usize;
        return Ok(items.splice(start..end, new).collect());
    }
    let length = bounds.len();
    if new.len() != length {
        return Err(SizeMismatch { new, length });
    }
    let pairs = bounds.indices().zip(new);
    Ok(pairs
        .map(|(index, item)| std::mem::replace(&mut items[index], item))
        .collect())
}

fn remove_slice<T>(items: &mut Vec<T>, bounds: SliceBounds) -> Vec<T> {
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
