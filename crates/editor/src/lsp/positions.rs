//! Lines and columns of the protocol, in UTF-16 or UTF-8 units, and byte offsets of a text.

use elite_syntax::Span;
use ls_types::{Position, Range};

/// What columns count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Bytes.
    Utf8,
    /// Units of two bytes, what clients speak that say nothing else.
    #[default]
    Utf16,
}

/// Beginnings of the lines of a text.
#[derive(Debug, Default)]
pub struct LineIndex {
    starts: Vec<usize>,
    is_ascii: bool,
}

impl LineIndex {
    /// Of this text. Lines end as the protocol says: `\n`, `\r\n` or `\r`.
    pub fn of(text: &str) -> Self {
        let bytes = text.as_bytes();
        let ends = bytes.iter().enumerate().filter(|(at, byte)| match byte {
            b'\n' => true,
            b'\r' => bytes.get(at + 1) != Some(&b'\n'),
            _ => false,
        });
        let starts = std::iter::once(0).chain(ends.map(|(at, _)| at + 1));
        LineIndex {
            starts: starts.collect(),
            is_ascii: text.is_ascii(),
        }
    }

    /// The text of a line without its end; empty behind the last one.
    fn line<'t>(&self, text: &'t str, line: usize) -> (usize, &'t str) {
        let Some(start) = self.starts.get(line).copied() else {
            return (text.len(), "");
        };
        let end = self.starts.get(line + 1).copied().unwrap_or(text.len());
        let content = text.get(start..end).unwrap_or("");
        (start, content.trim_end_matches(['\n', '\r']))
    }

    /// The byte at a position; what lies behind the end of a line or of the text is that end.
    pub fn offset(&self, text: &str, position: Position, encoding: Encoding) -> u32 {
        let (start, line) = self.line(text, position.line as usize);
        let column = position.character as usize;
        let within = match encoding {
            _ if self.is_ascii => column.min(line.len()),
            Encoding::Utf8 => line.floor_char_boundary(column.min(line.len())),
            Encoding::Utf16 => {
                let mut units = 0;
                let mut places = line.char_indices().take_while(|(_, c)| {
                    let fits = units + c.len_utf16() <= column;
                    units += c.len_utf16();
                    fits
                });
                places
                    .by_ref()
                    .last()
                    .map_or(0, |(at, c)| at + c.len_utf8())
            }
        };
        (start + within) as u32
    }

    /// The position of a byte.
    pub fn position(&self, text: &str, offset: u32, encoding: Encoding) -> Position {
        let offset = text.floor_char_boundary((offset as usize).min(text.len()));
        let line = self
            .starts
            .partition_point(|start| *start <= offset)
            .saturating_sub(1);
        let start = self.starts.get(line).copied().unwrap_or(0);
        let before = text.get(start..offset).unwrap_or("");
        let character = match encoding {
            _ if self.is_ascii => before.len(),
            Encoding::Utf8 => before.len(),
            Encoding::Utf16 => before.chars().map(char::len_utf16).sum(),
        };
        Position {
            line: line as u32,
            character: character as u32,
        }
    }

    /// The range of a span.
    pub fn range(&self, text: &str, span: Span, encoding: Encoding) -> Range {
        Range {
            start: self.position(text, span.start, encoding),
            end: self.position(text, span.end.max(span.start), encoding),
        }
    }
}
