//! The derive macro of `Localized`.

use std::collections::BTreeSet;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote};
use syn::{Attribute, Data, DeriveInput, Fields, Ident, LitStr, Token};

use crate::template::{Piece, chinese_punctuation, has_words, pieces};
use crate::text::shown_argument;

/// The text of an attribute: a format string and the arguments behind it.
struct AttributeText {
    literal: LitStr,
    /// Arguments, with their names if they have one.
    arguments: Vec<(Option<String>, TokenStream)>,
}

/// An attribute of `thiserror`.
enum ErrorAttribute {
    Transparent,
    Text(AttributeText),
}

/// A format string whose places name arguments by number.
struct VariantForm {
    format: String,
    /// The arguments, and whether each is shown in the language of the text.
    shown: Vec<(TokenStream, bool)>,
}

impl VariantForm {
    /// The arguments as text, to be compared.
    fn keys(&self) -> BTreeSet<String> {
        let keys = self.shown.iter().map(|(argument, _)| argument.to_string());
        keys.collect()
    }
}

pub(crate) fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let name = &input.ident;
    let arms = match &input.data {
        Data::Enum(data) => data
            .variants
            .iter()
            .map(|variant| {
                let path = &variant.ident;
                arm(&quote!(Self::#path), path, &variant.attrs, &variant.fields)
            })
            .collect::<syn::Result<Vec<_>>>()?,
        Data::Struct(data) => vec![arm(&quote!(Self), name, &input.attrs, &data.fields)?],
        Data::Union(_) => return Err(syn::Error::new(name.span(), "a union has no text")),
    };
    let (implemented, arguments, conditions) = input.generics.split_for_impl();
    Ok(quote! {
        #[automatically_derived]
        impl #implemented ::messages::Localized for #name #arguments #conditions {
            #[allow(unused_variables, unused_imports, clippy::all, clippy::pedantic, clippy::nursery)]
            fn fmt_in(
                &self,
                language: ::messages::Language,
                f: &mut ::std::fmt::Formatter<'_>,
            ) -> ::std::fmt::Result {
                use ::messages::value::{ShownAsIs as _, ShownInLanguage as _};
                if language == ::messages::Language::English {
                    return ::std::fmt::Display::fmt(self, f);
                }
                match self { #(#arms)* }
            }
        }
    })
}

/// The arm of a variant: its fields, and how they are written in Chinese.
fn arm(
    path: &TokenStream,
    name: &Ident,
    attributes: &[Attribute],
    fields: &Fields,
) -> syn::Result<TokenStream> {
    let (pattern, bound) = bind(path, fields);
    let error = attribute(attributes, "error")
        .map(parse_error)
        .transpose()?
        .ok_or_else(|| syn::Error::new(name.span(), "there is no #[error(…)]"))?;
    let text = match error {
        ErrorAttribute::Transparent => {
            let inner = bound
                .first()
                .ok_or_else(|| syn::Error::new(name.span(), "there is no field"))?;
            let shown = shown_argument(&quote!(#inner), true, &quote!(language));
            return Ok(quote!(#pattern => ::std::write!(f, "{}", #shown),));
        }
        ErrorAttribute::Text(text) => text,
    };
    let english = form(&text, fields, false)?;
    let chinese = match attribute(attributes, "zh") {
        Some(attribute) => form(&attribute.parse_args_with(parse_text)?, fields, false)?,
        None if has_words(&pieces(&text.literal)?) => {
            let message = "the Chinese text is missing: add #[zh(\"…\")]";
            return Err(syn::Error::new(name.span(), message));
        }
        None => form(&text, fields, true)?,
    };
    let (of_english, of_chinese) = (english.keys(), chinese.keys());
    if let Some(one) = of_english.symmetric_difference(&of_chinese).next() {
        let message = format!("only one of the two texts has the argument `{one}`");
        return Err(syn::Error::new(name.span(), message));
    }
    let format = &chinese.format;
    let shown = chinese
        .shown
        .iter()
        .map(|(argument, in_language)| shown_argument(argument, *in_language, &quote!(language)));
    Ok(quote!(#pattern => ::std::write!(f, #format, #(#shown),*),))
}

/// The pattern of a variant, and the names that it binds.
fn bind(path: &TokenStream, fields: &Fields) -> (TokenStream, Vec<Ident>) {
    match fields {
        Fields::Named(fields) => {
            let names: Vec<_> = fields
                .named
                .iter()
                .filter_map(|field| field.ident.clone())
                .collect();
            (quote!(#path { #(#names),* }), names)
        }
        Fields::Unnamed(fields) => {
            let names: Vec<_> = (0..fields.unnamed.len()).map(field_of_tuple).collect();
            (quote!(#path(#(#names),*)), names)
        }
        Fields::Unit => (path.clone(), Vec::new()),
    }
}

/// The name that the field of a tuple is bound to.
fn field_of_tuple(number: usize) -> Ident {
    format_ident!("field_{number}")
}

fn attribute<'a>(attributes: &'a [Attribute], name: &str) -> Option<&'a Attribute> {
    attributes
        .iter()
        .find(|attribute| attribute.path().is_ident(name))
}

fn parse_error(attribute: &Attribute) -> syn::Result<ErrorAttribute> {
    attribute.parse_args_with(|input: syn::parse::ParseStream<'_>| {
        if input.peek(Ident) {
            let word: Ident = input.parse()?;
            return match word == "transparent" {
                true => Ok(ErrorAttribute::Transparent),
                false => Err(syn::Error::new(word.span(), "a text is needed here")),
            };
        }
        parse_text(input).map(ErrorAttribute::Text)
    })
}

fn parse_text(input: syn::parse::ParseStream<'_>) -> syn::Result<AttributeText> {
    let literal = input.parse()?;
    let mut arguments = Vec::new();
    while input.parse::<Option<Token![,]>>()?.is_some() {
        if input.is_empty() {
            break;
        }
        let is_named = input.peek(Ident) && input.peek2(Token![=]) && !input.peek2(Token![==]);
        let name = match is_named {
            true => {
                let name: Ident = input.parse()?;
                input.parse::<Token![=]>()?;
                Some(name.to_string())
            }
            false => None,
        };
        let mut tokens = Vec::new();
        while !input.is_empty() && !input.peek(Token![,]) {
            tokens.push(input.parse::<TokenTree>()?);
        }
        arguments.push((name, bound_fields(tokens)));
    }
    Ok(AttributeText { literal, arguments })
}

/// An argument with its fields (`.0`, `.path`) as the names that they are bound to.
fn bound_fields(tokens: Vec<TokenTree>) -> TokenStream {
    let mut bound = TokenStream::new();
    let mut tokens = tokens.into_iter().peekable();
    let mut begins = true;
    while let Some(token) = tokens.next() {
        match &token {
            TokenTree::Punct(punct) if begins && punct.as_char() == '.' => match tokens.next() {
                Some(TokenTree::Literal(number)) => {
                    // `.0.1` is one token, a number with a point.
                    let text = number.to_string();
                    let mut numbers = text.split('.').filter_map(|part| part.parse().ok());
                    let first = numbers.next().map(field_of_tuple);
                    let others = numbers.map(syn::Index::from);
                    bound.extend(quote!(#first #(.#others)*));
                }
                Some(TokenTree::Ident(name)) => bound.extend(quote!(#name)),
                other => bound.extend(other),
            },
            TokenTree::Group(group) if group.delimiter() != Delimiter::None => {
                let inner = bound_fields(group.stream().into_iter().collect());
                let group = proc_macro2::Group::new(group.delimiter(), inner);
                group.to_tokens(&mut bound);
            }
            _ => token.to_tokens(&mut bound),
        }
        // A point that follows an operator, an opening bracket or a comma begins a field; any other calls a method.
        begins = matches!(&token, TokenTree::Punct(punct) if punct.as_char() != '.');
    }
    bound
}

/// The format string and the arguments of a text; `punctuation`: with Chinese punctuation.
fn form(text: &AttributeText, fields: &Fields, punctuation: bool) -> syn::Result<VariantForm> {
    let mut positional = text
        .arguments
        .iter()
        .filter(|(name, _)| name.is_none())
        .map(|(_, argument)| argument);
    let mut form = VariantForm {
        format: String::new(),
        shown: Vec::new(),
    };
    for piece in pieces(&text.literal)? {
        let place = match piece {
            Piece::Words(words) if punctuation => {
                form.format.push_str(&chinese_punctuation(&words));
                continue;
            }
            Piece::Words(words) => {
                form.format.push_str(&words);
                continue;
            }
            Piece::Placeholder(place) => place,
        };
        let named = text
            .arguments
            .iter()
            .find(|(name, _)| name.as_deref() == Some(&place.name));
        let number = place.name.parse::<usize>();
        let argument = match (named, number) {
            (Some((_, argument)), _) => argument.clone(),
            (None, Ok(number)) if matches!(fields, Fields::Unnamed(_)) => {
                let field = field_of_tuple(number);
                quote!(#field)
            }
            (None, Ok(_)) => {
                let message = "a number stands for a field of a tuple";
                return Err(syn::Error::new(text.literal.span(), message));
            }
            (None, Err(_)) if place.name.is_empty() => {
                let next = positional.next().cloned();
                next.ok_or_else(|| {
                    syn::Error::new(text.literal.span(), "there is no argument for {}")
                })?
            }
            (None, Err(_)) => {
                let name = Ident::new(&place.name, text.literal.span());
                quote!(#name)
            }
        };
        let number = form.shown.len();
        form.format
            .push_str(&format!("{{{number}{}}}", place.format));
        form.shown.push((argument, place.format.is_empty()));
    }
    Ok(form)
}
