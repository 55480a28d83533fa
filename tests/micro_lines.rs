//! Files of points as scripts of the real binary: every position and unit type, a part's frame, ranges, and a recording
//! that runs again. What the motion itself keeps is tested in the motion crate.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

use std::fmt::Write as _;
use std::path::Path;

use crate::common::{eliteserver, run_script};

/// What the program prints, with the folder as its task folder; fails when the program does.
fn printed(folder: &Path, text: &str, options: &[&str]) -> String {
    let options = [&["--task-dir", "."], options].concat();
    let output = run_script(folder, text, &options);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{error}");
    String::from_utf8(output.stdout).unwrap()
}

/// A wave of joint 1 by 0.2 rad in 50 points, around the pose in which the arm starts; `per_radian` units a radian.
fn wave(per_radian: f64) -> String {
    let quarter = core::f64::consts::FRAC_PI_2;
    let home = [0.0, -quarter, quarter, -quarter, -quarter, 0.0];
    let mut text = String::from("# one wave\n");
    for k in 0..50 {
        let turn = f64::from(k) / 49.0 * core::f64::consts::TAU;
        let first = 0.1 * (1.0 - turn.cos());
        let point = [first, home[1], home[2], home[3], home[4], home[5]];
        let words: Vec<String> = point
            .iter()
            .map(|q| format!("{:.12}", q * per_radian))
            .collect();
        writeln!(text, "{}  # point {}", words.join(", "), k + 1).unwrap();
    }
    text
}

#[test]
fn joint_points_in_radians_and_degrees_are_the_same_motion() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("rad.txt"), wave(1.0)).unwrap();
    std::fs::write(folder.path().join("deg.csv"), wave(1.0_f64.to_degrees())).unwrap();
    let out = printed(
        folder.path(),
        r#"
def p():
    rad = load_micro_line_file("rad", 40)
    deg = load_micro_line_file("deg.csv", 40, 0, 1)
    print(rad != deg, rad == load_micro_line_file("rad.txt", 40))
    a = get_micro_line_values_by_index(rad, 0, 25)
    b = get_micro_line_values_by_index(deg, 0, 25)
    print(norm([a[i] - b[i] for i in range(6)]) < 1e-9, a[0] > 0.19)
    for index in [rad, deg]:
        def watch():
            global high
            high = 0
            while True:
                high = max(high, get_target_joint_positions()[0])
                sync()
            end
        end
        w = start_thread(watch, ())
        start = controller_timestamp()
        moveml(index)
        print(0 <= controller_timestamp() - start - 49 * 0.04 < 0.15)
        stop_thread(w)
        print(abs(high - 0.2) < 1e-3)
    end
    moveml(rad, 1, 25)
    last = get_micro_line_values_by_index(rad, 0, 25)
    now = get_target_joint_positions()
    print(norm([now[i] - last[i] for i in range(6)]) < 1e-9)
    moveml(rad, 25)
    print(abs(get_target_joint_positions()[0]) < 1e-9)
end
"#,
        &[],
    );
    assert_eq!(
        out,
        "True True\nTrue True\nTrue\nTrue\nTrue\nTrue\nTrue\nTrue\n"
    );
}

#[test]
fn poses_in_metres_and_millimetres_lie_in_the_part_s_frame() {
    let folder = tempfile::tempdir().unwrap();
    let line = |unit: f64| {
        (0..20).fold(String::new(), |mut text, k| {
            writeln!(text, "{} 0 0 0 0 0", f64::from(k) * 0.005 * unit).unwrap();
            text
        })
    };
    std::fs::write(folder.path().join("m.txt"), line(1.0)).unwrap();
    std::fs::write(folder.path().join("mm.txt"), line(1000.0)).unwrap();
    let out = printed(
        folder.path(),
        r#"
def p():
    # the part's frame is where the tool stands now, turned so that its x axis is the base's y axis
    part = get_target_tcp_pose()
    m = load_micro_line_file("m", 50, 1, 0)
    mm = load_micro_line_file("mm", 50, 1, 1)
    for index in [m, mm]:
        micro_line_set_pcs(index, part)
        movel(part)
        moveml(index)
        goal = pose_trans(part, [0.095, 0, 0, 0, 0, 0])
        print(point_dist(get_target_tcp_pose(), goal) < 1e-9)
        print(point_dist(get_micro_line_values_by_index(index, 1, 20), [0.095, 0, 0, 0, 0, 0]) < 1e-9)
        joints = get_micro_line_values_by_index(index, 0, 20)
        print(point_dist(get_forward_kin(joints), goal) < 1e-9)
    end
end
"#,
        &[],
    );
    assert_eq!(out, "True\n".repeat(6));
}

/// A swing of joint 1 by 0.3 rad in `seconds`, a point every `interval` ms, with so many decimals.
fn swing(seconds: f64, interval: f64, decimals: usize) -> String {
    let last = seconds * 1000.0 / interval;
    (0..=last as usize).fold(String::new(), |mut text, k| {
        let turn = k as f64 / last * core::f64::consts::TAU;
        let first = 0.15 * (1.0 - turn.cos());
        writeln!(
            text,
            "{first:.decimals$}, -1.5708, 1.5708, -1.5708, -1.5708, 0"
        )
        .unwrap();
        text
    })
}

#[test]
fn a_rounded_list_takes_the_time_of_the_exact_one_within_its_rounding() {
    let folder = tempfile::tempdir().unwrap();
    for (interval, seconds) in [(4.0, 2.0), (2.0, 1.5), (8.0, 2.0)] {
        for decimals in [3, 4, 5, 16] {
            let name = format!("swing_{interval}_{decimals}.txt");
            std::fs::write(folder.path().join(name), swing(seconds, interval, decimals)).unwrap();
        }
    }
    let out = printed(
        folder.path(),
        r#"
def p():
    movej([0, -1.5708, 1.5708, -1.5708, -1.5708, 0])
    for interval, seconds in [(4, 2.0), (2, 1.5), (8, 2.0)]:
        times = []
        for decimals in [16, 3, 4, 5]:
            n = load_micro_line_file("swing_" + str(interval) + "_" + str(decimals), interval)
            start = controller_timestamp()
            moveml(n)
            times.append(controller_timestamp() - start)
        end
        near = [abs(t - times[0]) < 0.02 * seconds for t in times[2:]]
        print(near == [True, True], times[1] < 1.1 * times[0], times[0] < 1.1 * seconds + 0.1)
    end
end
"#,
        &[],
    );
    assert_eq!(out, "True True True\nTrue True True\nTrue True True\n");
}

#[test]
fn what_cannot_be_loaded_or_run_says_so_and_the_arm_stays() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("good.txt"), wave(1.0)).unwrap();
    std::fs::write(folder.path().join("five.txt"), "0 0 0 0 0\n").unwrap();
    std::fs::write(folder.path().join("word.txt"), "0 0 0 0 0 nought\n").unwrap();
    std::fs::write(folder.path().join("nan.txt"), "0 0 0 0 0 nan\n").unwrap();
    std::fs::write(folder.path().join("empty.txt"), "# nothing\n").unwrap();
    std::fs::write(
        folder.path().join("far.txt"),
        "0.4 0 0.4 0 0 0\n9 9 9 0 0 0\n",
    )
    .unwrap();
    std::fs::write(folder.path().join("binary.txt"), [0xff_u8, 0xfe, 0, 1]).unwrap();
    let out = printed(
        folder.path(),
        r#"
def attempt(work):
    try:
        work()
        print("went")
    except Exception as e:
        print(type(e).__name__ + ": " + str(e))
    end
end
def p():
    q = get_target_joint_positions()
    for name in ["five", "word", "nan", "empty", "binary", "missing", "../good", "/etc/passwd", ""]:
        attempt(lambda: load_micro_line_file(name, 10))
    end
    attempt(lambda: load_micro_line_file("good", 0))
    attempt(lambda: load_micro_line_file("good", 10, 2))
    attempt(lambda: load_micro_line_file("good", 10, 0, 7))
    good = load_micro_line_file("good", 10)
    attempt(lambda: moveml(good + 100))
    attempt(lambda: moveml(good, 51))
    attempt(lambda: moveml(good, 20, 10))
    attempt(lambda: moveml(good, -1))
    attempt(lambda: get_micro_line_values_by_index(good, 0, 0))
    attempt(lambda: get_micro_line_values_by_index(good, 3, 1))
    attempt(lambda: micro_line_set_pcs(good, [0, 0, 0]))
    far = load_micro_line_file("far", 10, 1)
    attempt(lambda: moveml(far))
    print(q == get_target_joint_positions())
end
p()
"#,
        &[],
    );
    insta::assert_snapshot!(out);
}

#[test]
fn a_recording_of_moveml_runs_again_without_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rad.txt");
    std::fs::write(&file, wave(1.0)).unwrap();
    printed(
        folder.path(),
        "def p():\n    moveml(load_micro_line_file(\"rad\", 20))\nend\n",
        &["--record", "run.mcap"],
    );
    std::fs::remove_file(file).unwrap();
    let output = eliteserver()
        .args(["replay", "run.mcap", "--rerun"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.starts_with("identical: "), "{said}");
}
