//! Conversions to the integers and floats that builtins need.

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::int::Int;
use crate::value::symbol::known;
use crate::value::{R, Value};

impl Evaluator<'_> {
    /// The integer a value stands for as an index: integers, booleans and objects with `__index__`.
    pub fn to_int(&self, value: &Value) -> R<Int> {
        if let Some(int) = Int::of(value) {
            return Ok(int);
        }
        if let Value::Instance(instance) = value {
            if let Some(result) = instance.builtin_value().as_ref().and_then(Int::of) {
                return Ok(result);
            }
            if let Some(result) = self.special(value, known::INDEX, &mut [])? {
                let name = self.core.types.name_of(&result);
                let error = || self.type_error(format!("__index__ returned non-int (type {name})"));
                return Int::of(&self.unwrap_builtin(&result)).ok_or_else(error);
            }
        }
        let name = self.core.types.name_of(value);
        Err(self.type_error(format!(
            "'{name}' object cannot be interpreted as an integer"
        )))
    }

    /// Whether a value can be an index: an integer or something with `__index__`.
    pub fn has_index(&self, value: &Value) -> bool {
        match value {
            Value::Instance(instance) => {
                instance
                    .builtin_value()
                    .as_ref()
                    .and_then(Int::of)
                    .is_some()
                    || instance.class.lookup(known::INDEX).is_some()
            }
            value => Int::of(value).is_some(),
        }
    }

    /// Like `to_int`, within 64 bits.
    #[inline]
    pub fn index(&self, value: &Value) -> R<i64> {
        if let Value::Int(int) = value {
            return Ok(*int);
        }
        match self.to_int(value)? {
            Int::Small(small) => Ok(small),
            Int::Big(_) => Err(self.raise(
                ExceptionKind::OverflowError,
                "Python int too large to convert to C ssize_t",
            )),
        }
    }

    /// Like `index`, for the place or the number of items: what is too large for that is an error of `kind`.
    pub fn sized_index(&self, value: &Value, kind: ExceptionKind) -> R<i64> {
        match self.to_int(value)? {
            Int::Small(small) => Ok(small),
            Int::Big(_) => {
                let name = self.core.types.name_of(value);
                let text = format!("cannot fit '{name}' into an index-sized integer");
                Err(self.raise(kind, text))
            }
        }
    }

    /// Like `index`, within the 32 bits of an `int` of C.
    pub fn c_int(&self, value: &Value) -> R<i32> {
        let small = match self.to_int(value)? {
            Int::Small(small) => i32::try_from(small).ok(),
            Int::Big(_) => None,
        };
        small.ok_or_else(|| {
            let text = "Python int too large to convert to C int";
            self.raise(ExceptionKind::OverflowError, text)
        })
    }

    /// Like `index`, but out of range means the nearest bound, as slices want it.
    pub fn clamped_index(&self, value: &Value) -> R<i64> {
        Ok(match self.to_int(value)? {
            Int::Small(small) => small,
            big if big.is_negative() => i64::MIN,
            Int::Big(_) => i64::MAX,
        })
    }

    /// The float a real number stands for, including objects with `__float__` or `__index__`.
    pub fn to_f64(&self, value: &Value) -> R<f64> {
        match value {
            Value::Float(float) => return Ok(*float),
            Value::Int(int) => return Ok(*int as f64),
            _ => {}
        }
        if let Some(int) = Int::of(value) {
            return self.int_to_f64(&int);
        }
        if let Value::Instance(instance) = value {
            let is_own = matches!(
                instance.class.lookup(known::FLOAT),
                Some(Value::Function(_))
            );
            match instance.builtin_value() {
                Some(Value::Float(float)) => return Ok(float),
                Some(extended) if !is_own && Int::of(&extended).is_some() => {
                    return self.to_f64(&extended);
                }
                _ => {}
            }
            if let Some(result) = self.special(value, known::FLOAT, &mut [])? {
                return self.given_float(value, &result);
            }
            if instance.class.lookup(known::INDEX).is_some() {
                let int = self.to_int(value)?;
                return self.int_to_f64(&int);
            }
        }
        let name = self.core.types.name_of(value);
        Err(self.type_error(format!("must be real number, not {name}")))
    }

    /// The float a real number stands for, where it becomes a float or a complex number: a class derived from float is
    /// asked for its own `__float__` here.
    pub fn converted_f64(&self, value: &Value) -> R<f64> {
        if let Value::Instance(instance) = value
            && let Some(method @ Value::Function(_)) = instance.class.lookup(known::FLOAT)
        {
            let result = self.call_method_value(&method, value, &mut [])?;
            return self.given_float(value, &result);
        }
        self.to_f64(value)
    }

    /// What `__float__` of a value has given.
    fn given_float(&self, value: &Value, result: &Value) -> R<f64> {
        match self.unwrap_builtin(result) {
            Value::Float(float) => Ok(float),
            _ => {
                let types = &self.core.types;
                let (own, name) = (types.of(value).name(), types.name_of(result));
                Err(self.type_error(format!("{own}.__float__ returned non-float (type {name})")))
            }
        }
    }

    /// An integer as a float; an error if it is out of range.
    pub fn int_to_f64(&self, int: &Int) -> R<f64> {
        let float = int.to_f64();
        if float.is_finite() {
            return Ok(float);
        }
        Err(self.raise(
            ExceptionKind::OverflowError,
            "int too large to convert to float",
        ))
    }

    /// The builtin value behind an instance of a subclass of a builtin type; any other value as it is.
    pub fn unwrap_builtin(&self, value: &Value) -> Value {
        match value {
            Value::Instance(instance) => instance.builtin_value().unwrap_or_else(|| value.clone()),
            _ => value.clone(),
        }
    }
}
