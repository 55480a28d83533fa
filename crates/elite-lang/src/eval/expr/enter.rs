//! Entering script functions: arguments are evaluated straight into the variables of the called function.

use std::rc::Rc;

use super::call::CallArgs;
use super::keywords::call_with_keywords;
use super::operand::Operand;
use crate::eval::code::{CodeKind, Params};
use crate::eval::run::{StackSlots, make_cells};
use crate::eval::words::PairOf;
use crate::eval::{Evaluator, Frame, TraceExt};
use crate::value::held::assert_no_borrows;
use crate::value::{Function, R, Value};

/// How a function is entered with values by position: `first`, if it is not `Unbound`, comes before them.
pub type ValueEntry = fn(&Rc<Function>, PairOf<Value>, &mut [Value], &Evaluator<'_>) -> PairOf<R>;

/// How a function is entered from the place of a call: the receiver, if it is not `Unbound`, comes before the
/// arguments.
pub type CallEntry =
    fn(&Rc<Function>, PairOf<Value>, &CallArgs, &Evaluator<'_>, &mut Frame<'_>) -> PairOf<R>;

/// How functions of some code are entered.
#[derive(Clone, Copy)]
pub struct EntryPoints {
    /// The entry from the place of a call.
    pub call: CallEntry,
    /// The entry for a call with values.
    pub given: ValueEntry,
}

impl EntryPoints {
    /// The entry points of functions of that kind with so many variables.
    pub fn for_code(kind: CodeKind, params: &Params, slots: usize) -> Self {
        let (call, given): (CallEntry, ValueEntry) = match slots {
            0..=4 if params.is_starred() && kind == CodeKind::Plain => {
                (enter_starred::<4>, enter_with_any)
            }
            5..=8 if params.is_starred() && kind == CodeKind::Plain => {
                (enter_starred::<8>, enter_with_any)
            }
            _ if !params.is_simple() || kind != CodeKind::Plain => (enter_general, enter_with_any),
            0..=2 => (enter::<2>, enter_with::<2>),
            3..=4 => (enter::<4>, enter_with::<4>),
            5..=8 => (enter::<8>, enter_with::<8>),
            9..=16 => (enter::<16>, enter_with::<16>),
            _ => (enter_general, enter_with_any),
        };
        EntryPoints { call, given }
    }
}

/// Calls a script function, its receiver (if any) before the arguments.
#[inline(always)]
pub(super) fn call_script(
    function: &Rc<Function>,
    receiver: Option<Value>,
    site: &CallArgs,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> R {
    let receiver = PairOf::pack(receiver.unwrap_or_default());
    (function.code.entries.call)(function, receiver, site, ev, f).whole()
}

/// Any function with any arguments.
fn enter_general(
    function: &Rc<Function>,
    receiver: PairOf<Value>,
    site: &CallArgs,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> PairOf<R> {
    let receiver = Some(receiver.whole()).filter(|value| !value.is_unbound());
    let result = call_with_keywords(function, receiver, &site.args, &[], ev, f, site.span);
    PairOf::pack(result)
}

/// A function of at most `N` variables, which lie on the native stack, and no more values than it has parameters.
fn enter<const N: usize>(
    function: &Rc<Function>,
    receiver: PairOf<Value>,
    site: &CallArgs,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> PairOf<R> {
    let code = &*function.code;
    let receiver = receiver.whole();
    let first = usize::from(!receiver.is_unbound());
    let given = site.args.len() + first;
    if given > code.params.positional {
        return enter_general(function, PairOf::pack(receiver), site, ev, f);
    }
    let mut slots = StackSlots::<N>::empty();
    let places = slots.first(N);
    places[0].fill(receiver);
    if let Err(raised) = fill(&mut places[first..], &site.args, ev, f) {
        return PairOf::pack(Err(raised));
    }
    let all = given == code.params.positional;
    PairOf::pack(run_bound(function, places, all, ev).trace_at(ev, f, site.span))
}

/// Evaluates arguments into the places of their parameters.
#[inline(always)]
fn fill(places: &mut [Value], args: &[Operand], ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
    for (place, arg) in places.iter_mut().zip(args) {
        place.fill(arg.eval(ev, f)?);
    }
    Ok(())
}

/// Runs a function whose arguments are in their places, `all` of them or all but those that have defaults.
#[inline(always)]
fn run_bound(function: &Rc<Function>, places: &mut [Value], all: bool, ev: &Evaluator<'_>) -> R {
    if !all {
        ev.fill_defaults(function, places)?;
    }
    run_here(function, places, ev)
}

/// A function of at most `N` variables with `*args` after its positional parameters and nothing else.
fn enter_starred<const N: usize>(
    function: &Rc<Function>,
    receiver: PairOf<Value>,
    site: &CallArgs,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> PairOf<R> {
    let code = &*function.code;
    let positional = code.params.positional;
    let receiver = receiver.whole();
    let first = usize::from(!receiver.is_unbound());
    let (Some(star), true) = (code.params.star, first <= positional) else {
        return enter_general(function, PairOf::pack(receiver), site, ev, f);
    };
    let (own, others) = site.args.split_at(site.args.len().min(positional - first));
    let mut slots = StackSlots::<N>::empty();
    let places = slots.first(N);
    places[0].fill(receiver);
    if let Err(raised) = fill(&mut places[first..], own, ev, f) {
        return PairOf::pack(Err(raised));
    }
    match star_args(others, ev, f).whole() {
        Ok(rest) => places[star].put(rest),
        Err(raised) => return PairOf::pack(Err(raised)),
    }
    let all = own.len() + first == positional;
    PairOf::pack(run_bound(function, places, all, ev).trace_at(ev, f, site.span))
}

/// What `*args` is bound to.
fn star_args(args: &[Operand], ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<R> {
    let mut rest = || {
        Ok(match args {
            [] => ev.core.empty_tuple.clone(),
            [a, b] => Value::pair(a.eval(ev, f)?, b.eval(ev, f)?),
            [a, b, c] => Value::triple([a.eval(ev, f)?, b.eval(ev, f)?, c.eval(ev, f)?]),
            _ => {
                let mut rest = Vec::with_capacity(args.len());
                for arg in args {
                    rest.push(arg.eval(ev, f)?);
                }
                Value::tuple(rest)
            }
        })
    };
    PairOf::pack(rest())
}

/// Any function with values by position.
fn enter_with_any(
    function: &Rc<Function>,
    first: PairOf<Value>,
    args: &mut [Value],
    ev: &Evaluator<'_>,
) -> PairOf<R> {
    let first = first.whole();
    PairOf::pack(match first.is_unbound() {
        true => ev.call_bound(function, args, &[]),
        false => ev.with_first(first, args, |all| ev.call_bound(function, all, &[])),
    })
}

/// A function of at most `N` variables with no more values than it has parameters.
fn enter_with<const N: usize>(
    function: &Rc<Function>,
    first: PairOf<Value>,
    args: &mut [Value],
    ev: &Evaluator<'_>,
) -> PairOf<R> {
    let code = &*function.code;
    let first = first.whole();
    let before = usize::from(!first.is_unbound());
    let given = args.len() + before;
    if given > code.params.positional {
        return enter_with_any(function, PairOf::pack(first), args, ev);
    }
    let mut slots = StackSlots::<N>::empty();
    let places = slots.first(N);
    places[0].fill(first);
    for (place, arg) in places[before..].iter_mut().zip(args) {
        place.fill(std::mem::take(arg));
    }
    let all = given == code.params.positional;
    PairOf::pack(run_bound(function, places, all, ev))
}

/// Runs a plain function whose parameters are bound.
#[inline(always)]
fn run_here(function: &Rc<Function>, places: &mut [Value], ev: &Evaluator<'_>) -> R {
    let code = &*function.code;
    assert_no_borrows();
    let core = &*ev.core;
    let depth = core.depth.get();
    if depth >= core.limits.call_depth {
        return Err(ev.recursion_error());
    }
    ev.safepoint()?;
    if !code.cells.is_empty() {
        make_cells(code, places);
    }
    core.depth.set(depth + 1);
    let line = core.line.get();
    let result = if ev.stack_left() >= code.stack_bytes {
        let frame = &mut Frame {
            slots: places,
            function,
        };
        code.body.run(ev, frame)
    } else {
        ev.run_on_segment(function, places)
    };
    // The outermost function of a thread leaves the line in which it ended.
    if depth > 0 {
        core.line.set(line);
    }
    core.depth.set(depth);
    result
}
