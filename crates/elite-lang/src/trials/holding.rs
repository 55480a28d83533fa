//! Every callable of the builtins and of the library that keeps an argument in what it gives: a long chain of it is
//! dropped. Which ones do is found by asking, so that a new native is tried without being named here.

use super::{TestHost, drive};
use elite_syntax::{KnownNames, SourceFile, compile};

use crate::{Interpreter, Limits, NativeBody, NativeFunction, Param, Value};
use std::rc::Rc;

/// Whoever imports a module of the library gets these names; `_` begins those that scripts do not see.
const PROGRAM: &str = r#"
class Kept:
    def __call__(self, *a): return self
    def __iter__(self): return iter(())
    def __len__(self): return 0
    def keys(self): return []
def plain(*a): return None
class Letters(str): pass
class Numbers(list): pass
class Pairs(dict): pass
def forms(v):
    text = Letters('ab')
    text.next = v
    numbers = Numbers([1])
    numbers.next = v
    pairs = Pairs(a=1)
    pairs.next = v
    yield (v,), {}
    yield (v, v), {}
    yield (v, v, v), {}
    yield ('a', v), {}
    yield ('a',), {'b': v}
    yield (plain, v), {}
    yield (v, 1), {}
    yield (1, v), {}
    yield (None, v), {}
    yield ([v],), {}
    yield ([v], 1), {}
    yield ({'k': v},), {}
    yield ('', text), {}
    yield (text,), {}
    yield (numbers,), {}
    yield (pairs,), {}
    yield ('a', (Kept,), {'v': v}), {}
FORMS = 17
def attempt(function, form, v):
    for number, (args, names) in enumerate(forms(v)):
        if number == form: return function(*args, **names)
def keeps(function, form):
    try:
        kept = Kept()
        before = references(kept)
        made = attempt(function, form, kept)
        return made is not kept and made is not None and references(kept) > before
    except BaseException: return False
found, failed = [], []
TRIED = ('BaseException', 'ValueError', 'OSError', 'StopIteration', 'SystemExit', 'ExceptionGroup', 'UnicodeError',
         'SyntaxError', 'KeyError')
def chain(name, function):
    ways = 0
    for form in range(FORMS):
        if ways == WAYS or not keeps(function, form): continue
        ways += 1
        found.append(name)
        v = plain
        try:
            for n in range(COUNT): v = attempt(function, form, v)
        except BaseException as e: failed.append(name)
        v = None
SKIPPED = ['input', 'exit', 'quit', '_exit', 'sleep', 'settrace', 'setprofile', 'start_new_thread', 'signal',
           'alarm', 'atexit.register', 'register']
def all_of(place, module):
    for name in dir(module):
        if name in SKIPPED: continue
        value = getattr(module, name, None)
        # All exceptions are made alike.
        if isinstance(value, type) and issubclass(value, BaseException) and name not in TRIED: continue
        if callable(value): chain(place + name, value)
        if isinstance(value, type):
            for method in dir(value):
                if method.startswith('from_'): chain(place + name + '.' + method, getattr(value, method))
"#;

/// With so many links a recursion of a hundred bytes runs out of any stack of a script's thread.
const COUNT: usize = if cfg!(debug_assertions) {
    4_000
} else {
    20_000
};
/// Ways to call one function that are tried.
const WAYS: usize = 3;

fn found_in(modules: &[&str]) -> String {
    let mut text = PROGRAM
        .replace("COUNT", &COUNT.to_string())
        .replace("WAYS", &WAYS.to_string());
    for module in modules {
        text += &format!(
            "try:\n    import {module}\n    all_of('{module}.', {module})\nexcept ImportError: pass\n"
        );
    }
    text += "print(' '.join(sorted(set(found))))";
    let references = NativeFunction {
        name: "references",
        params: vec![Param::required("value")],
        call: NativeBody::new(|call| match &call.args()[0] {
            Value::Instance(instance) => Ok(Value::from(Rc::strong_count(instance) as i64)),
            _ => Ok(Value::None),
        }),
    };
    let (stage, limits) = (Rc::new(TestHost::default()), Limits::default());
    let interpreter = Interpreter::new(stage.clone(), vec![references], limits);
    let known = KnownNames::new(["references"]);
    let program = compile(SourceFile::new("trial", text), &known);
    let program = program.unwrap_or_else(|found| panic!("{found:?}"));
    let report = drive(&stage, interpreter.spawn_program(&program));
    assert_eq!(report, "");
    drop(interpreter);
    stage.output.take()
}

/// The names that were found, of which these must be some.
fn check(modules: &[&str], some: &[&str]) {
    let found = found_in(modules);
    let names: Vec<&str> = found.split_whitespace().collect();
    for name in some {
        assert!(names.contains(name), "{name} keeps nothing: {found}");
    }
}

#[test]
fn chains_of_whatever_builtins_keep_are_dropped() {
    check(
        &["builtins"],
        &[
            "builtins.list",
            "builtins.map",
            "builtins.slice",
            "builtins.property",
        ],
    );
}

#[test]
fn chains_of_whatever_the_library_keeps_are_dropped() {
    // The module `typing` is left out: what it keeps is nothing that scripts would not.
    let ours: Vec<&str> = elite_syntax::python_names::module_names()
        .filter(|name| *name != "typing")
        .collect();
    assert!(ours.len() > 30, "{ours:?}");
    check(
        &ours,
        &[
            "operator.itemgetter",
            "operator.methodcaller",
            "functools.partial",
            "functools.cmp_to_key",
            "collections.deque",
            "itertools.chain",
            "re.match",
        ],
    );
}
