//! Macros of the crate `messages`: they compare the English and the Chinese form of a text while it is compiled.

mod derive;
mod help;
mod template;
mod text;

use proc_macro::TokenStream;
use syn::parse_macro_input;

/// Implements `messages::Localized` for an error of `thiserror`.
///
/// Each variant (or the struct) has `#[zh("…")]` beside `#[error("…")]`, with the grammar of `#[error]`: `{field}`,
/// `{0}`, and `{}` for further arguments, which may begin with a field (`.path.display()`). Both texts must use the
/// same arguments. The attribute is left out where the English text has no letters of its own, and for
/// `#[error(transparent)]`.
#[proc_macro_derive(Localized, attributes(zh))]
pub fn derive_localized(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as syn::DeriveInput);
    derive::expand(&input)
        .unwrap_or_else(syn::Error::into_compile_error)
        .into()
}

/// Implements `messages::LocalizedHelp` for a type of clap.
///
/// A comment that is a help text has its Chinese form below it: `#[zh("…")]`, and `#[zh("…", long = "…")]` where the
/// comment has more than one paragraph.
#[proc_macro_derive(LocalizedHelp, attributes(zh))]
pub fn derive_help(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as syn::DeriveInput);
    help::expand(&input)
        .unwrap_or_else(syn::Error::into_compile_error)
        .into()
}

/// A `messages::Text` from its English and its Chinese form and arguments as of `format!`.
///
/// Both forms must use the same arguments; in the Chinese one the position of an argument is given as `{0}` where the
/// order differs. Without arguments the result may stand in a constant.
#[proc_macro]
pub fn text(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as text::Input);
    text::expand(&input)
        .unwrap_or_else(syn::Error::into_compile_error)
        .into()
}
