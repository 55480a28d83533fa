//! Case and kinds of the characters of a `str`: its mapping methods and the tests.

use super::receiver;
use crate::eval::Evaluator;
use crate::ops::unicode;
use crate::value::{R, Value};

/// A text mapped piece by piece; where the pieces are cut must not matter.
pub(super) fn mapped(ev: &Evaluator<'_>, args: &[Value], map: impl FnMut(&str, &mut String)) -> R {
    let text = receiver(ev, &args[0])?;
    ev.new_str(ev.map_text(text.as_str(), map)?)
}

pub(super) fn capitalize(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let text = text.as_str();
    let Some(first) = text.chars().next() else {
        return Ok(ev.core.empty_str.clone());
    };
    let mut out = String::new();
    unicode::push_title(first, &mut out);
    ev.push_text(&mut out, &to_lower(ev, text, first.len_utf8())?)?;
    ev.new_str(out)
}

const SIGMA: char = 'Σ';

/// The small form of the capital sigma at a byte of a text.
fn small_sigma(text: &str, place: usize) -> char {
    match unicode::ends_word(&text[..place], &text[place + SIGMA.len_utf8()..]) {
        true => 'ς',
        false => 'σ',
    }
}

/// The lower case of a text from a byte on. A capital sigma at the end of a word has a small form of its own.
pub(super) fn to_lower(ev: &Evaluator<'_>, text: &str, from: usize) -> R<String> {
    let mut at = from;
    let lower = |piece: &str, out: &mut String| {
        let mut rest = piece;
        while let Some(sigma) = rest.find(SIGMA) {
            out.push_str(&rest[..sigma].to_lowercase());
            let after = sigma + SIGMA.len_utf8();
            let place = at + (piece.len() - rest.len()) + sigma;
            out.push(small_sigma(text, place));
            rest = &rest[after..];
        }
        out.push_str(&rest.to_lowercase());
        at += piece.len();
    };
    ev.map_text(&text[from..], lower)
}

/// A text with each word in title case.
pub(super) fn to_title(ev: &Evaluator<'_>, text: &str) -> R<String> {
    let (mut at, mut inside) = (0, false);
    ev.map_text(text, |piece, out| {
        for c in piece.chars() {
            match inside {
                true if c == SIGMA => out.push(small_sigma(text, at)),
                true => out.extend(c.to_lowercase()),
                false => unicode::push_title(c, out),
            }
            inside = unicode::is_cased(c);
            at += c.len_utf8();
        }
    })
}

/// What has been seen of a text that may be one in title case.
#[derive(Default)]
pub struct TitleCaseCheck {
    inside: bool,
    any: bool,
}

impl TitleCaseCheck {
    /// Whether it still may be one with these characters.
    pub fn goes_on(&mut self, mut chars: impl Iterator<Item = char>) -> bool {
        chars.all(|c| {
            if c.is_uppercase() || unicode::is_title_form(c) {
                if self.inside {
                    return false;
                }
                (self.inside, self.any) = (true, true);
            } else if c.is_lowercase() {
                if !self.inside {
                    return false;
                }
                self.any = true;
            } else {
                self.inside = false;
            }
            true
        })
    }

    /// Whether what has been seen is one.
    pub fn is_one(&self) -> bool {
        self.any
    }
}

/// A text with its capitals small and its small letters capital.
pub(super) fn swap_case(ev: &Evaluator<'_>, text: &str) -> R<String> {
    let mut at = 0;
    ev.map_text(text, |piece, out| {
        for c in piece.chars() {
            if c == SIGMA {
                out.push(small_sigma(text, at));
            } else if c.is_uppercase() {
                out.extend(c.to_lowercase())
            } else if c.is_lowercase() {
                out.extend(c.to_uppercase())
            } else {
                out.push(c);
            }
            at += c.len_utf8();
        }
    })
}

/// White space as Python's `str.isspace` has it: Unicode's, and the separators 0x1c to 0x1f.
pub(super) fn is_space(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\x1c'..='\x1f')
}

pub(super) fn all(ev: &Evaluator<'_>, args: &[Value], test: impl Fn(char) -> bool) -> R {
    let text = receiver(ev, &args[0])?;
    let all = !text.is_empty() && ev.all_chars(text.as_str(), test)?;
    Ok(Value::Bool(all))
}

/// `isupper` and `islower`: at least one wanted letter and none of the other case.
pub(super) fn cased(
    ev: &Evaluator<'_>,
    args: &[Value],
    wanted: fn(char) -> bool,
    other: fn(char) -> bool,
) -> R {
    let text = receiver(ev, &args[0])?;
    let none = |test: fn(char) -> bool| ev.all_chars(text.as_str(), |c| !test(c));
    Ok(Value::Bool(!none(wanted)? && none(other)?))
}
