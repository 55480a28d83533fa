//! Calls with keywords and calls of functions that take more than plain positional parameters: if the arguments fit,
//! they are evaluated straight into the slots of the function.

use std::rc::Rc;

use elite_syntax::Span;
use smallvec::SmallVec;

use super::operand::Operand;
use crate::eval::code::Params;
use crate::eval::run::with_slots;
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::value::{Dict, Function, R, Symbol, Value};

/// `function(a, b, name=c)` without stars.
pub struct CallKeywords {
    /// What is called.
    pub function: BoxExpr,
    /// What is given by position.
    pub args: NodeList<Operand>,
    /// What is given by name.
    pub keywords: NodeList<(Symbol, Operand)>,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for CallKeywords {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = self.function.eval(ev, f)?;
        let (function, receiver) = match &callee {
            Value::BoundMethod(method) => (&method.function, Some(&method.receiver)),
            other => (other, None),
        };
        if let Value::Function(function) = function {
            let (args, keywords) = (&self.args, &self.keywords);
            return call_with_keywords(
                function,
                receiver.cloned(),
                args,
                keywords,
                ev,
                f,
                self.span,
            );
        }
        let (mut args, keywords) = gather(None, &self.args, &self.keywords, ev, f)?;
        ev.call_from(&callee, &mut args, &keywords, Some(&mut *f))
            .trace_at(ev, f, self.span)
    }
}

/// Arguments by position and by name.
type Arguments = (Vec<Value>, Vec<(Symbol, Value)>);

/// Evaluates arguments in the order of the text.
fn gather(
    receiver: Option<Value>,
    args: &[Operand],
    keywords: &[(Symbol, Operand)],
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> R<Arguments> {
    let mut positional = Vec::with_capacity(args.len() + 1);
    positional.extend(receiver);
    for arg in args {
        positional.push(arg.eval(ev, f)?);
    }
    let mut named = Vec::with_capacity(keywords.len());
    for (name, value) in keywords {
        named.push((*name, value.eval(ev, f)?));
    }
    Ok((positional, named))
}

/// Calls a script function of any kind, its receiver (if any) before the arguments.
#[inline(never)]
pub(super) fn call_with_keywords(
    function: &Rc<Function>,
    receiver: Option<Value>,
    args: &[Operand],
    keywords: &[(Symbol, Operand)],
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    span: Span,
) -> R {
    let params = &function.code.params;
    let first = usize::from(receiver.is_some());
    let given = args.len() + first;
    if !fit(params, given, keywords) {
        let (mut args, keywords) = gather(receiver, args, keywords, ev, f)?;
        return ev
            .call_function(function, &mut args, &keywords)
            .trace_at(ev, f, span);
    }
    with_slots(function.code.slots, |slots| {
        let mut more = ExtraArgs::new();
        let mut place = |index: usize, value: Value, slots: &mut [Value]| match params.positional {
            count if index < count => slots[index].put(value),
            _ => more.push(value),
        };
        if let Some(receiver) = receiver {
            place(0, receiver, slots);
        }
        for (index, arg) in (first..).zip(args) {
            place(index, arg.eval(ev, f)?, slots);
        }
        let others = params.double_star.map(|slot| {
            let is_other = |(name, _): &&(Symbol, Operand)| params.by_name(*name).is_none();
            (
                slot,
                Dict::with_room(keywords.iter().filter(is_other).count()),
            )
        });
        for (name, value) in keywords {
            let value = value.eval(ev, f)?;
            match (params.by_name(*name), &others) {
                (Some(index), _) => slots[index].put(value),
                (None, Some((_, dict))) => {
                    let name = ev.core.symbols.to_value(*name);
                    // No name is given twice.
                    if let Value::Str(text) = &name {
                        dict.append(text.hash(), name.clone(), value);
                    }
                }
                (None, None) => {}
            }
        }
        if let Some(star) = params.star {
            slots[star].put(rest(more, ev));
        }
        if let Some((slot, dict)) = others {
            slots[slot].put(Value::Dict(Rc::new(dict)));
        }
        ev.fill_defaults(function, slots).trace_at(ev, f, span)?;
        ev.run(function, slots).trace_at(ev, f, span)
    })
}

/// Arguments beyond the positional parameters.
type ExtraArgs = SmallVec<[Value; 4]>;

/// What `*args` is bound to.
fn rest(mut more: ExtraArgs, ev: &Evaluator<'_>) -> Value {
    match &mut more[..] {
        [] => ev.core.empty_tuple.clone(),
        [a, b] => Value::pair(std::mem::take(a), std::mem::take(b)),
        [a, b, c] => Value::triple([a, b, c].map(std::mem::take)),
        _ => Value::tuple(more.into_vec()),
    }
}

/// Whether every argument has a parameter of its own; defaults aside, binding them cannot fail then.
#[inline]
fn fit(params: &Params, given: usize, keywords: &[(Symbol, Operand)]) -> bool {
    (given <= params.positional || params.star.is_some())
        && keywords
            .iter()
            .all(|(name, _)| match params.by_name(*name) {
                Some(index) => index >= given.min(params.positional),
                None => params.double_star.is_some(),
            })
}
