//! Simple statements, and how lines are put together from them.

use messages::{Text, text};

use super::{ErrorReported, ParseResult, Parser};
use crate::ast::{BinaryOp, DirectiveAnchor, Expr, ExprKind, Ident, ImportAlias, Stmt, StmtKind};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::quoted;
use crate::lexer::TokenKind as T;
use crate::source::Span;
use crate::suggestions::nearest;

impl Parser<'_> {
    /// One statement (or one line of them) into `body`. After an error, skips to the next line; what is indented
    /// below a header that did not parse is still read for its errors.
    pub(super) fn statement_or_recover(&mut self, body: &mut Vec<Stmt>) {
        let before = self.at;
        match self.statement(body) {
            Ok(()) => {}
            Err(ErrorReported) => {
                let reported = self.diagnostics.len();
                let unsupported = self
                    .diagnostics
                    .iter()
                    .last()
                    .is_some_and(|last| last.code == "not-supported");
                self.recover(before, body);
                if unsupported {
                    // What its block holds makes no sense on its own.
                    self.diagnostics.truncate(reported);
                }
            }
        }
        if self.diagnostics.is_full() {
            // Nothing that could follow would be reported.
            self.at = self.tokens.len() - 1;
        }
        if self.at == before {
            self.bump();
        }
    }

    /// Leaves a statement that did not parse and began with token `first`: its line, the block below it, and what
    /// belongs to that block. What can be told of it stays in the tree, for those who read programs while they are
    /// written.
    fn recover(&mut self, first: usize, body: &mut Vec<Stmt>) {
        let mut below = Vec::new();
        if self.skip_line_and_block(&mut below) {
            // The clauses and the `end` of the statement mean nothing without its header; only what they hold is read.
            while matches!(self.kind(), T::Elif | T::Else | T::Except | T::Finally) {
                self.skip_line_and_block(&mut below);
            }
            if self.eat(T::End).is_some() {
                self.eat(T::Newline);
            }
        }
        self.recover_statement(first, below, body);
    }

    /// Skips the rest of the line; whether a block was below it, whose statements go into `below`.
    pub(super) fn skip_line_and_block(&mut self, below: &mut Vec<Stmt>) -> bool {
        while !matches!(
            self.kind(),
            T::Newline | T::EndOfFile | T::Indent | T::Dedent
        ) {
            self.bump();
        }
        self.eat(T::Newline);
        if self.eat(T::Indent).is_none() {
            return false;
        }
        while !matches!(self.kind(), T::Dedent | T::EndOfFile) {
            self.statement_or_recover(below);
        }
        self.eat(T::Dedent);
        true
    }

    fn statement(&mut self, body: &mut Vec<Stmt>) -> ParseResult<()> {
        match self.kind() {
            T::Newline => {
                self.bump();
                Ok(())
            }
            T::Indent => self.unexpected_indent(body),
            T::End => self.misplaced_end(),
            _ => self.ordinary_statement(body),
        }
    }

    fn ordinary_statement(&mut self, body: &mut Vec<Stmt>) -> ParseResult<()> {
        let start = self.token().span.start;
        self.anchor_directives(start, DirectiveAnchor::Before(start));
        match self.compound_statement()? {
            Some(statement) => {
                body.push(statement);
                // `end` at the column of the header closes the whole statement (language.md 4.1, rules 2 and 4).
                if self.eat(T::End).is_some() {
                    self.end_of_line()?;
                }
                Ok(())
            }
            None => self.simple_line(body),
        }
    }

    fn unexpected_indent(&mut self, body: &mut Vec<Stmt>) -> ParseResult<()> {
        self.bump();
        let span = self.token().span;
        let mut finding = Diagnostic::error(
            "indentation",
            span,
            text!(
                "this line is indented, but no block is open",
                "这一行有缩进，但没有打开的块"
            ),
        );
        if let Some(help) = self.tab_advice(span) {
            finding = finding.with_help(help);
        }
        let failed = self.report(finding);
        // Read the block as if it were not indented, so that its own errors show too.
        while !matches!(self.kind(), T::Dedent | T::EndOfFile) {
            self.statement_or_recover(body);
        }
        self.eat(T::Dedent);
        let _ = failed;
        Ok(())
    }

    /// What to do about a line that begins with a tab: what looks like four columns are eight.
    fn tab_advice(&self, first: Span) -> Option<Text> {
        let before = &self.file.text()[..first.start as usize];
        let line = before.rfind(['\n', '\r']).map_or(0, |end| end + 1);
        before[line..].contains('\t').then_some(text!(
            "this line begins with a tab, which goes to the next multiple of 8 columns: use \
                 blanks, as the lines around it",
            "这一行以制表符开头，制表符跳到 8 的下一个倍数列：请像周围的行一样使用空格"
        ))
    }

    fn misplaced_end(&mut self) -> ParseResult<()> {
        let token = self.bump();
        let message = text!(
            "this 'end' closes nothing: no block starts at its column",
            "这个 'end' 没有可结束的块：没有块从它所在的列开始"
        );
        Err(self.report(Diagnostic::error("misplaced-end", token.span, message)))
    }

    /// Simple statements separated by `;` up to the end of the line.
    pub(super) fn simple_line(&mut self, body: &mut Vec<Stmt>) -> ParseResult<()> {
        loop {
            body.push(self.simple_statement()?);
            if self.eat(T::Semicolon).is_none() {
                return self.end_of_line();
            }
            while self.eat(T::Semicolon).is_some() {}
            if self.eat(T::Newline).is_some() {
                return Ok(());
            }
        }
    }

    pub(super) fn end_of_line(&mut self) -> ParseResult<()> {
        if self.eat(T::Newline).is_some() || self.kind() == T::EndOfFile {
            return Ok(());
        }
        self.unexpected(text!("the end of the line", "行尾"))
    }

    fn simple_statement(&mut self) -> ParseResult<Stmt> {
        let start = self.token().span;
        let kind = match self.kind() {
            T::Pass => self.keyword(StmtKind::Pass),
            T::Break => self.loop_exit(StmtKind::Break, "break")?,
            T::Continue => self.loop_exit(StmtKind::Continue, "continue")?,
            T::Return => self.return_statement()?,
            T::Raise => self.raise_statement()?,
            T::Global => {
                self.bump();
                let names = self.names()?;
                self.check_no_value(start, &names)?;
                StmtKind::Global(names)
            }
            T::Nonlocal => {
                self.bump();
                StmtKind::Nonlocal(self.names()?)
            }
            T::Del => self.del_statement()?,
            T::Assert => self.assert_statement()?,
            T::Import => self.import_statement()?,
            T::From => self.import_from()?,
            T::Name if self.starts_print_statement() => self.print_statement()?,
            _ => self.expression_statement()?,
        };
        Ok(Stmt {
            kind,
            span: self.span_from(start),
        })
    }

    /// `global x = 3` of other robots declares and sets in one.
    fn check_no_value(&mut self, start: Span, names: &[Ident]) -> ParseResult<()> {
        if self.kind() != T::Equal {
            return Ok(());
        }
        let text = text!(
            "a 'global' line only says which names are global, it sets nothing",
            "'global' 行只声明哪些名称是全局的，不赋值"
        );
        let finding = Diagnostic::error("syntax", self.token().span, text);
        Err(self.report(match names {
            // Names of the top level are global without a word.
            [_] if !self.context.in_function => finding
                .with_help(text!(
                    "leave out the word 'global' here: names of the top level are global",
                    "这里去掉 'global' 一词：顶层的名称就是全局的"
                ))
                .with_fix(
                    Span::new(start.start as usize, names[0].span.start as usize),
                    "",
                ),
            _ => finding.with_help(text!(
                "set the name on a line of its own, below this one",
                "在下面单独写一行给它赋值"
            )),
        }))
    }

    fn keyword(&mut self, kind: StmtKind) -> StmtKind {
        self.bump();
        kind
    }

    fn loop_exit(&mut self, kind: StmtKind, word: &str) -> ParseResult<StmtKind> {
        let token = self.bump();
        if !self.context.in_loop {
            return self.fail(
                token.span,
                text!("'{word}' outside a loop", "'{word}' 不在循环内"),
            );
        }
        Ok(kind)
    }

    fn at_statement_end(&self) -> bool {
        matches!(self.kind(), T::Newline | T::Semicolon | T::EndOfFile)
    }

    fn return_statement(&mut self) -> ParseResult<StmtKind> {
        let token = self.bump();
        if !self.context.in_function {
            self.report(Diagnostic::error(
                "syntax",
                token.span,
                text!("'return' outside a function", "'return' 不在函数内"),
            ));
        }
        let value = if self.at_statement_end() {
            None
        } else {
            Some(self.star_list()?)
        };
        Ok(StmtKind::Return(value))
    }

    fn raise_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        if self.at_statement_end() {
            return Ok(StmtKind::Raise {
                exception: None,
                cause: None,
            });
        }
        let exception = Some(self.expression()?);
        let cause = if self.eat(T::From).is_some() {
            Some(self.expression()?)
        } else {
            None
        };
        Ok(StmtKind::Raise { exception, cause })
    }

    fn names(&mut self) -> ParseResult<Vec<Ident>> {
        let mut names = vec![self.ident()?];
        while self.eat(T::Comma).is_some() {
            names.push(self.ident()?);
        }
        Ok(names)
    }

    fn del_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        let list = self.star_list()?;
        let targets = match list.kind {
            ExprKind::Tuple(items) if !self.is_parenthesised(list.span) => items,
            _ => vec![list],
        };
        for target in &targets {
            self.check_delete_target(target)?;
        }
        Ok(StmtKind::Delete(targets))
    }

    fn assert_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        let test = self.expression()?;
        let message = if self.eat(T::Comma).is_some() {
            Some(self.expression()?)
        } else {
            None
        };
        Ok(StmtKind::Assert { test, message })
    }

    fn dotted_name(&mut self) -> ParseResult<Ident> {
        let first = self.ident()?;
        let (mut name, mut span) = (String::from(first.name), first.span);
        while self.eat(T::Dot).is_some() {
            let part = self.ident()?;
            name.push('.');
            name.push_str(&part.name);
            span = span.to(part.span);
        }
        Ok(Ident {
            name: name.into(),
            span,
        })
    }

    fn alias(&mut self) -> ParseResult<Option<Ident>> {
        if self.eat(T::As).is_none() {
            return Ok(None);
        }
        self.ident().map(Some)
    }

    fn import_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        let mut names = Vec::new();
        loop {
            let name = self.dotted_name()?;
            let alias = self.alias()?;
            names.push(ImportAlias { name, alias });
            if self.eat(T::Comma).is_none() {
                return Ok(StmtKind::Import(names));
            }
        }
    }

    fn import_from(&mut self) -> ParseResult<StmtKind> {
        let start = self.bump().span;
        let module = self.module_name(start)?;
        self.expect(T::Import)?;
        if self.eat(T::Star).is_some() {
            return Ok(StmtKind::ImportFrom {
                module,
                names: Vec::new(),
                star: true,
            });
        }
        let parenthesised = self.eat(T::LeftParen).is_some();
        let mut names = Vec::new();
        loop {
            let name = self.ident()?;
            let alias = self.alias()?;
            names.push(ImportAlias { name, alias });
            let more = self.eat(T::Comma).is_some();
            if !more || (parenthesised && self.kind() == T::RightParen) {
                break;
            }
        }
        if parenthesised {
            self.expect(T::RightParen)?;
        }
        Ok(StmtKind::ImportFrom {
            module,
            names,
            star: false,
        })
    }

    /// The module after `from`: a dotted name, with dots before it, or dots alone, if it is relative.
    fn module_name(&mut self, start: Span) -> ParseResult<Ident> {
        let mut dots = String::new();
        loop {
            match self.kind() {
                T::Dot => dots.push('.'),
                T::Ellipsis => dots.push_str("..."),
                _ => break,
            }
            self.bump();
        }
        if dots.is_empty() {
            return self.dotted_name();
        }
        if self.kind() != T::Import {
            dots.push_str(&self.dotted_name()?.name);
        }
        Ok(Ident {
            name: dots.into(),
            span: self.span_from(start),
        })
    }

    /// Whether the script gives the name `print` another meaning; then `print x` is no statement (language.md 4.3).
    pub(super) fn assigns_print(&self) -> bool {
        self.tokens.windows(2).any(|pair| {
            self.budget.charge(2);
            let [first, second] = pair else { return false };
            let binds = matches!(
                first.kind,
                T::Def | T::Class | T::As | T::For | T::Global | T::Import
            );
            let is_print =
                |token: &crate::lexer::Token| token.kind == T::Name && self.text(*token) == "print";
            (binds && is_print(second)) || (is_print(first) && second.kind == T::Equal)
        })
    }

    fn starts_print_statement(&self) -> bool {
        if self.print_is_assigned || self.text(self.token()) != "print" {
            return false;
        }
        matches!(
            self.kind_ahead(1),
            T::Newline
                | T::Semicolon
                | T::EndOfFile
                | T::Name
                | T::Int
                | T::Float
                | T::Imaginary
                | T::Str
                | T::None
                | T::True
                | T::False
                | T::Not
                | T::Lambda
                | T::LeftBracket
                | T::LeftBrace
                | T::Minus
                | T::Plus
                | T::Tilde
        )
    }

    fn print_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        let mut values = Vec::new();
        let mut trailing_comma = false;
        while !self.at_statement_end() {
            values.push(self.expression()?);
            trailing_comma = self.eat(T::Comma).is_some();
            if !trailing_comma && !self.at_statement_end() {
                return self.unexpected(text!("',' or the end of the line", "',' 或行尾"));
            }
        }
        Ok(StmtKind::Print {
            values,
            trailing_comma,
        })
    }

    fn expression_statement(&mut self) -> ParseResult<StmtKind> {
        let start = self.token().span;
        self.reject_reserved_statements()?;
        let first = self.expression_list()?;
        if self.kind() == T::Colon {
            return self.annotated_assignment(first);
        }
        if let Some(op) = augmented_op(self.kind()) {
            self.bump();
            self.check_augmented_target(&first)?;
            let value = self.value_list()?;
            return Ok(StmtKind::AugAssign {
                target: first,
                op,
                value,
            });
        }
        if self.kind() != T::Equal {
            self.check_no_star(&first)?;
            return self.expression_alone(first, start);
        }
        let mut targets = Vec::new();
        let mut value = first;
        while self.eat(T::Equal).is_some() {
            self.check_target(&value)?;
            targets.push(value);
            value = self.value_list()?;
        }
        self.check_no_star(&value)?;
        Ok(StmtKind::Assign { targets, value })
    }

    /// An expression as a statement; two expressions side by side get advice where the likely slip is known.
    fn expression_alone(&mut self, expr: Expr, start: Span) -> ParseResult<StmtKind> {
        if !self.at_statement_end() {
            let word = self.file.slice(expr.span);
            let token = self.token();
            let two_names = matches!(expr.kind, ExprKind::Name(_)) && token.kind == T::Name;
            if two_names {
                let message = text!(
                    "'{} {}': two names side by side mean nothing",
                    "'{} {}'：两个名称并列没有意义",
                    quoted(word),
                    quoted(self.text(token))
                );
                let mut diagnostic = Diagnostic::error("syntax", start.to(token.span), message);
                let head = head_of_elsewhere(word)
                    .map(str::to_owned)
                    .or_else(|| nearest(word, HEADS.iter()));
                if let Some(help) = slip(word) {
                    diagnostic = diagnostic.with_help(help);
                } else if let Some(head) = head {
                    diagnostic = diagnostic
                        .with_help(text!("did you mean '{head}'", "是否想写 '{head}'"))
                        .with_fix(expr.span, head);
                }
                return Err(self.report(diagnostic));
            }
        }
        Ok(StmtKind::Expr(expr))
    }

    /// `async`, `await`, `match` and `type` statements are Python, but not part of this language.
    fn reject_reserved_statements(&mut self) -> ParseResult<()> {
        let token = self.token();
        match token.kind {
            T::Async => return self.not_supported(token.span, Text::verbatim("'async'")),
            T::Await => return self.not_supported(token.span, Text::verbatim("'await'")),
            T::Name => {}
            _ => return Ok(()),
        }
        let next = self.kind_ahead(1);
        let starts_operand = matches!(
            next,
            T::Name | T::Int | T::Float | T::Str | T::None | T::True | T::False
        );
        match self.text(token) {
            "match" if starts_operand => {
                self.not_supported(token.span, text!("the 'match' statement", "'match' 语句"))
            }
            "type" if next == T::Name => {
                self.not_supported(token.span, text!("the 'type' statement", "'type' 语句"))
            }
            _ => Ok(()),
        }
    }

    fn annotated_assignment(&mut self, target: Expr) -> ParseResult<StmtKind> {
        let simple = matches!(
            target.kind,
            ExprKind::Name(_) | ExprKind::Attribute { .. } | ExprKind::Subscript { .. }
        );
        if !simple {
            let span = self.token().span;
            return self.fail(
                span,
                text!(
                    "':' after an expression: only a name, an attribute or an item can be \
                     annotated",
                    "表达式后的 ':'：只有名称、属性或元素可以带注解"
                ),
            );
        }
        self.bump();
        let annotation = self.expression()?;
        let value = if self.eat(T::Equal).is_some() {
            Some(self.value_list()?)
        } else {
            None
        };
        Ok(StmtKind::AnnAssign {
            target,
            annotation,
            value,
        })
    }

    /// The right-hand side of an assignment: `yield`, or expressions separated by commas.
    pub(super) fn value_list(&mut self) -> ParseResult<Expr> {
        self.expression_list()
    }
}

/// Words that head a statement and stand before a name.
const HEADS: [&str; 15] = [
    "assert", "class", "def", "del", "elif", "for", "from", "global", "import", "nonlocal",
    "print", "raise", "return", "while", "with",
];

/// The word for what heads a statement elsewhere.
fn head_of_elsewhere(word: &str) -> Option<&'static str> {
    Some(match word {
        "elseif" | "elsif" => "elif",
        "function" | "func" | "fun" | "define" => "def",
        "foreach" => "for",
        _ => return None,
    })
}

/// What somebody meant who wrote another language's word that has none of its own here.
fn slip(word: &str) -> Option<Text> {
    Some(match word {
        "let" | "var" | "const" | "local" => text!(
            "variables are not declared: write 'name = value'",
            "变量无需声明：请写 'name = value'"
        ),
        "switch" | "case" => text!(
            "there is no switch: use 'if' and 'elif'",
            "没有 switch：请用 'if' 和 'elif'"
        ),
        "thread" => {
            text!(
                "a thread is a function that start_thread() begins: write 'def' in place of \
                 'thread'",
                "线程是由 start_thread() 启动的函数：把 'thread' 改为 'def'"
            )
        }
        "int" | "float" | "double" | "bool" | "string" | "auto" => {
            text!(
                "variables are not declared: write 'name = value'",
                "变量无需声明：请写 'name = value'"
            )
        }
        "until" => text!(
            "write 'while not' and the condition",
            "写 'while not' 加条件"
        ),
        "repeat" | "loop" => text!(
            "write 'for i in range(n):' or 'while True:'",
            "写 'for i in range(n):' 或 'while True:'"
        ),
        _ => return None,
    })
}

fn augmented_op(kind: T) -> Option<BinaryOp> {
    Some(match kind {
        T::PlusEqual => BinaryOp::Add,
        T::MinusEqual => BinaryOp::Sub,
        T::StarEqual => BinaryOp::Mul,
        T::SlashEqual => BinaryOp::Div,
        T::DoubleSlashEqual => BinaryOp::FloorDiv,
        T::PercentEqual => BinaryOp::Mod,
        T::DoubleStarEqual => BinaryOp::Pow,
        T::AtEqual => BinaryOp::MatMul,
        T::AmpersandEqual => BinaryOp::BitAnd,
        T::BarEqual => BinaryOp::BitOr,
        T::CaretEqual => BinaryOp::BitXor,
        T::LeftShiftEqual => BinaryOp::Shl,
        T::RightShiftEqual => BinaryOp::Shr,
        _ => return None,
    })
}
