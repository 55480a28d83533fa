//! A thread that is stopped, or ends, takes its motion with it; whatever follows from another thread waits for the
//! braking.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::common;

use common::{program, started};
use controller::ControllerConfig;

/// What a program prints; an exception at its end is printed as well.
fn printed(text: &str) -> String {
    let (controller, prints) = started(&ControllerConfig::default());
    let lines: String = text.lines().map(|line| format!("  {line}\n")).collect();
    let caught = format!("try:\n{lines}except Exception as error:\n  print(error)\nend\n");
    let end = controller.run_to_end(program(&caught), "a test", std::future::pending());
    assert!(end.unwrap().is_some());
    assert!(controller.shut_down());
    let printed = prints.0.lock();
    printed.clone()
}

/// What a thread does when it is stopped half a second later.
const MOTIONS: [&str; 6] = [
    "movej([1.2, -1.57, 1.57, -1.57, -1.57, 0], t=10)",
    "movej([1.2, -1.57, 1.57, -1.57, -1.57, 0], a=8, v=2, r=0.05)",
    "movel(pose_add(get_target_tcp_pose(), [0, 0.2, 0, 0, 0, 0]), a=0.3, v=0.1)",
    "speedj([0.5, 0, 0, 0, 0, 0], 0.5)\n  sleep(10)",
    "speedl([0, 0.1, 0, 0, 0, 0], 0.5)\n  sleep(10)",
    "servoj([0.8, -1.57, 1.57, -1.57, -1.57, 0], t=5)",
];

/// What comes at once from the thread that has stopped it.
const NEXT: [&str; 7] = [
    "movej([-0.3, -1.57, 1.57, -1.57, -1.57, 0])",
    "movel(pose_add(get_target_tcp_pose(), [0, -0.03, 0, 0, 0, 0]))",
    "speedj([0, 0, 0, 0, 0, 0.5], 1, 0.3)",
    "speedl([0, 0, 0.02, 0, 0, 0], 0.5, 0.3)",
    "servoj(get_target_joint_positions(), t=0.1)",
    "stopj(2)",
    "freedrive_mode()\nsleep(0.3)\nend_freedrive_mode()",
];

#[test]
fn any_motion_may_follow_a_thread_that_was_stopped() {
    let mut wrong = Vec::new();
    for motion in MOTIONS {
        for next in NEXT {
            for join in ["", "join_thread(h)\n"] {
                let text = format!(
                    "movej([0, -1.57, 1.57, -1.57, -1.57, 0])
def moves():
  {motion}
end
h = start_thread(moves, ())
sleep(0.5)
stop_thread(h)
{join}{next}
print('done')
"
                );
                let printed = printed(&text);
                if printed != "done\n" {
                    wrong.push(format!("{motion}; {next}; {join}: {printed}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn speeds_and_streams_end_with_the_thread_that_asked_for_them() {
    for (motion, ending) in [
        ("speedj([0.5, 0, 0, 0, 0, 0], 0.5)", ""),
        ("speedl([0, 0.1, 0, 0, 0, 0], 0.5)", ""),
        ("speedj([0.5, 0, 0, 0, 0, 0], 0.5)", "stop_thread(h)\n"),
    ] {
        let text = format!(
            "movej([0, -1.57, 1.57, -1.57, -1.57, 0])
def moves():
  {motion}
end
h = start_thread(moves, ())
sleep(0.4)
{ending}join_thread(h)
sleep(1.5)
print(max(abs(v) for v in get_target_joint_speeds()))
"
        );
        assert_eq!(printed(&text), "0.0\n", "{motion} {ending}");
    }
}
