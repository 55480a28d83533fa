//! The remarks of a translation as a page.

use core::fmt::Write;

use super::{MessageKind, Translation};

/// A page of Markdown.
pub fn page(translation: &Translation, name: &str) -> String {
    let mut page = format!("# Translation of {}\n\n", cell(name));
    let count = |kind| {
        translation
            .messages
            .iter()
            .filter(|message| message.kind == kind)
            .count()
    };
    let missing = count(MessageKind::Missing);
    let _ = match missing {
        0 => writeln!(page, "Everything has a counterpart."),
        _ => writeln!(
            page,
            "{missing} lines have no counterpart: the program raises `NotImplementedError` where it reaches them."
        ),
    };
    let sections = [
        (MessageKind::Missing, "Without a counterpart"),
        (MessageKind::Changed, "Changed"),
        (
            MessageKind::Helper,
            "Conversions and functions that were added",
        ),
        (MessageKind::Renamed, "Renamed"),
    ];
    for (kind, title) in sections {
        if count(kind) == 0 {
            continue;
        }
        let _ = write!(
            page,
            "\n## {title}\n\n| line | name | what |\n|---|---|---|\n"
        );
        for message in translation
            .messages
            .iter()
            .filter(|message| message.kind == kind)
        {
            let _ = writeln!(
                page,
                "| {} | `{}` | {} |",
                message.line,
                cell(&message.name),
                cell(&message.text)
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
