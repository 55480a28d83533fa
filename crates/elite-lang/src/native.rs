//! Functions that the embedder provides to scripts.

use std::rc::Rc;

use crate::errors::ExceptionKind;
use crate::eval::coroutine::Request;
use crate::eval::node::NodeState;
use crate::eval::{Evaluator, Frame};
use crate::host::ThreadId;
use crate::value::{R, Raised, Value};

/// Whether and how a parameter may be omitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamKind {
    /// It must be given.
    Required,
    /// It may be omitted; the native then sees no value.
    Optional,
    /// It takes all further positional arguments, as a tuple. Only as the last parameter.
    VarArgs,
}

/// A parameter of a native function.
#[derive(Clone, Debug)]
pub struct Param {
    /// The name to give it by.
    pub name: &'static str,
    /// Other names it may be given by.
    pub aliases: &'static [&'static str],
    /// Whether it may be omitted.
    pub kind: ParamKind,
}

impl Param {
    /// A parameter that must be given.
    pub const fn required(name: &'static str) -> Self {
        Param {
            name,
            aliases: &[],
            kind: ParamKind::Required,
        }
    }

    /// A parameter that may be omitted.
    pub const fn optional(name: &'static str) -> Self {
        Param {
            name,
            aliases: &[],
            kind: ParamKind::Optional,
        }
    }

    /// The parameter for all further positional arguments.
    pub const fn var_args(name: &'static str) -> Self {
        Param {
            name,
            aliases: &[],
            kind: ParamKind::VarArgs,
        }
    }

    /// The same parameter, also known by other names.
    pub const fn with_aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }
}

/// The body of a native function.
pub type NativeBody = Rc<dyn Fn(&mut NativeCall<'_>) -> R>;

/// A function the embedder provides: binding of arguments and the errors for wrong ones are done before it is called.
#[derive(Clone)]
pub struct NativeFunction {
    /// Its name, a global of every program.
    pub name: &'static str,
    /// Its parameters, in order.
    pub params: Vec<Param>,
    /// What it does.
    pub call: NativeBody,
}

/// What a native waits for, by a number of the embedder's own tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct WaitToken(pub u64);

/// A call of a native function that is under way.
pub struct NativeCall<'c> {
    pub(crate) ev: &'c Evaluator<'c>,
    pub(crate) args: &'c [Value],
    pub(crate) caller: Option<Frame<'c>>,
}

impl NativeCall<'_> {
    /// Argument number `index` in the order of the parameters; None if it was omitted.
    pub fn arg(&self, index: usize) -> Option<&Value> {
        self.args.get(index).and_then(Value::given)
    }

    /// All arguments in the order of the parameters; omitted ones are `Value::Unbound`.
    pub fn args(&self) -> &[Value] {
        self.args
    }

    /// The script thread that calls.
    pub fn thread(&self) -> ThreadId {
        ThreadId(self.ev.core.thread.get())
    }

    /// The line that calls, from 1.
    pub fn line(&self) -> u32 {
        self.ev.core.line.get()
    }

    /// Where in the pendant's task a thread would begin that is started here.
    pub fn node(&self) -> NodeState {
        self.ev.core.nodes.state().inherited()
    }

    /// A motion that the calling thread waited for has ended, or could not be done: a node that is to be shown after it is
    /// shown from now on, or not at all.
    pub fn motion_ended(&self, failed: bool) {
        self.ev.core.nodes.motion_ended(failed, self.line());
    }

    /// The name of the program text that calls.
    pub fn program_name(&self) -> &str {
        self.caller
            .as_ref()
            .map_or("", |frame| frame.function.code.file.name())
    }

    /// Suspends the script thread until the embedder resumes it. The embedder knows by the token what is waited for,
    /// and when the thread goes on, the native picks up the outcome from the embedder's tables. An error means that
    /// the thread is to stop: pass it on.
    pub fn wait(&self, token: WaitToken) -> R<()> {
        self.ev.suspend(Request::Wait(token))
    }

    /// An exception to return as error.
    pub fn raise(&self, kind: ExceptionKind, message: impl Into<String>) -> Raised {
        self.ev.raise(kind, message)
    }

    /// The same exception with advice, which the report of an uncaught one shows before its last line.
    pub fn with_help(&self, raised: Raised, help: impl Into<String>) -> Raised {
        if let Raised::Exception(exception) = &raised
            && let Some(state) = exception.exception()
        {
            *state.help.borrow_mut() = Some(help.into().into());
        }
        raised
    }

    /// Calls a function of the script.
    pub fn call_value(&self, function: &Value, args: &[Value]) -> R {
        self.ev.call(function, &mut args.to_vec(), &[])
    }

    /// Python's `str(value)`.
    pub fn str(&self, value: &Value) -> R<String> {
        self.ev.str(value)
    }

    /// Python's `repr(value)`.
    pub fn repr(&self, value: &Value) -> R<String> {
        self.ev.repr(value)
    }

    /// Python's truth of a value.
    pub fn truth(&self, value: &Value) -> R<bool> {
        self.ev.truth(value)
    }

    /// All items of any iterable.
    pub fn items(&self, iterable: &Value) -> R<Vec<Value>> {
        self.ev.collect(iterable).map(Vec::from)
    }

    /// A random number from the embedder's seed.
    pub fn random_u64(&self) -> u64 {
        self.ev.core.host.random_u64()
    }

    /// Counts the embedder's work with a text for people of so many bytes; others have their turn when it is much.
    ///
    /// # Errors
    /// The thread is to stop.
    pub fn said(&self, bytes: usize) -> R<()> {
        self.ev.said(bytes)
    }

    /// The evaluator, for the interpreter's own library.
    pub fn evaluator(&self) -> &Evaluator<'_> {
        self.ev
    }
}
