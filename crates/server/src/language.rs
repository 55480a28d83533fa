//! The language in which this process talks to people: of findings, errors of programs, stops and alarms. Chosen once,
//! at the start. Logs of the service itself, recordings and answers of ports stay English.

use std::ffi::OsString;
use std::sync::OnceLock;

use messages::{Language, Localized, LocalizedDisplay};

use crate::cli::TextLanguage;

/// Stands before what is wrong.
const PROGRAM: &str = "eliteserver: ";

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
    choose_this(given.map_or_else(of_environment, Language::from));
}

/// Takes this language unless one is chosen.
pub fn choose_this(language: Language) {
    CHOSEN.get_or_init(|| language);
}

/// The language of a command line that is not read yet, or that cannot be: its option, or the environment.
pub fn of_arguments(arguments: &[OsString]) -> Language {
    let texts: Vec<_> = arguments
        .iter()
        .map(|text| text.to_string_lossy())
        .collect();
    let given = texts.iter().enumerate().find_map(|(index, text)| {
        let value = text.strip_prefix("--language")?;
        value.strip_prefix('=').or_else(|| {
            texts
                .get(index + 1)
                .filter(|_| value.is_empty())
                .map(|text| &**text)
        })
    });
    match given {
        Some("zh") => Language::Chinese,
        Some(_) => Language::English,
        None => of_environment(),
    }
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

/// One of two forms of a text.
pub fn pick<'t>(english: &'t str, chinese: &'t str) -> &'t str {
    chosen().pick(english, chinese)
}

/// The language in which people are talked to.
pub fn chosen() -> Language {
    CHOSEN.get().copied().unwrap_or(Language::English)
}

/// A text as it is shown in the language of this process.
pub fn shown<T: Localized>(text: &T) -> LocalizedDisplay<'_, T> {
    text.in_language(chosen())
}

/// A text with blanks behind it, so wide on a terminal: Chinese letters take two columns.
pub fn padded(text: &str, columns: usize) -> String {
    let blanks = columns.saturating_sub(columns_of(text));
    format!("{text}{:blanks$}", "")
}

/// Columns of a text on a terminal.
pub fn columns_of(text: &str) -> usize {
    text.chars()
        .map(|letter| 1 + usize::from(is_wide(letter)))
        .sum()
}

/// Whether a letter takes two columns: Chinese ones and their punctuation.
pub const fn is_wide(letter: char) -> bool {
    matches!(
        letter,
        '\u{2e80}'..='\u{a4cf}'
            | '\u{ac00}'..='\u{d7a3}'
            | '\u{f900}'..='\u{faff}'
            | '\u{fe30}'..='\u{fe6f}'
            | '\u{ff00}'..='\u{ff60}'
            | '\u{20000}'..='\u{3fffd}'
    )
}

/// Says a text on stderr in the language of this process.
pub fn say(text: &impl Localized) {
    crate::logging::say(&shown(text).to_string());
}

/// Says what is wrong on stderr in the language of this process, behind the name of the program.
pub fn complain(text: &impl Localized) {
    crate::logging::say(&format!("{PROGRAM}{}", shown(text)));
}
