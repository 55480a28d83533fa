//! Exceptions of running programs: their kinds, how they are raised, how an uncaught one is reported.

use std::fmt::Write as _;
use std::rc::Rc;
use std::sync::Arc;

use elite_syntax::{SourceFile, Span, TaskNode};
use messages::{Language, Localized, Text, text};

use crate::eval::Evaluator;
use crate::stdlib;
use crate::value::exception::{ExceptionState, TracebackEntry};
use crate::value::instance::InstancePayload;
use crate::value::{Instance, R, Unwind, Value};

macro_rules! exceptions {
    ($($name:ident : $parent:ident,)*) => {
        /// Python's exception types.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        #[allow(missing_docs)]
        pub enum ExceptionKind { BaseException, $($name,)* }

        impl ExceptionKind {
            /// All kinds; a parent comes before its children.
            pub const ALL: &[ExceptionKind] = &[ExceptionKind::BaseException, $(ExceptionKind::$name,)*];

            /// The name of the type.
            pub fn name(self) -> &'static str {
                match self {
                    ExceptionKind::BaseException => "BaseException",
                    $(ExceptionKind::$name => stringify!($name),)*
                }
            }

            /// The type it is derived from.
            pub fn parent(self) -> Option<ExceptionKind> {
                match self {
                    ExceptionKind::BaseException => None,
                    $(ExceptionKind::$name => Some(ExceptionKind::$parent),)*
                }
            }
        }
    };
}

exceptions! {
    Exception: BaseException, GeneratorExit: BaseException, KeyboardInterrupt: BaseException,
    SystemExit: BaseException, BaseExceptionGroup: BaseException,
    ArithmeticError: Exception, FloatingPointError: ArithmeticError, OverflowError: ArithmeticError,
    ZeroDivisionError: ArithmeticError, AssertionError: Exception, AttributeError: Exception,
    BufferError: Exception, EOFError: Exception, ExceptionGroup: Exception, ImportError: Exception,
    ModuleNotFoundError: ImportError,
    LookupError: Exception, IndexError: LookupError, KeyError: LookupError, MemoryError: Exception,
    NameError: Exception, UnboundLocalError: NameError, OSError: Exception, BlockingIOError: OSError,
    ChildProcessError: OSError, ConnectionError: OSError, BrokenPipeError: ConnectionError,
    ConnectionAbortedError: ConnectionError, ConnectionRefusedError: ConnectionError,
    ConnectionResetError: ConnectionError, FileExistsError: OSError, FileNotFoundError: OSError,
    InterruptedError: OSError, IsADirectoryError: OSError, NotADirectoryError: OSError, PermissionError: OSError,
    ProcessLookupError: OSError, TimeoutError: OSError, ReferenceError: Exception, RuntimeError: Exception,
    NotImplementedError: RuntimeError, RecursionError: RuntimeError, StopIteration: Exception,
    StopAsyncIteration: Exception, SyntaxError: Exception, IndentationError: SyntaxError,
    TabError: IndentationError, SystemError: Exception, TypeError: Exception, ValueError: Exception,
    UnicodeError: ValueError, UnicodeDecodeError: UnicodeError, UnicodeEncodeError: UnicodeError,
    UnicodeTranslateError: UnicodeError, Warning: Exception, BytesWarning: Warning, DeprecationWarning: Warning,
    FutureWarning: Warning, ImportWarning: Warning, PendingDeprecationWarning: Warning, ResourceWarning: Warning,
    RuntimeWarning: Warning, SyntaxWarning: Warning, UnicodeWarning: Warning, UserWarning: Warning,
}

/// What an exception says. Programs see the English form.
#[derive(Clone, Debug)]
pub enum ExceptionText {
    /// Words that are the same in every language: Python's own, and those of programs.
    Words(String),
    /// A text of ours.
    Text(Text),
}

impl From<String> for ExceptionText {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl From<&str> for ExceptionText {
    fn from(words: &str) -> Self {
        Self::Words(words.to_owned())
    }
}

impl From<Text> for ExceptionText {
    fn from(text: Text) -> Self {
        Self::Text(text)
    }
}

impl Evaluator<'_> {
    /// An exception with a message.
    #[cold]
    #[inline(never)]
    pub fn raise(&self, kind: ExceptionKind, message: impl Into<ExceptionText>) -> Unwind {
        let class = self.core.types.exception(kind).clone();
        let state = match message.into() {
            ExceptionText::Words(words) => ExceptionState::with_message(words),
            ExceptionText::Text(text) => ExceptionState::with_text(text),
        };
        Unwind::Exception(Instance::new(
            class,
            InstancePayload::Exception(Box::new(state)),
        ))
    }

    /// An exception with a message about something that has a name, which its attribute `name` tells.
    #[cold]
    pub fn raise_about(&self, kind: ExceptionKind, message: String, name: &str) -> Unwind {
        let raised = self.raise(kind, message);
        if let Unwind::Exception(exception) = &raised {
            let symbol = self.core.symbols.intern("name");
            exception.set(symbol, Value::str(name), &self.core.symbols);
        }
        raised
    }

    /// An exception with arguments.
    #[cold]
    pub fn raise_args(&self, kind: ExceptionKind, args: Vec<Value>) -> Unwind {
        let class = self.core.types.exception(kind).clone();
        let state = ExceptionState::with_args(Value::tuple(args));
        Unwind::Exception(Instance::new(
            class,
            InstancePayload::Exception(Box::new(state)),
        ))
    }

    /// `TypeError`
    #[cold]
    pub fn type_error(&self, message: impl Into<ExceptionText>) -> Unwind {
        self.raise(ExceptionKind::TypeError, message)
    }

    /// `ValueError`
    #[cold]
    pub fn value_error(&self, message: impl Into<ExceptionText>) -> Unwind {
        self.raise(ExceptionKind::ValueError, message)
    }

    /// `MemoryError`
    #[cold]
    pub fn memory_error(&self, message: impl Into<ExceptionText>) -> Unwind {
        self.raise(ExceptionKind::MemoryError, message)
    }

    /// `RecursionError`
    #[cold]
    pub fn recursion_error(&self) -> Unwind {
        self.raise(
            ExceptionKind::RecursionError,
            "maximum recursion depth exceeded",
        )
    }

    /// Whether `raised` is an exception of this kind or one derived from it.
    pub fn is_kind(&self, raised: &Unwind, kind: ExceptionKind) -> bool {
        match raised {
            Unwind::Exception(exception) => exception
                .class
                .is_subclass_of(self.core.types.exception(kind)),
            Unwind::Stop => false,
        }
    }
}

/// One level of the call stack of an error.
#[derive(Clone, Debug)]
pub struct TraceFrame {
    /// Name of the function, `<module>` at the top level.
    pub function: String,
    /// The program text.
    pub file: Arc<SourceFile>,
    /// The expression that failed or called.
    pub span: Span,
    /// The line of that expression, from 1.
    pub line: u32,
    /// The column of that expression in characters, from 1.
    pub column: u32,
}

impl TraceFrame {
    /// Whether the text is one of the library that comes with the language, and of no program.
    pub fn is_in_library(&self) -> bool {
        stdlib::is_library(&self.file)
    }
}

/// An exception that no handler took: it ended its script thread.
#[derive(Clone, Debug)]
pub struct ScriptError {
    /// Name of the exception's type.
    pub exception: String,
    /// The exception as text.
    pub message: Text,
    /// The call stack, outermost first.
    pub traceback: Vec<TraceFrame>,
    /// The node of the pendant's task whose directive the thread passed last.
    pub node: Option<TaskNode>,
    /// Advice for the person who wrote the program: a name that was probably meant, how a function is called.
    pub help: Option<Text>,
    /// The exception this one was raised from, or while handling which it was raised.
    pub previous: Option<(Link, Box<ScriptError>)>,
}

/// How an exception is linked to the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// `raise … from …`
    Cause,
    /// Unwind while the other was being handled.
    Context,
}

impl ScriptError {
    /// The last line of the report: `Type: message`, or the type alone.
    pub fn headline(&self) -> Text {
        Text::of(self)
    }
}

impl std::fmt::Display for ScriptError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.fmt_in(Language::English, f)
    }
}

impl Localized for ScriptError {
    fn fmt_in(&self, language: Language, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.exception)?;
        match self.message.is_empty() {
            true => Ok(()),
            false => write!(f, ": {}", self.message.in_language(language)),
        }
    }
}

impl std::error::Error for ScriptError {}

/// Levels of a call stack that are printed at each end; what lies between is counted.
const FRAMES_SHOWN: usize = 12;

/// Renders an error for people: the call stack with source lines and carets, innermost last, then `Type: message`.
pub fn render_script_error(error: &ScriptError) -> Text {
    let [english, chinese] = [Language::English, Language::Chinese].map(|language| {
        let mut out = String::new();
        render_into(error, language, &mut out);
        out
    });
    Text::new(english, chinese)
}

fn render_into(error: &ScriptError, language: Language, out: &mut String) {
    if let Some((link, previous)) = &error.previous {
        render_into(previous, language, out);
        out.push_str(match link {
            Link::Cause => {
                "\nThe above exception was the direct cause of the following exception:\n\n"
            }
            Link::Context => {
                "\nDuring handling of the above exception, another exception occurred:\n\n"
            }
        });
    }
    if !error.traceback.is_empty() {
        out.push_str("Traceback (most recent call last):\n");
    }
    let frames = &error.traceback;
    let hidden = frames.len().saturating_sub(2 * FRAMES_SHOWN);
    for (index, frame) in frames.iter().enumerate() {
        if hidden > 0 && index == FRAMES_SHOWN {
            let more = text!("{hidden} more levels", "另有 {hidden} 层");
            let _ = writeln!(out, "  … {} …", more.in_language(language));
        }
        if hidden == 0 || index < FRAMES_SHOWN || index >= frames.len() - FRAMES_SHOWN {
            render_frame(frame, out);
        }
    }
    if let Some(node) = &error.node {
        let place = text!("in {node}", "位于{node}");
        let _ = writeln!(out, "  {}", place.in_language(language));
    }
    // Advice comes first: tools read the last line, which is always `Type: message`.
    if let Some(help) = &error.help {
        let _ = writeln!(out, "  help: {}", help.in_language(language));
    }
    let _ = writeln!(out, "{}", error.in_language(language));
}

fn render_frame(frame: &TraceFrame, out: &mut String) {
    let (name, line, column) = (frame.file.name(), frame.line, frame.column);
    let _ = writeln!(
        out,
        "  {name}, line {line}, column {column}, in {}",
        frame.function
    );
    let text = frame.file.line_text(line);
    let code = text.trim_start();
    if code.is_empty() {
        return;
    }
    let _ = writeln!(out, "    {}", code.trim_end());
    let indent = text.chars().count() - code.chars().count();
    let start = (column as usize).saturating_sub(1 + indent);
    let end = frame.file.position(frame.span.end);
    let on_line = if end.line == line {
        end.column as usize - 1
    } else {
        text.trim_end().chars().count()
    };
    let width = on_line.saturating_sub(start + indent).max(1);
    // Tabs are kept in the caret line, so that the carets stand below the text whatever a tab's width is.
    let before: String = code
        .chars()
        .take(start)
        .map(|c| if c == '\t' { '\t' } else { ' ' })
        .collect();
    let _ = writeln!(out, "    {before}{}", "^".repeat(width));
}

impl Evaluator<'_> {
    /// The report of an exception that nobody handled. Runs the exception's `__str__` if the script defines one.
    pub fn report(&self, exception: &Rc<Instance>) -> ScriptError {
        self.report_at(exception, 0)
    }

    fn report_at(&self, exception: &Rc<Instance>, depth: u32) -> ScriptError {
        let value = Value::Instance(exception.clone());
        let message = self
            .str(&value)
            .unwrap_or_else(|_| "<exception str() failed>".to_owned());
        let state = exception.exception();
        let message = state
            .and_then(|state| state.text_of(&message))
            .unwrap_or_else(|| Text::verbatim(message));
        let mut traceback: Vec<TraceFrame> = state
            .map(|s| s.traceback())
            .unwrap_or_default()
            .iter()
            .map(frame)
            .collect();
        traceback.reverse();
        let previous = state.and_then(|state| {
            let (cause, context) = (state.cause.get(), state.context.get());
            match (cause, context) {
                (Value::Instance(cause), _) => Some((Link::Cause, cause)),
                (_, Value::Instance(context)) if !state.suppress_context.get() => {
                    Some((Link::Context, context))
                }
                _ => None,
            }
        });
        let previous = previous.filter(|_| depth < 8);
        let previous =
            previous.map(|(link, other)| (link, Box::new(self.report_at(&other, depth + 1))));
        ScriptError {
            exception: self.exception_name(exception),
            message,
            traceback,
            node: self.core.nodes.passed().filter(|_| depth == 0),
            help: self.advice(exception),
            previous,
        }
    }

    /// The type of an exception as reports name it: with its module unless that is the program.
    fn exception_name(&self, exception: &Instance) -> String {
        let prefix = self.module_prefix(&exception.class);
        let prefix = if prefix == "__main__." { "" } else { &prefix };
        format!("{prefix}{}", self.qualname_of(&exception.class))
    }

    /// Python's chain of `__context__`: `raised` came up while `handled` was being dealt with.
    pub fn chain(&self, raised: &Unwind, handled: &Rc<Instance>) {
        if let Unwind::Exception(exception) = raised
            && let Some(state) = exception.exception()
        {
            if !exception.noted.get() {
                self.core.note_instance(exception);
            }
            state.set_context(exception, handled);
        }
    }

    /// A `KeyError` for a key.
    #[cold]
    pub fn key_error(&self, key: &Value) -> Unwind {
        self.raise_args(ExceptionKind::KeyError, vec![key.clone()])
    }

    /// Ends an iteration from native code.
    pub fn stop_iteration(&self, value: Value) -> R {
        let args = if value.is_none() {
            Vec::new()
        } else {
            vec![value]
        };
        Err(self.raise_args(ExceptionKind::StopIteration, args))
    }
}

fn frame(trace: &TracebackEntry) -> TraceFrame {
    let position = trace.code.file.position(trace.span.start);
    TraceFrame {
        function: trace.code.qualname.to_string(),
        file: trace.code.file.clone(),
        span: trace.span,
        line: position.line,
        column: position.column,
    }
}
