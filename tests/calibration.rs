//! An arm with kinematics of its own, end to end: scripts, port 30001, recordings, running them again.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::io::Read;
use std::path::{Path, PathBuf};

use crate::common::{Server, eliteserver, run_script};
use kinematics::{Calibration, JointPositions, Pose, RobotModel};

fn file(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.join("robots/calibrations").join(name)
}

/// The CS66 that was measured.
fn measured() -> (PathBuf, RobotModel) {
    let path = file("cs66-measured.toml");
    let arm = Calibration::load(&path).unwrap().open().unwrap();
    (path, arm)
}

/// Numbers that a script printed, one list a line.
fn lists(stdout: &[u8]) -> Vec<Vec<f64>> {
    let text = std::str::from_utf8(stdout).unwrap();
    text.lines()
        .map(|line| {
            let line = line.trim_matches(['[', ']']);
            line.split(", ").map(|x| x.parse().unwrap()).collect()
        })
        .collect()
}

#[test]
fn scripts_see_the_measured_arm_and_lines_end_where_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let (path, arm) = measured();
    let script = "def p():
  q = [0.3, -1.2, 1.9, -0.7, 1.5, 0.2]
  print(get_forward_kin(q, [0,0,0,0,0,0]))
  print(get_inverse_kin(get_forward_kin(q, [0,0,0,0,0,0]), qnear=q, tcp=[0,0,0,0,0,0]))
  movej(q, a=3, v=2)
  here = get_actual_tcp_pose()
  there = pose_add(here, [0.05, -0.04, 0.06, 0, 0, 0])
  print(there)
  movel(there, a=2, v=0.5)
  print(get_actual_tcp_pose())
  print(get_actual_joint_positions())
end
";
    let path = path.to_str().unwrap();
    let output = run_script(
        folder.path(),
        script,
        &["--calibration", path, "--plant", "ideal"],
    );
    assert!(output.status.success(), "{output:?}");
    let lists = lists(&output.stdout);
    let [forward, inverse, wanted, reached, joints] = &lists[..] else {
        panic!("{lists:?}");
    };
    let q = [0.3, -1.2, 1.9, -0.7, 1.5, 0.2];
    let near = |a: &[f64], b: &[f64], tolerance: f64| {
        assert_eq!(a.len(), b.len());
        let off = a
            .iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(off < tolerance, "{a:?} {b:?}");
    };
    let flange = arm.flange_pose(&JointPositions(q)).to_rpy().to_array();
    near(forward, &flange, 1e-12);
    near(inverse, &q, 1e-9);
    near(reached, wanted, 1e-9);
    let joints = JointPositions(joints.as_slice().try_into().unwrap());
    near(
        reached,
        &arm.tcp_pose(&joints, &Pose::IDENTITY).to_rpy().to_array(),
        1e-9,
    );
    // The nominal arm would be two centimetres beside.
    let nominal = RobotModel::built_in("cs66").unwrap();
    let beside = nominal.flange_pose(&joints).translation - arm.flange_pose(&joints).translation;
    assert!(beside.norm() > 0.01);
}

#[test]
fn the_recording_carries_the_numbers_and_runs_again_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = measured();
    let script = "def p():
  movej([0.3, -1.2, 1.9, -0.7, 1.5, 0.2], a=3, v=2)
  movel(pose_add(get_actual_tcp_pose(), [0.05, -0.04, 0.06, 0, 0, 0]), a=2, v=0.5)
end
";
    // The file need not be there when the recording is read.
    let copy = folder.path().join("arm.toml");
    std::fs::copy(path, &copy).unwrap();
    let recording = folder.path().join("run.mcap");
    let options = ["--calibration", "arm.toml", "--record", "run.mcap"];
    let output = run_script(folder.path(), script, &options);
    assert!(output.status.success(), "{output:?}");
    std::fs::remove_file(copy).unwrap();
    let replay = |option: Option<&str>| {
        let output = eliteserver()
            .arg("replay")
            .arg(&recording)
            .args(option)
            .output()
            .unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success(), "{text}");
        text
    };
    assert!(replay(None).contains("robot: cs66 (calibrated), rigid plant"));
    assert!(replay(Some("--rerun")).starts_with("identical: "));
}

#[test]
fn port_30001_sends_the_arms_own_table() {
    let folder = tempfile::tempdir().unwrap();
    let (path, arm) = measured();
    let options = ["--calibration", path.to_str().unwrap(), "--record", "off"];
    let server = Server::start(folder.path(), &options);
    let mut stream = server.primary().stream;
    let configuration = loop {
        let mut head = [0; 5];
        stream.read_exact(&mut head).unwrap();
        let length = u32::from_be_bytes(head[..4].try_into().unwrap()) as usize;
        let mut body = vec![0; length - 5];
        stream.read_exact(&mut body).unwrap();
        if head[4] != 16 {
            continue;
        }
        // Parts of a state message: length, type, content.
        let mut parts = &body[..];
        let found = loop {
            let length = u32::from_be_bytes(parts[..4].try_into().unwrap()) as usize;
            let (part, rest) = parts.split_at(length);
            if part[4] == 6 {
                break part.to_vec();
            }
            parts = rest;
        };
        break found;
    };
    let six = |at: usize| -> [f64; 6] {
        std::array::from_fn(|k| {
            let at = at + 8 * k;
            f64::from_be_bytes(configuration[at..at + 8].try_into().unwrap())
        })
    };
    let table = arm.modified_dh().unwrap();
    assert_eq!(
        (six(237), six(285), six(333)),
        (table.a, table.d, table.alpha)
    );
    assert_eq!(table.d[5], 0.112116);
}

#[test]
fn what_does_not_fit_is_said_and_nothing_starts() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = measured();
    let mistake = |options: &[&str]| {
        let output = run_script(folder.path(), "print(1)\n", options);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(output.stdout.is_empty());
        String::from_utf8(output.stderr).unwrap()
    };
    let other = mistake(&["--calibration", path.to_str().unwrap(), "--model", "cs612"]);
    assert!(
        other.contains("is for the model cs66, but the model cs612 is asked for"),
        "{other}"
    );
    let text = std::fs::read_to_string(&path)
        .unwrap()
        .replace("0.112116", "112.116");
    std::fs::write(folder.path().join("mm.toml"), text).unwrap();
    let far = mistake(&["--calibration", "mm.toml"]);
    assert!(
        far.contains("mm.toml: [modified_dh] has d[5] = 112.116; the cs66 has 0.092 m there"),
        "{far}"
    );
}
