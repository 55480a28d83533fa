//! Values as embedders make and read them.

use std::rc::Rc;

use messages::Text;

use super::int::Int;
use super::{Dict, Value};

impl Value {
    /// A list of floats.
    pub fn list_of_f64(items: &[f64]) -> Value {
        Value::list(items.iter().map(|item| Value::Float(*item)).collect())
    }

    /// A list of integers.
    pub fn list_of_i64(items: &[i64]) -> Value {
        Value::list(items.iter().map(|item| Value::Int(*item)).collect())
    }

    /// A dictionary with text keys.
    pub fn dict_of(entries: impl IntoIterator<Item = (String, Value)>) -> Value {
        let dict = Dict::new();
        for (key, value) in entries {
            dict.set_str(&key, value);
        }
        Value::Dict(Rc::new(dict))
    }

    /// A real number as a float; booleans count as 0 and 1. None for anything else.
    pub fn as_f64(&self) -> Option<f64> {
        crate::ops::arith::as_f64(self)
    }

    /// A whole number as an integer: integers, booleans, and floats without a fraction, within 64 bits.
    pub fn as_i64(&self) -> Option<i64> {
        match self {
            Value::Float(float) => {
                let in_range = float.fract() == 0.0 && (-9.3e18..9.3e18).contains(float);
                in_range
                    .then(|| super::int::from_f64(*float))
                    .and_then(|value| value.as_i64())
            }
            other => match Int::of(other)? {
                Int::Small(small) => Some(small),
                Int::Big(_) => None,
            },
        }
    }

    /// A boolean; numbers count as true unless they are zero. None for anything else.
    pub fn as_bool(&self) -> Option<bool> {
        match self {
            Value::Bool(flag) => Some(*flag),
            other => other.as_f64().map(|number| number != 0.0),
        }
    }

    /// The text of a string.
    pub fn as_str(&self) -> Option<&str> {
        match self {
            Value::Str(text) => Some(text.as_str()),
            _ => None,
        }
    }

    /// The items of a list or tuple.
    pub fn as_items(&self) -> Option<Vec<Value>> {
        match self {
            Value::List(list) => Some(list.borrow().clone()),
            Value::Tuple(tuple) => Some(tuple.items().to_vec()),
            Value::Instance(instance) => instance.builtin_value()?.as_items(),
            _ => None,
        }
    }

    /// The integer part of a float, `None` for NaN and the infinities.
    pub fn whole_part(number: f64) -> Option<Value> {
        number.is_finite().then(|| super::int::from_f64(number))
    }

    /// Whether it can be called: a function, a method, a class, an instance of a class with `__call__`.
    pub fn is_callable(&self) -> bool {
        match self {
            Value::Instance(instance) => {
                let call = super::symbol::known::CALL;
                instance.class.lookup(call).is_some()
            }
            Value::Function(_)
            | Value::BoundMethod(_)
            | Value::Builtin(_)
            | Value::StaticMethod(_)
            | Value::Class(_) => true,
            _ => false,
        }
    }

    /// The text of an exception that shows as `shown`, in each language where it is one of ours.
    pub fn text_of(&self, shown: String) -> Text {
        let text = match self {
            Value::Instance(instance) => {
                instance.exception().and_then(|state| state.text_of(&shown))
            }
            _ => None,
        };
        text.unwrap_or_else(|| Text::verbatim(shown))
    }

    /// The name of the value's type, as scripts see it.
    pub fn type_name(&self) -> Rc<str> {
        match self {
            Value::Instance(instance) => instance.class.name(),
            Value::Unbound | Value::None => "NoneType".into(),
            Value::Ellipsis => "ellipsis".into(),
            Value::NotImplemented => "NotImplementedType".into(),
            Value::Bool(_) => "bool".into(),
            Value::Int(_) | Value::BigInt(_) => "int".into(),
            Value::Float(_) => "float".into(),
            Value::Complex(_) => "complex".into(),
            Value::Str(_) => "str".into(),
            Value::Bytes(_) => "bytes".into(),
            Value::ByteArray(_) => "bytearray".into(),
            Value::List(_) => "list".into(),
            Value::Tuple(_) => "tuple".into(),
            Value::Dict(_) => "dict".into(),
            Value::DictView(_) => "dict view".into(),
            Value::Set(_) => "set".into(),
            Value::FrozenSet(_) => "frozenset".into(),
            Value::Range(_) | Value::LongRange(_) => "range".into(),
            Value::Slice(_) => "slice".into(),
            Value::Function(_) => "function".into(),
            Value::BoundMethod(_) => "method".into(),
            Value::Builtin(_) => "builtin_function_or_method".into(),
            Value::Class(_) => "type".into(),
            Value::Module(_) => "module".into(),
            Value::Iter(iter) => iter.type_name(),
            Value::Generator(_) => "generator".into(),
            Value::Property(_) => "property".into(),
            Value::StaticMethod(_) => "staticmethod".into(),
            Value::ClassMethod(_) => "classmethod".into(),
            Value::Super(_) => "super".into(),
            Value::Cell(_) => "cell".into(),
            Value::Code(_) => "code".into(),
        }
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Value::str(text)
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Value::str(text)
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Value::Float(value)
    }
}

impl From<i64> for Value {
    fn from(value: i64) -> Self {
        Value::Int(value)
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Value::Bool(value)
    }
}

impl std::fmt::Debug for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::None => f.write_str("None"),
            Value::Bool(flag) => write!(f, "{flag}"),
            Value::Int(int) => write!(f, "{int}"),
            Value::Float(float) => write!(f, "{float:?}"),
            Value::Str(text) => write!(f, "{:?}", text.as_str()),
            Value::List(_) | Value::Tuple(_) => f
                .debug_list()
                .entries(self.as_items().unwrap_or_default())
                .finish(),
            other => write!(f, "<{}>", other.type_name()),
        }
    }
}
