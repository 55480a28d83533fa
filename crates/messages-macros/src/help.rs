//! The derive macro of `LocalizedHelp`.

use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Data, DeriveInput, Expr, ExprLit, Ident, Lit, LitStr, Meta, Token};

/// `#[zh("…")]`, or `#[zh("…", long = "…")]` where the comment has more than one paragraph.
struct ChineseHelp {
    short: LitStr,
    long: Option<LitStr>,
}

impl Parse for ChineseHelp {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let short = input.parse()?;
        let long = match input.parse::<Option<Token![,]>>()? {
            None => None,
            Some(_) => {
                let word: Ident = input.parse()?;
                if word != "long" {
                    return Err(syn::Error::new(word.span(), "only `long` may stand here"));
                }
                input.parse::<Token![=]>()?;
                Some(input.parse()?)
            }
        };
        Ok(Self { short, long })
    }
}

pub(crate) fn expand(input: &DeriveInput) -> syn::Result<TokenStream> {
    let places: Vec<(&Ident, &[Attribute])> = match &input.data {
        Data::Struct(data) => data
            .fields
            .iter()
            .filter(|field| !holds_others(&field.attrs))
            .filter_map(|field| Some((field.ident.as_ref()?, &*field.attrs)))
            .collect(),
        Data::Enum(data) => data
            .variants
            .iter()
            .map(|variant| (&variant.ident, &*variant.attrs))
            .collect(),
        Data::Union(_) => Vec::new(),
    };
    let own = std::iter::once((&input.ident, &*input.attrs))
        .filter(|(_, attributes)| chinese(attributes).is_some());
    let mut pairs = Vec::new();
    for (name, attributes) in own.chain(places) {
        pairs.extend(texts(name, attributes)?);
    }
    let (english, chinese): (Vec<_>, Vec<_>) = pairs.into_iter().unzip();
    let name = &input.ident;
    Ok(quote! {
        #[automatically_derived]
        impl ::messages::LocalizedHelp for #name {
            const CHINESE: &'static [(&'static str, &'static str)] = &[#((#english, #chinese)),*];
        }
    })
}

fn chinese(attributes: &[Attribute]) -> Option<&Attribute> {
    attributes
        .iter()
        .find(|attribute| attribute.path().is_ident("zh"))
}

/// Whether a field is no option itself: it holds other options or commands, or clap skips it.
fn holds_others(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("arg") || list.path.is_ident("command") => {
            let word = list.tokens.to_string();
            matches!(word.as_str(), "flatten" | "skip" | "subcommand")
        }
        _ => false,
    })
}

/// The help texts of a comment, English and Chinese.
fn texts(name: &Ident, attributes: &[Attribute]) -> syn::Result<Vec<(String, LitStr)>> {
    let paragraphs = paragraphs(attributes);
    let Some(first) = paragraphs.first() else {
        return Ok(Vec::new());
    };
    let Some(attribute) = chinese(attributes) else {
        let message = "the Chinese help is missing: add #[zh(\"…\")] below the comment";
        return Err(syn::Error::new(name.span(), message));
    };
    let ChineseHelp { short, long } = attribute.parse_args()?;
    let mut texts = vec![(first.trim_end_matches('.').to_owned(), short)];
    match (long, paragraphs.len()) {
        (None, 1) => {}
        (Some(long), 2..) => texts.push((paragraphs.join("\n\n"), long)),
        (Some(long), _) => {
            let message = "the comment has one paragraph, so there is no long help";
            return Err(syn::Error::new(long.span(), message));
        }
        (None, _) => {
            let message = "the comment has several paragraphs: add `long = \"…\"`";
            return Err(syn::Error::new(name.span(), message));
        }
    }
    Ok(texts)
}

/// The paragraphs of a comment, each as one line.
fn paragraphs(attributes: &[Attribute]) -> Vec<String> {
    let lines = attributes
        .iter()
        .filter_map(|attribute| match &attribute.meta {
            Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
                Expr::Lit(ExprLit {
                    lit: Lit::Str(text),
                    ..
                }) => Some(text.value().trim().to_owned()),
                _ => None,
            },
            _ => None,
        });
    let lines: Vec<String> = lines.collect();
    lines
        .split(String::is_empty)
        .filter(|paragraph| !paragraph.is_empty())
        .map(|paragraph| paragraph.join(" "))
        .collect()
}
