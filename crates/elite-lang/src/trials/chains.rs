//! Each kind of value that can hold another, a long chain of it: dropped, shown, compared, hashed, copied, called,
//! walked through. Everything ends with a result or an exception of the script; a native stack that overflows ends the
//! test.

use super::{begin, drive, task};
use crate::Value;
use crate::value::Iter;

/// How a kind of value is nested.
enum Nesting {
    /// The value holds no other value.
    Flat,
    /// By these chains of `CHAINS`.
    Chains(&'static [&'static str]),
}

use Nesting::{Chains, Flat};

/// Every kind of value has its place here; there is no wildcard on purpose.
fn nesting(value: &Value) -> Nesting {
    match value {
        Value::Unbound
        | Value::None
        | Value::Ellipsis
        | Value::NotImplemented
        | Value::Bool(_)
        | Value::Int(_)
        | Value::Float(_)
        | Value::BigInt(_)
        | Value::Complex(_)
        | Value::Str(_)
        | Value::Bytes(_)
        | Value::ByteArray(_)
        | Value::Range(_)
        | Value::LongRange(_) => Flat,
        // Programs make none; they set variables of the modules there are.
        Value::Module(_) => Flat,
        // All other kinds hold values of a program.
        Value::Builtin(_) => Chains(&["cmp_to_key"]),
        Value::List(_) => Chains(&["list", "long list"]),
        Value::Tuple(_) => Chains(&["tuple", "pair", "triple"]),
        Value::Dict(_) => Chains(&["dict", "dict key", "instance dict"]),
        Value::DictView(_) => Chains(&["dict keys", "dict values", "dict items"]),
        Value::Set(_) => Chains(&["set"]),
        Value::FrozenSet(_) => Chains(&["frozenset"]),
        Value::Slice(_) => Chains(&["slice start", "slice stop", "slice step"]),
        Value::Function(_) => Chains(&[
            "default",
            "keyword default",
            "set default",
            "closure",
            "function attribute",
        ]),
        Value::BoundMethod(_) => Chains(&[
            "method",
            "__call__",
            "method of a builtin",
            "class method of a method",
        ]),
        Value::Class(_) => Chains(&[
            "class attribute",
            "metaclass",
            "derived class",
            "property of a class",
        ]),
        Value::Instance(_) => Chains(&[
            "instance",
            "instance with methods",
            "slots",
            "exception argument",
            "cause",
            "context",
            "note",
            "group",
            "key of a cmp_to_key",
            "list subclass",
            "tuple subclass",
            "dict subclass",
            "set subclass",
            "deque",
            "partial",
            "ordered dict",
            "default dict",
            "counter",
            "named tuple",
            "condition",
            "barrier",
            "exception in an attribute",
            "getattr",
            "call of an instance",
            "descriptor",
            "callable descriptor",
            "item getter",
            "several items",
            "method caller",
            "method by name",
            "match",
        ]),
        Value::Iter(iter) => iterator(iter),
        Value::Generator(_) => Chains(&[
            "fresh generator",
            "fresh coroutine",
            "begun generator",
            "delegating generator",
            "begun coroutine",
        ]),
        Value::Property(_) => Chains(&[
            "property getter",
            "property setter",
            "property deleter",
            "property doc",
        ]),
        Value::StaticMethod(_) => Chains(&["staticmethod"]),
        Value::ClassMethod(_) => Chains(&["classmethod"]),
        Value::Super(_) => Chains(&["super"]),
        // A variable of closures: it is no value of a program by itself.
        Value::Cell(_) | Value::Code(_) => Chains(&["closure"]),
    }
}

fn iterator(iter: &Iter) -> Nesting {
    match iter {
        Iter::Str { .. } | Iter::Bytes { .. } | Iter::Range { .. } => Flat,
        Iter::List { .. } => Chains(&["iterator of a list"]),
        Iter::Tuple { .. } => Chains(&["iterator of a tuple"]),
        Iter::Dict { .. } => Chains(&["iterator of a dict", "iterator of items"]),
        Iter::Set { .. } => Chains(&["iterator of a set"]),
        Iter::ListReversed { .. } => Chains(&["reversed list"]),
        Iter::Sequence { .. } => Chains(&["iterator of items by number", "reversed"]),
        Iter::Callable { .. } => Chains(&["iterator of calls", "sentinel"]),
        Iter::Map { .. } => Chains(&["map", "map of two", "function of a map"]),
        Iter::Filter { .. } => Chains(&["filter", "filter of none", "function of a filter"]),
        Iter::Zip { .. } => Chains(&["zip", "zip of two", "zip of three"]),
        Iter::Enumerate { .. } => Chains(&["enumerate"]),
        Iter::Native(_) => Chains(&[
            "chain",
            "chain of iterables",
            "islice",
            "cycle",
            "takewhile",
            "dropwhile",
            "filterfalse",
            "starmap",
            "accumulate",
            "compress",
            "zip_longest",
            "pairwise",
            "repeat",
            "product",
            "permutations",
            "combinations",
            "tee",
            "groupby",
            "iterator of a deque",
            "reversed deque",
            "matches",
        ]),
    }
}

/// Name, how one value is put into the next, the innermost value, how many.
type Chain = (&'static str, &'static str, &'static str, usize);

/// Long enough for any native stack there is: a level of recursion takes at least a hundred bytes.
const LONG: usize = 50_000;
/// For what takes more time to make.
const MIDDLE: usize = 12_000;
/// For what has a native stack of its own, or takes memory with the square of its number.
const SHORT: usize = 2_000;

const CHAINS: &[Chain] = &[
    ("list", "[v]", "[]", LONG),
    ("long list", "[1, 2, v, 3]", "[]", MIDDLE),
    ("tuple", "(v,)", "()", LONG),
    ("pair", "(1, v)", "()", MIDDLE),
    ("triple", "(v, 1, 2)", "()", MIDDLE),
    ("dict", "{'k': v}", "{}", LONG),
    ("dict key", "{Node(v): 1}", "{}", MIDDLE),
    ("dict keys", "{Node(v): 1}.keys()", "{}", MIDDLE),
    ("dict values", "{'k': v}.values()", "{}", MIDDLE),
    ("dict items", "{'k': v}.items()", "{}", MIDDLE),
    ("set", "{Node(v)}", "None", MIDDLE),
    ("frozenset", "frozenset([v])", "frozenset()", MIDDLE),
    ("slice start", "slice(v, 1)", "1", LONG),
    ("slice stop", "slice(v)", "1", MIDDLE),
    ("slice step", "slice(1, 2, v)", "1", MIDDLE),
    ("default", "lambda x=v: x", "None", LONG),
    ("keyword default", "lambda *, x=v: x", "None", LONG),
    ("set default", "set_default(v)", "None", MIDDLE),
    ("closure", "closure(v)", "None", LONG),
    ("function attribute", "with_attribute(v)", "None", MIDDLE),
    ("method", "Node(v).step", "None", LONG),
    ("__call__", "v.__call__", "plain", LONG),
    ("method of a builtin", "[v].append", "None", MIDDLE),
    (
        "class method of a method",
        "class_method(v)",
        "plain",
        SHORT,
    ),
    ("cmp_to_key", "functools.cmp_to_key(v)", "plain", SHORT),
    ("item getter", "operator.itemgetter(v)", "None", LONG),
    ("several items", "operator.itemgetter(1, v)", "None", MIDDLE),
    (
        "method caller",
        "operator.methodcaller('f', v)",
        "None",
        LONG,
    ),
    (
        "method by name",
        "operator.methodcaller('f', a=v)",
        "None",
        MIDDLE,
    ),
    ("match", "re.match('', Letters(v))", "None", MIDDLE),
    ("matches", "re.finditer('', Letters(v))", "None", MIDDLE),
    ("class attribute", "type('C', (), {'a': v})", "None", SHORT),
    ("metaclass", "metaclass(v)", "type", SHORT),
    ("derived class", "derived(v)", "object", 500),
    (
        "property of a class",
        "type('C', (), {'a': property(v)})",
        "None",
        SHORT,
    ),
    ("instance", "Node(v)", "None", LONG),
    ("instance with methods", "Talks(v)", "None", LONG),
    ("instance dict", "Node(v).__dict__", "None", MIDDLE),
    ("slots", "Slotted(v)", "None", MIDDLE),
    ("exception argument", "ValueError(v)", "None", LONG),
    ("cause", "chained('__cause__', v)", "None", MIDDLE),
    ("context", "chained('__context__', v)", "None", MIDDLE),
    ("note", "chained('note', v)", "None", MIDDLE),
    ("group", "ExceptionGroup('g', [v])", "ValueError()", MIDDLE),
    ("key of a cmp_to_key", "key(v)", "None", MIDDLE),
    ("list subclass", "L([v])", "[]", MIDDLE),
    ("tuple subclass", "T([v])", "()", MIDDLE),
    ("dict subclass", "D(k=v)", "{}", MIDDLE),
    ("set subclass", "S([Node(v)])", "()", MIDDLE),
    ("deque", "collections.deque([v])", "()", MIDDLE),
    ("partial", "functools.partial(v)", "plain", SHORT),
    ("ordered dict", "collections.OrderedDict(k=v)", "()", SHORT),
    (
        "default dict",
        "collections.defaultdict(None, k=v)",
        "()",
        SHORT,
    ),
    ("counter", "collections.Counter({'k': v})", "1", SHORT),
    ("named tuple", "Named(v)", "()", MIDDLE),
    (
        "condition",
        "threading.Condition(v)",
        "threading.Lock()",
        MIDDLE,
    ),
    ("barrier", "threading.Barrier(1, v)", "plain", MIDDLE),
    (
        "exception in an attribute",
        "chained('a', v)",
        "None",
        MIDDLE,
    ),
    ("getattr", "Asks(v)", "None", MIDDLE),
    ("call of an instance", "Calls(v)", "plain", MIDDLE),
    (
        "descriptor",
        "type('G', (), {'__get__': v})()",
        "plain",
        SHORT,
    ),
    (
        "callable descriptor",
        "type('G', (), {'__call__': v})()",
        "plain",
        SHORT,
    ),
    ("iterator of a list", "iter([v])", "()", MIDDLE),
    ("iterator of a tuple", "iter((v,))", "()", MIDDLE),
    ("iterator of a dict", "iter({Node(v): 1})", "()", MIDDLE),
    ("iterator of items", "iter({1: v}.items())", "()", MIDDLE),
    ("iterator of a set", "iter({Node(v)})", "()", MIDDLE),
    ("reversed list", "reversed([v])", "()", MIDDLE),
    (
        "iterator of items by number",
        "iter(Numbered(v))",
        "[]",
        MIDDLE,
    ),
    ("reversed", "reversed(Numbered(v))", "[]", MIDDLE),
    ("iterator of calls", "iter(Calls(v), 1)", "plain", MIDDLE),
    ("sentinel", "iter(ending, v)", "[]", MIDDLE),
    ("map", "map(str, v)", "[1, 2]", LONG),
    ("map of two", "map(pair, v, [1, 2])", "[1, 2]", MIDDLE),
    ("function of a map", "map(v, [1])", "plain", MIDDLE),
    ("filter", "filter(str, v)", "[1, 2]", MIDDLE),
    ("filter of none", "filter(None, v)", "[1, 2]", MIDDLE),
    ("function of a filter", "filter(v, [1])", "plain", MIDDLE),
    ("zip", "zip(v)", "[1, 2]", MIDDLE),
    ("zip of two", "zip([1, 2], v)", "[1, 2]", MIDDLE),
    ("zip of three", "zip([1], [2], v)", "[1, 2]", MIDDLE),
    ("enumerate", "enumerate(v)", "[1, 2]", MIDDLE),
    ("chain", "itertools.chain(v)", "[1, 2]", MIDDLE),
    (
        "chain of iterables",
        "itertools.chain.from_iterable([v])",
        "[1, 2]",
        MIDDLE,
    ),
    ("islice", "itertools.islice(v, 2)", "[1, 2]", MIDDLE),
    ("cycle", "itertools.cycle(v)", "[1, 2]", MIDDLE),
    ("takewhile", "itertools.takewhile(str, v)", "[1, 2]", MIDDLE),
    ("dropwhile", "itertools.dropwhile(int, v)", "[0, 2]", MIDDLE),
    (
        "filterfalse",
        "itertools.filterfalse(None, v)",
        "[0]",
        MIDDLE,
    ),
    ("starmap", "itertools.starmap(pair, v)", "[(1, 2)]", MIDDLE),
    ("accumulate", "itertools.accumulate(v)", "[1, 2]", MIDDLE),
    (
        "compress",
        "itertools.compress(v, [1, 1])",
        "[1, 2]",
        MIDDLE,
    ),
    (
        "zip_longest",
        "itertools.zip_longest(v, [1])",
        "[1, 2]",
        MIDDLE,
    ),
    ("pairwise", "itertools.pairwise(v)", "[1, 2]", MIDDLE),
    ("repeat", "itertools.repeat(v, 2)", "1", MIDDLE),
    ("product", "itertools.product([v])", "1", MIDDLE),
    ("permutations", "itertools.permutations([v])", "1", MIDDLE),
    (
        "combinations",
        "itertools.combinations([v], 1)",
        "1",
        MIDDLE,
    ),
    (
        "tee",
        "itertools.tee(itertools.chain(v))[1]",
        "[1, 2]",
        MIDDLE,
    ),
    ("groupby", "itertools.groupby(v)", "[1, 2]", MIDDLE),
    (
        "iterator of a deque",
        "iter(collections.deque([v]))",
        "1",
        MIDDLE,
    ),
    (
        "reversed deque",
        "reversed(collections.deque([v]))",
        "1",
        MIDDLE,
    ),
    ("fresh generator", "stepping(v)", "[1, 2]", LONG),
    ("fresh coroutine", "delegating(v)", "[1, 2]", LONG),
    ("begun generator", "begun(stepping(v))", "range(1000)", 500),
    ("delegating generator", "handing_on(v)", "[1, 2]", MIDDLE),
    ("begun coroutine", "begun(holding(v))", "[1, 2]", SHORT),
    ("property getter", "property(v)", "plain", MIDDLE),
    ("property setter", "property(None, v)", "plain", MIDDLE),
    (
        "property deleter",
        "property(None, None, v)",
        "plain",
        MIDDLE,
    ),
    (
        "property doc",
        "property(None, None, None, v)",
        "plain",
        MIDDLE,
    ),
    ("staticmethod", "staticmethod([v])", "[]", MIDDLE),
    ("classmethod", "classmethod((v,))", "[]", MIDDLE),
    ("super", "super(Node, Node(v))", "None", MIDDLE),
];

const PRELUDE: &str = r#"
import copy, json, itertools, functools, collections, threading, operator, re
class Letters(str):
    def __new__(cls, next):
        new = str.__new__(cls, "ab")
        new.next = next
        return new
class Node:
    def __init__(self, next): self.next = next
    def step(self): return self.next
class Slotted:
    __slots__ = ('next',)
    def __init__(self, next): self.next = next
class Talks:
    def __init__(self, next): self.next = next
    def __repr__(self): return f'T({self.next!r})'
    def __str__(self): return str(self.next)
    def __format__(self, spec): return format(self.next, spec)
    def __eq__(self, other): return self.next == other.next
    def __lt__(self, other): return self.next < other.next
    def __hash__(self): return hash((1, self.next))
    def __len__(self): return len(self.next)
    def __bool__(self): return bool(self.next)
    def __iter__(self): return iter(self.next)
    def __contains__(self, x): return x in self.next
    def __call__(self): return self.next()
    def __add__(self, other): return self.next + other
    def __neg__(self): return -self.next
    def __index__(self): return self.next.__index__()
    def __getitem__(self, i): return self.next[i]
    def __enter__(self): return self.next.__enter__()
    def __copy__(self): return copy.copy(self.next)
class Asks:
    def __init__(self, next): self.next = next
    def __getattr__(self, name): return getattr(self.next, name)
class Calls:
    def __init__(self, next): self.__dict__['__call__'] = next; self.next = next
    def __call__(self, *args): return self.next(*args)
class Numbered:
    def __init__(self, next): self.next = next
    def __len__(self): return 1
    def __getitem__(self, i): return next(self.next) if i == 0 else [][0]
Named = collections.namedtuple('Named', 'next')
class L(list): pass
class T(tuple): pass
class D(dict): pass
class S(set): pass
def plain(*args): return 1
def ending(): raise StopIteration
def pair(a, b): return a, b
def set_default(v):
    def f(x=1): pass
    f.__defaults__ = (v,)
    return f
def closure(v):
    def f(): return v() if v else 1
    return f
def with_attribute(v):
    def f(): pass
    f.a = v
    return f
def class_method(v):
    class C: m = classmethod(v)
    return C.m
def metaclass(v):
    if v is type: return type('M', (type,), {})
    return v('M', (type,), {})
def derived(v):
    class C(v): pass
    return C
key = functools.cmp_to_key(lambda a, b: 0)
def chained(name, v):
    e = ValueError('x')
    if name == 'note':
        e.__notes__ = [v]
    else:
        setattr(e, name, v)
    return e
def stepping(v):
    for x in v: yield x
def delegating(v):
    try:
        yield from v
    finally: pass
def handing_on(v):
    yield from v
def holding(v):
    try:
        yield v
    finally: pass
def begun(g):
    next(g)
    return g
def build(n):
    v = START
    for _ in range(n): v = WRAP
    return v
"#;

/// What is asked of each chain, `a`, and of another one like it, `b`.
const QUESTIONS: &[&str] = &[
    "repr(a)",
    "str(a)",
    "f'{a}'",
    "'%s' % (a,)",
    "'{0.next}'.format(a)",
    "print(a)",
    "a == b",
    "a != b",
    "a < b",
    "[a] == [b]",
    "sorted([a, b])",
    "max(a, b)",
    "hash(a)",
    "{a, b}",
    "{a: 1}[b]",
    "copy.copy(a)",
    "copy.deepcopy(a)",
    "json.dumps(a)",
    "a()",
    "a(1)",
    "next(a)",
    "list(a)",
    "sum(a)",
    "[*a]",
    "dict(a)",
    "len(a)",
    "bool(a)",
    "3 in a",
    "a in [b]",
    "[b].index(a)",
    "isinstance(1, a)",
    "issubclass(int, a)",
    "isinstance(a, list)",
    "a.missing",
    "a.__name__",
    "a.__doc__",
    "hasattr(a, 'x')",
    "setattr(a, 'x', 1)",
    "vars(a)",
    "dir(a)",
    "a[0]",
    "[1, 2, 3][a]",
    "[1, 2, 3][a:]",
    "a + b",
    "a | b",
    "-a",
    "range(a)",
    "int(a)",
    "float(a)",
    "complex(a)",
    "bytes(a)",
    "iter(a)",
    "reversed(a)",
    "functools.reduce(plain, a)",
    "type('X', (), {'p': a})().p",
    "type('X', (), {'__call__': a})()()",
    "type('X', (), {'__repr__': a})().__repr__()",
    "type('X', (a,), {})",
    "throw(a)",
    "catch(a)",
    "split(a)",
    "enter(a)",
    "collections.deque([a]) == collections.deque([b])",
    "'x'.join(a)",
    "a.acquire()",
    "a.notify()",
    "a.wait()",
    "callable(a)",
    "a.throw(ValueError())",
    "a.close()",
    "exec('', {'a': a})",
];

/// Questions to values that are used up by being asked; they are made anew for each question.
const QUESTIONS_OF_ITERATORS: &[&str] = &[
    "repr(a)",
    "a == b",
    "hash(a)",
    "copy.copy(a)",
    "copy.deepcopy(a)",
    "json.dumps(a)",
    "a()",
    "next(a)",
    "list(a)",
    "for_each(a)",
    "sum(a)",
    "3 in a",
    "isinstance(1, a)",
    "dict(a)",
    "max(a)",
    "''.join(a)",
    "unpack(a)",
    "bytes(a)",
    "a.send(None)",
    "a.throw(ValueError())",
    "a.close()",
    "list(map(plain, a))",
    "list(zip(a, b))",
    "list(delegating(a))",
    "list(handing_on(a))",
    "begun(stepping(a))",
    "collections.deque(a)",
    "[].extend(a)",
    "set(a)",
];

/// What names of such chains contain.
const KINDS_OF_ITERATORS: &[&str] = &[
    "iterator",
    "reversed",
    "sentinel",
    "map",
    "filter",
    "zip",
    "enumerate",
    "chain",
    "islice",
    "cycle",
    "takewhile",
    "dropwhile",
    "starmap",
    "accumulate",
    "compress",
    "pairwise",
    "repeat",
    "product",
    "permutations",
    "combinations",
    "tee",
    "groupby",
    "count",
    "generator",
    "coroutine",
];

/// How many a chain has for those.
const ITERATORS: usize = 3_000;

const ASK: &str = r#"
def throw(a): raise a
def catch(a):
    try: raise ValueError('x')
    except a: pass
def split(a):
    try: raise a
    except* KeyError: pass
def enter(a):
    with a: pass
def for_each(a):
    for x in a: pass
def unpack(a):
    x, *y = a
made = None
def ask(name, question):
    global made
    if FRESH or made is None:
        made = build(N), build(N)
    a, b = made
    try:
        question(a, b)
        r = 'ok'
    except BaseException as e:
        r = type(e).__name__
        e = None
    print(name, '->', r)
"#;

fn program(chain: &Chain) -> String {
    let (_, wrap, start, count) = chain;
    let is_iterator = KINDS_OF_ITERATORS.iter().any(|kind| chain.0.contains(kind));
    let (fresh, questions, asked) = if is_iterator {
        ("True", QUESTIONS_OF_ITERATORS, ITERATORS.min(*count))
    } else {
        ("False", QUESTIONS, *count)
    };
    let prelude = PRELUDE.replace("START", start).replace("WRAP", wrap);
    let ask = ASK
        .replace("FRESH", fresh)
        .replace("N)", &format!("{asked})"));
    let mut text = prelude + &ask;
    for question in questions {
        text += &format!("ask({question:?}, lambda a, b: {question})\n");
    }
    text + &format!(
        "made = None\nv = build({count})\nv = None\nprint('dropped')\nv = build({count})\n"
    )
}

/// The program lives, and what is left over at its end is dropped with the task.
fn survives(chain: &Chain) -> String {
    let (stage, interpreter) = task();
    let main = begin(&interpreter, &program(chain));
    let report = drive(&stage, main);
    let kind = interpreter.global("v").map_or(Flat, |v| nesting(&v));
    let name = chain.0;
    let Chains(names) = kind else {
        panic!("{name}: a chain of flat values, {report}");
    };
    assert!(
        names.contains(&name),
        "{name} is a chain of {names:?}, {report}"
    );
    drop(interpreter);
    let output = stage.output.take() + &report;
    assert!(output.ends_with("dropped\n"), "{name}: {output}");
    output
}

/// The chains are dealt out to several tests, so that they run side by side; a quarter of them is asked on the way.
fn every(part: usize, of: usize) {
    let only = std::env::var("CHAIN").ok();
    for chain in CHAINS.iter().skip(part).step_by(of) {
        if only.as_ref().is_none_or(|only| chain.0 == only) {
            survives(chain);
        }
    }
}

macro_rules! parts {
    ($($name:ident $part:literal;)*) => {
        $(#[test] fn $name() { every($part, PARTS); })*
        const PARTS: usize = [$($part,)*].len();
    };
}

parts! {
    long_chains_of_every_kind_are_survived_0_first_quarter 0;
    long_chains_of_every_kind_are_survived_0_second_quarter 1;
    long_chains_of_every_kind_are_survived_0_third_quarter 2;
    long_chains_of_every_kind_are_survived_0_last_quarter 3;
    long_chains_of_every_kind_are_survived_1_first_quarter 4;
    long_chains_of_every_kind_are_survived_1_second_quarter 5;
    long_chains_of_every_kind_are_survived_1_third_quarter 6;
    long_chains_of_every_kind_are_survived_1_last_quarter 7;
    long_chains_of_every_kind_are_survived_2_first_quarter 8;
    long_chains_of_every_kind_are_survived_2_second_quarter 9;
    long_chains_of_every_kind_are_survived_2_third_quarter 10;
    long_chains_of_every_kind_are_survived_2_last_quarter 11;
    long_chains_of_every_kind_are_survived_3_first_quarter 12;
    long_chains_of_every_kind_are_survived_3_second_quarter 13;
    long_chains_of_every_kind_are_survived_3_third_quarter 14;
    long_chains_of_every_kind_are_survived_3_last_quarter 15;
    long_chains_of_every_kind_are_survived_4_first_quarter 16;
    long_chains_of_every_kind_are_survived_4_second_quarter 17;
    long_chains_of_every_kind_are_survived_4_third_quarter 18;
    long_chains_of_every_kind_are_survived_4_last_quarter 19;
    long_chains_of_every_kind_are_survived_5_first_quarter 20;
    long_chains_of_every_kind_are_survived_5_second_quarter 21;
    long_chains_of_every_kind_are_survived_5_third_quarter 22;
    long_chains_of_every_kind_are_survived_5_last_quarter 23;
}
