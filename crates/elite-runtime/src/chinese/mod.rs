//! What is told about programs and the robot in Chinese: findings, errors of builtins, refusals, stops.
//!
//! Owns the table of this crate's sentences and of those of the motion (`motion-api`). Inside, in recordings and
//! towards programs every text stays English; whoever shows one to people asks here. Types of exceptions and Python's
//! own words stay as they are.

mod table;

use elite_syntax::Diagnostic;
use elite_syntax::chinese;
use elite_syntax::chinese::{PhraseTable, Translations};

use crate::message::Message;

/// Sentences about the robot.
pub const SENTENCES: PhraseTable = table::SENTENCES;
/// Words that stand in sentences.
pub const WORDS: PhraseTable = table::WORDS;

const ALL: Translations = Translations {
    sentences: &[SENTENCES, chinese::SENTENCES],
    words: &[WORDS, chinese::WORDS],
};

/// What programs raise is Python's own in part: sentences about texts are not looked for in it.
const OF_ROBOT: Translations = Translations {
    sentences: &[SENTENCES],
    words: &[WORDS],
};

/// A sentence about a text or the robot.
pub fn sentence(english: &str) -> Option<String> {
    ALL.sentence(english)
}

/// A finding of `check`.
pub fn finding(finding: &Diagnostic) -> Diagnostic {
    ALL.finding(finding)
}

/// A message as people are told it; what programs print is theirs.
pub fn message(message: &Message) -> Message {
    let mut told = message.clone();
    match &mut told {
        Message::Print { .. } => {}
        Message::Log { text, .. } | Message::Robot { text, .. } => {
            if let Some(chinese) = log_line(text) {
                *text = chinese;
            }
        }
        Message::ScriptError {
            summary, report, ..
        } => {
            *report = self::report(report);
            if let Some(chinese) = headline(summary) {
                *summary = chinese;
            }
        }
    }
    told
}

/// What a program or the robot reported, one line, as it stands in a log or a recording.
pub fn reported(english: &str) -> Option<String> {
    headline(english).or_else(|| log_line(english))
}

/// A line of the log; a warning about a motion has its command in front: `movel: a speed of …`.
fn log_line(english: &str) -> Option<String> {
    ALL.sentence(english).or_else(|| {
        let (command, said) = english.split_once(": ")?;
        let is_command = command
            .bytes()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'_');
        let said = ALL.sentence(said).filter(|_| is_command)?;
        Some(format!("{command}：{said}"))
    })
}

/// `Type: message` with the message in Chinese.
fn headline(english: &str) -> Option<String> {
    let (kind, said) = english.split_once(": ")?;
    let is_kind = kind
        .bytes()
        .all(|c| c.is_ascii_alphanumeric() || matches!(c, b'.' | b'_'));
    let tables = match kind {
        "SyntaxError" => ALL,
        _ => OF_ROBOT,
    };
    let said = tables.sentence(said).filter(|_| is_kind)?;
    Some(format!("{kind}: {said}"))
}

/// A report of an error line by line: titles and advice of findings, and the lines with a type and a message. Lines of
/// programs stay.
pub fn report(english: &str) -> String {
    let lines = english.split_inclusive('\n').map(|line| {
        let (text, end) = line.split_at(line.trim_end_matches('\n').len());
        let marked = ["error[", "warning["]
            .iter()
            .any(|mark| text.starts_with(mark));
        let advice = text.split_once("= help: ");
        let told = match (marked, text.split_once("]: "), advice) {
            (true, Some((head, said)), _) => sentence(said).map(|said| format!("{head}]: {said}")),
            (_, _, Some((blanks, said))) if blanks.trim().is_empty() => {
                sentence(said).map(|said| format!("{blanks}= help: {said}"))
            }
            _ => advice_line(text).or_else(|| headline(text)),
        };
        format!("{}{end}", told.as_deref().unwrap_or(text))
    });
    lines.collect()
}

/// Advice below the line of a program: `  help: …`. One that consists of two sentences is told by both.
fn advice_line(english: &str) -> Option<String> {
    let (blanks, said) = english.split_once("help: ")?;
    if !blanks.trim().is_empty() {
        return None;
    }
    let whole = sentence(said).or_else(|| {
        let (first, second) = said.split_once("; ")?;
        Some(format!("{}；{}", sentence(first)?, sentence(second)?))
    });
    Some(format!("{blanks}help: {}", whole?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_told_in_chinese_and_types_stay() {
        let english = "p.script:1:1\n  movej(1)\n  ^^^^^^^^\nTypeError: movej(): q must be six joint positions in \
                       rad, not int (1)";
        assert!(
            report(english)
                .ends_with("\nTypeError: movej(): q 必须是六个关节位置（rad），不能是 int（1）")
        );
        let summary = "ZeroDivisionError: division by zero";
        assert_eq!(headline(summary), None);
        let said = "SyntaxError: expected ':' after the 'if' condition, found the end of the line";
        assert_eq!(
            headline(said).as_deref(),
            Some("SyntaxError: 应为'if' 条件之后的 ':'，却是行尾")
        );
        // Python's own words are not taken for ours.
        assert_eq!(headline("ValueError: name 'x' is not defined"), None);
        let stop = sentence(
            "protective stop: upper arm and wrist 1 were about to run into each other, by 3.0 mm where the arm would \
             come to rest",
        );
        assert_eq!(
            stop.as_deref(),
            Some("保护性停止：上臂与手腕 1即将相撞，手臂停下处重叠 3.0 mm")
        );
        // "to" is a word of its own, and a part of longer sentences.
        let plane = sentence(
            "protective stop: the tool was about to cross safety plane \"fence\" of the cell: \
             it would come to rest 0.0012 m behind it",
        );
        assert_eq!(
            plane.as_deref(),
            Some("保护性停止：工具即将越过单元的安全平面 \"fence\"：将停在其后 0.0012 m 处")
        );
    }
}
