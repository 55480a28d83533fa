//! Iterators that may run script code while they step: `map`, `filter`, `zip`, `enumerate`, items by number, calls
//! until a sentinel. A `StopIteration` of what they ask goes through them with its value.

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::{Iter, R, ScriptCell, Value};

impl Evaluator<'_> {
    #[inline]
    pub(super) fn pair_or_end(&self, iter: &Iter) -> R<Option<(Value, Value)>> {
        let pair = self.deeper(|| self.next_pair_lazily(iter));
        pair.or_else(|raised| self.at_end(raised))
    }

    /// An item with its number, which may be of any size.
    pub(super) fn number_far(
        &self,
        count: &ScriptCell<Value>,
        item: Value,
    ) -> R<Option<(Value, Value)>> {
        let number = count.get();
        let following = match number {
            Value::Int(number) if number < i64::MAX => Value::Int(number + 1),
            _ => self.binary(elite_syntax::ast::BinaryOp::Add, &number, &Value::Int(1))?,
        };
        count.put(following);
        Ok(Some((number, item)))
    }

    /// The pairs of `enumerate` and of `zip` with two sources.
    fn next_pair_lazily(&self, iter: &Iter) -> R<Option<(Value, Value)>> {
        match iter {
            Iter::Enumerate { source, count } => {
                let Some(value) = self.next_with_end(source)? else {
                    return Ok(None);
                };
                self.number_far(count, value)
            }
            Iter::Zip { sources, .. } => {
                let [first, second] = &sources[..] else {
                    return Ok(None);
                };
                let Some(first) = self.next_with_end(first)? else {
                    return Ok(None);
                };
                Ok(self.next_with_end(second)?.map(|second| (first, second)))
            }
            _ => Ok(None),
        }
    }

    /// Iterators that may run script code.
    pub(super) fn next_lazy(&self, iter: &Iter) -> R<Option<Value>> {
        match iter {
            Iter::ListReversed { list, index } => {
                let at = index.get();
                if at == 0 {
                    return Ok(None);
                }
                let item = list.get(at - 1);
                index.set(if item.is_some() { at - 1 } else { 0 });
                Ok(item)
            }
            Iter::Sequence {
                object,
                index,
                reversed,
                done,
            } => {
                let at = index.get();
                if done.get() || (*reversed && at < 0) {
                    return Ok(None);
                }
                match self.item(object, &Value::Int(at)) {
                    Ok(value) => {
                        index.set(if *reversed { at - 1 } else { at + 1 });
                        Ok(Some(value))
                    }
                    Err(raised) => {
                        done.set(true);
                        let ends = self.is_kind(&raised, ExceptionKind::IndexError)
                            || self.is_kind(&raised, ExceptionKind::StopIteration);
                        if ends { Ok(None) } else { Err(raised) }
                    }
                }
            }
            Iter::Callable {
                function,
                sentinel,
                done,
            } => {
                if done.get() {
                    return Ok(None);
                }
                let value = match self.call(function, &mut [], &[]) {
                    Err(raised) => {
                        let ended = self.at_end(raised)?;
                        done.set(true);
                        return Ok(ended);
                    }
                    Ok(value) => value,
                };
                if self.equal(&value, sentinel)? {
                    done.set(true);
                    return Ok(None);
                }
                Ok(Some(value))
            }
            Iter::Map { function, sources } => {
                let mut args = Vec::with_capacity(sources.len());
                for source in sources {
                    match self.next_with_end(source)? {
                        Some(value) => args.push(value),
                        None => return Ok(None),
                    }
                }
                self.call(function, &mut args, &[]).map(Some)
            }
            Iter::Filter { function, source } => {
                while let Some(value) = self.next_with_end(source)? {
                    let keep = if function.is_none() {
                        self.truth(&value)?
                    } else {
                        let verdict = self.call1(function, value.clone())?;
                        self.truth(&verdict)?
                    };
                    if keep {
                        return Ok(Some(value));
                    }
                    self.safepoint()?;
                }
                Ok(None)
            }
            Iter::Zip {
                sources,
                strict: false,
            } if sources.len() == 2 => {
                let pair = self.next_pair_lazily(iter)?;
                Ok(pair.map(|(first, second)| Value::pair(first, second)))
            }
            Iter::Zip { sources, strict } => self.next_zip(sources, *strict),
            Iter::Enumerate { .. } => {
                let pair = self.next_pair_lazily(iter)?;
                Ok(pair.map(|(number, value)| Value::pair(number, value)))
            }
            Iter::Native(native) => native.steps.next(self),
            // Iterators of all other kinds are stepped by `next_of`.
            _ => Ok(None),
        }
    }

    fn next_zip(&self, sources: &[Value], strict: bool) -> R<Option<Value>> {
        let mut items = Vec::with_capacity(sources.len());
        for source in sources {
            let next = match strict {
                true => self.next(source)?,
                false => self.next_with_end(source)?,
            };
            match next {
                Some(value) => items.push(value),
                None if strict => return self.check_zip_lengths(sources, items.len()),
                None => return Ok(None),
            }
        }
        Ok((!sources.is_empty()).then(|| Value::tuple(items)))
    }

    /// `zip(strict=True)`: argument `ended` has ended; if it is the first, all others must have ended too.
    fn check_zip_lengths(&self, sources: &[Value], ended: usize) -> R<Option<Value>> {
        let before = |index: usize| match index {
            1 => "argument 1".to_owned(),
            _ => format!("arguments 1-{index}"),
        };
        if ended > 0 {
            let text = format!(
                "zip() argument {} is shorter than {}",
                ended + 1,
                before(ended)
            );
            return Err(self.value_error(text));
        }
        for (index, source) in sources.iter().enumerate().skip(1) {
            if self.next_with_end(source)?.is_some() {
                let text = format!(
                    "zip() argument {} is longer than {}",
                    index + 1,
                    before(index)
                );
                return Err(self.value_error(text));
            }
        }
        Ok(None)
    }
}
