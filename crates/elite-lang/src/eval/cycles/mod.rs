//! Reference cycles: what the interpreter does about them.
//!
//! Values are counted references, so a cycle keeps itself alive. Every cycle goes through something that was changed
//! after it was made: an instance, a shared variable of closures, a list, a dictionary or a function with attributes. The
//! interpreter notes those when they are given a value that can hold others. From time to time it looks for the ones that
//! only keep each other alive (`search`) and takes them apart; at the end of the task it takes apart whatever is left.
//!
//! A search goes on in slices. While one is under way no script code runs; after each slice the driver of the script
//! threads has its turn, so that a stop never waits for a search. What references what is in `graph`.
//! When a search begins depends on counts alone, so a program runs the same every time.

mod graph;
mod search;
#[cfg(test)]
mod tests;

use std::cell::{Cell, RefCell};
use std::rc::{Rc, Weak};

use super::Core;
use crate::value::{CellVar, Dict, Function, Instance, List, Value};
use graph::take_apart;
use search::Search;

/// Entries up to which the lists are not searched for dead ones.
const LEAST: usize = 1024;
/// A search is not worth it for fewer new parts of cycles than this.
const FRESH_MIN: usize = 10_000;
/// Nor for less growth than this, bytes.
const GROWTH_MIN: usize = 32 << 20;

/// What may be part of a cycle.
#[derive(Default)]
pub struct Cycles {
    instances: Noted<Instance>,
    cells: Noted<CellVar>,
    lists: Noted<List>,
    dicts: Noted<Dict>,
    functions: Noted<Function>,
    /// Noted since the last search.
    fresh: Cell<usize>,
    /// The next search is due with so many.
    fresh_due: Cell<usize>,
    /// Or with so many bytes in use.
    memory_due: Cell<usize>,
    /// The search that is under way; taken out while it does a slice.
    search: RefCell<Option<Box<Search>>>,
    searching: Cell<bool>,
    /// What a search that was given up has looked at, dropped bit by bit.
    leftover: RefCell<Option<Box<Search>>>,
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

    /// Object number `index`, if it is still alive; an error at the end of the list.
    fn at(&self, index: usize) -> Result<Option<Rc<T>>, ()> {
        self.all.borrow().get(index).map(Weak::upgrade).ok_or(())
    }

    /// Closes the gaps of dead objects, for entries from `read` on, up to `count` of them; false at the end of the list.
    fn forget_dead(&self, read: &mut usize, write: &mut usize, count: usize) -> bool {
        let mut all = self.all.borrow_mut();
        let end = all.len().min(*read + count);
        while *read < end {
            if all[*read].strong_count() > 0 {
                all.swap(*read, *write);
                *write += 1;
            }
            *read += 1;
        }
        let more = *read < all.len();
        if !more {
            all.truncate(*write);
        }
        more
    }

    fn take(&self) -> impl Iterator<Item = Rc<T>> {
        self.all
            .take()
            .into_iter()
            .filter_map(|object| object.upgrade())
    }
}

impl Cycles {
    /// Noted object number `index` of kind `kind`: None if it is dead, an error if there is no such number.
    fn noted(&self, kind: usize, index: usize) -> Result<Option<Value>, ()> {
        Ok(match kind {
            0 => self.instances.at(index)?.map(Value::Instance),
            1 => self.cells.at(index)?.map(Value::Cell),
            2 => self.lists.at(index)?.map(Value::List),
            3 => self.dicts.at(index)?.map(Value::Dict),
            _ => self.functions.at(index)?.map(Value::Function),
        })
    }

    fn forget_dead(&self, kind: usize, read: &mut usize, write: &mut usize, count: usize) -> bool {
        match kind {
            0 => self.instances.forget_dead(read, write, count),
            1 => self.cells.forget_dead(read, write, count),
            2 => self.lists.forget_dead(read, write, count),
            3 => self.dicts.forget_dead(read, write, count),
            _ => self.functions.forget_dead(read, write, count),
        }
    }
}

/// Kinds of noted objects.
const KINDS: usize = 5;

impl Core {
    fn one_more(&self) {
        self.cycles.fresh.set(self.cycles.fresh.get() + 1);
    }

    /// Notes an instance that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_instance(&self, instance: &Rc<Instance>) {
        instance.noted.set(true);
        self.one_more();
        self.cycles.instances.push(instance);
    }

    /// Notes a shared variable that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_cell(&self, cell: &Rc<CellVar>) {
        cell.noted.set(true);
        self.one_more();
        self.cycles.cells.push(cell);
    }

    /// Notes a list that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_list(&self, list: &Rc<List>) {
        list.noted.set(true);
        self.one_more();
        self.cycles.lists.push(list);
    }

    /// Notes a dictionary that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_dict(&self, dict: &Rc<Dict>) {
        dict.noted.set(true);
        self.one_more();
        self.cycles.dicts.push(dict);
    }

    /// Notes a function that is given an attribute which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_function(&self, function: &Rc<Function>) {
        self.one_more();
        self.cycles.functions.push(function);
    }

    /// Whether a search is under way: then no script code may run before `search_slice` says that it is over.
    #[inline]
    pub fn is_searching(&self) -> bool {
        self.cycles.searching.get()
    }

    /// Begins a search if enough has come up since the last one; whether it did.
    #[inline]
    pub fn begin_search_if_due(&self) -> bool {
        let cycles = &self.cycles;
        self.drop_leftover();
        let fresh = cycles.fresh.get();
        let due = fresh >= cycles.fresh_due.get().max(FRESH_MIN)
            || fresh > 0 && self.memory_used() >= cycles.memory_due.get().max(GROWTH_MIN);
        if due {
            self.begin_search();
        }
        due
    }

    /// Begins a search for cycles that nothing refers to from outside, unless one is under way.
    #[cold]
    fn begin_search(&self) {
        if !self.cycles.searching.replace(true) {
            *self.cycles.search.borrow_mut() = Some(Box::default());
        }
    }

    /// Goes on with a search that is under way; whether it is over.
    pub fn search_slice(&self) -> bool {
        let cycles = &self.cycles;
        // Taking cycles apart ends generators, whose `finally` blocks are script code that may come here again.
        let Some(mut search) = cycles.search.take() else {
            return !self.is_searching();
        };
        if !search.slice(cycles) {
            *cycles.search.borrow_mut() = Some(search);
            return false;
        }
        cycles.fresh.set(0);
        // So the work stays in proportion to what the program itself does.
        cycles.fresh_due.set(search.seen());
        cycles.memory_due.set(self.memory_used().saturating_mul(2));
        cycles.searching.set(false);
        true
    }

    /// Gives up the search that is under way, because script code is to run now.
    pub fn abandon_search(&self) {
        if let Some(search) = self.cycles.search.take() {
            self.cycles.searching.set(false);
            *self.cycles.leftover.borrow_mut() = Some(search);
        }
    }

    fn drop_leftover(&self) {
        let Some(mut search) = self.cycles.leftover.take() else {
            return;
        };
        if !search.drop_some() {
            self.cycles.leftover.borrow_mut().get_or_insert(search);
        }
    }

    /// A whole search at once, for when memory is short.
    #[cold]
    #[inline(never)]
    pub fn collect(&self) {
        self.begin_search();
        while !self.search_slice() {
            if self.cycles.search.borrow().is_none() {
                // The search itself has led here.
                return;
            }
        }
    }

    /// Breaks the cycles through all that was noted and still lives.
    pub fn break_cycles(&self) {
        drop(self.cycles.search.take());
        drop(self.cycles.leftover.take());
        // What is dropped on the way may run no script code any more, so nothing is noted meanwhile.
        let cycles = &self.cycles;
        cycles
            .cells
            .take()
            .for_each(|cell| take_apart(&Value::Cell(cell)));
        cycles
            .instances
            .take()
            .for_each(|one| take_apart(&Value::Instance(one)));
        cycles
            .lists
            .take()
            .for_each(|list| take_apart(&Value::List(list)));
        cycles
            .dicts
            .take()
            .for_each(|dict| take_apart(&Value::Dict(dict)));
        cycles
            .functions
            .take()
            .for_each(|function| take_apart(&Value::Function(function)));
    }
}
