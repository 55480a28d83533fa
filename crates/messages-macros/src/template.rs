//! Format strings: their words and their places for arguments.

use syn::LitStr;

/// A piece of a format string.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Piece {
    /// Words, with `{{` and `}}` as they stand.
    Words(String),
    /// The place of an argument.
    Placeholder(Placeholder),
}

/// The place of an argument.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Placeholder {
    /// What the place names: nothing, a number, or an identifier.
    pub name: String,
    /// How the argument is formatted, with its colon; empty for `Display`.
    pub format: String,
}

/// The pieces of a format string.
pub(crate) fn pieces(literal: &LitStr) -> syn::Result<Vec<Piece>> {
    let text = literal.value();
    let mut pieces = Vec::new();
    let mut words = String::new();
    let mut rest = text.as_str();
    while let Some(letter) = rest.chars().next() {
        let doubled = rest.starts_with("{{") || rest.starts_with("}}");
        match letter {
            '{' | '}' if doubled => {
                words.push_str(&rest[..2]);
                rest = &rest[2..];
            }
            '{' => {
                let Some(end) = rest.find('}') else {
                    return Err(syn::Error::new(literal.span(), "a '{' is not closed"));
                };
                let inner = &rest[1..end];
                let (name, format) = inner.split_at(inner.find(':').unwrap_or(inner.len()));
                pieces.push(Piece::Words(std::mem::take(&mut words)));
                pieces.push(Piece::Placeholder(Placeholder {
                    name: name.trim().to_owned(),
                    format: format.to_owned(),
                }));
                rest = &rest[end + 1..];
            }
            '}' => return Err(syn::Error::new(literal.span(), "a '}' closes nothing")),
            _ => {
                words.push(letter);
                rest = &rest[letter.len_utf8()..];
            }
        }
    }
    pieces.push(Piece::Words(words));
    Ok(pieces)
}

/// Whether a text has words of a language, as `{path}: {source}` has not.
pub(crate) fn has_words(pieces: &[Piece]) -> bool {
    pieces.iter().any(|piece| match piece {
        Piece::Words(words) => words.bytes().any(|letter| letter.is_ascii_alphabetic()),
        Piece::Placeholder(_) => false,
    })
}

/// The Chinese form of words that are punctuation only.
pub(crate) fn chinese_punctuation(words: &str) -> String {
    words
        .replace(": ", "：")
        .replace("; ", "；")
        .replace(", ", "，")
}
