//! The force frame: the axes in which some directions are force controlled (manual 4.1).
//!
//! Owns only its rotation: moments are always about the TCP. Where a mode leaves an axis open, and where it is not
//! defined at all (the TCP at the origin of the reference frame, or at rest), the choices here are ours and continuous:
//! the last valid frame stays, and before there is one the reference frame counts.

use kinematics::Pose;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// How the force frame follows from the reference frame; the numbers are the manual's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameMode {
    /// 0: the reference frame itself.
    #[default]
    Fixed,
    /// 1: Y points from the TCP to the origin of the reference frame; Z stays as near to the reference's Z as it can.
    Point,
    /// 2: X points along the TCP's velocity, projected on the XY plane of the reference frame; Z is the reference's.
    Motion,
    /// 3: the TCP frame.
    Tcp,
}

impl FrameMode {
    /// From the manual's number.
    pub const fn from_number(number: u64) -> Option<Self> {
        Some(match number {
            0 => Self::Fixed,
            1 => Self::Point,
            2 => Self::Motion,
            3 => Self::Tcp,
            _ => return None,
        })
    }
}

/// Nearer to the origin than this the direction to it counts as undefined, m.
const MIN_DISTANCE: f64 = 1e-3;
/// Slower than this there is no direction of motion, m/s.
const MIN_SPEED: f64 = 1e-3;

/// The force frame from cycle to cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaskFrame {
    mode: FrameMode,
    base_from_reference: Pose,
    last_rotation: Rotation3<f64>,
}

impl TaskFrame {
    /// A frame in the given mode; the reference frame is given in the base.
    pub fn new(mode: FrameMode, base_from_reference: Pose) -> Self {
        Self {
            mode,
            base_from_reference,
            last_rotation: base_from_reference.rotation,
        }
    }

    /// True when both give the same axes wherever the arm is.
    pub fn is_same(&self, other: &Self) -> bool {
        self.mode == other.mode
            && (self.mode == FrameMode::Tcp
                || self.base_from_reference == other.base_from_reference)
    }

    /// Base-from-force rotation with the TCP at `base_from_tcp` moving at `velocity` (base frame, m/s).
    pub fn rotation(&mut self, base_from_tcp: &Pose, velocity: &Vector3<f64>) -> Rotation3<f64> {
        let reference = &self.base_from_reference;
        let found = match self.mode {
            FrameMode::Fixed => Some(reference.rotation),
            FrameMode::Tcp => Some(base_from_tcp.rotation),
            FrameMode::Point => {
                let way = reference.translation - base_from_tcp.translation;
                way.try_normalize(MIN_DISTANCE).and_then(|y| {
                    let z = reference.rotation * Vector3::z();
                    let z = (z - y * y.dot(&z)).try_normalize(MIN_DISTANCE)?;
                    Some(from_columns(y.cross(&z), y, z))
                })
            }
            FrameMode::Motion => {
                let z = reference.rotation * Vector3::z();
                let along = velocity - z * z.dot(velocity);
                along
                    .try_normalize(MIN_SPEED)
                    .map(|x| from_columns(x, z.cross(&x), z))
            }
        };
        self.last_rotation = found.unwrap_or(self.last_rotation);
        self.last_rotation
    }
}

fn from_columns(x: Vector3<f64>, y: Vector3<f64>, z: Vector3<f64>) -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, z]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::RpyPose;

    fn at(v: [f64; 6]) -> Pose {
        Pose::from_rpy(&RpyPose::from_array(v))
    }

    fn is_rotation(r: &Rotation3<f64>) -> bool {
        (r.matrix().determinant() - 1.0).abs() < 1e-12
            && (r.matrix() * r.matrix().transpose() - Matrix3::identity()).norm() < 1e-12
    }

    const REFERENCE: [f64; 6] = [0.5, 0.2, 0.1, 0.3, -0.2, 0.7];

    #[test]
    fn a_fixed_frame_is_the_reference_and_a_tcp_frame_the_tool() {
        let tool = at([0.1, 0.4, 0.6, 1.0, 0.1, -2.0]);
        let still = Vector3::zeros();
        let mut fixed = TaskFrame::new(FrameMode::Fixed, at(REFERENCE));
        assert_eq!(fixed.rotation(&tool, &still), at(REFERENCE).rotation);
        let mut own = TaskFrame::new(FrameMode::Tcp, at(REFERENCE));
        assert_eq!(own.rotation(&tool, &still), tool.rotation);
    }

    #[test]
    fn in_point_mode_y_points_from_the_tcp_to_the_origin() {
        let mut frame = TaskFrame::new(FrameMode::Point, at(REFERENCE));
        let tool = at([0.1, 0.4, 0.6, 1.0, 0.1, -2.0]);
        let r = frame.rotation(&tool, &Vector3::zeros());
        assert!(is_rotation(&r));
        let y = (at(REFERENCE).translation - tool.translation).normalize();
        assert!((r * Vector3::y() - y).norm() < 1e-12);
        // At the origin itself the frame stays.
        assert_eq!(frame.rotation(&at(REFERENCE), &Vector3::zeros()), r);
    }

    #[test]
    fn in_motion_mode_x_follows_the_velocity_in_the_plane_and_stays_at_rest() {
        let reference = at(REFERENCE);
        let mut frame = TaskFrame::new(FrameMode::Motion, reference);
        let tool = at([0.1, 0.4, 0.6, 1.0, 0.1, -2.0]);
        assert_eq!(
            frame.rotation(&tool, &Vector3::new(0.0, 0.0, 1e-4)),
            reference.rotation
        );
        let velocity = Vector3::new(0.05, -0.02, 0.03);
        let r = frame.rotation(&tool, &velocity);
        assert!(is_rotation(&r));
        let z = reference.rotation * Vector3::z();
        assert!((r * Vector3::z() - z).norm() < 1e-12);
        let along = velocity - z * z.dot(&velocity);
        assert!((r * Vector3::x() - along.normalize()).norm() < 1e-12);
        assert_eq!(frame.rotation(&tool, &Vector3::zeros()), r);
    }

    #[test]
    fn a_direction_that_is_undefined_from_the_start_is_the_reference() {
        let reference = at(REFERENCE);
        for mode in [FrameMode::Point, FrameMode::Motion] {
            let mut frame = TaskFrame::new(mode, reference);
            assert_eq!(
                frame.rotation(&reference, &Vector3::zeros()),
                reference.rotation
            );
        }
        // Right above the origin Y would be the reference's own Z.
        let mut frame = TaskFrame::new(FrameMode::Point, at([0.0; 6]));
        let above = at([0.0, 0.0, 0.3, 0.0, 0.0, 0.0]);
        assert_eq!(
            frame.rotation(&above, &Vector3::zeros()),
            Rotation3::identity()
        );
    }
}
