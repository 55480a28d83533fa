//! A task holds what it may and no more, as the system sees it, and leaves nothing behind.

#[path = "support/shapes.rs"]
mod shapes;
mod support;

use std::sync::atomic::{AtomicIsize, Ordering};

use elite_lang::{Limits, NativeBody, NativeFunction, Value};
use shapes::{SHAPES, forget_peak, of_process, program};
use support::Task;

const MEBIBYTE: usize = 1 << 20;

/// Runs a program that may hold `limit` bytes on a thread of its own, as tasks are run.
fn run_within(limit: usize, text: String) -> String {
    let task = move || {
        let limits = Limits {
            memory_bytes: limit,
            ..Limits::default()
        };
        support::last_but_help(&Task::with(Vec::new(), limits).run(&text))
    };
    std::thread::spawn(task).join().unwrap_or_default()
}

/// What one of them may leave behind, and what the stacks of the test itself take, which are unoptimised.
const SLACK: usize = 6 * MEBIBYTE;

/// Fills the memory of a task with one kind of object after another, every fourth of them.
fn fill_with_each_kind(part: usize) {
    let limit = 12 * MEBIBYTE;
    run_within(limit, "x = 1".into());
    let base = of_process("VmRSS");
    let mut wrong = Vec::new();
    for (name, statement) in SHAPES.iter().skip(part).step_by(4) {
        forget_peak();
        let last = run_within(limit, program(statement));
        let (peak, after) = (of_process("VmHWM"), of_process("VmRSS"));
        let most = base + limit + limit / 4 + SLACK;
        if last != "499500" || peak > most || after > base + 2 * SLACK {
            let (peak, after) = (peak / MEBIBYTE, after / MEBIBYTE);
            wrong.push(format!(
                "{name}: {last}, at most {peak} MiB, then {after} MiB"
            ));
        }
    }
    let base = base / MEBIBYTE;
    assert!(wrong.is_empty(), "base {base} MiB\n{}", wrong.join("\n"));
}

/// Natives that make, or would make, much at once.
const AT_ONCE: &[&str] = &[
    "set(range(10 ** 10))",
    "frozenset(range(10 ** 10))",
    "dict.fromkeys(range(10 ** 10))",
    "dict(zip(range(10 ** 10), range(10 ** 10)))",
    "{1}.union(range(10 ** 10))",
    "set().update(map(str, range(10 ** 10)))",
    "{}.update((str(i), i) for i in range(10 ** 10))",
    "list(iter(int, 1))",
    "tuple(iter(str, 1))",
    "list(map(str, range(10 ** 10)))",
    "[*map(str, range(10 ** 10))]",
    "sorted(map(str, range(10 ** 10)))",
    "[str(i) for i in range(10 ** 10)]",
    "{str(i) for i in range(10 ** 10)}",
    "{str(i): i for i in range(10 ** 10)}",
    "list('é' * 3000000)",
    "('a,' * 6000000).split(',')",
    "('a ' * 6000000).split()",
    "('a,' * 6000000).rsplit(',')",
    "('a\\n' * 6000000).splitlines()",
    "(b'a,' * 6000000).split(b',')",
    "(b'a\\n' * 6000000).splitlines()",
    "list(zip('a' * 9000000))",
    "list(enumerate('a' * 9000000))",
    "import itertools; list(itertools.product(range(10 ** 4), repeat=2))",
    "import itertools; list(itertools.permutations(range(30), 6))",
    "import itertools; list(itertools.cycle(map(str, range(10 ** 10))))",
    "import itertools; a, b = itertools.tee(map(str, range(10 ** 10))); list(a)",
    "import json; json.loads('[' + '[],' * 5000000 + '1]')",
    "import json; json.dumps([['a'] * 1000] * 100000)",
    "import re; re.findall('a', 'a' * 20000000)",
    "import re; re.split(',', 'a,' * 6000000)",
    "import re; re.sub('a', 'b' * 1000, 'a' * 1000000)",
    "import struct; struct.unpack('9000000b', bytes(9000000))",
    "import struct; struct.pack('60000000s', b'')",
    "from collections import deque; deque(map(str, range(10 ** 10)))",
    "t = 'abc'\nwhile True: t = t.join('abc')",
    "t = b'abc'\nwhile True: t += t",
    "b = bytearray(b'abc')\nwhile True: b += bytes(b)",
    "b = bytearray()\nwhile True: b += b'some more bytes of the kind that are received'",
    "b = bytearray()\nwhile True: b.extend(b'0123456789' * 20000)",
    "t = 'abc'\nwhile True: t = t.replace('a', 'aaa')",
    "t = 'abc'\nwhile True: t = f'{t}{t}'",
    "x = [1]\nwhile True: x += x",
    "x = [1]\nwhile True: x = x + x + [x]",
    "d = {}\nwhile True: d = {**d, **{i: i for i in range(len(d), 2 * len(d) + 9)}}",
    "bytes(10 ** 12)",
    "bytearray(10 ** 12)",
    "bytes(iter(int, 1))",
    "'a' * 10 ** 10",
    "'-'.join(map(str, range(10 ** 10)))",
    "('a' * 10000000).replace('a', 'bcdefgh')",
    "('a' * 1000).center(10 ** 9)",
    "'%1000000000d' % 1",
    "f'{1:1000000000}'",
    "'{:>1000000000}'.format(1)",
    "('\\t' * 1000000).expandtabs(1000)",
    "('é' * 9000000).encode('utf-32')",
    "bytes(20000000).decode('latin-1') + bytes(30000000).decode('latin-1')",
    "('a' * 10000000).translate({97: 'bcdefgh'})",
    "bytes(30000000).hex()",
    "str(bytes(20000000))",
    "repr('\\x01' * 20000000)",
    "def f(*a, **k): return f(*a, *a, 'x' * 100)\nf(1, 2)",
    "def f(**k): pass\nf(**{str(i): i for i in range(10 ** 6)})",
    "exec('x = [' + '1,' * 3000000 + ']')",
    "eval('+'.join(['1'] * 3000000))",
    "compile('a = 1\\n' * 2000000, '', 'exec')",
    "int('9' * 4000) ** 100000",
    "x = 1\nwhile True: x = (x << 1000000) + 1; y = [x] * 1000; z = [a + 1 for a in y]",
    "def f(): return [f(), 'x' * 100000]\nf()",
    "print(*['x' * 100000] * 400)",
    "a = 'x' * 6000000\nprint a, a, a, a",
];

/// Runs them, every fourth.
fn make_much_at_once(part: usize) {
    let limit = 16 * MEBIBYTE;
    run_within(limit, "x = 1".into());
    let base = of_process("VmRSS");
    let mut wrong = Vec::new();
    for statement in AT_ONCE.iter().skip(part).step_by(4) {
        forget_peak();
        let text = format!(
            "import sys\ntry:\n    {}\n    print('made')\n\
             except (MemoryError, OverflowError, RecursionError, ValueError): print('refused')\n",
            statement.replace('\n', "\n    ")
        );
        let last = run_within(limit, text);
        let (peak, after) = (of_process("VmHWM"), of_process("VmRSS"));
        let most = base + limit + limit / 4 + SLACK;
        if !(last == "refused" || last == "made") || peak > most || after > base + 2 * SLACK {
            let (peak, after) = (peak / MEBIBYTE, after / MEBIBYTE);
            wrong.push(format!(
                "{statement}: {last}, at most {peak} MiB, then {after} MiB"
            ));
        }
    }
    let base = base / MEBIBYTE;
    assert!(wrong.is_empty(), "base {base} MiB\n{}", wrong.join("\n"));
}

macro_rules! parts {
    ($($test:ident $run:ident $part:literal;)*) => {
        $(#[test] fn $test() { $run($part); })*
    };
}

// Each in a process of its own, and at once where there are several processors.
parts! {
    every_kind_of_object_is_counted_as_the_system_counts_it_1 fill_with_each_kind 0;
    every_kind_of_object_is_counted_as_the_system_counts_it_2 fill_with_each_kind 1;
    every_kind_of_object_is_counted_as_the_system_counts_it_3 fill_with_each_kind 2;
    every_kind_of_object_is_counted_as_the_system_counts_it_4 fill_with_each_kind 3;
    natives_that_make_much_at_once_ask_before_1 make_much_at_once 0;
    natives_that_make_much_at_once_ask_before_2 make_much_at_once 1;
    natives_that_make_much_at_once_ask_before_3 make_much_at_once 2;
    natives_that_make_much_at_once_ask_before_4 make_much_at_once 3;
}

/// A generator that is being run has a native stack of 64 KiB, and what it calls far down takes more.
#[test]
fn native_stacks_of_generators_count() {
    static PEAK: AtomicIsize = AtomicIsize::new(0);
    fn note(_: &mut elite_lang::NativeCall<'_>) -> elite_lang::ScriptResult {
        PEAK.fetch_max(task_memory::live_bytes(), Ordering::Relaxed);
        Ok(Value::None)
    }
    let limit = 16 * MEBIBYTE;
    for first in [
        "next(f())",
        "sorted([2, 1], key=lambda _: next(f()))",
        "[x for x in f()]",
    ] {
        let native = NativeFunction {
            name: "note",
            params: Vec::new(),
            call: NativeBody::new(note),
        };
        let limits = Limits {
            memory_bytes: limit,
            ..Limits::default()
        };
        let task = Task::with(vec![native], limits);
        let base = task_memory::live_bytes();
        PEAK.store(0, Ordering::Relaxed);
        let output = task.run(&format!(
            "def f():\n    note()\n    try: yield {first}\n    finally: pass\nnext(f())"
        ));
        let last = support::last_but_help(&output);
        let peak = (PEAK.load(Ordering::Relaxed) - base) as usize;
        assert!(last.starts_with("MemoryError"), "{first}: {last}");
        assert!(
            (limit / 2..limit + limit / 8).contains(&peak),
            "{first}: {peak} bytes"
        );
    }
}

/// Whoever handles the refusal has room to say so, whatever has filled the memory, and however often it happens.
#[test]
fn a_refusal_can_be_handled() {
    let mut wrong = Vec::new();
    for (before, fill) in [
        ("b = bytearray()", "b += b'47 bytes'"),
        ("b = bytearray()", "b.append(1)"),
        ("t = ''", "t += 'abc' * 2000"),
        ("t = b''", "t = t + b'abc' * 2000"),
        ("x = []", "x.append(None)"),
        ("x = []", "x.append(str(len(x)))"),
        ("x = []", "x += [[], {}]"),
        ("x = None", "x = [x]"),
        ("x = None", "x = (x, 1.5)"),
        ("x = None", "x = {1: x}"),
        ("x = None", "x = lambda x=x: x"),
        ("class N: pass\nx = None", "n = N(); n.next = x; x = n"),
        ("d = {}", "d[len(d)] = None"),
        ("d = set()", "d.add(len(d))"),
        ("from collections import deque\nd = deque()", "d.append(1)"),
        ("i = 1", "i = i << 400000 | 1"),
        ("n = 0", "n += 1; exec(f'v{n} = {n}')"),
    ] {
        let text = format!(
            "{before}\nfor again in range(3):\n    try:\n        while True: {fill}\
             \n    except (MemoryError, OverflowError):\n        \
             kept = [i for i in range(200)]; print('handled', len(kept), f'{{1.5:>20}}', str(kept)[:20])\n\
             print('done')\n"
        );
        let last = run_within(4 * MEBIBYTE, text);
        if last != "done" {
            wrong.push(format!("{fill}: {last}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn names_and_classes_that_pass_leave_no_trace() {
    for text in [
        "class O: pass\no = O()\nfor i in range(60_000): getattr(o, f'name_{i}', None)",
        "class O: pass\no = O()\nfor i in range(60_000): hasattr(o, f'name_{i}')",
        "def f(**k): return len(k)\nfor i in range(40_000): f(**{f'name_{i}': i})",
        "def local():\n    class A:\n        def m(self): pass\n    return A\nfor i in range(20_000): local()",
        "def local():\n    class A:\n        def m(self): return super().m()\n    return A\n\
         for i in range(20_000): local()",
        "a = [3, 1, 2]\nfor i in range(10_000): a.sort(lambda x, y: x - y)",
        "for i in range(20_000): type('K', (), {})",
        "class O: pass\no = O(); o.__dict__\nfor i in range(60_000): setattr(o, f'name_{i}', i); \
         delattr(o, f'name_{i}')",
        "for i in range(60_000): '{0.real}'.format(i)",
        "for i in range(100_000):\n    try: getattr(i, f'name_{i}')\n    except AttributeError: pass",
        "for i in range(5_000): exec(f'v = {i}\\ndel v')",
        "def f():\n    for i in range(5_000): exec(f'v = [{i}]')\nf()",
        "for i in range(5_000): exec(f'def g(): return {i}', {})",
        "import functools\nclass O: pass\nfor i in range(20_000):\
         \n    o = O(); o.key = functools.cmp_to_key(o.__eq__); o.data = [i] * 20",
    ] {
        let last = run_within(5 * MEBIBYTE, format!("{text}\nprint('done')\n"));
        assert_eq!(last, "done", "{text}");
    }
}

/// Programs that make up names for ever hold only those they have in use.
#[test]
fn names_that_a_program_makes_up_are_given_up() {
    for made_up in [
        "exec(f'{n} = {i}\\ndel {n}')",
        "exec(f'{n} = {i}', {})",
        "exec(f'def f({n}): return {n}', {n: 1})",
        "exec(f'class {n}: {n}{i} = 1', {})",
        "eval(f'[{n} for {n} in (1, 2)]')",
        "eval(f'lambda {n}: {n}.{n}({n}={n})')",
        "eval(n, {n: 1}, {n + 'y': 1})",
        "missing(n)",
        "setattr(O, n, i); delattr(O, n)",
        "setattr(f, n, i); delattr(f, n)",
        "setattr(math, n, i); delattr(math, n)",
        "class K: pass\n    setattr(K(), n, i)",
        "class K: pass\n    K.__dict__; k = K(); k.__dict__[n] = i; getattr(k, n)",
        "type('K', (), {n: 1})",
        "type('K', (), {'__slots__': [n]})",
        "'{x}'.format_map({'x': 1, n: 2}); ('{' + n + '}').format_map({n: 2})",
        "f(**{n: i})",
        "operator.methodcaller('update', **{n: i})({}); operator.attrgetter(n)(K({n: i}))",
        "t = threading.Thread(target=f, kwargs={n: i}); t.start(); t.join()",
        "globals()[n] = i; del locals()[n]; vars(math)[n] = i; vars(math).pop(n)",
    ] {
        let text = format!(
            "import math, operator, threading\nclass O: pass\nclass K(dict): __getattr__ = dict.__getitem__\n\
             def f(**k): return len(k)\ndef missing(n):\n    try: eval(n)\n    except NameError: pass\n\
             for i in range(14_000):\n    n = f'v{{i}}' + 'x' * 500\n    {made_up}\n\
             print('done')\n"
        );
        let last = run_within(8 * MEBIBYTE, text);
        assert_eq!(last, "done", "{made_up}");
    }
}

/// Whatever is still called by a name goes on being called so, while others come and go.
#[test]
fn names_in_use_stay() {
    let text = "
import operator
class O: pass
class S: pass
def f(): pass
kept = []
for i in range(12_000):
    n = f'name_{i}'
    if i % 500 == 0:
        scope = {n: i}
        exec(f'def make({n}_p, *, {n}_k=2):\\n {n}_l = {n}_p + {n}_k\\n return lambda: {n} + {n}_l', scope)
        k = type('K', (), {n: i, '__slots__': [n + '_s']})
        o = k(); setattr(o, n + '_s', i)
        p = O(); setattr(p, n, i)
        setattr(f, n, i); setattr(S, n, i)
        exec(f'{n}_g = {i}')
        caller = operator.methodcaller('update', **{n: i})
        kept.append((i, n, scope, k, o, p, caller))
    else:
        exec(f'{n} = {i}\\ndel {n}')
        setattr(f, n, i); delattr(f, n)
        setattr(S, n, i); delattr(S, n)
for i, n, scope, k, o, p, caller in kept:
    called = {}
    caller(called)
    assert called == {n: i}, called
    made = scope['make'](**{n + '_p': 1, n + '_k': 3})
    found = [made() - 4, scope[n], getattr(k, n), getattr(o, n + '_s'), getattr(p, n), getattr(f, n), getattr(S, n),
             eval(n + '_g'), globals()[n + '_g'], p.__dict__[n]]
    assert found == [i] * len(found), (n, found)
    assert n in dir(k) and n + '_s' in k.__slots__ and list(vars(p)) == [n]
print('done')
";
    assert_eq!(run_within(32 * MEBIBYTE, text.into()), "done");
}

/// Large texts of every shape are read within what the task may hold, or not at all.
#[test]
fn a_text_that_is_compiled_counts_before_it_runs() {
    let limit = 24 * MEBIBYTE;
    run_within(limit, "x = 1".into());
    let base = of_process("VmRSS");
    for text in [
        "'f = (' + '0,' * 2000000 + ')'",
        "'x = 1\\n' * 600000",
        "'x = [' + '-a.b(c)[0],' * 200000 + ']'",
        "'def f(a=1): return a\\n' * 100000",
        "'x = f\"' + '{a}' * 300000 + '\"'",
        "';' .join(['x = 1'] * 600000)",
    ] {
        for how in ["exec", "eval", "compile"] {
            let rest = if how == "compile" {
                ", 'x', 'exec'"
            } else {
                ""
            };
            let program = format!(
                "text = {text}\ntry:\n    {how}(text{rest})\n    print('done')\n\
                 except MemoryError:\n    print('MemoryError')\nexcept SyntaxError:\n    print('SyntaxError')\n"
            );
            forget_peak();
            let last = run_within(limit, program);
            let peak = of_process("VmHWM");
            let most = base + limit + limit / 4 + 8 * MEBIBYTE;
            assert!(
                last != "done" && !last.is_empty() && peak < most,
                "{how} of {text}: {last}, {} of {} MiB",
                peak / MEBIBYTE,
                most / MEBIBYTE
            );
        }
    }
}
