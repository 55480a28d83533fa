//! Calling anything that can be called.

use std::rc::Rc;

use super::{Args, Builtin, BuiltinBody};
use crate::eval::coroutine::RESERVE;
use crate::eval::{Evaluator, Frame};
use crate::native::NativeCall;
use crate::value::symbol::known;
use crate::value::{Class, R, Symbol, Value, ValueVec};

/// Derived classes that are looked at between two safepoints.
const SUBCLASSES: usize = 1024;
/// Native stack that natives of the embedder find: they print, lock, log and talk to others, in whatever depth the
/// script calls them.
pub(crate) const EMBEDDER: usize = 3 * RESERVE;
/// Arguments up to this number are moved on the native stack.
const INLINE_ARGS: usize = 6;

impl Evaluator<'_> {
    /// Runs `inner` with `first` before `args`, which are taken out of their places.
    #[inline]
    pub fn with_first(
        &self,
        first: Value,
        args: &mut [Value],
        inner: impl FnOnce(&mut [Value]) -> R,
    ) -> R {
        let count = args.len() + 1;
        if count <= INLINE_ARGS {
            let mut all = [const { Value::Unbound }; INLINE_ARGS];
            all[0] = first;
            for (place, arg) in all[1..].iter_mut().zip(args) {
                *place = std::mem::take(arg);
            }
            return inner(&mut all[..count]);
        }
        inner(&mut self.in_front(first, args)?)
    }

    /// A vector of `first` and many `args`, which are taken out of their places some at a time.
    #[inline(never)]
    fn in_front(&self, first: Value, args: &mut [Value]) -> R<ValueVec> {
        let mut all = ValueVec::from(self.try_with_capacity(args.len() + 1)?);
        all.push(first);
        self.take_values(args, &mut all)?;
        Ok(all)
    }

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
            Value::BoundMethod(method) if let Value::Function(function) = &method.function => self
                .with_first(method.receiver.clone(), args, |all| {
                    self.call_function(function, all, keywords)
                }),
            // A method of a method, an object whose `__call__` is an object with a `__call__`: such chains have no end
            // of their own.
            _ => self.deeper(|| self.call_through(callee, args, keywords, caller)),
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
            Value::Builtin(builtin) => {
                self.check_receiver(builtin, args)?;
                self.call_builtin(builtin, args, keywords, caller)
            }
            Value::BoundMethod(method) => self.with_first(method.receiver.clone(), args, |all| {
                match &method.function {
                    Value::Builtin(builtin) => self.call_builtin(builtin, all, keywords, caller),
                    function => self.call_from(function, all, keywords, caller),
                }
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

    /// Refuses a call of a method as a function (`list.append(5, 6)`) whose receiver is none.
    #[inline]
    pub fn check_receiver(&self, builtin: &Builtin, args: &[Value]) -> R<()> {
        let Some(owner) = builtin.owner else {
            return Ok(());
        };
        match args.first() {
            Some(_) if owner == "object" => Ok(()),
            Some(receiver) if self.core.types.of(receiver).has_builtin_ancestor(owner) => Ok(()),
            // What has data of its own knows its class, and `__new__` is handed it.
            _ if matches!(builtin.body, BuiltinBody::Closure { .. }) => Ok(()),
            _ if builtin.name == "__new__" => Ok(()),
            Some(receiver) if self.is_of_library(builtin, receiver) => Ok(()),
            receiver => Err(self.receiver_error(builtin, receiver)),
        }
    }

    /// Whether the receiver is of a class of the library that is written in Python and has this method among its own.
    fn is_of_library(&self, builtin: &Builtin, receiver: &Value) -> bool {
        let Some(name) = self.core.symbols.find(builtin.name) else {
            return false;
        };
        let is_it =
            |found: &Value| matches!(found, Value::Builtin(own) if std::ptr::eq(&**own, builtin));
        let class = self.core.types.of(receiver);
        class.lookup(name).is_some_and(|found| is_it(&found))
            || (class.mro().iter()).any(|class| class.own_attrs().get(name).is_some_and(is_it))
    }

    /// Refuses to make a method of an object that is none of the class's.
    pub fn check_descriptor_receiver(&self, builtin: &Rc<Builtin>, receiver: &Value) -> R<()> {
        if self
            .check_receiver(builtin, std::slice::from_ref(receiver))
            .is_ok()
        {
            return Ok(());
        }
        let (owner, given) = (self.owner_of(builtin), self.core.types.name_of(receiver));
        Err(self.type_error(format!(
            "descriptor '{}' for '{owner}' objects doesn't apply to a '{given}' object",
            builtin.name
        )))
    }

    /// The class whose method it is: `__objclass__`.
    pub fn descriptor_owner(&self, builtin: &Builtin) -> R<Option<Value>> {
        let types = &self.core.types;
        let Some(name) = self.core.symbols.find(builtin.name) else {
            return Ok(None);
        };
        let has_it = |class: &Class| match class.own_attrs().get(name) {
            Some(Value::Builtin(own)) => std::ptr::eq(&**own, builtin),
            Some(Value::ClassMethod(wrapped)) => {
                matches!(&***wrapped, Value::Builtin(own) if std::ptr::eq(&**own, builtin))
            }
            _ => false,
        };
        if has_it(&types.natural) {
            return Ok(Some(Value::Class(types.object.clone())));
        }
        let builtin_types = types.all().into_iter().chain(types.exceptions());
        let mut called_so = builtin_types.filter(|class| builtin.owner == Some(&*class.name()));
        if let Some(class) = called_so.find(|class| has_it(class)) {
            return Ok(Some(Value::Class(class.clone())));
        }
        // Every class is derived from `object`; those of scripts may have it under the same name.
        let mut left = vec![types.object.clone()];
        let mut seen = std::collections::HashSet::new();
        let mut of_script = None;
        while let Some(class) = left.pop() {
            self.charge(crate::limits::yielding::WORK_PER_VALUE)?;
            if !seen.insert(Rc::as_ptr(&class)) {
                continue;
            }
            if has_it(&class) {
                match class.is_script && builtin.owner != Some(&*class.name()) {
                    false => return Ok(Some(Value::Class(class))),
                    true => of_script = Some(Value::Class(class.clone())),
                }
            }
            let mut before = usize::MAX;
            while before > 0 {
                before = class.some_subclasses(before, SUBCLASSES, &mut left);
                self.charge(SUBCLASSES)?;
            }
        }
        Ok(of_script)
    }

    /// How messages name the class whose method it is.
    #[cold]
    pub fn owner_of(&self, builtin: &Builtin) -> Rc<str> {
        match self.descriptor_owner(builtin) {
            Ok(Some(Value::Class(class))) => class.type_name(),
            _ => builtin.owner.unwrap_or_default().into(),
        }
    }

    /// `__self__` of a builtin function, which is its module, or `__module__`, its name.
    pub fn module_of_builtin(&self, builtin: &Builtin, name: Symbol) -> R<Option<Value>> {
        let module = match &builtin.module {
            Some(module) => module.clone(),
            None => {
                let known = self.core.symbols.find(builtin.name);
                let found = known.and_then(|name| self.core.builtins.get(name));
                match found {
                    Some(Value::Builtin(own)) if std::ptr::eq(&*own, builtin) => "builtins".into(),
                    _ => return Ok(Some(Value::None)),
                }
            }
        };
        Ok(Some(match name {
            known::MODULE => Value::str(&*module),
            _ => { self.core.module_table.get_str(&module) }.unwrap_or(Value::None),
        }))
    }

    #[cold]
    fn not_callable(&self, callee: &Value) -> crate::value::Unwind {
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
                    self.gc_track_receiver(builtin, args);
                    return body(self, args);
                }
                self.with_bound(builtin, args, keywords, |bound| {
                    self.gc_track_receiver(builtin, bound);
                    body(self, bound)
                })
            }
            BuiltinBody::Raw(body) => {
                self.gc_track_receiver(builtin, args);
                if builtin.stores_args
                    && let Some(receiver) = args.first()
                    && keywords.iter().any(|(_, value)| value.can_hold_values())
                {
                    self.core.gc_track(receiver);
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
                self.with_stack(EMBEDDER, || {
                    native.call.run(&mut NativeCall {
                        ev: self,
                        args: bound,
                        caller: caller.map(Frame::reborrow),
                    })
                })
            }),
        }
    }

    /// Notes the receiver of a method that may put values into it which can hold others.
    #[inline]
    pub fn gc_track_receiver(&self, builtin: &Builtin, args: &[Value]) {
        if builtin.stores_args
            && let Some((receiver, rest)) = args.split_first()
            && rest.iter().any(Value::can_hold_values)
        {
            self.core.gc_track(receiver);
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
