//! The motion modes of manual 3.1 beyond planned moves, as scripts of the real binary under the virtual clock.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

mod common;

use common::{printed_in_cell as printed, run_in_cell, run_script};

#[test]
fn streams_and_speeds_do_what_their_calls_say() {
    let out = printed(
        r#"
def modes():
    q = get_target_joint_positions()
    i = 0
    while i < 250:
        q[0] = q[0] + 0.001
        servoj(q, 0.004, 0.1, 300)
        i = i + 1
    end
    sleep(1)
    print(abs(get_target_joint_positions()[0] - q[0]) < 1e-9)
    speedj([0.2,0,0,0,0,0], 1.0)
    print(abs(get_target_joint_speeds()[0] - 0.2) < 1e-9)
    stopj(2.0)
    print(norm(get_target_joint_speeds()) == 0)
    p = get_target_tcp_pose()
    speedl([0,0,-0.05,0,0,0], 0.5, 1.0)
    stopl(0.5)
    w = get_target_tcp_pose()
    print(abs(w[0] - p[0]) < 1e-6 and abs(w[1] - p[1]) < 1e-6 and w[2] < p[2] - 0.04)
    stopj(1.0)
    servoj(q, lookahead_time=1, gain=99)
    speedl([0,0,0.01,0,0,0], 0.5, 0.5, aRot=0.3)
end
"#,
        "",
    );
    assert_eq!(out, "True\nTrue\nTrue\nTrue\n");
}

#[test]
fn a_blended_motion_returns_in_its_zone_and_the_last_one_at_its_target() {
    let out = printed(
        r#"
def blends():
    q = [0.3, -1.4, 1.7, -1.8, -1.5, 0.2]
    movej(q)
    p = get_target_tcp_pose()
    def at(dx, dy, dz):
        return [p[0] + dx, p[1] + dy, p[2] + dz, p[3], p[4], p[5]]
    def away(pose):
        now = get_target_tcp_pose()
        return norm([now[0] - pose[0], now[1] - pose[1], now[2] - pose[2]])
    def is_in_zone(pose, r):
        return 0.1 * r < away(pose) <= r and norm(get_target_joint_speeds()) > 0.001
    movel(at(0, 0.1, 0), r=0.05)
    set_standard_digital_out(1, True)
    print(is_in_zone(at(0, 0.1, 0), 0.05))
    movec(at(-0.05, 0.13, 0), at(-0.1, 0.1, 0), v=0.1, r=0.03)
    print(is_in_zone(at(-0.1, 0.1, 0), 0.03))
    movej(q, r=0.02)
    print(is_in_zone(p, 0.02), get_standard_digital_out(1))
    movel(at(0, 0, 0.1))
    print(away(at(0, 0, 0.1)) < 1e-9 and norm(get_target_joint_speeds()) == 0)
    movel(p, r=0.05)
    sleep(1)
    print(away(p) < 1e-9)
end
"#,
        "",
    );
    assert_eq!(out, "True\nTrue\nTrue True\nTrue\nTrue\n");
}

#[test]
fn bad_arguments_of_the_modes_are_value_errors() {
    for call in [
        "speedj([0,0,0],1,1)",
        "speedj([0,0,0,0,0,0],0,1)",
        "stopj(-1)",
        "stopl(0)",
        "servoj([0,0,0,0,0,0],0)",
        "encoder_get_tick_count(2)",
        "encoder_enable_set_tick_count(0,5)",
        "encoder_enable_pulse_decode(0,1,16,16)",
        "encoder_enable_pulse_decode(0,1,15,16)",
        "encoder_set_tick_count(0,1)",
        "set_dyn_collision_force_min_ratio(9)",
        "track_conveyor_linear([0,0,0,0,0,0],1000)",
        "track_conveyor_linear([1,0,0,0,0,0],0)",
        "freedrive_mode([1,1,1,1,1,2])",
        "freedrive_mode(frame='flange')",
        "set_gravity([0,0,1e9])",
    ] {
        let script = format!(
            "def p():\n    try:\n        {call}\n    except ValueError:\n        print('refused')\n    end\nend\n"
        );
        assert_eq!(printed(&script, ""), "refused\n", "{call}");
    }
}

#[test]
fn getters_agree_with_what_was_set() {
    let out = printed(
        r#"
def p():
    set_tcp([0, 0, 0.1, 0, 0, 0])
    set_payload(2, [0, 0, 0.05])
    print(get_tcp_offset() == [0, 0, 0.1, 0, 0, 0])
    print(get_target_payload_mass(), get_target_payload_cog())
    print(round(point_dist(get_actual_tcp_pose(), get_actual_tool_flange_pose()), 6))
    print(point_dist(get_target_waypoint(), get_target_tcp_pose()) == 0)
    print(norm(get_joint_torques()) < 1, is_collision_detect_enabled(), get_dyn_collision_force_min_ratio())
    set_collision_detect_enabled(False)
    set_dyn_collision_force_min_ratio(20)
    print(is_collision_detect_enabled(), get_dyn_collision_force_min_ratio())
    set_gravity([0, 9.82, 0])
    sleep(0.1)
    print(len(get_joint_temperatures()), get_controller_temperature() > 20)
    print(norm(get_actual_joint_speeds()) < 1e-3, norm(get_actual_tcp_speed()) < 1e-3, norm(get_target_tcp_speed()) == 0)
    encoder_enable_set_tick_count(0, 2)
    encoder_set_tick_count(0, 1234)
    print(encoder_get_tick_count(0), encoder_unwind_delta_tick_count(0, -64666))
end
"#,
        "",
    );
    let expected = "True\n2.0 [0.0, 0.0, 0.05]\n0.1\nTrue\nTrue True 50\nFalse 20\n6 True\nTrue True True\n1234.0 870.0\n";
    assert_eq!(out, expected);
}

#[test]
fn a_belt_of_the_cell_is_followed_and_the_end_of_the_program_ends_tracking() {
    let cell =
        "[[conveyor]]\nencoder = 0\ndirection = [0, 1, 0]\nspeed = 0.1\nticks_per_meter = 1000\n";
    let out = printed(
        r#"
def p():
    y = get_target_tcp_pose()[1]
    t = encoder_get_tick_count(0)
    track_conveyor_linear([0,1,0,0,0,0], 1000.0)
    sleep(1.5)
    belt = (encoder_get_tick_count(0) - t) / 1000
    print(abs(get_target_tcp_pose()[1] - y - belt) < 0.002)
end
"#,
        cell,
    );
    assert_eq!(out, "True\n");
}

#[test]
fn freedrive_follows_a_load_of_the_cell() {
    let cell = "[[wrench]]\nat = 0.2\nduration = 0.5\nwrench = [0, 20, 0, 0, 0, 0]\n";
    let out = printed(
        r#"
def p():
    p0 = get_actual_tcp_pose()
    freedrive_mode(freeAxes=[0,1,0,0,0,0], frame="base")
    sleep(1.2)
    end_freedrive_mode()
    end_freedrive_mode()
    p1 = get_actual_tcp_pose()
    print(p1[1] - p0[1] > 0.03, abs(p1[0] - p0[0]) < 1e-4, abs(p1[2] - p0[2]) < 1e-4)
end
"#,
        cell,
    );
    assert_eq!(out, "True True True\n");
}

#[test]
fn a_safety_plane_refuses_targets_and_agrees_with_the_check() {
    let cell = "[[safety_plane]]\nname = \"table\"\npoint = [0, 0, 0.3]\nnormal = [0, 0, 1]\n";
    let script = r#"
def p():
    p = get_target_tcp_pose()
    print(is_within_safety_limits(p))
    p[2] = 0.25
    print(is_within_safety_limits(p))
    try:
        movel(p)
    except RuntimeError as e:
        print(e)
    end
    speedl([0,0,-0.2,0,0,0], 1.0, 3.0)
end
"#;
    let (out, err, status) = run_in_cell(script, cell, &[]);
    assert_eq!(status, Some(1), "{err}");
    assert_eq!(
        out,
        "True\nFalse\nmovel(): the target lies 0.0500 m behind safety plane 1 of the cell\n"
    );
    assert!(err.contains("safety plane 1"), "{err}");
}

#[test]
fn motion_from_two_threads_is_refused() {
    let out = printed(
        r#"
def p():
    def other():
        try:
            speedj([0,0,0,0,0,0.1], 1, 0.1)
        except RuntimeError as e:
            print("refused")
        end
    end
    t = start_thread(other, ())
    q = get_target_joint_positions()
    q[0] = q[0] + 0.5
    movej(q)
    join_thread(t)
end
"#,
        "",
    );
    assert_eq!(out, "refused\n");
}

#[test]
fn a_run_ends_at_the_waypoint_of_its_last_motion_however_slowly_that_goes() {
    let folder = tempfile::tempdir().unwrap();
    let script = "def slow():\n    p = get_target_tcp_pose()\n    p[1] = p[1] + 0.08\n    movel(p, v=0.006, r=0.05)\n    print(p[1])\nend\n";
    let output = run_script(folder.path(), script, &["--record", "slow.mcap"]);
    assert_eq!(output.status.code(), Some(0));
    let wanted: f64 = String::from_utf8(output.stdout)
        .unwrap()
        .trim()
        .parse()
        .unwrap();
    let recording = common::read_recording(&folder.path().join("slow.mcap"));
    let last = recording.cycles.last().unwrap();
    assert!(last.time > 12.0, "{}", last.time);
    assert!(
        (last.target_tcp_pose[1] - wanted).abs() < 1e-9,
        "{}",
        last.target_tcp_pose[1]
    );
    assert!(last.target_qd.iter().all(|v| *v == 0.0));
}
