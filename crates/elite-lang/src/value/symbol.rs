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
///
/// A name that something is called by stays. One that a program only asks for (`getattr(o, name)`, a key of `**mapping`)
/// passes: it is forgotten when the last `Passing` for it is dropped, unless something has been called by it meanwhile.
pub struct Symbols {
    inner: RefCell<Inner>,
}

#[derive(Default)]
struct Inner {
    numbers: HashMap<Rc<str>, Symbol>,
    names: Vec<Name>,
    /// Numbers of names that have passed.
    free: Vec<Symbol>,
}

struct Name {
    text: Rc<str>,
    value: Rc<Str>,
    /// How many ask for it right now, if nothing is called by it yet.
    asked: Option<u32>,
}

/// A name for as long as somebody asks for it.
pub struct Passing<'s> {
    symbols: &'s Symbols,
    symbol: Symbol,
}

impl std::ops::Deref for Passing<'_> {
    type Target = Symbol;

    fn deref(&self) -> &Symbol {
        &self.symbol
    }
}

impl Drop for Passing<'_> {
    fn drop(&mut self) {
        self.symbols.no_longer_asked(self.symbol);
    }
}

impl Default for Symbols {
    fn default() -> Self {
        let symbols = Symbols {
            inner: RefCell::default(),
        };
        for (number, text) in KNOWN.iter().enumerate() {
            let symbol = symbols.intern(text);
            debug_assert_eq!(symbol, Symbol(number as u32), "{text} is listed twice");
        }
        symbols
    }
}

impl Symbols {
    /// The symbol for `name`, a new one if need be; from now on something is called by it.
    pub fn intern(&self, name: &str) -> Symbol {
        let mut inner = self.inner.borrow_mut();
        let symbol = inner.number(name, None);
        inner.names[symbol.0 as usize].asked = None;
        symbol
    }

    /// The symbol for `name`, to look for what is called by it. Whoever then calls something by it says so with `settle`.
    pub fn ask(&self, name: &str) -> Passing<'_> {
        let mut inner = self.inner.borrow_mut();
        let symbol = inner.number(name, Some(0));
        if let Some(asked) = &mut inner.names[symbol.0 as usize].asked {
            *asked += 1;
        }
        Passing {
            symbols: self,
            symbol,
        }
    }

    /// Something is called by this name from now on.
    pub fn settle(&self, symbol: Symbol) {
        self.inner.borrow_mut().names[symbol.0 as usize].asked = None;
    }

    fn no_longer_asked(&self, symbol: Symbol) {
        let mut inner = self.inner.borrow_mut();
        let name = &mut inner.names[symbol.0 as usize];
        let Some(asked) = &mut name.asked else { return };
        *asked -= 1;
        if *asked == 0 {
            let nothing: Rc<str> = Rc::from("");
            let text = std::mem::replace(&mut name.text, nothing);
            name.value = Rc::new(Str::new(""));
            inner.numbers.remove(&text);
            inner.free.push(symbol);
        }
    }

    /// The symbol for `name`, if anything has ever been called that.
    pub fn find(&self, name: &str) -> Option<Symbol> {
        self.inner.borrow().numbers.get(name).copied()
    }

    /// The text of a symbol.
    pub fn name(&self, symbol: Symbol) -> Rc<str> {
        self.inner.borrow().names[symbol.0 as usize].text.clone()
    }

    /// The text of a symbol as a value; always the same object.
    pub fn value(&self, symbol: Symbol) -> Value {
        Value::Str(self.inner.borrow().names[symbol.0 as usize].value.clone())
    }

    /// How many names there are.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.inner.borrow().numbers.len()
    }
}

impl Inner {
    fn number(&mut self, text: &str, asked: Option<u32>) -> Symbol {
        if let Some(symbol) = self.numbers.get(text) {
            return *symbol;
        }
        let name = Name {
            text: text.into(),
            value: Rc::new(Str::new(text)),
            asked,
        };
        let key = name.text.clone();
        let symbol = match self.free.pop() {
            Some(symbol) => {
                self.names[symbol.0 as usize] = name;
                symbol
            }
            None => {
                self.names.push(name);
                Symbol(self.names.len() as u32 - 1)
            }
        };
        self.numbers.insert(key, symbol);
        symbol
    }
}
