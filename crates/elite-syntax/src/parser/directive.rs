//! Directives: what they say, and which statement they belong to.
//!
//! `$ LINE: (7, "label")` names the node of the task tree that the statements after it were made from; a third part,
//! `"before"` or `"after"`, says when it is shown (from controller output, not from the manual). A directive is no
//! statement. It belongs to the block its column would put it in: a thread passes it before the next statement there,
//! or at the end of the block if there is none. Before `elif`, `else`, `except` and `finally` it belongs to that
//! clause.

use messages::{Text, text};

use super::{LOOK_EVERY, ParseResult, Parser};
use crate::ast::{Constant, DirectiveAnchor, Expr, ExprKind, NodeDirective, Stmt};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::quoted;
use crate::lexer::Directive;
use crate::source::Span;

/// Most characters of a label that are kept: it is repeated wherever the node is shown.
const LABEL_CHARS_MAX: usize = 200;

const FORM: Text = text!(
    "write '$ LINE: (7, \"name\")', with \"before\" or \"after\" as third part if wanted",
    "写作 '$ LINE: (7, \"name\")'，需要时第三部分为 \"before\" 或 \"after\""
);

/// A directive that says something, and where it stands.
pub(super) struct ParsedDirective {
    pub(super) node: NodeDirective,
    depth: u32,
    heads_clause: bool,
}

impl Parser<'_> {
    /// Reads the directives of the text, before its statements.
    pub(super) fn directives(&mut self, directives: &[Directive]) {
        for (index, directive) in directives.iter().enumerate() {
            if self.diagnostics.is_full() {
                return;
            }
            if index.is_multiple_of(LOOK_EVERY) && self.budget.is_spent() {
                self.is_too_large = true;
                self.at = self.tokens.len() - 1;
                return;
            }
            if let Ok(node) = self.line_directive(directive.span) {
                self.marks.push(ParsedDirective {
                    node,
                    depth: directive.depth,
                    heads_clause: directive.heads_clause,
                });
            }
        }
    }

    /// `$ LINE: (number, "label"[, "before"|"after"])`
    fn line_directive(&mut self, span: Span) -> ParseResult<NodeDirective> {
        let text = self.file.slice(span);
        let after = |at: usize| at + text[at..].len() - text[at..].trim_start().len();
        let word = after(1);
        let length = text[word..]
            .find(|c| !crate::lexer::continues_name(c))
            .unwrap_or(text.len() - word);
        let name = &text[word..word + length];
        let place = |at: usize, length: usize| {
            let start = span.start as usize + at;
            Span::new(start, start + length)
        };
        if name != "LINE" {
            let message = match name {
                "" => text!(
                    "a line that begins with '$' is a directive, and this one has no name",
                    "以 '$' 开头的行是指令，而这一行没有名称"
                ),
                _ => text!("there is no directive '{}'", "没有指令 '{}'", quoted(name)),
            };
            let span = place(0, (word + length).max(1));
            return self.directive_error(span, message);
        }
        let colon = after(word + length);
        if !text[colon..].starts_with(':') {
            let next = text[colon..].chars().next().map_or(0, char::len_utf8);
            return self.directive_error(
                place(colon, next),
                text!("expected ':' after '$ LINE'", "'$ LINE' 之后应为 ':'"),
            );
        }
        let parts = after(colon + 1);
        if !text[parts..].starts_with('(') {
            let next = text[parts..].chars().next().map_or(0, char::len_utf8);
            return self.directive_error(
                place(parts, next),
                text!("expected '(' after '$ LINE:'", "'$ LINE:' 之后应为 '('"),
            );
        }
        let start = span.start as usize + parts;
        let known = (self.lexer_diagnostics.len(), self.diagnostics.len());
        let place = Span::new(start, span.end as usize);
        let expr = self.field_expression(place, text!("the end of the line", "行尾"));
        if self.lexer_diagnostics.len() > known.0 {
            // What follows from a string that is not closed says nothing.
            self.diagnostics.truncate(known.1);
        }
        for (findings, known) in [
            (&mut self.lexer_diagnostics, known.0),
            (&mut self.diagnostics, known.1),
        ] {
            findings.change_from(known, |finding| {
                finding.code = "directive";
                finding.help.get_or_insert(FORM);
            });
        }
        self.node_mark(span.start, &expr?)
    }

    fn node_mark(&mut self, start: u32, expr: &Expr) -> ParseResult<NodeDirective> {
        let items = match &expr.kind {
            ExprKind::Tuple(items) if self.is_parenthesised(expr.span) => &items[..],
            _ => &[],
        };
        let (number, label, when) = match items {
            [number, label] => (number, label, None),
            [number, label, when] => (number, label, Some(when)),
            _ => {
                return self.directive_error(
                    expr.span,
                    text!(
                        "'$ LINE' takes a number and a text",
                        "'$ LINE' 需要一个数和一段文本"
                    ),
                );
            }
        };
        let node = match &number.kind {
            ExprKind::Constant(Constant::Int(node)) => u32::try_from(*node).ok(),
            _ => None,
        };
        let Some(node) = node.filter(|node| *node > 0) else {
            let given = quoted(self.file.slice(number.span));
            let message = text!(
                "the node of '$ LINE' must be a whole number from 1 to {}, not {given}",
                "'$ LINE' 的节点必须是 1 到 {} 的整数，不能是 {given}",
                u32::MAX
            );
            return self.directive_error(number.span, message);
        };
        let ExprKind::Constant(Constant::Str(label)) = &label.kind else {
            let given = quoted(self.file.slice(label.span));
            let message = text!(
                "the name in '$ LINE' must be a string literal, not {given}",
                "'$ LINE' 中的名称必须是字符串，不能是 {given}"
            );
            return self.directive_error(label.span, message);
        };
        let after = match when.map(|when| (&when.kind, when.span)) {
            None => false,
            Some((ExprKind::Constant(Constant::Str(when)), _)) if **when == *"before" => false,
            Some((ExprKind::Constant(Constant::Str(when)), _)) if **when == *"after" => true,
            Some((_, span)) => {
                let given = quoted(self.file.slice(span));
                let message = text!(
                    "the third part of '$ LINE' must be \"before\" or \"after\", not {given}",
                    "'$ LINE' 的第三部分必须是 \"before\" 或 \"after\"，不能是 {given}"
                );
                return self.directive_error(span, message);
            }
        };
        Ok(NodeDirective {
            number: node,
            label: shorten_label(label),
            start,
            after,
            place: DirectiveAnchor::AtEnd,
        })
    }

    fn directive_error<T>(&mut self, span: Span, message: Text) -> ParseResult<T> {
        let diagnostic = Diagnostic::error("directive", span, message);
        Err(self.report(diagnostic.with_help(FORM)))
    }

    /// Gives the directives that stand before byte `before`, and have no place yet, this one.
    pub(super) fn anchor_directives(&mut self, before: u32, place: DirectiveAnchor) {
        while let Some(mark) = self.marks.get_mut(self.claimed)
            && mark.node.start < before
        {
            mark.node.place = place;
            self.claimed += 1;
        }
    }

    /// At the end of the innermost block: the directives behind its last statement are its own by their column.
    pub(super) fn claim_at_end_of(&mut self, body: &[Stmt]) {
        let end = self.token().span.start;
        let Some(last) = body.last() else { return };
        while let Some(mark) = self.marks.get_mut(self.claimed)
            && mark.node.start < end
            && mark.depth >= self.depth
            && !mark.heads_clause
        {
            mark.node.place = DirectiveAnchor::After(last.span.start);
            self.claimed += 1;
        }
    }
}

fn shorten_label(label: &str) -> Box<str> {
    match label.char_indices().nth(LABEL_CHARS_MAX) {
        Some((cut, _)) => format!("{}…", &label[..cut]).into(),
        None => label.into(),
    }
}
