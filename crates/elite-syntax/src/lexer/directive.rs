//! Directives: lines that begin with `$`, which the pendant writes between statements. Wherever a comment may have a
//! line of its own, one of them may. A part of the lexer: finds them and where they stand; what they say is the
//! parser's business.

use super::Lexer;
use crate::source::Span;

/// A line with a directive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Directive {
    /// From its `$` to the end of the line.
    pub span: Span,
    /// How many blocks are open at its column.
    pub depth: u32,
    /// What follows is `elif`, `else`, `except` or `finally`.
    pub heads_clause: bool,
}

impl Lexer<'_> {
    /// Takes the directive that begins here, `depth` blocks deep, up to the end of its line.
    pub(super) fn directive(&mut self, depth: u32) {
        if self.directives.len() == self.directives.capacity() {
            let more = self.directives.len() * size_of::<Directive>();
            self.is_full |= self.budget.used() + more > self.budget.limit();
        }
        let start = self.at;
        self.skip_comment();
        self.directives.push(Directive {
            span: Span::new(start, self.at),
            depth,
            heads_clause: false,
        });
    }

    /// Whether the `$` here, between brackets, has a line of its own.
    pub(super) fn has_own_line(&self) -> bool {
        let line = &self.text[..self.at];
        let blanks = line.trim_end_matches([' ', '\t', '\u{c}']);
        self.takes_directives && !self.brackets.is_empty() && blanks.ends_with(['\n', '\r'])
    }

    /// At the first word of a line with statements: what the directives before it belong to.
    pub(super) fn settle_directives(&mut self) {
        if self.settled == self.directives.len() {
            return;
        }
        let rest = self.rest();
        let length = rest
            .find(|c| !super::names::continues_name(c))
            .unwrap_or(rest.len());
        let heads_clause = matches!(&rest[..length], "elif" | "else" | "except" | "finally");
        for directive in &mut self.directives[self.settled..] {
            directive.heads_clause = heads_clause;
        }
        self.settled = self.directives.len();
    }
}
