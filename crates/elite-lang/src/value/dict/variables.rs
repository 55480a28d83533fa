//! Dictionaries whose values are variables that code refers to: `globals()`, the namespaces of texts and modules.

use std::rc::Rc;

use super::Dict;
use super::table::{Entry, Found, Table};
use crate::value::{CellVar, Value};

impl Dict {
    /// Moves its values into variables, for code to refer to: it is the namespace of a text from now on. What such a
    /// dictionary has, and what the variables hold, is the same then; one that is unbound is not in it.
    pub fn hold_variables(&self) {
        self.table.change(|table| {
            if table.of_variables {
                return;
            }
            for entry in table.entries.iter_mut().filter(|e| !e.key.is_unbound()) {
                let value = std::mem::take(&mut entry.value);
                entry.value = Value::Cell(CellVar::new(value));
            }
            table.of_variables = true;
        });
    }

    /// The variable of a name in a dictionary that holds variables; made, unbound, if there is none.
    pub fn variable(&self, name: &Value) -> Rc<CellVar> {
        let Value::Str(text) = name else {
            return Rc::default();
        };
        let hash = text.hash();
        self.table.change(|table| {
            if let Found::At(index) = table.find(hash, name)
                && let Value::Cell(variable) = &table.entries[index].value
            {
                return variable.clone();
            }
            let variable: Rc<CellVar> = Rc::default();
            table.push(hash, name.clone(), Value::Cell(variable.clone()));
            variable
        })
    }

    /// Enters a variable that code refers to, in the place of one of the same name.
    pub fn enter_variable(&self, name: &Value, variable: Rc<CellVar>) {
        let Value::Str(text) = name else { return };
        let hash = text.hash();
        let old = self.table.change(|table| match table.find(hash, name) {
            Found::At(index) => {
                std::mem::replace(&mut table.entries[index].value, Value::Cell(variable))
            }
            Found::Nowhere | Found::Ask(..) => {
                table.push(hash, name.clone(), Value::Cell(variable));
                Value::Unbound
            }
        });
        drop(old);
    }

    /// All variables of a dictionary that holds them, bound or not.
    pub fn variables(&self) -> Vec<Rc<CellVar>> {
        let table = self.table.borrow();
        let entries = table.entries.iter().filter(|_| table.of_variables);
        let variable = |entry: &Entry| match &entry.value {
            Value::Cell(variable) => Some(variable.clone()),
            _ => None,
        };
        entries.filter_map(variable).collect()
    }

    /// Forgets the variables that are unbound and that nobody else refers to.
    pub fn forget_unused_variables(&self) {
        let gone = self.table.change(|table| {
            let is_unused = |entry: &Entry| match &entry.value {
                Value::Cell(variable) => {
                    Rc::strong_count(variable) == 1 && variable.value.borrow().is_unbound()
                }
                _ => false,
            };
            let unused: Vec<usize> = (0..table.entries.len())
                .filter(|index| table.of_variables && is_unused(&table.entries[*index]))
                .collect();
            let gone: Vec<_> = unused
                .iter()
                .map(|index| {
                    let entry = &mut table.entries[*index];
                    table.live -= 1;
                    (
                        std::mem::take(&mut entry.key),
                        std::mem::take(&mut entry.value),
                    )
                })
                .collect();
            if !gone.is_empty() {
                table.generation += 1;
                table.compact();
            }
            gone
        });
        drop(gone);
    }
}

/// The entries of a table of variables that are bound.
#[cold]
pub(super) fn count_bound(table: &Table) -> usize {
    let bound = table.entries.iter().filter(|entry| !table.is_absent(entry));
    bound.count()
}
