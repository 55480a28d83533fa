//! `eliteserver identify` and `excite`: numbers that a cell hides are found in recordings of the simulated arm, and
//! what data cannot tell is said.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::common::eliteserver;

const CELL: &str = "\
[sensor]
force_noise = 0.2
torque_noise = 0.01

[payload]
mass = 1.73
cog = [0.021, -0.034, 0.062]
inertia = [0.006, 0.007, 0.004, 0.0, 0.0, 0.0]

[arm]
coulomb = [6.0, 7.0, 5.0, 2.0, 1.5, 1.0]
viscous = [8.0, 9.0, 6.0, 2.5, 2.0, 1.2]
";

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = eliteserver();
    command
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let arguments = [&["identify"], arguments, &["--format", "json"]].concat();
    serde_json::from_str(&done(folder, &arguments)).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

/// A recording of the motion that `excite` makes.
fn excited(folder: &Path, what: &str) {
    std::fs::write(folder.join("hidden.toml"), CELL).unwrap();
    done(folder, &["excite", what, "-o", "excite.script"]);
    done(folder, &["check", "excite.script"]);
    let arguments = [
        "run",
        "excite.script",
        "--cell",
        "hidden.toml",
        "--record",
        "excite.mcap",
    ];
    done(folder, &arguments);
}

#[test]
fn a_hidden_payload_is_found_by_forces_and_by_torques() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    excited(folder, "payload");
    for (options, mass_within, cog_within) in [
        (&["payload", "excite.mcap"][..], 0.01, 0.002),
        (
            &["payload", "excite.mcap", "--from-torques"][..],
            0.01,
            0.002,
        ),
    ] {
        let found = json(folder, options);
        let mass = found["mass"].as_f64().unwrap();
        assert!((mass - 1.73).abs() < mass_within * 1.73, "{found}");
        for (found, hidden) in numbers(&found["cog"]).iter().zip([0.021, -0.034, 0.062]) {
            assert!((found - hidden).abs() < cog_within, "{found} {hidden}");
        }
        assert!(found["sigma"]["mass"].as_f64().unwrap() > 0.0);
        assert_eq!(numbers(&found["sigma"]["cog"]).len(), 3);
    }
    let human = done(
        folder,
        &["identify", "payload", "excite.mcap", "-o", "found.toml"],
    );
    assert!(
        human
            .trim_end()
            .lines()
            .last()
            .unwrap()
            .starts_with("set_payload(1.7"),
        "{human}"
    );
    let table: toml::Table = std::fs::read_to_string(folder.join("found.toml"))
        .unwrap()
        .parse()
        .unwrap();
    assert!(table["payload"]["mass"].is_float());
}

#[test]
fn tools_frames_and_sensors_are_found_from_rests() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // The tip touches one point in six ways, then steps along its x and into its y.
    let program = "\
set_tcp([0.01, -0.02, 0.13, 0.2, 0.1, -0.4])
movej([0.2, -1.4, 1.6, -1.7, -1.5, 0.3])
point = get_target_tcp_pose()
for turn in [[0.4, 0, 0], [-0.4, 0, 0], [0, 0.4, 0], [0, -0.4, 0.3], [0, 0, 0]]:
    movel(pose_trans(point, [0, 0, 0] + turn), v=0.2)
    sleep(0.5)
end
movel(pose_trans(point, [0.1, 0, 0, 0, 0, 0]), v=0.2)
sleep(0.5)
movel(pose_trans(point, [0.03, 0.1, 0, 0, 0, 0]), v=0.2)
sleep(0.5)
";
    std::fs::write(folder.join("touch.script"), program).unwrap();
    std::fs::write(folder.join("hidden.toml"), CELL).unwrap();
    done(
        folder,
        &[
            "run",
            "touch.script",
            "--plant",
            "ideal",
            "--record",
            "touch.mcap",
        ],
    );
    // The start, and the first posture before the point is touched, are rests as well.
    let found = json(
        folder,
        &["tool", "touch.mcap", "--orientation", "--from", "1.5"],
    );
    let tcp = numbers(&found["tcp"]);
    for (found, hidden) in tcp.iter().zip([0.01, -0.02, 0.13, 0.2, 0.1, -0.4]) {
        assert!((found - hidden).abs() < 5e-5, "{tcp:?}");
    }
    assert!(found["residual_max"].as_f64().unwrap() < 1e-5);

    let output = run(folder, &["identify", "frame", "touch.mcap"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("three are needed"));
}

#[test]
fn the_bias_of_a_sensor_and_what_data_cannot_tell() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    excited(folder, "payload");
    let found = json(folder, &["sensor", "excite.mcap"]);
    assert!(
        (found["mass"].as_f64().unwrap() - 1.73).abs() < 0.02,
        "{found}"
    );
    for bias in numbers(&found["bias"]) {
        assert!(bias.abs() < 0.1, "{found}");
    }
    std::fs::write(folder.join("still.script"), "sleep(1)\n").unwrap();
    done(
        folder,
        &[
            "run",
            "still.script",
            "--cell",
            "hidden.toml",
            "--record",
            "still.mcap",
        ],
    );
    for (what, sentence) in [
        ("friction", "did not turn far enough"),
        (
            "tool",
            "four or more rests at one point are needed, the data has 1",
        ),
        ("sensor", "three or more with other orientations are needed"),
    ] {
        let output = run(folder, &["identify", what, "still.mcap"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{what}: {said}");
        assert!(said.contains(sentence), "{what}: {said}");
    }
    std::fs::write(folder.join("broken.mcap"), "no recording").unwrap();
    let output = run(folder, &["identify", "payload", "broken.mcap"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("broken.mcap"));
}
