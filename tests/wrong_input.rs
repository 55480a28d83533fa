//! Wrong input to the commands about cells, paths, toolpaths, programs of others and numbers of an arm: a transcript of
//! what the terminal says. Each says what was given and what is allowed; none panics, hangs or names a library.

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

fn transcript() -> String {
    let folder = tempfile::tempdir().unwrap();
    files(folder.path());
    let recorded = eliteserver()
        .args(["run", "ok.script", "--record", "ok.mcap"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(recorded.status.success());
    let mut text = String::new();
    for question in QUESTIONS {
        let output = eliteserver()
            .args(question.split(' '))
            .args(["--language", "en"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{question}: {said}");
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

#[test]
fn wrong_input_says_what_is_allowed() {
    insta::assert_snapshot!(transcript());
}
