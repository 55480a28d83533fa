//! The tool centre point from rests at one point.

use messages::Localized;
use nalgebra::Vector3;

use super::least_squares::{FitError, LeastSquares};
use crate::pose::Pose;

/// The position of a TCP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolFit {
    /// In the flange frame, m.
    pub position: Vector3<f64>,
    /// One standard deviation of each coordinate, m.
    pub sigma: Vector3<f64>,
    /// The point in the base frame, m.
    pub point: Vector3<f64>,
    /// The largest distance of a tip from the point, m.
    pub residual_max: f64,
}

/// A reason why a tool cannot be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
pub enum ToolFitError {
    /// Fewer than four rests.
    #[error("four or more rests at one point are needed, the data has {0}")]
    #[zh("需要在同一点的四个以上静止段，数据中有 {0} 个")]
    TooFew(usize),
    /// The flange was turned about one axis only, or not at all.
    #[error(
        "the flange lies alike in all rests: turn it about two axes by 20 degrees or more between them"
    )]
    #[zh("各静止段中法兰姿态相同：请在它们之间绕两个轴转动 20 度以上")]
    Alike,
}

/// Finds the point of the flange that was at one place in all poses.
///
/// # Errors
/// The poses are too few or too much alike.
pub fn fit_tool(base_from_flange: &[Pose]) -> Result<ToolFit, ToolFitError> {
    if base_from_flange.len() < 4 {
        return Err(ToolFitError::TooFew(base_from_flange.len()));
    }
    // Rotation * tool - point = -translation.
    let mut sums = LeastSquares::new(6);
    for pose in base_from_flange {
        for axis in 0..3 {
            let mut row = [0.0; 6];
            let turned = pose.rotation.matrix().row(axis).into_owned();
            row[..3].copy_from_slice(turned.transpose().as_slice());
            row[3 + axis] = -1.0;
            sums.add(&row, -pose.translation[axis]);
        }
    }
    let solution = match sums.solve() {
        Ok(solution) => solution,
        Err(FitError::TooFew { .. } | FitError::Unobservable { .. }) => {
            return Err(ToolFitError::Alike);
        }
    };
    let v = &solution.values;
    let (position, point) = (
        Vector3::new(v[0], v[1], v[2]),
        Vector3::new(v[3], v[4], v[5]),
    );
    let residuals = base_from_flange
        .iter()
        .map(|pose| (pose.transform_point(position) - point).norm());
    let sigma = Vector3::new(solution.sigmas[0], solution.sigmas[1], solution.sigmas[2]);
    if is_vague(base_from_flange) {
        return Err(ToolFitError::Alike);
    }
    Ok(ToolFit {
        position,
        sigma,
        point,
        residual_max: residuals.fold(0.0, f64::max),
    })
}

/// Turns between the poses that are all about one axis, or smaller than some degrees, tell a coordinate badly.
fn is_vague(poses: &[Pose]) -> bool {
    const TURN_MIN_RAD: f64 = 0.1;
    let turns: Vec<Vector3<f64>> = poses[1..]
        .iter()
        .map(|pose| {
            let turn = poses[0].rotation.inverse() * pose.rotation;
            crate::rotation::rotvec_from_rotation(&turn)
        })
        .collect();
    let Some(largest) = turns
        .iter()
        .copied()
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))
    else {
        return true;
    };
    if largest.norm() < TURN_MIN_RAD {
        return true;
    }
    let axis = largest.normalize();
    turns
        .iter()
        .all(|turn| turn.cross(&axis).norm() < TURN_MIN_RAD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::RpyPose;
    use crate::random::RandomSequence;

    /// Nearly normal: twelve numbers of a uniform distribution.
    fn normal(random: &mut RandomSequence) -> f64 {
        (0..12).map(|_| random.unit()).sum::<f64>() - 6.0
    }

    /// Poses of a flange whose tip is put to a point with an error of `noise` in each axis.
    fn rests(
        random: &mut RandomSequence,
        count: usize,
        tool: Vector3<f64>,
        noise: f64,
    ) -> Vec<Pose> {
        let point = Vector3::new(-0.5, 0.1, 0.2);
        let mut rest = || {
            let rpy = core::array::from_fn(|_| random.between(-0.6, 0.6));
            let turned = Pose::from_rpy(&RpyPose { xyz: [0.0; 3], rpy });
            let error = Vector3::from_fn(|_, _| noise * normal(random));
            let at = point + error - turned.rotate(tool);
            Pose {
                translation: at,
                ..turned
            }
        };
        (0..count).map(|_| rest()).collect()
    }

    #[test]
    fn two_sigmas_cover_the_truth_in_95_of_100_cases_with_few_rests_as_with_many() {
        let tool = Vector3::new(0.01, -0.02, 0.13);
        for count in [4, 6, 12] {
            let mut random = RandomSequence::with_stream(49, count as u64);
            let (mut covered, mut all) = (0, 0);
            for _ in 0..4000 {
                // Turns that are too much alike are no matter here.
                let Ok(fit) = fit_tool(&rests(&mut random, count, tool, 2e-5)) else {
                    continue;
                };
                let error = fit.position - tool;
                covered += (0..3)
                    .filter(|axis| error[*axis].abs() <= 2.0 * fit.sigma[*axis])
                    .count();
                all += 3;
            }
            let share = f64::from(covered as u32) / f64::from(all as u32);
            assert!((0.94..0.965).contains(&share), "{count} rests: {share}");
        }
    }
}
