//! Operators of builtin containers: joining, repeating, set algebra, `%` of strings.

use std::rc::Rc;

use compact_str::CompactString;
use elite_syntax::ast::BinaryOp;

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::chunked::BULK_CHUNK;
use crate::value::bytes::BytesRef;
use crate::value::{ByteArray, Bytes, R, Set, Str, Value, ValueVec};

impl Evaluator<'_> {
    /// The operation on builtin containers; None if they have no such operation.
    pub fn builtin_binary(&self, op: BinaryOp, a: &Value, b: &Value) -> R<Option<Value>> {
        match op {
            BinaryOp::Add => self.concatenate(a, b),
            BinaryOp::Mul => self.repeat_either(a, b),
            BinaryOp::Mod => match a {
                Value::Str(format) => self.percent_value(format.as_str(), b).map(Some),
                Value::Bytes(_) | Value::ByteArray(_) => self.percent_bytes(a, b).map(Some),
                _ => Ok(None),
            },
            BinaryOp::BitOr | BinaryOp::BitAnd | BinaryOp::BitXor | BinaryOp::Sub => {
                self.algebra(op, a, b)
            }
            _ => Ok(None),
        }
    }

    fn concatenate(&self, a: &Value, b: &Value) -> R<Option<Value>> {
        Ok(Some(match (a, b) {
            (Value::Str(a), Value::Str(b)) => {
                let bytes = a.as_str().len() + b.as_str().len();
                if bytes > BULK_CHUNK {
                    let mut text = String::new();
                    self.grow(&mut text, bytes)?;
                    self.push_text(&mut text, a.as_str())?;
                    self.push_text(&mut text, b.as_str())?;
                    let chars = a.len() + b.len();
                    return Ok(Some(Value::Str(Rc::new(Str::with_char_count(text, chars)))));
                }
                self.check_allocation(bytes)?;
                let mut text = CompactString::with_capacity(bytes);
                text.push_str(a.as_str());
                text.push_str(b.as_str());
                Value::Str(Rc::new(Str::with_char_count(text, a.len() + b.len())))
            }
            (Value::List(a), Value::List(b)) => {
                self.check_allocation((a.len() + b.len()) * size_of::<Value>())?;
                let mut items = ValueVec::from(Vec::with_capacity(a.len() + b.len()));
                self.copy_list(a, &mut items)?;
                self.copy_list(b, &mut items)?;
                items.into_list()
            }
            (Value::Tuple(a), Value::Tuple(b)) => {
                self.check_allocation((a.items().len() + b.items().len()) * size_of::<Value>())?;
                let mut items =
                    ValueVec::from(Vec::with_capacity(a.items().len() + b.items().len()));
                self.copy_values(a.items(), &mut items)?;
                self.copy_values(b.items(), &mut items)?;
                items.into_tuple()
            }
            (Value::Bytes(_) | Value::ByteArray(_), _) => {
                let (Some(x), Some(y)) = (self.bytes_like(a), self.bytes_like(b)) else {
                    return Ok(None);
                };
                let mut data = Vec::new();
                self.grow(&mut data, x.len() + y.len())?;
                self.push_bytes(&mut data, &x)?;
                self.push_bytes(&mut data, &y)?;
                match a {
                    Value::ByteArray(_) => Value::ByteArray(Rc::new(ByteArray::new(data))),
                    _ => Value::Bytes(Rc::new(Bytes::new(data))),
                }
            }
            _ => return Ok(None),
        }))
    }

    /// The bytes of a bytes or bytearray.
    #[inline]
    pub fn bytes_like(&self, value: &Value) -> Option<BytesRef> {
        match value {
            Value::Bytes(bytes) => Some(BytesRef::Bytes(bytes.clone())),
            Value::ByteArray(bytes) => Some(BytesRef::Snapshot(bytes.snapshot())),
            Value::Instance(instance) => self.bytes_like(&instance.builtin_value()?),
            _ => None,
        }
    }

    fn repeat_either(&self, a: &Value, b: &Value) -> R<Option<Value>> {
        let is_sequence = |value: &Value| {
            matches!(
                value,
                Value::Str(_)
                    | Value::List(_)
                    | Value::Tuple(_)
                    | Value::Bytes(_)
                    | Value::ByteArray(_)
            )
        };
        // The left one is what is repeated; the right one may be of a class derived from a sequence and stand for a
        // number.
        let (sequence, count) = match (is_sequence(a), is_sequence(b)) {
            (true, _) => (a, b),
            (false, true) => (b, a),
            (false, false) => return Ok(None),
        };
        match self.count_of(count)? {
            Some(1) if matches!(sequence, Value::Str(_) | Value::Tuple(_) | Value::Bytes(_)) => {
                Ok(Some(sequence.clone()))
            }
            Some(count) => self.repeat(sequence, count),
            None => Ok(None),
        }
    }

    /// How often something is to be repeated: an integer, or an object that stands for one as an index.
    fn count_of(&self, value: &Value) -> R<Option<i64>> {
        if let Value::Int(count) = value {
            return Ok(Some(*count));
        }
        match self.has_index(value) {
            true => { self.sized_index(value, ExceptionKind::OverflowError) }.map(Some),
            false => Ok(None),
        }
    }

    /// How often to repeat something of `bytes` bytes; refused if the result would be too big.
    fn repetitions(&self, count: i64, bytes: usize) -> R<usize> {
        let count = usize::try_from(count).unwrap_or(0);
        self.check_allocation(bytes.saturating_mul(count))?;
        // Nothing, however often, is nothing.
        Ok(if bytes == 0 { 0 } else { count })
    }

    fn repeat(&self, sequence: &Value, count: i64) -> R<Option<Value>> {
        Ok(Some(match sequence {
            Value::Str(text) => {
                let count = self.repetitions(count, text.as_str().len())?;
                let mut out = String::new();
                self.push_repeated(&mut out, text.as_str(), count)?;
                Value::Str(Rc::new(Str::with_char_count(out, text.len() * count)))
            }
            Value::List(list) => {
                let count = self.repetitions(count, list.len() * size_of::<Value>())?;
                let mut items = ValueVec::default();
                self.copy_list(list, &mut items)?;
                self.repeat_values(items, count)?.into_list()
            }
            Value::Tuple(tuple) => {
                let count = self.repetitions(count, std::mem::size_of_val(tuple.items()))?;
                let mut items = ValueVec::default();
                self.copy_values(tuple.items(), &mut items)?;
                self.repeat_values(items, count)?.into_tuple()
            }
            Value::Bytes(bytes) => {
                let count = self.repetitions(count, bytes.data().len())?;
                Value::Bytes(Rc::new(Bytes::new(self.repeat_bytes(bytes.data(), count)?)))
            }
            Value::ByteArray(bytes) => {
                let count = self.repetitions(count, bytes.len())?;
                let data = self.repeat_bytes(&bytes.snapshot(), count)?;
                Value::ByteArray(Rc::new(ByteArray::new(data)))
            }
            _ => return Ok(None),
        }))
    }

    fn algebra(&self, op: BinaryOp, a: &Value, b: &Value) -> R<Option<Value>> {
        if let (BinaryOp::BitOr, Value::Dict(_), Value::Dict(_)) = (op, a, b) {
            return self.dict_union(a, b);
        }
        // Views of keys and items take any iterable on the other side.
        let is_view = |value: &Value| {
            matches!(value,
            Value::DictView(view) if view.kind != crate::value::dict::ViewKind::Values)
        };
        let operand = |value: &Value, other: &Value| -> R<Option<Rc<Set>>> {
            match self.set_operand(value)? {
                None if is_view(other) => {
                    let set = Set::new();
                    self.set_extend(&set, value)?;
                    Ok(Some(Rc::new(set)))
                }
                found => Ok(found),
            }
        };
        let (Some(x), Some(y)) = (operand(a, b)?, operand(b, a)?) else {
            return Ok(None);
        };
        let result = Rc::new(match op {
            BinaryOp::BitOr => self.set_union(&x, &y)?,
            BinaryOp::BitAnd => self.set_intersection(&x, &y)?,
            BinaryOp::Sub => self.set_difference(&x, &y)?,
            _ => self.set_symmetric_difference(&x, &y)?,
        });
        Ok(Some(if matches!(a, Value::FrozenSet(_)) && !is_view(b) {
            Value::FrozenSet(result)
        } else {
            Value::Set(result)
        }))
    }

    /// The set an operand is; views of keys and items count as sets.
    fn set_operand(&self, value: &Value) -> R<Option<Rc<Set>>> {
        Ok(match value {
            Value::Set(set) | Value::FrozenSet(set) => Some(set.clone()),
            Value::DictView(view) if view.kind != crate::value::dict::ViewKind::Values => {
                let set = Set::new();
                self.set_extend(&set, value)?;
                Some(Rc::new(set))
            }
            Value::Instance(instance) => match instance.builtin_value() {
                Some(Value::Set(set) | Value::FrozenSet(set)) => Some(set),
                _ => None,
            },
            _ => None,
        })
    }

    /// `a op= b` for containers that change in place; None if `a` is not one or the operands do not fit.
    pub fn builtin_in_place(&self, op: BinaryOp, a: &Value, b: &Value) -> R<Option<Value>> {
        if b.can_hold_values() {
            self.core.gc_track(a);
        }
        match (op, a) {
            (BinaryOp::Add, Value::List(list)) => {
                self.list_extend(list, b)?;
            }
            (BinaryOp::Mul, Value::List(list)) => {
                let Some(count) = self.count_of(b)? else {
                    return Ok(None);
                };
                let count = self.repetitions(count, list.len() * size_of::<Value>())?;
                let mut items = ValueVec::default();
                self.copy_list(list, &mut items)?;
                let items = self.repeat_values(items, count)?;
                drop(ValueVec::from(list.replace_all(items.into())));
            }
            (BinaryOp::Mul, Value::ByteArray(bytes)) => {
                let Some(count) = self.count_of(b)? else {
                    return Ok(None);
                };
                let data = bytes.snapshot();
                let count = self.repetitions(count, data.len())?;
                bytes.put(self.repeat_bytes(&data, count)?);
            }
            (BinaryOp::Add, Value::ByteArray(bytes)) => {
                let Some(more) = self.bytes_like(b) else {
                    return Ok(None);
                };
                if matches!(self.unwrap_builtin(b), Value::ByteArray(other) if Rc::ptr_eq(bytes, &other))
                {
                    // CPython has it in use while it grows.
                    let text = "Existing exports of data: object cannot be re-sized";
                    return Err(self.raise(ExceptionKind::BufferError, text));
                }
                self.extend_bytes(bytes, more)?;
            }
            (BinaryOp::BitOr, Value::Dict(dict)) => self.dict_update_from(dict, b)?,
            (
                BinaryOp::BitOr | BinaryOp::BitAnd | BinaryOp::Sub | BinaryOp::BitXor,
                Value::Set(set),
            ) => {
                // What a view gives is a new set.
                let Some(other) = self
                    .set_operand(b)?
                    .filter(|_| !matches!(b, Value::DictView(_)))
                else {
                    return Ok(None);
                };
                match op {
                    BinaryOp::BitOr => self.set_merge(set, &other)?,
                    BinaryOp::BitAnd => set.replace(self.set_intersection(set, &other)?),
                    BinaryOp::Sub => self.set_subtract(set, &other)?,
                    _ => self.set_toggle(set, &other)?,
                }
            }
            _ => return Ok(None),
        }
        Ok(Some(a.clone()))
    }
}
