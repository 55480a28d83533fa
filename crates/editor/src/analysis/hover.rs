//! What is shown about the thing under the pointer.

use elite_syntax::Span;
use elite_syntax::lexer::TokenKind;

use super::scopes::AttributeUse;
use super::types::{Type, TypeRef};
use super::words::Language;
use super::{Analysis, describe};

/// A text in Markdown and what it is about.
pub struct Hover {
    /// The text.
    pub text: String,
    /// The place it is about.
    pub span: Span,
}

/// What there is to say about the place at `offset`.
pub fn hover(analysis: &Analysis, offset: u32, language: Language) -> Option<Hover> {
    let names = &analysis.names;
    if let Some(used) = attribute_at(analysis, offset) {
        let text = of_attribute(analysis, used, language)?;
        return Some(Hover {
            text,
            span: used.span,
        });
    }
    if let Some((occurrence, symbol)) = names.occurrence_at(offset) {
        let name = analysis.file.slice(occurrence.span);
        let text = match symbol {
            Some(symbol) => describe::symbol(analysis, &names.symbols[symbol], language),
            None => {
                let shape = TypeRef::Name(occurrence.scope, name.into());
                describe::of_type(analysis, &analysis.infer(&shape), language)?
            }
        };
        return Some(Hover {
            text,
            span: occurrence.span,
        });
    }
    if let Some(keyword) = names
        .keyword_uses
        .iter()
        .find(|k| &*k.name != "**" && touches(k.span, offset))
    {
        let text = of_keyword(analysis, &keyword.function, &keyword.name, language)?;
        return Some(Hover {
            text,
            span: keyword.span,
        });
    }
    // A word in a line that does not parse.
    let token = analysis.token_at(offset)?;
    if token.kind != TokenKind::Name {
        return None;
    }
    let name = analysis.file.slice(token.span);
    let scope = analysis.scope_at(offset);
    let text = match names.lookup(scope, name) {
        Some(symbol) => describe::symbol(analysis, &names.symbols[symbol], language),
        None => {
            let shape = TypeRef::Name(scope, name.into());
            describe::of_type(analysis, &analysis.infer(&shape), language)?
        }
    };
    Some(Hover {
        text,
        span: token.span,
    })
}

fn of_attribute(analysis: &Analysis, used: &AttributeUse, language: Language) -> Option<String> {
    let known = match analysis.infer(&used.value) {
        Type::Instance(class) | Type::Class(class) => {
            describe::attribute(analysis, class, &used.name, language)
        }
        Type::Module(module) => describe::of_module(&module, &used.name, language),
        _ => None,
    };
    known.or_else(|| {
        let shape = TypeRef::Attribute(Box::new(used.value.clone()), used.name.clone());
        describe::of_type(analysis, &analysis.infer(&shape), language)
    })
}

/// The attribute whose name is at `offset`.
pub fn attribute_at(analysis: &Analysis, offset: u32) -> Option<&AttributeUse> {
    let mut uses = analysis.names.attribute_uses.iter();
    uses.find(|used| touches(used.span, offset))
}

/// Whether an offset is in a span or at its end.
pub fn touches(span: Span, offset: u32) -> bool {
    span.start <= offset && offset <= span.end
}

fn of_keyword(
    analysis: &Analysis,
    function: &TypeRef,
    name: &str,
    language: Language,
) -> Option<String> {
    let Type::Robot(builtin) = analysis.infer(function) else {
        return None;
    };
    let parameter = builtin
        .params
        .iter()
        .find(|p| p.name == name || p.aliases.contains(&name))?;
    let said = describe::of_parameter(parameter, language);
    Some(format!(
        "```python\n{}({parameter})\n```\n{said}\n",
        builtin.name
    ))
}
