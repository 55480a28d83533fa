//! A stop reaches every native: between two safepoints there are a few milliseconds at most, also where a native walks
//! through values that hold others twice, thirty levels deep, so that it never comes to an end.
//!
//! Functions and methods are those that `dir` finds, with values of every kind that holds others.
#![allow(clippy::unwrap_used, clippy::expect_used)] // a test

use elite_lang::Limits;

use crate::stretch::{STRETCH_MAX, TRIES, longest};
use crate::support::Task;

/// Levels that hold the next one twice: enough to compute for a second.
const LEVELS: usize = if cfg!(debug_assertions) { 21 } else { 26 };

/// How a value holds another one twice, and what is innermost.
const SHARED: &[(&str, &str, &str)] = &[
    ("tuple", "(v, v)", "int"),
    ("tuple behind others", "(str, v, v)", "int"),
    ("list", "[v, v]", "1"),
    ("tuple of values", "(v, v)", "1"),
    ("dict", "{'a': v, 'b': v}", "1"),
    ("class of tuples", "T((v, v))", "int"),
    ("instance", "Two(v, v)", "1"),
    ("group", "ExceptionGroup('g', [v, v])", "ValueError()"),
    ("deque", "collections.deque([v, v])", "1"),
    ("partial", "functools.partial(v, v)", "plain"),
    ("map", "map(pair, [v, v], [v, v])", "1"),
    ("text", "(v, v)", "'a'"),
];

const FORMS: &[&str] = &[
    "f(a)",
    "f(a, b)",
    "f(1, a)",
    "f('x', a)",
    "f(a, 1)",
    "f([a, b])",
    "f(str, a)",
    "f(int, a)",
    "f({'k': a})",
    "f([a], [b])",
    "f('%s', a)",
    "f(plain, [a, b])",
];

/// What is no call of a function.
const ACTS: &[&str] = &[
    "a == b",
    "a != b",
    "a < b",
    "a in [b]",
    "{a: 1}",
    "f'{a}'",
    "'%s' % (a,)",
    "'{}'.format(a)",
    "'abc'.startswith(a)",
    "[a].index(b)",
    "[a].count(b)",
    "[b].remove(a)",
    "sorted([a, b])",
    "caught(a)",
    "caught_group(a)",
    "raised(a)",
    "a | b",
    "type('X', (a,), {})",
    "copy.copy(a)",
    "copy.deepcopy(a)",
    "json.dumps(a)",
    "re.sub('a', 'b', a)",
    "isinstance(1, (str, a))",
    "issubclass(str, (list, a))",
    "a.split(plain)",
    "a.split(KeyError)",
    "a.subgroup(KeyError)",
    "Two(a, b) == Two(b, a)",
    "hash(Frozen(a))",
];

const BEGIN: &str = "
import collections, copy, json, re, struct, math, random, itertools, functools, operator, bisect, string, io, heapq, \
dataclasses
modules = [collections, json, re, struct, math, random, itertools, functools, operator, bisect, string, io, heapq]
class T(tuple): pass
@dataclasses.dataclass
class Two:
    x: object
    y: object
@dataclasses.dataclass(frozen=True)
class Frozen:
    x: object
def plain(*a): return 1
def pair(*a): return a
def caught(a):
    try: raise ValueError('x')
    except a: pass
def caught_group(a):
    try: raise ExceptionGroup('x', [ValueError('x')])
    except* a: pass
def raised(a):
    try: raise a
    except* KeyError: pass
def shared():
    v = START
    for _ in range(LEVELS): v = WRAP
    return v
";

fn begin(wrap: &str, start: &str) -> String {
    BEGIN
        .replace("LEVELS", &LEVELS.to_string())
        .replace("WRAP", wrap)
        .replace("START", start)
}

/// A program that does one thing with what is shared.
fn program(before: &str, act: &str) -> String {
    format!(
        "a, b = shared(), shared()\n{before}\nprint('go')\nfor _ in range(2): pass\n\
         try: {act}\nexcept Exception: pass\n"
    )
}

/// Functions, of builtins and of the library, that take a value of this kind in some form without refusing a small one.
fn functions_that_take(wrap: &str, start: &str) -> Vec<(String, usize)> {
    let names: Vec<&str> = elite_syntax::python_names::builtin_names()
        .filter(|name| name.starts_with(char::is_lowercase))
        .collect();
    let forms = FORMS.join(", lambda f, a, b: ");
    let text = format!(
        "{}
skipped = ('exit', 'quit', 'input', 'print', 'open', 'exec', 'eval', 'compile', 'globals', 'locals', 'vars', 'super', \
'cycle', 'count',
           'repeat', 'combinations', 'combinations_with_replacement', 'permutations', 'product', 'seed')
names = {names:?}
for module in modules:
    names += [module.__name__ + '.' + name for name in dir(module) if name[0] != '_']
forms = [lambda f, a, b: {forms}]
v = START
v = WRAP
for name in names:
    if name.split('.')[-1] in skipped: continue
    f = eval(name)
    if not callable(f): continue
    for number, form in enumerate(forms):
        try: form(f, v, v)
        except Exception: continue
        print(name, number)
",
        begin(wrap, start)
    )
    .replace("START", start)
    .replace("WRAP", wrap);
    let output = Task::new().run(&text);
    let line = |line: &str| {
        let (name, form) = line.rsplit_once(' ').expect("a name and a number");
        (name.to_owned(), form.parse().expect("a number"))
    };
    output.lines().map(line).collect()
}

fn check(part: usize, of: usize) {
    let mut trouble = Vec::new();
    for (kind, wrap, start) in SHARED.iter().skip(part).step_by(of) {
        let limits = Limits {
            memory_bytes: 64 << 20,
            ..Limits::default()
        };
        let task = Task::with(Vec::new(), limits);
        assert_eq!(task.run(&begin(wrap, start)), "");
        let taken = functions_that_take(wrap, start);
        assert!(taken.len() > 20, "{kind}: hardly any function takes it");
        let calls = taken
            .into_iter()
            .map(|(name, form)| (format!("f = {name}"), FORMS[form].to_owned(), name));
        let acts = ACTS
            .iter()
            .map(|act| (String::new(), (*act).to_owned(), String::new()));
        for (before, act, name) in calls.chain(acts) {
            let text = program(&before, &act);
            let tries = (0..TRIES).map(|_| longest(&task, &text, usize::MAX));
            let mut too_long = tries.take_while(|stretch| *stretch > STRETCH_MAX);
            if let Some(last) = too_long.nth(TRIES - 1) {
                trouble.push(format!("{kind}: {name} {act}: {last:?}"));
            }
        }
    }
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}

macro_rules! parts {
    ($($name:ident $part:literal;)*) => {
        $(#[test] fn $name() { check($part, PARTS); })*
        const PARTS: usize = [$($part,)*].len();
    };
}

parts! {
    a_stop_reaches_natives_on_shared_data_1 0;
    a_stop_reaches_natives_on_shared_data_2 1;
    a_stop_reaches_natives_on_shared_data_3 2;
    a_stop_reaches_natives_on_shared_data_4 3;
}
