//! Deep data on small stacks: every text that nests, run, compiled, evaluated and dropped in generators and in deep
//! calls. And what lies below all care: a native stack that overflows ends its task, and no more.
#![allow(clippy::unwrap_used, clippy::expect_used)] // a test

use std::hint::black_box;
use std::panic::{AssertUnwindSafe, catch_unwind};

use elite_lang::{Limits, NativeBody, NativeFunction, Param, Value};

use crate::nesting::{CHAINS, NESTED};
use crate::support::Task;

/// Levels and links that compile.
const LEVELS: usize = 190;
const LINKS: usize = 960;

/// Chains that are programs only with an end: the first link, what follows again and again, the end.
const ENDED_CHAINS: &[(&str, &str, &str)] = &[
    ("x = [a for b in c", " for b in c", "]"),
    ("x = {a for b in c", " for b in c", "}"),
    ("x = {a: a for b in c", " for b in c", "}"),
    ("x = f(*(a for b in c", " for b in c", "))"),
    ("x = [a for b in c", " for [b, d] in [[c, c]] if b < c", "]"),
    ("x = [a for b in c", " if b < c", "]"),
    ("x = [a", ", a", "]"),
    ("x = {a", ", *a", "}"),
    ("x = f(a", ", a", ")"),
    ("x = f(*a", ", *a", ")"),
    ("x = f(**a", ", **{}", ")"),
    ("x = f'", "{a}", "'"),
    ("with a", ", a", ": pass"),
    ("with a as b", ", a as (b)", ": pass"),
    ("for b in c", ", c", ": pass"),
    ("@a", "\n@a", "\ndef f(): pass"),
    ("if not a: pass", "\nelif not a: pass", "\nelse: pass"),
    ("x = ((lambda: a)", "()", ")"),
];

fn deep_texts() -> Vec<String> {
    let nested = NESTED.iter().map(|(before, open, inner, close, after)| {
        let (open, close) = (open.repeat(LEVELS), close.repeat(LEVELS));
        format!("{before}{open}{inner}{close}{after}")
    });
    let chains = CHAINS
        .iter()
        .map(|(first, more)| format!("{first}{}", more.repeat(LINKS)));
    let ended = ENDED_CHAINS
        .iter()
        .map(|(first, more, end)| format!("{first}{}{end}", more.repeat(LINKS)));
    nested.chain(chains).chain(ended).collect()
}

/// What is done with such texts, in a frame of a generator that has a stack of its own, `n` calls deep in it. Their
/// names are unbound, so that the first use ends them, or hold a value that allows everything, so that they are
/// evaluated to their deepest place.
const WALK: &str = "
class Willing:
    def whatever(self, *given, **named): return self
    __getattr__ = __call__ = __getitem__ = __enter__ = whatever
    for name in ('add', 'sub', 'mul', 'matmul', 'mod', 'floordiv', 'lshift', 'or', 'pow'):
        locals()['__' + name + '__'] = locals()['__r' + name + '__'] = whatever
    __neg__ = __pos__ = __invert__ = whatever
    def __iter__(self): return iter([self])
    truth = False
    def __bool__(self):
        self.truth = not self.truth
        return self.truth
    def __contains__(self, other): return True
    def __lt__(self, other): return True
    def __str__(self): return ''
    def __index__(self): return 0
    def keys(self): return ['a']
    def __setitem__(self, key, value): pass
    def __delitem__(self, key): pass
    def __exit__(self, *error): return False
def names(): return {name: Willing() for name in 'abcdfijk'}
def in_function(text): return 'def f(a, b, c):\\n    ' + text.replace('\\n', '\\n    ') + '\\nf(i, j, k)'
def each(text):
    for act in (lambda: exec(text, {}), lambda: compile(text, 'x', 'exec'), lambda: eval(text[4:], {}),
                lambda: exec(text, names()), lambda: exec(in_function(text), names()),
                lambda: exec(in_function(text), {})):
        try: act()
        except Exception: pass
def deep(n, text):
    if n: return deep(n - 1, text)
    each(text)
def walk(n):
    try:
        for text in texts:
            deep(n, text)
            yield 0
    finally: pass
";

fn walk(depths: &str) {
    let mut text = "texts = [\n".to_owned();
    for deep in deep_texts() {
        text += &format!("    {deep:?},\n");
    }
    text += &format!("]\n{WALK}for n in {depths}:\n    list(walk(n))\nprint('walked')\n");
    // Rust writes other escapes than this language reads; none of these texts has any but of the end of a line.
    let output = Task::new().run(&text);
    assert!(output.ends_with("walked\n"), "{:.300}", output.trim_start());
}

#[test]
fn deep_texts_are_run_and_dropped_in_generators() {
    walk("range(0, 12)");
}

#[test]
fn deep_texts_are_run_and_dropped_in_deep_calls_of_generators() {
    walk("range(12, 420, 17)");
}

#[test]
fn deep_texts_are_run_and_dropped_in_deep_calls() {
    walk("range(420, 700, 40)");
}

#[test]
fn groups_of_expressions_nest_in_any_call() {
    let output = Task::new().run(
        "import re\n\
         def deep(n):\n\
         \x20   re.purge()\n\
         \x20   re.compile('(' * 80 + 'a' + ')*' * 80)\n\
         \x20   if n: deep(n - 1)\n\
         def walk():\n\
         \x20   try:\n\
         \x20       yield deep(300)\n\
         \x20   finally: pass\n\
         deep(500)\n\
         list(walk())\n\
         print('read')",
    );
    assert_eq!(output, "read\n");
}

/// A fault of ours: recursion that asks nobody whether there is room, in steps of different sizes, with or without
/// blocks of memory.
fn fall(call: &mut elite_lang::NativeCall<'_>) -> elite_lang::ScriptResult {
    fn step(size: i64, level: u64) -> u64 {
        let small = [level; 5];
        let block =
            (size & 1 == 1).then(|| vec![level; 1 + (size as usize * 37 + level as usize) % 700]);
        let large = (size % 7 == 0).then_some([level; 1100]);
        if level == u64::MAX {
            return 0;
        }
        let deeper = step(size, level + 1);
        black_box(&small)[0]
            + black_box(&block).as_ref().map_or(0, |block| block[0])
            + deeper
            + black_box(&large).map_or(0, |large| large[0])
    }
    let size = call.arg(0).and_then(Value::as_i64).unwrap_or(0);
    Ok(Value::from(step(black_box(size), 0) as i64))
}

fn falling(program: &str) -> String {
    let native = NativeFunction {
        name: "fall",
        params: vec![Param::required("size")],
        call: NativeBody::new(fall),
    };
    let task = Task::with(vec![native], Limits::default());
    let fallen = catch_unwind(AssertUnwindSafe(|| task.run(program)));
    let panicked = fallen.expect_err("the stack has no end");
    let text = panicked.downcast_ref::<String>().cloned();
    drop(task);
    text.unwrap_or_default()
}

#[test]
fn an_overflow_ends_its_task_and_no_more() {
    if !cfg!(target_os = "linux") {
        return;
    }
    for round in 0..60 {
        let call = match round % 4 {
            0 => format!("fall({round})"),
            1 => format!(
                "def g():\n    try: yield fall({round})\n    finally: print('never')\nnext(g())"
            ),
            2 => format!("def deep(n):\n    return deep(n - 1) if n else fall({round})\ndeep(300)"),
            _ => format!("sorted([3, 1, 2], key=lambda x: fall({round}))"),
        };
        let program = format!(
            "def held():\n    try: yield 1\n    finally: print('never')\nkept = [held() for _ in range(9)]\n\
             x = []\nfor g in kept: next(g)\nfor i in range(20000): x = [x]\nkept.append(x)\n{call}"
        );
        let run = move || falling(&program);
        let text = std::thread::spawn(run).join().expect("it is caught");
        assert!(
            text.contains("native stack") && text.contains("at line"),
            "{text}"
        );
    }
    assert_eq!(Task::new().run("print(sum(range(9)))"), "36\n");
}
