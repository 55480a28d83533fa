//! The arm as a scope of its own: how it stands, what it is doing, its inputs and outputs. SI units, names of `/cycle`.

use motion_api::{CommandId, RobotState};
use recorder::{CycleMessage, FieldValue};

/// Where the motion under way began.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MotionProgress {
    command: CommandId,
    from: [f64; 3],
    began: f64,
}

impl MotionProgress {
    /// A cycle is about to pass.
    pub(crate) fn passes(&mut self, state: &RobotState) {
        if state.command_id != self.command {
            *self = Self {
                command: state.command_id,
                from: place(state),
                began: state.time,
            };
        }
    }

    /// Where on its path the arm is, in a sentence; None where none is under way.
    pub(crate) fn told(&self, state: &RobotState) -> Option<String> {
        if state.command_id == CommandId::NONE {
            return None;
        }
        let mode = state.motion_mode.name();
        if state.command_id != self.command {
            return Some(format!("{mode} begins"));
        }
        let left = distance(place(state), state.target_waypoint.xyz);
        let done = distance(self.from, place(state));
        let whole = done + left;
        let share = match whole > 1e-6 {
            true => format!(", {:.0} % of the way", 100.0 * done / whole),
            false => String::new(),
        };
        Some(format!(
            "{mode} for {:.3} s{share}: {:.1} mm from its beginning, {:.1} mm to its waypoint",
            state.time - self.began,
            1000.0 * done,
            1000.0 * left
        ))
    }
}

fn place(state: &RobotState) -> [f64; 3] {
    state.path_pose.xyz
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y));
    squares.sum::<f64>().sqrt()
}

/// A variable of the arm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RobotVariable {
    /// Name of the variable.
    pub name: String,
    /// Value of the variable.
    pub text: String,
    /// Elements of a vector.
    pub parts: Vec<String>,
}

/// All of them: the motion under way, then the fields of a cycle.
pub(crate) fn items(state: &RobotState, way: &MotionProgress) -> Vec<RobotVariable> {
    let plain = |name: &str, text: String| RobotVariable {
        name: name.to_owned(),
        text,
        parts: Vec::new(),
    };
    let standing = || "no motion under way".to_owned();
    let mut items = vec![plain("motion", way.told(state).unwrap_or_else(standing))];
    let cycle = CycleMessage::from(state);
    for (name, value) in cycle.fields() {
        items.push(match value {
            FieldValue::Unsigned(mask) if name.starts_with("digital") => {
                let set: Vec<String> = (0..64)
                    .filter(|bit| mask >> bit & 1 == 1)
                    .map(|bit| bit.to_string())
                    .collect();
                let text = match set.is_empty() {
                    true => "none set".to_owned(),
                    false => format!("set: {}", set.join(", ")),
                };
                plain(name, text)
            }
            FieldValue::Unsigned(number) => plain(name, word(name, number)),
            FieldValue::Number(number) => plain(name, number.to_string()),
            FieldValue::Text(text) => plain(name, format!("{text:?}")),
            FieldValue::Numbers(numbers) => {
                let parts: Vec<String> = numbers.iter().map(|x| format!("{x:.6}")).collect();
                RobotVariable {
                    name: name.to_owned(),
                    text: format!("[{}]", parts.join(", ")),
                    parts,
                }
            }
        });
    }
    items
}

fn word(name: &str, number: u64) -> String {
    let short = i32::try_from(number).unwrap_or(-1);
    match name {
        "safety_mode" => motion_api::SafetyMode::from_number(short).name().to_owned(),
        "robot_mode" => motion_api::RobotMode::from_number(short).name().to_owned(),
        _ => number.to_string(),
    }
}
