//! Truth and length.

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::words::Truth;
use crate::value::symbol::known;
use crate::value::{R, Value};

impl Evaluator<'_> {
    /// Python's `bool(value)`.
    #[inline(always)]
    pub fn truth(&self, value: &Value) -> R<bool> {
        match value {
            Value::Bool(flag) => Ok(*flag),
            Value::None => Ok(false),
            Value::Int(int) => Ok(*int != 0),
            other => self.truth_of(other).into(),
        }
    }

    #[inline(never)]
    fn truth_of(&self, value: &Value) -> Truth {
        Truth::from(self.truth_of_any(value))
    }

    #[inline(always)]
    fn truth_of_any(&self, value: &Value) -> R<bool> {
        Ok(match value {
            Value::Bool(flag) => *flag,
            Value::None | Value::Unbound => false,
            Value::Int(int) => *int != 0,
            Value::Float(float) => *float != 0.0,
            Value::Str(text) => !text.is_empty(),
            Value::List(list) => !list.is_empty(),
            Value::Instance(_) => return self.instance_truth(value),
            other => other_truth(other),
        })
    }

    fn instance_truth(&self, value: &Value) -> R<bool> {
        if let Some(result) = self.special(value, known::BOOL, &mut [])? {
            return match result {
                Value::Bool(flag) => Ok(flag),
                other => {
                    let name = self.core.types.name_of(&other);
                    Err(self.type_error(format!("__bool__ should return bool, returned {name}")))
                }
            };
        }
        let has_length = self.core.types.of(value).lookup(known::LEN).is_some();
        Ok(!has_length || self.len(value)? != 0)
    }

    /// Python's `len(value)`.
    pub fn len(&self, value: &Value) -> R<usize> {
        Ok(match value {
            Value::Str(text) => text.len(),
            Value::List(list) => list.len(),
            Value::Tuple(tuple) => tuple.items().len(),
            Value::Dict(dict) => dict.len(),
            Value::DictView(view) => view.dict.len(),
            Value::Set(set) | Value::FrozenSet(set) => set.len(),
            Value::Bytes(bytes) => bytes.data().len(),
            Value::ByteArray(bytes) => bytes.borrow().len(),
            Value::Range(range) => range.len() as usize,
            Value::LongRange(range) => match usize::try_from(range.len()) {
                Ok(length) if i64::try_from(length).is_ok() => length,
                _ => {
                    let text = "Python int too large to convert to C ssize_t";
                    return Err(self.raise(ExceptionKind::OverflowError, text));
                }
            },
            value if super::binary::has_methods(value) => {
                let Some(length) = self.special(value, known::LEN, &mut [])? else {
                    return Err(self.no_len(value));
                };
                if self.clamped_index(&length)? < 0 {
                    return Err(self.value_error("__len__() should return >= 0"));
                }
                self.sized_index(&length, ExceptionKind::OverflowError)? as usize
            }
            _ => return Err(self.no_len(value)),
        })
    }

    #[cold]
    fn no_len(&self, value: &Value) -> crate::value::Unwind {
        let name = self.core.types.name_of(value);
        self.type_error(format!("object of type '{name}' has no len()"))
    }
}

fn other_truth(value: &Value) -> bool {
    match value {
        Value::Complex(complex) => complex.0 != 0.0 || complex.1 != 0.0,
        Value::Tuple(tuple) => !tuple.items().is_empty(),
        Value::Dict(dict) => !dict.is_empty(),
        Value::DictView(view) => !view.dict.is_empty(),
        Value::Set(set) | Value::FrozenSet(set) => !set.is_empty(),
        Value::Bytes(bytes) => !bytes.data().is_empty(),
        Value::ByteArray(bytes) => !bytes.borrow().is_empty(),
        Value::Range(range) => !range.is_empty(),
        Value::LongRange(range) => !range.is_empty(),
        _ => true,
    }
}
