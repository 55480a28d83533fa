//! The one-line form `def f():; a(); b();end;` (manual 2.1.1, language.md 4.2): where its parts start and how
//! blocks are read from them. A part of the lexer; makes no tokens itself.

use crate::work_budget::WorkBudget;

/// Work for one byte.
const BYTE: usize = 4;

/// One physical line in which a `;` stands for a line end.
pub(super) struct OneLineForm {
    parts: Vec<LinePart>,
    /// Blocks cannot be read from blanks, so they are read from headers and `end`.
    pub(super) by_terminators: bool,
    /// Only by terminators: the part before was a header, the next one opens its block.
    pub(super) header_open: bool,
    /// Only by terminators: blocks opened on this line and not yet closed.
    pub(super) synthetic: u32,
}

/// What a part does to the blocks around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LinePartKind {
    Plain,
    /// `else`, `elif`, `except`, `finally`.
    Continuation,
    /// `end`
    Terminator,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct LinePart {
    start: usize,
    pub(super) column: u32,
    pub(super) kind: LinePartKind,
    /// The part ends with `:`.
    pub(super) is_header: bool,
}

impl OneLineForm {
    /// Looks at the physical line that starts at `start` (after its indentation, which reaches `column`).
    /// None if it is not in this form, which is the case unless a part ends with `:` before a `;`.
    pub(super) fn scan(
        text: &str,
        (start, end): (usize, usize),
        column: u32,
        budget: &WorkBudget<'_>,
    ) -> Option<OneLineForm> {
        let line = &text[start..end];
        let line = &line[..line.find(['\n', '\r']).unwrap_or(line.len())];
        // Cheap test first: nearly every line ends here.
        if !line.contains(';') {
            return None;
        }
        let parts = split(line, start, column, budget);
        let (_, before_last) = parts.split_last()?;
        let one_line = before_last.iter().any(|part| part.is_header);
        if !one_line {
            return None;
        }
        let by_terminators = !blocks_by_columns(&parts);
        let header_open = parts.first().is_some_and(|part| part.is_header);
        Some(OneLineForm {
            parts,
            by_terminators,
            header_open,
            synthetic: 0,
        })
    }

    pub(super) fn part_at(&self, at: usize) -> Option<LinePart> {
        let index = self.parts.binary_search_by_key(&at, |part| part.start);
        index.ok().map(|index| self.parts[index])
    }
}

/// Splits at `;` outside strings, brackets and comments; empty parts are dropped. The column of the first part is
/// that of the line, every `;` starts a new line whose indentation is the blanks after it.
fn split(line: &str, offset: usize, column: u32, budget: &WorkBudget<'_>) -> Vec<LinePart> {
    let bytes = line.as_bytes();
    let mut parts = Vec::new();
    let mut depth = 0u32;
    let mut at = 0;
    let mut part_start = 0;
    while at <= bytes.len() {
        budget.charge(BYTE);
        match bytes.get(at) {
            Some(b'"' | b'\'') => {
                at = skip_string(bytes, at);
                continue;
            }
            Some(b'(' | b'[' | b'{') => depth += 1,
            Some(b')' | b']' | b'}') => depth = depth.saturating_sub(1),
            Some(b';') if depth > 0 => {}
            None | Some(b';' | b'#') => {
                let content = &line[part_start..at];
                let blanks = content.len() - content.trim_start().len();
                let column = if part_start == 0 {
                    column
                } else {
                    blanks as u32
                };
                parts.extend(part(content.trim(), offset + part_start + blanks, column));
                part_start = at + 1;
                if bytes.get(at) != Some(&b';') {
                    break;
                }
            }
            _ => {}
        }
        at += 1;
    }
    parts
}

fn part(content: &str, start: usize, column: u32) -> Option<LinePart> {
    let word = content.split(|c| !super::names::continues_name(c)).next()?;
    let kind = match word {
        _ if content == "end" => LinePartKind::Terminator,
        "else" | "elif" | "except" | "finally" => LinePartKind::Continuation,
        _ => LinePartKind::Plain,
    };
    (!content.is_empty()).then_some(LinePart {
        start,
        column,
        kind,
        is_header: content.ends_with(':'),
    })
}

fn skip_string(bytes: &[u8], start: usize) -> usize {
    let quote = bytes[start];
    let mut at = start + 1;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'\\' => at += 1,
            _ if *byte == quote => return at + 1,
            _ => {}
        }
        at += 1;
    }
    at
}

/// Whether the columns of the parts make blocks as those of lines would.
fn blocks_by_columns(parts: &[LinePart]) -> bool {
    let mut open: Vec<u32> = Vec::new();
    let mut header = true;
    for part in parts {
        let innermost = open.last().copied();
        let deeper = innermost.is_none_or(|column| part.column > column);
        if deeper != header {
            // An `end` right after a header line closes an empty block; leave that to the parser.
            return false;
        }
        if deeper {
            open.push(part.column);
        }
        while open.last().is_some_and(|column| part.column < *column) {
            open.pop();
        }
        if open.last() != Some(&part.column) {
            return false;
        }
        header = part.is_header;
    }
    true
}
