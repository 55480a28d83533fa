//! Names that nothing is called by any more are given up.
//!
//! Symbols are plain numbers, so nobody counts who has one. Instead the interpreter looks, whenever the names in use
//! have doubled, at everything that is called by names: code, namespaces, classes, attributes of functions. Attributes
//! of instances go by the layout of their class or by texts; who has a name only for a moment holds a `TempSymbol`.

use std::cell::Cell;
use std::rc::Rc;

use crate::eval::code::SourceSymbols;
use crate::eval::{Evaluator, InterpreterState};
use crate::limits::chunked::WORK_PER_BYTE;
use crate::value::by_symbol::SymbolSet;
use crate::value::module::Namespace;
use crate::value::symbol::TempSymbol;
use crate::value::{Function, R, Symbol};

/// Names that are looked at at once, and the work for one.
const SWEEP_CHUNK: usize = 1024;
const WORK_PER_SYMBOL: usize = 48;
/// Longest name of an attribute, a keyword argument or a class that is made up at run time, in bytes.
pub const LENGTH_MAX: usize = 64 << 10;
/// Names up to this length, in bytes, are not counted as work of their own.
const UNCHARGED_NAME_MAX: usize = 256;
/// Work for a class.
const WORK_PER_CLASS: usize = 512;

impl InterpreterState {
    /// Where the names in the code of a new text are noted.
    pub fn names_of_text(&self) -> Rc<SourceSymbols> {
        let names = Rc::default();
        self.text_names.push(&names);
        names
    }
}

/// No name is given up while this lives, also when the thread is dropped meanwhile.
pub struct SweepPause<'c>(&'c Cell<u32>);

impl Drop for SweepPause<'_> {
    fn drop(&mut self) {
        self.0.set(self.0.get() - 1);
    }
}

impl Evaluator<'_> {
    /// The symbol for a name that a program has made up, to look for what is called by it.
    pub fn temp_symbol(&self, name: &str) -> R<TempSymbol<'_>> {
        self.check_name(name)?;
        Ok(self.core.symbols.intern_temp(name))
    }

    /// The symbol for a name that a program has made up, to call something by it.
    pub fn intern_name(&self, name: &str) -> R<Symbol> {
        self.check_name(name)?;
        Ok(self.core.symbols.intern_used(name))
    }

    /// Refuses a name that is too long to be one: names are looked up, kept and repeated in messages without a pause.
    pub fn check_name(&self, name: &str) -> R<()> {
        if name.len() > LENGTH_MAX {
            return Err(self.value_error(format!(
                "a name of {} bytes, {LENGTH_MAX} are allowed",
                name.len()
            )));
        }
        match name.len() {
            0..UNCHARGED_NAME_MAX => Ok(()),
            long => self.charge(long * WORK_PER_BYTE),
        }
    }

    /// Keeps all names as long as the result lives: for who has taken some that nothing is called by yet.
    pub fn pause_sweep(&self) -> SweepPause<'_> {
        let held = &self.core.sweep_pauses;
        held.set(held.get() + 1);
        SweepPause(held)
    }

    /// Gives up the names that nothing is called by, if there may be many. Not while something is borrowed: others have
    /// their turn meanwhile. What comes into use then has been settled, which the last step of the sweep respects.
    #[inline]
    pub fn sweep_names_if_due(&self) -> R<()> {
        match self.core.symbols.sweep_is_due() {
            true => self.sweep_names(),
            false => Ok(()),
        }
    }

    #[cold]
    #[inline(never)]
    fn sweep_names(&self) -> R<()> {
        /// The end of a sweep, also when the thread is dropped in the midst of it.
        struct SweepGuard<'c>(&'c InterpreterState);
        impl Drop for SweepGuard<'_> {
            fn drop(&mut self) {
                self.0.sweeping.set(false);
            }
        }
        if self.core.sweep_pauses.get() > 0 || self.core.sweeping.replace(true) {
            return Ok(());
        }
        let _over = SweepGuard(&self.core);
        self.sweep_all()
    }

    /// Goes through something in pieces: `some` does one from a number on and says whether there is more.
    fn in_chunks(&self, mut some: impl FnMut(usize) -> bool) -> R<()> {
        let mut from = 0;
        while some(from) {
            from += SWEEP_CHUNK;
            self.charge(SWEEP_CHUNK * WORK_PER_SYMBOL)?;
        }
        self.charge(WORK_PER_SYMBOL)
    }

    fn forget_unused(&self, namespace: &Namespace) -> R<()> {
        let mut next = Some(0);
        while let Some(from) = next {
            next = namespace.purge_unused_chunk(from, SWEEP_CHUNK);
            self.charge(SWEEP_CHUNK * WORK_PER_SYMBOL)?;
        }
        namespace.end_forgetting();
        Ok(())
    }

    fn sweep_all(&self) -> R<()> {
        let core = &self.core;
        let mut used = SymbolSet::default();
        let modules = core.modules.borrow().clone();
        let modules = modules.iter().map(|module| module.namespace.clone());
        let namespaces: Vec<Rc<Namespace>> = modules
            .chain(core.namespaces.alive())
            .chain([core.globals.clone()])
            .collect();
        let builtins = &core.builtins;
        self.forget_unused(builtins)?;
        self.in_chunks(|from| builtins.add_names_chunk(&mut used, from, SWEEP_CHUNK))?;
        for namespace in namespaces {
            self.forget_unused(&namespace)?;
            self.in_chunks(|from| namespace.add_names_chunk(&mut used, from, SWEEP_CHUNK))?;
        }
        let texts: Vec<Rc<SourceSymbols>> = core.text_names.alive().into_iter().collect();
        for text in texts {
            self.in_chunks(|from| text.add_some_to(&mut used, from, SWEEP_CHUNK))?;
        }
        let functions: Vec<Rc<Function>> = core.functions_with_attrs.alive().into_iter().collect();
        for function in functions {
            self.in_chunks(|from| {
                let attrs = function.attrs.borrow();
                let names = attrs.as_ref().map_or(&[][..], |attrs| attrs.names());
                let end = names.len().min(from + SWEEP_CHUNK);
                used.extend(names.get(from..end).unwrap_or_default().iter().copied());
                end < names.len()
            })?;
        }
        // Every class is derived from `object`.
        let mut seen = std::collections::HashSet::new();
        let mut left = vec![core.types.object.clone()];
        while let Some(class) = left.pop() {
            if seen.insert(Rc::as_ptr(&class)) {
                self.in_chunks(|from| class.add_some_names_to(&mut used, from, SWEEP_CHUNK))?;
                let mut before = usize::MAX;
                while before > 0 {
                    before = class.some_subclasses(before, SWEEP_CHUNK, &mut left);
                    self.charge(WORK_PER_CLASS)?;
                }
            }
            self.charge(WORK_PER_CLASS)?;
        }
        let symbols = &core.symbols;
        symbols.begin_sweep();
        self.in_chunks(|from| symbols.sweep_some(&used, from, SWEEP_CHUNK))?;
        symbols.end_sweep();
        Ok(())
    }
}
