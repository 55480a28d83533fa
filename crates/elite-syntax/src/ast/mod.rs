//! The syntax tree as the parser makes it: plain data, `Send`, a span on every node.
//!
//! Names are text here; slots come from `resolve`. Nothing in this tree is executed: `lower` turns it into
//! executable nodes for one interpreter.

pub(crate) mod chunked_drop;
pub(crate) mod relocate;
mod stmt;
pub mod visit;

use num_bigint::BigInt;

pub use stmt::{ClassDef, FunctionDef, Handler, ImportAlias, Stmt, StmtKind, WithItem};

use crate::source::Span;
use visit::NodePart;

/// A name with its place. Private names (`__x` inside a class) are already mangled by the parser.
#[derive(Clone, Debug, PartialEq)]
pub struct Ident {
    /// The text.
    pub name: Box<str>,
    /// The place in the text.
    pub span: Span,
}

/// Number of a scope in a program, in source order; the module is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ScopeId(pub u32);

/// A literal.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Constant {
    None,
    Bool(bool),
    Ellipsis,
    Int(i64),
    BigInt(BigInt),
    Float(f64),
    Imaginary(f64),
    Str(Box<str>),
    Bytes(Box<[u8]>),
}

/// Binary operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum BinaryOp {
    Add,
    Sub,
    Mul,
    Div,
    FloorDiv,
    Mod,
    Pow,
    MatMul,
    BitAnd,
    BitOr,
    BitXor,
    Shl,
    Shr,
}

/// Unary operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum UnaryOp {
    Not,
    Neg,
    Pos,
    Invert,
}

/// Comparison operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum CompareOp {
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
    Is,
    IsNot,
    In,
    NotIn,
}

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// The kind of the expression, with its parts.
    pub kind: ExprKind,
    /// The place in the text.
    pub span: Span,
    /// Levels of expressions below it.
    pub depth: u16,
}

impl Expr {
    /// An expression of this kind.
    pub fn new(kind: ExprKind, span: Span) -> Self {
        let below = kind.depth_of_parts();
        Expr {
            kind,
            span,
            depth: below.saturating_add(1),
        }
    }
}

/// The kinds of expression.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum ExprKind {
    Constant(Constant),
    Name(Box<str>),
    And(Vec<Expr>),
    Or(Vec<Expr>),
    Binary {
        op: BinaryOp,
        left: Box<Expr>,
        right: Box<Expr>,
    },
    Unary {
        op: UnaryOp,
        operand: Box<Expr>,
    },
    Compare {
        left: Box<Expr>,
        rest: Vec<(CompareOp, Expr)>,
    },
    Call {
        function: Box<Expr>,
        args: Vec<Arg>,
    },
    Attribute {
        value: Box<Expr>,
        name: Ident,
    },
    Subscript {
        value: Box<Expr>,
        index: Box<Expr>,
    },
    /// Only as (part of) the index of a subscript.
    Slice {
        lower: Option<Box<Expr>>,
        upper: Option<Box<Expr>>,
        step: Option<Box<Expr>>,
    },
    List(Vec<Expr>),
    Tuple(Vec<Expr>),
    Set(Vec<Expr>),
    Dict(Vec<DictItem>),
    Comprehension(Box<Comprehension>),
    Lambda(Box<Lambda>),
    IfElse {
        test: Box<Expr>,
        body: Box<Expr>,
        orelse: Box<Expr>,
    },
    /// `name := value`
    Named {
        target: Ident,
        value: Box<Expr>,
    },
    /// `*value`, in calls, displays and targets.
    Starred(Box<Expr>),
    Yield(Option<Box<Expr>>),
    YieldFrom(Box<Expr>),
    FString(Vec<FStringPart>),
}

impl ExprKind {
    /// The greatest depth among the expressions it consists of.
    fn depth_of_parts(&self) -> u16 {
        let mut depth = 0;
        visit::expression_parts(self, &mut |part| {
            if let NodePart::Expr(expr) | NodePart::ClauseTarget(expr) = part {
                depth = expr.depth.max(depth);
            }
        });
        match self {
            // Each clause is a level of its own.
            ExprKind::Comprehension(comprehension) => {
                depth.saturating_add(comprehension.clauses.len() as u16)
            }
            _ => depth,
        }
    }
}

/// An argument of a call or a class header.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Arg {
    Positional(Expr),
    /// `*iterable`
    Star(Expr),
    Keyword(Ident, Expr),
    /// `**mapping`
    DoubleStar(Expr),
}

/// An item of a dict display.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum DictItem {
    Pair(Expr, Expr),
    /// `**mapping`
    Unpack(Expr),
}

/// What a comprehension builds.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum ComprehensionKind {
    List(Expr),
    Set(Expr),
    Dict(Expr, Expr),
    Generator(Expr),
}

/// A list, set or dict comprehension or a generator expression.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Comprehension {
    pub kind: ComprehensionKind,
    /// At least one; the iterable of the first is evaluated in the enclosing scope.
    pub clauses: Vec<ComprehensionClause>,
    pub scope: ScopeId,
}

/// One `for target in iterable if …` of a comprehension.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct ComprehensionClause {
    pub target: Expr,
    pub iterable: Expr,
    pub conditions: Vec<Expr>,
}

/// A part of an f-string.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum FStringPart {
    Text(Box<str>),
    Value {
        value: Expr,
        conversion: Conversion,
        format: Option<Vec<FStringPart>>,
    },
}

/// `!s`, `!r`, `!a` of a replacement field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Conversion {
    None,
    Str,
    Repr,
    Ascii,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Parameter {
    pub name: Ident,
    pub annotation: Option<Expr>,
    pub default: Option<Expr>,
}

/// The parameters of a function, by kind.
#[derive(Clone, Debug, Default, PartialEq)]
#[allow(missing_docs)]
pub struct Parameters {
    pub positional_only: Vec<Parameter>,
    pub positional: Vec<Parameter>,
    pub star: Option<Parameter>,
    pub keyword_only: Vec<Parameter>,
    pub double_star: Option<Parameter>,
}

impl Parameters {
    /// All parameters in the order of their slots.
    pub fn iter(&self) -> impl Iterator<Item = &Parameter> {
        let by_position = self
            .positional_only
            .iter()
            .chain(&self.positional)
            .chain(&self.keyword_only);
        by_position.chain(&self.star).chain(&self.double_star)
    }

    /// Whether a call without arguments is possible.
    pub fn none_required(&self) -> bool {
        let mut named = self
            .positional_only
            .iter()
            .chain(&self.positional)
            .chain(&self.keyword_only);
        named.all(|parameter| parameter.default.is_some())
    }
}

/// A `lambda`.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Lambda {
    pub parameters: Parameters,
    pub body: Expr,
    pub scope: ScopeId,
}

/// A whole program text.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Module {
    pub body: Vec<Stmt>,
    pub span: Span,
    /// Number of scopes handed out, the module's own included.
    pub scope_count: u32,
    /// What its `$ LINE` directives say, in the order of the text.
    pub nodes: Vec<NodeDirective>,
}

impl Drop for Module {
    /// Any stack may be too small for a tree.
    fn drop(&mut self) {
        if !self.body.is_empty() {
            crate::deep_stack::drop_tree(std::mem::take(&mut self.body));
        }
    }
}

impl Module {
    /// A text without anything.
    pub const EMPTY: Self = Module {
        body: Vec::new(),
        span: Span { start: 0, end: 0 },
        scope_count: 1,
        nodes: Vec::new(),
    };
}

/// A `$ LINE` directive: here begins a node of the task that the pendant made the text from.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct NodeDirective {
    /// Row of the task tree, from 1.
    pub number: u32,
    pub label: Box<str>,
    /// The byte of the text at which it stands.
    pub start: u32,
    /// The node is shown when the motion that follows has ended, not before.
    pub after: bool,
    pub place: DirectiveAnchor,
}

/// When a thread passes a directive. Statements are known by where they start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DirectiveAnchor {
    /// Before the statement, or the condition of an `elif`, that starts at this byte.
    Before(u32),
    /// When the statement that starts at this byte, the last of its block, has ended.
    After(u32),
    /// At the end of the text.
    AtEnd,
}
