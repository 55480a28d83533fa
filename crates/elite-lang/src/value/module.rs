//! Modules and the namespaces of globals.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::symbol::{SymbolMap, SymbolSet};
use super::{CellVar, Symbol, Value};

/// Names up to which a namespace is not searched for unused ones.
const NAMES_MIN: usize = 1024;

/// An imported module.
pub struct Module {
    /// Its name.
    pub name: Rc<str>,
    /// Its attributes.
    pub namespace: Rc<Namespace>,
}

/// Global variables by name. Code refers to the cells directly, so a lookup by name happens once.
#[derive(Default)]
pub struct Namespace {
    cells: RefCell<SymbolMap<Rc<CellVar>>>,
    order: RefCell<Vec<Symbol>>,
    /// With so many names those that nothing refers to any more leave.
    limit: Cell<usize>,
    /// It is that of an evaluated text, and of nothing else.
    of_text: Cell<bool>,
    /// Where names are looked up that are not here.
    parent: Option<Rc<Namespace>>,
}

impl Namespace {
    /// An empty namespace in front of another one.
    pub fn in_front_of(parent: Rc<Namespace>) -> Self {
        Namespace {
            parent: Some(parent),
            ..Namespace::default()
        }
    }

    /// Makes it the namespace of an evaluated text.
    pub fn set_of_text(&self) {
        self.of_text.set(true);
    }

    /// Whether it is the namespace of an evaluated text.
    pub fn is_of_text(&self) -> bool {
        self.of_text.get()
    }

    /// The cell of a name; if there is none yet, one is made in the namespace at the back. `Unbound` until assigned.
    pub fn cell(&self, name: Symbol) -> Rc<CellVar> {
        match &self.parent {
            Some(parent) if !self.cells.borrow().contains_key(&name) => parent.cell(name),
            _ => self.own_cell(name),
        }
    }

    /// The cell that a name of this very namespace hides in the one behind it; None for other names.
    pub fn behind(&self, name: Symbol) -> Option<Rc<CellVar>> {
        let parent = self.parent.as_ref()?;
        let hides = self.cells.borrow().contains_key(&name);
        hides.then(|| parent.cell(name))
    }

    /// Whether the name has been mentioned as one of this very namespace, bound or not.
    pub fn mentions(&self, name: Symbol) -> bool {
        self.cells.borrow().contains_key(&name)
    }

    /// Makes a name stand for an existing variable.
    pub fn share(&self, name: Symbol, cell: Rc<CellVar>) {
        if self.cells.borrow_mut().insert(name, cell).is_none() {
            self.order.borrow_mut().push(name);
        }
    }

    /// The cell of a name in this very namespace, made if need be.
    pub fn own_cell(&self, name: Symbol) -> Rc<CellVar> {
        if let Some(cell) = self.cells.borrow().get(&name) {
            return cell.clone();
        }
        self.forget_unused_if_many();
        self.order.borrow_mut().push(name);
        self.cells.borrow_mut().entry(name).or_default().clone()
    }

    /// Names that are unbound, and that no code refers to, leave whenever their number has doubled: a program that evaluates
    /// ever new texts which bind and delete ever new names does not grow.
    fn forget_unused_if_many(&self) {
        if self.cells.borrow().len() >= self.limit.get().max(NAMES_MIN) {
            self.forget_unused();
        }
    }

    /// Names that are unbound, and that no code refers to, leave.
    pub fn forget_unused(&self) {
        let mut cells = self.cells.borrow_mut();
        // Only unbound ones are dropped, so no code runs.
        cells.retain(|_, cell| Rc::strong_count(cell) > 1 || !cell.value.borrow().is_unbound());
        let mut order = self.order.borrow_mut();
        order.retain(|name| cells.contains_key(name));
        self.limit.set(cells.len() * 2);
        cells.shrink_to(self.limit.get());
    }

    /// Adds up to `count` of its names to a set, from number `from` on; whether there are more.
    pub fn add_some_names_to(&self, set: &mut SymbolSet, from: usize, count: usize) -> bool {
        let order = self.order.borrow();
        set.extend(order.iter().skip(from).take(count));
        order.len() > from + count
    }

    /// The cells of all names of this very namespace.
    pub fn own_cells(&self) -> Vec<Rc<CellVar>> {
        self.cells.borrow().values().cloned().collect()
    }

    /// The cell of a name of this very namespace, if it is bound.
    pub fn bound_cell(&self, name: Symbol) -> Option<Rc<CellVar>> {
        let cell = self.cells.borrow().get(&name)?.clone();
        let bound = !cell.value.borrow().is_unbound();
        bound.then_some(cell)
    }

    /// The value of a name, if it is bound.
    pub fn get(&self, name: Symbol) -> Option<Value> {
        let value = self.cells.borrow().get(&name)?.value.borrow().clone();
        (!value.is_unbound()).then_some(value)
    }

    /// Binds a name.
    pub fn set(&self, name: Symbol, value: Value) {
        let cell = self.cell(name);
        let old = cell.value.replace(value);
        drop(old);
    }

    /// All bound names with their values, in the order they first appeared.
    pub fn entries(&self) -> Vec<(Symbol, Value)> {
        self.order
            .borrow()
            .iter()
            .filter_map(|name| self.get(*name).map(|value| (*name, value)))
            .collect()
    }

    /// Unbinds everything, to break cycles when an interpreter ends.
    pub fn dismantle(&self) {
        let cells: Vec<Rc<CellVar>> = self
            .cells
            .borrow_mut()
            .drain()
            .map(|(_, cell)| cell)
            .collect();
        for cell in cells {
            let value = cell.value.take();
            drop(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_neither_bound_nor_used_leave() {
        let namespace = Namespace::default();
        let kept = namespace.own_cell(Symbol(0));
        namespace.own_cell(Symbol(1)).value.put(Value::Int(1));
        for number in 2..100_000 {
            namespace.own_cell(Symbol(number)).value.put(Value::Int(2));
            namespace.own_cell(Symbol(number)).value.put(Value::Unbound);
        }
        assert!(namespace.cells.borrow().len() <= 2 * NAMES_MIN);
        assert!(Rc::ptr_eq(&kept, &namespace.own_cell(Symbol(0))));
        assert_eq!(namespace.entries().len(), 1);
        assert!(namespace.order.borrow().len() <= 2 * NAMES_MIN);
    }
}
