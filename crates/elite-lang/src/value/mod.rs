//! Values of running programs: 16 bytes each, numbers in place, everything else behind an `Rc`.
//!
//! One interpreter owns its values and never shares them with another thread: no atomics, no locks. The files beside
//! this one hold one type each; what operators do with them is in `ops`.

pub mod attrs;
pub mod by_symbol;
pub mod bytes;
pub mod class;
pub mod count;
pub mod data;
pub mod dict;
pub mod embed;
pub mod exception;
pub mod function;
pub mod held;
pub mod instance;
pub mod int;
pub mod iter;
pub mod list;
pub mod module;
pub mod order;
pub mod range;
pub mod set;
pub mod string;
pub mod symbol;
pub mod weak;

use std::cell::Cell;
use std::rc::Rc;

use compact_str::CompactString;
use num_bigint::BigInt;

pub use crate::limits::value_vec::ValueVec;
pub use bytes::{ByteArray, Bytes};
pub use class::Class;
pub use dict::{Dict, DictView};
pub use function::{BoundMethod, Function};
pub use held::ScriptCell;
pub use instance::Instance;
pub use iter::Iter;
pub use list::{List, Tuple};
pub use module::Module;
pub use range::{LongRange, Range, Slice};
pub use set::Set;
pub use string::Str;
pub use symbol::Symbol;

use crate::builtins::Builtin;
use crate::eval::code::Code;
use crate::eval::generator::Generator;

/// Any value of a program.
///
/// The tag is a whole word: values are then moved as two words, each of which is read as it was written. With a tag of
/// one byte the compiler moves the other fifteen in pieces that overlap the payload, and the processor has to wait for
/// the stores it has just made.
#[derive(Default)]
#[repr(u64)]
#[allow(missing_docs)]
pub enum Value {
    /// Not a value: an empty slot, an omitted argument.
    #[default]
    Unbound,
    None,
    Ellipsis,
    NotImplemented,
    Bool(bool),
    Int(i64),
    Float(f64),
    /// Integers that do not fit `Int`; never one that would.
    BigInt(Rc<BigInt>),
    /// Real and imaginary part.
    Complex(Rc<(f64, f64)>),
    Str(Rc<Str>),
    Bytes(Rc<Bytes>),
    ByteArray(Rc<ByteArray>),
    List(Rc<List>),
    Tuple(Rc<Tuple>),
    Dict(Rc<Dict>),
    DictView(Rc<DictView>),
    Set(Rc<Set>),
    FrozenSet(Rc<Set>),
    Range(Rc<Range>),
    /// Ranges that do not fit `Range`; never one that would.
    LongRange(Rc<LongRange>),
    Slice(Rc<Slice>),
    Function(Rc<Function>),
    BoundMethod(Rc<BoundMethod>),
    Builtin(Rc<Builtin>),
    Class(Rc<Class>),
    Instance(Rc<Instance>),
    Module(Rc<Module>),
    Iter(Rc<Iter>),
    Generator(Rc<Generator>),
    Property(Rc<function::Property>),
    StaticMethod(Rc<function::WrappedFunction>),
    ClassMethod(Rc<function::WrappedFunction>),
    Super(Rc<function::Super>),
    /// Only in slots: a variable shared with inner functions.
    Cell(Rc<CellVar>),
    /// Only in searches for cycles: code of an evaluated text, which refers to variables of the text.
    Code(Rc<Code>),
}

impl Clone for Value {
    /// Without a call, whatever it is (`count`).
    #[inline(always)]
    fn clone(&self) -> Self {
        self.clone_counted()
    }
}

const _: () = assert!(size_of::<Value>() == 16);

const _: () = assert!(size_of::<Result<Value, Unwind>>() == 16);

/// A variable shared between a function and functions inside it.
#[derive(Default)]
pub struct CellVar {
    /// The current value; `replace` changes it.
    pub value: ScriptCell<Value>,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

impl CellVar {
    /// A cell with this value.
    pub fn new(value: Value) -> Rc<Self> {
        Rc::new(CellVar {
            value: ScriptCell::new(value),
            noted: Cell::new(false),
            old: Cell::new(false),
        })
    }

    /// Puts a value in the place of the one before, which is given back.
    #[inline(always)]
    #[must_use = "what was kept is dropped only now"]
    pub fn replace(&self, value: Value) -> Value {
        let is_unbound = value.is_unbound();
        let old = self.value.replace(value);
        if old.is_unbound() != is_unbound {
            note_binding();
        }
        old
    }

    /// Takes the value out; it is unbound then.
    #[must_use = "what was kept is dropped only now"]
    pub fn take(&self) -> Value {
        self.replace(Value::Unbound)
    }
}

thread_local! {
    static BINDINGS: Cell<u64> = const { Cell::new(0) };
}

#[cold]
#[inline(never)]
fn note_binding() {
    let _ = BINDINGS.try_with(|bindings| bindings.set(bindings.get() + 1));
}

/// How often a variable of this OS thread has become bound or unbound: while it is the same, so is which of them are.
pub fn bindings() -> u64 {
    BINDINGS.try_with(Cell::get).unwrap_or(u64::MAX)
}

impl Drop for CellVar {
    fn drop(&mut self) {
        crate::limits::deferred_drop::drop_value(self.value.get_mut());
    }
}

/// The reason for which evaluation does not go on: an exception on its way to a handler, or the stop of the thread,
/// which no handler sees. One word, so that results stay in two registers.
#[derive(Clone)]
pub enum Unwind {
    /// An exception; always an instance of a class derived from `BaseException`.
    Exception(Rc<Instance>),
    /// The thread is being stopped: only `finally` blocks and `with` exits run.
    Stop,
}

impl std::fmt::Debug for Unwind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Unwind::Exception(instance) => write!(f, "Unwind({})", instance.class.name()),
            Unwind::Stop => f.write_str("Unwind(stop)"),
        }
    }
}

/// What most operations return.
pub type R<T = Value> = Result<T, Unwind>;

impl Value {
    /// Whether dropping it does nothing.
    #[inline(always)]
    pub fn is_immediate(&self) -> bool {
        matches!(
            self,
            Value::Unbound
                | Value::None
                | Value::Ellipsis
                | Value::NotImplemented
                | Value::Bool(_)
                | Value::Int(_)
                | Value::Float(_)
        )
    }

    /// Replaces it; the one before goes as in `drop_inline`.
    #[inline(always)]
    pub fn put(&mut self, value: Value) {
        std::mem::replace(self, value).drop_inline();
    }

    /// Puts a value into an empty slot.
    #[inline(always)]
    pub fn fill(&mut self, value: Value) {
        let empty = std::mem::replace(self, value);
        debug_assert!(empty.is_immediate());
        std::mem::forget(empty);
    }

    /// A new string.
    pub fn str(text: impl Into<CompactString>) -> Value {
        Value::Str(Rc::new(Str::new(text)))
    }

    /// A new list.
    pub fn list(items: Vec<Value>) -> Value {
        Value::List(Rc::new(List::new(items)))
    }

    /// A new tuple.
    pub fn tuple(items: Vec<Value>) -> Value {
        let items = match <[Value; 2]>::try_from(items) {
            Ok(two) => return Value::Tuple(Rc::new(Tuple::of_two(two))),
            Err(items) => items,
        };
        Value::Tuple(Rc::new(match <[Value; 3]>::try_from(items) {
            Ok(three) => Tuple::of_three(three),
            Err(items) => Tuple::new(items),
        }))
    }

    /// A new tuple of two items.
    #[inline]
    pub fn pair(first: Value, second: Value) -> Value {
        Value::Tuple(Rc::new(Tuple::of_two([first, second])))
    }

    /// A new tuple of three items.
    #[inline]
    pub fn triple(items: [Value; 3]) -> Value {
        Value::Tuple(Rc::new(Tuple::of_three(items)))
    }

    /// An integer of any size, in place if it fits.
    pub fn bigint(value: BigInt) -> Value {
        if value.magnitude().iter_u64_digits().len() > 1 {
            return Value::BigInt(Rc::new(value));
        }
        match i64::try_from(&value) {
            Ok(small) => Value::Int(small),
            Err(_) => Value::BigInt(Rc::new(value)),
        }
    }

    /// A complex number.
    pub fn complex(real: f64, imaginary: f64) -> Value {
        Value::Complex(Rc::new((real, imaginary)))
    }

    /// Whether this is an empty slot or an omitted argument.
    #[inline]
    pub fn is_unbound(&self) -> bool {
        matches!(self, Value::Unbound)
    }

    /// Whether it can hold other values, and so be part of a cycle.
    #[inline]
    pub fn can_hold_values(&self) -> bool {
        match self {
            Value::Unbound
            | Value::None
            | Value::Ellipsis
            | Value::NotImplemented
            | Value::Bool(_)
            | Value::Int(_)
            | Value::Float(_)
            | Value::Str(_)
            | Value::BigInt(_)
            | Value::Complex(_)
            | Value::Bytes(_)
            | Value::ByteArray(_)
            | Value::Range(_)
            | Value::LongRange(_)
            | Value::Module(_) => false,
            // Builtin types stay as long as the interpreter.
            Value::Class(class) => class.is_script,
            Value::List(_)
            | Value::Tuple(_)
            | Value::Dict(_)
            | Value::DictView(_)
            | Value::Set(_)
            | Value::FrozenSet(_)
            | Value::Slice(_)
            | Value::Function(_)
            | Value::BoundMethod(_)
            | Value::Builtin(_)
            | Value::Instance(_)
            | Value::Iter(_)
            | Value::Generator(_)
            | Value::Property(_)
            | Value::StaticMethod(_)
            | Value::ClassMethod(_)
            | Value::Super(_)
            | Value::Cell(_)
            | Value::Code(_) => true,
        }
    }

    /// Whether this is `None`.
    #[inline]
    pub fn is_none(&self) -> bool {
        matches!(self, Value::None)
    }

    /// None for an omitted argument.
    pub fn if_given(&self) -> Option<&Value> {
        (!self.is_unbound()).then_some(self)
    }

    /// Python's `is`.
    pub fn is(&self, other: &Value) -> bool {
        match (self, other) {
            (Value::None, Value::None)
            | (Value::Ellipsis, Value::Ellipsis)
            | (Value::NotImplemented, Value::NotImplemented) => true,
            (Value::Bool(a), Value::Bool(b)) => a == b,
            // There is one empty tuple.
            (Value::Tuple(a), Value::Tuple(b)) if a.items().is_empty() && b.items().is_empty() => {
                true
            }
            // There is one empty text, and one empty `bytes`.
            (Value::Str(a), Value::Str(b)) if a.as_str().is_empty() && b.as_str().is_empty() => {
                true
            }
            (Value::Bytes(a), Value::Bytes(b)) if a.data().is_empty() && b.data().is_empty() => {
                true
            }
            // Numbers have no identity of their own here; equal bits are the same object.
            (Value::Int(a), Value::Int(b)) => a == b,
            (Value::BigInt(a), Value::BigInt(b)) => a == b,
            (Value::Float(a), Value::Float(b)) => a.to_bits() == b.to_bits(),
            _ => match (self.ref_counts(), other.ref_counts()) {
                (Some(a), Some(b)) => self.kind() == other.kind() && Rc::ptr_eq(a, b),
                _ => false,
            },
        }
    }

    /// Where the object lies, for everything behind an `Rc`.
    pub fn address(&self) -> Option<usize> {
        fn of<T: ?Sized>(rc: &Rc<T>) -> Option<usize> {
            Some(Rc::as_ptr(rc).cast::<()>() as usize)
        }
        match self {
            Value::Unbound | Value::None | Value::Ellipsis | Value::NotImplemented => None,
            Value::Bool(_) | Value::Int(_) | Value::Float(_) => None,
            Value::BigInt(rc) => of(rc),
            Value::Complex(rc) => of(rc),
            Value::Str(rc) => of(rc),
            Value::Bytes(rc) => of(rc),
            Value::ByteArray(rc) => of(rc),
            Value::List(rc) => of(rc),
            Value::Tuple(rc) => of(rc),
            Value::Dict(rc) => of(rc),
            Value::DictView(rc) => of(rc),
            Value::Set(rc) | Value::FrozenSet(rc) => of(rc),
            Value::Range(rc) => of(rc),
            Value::LongRange(rc) => of(rc),
            Value::Slice(rc) => of(rc),
            Value::Function(rc) => of(rc),
            Value::BoundMethod(rc) => of(rc),
            Value::Builtin(rc) => of(rc),
            Value::Class(rc) => of(rc),
            Value::Instance(rc) => of(rc),
            Value::Module(rc) => of(rc),
            Value::Iter(rc) => of(rc),
            Value::Generator(rc) => of(rc),
            Value::Property(rc) => of(rc),
            Value::StaticMethod(rc) | Value::ClassMethod(rc) => of(rc),
            Value::Super(rc) => of(rc),
            Value::Cell(rc) => of(rc),
            Value::Code(rc) => of(rc),
        }
    }
}
