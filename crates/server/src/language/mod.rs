//! The language in which this process talks to people: of findings, errors of programs, stops and alarms. Chosen once,
//! at the start. Logs of the service itself, recordings and answers of ports stay English.
//!
//! Owns the Chinese of the command line: help texts, what is wrong with a command line, and what commands say.

mod libraries;
mod script_tests;
mod sentences;
mod words;

use std::borrow::Cow;
use std::ffi::OsString;
use std::sync::OnceLock;

use elite_runtime::chinese;
use elite_runtime::message::Message;
use elite_syntax::Diagnostic;
use elite_syntax::chinese::{self as texts, Translations};
use messages::{InLanguage, Language, Localized};

use crate::cli::TextLanguage;

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

/// What tests of programs report: their own sentences, those about conditions and the robot. What programs raise is
/// Python's own in part, so that only these are looked for in it.
const OF_SCRIPT_TESTS: Translations = Translations {
    sentences: &[script_tests::SENTENCES, chinese::SENTENCES],
    words: &[
        script_tests::WORDS,
        libraries::SENTENCES,
        libraries::WORDS,
        chinese::WORDS,
    ],
};

/// Begins how the program under test has ended.
const PROGRAM_UNDER_TEST: &str = "the program under test ";

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

/// A text as it is shown in the language of this process.
#[allow(dead_code)]
pub fn shown<T: Localized>(text: &T) -> InLanguage<'_, T> {
    text.in_language(chosen())
}

/// Lines of a command for people, in the language of this process: those that the tables have.
pub fn told(english: &str) -> Cow<'_, str> {
    told_in(chosen(), english)
}

/// Lines of a command in one of the languages. What programs read is asked for in English.
pub fn told_in(language: Language, english: &str) -> Cow<'_, str> {
    match language {
        Language::Chinese => Cow::Owned(in_chinese(english)),
        Language::English => Cow::Borrowed(english),
    }
}

/// What a program or the robot reported, one line, in one of the languages. Python's own words stay.
pub fn reported_in(language: Language, english: &str) -> Cow<'_, str> {
    let chinese = match language {
        Language::Chinese => chinese::reported(english),
        Language::English => None,
    };
    chinese.map_or(Cow::Borrowed(english), Cow::Owned)
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

/// A line of the report of tests in Chinese.
pub fn test_line_in_chinese(english: &str) -> String {
    let text = english.trim_start();
    let blanks = &english[..english.len() - text.len()];
    let chinese = OF_SCRIPT_TESTS.sentence(text);
    format!("{blanks}{}", chinese.as_deref().unwrap_or(text))
}

/// What a test of a program reported, in Chinese, line by line. Python's own words stay.
pub fn test_report_in_chinese(english: &str) -> String {
    let lines = english.split_inclusive('\n').map(|line| {
        let text = line.trim();
        let (before, after) = line.split_once(text).unwrap_or((line, ""));
        let own = match text.split_once(": ") {
            Some((end, error)) if end.starts_with(PROGRAM_UNDER_TEST) => {
                let end = OF_SCRIPT_TESTS.sentence(end);
                let error = chinese::reported(error).unwrap_or_else(|| error.to_owned());
                end.map(|end| format!("{end}：{error}"))
            }
            Some((kind, said)) if is_exception(kind) || kind == "help" => {
                let said = OF_SCRIPT_TESTS.sentence(said);
                said.map(|said| format!("{kind}: {said}"))
            }
            _ => OF_SCRIPT_TESTS.sentence(text),
        };
        match own {
            Some(own) => format!("{before}{own}{after}"),
            None => chinese::report(line),
        }
    });
    lines.collect()
}

/// Whether a word is the type of an exception, as it stands at the beginning of a report.
fn is_exception(word: &str) -> bool {
    let is_name = word
        .bytes()
        .all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    is_name
        && word
            .bytes()
            .next()
            .is_some_and(|byte| byte.is_ascii_uppercase())
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
