//! The language in which this process talks to people: of findings, errors of programs, stops and alarms. Chosen once,
//! at the start. Logs of the service itself, recordings and answers of ports stay English.
//!
//! Owns the Chinese of the command line: help texts, what is wrong with a command line, and what commands say.

mod help;
mod libraries;
mod sentences;
mod words;

use std::borrow::Cow;
use std::ffi::OsString;
use std::sync::OnceLock;

use editor::analysis::words::Language;
use elite_runtime::chinese;
use elite_runtime::message::Message;
use elite_syntax::Diagnostic;
use elite_syntax::chinese::{self as texts, PhraseTable, Translations};

use crate::cli::TextLanguage;

/// Help texts of the command line.
pub(crate) const HELP: PhraseTable = help::HELP;

/// What commands say, and the crates whose errors they pass on. Words stand alone as well: a name in a column.
const ALL: Translations = Translations {
    sentences: &[
        sentences::SENTENCES,
        words::WORDS,
        libraries::SENTENCES,
        libraries::WORDS,
        chinese::SENTENCES,
        chinese::WORDS,
        texts::SENTENCES,
    ],
    words: &[texts::WORDS],
};

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
        true => Cow::Owned(ALL.finding(finding)),
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

/// Lines of a command for people, in the language of this process: those that the tables have.
pub fn told(english: &str) -> Cow<'_, str> {
    match is_chinese() {
        true => Cow::Owned(in_chinese(english)),
        false => Cow::Borrowed(english),
    }
}

/// Lines of a command in Chinese, those that the tables have.
pub fn in_chinese(english: &str) -> String {
    english.split_inclusive('\n').map(line_in_chinese).collect()
}

fn line_in_chinese(line: &str) -> String {
    let text = line.trim();
    let (before, after) = line.split_once(text).unwrap_or((line, ""));
    let (head, said) = match text.strip_prefix(PROGRAM) {
        Some(said) => (PROGRAM, said),
        None => ("", text),
    };
    let chinese = ALL.sentence(said);
    format!(
        "{before}{head}{}{after}",
        chinese.as_deref().unwrap_or(said)
    )
}

/// The report of an error of a program in the language of this process.
pub fn report(english: &str) -> Cow<'_, str> {
    match is_chinese() {
        true => Cow::Owned(chinese::report(english)),
        false => Cow::Borrowed(english),
    }
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
