//! Statements.

use super::{Arg, BinaryOp, Expr, Ident, Parameters, ScopeId};
use crate::source::Span;

/// A statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Stmt {
    /// The kind of the statement, with its parts.
    pub kind: StmtKind,
    /// Where it is written; compound statements with their bodies.
    pub span: Span,
}

/// The kinds of statement.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum StmtKind {
    Expr(Expr),
    /// `print x, y` (language.md 4.3); with `trailing_comma` the line is ended by a blank.
    Print {
        values: Vec<Expr>,
        trailing_comma: bool,
    },
    Assign {
        targets: Vec<Expr>,
        value: Expr,
    },
    AugAssign {
        target: Expr,
        op: BinaryOp,
        value: Expr,
    },
    AnnAssign {
        target: Expr,
        annotation: Expr,
        value: Option<Expr>,
    },
    Delete(Vec<Expr>),
    Pass,
    Break,
    Continue,
    Return(Option<Expr>),
    Raise {
        exception: Option<Expr>,
        cause: Option<Expr>,
    },
    Global(Vec<Ident>),
    Nonlocal(Vec<Ident>),
    Assert {
        test: Expr,
        message: Option<Expr>,
    },
    Import(Vec<ImportAlias>),
    ImportFrom {
        module: Ident,
        names: Vec<ImportAlias>,
        star: bool,
    },
    /// `if` and its `elif`s in order, then `else`.
    If {
        branches: Vec<(Expr, Vec<Stmt>)>,
        orelse: Vec<Stmt>,
    },
    While {
        test: Expr,
        body: Vec<Stmt>,
        orelse: Vec<Stmt>,
    },
    For {
        target: Expr,
        iterable: Expr,
        body: Vec<Stmt>,
        orelse: Vec<Stmt>,
    },
    With {
        items: Vec<WithItem>,
        body: Vec<Stmt>,
    },
    Try {
        body: Vec<Stmt>,
        handlers: Vec<Handler>,
        orelse: Vec<Stmt>,
        finally: Vec<Stmt>,
    },
    Function(Box<FunctionDef>),
    Class(Box<ClassDef>),
}

/// `module as name` or `name as name`.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct ImportAlias {
    pub name: Ident,
    pub alias: Option<Ident>,
}

/// `context as target`.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct WithItem {
    pub context: Expr,
    pub target: Option<Expr>,
}

/// An `except` clause; `star` for `except*`, which all clauses of a `try` are or none.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Handler {
    pub star: bool,
    pub exception: Option<Expr>,
    pub name: Option<Ident>,
    pub body: Vec<Stmt>,
    pub span: Span,
}

/// A `def`, or the `sec` that heads a secondary program.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct FunctionDef {
    pub name: Ident,
    pub parameters: Parameters,
    pub returns: Option<Expr>,
    pub decorators: Vec<Expr>,
    pub body: Vec<Stmt>,
    pub secondary: bool,
    pub scope: ScopeId,
}

/// A `class`.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct ClassDef {
    pub name: Ident,
    pub args: Vec<Arg>,
    pub decorators: Vec<Expr>,
    pub body: Vec<Stmt>,
    pub scope: ScopeId,
}
