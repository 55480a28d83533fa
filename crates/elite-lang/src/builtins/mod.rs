//! Python's builtin functions, types and their methods, and how natives of any kind are called.

mod call;
mod compile;
pub(crate) mod evaluate;
mod functions;
mod numbers;
pub mod quick;
pub(crate) mod reading;
mod runs;
mod scope;
mod short;
mod signature;
mod sort;
pub mod types;

use std::rc::Rc;

pub(crate) use call::EMBEDDER;
pub use quick::FastPath;
pub use signature::{Signature, is_slot};

use elite_syntax::ast::BinaryOp;

use crate::eval::{Evaluator, Frame, InterpreterState};
use crate::limits::deferred_drop;
use crate::native::NativeFunction;
use crate::value::{R, Symbol, Value};

/// A function written in Rust.
pub struct Builtin {
    /// `__name__`.
    pub name: &'static str,
    /// For methods: the name of the type, which messages put before the name.
    pub owner: Option<&'static str>,
    /// For functions of a module: its name, which some messages put before the name.
    pub module: Option<Rc<str>>,
    /// The parameters of the function.
    pub signature: Signature,
    /// What the function does.
    pub body: BuiltinBody,
    /// A call may put its arguments into the receiver, which then may become part of a cycle.
    pub stores_args: bool,
    /// The answer to calls that need no script code and take no time.
    pub fast_path: Option<FastPath>,
    /// What a method of a builtin sequence adds or repeats by, and whether its receiver stands on the right. As methods
    /// these refuse what they cannot take; as operators they leave it to the other operand.
    pub sequence_op: Option<(BinaryOp, bool)>,
    /// For methods: CPython's type has a slot for it, not an entry in its table of methods.
    pub is_slot: bool,
}

/// A function whose arguments are bound to the signature; omitted ones are `Unbound`.
pub type BoundFn = fn(&Evaluator<'_>, &mut [Value]) -> R;
/// A function that looks at its arguments itself.
pub type RawFn = fn(&Evaluator<'_>, &mut Args<'_>) -> R;

/// A function with data of its own, which holds no values: those it gets as `captured`. Values do not go from thread to
/// thread, so a closure that had captured one would not compile.
pub type ClosureFn = dyn Fn(&Evaluator<'_>, &[Value], &mut Args<'_>) -> R + Send;

/// What a builtin does.
pub enum BuiltinBody {
    /// A function that gets its arguments bound.
    Bound(BoundFn),
    /// A function that gets its arguments as they come.
    Raw(RawFn),
    /// With data of its own and arguments as they come.
    Closure {
        /// The values that are part of it.
        held: Vec<Value>,
        /// What it does with them and the arguments.
        body: Box<ClosureFn>,
    },
    /// A function of the embedder.
    Native(NativeFunction),
}

/// Arguments of a call.
pub struct Args<'a> {
    /// By position.
    pub positional: &'a mut [Value],
    /// By name.
    pub keywords: &'a [(Symbol, Value)],
    /// The frame that calls, if a script does.
    pub caller: Option<Frame<'a>>,
}

impl Args<'_> {
    /// The value of a keyword argument.
    pub fn keyword(&self, name: Symbol) -> Option<&Value> {
        self.keywords
            .iter()
            .find(|(other, _)| *other == name)
            .map(|(_, value)| value)
    }
}

impl Builtin {
    /// A function with bound arguments. For the form of `signature` see `Signature::parse`.
    pub fn bound(
        core: &InterpreterState,
        name: &'static str,
        signature: &str,
        body: BoundFn,
    ) -> Value {
        let signature = Signature::parse(signature, &core.symbols);
        Value::Builtin(Rc::new(Builtin {
            name,
            owner: None,
            module: None,
            signature,
            body: BuiltinBody::Bound(body),
            stores_args: false,
            fast_path: quick::find(None, None, name),
            sequence_op: None,
            is_slot: false,
        }))
    }

    /// A function of a module, with bound arguments.
    pub fn of_module(
        core: &InterpreterState,
        module: &Rc<str>,
        name: &'static str,
        signature: &str,
        body: BoundFn,
    ) -> Value {
        Value::Builtin(Rc::new(Builtin {
            name,
            owner: None,
            module: Some(module.clone()),
            signature: Signature::parse(signature, &core.symbols),
            body: BuiltinBody::Bound(body),
            stores_args: false,
            fast_path: quick::find(None, Some(module), name),
            sequence_op: None,
            is_slot: false,
        }))
    }

    /// A function that takes its arguments as they come.
    pub fn raw(name: &'static str, body: RawFn) -> Value {
        let signature = Signature::default();
        Value::Builtin(Rc::new(Builtin {
            name,
            owner: None,
            module: None,
            signature,
            body: BuiltinBody::Raw(body),
            stores_args: false,
            fast_path: quick::find(None, None, name),
            sequence_op: None,
            is_slot: false,
        }))
    }

    /// A function with data of its own. Values that are part of it are `captured`, where dropping and the search for
    /// cycles find them; the closure can capture none.
    pub fn closure(
        name: &'static str,
        held: Vec<Value>,
        body: impl Fn(&Evaluator<'_>, &[Value], &mut Args<'_>) -> R + Send + 'static,
    ) -> Value {
        let signature = Signature::default();
        let body = BuiltinBody::Closure {
            held,
            body: Box::new(body),
        };
        Value::Builtin(Rc::new(Builtin {
            name,
            owner: None,
            module: None,
            signature,
            body,
            stores_args: false,
            fast_path: None,
            sequence_op: None,
            is_slot: false,
        }))
    }

    /// The values that are part of it.
    pub fn captured(&self) -> &[Value] {
        match &self.body {
            BuiltinBody::Closure { held, .. } => held,
            _ => &[],
        }
    }

    /// A native of the embedder.
    pub fn native(core: &InterpreterState, native: NativeFunction) -> Value {
        let (name, signature) = (native.name, Signature::of_native(&native, &core.symbols));
        Value::Builtin(Rc::new(Builtin {
            name,
            owner: None,
            module: None,
            signature,
            body: BuiltinBody::Native(native),
            stores_args: false,
            fast_path: None,
            sequence_op: None,
            is_slot: false,
        }))
    }
}

impl Drop for Builtin {
    fn drop(&mut self) {
        if let BuiltinBody::Closure { held, .. } = &mut self.body {
            deferred_drop::drop_values(held);
        }
    }
}

/// Puts all builtins in place.
pub fn install(core: &Rc<InterpreterState>) {
    for class in core.types.all().into_iter().chain(core.types.exceptions()) {
        let name = class.name();
        if elite_syntax::python_names::is_builtin_name(&name) {
            core.builtins
                .set(core.symbols.intern(&name), Value::Class(class.clone()));
        }
    }
    let alias = |alias: &str, name: &str| {
        let value = core
            .builtins
            .get(core.symbols.intern(name))
            .unwrap_or_default();
        core.builtins.set(core.symbols.intern(alias), value);
    };
    alias("IOError", "OSError");
    alias("EnvironmentError", "OSError");
    core.builtins
        .set(core.symbols.intern("Ellipsis"), Value::Ellipsis);
    core.builtins
        .set(core.symbols.intern("NotImplemented"), Value::NotImplemented);
    core.builtins
        .set(core.symbols.intern("__debug__"), Value::Bool(true));
    functions::install(core);
    types::install(core);
    alias("unichr", "chr");
}
