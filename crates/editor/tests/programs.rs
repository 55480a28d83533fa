//! Every program of the repository: formatting keeps its tree, renaming there and back keeps its text.

use std::path::{Path, PathBuf};

use editor::analysis::fixes::Edit;
use editor::analysis::format::{Indent, applied, format};
use editor::analysis::rename::{RenameError, rename};
use editor::analysis::scopes::SymbolKind;
use editor::analysis::{Analysis, TextKind};
use elite_syntax::SourceFile;
use elite_syntax::same_tree;

/// Symbols of one program that are renamed: some of each, or it takes minutes without optimisation.
const RENAMED_MAX: usize = 6;
const BYTES_MAX: usize = 40_000;
/// Programs that call the robot wrongly to see what happens, and one of Python's own functions that the robot has in
/// another form.
const ON_PURPOSE: &[&str] = &[
    "modes_test.script",
    "pow_corners.script",
    "pow() takes at most 2",
];

fn programs() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut open: Vec<PathBuf> = ["tests", "examples"].map(|name| root.join(name)).into();
    let mut found = Vec::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(
                std::fs::read_dir(path)
                    .unwrap()
                    .map(|entry| entry.unwrap().path()),
            );
        } else if path
            .extension()
            .is_some_and(|ending| ending == "script" || ending == "py")
        {
            let text = std::fs::read_to_string(&path).unwrap_or_default();
            if text.len() <= BYTES_MAX {
                found.push((path, text));
            }
        }
    }
    found.sort();
    assert!(found.len() > 300, "{}", found.len());
    found
}

/// The first, second … quarter of them.
fn quarter(number: usize) -> impl Iterator<Item = (PathBuf, String)> {
    programs().into_iter().skip(number - 1).step_by(4)
}

fn analysis(path: &Path, text: &str) -> Analysis {
    Analysis::of("program", text, TextKind::of_path(path))
}

fn formatting_keeps_the_tree_and_is_done_once(number: usize) {
    let mut formatted = 0;
    for (path, text) in quarter(number) {
        let analysed = analysis(&path, &text);
        if analysed.has_errors() {
            continue;
        }
        for indent in [
            Indent::default(),
            Indent {
                blanks: 2,
                tabs: false,
            },
            Indent {
                blanks: 4,
                tabs: true,
            },
        ] {
            let edits = format(&analysed, indent)
                .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            let result = applied(&text, &edits);
            let blankless = |text: &str| text.split_whitespace().collect::<String>();
            assert_eq!(blankless(&text), blankless(&result), "{}", path.display());
            let (old, new) = (SourceFile::new("x", &*text), SourceFile::new("x", &*result));
            assert_eq!(same_tree(&old, &new), Some(true), "{}", path.display());
            let again = format(&analysis(&path, &result), indent).unwrap();
            assert_eq!(applied(&result, &again), result, "{}", path.display());
            formatted += 1;
        }
    }
    assert!(formatted > 120, "{formatted}");
}

#[test]
fn formatting_keeps_the_tree_of_the_first_quarter() {
    formatting_keeps_the_tree_and_is_done_once(1);
}

#[test]
fn formatting_keeps_the_tree_of_the_second_quarter() {
    formatting_keeps_the_tree_and_is_done_once(2);
}

#[test]
fn formatting_keeps_the_tree_of_the_third_quarter() {
    formatting_keeps_the_tree_and_is_done_once(3);
}

#[test]
fn formatting_keeps_the_tree_of_the_last_quarter() {
    formatting_keeps_the_tree_and_is_done_once(4);
}

/// What is told of calls for certain is told of no program that runs.
#[test]
fn calls_in_the_programs_fit_the_declarations() {
    const CODES: &[&str] = &[
        "unknown-argument",
        "missing-argument",
        "argument-count",
        "argument-twice",
        "out-of-range",
    ];
    let mut found = Vec::new();
    for (path, text) in programs() {
        let analysed = analysis(&path, &text);
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let alarms = analysed.findings().iter();
        let alarms = alarms.filter(|finding| CODES.contains(&finding.code));
        found.extend(alarms.map(|finding| format!("{name}: {}", finding.message)));
    }
    found.retain(|said| !ON_PURPOSE.iter().any(|known| said.contains(known)));
    assert_eq!(found, [""; 0]);
}

fn renaming_there_and_back_keeps_the_text(number: usize) {
    let mut renamed = 0;
    for (path, text) in quarter(number) {
        let analysed = analysis(&path, &text);
        let kinds = [
            SymbolKind::Function,
            SymbolKind::Variable,
            SymbolKind::Parameter,
            SymbolKind::Class,
        ];
        let symbols = analysed
            .names
            .symbols
            .iter()
            // Words of the robot's language, and names in Python files.
            .filter(|s| kinds.contains(&s.kind) && !["end", "sec"].contains(&&*s.name));
        let step = (analysed.names.symbols.len() / RENAMED_MAX).max(1);
        for symbol in symbols.step_by(step) {
            let Some(first) = symbol.occurrences.first() else {
                continue;
            };
            let Ok(places) = rename(&analysed, first.span.start, "renamed_q") else {
                continue;
            };
            let edits = |places: &[elite_syntax::Span], text: &str| -> Vec<Edit> {
                let edit = |span: &elite_syntax::Span| Edit {
                    span: *span,
                    text: text.to_owned(),
                };
                places.iter().map(edit).collect()
            };
            let result = applied(&text, &edits(&places, "renamed_q"));
            let again = analysis(&path, &result);
            let name = |text: &str| text.replace("renamed_q", &symbol.name);
            let told = |a: &Analysis| -> Vec<String> {
                a.findings()
                    .iter()
                    .map(|f| name(&format!("{} {}", f.code, f.message)))
                    .collect()
            };
            assert_eq!(
                told(&analysed).len(),
                told(&again).len(),
                "{}: {}",
                path.display(),
                symbol.name
            );
            let at = result.find("renamed_q").unwrap() as u32;
            let back = match rename(&again, at, &symbol.name) {
                Ok(back) => back,
                // A name that hid another one of the program does not get it again.
                Err(RenameError::Taken { .. }) => continue,
                Err(error) => panic!("{}: {} {error}", path.display(), symbol.name),
            };
            assert_eq!(
                applied(&result, &edits(&back, &symbol.name)),
                text,
                "{}: {}",
                path.display(),
                symbol.name
            );
            renamed += 1;
        }
    }
    assert!(renamed > 70, "{renamed}");
}

#[test]
fn renaming_keeps_the_text_of_the_first_quarter() {
    renaming_there_and_back_keeps_the_text(1);
}

#[test]
fn renaming_keeps_the_text_of_the_second_quarter() {
    renaming_there_and_back_keeps_the_text(2);
}

#[test]
fn renaming_keeps_the_text_of_the_third_quarter() {
    renaming_there_and_back_keeps_the_text(3);
}

#[test]
fn renaming_keeps_the_text_of_the_last_quarter() {
    renaming_there_and_back_keeps_the_text(4);
}
