//! The motions of manual 3.1: which command each call becomes.

mod common;

use common::{Standing, run};
use elite_runtime::TaskEnd;
use kinematics::{JointPositions, RpyPose};
use motion_api::CommandKind;

const A: RpyPose = RpyPose {
    xyz: [0.4, -0.2, 0.3],
    rpy: [3.0, 0.1, 0.2],
};
const B: RpyPose = RpyPose {
    xyz: [0.4, 0.1, 0.3],
    rpy: [3.0, 0.1, 0.2],
};

fn motions(commands: Vec<CommandKind>) -> Vec<CommandKind> {
    commands
        .into_iter()
        .filter(CommandKind::is_motion)
        .collect()
}

/// The motions of a line after `a` and `b` are set.
fn commands(line: &str) -> Vec<CommandKind> {
    let poses = "a = [0.4, -0.2, 0.3, 3.0, 0.1, 0.2]\nb = [0.4, 0.1, 0.3, 3.0, 0.1, 0.2]\n";
    let ran = run(&Standing::default(), &format!("{poses}{line}\n"));
    assert_eq!(ran.end, TaskEnd::Finished, "{line}: {}", ran.error);
    motions(ran.commands)
}

#[test]
fn a_blend_radius_reaches_the_arm() {
    let target = JointPositions([0.0, -1.5, 1.5, -1.5, -1.5, 0.0]);
    let joint = CommandKind::MoveJ {
        target,
        acceleration: 2.0,
        speed: 0.5,
        duration: 0.0,
        radius: 0.05,
    };
    let line = "movej([0, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=0.5, r=0.05)";
    assert_eq!(commands(line), [joint]);
    let cartesian = CommandKind::MoveL {
        target: A,
        acceleration: 1.2,
        speed: 0.25,
        duration: 3.0,
        radius: 0.02,
    };
    assert_eq!(commands("movel(a, t=3, r=0.02)"), [cartesian]);
}

#[test]
fn movec_takes_two_poses_and_a_mode() {
    let arc = |speed, radius, fixed| CommandKind::MoveC {
        via: A,
        target: B,
        acceleration: 1.2,
        speed,
        radius,
        fixed,
    };
    assert_eq!(commands("movec(a, b)"), [arc(0.25, 0.0, true)]);
    assert_eq!(
        commands("movec(a, pose_to=b, v=0.1, r=0.03, mode=1)"),
        [arc(0.1, 0.03, false)]
    );
    assert_eq!(
        commands("movec(a, b, 1.2, 0.25, 0, 7)"),
        [arc(0.25, 0.0, false)]
    );
}

#[test]
fn a_negative_radius_is_a_value_error() {
    for call in [
        "movej([0] * 6, r=-0.1)",
        "movel(a, r=-0.1)",
        "movec(a, a, r=-0.1)",
    ] {
        let ran = run(
            &Standing::default(),
            &format!("a = [0.4, 0, 0.3, 3, 0, 0]\n{call}\n"),
        );
        assert!(ran.error.starts_with("ValueError"), "{call}: {}", ran.error);
        assert!(motions(ran.commands).is_empty());
    }
}
