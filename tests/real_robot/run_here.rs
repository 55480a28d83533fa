//! `eliteserver compare RECORDING --run SCRIPT`: from what a robot did to what the simulation does, in one command.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use super::{command, send};
use crate::common::{Server, eliteserver};

const MOVES: &str = "movej([0.4, -1.3, 1.5, -1.7, -1.5, 0.3], a=2, v=1)\n\
                     movel(pose_add(get_target_tcp_pose(), [0, 0.1, 0.05, 0, 0, 0]), a=0.6, v=0.2)\n\
                     print('was here')\n";

/// What was said, and the status.
fn compared(arguments: &[&Path], options: &[&str]) -> (String, Option<i32>) {
    let mut command = eliteserver();
    command.arg("compare").args(arguments).args(options);
    let output = command.output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (String::from_utf8(text).unwrap(), output.status.code())
}

fn script(folder: &Path) -> PathBuf {
    let path = folder.join("moves.script");
    std::fs::write(&path, MOVES).unwrap();
    path
}

fn calibration() -> PathBuf {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/calibrations");
    let files = std::fs::read_dir(robots).unwrap().flatten();
    let files = files.map(|entry| entry.path());
    let files = files.filter(|path| path.extension().is_some_and(|end| end == "toml"));
    files.min().unwrap()
}

#[test]
fn a_robot_that_was_recorded_is_compared_with_the_same_script_run_here() {
    let folder = tempfile::tempdir().unwrap();
    let arm = calibration();
    let options = [
        "--calibration",
        arm.to_str().unwrap(),
        "--tcp=0.01,0,0.12,0,0.2,0",
        "--payload=2.5,0,0,0.05",
        "--home=0.2,-1.4,1.4,-1.5,-1.5,0.1",
    ];
    let server = Server::start(folder.path(), &options);
    let recorded = folder.path().join("robot.mcap");
    let mut record = command(&server, "record");
    record
        .args(["--duration", "5", "--out"])
        .arg(&recorded)
        .stderr(Stdio::null());
    let mut recording = record.spawn().unwrap();
    std::thread::sleep(Duration::from_millis(800));
    let (text, status) = send(&server, folder.path(), MOVES, &[]);
    assert_eq!(status, Some(0), "{text}");
    assert!(recording.wait().unwrap().success());
    drop(server);

    let script = script(folder.path());
    let run = ["--run", script.to_str().unwrap()];
    let (text, status) = compared(&[&recorded], &[&run[..], &["--within", "0.002"]].concat());
    assert_eq!(status, Some(0), "{text}");
    assert!(text.contains("moves.script run here moves from"), "{text}");
    let json = |options: &[&str]| -> serde_json::Value {
        let options = [&run[..], &["--format", "json"], options].concat();
        let (text, status) = compared(&[&recorded], &options);
        assert_eq!(status, Some(0), "{text}");
        // What the script prints is not in the way of the answer.
        let line = text.lines().find(|line| line.starts_with('{')).unwrap();
        serde_json::from_str(line).unwrap()
    };
    // The tool was the recording's, or the TCP would be elsewhere.
    let kept = folder.path().join("kept.mcap");
    let found = json(&["--keep", kept.to_str().unwrap()]);
    let tcp = found["tcp_position"]["largest"].as_f64().unwrap();
    assert!(tcp < 0.002, "{found}");
    let (text, status) = compared(&[&recorded, &kept], &["--within", "0.002"]);
    assert_eq!(status, Some(0), "{text}");

    // The same with the nominal arm and no tool is not the same.
    let other = folder.path().join("other.mcap");
    let ran = eliteserver()
        .arg("run")
        .arg(&script)
        .args(["--home=0.2,-1.4,1.4,-1.5,-1.5,0.1", "--record"])
        .arg(&other)
        .output()
        .unwrap();
    assert!(ran.status.success());
    let (text, status) = compared(&[&recorded, &other], &["--format", "json"]);
    assert_eq!(status, Some(0), "{text}");
    let found: serde_json::Value = serde_json::from_str(text.trim()).unwrap();
    let tcp = found["tcp_position"]["largest"].as_f64().unwrap();
    assert!(tcp > 0.1, "{found}");
}

#[test]
fn a_recording_of_ours_runs_again_with_its_own_cell_and_model() {
    let folder = tempfile::tempdir().unwrap();
    let script = script(folder.path());
    let cell = folder.path().join("cell.toml");
    std::fs::write(
        &cell,
        "[[safety_plane]]\nname = \"wall\"\npoint = [0, 5, 0]\nnormal = [0, -1, 0]\n",
    )
    .unwrap();
    let a = folder.path().join("a.mcap");
    let ran = eliteserver()
        .arg("run")
        .arg(&script)
        .args([
            "--model",
            "cs612",
            "--step-ms",
            "2",
            "--payload",
            "3",
            "--cell",
        ])
        .arg(&cell)
        .arg("--record")
        .arg(&a)
        .output()
        .unwrap();
    assert!(ran.status.success(), "{ran:?}");
    let run = ["--run", script.to_str().unwrap()];
    // To the last bit: nothing of the setting was lost.
    let (text, status) = compared(&[&a], &[&run[..], &["--within", "0"]].concat());
    assert_eq!(status, Some(0), "{text}");
    // Another script is another run; one that fails half way is compared as far as it came.
    let other = folder.path().join("other.script");
    std::fs::write(
        &other,
        "movej([0.2, -1.3, 1.5, -1.7, -1.5, 0.3], a=2, v=1)\n1 / 0\n",
    )
    .unwrap();
    let run = ["--run", other.to_str().unwrap()];
    let (text, status) = compared(&[&a], &[&run[..], &["--within", "0.01"]].concat());
    assert_eq!(status, Some(1), "{text}");
    assert!(text.contains("did not end well here"), "{text}");
    assert!(text.contains("ZeroDivisionError"), "{text}");
}

#[test]
fn what_cannot_be_run_is_told_with_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let script = script(folder.path());
    let a = folder.path().join("a.mcap");
    let mut run = eliteserver();
    run.arg("run").arg(&script).arg("--record").arg(&a);
    assert!(run.output().unwrap().status.success());
    let broken = folder.path().join("broken.script");
    std::fs::write(&broken, "movej(\n").unwrap();
    for (options, wanted) in [
        (vec!["--run", broken.to_str().unwrap()], "does not compile"),
        (vec!["--run", "/does/not/exist"], "cannot read the script"),
        (
            vec![
                "--run",
                script.to_str().unwrap(),
                "--keep",
                "/dev/null/run.mcap",
            ],
            "/dev/null/run.mcap",
        ),
        (vec!["b.mcap", "--run", script.to_str().unwrap()], "--run"),
        (vec!["--keep", "b.mcap"], "--run"),
        (vec![], "B.mcap"),
    ] {
        let (text, status) = compared(&[&a], &options);
        assert_eq!(status, Some(2), "{options:?}: {text}");
        assert!(text.contains(wanted), "{options:?}: {text}");
    }
}
