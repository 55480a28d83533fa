//! The languages that people read.

/// A language that people read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Language {
    /// English.
    #[default]
    English,
    /// Chinese, in simplified characters.
    Chinese,
}

impl Language {
    /// The language of a locale such as `zh-CN` or `en_US.UTF-8`. English stands for every language without texts here.
    pub fn of_locale(locale: &str) -> Self {
        let is_chinese = locale
            .get(..2)
            .is_some_and(|two| two.eq_ignore_ascii_case("zh"));
        match is_chinese {
            true => Language::Chinese,
            false => Language::English,
        }
    }

    /// The one of two values that belongs to the language.
    pub fn pick<T>(self, english: T, chinese: T) -> T {
        match self {
            Language::English => english,
            Language::Chinese => chinese,
        }
    }
}
