//! A text that is read again after each change is what one fresh reading makes of it: tree, tokens, findings.

#![allow(clippy::unwrap_used)] // a test: a broken file should stop it

use std::path::Path;
use std::sync::OnceLock;

use elite_syntax::ParsedDocument;
use elite_syntax::{CallHint, CallSite, KnownNames, SourceFile, check};
use messages::Text;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

/// Programs that edits are made in: those of the repository, and some whose parts depend on each other.
fn corpus() -> &'static [String] {
    static CORPUS: OnceLock<Vec<String>> = OnceLock::new();
    CORPUS.get_or_init(|| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scripts");
        let mut open = vec![root];
        let mut texts: Vec<String> = Vec::new();
        while let Some(path) = open.pop() {
            if path.is_dir() {
                let inner = std::fs::read_dir(path).unwrap();
                open.extend(inner.map(|entry| entry.unwrap().path()));
            } else if path.extension().is_some_and(|ending| ending == "script") {
                texts.push(std::fs::read_to_string(path).unwrap());
            }
        }
        texts.retain(|text| text.len() < 2500);
        texts.sort();
        assert!(texts.len() > 20);
        texts.extend(
            [
                "import math\nfrom os import path as p, sep\ndef f(a):\n    unused = 1\n    return math.sin(a) + g(a)\n\
                 def g(b):\n    global made\n    made = b\n    return lambda q: q + made\nprint(f(1), made, mist)\n",
                "$ LINE: (1, \"Program\")\ndef program():\n    $ LINE: (2, \"MoveJ\")\n    movej([1, 2])\
                 \n    $ LINE: (3, \"While\", \"after\")\n    while True:\n        x = 1\n    $ LINE: (4, \"End\")\n\
                 $ LINE: (5, \"Call\")\nprogram()\nprogram()\n$ LINE: (6, \"Tail\")\n",
                "if a:\n    b = 1\nelif c:\n    d = 2\nelse:\n    e = 3\nend\nwhile True: pass\nb = d\n\
                 for i in [1]:\n    print i\nprint b, d,\nsec = 1\n",
                "def f():; if x:; y();end;end;\r\n# c\r\nz = 1; w = 2\r\n\
                 class A:\r\n    位置 = \"𝄞\"\r\n    def m(self):\r\n        def inner():\r\n            nonlocal \
                 q\r\n            q = 1\r\n        q = 2\r\n        return inner\r\nA().m()\r\n",
            ]
            .map(str::to_owned),
        );
        texts
    })
}

const WRITTEN: &[&str] = &[
    "",
    "x",
    ".",
    "(",
    ")",
    "\n",
    "\n\n",
    "    ",
    "def g(a):\n",
    "\"",
    "\"\"\"",
    ":",
    "movej(",
    "movej([200])",
    "class C:\n",
    "end",
    "end\n",
    ";",
    "\r\n",
    "𝄞",
    "#",
    "$ ",
    "$ LINE: (9, \"new\")\n",
    "=",
    "f\"{",
    "}",
    "[",
    "]",
    ", ",
    "import sys\n",
    "from sys import *\n",
    "\\",
    "\t",
    " \t",
    "sec s():\n",
    "lambda ",
    "global x\n",
    "nonlocal b\n",
    "else:\n",
    "elif x:\n",
    "print = 1\n",
    "print x\n",
    "while True:\n    sync()\n",
    "return\n",
    "locals()\n",
    "del b\n",
    "try:\n",
    "except:\n",
    "b = 1\n",
    "mist",
    "@",
    "if x:\n",
];

/// Where in the text, as a part of 10,000; how many characters go; what comes.
type Change = (usize, usize, &'static str);

fn changes() -> impl Strategy<Value = (Vec<usize>, Vec<Change>)> {
    let programs = prop::collection::vec(0..corpus().len(), 1..4);
    let gone = prop_oneof![5 => Just(0usize), 3 => 1..4usize, 1 => 4..60usize];
    let change = (0..=10_000usize, gone, prop::sample::select(WRITTEN));
    (programs, prop::collection::vec(change, 1..14))
}

/// The text after a change. Changes lie near lines' ends and beginnings more often than chance has it.
fn changed(text: &str, (place, gone, written): Change) -> String {
    let mut at = text.floor_char_boundary(text.len() * place / 10_000);
    if place % 3 == 0 {
        at = text[..at].rfind('\n').map_or(0, |end| end + 1);
    }
    let rest = &text[at..];
    let end = rest
        .char_indices()
        .nth(gone)
        .map_or(rest.len(), |(end, _)| end);
    format!("{}{written}{}", &text[..at], &rest[end..])
}

fn hint(site: &CallSite<'_>) -> Vec<CallHint> {
    let many = site.args.len() != 1;
    let hint = CallHint {
        argument: Some(0),
        code: "many",
        message: Text::verbatim(format!("{} takes one", site.function)),
        help: None,
    };
    many.then_some(hint).into_iter().collect()
}

fn known() -> KnownNames {
    KnownNames::new(["movej", "sync", "get_input"])
        .with_waiting(["sync"])
        .with_call_hook(hint)
}

/// All that can be told of a reading.
fn told(reading: &ParsedDocument) -> String {
    format!(
        "{:#?}\n{:?}\n{:#?}",
        reading.module(),
        reading.tokens(),
        reading.findings()
    )
}

/// Where two texts begin to differ, with the lines around.
fn difference(one: &str, other: &str) -> Option<String> {
    let lines = one.lines().zip(other.lines()).enumerate();
    let (number, _) = lines.clone().find(|(_, (one, other))| one != other)?;
    let shown = |text: &str| {
        let lines = text.lines().skip(number.saturating_sub(12)).take(20);
        lines
            .map(|line| line.chars().take(200).collect::<String>())
            .collect::<Vec<_>>()
            .join("\n")
    };
    Some(format!("{}\n--- fresh:\n{}", shown(one), shown(other)))
}

#[test]
fn a_changed_text_is_read_like_a_new_one() {
    let (mut kept, mut pieces) = (0, 0);
    let known = known();
    let config = ProptestConfig {
        cases: 150,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(21),
        ..ProptestConfig::default()
    };
    let outcome = TestRunner::new(config).run(&changes(), |(programs, changes)| {
        let mut text: String = programs.iter().map(|at| &*corpus()[*at]).collect();
        let mut reading = ParsedDocument::of(SourceFile::new("t", &*text), &known);
        for change in changes {
            let before = text.clone();
            text = changed(&text, change);
            reading = reading.reparse(SourceFile::new("t", &*text), &known);
            let fresh = ParsedDocument::of(SourceFile::new("t", &*text), &known);
            prop_assert!(
                reading.module() == fresh.module()
                    && reading.tokens() == fresh.tokens()
                    && reading.findings() == fresh.findings(),
                "{}\n=== before:\n{before}\n=== after:\n{text}",
                difference(&told(&reading), &told(&fresh)).unwrap_or_default()
            );
            prop_assert_eq!(
                reading.findings(),
                check(SourceFile::new("t", &*text), &known),
                "{}",
                text
            );
        }
        Ok(())
    });
    outcome.unwrap();
    // One key in the middle of each program: nearly everything is kept.
    for text in corpus().iter().filter(|text| text.len() > 800) {
        let reading = ParsedDocument::of(SourceFile::new("t", &**text), &known);
        let half = text[..text.floor_char_boundary(text.len() / 2)]
            .rfind('\n')
            .unwrap_or(0);
        let typed = format!("{} {}", &text[..half], &text[half..]);
        let reading = reading.reparse(SourceFile::new("t", typed), &known);
        pieces += reading.pieces().len();
        kept += reading
            .pieces()
            .filter(|piece| piece.origin.is_some())
            .count();
    }
    assert!(kept * 10 > pieces * 7, "{kept} of {pieces} pieces are kept");
}

#[test]
fn a_name_that_is_defined_elsewhere_is_known_at_once() {
    let known = known();
    let codes = |reading: &ParsedDocument| -> Vec<&str> {
        reading.findings().iter().map(|f| f.code).collect()
    };
    let reading = ParsedDocument::of(SourceFile::new("t", "import os\nprint(other)\n"), &known);
    assert_eq!(codes(&reading), ["unused-import", "undefined-name"]);
    let reading = reading.reparse(
        SourceFile::new("t", "import os\nprint(other)\nother = os\n"),
        &known,
    );
    assert_eq!(codes(&reading), [""; 0]);
    assert!(
        reading
            .pieces()
            .take(1)
            .all(|piece| piece.origin == Some(0))
    );
}
