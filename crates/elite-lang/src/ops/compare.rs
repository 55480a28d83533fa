//! Comparisons.

use std::cmp::Ordering;
use std::rc::Rc;

use elite_syntax::ast::CompareOp;
use elite_syntax::surrogate::{code_of, may_have_surrogates};

use super::hash::{Equality, QUICK_MAX, int_float_order, quick_equal};
use crate::eval::Evaluator;
use crate::limits::chunked::BULK_CHUNK;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::int::Int;
use crate::value::symbol::known;
use crate::value::{LongRange, R, Str, Symbol, Value};

/// The result of comparing two numbers of the commonest types, or whether two short texts are equal; None for others.
#[inline(always)]
pub fn fast(op: CompareOp, a: &Value, b: &Value) -> Option<bool> {
    match (a, b) {
        (Value::Int(a), Value::Int(b)) => Some(satisfies(op, a, b)),
        (Value::Float(a), Value::Float(b)) => Some(satisfies(op, a, b)),
        (Value::Float(a), Value::Int(b)) if b.unsigned_abs() < 1 << 53 => {
            Some(satisfies(op, a, &(*b as f64)))
        }
        (Value::Int(a), Value::Float(b)) if a.unsigned_abs() < 1 << 53 => {
            Some(satisfies(op, &(*a as f64), b))
        }
        (Value::Str(a), Value::Str(b)) if matches!(op, CompareOp::Eq | CompareOp::Ne) => {
            let equal = same_text(a, b)?;
            Some(equal == (op == CompareOp::Eq))
        }
        _ => None,
    }
}

/// Whether two texts are equal; None if it takes long to say.
#[inline(never)]
fn same_text(a: &Rc<Str>, b: &Rc<Str>) -> Option<bool> {
    if Rc::ptr_eq(a, b) {
        return Some(true);
    }
    let (a, b) = (a.as_str(), b.as_str());
    match a.len() == b.len() {
        true if a.len() > BULK_CHUNK => None,
        true => Some(a == b),
        false => Some(false),
    }
}

#[inline(always)]
fn satisfies<T: PartialOrd>(op: CompareOp, a: &T, b: &T) -> bool {
    match op {
        CompareOp::Eq => a == b,
        CompareOp::Ne => a != b,
        CompareOp::Lt => a < b,
        CompareOp::Le => a <= b,
        CompareOp::Gt => a > b,
        _ => a >= b,
    }
}

fn by_order(op: CompareOp, order: Option<Ordering>) -> bool {
    match (op, order) {
        (CompareOp::Ne, None) => true,
        (_, None) => false,
        (CompareOp::Eq, Some(order)) => order.is_eq(),
        (CompareOp::Ne, Some(order)) => order.is_ne(),
        (CompareOp::Lt, Some(order)) => order.is_lt(),
        (CompareOp::Le, Some(order)) => order.is_le(),
        (CompareOp::Gt, Some(order)) => order.is_gt(),
        (_, Some(order)) => order.is_ge(),
    }
}

fn method(op: CompareOp) -> Symbol {
    match op {
        CompareOp::Eq => known::EQ,
        CompareOp::Ne => known::NE,
        CompareOp::Lt => known::LT,
        CompareOp::Le => known::LE,
        CompareOp::Gt => known::GT,
        _ => known::GE,
    }
}

fn reflect(op: CompareOp) -> CompareOp {
    match op {
        CompareOp::Lt => CompareOp::Gt,
        CompareOp::Le => CompareOp::Ge,
        CompareOp::Gt => CompareOp::Lt,
        CompareOp::Ge => CompareOp::Le,
        other => other,
    }
}

/// How messages write an operator.
pub fn text(op: CompareOp) -> &'static str {
    match op {
        CompareOp::Eq => "==",
        CompareOp::Ne => "!=",
        CompareOp::Lt => "<",
        CompareOp::Le => "<=",
        CompareOp::Gt => ">",
        CompareOp::Ge => ">=",
        CompareOp::Is => "is",
        CompareOp::IsNot => "is not",
        CompareOp::In => "in",
        CompareOp::NotIn => "not in",
    }
}

impl Evaluator<'_> {
    /// `a op b` for any comparison operator; the result of a method may be any value.
    pub fn compare(&self, op: CompareOp, a: &Value, b: &Value) -> R {
        match op {
            CompareOp::Is => return Ok(Value::Bool(a.is(b))),
            CompareOp::IsNot => return Ok(Value::Bool(!a.is(b))),
            CompareOp::In => return self.contains(b, a).map(Value::Bool),
            CompareOp::NotIn => return self.contains(b, a).map(|found| Value::Bool(!found)),
            _ => {}
        }
        if let Some(result) = fast(op, a, b) {
            return Ok(Value::Bool(result));
        }
        if super::binary::has_methods(a) || super::binary::has_methods(b) {
            return self.compare_by_methods(op, a, b);
        }
        match self.builtin_compare(op, a, b)? {
            Some(result) => Ok(Value::Bool(result)),
            None => self.compare_default(op, a, b),
        }
    }

    /// `a op b` as truth.
    pub fn compare_truth(&self, op: CompareOp, a: &Value, b: &Value) -> R<bool> {
        match self.compare(op, a, b)? {
            Value::Bool(flag) => Ok(flag),
            other => self.truth(&other),
        }
    }

    /// Python's `a == b`; identical objects are equal, as containers have it.
    #[inline]
    pub fn equal(&self, a: &Value, b: &Value) -> R<bool> {
        match quick_equal(a, b) {
            Equality::Yes => Ok(true),
            Equality::No => Ok(false),
            Equality::Ask => {
                if let (Value::Tuple(_), Value::Tuple(_)) = (a, b) {
                    // The quick comparison may have looked at that many items before it gave up.
                    self.charge(QUICK_MAX as usize * WORK_PER_VALUE)?;
                }
                self.compare_truth(CompareOp::Eq, a, b)
            }
        }
    }

    /// Python's `a < b`.
    pub fn less(&self, a: &Value, b: &Value) -> R<bool> {
        match fast(CompareOp::Lt, a, b) {
            Some(result) => Ok(result),
            None => self.compare_truth(CompareOp::Lt, a, b),
        }
    }

    fn compare_by_methods(&self, op: CompareOp, a: &Value, b: &Value) -> R {
        let types = &self.core.types;
        let (class_a, class_b) = (types.of(a), types.of(b));
        let b_first = !Rc::ptr_eq(class_a, class_b) && class_b.is_subclass_of(class_a);
        let reflected = reflect(op);
        if b_first && let Some(value) = self.compare_method(reflected, b, a)? {
            return Ok(value);
        }
        if let Some(value) = self.compare_method(op, a, b)? {
            return Ok(value);
        }
        if !b_first && let Some(value) = self.compare_method(reflected, b, a)? {
            return Ok(value);
        }
        self.compare_default(op, a, b)
    }

    fn compare_method(&self, op: CompareOp, receiver: &Value, other: &Value) -> R<Option<Value>> {
        let class = self.core.types.of(receiver);
        let found = class.lookup(method(op));
        if let Some(found) = found {
            self.charge(16 * WORK_PER_VALUE)?;
            let value = self.with_native_depth(|| {
                self.call_method_value(&found, receiver, &mut [other.clone()])
            })?;
            return Ok((!matches!(value, Value::NotImplemented)).then_some(value));
        }
        // `!=` is the opposite of `==` unless defined otherwise.
        if op == CompareOp::Ne
            && let Some(equal) = self.compare_method(CompareOp::Eq, receiver, other)?
        {
            return Ok(Some(Value::Bool(!self.truth(&equal)?)));
        }
        Ok(None)
    }

    /// What comparison means for objects without methods: identity, or an error.
    fn compare_default(&self, op: CompareOp, a: &Value, b: &Value) -> R {
        match op {
            CompareOp::Eq => Ok(Value::Bool(a.is(b))),
            CompareOp::Ne => Ok(Value::Bool(!a.is(b))),
            _ => {
                let (a, b) = (self.core.types.name_of(a), self.core.types.name_of(b));
                let op = text(op);
                Err(self.type_error(format!(
                    "'{op}' not supported between instances of '{a}' and '{b}'"
                )))
            }
        }
    }

    /// Comparison of builtin values; None if their types define none.
    pub fn builtin_compare(&self, op: CompareOp, a: &Value, b: &Value) -> R<Option<bool>> {
        Ok(match (a, b) {
            (Value::Str(a), Value::Str(b)) => {
                let is_order = !matches!(op, CompareOp::Eq | CompareOp::Ne);
                if is_order && !a.is_ascii() && !b.is_ascii() && has_surrogates(a, b) {
                    let (a, b) = (a.as_str().chars(), b.as_str().chars());
                    let order = a.map(code_of).cmp(b.map(code_of));
                    return Ok(Some(by_order(op, Some(order))));
                }
                let (a, b) = (a.as_str().as_bytes(), b.as_str().as_bytes());
                Some(self.compare_bytes(op, a, b)?)
            }
            (Value::List(a), Value::List(b)) => {
                if Rc::ptr_eq(a, b) && matches!(op, CompareOp::Eq | CompareOp::Ne) {
                    return Ok(Some(op == CompareOp::Eq));
                }
                let lengths = || (a.len(), b.len());
                let pair = |i: usize| Some((a.get(i)?, b.get(i)?));
                Some(self.with_native_depth(|| self.compare_sequences(op, lengths, pair))?)
            }
            (Value::Tuple(a), Value::Tuple(b)) => {
                let (x, y) = (a.items(), b.items());
                let pair = |i: usize| Some((x.get(i)?.clone(), y.get(i)?.clone()));
                let lengths = || (x.len(), y.len());
                Some(self.with_native_depth(|| self.compare_sequences(op, lengths, pair))?)
            }
            (Value::Dict(a), Value::Dict(b)) => match op {
                CompareOp::Eq => Some(self.with_native_depth(|| self.dicts_equal(a, b))?),
                CompareOp::Ne => Some(!self.with_native_depth(|| self.dicts_equal(a, b))?),
                _ => None,
            },
            (Value::Set(a) | Value::FrozenSet(a), Value::Set(b) | Value::FrozenSet(b)) => {
                Some(self.compare_sets(op, a, b)?)
            }
            (Value::Bytes(_) | Value::ByteArray(_), Value::Bytes(_) | Value::ByteArray(_)) => {
                match (self.bytes_like(a), self.bytes_like(b)) {
                    (Some(a), Some(b)) => Some(self.compare_bytes(op, &a, &b)?),
                    _ => None,
                }
            }
            (Value::Range(x), Value::Range(y)) => {
                let equal = x.len() == y.len()
                    && (x.is_empty() || (x.start == y.start && (x.len() == 1 || x.step == y.step)));
                equality(op, equal)
            }
            (Value::Range(_) | Value::LongRange(_), Value::LongRange(_))
            | (Value::LongRange(_), Value::Range(_)) => {
                equality(op, LongRange::of(a) == LongRange::of(b))
            }
            (Value::Slice(x), Value::Slice(y)) => {
                let parts = |slice: &crate::value::Slice| {
                    let parts = [&slice.start, &slice.stop, &slice.step];
                    Value::tuple(parts.map(Value::clone).to_vec())
                };
                let (x, y) = (parts(x), parts(y));
                let result = self.with_native_depth(|| self.compare(op, &x, &y))?;
                Some(self.truth(&result)?)
            }
            (Value::DictView(_), _) | (_, Value::DictView(_)) => {
                self.with_native_depth(|| self.compare_views(op, a, b))?
            }
            (Value::BoundMethod(x), Value::BoundMethod(y)) => {
                equality(op, x.receiver.is(&y.receiver) && x.function.is(&y.function))
            }
            _ => number_order(op, a, b),
        })
    }

    #[inline]
    fn compare_bytes(&self, op: CompareOp, a: &[u8], b: &[u8]) -> R<bool> {
        if a.len().min(b.len()) <= BULK_CHUNK {
            return Ok(satisfies(op, &a, &b));
        }
        match op {
            CompareOp::Eq => self.bytes_equal(a, b),
            CompareOp::Ne => Ok(!self.bytes_equal(a, b)?),
            _ => Ok(by_order(op, Some(self.cmp_bytes(a, b)?))),
        }
    }

    fn compare_views(&self, op: CompareOp, a: &Value, b: &Value) -> R<Option<bool>> {
        let is_set = |value: &Value| match value {
            Value::Set(_) | Value::FrozenSet(_) => true,
            Value::DictView(view) => view.kind != crate::value::dict::ViewKind::Values,
            _ => false,
        };
        if !is_set(a) || !is_set(b) {
            return Ok(None);
        }
        // Sets are compared like CPython does: by the lengths, then whether the one holds all that the other gives.
        let (x, y) = (self.len(a)?, self.len(b)?);
        Ok(Some(match op {
            CompareOp::Eq => x == y && self.all_within(a, b)?,
            CompareOp::Ne => !(x == y && self.all_within(a, b)?),
            CompareOp::Le => x <= y && self.all_within(a, b)?,
            CompareOp::Lt => x < y && self.all_within(a, b)?,
            CompareOp::Ge => x >= y && self.all_within(b, a)?,
            _ => x > y && self.all_within(b, a)?,
        }))
    }

    fn all_within(&self, items: &Value, container: &Value) -> R<bool> {
        let iterator = self.iter(items)?;
        while let Some(item) = self.next_at_safepoint(&iterator)? {
            if !self.contains(container, &item)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn compare_sequences(
        &self,
        op: CompareOp,
        lengths: impl Fn() -> (usize, usize),
        pair: impl Fn(usize) -> Option<(Value, Value)>,
    ) -> R<bool> {
        let (a, b) = lengths();
        if a != b {
            match op {
                CompareOp::Eq => return Ok(false),
                CompareOp::Ne => return Ok(true),
                _ => {}
            }
        }
        let mut index = 0;
        // The lists may change while items are compared; the pairs are taken one by one.
        while let Some((a, b)) = pair(index) {
            self.charge(WORK_PER_VALUE)?;
            if !self.equal(&a, &b)? {
                match op {
                    CompareOp::Eq => return Ok(false),
                    CompareOp::Ne => return Ok(true),
                    _ => {}
                }
                match pair(index) {
                    Some((a, b)) => return self.compare_truth(op, &a, &b),
                    // The items are gone, because comparing them has changed a list; then the lengths decide.
                    None => break,
                }
            }
            index += 1;
        }
        let (a, b) = lengths();
        Ok(by_order(op, Some(a.cmp(&b))))
    }

    /// `item in container`.
    pub fn contains(&self, container: &Value, item: &Value) -> R<bool> {
        match container {
            Value::List(list) => {
                let mut index = 0;
                while let Some(other) = list.get(index) {
                    self.charge(WORK_PER_VALUE)?;
                    if self.equal(&other, item)? {
                        return Ok(true);
                    }
                    index += 1;
                }
                Ok(false)
            }
            Value::Tuple(tuple) => {
                for other in tuple.items() {
                    self.charge(WORK_PER_VALUE)?;
                    if self.equal(other, item)? {
                        return Ok(true);
                    }
                }
                Ok(false)
            }
            Value::Dict(dict) => Ok(self.dict_find(dict, item)?.is_some()),
            Value::Set(set) | Value::FrozenSet(set) => self.set_contains(set, item),
            Value::Str(text) => match item {
                Value::Str(part) => self.text_contains(text, part),
                _ => match self.unwrap_builtin(item) {
                    Value::Str(part) => self.text_contains(text, &part),
                    _ => {
                        let name = self.core.types.name_of(item);
                        Err(self.type_error(format!(
                            "'in <string>' requires string as left operand, not {name}"
                        )))
                    }
                },
            },
            Value::Range(range) => match Int::of(item) {
                Some(Int::Small(int)) => Ok(range.position(int).is_some()),
                Some(Int::Big(_)) => Ok(false),
                None => self.contains_by_iteration(container, item),
            },
            Value::LongRange(range) => match item.as_big() {
                Some(int) => Ok(range.position(&int).is_some()),
                None => self.contains_by_iteration(container, item),
            },
            Value::Bytes(_) | Value::ByteArray(_) => self.bytes_contain(container, item),
            Value::DictView(view) => match view.kind {
                crate::value::dict::ViewKind::Keys => {
                    Ok(self.dict_find(&view.dict, item)?.is_some())
                }
                crate::value::dict::ViewKind::Items => match &self.unwrap_builtin(item) {
                    Value::Tuple(pair) if pair.items().len() == 2 => {
                        match self.dict_get(&view.dict, &pair.items()[0])? {
                            Some(value) => self.equal(&value, &pair.items()[1]),
                            None => Ok(false),
                        }
                    }
                    _ => Ok(false),
                },
                _ => self.contains_by_iteration(container, item),
            },
            Value::Instance(instance) => {
                if let Some(Value::None) = instance.class.lookup(known::CONTAINS) {
                    let name = instance.class.name();
                    return Err(self.type_error(format!("'{name}' object is not a container")));
                }
                match self.special(container, known::CONTAINS, &mut [item.clone()])? {
                    Some(result) => self.truth(&result),
                    None => self.contains_by_iteration(container, item),
                }
            }
            Value::Class(class) if class.metaclass().is_some() => {
                match self.special(container, known::CONTAINS, &mut [item.clone()])? {
                    Some(result) => self.truth(&result),
                    None => self.contains_by_iteration(container, item),
                }
            }
            _ => self.contains_by_iteration(container, item),
        }
    }

    fn bytes_contain(&self, container: &Value, item: &Value) -> R<bool> {
        if let Some(part) = self.bytes_like(item) {
            let data = self.bytes_like(container).unwrap_or_default();
            return Ok(self.find_bytes(&data, &part)?.is_some());
        }
        if !self.has_index(item) {
            let name = self.core.types.name_of(item);
            return Err(self.type_error(format!("a bytes-like object is required, not '{name}'")));
        }
        let byte = u8::try_from(self.clamped_index(item)?);
        let byte = byte.map_err(|_| self.value_error("byte must be in range(0, 256)"))?;
        let data = self.bytes_like(container).unwrap_or_default();
        Ok(self.find_bytes(&data, &[byte])?.is_some())
    }

    fn text_contains(&self, text: &Str, part: &Str) -> R<bool> {
        let found = self.find_bytes(text.as_str().as_bytes(), part.as_str().as_bytes())?;
        Ok(found.is_some())
    }

    fn contains_by_iteration(&self, container: &Value, item: &Value) -> R<bool> {
        let iterator = match self.iter(container) {
            Ok(iterator) => iterator,
            Err(raised) if self.is_kind(&raised, crate::errors::ExceptionKind::TypeError) => {
                let name = self.core.types.name_of(container);
                return Err(self.type_error(format!("argument of type '{name}' is not iterable")));
            }
            Err(raised) => return Err(raised),
        };
        while let Some(other) = self.next_at_safepoint(&iterator)? {
            if self.equal(&other, item)? {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

fn equality(op: CompareOp, equal: bool) -> Option<bool> {
    match op {
        CompareOp::Eq => Some(equal),
        CompareOp::Ne => Some(!equal),
        _ => None,
    }
}

/// Comparison of numbers of any types; complex ones have no order. None if one is no number.
fn number_order(op: CompareOp, a: &Value, b: &Value) -> Option<bool> {
    if let (Value::Complex(_), _) | (_, Value::Complex(_)) = (a, b) {
        return equality(op, super::hash::numbers_equal(a, b)?);
    }
    let order = match (a, b) {
        (Value::Float(a), Value::Float(b)) => a.partial_cmp(b),
        (Value::Float(a), b) => int_float_order(&Int::of(b)?, *a).map(Ordering::reverse),
        (a, Value::Float(b)) => int_float_order(&Int::of(a)?, *b),
        _ => match (Int::of(a)?, Int::of(b)?) {
            (Int::Small(a), Int::Small(b)) => Some(a.cmp(&b)),
            (a, b) => Some(a.to_big().cmp(&b.to_big())),
        },
    };
    Some(by_order(op, order))
}

/// Whether one of two texts has surrogates, which lie elsewhere than where they are in the order of texts.
fn has_surrogates(a: &Str, b: &Str) -> bool {
    may_have_surrogates(a.as_str()) || may_have_surrogates(b.as_str())
}
