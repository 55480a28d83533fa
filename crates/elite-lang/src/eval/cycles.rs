//! Reference cycles: what the interpreter does about them.
//!
//! Values are counted references, so a cycle keeps itself alive. The interpreter notes every instance and every shared
//! variable (of closures) that is given a value which can hold others, and takes those that are left apart when the
//! task ends. What a task leaks while it runs counts towards its memory limit, so the limit is the bound; what it leaks
//! beyond its end are cycles that go through neither an instance nor a closure: lists, dictionaries and sets that
//! contain themselves.

use std::cell::{Cell, RefCell};
use std::rc::{Rc, Weak};

use super::Core;
use crate::value::{CellVar, Instance};

/// Entries up to which the lists are not searched for dead ones.
const LEAST: usize = 1024;

/// What may be part of a cycle.
#[derive(Default)]
pub struct Cycles {
    instances: Noted<Instance>,
    cells: Noted<CellVar>,
}

/// Weak references of one kind. A dead object's memory is kept while it is listed, so the dead ones are dropped
/// whenever the list has doubled.
struct Noted<T> {
    all: RefCell<Vec<Weak<T>>>,
    limit: Cell<usize>,
}

impl<T> Default for Noted<T> {
    fn default() -> Self {
        Noted {
            all: RefCell::default(),
            limit: Cell::new(LEAST),
        }
    }
}

impl<T> Noted<T> {
    fn push(&self, object: &Rc<T>) {
        let mut all = self.all.borrow_mut();
        if all.len() >= self.limit.get() {
            all.retain(|object| object.strong_count() > 0);
            self.limit.set((all.len() * 2).max(LEAST));
        }
        all.push(Rc::downgrade(object));
    }
}

impl Core {
    /// Notes an instance that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_instance(&self, instance: &Rc<Instance>) {
        instance.noted.set(true);
        self.cycles.instances.push(instance);
    }

    /// Notes a shared variable that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_cell(&self, cell: &Rc<CellVar>) {
        cell.noted.set(true);
        self.cycles.cells.push(cell);
    }

    /// Breaks the cycles through all that was noted and still lives.
    pub fn break_cycles(&self) {
        // What is dropped on the way may run no script code any more, so nothing is noted meanwhile.
        for cell in self
            .cycles
            .cells
            .all
            .take()
            .iter()
            .filter_map(Weak::upgrade)
        {
            drop(cell.value.take());
        }
        let instances = self.cycles.instances.all.take();
        for instance in instances.iter().filter_map(Weak::upgrade) {
            instance.dismantle();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test: a broken program should stop it

    use std::rc::Rc;

    use crate::limits::memory;
    use crate::{
        Host, Interpreter, KnownNames, Limits, Resume, SourceFile, Step, ThreadId, compile,
    };

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

    #[test]
    fn modules_and_what_they_hold_are_released_with_the_task() {
        let text = "import threading, queue, collections, json, re, datetime, random, functools\n\
            q = queue.Queue()\nfor i in range(1000): q.put([i] * 20)\n\
            lock = threading.Condition()\nc = collections.deque([q, lock] * 5000)\nr = random.Random(1)\nt = threading.Timer(1, print)\n";
        assert_eq!(left(text), 0);
    }
}
