//! The mistakes that people make most, as transcripts of what the terminal says: what `check` finds, and what `run`
//! says of the same program, in English and in Chinese.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::fmt::Write as _;
use std::path::Path;

use crate::common::{eliteserver, said_and_status};

/// A name, and the program.
const MISTAKES: [(&str, &str); 32] = [
    ("capitals", "moveJ([0, -1.57, 1.57, -1.57, -1.57, 0])\n"),
    (
        "names_of_others",
        "set_digital_out(0, true)\ntextmessage(\"hello\")\nwait(1)\n",
    ),
    (
        "pose_literal",
        "movel(p[0.4, 0, 0.3, 3.14, 0, 0], 1.2, 0.25)\n",
    ),
    ("global_with_value", "global x = 3\nprint(x)\n"),
    (
        "global_in_function",
        "def f():\n    global count = 0\nend\nf()\n",
    ),
    ("degrees", "movej([0, -90, 90, -90, -90, 0])\n"),
    ("millimetres", "movel([400, 0, 300, 3.14, 0, 0])\n"),
    (
        "no_break_space",
        "movej([0, -1.57, 1.57,\u{a0}-1.57, -1.57, 0])\n",
    ),
    ("tab_after_blanks", "def f():\n    x = 1\n\ty = 2\nend\n"),
    ("typographic_quotes", "textmsg(“hello”)\n"),
    (
        "speed_in_degrees",
        "movej([0, -1.57, 1.57, -1.57, -1.57, 0], v=60)\n",
    ),
    (
        "speed_in_millimetres",
        "here = get_actual_tcp_pose()\nmovel(pose_add(here, [0, 0, 0.05, 0, 0, 0]), a=1200, v=250)\n",
    ),
    (
        "radius_in_millimetres",
        "movej([0, -1.57, 1.57, -1.57, -1.57, 0], r=50)\n",
    ),
    ("comparison_for_assignment", "x = 3\nx == 4\n"),
    (
        "assignment_for_comparison",
        "x = 3\nif x = 4:\n    print(x)\nend\n",
    ),
    (
        "joints_to_movel",
        "home = get_actual_joint_positions()\nmovel(home)\n",
    ),
    ("pose_to_movej", "movej(get_actual_tcp_pose())\n"),
    (
        "argument_forgotten",
        "def pick(pose, height):\n    movel(pose)\nend\npick([0.4, 0, 0.3, 3.14, 0, 0])\n",
    ),
    ("out_of_reach", "movel([1.4, 0, 0.3, 3.14, 0, 0])\n"),
    ("self_collision", "movej([0, -1.57, 2.9, 0, 0, 0])\n"),
    ("loop_without_wait", "while True:\n    x = 1\nend\n"),
    (
        "empty_loop",
        "while get_standard_digital_in(0) == False:\nend\n",
    ),
    ("colon_forgotten", "x = 3\nif x == 3\n    print(x)\nend\n"),
    (
        "else_if",
        "x = 3\nif x == 1:\n    print(1)\nelse if x == 3:\n    print(3)\nend\n",
    ),
    ("thread_statement", "thread blink():\n    sleep(1)\nend\n"),
    ("five_joints", "movej([0, -1.57, 1.57 -1.57, -1.57, 0])\n"),
    (
        "bracket_forgotten",
        "movej([0, -1.57, 1.57, -1.57, -1.57, 0]\nprint(1)\n",
    ),
    ("output_16", "set_standard_digital_out(16, True)\n"),
    ("numpy", "import numpy as np\nq = np.array([0, 1])\n"),
    ("text_and_number", "print(\"parts: \" + 3)\n"),
    ("comment_and_increment", "// go home\ni = 0\ni++\n"),
    (
        "misread_name",
        "p1 = [0, -1.57, 1.57, -1.57, -1.57, 0]\nmovej(pl)\nmovej\nmovej[p1]\n",
    ),
];

fn said(folder: &Path, arguments: &[&str]) -> String {
    let (said, status) = said_and_status(folder, arguments);
    format!("{}[{status}]\n", without_machine_time(&said))
}

/// What a run took of the machine's time is another time each time.
fn without_machine_time(text: &str) -> String {
    let lines = text.lines().map(|line| {
        for (head, mark) in [("ended: ", ", in "), ("结束：", "用时 ")] {
            if line.starts_with(head)
                && let Some((before, _)) = line.rsplit_once(mark)
            {
                return format!("{before}{mark}… s\n");
            }
        }
        format!("{line}\n")
    });
    lines.collect()
}

fn transcript(language: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::new();
    for (name, program) in MISTAKES {
        let file = format!("{name}.script");
        std::fs::write(folder.path().join(&file), program).unwrap();
        let _ = write!(text, "=== {name}\n{program}--- check\n");
        text += &said(
            folder.path(),
            &["check", "--model", "cs66", "--language", language, &file],
        );
        text += "--- run\n";
        // Only this one never ends; the moment at which a motion is cut off is another one each time.
        let timeout = if name == "loop_without_wait" {
            "1"
        } else {
            "60"
        };
        text += &said(
            folder.path(),
            &["run", "--timeout", timeout, "--language", language, &file],
        );
    }
    text
}

#[test]
fn mistakes_in_english() {
    insta::assert_snapshot!(transcript("en"));
}

#[test]
fn mistakes_in_chinese() {
    let text = transcript("zh");
    insta::assert_snapshot!(text);
}

/// What is said of programs that are right, or wrong on purpose where the finding cannot know: the end of the path, the
/// code, the beginning of the message.
const KNOWN_ALARMS: &[(&str, &str, &str)] = &[
    // Six numbers are joint positions to movej, whatever they were before; the run is compared with another one.
    ("moves/planned.script", "pose-for-joints", "'q' of movej()"),
    // Python's function of three arguments; the robot's has two.
    (".script", "argument-count", "pow() takes at most 2"),
];

#[test]
fn programs_of_this_repository_raise_no_false_alarm() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let output = eliteserver()
        .args(["check", "--format", "json", "examples", "tests"])
        .current_dir(root)
        .output()
        .unwrap();
    let found = String::from_utf8_lossy(&output.stdout).into_owned();
    let codes = [
        "argument-count",
        "degrees",
        "far-beyond",
        "joints-for-pose",
        "millimetres",
        "missing-argument",
        "not-called",
        "out-of-range",
        "out-of-reach",
        "pose-for-joints",
        "self-collision",
        "subscripted-function",
        "unknown-argument",
        "unused-comparison",
    ];
    let mut alarms = Vec::new();
    for line in found.lines() {
        let finding: serde_json::Value = serde_json::from_str(line).unwrap();
        let of = |key: &str| finding[key].as_str().unwrap_or_default();
        let is_known = KNOWN_ALARMS.iter().any(|(file, code, message)| {
            of("file").ends_with(file) && of("code") == *code && of("message").starts_with(message)
        });
        if codes.contains(&of("code")) && !is_known {
            alarms.push(format!(
                "{}:{}: {}",
                of("file"),
                finding["line"],
                of("message")
            ));
        }
    }
    assert_eq!(alarms, [""; 0]);
}
