//! No native keeps the other script threads waiting: between two safepoints there are a few milliseconds of work at most,
//! however much data it is given.
//!
//! Every method of every builtin type is called with whatever arguments from a small set it takes, on large data. The longest
//! time of the processor between two turns counts, so that other work on the machine does not disturb it. New methods are
//! found by `dir`.

mod support;

use std::collections::BTreeMap;
use std::time::Duration;

use elite_lang::{Limits, Resume, Step, render_script_error};
use nix::time::{ClockId, clock_gettime};
use support::Task;

/// The longest work between two safepoints: what INTERFACES promises, and some more without optimisation, where all of it is
/// slower by more than an order of magnitude.
const STRETCH_MAX: Duration = Duration::from_millis(if cfg!(debug_assertions) { 8 } else { 5 });
/// How often something must take too long before it counts.
const TRIES: usize = 4;
/// Parts of the data: characters, bytes, items. So many that a native without safepoints takes several times as long.
const PARTS: usize = if cfg!(debug_assertions) {
    300_000
} else {
    20_000_000
};
/// The same for values of their own.
const VALUES: usize = PARTS / 16;

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

/// Changes of a container in place, which others must never see half done: some nanoseconds an item, all at once.
const AT_ONCE: &[&str] = &["__setitem__", "__delitem__"];

fn processor_time() -> Duration {
    match clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID) {
        Ok(time) => time.into(),
        Err(error) => panic!("no clock of the thread: {error}"),
    }
}

/// Runs a program that prints a label before everything it does; the longest work between two safepoints for each label.
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
            Step::OutOfFuel => {}
            Step::Failed(error) => panic!("{}", render_script_error(&error)),
            _ => return longest,
        }
    }
}

/// What all programs begin with.
const BEGIN: &str = "
import collections, json, re, struct, math, random, itertools, functools, operator, copy, heapq, bisect, statistics
import string, io, datetime
modules = [collections, json, re, struct, math, random, itertools, functools, operator, copy, heapq, bisect, statistics,
           string, io]
def give_way():
    for _ in range(3): pass
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
        attempt(f'{{name}} {{index}}', call, lambda: (make(receiver), *args(6 if few else n)), lambda: (make(6), *args(6)))
"
    )
}

/// What keeps the others waiting whenever it is tried. A machine counts page faults, and what its own host takes from it, as
/// time of the processor: one long stretch proves nothing, the same one again and again does.
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
        if AT_ONCE.contains(&method) && arguments.starts_with("(slice") {
            continue;
        }
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
    methods_of_deques_give_way 15;
    methods_of_integers_give_way 16;
}
