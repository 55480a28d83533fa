//! Exception groups: making them, their methods, and splitting them as `except*` does.

use std::rc::Rc;

use super::{methods, wrong_receiver};
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::value::class::BuiltinBase;
use crate::value::exception::{ExceptionState, Group};
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Class, Instance, R, Value};

/// What a group is split by.
#[derive(Clone, Copy)]
pub enum Matcher<'m> {
    /// Exceptions of this type or of one in this tuple.
    Types(&'m Value),
    /// Exceptions for which a function of the script says so.
    Predicate(&'m Value),
    /// Exactly the exceptions of this list.
    Leaves(&'m [Rc<Instance>]),
}

/// The part of an exception that matches, and the rest.
pub type GroupSplit = (Option<Rc<Instance>>, Option<Rc<Instance>>);

pub(super) fn install(core: &Rc<InterpreterState>) {
    let class = core.types.exception(ExceptionKind::BaseExceptionGroup);
    methods(
        core,
        class,
        &[
            ("derive", "excs /", |ev, args| {
                let group = group(ev, &args[0])?;
                let message = message(&group);
                let class = ev.core.types.exception(ExceptionKind::BaseExceptionGroup);
                ev.new_group(class, &[message, args[1].clone()])
                    .map(Value::Instance)
            }),
            ("split", "condition /", |ev, args| {
                let (matched, rest) = split_by(ev, &args[0], &args[1])?;
                Ok(Value::tuple(vec![or_none(matched), or_none(rest)]))
            }),
            ("subgroup", "condition /", |ev, args| {
                Ok(or_none(split_by(ev, &args[0], &args[1])?.0))
            }),
        ],
    );
}

fn or_none(part: Option<Rc<Instance>>) -> Value {
    part.map_or(Value::None, Value::Instance)
}

fn group(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Instance>> {
    match value {
        Value::Instance(instance) if is_group(instance) => Ok(instance.clone()),
        other => Err(wrong_receiver(ev, "BaseExceptionGroup", other)),
    }
}

fn message(instance: &Instance) -> Value {
    let group = instance.exception().and_then(|state| state.group.get());
    group.map_or(Value::None, |group| group.message.clone())
}

/// Whether an exception is a group.
pub fn is_group(instance: &Instance) -> bool {
    instance
        .exception()
        .is_some_and(|state| state.group.get().is_some())
}

fn split_by(ev: &Evaluator<'_>, value: &Value, condition: &Value) -> R<GroupSplit> {
    let group = group(ev, value)?;
    let is_type = |value: &Value| matches!(value, Value::Class(class) if class.base == BuiltinBase::Exception);
    let matcher = match condition {
        Value::Function(_) => Matcher::Predicate(condition),
        Value::Tuple(types) if types.items().iter().all(is_type) => Matcher::Types(condition),
        single if is_type(single) => Matcher::Types(condition),
        _ => {
            let text = "expected a function, exception type or tuple of exception types";
            return Err(ev.type_error(text));
        }
    };
    ev.split_group(&group, matcher)
}

impl Evaluator<'_> {
    /// Whether instances of a class are exception groups.
    pub fn is_group_class(&self, class: &Class) -> bool {
        class.is_subclass_of(self.core.types.exception(ExceptionKind::BaseExceptionGroup))
    }

    /// `BaseExceptionGroup.__new__(class, message, exceptions)`
    pub fn new_group(&self, class: &Rc<Class>, args: &[Value]) -> R<Rc<Instance>> {
        const NEW: &str = "BaseExceptionGroup.__new__()";
        let [message, exceptions] = args else {
            let text = format!("{NEW} takes exactly 2 arguments ({} given)", args.len());
            return Err(self.type_error(text));
        };
        let Value::Str(text) = self.unwrap_builtin(message) else {
            let name = self.core.types.name_of(message);
            return Err(self.type_error(format!("{NEW} argument 1 must be str, not {name}")));
        };
        let members = match self.unwrap_builtin(exceptions) {
            Value::List(_) | Value::Tuple(_) => self.collect(exceptions)?,
            Value::Instance(instance) if instance.class.lookup(known::GETITEM).is_some() => {
                self.collect(exceptions)?
            }
            _ => {
                let text = "second argument (exceptions) must be a sequence";
                return Err(self.type_error(text));
            }
        };
        if members.is_empty() {
            let text = "second argument (exceptions) must be a non-empty sequence";
            return Err(self.value_error(text));
        }
        let exception = self.core.types.exception(ExceptionKind::Exception);
        let mut all_plain = true;
        for (index, member) in members.iter().enumerate() {
            match member {
                Value::Instance(instance) if instance.exception().is_some() => {
                    all_plain &= instance.class.is_subclass_of(exception);
                }
                _ => {
                    let text = "of second argument (exceptions) is not an exception";
                    return Err(self.value_error(format!("Item {index} {text}")));
                }
            }
        }
        let base = self.core.types.exception(ExceptionKind::BaseExceptionGroup);
        let plain = self.core.types.exception(ExceptionKind::ExceptionGroup);
        let class = if all_plain && Rc::ptr_eq(class, base) {
            plain
        } else if !all_plain && class.is_subclass_of(exception) {
            let text = if Rc::ptr_eq(class, plain) {
                "Cannot nest BaseExceptions in an ExceptionGroup".to_owned()
            } else {
                format!("Cannot nest BaseExceptions in '{}'", class.name())
            };
            return Err(self.type_error(text));
        } else {
            class
        };
        let state = ExceptionState::with_args(Value::tuple(args.to_vec()));
        let group = Group {
            message: Value::Str(text),
            exceptions: members.into_tuple(),
        };
        // The state is new, so its group is not set yet.
        let _ = state.group.set(group);
        Ok(Instance::new(
            class.clone(),
            InstancePayload::Exception(Box::new(state)),
        ))
    }

    /// A group without a message, as `except*` makes them, of a tuple or a list of members, which its arguments show.
    pub fn plain_group(&self, members: Value) -> R<Rc<Instance>> {
        let class = self.core.types.exception(ExceptionKind::BaseExceptionGroup);
        self.new_group(class, &[Value::str(""), members])
    }

    /// What `str` makes of a group.
    pub fn group_text(&self, group: &Group) -> R<String> {
        let count = match &group.exceptions {
            Value::Tuple(tuple) => tuple.items().len(),
            _ => 0,
        };
        let plural = if count == 1 { "" } else { "s" };
        let message = self.str(&group.message)?;
        Ok(format!("{message} ({count} sub-exception{plural})"))
    }

    /// Splits an exception into the part that matches and the rest, both with the structure of the original.
    pub fn split_group(&self, exception: &Rc<Instance>, matcher: Matcher<'_>) -> R<GroupSplit> {
        let matches = match matcher {
            Matcher::Types(types) => self.exception_matches(exception, types)?,
            Matcher::Predicate(function) => {
                let answer = self.call1(function, Value::Instance(exception.clone()))?;
                self.truth(&answer)?
            }
            Matcher::Leaves(leaves) => leaves.iter().any(|leaf| Rc::ptr_eq(leaf, exception)),
        };
        if matches {
            return Ok((Some(exception.clone()), None));
        }
        if !is_group(exception) {
            return Ok((None, Some(exception.clone())));
        }
        let members = exception.exception().map(ExceptionState::members);
        let (mut matched, mut rest) = (Vec::new(), Vec::new());
        for member in members.unwrap_or_default() {
            let parts = self.with_native_depth(|| self.split_group(&member, matcher))?;
            matched.extend(parts.0);
            rest.extend(parts.1);
        }
        Ok((
            self.derived_group(exception, matched)?,
            self.derived_group(exception, rest)?,
        ))
    }

    /// A group like `original` with some of its members, by its `derive`.
    fn derived_group(
        &self,
        original: &Rc<Instance>,
        members: Vec<Rc<Instance>>,
    ) -> R<Option<Rc<Instance>>> {
        if members.is_empty() {
            return Ok(None);
        }
        let members = Value::list(members.into_iter().map(Value::Instance).collect());
        let value = Value::Instance(original.clone());
        let derive = self.attribute(&value, self.core.symbols.intern("derive"))?;
        let part = match self.call1(&derive, members)? {
            Value::Instance(part) if is_group(&part) => part,
            _ => {
                let text = "derive must return an instance of BaseExceptionGroup";
                return Err(self.type_error(text));
            }
        };
        if let (Some(from), Some(to)) = (original.exception(), part.exception()) {
            to.set_traceback(from.traceback());
            to.context.put(from.context.get());
            to.cause.put(from.cause.get());
            to.suppress_context.set(true);
        }
        if let Some(notes) = self.attribute_or_none(&value, known::NOTES)?
            && matches!(self.unwrap_builtin(&notes), Value::List(_))
        {
            let copy = self.collect(&notes)?.into_list();
            self.set_attribute(&Value::Instance(part.clone()), known::NOTES, copy)?;
        }
        Ok(Some(part))
    }
}
