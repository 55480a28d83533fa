//! Tokens to the syntax tree. Line ends count in two places only: a `(` or `[` that begins a line begins no call and no
//! index, and a `return` without a value ends with its line.

use messages::{Text, text};

use super::SyntaxError;
use super::ast::{
    Argument, BinaryOperator, ElseBlock, Expr, ExprKind, Function, FunctionKind, Scope, Stmt,
    StmtKind, UnaryOperator,
};
use super::lexer::{Comment, Token, TokenKind, tokens};

/// Blocks, brackets and operators one inside the other.
const DEPTH_MAX: usize = 100;
/// Operators, calls and indices in a row, which nest to the left.
const CHAIN_MAX: usize = 500;

/// A text of URScript as a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Statements of the top level; a program is one `def`.
    pub body: Vec<Stmt>,
    /// Comments, in order.
    pub comments: Vec<Comment>,
}

/// Reads a text.
///
/// # Errors
///
/// Names the first place that is no URScript.
pub fn parse(text: &str) -> Result<Source, SyntaxError> {
    let (tokens, comments) = tokens(text)?;
    let mut parser = Parser {
        tokens,
        next: 0,
        depth: 0,
    };
    let mut body = Vec::new();
    while parser.peek() != &TokenKind::End {
        parser.statement(&mut body)?;
    }
    Ok(Source { body, comments })
}

struct Parser {
    tokens: Vec<Token>,
    next: usize,
    depth: usize,
}

type Parsed<T> = Result<T, SyntaxError>;

/// Words that end a block.
const BLOCK_ENDS: [&str; 3] = ["end", "elif", "else"];

impl Parser {
    fn token(&self) -> &Token {
        // The last token is `End`, and nothing goes beyond it.
        &self.tokens[self.next.min(self.tokens.len() - 1)]
    }

    fn peek(&self) -> &TokenKind {
        &self.token().kind
    }

    fn line(&self) -> u32 {
        self.token().line
    }

    /// Line of the token before the next.
    fn line_before(&self) -> u32 {
        self.tokens[self.next.saturating_sub(1)].line
    }

    fn is_symbol(&self, symbol: &str) -> bool {
        matches!(self.peek(), TokenKind::Symbol(found) if *found == symbol)
    }

    fn is_word(&self, word: &str) -> bool {
        matches!(self.peek(), TokenKind::Word(found) if found == word)
    }

    fn accept(&mut self, symbol: &str) -> bool {
        let found = self.is_symbol(symbol);
        self.next += usize::from(found);
        found
    }

    fn accept_word(&mut self, word: &str) -> bool {
        let found = self.is_word(word);
        self.next += usize::from(found);
        found
    }

    fn error<T>(&self, wanted: Text) -> Parsed<T> {
        let found = match self.peek() {
            TokenKind::Word(word) => Text::verbatim(format!("'{word}'")),
            TokenKind::Number(text) => Text::verbatim(text.clone()),
            TokenKind::Text(_) => text!("a text", "字符串"),
            TokenKind::PoseStart => Text::verbatim("'p['"),
            TokenKind::Symbol(symbol) => Text::verbatim(format!("'{symbol}'")),
            TokenKind::Label(_) => text!("a label ($)", "标签（$）"),
            TokenKind::End => text!("the end of the text", "文本结尾"),
        };
        Err(SyntaxError::new(
            self.line(),
            text!(
                "here is {found} and not {wanted}",
                "这里是{found}，而不是{wanted}"
            ),
        ))
    }

    fn expect(&mut self, symbol: &str) -> Parsed<()> {
        match self.accept(symbol) {
            true => Ok(()),
            false => self.error(Text::verbatim(format!("'{symbol}'"))),
        }
    }

    fn name(&mut self) -> Parsed<String> {
        match self.peek() {
            TokenKind::Word(word) if !is_keyword(word) => {
                let word = word.clone();
                self.next += 1;
                Ok(word)
            }
            // A variable called `p` before a bracket is read by whoever sees the bracket.
            _ => self.error(text!("a name", "名称")),
        }
    }

    /// Runs `inner` one level deeper.
    fn deeper<T>(&mut self, inner: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth == DEPTH_MAX {
            let text = text!(
                "blocks and brackets lie more than {DEPTH_MAX} deep",
                "块和括号嵌套超过 {DEPTH_MAX} 层"
            );
            return Err(SyntaxError::new(self.line(), text));
        }
        self.depth += 1;
        let result = inner(self);
        self.depth -= 1;
        result
    }

    fn statement(&mut self, into: &mut Vec<Stmt>) -> Parsed<()> {
        let line = self.line();
        if self.accept(";") {
            return Ok(());
        }
        let kind = match self.peek().clone() {
            TokenKind::Label(text) => {
                self.next += 1;
                StmtKind::Label(text)
            }
            TokenKind::Word(word) => self.statement_of_word(&word)?,
            TokenKind::PoseStart => self.assignment(Scope::Free)?,
            _ => return self.error(text!("a statement", "语句")),
        };
        let end_line = self.line_before();
        into.push(Stmt {
            line,
            end_line,
            kind,
        });
        Ok(())
    }

    fn statement_of_word(&mut self, word: &str) -> Parsed<StmtKind> {
        let simple = match word {
            "break" => Some(StmtKind::Break),
            "continue" => Some(StmtKind::Continue),
            "pass" => Some(StmtKind::Pass),
            "halt" => Some(StmtKind::Halt),
            "pause" => Some(StmtKind::Pause),
            "enter_critical" => Some(StmtKind::EnterCritical),
            "exit_critical" => Some(StmtKind::ExitCritical),
            _ => None,
        };
        if let Some(kind) = simple {
            self.next += 1;
            // `halt()` is written as well.
            if self.is_symbol("(") && !self.token().is_first {
                self.next += 1;
                self.expect(")")?;
            }
            return Ok(kind);
        }
        match word {
            "def" => self.function(FunctionKind::Def),
            "thread" => self.function(FunctionKind::Thread),
            "sec" => self.function(FunctionKind::Secondary),
            "if" => self.if_statement(),
            "while" => {
                self.next += 1;
                let test = self.expression()?;
                let body = self.block()?;
                self.end()?;
                Ok(StmtKind::While(test, body))
            }
            "return" => {
                self.next += 1;
                let ends = self.token().is_first
                    || self.is_symbol(";")
                    || matches!(self.peek(), TokenKind::End)
                    || BLOCK_ENDS.iter().any(|word| self.is_word(word));
                Ok(StmtKind::Return(match ends {
                    true => None,
                    false => Some(self.expression()?),
                }))
            }
            "kill" | "join" => {
                self.next += 1;
                let handle = self.expression()?;
                Ok(match word {
                    "kill" => StmtKind::Kill(handle),
                    _ => StmtKind::Join(handle),
                })
            }
            "local" | "global" => {
                self.next += 1;
                self.assignment(match word {
                    "local" => Scope::Local,
                    _ => Scope::Global,
                })
            }
            _ => self.assignment(Scope::Free),
        }
    }

    /// An assignment, a declaration or a call.
    fn assignment(&mut self, scope: Scope) -> Parsed<StmtKind> {
        let target = self.expression()?;
        let operator = match self.peek() {
            TokenKind::Symbol("=") => None,
            TokenKind::Symbol("+=") => Some(BinaryOperator::Add),
            TokenKind::Symbol("-=") => Some(BinaryOperator::Subtract),
            _ if scope == Scope::Free => {
                return match &target.kind {
                    ExprKind::Name(name) => Err(SyntaxError::new(
                        target.line,
                        text!("'{name}' alone is no statement", "单独的 '{name}' 不是语句"),
                    )),
                    _ => Ok(StmtKind::Expr(target)),
                };
            }
            _ => {
                return Ok(StmtKind::Assign {
                    scope,
                    target,
                    value: None,
                });
            }
        };
        if !matches!(
            target.kind,
            ExprKind::Name(_) | ExprKind::Index { .. } | ExprKind::Field(..)
        ) {
            return Err(SyntaxError::new(
                target.line,
                text!("this cannot be assigned to", "不能对它赋值"),
            ));
        }
        self.next += 1;
        let value = self.expression()?;
        let value = match operator {
            None => value,
            Some(operator) => Expr {
                line: target.line,
                kind: ExprKind::Binary(operator, Box::new(target.clone()), Box::new(value)),
            },
        };
        Ok(StmtKind::Assign {
            scope,
            target,
            value: Some(value),
        })
    }

    fn function(&mut self, kind: FunctionKind) -> Parsed<StmtKind> {
        self.next += 1;
        let name = self.name()?;
        let mut params = Vec::new();
        if self.accept("(") {
            while !self.accept(")") {
                let _ = self.accept_word("local");
                let param = self.name()?;
                let default = match self.accept("=") {
                    true => Some(self.expression()?),
                    false => None,
                };
                params.push((param, default));
                if !self.accept(",") && !self.is_symbol(")") {
                    return self.error(text!("',' or ')'", "',' 或 ')'"));
                }
            }
        }
        let body = self.block()?;
        self.end()?;
        Ok(StmtKind::Function(Function {
            kind,
            name,
            params,
            body,
        }))
    }

    fn if_statement(&mut self) -> Parsed<StmtKind> {
        self.next += 1;
        let test = self.expression()?;
        let mut branches = vec![(test, self.block()?)];
        let mut otherwise = None;
        loop {
            if self.accept_word("elif") {
                let test = self.expression()?;
                let body = self.block()?;
                branches.push((test, body));
            } else if self.is_word("else") {
                let line = self.line();
                self.next += 1;
                let body = self.block()?;
                otherwise = Some(ElseBlock { line, body });
                break;
            } else {
                break;
            }
        }
        self.end()?;
        Ok(StmtKind::If {
            branches,
            otherwise,
        })
    }

    /// `:` and statements up to a word that ends the block.
    fn block(&mut self) -> Parsed<Vec<Stmt>> {
        self.expect(":")?;
        self.deeper(|parser| {
            let mut body = Vec::new();
            while !BLOCK_ENDS.iter().any(|word| parser.is_word(word)) {
                if parser.peek() == &TokenKind::End {
                    return parser.error(Text::verbatim("'end'"));
                }
                parser.statement(&mut body)?;
            }
            Ok(body)
        })
    }

    fn end(&mut self) -> Parsed<()> {
        match self.accept_word("end") {
            true => Ok(()),
            false => self.error(Text::verbatim("'end'")),
        }
    }

    fn expression(&mut self) -> Parsed<Expr> {
        self.deeper(|parser| parser.operation(0))
    }

    /// An expression whose operators bind at least as strongly as `level`.
    fn operation(&mut self, level: u8) -> Parsed<Expr> {
        let mut left = self.operand(level)?;
        for _ in 0..CHAIN_MAX {
            let Some((operator, strength)) = self.operator() else {
                return Ok(left);
            };
            if strength < level {
                return Ok(left);
            }
            self.next += 1;
            let right = self.deeper(|parser| parser.operation(strength + 1))?;
            left = Expr {
                line: left.line,
                kind: ExprKind::Binary(operator, Box::new(left), Box::new(right)),
            };
        }
        let text = text!(
            "more than {CHAIN_MAX} operators in a row",
            "连续的运算符超过 {CHAIN_MAX} 个"
        );
        Err(SyntaxError::new(self.line(), text))
    }

    fn operator(&self) -> Option<(BinaryOperator, u8)> {
        Some(match self.peek() {
            TokenKind::Word(word) => match word.as_str() {
                "or" => (BinaryOperator::Or, 1),
                "xor" => (BinaryOperator::Xor, 1),
                "and" => (BinaryOperator::And, 2),
                _ => return None,
            },
            TokenKind::Symbol(symbol) => match *symbol {
                "==" | "!=" | "<" | "<=" | ">" | ">=" => (BinaryOperator::Compare(symbol), 4),
                "+" => (BinaryOperator::Add, 5),
                "-" => (BinaryOperator::Subtract, 5),
                "*" => (BinaryOperator::Multiply, 6),
                "/" => (BinaryOperator::Divide, 6),
                "%" => (BinaryOperator::Remainder, 6),
                _ => return None,
            },
            _ => return None,
        })
    }

    fn operand(&mut self, level: u8) -> Parsed<Expr> {
        let line = self.line();
        let (operator, strength) = match self.peek() {
            TokenKind::Word(word) if word == "not" && level <= 3 => (UnaryOperator::Not, 3),
            TokenKind::Symbol("-") => (UnaryOperator::Minus, 7),
            TokenKind::Symbol("+") => (UnaryOperator::Plus, 7),
            _ => return self.postfix(),
        };
        self.next += 1;
        let inner = self.deeper(|parser| parser.operation(strength))?;
        Ok(Expr {
            line,
            kind: ExprKind::Unary(operator, Box::new(inner)),
        })
    }

    /// An atom with its calls, indices and fields.
    fn postfix(&mut self) -> Parsed<Expr> {
        let mut expr = self.atom()?;
        for _ in 0..CHAIN_MAX {
            let line = expr.line;
            let kind = match self.peek() {
                TokenKind::Symbol("(") if !self.token().is_first => {
                    self.next += 1;
                    let args = self.arguments()?;
                    let callee = Box::new(expr);
                    ExprKind::Call { callee, args }
                }
                TokenKind::Symbol("[") if !self.token().is_first => {
                    self.next += 1;
                    let indices = self.items()?;
                    if !matches!(indices.len(), 1 | 2) {
                        return Err(SyntaxError::new(
                            line,
                            text!("an item has one index, or two", "元素有一个或两个下标"),
                        ));
                    }
                    let base = Box::new(expr);
                    ExprKind::Index { base, indices }
                }
                TokenKind::Symbol(".") => {
                    self.next += 1;
                    ExprKind::Field(Box::new(expr), self.name()?)
                }
                _ => return Ok(expr),
            };
            expr = Expr { line, kind };
        }
        let text = text!(
            "more than {CHAIN_MAX} calls, items and fields in a row",
            "连续的调用、元素和字段超过 {CHAIN_MAX} 个"
        );
        Err(SyntaxError::new(self.line(), text))
    }

    fn atom(&mut self) -> Parsed<Expr> {
        let line = self.line();
        let kind = match self.peek().clone() {
            TokenKind::Number(text) => {
                self.next += 1;
                ExprKind::Number(text)
            }
            TokenKind::Text(text) => {
                self.next += 1;
                ExprKind::Text(text)
            }
            TokenKind::PoseStart => {
                self.next += 1;
                let items = self.items()?;
                match items.len() {
                    6 => ExprKind::Pose(items),
                    // A variable called `p`.
                    1 | 2 => ExprKind::Index {
                        base: Box::new(Expr {
                            line,
                            kind: ExprKind::Name("p".to_owned()),
                        }),
                        indices: items,
                    },
                    count => {
                        let text = text!(
                            "a pose has six numbers, and this one {count}",
                            "位姿有六个数，而这里有 {count} 个"
                        );
                        return Err(SyntaxError::new(line, text));
                    }
                }
            }
            TokenKind::Symbol("[") => {
                self.next += 1;
                ExprKind::List(self.items()?)
            }
            TokenKind::Symbol("(") => {
                self.next += 1;
                let inner = self.expression()?;
                self.expect(")")?;
                ExprKind::Paren(Box::new(inner))
            }
            TokenKind::Word(word) => match word.as_str() {
                "True" | "true" => {
                    self.next += 1;
                    ExprKind::Bool(true)
                }
                "False" | "false" => {
                    self.next += 1;
                    ExprKind::Bool(false)
                }
                "run" => {
                    self.next += 1;
                    let name = self.name()?;
                    self.expect("(")?;
                    let args = self.arguments()?;
                    ExprKind::Run { name, args }
                }
                _ => ExprKind::Name(self.name()?),
            },
            _ => return self.error(text!("a value", "值")),
        };
        Ok(Expr { line, kind })
    }

    /// Values up to `]`.
    fn items(&mut self) -> Parsed<Vec<Expr>> {
        let mut items = Vec::new();
        while !self.accept("]") {
            items.push(self.expression()?);
            if !self.accept(",") && !self.is_symbol("]") {
                return self.error(text!("',' or ']'", "',' 或 ']'"));
            }
        }
        Ok(items)
    }

    /// Arguments up to `)`.
    fn arguments(&mut self) -> Parsed<Vec<Argument>> {
        let mut args = Vec::new();
        while !self.accept(")") {
            let value = self.expression()?;
            let argument = match value.kind {
                ExprKind::Name(name) if self.is_symbol("=") => {
                    self.next += 1;
                    Argument {
                        name: Some(name),
                        value: self.expression()?,
                    }
                }
                _ => Argument { name: None, value },
            };
            args.push(argument);
            if !self.accept(",") && !self.is_symbol(")") {
                return self.error(text!("',' or ')'", "',' 或 ')'"));
            }
        }
        Ok(args)
    }
}

fn is_keyword(word: &str) -> bool {
    matches!(
        word,
        "and"
            | "break"
            | "continue"
            | "def"
            | "elif"
            | "else"
            | "end"
            | "enter_critical"
            | "exit_critical"
            | "False"
            | "global"
            | "halt"
            | "if"
            | "join"
            | "kill"
            | "local"
            | "not"
            | "or"
            | "pass"
            | "return"
            | "run"
            | "sec"
            | "thread"
            | "True"
            | "while"
            | "xor"
    )
}
