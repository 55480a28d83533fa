//! How far the arm may be from its way and from its goal.

use super::check::TrajectoryError;
use crate::messages::{JointTolerance, TrajectoryGoal};
use crate::names::JOINTS;

/// The driver's defaults: rad on the way, rad at the goal, rad/s at the goal.
const DEFAULTS: (f64, f64, f64) = (0.2, 0.1, 0.2);

/// What was exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// The joint.
    pub joint: &'static str,
    /// Distance of the joint, rad or rad/s.
    pub away: f64,
    /// Largest distance that is allowed, rad or rad/s.
    pub allowed: f64,
}

/// The tolerances of a goal; infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    path: [f64; 6],
    goal: [f64; 6],
    goal_speed: [f64; 6],
    /// Time that the arm has to come near enough to the goal, s; none is any.
    pub time: Option<f64>,
}

impl Default for Tolerances {
    fn default() -> Self {
        let (path, goal, speed) = DEFAULTS;
        Self {
            path: [path; 6],
            goal: [goal; 6],
            goal_speed: [speed; 6],
            time: None,
        }
    }
}

impl Tolerances {
    /// Tolerances of a goal, laid over the defaults: 0 leaves the default, a negative number takes the limit away.
    ///
    /// # Errors
    /// A joint that the arm does not have, or no number.
    pub fn of(goal: &TrajectoryGoal, prefix: &str) -> Result<Self, TrajectoryError> {
        let mut tolerances = Self::default();
        for given in &goal.path_tolerance {
            let joint = joint_of(given, prefix)?;
            set(&mut tolerances.path[joint], given.position, given)?;
        }
        for given in &goal.goal_tolerance {
            let joint = joint_of(given, prefix)?;
            set(&mut tolerances.goal[joint], given.position, given)?;
            set(&mut tolerances.goal_speed[joint], given.velocity, given)?;
        }
        let time = goal.goal_time_tolerance.to_secs();
        tolerances.time = (time > 0.0).then_some(time);
        Ok(tolerances)
    }

    /// What the arm exceeds on its way, with its distances from where it should be.
    pub fn path_violation(&self, away: &[f64; 6]) -> Option<Violation> {
        violation(away, &self.path)
    }

    /// What the arm exceeds at its goal.
    pub fn goal_violation(&self, away: &[f64; 6], speeds: &[f64; 6]) -> Option<Violation> {
        violation(away, &self.goal).or_else(|| violation(speeds, &self.goal_speed))
    }
}

fn violation(values: &[f64; 6], allowed: &[f64; 6]) -> Option<Violation> {
    let mut all = JOINTS.iter().zip(values.iter().zip(allowed));
    let (joint, (value, allowed)) = all.find(|(_, (value, allowed))| value.abs() > **allowed)?;
    Some(Violation {
        joint,
        away: value.abs(),
        allowed: *allowed,
    })
}

fn joint_of(given: &JointTolerance, prefix: &str) -> Result<usize, TrajectoryError> {
    let bare = given.name.strip_prefix(prefix);
    bare.and_then(|bare| JOINTS.iter().position(|known| *known == bare))
        .ok_or_else(|| TrajectoryError::Tolerance {
            joint: given.name.chars().take(64).collect(),
            value: given.position.to_string(),
        })
}

fn set(slot: &mut f64, value: f64, given: &JointTolerance) -> Result<(), TrajectoryError> {
    if !value.is_finite() {
        return Err(TrajectoryError::Tolerance {
            joint: given.name.chars().take(64).collect(),
            value: value.to_string(),
        });
    }
    if value > 0.0 {
        *slot = value;
    } else if value < 0.0 {
        *slot = f64::INFINITY;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tolerance_counts_over_the_default_and_a_negative_one_takes_it_away() {
        let tolerance = |position| JointTolerance {
            name: "elbow_joint".to_owned(),
            position,
            ..JointTolerance::default()
        };
        let with = |position| {
            let goal = TrajectoryGoal {
                path_tolerance: vec![tolerance(position)],
                ..TrajectoryGoal::default()
            };
            Tolerances::of(&goal, "")
        };
        let away = [0.0, 0.0, 0.15, 0.0, 0.0, 0.0];
        assert_eq!(with(0.0).unwrap().path_violation(&away), None);
        let found = with(0.1).unwrap().path_violation(&away).unwrap();
        assert_eq!((found.joint, found.allowed), ("elbow_joint", 0.1));
        assert_eq!(
            with(-1.0).unwrap().path_violation(&[9.0; 6]).unwrap().joint,
            "shoulder_pan_joint"
        );
        assert!(with(f64::NAN).is_err());
        assert!(
            Tolerances::of(
                &TrajectoryGoal {
                    goal_tolerance: vec![JointTolerance::default()],
                    ..TrajectoryGoal::default()
                },
                ""
            )
            .is_err()
        );
    }
}
