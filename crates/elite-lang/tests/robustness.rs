//! Any text may come in: nothing panics, hangs or grows without bound, whatever it is.

use messages::Language;

use crate::support;

use std::path::Path;
use std::sync::OnceLock;

use elite_lang::{Limits, Resume, ResumeOutcome};
use elite_syntax::{check, compile, render_human};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use support::Task;

/// The same cases on every run.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(7),
        ..ProptestConfig::default()
    }
}

/// All test scripts, as material to mutate.
fn corpus() -> &'static [String] {
    static CORPUS: OnceLock<Vec<String>> = OnceLock::new();
    CORPUS.get_or_init(|| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scripts");
        let mut texts = Vec::new();
        for folder in std::fs::read_dir(root).into_iter().flatten().flatten() {
            for file in std::fs::read_dir(folder.path())
                .into_iter()
                .flatten()
                .flatten()
            {
                if file
                    .path()
                    .extension()
                    .is_some_and(|extension| extension == "script")
                {
                    texts.extend(std::fs::read_to_string(file.path()));
                }
            }
        }
        texts.sort();
        assert!(texts.len() > 20);
        texts
    })
}

/// Checks a text, renders what is found, and runs it for a while if it compiles.
fn survive(text: &str, run: bool) {
    let file = Task::file(text);
    let found = check(file.clone(), &Default::default());
    for finding in found.iter().take(3) {
        let shown = render_human(finding, &file, Language::English, false);
        assert!(
            shown.contains(
                &finding
                    .message
                    .english()
                    .lines()
                    .next()
                    .unwrap_or("")
                    .to_owned()
            )
        );
        let fields = finding.fields(&file);
        assert!(
            (1..=file.line_count() + 1).contains(&fields.line),
            "{fields:?}"
        );
    }
    let Ok(program) = compile(file, &Default::default()) else {
        return;
    };
    if !run {
        return;
    }
    let limits = Limits {
        memory_bytes: 8 << 20,
        stop_fuel: 100,
        ..Limits::default()
    };
    let task = Task::with(Vec::new(), limits);
    let mut thread = task.interpreter.spawn_program(&program);
    match thread.resume(Resume::Continue, 300) {
        ResumeOutcome::Done(_) | ResumeOutcome::Failed(_) | ResumeOutcome::Stopped => {}
        _ => {
            let end = thread.resume(Resume::Stop, 0);
            assert!(matches!(end, ResumeOutcome::Stopped), "{end:?}");
        }
    }
}

/// A script with a few pieces cut out, doubled, moved or replaced.
fn mutated() -> impl Strategy<Value = String> {
    let edit = (
        0..5u8,
        any::<prop::sample::Index>(),
        any::<prop::sample::Index>(),
        "[ -~\n\t\u{4e00}]{0,6}",
    );
    let edits = prop::collection::vec(edit, 1..6);
    (
        any::<prop::sample::Index>(),
        any::<prop::sample::Index>(),
        edits,
    )
        .prop_map(|(which, window, edits)| {
            let text = &corpus()[which.index(corpus().len())];
            // A window of lines, so that single mistakes do not always hide behind earlier ones.
            let all: Vec<&str> = text.lines().collect();
            let start = window.index(all.len());
            let mut lines: Vec<String> = all[start..all.len().min(start + 12)]
                .iter()
                .map(|l| (*l).to_owned())
                .collect();
            for (kind, at, other, insert) in edits {
                let line = at.index(lines.len());
                let chars: Vec<char> = lines[line].chars().collect();
                let column = other.index(chars.len() + 1);
                match kind {
                    0 => lines[line] = chars[..column].iter().collect(),
                    1 => lines[line] = chars[column..].iter().collect(),
                    2 => {
                        let (head, tail) = chars.split_at(column);
                        lines[line] = format!(
                            "{}{insert}{}",
                            String::from_iter(head),
                            String::from_iter(tail)
                        );
                    }
                    3 => {
                        let to = other.index(lines.len());
                        lines.swap(line, to);
                    }
                    _ => lines.insert(line, insert),
                }
            }
            lines.join("\n")
        })
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn any_text_is_checked_without_a_panic(text in any::<String>()) {
        survive(&text, true);
    }

    #[test]
    fn any_sequence_of_tokens_is_checked_without_a_panic(
        words in prop::collection::vec(prop::sample::select(vec![
            "def", "f", "(", ")", ":", "\n", "    ", "\t", "end", "if", "else", "elif", "while", "for", "in", "x",
            "=", "==", "1", "1.5", "'a'", "f'{x}'", "f'{", "}'", "\"\"\"", "[", "]", "{", "}", ",", ";", "*", "**",
            "lambda", "yield", "return", "class", "try", "except", "finally", "with", "as", "import", "from", ".",
            "...", "not", "and", "or", "is", "sec", "print", "global", "nonlocal", "del", "assert", "raise", ":=",
            "@", "->", "#", "\\\n", "break", "continue", "pass", "None", "async", "await", "match", "-", "~", "0x",
        ]), 0..40),
        glue in prop::sample::select(vec!["", " "]),
    ) {
        survive(&words.join(glue), true);
    }

    #[test]
    fn mutated_programs_are_checked_and_run_without_a_panic(text in mutated()) {
        survive(&text, true);
    }
}

#[test]
fn large_texts_are_checked_in_time() {
    let many_lines = "x = [1, 2, 3]\n".repeat(5_000);
    let many_names: String = (0..2_000)
        .map(|n| format!("name{n} = other{n}\n"))
        .collect();
    let many_functions: String = (0..3_000)
        .map(|n| format!("def f{n}(a): return [a + b for b in c]\n"))
        .collect();
    let one_line = format!("x = [{}]", "1, ".repeat(50_000));
    let open_brackets = "x = (1\n".repeat(3_000);
    let open_strings = "x = 'abc\n".repeat(3_000);
    let long_string = format!("x = '{}'", "a".repeat(1 << 20));
    let semicolons = "x = 1; ".repeat(5_000);
    let parts = format!("def f():; {}end", "x = 1; ".repeat(2_000));
    for text in [
        many_lines,
        many_names,
        many_functions,
        one_line,
        open_brackets,
        open_strings,
        long_string,
        semicolons,
        parts,
    ] {
        survive(&text, false);
    }
}

#[test]
fn a_regular_expression_that_steps_back_without_end_is_an_error() {
    let text = "import re\ntry:\n    re.match(r'(?=(a+)+$)(\\w+)\\1b', 'a' * 40 + '!')\n    print('matched')\n\
                except RuntimeError as e:\n    print('bounded')\n\
                print(re.search('(a+)+b', 'a' * 5000), re.search('(x+x+)+y', 'x' * 5000))\n";
    let printed = support::run(text);
    assert!(printed.ends_with("None None\n"), "{printed}");
    let refused = "import re\nfor p in ('(' * 500 + ')' * 500, 'a{100000}{100000}', 'a{100001}', 'a' * 2_000_000, b'a' \
                   * 2_000_000):\n    try:\n        re.compile(p)\n        print('compiled')\
                   \n    except (re.error, ValueError) as e:\n        print('refused')\n";
    assert_eq!(support::run(refused), "refused\n".repeat(5));
    // Repetitions are counted, not written out.
    let counted = "import re\nfor p in ('((a{1000}){1000}){1000}', '(?:a{50000}){50000}', '(a|b{100000}){2,100000}'):\
                   \n    print(re.search(p, 'ab'))\n";
    assert_eq!(support::run(counted), "None\n".repeat(3));
}

#[test]
fn what_nests_a_hundred_thousand_deep_is_refused_and_dropped_without_harm() {
    let limits = Limits {
        memory_bytes: 1 << 30,
        ..Limits::default()
    };
    let out = Task::with(Vec::new(), limits).run(include_str!("robustness/deep.script"));
    assert!(out.ends_with("\nall\n"), "{out}");
    for kind in ["list", "tuple", "dict", "talks"] {
        for question in ["repr", "eq", "deepcopy"] {
            let line = format!("{kind} {question} RecursionError\n");
            assert!(out.contains(&line), "{line} is not in {out}");
        }
    }
    for line in [
        "tuple hash RecursionError\n",
        "talks hash RecursionError\n",
        "list json RecursionError\n",
        "slice eq RecursionError\n",
    ] {
        assert!(out.contains(line), "{line} is not in {out}");
    }
}
