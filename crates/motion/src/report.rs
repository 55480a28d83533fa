//! The state that is published at the end of a cycle, computed from what the cycle holds.

use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{MotionMode, OffsetAxes, RobotState, SafetyMode};

use crate::cycle::{ControlLoop, CycleTiming, Generator};
use crate::queue::QueuedSegment;

/// Everything that is known about the robot now.
pub(crate) fn robot_state(cycle: &mut ControlLoop, timing: CycleTiming) -> RobotState {
    cycle.waypoint = waypoint(cycle);
    let cycle = &*cycle;
    let (target, actual) = (cycle.commanded.setpoint(), cycle.actual.state());
    let target_frames = cycle.commanded.frames();
    let target_tcp = cycle.tool.base_from_tcp(target_frames);
    let target_twist = target_frames.twist(&target.qd, target_tcp.translation);
    let target_tcp_pose = target_tcp.to_rpy();
    // An arm that is just where it should be is looked at once.
    let is_there = actual.q.has_bits_of(&target.q) && actual.qd.has_bits_of(&target.qd);
    let (actual_tcp_pose, actual_twist) = if is_there {
        (target_tcp_pose, target_twist)
    } else {
        let frames = cycle.actual.frames();
        let tcp = cycle.tool.base_from_tcp(frames);
        (tcp.to_rpy(), frames.twist(&actual.qd, tcp.translation))
    };
    let target_torque = match &cycle.setpoint_dynamics {
        expected if expected.of.bit_eq(target) => expected.torques,
        _ => cycle
            .load
            .dynamics()
            .inverse_dynamics(&target.q, &target.qd, &target.qdd),
    };
    let count = cycle.out.cycle;
    let (path_pose, path_rpy) = if cycle.target.q == target.q {
        (target_tcp, target_tcp_pose)
    } else {
        let pose = cycle
            .model
            .tcp_pose(&cycle.target.q, cycle.tool.flange_from_tcp());
        (pose, pose.to_rpy())
    };
    RobotState {
        cycle: count,
        time: count as f64 * cycle.step,
        step_time: cycle.step,
        target_q: target.q,
        target_qd: target.qd,
        target_qdd: target.qdd,
        actual_q: actual.q,
        actual_qd: actual.qd,
        target_torque,
        actual_torque: actual.torque,
        target_tcp_pose,
        actual_tcp_pose,
        target_tcp_speed: target_twist.to_array(),
        actual_tcp_speed: actual_twist.to_array(),
        tcp_force: cycle.sensor.compensated.to_array(),
        raw_wrench: cycle.sensor.raw.to_array(),
        elbow_position: cycle.actual.frames().elbow().into(),
        tcp_offset: cycle.tool.rpy(),
        payload: *cycle.load.payload(),
        motion_mode: motion_mode(cycle),
        command_id: cycle.running_command(),
        target_speed_fraction: cycle.speed_fraction,
        speed_scaling: speed_scaling(cycle),
        robot_mode: cycle.machine.robot_mode(),
        safety_mode: cycle.machine.safety_mode(),
        stop_code: cycle.stop_code(),
        digital_in: cycle.io.image.digital_in.into(),
        digital_out: cycle.io.image.digital_out.into(),
        analog_in: cycle.io.image.analog_in,
        analog_out: cycle.io.image.analog_out(),
        io_config: cycle.io.image.config,
        records_lost: cycle.out.records_lost(),
        step_duration_us: timing.step_duration_us,
        wakeup_latency_us: timing.wakeup_latency_us,
        external_torque: cycle.collision.external_torque(),
        joint_temperatures: cycle.thermal.joints,
        controller_temperature: cycle.thermal.controller,
        target_waypoint: cycle
            .waypoint
            .map_or(target_tcp_pose, |waypoint| waypoint.pose),
        gravity: (*cycle.load.gravity()).into(),
        encoder_counts: core::array::from_fn(|k| cycle.encoders[k].counts()),
        encoder_ranges: core::array::from_fn(|k| cycle.encoders[k].range().number()),
        collision_detection: cycle.collision.is_enabled,
        collision_sensitivity: u64::from(cycle.collision.sensitivity()),
        force_mode: cycle.force.is_on(),
        path_pose: path_rpy,
        path_offsets: path_offsets(cycle, &path_pose),
    }
}

/// The offset of the path in base, TCP and motion axes.
fn path_offsets(cycle: &ControlLoop, path_pose: &Pose) -> [[f64; 6]; 3] {
    let offset = &cycle.path_offset;
    if !offset.is_on() {
        return [[0.0; 6]; 3];
    }
    [OffsetAxes::Base, OffsetAxes::Tool, OffsetAxes::Motion]
        .map(|axes| offset.in_force(axes, &path_pose.rotation))
}

/// Where a motion leads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waypoint {
    q: JointPositions,
    tcp: RpyPose,
    pose: RpyPose,
}

/// Where the motion under way leads, which stays the same for many cycles.
fn waypoint(cycle: &ControlLoop) -> Option<Waypoint> {
    let q = match &cycle.generator {
        Generator::Path(_) => cycle.queue.current().map(QueuedSegment::end_q),
        Generator::Online(online) => online.goal(),
        _ => None,
    }?;
    if let Some(known) = &cycle.waypoint
        && known.q.has_bits_of(&q)
        && known.tcp == cycle.tool.rpy()
    {
        return Some(*known);
    }
    let pose = cycle
        .model
        .tcp_pose(&q, cycle.tool.flange_from_tcp())
        .to_rpy();
    Some(Waypoint {
        q,
        tcp: cycle.tool.rpy(),
        pose,
    })
}

fn motion_mode(cycle: &ControlLoop) -> MotionMode {
    if cycle.has_brakes_engaged() {
        return MotionMode::PoweredOff;
    }
    if cycle.machine.safety_mode() == SafetyMode::ProtectiveStop {
        return MotionMode::ProtectiveStop;
    }
    match &cycle.generator {
        Generator::Hold => match (&cycle.pending_motion, &cycle.tracking) {
            (Some(upcoming), _) => upcoming.mode,
            (None, Some(_)) if cycle.is_paused && cycle.is_standing() => MotionMode::Paused,
            (None, Some(_)) => MotionMode::Conveyor,
            (None, None) if cycle.force.is_on() => MotionMode::ForceMode,
            (None, None) => MotionMode::Idle,
        },
        Generator::Online(online) if online.is_stopping => MotionMode::Stopping,
        Generator::Online(online) => online.mode,
        Generator::Stop(_) => MotionMode::ProtectiveStop,
        Generator::Path(motion) if motion.is_stopping => MotionMode::Stopping,
        Generator::Path(motion) if cycle.is_paused && cycle.queue.is_standing(motion) => {
            MotionMode::Paused
        }
        Generator::Path(_) => cycle
            .queue
            .current()
            .map_or(MotionMode::Idle, |leg| leg.mode),
    }
}

/// Drivers scale the time of their trajectories by this: 0 while nothing they ask for is carried out.
fn speed_scaling(cycle: &ControlLoop) -> f64 {
    match &cycle.generator {
        Generator::Path(motion) => motion.fraction(),
        Generator::Stop(_) => 0.0,
        _ if cycle.is_held() || !cycle.is_under_servo() => 0.0,
        _ => cycle.speed_fraction,
    }
}
