//! `eliteserver check`: parses and checks scripts without running them.

use std::io::{Read, Write};
use std::path::Path;

use elite_lang::{Diagnostic, SourceFile};
use serde_json::json;

use crate::cli::{CheckArgs, FindingFormat};
use crate::commands::run::SCRIPT_BYTES_MAX;
use crate::logging;
use crate::ports::shown::{Escaped, Lines};

/// Exit status: 0 clean, 1 findings (warnings count), 2 unreadable.
pub fn check(args: &CheckArgs) -> u8 {
    let known = elite_runtime::builtins::known_names();
    let mut status = 0;
    for path in &args.files {
        match read_script(path) {
            Ok(text) => {
                let file = SourceFile::new(display_name(path), text);
                let findings = elite_lang::check(file.clone(), &known);
                for finding in &findings {
                    // Whoever reads may have seen enough; the status still tells.
                    let shown = render(finding, &file, args.format);
                    let _ = std::io::stdout().write_all(shown.as_bytes());
                }
                if findings.len() == elite_lang::FINDINGS_MAX {
                    let most = elite_lang::FINDINGS_MAX;
                    logging::say(&format!(
                        "eliteserver: {}: only the first {most} findings are shown",
                        file.name()
                    ));
                }
                if !findings.is_empty() {
                    status = status.max(1);
                }
            }
            Err(sentence) => {
                logging::say(&format!("eliteserver: {sentence}"));
                status = 2;
            }
        }
    }
    status
}

fn render(finding: &Diagnostic, file: &SourceFile, format: FindingFormat) -> String {
    match format {
        FindingFormat::Human => {
            let picture = elite_lang::render_human(finding, file, false);
            let picture = picture.trim_end_matches('\n');
            picture
                .lines()
                .map(|line| format!("{}\n", Lines(line)))
                .collect()
        }
        FindingFormat::Json => {
            let fields = finding.fields(file);
            let object = json!({
                "file": fields.file,
                "line": fields.line,
                "column": fields.column,
                "end_line": fields.end_line,
                "end_column": fields.end_column,
                "code": fields.code,
                "message": fields.message,
                "help": fields.help,
            });
            format!("{object}\n")
        }
    }
}

/// The name of a script in messages.
pub fn display_name(path: &Path) -> String {
    if path == Path::new("-") {
        "<stdin>".to_owned()
    } else {
        Escaped(&path.display().to_string()).to_string()
    }
}

/// Reads a script, `-` from stdin; the error is a sentence.
pub fn read_script(path: &Path) -> Result<String, String> {
    let mut bytes = Vec::new();
    let limit = SCRIPT_BYTES_MAX as u64 + 1;
    let read = if path == Path::new("-") {
        std::io::stdin().lock().take(limit).read_to_end(&mut bytes)
    } else {
        std::fs::File::open(path).and_then(|file| file.take(limit).read_to_end(&mut bytes))
    };
    let name = display_name(path);
    read.map_err(|error| format!("cannot read the script {name}: {error}"))?;
    if bytes.len() > SCRIPT_BYTES_MAX {
        return Err(format!(
            "the script {name} is larger than the {} MiB allowed",
            SCRIPT_BYTES_MAX >> 20
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        format!(
            "the script {name} is not UTF-8 text (byte {} is not)",
            error.utf8_error().valid_up_to() + 1
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_for_people_end_with_a_line_end() {
        let file = SourceFile::new("pick.script", "1a");
        let found = elite_lang::check(file.clone(), &elite_lang::KnownNames::default());
        let pictures: Vec<String> = found
            .iter()
            .map(|finding| render(finding, &file, FindingFormat::Human))
            .collect();
        assert!(!pictures.is_empty());
        for picture in pictures {
            assert!(
                picture.ends_with('\n') && !picture.ends_with("\n\n"),
                "{picture:?}"
            );
        }
    }

    #[test]
    fn findings_are_one_json_object_a_line() {
        let text = "def f():\n    spee = 1\n    movej([0, -90, 0, 0, 0, 0], v=sped)\n    return 1\n    sync()\n";
        let file = SourceFile::new("pick.script", text);
        let known = elite_runtime::builtins::known_names();
        let found: Vec<(String, u64)> = elite_lang::check(file.clone(), &known)
            .iter()
            .map(|finding| {
                let line = render(finding, &file, FindingFormat::Json);
                let object: serde_json::Value = serde_json::from_str(line.trim_end())
                    .unwrap_or_else(|error| panic!("{line}: {error}"));
                let code = object["code"].as_str().unwrap_or_default().to_owned();
                (code, object["line"].as_u64().unwrap_or_default())
            })
            .collect();
        let expected = [
            ("unused-variable", 2),
            ("degrees", 3),
            ("undefined-name", 3),
            ("unreachable", 5),
        ];
        assert_eq!(found, expected.map(|(code, line)| (code.to_owned(), line)));
    }
}
