//! A text in both languages.

use std::borrow::Cow;
use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use serde::{Serialize, Serializer};

use crate::{Language, Localized};

/// A text in both languages, made by [`text!`](crate::text!). `Display` and `serde` give the English form.
#[derive(Clone)]
pub struct Text(Words);

/// The words of a text. Errors hold texts, so that these are small and copied without cost.
#[derive(Clone)]
enum Words {
    Fixed([&'static str; 2]),
    Filled(Arc<[String; 2]>),
}

impl Text {
    /// A text without arguments.
    pub const fn fixed(english: &'static str, chinese: &'static str) -> Self {
        Self(Words::Fixed([english, chinese]))
    }

    /// A text with its arguments filled in.
    pub fn new(english: String, chinese: String) -> Self {
        Self(Words::Filled(Arc::new([english, chinese])))
    }

    /// Words that are the same in every language because they are not ours: a name, a line of a program, what another
    /// machine or a library says.
    pub fn verbatim(words: impl Into<Cow<'static, str>>) -> Self {
        match words.into() {
            Cow::Borrowed(words) => Self::fixed(words, words),
            Cow::Owned(words) => Self::new(words.clone(), words),
        }
    }

    /// The text of a localized value.
    pub fn of(value: &(impl Localized + ?Sized)) -> Self {
        let [english, chinese] = [Language::English, Language::Chinese]
            .map(|language| value.in_language(language).to_string());
        Self::new(english, chinese)
    }

    /// Several texts as one, with a separator for each language.
    pub fn joined<T: Localized>(
        texts: impl IntoIterator<Item = T>,
        english_separator: &str,
        chinese_separator: &str,
    ) -> Self {
        let (english, chinese): (Vec<_>, Vec<_>) = texts
            .into_iter()
            .map(|text| {
                let in_language = |language| text.in_language(language).to_string();
                (
                    in_language(Language::English),
                    in_language(Language::Chinese),
                )
            })
            .unzip();
        Self::new(
            english.join(english_separator),
            chinese.join(chinese_separator),
        )
    }

    /// The English form.
    pub fn english(&self) -> &str {
        self.forms()[0]
    }

    /// The form in a language.
    pub fn in_language(&self, language: Language) -> &str {
        let [english, chinese] = self.forms();
        language.pick(english, chinese)
    }

    fn forms(&self) -> [&str; 2] {
        match &self.0 {
            Words::Fixed(forms) => *forms,
            Words::Filled(forms) => [&forms[0], &forms[1]],
        }
    }

    /// A text as it was kept: the Chinese form is left out where it is the English one.
    pub fn recorded(english: String, chinese: Option<String>) -> Self {
        match chinese {
            Some(chinese) => Self::new(english, chinese),
            None => Self::verbatim(english),
        }
    }

    /// The Chinese form where it is not the English one.
    pub fn other_chinese(&self) -> Option<&str> {
        let [english, chinese] = self.forms();
        (chinese != english).then_some(chinese)
    }

    /// Whether the text says nothing.
    pub fn is_empty(&self) -> bool {
        self.english().is_empty()
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.english())
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Text").field(&self.forms()).finish()
    }
}

impl PartialEq for Text {
    fn eq(&self, other: &Self) -> bool {
        self.forms() == other.forms()
    }
}

impl Eq for Text {}

impl PartialOrd for Text {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Text {
    fn cmp(&self, other: &Self) -> Ordering {
        self.forms().cmp(&other.forms())
    }
}

impl Hash for Text {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.forms().hash(state);
    }
}

impl Localized for Text {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.in_language(language))
    }
}

/// A text may be the source of an error of the operating system's type, which then shows it in each language.
impl std::error::Error for Text {}

impl Serialize for Text {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.english())
    }
}

impl PartialEq<str> for Text {
    fn eq(&self, other: &str) -> bool {
        self.english() == other
    }
}

impl PartialEq<&str> for Text {
    fn eq(&self, other: &&str) -> bool {
        self.english() == *other
    }
}
