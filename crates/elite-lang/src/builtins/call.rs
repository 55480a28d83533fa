//! Calling anything that can be called.

use std::rc::Rc;

use super::{Args, Builtin, BuiltinBody};
use crate::eval::{Evaluator, Frame};
use crate::native::NativeCall;
use crate::value::symbol::known;
use crate::value::{R, Symbol, Value};

/// Arguments up to this number are moved on the native stack.
const INLINE_ARGS: usize = 6;

/// Runs `inner` with `first` before `args`.
#[inline]
pub fn with_first<T>(first: Value, args: &mut [Value], inner: impl FnOnce(&mut [Value]) -> T) -> T {
    let count = args.len() + 1;
    if count <= INLINE_ARGS {
        let mut all = [const { Value::Unbound }; INLINE_ARGS];
        all[0] = first;
        for (place, arg) in all[1..].iter_mut().zip(args) {
            *place = std::mem::take(arg);
        }
        return inner(&mut all[..count]);
    }
    let mut all = Vec::with_capacity(count);
    all.push(first);
    all.extend(args.iter_mut().map(std::mem::take));
    inner(&mut all)
}

impl Evaluator<'_> {
    /// Calls `callee`; the arguments are taken out of `args`.
    pub fn call(&self, callee: &Value, args: &mut [Value], keywords: &[(Symbol, Value)]) -> R {
        self.call_from(callee, args, keywords, None)
    }

    /// Calls `callee` with one argument.
    pub fn call1(&self, callee: &Value, arg: Value) -> R {
        self.call_from(callee, &mut [arg], &[], None)
    }

    /// Calls `callee` from the frame `caller`.
    pub fn call_from(
        &self,
        callee: &Value,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
        caller: Option<&mut Frame<'_>>,
    ) -> R {
        match callee {
            Value::Function(function) => self.call_function(function, args, keywords),
            Value::BoundMethod(method)
                if keywords.is_empty()
                    && let Value::Function(function) = &method.function =>
            {
                self.call_method(function, method.receiver.clone(), args)
            }
            Value::BoundMethod(method) if let Value::Function(function) = &method.function => {
                with_first(method.receiver.clone(), args, |all| {
                    self.call_function(function, all, keywords)
                })
            }
            // A method of a method, an object whose `__call__` is an object with a `__call__`: such chains have no end
            // of their own.
            _ => self.recurse(|| self.call_through(callee, args, keywords, caller)),
        }
    }

    /// Calls what is no function of a script; what that calls in turn comes back to `call_from`.
    fn call_through(
        &self,
        callee: &Value,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
        caller: Option<&mut Frame<'_>>,
    ) -> R {
        match callee {
            Value::Builtin(builtin) => self.call_builtin(builtin, args, keywords, caller),
            Value::BoundMethod(method) => with_first(method.receiver.clone(), args, |all| {
                self.call_from(&method.function, all, keywords, caller)
            }),
            Value::Class(class) => match class.meta_method(known::CALL) {
                Some(function) => {
                    let metaclass = self.core.types.of(callee);
                    let method = self.bind_attribute(&function, callee, metaclass)?;
                    self.call_from(&method, args, keywords, caller)
                }
                None => self.instantiate(class, args, keywords, caller),
            },
            Value::StaticMethod(function) => self.call_from(function, args, keywords, caller),
            Value::Instance(instance) => match instance.class.lookup(known::CALL) {
                Some(function) => {
                    let method = self.bind_attribute(&function, callee, &instance.class)?;
                    self.call_from(&method, args, keywords, caller)
                }
                None => Err(self.not_callable(callee)),
            },
            _ => Err(self.not_callable(callee)),
        }
    }

    #[cold]
    fn not_callable(&self, callee: &Value) -> crate::value::Raised {
        self.type_error(format!(
            "'{}' object is not callable",
            self.core.types.name_of(callee)
        ))
    }

    /// Calls a builtin.
    #[inline]
    pub fn call_builtin(
        &self,
        builtin: &Rc<Builtin>,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
        caller: Option<&mut Frame<'_>>,
    ) -> R {
        match &builtin.body {
            BuiltinBody::Bound(body) => {
                if keywords.is_empty()
                    && args.len() == builtin.signature.len()
                    && builtin.signature.accepts(args.len())
                {
                    self.note_filled(builtin, args);
                    return body(self, args);
                }
                self.with_bound(builtin, args, keywords, |bound| {
                    self.note_filled(builtin, bound);
                    body(self, bound)
                })
            }
            BuiltinBody::Raw(body) => {
                self.note_filled(builtin, args);
                if builtin.fills
                    && let Some(receiver) = args.first()
                    && keywords.iter().any(|(_, value)| value.holds_values())
                {
                    self.core.note(receiver);
                }
                body(
                    self,
                    &mut Args {
                        positional: args,
                        keywords,
                        caller: caller.map(Frame::reborrow),
                    },
                )
            }
            BuiltinBody::Closure { held, body } => body(
                self,
                held,
                &mut Args {
                    positional: args,
                    keywords,
                    caller: caller.map(Frame::reborrow),
                },
            ),
            BuiltinBody::Native(native) => self.with_bound(builtin, args, keywords, |bound| {
                (native.call)(&mut NativeCall {
                    ev: self,
                    args: bound,
                    caller: caller.map(Frame::reborrow),
                })
            }),
        }
    }

    /// Notes the receiver of a method that may put values into it which can hold others.
    #[inline]
    pub fn note_filled(&self, builtin: &Builtin, args: &[Value]) {
        if builtin.fills
            && let Some((receiver, rest)) = args.split_first()
            && rest.iter().any(Value::holds_values)
        {
            self.core.note(receiver);
        }
    }

    /// Binds arguments to the signature of a builtin and runs `body` with them.
    #[inline]
    fn with_bound(
        &self,
        builtin: &Builtin,
        args: &mut [Value],
        keywords: &[(Symbol, Value)],
        body: impl FnOnce(&mut [Value]) -> R,
    ) -> R {
        let count = builtin.signature.len();
        crate::eval::run::with_slots(count, |bound| {
            if keywords.is_empty() && builtin.signature.accepts(args.len()) {
                for (place, arg) in bound.iter_mut().zip(args) {
                    *place = std::mem::take(arg);
                }
            } else {
                self.bind_builtin(builtin, args, keywords, bound)?;
            }
            body(bound)
        })
    }
}
