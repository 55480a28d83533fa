//! Statements with blocks: `if`, `while`, `for`, `try`, `with`, `def`, `sec`, `class`, decorators.

use messages::{Text, text};

use super::atom::ArgContext;
use super::{Context, ErrorReported, ParseResult, Parser};
use crate::ast::visit::blocks;
use crate::ast::{
    ClassDef, Constant, DirectiveAnchor, Expr, ExprKind, FunctionDef, Handler, Stmt, StmtKind,
    WithItem,
};
use crate::diagnostic::Diagnostic;
use crate::lexer::{Token, TokenKind as T};
use crate::source::Span;

/// Items of one `with`: each is a level of nesting.
const WITH_ITEMS_MAX: usize = 50;

impl Parser<'_> {
    /// The compound statement that starts here, or None if the line starts with anything else.
    pub(super) fn compound_statement(&mut self) -> ParseResult<Option<Stmt>> {
        let start = self.token().span;
        let kind = match self.kind() {
            T::If => self.if_statement()?,
            T::While => self.while_statement()?,
            T::For => self.for_statement()?,
            T::Try => self.try_statement()?,
            T::With => self.with_statement()?,
            T::Def => self.function(Vec::new(), false)?,
            T::Class => self.class(Vec::new())?,
            T::At => self.decorated_definition()?,
            T::Name if self.heads_secondary() => self.function(Vec::new(), true)?,
            T::Elif | T::Else | T::Except | T::Finally => return self.stray_clause(),
            _ => return Ok(None),
        };
        Ok(Some(Stmt {
            kind,
            span: self.span_from(start),
        }))
    }

    /// `sec name(` heads a secondary program; anywhere else `sec` is an ordinary name (language.md 5 and 7).
    fn heads_secondary(&self) -> bool {
        self.text(self.token()) == "sec"
            && self.kind_ahead(1) == T::Name
            && self.kind_ahead(2) == T::LeftParen
    }

    fn stray_clause<N>(&mut self) -> ParseResult<N> {
        let token = self.token();
        let word = self.text(token);
        let opener = match token.kind {
            T::Except | T::Finally => Text::verbatim("'try'"),
            _ => text!("'if', loop or 'try'", "'if'、循环或 'try'"),
        };
        let message = text!(
            "'{word}' without a matching {opener}",
            "'{word}' 没有对应的{opener}"
        );
        let mut diagnostic = Diagnostic::error("syntax", token.span, message);
        let after_end = self.at >= 2 && self.tokens[self.at - 2].kind == T::End;
        if after_end {
            diagnostic = diagnostic.with_help(text!(
                "'end' closes the whole statement: write it once, after the last branch",
                "'end' 结束整个语句：只在最后一个分支之后写一次"
            ));
        }
        Err(self.report(diagnostic))
    }

    /// `:` and the block after it, indented or on the same line. Returns whether the block was closed by an `end`
    /// at the column of its own lines, which also ends the statement.
    pub(super) fn block(&mut self, header: Text) -> ParseResult<Vec<Stmt>> {
        if self.eat(T::Colon).is_none() {
            let failed = self.unexpected_instead_of(
                Some(T::Colon),
                text!("':' after {header}", "{header}之后的 ':'"),
            );
            // A header that only lacks its colon keeps its block.
            if self.kind() != T::Newline || self.kind_ahead(1) != T::Indent {
                return failed;
            }
        }
        self.nested(|parser| {
            let mut body = Vec::new();
            if parser.eat(T::Newline).is_none() {
                if parser.compound_starts_here() {
                    let span = parser.token().span;
                    return parser.fail(
                        span,
                        text!(
                            "a statement with a block needs a line of its own",
                            "带块的语句需要单独一行"
                        ),
                    );
                }
                parser.simple_line(&mut body)?;
                return Ok(body);
            }
            if parser.eat(T::Indent).is_none() {
                let span = parser.token().span;
                let message = text!(
                    "expected an indented block after {header}",
                    "{header}之后应有缩进的块"
                );
                let finding = Diagnostic::error("indentation", span, message);
                parser.report(match parser.kind() {
                    T::End => finding.with_help(text!(
                        "a block that does nothing has 'pass' in it, a loop that waits 'sync()'",
                        "什么都不做的块写 'pass'，等待的循环写 'sync()'"
                    )),
                    _ => finding,
                });
                // The lines that follow are what they are.
                return Ok(body);
            }
            parser.depth += 1;
            let read = parser.block_lines(&mut body);
            parser.depth -= 1;
            read.map(|()| body)
        })
    }

    fn compound_starts_here(&self) -> bool {
        matches!(
            self.kind(),
            T::If | T::While | T::For | T::Try | T::With | T::Def | T::Class
        )
    }

    /// The lines of an indented block. An `end` at the column of these lines closes the block (rule 3).
    fn block_lines(&mut self, body: &mut Vec<Stmt>) -> ParseResult<()> {
        loop {
            match self.kind() {
                T::Dedent => {
                    self.claim_at_end_of(body);
                    self.bump();
                    return Ok(());
                }
                T::EndOfFile => return Ok(()),
                T::End => {
                    let end = self.bump();
                    self.end_of_line()?;
                    if self.kind() != T::Dedent && self.kind() != T::EndOfFile {
                        let span = self.token().span;
                        let message = text!(
                            "the block was closed by 'end' above, but its lines go on",
                            "块已由上面的 'end' 结束，但其行仍在继续"
                        );
                        let diagnostic = Diagnostic::error("misplaced-end", span, message);
                        self.report(
                            diagnostic.with_label(end.span, text!("closed here", "在此结束")),
                        );
                        continue;
                    }
                }
                _ => self.statement_or_recover(body),
            }
        }
    }

    fn loop_block(&mut self, header: Text) -> ParseResult<Vec<Stmt>> {
        let outer = std::mem::replace(&mut self.context.in_loop, true);
        let body = self.block(header);
        self.context.in_loop = outer;
        body
    }

    fn else_block(&mut self) -> ParseResult<Vec<Stmt>> {
        if self.eat(T::Else).is_none() {
            return Ok(Vec::new());
        }
        let (parsed, span) = (self.block(Text::verbatim("'else'")), self.token().span);
        let gap = Expr::new(ExprKind::Constant(Constant::Ellipsis), span);
        let parsed = parsed.map(|body| (gap, body));
        Ok(self.clause_or_rest(parsed, span).1)
    }

    fn condition(&mut self) -> ParseResult<Expr> {
        let test = self.named_expression()?;
        self.check_no_star(&test)?;
        Ok(test)
    }

    fn if_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        let test = self.condition()?;
        let mut branches = vec![(test, self.block(text!("the 'if' condition", "'if' 条件"))?)];
        while let Some(elif) = self.eat(T::Elif) {
            let parsed = self.elif_clause(elif);
            branches.push(self.clause_or_rest(parsed, elif.span));
        }
        let orelse = self.else_block()?;
        Ok(StmtKind::If { branches, orelse })
    }

    fn elif_clause(&mut self, elif: Token) -> ParseResult<(Expr, Vec<Stmt>)> {
        let test = self.condition()?;
        self.anchor_directives(elif.span.start, DirectiveAnchor::Before(test.span.start));
        Ok((
            test,
            self.block(text!("the 'elif' condition", "'elif' 条件"))?,
        ))
    }

    /// A further clause of a statement; of one that did not parse, what its block holds: the clauses before it stand.
    fn clause_or_rest(
        &mut self,
        parsed: ParseResult<(Expr, Vec<Stmt>)>,
        span: Span,
    ) -> (Expr, Vec<Stmt>) {
        parsed.unwrap_or_else(|ErrorReported| {
            let mut body = Vec::new();
            self.skip_line_and_block(&mut body);
            let gap = Expr::new(ExprKind::Constant(Constant::Ellipsis), span);
            (gap, body)
        })
    }

    fn while_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        let test = self.condition()?;
        let body = self.loop_block(text!("the 'while' condition", "'while' 条件"))?;
        let orelse = self.else_block()?;
        Ok(StmtKind::While { test, body, orelse })
    }

    fn for_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        let target = self.target_list()?;
        self.expect(T::In)?;
        let iterable = self.star_list()?;
        self.check_no_star(&iterable)?;
        let body = self.loop_block(text!("the 'for' line", "'for' 行"))?;
        let orelse = self.else_block()?;
        Ok(StmtKind::For {
            target,
            iterable,
            body,
            orelse,
        })
    }

    fn try_statement(&mut self) -> ParseResult<StmtKind> {
        let start = self.bump().span;
        let body = self.block(Text::verbatim("'try'"))?;
        let mut handlers: Vec<Handler> = Vec::new();
        let mut bare: Option<Span> = None;
        while self.kind() == T::Except {
            let start = self.token().span;
            let handler = self.handler().unwrap_or_else(|ErrorReported| {
                let mut body = Vec::new();
                self.skip_line_and_block(&mut body);
                Handler {
                    star: false,
                    exception: None,
                    name: None,
                    body,
                    span: start,
                }
            });
            if handlers
                .first()
                .is_some_and(|first| first.star != handler.star)
            {
                let message = text!(
                    "cannot have both 'except' and 'except*' on the same 'try'",
                    "同一个 'try' 不能同时有 'except' 和 'except*'"
                );
                self.report(Diagnostic::error("syntax", handler.span, message));
            }
            if let Some(bare) = bare {
                let message = text!(
                    "a bare 'except:' must be the last one",
                    "不带类型的 'except:' 必须是最后一个"
                );
                self.report(Diagnostic::error("syntax", bare, message));
            }
            if handler.exception.is_none() {
                bare.get_or_insert(handler.span);
            }
            handlers.push(handler);
        }
        let orelse = if handlers.is_empty() {
            Vec::new()
        } else {
            self.else_block()?
        };
        let has_finally = self.eat(T::Finally).is_some();
        let finally = if has_finally {
            self.block(Text::verbatim("'finally'"))?
        } else {
            Vec::new()
        };
        if handlers.is_empty() && !has_finally {
            let message = text!(
                "'try' needs at least one 'except' or a 'finally'",
                "'try' 至少需要一个 'except' 或 'finally'"
            );
            self.report(Diagnostic::error("syntax", start, message));
        }
        Ok(StmtKind::Try {
            body,
            handlers,
            orelse,
            finally,
        })
    }

    fn handler(&mut self) -> ParseResult<Handler> {
        let start = self.bump().span;
        let star = self.eat(T::Star);
        let mut exception = None;
        let mut name = None;
        if self.kind() != T::Colon {
            let first = self.expression()?;
            if self.kind() == T::Comma {
                let span = self.token().span;
                let message = text!(
                    "several exception types need parentheses",
                    "多个异常类型需要括号"
                );
                let help = text!(
                    "write 'except (A, B):'; to name the exception, 'except A as e:'",
                    "请写 'except (A, B):'；命名异常写 'except A as e:'"
                );
                return Err(self.report(Diagnostic::error("syntax", span, message).with_help(help)));
            }
            exception = Some(first);
            if self.eat(T::As).is_some() {
                name = Some(self.ident()?);
            }
        } else if let Some(star) = star {
            let message = text!(
                "'except*' needs the types it takes",
                "'except*' 需要给出异常类型"
            );
            return self.fail(start.to(star.span), message);
        }
        let span = self.span_from(start);
        let body = self.block(Text::verbatim("'except'"))?;
        if star.is_some() {
            self.check_no_leaving(&body, false);
        }
        Ok(Handler {
            star: star.is_some(),
            exception,
            name,
            body,
            span,
        })
    }

    /// Reports what would leave the body of an `except*`: the exceptions that remain could not be raised any more.
    fn check_no_leaving(&mut self, body: &[Stmt], in_loop: bool) {
        for statement in body {
            let leaves = match &statement.kind {
                StmtKind::Return(_) => true,
                StmtKind::Break | StmtKind::Continue => !in_loop,
                _ => false,
            };
            if leaves {
                let message = text!(
                    "'break', 'continue' and 'return' cannot appear in an except* block",
                    "'break'、'continue' 和 'return' 不能出现在 except* 块中"
                );
                self.report(Diagnostic::error("syntax", statement.span, message));
            }
            match &statement.kind {
                StmtKind::Function(_) | StmtKind::Class(_) => {}
                StmtKind::While { body, orelse, .. } | StmtKind::For { body, orelse, .. } => {
                    self.check_no_leaving(body, true);
                    self.check_no_leaving(orelse, in_loop);
                }
                StmtKind::Try {
                    body,
                    handlers,
                    orelse,
                    finally,
                } => {
                    // The bodies of an inner `except*` have been looked at already, and not less strictly.
                    let caught = handlers.iter().filter(|handler| !handler.star);
                    let caught = caught.map(|handler| &handler.body);
                    for block in [body, orelse, finally].into_iter().chain(caught) {
                        self.check_no_leaving(block, in_loop);
                    }
                }
                _ => {
                    for block in blocks(statement) {
                        self.check_no_leaving(block, in_loop);
                    }
                }
            }
        }
    }

    fn with_statement(&mut self) -> ParseResult<StmtKind> {
        self.bump();
        let items = match self.parenthesised_with_items() {
            Some(items) => items,
            None => self.with_items(T::Colon)?,
        };
        let body = self.block(text!("the 'with' line", "'with' 行"))?;
        Ok(StmtKind::With { items, body })
    }

    /// `with (a as b, c):` — tried first, given up without a trace if the parentheses belong to an expression.
    fn parenthesised_with_items(&mut self) -> Option<Vec<WithItem>> {
        if self.kind() != T::LeftParen {
            return None;
        }
        let (at, scopes) = (self.at, self.scope_count);
        let (lexed, reported) = (self.lexer_diagnostics.len(), self.diagnostics.len());
        self.bump();
        let items = self
            .with_items(T::RightParen)
            .ok()
            .filter(|items| !items.is_empty());
        let closed = self.eat(T::RightParen).is_some() && self.kind() == T::Colon;
        if let Some(items) = items.filter(|_| closed) {
            return Some(items);
        }
        (self.at, self.scope_count) = (at, scopes);
        self.lexer_diagnostics.truncate(lexed);
        self.diagnostics.truncate(reported);
        None
    }

    fn with_items(&mut self, closer: T) -> ParseResult<Vec<WithItem>> {
        let mut items = Vec::new();
        loop {
            let context = self.expression()?;
            let target = if self.eat(T::As).is_some() {
                let target = self.target_item()?;
                self.check_target(&target)?;
                Some(target)
            } else {
                None
            };
            items.push(WithItem { context, target });
            if items.len() > WITH_ITEMS_MAX {
                let span = self.token().span;
                return self.fail(
                    span,
                    text!(
                        "more than {WITH_ITEMS_MAX} items in one 'with'",
                        "一个 'with' 中超过 {WITH_ITEMS_MAX} 项"
                    ),
                );
            }
            // A comma may stand at the end between brackets only.
            let is_last = self.eat(T::Comma).is_none();
            if is_last || closer == T::RightParen && self.kind() == closer {
                return Ok(items);
            }
        }
    }

    fn decorated_definition(&mut self) -> ParseResult<StmtKind> {
        let mut decorators = Vec::new();
        while self.eat(T::At).is_some() {
            decorators.push(self.named_expression()?);
            self.end_of_line()?;
        }
        match self.kind() {
            T::Def => self.function(decorators, false),
            T::Class => self.class(decorators),
            T::Async => {
                let span = self.token().span;
                self.not_supported(span, Text::verbatim("'async'"))
            }
            _ => self.unexpected(text!(
                "'def' or 'class' after the decorator",
                "装饰器之后的 'def' 或 'class'"
            )),
        }
    }

    fn function(&mut self, decorators: Vec<Expr>, secondary: bool) -> ParseResult<StmtKind> {
        self.bump();
        let name = self.ident()?;
        let scope = self.new_scope();
        self.expect(T::LeftParen)?;
        let parameters = self.parameters(T::RightParen)?;
        self.expect(T::RightParen)?;
        let returns = if self.eat(T::Arrow).is_some() {
            Some(self.expression()?)
        } else {
            None
        };
        let inner = Context {
            in_function: true,
            ..Context::default()
        };
        let outer = std::mem::replace(&mut self.context, inner);
        let body = self.block(text!("the function header", "函数头"));
        self.context = outer;
        let body = body?;
        let def = FunctionDef {
            name,
            parameters,
            returns,
            decorators,
            body,
            secondary,
            scope,
        };
        Ok(StmtKind::Function(Box::new(def)))
    }

    fn class(&mut self, decorators: Vec<Expr>) -> ParseResult<StmtKind> {
        self.bump();
        let name = self.ident()?;
        let scope = self.new_scope();
        let args = if self.eat(T::LeftParen).is_some() {
            self.arguments(ArgContext::OfClass)?
        } else {
            Vec::new()
        };
        let inner = Context::default();
        let outer = std::mem::replace(&mut self.context, inner);
        self.classes.push(name.name.clone());
        let body = self.block(text!("the class header", "类头"));
        self.classes.pop();
        self.context = outer;
        Ok(StmtKind::Class(Box::new(ClassDef {
            name,
            args,
            decorators,
            body: body?,
            scope,
        })))
    }

    /// The targets between `for` and `in`.
    pub(super) fn target_list(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let first = self.target_item()?;
        let target = if self.kind() == T::Comma {
            let mut items = vec![first];
            while self.eat(T::Comma).is_some() && self.kind() != T::In {
                items.push(self.target_item()?);
            }
            Expr::new(ExprKind::Tuple(items), self.span_from(start))
        } else {
            first
        };
        self.check_target(&target)?;
        Ok(target)
    }
}
