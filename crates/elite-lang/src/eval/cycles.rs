//! Reference cycles: what the interpreter does about them.
//!
//! Values are counted references, so a cycle keeps itself alive. Every cycle goes through something that was changed
//! after it was made: an instance, a shared variable of closures, a list or a dictionary. The interpreter notes those
//! when they are given a value that can hold others. From time to time it looks for the ones that only keep each other
//! alive (`collect`) and takes them apart; at the end of the task it takes apart whatever is left.
//!
//! The search is trial deletion (Lins 1992; Bacon and Rajan 2001, without the concurrency): walk from what was noted,
//! count the references that come from within, and keep what has more, with all it reaches. A reference the walk does
//! not know of (a generator's stack, a native's data) keeps its object alive, so it errs towards keeping. When it runs
//! depends on counts alone, so a program runs the same every time.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::{Rc, Weak};

use super::Core;
use crate::value::{CellVar, Dict, Instance, List, Value};

/// Entries up to which the lists are not searched for dead ones.
const LEAST: usize = 1024;

/// What may be part of a cycle.
#[derive(Default)]
pub struct Cycles {
    instances: Noted<Instance>,
    cells: Noted<CellVar>,
    lists: Noted<List>,
    dicts: Noted<Dict>,
    /// Noted since the last search.
    fresh: Cell<usize>,
    /// The next search is due with so many.
    fresh_due: Cell<usize>,
    /// Or with so many bytes in use.
    memory_due: Cell<usize>,
    /// A search is under way.
    searching: Cell<bool>,
}

/// A search is not worth it for fewer new parts of cycles than this.
const FRESH_MIN: usize = 10_000;
/// Nor for less growth than this, bytes.
const GROWTH_MIN: usize = 32 << 20;
/// Objects a search looks at; where there are more it gives up, so that it never takes long.
const OBJECTS_MAX: usize = 1 << 20;

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

    /// What is still alive, as values.
    fn alive(&self, value: fn(Rc<T>) -> Value) -> Vec<Value> {
        let alive = self.all.borrow();
        alive.iter().filter_map(Weak::upgrade).map(value).collect()
    }

    fn forget_dead(&self) {
        self.all
            .borrow_mut()
            .retain(|object| object.strong_count() > 0);
    }
}

/// One object of a search.
struct Node {
    value: Value,
    /// References from other objects of the search.
    within: usize,
    lives: bool,
}

/// Counted references to what a value stands for; None for what the search does not follow.
fn references(value: &Value) -> Option<usize> {
    Some(match value {
        Value::List(rc) => Rc::strong_count(rc),
        Value::Tuple(rc) => Rc::strong_count(rc),
        Value::Dict(rc) => Rc::strong_count(rc),
        Value::Set(rc) | Value::FrozenSet(rc) => Rc::strong_count(rc),
        Value::Instance(rc) => Rc::strong_count(rc),
        Value::Cell(rc) => Rc::strong_count(rc),
        Value::Function(rc) => Rc::strong_count(rc),
        Value::BoundMethod(rc) => Rc::strong_count(rc),
        _ => return None,
    })
}

/// Runs `each` on what a value refers to directly. What is in use right now is left out, so its parts are kept.
fn visit(value: &Value, each: &mut dyn FnMut(&Value)) {
    match value {
        Value::List(list) => list.visit(each),
        Value::Tuple(tuple) => tuple.items().iter().for_each(each),
        Value::Dict(dict) => dict.visit(each),
        Value::Set(set) | Value::FrozenSet(set) => set.visit(each),
        Value::Instance(instance) => instance.visit(each),
        Value::Cell(cell) => {
            if let Ok(held) = cell.value.try_borrow() {
                each(&held);
            }
        }
        Value::Function(function) => {
            for cell in &function.closure {
                each(&Value::Cell(cell.clone()));
            }
            function.keyword_defaults.iter().for_each(each);
        }
        Value::BoundMethod(method) => {
            each(&method.receiver);
            each(&method.function);
        }
        _ => {}
    }
}

/// Everything reachable from `starts`; None if that is too much.
fn walk(starts: Vec<Value>) -> Option<(Vec<Node>, HashMap<usize, usize>)> {
    let (mut nodes, mut places) = (Vec::new(), HashMap::new());
    let mut enter = |nodes: &mut Vec<Node>, value: &Value, from_within: bool| {
        let (Some(_), Some(address)) = (references(value), value.address()) else {
            return;
        };
        let place = *places.entry(address).or_insert_with(|| {
            nodes.push(Node {
                value: value.clone(),
                within: 0,
                lives: false,
            });
            nodes.len() - 1
        });
        nodes[place].within += usize::from(from_within);
    };
    for start in &starts {
        enter(&mut nodes, start, false);
    }
    drop(starts);
    let mut next = 0;
    while next < nodes.len() {
        if nodes.len() > OBJECTS_MAX {
            return None;
        }
        let value = nodes[next].value.clone();
        visit(&value, &mut |child| enter(&mut nodes, child, true));
        next += 1;
    }
    Some((nodes, places))
}

/// Marks what is referred to from elsewhere, and all it reaches.
fn mark(nodes: &mut [Node], places: &HashMap<usize, usize>) {
    let mut open: Vec<usize> = Vec::new();
    for (index, node) in nodes.iter_mut().enumerate() {
        // One reference is the search's own.
        if references(&node.value).is_some_and(|count| count - 1 > node.within) {
            node.lives = true;
            open.push(index);
        }
    }
    while let Some(index) = open.pop() {
        let value = nodes[index].value.clone();
        visit(&value, &mut |child| {
            let place = child.address().and_then(|address| places.get(&address));
            if let Some(place) = place
                && references(child).is_some()
                && !nodes[*place].lives
            {
                nodes[*place].lives = true;
                open.push(*place);
            }
        });
    }
}

impl Core {
    /// Notes an instance that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_instance(&self, instance: &Rc<Instance>) {
        instance.noted.set(true);
        self.cycles.fresh.set(self.cycles.fresh.get() + 1);
        self.cycles.instances.push(instance);
    }

    /// Notes a shared variable that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_cell(&self, cell: &Rc<CellVar>) {
        cell.noted.set(true);
        self.cycles.fresh.set(self.cycles.fresh.get() + 1);
        self.cycles.cells.push(cell);
    }

    /// Notes a list that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_list(&self, list: &Rc<List>) {
        list.noted.set(true);
        self.cycles.fresh.set(self.cycles.fresh.get() + 1);
        self.cycles.lists.push(list);
    }

    /// Notes a dictionary that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_dict(&self, dict: &Rc<Dict>) {
        dict.noted.set(true);
        self.cycles.fresh.set(self.cycles.fresh.get() + 1);
        self.cycles.dicts.push(dict);
    }

    /// Looks for cycles if enough has come up since the last time.
    #[inline]
    pub fn collect_if_due(&self) {
        let cycles = &self.cycles;
        let fresh = cycles.fresh.get();
        if fresh >= cycles.fresh_due.get().max(FRESH_MIN)
            || fresh > 0 && self.memory_used() >= cycles.memory_due.get().max(GROWTH_MIN)
        {
            self.collect();
        }
    }

    /// Takes cycles apart that nothing refers to from outside.
    #[cold]
    #[inline(never)]
    pub fn collect(&self) {
        let cycles = &self.cycles;
        if cycles.searching.replace(true) {
            return;
        }
        let mut starts = cycles.instances.alive(Value::Instance);
        starts.extend(cycles.cells.alive(Value::Cell));
        starts.extend(cycles.lists.alive(Value::List));
        starts.extend(cycles.dicts.alive(Value::Dict));
        let begun_with = starts.len();
        let seen = match walk(starts) {
            Some((mut nodes, places)) => {
                mark(&mut nodes, &places);
                let seen = nodes.len();
                let dead: Vec<Value> = nodes
                    .into_iter()
                    .filter(|node| !node.lives)
                    .map(|node| node.value)
                    .collect();
                dead.iter().for_each(take_apart);
                seen
            }
            None => OBJECTS_MAX.max(begun_with),
        };
        cycles.instances.forget_dead();
        cycles.cells.forget_dead();
        cycles.lists.forget_dead();
        cycles.dicts.forget_dead();
        cycles.fresh.set(0);
        // So the work stays in proportion to what the program itself does.
        cycles.fresh_due.set(seen);
        cycles.memory_due.set(self.memory_used().saturating_mul(2));
        cycles.searching.set(false);
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
        for list in self
            .cycles
            .lists
            .all
            .take()
            .iter()
            .filter_map(Weak::upgrade)
        {
            take_apart(&Value::List(list));
        }
        for dict in self
            .cycles
            .dicts
            .all
            .take()
            .iter()
            .filter_map(Weak::upgrade)
        {
            dict.clear();
        }
    }
}

/// Empties what can be emptied; a cycle always goes through one such object.
fn take_apart(value: &Value) {
    match value {
        Value::List(list) => {
            let items = std::mem::take(&mut *list.borrow_mut());
            list.account();
            drop(items);
        }
        Value::Dict(dict) => dict.clear(),
        Value::Set(set) => set.clear(),
        Value::Instance(instance) => instance.dismantle(),
        Value::Cell(cell) => drop(cell.value.take()),
        _ => {}
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
        let classes = "class A:\n    pass\n";
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
        ] {
            let text = format!(
                "{classes}def closure():\n    data = 'x' * 13600\n    def walk(): return walk, data\n\
                 for i in range(6_000):\n    {make}\n"
            );
            let most = peak(&text);
            // All of them would be 80 MB.
            assert!(most < 50 << 20, "{make}: {most} bytes");
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
}
