//! Sentences in Chinese: the table of those that this crate makes about texts of programs, and how sentences are found
//! in such tables.
//!
//! A sentence is known by its English form, in which `{}` stands for what varies. Findings stay English inside; whoever
//! shows them to people asks for the Chinese form. Python's own exceptions keep CPython's words, which is how people
//! know them.

mod table;

use std::collections::HashMap;

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

/// What was looked up within one sentence, by how deep sentences may lie in it.
type Known<'t> = HashMap<(&'t str, u32), Option<(usize, String)>>;

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
        if english.len() > BYTES_MAX {
            return None;
        }
        let sentences = self.sentences.iter().copied();
        let known = &mut Known::new();
        let (_, chinese) = self.among(sentences, english, NESTED_SENTENCES_MAX, known)?;
        Some(chinese)
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

    /// The form that leaves least of the sentence as it is, with how many letters it takes; of two alike the one that
    /// has more of its own.
    fn among<'t>(
        self,
        tables: impl Iterator<Item = PhraseTable>,
        english: &'t str,
        depth: u32,
        known: &mut Known<'t>,
    ) -> Option<(usize, String)> {
        let matching = tables.flatten().filter_map(|(form, chinese)| {
            let holes = match_template(form, english)?;
            let own = |measure: fn(&str) -> usize| {
                measure(english) - holes.iter().map(|hole| measure(hole)).sum::<usize>()
            };
            let joins = !form.bytes().any(|byte| byte.is_ascii_alphabetic());
            let (inner, text) = self.fill_template(chinese, &holes, joins, depth, known)?;
            Some((own(letters) + inner, own(str::len), text))
        });
        let (taken, _, text) = matching.max_by_key(|(taken, own, _)| (*taken, *own))?;
        Some((taken, text))
    }

    /// The Chinese form with what stands in it, and how many English letters of that are Chinese as well. None if the
    /// form only `joins` sentences and the tables lack one of these: half a text in each language is none.
    fn fill_template<'t>(
        self,
        chinese: &str,
        holes: &[&'t str],
        joins: bool,
        depth: u32,
        known: &mut Known<'t>,
    ) -> Option<(usize, String)> {
        let (mut taken, mut text) = (0, String::new());
        let mut rest = chinese;
        while let Some((number, is_word, length)) = rest.find('{').and_then(|at| {
            text.push_str(&rest[..at]);
            rest = &rest[at..];
            place(rest)
        }) {
            let hole = holes.get(number).copied().unwrap_or_default();
            let word = match is_word {
                true => self.word(hole, depth, known),
                false => None,
            };
            if joins && is_word && word.is_none() && is_prose(hole) {
                return None;
            }
            let (inner, shown) = word.unwrap_or_else(|| (0, hole.to_owned()));
            taken += inner;
            text.push_str(&shown);
            rest = &rest[length..];
        }
        text.push_str(rest);
        Some((taken, text))
    }

    /// What stands in a sentence, and how much of it is Chinese.
    fn word<'t>(
        self,
        english: &'t str,
        depth: u32,
        known: &mut Known<'t>,
    ) -> Option<(usize, String)> {
        let depth = depth.checked_sub(1)?;
        if let Some(word) = known.get(&(english, depth)) {
            return word.clone();
        }
        // Of both, since a word such as "{} to {}" is found in many a sentence; words win where both fit alike.
        let tables = self.sentences.iter().chain(self.words).copied();
        let word = self.among(tables, english, depth, known);
        known.insert((english, depth), word.clone());
        word
    }
}

/// Whether a text has words side by side, as sentences have and names and numbers have not.
fn is_prose(text: &str) -> bool {
    let is_word =
        |word: &&str| word.len() > 1 && word.bytes().all(|byte| byte.is_ascii_lowercase());
    text.split_whitespace().filter(is_word).count() > 1
}

/// How many English letters a text has. Commas between others are no words.
fn letters(text: &str) -> usize {
    text.bytes().filter(u8::is_ascii_alphabetic).count()
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

    #[test]
    fn the_form_that_leaves_least_is_taken() {
        const FORMS: PhraseTable = &[
            ("the program failed: {}", "程序失败：{0~}"),
            ("{} must be {}", "{0}应为{1~}"),
            ("{}, {}", "{0~}、{1~}"),
            ("{}: {}", "{0}：{1~}"),
            ("joint {}", "关节 {0}"),
        ];
        let forms = Translations {
            sentences: &[FORMS],
            words: &[],
        };
        let chinese = |english: &str| forms.sentence(english);
        assert_eq!(
            chinese("a.script: the program failed: q must be joint 1, joint 2").as_deref(),
            Some("a.script：程序失败：q应为关节 1、关节 2")
        );
    }

    #[test]
    fn sentences_are_joined_in_one_language() {
        const FORMS: PhraseTable = &[("nothing was sent", "没有发送"), ("{}; {}", "{0~}；{1~}")];
        let forms = Translations {
            sentences: &[FORMS],
            words: &[],
        };
        let chinese = |english: &str| forms.sentence(english);
        assert_eq!(chinese("a sentence without a row; nothing was sent"), None);
        assert_eq!(
            chinese("pick.script; nothing was sent").as_deref(),
            Some("pick.script；没有发送")
        );
    }
}
