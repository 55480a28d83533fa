//! Calls. Script functions with plain positional arguments get them evaluated straight into their slots.

use std::rc::Rc;

use super::attribute::{Cache, Hint};
use crate::errors::ExceptionKind;
use crate::eval::run::with_slots;
use crate::eval::{Evaluator, Expr, Expression, Frame, Located};
use crate::source::Span;
use crate::value::symbol::known;
use crate::value::{Dict, Function, R, Symbol, Value};

/// `function(a, b)` without stars and keywords.
pub struct Call {
    /// What is called.
    pub function: Expr,
    /// With what.
    pub args: Box<[Expr]>,
    /// Where it is written.
    pub span: Span,
}

impl Expression for Call {
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = self.function.eval(ev, f)?;
        match &callee {
            Value::Function(function) => call_script(function, None, &self.args, ev, f, self.span),
            _ => with_args(&self.args, ev, f, |ev, f, args| {
                ev.call_from(&callee, args, &[], Some(&mut *f))
                    .at(ev, f, self.span)
            }),
        }
    }
}

/// Evaluates arguments into a buffer and runs `inner` with them.
#[inline]
fn with_args(
    args: &[Expr],
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

/// Calls a script function, its receiver (if any) before the arguments.
#[inline]
fn call_script(
    function: &Rc<Function>,
    receiver: Option<Value>,
    args: &[Expr],
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    span: Span,
) -> R {
    let params = &function.code.params;
    let first = usize::from(receiver.is_some());
    let given = args.len() + first;
    if !params.is_simple() || given > params.positional {
        return call_bound(function, receiver, args, ev, f, span);
    }
    with_slots(function.code.slots, |slots| {
        if let Some(receiver) = receiver {
            slots[0] = receiver;
        }
        for (slot, arg) in slots[first..given].iter_mut().zip(args) {
            *slot = arg.eval(ev, f)?;
        }
        if given < params.positional {
            ev.fill_defaults(function, slots).at(ev, f, span)?;
        }
        ev.run(function, slots).at(ev, f, span)
    })
}

/// Calls a script function whose arguments need binding.
#[inline(never)]
fn call_bound(
    function: &Rc<Function>,
    receiver: Option<Value>,
    args: &[Expr],
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    span: Span,
) -> R {
    let mut values: Vec<Value> = Vec::with_capacity(args.len() + 1);
    values.extend(receiver);
    for arg in args {
        values.push(arg.eval(ev, f)?);
    }
    ev.call_function(function, &mut values, &[]).at(ev, f, span)
}

/// `receiver.name(a, b)` without stars and keywords: no bound method is made.
pub struct CallMethod {
    /// The object before the dot.
    pub receiver: Expr,
    /// The method.
    pub name: Symbol,
    /// With what.
    pub args: Box<[Expr]>,
    /// Where the attribute is written.
    pub attribute_span: Span,
    /// Where the call is written.
    pub span: Span,
    /// What is known about the method.
    pub cache: Cache,
}

impl Expression for CallMethod {
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let receiver = self.receiver.eval(ev, f)?;
        let by_class = !matches!(
            receiver,
            Value::Class(_) | Value::Module(_) | Value::Super(_) | Value::Function(_)
        );
        if by_class {
            let class = ev.core.types.of(&receiver);
            let hint = self
                .cache
                .get(class.version())
                .or_else(|| self.cache.learn(class, self.name));
            if let Some(Hint::Method(location)) = hint {
                return match class.at(location) {
                    Value::Function(function) => {
                        call_script(&function, Some(receiver), &self.args, ev, f, self.span)
                    }
                    Value::Builtin(builtin) => self.call_builtin(&builtin, receiver, ev, f),
                    // The hint says what it is; anything else goes the general way.
                    _ => self.call_generally(&receiver, ev, f),
                };
            }
        }
        self.call_generally(&receiver, ev, f)
    }
}

impl CallMethod {
    #[inline]
    fn call_builtin(
        &self,
        builtin: &Rc<crate::builtins::Builtin>,
        receiver: Value,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> R {
        match &*self.args {
            [] => ev
                .call_builtin(builtin, &mut [receiver], &[], Some(&mut *f))
                .at(ev, f, self.span),
            [a] => {
                let a = a.eval(ev, f)?;
                ev.call_builtin(builtin, &mut [receiver, a], &[], Some(&mut *f))
                    .at(ev, f, self.span)
            }
            args => {
                let mut values = Vec::with_capacity(args.len() + 1);
                values.push(receiver);
                for arg in args {
                    values.push(arg.eval(ev, f)?);
                }
                ev.call_builtin(builtin, &mut values, &[], Some(&mut *f))
                    .at(ev, f, self.span)
            }
        }
    }

    #[inline(never)]
    fn call_generally(&self, receiver: &Value, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = ev
            .attribute(receiver, self.name)
            .at(ev, f, self.attribute_span)?;
        match &callee {
            Value::Function(function) => call_script(function, None, &self.args, ev, f, self.span),
            Value::BoundMethod(method) => match &method.function {
                Value::Function(function) => call_script(
                    function,
                    Some(method.receiver.clone()),
                    &self.args,
                    ev,
                    f,
                    self.span,
                ),
                _ => with_args(&self.args, ev, f, |ev, f, args| {
                    ev.call_from(&callee, args, &[], Some(&mut *f))
                        .at(ev, f, self.span)
                }),
            },
            _ => with_args(&self.args, ev, f, |ev, f, args| {
                ev.call_from(&callee, args, &[], Some(&mut *f))
                    .at(ev, f, self.span)
            }),
        }
    }
}

/// An argument of a call with stars or keywords.
pub enum CallArg {
    /// By position.
    Positional(Expr),
    /// `*iterable`
    Star(Expr),
    /// By name.
    Keyword(Symbol, Expr),
    /// `**mapping`
    DoubleStar(Expr),
}

/// A call with stars or keywords.
pub struct CallWith {
    /// What is called.
    pub function: Expr,
    /// With what, in the order of the text.
    pub args: Box<[CallArg]>,
    /// Where it is written.
    pub span: Span,
}

impl Expression for CallWith {
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = self.function.eval(ev, f)?;
        let mut positional = Vec::with_capacity(self.args.len());
        let mut keywords = Vec::new();
        gather(
            &self.args,
            &callee,
            ev,
            f,
            self.span,
            &mut positional,
            &mut keywords,
        )?;
        ev.call_from(&callee, &mut positional, &keywords, Some(&mut *f))
            .at(ev, f, self.span)
    }
}

/// Evaluates arguments with stars and keywords. `callee` is only for messages.
pub fn gather(
    args: &[CallArg],
    callee: &Value,
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    span: Span,
    positional: &mut Vec<Value>,
    keywords: &mut Vec<(Symbol, Value)>,
) -> R<()> {
    let single = args
        .iter()
        .filter(|arg| matches!(arg, CallArg::Positional(_) | CallArg::Star(_)))
        .count()
        == 1;
    for arg in args {
        match arg {
            CallArg::Positional(expr) => positional.push(expr.eval(ev, f)?),
            CallArg::Star(expr) => {
                let iterable = expr.eval(ev, f)?;
                let items = ev.collect(&iterable).map_err(|raised| {
                    let raised = ev.not_unpackable(raised, &iterable);
                    let plain = !matches!(iterable, Value::Instance(_));
                    if single && plain && ev.is_kind(&raised, ExceptionKind::TypeError) {
                        let (label, name) =
                            (ev.callee_label(callee), ev.core.types.name_of(&iterable));
                        return ev.type_error(format!(
                            "{label} argument after * must be an iterable, not {name}"
                        ));
                    }
                    raised
                });
                positional.extend(items.at(ev, f, span)?);
            }
            CallArg::Keyword(name, expr) => {
                let value = expr.eval(ev, f)?;
                add_keyword(*name, value, callee, ev, keywords).at(ev, f, span)?;
            }
            CallArg::DoubleStar(expr) => {
                let mapping = expr.eval(ev, f)?;
                gather_mapping(&mapping, callee, ev, keywords).at(ev, f, span)?;
            }
        }
    }
    Ok(())
}

fn gather_mapping(
    mapping: &Value,
    callee: &Value,
    ev: &Evaluator<'_>,
    keywords: &mut Vec<(Symbol, Value)>,
) -> R<()> {
    let dict = Dict::new();
    ev.update_from_mapping(&dict, mapping).map_err(|raised| {
        let no_mapping = match mapping {
            Value::Instance(instance) => {
                instance.extended().is_none() && instance.class.lookup(known::KEYS).is_none()
            }
            _ => true,
        };
        if ev.is_kind(&raised, ExceptionKind::TypeError) && no_mapping {
            let (label, name) = (ev.callee_label(callee), ev.core.types.name_of(mapping));
            return ev.type_error(format!(
                "{label} argument after ** must be a mapping, not {name}"
            ));
        }
        raised
    })?;
    for (_, key, value) in dict.entries() {
        let Value::Str(text) = ev.plain(&key) else {
            return Err(ev.type_error("keywords must be strings"));
        };
        add_keyword(
            ev.core.symbols.intern(text.as_str()),
            value,
            callee,
            ev,
            keywords,
        )?;
    }
    Ok(())
}

fn add_keyword(
    name: Symbol,
    value: Value,
    callee: &Value,
    ev: &Evaluator<'_>,
    keywords: &mut Vec<(Symbol, Value)>,
) -> R<()> {
    if keywords.iter().any(|(other, _)| *other == name) {
        let (label, name) = (ev.callee_label(callee), ev.core.symbols.name(name));
        return Err(ev.type_error(format!(
            "{label} got multiple values for keyword argument '{name}'"
        )));
    }
    keywords.push((name, value));
    Ok(())
}

impl Evaluator<'_> {
    /// How messages about a call name what is called.
    fn callee_label(&self, callee: &Value) -> String {
        match callee {
            Value::Function(function) => format!("__main__.{}()", function.code.qualname),
            Value::Builtin(builtin) => format!("{}()", builtin.full_label()),
            Value::BoundMethod(method) => self.callee_label(&method.function),
            Value::Class(class) if class.is_script => {
                format!("__main__.{}()", self.qualname_of(class))
            }
            Value::Class(class) => format!("{}()", class.name()),
            other => format!("{} object", self.core.types.name_of(other)),
        }
    }
}

/// `super()` without arguments: the class the method is written in, and the method's first argument.
pub struct SuperCall {
    /// The name `super`; if it is not the builtin, it is called without arguments.
    pub function: Expr,
    /// The implicit variable `__class__`.
    pub class: Expr,
    /// The first parameter of the method.
    pub receiver: Option<Expr>,
    /// Where it is written.
    pub span: Span,
}

impl Expression for SuperCall {
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = self.function.eval(ev, f)?;
        let is_super =
            matches!(&callee, Value::Class(class) if Rc::ptr_eq(class, &ev.core.types.super_));
        if !is_super {
            return ev
                .call_from(&callee, &mut [], &[], Some(&mut *f))
                .at(ev, f, self.span);
        }
        let Some(receiver) = &self.receiver else {
            let error = ev.raise(ExceptionKind::RuntimeError, "super(): no arguments");
            return Err(error).at(ev, f, self.span);
        };
        let class = self.class.eval(ev, f)?;
        let receiver = receiver.eval(ev, f).map_err(|raised| {
            if ev.is_kind(&raised, ExceptionKind::UnboundLocalError) {
                return ev.raise(ExceptionKind::RuntimeError, "super(): arg[0] deleted");
            }
            raised
        });
        let receiver = receiver.at(ev, f, self.span)?;
        ev.make_super(&class, &receiver).at(ev, f, self.span)
    }
}
