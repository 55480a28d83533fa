//! Names that nothing is called by any more are given up.
//!
//! Symbols are plain numbers, so nobody counts who has one. Instead the interpreter looks, whenever the names in use have
//! doubled, at everything that is called by names: code, namespaces, classes, attributes of functions. Attributes of
//! instances go by the layout of their class or by texts; who has a name only for a moment holds a `Passing`.

use std::rc::Rc;

use super::Core;
use super::code::TextNames;
use crate::value::module::Namespace;
use crate::value::symbol::SymbolSet;

impl Core {
    /// Where the names in the code of a new text are noted.
    pub fn names_of_text(&self) -> Rc<TextNames> {
        let names = Rc::default();
        self.text_names.push(&names);
        names
    }

    /// Gives up the names that nothing is called by, if there may be many. Not while something is borrowed.
    #[inline]
    pub fn sweep_names_if_due(&self) {
        if self.symbols.sweep_is_due() {
            self.sweep_names();
        }
    }

    #[cold]
    #[inline(never)]
    fn sweep_names(&self) {
        let mut used = SymbolSet::default();
        let mut namespace = |namespace: &Namespace| {
            namespace.forget_unused();
            namespace.add_names_to(&mut used);
        };
        namespace(&self.builtins);
        namespace(&self.globals);
        for module in &*self.modules.borrow() {
            namespace(&module.namespace);
        }
        for text in self.namespaces.alive() {
            namespace(&text);
        }
        for text in self.text_names.alive() {
            text.add_to(&mut used);
        }
        for function in self.named_functions.alive() {
            if let Some(attrs) = &*function.attrs.borrow() {
                used.extend(attrs.names());
            }
        }
        // Every class is derived from `object`.
        let mut seen = std::collections::HashSet::new();
        let mut left = vec![self.types.object.clone()];
        while let Some(class) = left.pop() {
            if seen.insert(Rc::as_ptr(&class)) {
                class.add_names_to(&mut used);
                left.extend(class.subclasses());
            }
        }
        self.symbols.sweep(&used);
    }
}
