//! Values that hold the same value twice, that one another twice, and so on: what walks through them takes a step for
//! each way through, and there are more ways than anybody can wait for. Whoever walks gives way meanwhile, and asks for
//! the memory.

use std::time::Instant;

use super::{begin, task_with};
use crate::{Limits, Resume, ResumeOutcome};

/// How the next value is made of `v`, the innermost one, and what walks through the outermost.
const WALKS: &[(&str, &str, &[&str])] = &[
    (
        "[v, v]",
        "[]",
        &[
            "repr(v)",
            "str(v)",
            "f'{v}'",
            "'%s' % (v,)",
            "ascii(v)",
            "v == w",
            "v < w",
            "v != w",
            "w in [v]",
            "[v].index(w)",
            "min([v, w])",
            "sorted([v, w])",
            "json.dumps(v)",
            "pprint.pformat(v)",
            "print(v)",
            "'{}'.format(v)",
            "ValueError(v).__repr__()",
            "str(ValueError(v))",
            "textwrap.shorten(str(v), 10)",
        ],
    ),
    (
        "(v, v)",
        "()",
        &[
            "repr(v)",
            "hash(v)",
            "{v}",
            "{v: 1}",
            "v == w",
            "v < w",
            "v in (w,)",
            "json.dumps(v)",
            "isinstance(1, v)",
            "issubclass(int, v)",
        ],
    ),
    (
        "{1: v, 2: v}",
        "{}",
        &[
            "repr(v)",
            "v == w",
            "json.dumps(v)",
            "v.values()",
            "repr(v.items())",
        ],
    ),
    ("{1: v, 2: v}.values()", "[]", &["repr(v)"]),
    (
        "frozenset([(1, v), (2, v)])",
        "frozenset()",
        &["repr(v)", "hash(v)", "v == w"],
    ),
    ("slice(v, v)", "slice(1)", &["repr(v)", "v == w"]),
    (
        "K(v)",
        "K(1)",
        &["repr(v)", "hash(v)", "v == w", "copy.copy(v)"],
    ),
    ("collections.deque([v, v])", "1", &["repr(v)", "v == w"]),
    (
        "collections.OrderedDict(a=v, b=v)",
        "1",
        &["repr(v)", "v == w"],
    ),
    ("functools.partial(v, v)", "print", &["repr(v)"]),
    ("P(v, v)", "1", &["repr(v)", "hash(v)", "v == w"]),
    (
        "D(v, v)",
        "1",
        &["repr(v)", "v == w", "dataclasses.asdict(v)"],
    ),
    ("ValueError(v, v)", "1", &["repr(v)", "str(v)"]),
];

#[test]
fn walks_that_never_end_give_way_and_end_when_they_are_stopped() {
    for (next, innermost, walks) in WALKS {
        for walk in *walks {
            let text = format!(
                r#"
import json, pprint, copy, collections, functools, dataclasses, textwrap
class K:
    def __init__(self, v): self.v = v
    def __repr__(self): return repr((self.v, self.v))
    def __eq__(self, other): return (self.v, self.v) == (other.v, other.v)
    def __hash__(self): return hash((self.v, self.v))
P = collections.namedtuple('P', 'a b')
@dataclasses.dataclass
class D:
    a: object
    b: object
def made():
    v = {innermost}
    for k in range(60): v = {next}
    return v
v = made()
w = made()
try:
    {walk}
except (MemoryError, RecursionError, TypeError, ValueError):
    pass
"#
            );
            let limits = Limits {
                memory_bytes: 32 << 20,
                stop_fuel: 200,
                ..Limits::default()
            };
            let (_stage, interpreter) = task_with(limits);
            let mut main = begin(&interpreter, &text);
            let began = Instant::now();
            let mut ended = false;
            for _ in 0..40 {
                match main.resume(Resume::Continue, 1000) {
                    ResumeOutcome::OutOfFuel => {}
                    ResumeOutcome::Done(_) | ResumeOutcome::Failed(_) => {
                        ended = true;
                        break;
                    }
                    other => panic!("{next}: {walk}: {other:?}"),
                }
            }
            if !ended {
                let step = main.resume(Resume::Stop, 0);
                assert!(main.is_ended(), "{next}: {walk}: {step:?}");
            }
            let took = began.elapsed().as_secs();
            assert!(took < 30, "{next}: {walk} takes {took} s to give way");
        }
    }
}
