//! Script threads that wait within natives: what one of them is in the middle of is no business of the others.

use super::run;

/// Ways to wait within a native operation, `wait` being a function of one argument that sleeps.
const WITHIN: &[&str] = &[
    "list(map(wait, [1]))",
    "list(zip(map(wait, [1]), [2]))",
    "list(enumerate(map(wait, [1])))",
    "list(filter(wait, [1]))",
    "sorted([1], key=wait)",
    "max([1], key=wait)",
    "repr([Waits()])",
    "str(Waits())",
    "[Waits()] == [Waits()]",
    "(Waits(),) < (Waits(),)",
    "hash((Waits(),))",
    "{Waits()}",
    "{1: Waits()} == {1: Waits()}",
    "json.dumps(Waits(), default=lambda x: wait(1))",
    "json.loads('{\"a\": 1}', object_hook=wait)",
    "re.sub('a', lambda m: wait('b'), 'a')",
    "isinstance(1, (str, (Meta('K', (), {}),)))",
    "Waits()()",
    "functools.reduce(lambda a, b: wait(a), [1, 2])",
    "list(itertools.chain.from_iterable(map(lambda x: [wait(x)], [1])))",
    "list(generator())",
    "copy.copy(Waits())",
    "f'{Waits()}'",
    "bound()",
    "list(map(bound.__call__, []))",
];

#[test]
fn threads_that_wait_within_natives_leave_no_depth_behind() {
    for within in WITHIN {
        let text = format!(
            r#"
import threading, time, json, re, functools, itertools, copy
count = 0
def wait(x):
    global count
    count += 1
    time.sleep(0.01)
    return x
class Waits:
    def __repr__(self): wait(1); return 'W'
    def __eq__(self, other): wait(1); return True
    def __lt__(self, other): wait(1); return True
    def __hash__(self): return wait(1)
    def __call__(self): return wait(1)
    def __format__(self, spec): wait(1); return ''
    def __copy__(self): return wait(1)
class Meta(type):
    def __instancecheck__(cls, x): return wait(False)
def generator():
    try: yield wait(1)
    finally: pass
bound = Waits().__repr__
def work():
    for i in range(1500):
        {within}
        time.sleep(0.01)
threads = [threading.Thread(target=work) for _ in range(2)]
for t in threads: t.start()
for t in threads: t.join()
print('done')
"#
        );
        assert_eq!(run(&text), "done\n", "{within}");
    }
}
