//! What is asked of a trajectory before the arm moves.

use messages::{Localized, Text, text};
use thiserror::Error;

use super::code;
use crate::messages::JointTrajectory;
use crate::names::JOINTS;

/// Most points of a trajectory.
pub const POINTS_MAX: usize = 10_000;
/// Longest trajectory, s.
pub const SECONDS_MAX: f64 = 3600.0;
/// A trajectory without times is joined to where the arm is within this, s.
const IMMEDIATELY: f64 = 1e-9;

/// What the arm can do: rad, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrajectoryLimits {
    /// Lowest and highest position of each joint.
    pub positions: [(f64, f64); 6],
    /// Highest speed of each joint.
    pub speeds: [f64; 6],
}

/// One point with the arm's joints in their order; speeds and accelerations where they were given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Time from the start, s.
    pub time: f64,
    /// rad.
    pub position: [f64; 6],
    /// rad/s.
    pub speed: Option<[f64; 6]>,
    /// rad/s².
    pub acceleration: Option<[f64; 6]>,
}

/// Points that can be run.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedTrajectory {
    /// At least one, times rising.
    pub points: Vec<Waypoint>,
    /// The arm's joint at each place of the goal's own lists.
    pub order: [usize; 6],
}

/// The reason for which a trajectory cannot be run.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// Joints that the arm does not have, or not all of them.
    #[error("the joints are {given}; needed are {needed}, in any order")]
    #[zh("关节为 {given}；需要 {needed}，顺序不限")]
    Joints {
        /// The joints as given.
        given: String,
        /// The joints of the arm.
        needed: String,
    },
    /// No point.
    #[error("the trajectory has no point")]
    #[zh("轨迹没有点")]
    Empty,
    /// Too many points.
    #[error("the trajectory has {count} points, {POINTS_MAX} at most are allowed")]
    #[zh("轨迹有 {count} 个点，最多允许 {POINTS_MAX} 个")]
    TooManyPoints {
        /// Number of points.
        count: usize,
    },
    /// A list of a point that has not six numbers.
    #[error("{list} of point {point} have {count} numbers, needed are 6")]
    #[zh("第 {point} 点的 {list} 有 {count} 个数，需要 6 个")]
    Length {
        /// From 1.
        point: usize,
        /// The list.
        list: &'static str,
        /// Numbers found.
        count: usize,
    },
    /// A number that is none.
    #[error("{list} of point {point} have {value} for {joint}, needed is a finite number")]
    #[zh("第 {point} 点的 {list} 中 {joint} 为 {value}，需要有限数")]
    NotFinite {
        /// From 1.
        point: usize,
        /// The list.
        list: &'static str,
        /// The joint.
        joint: &'static str,
        /// The number as text.
        value: String,
    },
    /// Times that do not rise.
    #[error("point {point} is at {time:.4} s, not after the one before, at {before:.4} s")]
    #[zh("第 {point} 点在 {time:.4} s，不晚于前一点（{before:.4} s）")]
    Times {
        /// From 1.
        point: usize,
        /// s.
        time: f64,
        /// s.
        before: f64,
    },
    /// A trajectory that lasts too long.
    #[error("the trajectory takes {seconds:.1} s, {SECONDS_MAX} s at most are allowed")]
    #[zh("轨迹需要 {seconds:.1} s，最多允许 {SECONDS_MAX} s")]
    TooLong {
        /// s.
        seconds: f64,
    },
    /// A position or a speed beyond a limit.
    #[error("{what} {value:.4} of {joint} at {time:.4} s is beyond its limit, {limit:.4}")]
    #[zh("{joint} 在 {time:.4} s 处的{what} {value:.4} 超出其极限 {limit:.4}")]
    Limit {
        /// Position or speed.
        what: Text,
        /// The joint.
        joint: &'static str,
        /// rad or rad/s.
        value: f64,
        /// s.
        time: f64,
        /// rad or rad/s.
        limit: f64,
    },
    /// The first point is too far from the arm to be reached in no time.
    #[error(
        "the trajectory starts {away:.4} rad from where {joint} is; 0.1 rad at most can be made good"
    )]
    #[zh("轨迹起点与 {joint} 的当前位置相差 {away:.4} rad；最多可弥补 0.1 rad")]
    Start {
        /// The joint.
        joint: &'static str,
        /// rad.
        away: f64,
    },
    /// Forces, or joints of several degrees of freedom.
    #[error("{what} cannot be followed: the arm follows positions of its six joints")]
    #[zh("无法跟随 {what}：手臂跟随其六个关节的位置")]
    Unsupported {
        /// What was given.
        what: Text,
    },
    /// A tolerance that is no number, or of a joint that there is not.
    #[error(
        "the tolerance of {joint:?} is {value}: needed are joints of the arm and finite numbers"
    )]
    #[zh("{joint:?} 的容差为 {value}：需要手臂的关节和有限数")]
    Tolerance {
        /// The joint as given.
        joint: String,
        /// The number as text.
        value: String,
    },
    /// The trajectory was to begin earlier.
    #[error("the trajectory was to start {seconds:.3} s ago and is over")]
    #[zh("轨迹本应在 {seconds:.3} s 前开始，已经结束")]
    OldStamp {
        /// s.
        seconds: f64,
    },
}

impl CheckedTrajectory {
    /// The trajectory as it is to be run when it was to begin `late` seconds ago (negative: in so many seconds), with
    /// the arm at `position`.
    ///
    /// # Errors
    /// The trajectory is over already.
    pub fn begun_before(mut self, late: f64, position: [f64; 6]) -> Result<Self, TrajectoryError> {
        let Some(first) = self.points.first().copied() else {
            return Ok(self);
        };
        if late < 0.0 {
            for point in &mut self.points {
                point.time -= late;
            }
            if first.time > 0.0 {
                // Until then the arm stays.
                self.points.insert(
                    0,
                    Waypoint {
                        time: -late,
                        position,
                        speed: first.speed.map(|_| [0.0; 6]),
                        acceleration: first.acceleration.map(|_| [0.0; 6]),
                    },
                );
            }
            return Ok(self);
        }
        self.points.retain(|point| point.time > late);
        if self.points.is_empty() {
            return Err(TrajectoryError::OldStamp { seconds: late });
        }
        for point in &mut self.points {
            point.time -= late;
        }
        Ok(self)
    }
}

impl TrajectoryError {
    /// The code of control_msgs.
    pub const fn code(&self) -> i32 {
        match self {
            Self::Joints { .. } => code::INVALID_JOINTS,
            Self::OldStamp { .. } => code::OLD_HEADER_TIMESTAMP,
            _ => code::INVALID_GOAL,
        }
    }
}

/// The arm's joint at each place of a list of names.
pub(crate) fn joint_order(names: &[String], prefix: &str) -> Result<[usize; 6], TrajectoryError> {
    let wrong = || {
        let given: Vec<&str> = names.iter().take(8).map(String::as_str).collect();
        let given: String = given.join(", ").chars().take(200).collect();
        TrajectoryError::Joints {
            given: if names.is_empty() {
                "none".to_owned()
            } else {
                given
            },
            needed: JOINTS.map(|name| format!("{prefix}{name}")).join(", "),
        }
    };
    if names.len() != 6 {
        return Err(wrong());
    }
    let mut order = [0; 6];
    let mut seen = [false; 6];
    for (place, name) in order.iter_mut().zip(names) {
        let bare = name.strip_prefix(prefix).ok_or_else(wrong)?;
        let joint = JOINTS.iter().position(|known| *known == bare);
        *place = joint.ok_or_else(wrong)?;
        seen[*place] = true;
    }
    match seen.iter().all(|seen| *seen) {
        true => Ok(order),
        false => Err(wrong()),
    }
}

/// The points of a trajectory, if it can be run; `prefix` is what names of joints begin with.
///
/// # Errors
/// [`TrajectoryError`] with the first thing that is wrong.
pub fn check(
    trajectory: &JointTrajectory,
    prefix: &str,
    limits: &TrajectoryLimits,
) -> Result<CheckedTrajectory, TrajectoryError> {
    let order = joint_order(&trajectory.joint_names, prefix)?;
    let count = trajectory.points.len();
    if count == 0 {
        return Err(TrajectoryError::Empty);
    }
    if count > POINTS_MAX {
        return Err(TrajectoryError::TooManyPoints { count });
    }
    let mut points: Vec<Waypoint> = Vec::with_capacity(count);
    for (index, point) in trajectory.points.iter().enumerate() {
        let number = index + 1;
        let six = |list: &'static str, given: &[f64]| six(list, number, given, &order);
        let optional = |list, given: &[f64]| match given.is_empty() {
            true => Ok(None),
            false => six(list, given).map(Some),
        };
        let position = six("positions", &point.positions)?;
        let speed = optional("velocities", &point.velocities)?;
        let acceleration = optional("accelerations", &point.accelerations)?;
        if !point.effort.is_empty() {
            return Err(TrajectoryError::Unsupported {
                what: text!("efforts", "力矩"),
            });
        }
        let time = point.time_from_start.to_secs();
        let before = points.last().map(|before| before.time);
        let is_later = match before {
            Some(before) => time > before + IMMEDIATELY,
            None => time >= 0.0,
        };
        if !is_later {
            return Err(TrajectoryError::Times {
                point: number,
                time,
                before: before.unwrap_or(0.0),
            });
        }
        for (joint, name) in JOINTS.iter().enumerate() {
            let (low, high) = limits.positions[joint];
            let beyond = |what, value: f64, limit| TrajectoryError::Limit {
                what,
                joint: name,
                value,
                time,
                limit,
            };
            if position[joint] < low {
                return Err(beyond(text!("position", "位置"), position[joint], low));
            }
            if position[joint] > high {
                return Err(beyond(text!("position", "位置"), position[joint], high));
            }
            let most = limits.speeds[joint];
            if let Some(speed) = speed.map(|speed| speed[joint])
                && speed.abs() > most
            {
                return Err(beyond(text!("speed", "速度"), speed, most));
            }
        }
        points.push(Waypoint {
            time,
            position,
            speed,
            acceleration,
        });
    }
    match points.last() {
        Some(last) if last.time > SECONDS_MAX => {
            Err(TrajectoryError::TooLong { seconds: last.time })
        }
        _ => Ok(CheckedTrajectory { points, order }),
    }
}

fn six(
    list: &'static str,
    point: usize,
    given: &[f64],
    order: &[usize; 6],
) -> Result<[f64; 6], TrajectoryError> {
    if given.len() != 6 {
        return Err(TrajectoryError::Length {
            point,
            list,
            count: given.len(),
        });
    }
    let mut values = [0.0; 6];
    for (value, joint) in given.iter().zip(order) {
        // Numbers so large that arithmetic with them ends in nothing are no positions.
        if !value.is_finite() || value.abs() > 1e6 {
            return Err(TrajectoryError::NotFinite {
                point,
                list,
                joint: JOINTS[*joint],
                value: value.to_string(),
            });
        }
        values[*joint] = *value;
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::{Duration, JointTrajectoryPoint};

    pub(crate) const LIMITS: TrajectoryLimits = TrajectoryLimits {
        positions: [(-6.25, 6.25); 6],
        speeds: [3.0; 6],
    };

    fn point(at: f64, positions: [f64; 6]) -> JointTrajectoryPoint {
        JointTrajectoryPoint {
            positions: positions.into(),
            time_from_start: Duration::from_secs(at),
            ..JointTrajectoryPoint::default()
        }
    }

    fn good() -> JointTrajectory {
        JointTrajectory {
            joint_names: JOINTS.map(str::to_owned).into(),
            points: vec![point(1.0, [0.1; 6]), point(2.0, [0.2; 6])],
            ..JointTrajectory::default()
        }
    }

    #[test]
    fn joints_may_come_in_any_order() {
        let mut trajectory = good();
        trajectory.joint_names.swap(0, 5);
        trajectory.points[0].positions = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let checked = check(&trajectory, "", &LIMITS).unwrap();
        assert_eq!(checked.points[0].position, [6.0, 2.0, 3.0, 4.0, 5.0, 1.0]);
    }

    #[test]
    fn what_is_wrong_is_named_with_the_code_for_it() {
        type Change = fn(&mut JointTrajectory);
        let cases: [(Change, i32, &str); 15] = [
            (|t| t.joint_names[2] = "elbow".to_owned(), -2, "elbow_joint"),
            (
                |t| t.joint_names[2] = t.joint_names[1].clone(),
                -2,
                "needed are",
            ),
            (|t| drop(t.joint_names.pop()), -2, "needed are"),
            (|t| t.joint_names.clear(), -2, "none"),
            (|t| t.points.clear(), -1, "no point"),
            (
                |t| t.points = vec![point(1.0, [0.0; 6]); 100_000],
                -1,
                "100000 points",
            ),
            (|t| t.points[1].positions.truncate(5), -1, "5 numbers"),
            (|t| t.points[1].positions.clear(), -1, "0 numbers"),
            (
                |t| t.points[1].velocities = vec![0.0; 3],
                -1,
                "velocities of point 2",
            ),
            (
                |t| t.points[0].positions[3] = f64::NAN,
                -1,
                "NaN for wrist_1_joint",
            ),
            (
                |t| t.points[1].velocities = vec![f64::INFINITY; 6],
                -1,
                "inf",
            ),
            (
                |t| t.points[1].time_from_start = Duration::from_secs(1.0),
                -1,
                "not after",
            ),
            (
                |t| t.points[0].time_from_start = Duration::from_secs(-1.0),
                -1,
                "not after",
            ),
            (
                |t| t.points[1].positions[0] = 7.0,
                -1,
                "beyond its limit, 6.25",
            ),
            (|t| t.points[1].velocities = vec![3.5; 6], -1, "speed 3.5"),
        ];
        for (change, code, said) in cases {
            let mut trajectory = good();
            change(&mut trajectory);
            let error = check(&trajectory, "", &LIMITS).unwrap_err();
            assert_eq!(error.code(), code, "{error}");
            assert!(error.to_string().contains(said), "{error}");
        }
        let error = check(&good(), "left_", &LIMITS).unwrap_err();
        assert!(error.to_string().contains("left_elbow_joint"), "{error}");
    }
}
