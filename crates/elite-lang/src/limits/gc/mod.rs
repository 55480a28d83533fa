//! Reference cycles: what the interpreter does about them.
//!
//! Values are counted references, so a cycle keeps itself alive. Every cycle goes through something that was changed
//! after it was made: an instance, a shared variable of closures, a list, a dictionary, a set, a function with
//! attributes, a class or a generator. The interpreter notes the former when they are given a value that can hold
//! others, the last two when they are made. From time to time it looks for the ones that only keep each other alive
//! (`search`) and takes them apart; at the end of the task it takes apart whatever is left.
//!
//! There are two generations. Most searches look at what was noted since the one before, and at what that reaches, but
//! not at what an earlier search has found in use: references from there keep objects alive like any others from
//! outside. Everything is looked at when a quarter as much again has been found in use, or when memory is short. So the
//! work stays in proportion to what the program makes, however much it keeps.
//!
//! A search goes on in slices. While one is under way no script code runs; after each slice the driver of the script
//! threads has its turn, so that a stop never waits for a search. What references what is in `graph`, the lists of what
//! was noted are in `gc_tracked`. When a search begins depends on counts alone, so a program runs the same every time.

mod candidates;
mod run;
#[cfg(test)]
mod tests;
mod traverse;

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use crate::eval::InterpreterState;
use crate::eval::generator::Generator;
use crate::value::module::Namespace;
use crate::value::{CellVar, Class, Dict, Function, Instance, List, Set, Value};
use candidates::GcCandidates;
use run::GcRun;
use traverse::clear_references;

/// A search is not worth it for fewer new parts of cycles than this.
const FRESH_MIN: usize = 10_000;
/// Growth for which one is worth it, bytes, if the task may hold as much as usual.
const GROWTH: usize = 32 << 20;
/// A search through everything is not worth it for fewer objects that have grown old since the last one.
const AGED_MIN: usize = 25_000;

/// What may be part of a cycle.
#[derive(Default)]
pub struct CycleCollector {
    noted: GcCandidates,
    /// Candidates noted since the last search.
    new_candidates: Cell<usize>,
    /// Number of new candidates that makes the next search due.
    fresh_due: Cell<usize>,
    /// Bytes in use that make the next search due.
    memory_due: Cell<usize>,
    /// Bytes in use that make a search through everything due.
    memory_due_all: Cell<usize>,
    /// Objects found in use since the last search through everything, and by it.
    promoted: Cell<usize>,
    old: Cell<usize>,
    /// Slices of fuel since the last search through everything.
    slices: Cell<usize>,
    /// The search that is under way; taken out while it does a slice.
    search: RefCell<Option<Box<GcRun>>>,
    searching: Cell<bool>,
    /// What a search that was given up has looked at, dropped bit by bit.
    abandoned: RefCell<Option<Box<GcRun>>>,
}

impl InterpreterState {
    /// One more is noted, and so many that had died are not any more.
    fn count_tracked(&self, died: usize) {
        let fresh = self.cycles.new_candidates.get().saturating_sub(died);
        self.cycles.new_candidates.set(fresh + 1);
    }

    /// Notes whatever a container is, because it is given a value which can hold others.
    #[inline(never)]
    pub fn gc_track(&self, value: &Value) {
        match value {
            Value::List(list) if !list.gc_tracked.get() => self.gc_track_list(list),
            Value::Dict(dict) if !dict.noted.get() => self.note_dict(dict),
            Value::Set(set) if !set.noted.get() => self.note_set(set),
            Value::Function(function) => self.note_function(function),
            Value::Instance(instance) => {
                if !instance.noted.get() {
                    self.note_instance(instance);
                }
                if let Some(extended) = instance.builtin_value() {
                    self.gc_track(&extended);
                }
            }
            _ => {}
        }
    }

    /// Notes an instance that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_instance(&self, instance: &Rc<Instance>) {
        instance.noted.set(true);
        instance.old.set(false);
        self.count_tracked(
            self.cycles
                .noted
                .instances
                .push(instance, self.is_gc_running()),
        );
    }

    /// Notes a shared variable that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_cell(&self, cell: &Rc<CellVar>) {
        cell.noted.set(true);
        cell.old.set(false);
        self.count_tracked(self.cycles.noted.cells.push(cell, self.is_gc_running()));
    }

    /// Notes a list that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn gc_track_list(&self, list: &Rc<List>) {
        list.gc_tracked.set(true);
        list.gc_old.set(false);
        self.count_tracked(self.cycles.noted.lists.push(list, self.is_gc_running()));
    }

    /// Notes a dictionary that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_dict(&self, dict: &Rc<Dict>) {
        dict.noted.set(true);
        dict.old.set(false);
        self.count_tracked(self.cycles.noted.dicts.push(dict, self.is_gc_running()));
    }

    /// Notes a set that is given a value which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_set(&self, set: &Rc<Set>) {
        set.noted.set(true);
        set.old.set(false);
        self.count_tracked(self.cycles.noted.sets.push(set, self.is_gc_running()));
    }

    /// Notes a function that is given an attribute which can hold others.
    #[cold]
    #[inline(never)]
    pub fn note_function(&self, function: &Rc<Function>) {
        if !function.noted.replace(true) {
            function.old.set(false);
            self.count_tracked(
                self.cycles
                    .noted
                    .functions
                    .push(function, self.is_gc_running()),
            );
        }
    }

    /// Notes the variables of a namespace that hold what can hold others.
    pub fn note_namespace(&self, namespace: &Namespace) {
        for cell in namespace.own_cells() {
            if !cell.noted.get() && cell.value.borrow().can_hold_values() {
                self.note_cell(&cell);
            }
        }
    }

    /// Notes a class that has just been made.
    pub fn note_class(&self, class: &Rc<Class>) {
        self.count_tracked(self.cycles.noted.classes.push(class, self.is_gc_running()));
    }

    /// Notes a generator that has just been made.
    pub fn note_generator(&self, generator: &Rc<Generator>) {
        self.count_tracked(
            self.cycles
                .noted
                .generators
                .push(generator, self.is_gc_running()),
        );
    }

    /// Whether a search is under way: then no script code may run before `run_gc_slice` says that it is over.
    #[inline]
    pub fn is_gc_running(&self) -> bool {
        self.cycles.searching.get()
    }

    /// Begins a search if enough has come up since the last one; whether it did.
    #[inline]
    pub fn start_gc_if_due(&self) -> bool {
        let cycles = &self.cycles;
        self.drop_leftover();
        cycles.slices.set(cycles.slices.get() + 1);
        let (fresh, aged) = (cycles.new_candidates.get(), cycles.promoted.get());
        let (used, first) = (self.memory_used(), self.gc_growth_bytes(0));
        let young = fresh >= cycles.fresh_due.get().max(FRESH_MIN)
            || fresh > 0 && used >= cycles.memory_due.get().max(first);
        let all = aged >= (cycles.old.get() / 4).max(AGED_MIN)
            || aged > 0 && used >= cycles.memory_due_all.get().max(first);
        if young || all {
            // What was made lately is more likely to be free than the rest.
            self.begin_search(!young);
        }
        young || all
    }

    /// With how many bytes in use a search may be due.
    pub fn gc_threshold_bytes(&self) -> usize {
        self.cycles.memory_due.get().max(self.gc_growth_bytes(0))
    }

    /// How much more a task with `used` bytes may come to hold before a search is worth it: as much again, but less the
    /// nearer it is to its limit.
    fn gc_growth_bytes(&self, used: usize) -> usize {
        let limit = self.limits.memory_bytes;
        let left = limit.saturating_sub(used) / 2;
        used.max(GROWTH).min(left).max(limit / 64)
    }

    /// Begins a search for cycles that nothing refers to from outside, unless one is under way: of everything, or of
    /// what is not old.
    #[cold]
    fn begin_search(&self, all: bool) {
        if !self.cycles.searching.replace(true) {
            // The tables of a search may take an eighth of what the task may hold.
            let most = self.limits.memory_bytes / 8 / run::BYTES_OF_NODE;
            *self.cycles.search.borrow_mut() = Some(Box::new(GcRun::new(all, most)));
        }
    }

    /// Goes on with a search that is under way; whether it is over.
    pub fn run_gc_slice(&self) -> bool {
        let cycles = &self.cycles;
        // Taking cycles apart ends generators, whose `finally` blocks are script code that may come here again.
        let Some(mut search) = cycles.search.take() else {
            return !self.is_gc_running();
        };
        let is_over = search.slice(&cycles.noted);
        // What it has freed in big blocks goes back slice by slice, too.
        task_memory::unmap_deferred();
        if !is_over {
            *cycles.search.borrow_mut() = Some(search);
            return false;
        }
        cycles.new_candidates.set(0);
        if search.is_of_all() {
            cycles.old.set(search.alive_count());
            cycles.promoted.set(0);
            cycles.slices.set(0);
            let used = self.memory_used();
            let due = used.saturating_add(self.gc_growth_bytes(used));
            cycles.memory_due_all.set(due);
        } else {
            cycles
                .promoted
                .set(cycles.promoted.get() + search.alive_count());
            // The next search waits for that many new candidates, so that searching stays in proportion to the
            // program's own work.
            cycles.fresh_due.set(search.seen_count());
        }
        let used = self.memory_used();
        let due = used.saturating_add(self.gc_growth_bytes(used));
        cycles.memory_due.set(due);
        cycles.searching.set(false);
        true
    }

    /// Gives up the search that is under way, because script code is to run now.
    pub fn abandon_gc(&self) {
        if let Some(search) = self.cycles.search.take() {
            self.cycles.searching.set(false);
            *self.cycles.abandoned.borrow_mut() = Some(search);
        }
    }

    fn drop_leftover(&self) {
        let Some(mut search) = self.cycles.abandoned.take() else {
            return;
        };
        if !search.drop_some() {
            self.cycles.abandoned.borrow_mut().get_or_insert(search);
        }
    }

    /// Whole searches at once until `bytes` more fit, for when memory is short. Everything is only looked at if the
    /// program has done as much since it was looked at last.
    #[cold]
    #[inline(never)]
    pub fn gc_until_fits(&self, bytes: usize) {
        self.search_at_once(false);
        let work = self
            .cycles
            .slices
            .get()
            .saturating_mul(crate::eval::core::FUEL_SLICE as usize);
        if !self.fits_memory(bytes) && work >= self.cycles.old.get() / 8 {
            self.search_at_once(true);
        }
    }

    fn search_at_once(&self, all: bool) {
        self.begin_search(all);
        while !self.run_gc_slice() {
            if self.cycles.search.borrow().is_none() {
                // The search itself has led here.
                return;
            }
        }
    }

    /// Breaks the cycles through all that was noted and still lives.
    pub fn break_cycles(&self) {
        drop(self.cycles.search.take());
        drop(self.cycles.abandoned.take());
        // What is dropped on the way may run no script code any more, so nothing is noted meanwhile.
        for object in self.cycles.noted.take() {
            clear_references(&object);
        }
    }
}
