//! From text to a program that can be run: the one entry for lexer, parser and resolver.

use std::sync::Arc;
use std::thread::ThreadId;

use messages::text;

use crate::ast::{Expr, ExprKind, FunctionDef, Module, Stmt, StmtKind};
use crate::deep_stack::with_deep_stack;
use crate::diagnostic::{Diagnostic, Severity};
use crate::diagnostic_list::{attach_task_nodes, sort_and_cap};
use crate::parser::parse;
use crate::resolve::{KnownNames, Resolution, resolve};
use crate::source::{SourceFile, Span};
use crate::work_budget::WorkBudget;

/// Longest text that is compiled, in bytes.
pub(crate) const SOURCE_BYTES_MAX: usize = 64 << 20;

/// From this length on, in bytes, reading a text takes so much that what is over is worth giving back: some 100 MiB.
const LONG_TEXT: usize = 1 << 20;

/// What a program is to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramKind {
    /// The main task.
    Main,
    /// A secondary program, headed by `sec` (manual 1.2.6).
    Secondary,
}

/// A program that compiles. Plain data: it can be sent to the thread that runs it, and run any number of times.
#[derive(Clone, Debug)]
pub struct Program {
    file: Arc<SourceFile>,
    module: Arc<Module>,
    resolution: Arc<Resolution>,
    kind: ProgramKind,
    /// The function that is called once it is defined.
    entry: Option<Box<str>>,
    warnings: Arc<[Diagnostic]>,
    /// Bytes that its tree takes, and the thread in whose account they are.
    bytes: usize,
    made_by: ThreadId,
}

impl Program {
    /// Main or secondary.
    pub fn kind(&self) -> ProgramKind {
        self.kind
    }

    /// The name of its function if it consists of one, otherwise that of its text.
    pub fn name(&self) -> &str {
        self.entry.as_deref().unwrap_or(self.file.name())
    }

    /// The text it was compiled from.
    pub fn file(&self) -> &Arc<SourceFile> {
        &self.file
    }

    /// Names that are declared `global` anywhere in it; the variable monitor shows them (language.md 3).
    pub fn declared_globals(&self) -> impl Iterator<Item = &str> {
        self.resolution.declared_globals.iter().map(|name| &**name)
    }

    /// Whether a top-level statement or a `global` declaration of it makes `name` a global variable.
    pub fn defines_global(&self, name: &str) -> bool {
        let bindings = self.resolution.bindings.iter();
        let mut names = bindings.chain(&self.resolution.declared_globals);
        names.any(|own| **own == *name)
    }

    /// Names that its top-level statements make global variables, in no order that means anything.
    pub fn global_names(&self) -> impl Iterator<Item = &str> {
        self.resolution.bindings.iter().map(|name| &**name)
    }

    /// The syntax tree of the program.
    pub fn module(&self) -> &Module {
        &self.module
    }

    /// The storage of its names.
    pub fn resolution(&self) -> &Resolution {
        &self.resolution
    }

    /// The function that is called once it is defined, if the program consists of one.
    pub fn entry(&self) -> Option<&str> {
        self.entry.as_deref()
    }

    /// Bytes that its tree takes in the account of the thread that compiled it.
    pub fn tree_bytes(&self) -> usize {
        self.bytes
    }

    /// The thread that compiled it.
    pub fn compiled_by(&self) -> ThreadId {
        self.made_by
    }

    /// What was found that does not keep it from running.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }
}

/// Compiles a program. `known` are the names that the embedder provides to scripts.
///
/// # Errors
/// The syntax and scope errors of the text, at most [`DIAGNOSTICS_MAX`](crate::DIAGNOSTICS_MAX).
pub fn compile(file: Arc<SourceFile>, known: &KnownNames) -> Result<Program, Vec<Diagnostic>> {
    let bytes = file.text().len();
    let result = with_deep_stack(|| compile_here(file, known));
    give_back_after(bytes);
    result
}

/// What was taken to read a long text goes back to the system, together with the free lists (`task_memory`).
fn give_back_after(bytes: usize) {
    if bytes > LONG_TEXT {
        task_memory::clear_free_lists();
    }
}

fn compile_here(file: Arc<SourceFile>, known: &KnownNames) -> Result<Program, Vec<Diagnostic>> {
    let budget = WorkBudget::with_limit(usize::MAX);
    let (module, mut diagnostics, shape) = parse_and_classify(&file);
    let Some(module) = module else {
        return Err(diagnostics);
    };
    let resolution = resolve(&module, known);
    diagnostics.extend(resolution.diagnostics.iter().cloned());
    if diagnostics
        .iter()
        .any(|diagnostic| diagnostic.severity == Severity::Error)
    {
        diagnostics.retain(|diagnostic| diagnostic.severity == Severity::Error);
        return Err(attach_task_nodes(sort_and_cap(diagnostics), &module.nodes));
    }
    let warnings = attach_task_nodes(sort_and_cap(diagnostics), &module.nodes).into();
    Ok(Program {
        file,
        module: Arc::new(module),
        resolution: Arc::new(resolution),
        kind: shape.kind,
        entry: shape.entry,
        warnings,
        bytes: budget.used(),
        made_by: std::thread::current().id(),
    })
}

/// Parses and checks a text without running it: errors and warnings, in the order of the text. Codes of warnings:
/// `undefined-name`, `unused-variable`, `unused-import`, `missing-module`, `unreachable`, `busy-loop`, and those of the
/// embedder's hook. Not more than [`DIAGNOSTICS_MAX`](crate::DIAGNOSTICS_MAX); where there are so many there may be
/// further ones.
pub fn check(file: Arc<SourceFile>, known: &KnownNames) -> Vec<Diagnostic> {
    let bytes = file.text().len();
    let found = with_deep_stack(|| match compile_here(file.clone(), known) {
        Ok(program) => {
            let mut found = program.warnings.to_vec();
            found.extend(crate::lint::lint(&program.module, &file, known));
            attach_task_nodes(sort_and_cap(found), &program.module.nodes)
        }
        Err(diagnostics) => diagnostics,
    });
    give_back_after(bytes);
    found
}

/// What a text is as a whole.
pub(crate) struct ProgramForm {
    kind: ProgramKind,
    entry: Option<Box<str>>,
}

/// What is said of a text that is longer than any that is read.
pub(crate) fn too_long(bytes: usize) -> Diagnostic {
    let text = text!(
        "the text has {bytes} bytes, {SOURCE_BYTES_MAX} are allowed",
        "文本有 {bytes} 字节，最多允许 {SOURCE_BYTES_MAX}"
    );
    Diagnostic::error("too-long", Span::default(), text)
}

fn parse_and_classify(file: &SourceFile) -> (Option<Module>, Vec<Diagnostic>, ProgramForm) {
    let nothing = ProgramForm {
        kind: ProgramKind::Main,
        entry: None,
    };
    if file.text().len() > SOURCE_BYTES_MAX {
        return (None, vec![too_long(file.text().len())], nothing);
    }
    let parsed = parse(file);
    let mut diagnostics = parsed.diagnostics;
    let shape = classify(&parsed.module, &mut diagnostics);
    let failed = diagnostics
        .iter()
        .any(|diagnostic| diagnostic.severity == Severity::Error);
    if failed {
        // Names are looked up in trees without gaps only: a gap would make half of the names look undefined.
        diagnostics.retain(|diagnostic| diagnostic.severity == Severity::Error);
        let diagnostics = attach_task_nodes(diagnostics, &parsed.module.nodes);
        return (None, diagnostics, shape);
    }
    (Some(parsed.module), diagnostics, shape)
}

/// A text whose only statement is a function without required parameters runs that function; `sec` always does
/// (language.md 5).
pub(crate) fn classify(module: &Module, diagnostics: &mut Vec<Diagnostic>) -> ProgramForm {
    let statements: Vec<&Stmt> = module
        .body
        .iter()
        .filter(|statement| !is_docstring(statement))
        .collect();
    let mut secondary = functions(&module.body).filter(|def| def.secondary);
    if let [
        Stmt {
            kind: StmtKind::Function(def),
            ..
        },
    ] = &statements[..]
    {
        if def.secondary && !def.parameters.none_required() {
            let message = text!(
                "a secondary program takes no parameters",
                "次要程序不能有参数"
            );
            diagnostics.push(Diagnostic::error("secondary", def.name.span, message));
        }
        let kind = if def.secondary {
            ProgramKind::Secondary
        } else {
            ProgramKind::Main
        };
        let entry = def
            .parameters
            .none_required()
            .then(|| def.name.name.clone());
        return ProgramForm { kind, entry };
    }
    if let Some(def) = secondary.next() {
        let message = text!(
            "'sec' heads a program of its own: nothing else can stand in the same text",
            "'sec' 开头的是独立的程序：同一文本中不能有其他内容"
        );
        diagnostics.push(Diagnostic::error("secondary", def.name.span, message));
    }
    ProgramForm {
        kind: ProgramKind::Main,
        entry: None,
    }
}

fn functions(body: &[Stmt]) -> impl Iterator<Item = &FunctionDef> {
    body.iter().filter_map(|statement| match &statement.kind {
        StmtKind::Function(def) => Some(&**def),
        _ => None,
    })
}

fn is_docstring(statement: &Stmt) -> bool {
    matches!(
        &statement.kind,
        StmtKind::Expr(Expr {
            kind: ExprKind::Constant(_),
            ..
        })
    )
}
