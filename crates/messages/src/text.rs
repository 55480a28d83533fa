//! A text in both languages.

use std::borrow::Cow;
use std::fmt;

use serde::{Serialize, Serializer};

use crate::{Language, Localized};

/// A text in both languages, made by [`text!`](crate::text!). `Display` and `serde` give the English form.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Text {
    english: Cow<'static, str>,
    chinese: Cow<'static, str>,
}

impl Text {
    /// A text without arguments.
    pub const fn fixed(english: &'static str, chinese: &'static str) -> Self {
        Self {
            english: Cow::Borrowed(english),
            chinese: Cow::Borrowed(chinese),
        }
    }

    /// A text with its arguments filled in.
    pub const fn new(english: String, chinese: String) -> Self {
        Self {
            english: Cow::Owned(english),
            chinese: Cow::Owned(chinese),
        }
    }

    /// Words that are the same in every language because they are not ours: a name, a line of a program, what another
    /// machine or a library says.
    pub fn verbatim(words: impl Into<Cow<'static, str>>) -> Self {
        let english = words.into();
        Self {
            chinese: english.clone(),
            english,
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
        &self.english
    }

    /// The form in a language.
    pub fn in_language(&self, language: Language) -> &str {
        language.pick(&self.english, &self.chinese)
    }

    /// Whether the text says nothing.
    pub fn is_empty(&self) -> bool {
        self.english.is_empty()
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.english)
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
        serializer.serialize_str(&self.english)
    }
}

impl PartialEq<str> for Text {
    fn eq(&self, other: &str) -> bool {
        self.english == other
    }
}

impl PartialEq<&str> for Text {
    fn eq(&self, other: &&str) -> bool {
        self.english == *other
    }
}
