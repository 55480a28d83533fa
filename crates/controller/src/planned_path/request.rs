//! What a path is asked for with, as people write it.

use core::fmt;
use core::str::FromStr;
use std::time::Duration;

use kinematics::{JointPositions, RpyPose};
use messages::{Text, text};

use crate::options::ANGLE_MAX;

/// Where a path ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathTarget {
    /// There.
    Joints(JointPositions),
    /// With the TCP there in the base frame, whatever the joints are.
    Pose(RpyPose),
}

impl FromStr for PathTarget {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        let text = text.trim();
        let pose = text
            .strip_prefix('p')
            .and_then(|rest| rest.trim_start().strip_prefix('['))
            .and_then(|rest| rest.strip_suffix(']'));
        let joints = text
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
            .unwrap_or(text);
        let numbers = six_numbers(pose.unwrap_or(joints)).ok_or(
            text!("six joint positions in rad are needed, as in 0,-1.57,1.57,-1.57,-1.57,0, or a pose of the TCP in m \
             and rad, all of them up to 1000, as in 'p[0.4,0.1,0.3,3.14,0,0]'",
             "需要六个关节位置（rad），如 0,-1.57,1.57,-1.57,-1.57,0，或 TCP 的位姿（m 和 rad），如 'p[0.4,0.1,0.3,3.14,0,0]'；都不超过 1000"),
        )?;
        Ok(match pose {
            Some(_) => Self::Pose(RpyPose::from_array(numbers)),
            None => Self::Joints(JointPositions(numbers)),
        })
    }
}

impl fmt::Display for PathTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (prefix, numbers) = match self {
            Self::Joints(q) => ("", q.0),
            Self::Pose(pose) => ("p", pose.to_array()),
        };
        let numbers = numbers.map(|number| number.to_string());
        write!(f, "{prefix}[{}]", numbers.join(","))
    }
}

fn six_numbers(text: &str) -> Option<[f64; 6]> {
    let numbers = text.split(',').map(|part| {
        part.trim()
            .parse()
            .ok()
            .filter(|x: &f64| x.abs() <= ANGLE_MAX)
    });
    numbers.collect::<Option<Vec<f64>>>()?.try_into().ok()
}

/// Joint speed of the program's motions that is not given, rad/s: that of `movej`.
pub const DEFAULT_SPEED: f64 = 1.05;
/// Joint acceleration of the program's motions that is not given, rad/s²: that of `movej`.
pub const DEFAULT_ACCELERATION: f64 = 1.4;

/// What is planned.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanOptions {
    /// Where the path ends.
    pub target: PathTarget,
    /// Where it passes, in this order.
    pub via: Vec<JointPositions>,
    /// The distance that is kept, m.
    pub margin: f64,
    /// Longest search, time of the machine.
    pub time: Duration,
    /// Name of what hangs on the flange, as it lies when the arm is at the start.
    pub held: Option<String>,
    /// Length of the last piece, a line along the z axis of the tool, m.
    pub approach: f64,
    /// Joint speed of the program, rad/s.
    pub speed: f64,
    /// Joint acceleration of the program, rad/s².
    pub acceleration: f64,
}

impl PlanOptions {
    /// A path to `target` with the defaults of the command line.
    pub const fn to(target: PathTarget) -> Self {
        Self {
            target,
            via: Vec::new(),
            margin: 0.01,
            time: Duration::from_secs(5),
            held: None,
            approach: 0.0,
            speed: DEFAULT_SPEED,
            acceleration: DEFAULT_ACCELERATION,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_joints_or_poses() {
        for text in ["1,2,3,4,5,6", "[1, 2, 3, 4, 5, 6]", " 1,2,3,4,5,6 "] {
            let q = JointPositions([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
            assert_eq!(text.parse(), Ok(PathTarget::Joints(q)), "{text}");
        }
        for text in ["p[1,2,3,4,5,6]", "p [1, 2,3,4,5,6]"] {
            let pose = RpyPose::from_array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
            assert_eq!(text.parse(), Ok(PathTarget::Pose(pose)), "{text}");
        }
        for wrong in [
            "",
            "1,2,3,4,5",
            "p1,2,3,4,5,6",
            "[1,2,3,4,5,6",
            "1,2,3,4,5,inf",
            "1,2,3,4,5,1e300",
        ] {
            let error = wrong.parse::<PathTarget>().unwrap_err();
            assert!(error.english().contains("p[0.4"), "{wrong}: {error}");
        }
    }
}
