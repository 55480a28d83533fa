//! Calls of methods: no bound method is made.

use std::cell::Cell;
use std::rc::{Rc, Weak};

use elite_syntax::Span;

use super::attribute::{CachedLookup, InlineCache, ModuleMemberCache};
use super::call::{CallArgs, call_fast_path, call_native, call_other};
use super::enter::call_script;
use super::names::{LocalVar, Readable};
use super::operand::Operand;
use crate::builtins::{Builtin, FastPath};
use crate::errors::ExceptionKind;
use crate::eval::words::PairOf;
use crate::eval::{BoxExpr, Evaluator, ExprNode, Frame, TraceExt};
use crate::value::{Class, Function, Instance, Module, R, Symbol, Value};

/// The functions that a call has found in two classes. A class in the same state has the same functions, and keeps
/// them.
#[derive(Default)]
pub struct MethodCache {
    found: [(Cell<u32>, Cell<Weak<Function>>); 2],
}

impl MethodCache {
    /// The function for instances of a class in the state `version`, if that is known.
    #[inline(always)]
    fn of(&self, version: u32) -> Option<Rc<Function>> {
        let [first, second] = &self.found;
        let function = match version {
            version if first.0.get() == version => &first.1,
            version if second.0.get() == version => &second.1,
            _ => return None,
        };
        let weak = function.take();
        let found = weak.upgrade();
        function.set(weak);
        found
    }

    fn add(&self, version: u32, function: &Rc<Function>) {
        let [first, second] = &self.found;
        second.0.set(first.0.get());
        second.1.set(first.1.take());
        first.0.set(version);
        first.1.set(Rc::downgrade(function));
    }
}

/// The kind of instances of a class in the state `version`: none that a value of another type has.
#[inline(always)]
fn kind_of_class(version: u32) -> u64 {
    1 << 32 | u64::from(version)
}

/// `receiver.name(a, b)` without stars and keywords: no bound method is made.
pub struct CallMethod {
    /// The object before the dot.
    pub receiver: Operand,
    /// The method.
    pub name: Symbol,
    /// The arguments.
    pub site: CallArgs,
    /// Where the attribute is written.
    pub attribute_span: Span,
    /// The functions of classes.
    pub methods: MethodCache,
    /// The kind of values that were the receiver last, and what their method answers at once.
    pub quick: Cell<Option<(u64, FastPath)>>,
    /// What else is known about the method.
    pub cache: InlineCache,
    /// Where the name was found last, if it belongs to a module.
    pub member: ModuleMemberCache,
}

impl ExprNode for CallMethod {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        if let Operand::Local(local) = &self.receiver {
            return match local.peek(f) {
                Value::Instance(_) => self.call_of_instance(local, ev, f).whole(),
                _ => self.call_of_builtin(local, ev, f).whole(),
            };
        }
        self.call(ev, f).whole()
    }
}

impl CallMethod {
    /// A call with an instance in a local variable.
    #[inline(never)]
    fn call_of_instance(
        &self,
        local: &LocalVar,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> PairOf<R> {
        if let Value::Instance(instance) = local.peek(f)
            && !instance.in_dict.get()
        {
            let version = instance.class.version();
            if let Some(function) = self.methods.of(version) {
                let receiver = Some(Value::Instance(instance.clone()));
                return PairOf::pack(call_script(&function, receiver, &self.site, ev, f));
            }
            if let Some((kind, quick)) = self.quick.get()
                && kind == kind_of_class(version)
                && let receiver = Some(local.peek(f))
                && let Some(answer) = call_fast_path(quick, receiver, &self.site, ev, f)
            {
                return PairOf::pack(Ok(answer));
            }
        }
        self.call(ev, f)
    }

    /// A call with a value of a builtin type in a local variable.
    #[inline(never)]
    fn call_of_builtin(
        &self,
        local: &LocalVar,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> PairOf<R> {
        let receiver = local.peek(f);
        if let Some((kind, quick)) = self.quick.get()
            && kind == receiver.kind()
            && let Some(answer) = call_fast_path(quick, Some(receiver), &self.site, ev, f)
        {
            return PairOf::pack(Ok(answer));
        }
        self.call(ev, f)
    }

    /// A call of what is not a known function of the class of a local variable.
    #[inline(never)]
    fn call(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> PairOf<R> {
        PairOf::pack(self.call_any(ev, f))
    }

    #[inline(always)]
    fn call_any(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let receiver = self.receiver.eval(ev, f)?;
        match &receiver {
            Value::Instance(instance) => {
                if let Some(function) = self.function_of(instance) {
                    return call_script(&function, Some(receiver), &self.site, ev, f);
                }
            }
            Value::Module(module) => {
                if let Some(answer) = self.answer_of_module(module, ev, f) {
                    receiver.drop_inline();
                    return Ok(answer);
                }
            }
            _ => {}
        }
        if let Some(quick) = self.quick(&receiver, ev) {
            if let [arg] = &*self.site.args
                && let Operand::Expr(_) = arg
            {
                let arg = arg.eval(ev, f)?;
                return match quick.ask(ev, &[&receiver, &arg]) {
                    Some(answer) => Ok(answer),
                    None => self.call_with(receiver, arg, ev, f),
                };
            }
            if let Some(answer) = call_fast_path(quick, Some(&receiver), &self.site, ev, f) {
                receiver.drop_inline();
                return Ok(answer);
            }
        }
        self.call_by_class(receiver, ev, f)
    }

    /// A call with one argument, which has been evaluated.
    #[inline(never)]
    fn call_with(&self, receiver: Value, arg: Value, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let method = { ev.attribute(&receiver, self.name) }.trace_at(ev, f, self.attribute_span)?;
        ev.call_from(&method, &mut [arg], &[], Some(&mut *f))
            .trace_at(ev, f, self.site.span)
    }

    /// The function that the class of an instance has, if the instance has no attribute of that name.
    #[inline]
    fn function_of(&self, instance: &Instance) -> Option<Rc<Function>> {
        if instance.in_dict.get() {
            return None;
        }
        let class = &*instance.class;
        let version = class.version();
        if let Some(function) = self.methods.of(version) {
            return Some(function);
        }
        let hint = { self.cache.get(version) }.or_else(|| self.cache.learn(class, self.name));
        let Some(CachedLookup::Method(location)) = hint else {
            return None;
        };
        let function = class.function_at(location)?;
        self.methods.add(class.version(), &function);
        Some(function)
    }

    /// What a method of a builtin type answers at once. Such types never change.
    #[inline]
    fn quick(&self, receiver: &Value, ev: &Evaluator<'_>) -> Option<FastPath> {
        match (self.quick.get(), receiver) {
            (_, Value::Instance(instance)) if !instance.in_dict.get() => {
                let quick = self.learn_quick(&instance.class)?;
                let kind = kind_of_class(instance.class.version());
                self.quick.set(Some((kind, quick)));
                Some(quick)
            }
            (_, Value::Instance(_)) => None,
            (Some((kind, quick)), receiver) if kind == receiver.kind() => Some(quick),
            (_, Value::List(_) | Value::Dict(_) | Value::Set(_) | Value::Str(_)) => {
                let quick = self.learn_quick(ev.core.types.of(receiver))?;
                self.quick.set(Some((receiver.kind(), quick)));
                Some(quick)
            }
            _ => None,
        }
    }

    fn learn_quick(&self, class: &Class) -> Option<FastPath> {
        let known = self.cache.get(class.version());
        match known.or_else(|| self.cache.learn(class, self.name))? {
            CachedLookup::Quick(quick) => Some(quick),
            _ => None,
        }
    }

    /// What a function of a module answers at once.
    #[inline]
    fn answer_of_module(
        &self,
        module: &Rc<Module>,
        ev: &Evaluator<'_>,
        f: &Frame<'_>,
    ) -> Option<Value> {
        let cell = self.member.cell_of(module, self.name)?;
        let quick = Builtin::quick_of(&cell.value.borrow())?;
        call_fast_path(quick, None, &self.site, ev, f)
    }

    /// Calls a method of a builtin type.
    #[inline(never)]
    fn call_by_class(&self, receiver: Value, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        if let Value::Module(module) = &receiver
            && let Some(cell) = self.member.cell_of(module, self.name)
        {
            let callee = cell.value.get();
            match &callee {
                Value::Builtin(builtin) => {
                    return call_native(builtin, None, &self.site, ev, f);
                }
                Value::Function(function) => {
                    return call_script(function, None, &self.site, ev, f);
                }
                _ => {}
            }
        }
        let by_class = match &receiver {
            Value::Class(_) | Value::Module(_) | Value::Super(_) | Value::Function(_) => false,
            Value::Instance(instance) => !instance.in_dict.get(),
            _ => true,
        };
        if by_class {
            let class = ev.core.types.of(&receiver);
            let hint = self
                .cache
                .get(class.version())
                .or_else(|| self.cache.learn(class, self.name));
            let method = match hint {
                Some(CachedLookup::Method(location) | CachedLookup::Static(location)) => {
                    class.at(location)
                }
                Some(CachedLookup::Quick(_)) => class.lookup(self.name).unwrap_or_default(),
                _ => Value::Unbound,
            };
            match &method {
                Value::Function(function) => {
                    return call_script(function, Some(receiver), &self.site, ev, f);
                }
                Value::Builtin(builtin) => {
                    return call_native(builtin, Some(receiver), &self.site, ev, f);
                }
                Value::StaticMethod(function) => {
                    if let Value::Function(function) = &***function {
                        return call_script(function, None, &self.site, ev, f);
                    }
                }
                // The hint says what it is; anything else goes the general way.
                _ => {}
            }
        }
        self.call_generally(&receiver, ev, f)
    }

    #[inline(never)]
    fn call_generally(&self, receiver: &Value, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        if let Value::Super(sup) = receiver
            && let Some(Value::Function(function)) =
                sup.receiver_class.lookup_after(&sup.class, self.name)
        {
            let receiver = Some(sup.receiver.clone());
            return call_script(&function, receiver, &self.site, ev, f);
        }
        let callee = ev
            .attribute(receiver, self.name)
            .trace_at(ev, f, self.attribute_span)?;
        match &callee {
            Value::Function(function) => call_script(function, None, &self.site, ev, f),
            Value::BoundMethod(method) => match &method.function {
                Value::Function(function) => {
                    let receiver = Some(method.receiver.clone());
                    call_script(function, receiver, &self.site, ev, f)
                }
                _ => call_other(&callee, &self.site.args, ev, f, self.site.span),
            },
            _ => call_other(&callee, &self.site.args, ev, f, self.site.span),
        }
    }
}

/// `super()` without arguments: the class the method is written in, and the method's first argument.
pub struct SuperCall {
    /// The name `super`; if it is not the builtin, it is called without arguments.
    pub function: BoxExpr,
    /// The implicit variable `__class__`.
    pub class: BoxExpr,
    /// The first parameter of the method.
    pub receiver: Option<BoxExpr>,
    /// The place in the text.
    pub span: Span,
}

impl ExprNode for SuperCall {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let callee = self.function.eval(ev, f)?;
        let is_super =
            matches!(&callee, Value::Class(class) if Rc::ptr_eq(class, &ev.core.types.super_));
        if !is_super {
            return ev
                .call_from(&callee, &mut [], &[], Some(&mut *f))
                .trace_at(ev, f, self.span);
        }
        let Some(receiver) = &self.receiver else {
            let error = ev.raise(ExceptionKind::RuntimeError, "super(): no arguments");
            return Err(error).trace_at(ev, f, self.span);
        };
        let class = self.class.eval(ev, f)?;
        let receiver = receiver.eval(ev, f).map_err(|raised| {
            if ev.is_kind(&raised, ExceptionKind::UnboundLocalError) {
                return ev.raise(ExceptionKind::RuntimeError, "super(): arg[0] deleted");
            }
            raised
        });
        let receiver = receiver.trace_at(ev, f, self.span)?;
        ev.make_super(&class, &receiver).trace_at(ev, f, self.span)
    }
}
