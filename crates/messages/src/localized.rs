//! What can be told in every language: errors, and texts.

use std::fmt;
use std::sync::Arc;

use crate::Language;

/// A value that can be shown to people in each language. `Display` shows the English form.
pub trait Localized: fmt::Display {
    /// Writes the value in a language.
    ///
    /// # Errors
    /// Those of the formatter.
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result;

    /// The value as something that is displayed in a language.
    fn in_language(&self, language: Language) -> LocalizedDisplay<'_, Self> {
        LocalizedDisplay {
            value: self,
            language,
        }
    }
}

/// A localized value with the language in which it is displayed.
#[derive(Debug)]
pub struct LocalizedDisplay<'v, T: ?Sized> {
    value: &'v T,
    language: Language,
}

impl<T: Localized + ?Sized> fmt::Display for LocalizedDisplay<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.value.fmt_in(self.language, f)
    }
}

impl<T: Localized + ?Sized> Localized for &T {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt_in(language, f)
    }
}

impl<T: Localized + ?Sized> Localized for Box<T> {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt_in(language, f)
    }
}

impl<T: Localized + ?Sized> Localized for Arc<T> {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt_in(language, f)
    }
}
