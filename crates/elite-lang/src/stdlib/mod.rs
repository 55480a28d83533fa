//! The modules scripts can import.
//!
//! A module is either written in Rust (where speed or types matter) or an embedded script of our own, compiled when it
//! is first imported; an embedded script reaches native parts by importing a module whose name begins with `_`.
//! Modules that reach beyond the program go through the host, which decides what is permitted.

mod abstracts;
mod binary;
mod bisect;
mod codecs;
pub(crate) mod collections;
mod copies;
mod define;
mod fields;
mod files;
mod functools;
pub(crate) mod heap;
mod itertools;
mod json;
mod math;
mod operator;
mod process;
mod random;
mod regex;
mod socket;
mod system;
mod thread;
mod time;

use std::rc::Rc;

use elite_syntax::SourceFile;
use elite_syntax::ast::StmtKind;

use crate::builtins::reading::{ResolvedTree, parse_and_resolve, release, with_parse_budget};
use crate::eval::Evaluator;
use crate::eval::code::Code;
use crate::lower;
use crate::value::module::Namespace;
use crate::value::symbol::known;
use crate::value::{Function, Module, R, Symbol, Value};

use define::ModuleBuilder;

/// What modules keep for the programs of one interpreter.
#[derive(Default)]
pub struct ModuleState {
    formats: binary::FormatCache,
}

/// What a module is made of.
#[derive(Clone, Copy)]
enum ModuleSource {
    /// Rust code that fills it.
    Native(fn(&ModuleBuilder<'_, '_>) -> R<()>),
    /// An embedded script.
    Script(&'static str),
}

use ModuleSource::{Native, Script};

/// All modules, by name.
const MODULES: &[(&str, ModuleSource)] = &[
    ("_codecs", Native(codecs::fill)),
    ("_collections", Native(collections::fill)),
    ("_copy", Native(copies::fill)),
    ("_files", Native(files::fill)),
    ("_functools", Native(functools::fill)),
    ("_heapq", Native(heap::fill)),
    ("_json", Native(json::fill)),
    ("_operator", Native(operator::fill)),
    ("_process", Native(process::fill)),
    ("_random", Native(random::fill)),
    ("_re", Native(regex::fill)),
    ("_socket", Native(socket::fill)),
    ("_system", Native(system::fill)),
    ("_string", Native(fields::fill)),
    ("_struct", Native(binary::fill)),
    ("_thread", Native(thread::fill)),
    ("_time", Native(time::fill)),
    ("abc", Native(abstracts::fill)),
    ("bisect", Native(bisect::fill)),
    ("codecs", Script(include_str!("lib/codecs.py"))),
    ("collections", Script(include_str!("lib/collections.py"))),
    (
        "collections.abc",
        Script(include_str!("lib/collections_abc.py")),
    ),
    ("contextlib", Script(include_str!("lib/contextlib.py"))),
    ("copy", Script(include_str!("lib/copy.py"))),
    ("dataclasses", Script(include_str!("lib/dataclasses.py"))),
    ("datetime", Script(include_str!("lib/datetime.py"))),
    ("elicopy", Script("from copy import copy, deepcopy\n")),
    ("enum", Script(include_str!("lib/enum.py"))),
    ("functools", Script(include_str!("lib/functools.py"))),
    ("heapq", Script(include_str!("lib/heapq.py"))),
    ("importlib", Script(include_str!("lib/importlib.py"))),
    ("io", Script(include_str!("lib/io.py"))),
    ("itertools", Native(itertools::fill)),
    ("json", Script(include_str!("lib/json.py"))),
    ("math", Native(math::fill)),
    ("operator", Script(include_str!("lib/operator.py"))),
    ("os", Script(include_str!("lib/os.py"))),
    ("os.path", Script(include_str!("lib/os_path.py"))),
    ("queue", Script(include_str!("lib/queue.py"))),
    ("random", Script(include_str!("lib/random.py"))),
    ("re", Script(include_str!("lib/re.py"))),
    ("signal", Script(include_str!("lib/signal.py"))),
    ("socket", Script(include_str!("lib/socket.py"))),
    ("statistics", Script(include_str!("lib/statistics.py"))),
    ("string", Script(include_str!("lib/string.py"))),
    ("struct", Script(include_str!("lib/struct.py"))),
    ("subprocess", Script(include_str!("lib/subprocess.py"))),
    ("sys", Script(include_str!("lib/sys.py"))),
    ("threading", Script(include_str!("lib/threading.py"))),
    ("time", Script(include_str!("lib/time.py"))),
    ("typing", Script(include_str!("lib/typing.py"))),
];

/// Classes of embedded scripts that CPython has in C, in which module there: its messages name them with it.
const IN_C: &[(&str, &str, &[&str])] = &[
    (
        "datetime",
        "datetime",
        &[
            "date",
            "datetime",
            "time",
            "timedelta",
            "timezone",
            "tzinfo",
        ],
    ),
    ("functools", "functools", &["partial"]),
    ("io", "_io", &["BytesIO", "StringIO"]),
    ("queue", "_queue", &["SimpleQueue"]),
    ("struct", "_struct", &["Struct"]),
    ("threading", "_thread", &["local"]),
];

fn mark_as_c(ev: &Evaluator<'_>, module: &Module) {
    let found = IN_C.iter().find(|(name, _, _)| *name == &*module.name);
    let (_, home, names) = found.copied().unwrap_or_default();
    for name in names {
        if let Some(Value::Class(class)) = module.namespace.get(ev.core.symbols.intern(name)) {
            class.is_c_type.set(true);
            class.set(known::MODULE, Value::str(home));
        }
    }
}

/// The module that a name means which nothing else defines. It is loaded when it is first used.
pub fn implicit_module(ev: &Evaluator<'_>, name: Symbol) -> R<Option<Value>> {
    let text = ev.core.symbols.name(name);
    if !elite_syntax::python_names::IMPLICIT_MODULES.contains(&&*text) {
        return Ok(None);
    }
    let module = ev.import(&text)?;
    ev.core.builtins.set(name, module.clone());
    Ok(Some(module))
}

/// Whether a module may have others in it.
pub fn is_package(name: &str) -> bool {
    // The list has the modules that are packages in CPython.
    matches!(name, "collections" | "importlib" | "json" | "re")
}

/// Makes the module of this name and enters it in the list of modules; None if there is none.
pub fn load(ev: &Evaluator<'_>, name: &str) -> R<Option<Rc<Module>>> {
    let Some((name, content)) = MODULES.iter().find(|(known, _)| *known == name) else {
        return Ok(None);
    };
    let core = &ev.core;
    let namespace = core.new_namespace(None);
    // The code of a module is made with its name, so the name is set first.
    namespace.set(known::NAME, Value::str(*name));
    let code = match content {
        Native(_) => None,
        Script(text) => {
            let code = read_script(ev, &namespace, name, text)?;
            // Other threads have had their turn meanwhile, and may have made the module.
            if let Some(Value::Module(module)) = core.module_table.get_str(name) {
                return Ok(Some(module));
            }
            Some(code)
        }
    };
    let module = Rc::new(Module {
        name: (*name).into(),
        namespace,
    });
    core.modules.borrow_mut().push(module.clone());
    if !name.starts_with('_') {
        let entry = Value::Module(module.clone());
        core.module_table.set_str(name, entry);
    }
    core.module_load_depth.set(core.module_load_depth.get() + 1);
    let filled = match (content, code) {
        (Native(fill), _) => fill(&ModuleBuilder::new(ev, &module)),
        (Script(_), code) => code.map_or(Ok(()), |code| {
            let function = Function::without_defaults(code, Box::default());
            ev.call_function(&function, &mut [], &[]).map(drop)
        }),
    };
    core.module_load_depth.set(core.module_load_depth.get() - 1);
    if filled.is_ok() {
        mark_as_c(ev, &module);
    }
    if let Err(raised) = filled {
        core.modules
            .borrow_mut()
            .retain(|other| !Rc::ptr_eq(other, &module));
        ev.dict_remove(&core.module_table, &Value::str(*name))?;
        return Err(raised);
    }
    Ok(Some(module))
}

/// Whether a text is one of the embedded scripts.
pub fn is_library(file: &SourceFile) -> bool {
    MODULES.iter().any(|(name, source)| match source {
        Script(text) => *text == file.text() && file_name(name) == file.name(),
        Native(_) => false,
    })
}

/// The name under which tracebacks have an embedded script.
fn file_name(module: &str) -> String {
    format!("lib/{module}.py")
}

/// The code of an embedded script, read with pauses. What it imports is there then, so that what is left, its
/// statements, takes a millisecond or two: they run in one piece, for a module must not be seen half loaded.
fn read_script(
    ev: &Evaluator<'_>,
    namespace: &Rc<Namespace>,
    name: &str,
    text: &str,
) -> R<Rc<Code>> {
    let file = SourceFile::new(file_name(name), text);
    let (code, imported) = with_parse_budget(ev, |budget| {
        let ResolvedTree { module, resolution } = parse_and_resolve(ev, &file, false, budget)?;
        let imported = module
            .body
            .iter()
            .flat_map(|statement| match &statement.kind {
                StmtKind::Import(names) => {
                    names.iter().map(|alias| alias.name.name.clone()).collect()
                }
                StmtKind::ImportFrom { module, .. } => vec![module.name.clone()],
                _ => Vec::new(),
            });
        let imported: Vec<_> = imported.collect();
        let code = lower::module(&ev.core, namespace, &file, &module, &resolution, budget);
        release(module, resolution, budget);
        Ok((code, imported))
    })?;
    for module in imported {
        // Without its package, which may be the one that is being loaded.
        ev.import_one(&module)?;
    }
    Ok(code)
}

/// The end of a main program: it waits for the threads that are not daemons, as Python does.
pub fn finish_main(ev: &Evaluator<'_>) -> R<()> {
    let loaded = ev
        .core
        .modules
        .borrow()
        .iter()
        .find(|module| &*module.name == "threading")
        .cloned();
    let Some(threading) = loaded else {
        return Ok(());
    };
    match threading.namespace.get(ev.core.symbols.intern("_shutdown")) {
        Some(shutdown) => ev.call(&shutdown, &mut [], &[]).map(drop),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_modules_are_those_that_texts_are_checked_against() {
        let ours = super::MODULES.iter().map(|(name, _)| *name);
        assert!(ours.eq(elite_syntax::python_names::all_module_names()));
    }
}
