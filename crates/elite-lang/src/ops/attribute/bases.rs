//! `class.__bases__ = bases`: what may be assigned, and the new resolution order of the class and of all below it.

use std::rc::Rc;

use crate::eval::Evaluator;
use crate::eval::stmt::define::{is_final, linearise};
use crate::value::{Class, R, Value};

impl Evaluator<'_> {
    /// Gives a class of a script other bases. Nothing is changed unless all classes below it have an order then.
    pub(super) fn set_bases(&self, class: &Rc<Class>, new: &Value) -> R<()> {
        let name = class.name();
        let Value::Tuple(bases) = self.unwrap_builtin(new) else {
            let found = self.core.types.name_of(new);
            return Err(self.type_error(format!(
                "can only assign tuple to {name}.__bases__, not {found}"
            )));
        };
        if bases.items().is_empty() {
            return Err(self.type_error(format!(
                "can only assign non-empty tuple to {name}.__bases__, not ()"
            )));
        }
        let mut parents: Vec<Rc<Class>> = Vec::new();
        for base in bases.items() {
            let Value::Class(base) = base else {
                let found = self.core.types.name_of(base);
                return Err(self.type_error(format!(
                    "{name}.__bases__ must be tuple of classes, not '{found}'"
                )));
            };
            if base.is_subclass_of(class) {
                return Err(self.type_error("a __bases__ item causes an inheritance cycle"));
            }
            parents.push(base.clone());
        }
        for base in &parents {
            if is_final(base) {
                let base = base.type_name();
                return Err(
                    self.type_error(format!("type '{base}' is not an acceptable base type"))
                );
            }
        }
        self.check_layout(class, &parents)?;
        for (index, base) in parents.iter().enumerate() {
            if parents[..index].iter().any(|other| Rc::ptr_eq(other, base)) {
                return Err(self.type_error(format!("duplicate base class {}", base.name())));
            }
        }
        let old = class.bases();
        class.set_bases(parents);
        let mut orders = Vec::new();
        if let Err(names) = reorder(class, &mut orders) {
            for (class, before) in orders.into_iter().rev() {
                class.set_ancestors(before.to_vec());
            }
            class.set_bases(old.to_vec());
            let text = "Cannot create a consistent method resolution\norder (MRO) for bases";
            return Err(self.type_error(format!("{text} {}", names.join(", "))));
        }
        Ok(())
    }

    /// Instances there are must fit the new bases.
    fn check_layout(&self, class: &Rc<Class>, parents: &[Rc<Class>]) -> R<()> {
        let best = |parents: &[Rc<Class>]| -> Rc<Class> {
            let with_layout = parents.iter().find(|parent| parent.base == class.base);
            with_layout.unwrap_or(&parents[0]).clone()
        };
        let base = self.layout_base(parents)?;
        let (old, new) = (
            best(&class.bases()),
            match base == class.base {
                true => best(parents),
                false => parents
                    .iter()
                    .find(|parent| parent.base == base)
                    .unwrap_or(&parents[0])
                    .clone(),
            },
        );
        let kind = if base != class.base || old.is_script != new.is_script {
            "deallocator"
        } else if !old.has_layout_of(&new) {
            "object layout"
        } else {
            return Ok(());
        };
        let (old, new) = (old.name(), new.name());
        Err(self.type_error(format!(
            "__bases__ assignment: '{new}' {kind} differs from '{old}'"
        )))
    }
}

/// The orders that classes had before.
type SavedMros = Vec<(Rc<Class>, Rc<[Rc<Class>]>)>;

/// Finds the orders of a class and of those below it anew, and notes the ones before.
fn reorder(class: &Rc<Class>, before: &mut SavedMros) -> Result<(), Vec<Rc<str>>> {
    let mut left = vec![class.clone()];
    while let Some(class) = left.pop() {
        let order = linearise(&class.bases())?;
        before.push((class.clone(), class.mro_tail()));
        class.set_ancestors(order);
        left.extend(class.subclasses());
    }
    Ok(())
}
