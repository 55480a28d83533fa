//! The tool `builtin`: functions of the language, from their declarations.

use std::collections::BTreeMap;

use editor::analysis::words::Language;
use editor::analysis::{describe, library};
use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::Builtin;
use rmcp::schemars::JsonSchema;
use serde::Deserialize;

use super::tools::ToolOutput;
use super::workspace::{CancelFlag, Workspace};

/// Functions that a search tells of.
const FOUND_MAX: usize = 30;

/// Arguments of `builtin`.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct BuiltinArguments {
    /// The name of one function, for its full text: movel
    #[serde(default)]
    name: Option<String>,
    /// Words that must all be in name, summary, parameters, category or section: "force mode", "3.2.31"
    #[serde(default)]
    search: Option<String>,
    /// Language of the text: en (default) or zh
    #[serde(default)]
    language: Option<LanguageArgument>,
}

/// A language of texts.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars", inline)]
#[serde(rename_all = "lowercase")]
enum LanguageArgument {
    En,
    Zh,
}

pub(super) fn builtin(
    _: &Workspace,
    arguments: BuiltinArguments,
    _: &CancelFlag,
) -> Result<ToolOutput, String> {
    let language = match arguments.language {
        Some(LanguageArgument::Zh) => Language::Chinese,
        Some(LanguageArgument::En) | None => Language::English,
    };
    match (arguments.name, arguments.search) {
        (Some(_), Some(_)) => Err("give either name or search".to_owned()),
        (Some(name), None) => full_text(name.trim(), language),
        (None, Some(words)) => found(&words, language),
        (None, None) => Ok(ToolOutput::text(names())),
    }
}

fn full_text(name: &str, language: Language) -> Result<ToolOutput, String> {
    let name = name.trim_end_matches("()");
    if let Some(builtin) = library::robot(name) {
        return Ok(ToolOutput::text(describe::robot(builtin, language)));
    }
    if library::is_python(name) {
        let text = format!("`{name}` is Python's own and does what Python 3 documents.");
        return Ok(ToolOutput::text(text));
    }
    let shown: String = name.chars().take(80).collect();
    let near: Vec<&str> = all()
        .map(|builtin| builtin.name)
        .filter(|other| name.len() >= 3 && (other.contains(name) || name.contains(other)))
        .take(10)
        .collect();
    Err(match near.is_empty() {
        true => format!("there is no function {shown:?}; search finds functions by words"),
        false => format!(
            "there is no function {shown:?}; similar are {}",
            near.join(", ")
        ),
    })
}

fn found(words: &str, language: Language) -> Result<ToolOutput, String> {
    let words: Vec<String> = words.split_whitespace().map(str::to_lowercase).collect();
    if words.is_empty() {
        return Err("search has no words".to_owned());
    }
    let mut hits: Vec<(usize, &Builtin)> = Vec::new();
    for builtin in all() {
        let name = builtin.name.to_lowercase();
        let text = library::searched_text(builtin);
        if words.iter().all(|word| text.contains(word.as_str())) {
            let in_name = words.iter().filter(|word| name.contains(word.as_str()));
            hits.push((words.len() - in_name.count(), builtin));
        }
    }
    hits.sort_by_key(|(rank, builtin)| (*rank, builtin.name));
    let count = hits.len();
    if count == 0 {
        let text = format!("no function has all of: {}", words.join(" "));
        return Ok(ToolOutput::text(shortened_words(text)));
    }
    let mut text = String::new();
    for (_, builtin) in hits.iter().take(FOUND_MAX) {
        let summary = builtin.summary.in_language(language);
        text.push_str(&format!("{}\n    {summary}\n", builtin.signature()));
    }
    if count > FOUND_MAX {
        text.push_str(&format!(
            "and {} more; search for more words\n",
            count - FOUND_MAX
        ));
    }
    Ok(ToolOutput::text(text))
}

fn shortened_words(text: String) -> String {
    super::server::shortened(text, 400)
}

fn names() -> String {
    let mut by_category: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for builtin in all() {
        by_category
            .entry(builtin.category.name())
            .or_default()
            .push(builtin.name);
    }
    let mut text = String::new();
    for (category, mut names) in by_category {
        names.sort_unstable();
        text.push_str(&format!("{category}: {}\n", names.join(", ")));
    }
    text
}
