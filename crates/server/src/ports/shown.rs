//! Texts of peers as they may be shown to people: in the log, in files, in messages about them.

use core::fmt::{self, Write};

/// Longest text that is shown, characters; the rest is cut off with a mark.
pub const SHOWN_CHARS_MAX: usize = 400;

/// A text of somebody else on one line: what would begin a new line, move the cursor, change colours or reverse the order
/// of letters stands as an escape, and what is long is cut.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a>(pub &'a str);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.char_indices().nth(SHOWN_CHARS_MAX) {
            Some((end, _)) => write!(f, "{}…", Escaped(&self.0[..end])),
            None => Escaped(self.0).fmt(f),
        }
    }
}

/// The same for a text whose length is bounded already.
#[derive(Clone, Copy, Debug)]
pub struct Escaped<'a>(pub &'a str);

impl fmt::Display for Escaped<'_> {
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
            assert_eq!(Shown(text).to_string(), shown);
        }
        let long = "é".repeat(SHOWN_CHARS_MAX + 1);
        let shown = Shown(&long).to_string();
        assert_eq!(shown.chars().count(), SHOWN_CHARS_MAX + 1);
        assert!(shown.ends_with("é…"));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn nothing_that_is_shown_is_a_control(text in "\\PC{0,20}|[\\x00-\\x1f\\x7f-\\u{9f}a]{0,20}|(?s:.{0,30})") {
            let shown = Shown(&text).to_string();
            prop_assert!(shown.chars().all(|c| is_seen(c) && !c.is_control()));
        }
    }
}
