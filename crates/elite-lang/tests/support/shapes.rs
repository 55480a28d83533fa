//! Ways to fill a task's memory, one for each kind of object a program can make, and what the system says of it.

/// A name, and a statement that makes one more object; `x` is the list that keeps them, `i` counts.
pub const SHAPES: &[(&str, &str)] = &[
    ("integers beyond 64 bits", "x.append((1 << 70) + i)"),
    ("big integers", "x.append((1 << 400000) + i)"),
    ("strings of 30 bytes", "x.append('%030d' % i)"),
    ("small tuples", "x.append((i, i))"),
    ("nested tuples", "x.append(((i,), (i,)))"),
    ("small lists", "x.append([i])"),
    ("empty lists", "x.append([])"),
    ("lists of circles", "a = []; a.append(a); x.append(a)"),
    ("dictionaries", "x.append({i: i})"),
    ("one dictionary", "d[i] = str(i)"),
    ("sets", "x.append({i})"),
    ("one set", "s.add(str(i))"),
    ("frozen sets", "x.append(frozenset((i, str(i))))"),
    ("instances", "x.append(A(i))"),
    (
        "instances with many attributes",
        "a = A(i); a.b = a.c = a.d = a.e = a.f = i; x.append(a)",
    ),
    ("attributes", "setattr(o, 'a%d' % i, i)"),
    ("closures", "x.append(closure(i))"),
    ("functions", "x.append(lambda: i)"),
    ("functions with defaults", "x.append(lambda a=[i]: a)"),
    ("bound methods", "x.append(A(i).go)"),
    ("classes", "x.append(type('K', (), {'i': i}))"),
    ("generators", "g = count(i); next(g); x.append(g)"),
    (
        "generators with a stack",
        "g = careful(i); next(g); x.append(g)",
    ),
    ("iterators", "x.append(iter([i]))"),
    ("exceptions", "x.append(ValueError(i))"),
    ("raised exceptions", "x.append(raised(i))"),
    ("byte arrays", "x.append(bytearray(1000))"),
    ("bytes", "x.append(b'%d' % i)"),
    ("complex numbers", "x.append(complex(i, i))"),
    ("ranges", "x.append(range(i, i + 9))"),
    ("slices", "x.append(slice(i, i))"),
    ("views", "x.append({}.keys())"),
    ("properties", "x.append(property(len))"),
    ("names", "x.append(eval('lambda: v%d' % i))"),
    ("big strings", "x.append('a' * 3000000 + str(i))"),
    (
        "a string that grows",
        "t += 'some more text of the kind that is logged '",
    ),
    (
        "bytes that grow",
        "b += b'some more bytes of the kind that are received'",
    ),
    ("a deque", "q.append(str(i))"),
    (
        "matches",
        "x.append(re.match('a(b*)', 'abbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb'))",
    ),
    (
        "parsed texts",
        "x.append(json.loads('{\"a\": [1, 2, {\"b\": null}]}'))",
    ),
    ("partials", "x.append(partial(print, i))"),
    ("a tee", "n = next(t1)"),
];

/// A program that fills its memory with one kind of object, then lets go of it and goes on.
pub fn program(statement: &str) -> String {
    format!(
        "import re, json\nfrom collections import deque\nfrom functools import partial\n\
         from itertools import tee, repeat\nclass A:\n    def __init__(self, i): self.i = i\n    def go(self): pass\n\
         def closure(i):\n    def inner(): return i\n    return inner\n\
         def count(i):\n    while True: yield i\n\
         def careful(i):\n    try:\n        yield i\n    finally:\n        i = 0\n\
         def raised(i):\n    try:\n        raise KeyError(i)\n    except KeyError as error: return error\n\
         def fill():\n    x, d, s, o, q, t, b, i = [], {{}}, set(), A(0), deque(), '', bytearray(), 0\
         \n    t1, t2 = tee(str(k) for k in repeat(10 ** 9))\n    \
         while True:\n        {statement}\n        i += 1\n\
         try: fill()\nexcept MemoryError: print('MemoryError')\n\
         print(sum([k for k in range(1000)]))\n"
    )
}

/// A figure of `/proc/self/status` in bytes: `VmRSS`, `VmHWM`.
pub fn of_process(figure: &str) -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with(figure));
    let kilobytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<usize>().ok());
    kilobytes.unwrap_or(0) << 10
}

/// `VmHWM` counts from now on.
pub fn forget_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
