//! Tool and frame, from where the arm rests.

use kinematics::identification::fit_tool;
use kinematics::{Pose, RpyPose};
use messages::{Text, text};
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::IdentifyError;
use super::answer::{Answer, FrameAnswer, ToolAnswer};
use super::samples::Samples;

/// Points that are nearer tell no direction, m.
const DISTANCE_MIN_M: f64 = 0.02;
/// Directions whose angle is smaller tell no plane, rad.
const ANGLE_MIN_RAD: f64 = 0.1;

fn cannot(text: Text) -> IdentifyError {
    IdentifyError::CannotTell(text)
}

/// The TCP from rests of its tip at one point.
pub fn tool(
    samples: &Samples,
    at: &[f64],
    with_orientation: bool,
) -> Result<Answer, IdentifyError> {
    let rests = samples.chosen_rests(at)?;
    let poses = samples.flange_poses(&rests);
    let (points, directions) = match with_orientation {
        // The last three: the point, a step along x, a step into +y.
        true if poses.len() >= 6 => (&poses[..poses.len() - 2], Some(&poses[poses.len() - 3..])),
        true => {
            return Err(cannot(text!(
                "{} rests: with --orientation four at the point and two beside it are needed",
                "静止段有 {} 个：用 --orientation 时需要在该点的四个和旁边的两个",
                poses.len()
            )));
        }
        false => (&poses[..], None),
    };
    let fit = fit_tool(points).map_err(|error| cannot(Text::of(&error)))?;
    let sigma = fit.sigma.norm();
    let (rpy, sigma_orientation) = match directions {
        None => ([0.0; 3], None),
        Some(three) => {
            let tips: Vec<Vector3<f64>> = three
                .iter()
                .map(|pose| pose.transform_point(fit.position))
                .collect();
            let (rotation, length) = axes(&tips)?;
            let flange_from_tool = three[0].rotation.inverse() * rotation;
            let rpy = kinematics::rotation::rpy_from_rotation(&flange_from_tool);
            (rpy, Some(sigma.max(fit.residual_max / 3.0) / length))
        }
    };
    let [x, y, z]: [f64; 3] = fit.position.into();
    Ok(Answer::Tool(ToolAnswer {
        tcp: [x, y, z, rpy[0], rpy[1], rpy[2]],
        sigma_position: fit.sigma.into(),
        sigma_orientation,
        residual_max: fit.residual_max,
        rests: rests.len(),
    }))
}

/// A frame from rests at its origin, on its x axis and in its xy plane, at +y.
pub fn frame(samples: &Samples, at: &[f64]) -> Result<Answer, IdentifyError> {
    let rests = samples.chosen_rests(at)?;
    let [first, second, third] = rests[..] else {
        return Err(cannot(text!(
            "{} rests: three are needed (origin, on X, in the XY plane); choose them with --at",
            "静止段有 {} 个：需要三个（原点、X 轴上、XY 平面内）；请用 --at 选择",
            rests.len()
        )));
    };
    let tips: Vec<Vector3<f64>> = [first, second, third]
        .iter()
        .map(|rest| {
            samples
                .model
                .tcp_pose(&rest.q, &rest.flange_from_tcp)
                .translation
        })
        .collect();
    let (rotation, _) = axes(&tips)?;
    let pose = Pose {
        rotation,
        translation: tips[0],
    };
    let frame: RpyPose = pose.to_rpy();
    Ok(Answer::Frame(FrameAnswer {
        frame: frame.to_array(),
        rests: rests.len(),
    }))
}

/// Axes from a point, one along x, and one in the xy plane at +y; and the shorter of the two distances.
fn axes(points: &[Vector3<f64>]) -> Result<(Rotation3<f64>, f64), IdentifyError> {
    let (along, aside) = (points[1] - points[0], points[2] - points[0]);
    let shorter = along.norm().min(aside.norm());
    if shorter < DISTANCE_MIN_M {
        return Err(cannot(text!(
            "two of the points are {:.1} mm apart: 20 mm or more are needed",
            "有两点相距 {:.1} mm：需要至少 20 mm",
            shorter * 1e3
        )));
    }
    let x = along.normalize();
    let z = x.cross(&aside);
    if z.norm() < ANGLE_MIN_RAD.sin() * aside.norm() {
        return Err(cannot(text!(
            "the three points lie in one line: the third one has to lie beside it",
            "三点在一条直线上：第三点必须在直线之外"
        )));
    }
    let z = z.normalize();
    let matrix = Matrix3::from_columns(&[x, z.cross(&x), z]);
    Ok((Rotation3::from_matrix_unchecked(matrix), shorter))
}
