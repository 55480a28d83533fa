//! No operation grows faster than it should, and none keeps the other script threads waiting.
//!
//! Every method of every builtin type is called, with whatever arguments from a small set it takes, on a value of one
//! size and of four times that size; the times are compared. They are those of the processor, so that other work on the
//! machine does not disturb them. New methods are found by `dir`.

use crate::support;

use std::collections::BTreeMap;

use elite_lang::{Resume, ResumeOutcome, render_script_error};
use support::Task;

/// How much longer the larger value may take: 4 in proportion, some more where it is sorted, 16 with the square.
const RATIO_MAX: f64 = 9.0;
/// Seconds in which no square of the larger size fits.
const FAST: f64 = 0.1;

/// What the methods are called on: a name, and how a value of `n` parts is made.
const RECEIVERS: &[(&str, &str)] = &[
    ("str", "'ab ' * (n // 3)"),
    ("wide str", "'位b ' * (n // 3)"),
    ("bytes", "b'ab ' * (n // 3)"),
    ("bytearray", "bytearray(b'ab ' * (n // 3))"),
    ("list", "list(range(n))"),
    ("tuple", "tuple(range(n))"),
    ("dict", "dict.fromkeys(range(n))"),
    ("keys", "dict.fromkeys(range(n)).keys()"),
    ("items", "dict.fromkeys(range(n)).items()"),
    ("values", "dict.fromkeys(range(n)).values()"),
    ("set", "set(range(n))"),
    ("frozenset", "frozenset(range(n))"),
    ("range", "range(n)"),
    ("deque", "collections.deque(range(n))"),
    ("bounded deque", "collections.deque(range(n), n)"),
    ("Counter", "collections.Counter(range(n))"),
    ("OrderedDict", "collections.OrderedDict.fromkeys(range(n))"),
    (
        "defaultdict",
        "collections.defaultdict(int, dict.fromkeys(range(n)))",
    ),
    (
        "ChainMap",
        "collections.ChainMap(dict.fromkeys(range(n)), dict.fromkeys(range(n)))",
    ),
];

/// Arguments that are tried.
const ARGUMENTS: &[&str] = &[
    "()",
    "(1,)",
    "(b' ',)",
    "(' ',)",
    "('位',)",
    "(None,)",
    "(n // 2,)",
    "(make(n),)",
    "([make(2)],)",
    "(iter(make(n)),)",
    "(1, 2)",
    "(' ', 'xy')",
    "(b' ', b'xy')",
    "(' ', n // 2)",
    "(b' ', n // 2)",
    "(slice(1, n, 2),)",
    "(slice(n // 2, None),)",
];

/// Seconds of processor time this thread has used, as Linux tells it.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split(' ').next().and_then(|field| field.parse().ok());
    nanoseconds.unwrap_or(0.0) / 1e9
}

/// Runs a program that prints a label before everything it does; the seconds behind each label.
fn times(text: &str) -> BTreeMap<String, f64> {
    let task = Task::new();
    let mut thread = task.spawn(text);
    let mut times: BTreeMap<String, f64> = BTreeMap::new();
    let mut label = String::new();
    loop {
        let before = processor_time();
        let step = thread.resume(Resume::Continue, 50);
        *times.entry(label.clone()).or_default() += processor_time() - before;
        if let Some(last) = task.host.output.take().lines().last() {
            label = last.to_owned();
        }
        match step {
            ResumeOutcome::OutOfFuel => {}
            ResumeOutcome::Failed(error) => panic!("{}", render_script_error(&error)),
            _ => return times,
        }
    }
}

/// A program that calls one method after another; it gives way before each, so that the label is known.
fn program(make: &str, n: usize) -> String {
    let arguments = ARGUMENTS.join(", lambda n: ");
    format!(
        "
import collections
n = {n}
def make(n): return {make}
def give_way():
    for _ in range(60): pass
skipped = ('__class__', '__init_subclass__', '__subclasshook__', '__new__', '__reduce__', '__reduce_ex__',
           '__getattribute__', '__setattr__', '__delattr__',
           # What these make grows with the square of what they are given here.
           '__mul__', '__rmul__', '__imul__', 'join')
arguments = [lambda n: {arguments}]
for name in dir(make(1)):
    if name in skipped: continue
    for index, args in enumerate(arguments):
        given = args(2)
        try: getattr(make(2), name)(*given)
        except Exception: continue
        receiver = make(n)
        given = args(n)
        print(name, index)
        give_way()
        try: getattr(receiver, name)(*given)
        except Exception: pass
        give_way()
        print('-')
        give_way()
"
    )
}

fn compare(receivers: &[(&str, &str)]) {
    for (name, make) in receivers {
        report(|n| program(make, n), name);
    }
}

/// How often what seems to grow too fast is measured: a square does so each time, a machine with other work now and
/// then.
const TRIES: usize = 4;

/// Fails with what took more than in proportion longer on the larger data, each time it was measured.
fn report(program: impl Fn(usize) -> String, name: &str) {
    let mut trouble = out_of_proportion(&program);
    for _ in 1..TRIES {
        if trouble.is_empty() {
            return;
        }
        let again = out_of_proportion(&program);
        trouble.retain(|label, _| again.contains_key(label));
    }
    let trouble = trouble
        .iter()
        .map(|(label, ratio)| format!("{name} {label}: {ratio:.1} times as long"));
    let trouble: Vec<String> = trouble.collect();
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}

/// What takes more than in proportion longer on the larger data, and how much.
fn out_of_proportion(program: impl Fn(usize) -> String) -> BTreeMap<String, f64> {
    let (small, large) = (2500, 10_000);
    let mut slow = times(&program(large));
    slow.retain(|label, seconds| *seconds > FAST && label.len() > 1);
    if slow.is_empty() {
        return slow;
    }
    let least = times(&program(small));
    for (label, seconds) in &mut slow {
        *seconds /= least.get(label).copied().unwrap_or(f64::MAX);
    }
    slow.retain(|_, ratio| *ratio > RATIO_MAX);
    slow
}

#[test]
fn methods_of_texts_and_bytes_grow_in_proportion() {
    compare(&RECEIVERS[..4]);
}

#[test]
fn methods_of_sequences_grow_in_proportion() {
    compare(&RECEIVERS[4..6]);
    compare(&RECEIVERS[12..15]);
}

#[test]
fn methods_of_the_library_grow_in_proportion() {
    compare(&RECEIVERS[15..]);
}

/// Arguments that are tried with functions.
const OF_FUNCTIONS: &[&str] = &[
    "('ab ' * n,)",
    "(b'ab ' * n,)",
    "(list(range(n)),)",
    "([2.5, 1.5] * n,)",
    "(['b', 'a'] * n,)",
    "(tuple(range(n)),)",
    "(range(n),)",
    "(dict.fromkeys(range(n)),)",
    "(set(range(n)),)",
    "(n,)",
    "(n, n // 2)",
    "(1 << 64, 2)",
    "('1' * 4000,)",
    "(None, [0, 1] * n)",
    "(str, [0, 1] * n)",
    "([0, 1] * n, 1)",
    "([0, 1] * n, [0, 1] * n)",
    "([2.5, 1.5] * n, [1.5, 0.5] * n)",
    "('x', 'ab' * n)",
    "('a*b', 'ab' * n)",
    "('b', 'c', 'ab' * n)",
    "('[' + '1,' * n + '2]',)",
    "('%db' % n, bytes(n))",
    "(3, list(range(n)))",
    "(n // 2, list(range(n)))",
    "(lambda x, y: y, list(range(n)))",
];

/// Calls every builtin function and every function of the library with them.
fn functions(n: usize) -> String {
    let arguments = OF_FUNCTIONS.join(", lambda n: ");
    let names: Vec<&str> = elite_syntax::python_names::builtin_names()
        .filter(|name| name.starts_with(char::is_lowercase))
        .collect();
    format!(
        "
import collections, json, re, struct, math, random, itertools, functools, operator, copy, heapq, bisect, statistics, \
string, io
n = {n}
def give_way():
    for _ in range(60): pass
# They print, wait, end the program, never end, or make all there is to choose from.
skipped = ('exit', 'quit', 'input', 'print', 'open', 'exec', 'eval', 'compile', 'globals', 'locals', 'vars', 'super',
           'cycle', 'count', 'repeat', 'combinations', 'combinations_with_replacement', 'permutations', 'product',
           # What these make grows with the square, or faster, with what they are given here.
           'accumulate', 'reduce', 'concat', 'iconcat', 'mul', 'imul', 'pow', 'ipow', 'lshift', 'ilshift', 'sum', \
           'factorial',
           'comb', 'perm', 'prod')
functions = [(name, eval(name)) for name in {names:?}]
for module in (collections, json, re, struct, math, random, itertools, functools, operator, copy, heapq, bisect, \
statistics, io):
    functions += [(module.__name__ + '.' + name, getattr(module, name)) for name in dir(module) if name[0] != '_']
arguments = [lambda n: {arguments}]
for name, function in functions:
    if name.split('.')[-1] in skipped or not callable(function): continue
    for index, args in enumerate(arguments):
        given = args(40)
        try: function(*given)
        except Exception: continue
        given = args(n)
        print(name, index)
        give_way()
        try:
            result = function(*given)
            if name.startswith('itertools.'):
                for _ in result: pass
        except Exception: pass
        give_way()
        result = given = None
        print('-')
        give_way()
"
    )
}

#[test]
fn functions_grow_in_proportion() {
    report(functions, "");
}

#[test]
fn methods_of_tables_grow_in_proportion() {
    compare(&RECEIVERS[6..12]);
}

/// Loops of many cheap steps, each in proportion to their number `n`.
const LOOPS: &[(&str, &str)] = &[
    ("set.pop", "s = set(range(n))\nwhile s: s.pop()"),
    (
        "names of a dictionary that was globals",
        "d = {str(i): i for i in range(n)}\nexec('a = 1', d)\nfor k in d: len(d)\nwhile d: d.popitem()",
    ),
    (
        "names that texts have bound",
        "d = {}\nexec('\\n'.join(f'v{i} = 1' for i in range(n // 8)), d)\nfor k in d: len(d)\nwhile d: d.popitem()",
    ),
    (
        "OrderedDict.move_to_end to and fro",
        "import collections\nd = collections.OrderedDict.fromkeys(range(n))\n\
         for i in range(n): d.move_to_end(i, last=i % 2 == 0)",
    ),
    (
        "keys of a dictionary that the script compares",
        "class K:\n    def __init__(self, i): self.i = i\n    def __hash__(self): return hash(self.i)\n    \
         def __eq__(self, other): return self.i == other.i\n\
         d = {K(i): i for i in range(n // 8)}\nfor i in range(n // 8): d[K(i)]",
    ),
    (
        "elements of a set that the script compares",
        "class K:\n    def __init__(self, i): self.i = i\n    def __hash__(self): return hash(self.i)\n    \
         def __eq__(self, other): return self.i == other.i\n\
         d = {K(i) for i in range(n // 8)}\nfor i in range(n // 8): K(i) in d",
    ),
    (
        "arguments by name",
        "def f(**named): return len(named)\nd = {f'k{i}': i for i in range(n // 2)}\nf(**d), dict(**d), f(a=1, **d)",
    ),
    (
        "fields of a named tuple",
        "import collections\nm = min(n // 4, 60_000)\nT = collections.namedtuple('T', [f'f{i}' for i in range(m)])\n\
         T(**{f'f{i}': i for i in range(m)})",
    ),
    (
        "keys whose hashes differ in their upper bits",
        "d = {i << 45: i for i in range(2 * n)}\nd = {i / 1024: i for i in range(2 * n)}",
    ),
    (
        "slots of a class",
        "names = [f's{i}' for i in range(n // 4)]\nclass S: __slots__ = names\ns = S()\n\
         for name in names: setattr(s, name, 1)",
    ),
    (
        "names that a module lists",
        "import string\nstring.__all__ = [f's{i}' for i in range(n // 4)]\n\
         for name in string.__all__: setattr(string, name, 1)\nexec('from string import *', {})",
    ),
    (
        "classes below a class",
        "class A: pass\nbelow = [type('B', (A,), {}) for _ in range(n // 8)]\n\
         for i in range(n): A.x = len\nfor b in below[::8]: b.__bases__ = (A,)",
    ),
    (
        "dict.popitem",
        "d = dict.fromkeys(range(n))\nwhile d: d.popitem()",
    ),
    (
        "first key",
        "d = dict.fromkeys(range(n))\nwhile d: del d[next(iter(d))]",
    ),
    (
        "last key",
        "d = dict.fromkeys(range(n))\nwhile d: del d[next(reversed(d))]",
    ),
    (
        "queue in a dict",
        "d = dict.fromkeys(range(n))\nfor i in range(n):\n    del d[next(iter(d))]\n    d[n + i] = 1",
    ),
    (
        "OrderedDict",
        "import collections\nd = collections.OrderedDict.fromkeys(range(n))\nwhile d: d.popitem(last=False)",
    ),
    (
        "move to the front",
        "import collections\nd = collections.OrderedDict.fromkeys(range(n))\n\
         for i in range(n): d.move_to_end(i, last=False)",
    ),
    (
        "move to the end",
        "import collections\nd = collections.OrderedDict.fromkeys(range(n))\nfor i in range(n): d.move_to_end(i)",
    ),
    (
        "move to both ends",
        "import collections\nd = collections.OrderedDict.fromkeys(range(n))\n\
         for i in range(n):\n    d.move_to_end(i, last=i % 2)\n    d[-i] = i\n    del d[-i]",
    ),
    (
        "smallest few",
        "import heapq\nfor i in range(8): heapq.nsmallest(3, range(n)), heapq.nlargest(3, range(n), key=lambda x: -x)",
    ),
    (
        "Counter",
        "import collections\nc = collections.Counter(range(n))\nc.update(range(n))\nc.most_common(3)\nc + c",
    ),
    (
        "lru_cache",
        "import functools\nf = functools.lru_cache(maxsize=n // 4)(lambda x: x)\nfor i in range(n): f(i)",
    ),
    (
        "index of wide text",
        "s = '位' * n\nfor i in range(n): s[i]",
    ),
    (
        "slice of wide text",
        "s = '位' * n\nfor i in range(n): s[i:i + 2]",
    ),
    (
        "step of wide text",
        "s = '位' * n\nfor i in range(n): s[i:i + 4:2]",
    ),
    (
        "find in wide text",
        "s = '位' * n\nfor i in range(n): s.find('位', i)",
    ),
    (
        "startswith in wide text",
        "s = '位' * n\nfor i in range(n): s.startswith('位', i)",
    ),
    (
        "reversed wide text",
        "s = '位' * n\nfor c in reversed(s): pass",
    ),
    (
        "growing wide text",
        "s = ''\nfor i in range(n):\n    s += '位'\n    s[i]",
    ),
    ("growing text", "s = ''\nfor i in range(n): s += 'a'"),
    (
        "bytearray as a queue",
        "b = bytearray(n)\nfor i in range(n // 4):\n    del b[:4]\n    b += b'abcd'",
    ),
    (
        "bytearray from the front",
        "b = bytearray(n)\nfor i in range(n // 2): b.pop(0)\nwhile b: del b[0]",
    ),
    (
        "bytes written in memory",
        "import io\nf = io.BytesIO(bytes(n))\nfor i in range(n // 10):\n    f.seek(i)\n    f.write(b'ab')\
         \n    f.read(1)",
    ),
    (
        "bytes written and read in memory",
        "import io\nf = io.BytesIO()\nfor i in range(n // 10):\n    f.write(b'ab')\n    f.seek(-1, 2)\n    f.read(1)",
    ),
    (
        "branches of a tee",
        "import itertools\na, b = itertools.tee(range(n))\nfor x in a: pass\nfor x in b: pass",
    ),
    (
        "growing bytearray",
        "b = bytearray()\nfor i in range(n): b += b'a'",
    ),
    (
        "find in bytes",
        "b = b'ab' * n\nfor i in range(n): b.find(b'b', i)",
    ),
    (
        "startswith in bytes",
        "b = b'ab' * n\nfor i in range(n): b.startswith(b'b', i)",
    ),
    (
        "index of bytes",
        "b = bytearray(n)\nfor i in range(n): b[i] = b[i - 1]",
    ),
    (
        "deque ends",
        "import collections\nd = collections.deque(range(n))\nwhile d: d.popleft()",
    ),
    (
        "deque rotate",
        "import collections\nd = collections.deque(range(n))\nfor i in range(n): d.rotate(1)",
    ),
    (
        "heap",
        "import heapq\nh = []\nfor i in range(n): heapq.heappush(h, -i)\nwhile h: heapq.heappop(h)",
    ),
    (
        "merge",
        "import heapq\nfor x in heapq.merge(*([i] for i in range(n // 8))): pass",
    ),
    ("in range", "r = range(n * 100)\nfor i in range(n): i in r"),
    (
        "in views",
        "d = dict.fromkeys(range(n))\nfor i in range(n): i in d.keys() and (i, None) in d.items()",
    ),
    (
        "sorted again",
        "l = list(range(n))\nfor i in range(10): l.sort()",
    ),
    (
        "shared tuples",
        "t = ()\nfor i in range(n // 20): t = (t, t) if i % 25 else ()\nhash(t)",
    ),
    (
        "shuffle",
        "import random\nl = list(range(n))\nrandom.shuffle(l)",
    ),
    ("sample", "import random\nrandom.sample(range(n), n // 2)"),
    (
        "choices",
        "import random\nrandom.choices(range(n), weights=range(1, n + 1), k=n // 4)",
    ),
    (
        "deepcopy",
        "import copy\nl = [0]\nfor i in range(n // 20): l = [l, l] if i % 50 else [0]\ncopy.deepcopy(l)",
    ),
    (
        "json",
        "import json\njson.loads(json.dumps(list(range(n)) + ['位'] * n))",
    ),
    ("regex", "import re\nlen(re.findall('位+a?', '位b' * n))"),
    (
        "regex positions",
        "import re\nfor m in re.finditer('位', '位b' * n): m.start()",
    ),
];

#[test]
fn loops_of_cheap_steps_grow_in_proportion() {
    // In a function, where texts grow in place; several runs, since the system counts processor time in steps of some
    // milliseconds.
    let seconds = |text: &str, n: usize| -> f64 {
        let body = text.replace('\n', "\n    ");
        let program = format!("def run(n):\n    {body}\nfor _ in range(4): run({n})\n");
        times(&program).values().sum()
    };
    let mut trouble = Vec::new();
    for (name, text) in LOOPS {
        if seconds(text, 16_000) < 4.0 * FAST {
            continue;
        }
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            best = best.min(seconds(text, 16_000) / seconds(text, 4000));
        }
        if best > RATIO_MAX {
            trouble.push(format!("{name}: {best:.1} times as long"));
        }
    }
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}

/// Operations that end never, or in a very long time.
const ENDLESS: &[&str] = &[
    "{1}.isdisjoint(iter(int, 1))",
    "{1: 2}.keys().isdisjoint(iter(int, 1))",
    "set(iter(int, 1))",
    "frozenset(iter(int, 1))",
    "set().update(iter(int, 1))",
    "{1}.union(iter(int, 1))",
    "{0}.intersection(iter(int, 1))",
    "{0}.issuperset(iter(int, 1))",
    "dict.fromkeys(iter(int, 1))",
    "dict(iter(lambda: (1, 2), 1))",
    "sum(iter(int, 1))",
    "any(iter(int, 1))",
    "all(iter(lambda: 1, 0))",
    "min(iter(int, 1))",
    "max(iter(int, 1))",
    "1 in iter(int, 1)",
    "next(filter(None, iter(int, 1)))",
    "[*iter(int, 1)]",
    "first, *rest = iter(int, 1)",
    "hash(shared(40, (object(),)))",
    "shared(40, (1,)) == shared(40, (1,))",
    "shared(40, [1]) == shared(40, [1])",
    "repr(shared(40, (1,)))",
    "str(shared(40, [1]))",
    "import json\njson.dumps(shared(40, [1]))",
    "import collections\ncollections.deque(iter(int, 1), maxlen=3)",
    "import itertools\nlist(itertools.repeat(None))",
    "import math\nmath.fsum(iter(float, 1))",
    "''.join(iter(str, 1))",
    "b''.join(iter(bytes, 1))",
];

#[test]
fn a_stop_ends_what_would_not_end() {
    let mut trouble = Vec::new();
    for operation in ENDLESS {
        let text = format!(
            "def shared(depth, leaf):\n    for _ in range(depth): leaf = type(leaf)((leaf, leaf))\n    return leaf\n\
             def run():\n    global rest\n    {}\ntry: run()\nexcept MemoryError: run()\n",
            operation.replace('\n', "\n    ")
        );
        let task = Task::new();
        let mut thread = task.spawn(&text);
        for _ in 0..10 {
            match thread.resume(Resume::Continue, 100) {
                ResumeOutcome::OutOfFuel => {}
                ResumeOutcome::Failed(error) => {
                    trouble.push(format!("{operation}: {}", render_script_error(&error)));
                    break;
                }
                step => {
                    trouble.push(format!("{operation}: {step:?}"));
                    break;
                }
            }
        }
        let step = thread.resume(Resume::Stop, 100);
        if !matches!(step, ResumeOutcome::Stopped) {
            trouble.push(format!("{operation}: not stopped but {step:?}"));
        }
    }
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}
