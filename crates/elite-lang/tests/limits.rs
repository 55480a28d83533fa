//! Sizes and depths of data: refused with an exception of the script, never a crash, whatever operation meets them.

use crate::support;

use elite_lang::{Limits, Value};
use support::{Task, drive, last_line, run};

/// The last line a program leaves if its task may hold `mebibytes`.
fn last_within(mebibytes: usize, text: &str) -> String {
    let limits = Limits {
        memory_bytes: mebibytes << 20,
        ..Limits::default()
    };
    support::last_but_help(&Task::with(Vec::new(), limits).run(text))
}

#[test]
fn sizes_are_refused_before_anything_is_allocated() {
    for case in [
        "'x' * (1 << 45)",
        "(1 << 45) * b'x'",
        "bytearray(1 << 45)",
        "[1] * (1 << 45)",
        "'a'.center(1 << 45)",
        "'a'.zfill(1 << 45)",
        "b'a'.rjust(1 << 45)",
        "'\\t'.expandtabs(1 << 30)",
        "(1).to_bytes(1 << 45, 'big')",
        "'%*d' % (1 << 30, 1)",
        "'{:{}}'.format(1, 1 << 30)",
        "format(1.0, '.1000000000f')",
        "x = 'ab' * (1 << 20)\nx.replace('a', x)",
        "x = 'ab' * (1 << 20)\nx.join(x)",
        "x = 'é' * (2 << 20)\nx.encode('ascii', 'backslashreplace')",
        "x = 'ab' * (3 << 20)\nx.encode('utf-32')",
        "x = [1]\nwhile True: x *= 2",
        "x = (1,)\nwhile True: x += x",
        "x = bytearray(b'a')\nwhile True: x += bytes(x)",
        "x = {}\nwhile True: x |= {len(x): 'x' * 1000}",
        "def f(*a): return a\nx = [1] * (1 << 20)\nf(*x, *x, *x, *x, *x, *x, *x, *x)",
        "[*range(1 << 40)]",
        "sorted(range(1 << 40))",
        "x = []\nx.extend(range(1 << 40))",
        "x = [0]\nx[1:1] = range(1 << 40)",
    ] {
        let last = last_within(16, case);
        assert!(
            last.starts_with("MemoryError")
                || last.starts_with("ValueError: Too many decimal digits"),
            "{case}\n{last}"
        );
    }
}

#[test]
fn a_refused_size_leaves_the_program_running() {
    let text = "n = 0\nfor size in [1 << 45, 1 << 60, 10 ** 30]:\n    try: 'x' * size\n    \
                except (MemoryError, OverflowError): n += 1\nprint(n)";
    assert_eq!(last_within(16, text), "3");
    let text = "x = []\ntry:\n    while True: x.append('y' * 1000)\nexcept MemoryError:\n    x.clear()\n\
                y = ['y' * 1000 for _ in range(5000)]\nprint(len(y))";
    assert_eq!(last_within(16, text), "5000");
}

#[test]
fn deep_data_is_compared_hashed_and_shown_within_bounds() {
    let deep = |make: &str| format!("x = y = None\nfor _ in range(100000): x, y = {make}\n");
    for (make, use_) in [
        ("[x], [y]", "repr(x)"),
        ("[x], [y]", "str(x)"),
        ("[x], [y]", "x == y"),
        ("[x], [y]", "x < y"),
        ("[x], [y]", "f'{x}'"),
        ("[x], [y]", "'%s' % x"),
        ("[x], [y]", "x in [y]"),
        ("[x], [y]", "[y].index(x)"),
        ("(x,), (y,)", "hash(x)"),
        ("(x,), (y,)", "{x}"),
        ("(x,), (y,)", "x == y"),
        ("{1: x}, {1: y}", "repr(x)"),
        ("{1: x}, {1: y}", "x == y"),
        ("frozenset([x]), frozenset([y])", "repr(x)"),
        ("slice(x), slice(y)", "repr(x)"),
        ("property(x), property(y)", "undefined"),
        ("staticmethod(x), classmethod(y)", "undefined"),
    ] {
        let last = last_line(&format!("{}{use_}", deep(make)));
        let expected = if use_ == "undefined" {
            "NameError"
        } else {
            "RecursionError"
        };
        assert!(last.starts_with(expected), "{make}, {use_}\n{last}");
    }
    // Nothing is left behind by the error, and dropping the data is no recursion.
    let text = format!(
        "{}try: repr(x)\nexcept RecursionError: print(repr([1, [2]]))",
        deep("[x], [y]")
    );
    assert_eq!(run(&text), "[1, [2]]\n");
}

#[test]
fn circles_are_shown_and_compared_in_the_end() {
    assert_eq!(run("x = []\nx.append(x)\nprint(x)"), "[[...]]\n");
    assert!(
        last_line("x = []\nx.append(x)\ny = []\ny.append(y)\nx == y").starts_with("RecursionError")
    );
    assert!(
        last_line(
            "class A:\n    def __init__(self): self.me = self\n    def __repr__(self): \
             return f'{self.me}'\nrepr(A())"
        )
        .starts_with("RecursionError")
    );
}

#[test]
fn the_call_depth_is_the_same_on_the_main_program_a_thread_and_in_a_generator() {
    let text = "def f(n): return n if n == 0 else f(n - 1)\n\
                def depth():\n    n = 0\n    while True:\n        try: f(n)\n        except RecursionError: return n\
                \n        n += 10\ndef g(): yield depth()\n\
                print(depth(), next(g()), [depth() for _ in '1'], max([1], key=lambda _: depth()))";
    let output = run(text);
    let numbers: Vec<i64> = output
        .split(|c: char| !c.is_ascii_digit())
        .filter_map(|word| word.parse().ok())
        .collect();
    assert!(
        numbers[..3].iter().all(|n| (970..=1000).contains(n)),
        "{output}"
    );
    let task = Task::new();
    task.run("def f(n): return n if n == 0 else f(n - 1)");
    let f = task.interpreter.global("f").map(|f| {
        task.interpreter
            .spawn_call(f, vec![Value::Int(5000)])
            .map(|mut thread| format!("{:?}", drive(&mut thread, &task.host)))
    });
    let end = format!("{f:?}");
    assert!(end.contains("RecursionError"), "{end}");
}

#[test]
fn texts_nest_two_hundred_deep_and_no_deeper() {
    for (open, close) in [
        ("(", ")"),
        ("[", "]"),
        ("{", "}"),
        ("{1: ", "}"),
        ("f(", ")"),
        ("x[", "]"),
        ("lambda: ", ""),
    ] {
        let nested = |n: usize| {
            format!(
                "x = f = None\ndef never():\n    y = {}1{}\n",
                open.repeat(n),
                close.repeat(n)
            )
        };
        assert_eq!(run(&nested(150)), "", "{open}");
        let found = elite_syntax::check(Task::file(&nested(250)), &Default::default());
        assert!(
            found
                .iter()
                .any(|f| f.message.english().contains("200 levels")),
            "{open}: {found:?}"
        );
    }
}

#[test]
fn names_made_up_at_run_time_are_bounded() {
    let program = "
class C: pass
o = C()
long, fits = 'a' * 65537, 'a' * 65536
acts = [lambda: hasattr(o, long), lambda: getattr(o, long, 0), lambda: setattr(o, long, 1), lambda: delattr(o, long),
        lambda: type(long, (), {}), lambda: type('A', (), {long: 1}), lambda: dict(**{long: 1}),
        lambda: setattr(C, '__name__', long), lambda: ('{' + long + '}').format(1), lambda: format(1, '0' * 4097)]
for act in acts:
    try: print('taken', act())
    except ValueError as error: print(error)
setattr(o, fits, 5)
print(getattr(o, fits), hasattr(o, fits), dict(**{fits: 1}) == {fits: 1}, eval('a', {long * 20: 1, 'a': 2}))
";
    let expected = format!(
        "{}{}5 True True 2\n",
        "a name of 65537 bytes, 65536 are allowed\n".repeat(9),
        "a format specification of 4097 bytes, 4096 are allowed\n"
    );
    assert_eq!(run(program), expected);
}
