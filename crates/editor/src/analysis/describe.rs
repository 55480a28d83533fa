//! Texts about functions and names, as editors show them: signatures, units, ranges, sections of the manual. Markdown.

use std::collections::BTreeSet;

use elite_lang::library::LibraryMember;
use elite_runtime::builtins::declare::{Builtin, FROM_OUTPUT, Parameter};

use super::Analysis;
use super::library;
use super::scopes::{Symbol, SymbolKind};
use super::types::{Type, TypeRef};
use super::words::{Language, LanguageWords as _};

/// Most lines in which an attribute is set that are told.
const PLACES_MAX: usize = 8;

/// A function of the robot.
pub fn robot(builtin: &Builtin, language: Language) -> String {
    let mut text = code(&builtin.signature());
    text.push_str(builtin.summary.in_language(language));
    text.push('\n');
    if !builtin.params.is_empty() {
        let title = language.pick("Parameters", "参数");
        text.push_str(&format!("\n**{title}**\n\n"));
        for parameter in builtin.params {
            text.push_str(&format!(
                "- `{}` {}\n",
                parameter.name,
                of_parameter(parameter, language)
            ));
        }
    }
    let returns = language.pick("Returns", "返回值");
    text.push_str(&format!(
        "\n**{returns}**: {}\n",
        builtin.returns.in_language(language)
    ));
    if builtin.waits {
        let waits = language.pick("May wait.", "可能阻塞等待。");
        text.push_str(&format!("\n{waits}\n"));
    }
    text.push_str(&match builtin.section {
        FROM_OUTPUT => {
            let from = language.pick(FROM_OUTPUT, "来自控制器输出，手册中没有");
            format!("\n*{from}*\n")
        }
        section => format!("\n*{} {section}*\n", language.pick("Manual", "手册")),
    });
    text
}

/// Type, unit, range, default and meaning of a parameter.
pub fn of_parameter(parameter: &Parameter, language: Language) -> String {
    let mut parts = vec![parameter.kind.type_name()];
    if !parameter.unit.is_empty() {
        parts.push(language.unit(parameter.unit));
    }
    if let Some(range) = parameter.kind.range_text() {
        let range = range.in_language(language);
        parts.push(format!("{}: {range}", language.pick("range", "范围")));
    }
    if let Some((_, default)) = parameter.to_string().split_once('=') {
        parts.push(format!("{}: {default}", language.pick("default", "默认")));
    }
    match parameter.meaning.in_language(language) {
        "" => parts.join(", "),
        meaning => format!("({}): {meaning}", parts.join(", ")),
    }
}

/// A function or type of Python's own, or what a module has.
pub fn member(member: &LibraryMember, of: &str, language: Language) -> String {
    let shown = match (&member.signature, &member.value) {
        (Some(signature), _) => signature.clone(),
        (None, Some(value)) => format!("{} = {value}", member.name),
        (None, None) => member.name.clone(),
    };
    let text = code(&shown);
    match of {
        "" => {
            let whose = language.pick("Python", "Python 内建");
            match language.python(&member.name) {
                Some(sentence) => format!("{text}{sentence}\n\n*{whose}*"),
                None => format!("{text}{whose}"),
            }
        }
        of => format!("{text}`{of}`"),
    }
}

/// An attribute that a class of the program has, or one that it is derived from: a method as functions are, another
/// with what it is and where it is set.
pub fn attribute(
    analysis: &Analysis,
    class: usize,
    name: &str,
    language: Language,
) -> Option<String> {
    let names = &analysis.names;
    let (owner, found) = super::types::attribute_of(names, class, name)?;
    let owner = &names.classes[owner].name;
    let of_class = |word: &str| match language {
        Language::English => format!("{word} of `{owner}`"),
        Language::Chinese => format!("`{owner}` 的{word}"),
    };
    if let Some(index) = found.function {
        let is_property = names.functions[index].is_property;
        let word = match is_property {
            true => language.pick("property", "属性（property）"),
            false => language.pick("method", "方法"),
        };
        let text = function(analysis, index);
        return Some(format!("{}\n\n{}", text.trim_end(), of_class(word)));
    }
    let types = found.values.iter().map(|value| analysis.infer(value));
    let shown = match types.filter_map(|found| found.describe(names)).next() {
        Some(told) => format!("{name}: {told}"),
        None => name.to_owned(),
    };
    let lines: BTreeSet<u32> = found
        .places
        .iter()
        .map(|place| analysis.file.line_of(place.start))
        .collect();
    let more = lines.len() > PLACES_MAX;
    let lines = lines.iter().take(PLACES_MAX);
    let mut lines: Vec<String> = lines.map(u32::to_string).collect();
    if more {
        lines.push("…".to_owned());
    }
    let lines = lines.join(", ");
    let set = match language {
        Language::English => format!("set in line {lines}"),
        Language::Chinese => format!("在第 {lines} 行赋值"),
    };
    let word = of_class(language.pick("attribute", "属性"));
    let comma = language.pick(", ", "，");
    Some(format!("{}{word}{comma}{set}", code(&shown)))
}

/// A name that a module has; None if it has none such.
pub fn of_module(module: &str, name: &str, language: Language) -> Option<String> {
    let all = library::members_of_module(module);
    let found = all.iter().find(|member| member.name == name)?;
    Some(member(found, module, language))
}

/// A name of the program.
pub fn symbol(analysis: &Analysis, symbol: &Symbol, language: Language) -> String {
    let names = &analysis.names;
    let value = symbol.values.first();
    let found = value.map_or(Type::Unknown, |value| analysis.infer(value));
    match (symbol.kind, &found) {
        (SymbolKind::Function | SymbolKind::Variable, Type::Function(index)) => {
            function(analysis, *index)
        }
        (SymbolKind::Class | SymbolKind::Variable, Type::Class(index)) => class(analysis, *index),
        (SymbolKind::Import, Type::Unknown) if let Some(TypeRef::Member(module, name)) = value => {
            of_module(module, name, language)
                .unwrap_or_else(|| code(&format!("import {}", symbol.name)))
        }
        (SymbolKind::Import, _) => of_type(analysis, &found, language)
            .unwrap_or_else(|| code(&format!("import {}", symbol.name))),
        (kind, _) => {
            let word = match kind {
                SymbolKind::Parameter => language.pick("parameter", "形参"),
                _ if symbol.scope == 0 => language.pick("global variable", "全局变量"),
                _ => language.pick("variable", "变量"),
            };
            let known = symbol.values.iter().map(|value| analysis.infer(value));
            let mut told = known.filter_map(|found| found.describe(names));
            let shown = match told.next() {
                Some(told) => format!("{}: {told}", symbol.name),
                None => symbol.name.to_string(),
            };
            format!("{}{word}", code(&shown))
        }
    }
}

/// A function of the program.
pub fn function(analysis: &Analysis, index: usize) -> String {
    let info = &analysis.names.functions[index];
    let word = if info.is_secondary { "sec" } else { "def" };
    let mut shown = format!("{word} {}", info.signature());
    let types = info.returns.iter().map(|shape| analysis.infer(shape));
    if let Some(returned) = types.filter_map(|t| t.describe(&analysis.names)).next() {
        shown.push_str(&format!(" -> {returned}"));
    }
    let text = code(&shown);
    match &info.doc {
        Some(doc) => format!("{text}{}\n", plain(doc)),
        None => format!("{text}{}", comment_above(analysis, info.span.start)),
    }
}

/// A class of the program.
pub fn class(analysis: &Analysis, index: usize) -> String {
    let info = &analysis.names.classes[index];
    let init = super::types::attribute_of(&analysis.names, index, "__init__");
    let parameters = init.and_then(|(_, init)| init.function).map(|function| {
        let called = analysis.names.functions[function].called_with().iter();
        let written: Vec<&str> = called.map(|parameter| &*parameter.source_text).collect();
        written.join(", ")
    });
    let text = code(&format!(
        "class {}({})",
        info.name,
        parameters.unwrap_or_default()
    ));
    match &info.doc {
        Some(doc) => format!("{text}{}\n", plain(doc)),
        None => format!("{text}{}", comment_above(analysis, info.span.start)),
    }
}

/// What is known of a value by its type.
pub fn of_type(analysis: &Analysis, found: &Type, language: Language) -> Option<String> {
    Some(match found {
        Type::Robot(builtin) => robot(builtin, language),
        Type::Function(index) => function(analysis, *index),
        Type::Class(index) => class(analysis, *index),
        Type::Python(name) => member(library::PYTHON.get(&**name)?, "", language),
        Type::Member(module, name) => of_module(module, name, language)?,
        Type::Method(owner, name) => {
            let all = library::members_of_type(owner);
            member(all.iter().find(|m| *m.name == **name)?, owner, language)
        }
        Type::Module(name) => code(&format!("import {name}")),
        Type::TestFunction(name) => {
            let shown = test_signature(name)?;
            let whose = language.pick("tests of programs", "程序测试");
            format!("{}{whose}", code(&format!("test.{shown}")))
        }
        Type::Test => code("test"),
        other => code(&other.describe(&analysis.names)?),
    })
}

/// How a function of the object `test` is called.
pub fn test_signature(name: &str) -> Option<String> {
    let (name, parameters) = script_test::function_parameters().find(|(n, _)| *n == name)?;
    let written: Vec<String> = parameters
        .iter()
        .map(|parameter| match parameter.strip_suffix('?') {
            Some(name) => format!("{name}=…"),
            None => (*parameter).to_owned(),
        })
        .collect();
    Some(format!("{name}({})", written.join(", ")))
}

fn code(shown: &str) -> String {
    format!("```python\n{shown}\n```\n")
}

/// Text of the program in Markdown: nothing in it is markup.
fn plain(doc: &str) -> String {
    let mut text = String::new();
    for line in doc.trim().lines() {
        for c in line.trim().chars() {
            if matches!(
                c,
                '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '#' | '|' | '!'
            ) {
                text.push('\\');
            }
            text.push(c);
        }
        text.push_str("  \n");
    }
    text.trim_end().to_owned()
}

/// The comment lines right above a definition.
fn comment_above(analysis: &Analysis, start: u32) -> String {
    let text = &analysis.text()[..start as usize];
    let above = text.rfind('\n').map_or("", |at| &text[..at]);
    let mut lines: Vec<&str> = above
        .lines()
        .rev()
        .map(str::trim)
        .take_while(|line| line.starts_with('#'))
        .take(20)
        .collect();
    lines.reverse();
    let comment: Vec<&str> = lines
        .iter()
        .map(|line| line.trim_start_matches('#').trim())
        .collect();
    plain(&comment.join("\n"))
}
