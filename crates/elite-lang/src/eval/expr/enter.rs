//! Entering script functions: arguments are evaluated straight into the variables of the called function.

use std::rc::Rc;

use super::call::Site;
use super::keywords::call_with_keywords;
use crate::eval::code::{CodeKind, Params};
use crate::eval::run::{Slots, make_cells};
use crate::eval::words::Words;
use crate::eval::{Evaluator, Frame, Located};
use crate::value::held::nothing_is_open;
use crate::value::{Function, R, Value};

/// How a function is entered from the place of a call: the receiver, if it is not `Unbound`, comes before the arguments.
pub type Entry = fn(&Rc<Function>, Words<Value>, &Site, &Evaluator<'_>, &mut Frame<'_>) -> Words<R>;

/// The entry of functions of that kind with so many variables.
pub fn entry_of(kind: CodeKind, params: &Params, slots: usize) -> Entry {
    if !params.is_simple() || kind != CodeKind::Plain {
        return enter_generally;
    }
    match slots {
        0..=2 => enter::<2>,
        3..=4 => enter::<4>,
        5..=8 => enter::<8>,
        9..=16 => enter::<16>,
        _ => enter_generally,
    }
}

/// Calls a script function, its receiver (if any) before the arguments.
#[inline(always)]
pub(super) fn call_script(
    function: &Rc<Function>,
    receiver: Option<Value>,
    site: &Site,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> R {
    let receiver = Words::of(receiver.unwrap_or_default());
    (function.code.entry)(function, receiver, site, ev, f).whole()
}

/// Any function with any arguments.
fn enter_generally(
    function: &Rc<Function>,
    receiver: Words<Value>,
    site: &Site,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> Words<R> {
    let receiver = Some(receiver.whole()).filter(|value| !value.is_unbound());
    let result = call_with_keywords(function, receiver, &site.args, &[], ev, f, site.span);
    Words::of(result)
}

/// A function of at most `N` variables, which lie on the native stack, and a value for each of its parameters.
fn enter<const N: usize>(
    function: &Rc<Function>,
    receiver: Words<Value>,
    site: &Site,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> Words<R> {
    let code = &*function.code;
    let receiver = receiver.whole();
    let first = usize::from(!receiver.is_unbound());
    if site.args.len() + first != code.params.positional {
        return enter_generally(function, Words::of(receiver), site, ev, f);
    }
    let mut slots = Slots::<N>::empty();
    let places = slots.first(N);
    places[0].fill(receiver);
    for (place, arg) in places[first..].iter_mut().zip(&site.args) {
        match arg.eval(ev, f) {
            Ok(value) => place.fill(value),
            Err(raised) => return Words::of(Err(raised)),
        }
    }
    nothing_is_open();
    let core = &*ev.core;
    let depth = core.depth.get();
    if depth >= core.limits.call_depth {
        return Words::of(Err(ev.recursion_error()).at(ev, f, site.span));
    }
    if let Err(raised) = ev.safepoint() {
        return Words::of(Err(raised).at(ev, f, site.span));
    }
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
        ev.run_deeper(function, places)
    };
    core.line.set(line);
    core.depth.set(depth);
    Words::of(result.at(ev, f, site.span))
}
