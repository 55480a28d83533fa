//! The language in which this process talks to people: of findings, errors of programs, stops and alarms. Chosen once,
//! at the start. Logs of the service itself, recordings and answers of ports stay English.

use std::borrow::Cow;
use std::sync::OnceLock;

use editor::analysis::words::Language;
use elite_runtime::chinese;
use elite_runtime::message::Message;
use elite_syntax::Diagnostic;

use crate::cli::TextLanguage;

static CHOSEN: OnceLock<Language> = OnceLock::new();

impl From<TextLanguage> for Language {
    fn from(language: TextLanguage) -> Self {
        match language {
            TextLanguage::En => Language::English,
            TextLanguage::Zh => Language::Chinese,
        }
    }
}

/// Takes the language of the command line, or that of the environment. The first choice stays.
pub fn choose(given: Option<TextLanguage>) {
    let language = given.map_or_else(of_environment, Language::from);
    CHOSEN.get_or_init(|| language);
}

/// The language of the environment: the first of the variables of POSIX that is set and not empty decides.
fn of_environment() -> Language {
    let names = ["LC_ALL", "LC_MESSAGES", "LANG"];
    let values = names
        .into_iter()
        .filter_map(|name| std::env::var(name).ok());
    let mut set = values.filter(|value| !value.is_empty());
    set.next()
        .map_or(Language::English, |value| Language::of_locale(&value))
}

/// Whether people are talked to in Chinese.
pub fn is_chinese() -> bool {
    CHOSEN.get() == Some(&Language::Chinese)
}

/// One of two forms of a text.
pub fn pick<'t>(english: &'t str, chinese: &'t str) -> &'t str {
    match is_chinese() {
        true => chinese,
        false => english,
    }
}

/// The language in which people are talked to.
pub fn chosen() -> Language {
    CHOSEN.get().copied().unwrap_or(Language::English)
}

/// A finding in the language of this process.
pub fn finding(finding: &Diagnostic) -> Cow<'_, Diagnostic> {
    match is_chinese() {
        true => Cow::Owned(chinese::finding(finding)),
        false => Cow::Borrowed(finding),
    }
}

/// A message in the language of this process.
pub fn message(message: &Message) -> Cow<'_, Message> {
    match is_chinese() {
        true => Cow::Owned(chinese::message(message)),
        false => Cow::Borrowed(message),
    }
}
