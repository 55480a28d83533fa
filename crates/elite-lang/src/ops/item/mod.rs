//! Items: `value[index]`. Slices are in `slice`, assigning and deleting in `change`.

mod change;
pub mod slice;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::words::PairOf;
use crate::value::int::Int;
use crate::value::symbol::known;
use crate::value::{R, Str, Unwind, Value};

/// The place `index` means in a sequence of `length` items; None if out of range.
#[inline]
pub fn place_of(index: i64, length: usize) -> Option<usize> {
    let index = if index < 0 {
        index + length as i64
    } else {
        index
    };
    usize::try_from(index).ok().filter(|index| *index < length)
}

impl Evaluator<'_> {
    /// The place `index` means in a sequence of `length` items; None if out of range.
    #[inline]
    pub fn place(&self, index: i64, length: usize) -> Option<usize> {
        place_of(index, length)
    }

    /// `value[index]`
    #[inline]
    pub fn item(&self, value: &Value, index: &Value) -> R {
        if let (Value::List(list), Value::Int(at)) = (value, index) {
            return match list.at(*at) {
                Some(item) => Ok(item),
                None => Err(self.index_error("list")),
            };
        }
        self.item_of(value, index)
    }

    /// `value[index]` where that runs no script code and is no error; None otherwise.
    #[inline(never)]
    pub fn item_at_once(&self, value: &Value, index: &Value) -> PairOf<Option<Value>> {
        PairOf::pack(self.item_fast(value, index))
    }

    #[inline(always)]
    fn item_fast(&self, value: &Value, index: &Value) -> Option<Value> {
        match (value, index) {
            (Value::List(list), Value::Int(at)) => list.at(*at),
            (Value::Tuple(tuple), Value::Int(at)) => {
                let items = tuple.items();
                items.get(self.place(*at, items.len())?).cloned()
            }
            (Value::Str(text), Value::Int(at)) if text.is_ascii() => {
                let place = self.place(*at, text.len())?;
                let byte = text.as_str().as_bytes()[place];
                self.core.ascii.get(usize::from(byte)).cloned()
            }
            (Value::Dict(dict), Value::Str(_) | Value::Int(_) | Value::Tuple(_)) => {
                dict.get_fast(crate::ops::hash::quick_hash(index)?, index)?
            }
            _ => None,
        }
    }

    #[cold]
    fn index_error(&self, what: &str) -> Unwind {
        self.raise(
            ExceptionKind::IndexError,
            format!("{what} index out of range"),
        )
    }

    #[cold]
    fn index_type_error(&self, what: &str, index: &Value) -> Unwind {
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
        if let Value::Instance(_) = index
            && !self.has_index(index)
        {
            return Err(self.index_type_error(what, index));
        }
        self.sized_index(index, ExceptionKind::IndexError)
    }

    /// The place that an index of a range means, however far.
    fn range_index(&self, index: &Value) -> R<Int> {
        match index {
            Value::Int(at) => Ok(Int::Small(*at)),
            Value::Bool(_) | Value::BigInt(_) => self.to_int(index),
            Value::Instance(_) if self.has_index(index) => self.to_int(index),
            _ => Err(self.index_type_error("range", index)),
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
                self.index_chars(text)?;
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
                        let data = bytes.borrow();
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
                let place = match self.range_index(index)? {
                    Int::Small(at) => self.place(at, range.len() as usize),
                    Int::Big(_) => None,
                };
                match place {
                    Some(place) => Ok(Value::Int(range.at(place as u64))),
                    None => Err(self.range_index_error()),
                }
            }
            Value::LongRange(range) => {
                let index = self.range_index(index)?.to_big();
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
    fn range_index_error(&self) -> Unwind {
        self.raise(ExceptionKind::IndexError, "range object index out of range")
    }

    #[cold]
    fn not_subscriptable(&self, value: &Value) -> Unwind {
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
        let c = text.char_at(place);
        c.map_or_else(|| self.core.empty_str.clone(), |c| self.core.char_value(c))
    }
}

/// Builtin types that can be written with type arguments (`list[int]`); the arguments mean nothing when running.
fn is_generic(name: &str) -> bool {
    matches!(
        name,
        "list" | "tuple" | "dict" | "set" | "frozenset" | "type" | "deque" | "defaultdict"
    )
}
