//! No native keeps the other script threads waiting: between two safepoints there are a few milliseconds of work at
//! most, however much data it is given.
//!
//! Every method of every builtin type, every builtin function and the functions of the library are called with whatever
//! arguments from a small set they take, on large data. The longest time of the processor between two turns counts, so
//! that other work on the machine does not disturb it. New natives are found by `dir`.

use crate::support;

use std::collections::BTreeMap;
use std::time::Duration;

use elite_lang::{Limits, Resume, ResumeOutcome, render_script_error};
use nix::time::{ClockId, clock_gettime};
use support::Task;

/// The longest work between two safepoints: what INTERFACES promises, and some more without optimisation, where all of
/// it is slower by more than an order of magnitude, on machines whose clock drifts by a factor of two.
const STRETCH_MAX: Duration = Duration::from_millis(if cfg!(debug_assertions) { 32 } else { 5 });
/// How often something must take too long before it counts.
const TRIES: usize = 4;
/// Characters and bytes of the data: what INTERFACES promises the bound for.
const PARTS: usize = if cfg!(debug_assertions) {
    300_000
} else {
    1_000_000
};
/// Items of the data, likewise.
const VALUES: usize = if cfg!(debug_assertions) {
    PARTS / 16
} else {
    100_000
};

/// What the methods are called on: a name, and how a value of `n` parts is made.
const RECEIVERS: &[(&str, &str, usize)] = &[
    ("str", "'aB ' * (n // 3)", PARTS),
    ("letters", "'aB' * (n // 2)", PARTS),
    ("digits", "'12' * (n // 2)", PARTS),
    ("blanks", "' ' * n", PARTS),
    ("wide str", "'位b ' * (n // 3)", PARTS),
    ("bytes", "b'aB ' * (n // 3)", PARTS),
    ("bytearray", "bytearray(b'aB ') * (n // 3)", PARTS),
    ("list", "[1, 2] * (n // 2)", VALUES * 2),
    ("tuple", "(1, 'a') * (n // 2)", VALUES * 2),
    ("dict", "dict.fromkeys(range(n))", VALUES),
    ("keys", "dict.fromkeys(range(n)).keys()", VALUES),
    ("items", "dict.fromkeys(range(n)).items()", VALUES),
    ("values", "dict.fromkeys(range(n)).values()", VALUES),
    ("set", "set(range(n))", VALUES),
    ("frozenset", "frozenset(range(n))", VALUES),
    ("range", "range(n)", VALUES),
    ("deque", "collections.deque(range(n))", VALUES),
    ("int", "(1 << n) - 1", VALUES),
];

/// Arguments that are tried with methods.
const ARGUMENTS: &[&str] = &[
    "()",
    "(1,)",
    "(b' ',)",
    "(' ',)",
    "('zz',)",
    "('位',)",
    "('utf-16',)",
    "('latin-1', 'replace')",
    "(None,)",
    "(n // 2,)",
    "(make(n),)",
    "([make(2)] * 3,)",
    "(['ab'] * (n // 10),)",
    "([b'ab'] * (n // 10),)",
    "(iter(make(n // 10)),)",
    "(1, 2)",
    "(' ', 'xy')",
    "(b' ', b'xy')",
    "('a', '')",
    "(' ', n // 2)",
    "(b' ', n // 2)",
    "(slice(1, n, 2),)",
    "(slice(n // 2, None),)",
    "(slice(None, None, -1), make(n))",
    "(slice(None, n // 2), make(n // 4))",
    "(n // 2, 1)",
    "({97: 'x'},)",
    "(bytes(range(256)), b'ab')",
];

/// Arguments that are tried with functions.
const OF_FUNCTIONS: &[&str] = &[
    "('aB ' * (n // 3),)",
    "('1' * 4000,)",
    "('1.' + '1' * n,)",
    "(b'aB ' * (n // 3),)",
    "(bytearray(b'aB ') * (n // 3),)",
    "([1, 2] * (n // 10),)",
    "([2.5, 1.5] * (n // 10),)",
    "(['b', 'a'] * (n // 10),)",
    "(list(range(n // 10)),)",
    "((1, 2) * (n // 10),)",
    "(range(n // 10),)",
    "(dict.fromkeys(range(n // 10)),)",
    "(set(range(n // 10)),)",
    "(n // 100,)",
    "(n // 10, n // 20)",
    "((1 << n // 10) - 1,)",
    "((1 << n // 10) - 1, (1 << n // 20) + 5)",
    "(' ' * n, 'utf-8')",
    "(b' ' * n, 'utf-8')",
    "(None, [0, 1] * (n // 10))",
    "(str, [0, 1] * (n // 10))",
    "([0, 1] * (n // 10), 1)",
    "([0, 1] * (n // 10), [0, 1] * (n // 10))",
    "([(2, 1)] * (n // 10), 1)",
    "('x', 'ab' * (n // 2))",
    "('(a|b)+', 'ab' * (n // 2))",
    "('b', 'c', 'ab' * (n // 20))",
    "('x', 'c', 'ab' * (n // 2))",
    "('[' + '1,' * (n // 10) + '2]',)",
    "('\"' + 'a' * n + '\"',)",
    "('%ds' % n, b'')",
    "('%db' % (n // 10), b'\\0' * (n // 10))",
    "(3, list(range(n // 10)))",
    "(n // 20, list(range(n // 10)))",
    "(1, str(n * 10))",
    "(5, '0' + str(n) + ',')",
    "('x', str(n * 10))",
    "('0x' + 'f' * (n * 4),)",
    "(' ' * (n * 4) + '1' + ' ' * (n * 4),)",
    "('0x1p' + '0' * (n * 4),)",
];

fn processor_time() -> Duration {
    match clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID) {
        Ok(time) => time.into(),
        Err(error) => panic!("no clock of the thread: {error}"),
    }
}

/// Runs a program that prints a label before everything it does; the longest work between two safepoints for each
/// label.
fn stretches(text: &str) -> BTreeMap<String, Duration> {
    let limits = Limits {
        memory_bytes: 2 << 30,
        ..Limits::default()
    };
    let task = Task::with(Vec::new(), limits);
    let mut thread = task.spawn(text);
    let mut longest: BTreeMap<String, Duration> = BTreeMap::new();
    let mut label = String::from("-");
    loop {
        let before = processor_time();
        let step = thread.resume(Resume::Continue, 1);
        let stretch = processor_time() - before;
        if label != "-" {
            let most = longest.entry(label.clone()).or_default();
            *most = stretch.max(*most);
        }
        if let Some(last) = task.host.output.take().lines().last() {
            label = last.to_owned();
        }
        match step {
            ResumeOutcome::OutOfFuel => {}
            ResumeOutcome::Failed(error) => panic!("{}", render_script_error(&error)),
            _ => return longest,
        }
    }
}

/// What all programs begin with.
const BEGIN: &str = "
import collections, copy, json, re, struct, math, random, itertools, functools, operator, bisect, string, io
modules = [collections, json, re, struct, math, random, itertools, functools, operator, bisect, string, io]
def give_way():
    for _ in range(3): pass
def tree(leaf, n):
    # An expression that is as broad as it is deep, without a list in it.
    while 2 * len(leaf) + 3 <= n: leaf = f'({leaf}+{leaf})'
    return leaf
def attempt(label, function, given, small):
    try: result = function(*small())
    except Exception: return
    del result
    try: given = given()
    except Exception: return
    print(label)
    give_way()
    try: result = function(*given)
    except Exception: result = None
    give_way()
    print('-')
    give_way()
";

/// A program that calls one method after another; it gives way before each, so that the label is known.
fn methods(make: &str, n: usize) -> String {
    let arguments = ARGUMENTS.join(", lambda n: ");
    format!(
        "{BEGIN}
n = {n}
def make(n): return {make}
skipped = ('__class__', '__init_subclass__', '__subclasshook__', '__new__', '__reduce__', '__reduce_ex__',
           '__getattribute__', '__setattr__', '__delattr__', '__getattr__')
arguments = [lambda n: {arguments}]
for name in dir(make(1)):
    if name in skipped: continue
    def call(receiver, *args): return getattr(receiver, name)(*args)
    for index, args in enumerate(arguments):
        # What these make grows with the square of what they would be given here, or faster.
        few = name in ('__mul__', '__rmul__', '__imul__', '__pow__', '__rpow__', '__lshift__', '__rlshift__')
        receiver = 2 if name in ('join', '__rpow__', '__rlshift__') else n
        attempt(f'{{name}} {{index}}', call, lambda: (make(receiver), *args(6 if few else n)), lambda: (make(6), \
        *args(6)))
"
    )
}

/// What keeps the others waiting whenever it is tried. A machine counts page faults, and what its own host takes from
/// it, as time of the processor: one long stretch proves nothing, the same one again and again does.
fn too_long(text: &str) -> BTreeMap<String, Duration> {
    let long = || {
        let mut found = stretches(text);
        found.retain(|_, stretch| *stretch > STRETCH_MAX);
        found
    };
    let mut trouble = long();
    for _ in 1..TRIES {
        if trouble.is_empty() {
            break;
        }
        let again = long();
        trouble.retain(|label, _| again.contains_key(label));
    }
    trouble
}

fn check(receiver: usize) {
    let (name, make, n) = RECEIVERS[receiver];
    let mut trouble = Vec::new();
    for (label, stretch) in too_long(&methods(make, n)) {
        let (method, arguments) = label.rsplit_once(' ').unwrap_or((&label, "0"));
        let arguments = ARGUMENTS[arguments.parse::<usize>().unwrap_or(0)];
        trouble.push(format!("{name}.{method}{arguments}: {stretch:?}"));
    }
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}

macro_rules! receivers {
    ($($test:ident $receiver:literal;)*) => {
        $(#[test] fn $test() { check($receiver); })*
        const _: () = assert!([$($receiver,)*].len() == RECEIVERS.len());
    };
}

receivers! {
    methods_of_texts_give_way 0;
    methods_of_letters_give_way 1;
    methods_of_digits_give_way 2;
    methods_of_blanks_give_way 3;
    methods_of_wide_texts_give_way 4;
    methods_of_bytes_give_way 5;
    methods_of_bytearrays_give_way 6;
    methods_of_lists_give_way 7;
    methods_of_tuples_give_way 8;
    methods_of_dicts_give_way 9;
    methods_of_keys_give_way 10;
    methods_of_items_give_way 11;
    methods_of_values_give_way 12;
    methods_of_sets_give_way 13;
    methods_of_frozen_sets_give_way 14;
    methods_of_ranges_give_way 15;
    methods_of_deques_give_way 16;
    methods_of_integers_give_way 17;
}

/// Calls all functions with some of the arguments.
fn check_functions(part: usize, parts: usize) {
    let given: Vec<&str> = OF_FUNCTIONS
        .iter()
        .skip(part)
        .step_by(parts)
        .copied()
        .collect();
    let arguments = given.join(", lambda n: ");
    let n = if cfg!(debug_assertions) {
        PARTS / 5
    } else {
        PARTS / 10
    };
    let program = format!(
        "{BEGIN}
n = {n}
arguments = [lambda n: {arguments}]
# They print, wait, end the program, never end or are tried elsewhere.
skipped = ('exit', 'quit', 'input', 'print', 'open', 'exec', 'eval', 'compile', 'globals', 'locals', 'vars', 'super',
           'cycle', 'count', 'repeat', 'combinations', 'combinations_with_replacement', 'permutations', 'product')
functions = [(name, eval(name)) for name in NAMES]
for module in modules:
    functions += [(module.__name__ + '.' + name, getattr(module, name)) for name in dir(module) if name[0] != '_']
# What a type does without a value of its own, such as `float.fromhex`.
for of, kind in list(functions):
    if isinstance(kind, type):
        functions += [(of + '.' + name, getattr(kind, name)) for name in dir(kind)
                      if name[0] != '_' and type(getattr(kind, name)).__name__ == 'builtin_function_or_method']
for name, function in functions:
    if name.split('.')[-1] in skipped or not callable(function): continue
    def call(*args):
        result = function(*args)
        # What is made step by step is asked for all of it.
        if type(result).__name__ in ('map', 'filter', 'zip', 'enumerate', 'reversed') or name.startswith('itertools'):
            for _ in zip(range(20_000), result): pass
        return result
    for index, args in enumerate(arguments):
        attempt(f'{{name}} {{index}}', call, lambda: args(n), lambda: args(60))
"
    )
    .replace("NAMES", &format!("{:?}", builtin_functions()));
    let mut trouble = Vec::new();
    for (label, stretch) in too_long(&program) {
        let (function, arguments) = label.rsplit_once(' ').unwrap_or((&label, "0"));
        let arguments = given[arguments.parse::<usize>().unwrap_or(0)];
        trouble.push(format!("{function}{arguments}: {stretch:?}"));
    }
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}

/// The names of the builtin functions and types, but the exceptions and what is no name of its own.
fn builtin_functions() -> Vec<&'static str> {
    let names = elite_syntax::python_names::builtin_names();
    names
        .filter(|name| name.starts_with(char::is_lowercase))
        .collect()
}

macro_rules! functions {
    ($($test:ident $part:literal;)*) => {
        $(#[test] fn $test() { check_functions($part, 8); })*
    };
}

// With an eighth of the arguments each.
functions! {
    functions_give_way_1 0;
    functions_give_way_2 1;
    functions_give_way_3 2;
    functions_give_way_4 3;
    functions_give_way_5 4;
    functions_give_way_6 5;
    functions_give_way_7 6;
    functions_give_way_8 7;
}

/// Texts for `exec`, `eval` and `compile`: long in every way a text can be.
const TEXTS: &[(&str, &str)] = &[
    ("exec", "'x = 1\\n' * (n // 6)"),
    (
        "exec",
        "''.join(f'x{k} = x{k - 1 if k else 0} = {k}\\n' for k in range(min(n // 16, 3000)))",
    ),
    ("exec", "'def f(a, b):\\n  return a + b\\n' * (n // 28)"),
    ("exec", "'class A:\\n  def f(self): pass\\n' * (n // 32)"),
    ("exec", "'if 0:\\n' + '  f(1, x=2)\\n' * (n // 14)"),
    (
        "exec",
        "'def f():\\n' + '  a = [b for b in c]\\n' * (n // 22)",
    ),
    ("exec", "'\\n' * n"),
    ("exec", "'#' * n"),
    ("exec", "'# a\\n' * (n // 4)"),
    ("exec", "' ' * n + 'x = 1'"),
    ("exec", "'x = 1; ' * (n // 7)"),
    ("exec", "'位 = 1\\n' * (n // 8)"),
    ("exec", "'x' * n + ' = 1'"),
    (
        "exec",
        "'x = (' + 'y.z(1), ' * (n // 8) + ')' if n < 100 else 'x = lambda: (' + 'y.z(1), ' * (n // 8) + ')'",
    ),
    ("exec", "'$ LINE: (1, \"a\")\\nx = 1\\n' * (n // 24)"),
    ("exec", "'pass ' * (n // 5)"),
    ("exec", "'x = \\\\n' + '\\\\n' * (n // 2) + '1'"),
    ("eval", "'[' + '1,' * (n // 2) + ']'"),
    ("eval", "'[' + 'n,' * (n // 2) + ']'"),
    ("eval", "'{' + '1: n,' * (n // 5) + '}'"),
    ("eval", "'(' + '\"a\",' * (n // 4) + ')'"),
    ("eval", "'\"' + 'a' * n + '\"'"),
    ("eval", "'\"' + '位' * (n // 3) + '\"'"),
    ("eval", "'\"' + '\\n' * (n // 2) + '\"'"),
    ("eval", "'b\"' + '\\n' * (n // 2) + '\"'"),
    ("eval", "'\"a\" ' * (n // 4)"),
    ("eval", "'f\"' + '{n}' * (n // 3) + '\"'"),
    ("eval", "'f\"' + '{{' * (n // 2) + '\"'"),
    ("eval", "'max(' + 'n,' * (n // 2) + '1)'"),
    ("eval", "'n' + ' < n' * (n // 4)"),
    ("eval", "'0 or ' * (n // 5) + '1'"),
    ("eval", "' ' * n + '1'"),
    ("eval", "'1.' + '0' * n"),
    ("eval", "'0x' + '0' * n"),
    ("eval", "'(' * n"),
    ("eval", "b'[' + b'1,' * (n // 2) + b']'"),
    (
        "exec",
        "'if 0: ' + ', '.join(f'name{k}' for k in range(n // 12)) + '\\n'",
    ),
    (
        "exec",
        "'def f():\\n' + ''.join(f'  local{k} = 1\\n' for k in range(n // 16))",
    ),
    (
        "exec",
        "''.join(f'x.attribute{k}\\n' for k in range(n // 18)) if n < 100 else 'def f(): ' + \
         '; '.join(f'x.attribute{k}' for k in range(n // 18))",
    ),
    (
        "eval",
        "'lambda ' + ', '.join(f'name{k}' for k in range(n // 12)) + ': 0'",
    ),
    (
        "exec",
        "'lambda: f(' + ', '.join(f'name{k}=0' for k in range(n // 12)) + ')'",
    ),
    ("compile", "'x = 1\\n' * (n // 6)"),
    ("compile", "'x = [' + '1, ' * (n // 3) + ']'"),
    // What is long in the parts of a statement, not in their number; in a function, so that it is read and not run.
    (
        "exec",
        "'global ' + ', '.join(f'name{k}' for k in range(n // 12))",
    ),
    (
        "exec",
        "'def f(): global ' + ', '.join(f'name{k}' for k in range(n // 12))",
    ),
    (
        "exec",
        "'def f(): del ' + ', '.join(f'name{k}' for k in range(n // 12))",
    ),
    (
        "exec",
        "'def f(): import ' + ', '.join(f'name{k}' for k in range(n // 12))",
    ),
    (
        "exec",
        "'def f(): from os import ' + ', '.join(f'name{k}' for k in range(n // 12))",
    ),
    (
        "exec",
        "'def f():\\n' + ''.join(f' x{k} = 1\\n' for k in range(n // 20)) + ' def g(): nonlocal ' + ', '.join(f'x{k}' \
         for k in range(n // 20))",
    ),
    (
        "exec",
        "'def f():\\n' + ''.join(f' x{k} = 1\\n' for k in range(n // 20)) + ' def g(): return [' + ', '.join(f'x{k}' \
         for k in range(n // 20)) + ']'",
    ),
    (
        "exec",
        "''.join(f'def f{k}(): pass\\n' for k in range(n // 18))",
    ),
    (
        "exec",
        "''.join(f'class f{k}: pass\\n' for k in range(n // 18))",
    ),
    (
        "exec",
        "'class A:\\n' + ''.join(f'  x{k}: int = 1\\n' for k in range(n // 18))",
    ),
    (
        "exec",
        "'def f():\\n' + '  return lambda x: x + y\\n' * (n // 26)",
    ),
    ("exec", "'def f():\\n' + '  yield x\\n' * (n // 11)"),
    (
        "exec",
        "'def f():\\n' + ''.join(f'  yield x{k}\\n' for k in range(n // 13))",
    ),
    (
        "exec",
        "'def f():\\n if x: y\\n' + ' elif x: y\\n' * (n // 12)",
    ),
    (
        "exec",
        "'def f():\\n try: x\\n' + ' except x: y\\n' * (n // 14)",
    ),
    (
        "exec",
        "'def f():\\n' + '  try: x\\n  except A: pass\\n' * (n // 30)",
    ),
    ("exec", "'def f():\\n' + '  for x in y: x\\n' * (n // 16)"),
    ("exec", "'def f(): ' + 'x = ' * (n // 4) + 'y'"),
    ("exec", "'def f(): x[' + ':1,' * (n // 3) + ']'"),
    (
        "exec",
        "'def f(): x = [x for x in x' + ' if x' * (n // 5) + ']'",
    ),
    (
        "exec",
        "'def f(): (' + '(x for x in y), ' * (n // 16) + ')'",
    ),
    (
        "exec",
        "'def f():\\n' + ' $ LINE: (1, \"a\")\\n x = 1\\n' * (n // 26)",
    ),
    ("exec", "'def f(): x = ' + tree('x', n)"),
    ("eval", "'lambda: ' + tree('x + 1', n)"),
    ("eval", "'[' + '1,' * (n // 2)"),
    ("eval", "'f(' + 'x=[1],' * (n // 6) + ')'"),
];

/// Characters of those texts: as many as are allowed.
const TEXT: usize = if cfg!(debug_assertions) {
    100_000
} else {
    1 << 20
};

/// Reads the texts, with what `damage` makes of each (`t`).
fn check_texts(damage: &str, part: usize, parts: usize) {
    let given: Vec<_> = TEXTS.iter().skip(part).step_by(parts).collect();
    let calls: String = given
        .iter()
        .enumerate()
        .map(|(index, (function, text))| {
            let rest = match *function {
                "compile" => ", 'text', 'exec'",
                _ => "",
            };
            format!("attempt('{index}', lambda t: {function}(t{rest}), lambda: (damaged({text}),), lambda: ('1',))\n")
        })
        .collect();
    let trouble: Vec<String> = too_long(&format!(
        "{BEGIN}\nn = {TEXT}\ndef damaged(t): return {damage}\n{calls}"
    ))
    .iter()
    .map(|(index, stretch)| {
        let (function, text) = given[index.parse::<usize>().unwrap_or(0)];
        format!("{function}({text}): {stretch:?}")
    })
    .collect();
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}

/// An error after most of a text, in whatever it is in the middle of then.
const BROKEN_OFF: &str = "t[:len(t) // 4 * 3] + (b' 7 7' if isinstance(t, bytes) else ' 7 7')";

#[test]
fn reading_texts_that_break_off_gives_way_1() {
    check_texts(BROKEN_OFF, 0, 2);
}

#[test]
fn reading_texts_that_break_off_gives_way_2() {
    check_texts(BROKEN_OFF, 1, 2);
}

#[test]
fn reading_texts_gives_way_1() {
    check_texts("t", 0, 4);
}

#[test]
fn reading_texts_gives_way_2() {
    check_texts("t", 1, 4);
}

#[test]
fn reading_texts_gives_way_3() {
    check_texts("t", 2, 4);
}

#[test]
fn reading_texts_gives_way_4() {
    check_texts("t", 3, 4);
}

/// What is done with names, formats and numbers of any length: an expression of `n`.
const ACTS: &[&str] = &[
    "hasattr(o, 'a' * n)",
    "getattr(o, 'a' * n, 0)",
    "setattr(o, 'a' * n, 1)",
    "delattr(o, 'a' * n)",
    "setattr(C, 'a' * n, 1)",
    "setattr(C, '__name__', 'a' * n)",
    "getattr(math, 'a' * n)",
    "getattr(o, 'a' * min(n, 60_000))",
    "setattr(o, 'a' * min(n, 60_000), 1)",
    "o.__getattribute__('a' * n)",
    "type('a' * n, (), {})",
    "type('A', (), {'a' * n: 1})",
    "type('A', (), {'__slots__': ('a' * n,)})",
    "dict(**{'a' * n: 1})",
    "dict(**{'a' * min(n, 60_000) + str(k): 1 for k in range(200)})",
    "f(**{'a' * n: 1})",
    "eval('1', {'a' * n: 1})",
    "exec('b = 1', {}, {'a' * n: 1})",
    "'{' + 'a' * n + '}'",
    "('{' + 'a' * n + '}').format(a=1)",
    "('{' + '0' * n + '}').format(1)",
    "('{0.' + 'a' * n + '}').format(1)",
    "('{0[' + 'a' * n + ']}').format({})",
    "('{0!' + 'a' * n + '}').format(1)",
    "('{0:' + 'a' * n + '}').format(1)",
    "('{0:' + '0' * n + '}').format(1)",
    "('{:' + '{}' * (n // 2) + '}').format(1)",
    "('{' + 'a' * n).format(1)",
    "('{' + 'a' * n + '}').format_map({'a': 1})",
    "('%(' + 'a' * n + ')s') % {}",
    "('%(' + 'a' * n + ')s') % {'a' * n: 1}",
    "(b'%(' + b'a' * n + b')s') % {}",
    "('%' + '0' * n + 'd') % 1",
    "('%' + '-' * n + 'd') % 1",
    "('%' + '1' * n + 'd') % 1",
    "('%' + 'l' * n + 'd') % 1",
    "('位' * (n // 3) + '%q') % 1",
    "'%.*f' % (n, 1.5)",
    "'%.*e' % (n, 1.5)",
    "'%#.*g' % (n, 1.5)",
    "'%0*.*f' % (2 * n, n, 1.5)",
    "'%-*.*F' % (2 * n, n, 1.5)",
    "'%*d' % (n, 1)",
    "'%.*d' % (n, 1)",
    "'%*s' % (n, 'a')",
    "'%.*s' % (n, '位' * (n // 2))",
    "'%.*s' % (n // 4, '位' * (n // 2))",
    "'%s' % ('位' * (n // 3))",
    "b'%.*f' % (n, 1.5)",
    "format(1.5, f'.{n}f')",
    "format(1.5, f'.{n}%')",
    "format(1.5, f'#.{n}G')",
    "format(1.5, f',.{n}f')",
    "format(1.5, f'0{n},.{n // 2}f')",
    "format(1.5, f'^{2 * n}.{n}f')",
    "format(1e300, f'z.{n}e')",
    "format(1.5 + 2j, f'.{n}f')",
    "format(1.5 + 2j, f'>{2 * n}.{n}f')",
    "f'{1.5:.{n}f}'",
    "'{:.{}f}'.format(1.5, n)",
    "f'{7:{n}}{7:<{n}}{7:^{n}}'",
    "f'{7:0{n},}'",
    "f'{text}{text!r}{text!s:>{n + 9}}'",
    "'{}{}'.format(text, text)",
    "'{:.5}{:位<{}}'.format(text, text, n + 9)",
    "bin(big), oct(big), hex(big)",
    "f'{big:b}', f'{big:_X}', f'{big:#o}', '%x' % big, '%X' % big",
    "round(1.5, n), round(1.5, -n), round(big, -n)",
];

#[test]
fn names_and_formats_give_way() {
    let acts: Vec<String> = ACTS
        .iter()
        .enumerate()
        .map(|(index, act)| {
            format!("attempt('{index}', lambda: ({act}), lambda: (), lambda: ())\n")
        })
        .collect();
    let n = if cfg!(debug_assertions) {
        PARTS
    } else {
        PARTS / 2
    };
    let program = format!(
        "{BEGIN}
class C: pass
def f(**given): pass
def attempt(label, act, given, small):
    global n, text, big
    n, text, big = many
    print(label)
    give_way()
    try: result = act()
    except Exception: result = None
    give_way()
    del result
    give_way()
    print('-')
    give_way()
o = C()
many = {n}, 'a位' * ({n} // 4), (1 << min({n}, 4_000_000)) - 1
{}",
        acts.concat()
    );
    let trouble: Vec<String> = too_long(&program)
        .iter()
        .map(|(index, stretch)| {
            format!("{}: {stretch:?}", ACTS[index.parse::<usize>().unwrap_or(0)])
        })
        .collect();
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}

/// Patterns that are long in every way one can be, and texts that they are looked for in.
const PATTERNS: &[(&str, &str)] = &[
    ("'a' * n", "'a' * m"),
    ("'é' * (n // 2)", "'é' * m"),
    ("'(?i)' + 'aß' * (n // 3)", "'aß' * m"),
    ("'\\w' * (n // 2)", "'a' * m"),
    ("'[a-z]' * (n // 5)", "'a' * m"),
    ("'(?i)' + '[^a-zß]' * (n // 9)", "'0' * m"),
    (
        "'[' + ''.join(chr(0x4e00 + 7 * k % 90_000) for k in range(n // 4)) + ']'",
        "'a' * m",
    ),
    ("'a|' * (n // 2)", "'b' * 20"),
    ("'(a)' * (n // 3)", "'a' * m"),
    ("'(?:a?)' * (n // 6)", "'a' * 2000"),
    ("'(?:a*)*' * (n // 7)", "'a' * 2000"),
    ("'(?:aa|b){2,5}' * (n // 13)", "'aa' * m"),
    ("'(' * 90 + 'a' * n + ')*' * 90", "'a' * m"),
    ("'(?:' * 90 + 'a|' * (n // 2) + ')+' * 90", "'b' * 20"),
    ("''.join(f'(?P<n{k}>x)' for k in range(n // 14))", "'x' * m"),
    ("'(a)' + '\\1' * (n // 2)", "'a' * m"),
    ("'(a)' + '(?(1)a|b)' * (n // 9)", "'a' * m"),
    ("'(?=a)' * (n // 5)", "'a' * 500"),
    ("'(?<=' + 'a' * n + ')b'", "'a' * m"),
    ("'(?>a)' * (n // 5)", "'a' * m"),
    ("'(?x)' + '# a' * (n // 3)", "'a' * m"),
    ("'(?#' + 'a' * n + ')'", "'a' * m"),
    ("'a{' + '1' * n", "'a' * m"),
    ("'[' * n", "''"),
    ("'(?P<' + 'a' * n", "''"),
    // Short ones, and texts on which they take long.
    ("'(?=(a+)+$)(\\w+)\\1b'", "'a' * 40 + '!'"),
    ("'(?s)(?=.*b)x'", "'a' * m"),
    ("'(?=.*b)'", "'a' * 4000"),
    ("'(a*)\\1b'", "'a' * 4000"),
    ("'(?>a*)b'", "'a' * 4000"),
    ("'(?i)(é*)\\1b'", "'éÉ' * 1000"),
    ("'(?<=a{1000})b'", "'a' * 4000"),
    ("'(a+)+b'", "'a' * m"),
    ("'(a|b|ab)*c'", "'ab' * m"),
    ("'a{1,1000}b'", "'a' * m"),
    ("'(?:a{1,10}){3}b'", "'a' * m"),
    ("'(?:(?:a|b){0,3}?)*$'", "'ab' * m"),
    ("'x*'", "'位' * m"),
    ("'位'", "'a' * m"),
];

fn check_expressions(part: usize, parts: usize) {
    // What is tried at every place of a text takes time that grows with the product of both.
    let (n, m) = if cfg!(debug_assertions) {
        (40_000, 500)
    } else {
        (1_000_000, 20_000)
    };
    let given: Vec<_> = PATTERNS.iter().skip(part).step_by(parts).collect();
    let calls: String = given
        .iter()
        .enumerate()
        .map(|(index, (pattern, text))| {
            format!(
                "attempt('{index}', use, lambda: ({pattern}, {text}), lambda: ('a', 'a'))\n\
                 attempt('{index}', use, lambda: (({pattern}).encode(), ({text}).encode()), lambda: ('a', 'a'))\n"
            )
        })
        .collect();
    let program = format!(
        "{BEGIN}
n = {n}
m = {m}
def use(pattern, text):
    made = re.compile(pattern)
    make = (made.search, made.fullmatch, made.split, lambda text: made.groupindex)
    for act in make:
        try: found = act(text)
        except RuntimeError: continue
    found = made.match(text)
    if found: return found.regs, found.groups(), found.groupdict()
{calls}"
    );
    let trouble: Vec<String> = too_long(&program)
        .iter()
        .map(|(index, stretch)| {
            let (pattern, text) = given[index.parse::<usize>().unwrap_or(0)];
            format!("{pattern} in {text}: {stretch:?}")
        })
        .collect();
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}

#[test]
fn regular_expressions_give_way_1() {
    check_expressions(0, 2);
}

#[test]
fn regular_expressions_give_way_2() {
    check_expressions(1, 2);
}

/// What a program does with many values, and what it leaves behind: how they are made of `n`, and what is done with
/// them (`x`).
const DEEDS: &[(&str, &str)] = &[
    ("list(range(n))", "f(*x)"),
    ("list(range(n))", "max(*x)"),
    ("list(range(n))", "'{}'.format(*x)"),
    ("{f'k{i}': i for i in range(n // 16)}", "f(**x)"),
    ("{f'k{i}': i for i in range(n // 16)}", "dict(**x)"),
    ("list(range(n))", "unpacked(x)"),
    ("dict.fromkeys(range(n))", "[x.popitem() for _ in range(n)]"),
    (
        "dict.fromkeys(range(n))",
        "[x.pop(next(iter(x))) for _ in range(n)]",
    ),
    ("set(range(n))", "[x.pop() for _ in range(n)]"),
    (
        "collections.OrderedDict.fromkeys(range(n))",
        "[x.move_to_end(i, False) for i in range(0, n, 2)]",
    ),
    // Tables of which little is left, between and before what has gone.
    (
        "dict.fromkeys(range(16 * n))",
        "[x.pop(i) for i in range(1, 11 * n)] and (list(zip(x, x)), [next(iter(x)) for _ in range(9)])",
    ),
    (
        "dict.fromkeys(range(16 * n))",
        "[x.pop(i) for i in range(5 * n, 16 * n - 1)] and (list(reversed(x)), x.popitem(), x.popitem())",
    ),
    (
        "collections.OrderedDict.fromkeys(range(16 * n))",
        "[x.pop(i) for i in range(11 * n)] and (x.move_to_end(12 * n, False), x.popitem(False))",
    ),
    (
        "set(range(16 * n))",
        "[x.discard(i) for i in range(16 * n - 1)] and (list(x), next(iter(x)), x.pop())",
    ),
    // Names.
    (
        "Node()",
        "[setattr(x, f'n{i}', i) for i in range(n // 4)] and (dir(x), vars(x), [delattr(x, f'n{i}') \
         for i in range(n // 4)])",
    ),
    (
        "type('T', (), {})",
        "[setattr(x, f'n{i}', i) for i in range(n // 4)] and (dir(x), x.__dict__, [delattr(x, f'n{i}') \
         for i in range(n // 4)])",
    ),
    (
        "(lambda: 1)",
        "[setattr(x, f'n{i}', i) for i in range(n // 4)] and (dir(x), x.__dict__)",
    ),
    (
        "{f'm{i}': i for i in range(n // 4)}",
        "(type('T', (), x), type('T', (), {'__slots__': list(x)}))",
    ),
    (
        "[type('D', (Node,), {}) for _ in range(n // 32)]",
        "([y().me for y in x if setattr(y, 'me', 1)], setattr(Node, 'me', 2), Node.__subclasses__(), \
         delattr(Node, 'me'))",
    ),
    (
        "[]",
        "(__import__('dataclasses'), __import__('statistics'), __import__('subprocess'), __import__('datetime'))",
    ),
    // Containers of which none is big.
    ("[[0] * 1000 for _ in range(n // 100)]", "x.clear()"),
    ("[(0,) * 1000 for _ in range(n // 100)]", "x.clear()"),
    ("[[0] * 200 for _ in range(n // 80)]", "x.clear()"),
    (
        "[dict.fromkeys(range(1000)) for _ in range(n // 300)]",
        "x.clear()",
    ),
    ("[set(range(1000)) for _ in range(n // 300)]", "x.clear()"),
    (
        "[collections.deque(range(1000)) for _ in range(n // 100)]",
        "x.clear()",
    ),
    ("[Node() for _ in range(n // 3)]", "x.clear()"),
    ("[[i] for i in range(n)]", "x.clear()"),
    (
        "[None]",
        "[x.__setitem__(0, [x[0]]) for _ in range(n)] and None",
    ),
    (
        "[None]",
        "[x.__setitem__(0, (x[0],)) for _ in range(n)] and None",
    ),
    (
        "[None]",
        "[x.__setitem__(0, {1: x[0]}) for _ in range(n // 4)] and None",
    ),
    ("[str(i) for i in range(n)]", "sorted(x)"),
    ("[str(i) for i in range(n)]", "sorted(x, key=len)"),
    (
        "dict.fromkeys(range(n))",
        "(set(x), frozenset(x), dict(x), list(x))",
    ),
    (
        "[Node() for _ in range(n // 8)]",
        "[setattr(a, 'me', a) for a in x] and None",
    ),
    (
        "[f'f{i}' for i in range(min(n // 32, 60_000))]",
        "collections.namedtuple('T', x)",
    ),
    (
        "' '.join(f'f{i}' for i in range(min(n // 32, 60_000)))",
        "collections.namedtuple('T', x)",
    ),
    ("'a,' * n", "collections.namedtuple('T', x)"),
    (
        "{str(i): [i] for i in range(n // 8)}",
        "json.loads(json.dumps(x, sort_keys=True))",
    ),
    (
        "list(range(n))",
        "(p := itertools.permutations(x), next(p), copy.copy(p), next(p), next(itertools.permutations(x, 1)))",
    ),
    (
        "list(range(n))",
        "(c := itertools.combinations(x, n), next(c), next(c, None), \
         next(itertools.combinations_with_replacement(x, n)))",
    ),
    (
        "[[1, 2]] * n",
        "(p := itertools.product(*x), next(p), copy.copy(p), next(p))",
    ),
];

#[test]
fn what_is_done_and_left_gives_way() {
    let deeds: Vec<String> = DEEDS
        .iter()
        .enumerate()
        .map(|(index, (made, deed))| {
            format!("attempt('{index}', lambda: ({made}), lambda x: ({deed}))\n")
        })
        .collect();
    let program = format!(
        "{BEGIN}
class Node: pass
def f(*a, **k): return len(a) + len(k)
def unpacked(x):
    a, *b = x
    *c, d = x
    a, *b, d = x
    return b, c
def attempt(label, make, act):
    x = make()
    print(label)
    give_way()
    try: result = act(x)
    except Exception: result = None
    give_way()
    result = x = None
    give_way()
    print('-')
    give_way()
n = {VALUES}
{}",
        deeds.concat()
    );
    let trouble: Vec<String> = too_long(&program)
        .iter()
        .map(|(index, stretch)| {
            let (made, deed) = DEEDS[index.parse::<usize>().unwrap_or(0)];
            format!("{deed} of {made}: {stretch:?}")
        })
        .collect();
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}
