//! Natives that keep a value, in chains of 200,000: each is dropped without ending the process, which it would not be
//! if the value lay in a closure of Rust, where deferred drop cannot see it.

use super::run;

/// How the next link is made of the one before (`v`).
const LINKS: &[&str] = &[
    "operator.methodcaller('f', v)",
    "operator.methodcaller('f', a=v)",
    "operator.itemgetter(v)",
    "operator.itemgetter(1, v)",
    "operator.attrgetter(Name('a', v))",
    "property(v)",
    "staticmethod(v)",
    "classmethod(v)",
    "iter(plain, v)",
    "map(plain, [v])",
    "filter(plain, [v])",
    "itertools.chain([v])",
    "itertools.repeat(v)",
    "itertools.starmap(plain, [v])",
    "re.finditer('', Name('a', v))",
    "[v].append",
    "collections.deque([v])",
];

/// Links of each chain; the same in all builds, for a recursion of forty bytes would end the process.
const LENGTH: usize = 200_000;

const BEGIN: &str = "
import collections, functools, itertools, operator, re
def plain(*a, **k): return None
class Name(str):
    def __new__(cls, text, v):
        self = str.__new__(cls, text)
        self.next = v
        return self
def chain(link):
    v = plain
    made = 0
    try:
        for n in range(LENGTH):
            v = link(v)
            made += 1
    except TypeError as refused:
        print(refused)
    v = None
    return made
";

#[test]
fn natives_that_hold_a_value_are_dropped_in_chains_of_any_length() {
    for link in LINKS {
        let text = BEGIN.replace("LENGTH", &LENGTH.to_string());
        let printed = run(&format!("{text}print(chain(lambda v: {link}))"));
        assert_eq!(printed, format!("{LENGTH}\n"), "{link}");
    }
}
