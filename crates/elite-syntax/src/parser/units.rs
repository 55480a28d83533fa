//! A text that is read again after a change: lines of the top level whose text and surroundings are what they were keep
//! their trees.
//!
//! A unit is what the parser takes in one step at the top level: a statement with its blocks, or a line of simple ones.
//! What comes of it depends on its tokens, on up to [`LOOK_AHEAD`] behind them, and on whether the program assigns
//! `print`; and, if something in it is reported, on what else was. So a unit in which nothing was reported is kept when
//! those tokens and the text below them are the same.

use std::ops::Range;

use super::{Parser, parse_tokens};
use crate::ast::relocate::Shift;
use crate::ast::{Module, Stmt, StmtKind};
use crate::diagnostic::Diagnostic;
use crate::lexer::{Token, TokenKind, Tokens};
use crate::source::{SourceFile, Span};
use crate::work_budget::WorkBudget;

/// Tokens behind a unit that the parser may have looked at: the one it stops at, and two further ones.
const LOOK_AHEAD: usize = 3;

/// A part of a text that the parser took in one step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TopLevelUnit {
    /// The tokens of the unit.
    pub(crate) tokens: Range<usize>,
    /// The statements of the unit, in the body of the module.
    pub(crate) body: Range<usize>,
    /// The scopes in the unit.
    pub(crate) scopes: Range<u32>,
    /// The first byte of the unit's first token.
    pub(crate) start: u32,
    /// The directives that found their place while the unit was read.
    marks: Range<usize>,
    /// Nothing in the unit was reported.
    is_clean: bool,
    /// The number of this very unit in the reading before.
    pub(crate) origin: Option<usize>,
}

/// What the parser makes of a text, in units.
#[derive(Debug)]
pub(crate) struct ParsedUnits {
    pub(crate) module: Module,
    pub(crate) tokens: Vec<Token>,
    pub(crate) units: Vec<TopLevelUnit>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    print_is_assigned: bool,
    is_too_large: bool,
}

impl ParsedUnits {
    /// A text of which there is no tree.
    pub(crate) fn empty(tokens: Vec<Token>) -> Self {
        ParsedUnits {
            module: Module::EMPTY,
            tokens,
            units: Vec::new(),
            diagnostics: Vec::new(),
            print_is_assigned: false,
            is_too_large: true,
        }
    }
}

/// Where two texts differ: `old` was replaced by `new`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TextEdit {
    pub(crate) old: Range<usize>,
    pub(crate) new: Range<usize>,
}

impl TextEdit {
    /// The shortest piece that has to be replaced.
    pub(crate) fn diff(old: &str, new: &str) -> Self {
        const STEP: usize = 64;
        let (old, new) = (old.as_bytes(), new.as_bytes());
        let shorter = old.len().min(new.len());
        let mut start = 0;
        while start + STEP <= shorter && old[start..start + STEP] == new[start..start + STEP] {
            start += STEP;
        }
        while start < shorter && old[start] == new[start] {
            start += 1;
        }
        let (old_rest, new_rest) = (&old[start..], &new[start..]);
        let shorter = shorter - start;
        let mut kept = 0;
        while kept + STEP <= shorter
            && old_rest[old_rest.len() - kept - STEP..][..STEP]
                == new_rest[new_rest.len() - kept - STEP..][..STEP]
        {
            kept += STEP;
        }
        while kept < shorter
            && old_rest[old_rest.len() - kept - 1] == new_rest[new_rest.len() - kept - 1]
        {
            kept += 1;
        }
        TextEdit {
            old: start..old.len() - kept,
            new: start..new.len() - kept,
        }
    }

    /// Where something that begins at byte `start` of the new text began in the old one.
    fn old_start(&self, start: u32) -> Option<u32> {
        let at = start as usize;
        if at < self.new.start {
            return Some(start);
        }
        let behind = at.checked_sub(self.new.end)?;
        Some((self.old.end + behind) as u32)
    }
}

/// Parses a text of which `before` is an earlier state.
pub(crate) fn reparse(
    file: &SourceFile,
    lexed: Tokens,
    budget: &WorkBudget<'_>,
    before: Option<(ParsedUnits, TextEdit)>,
) -> ParsedUnits {
    let mut parser = parse_tokens(file, lexed, budget);
    let print_is_assigned = parser.print_is_assigned;
    let before = before.filter(|(old, _)| {
        old.print_is_assigned == print_is_assigned
            && !old.is_too_large
            && !parser.lexer_diagnostics.is_full()
    });
    let mut reader = UnitParser {
        body: Vec::new(),
        units: Vec::new(),
        old: before,
        next_old: 0,
    };
    while parser.kind() != TokenKind::EndOfFile {
        reader.unit(&mut parser);
    }
    parser.anchor_directives(u32::MAX, crate::ast::DirectiveAnchor::AtEnd);
    let tokens = std::mem::take(&mut parser.tokens);
    let is_too_large = parser.is_too_large;
    let parsed = parser.finish(reader.body);
    if is_too_large {
        reader.units.clear();
    }
    ParsedUnits {
        module: parsed.module,
        tokens,
        units: reader.units,
        diagnostics: parsed.diagnostics,
        print_is_assigned,
        is_too_large,
    }
}

struct UnitParser {
    body: Vec<Stmt>,
    units: Vec<TopLevelUnit>,
    old: Option<(ParsedUnits, TextEdit)>,
    /// The first unit of the old text that may still be met.
    next_old: usize,
}

impl UnitParser {
    fn unit(&mut self, parser: &mut Parser<'_>) {
        let start = parser.token().span.start;
        let (first, body) = (parser.at, self.body.len());
        let (scopes, marks) = (parser.scope_count, parser.claimed);
        let origin = self.reuse_unit(parser);
        let reports = (parser.report_count, parser.lexer_diagnostics.len());
        if origin.is_none() {
            parser.statement_or_recover(&mut self.body);
        } else if parser.diagnostics.is_full() {
            parser.at = parser.tokens.len() - 1;
        }
        self.units.push(TopLevelUnit {
            tokens: first..parser.at,
            body: body..self.body.len(),
            scopes: scopes..parser.scope_count,
            start,
            marks: marks..parser.claimed,
            is_clean: reports == (parser.report_count, parser.lexer_diagnostics.len())
                && !parser.lexer_diagnostics.is_full()
                && !parser.diagnostics.is_full(),
            origin,
        });
    }

    /// Takes over the tree of the old unit that the next tokens are, if there is one.
    fn reuse_unit(&mut self, parser: &mut Parser<'_>) -> Option<usize> {
        let start = parser.token().span.start;
        let (old, difference) = self.old.as_mut()?;
        let old_start = difference.old_start(start)?;
        let (number, unit) = loop {
            let unit = old.units.get(self.next_old)?;
            if unit.start >= old_start {
                break (self.next_old, unit.clone());
            }
            self.next_old += 1;
        };
        // Two units begin at one byte where blocks end there; they are told apart by what they begin with.
        if unit.start != old_start || !unit.is_clean {
            return None;
        }
        let shift = Shift::between((unit.start, unit.scopes.start), (start, parser.scope_count));
        let looked_at = unit.tokens.start..unit.tokens.end + LOOK_AHEAD;
        let is_same = looked_at.clone().all(|at| {
            let known = old.tokens.get(at);
            let token = parser.tokens.get(parser.at + at - unit.tokens.start);
            match (known, token) {
                (Some(known), Some(token)) => {
                    known.kind == token.kind && shift.moved(known.span) == token.span
                }
                (None, None) => true,
                _ => false,
            }
        });
        let end = old.tokens[..looked_at.end.min(old.tokens.len())]
            .last()?
            .span
            .end as usize;
        if !is_same || end >= difference.old.start && (unit.start as usize) < difference.old.end {
            return None;
        }
        // The directives before the unit belong to its first statement, those within it to where they belonged.
        let inner = |node: &crate::ast::NodeDirective| node.start >= unit.start;
        let old_marks: Vec<_> = old.module.nodes[unit.marks.clone()]
            .iter()
            .filter(|node| inner(node))
            .collect();
        let above = parser.marks[parser.claimed..]
            .iter()
            .take_while(|mark| mark.node.start < start)
            .count();
        // An empty line takes no directives.
        let takes = parser.kind() != TokenKind::Newline;
        let first = parser.claimed + if takes { above } else { 0 };
        let new_marks = parser.marks.get(first..first + old_marks.len())?;
        let are_same = old_marks.iter().zip(new_marks).all(|(old, new)| {
            shift.offset(old.start) == new.node.start && old.number == new.node.number
        });
        if !are_same {
            return None;
        }
        if takes {
            parser.anchor_directives(start, crate::ast::DirectiveAnchor::Before(start));
        }
        for old in &old_marks {
            parser.marks[parser.claimed].node.place = shift.node_place(old.place);
            parser.claimed += 1;
        }
        let from = self.body.len();
        for statement in &mut old.module.body[unit.body.clone()] {
            let gone = Stmt {
                kind: StmtKind::Pass,
                span: Span::default(),
            };
            self.body.push(std::mem::replace(statement, gone));
        }
        shift.statements(&mut self.body[from..]);
        parser.scope_count += unit.scopes.end - unit.scopes.start;
        parser.at += unit.tokens.len();
        self.next_old = number + 1;
        Some(number)
    }
}
