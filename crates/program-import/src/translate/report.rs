//! The remarks of a translation as a page.

use core::fmt::Write;

use messages::{Language, Text, text};

use super::{MessageKind, Translation};

/// A page of Markdown.
pub fn page(translation: &Translation, name: &str, language: Language) -> String {
    let shown = |text: Text| text.in_language(language).to_owned();
    let of_kind = |kind| {
        let messages = translation.messages.iter();
        messages.filter(move |message| message.kind == kind)
    };
    let title = text!("Translation of {}", "{} 的翻译", cell(name));
    let mut page = format!("# {}\n\n", shown(title));
    let missing = of_kind(MessageKind::Missing).count();
    let summary = match missing {
        0 => text!("Everything has a counterpart.", "全部都有对应。"),
        _ => text!(
            "{missing} lines have no counterpart: the program raises `NotImplementedError` where \
             it reaches them.",
            "{missing} 行没有对应：程序运行到那里时引发 `NotImplementedError`。"
        ),
    };
    let _ = writeln!(page, "{}", shown(summary));
    let sections = [
        (
            MessageKind::Missing,
            text!("Without a counterpart", "没有对应"),
        ),
        (MessageKind::Changed, text!("Changed", "改动")),
        (
            MessageKind::Helper,
            text!(
                "Conversions and functions that were added",
                "添加的换算和函数"
            ),
        ),
        (MessageKind::Renamed, text!("Renamed", "改名")),
    ];
    for (kind, title) in sections {
        if of_kind(kind).next().is_none() {
            continue;
        }
        let head = text!("| line | name | what |", "| 行 | 名称 | 说明 |");
        let _ = write!(
            page,
            "\n## {}\n\n{}\n|---|---|---|\n",
            shown(title),
            shown(head)
        );
        for message in of_kind(kind) {
            let _ = writeln!(
                page,
                "| {} | `{}` | {} |",
                message.line,
                cell(&message.name),
                cell(message.text.in_language(language))
            );
        }
    }
    page
}

/// A text that keeps to one cell of a table.
fn cell(text: &str) -> String {
    text.chars()
        .filter(|c| !c.is_control())
        .collect::<String>()
        .replace('|', "\\|")
}
