//! Cycles are found and released; what is in use stays.
#![allow(clippy::unwrap_used)] // a test: a broken program should stop it

use std::rc::Rc;
use std::time::{Duration, Instant};

use crate::limits::memory;
use crate::{Host, Interpreter, KnownNames, Limits, Resume, SourceFile, Step, ThreadId, compile};

struct Silent;

impl Host for Silent {
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

/// Bytes still held after a task that ran `text` is gone.
fn left(text: &str) -> isize {
    let before = memory::held();
    let program = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let interpreter = Interpreter::new(Rc::new(Silent), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    loop {
        match thread.resume(Resume::Continue, 100_000) {
            Step::OutOfFuel => {}
            Step::Done(_) => break,
            other => panic!("{other:?}"),
        }
    }
    assert!(
        interpreter.memory_used() > 100_000,
        "the program holds nothing"
    );
    drop(thread);
    drop(interpreter);
    memory::held() - before
}

#[test]
fn cycles_of_instances_are_released_with_the_task() {
    let text = "class Node:\n    def __init__(self, parent=None):\n        self.parent, self.children, self.data = parent, [], [0] * 100\n\
        def grow():\n    root = Node()\n    for i in range(200):\n        root.children.append(Node(root))\n    root.me = root\n\
        for i in range(5): grow()\n";
    assert_eq!(left(text), 0);
}

#[test]
fn cycles_of_closures_are_released_with_the_task() {
    let text = "def make(n):\n    data = [0] * 1000\n    def walk(k):\n        return 0 if k == 0 else walk(k - 1) + len(data)\n    return walk(n)\n\
        for i in range(50): make(3)\n\
        class A:\n    def __init__(self):\n        self.data = [0] * 1000\n        self.go = self.step\n        self.later = lambda: self.data\n    def step(self): pass\n\
        for i in range(50): A()\n";
    assert_eq!(left(text), 0);
}

/// Most bytes a task holds while it runs `text`.
fn peak(text: &str) -> usize {
    let program = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let interpreter = Interpreter::new(Rc::new(Silent), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    let mut most = 0;
    loop {
        match thread.resume(Resume::Continue, 20_000) {
            Step::OutOfFuel => most = most.max(interpreter.memory_used()),
            Step::Done(_) => return most,
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_loop_that_drops_cycles_does_not_grow() {
    let classes = "from collections import deque\nfrom itertools import chain, repeat, tee, groupby\nfrom functools import partial\n\
        class A:\n    def step_with(self, data):\n        def go(): return self, data\n        return go\n\
        def numbers(a, data):\n    yield a\n\
        def failing():\n    try:\n        raise ValueError('x' * 13600)\n    except ValueError as e:\n        box = A(); box.error = e; e.box = box\n";
    for make in [
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
    ] {
        let text = format!(
            "{classes}def closure():\n    data = 'x' * 13600\n    def walk(): return walk, data\n\
             for i in range(6_000):\n    {make}\n"
        );
        let most = peak(&text);
        // All of them would be 80 MB.
        assert!(most < 62 << 20, "{make}: {most} bytes");
    }
}

#[test]
fn what_is_in_use_survives_the_search() {
    let text = "class Node:\n    def __init__(self, up): self.up, self.down, self.tag = up, [], {'n': [1]}\n\
        def generator(node):\n    own = Node(node); own.down.append(own)\n    for i in range(3):\n        yield own.tag['n'][0] + i\n\
        root = Node(None)\nfor i in range(50): root.down.append(Node(root))\n\
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
        lock = threading.Condition()\nc = collections.deque([q, lock] * 5000)\nr = random.Random(1)\nt = threading.Timer(1, print)\n";
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
    let interpreter = Interpreter::new(Rc::new(Silent), Vec::new(), limits);
    let mut thread = interpreter.spawn_program(&program);
    // On to the last searches, which see most objects.
    let (mut slices, mut slowest) = (0, Duration::ZERO);
    while slices < 15 || interpreter.memory_used() < 14_000_000 {
        let begin = Instant::now();
        let step = thread.resume(Resume::Continue, 2_000);
        if slices > 0 {
            slowest = slowest.max(begin.elapsed());
        }
        assert!(matches!(step, Step::OutOfFuel), "{step:?}");
        slices = if interpreter.core().is_searching() {
            slices + 1
        } else {
            0
        };
    }
    let begin = Instant::now();
    let end = thread.resume(Resume::Stop, 0);
    let stop = begin.elapsed();
    assert!(matches!(end, Step::Stopped), "{end:?}");
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
    assert!(!interpreter.core().is_searching());
}

#[test]
fn what_a_search_that_was_given_up_has_seen_is_released() {
    let text = big(60_000);
    let before = memory::held();
    let program = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let interpreter = Interpreter::new(Rc::new(Silent), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    while !interpreter.core().is_searching() {
        assert!(matches!(
            thread.resume(Resume::Continue, 100_000),
            Step::OutOfFuel
        ));
    }
    assert!(matches!(thread.resume(Resume::Stop, 0), Step::Stopped));
    drop(thread);
    // Another thread goes on with the same objects.
    let text = "total = sum(1 for a in kept if a.me is a)\nfor i in range(30_000):\n    x = []; x.append(x)\n";
    let second = compile(SourceFile::new("test", text), &KnownNames::default()).unwrap();
    let mut thread = interpreter.spawn_program(&second);
    while let Step::OutOfFuel = thread.resume(Resume::Continue, 100_000) {}
    assert!(interpreter.global("total").and_then(|total| total.as_i64()) > Some(1000));
    drop((thread, interpreter, program, second));
    assert_eq!(memory::held() - before, 0);
}
