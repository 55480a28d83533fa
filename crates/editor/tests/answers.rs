//! What each request answers, on small programs.

use editor::analysis::library;
use editor::analysis::words::{Language, LanguageWords as _};
use serde_json::{Value, json};

use crate::client::{Client, URI};

const PROGRAM: &str = "\
import math
class Arm:
    \"\"\"An arm.\"\"\"
    def __init__(self, name, speed=0.25):
        self.name = name
        self.q = get_actual_joint_positions()
    def go(self, pose, v=1):
        movel(pose, 1.2, v)
        return self.name.upper()
def pick(limit):
    arm = Arm(\"x\")
    for i in range(limit):
        arm.go([0, 0, 0.1, 0, 0, 0], v=0.2)
    return math.sin(limit)
pick(limit=3)
";

fn starts(places: &Value) -> Vec<(u64, u64)> {
    let places = places.as_array().cloned().unwrap_or_default();
    let start = |place: &Value| {
        let start = &place["range"]["start"];
        (
            start["line"].as_u64().unwrap(),
            start["character"].as_u64().unwrap(),
        )
    };
    places.iter().map(start).collect()
}

#[test]
fn findings_are_those_of_check() {
    let text = "def f():\n    spee = 1\n    movej([0, -90, 0, 0, 0, 0], v=sped)\n    return 1\n    sync()\n";
    let mut client = Client::of(text);
    let file = elite_syntax::SourceFile::new("x", text);
    let checked = elite_syntax::check(file.clone(), &elite_runtime::builtins::known_names());
    let checked: Vec<(String, u64)> = checked
        .iter()
        .map(|f| (f.code.to_owned(), u64::from(file.line_of(f.span.start) - 1)))
        .collect();
    assert_eq!(client.findings(), checked);
    assert_eq!(checked.len(), 4);
}

#[test]
fn hover_tells_units_ranges_and_the_section_of_the_manual() {
    let mut client = Client::of("movej([0, 0, 0, 0, 0, 0])\n");
    let told = client.at("textDocument/hover", 0, 2);
    insta::assert_snapshot!(told["contents"]["value"].as_str().unwrap());
    assert_eq!(told["range"]["end"]["character"], 5);
}

#[test]
fn hover_speaks_the_language_of_the_client() {
    let mut client = Client::with(json!({}), "zh-CN");
    client.open("movej([0, 0, 0, 0, 0, 0])\n");
    let told = client.at("textDocument/hover", 0, 2);
    insta::assert_snapshot!(told["contents"]["value"].as_str().unwrap());
}

#[test]
fn every_function_of_the_robot_has_a_chinese_text() {
    for builtin in elite_runtime::builtins::all() {
        let chinese = builtin.summary.in_language(Language::Chinese);
        let is_chinese = chinese
            .chars()
            .any(|c| ('\u{4e00}'..'\u{a000}').contains(&c));
        assert!(is_chinese, "{}: {chinese}", builtin.name);
    }
    assert!(library::robot("movej").is_some());
}

#[test]
fn names_of_the_program_tell_what_they_are() {
    let mut client = Client::of(PROGRAM);
    let mut hover = |line, character| client.hover(line, character);
    let all = [
        hover(1, 7),
        hover(6, 9),
        hover(10, 5),
        hover(12, 13),
        hover(13, 16),
        hover(5, 14),
    ];
    insta::assert_snapshot!(all.join("\n---\n"));
}

#[test]
fn attributes_tell_where_they_are_set_and_what_they_do() {
    let program = "\
import math
from math import tau
class Base:
    unit = \"mm\"
class Tool(Base):
    def __init__(self):
        self.weight = 1.5
        self.parts, self.left = 1, unknown()
    def take(self, part, *more):
        \"\"\"Takes a part.\"\"\"
        self.weight = 2.5
        return len(self.unit)
    @property
    def load(self):
        return self.weight * 2
tool = Tool()
print(tool.weight, tool.left, tool.take(1), tool.load, tool.unit, Tool.take)
print(math.pi, math.sin(1), math, tau, tool.nothing)
";
    let all = ["en", "zh-CN"].map(|locale| {
        let mut client = Client::with(json!({}), locale);
        client.open(program);
        let mut hover = |line: u32, word: &str| {
            let text = program.lines().nth(line as usize).unwrap();
            let at = text.find(word).unwrap() as u32;
            format!("{word}: {}", client.hover(line, at + 1))
        };
        let in_uses = ["weight", "left", "take", "load", "unit"].map(|word| hover(16, word));
        let in_class = hover(10, "weight");
        let of_modules = ["pi", "sin", "tau", "nothing"].map(|word| hover(17, word));
        [
            in_uses.join("\n---\n"),
            in_class,
            of_modules.join("\n---\n"),
        ]
        .join("\n---\n")
    });
    insta::assert_snapshot!(all.join("\n=====\n"));
}

#[test]
fn everything_that_python_gives_is_explained_in_both_languages() {
    let is_chinese = |text: &str| text.chars().any(|c| ('\u{4e00}'..'\u{a000}').contains(&c));
    for name in elite_syntax::python_names::builtin_names() {
        let english = Language::English.python(name).unwrap_or_default();
        let chinese = Language::Chinese.python(name).unwrap_or_default();
        assert!(
            english.ends_with('.') && !is_chinese(english),
            "{name}: {english}"
        );
        assert!(
            chinese.ends_with('。') && is_chinese(chinese),
            "{name}: {chinese}"
        );
    }
    assert_eq!(Language::English.python("nonsense"), None);
    let mut client = Client::with(json!({}), "zh-CN");
    client.open("x = sorted(range(3))\ntry:\n    pass\nexcept ValueError:\n    pass\n");
    let mut hover = |line, character| client.hover(line, character);
    assert!(hover(0, 5).contains("排序后的新列表"));
    assert!(hover(0, 12).contains("整数"));
    assert!(hover(3, 9).contains("类型正确"));
    for (label, kind) in [("zip", 3), ("int", 7)] {
        let item = client.ask(
            "completionItem/resolve",
            json!({"label": label, "kind": kind}),
        );
        let told = item["result"]["documentation"]["value"]
            .as_str()
            .unwrap_or_default()
            .to_owned();
        assert!(is_chinese(&told), "{label}: {told}");
    }
}

#[test]
fn attributes_complete_by_type() {
    let text = format!("{PROGRAM}a = Arm(\"y\")\na.\nmath.\n\"x\".join([]).\na.q.\n");
    let mut client = Client::of(&text);
    assert_eq!(
        client.completions(16, 2),
        ["go", "name", "q", "speed"].map(str::to_owned)[..3]
    );
    assert!(client.completions(17, 5).contains(&"sin".to_owned()));
    assert!(client.completions(18, 13).contains(&"upper".to_owned()));
    assert!(client.completions(19, 4).contains(&"append".to_owned()));
}

#[test]
fn completion_knows_scopes_keywords_and_inputs() {
    let mut client =
        Client::of("def f(alpha):\n    beta = 1\n    \nmovej(\nfrom math import s\nimport js\n");
    let inside = client.completions(2, 4);
    assert!(inside.contains(&"alpha".to_owned()) && inside.contains(&"beta".to_owned()));
    assert!(inside.contains(&"movej".to_owned()) && inside.contains(&"while".to_owned()));
    let call = client.completions(3, 6);
    assert_eq!(call[..5], ["a=", "q=", "r=", "t=", "v="].map(str::to_owned));
    assert!(
        !call.contains(&"alpha".to_owned()),
        "a parameter of another function"
    );
    assert_eq!(
        client.completions(4, 18),
        ["sin", "sinh", "sqrt"].map(str::to_owned)
    );
    assert_eq!(client.completions(5, 9), ["json"].map(str::to_owned));
    client.uri = "file:///programs/test_pick.script".to_owned();
    client.open("def test_x():\n    test.set(\"std_in\")\n    test.\n");
    let inputs = client.completions(1, 17);
    assert_eq!(
        inputs
            .iter()
            .filter(|name| name.starts_with("standard_digital_in["))
            .count(),
        16
    );
    assert!(client.completions(2, 9).contains(&"wrench".to_owned()));
}

#[test]
fn fields_of_formatted_strings_complete() {
    let mut client = Client::of("speed = 1\nx = f\"{spe\"\ny = \"{spe\"\n");
    assert_eq!(client.completions(1, 10)[0], "speed");
    assert!(client.completions(2, 9).is_empty());
}

#[test]
fn signatures_follow_the_cursor() {
    let mut client = Client::of(&format!(
        "{PROGRAM}movej([1, 2], 1, \nArm(\npick(limit=\nprint(len(\n"
    ));
    let mut active = |line, character| {
        let told = client.at("textDocument/signatureHelp", line, character);
        let label = told["signatures"][0]["label"]
            .as_str()
            .unwrap_or("none")
            .to_owned();
        (label, told["activeParameter"].as_u64())
    };
    assert_eq!(
        active(15, 6),
        (
            "movej(q, a=1.396263, v=1.047197, t=0, r=0)".to_owned(),
            Some(0)
        )
    );
    assert_eq!(active(15, 10).1, Some(0));
    assert_eq!(active(15, 17).1, Some(2));
    assert_eq!(active(16, 4), ("Arm(name, speed=0.25)".to_owned(), Some(0)));
    assert_eq!(active(17, 11), ("pick(limit)".to_owned(), Some(0)));
}

#[test]
fn definitions_and_references_follow_scopes() {
    let mut client = Client::of(PROGRAM);
    assert_eq!(
        starts(&client.at("textDocument/definition", 12, 13)),
        [(6, 8)]
    );
    assert_eq!(
        starts(&client.at("textDocument/definition", 14, 1)),
        [(9, 4)]
    );
    assert_eq!(
        starts(&client.at("textDocument/definition", 14, 6)),
        [(9, 9)]
    );
    let highlights = client.at("textDocument/documentHighlight", 9, 10);
    assert_eq!(starts(&highlights), [(9, 9), (11, 19), (13, 20), (14, 5)]);
    let all = client.ask(
        "textDocument/references",
        json!({ "textDocument": { "uri": URI }, "position": { "line": 4, "character": 14 },
            "context": { "includeDeclaration": false } }),
    );
    assert_eq!(starts(&all["result"]), [(8, 20)]);
}

#[test]
fn globals_and_nonlocals_are_one_name() {
    let text = "n = 0\ndef f():\n    global n\n    n = 1\n    k = 2\n    def g():\n        nonlocal k\
        \n        k += n\n    g()\nclass C:\n    n = 5\n    def m(self):\n        return n\n";
    let mut client = Client::of(text);
    assert_eq!(
        starts(&client.at("textDocument/documentHighlight", 0, 0)),
        [(0, 0), (2, 11), (3, 4), (7, 13), (12, 15)]
    );
    assert_eq!(
        starts(&client.at("textDocument/documentHighlight", 4, 4)),
        [(4, 4), (6, 17), (7, 8)]
    );
}

fn renamed(text: &str, line: u32, character: u32, new: &str) -> Result<Vec<(u64, u64)>, String> {
    let mut client = Client::of(text);
    let params = json!({ "textDocument": { "uri": URI }, "position": { "line": line, "character": character },
        "newName": new });
    let answer = client.ask("textDocument/rename", params);
    match answer["error"]["message"].as_str() {
        Some(message) => Err(message.to_owned()),
        None => Ok(starts(&answer["result"]["changes"][URI])),
    }
}

#[test]
fn renaming_changes_every_place_or_says_why_not() {
    assert_eq!(
        renamed(PROGRAM, 9, 10, "count"),
        Ok(vec![(9, 9), (11, 19), (13, 20), (14, 5)])
    );
    assert_eq!(renamed(PROGRAM, 4, 14, "title"), Ok(vec![(4, 13), (8, 20)]));
    let refused = [
        renamed(PROGRAM, 7, 9, "x"),
        renamed(PROGRAM, 9, 10, "2x"),
        renamed(PROGRAM, 9, 10, "while"),
        renamed(PROGRAM, 9, 10, "end"),
        renamed(PROGRAM, 9, 10, "arm"),
        renamed(PROGRAM, 9, 10, "range"),
        renamed(PROGRAM, 9, 10, ""),
        renamed(PROGRAM, 3, 9, "start"),
        renamed(PROGRAM, 0, 8, "maths"),
        renamed(PROGRAM, 14, 4, "x"),
        renamed("x = 1\ny = (\n", 0, 0, "z"),
        renamed(
            "class A:\n    def go(self): pass\ndef f(a):\n    a.go()\n",
            1,
            9,
            "run",
        ),
        renamed("a = b\n", 0, 4, "c"),
    ];
    let shown: Vec<String> = refused
        .iter()
        .map(|refused| format!("{refused:?}"))
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn renaming_reaches_arguments_by_name() {
    let points = "from dataclasses import dataclass, replace\n@dataclass\nclass Pt:\n    px: float\
        \n    py: float = 0.0\na = Pt(px=3)\nb = replace(a, px=4)\nprint(a.px, b)\n";
    let all = vec![(3, 4), (5, 7), (6, 15), (7, 8)];
    for (line, column) in &all {
        let column = u32::try_from(*column).unwrap();
        let line = u32::try_from(*line).unwrap();
        assert_eq!(renamed(points, line, column, "x"), Ok(all.clone()));
    }
    let named = "from typing import NamedTuple\nclass Pt(NamedTuple):\n    px: float\na = Pt(px=3)._replace(px=4)\n\
        b = Pt(1)\nc = b._replace(px=5)\nprint(b.px)\n";
    assert_eq!(
        renamed(named, 2, 4, "x"),
        Ok(vec![(2, 4), (3, 7), (3, 22), (5, 15), (6, 8)])
    );
    let partial = "import functools\ndef f(a, c=1): return a + c\ng = functools.partial(f, c=9)\n";
    assert_eq!(
        renamed(partial, 1, 9, "d"),
        Ok(vec![(1, 9), (1, 26), (2, 25)])
    );
    // What may be meant, and nobody can tell.
    for text in [
        "class Pt:\n    px = 1\ndef make(k, **rest): return k(**rest)\nmake(Pt, px=3)\n",
        "class Pt:\n    px = 1\nd = {'px': 1}\nPt(**d)\n",
        "class Pt:\n    px = 1\nprint(getattr(Pt(), 'px'))\n",
        "class Pt:\n    px = 1\ndef make(k): return k(px=3)\n",
    ] {
        let refused = renamed(text, 1, 4, "x");
        assert!(
            refused
                .as_ref()
                .is_err_and(|why| why.contains("may be meant")),
            "{text}: {refused:?}"
        );
    }
}

#[test]
fn the_outline_and_the_folds_follow_the_blocks() {
    let mut client = Client::of(PROGRAM);
    let symbols = client.whole("textDocument/documentSymbol");
    let names = |all: &Value| -> Vec<String> {
        let all = all.as_array().cloned().unwrap_or_default();
        all.iter()
            .map(|s| s["name"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(names(&symbols), ["Arm", "pick"]);
    assert_eq!(
        names(&symbols[0]["children"]),
        ["__init__", "name", "q", "go"]
    );
    let folds = client.whole("textDocument/foldingRange");
    let folds: Vec<(u64, u64)> = folds
        .as_array()
        .unwrap()
        .iter()
        .map(|f| {
            (
                f["startLine"].as_u64().unwrap(),
                f["endLine"].as_u64().unwrap(),
            )
        })
        .collect();
    assert_eq!(folds, [(1, 8), (3, 5), (6, 8), (9, 13), (11, 12)]);
}

#[test]
fn units_stand_behind_positional_arguments() {
    let mut client =
        Client::of("movej([0, 0, 0, 0, 0, 0], 1, v=2)\ndef sleep(t):\n    pass\nsleep(1)\n");
    let hints = client.whole("textDocument/inlayHint");
    let hints: Vec<(u64, &str)> = hints
        .as_array()
        .unwrap()
        .iter()
        .map(|h| {
            (
                h["position"]["character"].as_u64().unwrap(),
                h["label"].as_str().unwrap(),
            )
        })
        .collect();
    assert_eq!(hints, [(24, "rad"), (27, "rad/s²")]);
}

#[test]
fn findings_with_a_suggestion_have_an_action() {
    let text = "import json, math\ndef f():\n    spee = 1\n    movej([0, -90, 0, 0, 0, 0], v=sped)\
        \n    movel([100, 0, 0, 0, 0, 90])\n    while True:\n        x = math.pi\n";
    let mut client = Client::of(text);
    let actions = client.whole("textDocument/codeAction");
    let shown: Vec<String> = actions
        .as_array()
        .unwrap()
        .iter()
        .map(|action| {
            let edits = action["edit"]["changes"][URI].as_array().unwrap();
            let edits: Vec<String> = edits
                .iter()
                .map(|e| {
                    format!(
                        "{}:{} {}",
                        e["range"]["start"]["line"], e["range"]["start"]["character"], e["newText"]
                    )
                })
                .collect();
            format!(
                "{}: {}",
                action["title"].as_str().unwrap(),
                edits.join(", ")
            )
        })
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn colours_lie_side_by_side_in_the_order_of_the_text() {
    let text = "# 位置\nx = f\"a{x}b\"\n\"\"\"one\ntwo\"\"\"\ndef f(p): return p.q + movej\n$ 1 \"node\"\nx. = (\n";
    let mut client = Client::of(text);
    let told = client.whole("textDocument/semanticTokens/full");
    let data: Vec<u64> = told["data"]
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n.as_u64().unwrap())
        .collect();
    let (mut line, mut column, mut shown) = (0, 0, Vec::new());
    let lines: Vec<Vec<u16>> = text
        .split('\n')
        .map(|line| line.encode_utf16().collect())
        .collect();
    for word in data.chunks(5) {
        column = if word[0] == 0 {
            column + word[1]
        } else {
            word[1]
        };
        line += word[0];
        let units = &lines[line as usize][column as usize..(column + word[2]) as usize];
        shown.push(format!(
            "{} {} {}",
            String::from_utf16_lossy(units),
            word[3],
            word[4]
        ));
    }
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn formatting_touches_blanks_only() {
    let text = "def f( a,b = 1 , *c ):\n  x=[ 1,2 ]  \n  if a<b :# yes\n     y = {1:2}[ 1 ] ;z=-1\n     w = x [1:2]\
        \n  # here\n  return (x\n    ,w)\n\n\n\n\nf(1, b = 2)\n";
    let mut client = Client::of(text);
    let edits = client.whole("textDocument/formatting");
    let mut lines: Vec<String> = text.split('\n').map(str::to_owned).collect();
    let mut edits = edits.as_array().unwrap().clone();
    edits.reverse();
    for edit in edits {
        let place = |end: &str| {
            let at = &edit["range"][end];
            (
                at["line"].as_u64().unwrap() as usize,
                at["character"].as_u64().unwrap() as usize,
            )
        };
        let ((l, c), (m, d)) = (place("start"), place("end"));
        let after = lines[m].split_off(d);
        lines[l].truncate(c);
        lines[l].push_str(edit["newText"].as_str().unwrap());
        lines[l].push_str(&after);
        lines.drain(l + 1..=m.max(l));
    }
    insta::assert_snapshot!(lines.join("\n"));
    let refused = Client::of("x = (\n").ask(
        "textDocument/formatting",
        json!({ "textDocument": { "uri": URI }, "options": { "tabSize": 4, "insertSpaces": true } }),
    );
    assert!(
        refused["error"]["message"]
            .as_str()
            .unwrap()
            .contains("line 1"),
        "{refused}"
    );
}
