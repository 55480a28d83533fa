//! `import` and `from … import`.

use std::rc::Rc;

use elite_syntax::Span;
use messages::{Text, text};

use super::target::Target;
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, Flow, Frame, StmtNode, TraceExt, attempt};
use crate::limits::deferred_drop::NodeList;
use crate::ops::dict::WORK_PER_NAME;
use crate::value::by_symbol::SymbolSet;
use crate::value::module::Namespace;
use crate::value::symbol::known;
use crate::value::{CellVar, R, Symbol, Unwind, Value, ValueVec};

/// `import name as target`
pub struct Import {
    /// The module.
    pub module: Box<str>,
    /// With an alias a dotted name means its last part, otherwise its first.
    pub aliased: bool,
    /// The variable that the module is bound to.
    pub target: Box<dyn Target>,
    /// The place in the text.
    pub span: Span,
}

impl StmtNode for Import {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let module = attempt!(ev.import(&self.module).trace_at(ev, f, self.span));
        let module = match self.module.split_once('.') {
            Some((first, _)) if !self.aliased => {
                attempt!(ev.import(first).trace_at(ev, f, self.span))
            }
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
    pub names: NodeList<ImportedName>,
    /// The place in the text.
    pub span: Span,
}

impl StmtNode for ImportFrom {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let module = attempt!(ev.import(&self.module).trace_at(ev, f, self.span));
        for (name, target, span) in &self.names {
            let value = attempt!(self.name(ev, &module, *name).trace_at(ev, f, *span));
            attempt!(target.assign(ev, f, value));
        }
        Flow::Next
    }
}

impl ImportFrom {
    fn name(&self, ev: &Evaluator<'_>, module: &Value, name: Symbol) -> R {
        if let Some(value) = ev.attribute_or_none(module, name)? {
            return Ok(value);
        }
        let text = ev.core.symbols.name(name);
        // What is only in the table of modules is part of its package, too.
        let within = format!("{}.{text}", self.module);
        if let Some(found) = ev.core.module_table.get_str(&within) {
            return Ok(found);
        }
        let hint = match module {
            Value::Module(module) => {
                let entries = module.namespace.entries();
                let names = entries.iter().map(|(name, _)| ev.core.symbols.name(*name));
                suggestion(&text, names.filter(|name| !name.starts_with('_')))
            }
            _ => None,
        };
        let message = format!(
            "cannot import name '{text}' from '{}' (unknown location)",
            self.module
        );
        Err(ev.import_error(
            ExceptionKind::ImportError,
            message,
            Some(&self.module),
            hint,
        ))
    }
}

/// `from module import *`, at the top level.
pub struct ImportStar {
    /// The module.
    pub module: Box<str>,
    /// Makes the global of a name.
    pub global: Rc<dyn Fn(Symbol) -> Rc<CellVar>>,
    /// The place in the text.
    pub span: Span,
}

impl StmtNode for ImportStar {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let module = attempt!(ev.import(&self.module).trace_at(ev, f, self.span));
        let Value::Module(module) = module else {
            let names = attempt!(star_names(ev, &module));
            for name in names {
                let value = attempt!(ev.attribute(&module, name));
                drop((self.global)(name).replace(value));
            }
            return Flow::Next;
        };
        for name in attempt!(public_names(ev, &module.namespace)) {
            attempt!(ev.charge(WORK_PER_NAME));
            if let Some(value) = module.namespace.get(name) {
                drop((self.global)(name).replace(value));
            }
        }
        Flow::Next
    }
}

/// The names that `import *` takes from a module.
fn public_names(ev: &Evaluator<'_>, namespace: &Namespace) -> R<Vec<Symbol>> {
    let mut names = ev.bound_names(namespace)?;
    let listed = namespace.get(ev.core.symbols.intern("__all__"));
    let listed = listed.map(|listed| ev.collect(&listed)).transpose()?;
    let all = match &listed {
        Some(listed) => {
            let mut all = SymbolSet::default();
            for text in listed.iter().filter_map(Value::as_str) {
                all.extend(ev.core.symbols.find(text));
                ev.charge(WORK_PER_NAME)?;
            }
            Some(all)
        }
        None => None,
    };
    let mut kept = 0;
    for at in 0..names.len() {
        let name = names[at];
        let is_public = match &all {
            Some(all) => all.contains(&name),
            None => !ev.core.symbols.name(name).starts_with('_'),
        };
        names[kept] = name;
        kept += usize::from(is_public);
        ev.charge(WORK_PER_NAME)?;
    }
    names.truncate(kept);
    Ok(names)
}

/// The names that `import *` takes from an object that stands in `sys.modules` for a module.
fn star_names(ev: &Evaluator<'_>, module: &Value) -> R<Vec<Symbol>> {
    let all = ev.core.symbols.intern("__all__");
    let (names, is_listed) = match ev.attribute_or_none(module, all)? {
        Some(names) => (ev.collect(&names)?, true),
        None => match ev.attribute_or_none(module, known::DICT)? {
            Some(names) => (ev.collect(&names)?, false),
            None => (ValueVec::default(), false),
        },
    };
    let names = names.iter().filter_map(Value::as_str);
    let public = names.filter(|name| is_listed || !name.starts_with('_'));
    Ok(public
        .map(|name| ev.core.symbols.intern_used(name))
        .collect())
}

/// What to say beside a message about an unknown name.
fn suggestion(name: &str, names: impl Iterator<Item = impl AsRef<str>>) -> Option<Text> {
    let near = elite_syntax::nearest(name, names)?;
    Some(text!("did you mean '{near}'?", "是否想写 '{near}'？"))
}

impl Evaluator<'_> {
    /// The module of this name; what a script has put into `sys.modules` counts.
    pub fn import(&self, name: &str) -> R {
        if name.is_empty() {
            return Err(self.value_error("Empty module name"));
        }
        if name.starts_with('.') {
            let text = "attempted relative import with no known parent package";
            return Err(self.import_error(ExceptionKind::ImportError, text.into(), None, None));
        }
        // The part of a dotted name that exists is looked for first, as in Python.
        for (end, _) in name.match_indices('.') {
            self.import_one(&name[..end])?;
        }
        self.import_one(name)
    }

    /// The module of this name, whose packages have been found.
    pub fn import_one(&self, name: &str) -> R {
        match self.core.module_table.get_str(name) {
            Some(Value::None) => {
                let text = format!("import of {name} halted; None in sys.modules");
                return Err(self.not_found(text, name, None));
            }
            Some(module) => return Ok(module),
            None => {}
        }
        if name.starts_with('_')
            && let Some(module) = self.inner_module(name)
        {
            return Ok(Value::Module(module));
        }
        if let Some(module) = crate::stdlib::load(self, name)? {
            return Ok(Value::Module(module));
        }
        let Some((package, _)) = name.rsplit_once('.') else {
            let hint = suggestion(name, elite_syntax::python_names::module_names());
            let names: Vec<&str> = elite_syntax::python_names::module_names().collect();
            let help = hint.unwrap_or_else(|| {
                text!(
                    "programs can import {}",
                    "程序可以导入 {}",
                    names.join(", ")
                )
            });
            return Err(self.not_found(format!("No module named '{name}'"), name, Some(help)));
        };
        let text = match crate::stdlib::is_package(package) {
            true => format!("No module named '{name}'"),
            false => format!("No module named '{name}'; '{package}' is not a package"),
        };
        Err(self.not_found(text, name, None))
    }

    fn inner_module(&self, name: &str) -> Option<Rc<crate::value::Module>> {
        let modules = self.core.modules.borrow();
        modules.iter().find(|module| &*module.name == name).cloned()
    }

    fn not_found(&self, text: String, name: &str, help: Option<Text>) -> Unwind {
        self.import_error(ExceptionKind::ModuleNotFoundError, text, Some(name), help)
    }

    /// An `ImportError` about the module `name`.
    fn import_error(
        &self,
        kind: ExceptionKind,
        text: String,
        name: Option<&str>,
        help: Option<Text>,
    ) -> Unwind {
        let raised = self.raise(kind, text);
        if let Unwind::Exception(exception) = &raised
            && let Some(state) = exception.exception()
        {
            if let Some(name) = name {
                let attribute = self.core.symbols.intern("name");
                exception.set(attribute, Value::str(name), &self.core.symbols);
            }
            *state.help.borrow_mut() = help.map(Box::new);
        }
        raised
    }
}
