//! Names of attributes and keywords as small numbers, one table per interpreter.

use std::cell::{Cell, RefCell};
use std::hash::{BuildHasher, RandomState};
use std::rc::Rc;

use hashbrown::HashTable;

use super::by_symbol::SymbolSet;
use super::{Str, Value};

/// A name, by its number in the interpreter's table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Symbol(pub u32);

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
FGET = "fget", FSET = "fset", FDEL = "fdel", DIR = "__dir__", KEY = "key", SEP = "sep", END = "end", FILE = "file",
FLUSH = "flush", DEFAULT = "default",
KEYS = "keys", METACLASS = "metaclass", STRICT = "strict",
NOTES = "__notes__", THROW = "throw", SEND = "send",
BYTES = "__bytes__", SLOTS = "__slots__", WEAKREF = "__weakref__", OBJCLASS = "__objclass__",
LENGTH_HINT = "__length_hint__", THISCLASS = "__thisclass__", SELF_CLASS = "__self_class__",
KWDEFAULTS = "__kwdefaults__",
CLASSCELL = "__classcell__", INSTANCE_CHECK = "__instancecheck__", SUBCLASS_CHECK = "__subclasscheck__",
SUBCLASS_HOOK = "__subclasshook__",
ABSTRACT_METHODS = "__abstractmethods__", IS_ABSTRACT = "__isabstractmethod__", ABC_IMPL = "_abc_impl",
CLOSE = "close", MAIN = "__main__", }

/// The table of names of one interpreter.
///
/// A name of the interpreter's own stays. One that a program only asks for (`getattr(o, name)`, a key of `**mapping`)
/// passes: it is forgotten when the last `TempSymbol` for it is dropped, unless something has been called by it
/// meanwhile. What texts and attributes of a program are called by is given up when a `sweep` finds that nothing is
/// called so any more, so a program may go on making up names for ever.
pub struct Symbols {
    inner: RefCell<SymbolTable>,
    /// What the names weigh that a sweep may give up, and how much makes the next one due.
    sweepable_weight: Cell<usize>,
    /// Weight of the names that a sweep under way has found in use.
    kept: Cell<usize>,
    due: Cell<usize>,
    /// Names that were looked for lately, by the hash of their text; who asks here compares the text.
    recent: [Cell<Symbol>; RECENT],
}

/// Names that are found again without asking the table.
const RECENT: usize = 64;

/// A sweep is not worth it for less.
const LOOSE_MIN: usize = 2048;

/// What a name weighs: long ones count as several.
fn weight(text: &str) -> usize {
    1 + text.len() / 32
}

struct SymbolTable {
    numbers: SymbolIndex,
    names: Vec<SymbolEntry>,
    /// Numbers of names that have passed.
    free: Vec<Symbol>,
    /// What those are called.
    nothing: Rc<str>,
    nothing_value: Rc<Str>,
}

impl Default for SymbolTable {
    fn default() -> Self {
        SymbolTable {
            numbers: SymbolIndex::default(),
            names: Vec::new(),
            free: Vec::new(),
            nothing: "".into(),
            nothing_value: Rc::new(Str::new("")),
        }
    }
}

struct SymbolEntry {
    text: Rc<str>,
    hash: u64,
    value: Rc<Str>,
    /// How many ask for it right now.
    temp_refs: u32,
    retention: Retention,
}

/// How long a name stays.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Retention {
    /// While somebody asks for it.
    Temporary,
    /// While something is called by it, as far as is known.
    Used,
    /// The last sweep found nothing called by it. The next one gives it up, if there still is nothing then: whoever has
    /// taken it may not have had the time to call something by it.
    Unconfirmed,
    /// Always.
    Always,
}

/// A name for as long as somebody asks for it.
pub struct TempSymbol<'s> {
    symbols: &'s Symbols,
    symbol: Symbol,
}

impl std::ops::Deref for TempSymbol<'_> {
    type Target = Symbol;

    fn deref(&self) -> &Symbol {
        &self.symbol
    }
}

impl Drop for TempSymbol<'_> {
    fn drop(&mut self) {
        self.symbols.release_temp(self.symbol);
    }
}

impl Default for Symbols {
    fn default() -> Self {
        let symbols = Symbols {
            inner: RefCell::default(),
            sweepable_weight: Cell::new(0),
            kept: Cell::new(0),
            due: Cell::new(LOOSE_MIN),
            recent: [const { Cell::new(Symbol(0)) }; RECENT],
        };
        for (number, text) in KNOWN.iter().enumerate() {
            let symbol = symbols.intern(text);
            debug_assert_eq!(symbol, Symbol(number as u32), "{text} is listed twice");
        }
        symbols
    }
}

impl Symbols {
    /// The symbol for a name of the interpreter's own, a new one if need be; it stays.
    pub fn intern(&self, name: &str) -> Symbol {
        let mut inner = self.inner.borrow_mut();
        let symbol = inner.number(name);
        inner.names[symbol.0 as usize].retention = Retention::Always;
        symbol
    }

    /// The symbol for a name that a program has made up, a new one if need be. Something that
    /// `InterpreterState::sweep_names` looks at is called by it from now on, or soon.
    pub fn intern_used(&self, name: &str) -> Symbol {
        let symbol = self.inner.borrow_mut().number(name);
        self.mark_used(symbol);
        symbol
    }

    /// The symbol for `name`, to look for what is called by it. Whoever then calls something by it says so with
    /// `mark_used`.
    pub fn intern_temp(&self, name: &str) -> TempSymbol<'_> {
        let mut inner = self.inner.borrow_mut();
        let symbol = inner.number(name);
        inner.names[symbol.0 as usize].temp_refs += 1;
        TempSymbol {
            symbols: self,
            symbol,
        }
    }

    /// Something is called by this name from now on.
    pub fn mark_used(&self, symbol: Symbol) {
        let name = &mut self.inner.borrow_mut().names[symbol.0 as usize];
        match name.retention {
            Retention::Temporary => self
                .sweepable_weight
                .set(self.sweepable_weight.get() + weight(&name.text)),
            Retention::Unconfirmed => {}
            Retention::Used | Retention::Always => return,
        }
        name.retention = Retention::Used;
    }

    /// Whether so many names, or such long ones, have come into use that a sweep is worth it.
    pub fn sweep_is_due(&self) -> bool {
        self.sweepable_weight.get() >= self.due.get()
    }

    /// Begins to give up names that nothing is called by any more.
    pub fn begin_sweep(&self) {
        self.kept.set(0);
    }

    /// Goes on with it for up to `count` names from number `from` on; whether there are more. `used` are those that
    /// something is called by.
    pub fn sweep_some(&self, used: &SymbolSet, from: usize, count: usize) -> bool {
        let mut inner = self.inner.borrow_mut();
        let end = inner.names.len().min(from + count);
        for number in from..end {
            let symbol = Symbol(number as u32);
            let name = &mut inner.names[number];
            if !matches!(name.retention, Retention::Used | Retention::Unconfirmed) {
                continue;
            }
            let weight = weight(&name.text);
            name.retention = match name.retention {
                _ if used.contains(&symbol) => Retention::Used,
                Retention::Used => Retention::Unconfirmed,
                _ if name.temp_refs > 0 => Retention::Temporary,
                _ => {
                    inner.give_up(symbol);
                    continue;
                }
            };
            if name.retention != Retention::Temporary {
                self.kept.set(self.kept.get() + weight);
            }
        }
        inner.names.len() > end
    }

    /// Ends a sweep.
    pub fn end_sweep(&self) {
        self.inner.borrow_mut().numbers.shrink();
        let loose = self.kept.get();
        self.sweepable_weight.set(loose);
        self.due.set((loose * 2).max(LOOSE_MIN));
    }

    fn release_temp(&self, symbol: Symbol) {
        let mut inner = self.inner.borrow_mut();
        let name = &mut inner.names[symbol.0 as usize];
        name.temp_refs -= 1;
        if name.temp_refs == 0 && name.retention == Retention::Temporary {
            inner.give_up(symbol);
        }
    }

    /// The symbol for `name`, if anything has ever been called that.
    pub fn find(&self, name: &str) -> Option<Symbol> {
        self.inner.borrow().find(name)
    }

    /// The symbol for a text whose hash is known, or soon is, if anything has ever been called that.
    pub fn find_text(&self, name: &Str) -> Option<Symbol> {
        let recent = &self.recent[(name.hash() >> 32) as usize % RECENT];
        let inner = self.inner.borrow();
        let last = recent.get();
        if *inner.names.get(last.0 as usize)?.text == *name.as_str() {
            return Some(last);
        }
        let found = inner.find(name.as_str())?;
        recent.set(found);
        Some(found)
    }

    /// The text of a symbol.
    pub fn name(&self, symbol: Symbol) -> Rc<str> {
        self.inner.borrow().names[symbol.0 as usize].text.clone()
    }

    /// The text of a symbol as a value; always the same object.
    pub fn to_value(&self, symbol: Symbol) -> Value {
        Value::Str(self.inner.borrow().names[symbol.0 as usize].value.clone())
    }

    /// How many names there are.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.inner.borrow().numbers.count
    }
}

impl SymbolTable {
    fn give_up(&mut self, symbol: Symbol) {
        let name = &mut self.names[symbol.0 as usize];
        name.text = self.nothing.clone();
        name.value = self.nothing_value.clone();
        name.retention = Retention::Temporary;
        self.numbers.remove(name.hash, symbol);
        self.free.push(symbol);
    }

    fn find(&self, text: &str) -> Option<Symbol> {
        self.numbers
            .find(self.numbers.hash(text), text, &self.names)
    }

    fn number(&mut self, text: &str) -> Symbol {
        let hash = self.numbers.hash(text);
        if let Some(symbol) = self.numbers.find(hash, text, &self.names) {
            return symbol;
        }
        let name = SymbolEntry {
            text: text.into(),
            hash,
            value: Rc::new(Str::new(text)),
            temp_refs: 0,
            retention: Retention::Temporary,
        };
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
        self.numbers.insert(hash, symbol);
        symbol
    }
}

/// The numbers of names by their text: many small tables, because one of millions of names would take long to grow.
struct SymbolIndex {
    tables: Vec<HashTable<(u64, Symbol)>>,
    state: RandomState,
    count: usize,
}

const TABLES: usize = 64;

impl Default for SymbolIndex {
    fn default() -> Self {
        SymbolIndex {
            tables: (0..TABLES).map(|_| HashTable::new()).collect(),
            state: RandomState::new(),
            count: 0,
        }
    }
}

impl SymbolIndex {
    fn hash(&self, text: &str) -> u64 {
        self.state.hash_one(text)
    }

    /// The table for a hash; the tables themselves go by the lowest and the highest bits.
    fn table(hash: u64) -> usize {
        hash as usize >> 32 & (TABLES - 1)
    }

    fn find(&self, hash: u64, text: &str, names: &[SymbolEntry]) -> Option<Symbol> {
        let is_it = |(_, symbol): &(u64, Symbol)| *names[symbol.0 as usize].text == *text;
        self.tables[Self::table(hash)]
            .find(hash, is_it)
            .map(|(_, symbol)| *symbol)
    }

    fn insert(&mut self, hash: u64, symbol: Symbol) {
        self.tables[Self::table(hash)].insert_unique(hash, (hash, symbol), |(hash, _)| *hash);
        self.count += 1;
    }

    fn remove(&mut self, hash: u64, symbol: Symbol) {
        let table = &mut self.tables[Self::table(hash)];
        if let Ok(entry) = table.find_entry(hash, |(_, other)| *other == symbol) {
            entry.remove();
            self.count -= 1;
        }
    }

    fn shrink(&mut self) {
        for table in &mut self.tables {
            let room = table.len() * 2;
            table.shrink_to(room, |(hash, _)| *hash);
        }
    }
}
