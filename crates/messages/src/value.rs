//! How the macros show an argument: a localized one in the language of the text, any other as it is displayed.
//!
//! The call `(&Value(&x)).shown(language)` finds the trait of localized values first, because its receiver needs one
//! reference less; only where `x` is not localized the other trait is left. This works with the concrete types that
//! arguments have, not with type parameters.

use std::fmt::Display;

use crate::{Language, Localized, LocalizedDisplay};

/// An argument of a text.
#[derive(Debug)]
pub struct Value<'v, T: ?Sized>(pub &'v T);

/// Arguments that are localized.
pub trait ShownInLanguage<'v> {
    /// What is displayed.
    type Shown: Display;

    /// The argument in a language.
    fn shown(&self, language: Language) -> Self::Shown;
}

impl<'v, T: Localized + ?Sized> ShownInLanguage<'v> for Value<'v, T> {
    type Shown = LocalizedDisplay<'v, T>;

    fn shown(&self, language: Language) -> Self::Shown {
        self.0.in_language(language)
    }
}

/// Arguments that are the same in every language: numbers, names, paths.
pub trait ShownAsIs<'v> {
    /// What is displayed.
    type Shown: Display;

    /// The argument as it is.
    fn shown(&self, language: Language) -> Self::Shown;
}

impl<'v, T: Display + ?Sized> ShownAsIs<'v> for &Value<'v, T> {
    type Shown = &'v T;

    fn shown(&self, _: Language) -> Self::Shown {
        self.0
    }
}
