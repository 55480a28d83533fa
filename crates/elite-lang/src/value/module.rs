//! Modules and the namespaces of globals.

use std::cell::{Cell, OnceCell, RefCell};
use std::rc::Rc;

use super::by_symbol::{SymbolMap, SymbolSet};
use super::symbol::Symbols;
use super::{CellVar, Dict, Symbol, Value};

/// Names up to which a namespace is not searched for unused ones.
const NAMES_MIN: usize = 1024;
/// Most names that are looked through at once.
const NAMES_AT_ONCE: usize = 16 << 10;

/// An imported module.
pub struct Module {
    /// The name of the module.
    pub name: Rc<str>,
    /// The attributes of the module.
    pub namespace: Rc<Namespace>,
}

/// Global variables by name. Code refers to the cells directly, so a lookup by name happens once.
#[derive(Default)]
pub struct Namespace {
    cells: RefCell<SymbolMap<Rc<CellVar>>>,
    order: RefCell<Vec<Symbol>>,
    /// Number of names from which on those leave that nothing refers to any more.
    limit: Cell<usize>,
    /// The namespace is that of an evaluated text, and of nothing else.
    is_eval_namespace: Cell<bool>,
    /// The variables are in a dictionary that a script has given to a text.
    is_in_script_dict: Cell<bool>,
    /// Names at the top level of the text are looked up in a mapping of a script first.
    uses_mapping: Cell<bool>,
    /// Where names are looked up that are not here.
    parent: Option<Rc<Namespace>>,
    /// The dictionary with the same variables that scripts have of it.
    shown: OnceCell<NamespaceDict>,
    /// What names mean that are bound nowhere, if that is not the interpreter's own builtins.
    builtins: OnceCell<Rc<Namespace>>,
}

/// A namespace as a dictionary of scripts: both have the same variables, each made in whichever is asked first.
struct NamespaceDict {
    dict: Rc<Dict>,
    symbols: Rc<Symbols>,
}

impl NamespaceDict {
    fn variable(&self, name: Symbol) -> Rc<CellVar> {
        self.dict.variable(&self.symbols.to_value(name))
    }

    fn get(&self, name: Symbol) -> Option<Value> {
        self.dict.get_str(&self.symbols.name(name))
    }
}

impl Namespace {
    /// An empty namespace in front of another one.
    pub fn child_of(parent: Rc<Namespace>) -> Self {
        Namespace {
            parent: Some(parent),
            ..Namespace::default()
        }
    }

    /// The dictionary with its variables, if it has one.
    pub fn shown(&self) -> Option<Rc<Dict>> {
        self.shown.get().map(|shown| shown.dict.clone())
    }

    /// Makes `dict` show its variables from now on; names it has are names of the namespace. Once only.
    pub fn attach_dict(&self, dict: Rc<Dict>, symbols: &Rc<Symbols>) {
        dict.hold_variables();
        for name in &*self.order.borrow() {
            if let Some(variable) = self.cells.borrow().get(name) {
                dict.enter_variable(&symbols.to_value(*name), variable.clone());
            }
        }
        let symbols = symbols.clone();
        let _ = self.shown.set(NamespaceDict { dict, symbols });
    }

    /// What unbound names mean, if that is not the interpreter's own builtins.
    pub fn builtins(&self) -> Option<&Rc<Namespace>> {
        let outer = || self.parent.as_ref()?.builtins();
        self.builtins.get().or_else(outer)
    }

    /// Says that its variables are in a dictionary that a script has given to a text.
    pub fn set_in_dictionary(&self) {
        self.is_in_script_dict.set(true);
    }

    /// Whether the global variables of the text are in a dictionary that a script has given.
    pub fn is_in_dictionary(&self) -> bool {
        let outer = || {
            self.parent
                .as_ref()
                .is_some_and(|parent| parent.is_in_dictionary())
        };
        self.is_in_script_dict.get() || outer()
    }

    /// Says that the top level of the text goes through a mapping.
    pub fn set_by_mapping(&self) {
        self.uses_mapping.set(true);
    }

    /// Whether the top level of the text goes through a mapping.
    pub fn is_by_mapping(&self) -> bool {
        self.uses_mapping.get()
    }

    /// Sets what unbound names mean, once.
    pub fn set_builtins(&self, builtins: Rc<Namespace>) {
        let _ = self.builtins.set(builtins);
    }

    /// Makes it the namespace of an evaluated text.
    pub fn set_of_text(&self) {
        self.is_eval_namespace.set(true);
    }

    /// Whether it is the namespace of an evaluated text.
    pub fn is_of_text(&self) -> bool {
        self.is_eval_namespace.get()
    }

    /// The cell of a name; if there is none yet, one is made in the namespace at the back. `Unbound` until assigned.
    pub fn cell(&self, name: Symbol) -> Rc<CellVar> {
        match &self.parent {
            Some(parent) if !self.has_name(name) => parent.cell(name),
            _ => self.own_cell(name),
        }
    }

    /// The cell that a name of this very namespace hides in the one behind it; None for other names.
    pub fn shadowed_cell(&self, name: Symbol) -> Option<Rc<CellVar>> {
        let parent = self.parent.as_ref()?;
        self.has_name(name).then(|| parent.cell(name))
    }

    /// Whether the name has been mentioned as one of this very namespace, bound or not.
    pub fn has_name(&self, name: Symbol) -> bool {
        self.cells.borrow().contains_key(&name)
            || self
                .shown
                .get()
                .is_some_and(|shown| shown.get(name).is_some())
    }

    /// Makes a name stand for an existing variable.
    pub fn bind_cell(&self, name: Symbol, cell: Rc<CellVar>) {
        if let Some(shown) = self.shown.get() {
            let name = shown.symbols.to_value(name);
            shown.dict.enter_variable(&name, cell.clone());
        }
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
        let variable = match self.shown.get() {
            Some(shown) => shown.variable(name),
            None => Rc::default(),
        };
        self.order.borrow_mut().push(name);
        self.cells.borrow_mut().insert(name, variable.clone());
        variable
    }

    /// Names that are unbound, and that no code refers to, leave whenever their number has doubled: a program that
    /// evaluates ever new texts which bind and delete ever new names does not grow. Where there are very many, a sweep
    /// finds them.
    fn forget_unused_if_many(&self) {
        let many = self.limit.get().max(NAMES_MIN);
        if (many..NAMES_AT_ONCE).contains(&self.cells.borrow().len()) {
            self.purge_unused_chunk(0, NAMES_AT_ONCE);
            self.end_forgetting();
        }
    }

    /// Takes out names that are unbound and that no code refers to, of up to `count` names from number `from` on. The
    /// number of the name to go on with; None at the end.
    pub fn purge_unused_chunk(&self, from: usize, count: usize) -> Option<usize> {
        let mut cells = self.cells.borrow_mut();
        let own = 1 + usize::from(self.shown.get().is_some());
        let mut order = self.order.borrow_mut();
        let end = order.len().min(from.saturating_add(count));
        let from = from.min(end);
        let mut kept = from;
        for at in from..end {
            let name = order[at];
            let is_unused = cells.get(&name).is_none_or(|cell| {
                Rc::strong_count(cell) <= own && cell.value.borrow().is_unbound()
            });
            if is_unused {
                // An unbound variable holds no value, so no code runs.
                cells.remove(&name);
            } else {
                order[kept] = name;
                kept += 1;
            }
        }
        order.drain(kept..end);
        (kept < order.len()).then_some(kept)
    }

    /// After all of them: when to look again.
    pub fn end_forgetting(&self) {
        if let Some(shown) = self.shown.get() {
            shown.dict.forget_unused_variables();
        }
        let mut cells = self.cells.borrow_mut();
        self.limit.set(cells.len() * 2);
        let room = cells.len() * 2;
        cells.shrink_to(room);
    }

    /// Adds up to `count` of its names to a set, from number `from` on; whether there are more.
    pub fn add_names_chunk(&self, set: &mut SymbolSet, from: usize, count: usize) -> bool {
        let order = self.order.borrow();
        set.extend(order.iter().skip(from).take(count).copied());
        order.len() > from + count
    }

    /// Appends the bound ones of up to `count` of its names to others, from number `from` on; whether there are more.
    /// Of one that is shown in a dictionary those that code has asked for only.
    pub fn some_bound_names(&self, from: usize, count: usize, out: &mut Vec<Symbol>) -> bool {
        let order = self.order.borrow();
        let end = order.len().min(from.saturating_add(count));
        let some = order.get(from..end).unwrap_or_default().iter().copied();
        out.extend(some.filter(|name| self.get(*name).is_some()));
        end < order.len()
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
        let value = match self.cells.borrow().get(&name) {
            Some(cell) => cell.value.borrow().clone(),
            None => self.shown.get()?.get(name)?,
        };
        (!value.is_unbound()).then_some(value)
    }

    /// Binds a name.
    pub fn set(&self, name: Symbol, value: Value) {
        let cell = self.cell(name);
        let old = cell.replace(value);
        drop(old);
    }

    /// All bound names with their values, in the order they first appeared.
    pub fn entries(&self) -> Vec<(Symbol, Value)> {
        if let Some(shown) = self.shown.get() {
            let entries = shown.dict.entries().into_iter();
            let named = entries.filter_map(|(_, key, value)| match key {
                Value::Str(text) => Some((shown.symbols.intern_used(text.as_str()), value)),
                _ => None,
            });
            return named.collect();
        }
        self.order
            .borrow()
            .iter()
            .filter_map(|name| self.get(*name).map(|value| (*name, value)))
            .collect()
    }

    /// Unbinds everything, to break cycles when an interpreter ends.
    pub fn dismantle(&self) {
        let cells = self.cells.take();
        for cell in cells.into_values() {
            let value = cell.take();
            drop(value);
        }
        if let Some(shown) = self.shown.get() {
            shown.dict.clear();
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
        drop(namespace.own_cell(Symbol(1)).replace(Value::Int(1)));
        for number in 2..100_000 {
            drop(namespace.own_cell(Symbol(number)).replace(Value::Int(2)));
            drop(namespace.own_cell(Symbol(number)).take());
        }
        assert!(namespace.cells.borrow().len() <= 2 * NAMES_MIN);
        assert!(Rc::ptr_eq(&kept, &namespace.own_cell(Symbol(0))));
        assert_eq!(namespace.entries().len(), 1);
        assert!(namespace.order.borrow().len() <= 2 * NAMES_MIN);
    }
}
