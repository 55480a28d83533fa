//! Texts of containers that lead back to themselves, also through a `__repr__` of the script: as CPython 3.11 has them.

use super::run;

/// What is made, with `c` in it somewhere below, and its text.
const CIRCLES: &[(&str, &str)] = &[
    ("c = []; c.append(c)", "[[...]]"),
    ("c = {}; c[1] = c", "{1: {...}}"),
    ("l = []; c = (l,); l.append(c)", "([(...)],)"),
    ("c = []; c.append(Shows())", "[[...]]"),
    ("c = {}; c['k'] = [Shows()]", "{'k': [{...}]}"),
    ("c = {Shows()}", "{set(...)}"),
    ("c = frozenset([Shows()])", "frozenset({frozenset(...)})"),
    ("c = (1, Shows())", "(1, (...))"),
    ("d = {1: Shows()}; c = d.values()", "dict_values([...])"),
    ("class L(list): pass\nc = L([Shows()])", "[[...]]"),
    ("c = [Shows(), [Shows()]]", "[[...], [[...]]]"),
    ("c = [f'{Shows()}', Within()]", "['<[...]>', [...]]"),
    ("c = [Twice()]", "[[...][...]]"),
    (
        "c = slice(1, [2]); c = [c, c]",
        "[slice(1, [2], None), slice(1, [2], None)]",
    ),
];

#[test]
fn circles_are_shown_once_also_through_a_method_of_the_script() {
    for (made, shown) in CIRCLES {
        let text = format!(
            r#"
class Shows:
    def __repr__(self): return repr(c)
    def __format__(self, spec): return '<[...]>'
    def __hash__(self): return 1
class Within(Shows):
    def __repr__(self): return str(c)
class Twice(Shows):
    def __repr__(self): return repr(c) + str(c)
{made}
for k in range(2):
    print(repr(c))
"#
        );
        assert_eq!(run(&text), format!("{shown}\n{shown}\n"), "{made}");
    }
}

/// What one thread is in the middle of showing, another shows whole; and an error on the way leaves nothing behind.
#[test]
fn what_another_thread_shows_is_no_circle() {
    let text = r#"
import threading, time
class Waits:
    def __repr__(self):
        time.sleep(0.01)
        return 'W'
class Fails:
    def __repr__(self): raise ValueError('no')
shared = [Waits(), {1: Waits()}]
texts = []
def show(): texts.append(repr(shared))
threads = [threading.Thread(target=show) for _ in range(4)]
for t in threads: t.start()
for t in threads: t.join()
print(sorted(set(texts)))
c = [1, [Fails()]]
for k in range(2):
    try: repr(c)
    except ValueError as e: print(e)
c[1][0] = c
print(c)
"#;
    assert_eq!(run(text), "['[W, {1: W}]']\nno\nno\n[1, [[...]]]\n");
}
