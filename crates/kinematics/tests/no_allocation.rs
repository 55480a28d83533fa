//! Nothing a control cycle calls touches the heap.

use assert_no_alloc::{AllocDisabler, assert_no_alloc, violation_count};
use kinematics::{
    GRAVITY_UPRIGHT, JointAccelerations, JointPositions, JointSpeeds, Payload, PlaneMode,
    PlaneSwitches, Pose, RobotModel, SafetyBounds, SafetyPlane,
};
use std::hint::black_box;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn the_calls_of_a_control_cycle_do_not_allocate() {
    let arm = RobotModel::built_in("cs66").unwrap();
    let iterated =
        include_str!("../../../robots/cs66/cs66.urdf").replace("-0.427 0 0", "-0.428 0.0004 0");
    let iterated = RobotModel::from_urdf(&iterated).unwrap();
    let tcp = Pose::from_translation(0.0, 0.02, 0.1);
    let (qd, qdd) = (JointSpeeds([0.3; 6]), JointAccelerations([1.0; 6]));
    let payload = Payload::new(2.0, [0.0, 0.0, 0.05], [0.0; 6]).unwrap();
    let plane = SafetyPlane::new([0.0, 0.0, 0.2], [0.0, 0.0, 1.0], PlaneMode::Both, None).unwrap();
    let bounds = SafetyBounds::default().with_plane(plane).unwrap();
    let switches = PlaneSwitches::default();
    assert_no_alloc(|| {
        for step in 0..200 {
            let q = JointPositions(
                [0.3, -1.2, 1.9, -0.7, 1.5, 0.2].map(|x| x + 0.003 * f64::from(step)),
            );
            let pose = arm.tcp_pose(&q, &tcp);
            black_box(arm.inverse_all(&pose, &tcp));
            black_box(arm.inverse_nearest(&pose, &tcp, &q));
            black_box(iterated.inverse_nearest(&pose, &tcp, &q));
            black_box(iterated.inverse_all(&pose, &tcp));
            // Where axes 4 and 6 are parallel and the arm is straight, it is looked for around.
            let singular = JointPositions([0.1, -1.0, 1e-5 * f64::from(step), 0.4, 1e-6, 0.2]);
            black_box(iterated.inverse_all(&iterated.tcp_pose(&singular, &tcp), &tcp));
            black_box(bounds.violation_at_pose(&arm, &pose, &tcp, &q, &switches));
            let frames = arm.forward(&q);
            black_box(frames.jacobian(pose.translation));
            black_box(frames.jacobian_rate_times_speeds(&qd, pose.translation));
            black_box(arm.collision().self_distance(&frames));
            let dynamics = arm.dynamics(&payload, GRAVITY_UPRIGHT);
            let tau = dynamics.inverse_dynamics(&q, &qd, &qdd);
            black_box(dynamics.mass_matrix(&q));
            black_box(dynamics.forward_dynamics(&q, &qd, &tau));
            black_box(pose.to_rpy());
        }
    });
    assert_eq!(violation_count(), 0);
}
