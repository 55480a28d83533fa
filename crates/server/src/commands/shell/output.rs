//! What a shell answers, on standard output.

use std::io::{Write, stdout};

use messages::{Text, text};
use motion_api::{RobotMode, SafetyMode};
use wire::primary::State;

use crate::language;

/// A line of the answer. Whoever reads may have seen enough; the status still tells.
pub(super) fn show(line: &str) {
    let mut out = stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}

/// A text of the answer, in the language of this process.
pub(super) fn show_text(text: &Text) {
    show(text.in_language(language::chosen()));
}

/// How the robot is.
pub(super) fn described(state: &State) -> Vec<Text> {
    let row = |values: &[f64]| {
        let values = values.iter().map(|value| format!("{value:.4}"));
        values.collect::<Vec<_>>().join(", ")
    };
    let mut lines = Vec::new();
    if let Some(mode) = &state.mode {
        let doing = match (mode.is_task_running, mode.is_task_paused) {
            (true, true) => text!("paused", "已暂停"),
            (true, false) => text!("running", "运行中"),
            (false, _) => text!("standing", "静止"),
        };
        let number = match mode.robot_mode {
            255 => -1,
            number => i32::from(number),
        };
        let robot = RobotMode::from_number(number).name();
        let speed = mode.target_speed_fraction * 100.0;
        lines.push(text!(
            "  robot {robot}, program {doing}, speed {speed:.0} %",
            "  机器人 {robot}，程序{doing}，速度 {speed:.0} %"
        ));
    }
    if let Some(board) = &state.masterboard {
        let safety = SafetyMode::from_number(i32::from(board.safety_mode));
        let (safety, read, set) = (safety.name(), board.digital_in, board.digital_out);
        lines.push(text!(
            "  safety {safety}, inputs {read:#x}, outputs {set:#x}",
            "  安全 {safety}，输入 {read:#x}，输出 {set:#x}"
        ));
    }
    if let Some(joints) = &state.joints {
        let q = joints.0.each_ref().map(|joint| joint.actual_q);
        let row = row(&q);
        lines.push(text!("  joints [{row}] rad", "  关节 [{row}] rad"));
    }
    if let Some(cartesian) = &state.cartesian {
        let row = row(&cartesian.tcp_pose);
        lines.push(Text::verbatim(format!("  TCP [{row}] m, rad")));
    }
    lines
}
