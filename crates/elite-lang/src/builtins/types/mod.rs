//! Constructors and methods of the builtin types, one file a type.

mod bounds;
pub mod bytes;
mod bytes_hex;
mod bytes_layout;
mod bytes_parts;
mod bytes_search;
mod codec;
pub mod descriptor;
mod dict;
mod dunder;
mod exception;
mod float_hex;
mod float_text;
mod function;
pub mod group;
mod iterators;
mod list;
mod module;
mod number;
mod object;
pub mod range;
mod reduce;
mod set;
mod string;
pub mod union;
mod wrappers;

pub use dunder::install_next;
pub use number::int_from;

use std::rc::Rc;

use elite_syntax::ast::BinaryOp;

use super::signature::is_slot;
use super::{BoundFn, Builtin, BuiltinBody, RawFn, Signature, quick};
use crate::eval::{Evaluator, InterpreterState};
use crate::value::class::BuiltinBase;
use crate::value::function::WrappedFunction;
use crate::value::{Class, R, Unwind, Value};

/// Puts them in place.
pub fn install(core: &Rc<InterpreterState>) {
    object::install(core);
    module::install(core);
    number::install(core);
    string::install(core);
    bytes::install(core);
    list::install(core);
    range::install(core);
    dict::install(core);
    set::install(core);
    function::install(core);
    iterators::install(core);
    exception::install(core);
    reduce::install(core);
    group::install(core);
    dunder::install(core);
    union::install(core);
    descriptor::install(core);
}

/// The name of a builtin type, which lives as long as the program.
fn static_name(class: &Class) -> &'static str {
    let name = class.name();
    let mut names = elite_syntax::python_names::builtin_names()
        .chain(crate::eval::types::NAMES.iter().copied());
    names.find(|known| **known == *name).unwrap_or("object")
}

/// Gives a class methods with bound arguments; the receiver is the first one.
fn methods(core: &InterpreterState, class: &Class, list: &[(&'static str, &str, BoundFn)]) {
    let owner = Some(static_name(class));
    for (name, signature, body) in list {
        let signature = Signature::parse(&format!("self {signature}"), &core.symbols);
        let body = BuiltinBody::Bound(*body);
        class.set(
            core.symbols.intern(name),
            Value::Builtin(Rc::new(Builtin {
                name,
                owner,
                module: None,
                signature,
                body,
                stores_args: holds_items(class),
                fast_path: quick::find(owner, None, name),
                sequence_op: owner.and_then(|owner| joins(owner, name)),
                is_slot: is_slot(owner, name),
            })),
        );
    }
}

/// `Builtin::sequence_op` of a method of this name.
pub fn joins(owner: &str, name: &str) -> Option<(BinaryOp, bool)> {
    let is_sequence = matches!(
        owner,
        "str" | "list" | "tuple" | "bytes" | "bytearray" | "deque"
    );
    if !is_sequence {
        return None;
    }
    match name {
        "__add__" | "__iadd__" => Some((BinaryOp::Add, false)),
        "__mul__" | "__imul__" => Some((BinaryOp::Mul, false)),
        "__rmul__" => Some((BinaryOp::Mul, true)),
        _ => None,
    }
}

/// Whether methods of a class may put their arguments into the receiver.
fn holds_items(class: &Class) -> bool {
    matches!(
        class.base,
        BuiltinBase::List | BuiltinBase::Dict | BuiltinBase::Set | BuiltinBase::Exception
    )
}

/// Gives a class a method that takes its arguments as they come.
fn raw_method(core: &InterpreterState, class: &Class, name: &'static str, body: RawFn) {
    let (owner, signature) = (Some(static_name(class)), Signature::default());
    let body = BuiltinBody::Raw(body);
    class.set(
        core.symbols.intern(name),
        Value::Builtin(Rc::new(Builtin {
            name,
            owner,
            module: None,
            signature,
            body,
            stores_args: holds_items(class),
            fast_path: None,
            sequence_op: None,
            is_slot: is_slot(owner, name),
        })),
    );
}

/// Gives a class a static or class method; for the latter the class is the first argument.
fn class_method(
    core: &InterpreterState,
    class: &Class,
    name: &'static str,
    signature: &str,
    body: BoundFn,
) {
    let function = Builtin {
        name,
        owner: Some(static_name(class)),
        module: None,
        signature: Signature::parse(&format!("cls {signature}"), &core.symbols),
        body: BuiltinBody::Bound(body),
        stores_args: false,
        fast_path: None,
        sequence_op: None,
        is_slot: false,
    };
    class.set(
        core.symbols.intern(name),
        Value::ClassMethod(WrappedFunction::around(Value::Builtin(Rc::new(function)))),
    );
}

/// Refuses what is no text as the format specification that `__format__` is called with.
fn check_spec(ev: &Evaluator<'_>, spec: &Value) -> R<()> {
    if matches!(ev.unwrap_builtin(spec), Value::Str(_)) {
        return Ok(());
    }
    let name = ev.core.types.name_of_argument(spec);
    Err(ev.type_error(format!("__format__() argument must be str, not {name}")))
}

impl Evaluator<'_> {
    /// What a class method of a builtin type has made, as an object of the class it was called on.
    fn of_class(&self, class: &Value, made: Value) -> R {
        match class {
            Value::Class(class) if !Rc::ptr_eq(class, self.core.types.of(&made)) => {
                self.call1(&Value::Class(class.clone()), made)
            }
            _ => Ok(made),
        }
    }
}

/// What calling the class does.
fn constructor(core: &InterpreterState, class: &Class, signature: &str, body: BoundFn) {
    class
        .constructor
        .put(Builtin::bound(core, static_name(class), signature, body));
}

/// What calling the class does, with arguments as they come.
fn raw_constructor(class: &Class, body: RawFn) {
    class
        .constructor
        .put(Builtin::raw(static_name(class), body));
}

/// The error for a receiver of the wrong type.
#[cold]
fn wrong_receiver(ev: &Evaluator<'_>, wanted: &str, value: &Value) -> Unwind {
    let name = ev.core.types.name_of(value);
    ev.type_error(format!(
        "descriptor requires a '{wanted}' object but received a '{name}'"
    ))
}

/// Where `insert` puts an item in a sequence of `length`: negative indices count from the end, others beyond an end
/// mean that end.
pub fn insertion_place(index: i64, length: usize) -> usize {
    let from_start = if index < 0 {
        index.saturating_add(length as i64).max(0)
    } else {
        index
    };
    usize::try_from(from_start)
        .unwrap_or(usize::MAX)
        .min(length)
}
