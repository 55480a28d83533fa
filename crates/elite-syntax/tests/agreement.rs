//! Our parser and ruff's agree on which texts are programs: over all scripts, and over mutated pieces of them.
//!
//! ruff's parser checks the grammar; what needs to know the surroundings (a `return` outside a function, a name that
//! is both parameter and global) is checked elsewhere there, so our findings of that kind do not count. What
//! EliteScript adds to Python is left out by rule, and so is what it does not support.

#![allow(clippy::unwrap_used)] // a test: a broken file should stop it

use std::path::{Path, PathBuf};

use elite_syntax::{Diagnostic, KnownNames, Severity, SourceFile, check};
use ruff_python_ast::PythonVersion;
use ruff_python_parser::{Mode, ParseOptions, parse_unchecked};

/// Parts of messages about the surroundings, which ruff's parser does not look at.
const OF_THE_SURROUNDINGS: &[&str] = &[
    "outside a function",
    "outside a loop",
    "cannot appear in an except* block",
    "on the same 'try'",
    "cannot rebind the iteration variable",
    "cannot use a starred expression here",
    "a starred expression cannot stand here",
    "a starred target must be in a list or tuple",
    "duplicate argument",
    "is given twice",
    "no binding for nonlocal",
    "nonlocal declaration not allowed",
    "is parameter and",
    "is nonlocal and global",
    "declaration",
    "annotated name",
    "only one target may be starred",
    "import * only allowed at module level",
];

fn our_errors(text: &str) -> Vec<Diagnostic> {
    let mut found = check(SourceFile::new("test.script", text), &KnownNames::default());
    found.retain(|finding| finding.severity == Severity::Error);
    found
}

/// Whether the text is a program for us; None if only rules that ruff's parser does not check say no.
fn ours(text: &str) -> Option<bool> {
    let errors = our_errors(text);
    if errors.is_empty() {
        return Some(true);
    }
    let counts = |error: &Diagnostic| {
        error.code != "not-supported"
            && !OF_THE_SURROUNDINGS
                .iter()
                .any(|part| error.message.english().contains(part))
    };
    errors.iter().any(counts).then_some(false)
}

fn ruffs(text: &str) -> bool {
    let options = ParseOptions::from(Mode::Module).with_target_version(PythonVersion::PY311);
    let parsed = parse_unchecked(text, options);
    parsed.errors().is_empty() && parsed.unsupported_syntax_errors().is_empty()
}

/// EliteScript has more than Python: `end`, `sec`, `print x`, one-line blocks, `\e`, `\oNN`.
fn uses_additions(text: &str) -> bool {
    text.lines().any(|line| {
        let line = line.trim();
        let word = line.split([' ', ';', '#']).next().unwrap_or("");
        word == "end"
            || word == "sec"
            || line.split(':').skip(1).any(|part| part.trim_start().starts_with(';'))
            // Nothing between two semicolons is nothing.
            || line.split(';').rev().skip(1).any(|part| part.trim().is_empty())
            || line.split([';', ':']).any(|part| {
                let part = part.trim_start();
                part.strip_prefix("print").is_some_and(|rest| {
                    !rest.starts_with(|c: char| c.is_alphanumeric() || "_(.=:".contains(c))
                })
            })
    })
}

fn scripts() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scripts");
    let list = |path: &Path| -> Vec<PathBuf> {
        let mut found: Vec<PathBuf> = std::fs::read_dir(path)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        found.sort();
        found
    };
    let folders = list(&root).into_iter().filter(|path| path.is_dir());
    let files = folders.flat_map(|folder| list(&folder));
    files
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "script")
        })
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            (path, text)
        })
        .collect()
}

#[test]
fn all_scripts_are_programs_for_both() {
    for (path, text) in scripts() {
        if uses_additions(&text)
            || path
                .parent()
                .is_some_and(|folder| folder.ends_with("elite"))
        {
            continue;
        }
        assert_eq!(ours(&text), Some(true), "{}", path.display());
        assert!(ruffs(&text), "{}", path.display());
    }
}

/// The top-level statements of a text.
fn pieces(text: &str) -> Vec<String> {
    let mut pieces: Vec<String> = Vec::new();
    for line in text.lines() {
        let continues = line.is_empty()
            || line.starts_with([' ', '\t', '#', ')', ']', '}'])
            || ["else", "elif", "except", "finally"]
                .iter()
                .any(|word| line.starts_with(word));
        match pieces.last_mut() {
            Some(last) if continues || last.starts_with('@') => {
                last.push_str(line);
                last.push('\n');
            }
            _ => pieces.push(format!("{line}\n")),
        }
    }
    pieces.retain(|piece| piece.len() < 600);
    pieces
}

/// A small generator of numbers: the same mutants in every run, whatever other programs there are.
struct Numbers(u64);

impl Numbers {
    fn of(piece: &str, seed: u64) -> Self {
        // FNV-1a.
        let mixed = piece.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        });
        Numbers(seed ^ mixed)
    }

    fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit.max(1)
    }
}

/// Words, numbers, signs, blanks and line ends of a text.
fn tokens(text: &str) -> Vec<String> {
    let class = |c: char| match c {
        c if c.is_alphanumeric() || c == '_' => 0,
        ' ' => 1,
        _ => 2,
    };
    let mut tokens: Vec<String> = Vec::new();
    for c in text.chars() {
        match tokens.last_mut() {
            Some(last) if class(c) < 2 && last.chars().all(|other| class(other) == class(c)) => {
                last.push(c);
            }
            _ => tokens.push(c.to_string()),
        }
    }
    tokens
}

const SPARE: &[&str] = &[
    "=", "==", ":=", "*", "**", "(", ")", "[", "]", "{", "}", ",", ":", ";", ".", "...", "->", "@",
    "+=", "<", "not", "in", "is", "if", "else", "for", "while", "lambda", "yield", "from",
    "import", "def", "class", "return", "pass", "break", "del", "global", "nonlocal", "assert",
    "raise", "try", "except", "finally", "with", "as", "and", "or", "None", "True", "x", "1", "0x",
    "1e", "1_", "'", "\"", "f'", "b'", "'''", "\\", "\n", "\n    ", "\t", "!", "?", "!=", "async",
    "await", "/", "//", "~", "-", "*a", "**k", "1.5j", "#",
];

fn mutated(piece: &str, numbers: &mut Numbers) -> String {
    let mut tokens = tokens(piece);
    for _ in 0..=numbers.below(2) {
        let at = numbers.below(tokens.len());
        match numbers.below(5) {
            0 if tokens.len() > 1 => {
                tokens.remove(at);
            }
            1 => tokens.insert(at, SPARE[numbers.below(SPARE.len())].to_owned()),
            2 => tokens[at] = SPARE[numbers.below(SPARE.len())].to_owned(),
            3 => {
                let other = numbers.below(tokens.len());
                tokens.swap(at, other);
            }
            _ => {
                let copy = tokens[numbers.below(tokens.len())].clone();
                tokens.insert(at, copy);
            }
        }
    }
    tokens.concat()
}

/// Disagreements that stay, each with its reason.
fn is_meant(text: &str, ours_accepts: bool) -> bool {
    // ruff takes `yield , 1`, `yield / 1` and `yield != 1`; CPython does not. It also lets tabs and blanks mix, and
    // refuses `raise;`.
    let odd_yield = |rest: &str| {
        rest.trim_start()
            .starts_with(|c| ",/=<@.&|^%>!".contains(c))
    };
    let odd_word = |rest: &str| {
        let word = rest.trim_start().split(|c: char| !c.is_alphanumeric());
        let word = word.into_iter().next().unwrap_or_default();
        ["if", "and", "or", "is", "in"].contains(&word)
    };
    let odd = |rest: &str| odd_yield(rest) || odd_word(rest);
    // Robot programs have no coroutines: the words of those are names.
    let coroutine = ["await", "async"].iter().any(|word| text.contains(word));
    if ours_accepts {
        return coroutine || text.contains("raise;") || text.contains('\t');
    }
    // It also takes a blank after a conversion, as CPython does from 3.12 on.
    let blank_after_conversion = ["!r }", "!s }", "!a }", "!r :", "!s :", "!a :"]
        .iter()
        .any(|part| text.contains(part));
    // It takes an `else` after `try` that has no `except`, as long as there is a `finally`.
    let bare_else =
        ["else:", "finally:"].iter().all(|word| text.contains(word)) && !text.contains("except");
    // It does not look for the loop or function that a `break` or `return` belongs to, and assigns to a name in
    // brackets.
    let outside = our_errors(text)
        .iter()
        .any(|error| error.message.english().contains("outside a"));
    let bracketed = text.contains(":=") && text.replace(' ', "").contains("):=");
    text.contains('\t')
        || bare_else
        || outside
        || bracketed
        || blank_after_conversion
        || coroutine
        || text.split("yield").skip(1).any(odd)
}

#[test]
fn mutated_programs_are_programs_for_both_or_for_neither() {
    let count: usize = std::env::var("MUTANTS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(1);
    let seed = std::env::var("MUTANTS_SEED")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(1);
    let (mut checked, mut accepted) = (0u32, 0u32);
    let mut disagreements = Vec::new();
    for (path, text) in scripts() {
        if path
            .parent()
            .is_some_and(|folder| folder.ends_with("elite"))
        {
            continue;
        }
        for piece in pieces(&text) {
            let mut numbers = Numbers::of(&piece, seed);
            for _ in 0..count {
                let mutant = mutated(&piece, &mut numbers);
                if uses_additions(&mutant) {
                    continue;
                }
                let Some(ours) = ours(&mutant) else { continue };
                checked += 1;
                accepted += u32::from(ours);
                if ours != ruffs(&mutant) && !is_meant(&mutant, ours) {
                    let reason = our_errors(&mutant);
                    let reason = reason
                        .first()
                        .map_or("accepted", |error| error.message.english());
                    disagreements.push(format!("ours: {reason}\n{mutant}"));
                }
            }
        }
    }
    assert!(
        checked > 2000 && accepted > 300,
        "{checked} checked, {accepted} accepted"
    );
    assert!(
        disagreements.is_empty(),
        "{} of {checked} mutants:\n{}",
        disagreements.len(),
        disagreements[..disagreements.len().min(60)].join("\n--------\n")
    );
}
