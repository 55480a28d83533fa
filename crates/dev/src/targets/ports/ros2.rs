//! The link to the node's process, and the trajectories that come over it.

use ros2::link::{ControllerMessage, NodeMessage, frame, value};
use ros2::messages::{Duration, JointTrajectoryPoint, TrajectoryGoal};
use ros2::names::JOINTS;
use ros2::trajectory::{ArmStart, Tolerances, TrajectoryLimits, check, sample};

const LIMITS: TrajectoryLimits = TrajectoryLimits {
    positions: [(-6.3, 6.3); 6],
    speeds: [3.2; 6],
};
const START: ArmStart = ArmStart {
    position: [0.0; 6],
    speed: [0.1; 6],
    accelerations: [20.0; 6],
};

/// Whatever bytes come are a message or an error; a trajectory is refused, or leads through numbers within the limits.
pub(super) fn judge(data: &[u8]) {
    let _ = value::<ControllerMessage>(data);
    let Ok(NodeMessage::Goal { goal, .. }) = value::<NodeMessage>(data) else {
        return;
    };
    let _ = Tolerances::of(&goal, "");
    let Ok(checked) = check(&goal.trajectory, "", &LIMITS) else {
        return;
    };
    if let Ok(sampled) = sample(&checked, &START, &LIMITS, 0.004) {
        assert!(sampled.positions.len() <= 100_000);
        for position in sampled.positions.iter().flatten() {
            assert!(position.abs() <= 6.31, "{position}");
        }
    }
}

/// Goals that are right, as the node sends them.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let point = |at: f64, by: f64, speeds: bool| JointTrajectoryPoint {
        positions: vec![by; 6],
        velocities: if speeds { vec![0.0; 6] } else { vec![] },
        time_from_start: Duration::from_secs(at),
        ..JointTrajectoryPoint::default()
    };
    let goal = |speeds| {
        let mut goal = TrajectoryGoal::default();
        goal.trajectory.joint_names = JOINTS.map(str::to_owned).into();
        goal.trajectory.points = vec![point(1.0, 0.2, speeds), point(2.5, -0.1, speeds)];
        NodeMessage::Goal { id: [7; 16], goal }
    };
    let messages = [
        goal(false),
        goal(true),
        NodeMessage::Cancel { ids: vec![[1; 16]] },
        NodeMessage::Ready { version: 1 },
    ];
    let frames = messages.iter().filter_map(|message| frame(message).ok());
    frames.map(|frame| frame[4..].to_vec()).collect()
}
