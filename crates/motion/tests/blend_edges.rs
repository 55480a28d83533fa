//! Blends at their edges: legs of no length, turns back, and radii of motions that go nowhere. Ordinary ones:
//! blends.rs.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::{Bench, ideal, moved};
use kinematics::RpyPose;
use motion_api::{CommandKind, MotionCommand, Outcome, Warning};
use nalgebra::Vector3;

fn line(target: RpyPose, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: 1.2,
        speed: 0.25,
        duration: 0.0,
        radius,
    })
}

fn away(bench: &Bench, pose: &RpyPose) -> f64 {
    (Vector3::from(bench.now().target_tcp_pose.xyz) - Vector3::from(pose.xyz)).norm()
}

/// Sends each when the one before has ended; all must get to their ends.
fn chain(bench: &mut Bench, kinds: &[CommandKind]) {
    for kind in kinds {
        assert_eq!(bench.do_it(*kind), Outcome::Done, "{kind:?}");
    }
    bench.check_limits();
}

fn is_not_blended(bench: &Bench) -> bool {
    let mut warnings = bench.warnings.iter();
    warnings.any(|(_, warning)| matches!(warning, Warning::NotBlended))
}

#[test]
fn a_next_leg_of_no_length_stops_at_the_corner_and_says_so() {
    let mut bench = Bench::new(ideal("cs66"));
    let corner = moved(&bench.now().target_tcp_pose, [0.0, 0.2, 0.0]);
    chain(&mut bench, &[line(corner, 0.05), line(corner, 0.0)]);
    assert!(away(&bench, &corner) < 1e-9, "{}", away(&bench, &corner));
    assert!(bench.cycle.is_standing());
    let end = moved(&corner, [-0.1, 0.0, 0.0]);
    chain(&mut bench, &[line(end, 0.0)]);
    assert!(away(&bench, &end) < 1e-9);
}

#[test]
fn a_leg_of_no_length_with_a_radius_lets_the_next_one_begin_where_the_arm_stands() {
    let mut bench = Bench::new(ideal("cs66"));
    let here = bench.now().target_tcp_pose;
    let end = moved(&here, [0.0, 0.15, 0.0]);
    chain(&mut bench, &[line(here, 0.05), line(end, 0.0)]);
    assert!(away(&bench, &end) < 1e-9);
}

#[test]
fn legs_of_no_length_between_two_others_lose_no_way() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    let corner = moved(&start, [0.0, 0.2, 0.0]);
    let end = moved(&corner, [-0.2, 0.0, 0.0]);
    chain(
        &mut bench,
        &[
            line(corner, 0.05),
            line(corner, 0.05),
            line(corner, 0.05),
            line(end, 0.0),
        ],
    );
    assert!(away(&bench, &end) < 1e-9);
    // Nothing but the two lines and the corner between them was seen.
    for state in &bench.states {
        let at = Vector3::from(state.target_tcp_pose.xyz) - Vector3::from(start.xyz);
        assert!(
            at.x < 1e-9 && at.y < 0.2 + 1e-9 && at.z.abs() < 1e-9,
            "{at:?}"
        );
    }
}

#[test]
fn a_turn_straight_back_keeps_inside_the_radius_and_ends_exactly() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    let corner = moved(&start, [0.0, 0.2, 0.0]);
    chain(&mut bench, &[line(corner, 0.04), line(start, 0.0)]);
    assert!(away(&bench, &start) < 1e-9);
    for state in &bench.states {
        let at = Vector3::from(state.target_tcp_pose.xyz) - Vector3::from(start.xyz);
        // Inside the radius the joints make the way; outside of it the line is kept.
        let allowed = if at.y > 0.16 - 1e-9 { 1e-3 } else { 1e-9 };
        assert!(at.y < 0.2 + 1e-9 && at.x.hypot(at.z) < allowed, "{at:?}");
    }
    let farthest = bench
        .states
        .iter()
        .map(|s| s.target_tcp_pose.xyz[1] - start.xyz[1])
        .fold(0.0, f64::max);
    // Blended, it turns inside the zone; stopped, at the corner, and says so.
    assert!(farthest > 0.16 - 1e-9, "{farthest}");
    assert_eq!(is_not_blended(&bench), farthest > 0.2 - 1e-9, "{farthest}");
}
