//! Source text with its line table, and byte spans into it.
//!
//! Owns the translation from byte offsets to the lines and columns people read. Knows nothing of tokens.

use std::convert::Infallible;
use std::ops::Range;
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
    /// Characters before every `COLUMN_STEP`th byte, unless all are of one byte.
    characters: Vec<u32>,
}

/// Bytes between two places at which the characters before are known.
const COLUMN_STEP: usize = 1024;
/// Bytes between two pauses.
const PAUSE_CHUNK: usize = 32 * COLUMN_STEP;

impl SourceFile {
    /// Takes over `text` and builds the line table. Lines end at `\n`, `\r\n` or a lone `\r`.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        let (name, text) = (name.into(), text.into());
        match SourceFile::by_pieces(name, text, |_| Ok::<(), Infallible>(())) {
            Ok(file) => file,
            Err(never) => match never {},
        }
    }

    /// Takes over a text of any length: `pause` is called after each piece, with its bytes, and may put an end to it.
    pub fn by_pieces<E>(
        name: String,
        text: String,
        mut pause: impl FnMut(usize) -> Result<(), E>,
    ) -> Result<Arc<Self>, E> {
        let mut line_starts = vec![0];
        let bytes = text.as_bytes();
        for (piece, first) in bytes.chunks(PAUSE_CHUNK).zip((0..).step_by(PAUSE_CHUNK)) {
            for (byte, i) in piece.iter().zip(first..) {
                let lone_return = *byte == b'\r' && bytes.get(i + 1) != Some(&b'\n');
                if *byte == b'\n' || lone_return {
                    line_starts.push(i as u32 + 1);
                }
            }
            pause(piece.len())?;
        }
        let mut characters = Vec::new();
        if !text.is_ascii() {
            let mut before = 0;
            for (index, piece) in bytes.chunks(COLUMN_STEP).enumerate() {
                characters.push(before);
                before += character_starts(piece) as u32;
                if index % (PAUSE_CHUNK / COLUMN_STEP) == 0 {
                    pause(PAUSE_CHUNK / 4)?;
                }
            }
            characters.push(before);
        }
        Ok(Arc::new(SourceFile {
            name,
            text,
            line_starts,
            characters,
        }))
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

    /// Line and column of the byte at `offset`; offsets past the end mean the end of the last line, since behind a
    /// final newline there is no line to show.
    pub fn position(&self, offset: u32) -> Position {
        let offset = self.on_a_line(offset);
        let line = self.line_of(offset as u32);
        let start = self.line_starts[line as usize - 1] as usize;
        Position {
            line,
            column: (self.characters_up_to(offset) - self.characters_up_to(start)) as u32 + 1,
        }
    }

    /// `offset`, or the end of the last line if it lies behind that.
    pub(crate) fn on_a_line(&self, offset: u32) -> usize {
        let end = self.text.strip_suffix('\n').unwrap_or(&self.text);
        let end = end.strip_suffix('\r').unwrap_or(end);
        (offset as usize).min(end.len())
    }

    /// The lines (from 1) that a span touches.
    pub(crate) fn lines_of(&self, span: Span) -> Range<u32> {
        let (start, end) = (self.on_a_line(span.start), self.on_a_line(span.end));
        self.line_of(start as u32)..self.line_of(end.max(start) as u32) + 1
    }

    /// The bytes of line `line` (from 1) without its line end; an empty range if there is no such line.
    pub(crate) fn line_range(&self, line: u32) -> Range<usize> {
        let index = (line as usize).wrapping_sub(1);
        let start = self.line_starts.get(index).map(|start| *start as usize);
        let text = self.line_text(line);
        start.map_or(0..0, |start| start..start + text.len())
    }

    /// Number of characters before `offset`; those that are cut in two count.
    fn characters_up_to(&self, offset: usize) -> usize {
        if self.characters.is_empty() {
            return offset;
        }
        let step = offset / COLUMN_STEP;
        let known = self.characters.get(step).map_or(0, |count| *count as usize);
        known + character_starts(&self.text.as_bytes()[step * COLUMN_STEP..offset])
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
        let line = &self.text[*start as usize..end];
        let line = line.strip_suffix('\n').unwrap_or(line);
        line.strip_suffix('\r').unwrap_or(line)
    }
}

fn character_starts(bytes: &[u8]) -> usize {
    let starts = bytes.iter().filter(|byte| (**byte as i8) >= -0x40);
    starts.count()
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
    fn columns_far_into_a_line_count_characters() {
        for unit in ["a", "位", "é1", "𝄞"] {
            let text = format!("x\n{}", unit.repeat(3000));
            let file = SourceFile::new("t", &*text);
            for (column, (offset, _)) in text[2..].char_indices().enumerate() {
                let position = file.position(offset as u32 + 2);
                let expected = Position {
                    line: 2,
                    column: column as u32 + 1,
                };
                assert_eq!(position, expected, "{unit}");
            }
        }
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
