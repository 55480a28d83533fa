//! What a shell answers, on standard output.

use std::io::{Write, stdout};

use motion_api::{RobotMode, SafetyMode};
use wire::primary::State;

use crate::language::{is_chinese, pick};

/// A line of the answer. Whoever reads may have seen enough; the status still tells.
pub(super) fn show(line: &str) {
    let mut out = stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}

/// How the robot is.
pub(super) fn described(state: &State) -> Vec<String> {
    let row = |values: &[f64]| {
        let values = values.iter().map(|value| format!("{value:.4}"));
        values.collect::<Vec<_>>().join(", ")
    };
    let mut lines = Vec::new();
    if let Some(mode) = &state.mode {
        let doing = match (mode.is_task_running, mode.is_task_paused) {
            (true, true) => pick("paused", "已暂停"),
            (true, false) => pick("running", "运行中"),
            (false, _) => pick("standing", "静止"),
        };
        let number = match mode.robot_mode {
            255 => -1,
            number => i32::from(number),
        };
        let robot = RobotMode::from_number(number).name();
        let speed = mode.target_speed_fraction * 100.0;
        lines.push(match is_chinese() {
            true => format!("  机器人 {robot}，程序{doing}，速度 {speed:.0} %"),
            false => format!("  robot {robot}, program {doing}, speed {speed:.0} %"),
        });
    }
    if let Some(board) = &state.masterboard {
        let safety = SafetyMode::from_number(i32::from(board.safety_mode));
        let (safety, read, set) = (safety.name(), board.digital_in, board.digital_out);
        lines.push(match is_chinese() {
            true => format!("  安全 {safety}，输入 {read:#x}，输出 {set:#x}"),
            false => format!("  safety {safety}, inputs {read:#x}, outputs {set:#x}"),
        });
    }
    if let Some(joints) = &state.joints {
        let q = joints.0.each_ref().map(|joint| joint.actual_q);
        let name = pick("joints", "关节");
        lines.push(format!("  {name} [{}] rad", row(&q)));
    }
    if let Some(cartesian) = &state.cartesian {
        lines.push(format!("  TCP [{}] m, rad", row(&cartesian.tcp_pose)));
    }
    lines
}
