//! movej: a straight line in joint space, as fast as the leading joint is asked to go and every joint is able to.

use kinematics::JointPositions;
use motion_api::{Refusal, Warning, WayUnit};

use super::torque::TorqueBounds;
use super::{MotionRequest, MotionSegment, PlanningContext, SegmentLimits, Warnings};
use crate::config::MotionLimits;
use crate::constants::{
    HARD_STOP_SHARE, JOINT_LINE_INTERVALS, LIMIT_SLACK, POINT_SPEED_MARGIN, POINT_SPEED_SAMPLES,
    TORQUE_SAMPLES, TORQUE_SHARE_OF_SPEED,
};
use crate::path::{JointLine, Path};
use crate::scalar::{IntervalLimits, ScalarLimits};
use crate::self_collision::SelfCollisionMonitor;
use crate::setpoint::elbow_speed;

/// Plans a movej (manual 3.1.1) from rest at `start` to rest at `target`.
///
/// Speed and acceleration of `wish` are those of the leading joint, rad/s and rad/s²; where another joint would exceed
/// its limits they are lowered, with a warning. A duration that is too short gives the fastest motion and a warning.
///
/// # Errors
/// A target outside a joint's range, a way on which the arm runs into itself, or a number that cannot be used.
pub fn plan_movej(
    start: &JointPositions,
    target: &JointPositions,
    wish: &MotionRequest,
    arm: &PlanningContext,
    cells: &mut SegmentLimits,
) -> Result<(MotionSegment, Warnings), Refusal> {
    wish.check()?;
    check_range(target, arm.limits)?;
    let line = JointLine::new(*start, *target);
    let mut watch = SelfCollisionMonitor::starting_at(arm.model, arm.limits.link_overlap, start);
    if let Some((fraction, found)) = watch.check_line(&line, arm.model) {
        let fault = found.into();
        return Err(Refusal::Path { fraction, fault });
    }
    let mut able = line.limits(arm.limits);
    let mut warnings = Warnings::default();
    if line.length() == 0.0 {
        // Nothing turns: any limits do, and a wanted duration is waited for.
        able = ScalarLimits {
            speed: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
        };
    } else {
        able.speed = able.speed.min(point_speed_cap(&line, arm));
        let torques = torque_bounds(&line, arm);
        able.speed = able.speed.min(torques.speed_limit(TORQUE_SHARE_OF_SPEED));
        let speed = if wish.duration > 0.0 {
            able.speed
        } else {
            able.speed.min(wish.speed)
        };
        able.acceleration = able.acceleration.min(torques.acceleration_limit(speed));
    }
    let is_timed = wish.duration > 0.0;
    let chosen = if is_timed {
        able
    } else {
        ScalarLimits {
            speed: able.speed.min(wish.speed),
            acceleration: able.acceleration.min(wish.acceleration),
            jerk: able.jerk,
        }
    };
    if !is_timed && line.length() > 0.0 {
        if chosen.speed < wish.speed * (1.0 - 1e-9) {
            warnings.add(Warning::SpeedLimited {
                wanted: wish.speed,
                planned: chosen.speed,
                unit: WayUnit::Radian,
            });
        }
        if chosen.acceleration < wish.acceleration * (1.0 - 1e-9) {
            warnings.add(Warning::AccelerationLimited {
                wanted: wish.acceleration,
                planned: chosen.acceleration,
                unit: WayUnit::Radian,
            });
        }
    }
    cells.clear();
    let limits = IntervalLimits {
        speed: chosen.speed,
        asked: [chosen.acceleration; 2],
        braking: [chosen.acceleration; 2],
        planned: [HARD_STOP_SHARE * able.acceleration; 2],
        max_braking: [HARD_STOP_SHARE * able.acceleration; 2],
        jerk: chosen.jerk,
    };
    // What a neighbour slows down is a cell: so there are many, although they are all alike.
    for cell in 1..=JOINT_LINE_INTERVALS {
        cells.push(
            line.length() * cell as f64 / JOINT_LINE_INTERVALS as f64,
            limits,
        );
    }
    let leg = MotionSegment::new(Path::Joint(line), wish, arm, &mut warnings);
    Ok((leg, warnings))
}

pub(super) fn check_range(target: &JointPositions, limits: &MotionLimits) -> Result<(), Refusal> {
    for (joint, number) in (0u8..6).enumerate() {
        let (value, min, max) = (
            target[joint],
            limits.position_min[joint],
            limits.position_max[joint],
        );
        if !(value >= min - LIMIT_SLACK && value <= max + LIMIT_SLACK) {
            return Err(Refusal::JointLimit {
                joint: number,
                value,
                min,
                max,
            });
        }
    }
    Ok(())
}

/// The speed of s at which neither TCP nor elbow exceeds its limit anywhere on the line; infinite without such limits.
fn point_speed_cap(line: &JointLine, arm: &PlanningContext) -> f64 {
    let limits = arm.limits;
    if limits.tcp_speed.is_infinite() && limits.elbow_speed.is_infinite() {
        return f64::INFINITY;
    }
    let direction = line.direction();
    let mut cap = f64::INFINITY;
    for sample in 0..=POINT_SPEED_SAMPLES {
        let s = line.length() * sample as f64 / POINT_SPEED_SAMPLES as f64;
        let frames = arm.model.forward(&line.positions(s));
        let tcp = (frames.base_from_flange * *arm.flange_from_tcp).translation;
        let tcp_per_s = frames.twist(&direction, tcp).linear.norm();
        let elbow_per_s = elbow_speed(&frames, &direction);
        // A point that does not move divides by zero and caps nothing.
        cap = cap
            .min(limits.tcp_speed / tcp_per_s)
            .min(limits.elbow_speed / elbow_per_s);
    }
    cap * POINT_SPEED_MARGIN
}

/// What the line asks of the drives at a number of places.
fn torque_bounds(line: &JointLine, arm: &PlanningContext) -> TorqueBounds {
    let first = line.direction().0;
    let mut bounds = TorqueBounds::NONE;
    for sample in 0..=TORQUE_SAMPLES {
        let s = line.length() * sample as f64 / TORQUE_SAMPLES as f64;
        bounds.cover(&line.positions(s), &first, &[0.0; 6], arm);
    }
    bounds
}
