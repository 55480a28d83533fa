//! Manual chapter 4 as scripts of the real binary in cells with plates, under the virtual clock.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

mod common;

use common::run_in_cell;

/// A level plate of 20 N/mm, 20 mm below the TCP of the home position with the tool of these tests.
const PLATE: &str = "[[obstacle]]\nname = \"plate\"\nshape = \"plane\"\npose = [0, 0, SURFACE, 0, 0, 0]\nstiffness = 2e4\n";

/// What the script printed, what it said, and the exit status.
fn run(text: &str, cell: &str) -> (String, String, Option<i32>) {
    let model = kinematics::RobotModel::built_in("cs66").unwrap();
    let home = recorder::Setup::default().home;
    let tool = kinematics::Pose::from_translation(0.0, 0.0, 0.15);
    let surface = model.tcp_pose(&home, &tool).translation.z - 0.02;
    let cell = cell.replace("SURFACE", &surface.to_string());
    run_in_cell(text, &cell, &["--tcp", "0,0,0.15,0,0,0"])
}

fn printed(text: &str, cell: &str) -> String {
    let (out, err, status) = run(text, cell);
    assert_eq!(status, Some(0), "{err}");
    out
}

#[test]
fn a_plate_is_pressed_with_the_wanted_force_and_read_with_the_signs_of_the_manual() {
    let out = printed(
        r#"
def p():
    p0 = get_actual_tcp_pose()
    force_mode([0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,-27,0,0,0], 0, [0,0,0.1,0,0,0])
    sleep(4)
    f = get_tcp_force(True)
    print(abs(force() - 27) < 0.27, abs(f[2] + 27) < 0.27, abs(f[0]) < 0.1)
    p1 = get_actual_tcp_pose()
    print(abs(p0[2] - p1[2] - 0.02 - 27 / 20000) < 2e-5, abs(p1[0] - p0[0]) < 5e-4)
    end_force_mode()
    end_force_mode()
    sleep(0.1)
    print(norm(get_target_joint_speeds()) == 0)
end
"#,
        PLATE,
    );
    // The tool points down: what pushes it up is along -z of the TCP.
    assert_eq!(out, "True True True\nTrue True\nTrue\n");
}

#[test]
fn a_line_goes_on_while_the_tool_presses_and_the_end_of_the_program_ends_it() {
    let out = printed(
        r#"
def p():
    force_mode_set_gain_scaling(0.3)
    force_mode_set_damping(0.1)
    force_mode([0,0,0,0,0,0], (0,0,1.0,0,0,0), [0,0,-20,0,0,0], 0, [0,0,0.1,0,0,0])
    sleep(4)
    target = get_actual_tcp_pose()
    target[1] = target[1] + 0.1
    movel(target, a=0.5, v=0.05)
    end = get_actual_tcp_pose()
    print(abs(end[1] - target[1]) < 5e-4, abs(force() - 20) < 1)
end
"#,
        PLATE,
    );
    assert_eq!(out, "True True\n");
}

#[test]
fn bad_arguments_are_value_errors_that_name_the_argument() {
    let good = [
        "[0,0,0,0,0,0]",
        "[0,0,1,0,0,0]",
        "[0,0,-5,0,0,0]",
        "0",
        "[0,0,0.1,0,0,0]",
    ];
    for (place, bad, names) in [
        (0, "[0,0,0,0,0]", "reference_frame"),
        (0, "[0,0,float('nan'),0,0,0]", "reference_frame"),
        (1, "[1,1,1]", "selection_vector"),
        (2, "[0,0,float('inf'),0,0,0]", "target_wrench"),
        (2, "[0,0,1e9,0,0,0]", "target_wrench"),
        (3, "4", "mode"),
        (3, "-1", "mode"),
        (4, "[0,0,-0.1,0,0,0]", "speed_limits"),
        (4, "[0,0]", "speed_limits"),
    ] {
        let mut arguments = good;
        arguments[place] = bad;
        let call = format!("force_mode({})", arguments.join(", "));
        let script = format!(
            "def p():\n    try:\n        {call}\n    except ValueError as e:\n        print(str(e))\n    end\nend\n"
        );
        let out = printed(&script, "");
        assert!(
            out.starts_with("force_mode()") && out.contains(names),
            "{call}: {out}"
        );
    }
}

#[test]
fn gain_and_damping_outside_their_ranges_are_clamped_with_a_warning() {
    let (out, err, status) = run(
        "def p():\n    force_mode_set_gain_scaling(scoring=3)\n    force_mode_set_damping(-1)\n    print('on')\nend\n",
        "",
    );
    assert_eq!((out.as_str(), status), ("on\n", Some(0)));
    assert!(err.contains("allowed are 0 to 2; 2 is used"), "{err}");
    assert!(err.contains("allowed are 0 to 1; 0 is used"), "{err}");
    let nan = "def p():\n    force_mode_set_damping(float('nan'))\nend\n";
    let (_, err, status) = run(nan, "");
    assert_eq!(status, Some(1));
    assert!(
        err.contains("ValueError: force_mode_set_damping(): damping"),
        "{err}"
    );
}

#[test]
fn what_force_mode_excludes_is_said() {
    let out = printed(
        r#"
def p():
    force_mode([0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,0,0,0,0], 0, [0,0,0.1,0,0,0])
    try:
        freedrive_mode()
    except RuntimeError as e:
        print(str(e))
    end
    end_force_mode()
    freedrive_mode()
    try:
        force_mode([0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,0,0,0,0], 0, [0,0,0.1,0,0,0])
    except RuntimeError:
        print("busy")
    end
end
"#,
        "",
    );
    assert_eq!(
        out,
        "freedrive_mode(): force mode is on; end it first with end_force_mode()\nbusy\n"
    );
}
