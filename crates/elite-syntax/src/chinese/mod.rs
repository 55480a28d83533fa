//! Sentences in Chinese: the table of those that this crate makes about texts of programs, and how sentences are found
//! in such tables.
//!
//! A sentence is known by its English form, in which `{}` stands for what varies. Findings stay English inside; whoever
//! shows them to people asks for the Chinese form. Python's own exceptions keep CPython's words, which is how people
//! know them.

mod table;

use crate::diagnostic::Diagnostic;

/// English forms and their Chinese ones. In those `{0}` is what stands for the first `{}` as it is, `{0~}` the same in
/// Chinese.
pub type PhraseTable = &'static [(&'static str, &'static str)];

/// Sentences about texts of programs.
pub const SENTENCES: PhraseTable = table::SENTENCES;
/// What stands in them.
pub const WORDS: PhraseTable = table::WORDS;

/// Longest sentence that is looked up, in bytes.
const BYTES_MAX: usize = 4000;
/// Sentences within sentences; items of a list lie in each other.
const NESTED_SENTENCES_MAX: u32 = 8;

/// The tables that sentences are looked up in.
#[derive(Clone, Copy, Debug)]
pub struct Translations {
    /// Whole sentences.
    pub sentences: &'static [PhraseTable],
    /// What stands in them.
    pub words: &'static [PhraseTable],
}

impl Translations {
    /// The Chinese form of a sentence; none if the tables do not have it.
    pub fn sentence(self, english: &str) -> Option<String> {
        (english.len() <= BYTES_MAX).then(|| {
            self.among(
                self.sentences.iter().copied(),
                english,
                NESTED_SENTENCES_MAX,
            )
        })?
    }

    /// A finding with its message, labels and advice in Chinese, as far as the tables have them.
    pub fn finding(self, finding: &Diagnostic) -> Diagnostic {
        let mut finding = finding.clone();
        let labels = finding.labels.iter_mut().map(|label| &mut label.text);
        for text in labels
            .chain(&mut finding.help)
            .chain([&mut finding.message])
        {
            if let Some(chinese) = self.sentence(text) {
                *text = chinese;
            }
        }
        finding
    }

    /// The form whose words are most of the sentence.
    fn among(
        self,
        tables: impl Iterator<Item = PhraseTable>,
        english: &str,
        depth: u32,
    ) -> Option<String> {
        let entries = tables.flatten();
        let matching = entries.filter_map(|(form, chinese)| {
            let holes = match_template(form, english)?;
            let own = english.len() - holes.iter().map(|hole| hole.len()).sum::<usize>();
            Some((own, holes, chinese))
        });
        let (_, holes, chinese) = matching.max_by_key(|(own, ..)| *own)?;
        Some(self.fill_template(chinese, &holes, depth))
    }

    fn fill_template(self, chinese: &str, holes: &[&str], depth: u32) -> String {
        let mut text = String::new();
        let mut rest = chinese;
        while let Some((number, is_word, length)) = rest.find('{').and_then(|at| {
            text.push_str(&rest[..at]);
            rest = &rest[at..];
            place(rest)
        }) {
            let hole = holes.get(number).copied().unwrap_or_default();
            let word = depth.checked_sub(1).filter(|_| is_word).and_then(|depth| {
                // Of both, since a word such as "{} to {}" is found in many a sentence; words win where both fit alike.
                let tables = self.sentences.iter().chain(self.words);
                self.among(tables.copied(), hole, depth)
            });
            text.push_str(word.as_deref().unwrap_or(hole));
            rest = &rest[length..];
        }
        text.push_str(rest);
        text
    }
}

/// `{0}` or `{0~}` at the beginning of a text: the number, whether it is to be Chinese, how long it is.
fn place(text: &str) -> Option<(usize, bool, usize)> {
    let end = text.find('}')?;
    let inner = text.get(1..end)?;
    let number = inner.trim_end_matches('~');
    Some((number.parse().ok()?, number != inner, end + 1))
}

/// What stands for each `{}` of a form in a text; none if the text has another form.
fn match_template<'t>(form: &str, text: &'t str) -> Option<Vec<&'t str>> {
    let mut pieces = form.split("{}");
    let mut rest = text.strip_prefix(pieces.next()?)?;
    let mut pieces = pieces.peekable();
    let mut found = Vec::new();
    while let Some(piece) = pieces.next() {
        let at = match pieces.peek() {
            // The last piece is the end of the text.
            None => rest.strip_suffix(piece)?.len(),
            Some(_) => rest.find(piece)?,
        };
        found.push(&rest[..at]);
        rest = &rest[at + piece.len()..];
    }
    rest.is_empty().then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLES: Translations = Translations {
        sentences: &[SENTENCES],
        words: &[WORDS],
    };

    #[test]
    fn sentences_are_known_by_their_form() {
        let chinese = |english: &str| TABLES.sentence(english);
        let said = chinese("expected ':' after the 'if' condition, found the end of the line");
        assert_eq!(said.as_deref(), Some("应为'if' 条件之后的 ':'，却是行尾"));
        let said = chinese("the name 'string' is not defined");
        assert_eq!(said.as_deref(), Some("名称 'string' 未定义"));
        assert_eq!(chinese("list index out of range"), None);
        assert_eq!(chinese(""), None);
        assert_eq!(
            chinese("this  is never closed").as_deref(),
            Some("这个没有结束")
        );
    }
}
