//! Programs do after formatting and renaming what they did before: each of those with an expected output is run again.

#[path = "../../elite-lang/tests/support/mod.rs"]
mod support;

use std::path::{Path, PathBuf};

use editor::analysis::fixes::Edit;
use editor::analysis::format::{Indent, applied, format};
use editor::analysis::rename::rename;
use editor::analysis::scopes::SymbolKind;
use editor::analysis::{Analysis, TextKind};
use elite_lang::ResumeOutcome;
use support::{Task, drive};

/// Names of one program that are renamed, one after the other.
const RENAMED_MAX: usize = 2;
/// Longest program, in bytes.
const BYTES_MAX: usize = 3000;

/// Programs that look at their own names, or at where they stand, do something else on purpose.
const REFLECTS: &[&str] = &[
    "dir(",
    "vars(",
    "locals(",
    "globals(",
    "attr(",
    "eval(",
    "exec(",
    "__dict__",
    "__name__",
    "__qualname__",
    "__slots__",
    "__match_args__",
    "__code__",
    "__annotations__",
    "__kwdefaults__",
    "signature",
    "lineno",
    "traceback",
    "inspect",
    "sys.",
    "namedtuple",
    "dataclass",
    "format_map",
    "%(",
    "{x",
    "**",
];

fn programs() -> Vec<(PathBuf, String)> {
    let mut open = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scripts")];
    let mut found = Vec::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let inner = std::fs::read_dir(path).unwrap();
            open.extend(inner.map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|ending| ending == "script") {
            let text = std::fs::read_to_string(&path).unwrap();
            if text.len() <= BYTES_MAX {
                found.push((path, text));
            }
        }
    }
    found.sort();
    found
}

/// What a program prints, and how it ends.
fn output(text: &str) -> String {
    let task = Task::new();
    let mut thread = task.spawn(text);
    let end = drive(&mut thread, &task.host);
    let mut output = task.host.output.take();
    if let ResumeOutcome::Failed(error) = end {
        output.push_str(error.headline().english());
    }
    output
}

/// Of every fourth program, from this one on.
fn programs_do_what_they_did(number: usize) {
    let (mut formatted, mut renamed) = (0, 0);
    for (path, text) in programs().into_iter().skip(number - 1).step_by(4) {
        let analysed = Analysis::of("program", &text, TextKind::Program);
        if analysed.has_errors() || text.contains("print_exc") {
            continue;
        }
        let before = output(&text);
        let indent = Indent {
            blanks: 2,
            tabs: false,
        };
        let edits = format(&analysed, indent).unwrap();
        assert_eq!(
            output(&applied(&text, &edits)),
            before,
            "{} formatted",
            path.display()
        );
        formatted += 1;
        if REFLECTS.iter().any(|word| text.contains(word)) {
            continue;
        }
        let kinds = [
            SymbolKind::Function,
            SymbolKind::Variable,
            SymbolKind::Parameter,
        ];
        let symbols = analysed.names.symbols.iter();
        let symbols = symbols.filter(|s| kinds.contains(&s.kind) && s.name.len() > 2);
        for symbol in symbols
            .filter(|s| !s.name.starts_with('_'))
            .take(RENAMED_MAX)
        {
            let new = format!("q_{}", symbol.name);
            let Ok(places) = rename(&analysed, symbol.occurrences[0].span.start, &new) else {
                continue;
            };
            let edits = places.iter().map(|span| Edit {
                span: *span,
                text: new.clone(),
            });
            let result = applied(&text, &edits.collect::<Vec<_>>());
            // Functions tell their names.
            let told = output(&result).replace(&new, &symbol.name);
            assert_eq!(told, before, "{}: {} renamed", path.display(), symbol.name);
            renamed += 1;
        }
    }
    assert!(
        formatted > 40 && renamed > 6,
        "{formatted} formatted, {renamed} renamed"
    );
}

#[test]
fn programs_do_what_they_did_first_quarter() {
    programs_do_what_they_did(1);
}

#[test]
fn programs_do_what_they_did_second_quarter() {
    programs_do_what_they_did(2);
}

#[test]
fn programs_do_what_they_did_third_quarter() {
    programs_do_what_they_did(3);
}

#[test]
fn programs_do_what_they_did_last_quarter() {
    programs_do_what_they_did(4);
}
