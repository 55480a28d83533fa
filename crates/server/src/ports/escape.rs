//! Texts of peers as they may be shown to people: in the log, in files, in messages about them.

use core::fmt::{self, Write};
use std::io;

use messages::{Language, Localized, Text};

/// Longest text that is shown, characters; the rest is cut off with a mark.
pub const SHOWN_CHARS_MAX: usize = 400;

/// A text of somebody else on one line: what would begin a new line, move the cursor, change colours or reverse the
/// order of letters stands as an escape, and what is long is cut.
#[derive(Clone, Copy, Debug)]
pub struct EscapedLine<'a>(pub &'a str);

impl fmt::Display for EscapedLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.char_indices().nth(SHOWN_CHARS_MAX) {
            Some((end, _)) => write!(f, "{}…", EscapedText(&self.0[..end])),
            None => EscapedText(self.0).fmt(f),
        }
    }
}

/// A text of somebody else whose length is bounded already: what would begin a new line, move the cursor, change
/// colours or reverse the order of letters stands as an escape.
#[derive(Clone, Copy, Debug)]
pub struct EscapedText<'a>(pub &'a str);

impl fmt::Display for EscapedText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '\n' => f.write_str("\\n")?,
                '\r' => f.write_str("\\r")?,
                '\t' => f.write_str("\\t")?,
                _ if is_seen(character) => f.write_char(character)?,
                _ => write!(f, "\\u{{{:x}}}", u32::from(character))?,
            }
        }
        Ok(())
    }
}

/// A text in which words of somebody else may stand, as [`EscapedText`].
pub fn escaped(text: &(impl Localized + ?Sized)) -> Text {
    let [english, chinese] = [Language::English, Language::Chinese].map(|language| {
        let words = text.in_language(language).to_string();
        EscapedText(&words).to_string()
    });
    Text::new(english, chinese)
}

/// A text of several lines, which stay lines, with tabs as they are.
#[derive(Clone, Copy, Debug)]
pub struct EscapedLines<'a>(pub &'a str);

impl fmt::Display for EscapedLines<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // At most one character of a piece is one that is kept: the last.
        for piece in self.0.split_inclusive(['\n', '\t']) {
            let kept = piece.len() - usize::from(piece.ends_with(['\n', '\t']));
            write!(f, "{}{}", EscapedText(&piece[..kept]), &piece[kept..])?;
        }
        Ok(())
    }
}

/// Output for people: what a terminal would obey stands as an escape, lines and tabs stay.
#[derive(Debug)]
pub struct EscapingWriter<W: io::Write> {
    out: W,
    /// The beginning of a character.
    begun: Vec<u8>,
}

impl<W: io::Write> EscapingWriter<W> {
    /// Shows on `out`.
    pub const fn new(out: W) -> Self {
        Self {
            out,
            begun: Vec::new(),
        }
    }

    /// What it was shown on. The beginning of a character whose rest did not come is not.
    pub fn into_inner(self) -> W {
        self.out
    }
}

impl<W: io::Write> io::Write for EscapingWriter<W> {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let mut bytes = core::mem::take(&mut self.begun);
        bytes.extend_from_slice(data);
        let mut chunks = bytes.utf8_chunks().peekable();
        while let Some(chunk) = chunks.next() {
            write!(self.out, "{}", EscapedLines(chunk.valid()))?;
            let broken = chunk.invalid();
            if chunks.peek().is_none() && may_go_on(broken) {
                self.begun = broken.to_vec();
            } else if !broken.is_empty() {
                write!(self.out, "{}", char::REPLACEMENT_CHARACTER)?;
            }
        }
        Ok(data.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Whether bytes that are no text may be the beginning of a character.
fn may_go_on(broken: &[u8]) -> bool {
    core::str::from_utf8(broken).is_err_and(|error| error.error_len().is_none())
}

/// False for controls, line and paragraph ends, and what changes the direction of writing without a sign of its own.
const fn is_seen(character: char) -> bool {
    !matches!(
        character,
        '\0'..='\x1f'
            | '\x7f'..='\u{9f}'
            | '\u{ad}'
            | '\u{61c}'
            | '\u{200b}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}'
            | '\u{feff}'
            | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e007f}'
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_text_of_a_peer_cannot_forge_a_line_or_paint_the_terminal() {
        for (text, shown) in [
            ("play", "play"),
            (
                "a\r\n2026-01-01 ERROR forged",
                "a\\r\\n2026-01-01 ERROR forged",
            ),
            ("\x1b[2J\x1b]0;title\x07", "\\u{1b}[2J\\u{1b}]0;title\\u{7}"),
            ("\u{9b}31m", "\\u{9b}31m"),
            ("abc\u{202e}fed", "abc\\u{202e}fed"),
            ("tab\there", "tab\\there"),
            ("über 機械", "über 機械"),
        ] {
            assert_eq!(EscapedLine(text).to_string(), shown);
        }
        let long = "é".repeat(SHOWN_CHARS_MAX + 1);
        let shown = EscapedLine(&long).to_string();
        assert_eq!(shown.chars().count(), SHOWN_CHARS_MAX + 1);
        assert!(shown.ends_with("é…"));
    }

    #[test]
    fn a_screen_shows_lines_and_obeys_nothing_in_whatever_pieces_it_comes() {
        let text = "über\t機械\n\x1b[2J\u{9b}31m\r\n\x7f\u{85}end\n";
        let shown = "über\t機械\n\\u{1b}[2J\\u{9b}31m\\r\n\\u{7f}\\u{85}end\n";
        assert_eq!(EscapedLines(text).to_string(), shown);
        for piece in [1, 2, 3, 5, 100] {
            let mut screen = EscapingWriter::new(Vec::new());
            for part in text.as_bytes().chunks(piece) {
                io::Write::write_all(&mut screen, part).unwrap();
            }
            assert_eq!(String::from_utf8(screen.out).unwrap(), shown, "{piece}");
        }
        let mut screen = EscapingWriter::new(Vec::new());
        io::Write::write_all(&mut screen, b"a\xff\xe6b\xc2").unwrap();
        assert_eq!(String::from_utf8(screen.out).unwrap(), "a\u{fffd}\u{fffd}b");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn nothing_that_is_shown_is_a_control(text in "\\PC{0,20}|[\\x00-\\x1f\\x7f-\\u{9f}a]{0,20}|(?s:.{0,30})") {
            let shown = EscapedLine(&text).to_string();
            prop_assert!(shown.chars().all(|c| is_seen(c) && !c.is_control()));
        }
    }
}
