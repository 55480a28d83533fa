//! What the editor of the page is told about a text: findings, completions, the thing under the pointer, the call
//! around the cursor. The same answers as the language server's; this module only gives them the page's form.
//!
//! Places are numbers of characters from the beginning of the text. Everything here reads a text of any kind and takes
//! time for it, so it belongs on the compile pool.

use std::path::Path;

use editor::analysis::completion::{self, CompletionKind};
use editor::analysis::fixes::fixes;
use editor::analysis::words::Language;
use editor::analysis::{Analysis, TextKind, hover, signature};
use elite_syntax::{Severity, Span};
use messages::Localized;
use serde::Deserialize;
use serde_json::{Value, json};
use thiserror::Error;

use crate::orders::{NAME_BYTES_MAX, PROGRAM_BYTES_MAX};

/// Completions in one answer: the nearest.
const ITEMS_MAX: usize = 400;

/// A text, and where in it something is asked.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextQuery {
    /// How findings call it; the name also says whether it is a test of programs.
    #[serde(default)]
    pub name: String,
    /// The text.
    pub text: String,
    /// Characters before the place; the end of the text for larger ones.
    #[serde(default)]
    pub at: usize,
    /// `en` or `zh`.
    #[serde(default)]
    pub language: String,
}

/// A reason why a question is not answered, told in a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error, Localized)]
pub enum QuestionError {
    /// The text is too long.
    #[error("text is {0} bytes long; it must be at most {PROGRAM_BYTES_MAX} bytes long")]
    #[zh("text 有 {0} 字节；最多 {PROGRAM_BYTES_MAX} 字节")]
    Text(usize),
    /// The name is too long.
    #[error("name is {0} bytes long; it must be at most {NAME_BYTES_MAX} bytes long")]
    #[zh("name 有 {0} 字节；最多 {NAME_BYTES_MAX} 字节")]
    Name(usize),
}

impl TextQuery {
    /// Looks at its sizes.
    ///
    /// # Errors
    /// [`QuestionError`]
    pub fn check(&self) -> Result<(), QuestionError> {
        match (self.text.len(), self.name.len()) {
            (bytes, _) if bytes > PROGRAM_BYTES_MAX => Err(QuestionError::Text(bytes)),
            (_, bytes) if bytes > NAME_BYTES_MAX => Err(QuestionError::Name(bytes)),
            _ => Ok(()),
        }
    }

    fn analysis(&self) -> Analysis {
        let kind = TextKind::of_path(Path::new(&self.name));
        Analysis::of(&self.name, &self.text, kind)
    }

    fn language(&self) -> Language {
        Language::of_locale(&self.language)
    }

    /// The byte of the place.
    fn offset(&self) -> u32 {
        let mut characters = self.text.char_indices();
        let byte = characters.nth(self.at).map(|(byte, _)| byte);
        byte.unwrap_or(self.text.len()) as u32
    }

    /// A part of the text, in characters.
    fn place(&self, span: Span) -> (usize, usize) {
        let range = span.range();
        let count = |part: Option<&str>| part.map_or(0, |part| part.chars().count());
        let from = count(self.text.get(..range.start));
        (from, from + count(self.text.get(range)))
    }
}

/// What `check` finds, as `check --format json` tells it but in the language of the question, with what can be done
/// about it.
pub fn findings(question: &TextQuery) -> Value {
    let analysis = question.analysis();
    let language = question.language();
    let rows = analysis.findings().iter().map(|finding| {
        let fields = finding.fields(&analysis.file);
        let changes = fixes(&analysis, finding, language).into_iter();
        let changes = changes.map(|fix| {
            let edits = fix.edits.iter().map(|edit| {
                let (from, to) = question.place(edit.span);
                json!({"from": from, "to": to, "text": edit.text})
            });
            json!({"title": fix.title, "edits": edits.collect::<Value>()})
        });
        json!({
            "line": fields.line,
            "column": fields.column,
            "end_line": fields.end_line,
            "end_column": fields.end_column,
            "severity": match finding.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
            },
            "code": fields.code,
            "message": finding.message.in_language(language),
            "help": finding.help.as_ref().map(|help| help.in_language(language)),
            "fixes": changes.collect::<Value>(),
        })
    });
    rows.collect()
}

/// What could be written at the place, the nearest first, and the part of the text that it replaces.
pub fn completions(question: &TextQuery) -> Value {
    let analysis = question.analysis();
    let found = completion::complete(&analysis, question.offset(), question.language());
    let (from, to) = question.place(found.span);
    let items = found.items.iter().take(ITEMS_MAX).map(|item| {
        let kind = match item.kind {
            CompletionKind::Function => "function",
            CompletionKind::Method => "method",
            CompletionKind::Class => "class",
            CompletionKind::Variable => "variable",
            CompletionKind::Field => "property",
            CompletionKind::Module => "namespace",
            CompletionKind::Keyword => "keyword",
            CompletionKind::Argument => "argument",
            CompletionKind::Text => "text",
        };
        json!({"label": item.label, "kind": kind, "detail": item.detail, "rank": item.rank})
    });
    json!({"from": from, "to": to, "complete": found.items.len() <= ITEMS_MAX, "items": items.collect::<Value>()})
}

/// What there is to say about the thing at the place, in Markdown; null for nothing.
pub fn about_place(question: &TextQuery) -> Value {
    let analysis = question.analysis();
    let found = hover::hover(&analysis, question.offset(), question.language());
    found.map_or(Value::Null, |hover| {
        let (from, to) = question.place(hover.span);
        json!({"from": from, "to": to, "text": hover.text})
    })
}

/// How the function is called whose call is around the place; null outside of calls.
pub fn call_around(question: &TextQuery) -> Value {
    let analysis = question.analysis();
    let found = signature::signature(&analysis, question.offset(), question.language());
    found.map_or(Value::Null, |call| {
        let parameters = call.parameters.iter();
        let parameters =
            parameters.map(|(written, text)| json!({"written": written, "text": text}));
        json!({
            "label": call.label,
            "text": call.text,
            "parameters": parameters.collect::<Value>(),
            "active": call.active,
        })
    })
}

/// The long text about a function of the robot or of Python, in Markdown; null for other names.
pub fn about_name(name: &str, language: &str) -> Value {
    json!(completion::resolve(name, Language::of_locale(language)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A question at the bar in the text.
    fn at(text: &str, language: &str) -> TextQuery {
        let (before, behind) = text.split_once('|').unwrap();
        TextQuery {
            name: "a.script".to_owned(),
            text: format!("{before}{behind}"),
            at: before.chars().count(),
            language: language.to_owned(),
        }
    }

    #[test]
    fn findings_have_places_severities_and_changes() {
        let question = at(
            "# 中文 🤖\nx = undefined_thing\nmvoej([0,0,0,0,0,0])\n|",
            "en",
        );
        let found = findings(&question);
        assert_eq!(
            (&found[0]["line"], &found[0]["code"]),
            (&json!(2), &json!("undefined-name"))
        );
        assert_eq!(found[0]["severity"], "warning");
        assert_eq!(findings(&at("x = (\n|", "en"))[0]["severity"], "error");
        let fix = &found[1]["fixes"][0]["edits"][0];
        assert_eq!(fix["text"], "movej");
        let (from, to) = (fix["from"].as_u64().unwrap(), fix["to"].as_u64().unwrap());
        let replaced: String = question
            .text
            .chars()
            .skip(from as usize)
            .take((to - from) as usize)
            .collect();
        assert_eq!(replaced, "mvoej");
    }

    #[test]
    fn completions_are_those_of_the_language_server() {
        let question = at("# 🤖\nmov|", "en");
        let found = completions(&question);
        let labels: Vec<&str> = found["items"]
            .as_array()
            .unwrap()
            .iter()
            .map(|item| item["label"].as_str().unwrap())
            .collect();
        assert!(
            labels.contains(&"movej") && labels.contains(&"movel"),
            "{labels:?}"
        );
        assert_eq!((&found["from"], &found["to"]), (&json!(4), &json!(7)));
        let after_dot = completions(&at("x = []\nx.app|", "en"));
        assert_eq!(after_dot["items"][0]["label"], "append");
        let argument = completions(&at("movej([0,0,0,0,0,0], |", "en"));
        assert_eq!(argument["items"][0]["kind"], "argument");
    }

    #[test]
    fn hover_and_calls_speak_both_languages() {
        let english = about_place(&at("mov|ej([0,0,0,0,0,0])", "en"));
        let chinese = about_place(&at("mov|ej([0,0,0,0,0,0])", "zh-CN"));
        assert!(english["text"].as_str().unwrap().contains("Parameters"));
        assert!(chinese["text"].as_str().unwrap().contains("参数"));
        assert_eq!(about_place(&at("  |  ", "en")), Value::Null);
        let call = call_around(&at("movej([0,0,0,0,0,0], a=1.4, v=|", "en"));
        let active = call["active"].as_u64().unwrap() as usize;
        assert!(
            call["parameters"][active]["written"]
                .as_str()
                .unwrap()
                .starts_with('v')
        );
        assert_eq!(call_around(&at("x = 1|", "en")), Value::Null);
        assert!(
            about_name("movej", "en")
                .as_str()
                .unwrap()
                .contains("movej")
        );
        assert_eq!(about_name("<b>", "en"), Value::Null);
    }

    #[test]
    fn what_is_too_long_is_not_read() {
        let mut question = at("|", "en");
        assert_eq!(question.check(), Ok(()));
        question.text = " ".repeat(PROGRAM_BYTES_MAX + 1);
        assert_eq!(
            question.check(),
            Err(QuestionError::Text(PROGRAM_BYTES_MAX + 1))
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn any_text_is_answered_with_places_inside_of_it(
            text in r#"[a-z_0-9 .,()\[\]"'#$=:\n🤖中]{0,60}"#,
            at in 0_usize..80,
        ) {
            let question = TextQuery { name: String::new(), text, at, language: String::new() };
            let length = question.text.chars().count() as u64;
            for answer in [completions(&question), about_place(&question)] {
                if let Some(to) = answer["to"].as_u64() {
                    prop_assert!(answer["from"].as_u64().unwrap() <= to && to <= length);
                }
            }
            call_around(&question);
            findings(&question);
        }
    }
}
