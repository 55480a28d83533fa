//! The points of a moveml: a list that is made and checked by its sender, handed over once, and never changed.
//!
//! A list is too long for a slot of the command ring, so it crosses the border as a handle beside its command. Owns
//! what a list is and which numbers may stand in it. Nobody frees one on the motion thread: the sender keeps its handle
//! until no other is left ([`CommandSender::send_points`](crate::CommandSender::send_points)).

use kinematics::JointPositions;

use crate::Refusal;
use crate::form::bad_value;
use crate::phrase;

/// One point: joint positions in rad and a number that is not used; or x, y, z in m and a quaternion w, x, y, z.
pub type PointValues = [f64; 7];

/// Most points of a list.
pub const POINTS_MAX: usize = 100_000;
/// Lengths of a quaternion that stands for a rotation; what lies between two points is hardly shorter than they are.
const QUATERNION_LENGTH: core::ops::RangeInclusive<f64> = 0.5..=2.0;

/// Points of one kind, at least two.
#[derive(Clone, Debug, PartialEq)]
pub struct PointList {
    samples: Box<[PointValues]>,
    are_poses: bool,
}

impl PointList {
    /// Joint positions, rad.
    ///
    /// # Errors
    /// Fewer than 2 points, more than [`POINTS_MAX`], or a number that is not finite.
    pub fn from_joint_positions(points: &[JointPositions]) -> Result<Self, Refusal> {
        let samples = points
            .iter()
            .map(|q| [q[0], q[1], q[2], q[3], q[4], q[5], 0.0]);
        Self::new(samples.collect(), false)
    }

    /// Joint positions, or poses of the TCP in the base frame with quaternions that need not be of length 1.
    ///
    /// # Errors
    /// The errors of [`from_joint_positions`](Self::from_joint_positions), and a quaternion much shorter or longer than
    /// 1.
    pub fn new(samples: Vec<PointValues>, are_poses: bool) -> Result<Self, Refusal> {
        if !(2..=POINTS_MAX).contains(&samples.len()) {
            let value = samples.len() as f64;
            return Err(bad_value(
                phrase!("the number of points", "点的数目"),
                value,
                phrase!("2 to 100000", "2 到 100000"),
            ));
        }
        for sample in &samples {
            if let Some(value) = sample.iter().find(|x| !x.is_finite()) {
                return Err(bad_value(
                    phrase!("a number of a point", "点的数"),
                    *value,
                    phrase!("a finite number", "有限的数"),
                ));
            }
            let [.., w, i, j, k] = *sample;
            let length = [w, i, j, k].iter().map(|x| x * x).sum::<f64>().sqrt();
            if are_poses && !QUATERNION_LENGTH.contains(&length) {
                return Err(bad_value(
                    phrase!("the length of a quaternion", "四元数的长度"),
                    length,
                    phrase!("0.5 to 2", "0.5 到 2"),
                ));
            }
        }
        Ok(Self {
            samples: samples.into_boxed_slice(),
            are_poses,
        })
    }

    /// The points in order.
    pub fn samples(&self) -> &[PointValues] {
        &self.samples
    }

    /// True when the points are poses of the TCP, false when they are joint positions.
    pub fn are_poses(&self) -> bool {
        self.are_poses
    }

    /// The number of points, which the moveml has to state as well.
    pub fn count(&self) -> u32 {
        // At most POINTS_MAX.
        self.samples.len() as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_that_cannot_be_run_are_refused_by_name() {
        let home = JointPositions::ZERO;
        let text = |list: Result<PointList, Refusal>| list.unwrap_err().to_string();
        for points in [vec![], vec![home], vec![home; POINTS_MAX + 1]] {
            let text = text(PointList::from_joint_positions(&points));
            assert!(text.contains("number of points"), "{text}");
        }
        let wrong = JointPositions([0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]);
        assert!(text(PointList::from_joint_positions(&[home, wrong])).contains("finite"));
        for (poses, said) in [([0.0; 7], "quaternion"), ([f64::INFINITY; 7], "finite")] {
            let text = text(PointList::new(vec![poses; 3], true));
            assert!(text.contains(said), "{text}");
        }
        assert_eq!(
            PointList::from_joint_positions(&[home; 3]).unwrap().count(),
            3
        );
    }
}
