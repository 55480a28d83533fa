//! Functions that the embedder provides to scripts.

use std::rc::Rc;

use messages::Text;

use crate::errors::{ExceptionKind, ExceptionText};
use crate::eval::coroutine::SuspendRequest;
use crate::eval::node::NodeCursor;
use crate::eval::{Evaluator, Frame};
use crate::host::ThreadId;
use crate::value::{R, Str, Unwind, Value};

/// Whether and how a parameter may be omitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamKind {
    /// The argument must be given.
    Required,
    /// The argument may be omitted; the native then sees no value.
    Optional,
    /// The parameter takes all further positional arguments, as a tuple. Only as the last parameter.
    VarArgs,
}

/// A parameter of a native function.
#[derive(Clone, Debug)]
pub struct Param {
    /// The name by which the argument is given.
    pub name: &'static str,
    /// Other names by which the argument may be given.
    pub aliases: &'static [&'static str],
    /// Whether the argument may be omitted.
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

    /// Adds other names by which the argument may be given.
    pub const fn with_aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }
}

/// The body of a native function. It holds no values: what nothing can find, neither the search for cycles nor the
/// queue that takes deep chains apart would know of.
#[derive(Clone)]
pub struct NativeBody(Rc<dyn Fn(&mut NativeCall<'_>) -> R>);

/// What natives need of their embedder: it is there for the whole task, and who drops the last native drops no values
/// with it.
pub trait NativeContext: 'static {}

impl<C: NativeContext + ?Sized> NativeContext for Rc<C> {}

impl NativeBody {
    /// A function. Values do not go from thread to thread, so that one which has captured a value does not compile.
    pub fn new(body: impl Fn(&mut NativeCall<'_>) -> R + Send + 'static) -> Self {
        NativeBody(Rc::new(body))
    }

    /// A function with a context.
    pub fn with<C: NativeContext>(
        context: C,
        body: impl Fn(&C, &mut NativeCall<'_>) -> R + Send + 'static,
    ) -> Self {
        NativeBody(Rc::new(move |call| body(&context, call)))
    }

    /// Runs it.
    #[inline]
    pub(crate) fn run(&self, call: &mut NativeCall<'_>) -> R {
        (self.0)(call)
    }
}

/// A function the embedder provides: binding of arguments and the errors for wrong ones are done before it is called.
#[derive(Clone)]
pub struct NativeFunction {
    /// The name of the function, a global of every program.
    pub name: &'static str,
    /// The parameters of the function, in order.
    pub params: Vec<Param>,
    /// What the function does.
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

/// A text whose letters are counted.
pub struct Letters<'c> {
    ev: &'c Evaluator<'c>,
    text: Rc<Str>,
}

impl<'c> NativeCall<'c> {
    /// The letters of a text, each found at once wherever it stands; None if the value is no text.
    ///
    /// # Errors
    /// The thread is to stop.
    pub fn letters(&self, value: &Value) -> R<Option<Letters<'c>>> {
        let Value::Str(text) = self.ev.unwrap_builtin(value) else {
            return Ok(None);
        };
        self.ev.index_chars(&text)?;
        Ok(Some(Letters { ev: self.ev, text }))
    }
}

impl Letters<'_> {
    /// The text.
    pub fn as_str(&self) -> &str {
        self.text.as_str()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.text.len()
    }

    /// Those from number `start` to before number `end`, as a text.
    ///
    /// # Errors
    /// `MemoryError`; the thread is to stop.
    pub fn part(&self, start: usize, end: usize) -> R<Value> {
        let end = end.min(self.count());
        self.ev.new_str_from(self.text.slice(start.min(end), end))
    }

    /// The byte that number `letter` begins at, or the length of the text.
    pub fn byte_of(&self, letter: usize) -> usize {
        self.text.byte_offset(letter.min(self.count()))
    }

    /// The number of the letter that begins at a byte.
    pub fn letter_at(&self, byte: usize) -> usize {
        self.text.char_index(byte)
    }
}

impl NativeCall<'_> {
    /// Argument number `index` in the order of the parameters; None if it was omitted.
    pub fn arg(&self, index: usize) -> Option<&Value> {
        self.args.get(index).and_then(Value::if_given)
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
    pub fn node(&self) -> NodeCursor {
        self.ev.core.nodes.state().for_new_thread()
    }

    /// A motion that the calling thread waited for has ended, or could not be done: a node that is to be shown after it
    /// is shown from now on, or not at all.
    pub fn on_motion_end(&self, failed: bool) {
        self.ev.core.nodes.on_motion_end(failed, self.line());
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
        self.ev.suspend(SuspendRequest::Wait(token))
    }

    /// An exception to return as error.
    pub fn raise(&self, kind: ExceptionKind, message: impl Into<ExceptionText>) -> Unwind {
        self.ev.raise(kind, message)
    }

    /// Adds advice to an exception, which the report of an uncaught one shows before its last line.
    pub fn with_help(&self, raised: Unwind, help: Text) -> Unwind {
        if let Unwind::Exception(exception) = &raised
            && let Some(state) = exception.exception()
        {
            *state.help.borrow_mut() = Some(Box::new(help));
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

    /// Runs work that comes back to itself through a value's parts, within the depth and the native stack there is. All
    /// recursion through values goes through here.
    ///
    /// # Errors
    /// `RecursionError`, or what `inner` raises.
    pub fn recurse<T>(&mut self, inner: impl FnOnce(&mut Self) -> R<T>) -> R<T> {
        let ev = self.ev;
        ev.with_native_depth(|| inner(self))
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
    pub fn charge_output(&self, bytes: usize) -> R<()> {
        self.ev.charge_output(bytes)
    }

    /// The evaluator, for the interpreter's own library.
    pub fn evaluator(&self) -> &Evaluator<'_> {
        self.ev
    }
}
