//! The state that is published at the end of a cycle, computed from what the cycle holds.

use motion_api::{MotionMode, RobotState, SafetyMode};

use crate::cycle::{Cycle, Generator, Timing};

/// Everything that is known about the robot now.
pub(crate) fn report(cycle: &Cycle, timing: Timing) -> RobotState {
    let (target, actual) = (&cycle.target, &cycle.actual);
    let target_tcp = cycle.target_frames.base_from_flange * cycle.flange_from_tcp;
    let actual_frames = cycle.model.forward(&actual.q);
    let actual_tcp = actual_frames.base_from_flange * cycle.flange_from_tcp;
    let target_twist = cycle
        .target_frames
        .twist(&target.qd, target_tcp.translation);
    let actual_twist = actual_frames.twist(&actual.qd, actual_tcp.translation);
    let count = cycle.out.cycle;
    RobotState {
        cycle: count,
        time: count as f64 * cycle.step,
        step_time: cycle.step,
        target_q: target.q,
        target_qd: target.qd,
        target_qdd: target.qdd,
        actual_q: actual.q,
        actual_qd: actual.qd,
        target_torque: cycle
            .dynamics
            .inverse_dynamics(&target.q, &target.qd, &target.qdd),
        actual_torque: actual.torque,
        target_tcp_pose: target_tcp.to_rpy(),
        actual_tcp_pose: actual_tcp.to_rpy(),
        target_tcp_speed: target_twist.to_array(),
        actual_tcp_speed: actual_twist.to_array(),
        // Nothing touches the arm yet: neither obstacles nor external wrenches are simulated.
        tcp_force: [0.0; 6],
        elbow_position: actual_frames.elbow().into(),
        tcp_offset: cycle.tcp,
        payload: cycle.payload,
        motion_mode: motion_mode(cycle),
        command_id: cycle.running(),
        target_speed_fraction: cycle.speed_fraction,
        speed_scaling: speed_scaling(cycle),
        robot_mode: cycle.machine.robot_mode(),
        safety_mode: cycle.machine.safety_mode(),
        stop_code: cycle.stop_code(),
        digital_in: 0,
        digital_out: cycle.digital_out,
        analog_in: [0.0; 3],
        analog_out: [0.0; 3],
        records_lost: cycle.out.records_lost(),
        step_duration_us: timing.step_duration_us,
        wakeup_latency_us: timing.wakeup_latency_us,
    }
}

fn motion_mode(cycle: &Cycle) -> MotionMode {
    if cycle.has_brakes_engaged() {
        return MotionMode::PoweredOff;
    }
    if cycle.machine.safety_mode() == SafetyMode::ProtectiveStop {
        return MotionMode::ProtectiveStop;
    }
    match &cycle.generator {
        Generator::Hold => cycle
            .upcoming
            .map_or(MotionMode::Idle, |upcoming| upcoming.mode),
        Generator::Brake(_) => MotionMode::ProtectiveStop,
        Generator::Path(motion) if motion.is_stopping => MotionMode::Stopping,
        Generator::Path(motion) if cycle.is_paused && motion.is_standing() => MotionMode::Paused,
        Generator::Path(motion) => motion.mode,
    }
}

fn speed_scaling(cycle: &Cycle) -> f64 {
    match &cycle.generator {
        Generator::Path(motion) => motion.fraction(),
        _ if cycle.is_paused => 0.0,
        _ => cycle.speed_fraction,
    }
}
