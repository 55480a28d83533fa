//! Binary and unary operators on any values: builtin types first, then the methods of classes.

use std::rc::Rc;

use crate::ast::{BinaryOp, UnaryOp};
use crate::eval::Evaluator;
use crate::value::symbol::known;
use crate::value::{R, Raised, Symbol, Value};

/// The method names of an operator: plain, reflected, in place.
pub fn methods(op: BinaryOp) -> (Symbol, Symbol, Symbol) {
    match op {
        BinaryOp::Add => (known::ADD, known::RADD, known::IADD),
        BinaryOp::Sub => (known::SUB, known::RSUB, known::ISUB),
        BinaryOp::Mul => (known::MUL, known::RMUL, known::IMUL),
        BinaryOp::Div => (known::TRUEDIV, known::RTRUEDIV, known::ITRUEDIV),
        BinaryOp::FloorDiv => (known::FLOORDIV, known::RFLOORDIV, known::IFLOORDIV),
        BinaryOp::Mod => (known::MOD, known::RMOD, known::IMOD),
        BinaryOp::Pow => (known::POW, known::RPOW, known::IPOW),
        BinaryOp::MatMul => (known::MATMUL, known::RMATMUL, known::IMATMUL),
        BinaryOp::BitAnd => (known::AND, known::RAND, known::IAND),
        BinaryOp::BitOr => (known::OR, known::ROR, known::IOR),
        BinaryOp::BitXor => (known::XOR, known::RXOR, known::IXOR),
        BinaryOp::Shl => (known::LSHIFT, known::RLSHIFT, known::ILSHIFT),
        BinaryOp::Shr => (known::RSHIFT, known::RRSHIFT, known::IRSHIFT),
    }
}

/// How messages write an operator.
pub fn text(op: BinaryOp) -> &'static str {
    match op {
        BinaryOp::Add => "+",
        BinaryOp::Sub => "-",
        BinaryOp::Mul => "*",
        BinaryOp::Div => "/",
        BinaryOp::FloorDiv => "//",
        BinaryOp::Mod => "%",
        BinaryOp::Pow => "** or pow()",
        BinaryOp::MatMul => "@",
        BinaryOp::BitAnd => "&",
        BinaryOp::BitOr => "|",
        BinaryOp::BitXor => "^",
        BinaryOp::Shl => "<<",
        BinaryOp::Shr => ">>",
    }
}

/// Lists of so many items together are put together at once.
const FEW: usize = 64;

impl Evaluator<'_> {
    /// `a op b`
    pub fn binary(&self, op: BinaryOp, a: &Value, b: &Value) -> R {
        if let (BinaryOp::Add, Value::List(a), Value::List(b)) = (op, a, b)
            && a.len() + b.len() <= FEW
        {
            let (a, b) = (a.borrow(), b.borrow());
            return Ok(Value::list([a.as_slice(), b.as_slice()].concat()));
        }
        if let Some(value) = self.number_binary(op, a, b)? {
            return Ok(value);
        }
        if has_methods(a) || has_methods(b) {
            let (plain, reflected, _) = methods(op);
            if let Some(value) = self.before_sequence(op, a, b)? {
                return Ok(value);
            }
            if let Some(value) = self.binary_by_methods(plain, reflected, a, b)? {
                return Ok(value);
            }
        } else if let Some(value) = self.builtin_binary(op, a, b)? {
            return Ok(value);
        }
        if op == BinaryOp::BitOr
            && let Some(union) = self.union(a, b)?
        {
            return Ok(union);
        }
        Err(self.unsupported(op, a, b, text(op)))
    }

    /// `a op= b`: containers change in place and are returned.
    pub fn binary_in_place(&self, op: BinaryOp, a: &Value, b: &Value) -> R {
        if let Some(value) = self.number_binary(op, a, b)? {
            return Ok(value);
        }
        let (plain, reflected, in_place) = methods(op);
        if has_methods(a) || has_methods(b) {
            if let Some(value) = self.before_sequence(op, a, b)? {
                return Ok(value);
            }
            if let Value::Instance(instance) = a
                && let Some(method) = instance.class.lookup(in_place)
                && joins(&method).is_none()
            {
                let value = self.call(&method, &mut [a.clone(), b.clone()], &[])?;
                if !matches!(value, Value::NotImplemented) {
                    return Ok(value);
                }
            } else if self.builtin_in_place(op, &self.plain(a), b)?.is_some() {
                // An instance of a subclass of a container has changed with what it extends.
                return Ok(a.clone());
            }
            if let Some(value) = self.binary_by_methods(plain, reflected, a, b)? {
                return Ok(value);
            }
        } else {
            if let Some(value) = self.builtin_in_place(op, a, b)? {
                return Ok(value);
            }
            if let Some(value) = self.builtin_binary(op, a, b)? {
                return Ok(value);
            }
        }
        let text = if op == BinaryOp::Pow {
            "**=".to_owned()
        } else {
            format!("{}=", text(op))
        };
        Err(self.unsupported(op, a, b, &text))
    }

    /// Sequences come last: an object that says what adding or repeating a sequence with it means has its turn first.
    fn before_sequence(&self, op: BinaryOp, a: &Value, b: &Value) -> R<Option<Value>> {
        if !is_sequence(a) || !matches!(op, BinaryOp::Add | BinaryOp::Mul) {
            return Ok(None);
        }
        match self.core.types.of(b).lookup(methods(op).1) {
            Some(method @ Value::Function(_)) => self.try_method(Some(&method), b, a),
            Some(method) if op == BinaryOp::Mul && multiplies(b) => {
                self.try_method(Some(&method), b, a)
            }
            _ => Ok(None),
        }
    }

    /// Tries `a.plain(b)` and `b.reflected(a)`; the right operand goes first if its class is derived from the left's.
    pub fn binary_by_methods(
        &self,
        plain: Symbol,
        reflected: Symbol,
        a: &Value,
        b: &Value,
    ) -> R<Option<Value>> {
        let (class_a, class_b) = (self.core.types.of(a), self.core.types.of(b));
        let same = Rc::ptr_eq(class_a, class_b);
        let method_b = if same {
            None
        } else {
            class_b.lookup(reflected)
        };
        // A subclass goes first only with a method of its own.
        let b_first = !same
            && class_b.is_subclass_of(class_a)
            && method_b.as_ref().is_some_and(|method| {
                class_a
                    .lookup(reflected)
                    .is_none_or(|other| !other.is(method))
            });
        if b_first && let Some(value) = self.try_method(method_b.as_ref(), b, a)? {
            return Ok(Some(value));
        }
        let method_a = class_a.lookup(plain);
        if let Some(value) = self.try_method(method_a.as_ref(), a, b)? {
            return Ok(Some(value));
        }
        if b_first {
            return Ok(None);
        }
        self.try_method(method_b.as_ref(), b, a)
    }

    fn try_method(
        &self,
        method: Option<&Value>,
        receiver: &Value,
        other: &Value,
    ) -> R<Option<Value>> {
        let Some(method) = method else {
            return Ok(None);
        };
        if let Some((op, turned)) = joins(method)
            && !(op == BinaryOp::Mul && multiplies(receiver))
        {
            let receiver = self.plain(receiver);
            // What is repeated is asked how often as what it is: its class may have an `__index__`.
            let other = match op {
                BinaryOp::Mul if turned && is_sequence(&self.plain(other)) => return Ok(None),
                BinaryOp::Mul => other.clone(),
                _ => self.plain(other),
            };
            let (a, b) = match turned {
                false => (&receiver, &other),
                true => (&other, &receiver),
            };
            return self.builtin_binary(op, a, b);
        }
        let value =
            self.recurse(|| self.call_method_value(method, receiver, &mut [other.clone()]))?;
        Ok((!matches!(value, Value::NotImplemented)).then_some(value))
    }

    /// Calls what was found in the class of `receiver` as its method.
    pub fn call_method_value(&self, method: &Value, receiver: &Value, args: &mut [Value]) -> R {
        match method {
            Value::Function(function) => self.call_method(function, receiver.clone(), args),
            Value::Builtin(builtin) => self.with_first(receiver.clone(), args, |all| {
                self.recurse(|| self.call_builtin(builtin, all, &[], None))
            }),
            // A descriptor may be found through a descriptor.
            _ => self.recurse(|| {
                let bound = self.bind_attribute(method, receiver, self.core.types.of(receiver))?;
                self.call(&bound, args, &[])
            }),
        }
    }

    /// Calls the method `name` of the class of `receiver`, if there is one.
    pub fn special(&self, receiver: &Value, name: Symbol, args: &mut [Value]) -> R<Option<Value>> {
        match self.core.types.of(receiver).lookup(name) {
            Some(method) => self.call_method_value(&method, receiver, args).map(Some),
            None => Ok(None),
        }
    }

    #[cold]
    pub fn unsupported(&self, op: BinaryOp, a: &Value, b: &Value, text: &str) -> Raised {
        let (name_a, name_b) = (self.core.types.name_of(a), self.core.types.name_of(b));
        let plain = self.plain(a);
        let plain_b = self.plain(b);
        // What says what it cannot add knows the builtin type, for bytes the class.
        let (name_a, a) = match plain {
            Value::Str(_) | Value::List(_) | Value::Tuple(_) if op == BinaryOp::Add => {
                (self.core.types.name_of(&plain), &plain)
            }
            Value::Bytes(_) | Value::ByteArray(_) if op == BinaryOp::Add => (name_a, &plain),
            _ => (name_a, a),
        };
        let concatenation = match (op, a) {
            (BinaryOp::Add, Value::Str(_) | Value::List(_) | Value::Tuple(_)) => true,
            (BinaryOp::Add, Value::Bytes(_) | Value::ByteArray(_)) => {
                return self.type_error(format!("can't concat {name_b} to {name_a}"));
            }
            _ => false,
        };
        if concatenation {
            return self.type_error(format!(
                "can only concatenate {name_a} (not \"{name_b}\") to {name_a}"
            ));
        }
        // What multiplies in its own way is no sequence for the operator, as in CPython.
        if op == BinaryOp::Mul {
            if is_sequence(&plain) && !multiplies(a) {
                return self.type_error(format!(
                    "can't multiply sequence by non-int of type '{name_b}'"
                ));
            }
            if is_sequence(&plain_b) && !multiplies(b) {
                return self.type_error(format!(
                    "can't multiply sequence by non-int of type '{name_a}'"
                ));
            }
        }
        self.type_error(format!(
            "unsupported operand type(s) for {text}: '{name_a}' and '{name_b}'"
        ))
    }

    /// `-value`, `+value`, `~value`; `not` is `!truth`.
    pub fn unary(&self, op: UnaryOp, value: &Value) -> R {
        let (method, text) = match op {
            UnaryOp::Not => return Ok(Value::Bool(!self.truth(value)?)),
            UnaryOp::Neg => {
                if let Some(value) = self.number_negate(value) {
                    return Ok(value);
                }
                (known::NEG, "-")
            }
            UnaryOp::Pos => {
                match value {
                    Value::Bool(flag) => return Ok(Value::Int(i64::from(*flag))),
                    Value::Int(_) | Value::Float(_) | Value::BigInt(_) | Value::Complex(_) => {
                        return Ok(value.clone());
                    }
                    _ => {}
                }
                (known::POS, "+")
            }
            UnaryOp::Invert => {
                match value {
                    Value::Int(int) => return Ok(Value::Int(!int)),
                    Value::Bool(flag) => return Ok(Value::Int(!i64::from(*flag))),
                    Value::BigInt(big) => return Ok(Value::bigint(!(**big).clone())),
                    _ => {}
                }
                (known::INVERT, "~")
            }
        };
        if let Value::Instance(_) = value
            && let Some(result) = self.special(value, method, &mut [])?
        {
            return Ok(result);
        }
        let name = self.core.types.name_of(value);
        Err(self.type_error(format!("bad operand type for unary {text}: '{name}'")))
    }
}

/// Whether operators look for methods in the class first.
pub fn has_methods(value: &Value) -> bool {
    match value {
        Value::Instance(_) => true,
        Value::Class(class) => class.metaclass().is_some(),
        _ => false,
    }
}

/// Whether the class of an object derived from a sequence has a script's way to multiply, in one direction at least: then
/// CPython takes it for a number and calls the method of the other direction, too, which says what it cannot take.
fn multiplies(value: &Value) -> bool {
    let Value::Instance(instance) = value else {
        return false;
    };
    [known::MUL, known::RMUL]
        .into_iter()
        .any(|name| matches!(instance.class.lookup(name), Some(Value::Function(_))))
}

fn is_sequence(value: &Value) -> bool {
    matches!(
        value,
        Value::Str(_) | Value::List(_) | Value::Tuple(_) | Value::Bytes(_) | Value::ByteArray(_)
    )
}

/// `Builtin::joins` of a method.
#[inline]
fn joins(method: &Value) -> Option<(BinaryOp, bool)> {
    match method {
        Value::Builtin(builtin) => builtin.joins,
        _ => None,
    }
}
