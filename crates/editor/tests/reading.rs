//! Random edits: the analysis that goes along with them is that of the text as it is: findings, tokens, scopes,
//! symbols, places of names.

use editor::analysis::scopes::NameTables;
use editor::analysis::{Analysis, TextKind};
use proptest::prelude::*;

/// Programs whose parts know each other.
const PROGRAMS: &[&str] = &[
    "import math\nfrom time import sleep as nap\n\n",
    "class Station:\n    kind = 1\n    def __init__(self, name, speed=0.25):\n        self.name = name\
     \n        self.poses = [[0, 1], [2]]\n    def pick(self, n: int):\n        for pose in self.poses:\
     \n            movel(pose, v=self.speed)\n        return self.name\n\n",
    "def run(limit=10):\n    global done\n    station = Station('s', speed=0.5)\
     \n    done = [math.sin(i) for i in range(limit)]\n    def inner():\n        nonlocal limit\
     \n        limit += len(done)\n    inner()\n    return station.pick(n=1)\n\n",
    "while get_standard_digital_in(0):\n    x = run(limit=3)\n    sync()\nelse:\n    x = 1\n",
    "$ LINE: (1, \"Job\")\ntry:\n    movej([0, 0, 0, 0, 0, 0])\nexcept Exception as e:\
     \n    print(f\"{e!r} {x:>{width}}\")\nwidth = 3\n",
    "def f():; if x:; y();end;end;\r\n# c\r\n位置 = lambda q, *r: (q, r, 位置)\r\nclass B(Station): z = 1\r\n",
    "sec s():\n    while True:\n        sync()\n    end\nend\n",
];

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
    "self.",
    "class C(Station):\n",
    "end\n",
    ";",
    "; ",
    "\r\n",
    "𝄞",
    "#",
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
    "lambda ",
    "global x\n",
    "nonlocal x\n",
    "else:\n",
    "print = 1\n",
    "x = run\n",
    "del x\n",
    "try:\n",
    "run",
    "Station",
    "(y := 1)",
    "@run\n",
];

/// Where in the text, as a part of 10,000; how many characters go; what comes.
type Change = (usize, usize, &'static str);

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

/// All that can be told of names, in an order that does not change.
fn told(names: &NameTables) -> String {
    let mut told = String::new();
    let mut put = |line: String| {
        told.push_str(&line);
        told.push('\n');
    };
    for scope in &names.scopes {
        let mut symbols: Vec<_> = scope.symbols.iter().collect();
        symbols.sort();
        put(format!(
            "{:?} {:?} {:?}",
            scope.kind, scope.parent, scope.span
        ));
        put(format!("    {} {} {symbols:?}", scope.limit, scope.column));
    }
    names
        .symbols
        .iter()
        .for_each(|symbol| put(format!("{symbol:?}")));
    names
        .functions
        .iter()
        .for_each(|function| put(format!("{function:?}")));
    names
        .classes
        .iter()
        .for_each(|class| put(format!("{class:?}")));
    names
        .attribute_uses
        .iter()
        .for_each(|used| put(format!("{used:?}")));
    names
        .keyword_uses
        .iter()
        .for_each(|used| put(format!("{used:?}")));
    let mut foreign: Vec<_> = names.foreign.iter().collect();
    foreign.sort_by_key(|(name, _)| &**name);
    foreign
        .iter()
        .for_each(|(name, places)| put(format!("{name} {places:?}")));
    names
        .places()
        .iter()
        .for_each(|place| put(format!("{place:?}")));
    told
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn an_analysis_that_goes_along_is_that_of_the_text(
        programs in prop::collection::vec(prop::sample::select(PROGRAMS), 1..6),
        changes in prop::collection::vec(
            (0..=10_000usize, prop_oneof![5 => Just(0usize), 3 => 1..4usize, 1 => 4..60usize],
                prop::sample::select(WRITTEN)),
            1..12,
        ),
    ) {
        let mut text = programs.concat();
        let mut analysis = Analysis::of("t", &text, TextKind::Program);
        for change in changes {
            let before = text.clone();
            text = changed(&text, change);
            analysis = analysis.change(&text);
            let fresh = Analysis::of("t", &text, TextKind::Program);
            prop_assert_eq!(analysis.findings(), fresh.findings(), "{}", text);
            prop_assert_eq!(analysis.tokens(), fresh.tokens(), "{}", text);
            let (one, other) = (told(&analysis.names), told(&fresh.names));
            let differ = one.lines().zip(other.lines()).find(|(one, other)| one != other);
            prop_assert!(one == other, "{differ:#?}\n=== before:\n{before}\n=== after:\n{text}");
        }
    }
}

#[test]
fn a_name_of_the_top_level_is_the_same_in_all_parts() {
    let mut analysis = Analysis::of(
        "t",
        "def f():\n    return count\n\nf()\n",
        TextKind::Program,
    );
    assert!(analysis.names.foreign.contains_key("count"));
    analysis = analysis.change("def f():\n    return count\n\nf()\ncount = 1\n");
    assert!(!analysis.names.foreign.contains_key("count"));
    let symbol = analysis.names.lookup(0, "count").unwrap();
    assert_eq!(analysis.names.symbols[symbol].occurrences.len(), 2);
}
