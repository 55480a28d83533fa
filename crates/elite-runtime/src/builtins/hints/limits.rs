//! What an arm cannot do: speeds, accelerations and radii far beyond it, places that it does not reach, joint positions
//! in which it stands in itself.
//!
//! Where it is not known which arm a program is for, only what no built-in arm can do is wrong, and a long tool is
//! allowed for.

use elite_syntax::ArgumentLiteral;
use kinematics::collision::link_name;
use kinematics::{JointPositions, RobotModel};
use messages::{Text, text};
use nalgebra::Vector3;

use super::super::declare::{Builtin, Category, Parameter, ParameterType};
use super::{HintText, number, numbers};

/// Asking for up to this many times what a joint can do is usual: the controller cuts it.
const SPEED_FACTOR: f64 = 2.0;
/// The vendor gives no accelerations; programs ask for several times what arms do.
const ACCELERATION_FACTOR: f64 = 10.0;
/// No arm moves its tool faster, m/s.
const TOOL_SPEED_MAX: f64 = 10.0;
/// m/s².
const TOOL_ACCELERATION_MAX: f64 = 150.0;
/// No blend is rounder, m.
const RADIUS_MAX: f64 = 2.0;
/// Length of a tool that nobody has said anything about, m.
pub const TOOL_LENGTH_MAX: f64 = 0.6;
/// Links whose housings overlap by more stand in each other, m.
const OVERLAP_MAX: f64 = 0.02;

const RADIANS: Text = text!(
    "speeds of joints are in rad/s: turn degrees into radians with d2r()",
    "关节速度以 rad/s 为单位：用 d2r() 把度换算为弧度"
);
const METRES: Text = text!(
    "lengths are in metres: divide millimetres by 1000",
    "长度以米为单位：把毫米除以 1000"
);
const OF_JOINTS: Text = text!(
    "if these are joint positions, movej() is the function for them",
    "如果这些是关节位置，请用 movej()"
);

/// The limits of one arm, or of all arms together.
pub(super) struct ArmLimits {
    /// The arm, or every built-in one.
    arms: Vec<Arm>,
    is_one: bool,
    tool: f64,
}

struct Arm {
    model: RobotModel,
    /// m above the base.
    shoulder: Vector3<f64>,
    /// From the shoulder to the flange at most, m.
    reach: f64,
}

impl Arm {
    fn new(model: RobotModel) -> Self {
        let frames = model.forward(&JointPositions::ZERO);
        let origins: Vec<Vector3<f64>> = frames
            .base_from_joint
            .iter()
            .map(|pose| pose.translation)
            .chain([frames.base_from_flange.translation])
            .collect();
        // However the joints turn, the flange is no further away than all links in a row.
        let reach = origins[1..]
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).norm())
            .sum();
        Self {
            shoulder: origins[1],
            reach,
            model,
        }
    }
}

impl ArmLimits {
    pub(super) fn of_any_arm() -> Self {
        let models = RobotModel::names().filter_map(|name| RobotModel::built_in(name).ok());
        Self {
            arms: models.map(Arm::new).collect(),
            is_one: false,
            tool: TOOL_LENGTH_MAX,
        }
    }

    pub(super) fn of(model: RobotModel, tool: f64) -> Self {
        Self {
            arms: vec![Arm::new(model)],
            is_one: true,
            tool,
        }
    }

    /// What of an argument no arm can do.
    pub(super) fn violation(
        &self,
        builtin: &Builtin,
        parameter: &Parameter,
        value: &ArgumentLiteral<'_>,
    ) -> Option<HintText> {
        if builtin.category != Category::Motion {
            return None;
        }
        let what = text!(
            "'{}' of {}()",
            "{1}() 的 '{0}'",
            parameter.name,
            builtin.name
        );
        let goes_there = builtin.name.starts_with("move") || builtin.name == "servoj";
        match (parameter.kind, value) {
            (ParameterType::Joints, ArgumentLiteral::List(items)) if goes_there => {
                self.in_itself(&what, &six(items)?)
            }
            (ParameterType::Pose, ArgumentLiteral::List(items)) if goes_there => {
                self.out_of_reach(&what, &six(items)?)
            }
            (ParameterType::Number(_), _) => {
                self.too_much(&what, parameter.name, parameter.unit, number(value)?)
            }
            // Speeds of the joints, or of the TCP in its directions and about its axes.
            (ParameterType::Numbers(6), ArgumentLiteral::List(items)) => {
                let units = match parameter.unit {
                    "rad/s" => ["rad/s"; 6],
                    "m/s, rad/s" => ["m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"],
                    _ => return None,
                };
                let mut speeds = items.iter().zip(units);
                speeds.find_map(|(item, unit)| {
                    self.too_much(&what, parameter.name, unit, number(item)?)
                })
            }
            _ => None,
        }
    }

    fn largest(&self, of: impl Fn(&RobotModel) -> f64) -> f64 {
        self.arms
            .iter()
            .map(|arm| of(&arm.model))
            .fold(0.0, f64::max)
    }

    fn too_much(&self, what: &Text, name: &str, unit: &str, given: f64) -> Option<HintText> {
        let (most, unit, help) = match (name, unit) {
            (_, "rad/s") => {
                let joints = self.largest(|model| model.limits().speed.max_abs());
                (SPEED_FACTOR * joints, "rad/s", RADIANS)
            }
            (_, "rad/s^2") => {
                let joints = self.largest(|model| model.limits().acceleration.max_abs());
                (ACCELERATION_FACTOR * joints, "rad/s²", RADIANS)
            }
            (_, "m/s") => (TOOL_SPEED_MAX, "m/s", METRES),
            (_, "m/s^2") => (TOOL_ACCELERATION_MAX, "m/s²", METRES),
            ("r", "m") => (RADIUS_MAX, "m", METRES),
            _ => return None,
        };
        (given.abs() > most).then(|| {
            let text = text!(
                "{what} is {given} {unit}, far beyond what the arm can do",
                "{what}为 {given} {unit}，远超机械臂的能力"
            );
            ("far-beyond", text, help)
        })
    }

    fn out_of_reach(&self, what: &Text, pose: &[f64; 6]) -> Option<HintText> {
        let place = Vector3::new(pose[0], pose[1], pose[2]);
        // The arm that comes nearest to it.
        let beyond = |arm: &Arm| (place - arm.shoulder).norm() - arm.reach - self.tool;
        let best = self
            .arms
            .iter()
            .min_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
        if beyond(best) <= 0.0 {
            return None;
        }
        let distance = (place - best.shoulder).norm();
        let reach = best.reach + self.tool;
        let name = best.model.name();
        let text = match (self.is_one, self.tool > 0.0) {
            (true, false) => text!(
                "{what} is out of reach: {distance:.2} m from the shoulder, a {name} reaches \
                 {reach:.2} m",
                "{what}够不到：距肩部 {distance:.2} m，{name} 只能到达 {reach:.2} m"
            ),
            (true, true) => text!(
                "{what} is out of reach: {distance:.2} m from the shoulder, a {name} with a tool of {:.2} m reaches \
                 {reach:.2} m",
                "{what}够不到：距肩部 {distance:.2} m，{name} 带 {:.2} m 的工具只能到达 {reach:.2} \
                 m",
                self.tool
            ),
            (false, _) => text!(
                "{what} is out of reach: {distance:.2} m from the shoulder, the largest arm with a long tool reaches \
                 {reach:.2} m",
                "{what}够不到：距肩部 {distance:.2} m，最大的机械臂带长工具也只能到达 {reach:.2} m"
            ),
        };
        let are_angles = pose.iter().all(|x| x.abs() <= std::f64::consts::TAU);
        let help = if are_angles { OF_JOINTS } else { METRES };
        Some(("out-of-reach", text, help))
    }

    fn in_itself(&self, what: &Text, q: &[f64; 6]) -> Option<HintText> {
        let q = JointPositions(*q);
        // Angles out of range are degrees, and said as such.
        if !q.is_finite() || q.max_abs() > std::f64::consts::TAU {
            return None;
        }
        let mut least = None;
        for arm in &self.arms {
            let found = arm
                .model
                .collision()
                .self_distance(&arm.model.forward(&q))?;
            if -found.distance <= OVERLAP_MAX {
                return None;
            }
            least = Some(found);
        }
        let found = least?;
        let (a, b) = found.links;
        let (a, b) = (link_name(a), link_name(b));
        let text = text!(
            "{what} folds the arm into itself: {a} and {b} would be in the same place",
            "{what}会使机械臂碰到自己：{a}和{b}会在同一位置"
        );
        Some((
            "self-collision",
            text,
            text!(
                "choose another position for the joints between them",
                "请为它们之间的关节选择其他位置"
            ),
        ))
    }
}

fn six(items: &[ArgumentLiteral<'_>]) -> Option<[f64; 6]> {
    numbers(items)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtins::{known_names, known_names_for};
    use elite_syntax::{SourceFile, check};
    use messages::Language;

    fn codes(text: &str) -> Vec<&'static str> {
        let found = check(SourceFile::new("test.script", text), &known_names());
        found.iter().map(|finding| finding.code).collect()
    }

    #[test]
    fn what_no_arm_can_do_is_found() {
        for (text, code) in [
            (
                "movej([0, -1.57, 1.57, -1.57, -1.57, 0], v=60)",
                "far-beyond",
            ),
            (
                "movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=1400)",
                "far-beyond",
            ),
            ("movel([0.4, 0, 0.3, 3.14, 0, 0], v=250)", "far-beyond"),
            ("movel([0.4, 0, 0.3, 3.14, 0, 0], a=1200)", "far-beyond"),
            ("movel([0.4, 0, 0.3, 3.14, 0, 0], r=50)", "far-beyond"),
            ("speedj([0, 60, 0, 0, 0, 0], 10, 1)", "far-beyond"),
            ("speedj([0, -60, 0, 0, 0, 0], 10, 1)", "far-beyond"),
            ("speedl([0, 0, -250, 0, 0, 0], 1, 1)", "far-beyond"),
            ("speedl([0, 0, 0, 0, 0, 90], 1, 1)", "far-beyond"),
            ("movel([3.4, 0, 0.3, 3.14, 0, 0])", "out-of-reach"),
            (
                "fast = 250\nmovel([0.4, 0, 0.3, 3.14, 0, 0], v=fast)",
                "far-beyond",
            ),
            ("movej([0, -1.57, 2.9, 0, 0, 0])", "self-collision"),
        ] {
            assert_eq!(codes(text), [code], "{text}");
        }
        for text in [
            "movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=8, v=3.9, r=0.1)",
            "movel([1.9, 0, 0.3, 3.14, 0, 0], a=10, v=2)",
            "ok = get_inverse_kin_has_solution([3.4, 0, 0.3, 3.14, 0, 0])",
            "speedj([0, 3, 0, 0, -3, 0], 10, 1)",
            "speedl([0.25, 0, -0.25, 0, 0, 1], 1, 1)",
            "fast = 1\nif get_standard_digital_in(0):\n  fast = 250\nmovel([0.4, 0, 0.3, 3.14, 0, 0], v=fast)",
        ] {
            assert_eq!(codes(text), [""; 0], "{text}");
        }
    }

    #[test]
    fn one_arm_is_measured_by_itself() {
        let text = "movel([1.4, 0, 0.3, 3.14, 0, 0])";
        let found = |model: &str, tool: f64| {
            let model = RobotModel::built_in(model).unwrap();
            let known = known_names_for(model, tool);
            check(SourceFile::new("test.script", text), &known)
        };
        let small = found("cs66", 0.0);
        assert_eq!(small.len(), 1, "{small:?}");
        let message = &small[0].message;
        assert!(message.english().contains("a cs66 reaches"), "{message:?}");
        let chinese = message.in_language(Language::Chinese);
        assert!(chinese.contains("够不到"), "{chinese}");
        assert!(found("cs66", 0.5).is_empty());
        assert!(found("cs620", 0.0).is_empty());
    }
}
