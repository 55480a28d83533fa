//! How the function that is being called is called, and which of its parameters is at the cursor.

use super::cursor::CursorContext;
use super::types::{Type, attribute_of};
use super::words::Language;
use super::{Analysis, describe, library};

/// A signature for people.
pub struct Signature {
    /// `movej(q, a=1.4, …)`
    pub label: String,
    /// What the function does, in Markdown.
    pub text: String,
    /// Each parameter: as it is written in the label, and what it means.
    pub parameters: Vec<(String, String)>,
    /// The parameter at the cursor.
    pub active: Option<usize>,
}

/// The parameters of whatever is called.
pub struct Callable {
    /// The name.
    pub name: String,
    /// What it does.
    pub text: String,
    /// Name, how it is written, what it means, whether it takes the rest.
    pub parameters: Vec<CallableParameter>,
}

/// A parameter of whatever is called.
pub struct CallableParameter {
    /// Name for keyword arguments; none if the parameter cannot be given by name.
    pub name: Option<String>,
    /// Text of the parameter in the label of the signature, with annotation and default.
    pub written: String,
    /// Meaning of the parameter, in Markdown.
    pub text: String,
    /// The parameter takes any number of arguments.
    pub is_rest: bool,
}

/// The signature of the call around `offset`.
pub fn signature(analysis: &Analysis, offset: u32, language: Language) -> Option<Signature> {
    let cursor = CursorContext::at(analysis, offset);
    if cursor.is_comment {
        return None;
    }
    let call = cursor.call()?;
    let callable = callable(analysis, &analysis.infer(&call.function), language)?;
    let written: Vec<&str> = callable.parameters.iter().map(|p| &*p.written).collect();
    let label = format!("{}({})", callable.name, written.join(", "));
    let by_name = call.keyword.as_ref().and_then(|keyword| {
        let mut all = callable.parameters.iter();
        all.position(|p| p.name.as_deref() == Some(keyword))
    });
    let rest = callable
        .parameters
        .iter()
        .position(|p| p.is_rest && !p.written.starts_with("**"));
    let by_position = match rest {
        Some(rest) if call.position >= rest => Some(rest),
        _ => (call.position < callable.parameters.len()).then_some(call.position),
    };
    let active = match call.keyword {
        Some(_) => by_name,
        None => by_position,
    };
    let parameters = callable.parameters.into_iter().map(|p| (p.written, p.text));
    Some(Signature {
        label,
        text: callable.text,
        parameters: parameters.collect(),
        active,
    })
}

/// What is known about calling a value of this type.
pub fn callable(analysis: &Analysis, function: &Type, language: Language) -> Option<Callable> {
    match function {
        Type::Robot(builtin) => Some(Callable {
            name: builtin.name.to_owned(),
            text: builtin.summary.in_language(language).to_owned(),
            parameters: builtin
                .params
                .iter()
                .map(|parameter| CallableParameter {
                    name: Some(parameter.name.to_owned()),
                    written: parameter.to_string(),
                    text: describe::of_parameter(parameter, language),
                    is_rest: parameter.to_string().starts_with('*'),
                })
                .collect(),
        }),
        Type::Function(index) => of_function(analysis, *index, None),
        Type::Class(class) => {
            let info = &analysis.names.classes[*class];
            let init = attribute_of(&analysis.names, *class, "__init__");
            match init.and_then(|(_, init)| init.function) {
                Some(function) => of_function(analysis, function, Some(&info.name)),
                None => Some(Callable {
                    name: info.name.to_string(),
                    text: info.doc.as_deref().unwrap_or("").to_owned(),
                    parameters: Vec::new(),
                }),
            }
        }
        Type::Python(name) => of_member(library::PYTHON.get(&**name)?.signature.as_deref()?),
        Type::Member(module, name) => {
            let all = library::members_of_module(module);
            of_member(
                all.iter()
                    .find(|m| *m.name == **name)?
                    .signature
                    .as_deref()?,
            )
        }
        Type::Method(owner, name) => {
            let all = library::members_of_type(owner);
            of_member(
                all.iter()
                    .find(|m| *m.name == **name)?
                    .signature
                    .as_deref()?,
            )
        }
        Type::TestFunction(name) => of_member(&describe::test_signature(name)?),
        _ => None,
    }
}

fn of_function(analysis: &Analysis, index: usize, called: Option<&str>) -> Option<Callable> {
    let info = analysis.names.functions.get(index)?;
    let parameters = info
        .called_with()
        .iter()
        .map(|parameter| CallableParameter {
            name: (!parameter.is_rest && !parameter.is_positional_only)
                .then(|| parameter.name.to_string()),
            written: parameter.source_text.to_string(),
            text: String::new(),
            is_rest: parameter.is_rest,
        });
    Some(Callable {
        name: called.unwrap_or(&info.name).to_owned(),
        text: info.doc.as_deref().unwrap_or("").to_owned(),
        parameters: parameters.collect(),
    })
}

/// Reads a signature like `split(sep=…, maxsplit=…)`.
fn of_member(signature: &str) -> Option<Callable> {
    let (name, rest) = signature.split_once('(')?;
    let inner = rest.strip_suffix(')')?;
    let written = inner.split(", ").filter(|part| !part.is_empty());
    let parameters = written.map(|part| {
        let name = part.split('=').next().unwrap_or(part);
        CallableParameter {
            name: (!name.starts_with('*')).then(|| name.to_owned()),
            written: part.to_owned(),
            text: String::new(),
            is_rest: name.starts_with('*'),
        }
    });
    Some(Callable {
        name: name.to_owned(),
        text: String::new(),
        parameters: parameters.collect(),
    })
}
