//! `eliteserver translate`: a program of Universal Robots as one of this controller.

use std::io::Write;
use std::path::Path;

use messages::text;
use program_import::translate::{Message, translate as translated};
use serde_json::json;

use crate::cli::{FindingFormat, TranslateArgs};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::check::{display_name, read_script};
use crate::language;
use crate::logging;
use crate::ports::escape::EscapedText;

/// Exit status: 0 complete, 1 something has no counterpart, 2 unreadable.
pub fn translate(args: &TranslateArgs) -> CommandResult {
    let source = read_script(&args.file).map_err(CommandError::sentence)?;
    let name = display_name(&args.file);
    let short_name = args
        .file
        .file_name()
        .map_or_else(|| name.clone(), |file| file.to_string_lossy().into_owned());
    let translation = translated(&source.text, &short_name)
        .map_err(|error| CommandError::sentence(text!("{name}: {error}", "{name}：{error}")))?;
    if let Some(path) = &args.report {
        write(path, &translation.report(&short_name, language::chosen()))?;
    }
    let remarks: String = translation
        .messages
        .iter()
        .map(|message| remark(message, args.format))
        .collect();
    match &args.output {
        Some(path) => {
            write(path, &translation.text)?;
            // Whoever reads may have seen enough; the status still tells.
            let _ = std::io::stdout().write_all(remarks.as_bytes());
        }
        None => {
            logging::flush_within(std::time::Duration::from_secs(1));
            let _ = std::io::stderr().write_all(remarks.as_bytes());
            let _ = std::io::stdout().write_all(translation.text.as_bytes());
        }
    }
    Ok(CommandStatus::of_answer(translation.is_complete()))
}

fn remark(message: &Message, format: FindingFormat) -> String {
    match format {
        FindingFormat::Human => {
            let said = language::shown(message).to_string();
            format!("{}\n", EscapedText(&said))
        }
        FindingFormat::Json => {
            let row = json!({
                "line": message.line,
                "kind": message.kind.word(),
                "name": message.name,
                "text": message.text,
            });
            format!("{row}\n")
        }
    }
}

/// Writes a file; the error is a sentence with its name.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), CommandError> {
    std::fs::write(path, text).map_err(|error| {
        CommandError::sentence(text!(
            "cannot write {}: {error}",
            "无法写入 {}：{error}",
            display_name(path)
        ))
    })
}
