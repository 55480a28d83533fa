//! Lists of objects that do not keep them alive. The memory of a dead object stays while it is listed, so the dead ones
//! leave whenever the list has doubled.

use std::cell::{Cell, RefCell};
use std::rc::{Rc, Weak};

/// Entries up to which a list is not searched for dead ones.
const PRUNE_MIN: usize = 16;

/// Weak references to objects of one kind.
pub struct WeakList<T> {
    all: RefCell<Vec<Weak<T>>>,
    /// At this length dead ones leave.
    limit: Cell<usize>,
}

impl<T> Default for WeakList<T> {
    fn default() -> Self {
        WeakList {
            all: RefCell::default(),
            limit: Cell::new(PRUNE_MIN),
        }
    }
}

impl<T> WeakList<T> {
    /// Lists one more.
    pub fn push(&self, object: &Rc<T>) {
        let mut all = self.all.borrow_mut();
        if all.len() >= self.limit.get() {
            all.retain(|listed| listed.strong_count() > 0);
            self.limit.set((all.len() * 2).max(PRUNE_MIN));
            all.shrink_to(self.limit.get());
        }
        all.push(Rc::downgrade(object));
    }

    /// Runs `for_each_alive`, which lists nothing here, on those that are alive.
    pub fn for_each_alive(&self, each: impl FnMut(&Rc<T>)) {
        self.each_alive_in(usize::MAX, usize::MAX, each);
    }

    /// Runs `for_each_alive`, which lists nothing here, on those that are alive among the `count` listed ones before
    /// number `before`, last ones first; the number to go on with, 0 at the end. Others may be listed in between: what
    /// is listed already only moves to the front, so none is left out.
    pub fn each_alive_in(
        &self,
        before: usize,
        count: usize,
        mut each: impl FnMut(&Rc<T>),
    ) -> usize {
        let all = self.all.borrow();
        let end = all.len().min(before);
        let begin = end.saturating_sub(count);
        let some = all[begin..end].iter().rev();
        some.filter_map(Weak::upgrade)
            .for_each(|object| each(&object));
        begin
    }

    /// Whether an object is listed.
    pub fn lists(&self, object: &Rc<T>) -> bool {
        let all = self.all.borrow();
        all.iter()
            .any(|listed| listed.as_ptr() == Rc::as_ptr(object))
    }

    /// The objects that are alive.
    pub fn alive(&self) -> Vec<Rc<T>> {
        self.all.borrow().iter().filter_map(Weak::upgrade).collect()
    }

    /// The objects that are alive; the list is empty then.
    pub fn take(&self) -> Vec<Rc<T>> {
        let all = self.all.take();
        all.iter().filter_map(Weak::upgrade).collect()
    }

    /// Listed objects, dead ones included.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.all.borrow().len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dead_ones_leave_and_the_others_keep_their_order() {
        let list = WeakList::default();
        let mut kept = Vec::new();
        for number in 0..100_000 {
            let object = Rc::new(number);
            list.push(&object);
            if number % 100 == 0 {
                kept.push(object);
            }
            assert!(
                list.len() <= 4 * kept.len() + 4 * PRUNE_MIN,
                "{} of {number}",
                list.len()
            );
        }
        assert_eq!(list.alive(), kept);
        let mut some = Vec::new();
        let mut before = usize::MAX;
        while before > 0 {
            before = list.each_alive_in(before, 10, |object| some.push(object.clone()));
            list.push(&Rc::new(0));
        }
        some.reverse();
        assert_eq!(some, kept);
        assert!(list.lists(&kept[0]) && !list.lists(&Rc::new(0)));
    }
}
