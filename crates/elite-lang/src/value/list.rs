//! Lists and tuples.

use std::cell::{Cell, Ref, RefCell, RefMut};

use super::{Value, trash};
use crate::limits::memory;

/// A list. Nothing may hold a borrow of the items while it runs script code.
#[derive(Default)]
pub struct List {
    items: RefCell<Vec<Value>>,
    /// Bytes of the items that are accounted for.
    tracked: Cell<usize>,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
}

impl List {
    /// A list of these items.
    pub fn new(items: Vec<Value>) -> Self {
        let bytes = items.capacity() * size_of::<Value>();
        memory::track(bytes);
        List {
            items: RefCell::new(items),
            tracked: Cell::new(bytes),
            noted: Cell::new(false),
        }
    }

    /// Runs `each` on up to `count` items from `from` on, unless they are being changed; whether there are more.
    pub fn visit(&self, from: usize, count: usize, each: &mut dyn FnMut(&Value)) -> bool {
        let Ok(items) = self.items.try_borrow() else {
            return false;
        };
        items.iter().skip(from).take(count).for_each(each);
        items.len() > from + count
    }

    /// The items, to read.
    #[inline]
    pub fn borrow(&self) -> Ref<'_, Vec<Value>> {
        self.items.borrow()
    }

    /// The items, to change. After growing them by more than a few, call `account`.
    #[inline]
    pub fn borrow_mut(&self) -> RefMut<'_, Vec<Value>> {
        self.items.borrow_mut()
    }

    /// Number of items.
    #[inline]
    pub fn len(&self) -> usize {
        self.items.borrow().len()
    }

    /// Whether there are no items.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Item `index`.
    #[inline]
    pub fn get(&self, index: usize) -> Option<Value> {
        self.items.borrow().get(index).cloned()
    }

    /// Appends an item.
    #[inline]
    pub fn push(&self, value: Value) {
        let mut items = self.items.borrow_mut();
        let full = items.len() == items.capacity();
        items.push(value);
        if full {
            drop(items);
            self.account();
        }
    }

    /// Brings the accounting up to date with the capacity.
    pub fn account(&self) {
        let bytes = self.items.borrow().capacity() * size_of::<Value>();
        let before = self.tracked.replace(bytes);
        memory::retrack(before, bytes);
    }
}

impl Drop for List {
    fn drop(&mut self) {
        memory::release(self.tracked.get());
        trash::dismantle(self.items.get_mut());
    }
}

/// A tuple. Two or three items, the commonest numbers, are kept in the object itself.
pub struct Tuple {
    items: Items,
    /// 0: not known, or not the same for ever because items have hashes of the script's making.
    hash: Cell<u64>,
}

enum Items {
    Two([Value; 2]),
    Three([Value; 3]),
    Many(Vec<Value>),
}

impl Tuple {
    /// A tuple of these items.
    pub fn new(items: Vec<Value>) -> Self {
        Tuple::counted(Items::Many(items))
    }

    /// A tuple of two items.
    #[inline]
    pub fn of_two(items: [Value; 2]) -> Self {
        Tuple::counted(Items::Two(items))
    }

    /// A tuple of three items.
    #[inline]
    pub fn of_three(items: [Value; 3]) -> Self {
        Tuple::counted(Items::Three(items))
    }

    #[inline]
    fn counted(items: Items) -> Self {
        memory::track(items.bytes());
        Tuple {
            items,
            hash: Cell::new(0),
        }
    }

    /// The hash, if it has been noted.
    pub fn known_hash(&self) -> Option<u64> {
        Some(self.hash.get()).filter(|hash| *hash != 0)
    }

    /// Notes the hash, which no code of the script has a part in.
    pub fn note_hash(&self, hash: u64) {
        self.hash.set(hash);
    }

    /// The items.
    #[inline]
    pub fn items(&self) -> &[Value] {
        match &self.items {
            Items::Two(items) => items,
            Items::Three(items) => items,
            Items::Many(items) => items,
        }
    }
}

impl Items {
    #[inline]
    fn bytes(&self) -> usize {
        match self {
            Items::Two(items) => size_of_val(items),
            Items::Three(items) => size_of_val(items),
            Items::Many(items) => items.capacity() * size_of::<Value>(),
        }
    }
}

impl Drop for Tuple {
    fn drop(&mut self) {
        memory::release(self.items.bytes());
        match &mut self.items {
            Items::Two(items) => trash::dismantle_all(items),
            Items::Three(items) => trash::dismantle_all(items),
            Items::Many(items) => trash::dismantle(items),
        }
    }
}
