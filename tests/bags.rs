//! Bags of ROS 2: of a recording, beside the recording of a run, and as a side of `compare`. That ROS tools read them
//! is seen in `tests/ros2`.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::path::Path;

use crate::common::eliteserver;

const MOVES: &str = "movej([0.3, -1.4, 1.5, -1.6, -1.5, 0.2], a=1.2, v=0.8)\n";

/// Runs the program in the folder; what is said and the exit status.
fn run(folder: &Path, text: &str, options: &[&str]) -> (String, Option<i32>) {
    std::fs::write(folder.join("x.script"), text).unwrap();
    command(folder, &[&["run", "x.script"], options].concat())
}

fn command(folder: &Path, arguments: &[&str]) -> (String, Option<i32>) {
    let mut command = eliteserver();
    let output = command
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (String::from_utf8(text).unwrap(), output.status.code())
}

fn files_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn the_bag_beside_a_recording_says_what_the_recording_says() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let options = ["--record", "x.mcap", "--ros2-profile"];
    for _ in 0..2 {
        // The second one takes the place of the first, as recordings do.
        let (text, status) = run(at, MOVES, &options);
        assert_eq!(status, Some(0), "{text}");
        assert_eq!(files_in(&at.join("x")), ["metadata.yaml", "x_0.mcap"]);
    }
    let (text, status) = command(at, &["replay", "x.mcap", "--rosbag2", "y"]);
    assert_eq!(status, Some(0), "{text}");
    let read = |path: &str| std::fs::read(at.join(path)).unwrap();
    assert_eq!(read("x/x_0.mcap"), read("y/y_0.mcap"));
    let json = [
        "compare", "x.mcap", "x", "--within", "1e-12", "--format", "json",
    ];
    let (text, status) = command(at, &json);
    assert_eq!(status, Some(0), "{text}");
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    // A bag has its own beginning, the first cycle.
    assert!((number(&found["shift"]) + 0.004).abs() < 1e-6, "{found}");
    assert!(number(&found["tcp_position"]["largest"]) < 1e-9, "{found}");
    assert!(number(&found["force"]["largest"]) < 1e-9, "{found}");
    assert!(found["tcp_speed"].is_null(), "{found}");
    // The file alone is as good as the folder, also as the first side.
    let (text, status) = command(
        at,
        &["compare", "x/x_0.mcap", "x.mcap", "--within", "1e-12"],
    );
    assert_eq!(status, Some(0), "{text}");
    let (text, status) = command(at, &["compare", "x", "--run", "x.script"]);
    assert_eq!(status, Some(2), "{text}");
    assert!(
        text.contains("run the script with 'run --record FILE'"),
        "{text}"
    );
}

#[test]
fn a_key_of_the_file_asks_for_the_bag_as_well_and_the_option_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(
        at.join("e.toml"),
        "record = 'x.mcap'\nros2-profile = true\n",
    )
    .unwrap();
    let (text, status) = run(
        at,
        "pass\n",
        &["--config", "e.toml", "--ros2-profile=false"],
    );
    assert_eq!(status, Some(0), "{text}");
    assert!(!at.join("x").exists());
    let (text, status) = run(at, "pass\n", &["--config", "e.toml"]);
    assert_eq!(status, Some(0), "{text}");
    assert!(at.join("x/x_0.mcap").exists());
}

#[test]
fn a_program_that_fails_leaves_its_bag_and_its_status() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let options = ["--record", "x.mcap", "--ros2-profile"];
    let (text, status) = run(at, "sleep(0.1)\n1 / 0\n", &options);
    assert_eq!(status, Some(1), "{text}");
    let (text, status) = command(at, &["compare", "x.mcap", "x", "--within", "1e-12"]);
    assert_eq!(status, Some(0), "{text}");
}

#[test]
fn where_there_can_be_no_bag_that_is_said_before_the_program_runs() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::create_dir(at.join("mine")).unwrap();
    std::fs::write(at.join("mine/letter.txt"), "dear").unwrap();
    std::fs::write(at.join("file"), "").unwrap();
    for (options, reason) in [
        (&["--ros2-profile"][..], "give --record FILE as well"),
        (
            &["--ros2-profile", "--record", "off"],
            "give --record FILE as well",
        ),
        (
            &[
                "--ros2-profile",
                "--record",
                "x.mcap",
                "--record-rotate",
                "10s",
            ],
            "leave --record-rotate out",
        ),
        (
            &["--ros2-profile", "--record", "mine.mcap"],
            "something else in that folder",
        ),
        (
            &["--ros2-profile", "--record", "file.mcap"],
            "the bag file: ",
        ),
    ] {
        let (text, status) = run(at, "print('it runs')\n", options);
        assert_eq!(status, Some(2), "{text}");
        assert!(text.contains(reason), "{text}");
        assert!(!text.contains("it runs"), "{text}");
    }
    assert_eq!(files_in(&at.join("mine")), ["letter.txt"]);
}

#[test]
fn what_is_no_bag_is_refused_with_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // Long enough for several chunks, of which the last one is lost where a file is cut off.
    let long = format!("{MOVES}sleep(20)\n");
    let (text, status) = run(at, &long, &["--record", "x.mcap", "--ros2-profile"]);
    assert_eq!(status, Some(0), "{text}");
    let bag = std::fs::read(at.join("x/x_0.mcap")).unwrap();
    std::fs::create_dir(at.join("empty")).unwrap();
    std::fs::create_dir(at.join("bad")).unwrap();
    let mut broken = bag.clone();
    // In the first chunk, which begins as everything that zstd packs.
    let packed = broken
        .windows(4)
        .position(|bytes| bytes == [0x28, 0xb5, 0x2f, 0xfd]);
    let within = packed.unwrap() + 200;
    broken[within..within + 64].fill(0xff);
    std::fs::write(at.join("bad/bad_0.mcap"), broken).unwrap();
    std::fs::create_dir(at.join("cut")).unwrap();
    std::fs::write(at.join("cut/cut_0.mcap"), &bag[..bag.len() / 2]).unwrap();
    for (side, reason) in [
        ("empty", "no file in that folder ends in .mcap"),
        ("bad", "is damaged: "),
        ("nowhere", "cannot read nowhere"),
    ] {
        let (text, status) = command(at, &["compare", "x.mcap", side]);
        assert_eq!(status, Some(2), "{text}");
        assert!(text.contains(reason) && text.lines().count() == 1, "{text}");
    }
    // What the writer of a killed recorder has left is compared, and said to be cut off.
    let (text, status) = command(at, &["compare", "x.mcap", "cut", "--within", "1e-12"]);
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("was cut off"), "{text}");
}
