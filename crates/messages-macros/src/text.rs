//! `text!`: a text in place.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Expr, Ident, LitStr, Token};

use crate::template::{Piece, pieces};

/// An argument, with its name if it has one.
struct TextArgument {
    name: Option<Ident>,
    value: Expr,
}

impl Parse for TextArgument {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let is_named = input.peek(Ident) && input.peek2(Token![=]) && !input.peek2(Token![==]);
        let name = match is_named {
            true => {
                let name = input.parse()?;
                input.parse::<Token![=]>()?;
                Some(name)
            }
            false => None,
        };
        let value = input.parse()?;
        Ok(Self { name, value })
    }
}

/// What stands in the brackets of `text!`.
pub(crate) struct Input {
    english: LitStr,
    chinese: LitStr,
    arguments: Vec<TextArgument>,
}

impl Parse for Input {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let english = input.parse()?;
        input.parse::<Token![,]>()?;
        let chinese = input.parse()?;
        let mut arguments = Vec::new();
        if input.parse::<Option<Token![,]>>()?.is_some() {
            let list = Punctuated::<TextArgument, Token![,]>::parse_terminated(input)?;
            arguments.extend(list);
        }
        Ok(Self {
            english,
            chinese,
            arguments,
        })
    }
}

/// The arguments of a text, those captured from around it behind those given.
struct TextArguments {
    values: Vec<TokenStream>,
    names: Vec<Option<String>>,
}

impl TextArguments {
    /// The number of the argument that a place names.
    fn number(&mut self, name: &str, next: &mut usize, literal: &LitStr) -> syn::Result<usize> {
        let given = self.values.len();
        let number = match name {
            "" => {
                *next += 1;
                *next - 1
            }
            digits if digits.bytes().all(|digit| digit.is_ascii_digit()) => {
                digits.parse().unwrap_or(usize::MAX)
            }
            name => match self
                .names
                .iter()
                .position(|one| one.as_deref() == Some(name))
            {
                Some(number) => number,
                None => {
                    let captured = Ident::new(name, literal.span());
                    self.values.push(quote!(#captured));
                    self.names.push(Some(name.to_owned()));
                    given
                }
            },
        };
        match number < self.values.len() {
            true => Ok(number),
            false => Err(syn::Error::new(
                literal.span(),
                format!("there is no argument for {{{name}}}"),
            )),
        }
    }
}

/// A format string whose places name arguments by number, and the numbers.
struct TextForm {
    format: String,
    shown: Vec<(usize, bool)>,
}

fn form(literal: &LitStr, arguments: &mut TextArguments) -> syn::Result<TextForm> {
    let mut format = String::new();
    let (mut shown, mut next) = (Vec::new(), 0);
    for piece in pieces(literal)? {
        match piece {
            Piece::Words(words) => format.push_str(&words),
            Piece::Placeholder(place) => {
                let number = arguments.number(&place.name, &mut next, literal)?;
                format.push_str(&format!("{{{}{}}}", shown.len(), place.format));
                shown.push((number, place.format.is_empty()));
            }
        }
    }
    Ok(TextForm { format, shown })
}

/// Refuses a text whose other form does not use one of its arguments.
fn compare(
    form: &TextForm,
    other: &TextForm,
    literal: &LitStr,
    arguments: &TextArguments,
) -> syn::Result<()> {
    let missing = form
        .shown
        .iter()
        .find(|(number, _)| !other.shown.iter().any(|(one, _)| one == number));
    match missing {
        None => Ok(()),
        Some((number, _)) => {
            let name = match &arguments.names[*number] {
                Some(name) => name.clone(),
                None => number.to_string(),
            };
            let message = format!("the argument {{{name}}} is not in this text");
            Err(syn::Error::new(literal.span(), message))
        }
    }
}

pub(crate) fn expand(input: &Input) -> syn::Result<TokenStream> {
    let Input {
        english,
        chinese,
        arguments,
    } = input;
    let mut arguments = TextArguments {
        names: arguments
            .iter()
            .map(|argument| argument.name.as_ref().map(Ident::to_string))
            .collect(),
        values: arguments
            .iter()
            .map(|TextArgument { value, .. }| quote!(#value))
            .collect(),
    };
    let english_form = form(english, &mut arguments)?;
    let chinese_form = form(chinese, &mut arguments)?;
    compare(&english_form, &chinese_form, chinese, &arguments)?;
    compare(&chinese_form, &english_form, english, &arguments)?;
    if let Some(unused) = (0..arguments.values.len())
        .find(|number| !english_form.shown.iter().any(|(one, _)| one == number))
    {
        let message = format!("the argument {unused} is not used");
        return Err(syn::Error::new(english.span(), message));
    }
    if arguments.values.is_empty() {
        let [english, chinese] = [english, chinese].map(|literal| {
            let words = literal.value().replace("{{", "{").replace("}}", "}");
            LitStr::new(&words, literal.span())
        });
        return Ok(quote!(::messages::Text::fixed(#english, #chinese)));
    }
    let bound: Vec<Ident> = (0..arguments.values.len())
        .map(|number| format_ident!("argument_{number}"))
        .collect();
    let values = &arguments.values;
    let english = english_shown(&english_form, &bound);
    let chinese = chinese_shown(&chinese_form, &bound);
    Ok(quote! {
        match (#(&(#values),)*) {
            (#(#bound,)*) => ::messages::Text::new(#english, #chinese),
        }
    })
}

fn english_shown(form: &TextForm, bound: &[Ident]) -> TokenStream {
    let format = &form.format;
    let shown = form.shown.iter().map(|(number, _)| {
        let argument = &bound[*number];
        quote!(#argument)
    });
    quote!(::std::format!(#format, #(#shown),*))
}

fn chinese_shown(form: &TextForm, bound: &[Ident]) -> TokenStream {
    let format = &form.format;
    let shown = form.shown.iter().map(|(number, in_language)| {
        let argument = &bound[*number];
        shown_argument(
            &quote!(#argument),
            *in_language,
            &quote!(::messages::Language::Chinese),
        )
    });
    quote!({
        #[allow(unused_imports)]
        use ::messages::value::{ShownAsIs as _, ShownInLanguage as _};
        ::std::format!(#format, #(#shown),*)
    })
}

/// An argument in a language, or as it is where it is formatted as a number.
pub(crate) fn shown_argument(
    argument: &TokenStream,
    in_language: bool,
    language: &TokenStream,
) -> TokenStream {
    match in_language {
        true => quote!((&::messages::value::Value(&(#argument))).shown(#language)),
        false => quote!(#argument),
    }
}
