//! Statements for a program that waits (interpreter mode, manual chapter 2): compiled without knowing where they will
//! run, so that a port can answer at once.

use std::sync::Arc;

use messages::text;

use crate::ast::Module;
use crate::deep_stack::with_deep_stack;
use crate::diagnostic::{Diagnostic, Severity};
use crate::diagnostic_list::sort_and_cap;
use crate::parser::parse;
use crate::resolve::{KnownNames, Resolution, Storage, resolve};
use crate::source::{SourceFile, Span};

/// Longest text of a statement, in bytes.
const STATEMENT_BYTES_MAX: usize = 8 << 20;

/// One or more statements that compile. Plain data: it can be sent to the thread that runs it, and run again.
#[derive(Clone, Debug)]
pub struct Statement {
    file: Arc<SourceFile>,
    module: Arc<Module>,
    resolution: Arc<Resolution>,
}

/// Compiles a statement: a line, or a block such as a `def`. The name of `file` stands in tracebacks.
///
/// # Errors
/// The syntax and scope errors of the text, at most [`DIAGNOSTICS_MAX`](crate::DIAGNOSTICS_MAX).
pub fn compile_statement(
    file: Arc<SourceFile>,
    known: &KnownNames,
) -> Result<Statement, Vec<Diagnostic>> {
    if file.text().len() > STATEMENT_BYTES_MAX {
        let (bytes, most) = (file.text().len(), STATEMENT_BYTES_MAX);
        let text = text!(
            "the statement has {bytes} bytes, {most} are allowed",
            "语句有 {bytes} 字节，最多允许 {most}"
        );
        return Err(vec![Diagnostic::error("too-long", Span::default(), text)]);
    }
    with_deep_stack(|| {
        let parsed = parse(&file);
        let mut diagnostics = parsed.diagnostics;
        let mut resolution = None;
        if !has_error(&diagnostics) {
            let resolved = resolve(&parsed.module, known);
            diagnostics.extend(resolved.diagnostics.iter().cloned());
            resolution = Some(resolved);
        }
        match resolution {
            Some(resolution) if !has_error(&diagnostics) => Ok(Statement {
                file,
                module: Arc::new(parsed.module),
                resolution: Arc::new(resolution),
            }),
            _ => {
                diagnostics.retain(|diagnostic| diagnostic.severity == Severity::Error);
                Err(sort_and_cap(diagnostics))
            }
        }
    })
}

fn has_error(diagnostics: &[Diagnostic]) -> bool {
    let mut severities = diagnostics.iter().map(|diagnostic| diagnostic.severity);
    severities.any(|severity| severity == Severity::Error)
}

impl Statement {
    /// The text of the statement.
    pub fn file(&self) -> &Arc<SourceFile> {
        &self.file
    }

    /// Whether it uses or binds `name` anywhere as a variable that is not local to one of its own functions.
    pub fn mentions(&self, name: &str) -> bool {
        self.outer_names().any(|outer| outer == name)
    }

    /// The names it declares `global`. One that is not a global of the program is refused when the statement runs;
    /// `Program::defines_global` tells beforehand.
    pub fn declared_globals(&self) -> impl Iterator<Item = &str> {
        self.resolution.declared_globals.iter().map(|name| &**name)
    }

    /// The syntax tree of the statement.
    pub fn module(&self) -> &Module {
        &self.module
    }

    /// The storage of its names.
    pub fn resolution(&self) -> &Resolution {
        &self.resolution
    }

    /// Names that none of its own functions, classes or comprehensions owns; some come more than once.
    pub fn outer_names(&self) -> impl Iterator<Item = &str> {
        let scopes = self.resolution.scopes.iter().flatten();
        let names = scopes.flat_map(|scope| &scope.names);
        // The names of a class body fall back to outer ones while they are not bound.
        let outer = names.filter(|(_, place)| matches!(place, Storage::Global | Storage::Class(_)));
        outer.map(|(name, _)| &**name)
    }
}
