//! Lists of objects that do not keep them alive. The memory of a dead object stays while it is listed, so the dead ones
//! leave whenever the list has doubled.

use std::cell::{Cell, RefCell};
use std::rc::{Rc, Weak};

/// Entries up to which a list is not searched for dead ones.
const LEAST: usize = 16;

/// Weak references to objects of one kind.
pub struct WeakList<T> {
    all: RefCell<Vec<Weak<T>>>,
    limit: Cell<usize>,
}

impl<T> Default for WeakList<T> {
    fn default() -> Self {
        WeakList {
            all: RefCell::default(),
            limit: Cell::new(LEAST),
        }
    }
}

impl<T> WeakList<T> {
    /// Lists one more.
    pub fn push(&self, object: &Rc<T>) {
        let mut all = self.all.borrow_mut();
        if all.len() >= self.limit.get() {
            all.retain(|object| object.strong_count() > 0);
            self.limit.set((all.len() * 2).max(LEAST));
            all.shrink_to(self.limit.get());
        }
        all.push(Rc::downgrade(object));
    }

    /// Those that are alive.
    pub fn alive(&self) -> Vec<Rc<T>> {
        self.all.borrow().iter().filter_map(Weak::upgrade).collect()
    }

    /// Those that are alive; the list is empty then.
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
