//! EliteScript as text: Python 3.11 as robot controllers speak it, with `end`, `sec` and one-line programs.
//!
//! Source text goes through [`lexer`], [`parser`] and [`resolve`]; what comes out is a tree whose names have their
//! storage, and diagnostics with positions and fixes. Nothing here runs a program: `elite-lang` does, and needs the
//! result of [`compile`]. Editors, `check`, formatters and translators need this crate alone.
//!
//! # Checking a text
//!
//! A [`SourceFile`] has a name and a text. [`KnownNames`] are the names that an embedder adds to Python's own: without
//! them every robot function would be reported as undefined.
//!
//! ```
//! use elite_syntax::{KnownNames, SourceFile, check, render_human};
//! use messages::Language;
//!
//! let known = KnownNames::new(["movej", "movel"].map(String::from));
//! let file = SourceFile::new("pick.script", "def pick():\n    movel(home)\n    x = 1\n");
//! let found = check(file.clone(), &known);
//!
//! let codes: Vec<&str> = found.iter().map(|diagnostic| diagnostic.code).collect();
//! assert_eq!(codes, ["undefined-name", "unused-variable"]);
//! let fields = found[0].fields(&file);
//! assert_eq!((fields.line, fields.column), (2, 11));
//! assert!(render_human(&found[0], &file, Language::English, false).contains("pick.script:2:11"));
//! ```
//!
//! # Reading the tree
//!
//! The tree ([`ast`]) is plain data with a [`Span`] on every node. [`ast::visit`] has the blocks of a statement and the
//! parts of an expression, so that a walk names only the nodes that it is about.
//!
//! ```
//! use elite_syntax::ast::visit::{blocks, own_expressions};
//! use elite_syntax::ast::{Expr, ExprKind, Stmt};
//! use elite_syntax::{SourceFile, parser};
//!
//! fn calls<'t>(body: &'t [Stmt], names: &mut Vec<&'t str>) {
//!     for statement in body {
//!         own_expressions(statement, &mut |expr: &'t Expr| {
//!             if let ExprKind::Call { function, .. } = &expr.kind
//!                 && let ExprKind::Name(name) = &function.kind
//!             {
//!                 names.push(name);
//!             }
//!         });
//!         blocks(statement).into_iter().for_each(|block| calls(block, names));
//!     }
//! }
//!
//! let file = SourceFile::new("pick.script", "if ready():\n    grip()\nelse:\n    sleep(1)\n");
//! let parsed = parser::parse(&file);
//! assert!(parsed.diagnostics.is_empty());
//! let mut names = Vec::new();
//! calls(&parsed.module.body, &mut names);
//! assert_eq!(names, ["ready", "grip", "sleep"]);
//! ```
//!
//! # Following a text that changes
//!
//! An editor keeps a [`ParsedDocument`] and gives it each new text. Units of the top level that no change could reach
//! keep their tree and their diagnostics.
//!
//! ```
//! use elite_syntax::{KnownNames, ParsedDocument, SourceFile};
//!
//! let known = KnownNames::default();
//! let first = SourceFile::new("a.script", "limit = 5\nprint(limti)\n");
//! let document = ParsedDocument::of(first, &known);
//! assert_eq!(document.findings().len(), 1);
//!
//! let second = SourceFile::new("a.script", "limit = 5\nprint(limit)\n");
//! let document = document.reparse(second, &known);
//! assert!(document.findings().is_empty());
//! ```

pub mod ast;
mod breakpoints;
mod deep_stack;
mod diagnostic;
mod diagnostic_list;
mod document;
mod excerpt;
mod format_check;
mod habits;
pub mod lexer;
mod lint;
pub mod parser;
mod program;
pub mod python_names;
pub mod resolve;
mod source;
mod statement;
mod suggestions;
pub mod surrogate;
mod task_node;
mod work_budget;

pub use breakpoints::{BreakpointLocation, breakpoint_locations, is_executable};
pub use deep_stack::{deep_stack, drop_tree, with_deep_stack, work_on_tree};
pub use diagnostic::{Diagnostic, DiagnosticFields, Fix, Label, Severity, picture, render_human};
pub use diagnostic_list::{DIAGNOSTICS_MAX, quoted};
pub use document::{DocumentUnit, ParsedDocument};
pub use format_check::same_tree;
pub use habits::advice as habit_advice;
pub use lint::{ArgumentLiteral, CallArgument, CallHint, CallSite};
pub use program::{Program, ProgramKind, check, compile};
pub use resolve::KnownNames;
pub use source::{Position, SourceFile, Span};
pub use statement::{Statement, compile_statement};
pub use suggestions::nearest;
pub use task_node::TaskNode;
pub use work_budget::{WORK_PER_DROP, WorkBudget};
