//! Cycles are found and released; what is in use stays.
#![allow(clippy::unwrap_used)] // a test: a broken program should stop it

use std::rc::Rc;
use std::time::{Duration, Instant};

use elite_syntax::{KnownNames, SourceFile, compile};

use crate::{Host, Interpreter, Limits, Resume, ResumeOutcome, ThreadId};

struct DiscardingHost;

impl Host for DiscardingHost {
    fn print(&self, _: ThreadId, _: &str) {}
    fn unix_time(&self) -> f64 {
        0.0
    }
    fn monotonic(&self) -> f64 {
        0.0
    }
    fn random_u64(&self) -> u64 {
        0
    }
    fn wake(&self, _: ThreadId) {}
}

/// Bytes still held after a task that ran `text` is gone. The first task of a thread makes tables that stay.
fn left(text: &str) -> isize {
    left_by(text);
    left_by(text)
}

fn left_by(text: &str) -> isize {
    let before = task_memory::live_bytes();
    let program = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let interpreter = Interpreter::new(Rc::new(DiscardingHost), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    loop {
        match thread.resume(Resume::Continue, 100_000) {
            ResumeOutcome::OutOfFuel => {}
            ResumeOutcome::Done(_) => break,
            other => panic!("{other:?}"),
        }
    }
    drop((thread, interpreter, program));
    task_memory::live_bytes() - before
}

#[test]
fn cycles_of_instances_are_released_with_the_task() {
    let text = "class Node:\n    def __init__(self, parent=None):\
                \n        self.parent, self.children, self.data = parent, [], [0] * 100\n\
        def grow():\n    root = Node()\n    for i in range(200):\n        root.children.append(Node(root))\
        \n    root.me = root\nfor i in range(5): grow()\n";
    assert_eq!(left(text), 0);
}

#[test]
fn cycles_of_closures_are_released_with_the_task() {
    let text = "def make(n):\n    data = [0] * 1000\n    def walk(k):\
                \n        return 0 if k == 0 else walk(k - 1) + len(data)\n    return walk(n)\n\
        for i in range(50): make(3)\n\
        class A:\n    def __init__(self):\n        self.data = [0] * 1000\n        self.go = self.step\
        \n        self.later = lambda: self.data\n    def step(self): pass\n\
        for i in range(50): A()\n";
    assert_eq!(left(text), 0);
}

/// Most bytes a task holds while it runs `text`.
fn peak(text: &str) -> usize {
    let program = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let interpreter = Interpreter::new(Rc::new(DiscardingHost), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    let mut most = 0;
    loop {
        match thread.resume(Resume::Continue, 20_000) {
            ResumeOutcome::OutOfFuel => most = most.max(interpreter.memory_used()),
            ResumeOutcome::Done(_) => return most,
            other => panic!("{other:?}"),
        }
    }
}

/// Objects in circles, in many ways, of 13 kB each.
const CIRCLES: &[&str] = &[
    "a = A(); a.me = a; a.data = 'x' * 13600",
    "a = A(); b = A(); a.other = b; b.other = a; b.data = 'x' * 13600",
    "x = []; x.append(x); x.append('x' * 13600)",
    "x = {}; x['me'] = [x, 'x' * 13600]",
    "p = {'kids': []}; k = {'up': p, 'data': 'x' * 13600}; p['kids'].append(k)",
    "x = [1, 2]; x[0] = (x, 'x' * 13600)",
    "a = A(); a.links = {a}; a.data = 'x' * 13600",
    "a = A(); a.step = a.__init__; a.data = 'x' * 13600",
    "a = A(); a.__dict__['me'] = a; a.data = 'x' * 13600",
    "closure()",
    "d = deque(); d.append(d); d.append('x' * 13600)",
    "d = deque([1]); a = A(); a.queue = d; d[0] = a; a.data = 'x' * 13600",
    "e = ValueError('x' * 13600); e.me = e",
    "e = ValueError(); f = KeyError('x' * 13600); e.__cause__ = f; f.args = (e, 'x' * 13600)",
    "failing()",
    "def f(): pass\n    f.me = f; f.data = 'x' * 13600",
    "def f(): pass\n    f.data = ['x' * 13600, f]",
    "a = A(); a.rows = numbers(a, 'x' * 13600)",
    "a = A(); a.it = iter([a, 'x' * 13600])",
    "a = A(); a.it = map(str, [a, 'x' * 13600])",
    "a = A(); a.it = zip([a], ['x' * 13600])",
    "a = A(); a.it = enumerate([a, 'x' * 13600])",
    "a = A(); a.it = chain([a, 'x' * 13600], [])",
    "a = A(); a.it = repeat((a, 'x' * 13600))",
    "a = A(); a.it, a.other = tee([a, 'x' * 13600]); next(a.it); next(a.it)",
    "a = A(); a.it = groupby([a, 'x' * 13600], id); a.group = next(a.it)",
    "d = {}; d['keys'] = d.items(); d['data'] = 'x' * 13600",
    "a = A(); a.part = partial(print, a, 'x' * 13600)",
    "a = A(); a.go = a.step_with('x' * 13600)",
    "exec('def f(): return f, data', {'data': 'x' * 13600})",
    "exec('def f():\\n def g(): return f, g, data\\n return g', {'data': 'x' * 13600})",
    "exec('class B:\\n def m(self): return B, data\\nb = B(); b.me = b', {'data': 'x' * 13600})",
    "exec('f = lambda: f\\nfor x in [lambda: (f, x)]: pass', {}, {'data': 'x' * 13600})",
    "exec('def f(): yield f\\ng = f(); next(g)', {'data': 'x' * 13600})",
    "local_text('x' * 13600)",
    "exec('def make():\\n def f(): return fs, data\\n return f\\nfs = [make(), make()]', {'data': 'x' * 13600})",
    "exec('fs = [lambda: (fs, data) for i in range(3)]', {'data': 'x' * 13600})",
    "exec('class B:\\n def m(self): return B, data\\nbs = [B.m, B().m, B.m]', {'data': 'x' * 13600})",
    "exec('def f(): return eval(\"data\")', {'data': 'x' * 13600})",
    "d = {'data': 'x' * 13600}; exec('def f(): return [g for g in (f,)]\\ndef g(): return f', d)",
];

/// Checks every fourth way, from this one on.
fn a_loop_that_drops_cycles_does_not_grow(number: usize) {
    let classes = "from collections import deque\nfrom itertools import chain, repeat, tee, groupby\n\
                   from functools import partial\n\
        class A:\n    def step_with(self, data):\n        def go(): return self, data\n        return go\n\
        def numbers(a, data):\n    yield a\n\
        def failing():\n    try:\n        raise ValueError('x' * 13600)\n    except ValueError as e:\
        \n        box = A(); box.error = e; e.box = box\n";
    for make in CIRCLES.iter().skip(number - 1).step_by(4) {
        let text = format!(
            "{classes}def local_text(data): exec('def f(): return f, data')\n\
             def closure():\n    data = 'x' * 13600\n    def walk(): return walk, data\n\
             for i in range(6_000):\n    {make}\n"
        );
        let most = peak(&text);
        // All objects together would be 80 MB.
        assert!(most < 62 << 20, "{make}: {most} bytes");
    }
}

#[test]
fn a_loop_that_drops_cycles_does_not_grow_first_quarter() {
    a_loop_that_drops_cycles_does_not_grow(1);
}

#[test]
fn a_loop_that_drops_cycles_does_not_grow_second_quarter() {
    a_loop_that_drops_cycles_does_not_grow(2);
}

#[test]
fn a_loop_that_drops_cycles_does_not_grow_third_quarter() {
    a_loop_that_drops_cycles_does_not_grow(3);
}

#[test]
fn a_loop_that_drops_cycles_does_not_grow_last_quarter() {
    a_loop_that_drops_cycles_does_not_grow(4);
}

/// Ways to put something into a container, by container: `c` is the container, `it` what goes in. Every way in which a
/// program can change what an object refers to belongs here.
const WAYS: &[(&str, &[&str])] = &[
    (
        "[0, 1]",
        &[
            "c.append(it)",
            "c.insert(0, it)",
            "c.extend([it])",
            "c.extend(x for x in (it,))",
            "c += [it]",
            "c += (it,)",
            "c[0] = it",
            "c[-1] = it",
            "c[1:] = [it]",
            "c[::2] = [it]",
            "c.__setitem__(0, it)",
            "c.__iadd__([it])",
            "c.__init__([it])",
            "list.append(c, it)",
            "c.append((it,))",
            "c.append({'it': it})",
            "c.append(iter([it]))",
            "c.append(slice(it, None))",
            "c.append(lambda: it)",
            "c.append(property(it))",
            "c.append(staticmethod(it))",
            "c.append(c.append)",
            "c[0], c[1] = it, 1",
            "for c[0] in [it]: pass",
        ],
    ),
    (
        "{'a': 0}",
        &[
            "c['b'] = it",
            "c['a'] = it",
            "c.update(b=it)",
            "c.update({'b': it})",
            "c.update([('b', it)])",
            "c |= {'b': it}",
            "c |= [('b', it)]",
            "c.setdefault('b', it)",
            "c.__setitem__('b', it)",
            "c.__init__(b=it)",
            "c[lambda: it] = 0",
            "c['b'] = c.items()",
            "c['b'] = c.setdefault",
        ],
    ),
    (
        "set()",
        &[
            "c.add(lambda: it)",
            "c.update([lambda: it])",
            "c |= {lambda: it}",
            "c ^= {lambda: it}",
            "c.symmetric_difference_update([lambda: it])",
            "c.__init__([lambda: it])",
            "c.add(iter([it]))",
            "c.add(c.add)",
        ],
    ),
    (
        "deque([0, 1], 5)",
        &[
            "c.append(it)",
            "c.appendleft(it)",
            "c.extend([it])",
            "c.extendleft([it])",
            "c.insert(0, it)",
            "c += [it]",
            "c[0] = it",
            "c.__init__([it])",
        ],
    ),
    (
        "A()",
        &[
            "c.me = it",
            "setattr(c, 'me', it)",
            "c.__dict__['me'] = it",
            "c.__dict__ = {'me': it}",
            "vars(c).update(me=it)",
            "object.__setattr__(c, 'me', it)",
            "c.go = c.step",
            "c.rows = numbers(c, 1)",
            "c.rows = numbers(c, 1); next(c.rows)",
            "c.rows = careful(c, 1); next(c.rows)",
            "c.rows = (x for x in [c]); next(c.rows)",
            "c.kind = partial(print, it)",
        ],
    ),
    (
        "L()",
        &["c.append(it)", "c += [it]", "c.me = it", "c[:] = [it]"],
    ),
    (
        "D()",
        &[
            "c['b'] = it",
            "c.update(b=it)",
            "c |= {'b': it}",
            "c.me = it",
        ],
    ),
    ("E()", &["c.add(lambda: it)", "c.me = it"]),
    ("S()", &["c.me = it"]),
    (
        "ValueError('x')",
        &[
            "c.me = it",
            "c.args = (it,)",
            "c.__init__(it)",
            "c.__setstate__({'me': it}) if hasattr(c, '__setstate__') else setattr(c, 'me', it)",
            "fails(c, it)",
            "fails_within(c, KeyError(it))",
        ],
    ),
    (
        "make()",
        &[
            "c.me = it",
            "c.__dict__['me'] = it",
            "c.__defaults__ = (it,)",
            "c([it])",
        ],
    ),
    (
        "Class()",
        &[
            "c.me = it",
            "setattr(c, 'me', it)",
            "c.me = lambda: it",
            "c.me = c()",
            "c.me = type('B', (c,), {})",
        ],
    ),
];

#[test]
fn cycles_are_found_whatever_they_are_made_of() {
    let classes = "from functools import partial\nfrom collections import deque\n\
        class A:\n    def step(self): pass\nclass L(list): pass\nclass D(dict): pass\nclass E(set): pass\n\
        class S:\n    __slots__ = ('me', 'pad')\ndef numbers(node, pad):\n    for i in range(5): yield node\n\
        def careful(node, pad):\n    try:\n        yield node\n    finally:\n        pad = 0\n\
        def make():\n    kept = []\n    def f(more=()):\n        kept.extend(more)\n    return f\n\
        def Class():\n    class K:\n        def __init__(self): super().__init__()\n    return K\n\
        def fails(one, other):\n    try:\n        raise one from KeyError(other)\n    except ValueError: pass\n\
        def fails_within(one, other):\n    try:\n        try:\n            raise other\n        except KeyError:\
        \n            raise one\n    except ValueError: pass\n";
    let mut missed = Vec::new();
    for (container, ways) in WAYS {
        for way in *ways {
            // 500 of 40 kB would be 20 MB; the stacks kept for reuse are 4 MiB.
            let text = format!(
                "{classes}def circle():\n    c = {container}\n    it = (c, bytearray(40_000))\n    {way}\n\
                 for i in range(500):\n    circle()\n"
            );
            let most = peak_within(&text, 12 << 20);
            match most {
                Ok(_) => {}
                other => missed.push(format!("{container}: {way}: {other:?}")),
            }
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Most bytes a task holds that may hold no more than `limit`; how it failed otherwise.
fn peak_within(text: &str, limit: usize) -> Result<usize, String> {
    let program = compile(SourceFile::new("test", text), &KnownNames::default())
        .map_err(|findings| format!("{findings:?}"))?;
    let limits = Limits {
        memory_bytes: limit,
        ..Limits::default()
    };
    let interpreter = Interpreter::new(Rc::new(DiscardingHost), Vec::new(), limits);
    let mut thread = interpreter.spawn_program(&program);
    let mut most = 0;
    loop {
        match thread.resume(Resume::Continue, 20_000) {
            ResumeOutcome::OutOfFuel => most = most.max(interpreter.memory_used()),
            ResumeOutcome::Done(_) => return Ok(most),
            ResumeOutcome::Failed(error) => {
                return Err(format!("{}: {}", error.exception, error.message));
            }
            other => return Err(format!("{other:?}")),
        }
    }
}

/// How often a search goes on while a program that keeps `kept` objects makes `made` cycles.
fn slices_of_searches(kept: usize, made: usize) -> usize {
    let text = format!(
        "class Node: pass\nroot = Node()\nroot.kids = []\n\
         for i in range({kept}):\n    kid = Node()\n    kid.up = root\n    root.kids.append(kid)\n\
         for i in range({made}):\n    x = []\n    x.append(x)\n"
    );
    let program = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let interpreter = Interpreter::new(Rc::new(DiscardingHost), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    let mut slices = 0;
    while let ResumeOutcome::OutOfFuel = thread.resume(Resume::Continue, 20_000) {
        slices += usize::from(interpreter.is_gc_running());
    }
    slices
}

#[test]
fn what_is_kept_is_not_looked_at_again_and_again() {
    let made = |kept: usize| slices_of_searches(kept, 60_000) - slices_of_searches(kept, 20_000);
    let (few, many) = (made(1_000), made(100_000));
    assert!(
        many <= few + few / 2 + 20,
        "{few} slices beside few objects, {many} beside many"
    );
    let (half, whole) = (
        slices_of_searches(50_000, 1),
        slices_of_searches(100_000, 1),
    );
    assert!(
        whole < half * 3,
        "{half} slices for half as many objects, {whole} for all"
    );
}

#[test]
fn cycles_of_any_kind_end_with_the_task() {
    for text in [
        "class A:\n    def go(self): return super().go\nx = [A] * 100_000\nA.me = A()\nA.me.a = A\n",
        "def g():\n    me = yield\n    try:\n        yield me\n    finally: me = 0\n\
         x = g(); next(x); x.send((x, [0] * 100_000))\n",
        "def g():\n    for i in range(5):\n        me = yield i\n\
         x = g(); next(x); x.send((x, [0] * 100_000))\n",
        "import itertools\nx = [0] * 100_000\ny = itertools.chain(x, [x])\nx.append(y)\nx.append(map(print, [y]))\n",
        "s = set()\nf = lambda: (s, [0] * 100_000)\ns.add(f)\nk = [0] * 100_000\ns.add(s.add)\n",
        "from functools import partial, lru_cache\nx = [0] * 100_000\nx.append(partial(print, x))\n\
         @lru_cache\ndef f(a): return f, x\nf(1)\n",
        "def outer():\n    d = {}\n    exec('def f(): return f', d)\n    d['me'] = d\n    return d\n\
         x = [outer() for i in range(1000)]\n",
        "import re, json, datetime, threading\nx = [re.compile('a+').finditer('a' * 100)] + [0] * 100_000\n\
         x.append(x)\n",
    ] {
        assert_eq!(left(text), 0, "{text}");
    }
}

#[test]
fn what_is_in_use_survives_the_search() {
    let text = "class Node:\n    def __init__(self, up): self.up, self.down, self.tag = up, [], {'n': [1]}\n\
        def generator(node):\n    own = Node(node); own.down.append(own)\n    for i in range(3):\
        \n        yield own.tag['n'][0] + i\nroot = Node(None)\nfor i in range(50): root.down.append(Node(root))\n\
        def keep():\n    box = []; box.append(box)\n    def get(): return box, get\n    return get\nget = keep()\n\
        running = generator(root); total = next(running)\n\
        for i in range(25_000):\n    n = Node(None); n.up = n\n\
        assert all(kid.up is root and kid.tag['n'] == [1] for kid in root.down) and len(root.down) == 50\n\
        assert get()[0][0] is get()[0] and get()[1] is get\n\
        assert [total] + list(running) == [1, 2, 3]\n";
    peak(text);
}

#[test]
fn modules_and_what_they_hold_are_released_with_the_task() {
    let text = "import threading, queue, collections, json, re, datetime, random, functools\n\
        q = queue.Queue()\nfor i in range(1000): q.put([i] * 20)\n\
        lock = threading.Condition()\nc = collections.deque([q, lock] * 5000)\nr = random.Random(1)\n\
        t = threading.Timer(1, print)\n";
    assert_eq!(left(text), 0);
}

/// A program that makes so many cyclic objects and keeps half of them, then goes on for ever.
fn big(objects: usize) -> String {
    format!(
        "class Node:\n    pass\nkept = []\n\
         def grow(n):\n    for i in range(n):\n        a = Node(); a.me = a\n        if i % 2: kept.append(a)\n\
         try:\n    grow({objects})\n    while True:\n        grow(1000)\nfinally:\n    ended = True\n"
    )
}

#[test]
fn a_stop_does_not_wait_for_a_search() {
    let program = compile(
        SourceFile::new("test", big(120_000)),
        &KnownNames::default(),
    )
    .unwrap();
    let limits = Limits {
        memory_bytes: 2 << 30,
        ..Limits::default()
    };
    let interpreter = Interpreter::new(Rc::new(DiscardingHost), Vec::new(), limits);
    let mut thread = interpreter.spawn_program(&program);
    // On to the last searches, which see most objects.
    let (mut slices, mut slowest) = (0, Duration::ZERO);
    while slices < 15 || interpreter.memory_used() < 14_000_000 {
        let begin = Instant::now();
        let step = thread.resume(Resume::Continue, 2_000);
        if slices > 0 {
            slowest = slowest.max(begin.elapsed());
        }
        assert!(matches!(step, ResumeOutcome::OutOfFuel), "{step:?}");
        slices = if interpreter.is_gc_running() {
            slices + 1
        } else {
            0
        };
    }
    let begin = Instant::now();
    let end = thread.resume(Resume::Stop, 0);
    let stop = begin.elapsed();
    assert!(matches!(end, ResumeOutcome::Stopped), "{end:?}");
    let ended = interpreter
        .global("ended")
        .and_then(|ended| ended.as_bool());
    assert_eq!(ended, Some(true));
    println!("slowest slice {slowest:?}, stop {stop:?}");
    // Without optimisation and beside other tests; a search at one go takes seconds.
    assert!(
        slowest.max(stop) < Duration::from_millis(200),
        "{slowest:?} {stop:?}"
    );
    assert!(!interpreter.is_gc_running());
}

#[test]
fn what_a_search_that_was_given_up_has_seen_is_released() {
    left_by("x = [0] * 100_000");
    let before = task_memory::live_bytes();
    let text = big(60_000);
    let program = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let interpreter = Interpreter::new(Rc::new(DiscardingHost), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    while !interpreter.is_gc_running() {
        assert!(matches!(
            thread.resume(Resume::Continue, 100_000),
            ResumeOutcome::OutOfFuel
        ));
    }
    assert!(matches!(
        thread.resume(Resume::Stop, 0),
        ResumeOutcome::Stopped
    ));
    drop(thread);
    // Another thread goes on with the same objects.
    let text = "total = sum(1 for a in kept if a.me is a)\nfor i in range(30_000):\n    x = []; x.append(x)\n";
    let second = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let mut thread = interpreter.spawn_program(&second);
    while let ResumeOutcome::OutOfFuel = thread.resume(Resume::Continue, 100_000) {}
    assert!(interpreter.global("total").and_then(|total| total.as_i64()) > Some(1000));
    drop((thread, interpreter, program, second));
    assert_eq!(task_memory::live_bytes() - before, 0);
}

#[test]
fn functions_of_evaluated_texts_keep_what_they_use() {
    let text = "
class A: pass
def make(i):
    scope = {'data': [i], 'twice': []}
    exec('def f(): return data[0] + g()\\ndef g(): return h()()\\ndef h():\\n def k(): return data[0]\\n \
    twice.append(k)\\n return k', scope)
    exec('def later(): return f() - data[0]\\nf.later = later', scope)
    def local(data):
        exec('def f(): return data[0]\\nkept.append(f)')
        exec('kept.append(lambda: data[0] + data[0])', {'data': data, 'kept': kept})
    local([i])
    return scope['f']
kept = []
made = [make(i) for i in range(200)]
def garbage():
    for i in range(30_000):
        a = A(); a.me = a
for turn in range(3):
    garbage()
    assert [f() for f in made] == [2 * i for i in range(200)]
    assert [f.later() for f in made] == list(range(200))
    assert [f() for f in kept] == [i * times for i in range(200) for times in (1, 2)]
";
    peak(text);
}
