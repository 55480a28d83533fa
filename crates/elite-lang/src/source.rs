//! Source text with its line table, and byte spans into it.
//!
//! Owns the translation from byte offsets to the lines and columns people read. Knows nothing of tokens.

use std::sync::Arc;

/// A byte range in one source file, end exclusive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Span {
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The span from `start` up to `end`.
    pub fn new(start: usize, end: usize) -> Self {
        // Sources are limited to 64 MiB (`compile` refuses more), so the offsets fit.
        Span {
            start: start as u32,
            end: end as u32,
        }
    }

    /// The smallest span that covers both.
    pub fn to(self, other: Span) -> Span {
        Span {
            start: self.start.min(other.start),
            end: self.end.max(other.end),
        }
    }

    /// Start and end as a range of `usize`, for slicing the text.
    pub fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// A place as people read it: both numbers count from 1, columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

/// One program text: its name (a path, or what the sender called it), the text, and where its lines start.
#[derive(Debug)]
pub struct SourceFile {
    name: String,
    text: String,
    line_starts: Vec<u32>,
}

impl SourceFile {
    /// Takes over `text` and builds the line table. Lines end at `\n`, `\r\n` or a lone `\r`.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        let text = text.into();
        let mut line_starts = vec![0];
        let bytes = text.as_bytes();
        for (i, byte) in bytes.iter().enumerate() {
            let lone_return = *byte == b'\r' && bytes.get(i + 1) != Some(&b'\n');
            if *byte == b'\n' || lone_return {
                line_starts.push(i as u32 + 1);
            }
        }
        Arc::new(SourceFile {
            name: name.into(),
            text,
            line_starts,
        })
    }

    /// The name given at construction.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text of `span`; empty if the span does not lie on character boundaries of this file.
    pub fn slice(&self, span: Span) -> &str {
        self.text.get(span.range()).unwrap_or("")
    }

    /// Number of lines; a final newline does not start another one.
    pub fn line_count(&self) -> u32 {
        let count = self.line_starts.len() as u32;
        let ends_with_newline = self.line_starts.last() == Some(&(self.text.len() as u32));
        if count > 1 && ends_with_newline {
            count - 1
        } else {
            count
        }
    }

    /// The line (from 1) that holds the byte at `offset`.
    pub fn line_of(&self, offset: u32) -> u32 {
        self.line_starts.partition_point(|start| *start <= offset) as u32
    }

    /// Line and column of the byte at `offset`; offsets past the end mean the end of the last line, since behind a final
    /// newline there is no line to show.
    pub fn position(&self, offset: u32) -> Position {
        let end = self.text.strip_suffix('\n').unwrap_or(&self.text);
        let offset = offset.min(end.trim_end_matches('\r').len() as u32);
        let line = self.line_of(offset);
        let start = self.line_starts[line as usize - 1] as usize;
        let before = self.text.get(start..offset as usize).unwrap_or("");
        Position {
            line,
            column: before.chars().count() as u32 + 1,
        }
    }

    /// The text of line `line` (from 1) without its line end; empty if there is no such line.
    pub fn line_text(&self, line: u32) -> &str {
        let Some(start) = line
            .checked_sub(1)
            .and_then(|i| self.line_starts.get(i as usize))
        else {
            return "";
        };
        let end = self
            .line_starts
            .get(line as usize)
            .map_or(self.text.len(), |end| *end as usize);
        self.text[*start as usize..end].trim_end_matches(['\n', '\r'])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_from_one_in_characters() {
        let file = SourceFile::new("t", "ab\n位置 = 1\r\nx\ry");
        assert_eq!(file.position(0), Position { line: 1, column: 1 });
        assert_eq!(file.position(9), Position { line: 2, column: 3 });
        assert_eq!(file.line_text(2), "位置 = 1");
        assert_eq!(file.line_text(4), "y");
        assert_eq!(file.line_count(), 4);
        assert_eq!(file.line_text(5), "");
    }

    #[test]
    fn the_end_of_the_text_is_the_end_of_its_last_line() {
        for text in ["if x:\n", "if x:\r\n", "if x:"] {
            let position = SourceFile::new("t", text).position(99);
            assert_eq!(position, Position { line: 1, column: 6 }, "{text:?}");
        }
        let position = SourceFile::new("t", "").position(0);
        assert_eq!(position, Position { line: 1, column: 1 });
    }
}
