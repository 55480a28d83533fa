//! What makes an instance an exception: arguments, cause and context, where it passed through.

use std::cell::{Cell, OnceCell, RefCell};
use std::rc::Rc;

use elite_syntax::Span;
use messages::Text;

use super::{Instance, ScriptCell, Value};
use crate::eval::code::Code;

/// The state of an exception instance.
#[derive(Default)]
pub struct ExceptionState {
    /// Arguments; `Unbound` while there is only a message, which then is the single argument.
    args: ScriptCell<Value>,
    message: RefCell<Option<Box<str>>>,
    /// `__cause__`, or `Unbound`.
    pub cause: ScriptCell<Value>,
    /// `__context__`; `Unbound` until it is known, `None` if it is known that there is none.
    pub context: ScriptCell<Value>,
    /// `raise … from …` has been used.
    pub suppress_context: Cell<bool>,
    /// How the function is to be called whose call raised it.
    pub signature: RefCell<Option<Box<str>>>,
    /// What is advised.
    pub help: RefCell<Option<Box<Text>>>,
    /// The message in each language, where it is a text of ours.
    text: Option<Box<Text>>,
    traceback: RefCell<Vec<TracebackEntry>>,
    /// What an exception group consists of.
    pub group: OnceCell<Group>,
}

/// The parts of an exception group.
pub struct Group {
    /// `message`, a string.
    pub message: Value,
    /// `exceptions`, a tuple of exceptions.
    pub exceptions: Value,
}

/// One place an exception passed through, innermost first in the list.
#[derive(Clone)]
pub struct TracebackEntry {
    /// The code of the frame.
    pub code: Rc<Code>,
    /// The expression or statement within it.
    pub span: Span,
}

/// Places kept per exception; more can only come from raising one object again and again.
const TRACEBACK_MAX: usize = 2048;

impl ExceptionState {
    /// State of an exception raised by the interpreter itself.
    pub fn with_message(message: String) -> Self {
        ExceptionState {
            message: RefCell::new(Some(message.into())),
            ..ExceptionState::default()
        }
    }

    /// State of an exception with a text of ours, whose English form is its message.
    pub fn with_text(text: Text) -> Self {
        ExceptionState {
            message: RefCell::new(Some(text.english().into())),
            text: Some(Box::new(text)),
            ..ExceptionState::default()
        }
    }

    /// The text whose English form is `shown`; none if the exception was raised with other words, or tells others now.
    pub fn text_of(&self, shown: &str) -> Option<Text> {
        let text = self.text.as_deref()?;
        (text == shown).then(|| text.clone())
    }

    /// State of an exception made with these arguments.
    pub fn with_args(args: Value) -> Self {
        ExceptionState {
            args: ScriptCell::new(args),
            ..ExceptionState::default()
        }
    }

    /// The arguments, a tuple.
    pub fn args(&self) -> Value {
        let args = self.args.get();
        if !args.is_unbound() {
            return args;
        }
        let message = self.message.take();
        let message = message.map(|message| Value::str(String::from(message)));
        let args = Value::tuple(message.into_iter().collect());
        self.args.put(args.clone());
        args
    }

    /// Replaces the arguments.
    pub fn set_args(&self, args: Value) {
        self.message.replace(None);
        self.args.put(args);
    }

    /// The message of an exception that the interpreter raised and nobody has looked at.
    pub fn plain_message(&self) -> Option<String> {
        self.message.borrow().as_deref().map(str::to_owned)
    }

    /// Notes a place it passed through.
    pub fn trace(&self, code: Rc<Code>, span: Span) {
        let mut traceback = self.traceback.borrow_mut();
        if traceback.len() < TRACEBACK_MAX {
            traceback.push(TracebackEntry { code, span });
        }
    }

    /// The places it passed through, innermost first.
    pub fn traceback(&self) -> Vec<TracebackEntry> {
        self.traceback.borrow().clone()
    }

    /// Takes over where another exception passed through.
    pub fn set_traceback(&self, traceback: Vec<TracebackEntry>) {
        *self.traceback.borrow_mut() = traceback;
    }

    /// The exceptions of a group; none if this is no group.
    pub fn members(&self) -> Vec<Rc<Instance>> {
        let Some(Group {
            exceptions: Value::Tuple(tuple),
            ..
        }) = self.group.get()
        else {
            return Vec::new();
        };
        let members = tuple.items().iter().filter_map(|item| match item {
            Value::Instance(instance) => Some(instance.clone()),
            _ => None,
        });
        members.collect()
    }

    /// Sets `__context__`, unless it is known already.
    pub fn set_context(&self, own: &Rc<Instance>, context: &Rc<Instance>) {
        if self.context.borrow().is_unbound() {
            self.replace_context(own, context);
        }
    }

    /// Says that there is no `__context__`, whatever is being handled where it passes, unless it is known already.
    pub fn settle_context(&self) {
        if self.context.borrow().is_unbound() {
            self.context.put(Value::None);
        }
    }

    /// Sets `__context__` anew, as `raise` does. No circle comes of it.
    pub fn replace_context(&self, own: &Rc<Instance>, context: &Rc<Instance>) {
        if Rc::ptr_eq(own, context) {
            return;
        }
        // Walk the chain that would hang below: if it holds this exception, the link is cut there (as CPython does).
        let mut at = context.clone();
        for _ in 0..1000 {
            let Some(state) = at.exception() else { break };
            let Value::Instance(next) = state.context.get() else {
                break;
            };
            if Rc::ptr_eq(&next, own) {
                state.context.put(Value::None);
                break;
            }
            at = next;
        }
        self.context.put(Value::Instance(context.clone()));
    }

    /// Runs `each` on what it refers to, unless that is being changed.
    pub fn visit(&self, each: &mut dyn FnMut(&Value)) {
        for place in [&self.args, &self.cause, &self.context] {
            if let Some(value) = place.try_borrow() {
                each(&value);
            }
        }
        if let Some(group) = self.group.get() {
            each(&group.exceptions);
        }
    }

    /// Lets go of arguments, cause and context.
    pub fn clear(&self) {
        for place in [&self.args, &self.cause, &self.context] {
            place.put(Value::Unbound);
        }
    }

    /// Takes out everything it refers to.
    pub fn take_values(&mut self) -> Vec<Value> {
        let places = [&mut self.args, &mut self.cause, &mut self.context];
        let mut values = Vec::from(places.map(ScriptCell::get_mut).map(std::mem::take));
        values.extend(self.group.take().map(|group| group.exceptions));
        values
    }
}
