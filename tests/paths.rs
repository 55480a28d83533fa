//! Clear paths from the command line: is the way free, a way around, a faster way, and where the arm should stand.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::path::Path;
use std::process::Output;

use serde_json::Value as Json;
use tempfile::TempDir;

use crate::common::eliteserver;

const CELL: &str = r#"
[[obstacle]]
name = "post"
shape = "cylinder"
size = [0.04, 1.0]
pose = [-0.45, 0, 0.5, 0, 0, 0]

[[obstacle]]
name = "table"
shape = "box"
size = [2, 2, 0.1]
pose = [0, 0, -0.06, 0, 0, 0]
"#;

const THROUGH: &str = "def through():
    movej([0.8, -1.4, 1.4, -1.57, -1.57, 0.0])
    movej([-0.8, -1.4, 1.4, -1.57, -1.57, 0.0])
end
";

const LEFT: &str = "0.8,-1.57,1.57,-1.57,-1.57,0";
const RIGHT: &str = "-0.8,-1.57,1.57,-1.57,-1.57,0";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cell.toml"), CELL).unwrap();
    std::fs::write(folder.path().join("through.script"), THROUGH).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = eliteserver();
    command
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn status(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn rows(output: &Output) -> Vec<Json> {
    let text = text(&output.stdout);
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn clearance_tells_each_motion_and_all_of_them() {
    let folder = folder();
    let home = format!("--home={LEFT}");
    let arguments = [
        "clearance",
        "through.script",
        "--cell",
        "cell.toml",
        &home,
        "--format",
        "json",
    ];
    let output = run(folder.path(), &arguments);
    assert_eq!(status(&output), 1, "{output:?}");
    let rows = rows(&output);
    let [first, second, summary] = &rows[..] else {
        panic!("{rows:?}");
    };
    for (row, line) in [(first, 2), (second, 3)] {
        assert_eq!(row["line"], line);
        assert_eq!(row["kind"], "movej");
        assert_eq!(row["node"], Json::Null);
        assert_eq!(row["tcp"].as_array().unwrap().len(), 6);
        for key in ["distance", "time", "joint_margin", "singularity"] {
            assert!(row[key].is_f64(), "{key}: {row}");
        }
    }
    assert!(first["distance"].as_f64().unwrap() > 0.0);
    assert!(second["distance"].as_f64().unwrap() < -0.02);
    assert_eq!(second["b"], "post");
    assert_eq!(summary["summary"], true);
    assert_eq!(summary["ok"], false);
    assert_eq!(summary["distance"], second["distance"]);
    assert_eq!(
        (&summary["line"], &summary["motions"]),
        (&Json::from(3), &Json::from(2))
    );

    let human = run(
        folder.path(),
        &["clearance", "through.script", "--cell", "cell.toml", &home],
    );
    let human = text(&human.stdout);
    assert!(
        human.contains("touches") && human.contains("post run "),
        "{human}"
    );
    // Beside the post there is room.
    std::fs::write(
        folder.path().join("beside.script"),
        "movej([0.7, -1.4, 1.4, -1.57, -1.57, 0.0])\n",
    )
    .unwrap();
    let plot = folder.path().join("distance.png");
    let beside = [
        "clearance",
        "beside.script",
        "--cell",
        "cell.toml",
        &home,
        "--plot",
        plot.to_str().unwrap(),
    ];
    let output = run(folder.path(), &beside);
    assert_eq!(status(&output), 0, "{output:?}");
    assert!(std::fs::metadata(&plot).unwrap().len() > 1000);
    let output = run(
        folder.path(),
        &[&beside[..5], &["--margin", "0.5"]].concat(),
    );
    assert_eq!(status(&output), 1, "{output:?}");
}

#[test]
fn what_cannot_be_measured_is_a_sentence() {
    let folder = folder();
    std::fs::write(
        folder.path().join("waits.script"),
        "while not get_standard_digital_in(0):\n    sync()\nend\n",
    )
    .unwrap();
    std::fs::write(
        folder.path().join("fails.script"),
        "movej([0.7, -1.4, 1.4, -1.57, -1.57, 0.0])\nx = 1 / 0\n",
    )
    .unwrap();
    for (arguments, code, said) in [
        (&["clearance", "waits.script"][..], 2, "line"),
        (&["clearance", "fails.script"], 1, "ZeroDivisionError"),
        (&["clearance", "nothing.script"], 2, "nothing.script"),
        (
            &["clearance", "through.script", "--margin", "-1"],
            2,
            "--margin",
        ),
        (
            &["clearance", "through.script", "--plant", "rigid"],
            2,
            "--plant",
        ),
        (
            &["clearance", "through.script", "--cell", "none.toml"],
            2,
            "none.toml",
        ),
        (&["plan", "--to", "1,2,3"], 2, "p[0.4"),
        (&["plan", "--to", "9,0,0,0,0,0"], 2, "joint 1"),
        (
            &[
                "plan",
                "--to",
                RIGHT,
                "--held",
                "box",
                "--cell",
                "cell.toml",
            ],
            2,
            "post, table",
        ),
        (&["place", "--points", "none.txt"], 2, "none.txt"),
        (&["optimize", "through.script", "--keep", "0-3"], 2, "12-30"),
    ] {
        let output = run(folder.path(), arguments);
        let error = text(&output.stderr);
        assert_eq!(status(&output), code, "{arguments:?}: {error}");
        assert!(error.contains(said), "{arguments:?}: {error}");
    }
}

#[test]
fn check_finds_collisions_where_the_cell_is_known() {
    let folder = folder();
    let home = format!("--home={LEFT}");
    let plain = run(folder.path(), &["check", "through.script"]);
    assert_eq!(status(&plain), 0, "{plain:?}");
    let output = run(
        folder.path(),
        &[
            "check",
            "through.script",
            "--cell",
            "cell.toml",
            &home,
            "--format",
            "json",
        ],
    );
    assert_eq!(status(&output), 1, "{output:?}");
    let rows = rows(&output);
    assert_eq!(rows.len(), 1, "{rows:?}");
    assert_eq!(
        (&rows[0]["code"], &rows[0]["line"]),
        (&Json::from("collision"), &Json::from(3))
    );
    assert!(
        rows[0]["message"].as_str().unwrap().contains("post"),
        "{rows:?}"
    );
    let near = run(
        folder.path(),
        &[
            "check",
            "through.script",
            "--cell",
            "cell.toml",
            &home,
            "--margin",
            "0.5",
            "--format",
            "json",
        ],
    );
    let text = text(&near.stdout);
    assert!(
        text.contains("\"near\"") && text.contains("\"collision\""),
        "{text}"
    );
}

#[test]
fn a_plan_is_a_program_that_keeps_the_margin() {
    let folder = folder();
    let (from, to) = (format!("--from={LEFT}"), format!("--to={RIGHT}"));
    let arguments = [
        "plan",
        &from,
        &to,
        "--cell",
        "cell.toml",
        "--margin",
        "0.02",
        "--seed",
        "5",
        "--time",
        "600",
        "--format",
        "json",
        "-o",
        "around.script",
    ];
    let output = run(folder.path(), &arguments);
    assert_eq!(status(&output), 0, "{output:?}");
    let answer = &rows(&output)[0];
    assert_eq!(answer["ok"], true);
    let program = std::fs::read_to_string(folder.path().join("around.script")).unwrap();
    assert_eq!(answer["program"], program.as_str());
    assert!(answer["distance"].as_f64().unwrap() >= 0.02, "{answer}");
    let waypoints = answer["waypoints"].as_array().unwrap();
    let last: Vec<f64> = serde_json::from_value(waypoints[waypoints.len() - 1].clone()).unwrap();
    assert_eq!(last, [-0.8, -1.57, 1.57, -1.57, -1.57, 0.0]);
    // The same seed gives the same program, and it is clear for whoever looks.
    let again = run(folder.path(), &arguments);
    let again = &rows(&again)[0];
    assert_eq!(again["program"], answer["program"]);
    let home = format!("--home={LEFT}");
    let clear = [
        "clearance",
        "around.script",
        "--cell",
        "cell.toml",
        &home,
        "--margin",
        "0.02",
    ];
    let output = run(folder.path(), &clear);
    assert_eq!(status(&output), 0, "{output:?}\n{program}");
    // The program runs as it is, and passes the check.
    let output = run(
        folder.path(),
        &["run", "around.script", "--cell", "cell.toml", &home],
    );
    assert_eq!(status(&output), 0, "{output:?}");
    assert_eq!(status(&run(folder.path(), &["check", "around.script"])), 0);

    let inside = [
        "plan",
        &from,
        "--to=0,-1.57,1.57,-1.57,-1.57,0",
        "--cell",
        "cell.toml",
        "--format",
        "json",
    ];
    let output = run(folder.path(), &inside);
    assert_eq!(status(&output), 1, "{output:?}");
    let answer = &rows(&output)[0];
    assert_eq!(
        (&answer["ok"], &answer["reason"]),
        (&Json::from(false), &Json::from("goal_in_collision"))
    );
    let far = [
        "plan",
        &from,
        "--to",
        "p[2,0,0.3,3.14,0,0]",
        "--cell",
        "cell.toml",
        "--format",
        "json",
    ];
    let answer = &rows(&run(folder.path(), &far))[0];
    assert_eq!(answer["reason"], "out_of_reach");
}

#[test]
fn an_optimized_program_is_shorter_and_does_the_same() {
    let folder = folder();
    let slow = "def cycle():
    movej([0.8, -1.3, 1.3, -1.57, -1.57, 0.0], a=0.8, v=0.5)
    movej([0.9, -1.35, 1.35, -1.57, -1.57, 0.0], a=0.8, v=0.5)
    movej([1.0, -1.4, 1.4, -1.57, -1.57, 0.0], a=0.8, v=0.5)
    set_standard_digital_out(0, True)
    sleep(0.2)
    # process
    movej([1.2, -1.4, 1.4, -1.57, -1.57, 0.0], a=0.3, v=0.2)
    set_standard_digital_out(0, False)
    movej([0.8, -1.57, 1.57, -1.57, -1.57, 0.0], a=0.8, v=0.5)
    print('done')
end
";
    std::fs::write(folder.path().join("slow.script"), slow).unwrap();
    let home = format!("--home={LEFT}");
    let arguments = [
        "optimize",
        "slow.script",
        "--cell",
        "cell.toml",
        &home,
        "--keep",
        "8",
        "-o",
        "fast.script",
    ];
    let output = run(folder.path(), &arguments);
    assert_eq!(status(&output), 0, "{output:?}");
    let diff = text(&output.stdout);
    assert!(
        diff.starts_with("--- slow.script\n+++ slow.script (optimized)\n@@ -1,"),
        "{diff}"
    );
    let fast = std::fs::read_to_string(folder.path().join("fast.script")).unwrap();
    assert!(
        fast.contains("    movej([1.2, -1.4, 1.4, -1.57, -1.57, 0.0], a=0.3, v=0.2)\n"),
        "{fast}"
    );
    assert!(!fast.contains("[0.9, -1.35"), "{fast}");
    let said = text(&output.stderr);
    assert!(said.contains("% shorter"), "{said}");
    let output = run(
        folder.path(),
        &["run", "fast.script", "--cell", "cell.toml", &home],
    );
    assert_eq!(
        (status(&output), text(&output.stdout)),
        (0, "done\n".to_owned()),
        "{output:?}"
    );
    // Once more there is nothing left to gain, and what touches is not made faster.
    let again = [
        "optimize",
        "fast.script",
        "--cell",
        "cell.toml",
        &home,
        "--keep",
        "1-99",
    ];
    let output = run(folder.path(), &again);
    assert_eq!(
        (status(&output), text(&output.stdout)),
        (0, String::new()),
        "{output:?}"
    );
    assert!(
        text(&output.stderr).contains("nothing can be gained"),
        "{output:?}"
    );
    let through = ["optimize", "through.script", "--cell", "cell.toml", &home];
    let output = run(folder.path(), &through);
    assert_eq!(status(&output), 1, "{output:?}");
    assert!(text(&output.stderr).contains("line 3"), "{output:?}");
}

#[test]
fn a_base_is_placed_where_all_points_are_reached() {
    let folder = folder();
    let points = "# x y z Rx Ry Rz\n0.4 0.3 0.3 3.14159 0 0\n0.5, -0.2, 0.2, 3.14159, 0, 0.5\n";
    std::fs::write(folder.path().join("points.txt"), points).unwrap();
    let arguments = [
        "place",
        "--points",
        "points.txt",
        "--cell",
        "cell.toml",
        "--area=-0.3,0.3,-0.3,0.3",
        "--format",
        "json",
    ];
    let output = run(folder.path(), &arguments);
    assert_eq!(status(&output), 0, "{output:?}");
    let answer = &rows(&output)[0];
    for key in ["x", "y", "yaw", "joint_margin", "distance", "time"] {
        assert!(answer[key].is_f64(), "{key}: {answer}");
    }
    assert!(answer["distance"].as_f64().unwrap() >= 0.01, "{answer}");
    std::fs::write(
        folder.path().join("points.txt"),
        "0.4 0 0.3 3.14159 0 0\n5 0 0.2 3.14159 0 0\n",
    )
    .unwrap();
    let output = run(folder.path(), &arguments);
    assert_eq!(status(&output), 1, "{output:?}");
    assert_eq!(
        rows(&output)[0],
        serde_json::json!({"ok": false, "points": [2]})
    );
}
