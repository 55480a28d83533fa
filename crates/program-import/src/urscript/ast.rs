//! The syntax tree of URScript: plain data with the line of every node.

/// A statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Stmt {
    /// Line on which it begins, from 1.
    pub line: u32,
    /// Line on which it ends: for a block that of its `end`.
    pub end_line: u32,
    /// What it is.
    pub kind: StmtKind,
}

/// What a statement is.
#[derive(Clone, Debug, PartialEq)]
pub enum StmtKind {
    /// `x = 3`, `local x = 3`, `global x`, `list[2] = 3`.
    Assign {
        /// The qualifier.
        scope: Scope,
        /// A name, an item or a field.
        target: Expr,
        /// None: only declared.
        value: Option<Expr>,
    },
    /// A call whose value is dropped.
    Expr(Expr),
    /// `if`, `elif`, `else`.
    If {
        /// Conditions with their blocks, in order.
        branches: Vec<(Expr, Vec<Stmt>)>,
        /// The block of `else`.
        otherwise: Option<ElseBlock>,
    },
    /// `while`.
    While(Expr, Vec<Stmt>),
    /// `def`, `thread`, `sec`.
    Function(Function),
    /// `return`.
    Return(Option<Expr>),
    /// `break`.
    Break,
    /// `continue`.
    Continue,
    /// `pass`.
    Pass,
    /// `halt`.
    Halt,
    /// `pause`.
    Pause,
    /// `kill handle`.
    Kill(Expr),
    /// `join handle`.
    Join(Expr),
    /// `enter_critical`.
    EnterCritical,
    /// `exit_critical`.
    ExitCritical,
    /// `$ 3 "Waypoint"`: a label of PolyScope, without the `$`.
    Label(String),
}

/// The block of an `else`.
#[derive(Clone, Debug, PartialEq)]
pub struct ElseBlock {
    /// Line of the word `else`.
    pub line: u32,
    /// Statements of the block.
    pub body: Vec<Stmt>,
}

/// A qualifier of an assignment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// None: the global where there is one.
    Free,
    /// `local`.
    Local,
    /// `global`.
    Global,
}

/// A function, a thread or a secondary program.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Function, thread or secondary program.
    pub kind: FunctionKind,
    /// Name of the function.
    pub name: String,
    /// Parameters with their defaults.
    pub params: Vec<(String, Option<Expr>)>,
    /// Statements of the function.
    pub body: Vec<Stmt>,
}

/// How a function is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// `def`.
    Def,
    /// `thread`: by `run`.
    Thread,
    /// `sec`: beside the program.
    Secondary,
}

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// Line on which it begins, from 1.
    pub line: u32,
    /// What it is.
    pub kind: ExprKind,
}

/// What an expression is.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// A number as it is written.
    Number(String),
    /// A text; backslashes stand for themselves.
    Text(String),
    /// `True`, `False`.
    Bool(bool),
    /// A variable or function.
    Name(String),
    /// `p[x, y, z, rx, ry, rz]`.
    Pose(Vec<Expr>),
    /// `[a, b]`.
    List(Vec<Expr>),
    /// `f(a, b=c)`.
    Call {
        /// What is called: a name, or a field of a handle.
        callee: Box<Expr>,
        /// Arguments of the call.
        args: Vec<Argument>,
    },
    /// `list[i]`, `matrix[i, j]`.
    Index {
        /// The list.
        base: Box<Expr>,
        /// One index, or two of a matrix.
        indices: Vec<Expr>,
    },
    /// `handle.field`.
    Field(Box<Expr>, String),
    /// `not x`, `-x`, `+x`.
    Unary(UnaryOperator, Box<Expr>),
    /// `x + y`.
    Binary(BinaryOperator, Box<Expr>, Box<Expr>),
    /// `(x)`.
    Paren(Box<Expr>),
    /// `run f()`: the handle of a thread.
    Run {
        /// The thread.
        name: String,
        /// Arguments of the thread.
        args: Vec<Argument>,
    },
}

/// An argument of a call.
#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// Name of the parameter, for an argument that is given by name.
    pub name: Option<String>,
    /// Value of the argument.
    pub value: Expr,
}

/// An operator of one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnaryOperator {
    /// `not`.
    Not,
    /// `-`.
    Minus,
    /// `+`.
    Plus,
}

/// An operator of two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinaryOperator {
    /// `or`.
    Or,
    /// `xor`.
    Xor,
    /// `and`.
    And,
    /// A comparison: `==`, `!=`, `<`, `<=`, `>`, `>=`.
    Compare(&'static str),
    /// `+`.
    Add,
    /// `-`.
    Subtract,
    /// `*`.
    Multiply,
    /// `/`.
    Divide,
    /// `%`.
    Remainder,
}

impl BinaryOperator {
    /// Text of the operator, which URScript and EliteScript share; only URScript has `xor`.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Or => "or",
            Self::Xor => "xor",
            Self::And => "and",
            Self::Compare(text) => text,
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Remainder => "%",
        }
    }
}

/// Calls `visit` for an expression and every expression below it, outer ones first.
pub fn walk_expr<'t>(expr: &'t Expr, visit: &mut dyn FnMut(&'t Expr)) {
    visit(expr);
    match &expr.kind {
        ExprKind::Number(_) | ExprKind::Text(_) | ExprKind::Bool(_) | ExprKind::Name(_) => {}
        ExprKind::Pose(items) | ExprKind::List(items) => {
            items.iter().for_each(|item| walk_expr(item, visit));
        }
        ExprKind::Call { callee, args } => {
            walk_expr(callee, visit);
            args.iter().for_each(|arg| walk_expr(&arg.value, visit));
        }
        ExprKind::Index { base, indices } => {
            walk_expr(base, visit);
            indices.iter().for_each(|index| walk_expr(index, visit));
        }
        ExprKind::Field(inner, _) | ExprKind::Unary(_, inner) | ExprKind::Paren(inner) => {
            walk_expr(inner, visit);
        }
        ExprKind::Binary(_, left, right) => {
            walk_expr(left, visit);
            walk_expr(right, visit);
        }
        ExprKind::Run { args, .. } => args.iter().for_each(|arg| walk_expr(&arg.value, visit)),
    }
}

impl Stmt {
    /// Expressions of the statement itself, without those of its blocks.
    pub fn expressions(&self) -> Vec<&Expr> {
        match &self.kind {
            StmtKind::Assign { target, value, .. } => value.iter().chain([target]).collect(),
            StmtKind::Expr(expr)
            | StmtKind::While(expr, _)
            | StmtKind::Return(Some(expr))
            | StmtKind::Kill(expr)
            | StmtKind::Join(expr) => vec![expr],
            StmtKind::If { branches, .. } => branches.iter().map(|(test, _)| test).collect(),
            StmtKind::Function(function) => function
                .params
                .iter()
                .filter_map(|(_, d)| d.as_ref())
                .collect(),
            _ => Vec::new(),
        }
    }

    /// Blocks of the statement; none for the definition of a function.
    pub fn blocks(&self) -> Vec<&[Stmt]> {
        match &self.kind {
            StmtKind::While(_, body) => vec![body],
            StmtKind::If {
                branches,
                otherwise,
            } => branches
                .iter()
                .map(|(_, body)| &body[..])
                .chain(otherwise.iter().map(|block| &block.body[..]))
                .collect(),
            _ => Vec::new(),
        }
    }
}
