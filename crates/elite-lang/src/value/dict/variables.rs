//! Dictionaries some of whose values are variables that code refers to: `globals()`, the namespaces of texts and
//! modules.
//!
//! A value becomes a variable when code asks for its name, so that a big dictionary can be such a namespace at once.
//! What the dictionary has, and what its variables hold, is the same; one that is unbound is not in it.

use std::cell::Cell;
use std::rc::{Rc, Weak};

use super::Dict;
use super::table::{DictTable, KeySearch};
use crate::value::{CellVar, Value, bindings};

/// What a dictionary knows of its variables.
#[derive(Default)]
pub(super) struct VariableIndex {
    /// All variables; some may be gone.
    known: Vec<Weak<CellVar>>,
    /// With this number of bindings so many of them were unbound.
    unbound: Cell<Option<(u64, usize)>>,
}

impl VariableIndex {
    fn enter(&mut self, variable: &Rc<CellVar>) {
        if self.known.len() == self.known.capacity() {
            self.forget_gone();
        }
        self.known.push(Rc::downgrade(variable));
        self.unbound.set(None);
    }

    fn leave(&mut self, variable: &Rc<CellVar>) {
        let address = Rc::as_ptr(variable);
        self.known.retain(|known| known.as_ptr() != address);
        self.unbound.set(None);
    }

    fn forget_gone(&mut self) {
        self.known.retain(|known| known.strong_count() > 0);
        self.unbound.set(None);
    }

    fn alive_cells(&self) -> impl Iterator<Item = Rc<CellVar>> {
        self.known.iter().filter_map(Weak::upgrade)
    }

    fn count_unbound(&self) -> usize {
        let now = bindings();
        if let Some((then, unbound)) = self.unbound.get()
            && then == now
        {
            return unbound;
        }
        let is_unbound = |variable: &Rc<CellVar>| variable.value.borrow().is_unbound();
        let unbound = self.alive_cells().filter(is_unbound).count();
        self.unbound.set(Some((now, unbound)));
        unbound
    }
}

impl Dict {
    /// Makes it the namespace of a text, for code to refer to its values, from now on.
    pub fn hold_variables(&self) {
        self.table.with_mut(|table| {
            if table.of_variables() {
                return;
            }
            let mut variables = Box::<VariableIndex>::default();
            for entry in &mut table.entries {
                // A cell that scripts see (`__closure__`) is a value like others.
                if let Value::Cell(_) = &entry.value {
                    let variable = CellVar::new(std::mem::take(&mut entry.value));
                    variables.enter(&variable);
                    entry.value = Value::Cell(variable);
                }
            }
            table.variables = Some(variables);
        });
    }

    /// The variable of a name in a dictionary that holds variables; made, unbound, if there is none.
    pub fn variable(&self, name: &Value) -> Rc<CellVar> {
        let Value::Str(text) = name else {
            return Rc::default();
        };
        let hash = text.hash();
        self.table.with_mut(|table| {
            let KeySearch::At(index) = table.find(hash, name) else {
                let variable: Rc<CellVar> = Rc::default();
                table.enter(&variable);
                table.push(hash, name.clone(), Value::Cell(variable.clone()));
                return variable;
            };
            if let Value::Cell(variable) = &table.entries[index].value {
                return variable.clone();
            }
            let variable = CellVar::new(std::mem::take(&mut table.entries[index].value));
            table.enter(&variable);
            table.entries[index].value = Value::Cell(variable.clone());
            variable
        })
    }

    /// Enters a variable that code refers to, in the place of a value of the same name.
    pub fn enter_variable(&self, name: &Value, variable: Rc<CellVar>) {
        let Value::Str(text) = name else { return };
        let hash = text.hash();
        let old = self.table.with_mut(|table| match table.find(hash, name) {
            KeySearch::At(index) => {
                let entered = Value::Cell(variable.clone());
                let old = std::mem::replace(&mut table.entries[index].value, entered);
                if let (Value::Cell(old), Some(variables)) = (&old, &mut table.variables) {
                    variables.leave(old);
                }
                table.enter(&variable);
                old
            }
            KeySearch::Nowhere | KeySearch::Ask(..) => {
                table.enter(&variable);
                table.push(hash, name.clone(), Value::Cell(variable));
                Value::Unbound
            }
        });
        drop(old);
    }

    /// All its variables, bound or not.
    pub fn variables(&self) -> Vec<Rc<CellVar>> {
        let table = self.table.borrow();
        let variables = table.variables.as_deref();
        variables.map_or_else(Vec::new, |variables| variables.alive_cells().collect())
    }

    /// Forgets the variables that are unbound and that nobody else refers to.
    pub fn forget_unused_variables(&self) {
        let is_unused = |variable: &Rc<CellVar>, references| {
            Rc::strong_count(variable) == references && variable.value.borrow().is_unbound()
        };
        // Each is held here, too.
        if !self.variables().iter().any(|known| is_unused(known, 2)) {
            return;
        }
        let gone = self.table.with_mut(|table| {
            let mut gone = Vec::new();
            for entry in &mut table.entries {
                if let Value::Cell(variable) = &entry.value
                    && is_unused(variable, 1)
                {
                    gone.push(std::mem::take(entry));
                }
            }
            table.live -= gone.len();
            table.generation += 1;
            table.compact();
            gone
        });
        drop(gone);
        self.table.with_mut(|table| {
            if let Some(variables) = &mut table.variables {
                variables.forget_gone();
            }
        });
    }

    /// Removes everything; variables that code refers to are unbound.
    pub(super) fn clear_variables(&self) {
        let variables = self.variables();
        let entries = self.table.with_mut(|table| {
            let mut entries = std::mem::take(&mut table.entries);
            if !variables.is_empty() {
                let kept = entries.iter_mut();
                let kept = kept.filter(|entry| matches!(entry.value, Value::Cell(_)));
                table.entries = kept.map(std::mem::take).collect();
            }
            table.live = table.entries.len();
            table.generation += 1;
            table.compact();
            entries
        });
        super::drop_entries(entries);
        for variable in variables {
            drop(variable.take());
        }
    }
}

impl DictTable {
    fn enter(&mut self, variable: &Rc<CellVar>) {
        if let Some(variables) = &mut self.variables {
            variables.enter(variable);
        }
    }

    fn new_variable(&mut self, value: Value) -> Value {
        let variable = CellVar::new(value);
        self.enter(&variable);
        Value::Cell(variable)
    }

    /// How many of its variables are unbound, if that is known.
    pub(super) fn known_unbound(&self) -> Option<usize> {
        let (then, unbound) = self.variables.as_deref()?.unbound.get()?;
        (then == bindings()).then_some(unbound)
    }

    /// Notes how many are unbound now, if that is known.
    pub(super) fn note_unbound(&self, unbound: Option<usize>) {
        if let Some(variables) = &self.variables {
            let now = bindings();
            variables.unbound.set(unbound.map(|unbound| (now, unbound)));
        }
    }

    /// Adds a key; the variable is the one that code refers to already, if there is one.
    #[cold]
    #[inline(never)]
    pub(super) fn append_variable(&mut self, hash: u64, key: Value, value: Value) {
        let known = match self.find(hash, &key) {
            KeySearch::At(index) => self.delete(index).1,
            KeySearch::Nowhere | KeySearch::Ask(..) => Value::Unbound,
        };
        let entered = match (known, value) {
            (Value::Cell(variable), value) => {
                // The variable was unbound, so one unbound variable less is left.
                let unbound = self.known_unbound();
                drop(variable.replace(value));
                self.note_unbound(unbound.map(|count| count.saturating_sub(1)));
                Value::Cell(variable)
            }
            (_, value @ Value::Cell(_)) => self.new_variable(value),
            (_, value) => value,
        };
        self.push(hash, key, entered);
    }

    /// Puts another value in the place of one, which is given back.
    #[cold]
    #[inline(never)]
    pub(super) fn set_variable(&mut self, index: usize, value: Value) -> Value {
        if let Value::Cell(variable) = &self.entries[index].value {
            return variable.replace(value);
        }
        let entered = match value {
            Value::Cell(_) => self.new_variable(value),
            value => value,
        };
        std::mem::replace(&mut self.entries[index].value, entered)
    }

    /// Number of entries that are bound.
    #[cold]
    #[inline(never)]
    pub(super) fn count_bound(&self) -> usize {
        let unbound = self
            .variables
            .as_deref()
            .map_or(0, VariableIndex::count_unbound);
        self.live.saturating_sub(unbound)
    }
}
