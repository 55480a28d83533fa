//! Bytes cut into lines, with a limit. Pure.

/// One thing a client sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A line without its end; bytes that are no UTF-8 are replaced.
    Text(String),
    /// A line longer than the limit; it is skipped to its end.
    TooLong,
}

/// Cuts the bytes of one connection at `\n` or `\r\n`.
#[derive(Debug)]
pub struct LineFramer {
    line: Vec<u8>,
    limit: usize,
    state: LineFramerState,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LineFramerState {
    Between,
    Skipping,
}

impl LineFramer {
    /// Lines of at most `limit` bytes.
    pub const fn new(limit: usize) -> Self {
        Self {
            line: Vec::new(),
            limit,
            state: LineFramerState::Between,
        }
    }

    /// Takes what was received and adds complete lines to `lines`; blank ones are left out.
    pub fn push(&mut self, bytes: &[u8], lines: &mut Vec<Line>) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            let (content, ended) = match piece.strip_suffix(b"\n") {
                Some(content) => (content, true),
                None => (piece, false),
            };
            match self.state {
                LineFramerState::Skipping if ended => self.state = LineFramerState::Between,
                LineFramerState::Skipping => {}
                LineFramerState::Between => self.take(content, ended, lines),
            }
        }
    }

    fn take(&mut self, content: &[u8], ended: bool, lines: &mut Vec<Line>) {
        self.line.extend(content);
        if self.line.len() > self.limit {
            self.line = Vec::new();
            self.state = if ended {
                LineFramerState::Between
            } else {
                LineFramerState::Skipping
            };
            lines.push(Line::TooLong);
        } else if ended {
            let line = core::mem::take(&mut self.line);
            let text = String::from_utf8_lossy(&line).trim().to_owned();
            if !text.is_empty() {
                lines.push(Line::Text(text));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(chunks: &[&[u8]]) -> Vec<Line> {
        let mut framer = LineFramer::new(10);
        let mut lines = Vec::new();
        for chunk in chunks {
            framer.push(chunk, &mut lines);
            assert!(framer.line.len() <= 10);
        }
        lines
    }

    fn text(text: &str) -> Line {
        Line::Text(text.to_owned())
    }

    #[test]
    fn lines_end_with_or_without_a_carriage_return_and_may_come_in_pieces() {
        let found = lines(&[b"ec", b"ho\r", b"\n\r\n \nplay\npa", b"use", b"\nrest"]);
        assert_eq!(found, [text("echo"), text("play"), text("pause")]);
    }

    #[test]
    fn a_long_line_is_reported_once() {
        let found = lines(&[
            b"0123456789\n",
            b"01234567",
            b"89a",
            b"bcdef",
            b"x\nplay\n",
            b"0123456789a\nplay\n",
        ]);
        assert_eq!(
            found,
            [
                text("0123456789"),
                Line::TooLong,
                text("play"),
                Line::TooLong,
                text("play")
            ]
        );
    }

    #[test]
    fn broken_text_is_replaced() {
        assert_eq!(lines(&[b"\xff\n"]), [text("\u{FFFD}")]);
    }
}
