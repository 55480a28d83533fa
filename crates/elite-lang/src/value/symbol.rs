//! Names of attributes and keywords as small numbers, one table per interpreter.

use std::cell::RefCell;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::rc::Rc;

use super::{Str, Value};

/// A name, by its number in the interpreter's table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Symbol(pub u32);

/// Tables by symbol.
pub type SymbolMap<V> = HashMap<Symbol, V, BuildHasherDefault<SymbolHasher>>;

/// Spreads symbols over a table: they are numbers that the interpreter gives out itself, so nobody can choose them to
/// collide.
#[derive(Default)]
pub struct SymbolHasher(u64);

impl Hasher for SymbolHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes
            .iter()
            .for_each(|byte| self.write_u32(u32::from(*byte)));
    }

    #[inline]
    fn write_u32(&mut self, number: u32) {
        self.0 = (self.0 ^ u64::from(number)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    #[inline]
    fn finish(&self) -> u64 {
        self.0
    }
}

macro_rules! known_symbols {
    ($($name:ident = $text:literal,)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Number { $($name,)* }

        /// Names the evaluator itself looks up.
        #[allow(missing_docs)]
        pub mod known {
            use super::{Number, Symbol};
            $(pub const $name: Symbol = Symbol(Number::$name as u32);)*
        }

        const KNOWN: &[&str] = &[$($text,)*];
    };
}

known_symbols! {
INIT = "__init__", NEW = "__new__", CALL = "__call__", STR = "__str__", REPR = "__repr__",
FORMAT = "__format__", HASH = "__hash__", BOOL = "__bool__", LEN = "__len__",
GETITEM = "__getitem__", SETITEM = "__setitem__", DELITEM = "__delitem__",
CONTAINS = "__contains__", ITER = "__iter__", NEXT = "__next__", REVERSED = "__reversed__",
MISSING = "__missing__", GETATTR = "__getattr__", GETATTRIBUTE = "__getattribute__", SETATTR = "__setattr__",
DELATTR = "__delattr__", GET = "__get__", SET = "__set__", DELETE = "__delete__", SET_NAME = "__set_name__",
INIT_SUBCLASS = "__init_subclass__", CLASS_GETITEM = "__class_getitem__", ENTER = "__enter__", EXIT = "__exit__",
EQ = "__eq__", NE = "__ne__", LT = "__lt__", LE = "__le__", GT = "__gt__", GE = "__ge__",
ADD = "__add__", SUB = "__sub__", MUL = "__mul__", TRUEDIV = "__truediv__", FLOORDIV = "__floordiv__",
MOD = "__mod__", POW = "__pow__", MATMUL = "__matmul__", AND = "__and__", OR = "__or__", XOR = "__xor__",
LSHIFT = "__lshift__", RSHIFT = "__rshift__", DIVMOD = "__divmod__",
RADD = "__radd__", RSUB = "__rsub__", RMUL = "__rmul__", RTRUEDIV = "__rtruediv__",
RFLOORDIV = "__rfloordiv__", RMOD = "__rmod__", RPOW = "__rpow__", RMATMUL = "__rmatmul__", RAND = "__rand__",
ROR = "__ror__", RXOR = "__rxor__", RLSHIFT = "__rlshift__", RRSHIFT = "__rrshift__", RDIVMOD = "__rdivmod__",
IADD = "__iadd__", ISUB = "__isub__", IMUL = "__imul__", ITRUEDIV = "__itruediv__",
IFLOORDIV = "__ifloordiv__", IMOD = "__imod__", IPOW = "__ipow__", IMATMUL = "__imatmul__", IAND = "__iand__",
IOR = "__ior__", IXOR = "__ixor__", ILSHIFT = "__ilshift__", IRSHIFT = "__irshift__",
NEG = "__neg__", POS = "__pos__", INVERT = "__invert__", ABS = "__abs__", INT = "__int__",
FLOAT = "__float__", COMPLEX = "__complex__", INDEX = "__index__", ROUND = "__round__", TRUNC = "__trunc__",
CLASS = "__class__", DICT = "__dict__", NAME = "__name__", QUALNAME = "__qualname__", DOC = "__doc__",
MODULE = "__module__", BASES = "__bases__", BASE = "__base__", MRO = "__mro__", FUNC = "__func__", SELF = "__self__",
DEFAULTS = "__defaults__", WRAPPED = "__wrapped__", ANNOTATIONS = "__annotations__",
CAUSE = "__cause__", CONTEXT = "__context__", SUPPRESS_CONTEXT = "__suppress_context__",
TRACEBACK = "__traceback__", ARGS = "args", VALUE = "value", CODE = "code", REAL = "real", IMAG = "imag",
NUMERATOR = "numerator", DENOMINATOR = "denominator", START = "start", STOP = "stop", STEP = "step",
FGET = "fget", FSET = "fset", FDEL = "fdel", DIR = "__dir__", KEY = "key", SEP = "sep", END = "end", FILE = "file", FLUSH = "flush", DEFAULT = "default",
KEYS = "keys", METACLASS = "metaclass", STRICT = "strict",
NOTES = "__notes__", THROW = "throw", SEND = "send",
BYTES = "__bytes__", SLOTS = "__slots__", THISCLASS = "__thisclass__", KWDEFAULTS = "__kwdefaults__",
CLASSCELL = "__classcell__", CLOSE = "close", MAIN = "__main__", }

/// The table of names of one interpreter.
pub struct Symbols {
    inner: RefCell<Inner>,
}

struct Inner {
    numbers: HashMap<Rc<str>, Symbol>,
    names: Vec<(Rc<str>, Rc<Str>)>,
}

impl Default for Symbols {
    fn default() -> Self {
        let symbols = Symbols {
            inner: RefCell::new(Inner {
                numbers: HashMap::new(),
                names: Vec::new(),
            }),
        };
        for (number, text) in KNOWN.iter().enumerate() {
            let symbol = symbols.intern(text);
            debug_assert_eq!(symbol, Symbol(number as u32), "{text} is listed twice");
        }
        symbols
    }
}

impl Symbols {
    /// The symbol for `name`, a new one if need be.
    pub fn intern(&self, name: &str) -> Symbol {
        let mut inner = self.inner.borrow_mut();
        if let Some(symbol) = inner.numbers.get(name) {
            return *symbol;
        }
        let symbol = Symbol(inner.names.len() as u32);
        let text: Rc<str> = name.into();
        inner.numbers.insert(text.clone(), symbol);
        inner.names.push((text, Rc::new(Str::new(name))));
        symbol
    }

    /// The symbol for `name`, if anything has ever been called that.
    pub fn find(&self, name: &str) -> Option<Symbol> {
        self.inner.borrow().numbers.get(name).copied()
    }

    /// The text of a symbol.
    pub fn name(&self, symbol: Symbol) -> Rc<str> {
        self.inner.borrow().names[symbol.0 as usize].0.clone()
    }

    /// The text of a symbol as a value; always the same object.
    pub fn value(&self, symbol: Symbol) -> Value {
        Value::Str(self.inner.borrow().names[symbol.0 as usize].1.clone())
    }
}
