//! The arm among the obstacles of a cell file, as scripts of the real binary under the virtual clock.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

use crate::common::run_in_cell;
use kinematics::{Pose, RobotModel};

/// What the script printed, what it said, and the exit status.
fn run(text: &str, cell: &str, options: &[&str]) -> (String, String, Option<i32>) {
    let options = [&["--tcp", "0,0,0.1,0,0,0"], options].concat();
    run_in_cell(text, cell, &options)
}

/// The TCP at home with the tool of these tests, m.
fn tcp_at_home() -> [f64; 3] {
    let model = RobotModel::built_in("cs66").unwrap();
    let home = recorder::Setup::default().home;
    let tcp = Pose::from_translation(0.0, 0.0, 0.1);
    model.tcp_pose(&home, &tcp).translation.into()
}

/// A plate whose surface is `gap` m below the TCP at home, with more keys.
fn plate(gap: f64, keys: &str) -> String {
    let [x, y, z] = tcp_at_home();
    let middle = z - gap - 0.05;
    format!(
        "[[obstacle]]\nname = \"plate\"\nshape = \"box\"\nsize = [0.4, 0.4, 0.1]\n\
         pose = [{x}, {y}, {middle}, 0, 0, 0]\n{keys}\n"
    )
}

const PRESS: &str = r#"
def press():
    print(get_tcp_force(True) == [0,0,0,0,0,0], force() == 0)
    p = get_target_tcp_pose()
    p[2] = p[2] - 0.012
    movel(p, v=0.02)
    sleep(0.5)
    depth = DEPTH
    w = get_tcp_force(True)
    print(abs(w[2] / (-1e4 * depth) - 1) < 1e-3, abs(force() + w[2]) < 1e-3)
    print(depth > 0.0015, abs(w[0]) < 0.01 and abs(w[1]) < 0.01)
    raw = get_tcp_force(False)
    print(abs(raw[2] - w[2] - 9.81 * 1.5) < 1e-2)
    zero_ftsensor()
    print(force() < 1e-6, abs(get_tcp_force(False)[2] - raw[2]) < 1e-3)
    p[2] = p[2] + 0.012
    movel(p)
    sleep(0.2)
    print(abs(get_tcp_force(True)[2] + w[2]) < 1e-3)
end
"#;

#[test]
fn a_script_presses_a_plate_and_reads_stiffness_times_depth() {
    let text = PRESS.replace(
        "DEPTH",
        &format!("{} - get_actual_tcp_pose()[2]", tcp_at_home()[2] - 0.01),
    );
    let cell = plate(0.01, "stiffness = 1e4");
    for plant in ["rigid", "ideal"] {
        let options = ["--plant", plant, "--payload", "1.5,0,0,0.05"];
        let (out, err, status) = run(&text, &cell, &options);
        assert_eq!(status, Some(0), "{plant}: {err}");
        assert_eq!(
            out, "True True\nTrue True\nTrue True\nTrue\nTrue True\nTrue\n",
            "{plant}: {err}"
        );
    }
}

#[test]
fn a_hit_ends_the_program_and_names_joint_and_force() {
    for (keys, sensitivity) in [("stiffness = 1e5", 50), ("", 50), ("", 100)] {
        let script = format!(
            "def p():\n    set_dyn_collision_force_min_ratio({sensitivity})\n    try:\n\
             \x20       p = get_target_tcp_pose()\n        p[2] = p[2] - 0.2\n        movel(p, v=0.25)\n    except:\n\
             \x20       print(\"caught\")\n    end\nend\n"
        );
        let (out, err, status) = run(&script, &plate(0.1, keys), &[]);
        assert_eq!((out.as_str(), status), ("", Some(1)), "{err}");
        assert!(err.contains("collision at joint "), "{err}");
        assert!(err.contains(" N at the TCP makes"), "{err}");
    }
}

#[test]
fn the_force_limit_of_the_cell_stops_a_slow_press() {
    let script = "def p():\n    p = get_target_tcp_pose()\n    p[2] = p[2] - 0.03\n    movel(p, v=0.02)\nend\n";
    let cell = format!(
        "{}[limits]\ntcp_force = 30\n",
        plate(0.01, "stiffness = 5e3")
    );
    let (_, err, status) = run(script, &cell, &[]);
    assert_eq!(status, Some(1), "{err}");
    assert!(
        err.contains("the force at the TCP is 30.") && err.contains("(allowed 30.0 N)"),
        "{err}"
    );
}

#[test]
fn bad_cells_end_with_status_2_and_name_the_key() {
    for (cell, wanted) in [
        (plate(0.01, "stifness = 1"), "stifness"),
        (
            plate(0.01, "stiffness = 0"),
            "obstacle \"plate\" has stiffness = 0",
        ),
        (
            plate(0.01, "friction = -1"),
            "obstacle \"plate\" has friction = -1",
        ),
        (
            "[tool]\nshape = \"plane\"\npose = [0,0,0,0,0,0]\n".to_owned(),
            "tool has shape",
        ),
        (
            "[sensor]\nforce_noise = -1\n".to_owned(),
            "sensor has force_noise = -1",
        ),
        ("[limits]\ntcp_force = 0\n".to_owned(), "tcp_force"),
    ] {
        let (_, err, status) = run("print(1)\n", &cell, &[]);
        assert_eq!(status, Some(2), "{cell}: {err}");
        assert!(err.contains(wanted), "{cell}: {err}");
        assert_eq!(err.trim_end().lines().count(), 1, "{err}");
    }
}

#[test]
fn arguments_of_the_sensor_functions_are_checked() {
    let script = r#"
def p():
    def refused(call):
        try:
            call()
        except (TypeError, ValueError) as e:
            print(e)
        end
    end
    refused(lambda: get_tcp_force("yes"))
    refused(lambda: ft_rtsi_input_enable(True, -1))
    refused(lambda: ft_rtsi_input_enable(True, 1, [0, 0]))
    refused(lambda: ft_rtsi_input_enable(True, sensor_cog=[0, 0, 20]))
    ft_rtsi_input_enable(True, sensor_mass=0.0, sensor_measuring_offset=[0.0,0.0,0.0], sensor_cog=[0.0,0.0,0.0])
    ft_rtsi_input_enable(False)
end
"#;
    let (out, err, status) = run(script, "", &[]);
    assert_eq!(status, Some(0), "{err}");
    insta::assert_snapshot!(out);
}
