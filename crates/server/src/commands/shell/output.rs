//! What a shell answers, on standard output.

use std::io::{Write, stdout};

use motion_api::{RobotMode, SafetyMode};
use wire::primary::State;

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
            (true, true) => "paused",
            (true, false) => "running",
            (false, _) => "standing",
        };
        let number = match mode.robot_mode {
            255 => -1,
            number => i32::from(number),
        };
        lines.push(format!(
            "  robot {}, program {doing}, speed {:.0} %",
            RobotMode::from_number(number).name(),
            mode.target_speed_fraction * 100.0
        ));
    }
    if let Some(board) = &state.masterboard {
        let safety = SafetyMode::from_number(i32::from(board.safety_mode));
        lines.push(format!(
            "  safety {}, inputs {:#x}, outputs {:#x}",
            safety.name(),
            board.digital_in,
            board.digital_out
        ));
    }
    if let Some(joints) = &state.joints {
        let q = joints.0.each_ref().map(|joint| joint.actual_q);
        lines.push(format!("  joints [{}] rad", row(&q)));
    }
    if let Some(cartesian) = &state.cartesian {
        lines.push(format!("  TCP [{}] m, rad", row(&cartesian.tcp_pose)));
    }
    lines
}
