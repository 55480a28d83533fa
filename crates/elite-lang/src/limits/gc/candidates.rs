//! What was noted as a possible part of a cycle, by kind and age.

use std::cell::{Cell, RefCell};
use std::rc::{Rc, Weak};

use crate::eval::generator::Generator;
use crate::value::{CellVar, Class, Dict, Function, Instance, List, Set, Value};

/// Kinds of noted objects.
pub(super) const KINDS: usize = 8;
/// Listed objects that are looked at for each one that grows old.
const TIDIED: usize = 4;
/// Listed objects that are looked at for each one that is noted: about half of those listed are alive, or more.
const TIDIED_YOUNG: usize = 2;

/// Weak references of one kind. A dead object's memory is kept while it is listed; the lists are looked through little
/// by little as others join them.
pub(super) struct CandidateList<T> {
    young: RefCell<Vec<Weak<T>>>,
    /// The next young entry to look at.
    next_young: Cell<usize>,
    old: RefCell<Vec<Weak<T>>>,
    /// The next old entry to look at.
    next: Cell<usize>,
}

/// Looks at `count` entries from number `next` on; the dead ones leave.
fn prune_dead<T>(list: &mut Vec<Weak<T>>, next: &Cell<usize>, count: usize) {
    let mut at = next.get();
    for _ in 0..count {
        match list.get(at) {
            Some(object) if object.strong_count() == 0 => drop(list.swap_remove(at)),
            Some(_) => at += 1,
            None => {
                at = 0;
                break;
            }
        }
    }
    next.set(at);
}

impl<T> Default for CandidateList<T> {
    fn default() -> Self {
        CandidateList {
            young: RefCell::default(),
            next_young: Cell::new(0),
            old: RefCell::default(),
            next: Cell::new(0),
        }
    }
}

impl<T> CandidateList<T> {
    /// Notes one more. Unless a search is under way, which counts on their order, some dead ones leave; how many did.
    pub(super) fn push(&self, object: &Rc<T>, searching: bool) -> usize {
        let mut young = self.young.borrow_mut();
        let before = young.len();
        if !searching {
            prune_dead(&mut young, &self.next_young, TIDIED_YOUNG);
        }
        let left = before - young.len();
        young.push(Rc::downgrade(object));
        left
    }

    fn young(&self) -> usize {
        self.young.borrow().len()
    }

    /// Object number `index`, the old ones first, if it is still alive; an error at the end of the list.
    fn at(&self, index: usize) -> Result<Option<Rc<T>>, ()> {
        let old = self.old.borrow();
        if let Some(object) = old.get(index) {
            return Ok(object.upgrade());
        }
        let young = self.young.borrow();
        young.get(index - old.len()).map(Weak::upgrade).ok_or(())
    }

    /// The first `count` of the young ones grow old, up to `most` of them; how many are left to do.
    fn age(&self, count: usize, most: usize) -> usize {
        let (mut young, mut old) = (self.young.borrow_mut(), self.old.borrow_mut());
        let now = count.min(most).min(young.len());
        // Taken from the end of those that were looked at; what was noted since then moves up.
        let from = count.min(young.len()) - now;
        for object in young.drain(from..from + now) {
            if object.strong_count() > 0 {
                old.push(object);
            }
        }
        prune_dead(&mut old, &self.next, now * TIDIED);
        if old.len() < old.capacity() / 4 {
            let room = old.len() * 2;
            old.shrink_to(room);
        }
        from
    }

    fn take(&self) -> impl Iterator<Item = Rc<T>> {
        let all = self.young.take().into_iter().chain(self.old.take());
        all.filter_map(|object| object.upgrade())
    }
}

/// All that was noted.
#[derive(Default)]
pub(super) struct GcCandidates {
    pub(super) instances: CandidateList<Instance>,
    pub(super) cells: CandidateList<CellVar>,
    pub(super) lists: CandidateList<List>,
    pub(super) dicts: CandidateList<Dict>,
    pub(super) sets: CandidateList<Set>,
    pub(super) functions: CandidateList<Function>,
    pub(super) classes: CandidateList<Class>,
    pub(super) generators: CandidateList<Generator>,
}

impl GcCandidates {
    /// Object number `index` of kind `kind`, the old ones first: None if it is dead, an error if there is no such
    /// number.
    pub(super) fn at(&self, kind: usize, index: usize) -> Result<Option<Value>, ()> {
        Ok(match kind {
            0 => self.instances.at(index)?.map(Value::Instance),
            1 => self.cells.at(index)?.map(Value::Cell),
            2 => self.lists.at(index)?.map(Value::List),
            3 => self.dicts.at(index)?.map(Value::Dict),
            4 => self.sets.at(index)?.map(Value::Set),
            5 => self.functions.at(index)?.map(Value::Function),
            6 => self.classes.at(index)?.map(Value::Class),
            _ => self.generators.at(index)?.map(Value::Generator),
        })
    }

    /// How many of a kind are old, and how many are young.
    pub(super) fn ages(&self, kind: usize) -> (usize, usize) {
        fn of<T>(kind: &CandidateList<T>) -> (usize, usize) {
            (kind.old.borrow().len(), kind.young())
        }
        match kind {
            0 => of(&self.instances),
            1 => of(&self.cells),
            2 => of(&self.lists),
            3 => of(&self.dicts),
            4 => of(&self.sets),
            5 => of(&self.functions),
            6 => of(&self.classes),
            _ => of(&self.generators),
        }
    }

    /// The first `count` of the young ones of a kind grow old, up to `most` of them; how many are left to do.
    pub(super) fn promote(&self, kind: usize, count: usize, most: usize) -> usize {
        match kind {
            0 => self.instances.age(count, most),
            1 => self.cells.age(count, most),
            2 => self.lists.age(count, most),
            3 => self.dicts.age(count, most),
            4 => self.sets.age(count, most),
            5 => self.functions.age(count, most),
            6 => self.classes.age(count, most),
            _ => self.generators.age(count, most),
        }
    }

    /// All that are still alive, which are no longer noted. Generators come first: what they do when they end should
    /// see the rest as it was.
    pub(super) fn take(&self) -> impl Iterator<Item = Value> {
        let generators = self.generators.take().map(Value::Generator);
        generators
            .chain(self.cells.take().map(Value::Cell))
            .chain(self.instances.take().map(Value::Instance))
            .chain(self.lists.take().map(Value::List))
            .chain(self.dicts.take().map(Value::Dict))
            .chain(self.sets.take().map(Value::Set))
            .chain(self.functions.take().map(Value::Function))
            .chain(self.classes.take().map(Value::Class))
    }
}
