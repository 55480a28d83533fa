//! The tool centre point from rests at one point.

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

/// Why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ToolFitError {
    /// Fewer than four rests.
    #[error("four or more rests at one point are needed, the data has {0}")]
    TooFew(usize),
    /// The flange was turned about one axis only, or not at all.
    #[error(
        "the flange lies alike in all rests: turn it about two axes by 20 degrees or more between them"
    )]
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
