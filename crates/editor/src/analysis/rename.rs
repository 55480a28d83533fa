//! New names for old: every place of a name, or the reason why not.

use elite_syntax::Span;
use elite_syntax::lexer::TokenKind;
use messages::Localized;

use super::navigate::{KeywordOwner, NamedEntity, entity_at, keyword_of, references_of};
use super::scopes::{KeywordUse, SymbolKind};
use super::types::Type;
use super::{Analysis, TextKind, library};

/// Longest name, in bytes.
const NAME_MAX: usize = 255;

/// A reason why something cannot be renamed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Localized)]
pub enum RenameError {
    /// Nothing is there.
    #[error("there is no name here that could be changed")]
    #[zh("这里没有可以更改的名称")]
    NoName,
    /// The name is a builtin, not the program's.
    #[error("'{0}' is a builtin: it cannot be renamed")]
    #[zh("'{0}' 是内置函数：不能重命名")]
    Builtin(String),
    /// Nothing defines it.
    #[error("nothing in this program defines '{0}'")]
    #[zh("本程序没有定义 '{0}'")]
    Undefined(String),
    /// The name is that of a module or of something in one.
    #[error("'{0}' is the name of what is imported: give it another one with 'as'")]
    #[zh("'{0}' 是导入内容的名称：请用 'as' 另取名称")]
    Imported(String),
    /// A name of an argument, or a text, may be it.
    #[error("'{name}' in line {line} may be meant: nobody can tell what takes it there")]
    #[zh("可能指第 {line} 行的 '{name}'：无法判断那里用的是什么")]
    MayBeMeant {
        /// The name.
        name: String,
        /// Line of that place, from 1.
        line: u32,
    },
    /// Some places could be missed.
    #[error("the text has errors: places of '{0}' in lines that do not parse could be missed")]
    #[zh("文本有错误：无法解析的行中的 '{0}' 可能被遗漏")]
    TextHasErrors(String),
    /// The name may be that of another object's attribute.
    #[error(
        "'{name}' is also an attribute of something whose type is not known (line {line}): it could be the same"
    )]
    #[zh("'{name}' 也是某个类型未知的对象的属性（第 {line} 行）：可能是同一个")]
    MayBeAnother {
        /// The attribute.
        name: String,
        /// Line of that place, from 1.
        line: u32,
    },
    /// The language or Python gives it a meaning.
    #[error("'{0}' is called by the language under this name")]
    #[zh("语言以此名称调用 '{0}'")]
    Special(String),
    /// The new name is no valid name.
    #[error("'{0}' is not a name")]
    #[zh("'{0}' 不是名称")]
    Invalid(String),
    /// The new name has a meaning at one of the places already.
    #[error("'{name}' means something else there already (line {line})")]
    #[zh("'{name}' 在那里已有别的含义（第 {line} 行）")]
    Taken {
        /// The new name.
        name: String,
        /// Line of that place, from 1.
        line: u32,
    },
    /// The new name would hide a builtin that the program uses.
    #[error("'{0}' is a builtin that this program uses")]
    #[zh("'{0}' 是本程序使用的内置函数")]
    HidesBuiltin(String),
}

/// The place of the name at `offset`, if it can be renamed.
///
/// # Errors
/// Why it cannot.
pub fn renamable(analysis: &Analysis, offset: u32) -> Result<Span, RenameError> {
    let (named, span) = entity_at(analysis, offset).ok_or(RenameError::NoName)?;
    let written = analysis.file.slice(span);
    check_old(analysis, &named, written)?;
    Ok(span)
}

/// Every place that is to get the new name.
///
/// # Errors
/// Why it cannot be given.
pub fn rename(analysis: &Analysis, offset: u32, new: &str) -> Result<Vec<Span>, RenameError> {
    let (named, span) = entity_at(analysis, offset).ok_or(RenameError::NoName)?;
    let written = analysis.file.slice(span);
    check_old(analysis, &named, written)?;
    check_new(analysis, &named, written, new)?;
    let places = references_of(analysis, &named).into_iter();
    Ok(places.map(|place| place.span).collect())
}

fn check_old(analysis: &Analysis, named: &NamedEntity, written: &str) -> Result<(), RenameError> {
    let names = &analysis.names;
    let is_special = written.starts_with("__") && written.ends_with("__");
    match named {
        NamedEntity::Foreign(name) => {
            let is_test = analysis.kind == TextKind::Test && &**name == script_test::OBJECT;
            return Err(match is_builtin(name) || is_test {
                true => RenameError::Builtin(name.to_string()),
                false => RenameError::Undefined(name.to_string()),
            });
        }
        _ if is_special => return Err(RenameError::Special(written.to_owned())),
        _ if analysis.has_errors() => {
            return Err(RenameError::TextHasErrors(written.to_owned()));
        }
        NamedEntity::Symbol(symbol) => {
            let symbol = &names.symbols[*symbol];
            if symbol.kind == SymbolKind::Import {
                // Only what is written behind `as` is the program's own.
                let first = symbol.bindings().next();
                let line = first.map_or("", |o| {
                    let line = analysis.file.line_of(o.span.start);
                    analysis.file.line_text(line)
                });
                let own = format!(" as {written}");
                if !line.contains(&own) {
                    return Err(RenameError::Imported(written.to_owned()));
                }
            }
            if symbol.kind == SymbolKind::Parameter {
                return unknown_keyword(analysis, named, written);
            }
            if symbol.kind == SymbolKind::Class {
                return private_name_of(analysis, written);
            }
        }
        NamedEntity::Attribute(class, name) => {
            unknown_attribute(analysis, *class, name)?;
            unknown_keyword(analysis, named, name)?;
            return name_in_text(analysis, name);
        }
    }
    Ok(())
}

/// A private name written in full, `_Arm__speed`, has the name of its class in it.
fn private_name_of(analysis: &Analysis, class: &str) -> Result<(), RenameError> {
    let begins = format!("_{}__", class.trim_start_matches('_'));
    let mut full = analysis.tokens().iter().filter(|token| {
        matches!(token.kind, TokenKind::Name | TokenKind::Str)
            && analysis.file.slice(token.span).contains(&begins)
    });
    full.next().map_or(Ok(()), |token| {
        Err(RenameError::MayBeAnother {
            name: class.to_owned(),
            line: analysis.file.line_of(token.span.start),
        })
    })
}

/// A keyword argument that nobody can tell could be this one, and so could a name that a mapping brings: what it is for
/// otherwise is known.
fn unknown_keyword(
    analysis: &Analysis,
    named: &NamedEntity,
    name: &str,
) -> Result<(), RenameError> {
    let is_taken_by = |used: &&KeywordUse| match &*used.name {
        "**" => {
            let by_name = KeywordUse {
                function: used.function.clone(),
                first: used.first.clone(),
                name: name.into(),
                span: used.span,
            };
            matches!(keyword_of(analysis, &by_name), KeywordOwner::Known(of) if of == *named)
        }
        other => other == name && keyword_of(analysis, used) == KeywordOwner::Unknown,
    };
    let place = analysis.names.keyword_uses.iter().find(is_taken_by);
    place.map_or(Ok(()), |used| {
        Err(RenameError::MayBeMeant {
            name: name.to_owned(),
            line: analysis.file.line_of(used.span.start),
        })
    })
}

/// Functions that take attributes by texts, and what shows them under texts.
const BY_TEXT: &[&str] = &[
    "getattr",
    "setattr",
    "hasattr",
    "delattr",
    "attrgetter",
    "asdict",
    "_asdict",
    "vars",
    "__dict__",
    "__slots__",
    "TypedDict",
    "fields",
];

/// A text with the name of the attribute in a program that reaches attributes by texts could be it.
fn name_in_text(analysis: &Analysis, name: &str) -> Result<(), RenameError> {
    let written = |token: &elite_syntax::lexer::Token| analysis.file.slice(token.span);
    let mut tokens = analysis.tokens().iter();
    let reaches =
        tokens.any(|token| token.kind == TokenKind::Name && BY_TEXT.contains(&written(token)));
    if !reaches {
        return Ok(());
    }
    let mut texts = analysis.tokens().iter().filter(|token| {
        let text = written(token).trim_start_matches(|c: char| c.is_ascii_alphabetic());
        let inner = text.trim_matches(['"', '\'']);
        token.kind == TokenKind::Str && inner.split(['.', ' ', ',']).any(|part| part == name)
    });
    texts.next().map_or(Ok(()), |token| {
        Err(RenameError::MayBeMeant {
            name: name.to_owned(),
            line: analysis.file.line_of(token.span.start),
        })
    })
}

/// An attribute of the same name of a value that nobody can tell could be this one; so could one of a class that is
/// derived.
fn unknown_attribute(analysis: &Analysis, class: usize, name: &str) -> Result<(), RenameError> {
    let names = &analysis.names;
    let uses = names
        .attribute_uses
        .iter()
        .filter(|used| &*used.name == name);
    let mut unknown = uses.filter(|used| match analysis.infer(&used.value) {
        Type::Unknown => true,
        Type::Instance(of) | Type::Class(of) => {
            let line = super::types::class_and_ancestors(names, of);
            let own = super::types::attribute_of(names, of, name).map(|(owner, _)| owner);
            // A class that has it anew, or one that nobody knows the ancestors of.
            (line.contains(&class) && own != Some(class)) || own.is_none()
        }
        _ => false,
    });
    let place = unknown.next().map(|used| used.span.start);
    // A derived class may define it anew.
    let classes = names.classes.iter().enumerate();
    let mut derived = classes.filter(|(index, info)| {
        *index != class
            && info.attribute(name).is_some()
            && super::types::class_and_ancestors(names, *index).contains(&class)
    });
    let ancestors = super::types::class_and_ancestors(names, class);
    let inherited = ancestors[1..]
        .iter()
        .any(|at| names.classes[*at].attribute(name).is_some());
    let place = place
        .or_else(|| derived.next().map(|(_, info)| info.span.start))
        .or_else(|| inherited.then(|| names.classes[class].span.start));
    place.map_or(Ok(()), |start| {
        Err(RenameError::MayBeAnother {
            name: name.to_owned(),
            line: analysis.file.line_of(start),
        })
    })
}

fn is_builtin(name: &str) -> bool {
    library::robot(name).is_some() || library::is_python(name) || name == "elicopy"
}

fn check_new(
    analysis: &Analysis,
    named: &NamedEntity,
    written: &str,
    new: &str,
) -> Result<(), RenameError> {
    let file = elite_syntax::SourceFile::new("name", new);
    let tokens = elite_syntax::lexer::tokens(&file);
    let is_name = tokens
        .first()
        .is_some_and(|token| token.kind == TokenKind::Name);
    let is_private = new.starts_with("__") || written.starts_with("__");
    // `end` closes blocks, `sec` heads programs, private names are mangled.
    if !elite_syntax::lexer::is_name(new)
        || !is_name
        || new.len() > NAME_MAX
        || new == "end"
        || new == "sec"
        || is_private
    {
        return Err(RenameError::Invalid(new.chars().take(80).collect()));
    }
    let taken = |start: u32| RenameError::Taken {
        name: new.to_owned(),
        line: analysis.file.line_of(start),
    };
    let names = &analysis.names;
    match named {
        NamedEntity::Symbol(symbol) if new != written => {
            let symbol = &names.symbols[*symbol];
            // Nowhere may the new name mean something else where the old one stands,
            for occurrence in &symbol.occurrences {
                if let Some(other) = names.lookup(occurrence.scope, new) {
                    let at = names.symbols[other].occurrences.first();
                    return Err(taken(at.map_or(0, |o| o.span.start)));
                }
            }
            // and nothing that has this name already may come to mean this.
            for (occurrence, other) in names.places() {
                if analysis.file.slice(occurrence.span) != new {
                    continue;
                }
                let now = names.lookup(occurrence.scope, written);
                let reaches = now.is_some_and(|now| std::ptr::eq(&names.symbols[now], symbol));
                if reaches && other.is_some() {
                    return Err(taken(occurrence.span.start));
                }
                if reaches || symbol.scope == 0 {
                    return Err(RenameError::HidesBuiltin(new.to_owned()));
                }
            }
            let own = &names.scopes[symbol.scope];
            if let Some(other) = own.symbols.get(new) {
                let at = names.symbols[*other].occurrences.first();
                return Err(taken(at.map_or(0, |o| o.span.start)));
            }
            Ok(())
        }
        NamedEntity::Attribute(class, _) if new != written => {
            let others = super::types::class_and_ancestors(names, *class);
            let known = others
                .iter()
                .find_map(|at| names.classes[*at].attribute(new));
            match known {
                Some(known) => Err(taken(known.places.first().map_or(0, |span| span.start))),
                None => Ok(()),
            }
        }
        _ => Ok(()),
    }
}
