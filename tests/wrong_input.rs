//! Wrong input to the commands about cells, paths, toolpaths, programs of others and numbers of an arm: a transcript of
//! what the terminal says, in English and in Chinese. Each says what was given and what is allowed; none panics, hangs
//! or names a library. In Chinese no line is a mixture; nor is one of their help texts and results.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::fmt::Write as _;
use std::path::Path;

use crate::common::eliteserver;

/// What is asked, in a folder with the files of [`files`].
const QUESTIONS: &[&str] = &[
    // Files that are none, empty, binary, or folders.
    "clearance none.script",
    "clearance binary",
    "clearance folder",
    "clearance ok.script --cell none.toml",
    "clearance ok.script --cell binary",
    "clearance ok.script --cell folder",
    "optimize none.script",
    "optimize binary",
    "cell none.toml",
    "cell binary",
    "cell folder",
    "place --points none",
    "place --points empty",
    "place --points binary",
    "place --points folder",
    "place --points huge.points",
    "place --points few.points",
    "import none.ngc",
    "import empty.ngc",
    "import empty.dxf",
    "import empty.csv",
    "import binary.dxf",
    "import binary.csv",
    "import folder.ngc",
    "import ok.script",
    "translate none",
    "translate binary",
    "translate folder",
    "identify payload none",
    "identify payload empty",
    "identify payload binary",
    "identify payload folder",
    "excite payload --cell none.toml",
    // Numbers that are none, negative or huge.
    "clearance ok.script --margin nan",
    "clearance ok.script --margin -1",
    "clearance ok.script --timeout 1e300",
    "clearance ok.script --tcp 1e300,0,0,0,0,0",
    "clearance ok.script --payload 1e300",
    "plan --to 0,1e300,0,0,0,0",
    "plan --to p[0.4,nan,0.3,3,0,0]",
    "plan --to 0,-1,1,-1,-1,0 --from 0,1e300,0,0,0,0",
    "plan --to 0,-1,1,-1,-1,0 --via nan",
    "plan --to 0,-1,1,-1,-1,0 --speed -1",
    "plan --to 0,-1,1,-1,-1,0 --acceleration nan",
    "plan --to 0,-1,1,-1,-1,0 --time 0",
    "plan --to 0,-1,1,-1,-1,0 --approach 1e300",
    "optimize ok.script --margin 1e300",
    "optimize ok.script --keep 5-2",
    "optimize ok.script --keep 100-200",
    "place --points ok.points --area 1,0,1,0",
    "import ok.ngc --frame 0,1e300,0,0,0,0",
    "import ok.ngc --tool-axis 0,0,0",
    "import ok.ngc --speed -1",
    "import ok.ngc --feed-scale nan",
    "import ok.ngc --tolerance 0",
    "import ok.ngc --lead-in x",
    "identify payload ok.mcap --from nan",
    "identify payload ok.mcap --to -1",
    "identify payload ok.mcap --from 2 --to 1",
    "identify tool ok.mcap --at 1,x",
    "excite payload --speed 0",
    "excite payload --tcp 1e300,0,0,0,0,0",
    "replay ok.mcap --at nan",
    "replay ok.mcap --plot plot.png --from x",
    // Options twice, unknown names, options that say nothing.
    "clearance ok.script --margin 0.1 --margin 0.2",
    "plan --to 0,-1,1,-1,-1,0 -o a -o b",
    "plan --to 0,-1,1,-1,-1,0 --held nothing",
    "place --points ok.points --margin 1 --margin 2",
    "cell empty --format human --format json",
    "translate ok.script -o a -o b",
    "import ok.ngc --model cs99",
    "import ok.ngc --units ell",
    "import ok.ngc --units m",
    "import ok.ngc --layer CUT",
    "identify weight ok.mcap",
    "identify friction ok.mcap --from-torques",
    "identify payload ok.mcap --orientation",
    "identify friction ok.mcap --at 1",
    "excite sensor",
    "optimize ok.script --marign 1",
];

fn files(folder: &Path) {
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    // Control characters of terminals among them.
    let binary = b"\x1b[31m\x00\xff\xfe\x07\n\x80\x01";
    for name in ["binary", "binary.dxf", "binary.csv"] {
        write(name, binary);
    }
    for name in ["empty", "empty.ngc", "empty.dxf", "empty.csv"] {
        write(name, b"");
    }
    for name in ["folder", "folder.ngc"] {
        std::fs::create_dir(folder.join(name)).unwrap();
    }
    write("ok.script", b"movej([0, -1.5, 1.5, -1.5, -1.5, 0])\n");
    write("ok.ngc", b"G21 G90\nG1 X10 Y10 F600\nM2\n");
    write("ok.points", b"-0.5 0 0.3 3.14159 0 0\n");
    write("huge.points", b"1e300 0 0.3 3.14159 0 0\n");
    write("few.points", b"1 2 3\n");
}

/// What is answered in Chinese, in the same folder.
const ANSWERED: &[&str] = &[
    "clearance --help",
    "plan --help",
    "optimize --help",
    "place --help",
    "cell --help",
    "import --help",
    "identify --help",
    "excite --help",
    "translate --help",
    "serve --help",
    "replay -h",
    "--help",
    "clearance ok.script --cell cell.toml",
    "clearance touches.script --cell cell.toml --margin 0.1",
    "clearance fails.script",
    "clearance waits.script --timeout 1",
    "clearance ok.script --plant rigid",
    "clearance ok.script --cell wrong.toml",
    "clearance ok.script --cell unknown.toml",
    "plan --to 0,-1,1,-1,-1,0 -o planned.script",
    "plan --to p[3,0,0.3,3.14,0,0]",
    "plan --to 0,-1.57,2.9,0,0,0",
    "optimize ok.script -o faster.script",
    "optimize fails.script",
    "place --points ok.points",
    "place --points far.points --area 0,0.1,0,0.1",
    "cell cell.toml",
    "cell none.cell",
    "cell wrong.toml",
    "import odd.ngc -o odd.script --check",
    "import odd.csv",
    "import ok.ngc -o out.script",
    "translate odd.urscript -o translated.script --report report.md",
    "translate wrong.urscript",
    "identify payload ok.mcap",
    "identify friction ok.mcap",
    "identify tool ok.mcap",
    "identify frame ok.mcap",
    "excite payload --cell narrow.toml",
    "check touches.script --cell cell.toml",
];

/// A cell with a table, and what is doubtful about it.
const CELL: &str = r#"
[[obstacle]]
name = "table"
shape = "box"
size = [0.4, 0.4, 0.2]
pose = [-0.6, 0, 0.1, 0, 0, 0]

[[part]]
name = "nut"
shape = "box"
size = [0.03, 0.03, 0.03]
pose = [0.6, 0.4, 0.015, 0, 0, 0]
mass = 0.1

[names]
"standard_digital_in[3]" = "door"
"#;

fn answered_files(folder: &Path) {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("cell.toml", CELL);
    write("none.cell", "");
    write(
        "wrong.toml",
        "[[obstacle]]\nname = \"a\"\nshape = \"box\"\nsize = [1.0]\n",
    );
    write(
        "unknown.toml",
        "[[obstacle]]\nname = \"a\"\nshap = \"box\"\n",
    );
    write(
        "narrow.toml",
        "[[obstacle]]\nname = \"wall\"\nshape = \"box\"\nsize = [0.02, 3, 3]\npose = [-0.4, 0, 0.7, 0, 0, 0]\n",
    );
    write(
        "touches.script",
        "movej([0, -1.57, 1.57, -1.57, -1.57, 0])\nmovej([0, -0.6, 1.6, -1.57, -1.57, 0])\n",
    );
    write("fails.script", "movej([0, -1.5, 1.5, -1.5, -1.5])\n");
    write(
        "waits.script",
        "while get_standard_digital_in(0) == False:\n    sync()\nend\n",
    );
    write("far.points", "-5 0 0.3 3.14159 0 0\n");
    write(
        "odd.ngc",
        "G21 G90\nG1 X10 Y10 F600\nG5 X1 Y1\nG1 X5000 Y5000\nM3\nM2\n",
    );
    write("odd.csv", "x,y,z\n1,2,3\n1,b,3\n");
    write(
        "odd.urscript",
        "def prog():\n  set_digital_out(1, True)\n  movej(p[0.4, 0, 0.3, 0, 3.14, 0])\n  tool_contact([0])\n  \
         unknown_thing(3)\nend\nprog()\n",
    );
    write("wrong.urscript", "def prog(:\n");
}

/// Asks in a folder with the files and a recording; each question has to end with a status for which `is_expected`.
fn transcript(questions: &[&str], language: &str, is_expected: fn(Option<i32>) -> bool) -> String {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path());
    answered_files(folder.path());
    let recorded = eliteserver()
        .args(["run", "ok.script", "--record", "ok.mcap"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(recorded.status.success());
    let mut text = String::new();
    for question in questions {
        let output = eliteserver()
            .args(question.split(' '))
            .args(["--language", language])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let mut said = String::from_utf8_lossy(&output.stdout).into_owned();
        said.push_str(&String::from_utf8_lossy(&output.stderr));
        assert!(is_expected(output.status.code()), "{question}: {said}");
        for inner in [
            "panicked",
            "overflowed",
            "literal",
            "parse float",
            "\u{1b}",
            "\u{7}",
        ] {
            assert!(!said.contains(inner), "{question}: {said}");
        }
        let longest = said.lines().map(str::len).max().unwrap_or_default();
        assert!(longest < 400, "{question}: {said}");
        let _ = write!(text, "$ {question}\n{said}");
    }
    text
}

/// Names of several words.
const NAMES: &[&str] = &[
    "Debug Adapter Protocol",
    "Elite Robots",
    "Model Context Protocol",
    "Rx Ry Rz",
    "Universal Robots",
    "eliteserver test",
    "identify friction",
    "identify payload",
    "identify tool",
];

/// Whether a line is not a sentence: a question, how a command is written, a comment of a program, Python's report of
/// an error.
fn is_code(line: &str) -> bool {
    let line = line.trim_start();
    ["$ ", "# ", "Traceback ", "用法: "]
        .iter()
        .any(|begin| line.starts_with(begin))
        || line.starts_with("eliteserver ")
        || line.contains(", line ")
}

/// The first two English words of a line that follow each other outside of code, names, lists and what was typed.
fn mixture(line: &str) -> Option<String> {
    if is_code(line) {
        return None;
    }
    let outside = ['\'', '`', '"']
        .iter()
        .fold(line.to_owned(), |text, quote| {
            let pieces: Vec<&str> = text.split(*quote).step_by(2).collect();
            pieces.join("…")
        });
    let outside = NAMES
        .iter()
        .fold(outside, |text, name| text.replace(name, "…"));
    let is_word = |word: &str| {
        word.len() > 1
            && word.bytes().all(|letter| letter.is_ascii_alphabetic())
            && word
                .bytes()
                .skip(1)
                .any(|letter| letter.is_ascii_lowercase())
    };
    let mut runs = outside.split(|letter: char| !letter.is_ascii());
    runs.find_map(|run| {
        let words: Vec<&str> = run.split(' ').collect();
        let mut pairs = words.windows(2);
        let pair = pairs.find(|pair| {
            is_word(pair[0]) && is_word(pair[1].trim_end_matches([',', '.', ';', ':']))
        })?;
        Some(pair.join(" "))
    })
}

pub(crate) fn assert_no_mixture(text: &str) {
    let found: Vec<_> = text
        .lines()
        .filter_map(|line| Some((line, mixture(line)?)))
        .collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn wrong_input_says_what_is_allowed() {
    insta::assert_snapshot!(transcript(QUESTIONS, "en", |status| status == Some(2)));
}

#[test]
fn wrong_input_is_told_in_chinese() {
    let text = transcript(QUESTIONS, "zh", |status| status == Some(2));
    insta::assert_snapshot!(text);
    assert_no_mixture(&text);
}

#[test]
fn help_and_results_are_told_in_chinese() {
    let text = transcript(ANSWERED, "zh", |status| matches!(status, Some(0..=2)));
    let lines = text.lines().map(|line| match line.split_once("规划用时") {
        Some((before, _)) => format!("{before}规划用时 …\n"),
        None => format!("{line}\n"),
    });
    let text: String = lines.collect();
    insta::assert_snapshot!(text);
    assert_no_mixture(&text);
}

#[test]
fn a_mixture_is_found() {
    assert_eq!(mixture("第 3 行：the arm 停止").as_deref(), Some("the arm"));
    assert_eq!(mixture("参数 'the arm' 无效，3 rad"), None);
}
