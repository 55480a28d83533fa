//! The motions of manual 3.1: which command each call becomes.

use crate::common;

use common::{Standing, run};
use elite_runtime::TaskEnd;
use kinematics::{JointPositions, RpyPose};
use motion_api::{CommandKind, MotionCommand, OverlayCommand};

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
    let joint = CommandKind::Motion(MotionCommand::MoveJ {
        target,
        acceleration: 2.0,
        speed: 0.5,
        duration: 0.0,
        radius: 0.05,
    });
    let line = "movej([0, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=0.5, r=0.05)";
    assert_eq!(commands(line), [joint]);
    let cartesian = CommandKind::Motion(MotionCommand::MoveL {
        target: A,
        acceleration: 1.2,
        speed: 0.25,
        duration: 3.0,
        radius: 0.02,
    });
    assert_eq!(commands("movel(a, t=3, r=0.02)"), [cartesian]);
}

#[test]
fn movec_takes_two_poses_and_a_mode() {
    let arc = |speed, radius, fixed| {
        CommandKind::Motion(MotionCommand::MoveC {
            via: A,
            target: B,
            acceleration: 1.2,
            speed,
            radius,
            fixed,
        })
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

#[test]
fn movep_has_four_arguments_with_defaults() {
    let process = |acceleration, speed, radius| {
        CommandKind::Motion(MotionCommand::MoveP {
            target: A,
            acceleration,
            speed,
            radius,
        })
    };
    assert_eq!(commands("movep(a)"), [process(1.2, 0.25, 0.0)]);
    assert_eq!(
        commands("movep(a,0.351, 0.0195, 0.0005)"),
        [process(0.351, 0.0195, 0.0005)]
    );
}

#[test]
fn path_offsets_become_commands_and_wrong_ones_exceptions() {
    let text = "path_offset_set_max_offset(0.02, 0.1)\npath_offset_set_alpha_filter(0.3)\n\
                path_offset_enable()\npath_offset_set([0, 0, 0.005, 0, 0, 0], 3)\npath_offset_disable()\n";
    let ran = run(&Standing::default(), text);
    assert_eq!(ran.end, TaskEnd::Finished, "{}", ran.error);
    let wanted = [
        CommandKind::Overlay(OverlayCommand::PathOffsetMax {
            translation: 0.02,
            rotation: 0.1,
        }),
        CommandKind::Overlay(OverlayCommand::PathOffsetFilter(0.3)),
        CommandKind::Overlay(OverlayCommand::PathOffsetEnable),
        CommandKind::Overlay(OverlayCommand::PathOffsetSet {
            offset: RpyPose::from_array([0.0, 0.0, 0.005, 0.0, 0.0, 0.0]),
            axes: motion_api::OffsetAxes::Motion,
        }),
        CommandKind::Overlay(OverlayCommand::PathOffsetDisable { acceleration: 20.0 }),
    ];
    let sent: Vec<_> = ran
        .commands
        .into_iter()
        .filter(|kind| kind.name().starts_with("path_offset"))
        .collect();
    assert_eq!(sent, wanted);
    for wrong in [
        "path_offset_set([0, 0, 0, 0, 0], 1)",
        "path_offset_set([0, 0, 0, 0, 0, 0], 4)",
        "path_offset_set([0, 0, 50, 0, 0, 0], 1)",
        "path_offset_set_alpha_filter(1.5)",
        "path_offset_set_max_offset(-1, 0)",
        "path_offset_get(0)",
        "path_offset_disable(0)",
    ] {
        let ran = run(&Standing::default(), &format!("{wrong}\n"));
        assert!(ran.error.contains("Error"), "{wrong}: {}", ran.error);
        assert!(ran.error.contains("path_offset"), "{wrong}: {}", ran.error);
    }
}
