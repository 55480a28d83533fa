//! `try` with `except*`: each clause takes its part of an exception group.

use std::rc::Rc;

use super::handle::ExceptClause;
use crate::builtins::types::group::{GroupSplit, Matcher, is_group};
use crate::eval::code::Block;
use crate::eval::{Evaluator, Flow, Frame, StmtNode, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::value::exception::ExceptionState;
use crate::value::{Instance, R, Unwind, Value};

/// `try: … except* …: … else: …`
pub struct TryStar {
    /// What may raise.
    pub body: Block,
    /// The clauses in order; all have types.
    pub handlers: NodeList<ExceptClause>,
    /// What runs if nothing was raised.
    pub orelse: Block,
}

impl StmtNode for TryStar {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        match self.body.exec(ev, f) {
            Flow::Next => self.orelse.exec(ev, f),
            Flow::Raise(Unwind::Exception(exception)) => {
                let outer = ev.set_handled_exception(Some(exception.clone()));
                if let Some(outer) = &outer {
                    ev.chain(&Unwind::Exception(exception.clone()), outer);
                }
                let flow = self.handle(&exception, ev, f);
                ev.set_handled_exception(outer);
                flow
            }
            other => other,
        }
    }
}

impl TryStar {
    #[inline(never)]
    fn handle(&self, exception: &Rc<Instance>, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let mut rest = Some(exception.clone());
        let mut raised: Vec<Rc<Instance>> = Vec::new();
        for handler in &self.handlers {
            // The types are looked at also when nothing is left: a wrong one is an error in any case.
            let parts = match handler.exception.as_ref().map(|types| types.eval(ev, f)) {
                Some(types) => {
                    types.and_then(|types| parts(&rest, &types, ev).trace_at(ev, f, handler.span))
                }
                None => Ok((rest.clone(), None)),
            };
            let matched = match parts {
                Ok((matched, left)) => {
                    rest = left;
                    matched
                }
                Err(error) => {
                    ev.chain(&error, exception);
                    return Flow::Raise(error);
                }
            };
            let Some(matched) = matched else { continue };
            ev.set_handled_exception(Some(matched.clone()));
            let flow = handler.run(&matched, ev, f);
            ev.set_handled_exception(Some(exception.clone()));
            match flow {
                Flow::Next => {}
                Flow::Raise(Unwind::Exception(error)) => {
                    ev.chain(&Unwind::Exception(error.clone()), &matched);
                    raised.push(error);
                }
                other => return other,
            }
        }
        raised.extend(rest);
        match remaining(exception, raised, ev) {
            Ok(None) => Flow::Next,
            Ok(Some(error)) => Flow::Raise(Unwind::Exception(error)),
            Err(error) => Flow::Raise(error),
        }
    }
}

/// What a clause with these types takes of what is left, and what it leaves.
fn parts(left: &Option<Rc<Instance>>, types: &Value, ev: &Evaluator<'_>) -> R<GroupSplit> {
    let listed = match types {
        Value::Tuple(tuple) => tuple.items(),
        single => std::slice::from_ref(single),
    };
    for class in listed {
        if let Value::Class(class) = class
            && ev.is_group_class(class)
        {
            let text = "catching ExceptionGroup with except* is not allowed. Use except instead.";
            return Err(ev.type_error(text));
        }
        if !matches!(class, Value::Class(class) if class.base == crate::value::class::BuiltinBase::Exception)
        {
            let text = "catching classes that do not inherit from BaseException is not allowed";
            return Err(ev.type_error(text));
        }
    }
    let Some(left) = left else {
        return Ok((None, None));
    };
    if is_group(left) {
        return ev.split_group(left, Matcher::Types(types));
    }
    if ev.exception_matches(left, types)? {
        // A single exception is handed over as a group of one.
        let group = Value::tuple(vec![Value::Instance(left.clone())]);
        return Ok((Some(made_here(group, ev)?), None));
    }
    Ok((None, Some(left.clone())))
}

/// What is raised in the end: parts of the original that nobody took or that were raised again keep its shape; new
/// exceptions stand beside them in a group without a message.
fn remaining(
    original: &Rc<Instance>,
    raised: Vec<Rc<Instance>>,
    ev: &Evaluator<'_>,
) -> R<Option<Rc<Instance>>> {
    if !is_group(original) {
        // One clause at most has run.
        return Ok(raised.into_iter().next());
    }
    let (again, mut new): (Vec<_>, Vec<_>) = raised
        .into_iter()
        .partition(|exception| is_part(exception, original));
    if !again.is_empty() {
        let mut leaves = Vec::new();
        again.iter().for_each(|group| collect(group, &mut leaves));
        new.extend(ev.split_group(original, Matcher::Leaves(&leaves))?.0);
    }
    if new.len() > 1 {
        let members = new.into_iter().map(Value::Instance).collect();
        return made_here(Value::list(members), ev).map(Some);
    }
    Ok(new.pop())
}

/// A group without a message around some exceptions. It has come up nowhere, so it has no context.
fn made_here(members: Value, ev: &Evaluator<'_>) -> R<Rc<Instance>> {
    let group = ev.plain_group(members)?;
    if let Some(state) = group.exception() {
        state.settle_context();
    }
    Ok(group)
}

/// Whether an exception is the original or a part split off it that was not raised anew: it has come the same way.
fn is_part(exception: &Rc<Instance>, original: &Rc<Instance>) -> bool {
    let (Some(one), Some(other)) = (exception.exception(), original.exception()) else {
        return false;
    };
    let same = |a: &Value, b: &Value| a.is_unbound() && b.is_unbound() || a.is(b);
    let (way, other_way) = (one.traceback(), other.traceback());
    is_group(exception)
        && same(&one.context.borrow(), &other.context.borrow())
        && same(&one.cause.borrow(), &other.cause.borrow())
        && way.len() == other_way.len()
        && { way.iter().zip(&other_way) }
            .all(|(a, b)| Rc::ptr_eq(&a.code, &b.code) && a.span == b.span)
}

/// The exceptions of a group that are no groups. Groups nest as deep as a script has nested them, so a list of what
/// is still to be looked into takes the place of recursion.
fn collect(group: &Rc<Instance>, leaves: &mut Vec<Rc<Instance>>) {
    let mut open = vec![group.clone()];
    while let Some(exception) = open.pop() {
        if is_group(&exception) {
            open.extend(
                exception
                    .exception()
                    .map(ExceptionState::members)
                    .unwrap_or_default(),
            );
        } else {
            leaves.push(exception);
        }
    }
}
