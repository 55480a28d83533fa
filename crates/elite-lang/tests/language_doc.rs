//! `docs/LANGUAGE.md` tells what the interpreter has: its tables are made here and compared with the file.
//! `UPDATE_DOCS=1 cargo test -p elite-lang --test all language_doc::` writes them.

#![allow(clippy::unwrap_used)] // a test: a missing file should stop it

use crate::support;

use std::fmt::Write as _;
use std::path::Path;

use elite_lang::{ExceptionKind, Limits};
use elite_syntax::python_names::{builtin_names, module_names};
use support::run;

/// Types whose methods are listed.
const TYPES: &[&str] = &[
    "int",
    "float",
    "complex",
    "bool",
    "str",
    "bytes",
    "bytearray",
    "list",
    "tuple",
    "dict",
    "set",
    "frozenset",
    "range",
    "slice",
    "property",
    "object",
];

fn limits() -> String {
    let limits = Limits::default();
    let mut out = String::new();
    let mut row = |name: &str, value: String| writeln!(out, "| {name} | {value} |").unwrap();
    row("nesting of blocks and brackets", "200".to_owned());
    row("nesting of an expression", "1000".to_owned());
    row(
        "calls within calls, on any thread and in generators",
        limits.call_depth.to_string(),
    );
    row(
        "memory of a task",
        format!("{} MiB", limits.memory_bytes >> 20),
    );
    row(
        "decimal digits of an integer read or written",
        limits.int_digits.to_string(),
    );
    row(
        "bits of the result of an integer operation",
        limits.int_bits.to_string(),
    );
    out
}

fn tables() -> String {
    let exceptions: Vec<&str> = ExceptionKind::ALL.iter().map(|kind| kind.name()).collect();
    let (types, functions): (Vec<&str>, Vec<&str>) = builtin_names()
        .filter(|name| !exceptions.contains(name) && !name.starts_with("__") && *name != "IOError")
        .partition(|name| TYPES.contains(name));
    let mut out = format!(
        "Functions: {}.\n\nTypes: {}.\n\n",
        code(&functions),
        code(&types)
    );
    out.push_str("| type | methods | special methods, beside those of `object` |\n|---|---|---|\n");
    for name in TYPES {
        let listed = run(&format!(
            "names = [n for n in dir({name}) if {name} is object or n not in dir(object)]\n\
             print(' '.join(n for n in names if not n.startswith('_')))\n\
             print(' '.join(n for n in names if n.startswith('__')))"
        ));
        let mut lines = listed.lines();
        let mut cell = || {
            code(
                &lines
                    .next()
                    .unwrap_or("")
                    .split(' ')
                    .filter(|n| !n.is_empty())
                    .collect::<Vec<_>>(),
            )
        };
        writeln!(out, "| `{name}` | {} | {} |", cell(), cell()).unwrap();
    }
    out.push_str("\n| module | names |\n|---|---|\n");
    for name in module_names() {
        // What a module itself imports is not its own.
        let listed = run(&format!(
            "import sys\nimport {name} as module\n\
             print(' '.join(n for n in dir(module) if not n.startswith('_') and n != 'annotations'\n\
             \x20   and (type(getattr(module, n)) != type(sys) or n == 'path')))"
        ));
        let names: Vec<&str> = listed.split_whitespace().collect();
        writeln!(out, "| `{name}` | {} |", code(&names)).unwrap();
    }
    out.push_str("\nExceptions, each below the one it is derived from:\n\n```text\n");
    exception_tree(ExceptionKind::BaseException, 0, &mut out);
    out.push_str("```\n");
    out
}

/// Why modules do without names of CPython's.
const ABSENT: &[(&str, &str)] = &[
    (
        "builtins",
        "`async`, a prompt and a debugger are not the program's (`eliteserver debug` is one); bytes are copied, \
         not looked into; warnings are not sorted by encoding",
    ),
    (
        "contextlib",
        "coroutines of `async`, which the language has not",
    ),
    ("io", "layers of files that `open` does not make"),
    (
        "os",
        "users, groups, scheduling, terminals, pipes and processes of the controller's host are not the program's; \
         processes go through `subprocess`",
    ),
    ("os.path", "about descriptors"),
    ("re", "deprecated in CPython, too"),
    (
        "signal",
        "a program's signals are its own; there are no masks",
    ),
    (
        "socket",
        "TCP and UDP over IPv4 only; names are resolved by `connect` and `create_connection`",
    ),
    ("statistics", "rarely used"),
    ("sys", "inner parts of CPython, and of `async`"),
    ("threading", "an exception in a thread ends the program"),
    ("time", "POSIX threads, which script threads are not"),
];

/// Each module beside CPython's of the same name (`cpython_names.py` writes the list).
fn beside_cpython() -> String {
    let mut out =
        String::from("| module | names of CPython 3.11's | absent, and why |\n|---|---|---|\n");
    for line in include_str!("cpython_names.txt").lines() {
        let (module, names) = line.split_once(": ").unwrap();
        let names: Vec<&str> = names.split(' ').collect();
        let absent = run(&format!(
            "import {module} as module\n\
             print(' '.join(n for n in '{}'.split() if not hasattr(module, n)))",
            names.join(" ")
        ));
        let (constants, absent): (Vec<&str>, Vec<&str>) = absent
            .split_whitespace()
            .partition(|name| !name.contains(|c: char| c.is_ascii_lowercase()));
        let count = names.len() - absent.len() - constants.len();
        let mut why = String::new();
        if count < names.len() {
            let found = ABSENT.iter().find(|(name, _)| *name == module);
            let (_, reason) = found
                .unwrap_or_else(|| panic!("why does `{module}` lack {absent:?} {constants:?}?"));
            why = code(&absent);
            if !constants.is_empty() {
                let and = if absent.is_empty() { "" } else { " and " };
                write!(why, "{and}{} constants", constants.len()).unwrap();
            }
            write!(why, ": {reason}").unwrap();
        }
        writeln!(out, "| `{module}` | {count} of {} | {why} |", names.len()).unwrap();
    }
    out
}

fn exception_tree(kind: ExceptionKind, depth: usize, out: &mut String) {
    writeln!(out, "{}{}", "  ".repeat(depth), kind.name()).unwrap();
    for child in ExceptionKind::ALL
        .iter()
        .filter(|child| child.parent() == Some(kind))
    {
        exception_tree(*child, depth + 1, out);
    }
}

fn code(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}

fn replaced(text: &str, mark: &str, content: &str) -> String {
    let (start, end) = (
        format!("<!-- {mark} -->\n"),
        format!("<!-- end of {mark} -->"),
    );
    let (before, rest) = text.split_once(&start).unwrap();
    let (_, after) = rest.split_once(&end).unwrap();
    format!("{before}{start}{content}{end}{after}")
}

#[test]
fn the_tables_of_the_language_page_are_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/LANGUAGE.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let wanted = replaced(&replaced(&text, "limits", &limits()), "tables", &tables());
    let wanted = replaced(&wanted, "modules beside CPython's", &beside_cpython());
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &wanted).unwrap();
        return;
    }
    assert!(
        text == wanted,
        "docs/LANGUAGE.md is out of date; write it anew with UPDATE_DOCS=1 cargo test -p elite-lang --test all \
         language_doc::"
    );
}
