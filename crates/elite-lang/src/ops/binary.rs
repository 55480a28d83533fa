//! Binary and unary operators on any values: builtin types first, then the methods of classes.

use std::rc::Rc;

use elite_syntax::ast::{BinaryOp, UnaryOp};

use crate::eval::Evaluator;
use crate::value::symbol::known;
use crate::value::{Class, R, Symbol, Unwind, Value};

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
const INLINE_CONCAT_MAX: usize = 64;

impl Evaluator<'_> {
    /// `a op b`
    pub fn binary(&self, op: BinaryOp, a: &Value, b: &Value) -> R {
        if let (BinaryOp::Add, Value::List(a), Value::List(b)) = (op, a, b)
            && a.len() + b.len() <= INLINE_CONCAT_MAX
        {
            let (a, b) = (a.borrow(), b.borrow());
            return Ok(Value::list([a.as_slice(), b.as_slice()].concat()));
        }
        if let Some(value) = self.number_binary(op, a, b)? {
            return Ok(value);
        }
        if has_methods(a) || has_methods(b) {
            let value = match op {
                BinaryOp::Add | BinaryOp::Mul => self.sequence_binary(op, a, b, false)?,
                _ => {
                    let (plain, reflected, _) = methods(op);
                    self.binary_by_methods(plain, reflected, a, b)?
                }
            };
            if let Some(value) = value {
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
        Err(self.unsupported_operand(op, a, b, text(op)))
    }

    /// `a op= b`: containers change in place and are returned.
    pub fn binary_in_place(&self, op: BinaryOp, a: &Value, b: &Value) -> R {
        if let Some(value) = self.number_binary(op, a, b)? {
            return Ok(value);
        }
        let (plain, reflected, in_place) = methods(op);
        if has_methods(a) || has_methods(b) {
            if matches!(op, BinaryOp::Add | BinaryOp::Mul) {
                return match self.sequence_binary(op, a, b, true)? {
                    Some(value) => Ok(value),
                    None => Err(self.unsupported_operand(op, a, b, &format!("{}=", text(op)))),
                };
            }
            if let Value::Instance(instance) = a
                && let Some(method) = instance.class.lookup(in_place)
            {
                let value = self.call(&method, &mut [a.clone(), b.clone()], &[])?;
                if !matches!(value, Value::NotImplemented) {
                    return Ok(value);
                }
            } else if self
                .builtin_in_place(op, &self.unwrap_builtin(a), b)?
                .is_some()
            {
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
        if op == BinaryOp::BitOr
            && let Some(union) = self.union(a, b)?
        {
            return Ok(union);
        }
        let text = if op == BinaryOp::Pow {
            "**=".to_owned()
        } else {
            format!("{}=", text(op))
        };
        Err(self.unsupported_operand(op, a, b, &text))
    }

    /// `a + b` and `a * b` where one of them has a class of its own. As numbers are added the two are asked first, as
    /// far as they have something to say beside what sequences have; then what the sequences say is final. None if
    /// there is no answer.
    fn sequence_binary(
        &self,
        op: BinaryOp,
        a: &Value,
        b: &Value,
        in_place: bool,
    ) -> R<Option<Value>> {
        let (plain, reflected, own) = methods(op);
        let (class_a, class_b) = (self.core.types.of(a), self.core.types.of(b));
        let changed = match in_place {
            true => class_a.lookup(own),
            false => None,
        };
        if let Some(method) = &changed {
            if joins(method).is_none() {
                if let Some(value) = self.try_method(Some(method), a, b)? {
                    return Ok(Some(value));
                }
            } else if op == BinaryOp::Add && class_a.is_script {
                // Classes derived from sequences have it as numbers have it.
                return self
                    .call_method_value(method, a, &mut [b.clone()])
                    .map(Some);
            }
        }
        let same = Rc::ptr_eq(class_a, class_b);
        let method_a = class_a.lookup(plain);
        let method_b = match same {
            true => None,
            false => class_b.lookup(reflected),
        };
        let is_number = |class: &Class, method: &Value, other: Symbol| {
            let has_other = || {
                class
                    .lookup(other)
                    .is_some_and(|other| joins(&other).is_none())
            };
            joins(method).is_none() || has_other()
        };
        let number_a = { method_a.as_ref() }.filter(|method| is_number(class_a, method, reflected));
        let number_b = { method_b.as_ref() }.filter(|method| is_number(class_b, method, plain));
        if (number_a.is_some() || number_b.is_some())
            && let Some(value) = self.by_these(number_a, number_b, reflected, a, b)?
        {
            return Ok(Some(value));
        }
        let changed = changed.filter(|method| joins(method).is_some());
        let method_a = method_a.filter(|method| joins(method).is_some());
        if op == BinaryOp::Add {
            return match (changed, method_a) {
                (Some(method), _) => self
                    .call_method_value(&method, a, &mut [b.clone()])
                    .map(Some),
                (None, Some(method)) => self.of_sequence(op, &method, a, b).map(Some),
                (None, None) => Ok(None),
            };
        }
        // A class that multiplies in its own way, in whichever direction, is repeated in none.
        let repeats = |class: &Class, name: Symbol| {
            class.lookup(name).filter(|method| joins(method).is_some())
        };
        let is_changed = changed.is_some();
        let method_a = changed.or_else(|| {
            let method = method_a?;
            repeats(class_a, reflected).map(|_| method)
        });
        let (method, sequence, count) = match method_a {
            Some(method) => (method, a, b),
            // In place the other one is not asked by what might have been a sequence.
            None if !in_place || !has_sequence_methods(a) => {
                match repeats(class_b, plain).filter(|_| repeats(class_b, reflected).is_some()) {
                    Some(method) => (method, b, a),
                    None => return Ok(None),
                }
            }
            None => return Ok(None),
        };
        if !self.has_index(count) {
            let name = self.core.types.name_of(count);
            let text = format!("can't multiply sequence by non-int of type '{name}'");
            return Err(self.type_error(text));
        }
        match is_changed {
            true => self.call_method_value(&method, sequence, &mut [count.clone()]),
            false => self.of_sequence(op, &method, sequence, count),
        }
        .map(Some)
    }

    /// What a sequence has to say: for those that are builtin, or extend one, without a call.
    fn of_sequence(&self, op: BinaryOp, method: &Value, sequence: &Value, other: &Value) -> R {
        let own = self.unwrap_builtin(sequence);
        let made = match op {
            BinaryOp::Mul => self.builtin_binary(op, &own, other)?,
            _ => self.builtin_binary(op, &own, &self.unwrap_builtin(other))?,
        };
        match made {
            Some(made) => Ok(made),
            None => self.call_method_value(method, sequence, &mut [other.clone()]),
        }
    }

    /// Tries `a.plain(b)` and `b.reflected(a)`; the right operand goes first if its class is derived from the
    /// left's.
    pub fn binary_by_methods(
        &self,
        plain: Symbol,
        reflected: Symbol,
        a: &Value,
        b: &Value,
    ) -> R<Option<Value>> {
        let (class_a, class_b) = (self.core.types.of(a), self.core.types.of(b));
        let method_b = match Rc::ptr_eq(class_a, class_b) {
            true => None,
            false => class_b.lookup(reflected),
        };
        let method_a = class_a.lookup(plain);
        self.by_these(method_a.as_ref(), method_b.as_ref(), reflected, a, b)
    }

    /// Tries the methods that were found for a binary operator, the left operand's and the reflected one of the right
    /// operand; `method_b` is none if both are of one class.
    fn by_these(
        &self,
        method_a: Option<&Value>,
        method_b: Option<&Value>,
        reflected: Symbol,
        a: &Value,
        b: &Value,
    ) -> R<Option<Value>> {
        let (class_a, class_b) = (self.core.types.of(a), self.core.types.of(b));
        // A subclass goes first only with a method of its own.
        let b_first = !Rc::ptr_eq(class_a, class_b)
            && class_b.is_subclass_of(class_a)
            && method_b.is_some_and(|method| {
                class_a
                    .lookup(reflected)
                    .is_none_or(|other| !other.is(method))
            });
        if b_first && let Some(value) = self.try_method(method_b, b, a)? {
            return Ok(Some(value));
        }
        if let Some(value) = self.try_method(method_a, a, b)? {
            return Ok(Some(value));
        }
        if b_first {
            return Ok(None);
        }
        self.try_method(method_b, b, a)
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
        let value =
            self.deeper(|| self.call_method_value(method, receiver, &mut [other.clone()]))?;
        Ok((!matches!(value, Value::NotImplemented)).then_some(value))
    }

    /// Calls what was found in the class of `receiver` as its method.
    pub fn call_method_value(&self, method: &Value, receiver: &Value, args: &mut [Value]) -> R {
        match method {
            Value::Function(function) => self.call_method(function, receiver.clone(), args),
            Value::Builtin(builtin) => self.with_first(receiver.clone(), args, |all| {
                self.deeper(|| self.call_builtin(builtin, all, &[], None))
            }),
            // A descriptor may be found through a descriptor.
            _ => self.with_native_depth(|| {
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
    pub fn unsupported_operand(&self, op: BinaryOp, a: &Value, b: &Value, text: &str) -> Unwind {
        let (name_a, name_b) = (self.core.types.name_of(a), self.core.types.name_of(b));
        let plain = self.unwrap_builtin(a);
        // What says what it cannot add knows the builtin type, for bytes the class.
        let is_concatenated = op == BinaryOp::Add && {
            let class = self.core.types.of(a);
            let method = class.lookup(known::ADD);
            method.is_some_and(|method| joins(&method).is_some())
        };
        let (name_a, a) = match plain {
            _ if !is_concatenated => (name_a, a),
            Value::Str(_) | Value::List(_) | Value::Tuple(_) => {
                (self.core.types.name_of(&plain), &plain)
            }
            Value::Bytes(_) | Value::ByteArray(_) => (name_a, &plain),
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
        if op == BinaryOp::Mul && !has_methods(a) && !has_methods(b) {
            let wrong = |name: &str| {
                let text = format!("can't multiply sequence by non-int of type '{name}'");
                self.type_error(text)
            };
            if is_sequence(a) {
                return wrong(&name_b);
            }
            if is_sequence(b) && !(text == "*=" && has_sequence_methods(a)) {
                return wrong(&name_a);
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

/// Whether the type of a value has methods of sequences in CPython, whichever.
fn has_sequence_methods(value: &Value) -> bool {
    match value {
        Value::Instance(instance) => {
            let class = &instance.class;
            class.is_script && !class.is_c_type.get() || class.lookup(known::LEN).is_some()
        }
        Value::Class(class) => class.metaclass().is_some(),
        Value::Dict(_) | Value::DictView(_) | Value::Set(_) | Value::FrozenSet(_) => true,
        Value::Range(_) | Value::LongRange(_) => true,
        value => is_sequence(value),
    }
}

fn is_sequence(value: &Value) -> bool {
    matches!(
        value,
        Value::Str(_) | Value::List(_) | Value::Tuple(_) | Value::Bytes(_) | Value::ByteArray(_)
    )
}

/// `Builtin::sequence_op` of a method.
#[inline]
fn joins(method: &Value) -> Option<(BinaryOp, bool)> {
    match method {
        Value::Builtin(builtin) => builtin.sequence_op,
        _ => None,
    }
}
