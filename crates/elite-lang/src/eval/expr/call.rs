//! Calls. Script functions with plain positional arguments get them evaluated straight into their slots.

use std::rc::Rc;

use elite_syntax::Span;

use super::enter::call_script;
use super::operand::Operand;
use crate::builtins::{Builtin, BuiltinBody, FastPath};
use crate::eval::run::{StackSlots, with_slots};
use crate::eval::{Evaluator, ExprNode, Frame, TraceExt};
use crate::limits::deferred_drop::NodeList;
use crate::value::class::ConstructPath;
use crate::value::instance::InstancePayload;
use crate::value::{Class, Function, Instance, R, Value};

/// `function(a, b)` without stars and keywords.
pub struct Call {
    /// What is called.
    pub function: Operand,
    /// The arguments.
    pub site: CallArgs,
}

/// The arguments of a call without stars and keywords.
pub struct CallArgs {
    /// By position.
    pub args: NodeList<Operand>,
    /// All arguments can be looked at without evaluating anything, some after copying them.
    is_readable: bool,
    /// Where the call is written.
    pub span: Span,
}

impl CallArgs {
    /// A call with these arguments.
    pub fn new(args: NodeList<Operand>, span: Span) -> Self {
        let is_expr = |arg: &Operand| matches!(arg, Operand::Expr(_));
        let is_bound = |arg: &Operand| matches!(arg, Operand::Local(_) | Operand::Const(_));
        CallArgs {
            is_readable: !args.iter().any(is_expr) && !args.iter().all(is_bound),
            args,
            span,
        }
    }
}

/// What the callee of a call turns out to be.
enum Callee {
    Script(Rc<Function>),
    Quick(FastPath),
    Other,
}

impl ExprNode for Call {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        // SAFETY: a function is copied, which counts a reference, or a builtin is asked what it answers with.
        #[allow(unsafe_code)]
        let callee = unsafe { self.function.value_ref(f) }.map(|callee| match callee {
            Value::Function(function) => Callee::Script(function.clone()),
            other => Builtin::quick_of(other).map_or(Callee::Other, Callee::Quick),
        });
        match callee {
            Some(Callee::Script(function)) => {
                return call_script(&function, None, &self.site, ev, f);
            }
            Some(Callee::Quick(quick)) => {
                if let Some(answer) = call_fast_path(quick, None, &self.site, ev, f) {
                    return Ok(answer);
                }
            }
            Some(Callee::Other) | None => {}
        }
        self.call_generally(ev, f)
    }
}

impl Call {
    #[inline(never)]
    fn call_generally(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = self.function.eval(ev, f)?;
        match &callee {
            Value::Function(function) => call_script(function, None, &self.site, ev, f),
            Value::Class(class) => make_instance(class, &self.site, ev, f),
            Value::Builtin(builtin) => call_native(builtin, None, &self.site, ev, f),
            Value::BoundMethod(method) => match &method.function {
                Value::Function(function) => {
                    let receiver = Some(method.receiver.clone());
                    call_script(function, receiver, &self.site, ev, f)
                }
                Value::Builtin(builtin) => {
                    let receiver = Some(method.receiver.clone());
                    call_native(builtin, receiver, &self.site, ev, f)
                }
                _ => call_other(&callee, &self.site.args, ev, f, self.site.span),
            },
            _ => call_other(&callee, &self.site.args, ev, f, self.site.span),
        }
    }
}

/// The answer to a call whose arguments are variables of the frame and constants, which are looked at where they lie,
/// or other variables, attributes and items, of which there are copies.
#[inline(always)]
pub(super) fn call_fast_path(
    quick: FastPath,
    receiver: Option<&Value>,
    site: &CallArgs,
    ev: &Evaluator<'_>,
    f: &Frame<'_>,
) -> Option<Value> {
    if site.is_readable {
        return call_fast_path_cloned(quick, receiver, &site.args, ev, f);
    }
    match (receiver, &*site.args) {
        (None, [a]) => quick.ask(ev, &[a.bound_ref(f)?]),
        (None, [a, b]) => quick.ask(ev, &[a.bound_ref(f)?, b.bound_ref(f)?]),
        (Some(receiver), []) => quick.ask(ev, &[receiver]),
        (Some(receiver), [a]) => quick.ask(ev, &[receiver, a.bound_ref(f)?]),
        (Some(receiver), [a, b]) => quick.ask(ev, &[receiver, a.bound_ref(f)?, b.bound_ref(f)?]),
        _ => None,
    }
}

#[inline(never)]
fn call_fast_path_cloned(
    quick: FastPath,
    receiver: Option<&Value>,
    args: &[Operand],
    ev: &Evaluator<'_>,
    f: &Frame<'_>,
) -> Option<Value> {
    match (receiver, args) {
        (None, [a]) => quick.ask(ev, &[&a.try_clone(f)?]),
        (None, [a, b]) => quick.ask(ev, &[&a.try_clone(f)?, &b.try_clone(f)?]),
        (Some(receiver), [a]) => quick.ask(ev, &[receiver, &a.try_clone(f)?]),
        (Some(receiver), [a, b]) => quick.ask(ev, &[receiver, &a.try_clone(f)?, &b.try_clone(f)?]),
        _ => None,
    }
}

/// Calls a function written in Rust, its receiver (if any) before the arguments.
#[inline]
pub(super) fn call_native(
    builtin: &Rc<Builtin>,
    receiver: Option<Value>,
    site: &CallArgs,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> R {
    let given = site.args.len() + usize::from(receiver.is_some());
    match builtin.signature.len().max(given) {
        0..=2 => run_native::<2>(builtin, receiver, site, ev, f),
        3..=4 => run_native::<4>(builtin, receiver, site, ev, f),
        5..=8 => run_native::<8>(builtin, receiver, site, ev, f),
        _ => {
            let args = receiver.into_iter().map(Ok);
            let mut args: Vec<Value> = args
                .chain(site.args.iter().map(|arg| arg.eval(ev, f)))
                .collect::<R<_>>()?;
            ev.check_receiver(builtin, &args)
                .trace_at(ev, f, site.span)?;
            let result = ev.call_builtin(builtin, &mut args, &[], Some(&mut *f));
            result.trace_at(ev, f, site.span)
        }
    }
}

/// Calls a function written in Rust that takes and is given at most `N` arguments: they are evaluated straight into the
/// places it wants them in.
#[inline(never)]
fn run_native<const N: usize>(
    builtin: &Rc<Builtin>,
    receiver: Option<Value>,
    site: &CallArgs,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
) -> R {
    let mut slots = StackSlots::<N>::empty();
    let slots = slots.first(N);
    let first = usize::from(receiver.is_some());
    let given = site.args.len() + first;
    let is_unbound = receiver.is_none();
    if let Some(receiver) = receiver {
        slots[0].fill(receiver);
    }
    for (slot, arg) in slots[first..].iter_mut().zip(&site.args) {
        slot.fill(arg.eval(ev, f)?);
    }
    if is_unbound {
        ev.check_receiver(builtin, &slots[..given])
            .trace_at(ev, f, site.span)?;
    }
    if let Some(quick) = builtin.fast_path
        && let Some(answer) = answer_to(quick, &slots[..given], ev)
    {
        return Ok(answer);
    }
    let result = match &builtin.body {
        BuiltinBody::Bound(body) if builtin.signature.accepts(given) => {
            let slots = &mut slots[..builtin.signature.len()];
            ev.gc_track_receiver(builtin, slots);
            body(ev, slots)
        }
        _ => ev.call_builtin(builtin, &mut slots[..given], &[], Some(&mut *f)),
    };
    result.trace_at(ev, f, site.span)
}

/// The answer to a call with arguments that have been evaluated.
#[inline(always)]
fn answer_to(quick: FastPath, args: &[Value], ev: &Evaluator<'_>) -> Option<Value> {
    match args {
        [a] => quick.ask(ev, &[a]),
        [a, b] => quick.ask(ev, &[a, b]),
        [a, b, c] => quick.ask(ev, &[a, b, c]),
        _ => None,
    }
}

/// Calls anything with arguments that are evaluated into a buffer.
#[inline(never)]
pub(super) fn call_other(
    callee: &Value,
    args: &[Operand],
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    span: Span,
) -> R {
    with_args(args, ev, f, |ev, f, args| {
        ev.call_from(callee, args, &[], Some(&mut *f))
            .trace_at(ev, f, span)
    })
}

/// Calls a class: a plain object gets the arguments evaluated straight into the slots of its `__init__`.
#[inline(never)]
fn make_instance(class: &Rc<Class>, site: &CallArgs, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
    let (args, span) = (&*site.args, site.span);
    let version = class.version();
    let init = match class.construct_path() {
        ConstructPath::NoInit if args.is_empty() => {
            return Ok(Value::Instance(Instance::new(
                class.clone(),
                InstancePayload::None,
            )));
        }
        ConstructPath::Init(location) => class.at(location),
        ConstructPath::Native => {
            if let Value::Builtin(constructor) = class.constructor.get() {
                return call_native(&constructor, None, site, ev, f);
            }
            Value::Unbound
        }
        _ => Value::Unbound,
    };
    let Value::Function(init) = &init else {
        return call_other(&Value::Class(class.clone()), args, ev, f, span);
    };
    let (params, given) = (&init.code.params, args.len() + 1);
    if !params.is_simple() || given > params.positional {
        return call_other(&Value::Class(class.clone()), args, ev, f, span);
    }
    with_slots(init.code.slots, |slots| {
        for (slot, arg) in slots[1..given].iter_mut().zip(args) {
            slot.fill(arg.eval(ev, f)?);
        }
        if class.version() != version {
            // An argument has changed the class.
            let result = ev.instantiate(class, &mut slots[1..given], &[], Some(&mut *f));
            return result.trace_at(ev, f, span);
        }
        let object = Instance::new(class.clone(), InstancePayload::None);
        slots[0].fill(Value::Instance(object.clone()));
        if given < params.positional {
            ev.fill_defaults(init, slots).trace_at(ev, f, span)?;
        }
        let result = ev.run(init, slots).trace_at(ev, f, span)?;
        if !result.is_none() {
            return Err(ev.init_result_error(&result)).trace_at(ev, f, span);
        }
        Ok(Value::Instance(object))
    })
}

/// Evaluates arguments into a buffer and runs `inner` with them.
#[inline]
pub(super) fn with_args(
    args: &[Operand],
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    inner: impl FnOnce(&Evaluator<'_>, &mut Frame<'_>, &mut [Value]) -> R,
) -> R {
    match args {
        [] => inner(ev, f, &mut []),
        [a] => {
            let a = a.eval(ev, f)?;
            inner(ev, f, &mut [a])
        }
        [a, b] => {
            let a = a.eval(ev, f)?;
            let b = b.eval(ev, f)?;
            inner(ev, f, &mut [a, b])
        }
        _ => {
            let mut values = Vec::with_capacity(args.len());
            for arg in args {
                values.push(arg.eval(ev, f)?);
            }
            inner(ev, f, &mut values)
        }
    }
}
