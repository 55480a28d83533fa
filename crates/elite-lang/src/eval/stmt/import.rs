//! `import` and `from … import`.

use std::rc::Rc;

use super::target::Target;
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, Flow, Frame, Located, Statement, attempt};
use crate::source::Span;
use crate::value::trash::Nodes;
use crate::value::{CellVar, R, Raised, Symbol, Value};

/// `import name as target`
pub struct Import {
    /// The module.
    pub module: Box<str>,
    /// With an alias a dotted name means its last part, otherwise its first.
    pub aliased: bool,
    /// What it is bound to.
    pub target: Box<dyn Target>,
    /// Where it is written.
    pub span: Span,
}

impl Statement for Import {
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let module = attempt!(ev.import(&self.module).at(ev, f, self.span));
        let module = match self.module.split_once('.') {
            Some((first, _)) if !self.aliased => attempt!(ev.import(first).at(ev, f, self.span)),
            _ => module,
        };
        self.target.assign(ev, f, module).into()
    }
}

/// A name, what it is bound to, and where it is written.
pub type ImportedName = (Symbol, Box<dyn Target>, Span);

/// `from module import name as target, …`
pub struct ImportFrom {
    /// The module.
    pub module: Box<str>,
    /// The names with their targets.
    pub names: Nodes<ImportedName>,
    /// Where it is written.
    pub span: Span,
}

impl Statement for ImportFrom {
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let module = attempt!(ev.import(&self.module).at(ev, f, self.span));
        for (name, target, span) in &self.names {
            let value = attempt!(self.name(ev, &module, *name).at(ev, f, *span));
            attempt!(target.assign(ev, f, value));
        }
        Flow::Next
    }
}

impl ImportFrom {
    fn name(&self, ev: &Evaluator<'_>, module: &Value, name: Symbol) -> R {
        match ev.attribute_or_none(module, name)? {
            Some(value) => Ok(value),
            None => {
                let value_of_module = match module {
                    Value::Module(module) => Some(module),
                    _ => None,
                };
                let (name, module) = (ev.core.symbols.name(name), &self.module);
                let hint = match value_of_module {
                    Some(module) => {
                        let entries = module.namespace.entries();
                        let names = entries.iter().map(|(name, _)| ev.core.symbols.name(*name));
                        suggestion(&name, names.filter(|name| !name.starts_with('_')))
                    }
                    None => String::new(),
                };
                let text =
                    format!("cannot import name '{name}' from '{module}' (unknown location){hint}");
                Err(ev.raise(ExceptionKind::ImportError, text))
            }
        }
    }
}

/// `from module import *`, at the top level.
pub struct ImportStar {
    /// The module.
    pub module: Box<str>,
    /// Makes the global of a name.
    pub global: Rc<dyn Fn(Symbol) -> Rc<CellVar>>,
    /// Where it is written.
    pub span: Span,
}

impl Statement for ImportStar {
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let module = attempt!(ev.import(&self.module).at(ev, f, self.span));
        if let Value::Module(module) = module {
            let listed = module.namespace.get(ev.core.symbols.intern("__all__"));
            let names = match listed {
                Some(names) => Some(attempt!(ev.collect(&names))),
                None => None,
            };
            for (name, value) in module.namespace.entries() {
                let is_public = match &names {
                    Some(names) => names
                        .iter()
                        .any(|listed| listed.as_str() == Some(&*ev.core.symbols.name(name))),
                    None => !ev.core.symbols.name(name).starts_with('_'),
                };
                if is_public {
                    drop((self.global)(name).value.replace(value));
                }
            }
        }
        Flow::Next
    }
}

/// What to add to a message about an unknown name.
fn suggestion(name: &str, names: impl Iterator<Item = impl AsRef<str>>) -> String {
    match crate::spelling::nearest(name, names) {
        Some(near) => format!("; did you mean '{near}'?"),
        None => String::new(),
    }
}

impl Evaluator<'_> {
    /// The module of this name.
    pub fn import(&self, name: &str) -> R {
        // Of dotted names the part that exists is looked for first, as in Python.
        for (end, _) in name.match_indices('.') {
            self.import_one(&name[..end])?;
        }
        self.import_one(name)
    }

    /// The module of this name, whose packages have been found.
    fn import_one(&self, name: &str) -> R {
        let known = self
            .core
            .modules
            .borrow()
            .iter()
            .find(|module| &*module.name == name)
            .cloned();
        if let Some(module) = known {
            return Ok(Value::Module(module));
        }
        match crate::stdlib::load(self, name)? {
            Some(module) => Ok(Value::Module(module)),
            None => {
                let text = match name.rsplit_once('.') {
                    Some((package, _)) => {
                        format!("No module named '{name}'; '{package}' is not a package")
                    }
                    None => {
                        let hint = suggestion(name, crate::stdlib::module_names());
                        format!("No module named '{name}'{hint}")
                    }
                };
                let raised = self.raise(ExceptionKind::ModuleNotFoundError, text);
                if let Raised::Exception(exception) = &raised
                    && let Some(state) = exception.exception()
                {
                    let names: Vec<&str> = crate::stdlib::module_names().collect();
                    let help = format!("there are the modules {}", names.join(", "));
                    *state.help.borrow_mut() = Some(help.into());
                }
                Err(raised)
            }
        }
    }
}
