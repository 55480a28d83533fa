//! Forward kinematics of six revolute joints, and everything that follows from the joint frames alone: Jacobian,
//! twist, acceleration bias.
//!
//! Owns the geometry of the chain. Knows no masses, no limits and no tool: a point on the tool is an argument.

use crate::joint::{DOF, JointPositions, JointSpeeds};
use crate::matrix3::turned_about_z;
use crate::pose::Pose;
use crate::trig;
use crate::wrench::Twist;
use nalgebra::{Matrix6, Rotation3, Vector3};

/// Geometry of the arm at rest: six fixed transforms with a turn about the local z axis after each, then the flange.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain {
    /// Frame of joint i in the frame of joint i-1 (the base for the first) when joint i stands at zero.
    pub parent_from_joint: [Pose; DOF],
    /// The tool flange in the frame of joint 6.
    pub joint6_from_flange: Pose,
}

impl Chain {
    /// Frame of each joint in its parent's at joint positions `q`.
    #[inline]
    pub(crate) fn joint_transforms(&self, q: &JointPositions) -> [Pose; DOF] {
        let (sines, cosines) = trig::sin_cos(&q.0);
        let mut transforms = self.parent_from_joint;
        for joint in 0..DOF {
            transforms[joint].rotation = Rotation3::from_matrix_unchecked(turned_about_z(
                transforms[joint].rotation.matrix(),
                sines[joint],
                cosines[joint],
            ));
        }
        transforms
    }

    /// What is to be known of joint positions `q` for several questions about them.
    pub fn posture(&self, q: &JointPositions) -> Posture {
        Posture(self.joint_transforms(q))
    }

    /// All joint frames and the flange at joint positions `q`.
    pub fn forward(&self, q: &JointPositions) -> Frames {
        self.frames(&self.posture(q))
    }

    /// All joint frames and the flange of a posture that [`Self::posture`] has computed.
    pub fn frames(&self, Posture(transforms): &Posture) -> Frames {
        let mut base_from_joint = *transforms;
        for joint in 1..DOF {
            base_from_joint[joint] = base_from_joint[joint - 1] * base_from_joint[joint];
        }
        Frames {
            base_from_joint,
            base_from_flange: base_from_joint[DOF - 1] * self.joint6_from_flange,
        }
    }

    /// Pose of the tool flange in the base frame at joint positions `q`.
    pub fn flange_pose(&self, q: &JointPositions) -> Pose {
        let transforms = self.joint_transforms(q);
        let mut pose = transforms[0];
        for transform in &transforms[1..] {
            pose = pose * *transform;
        }
        pose * self.joint6_from_flange
    }
}

/// The joint frames at some joint positions, each in its parent's: what frames and dynamics are worked out from.
#[derive(Clone, Copy, Debug)]
pub struct Posture(pub(crate) [Pose; DOF]);

/// Where the joint frames and the flange are at one set of joint positions.
///
/// Frame i moves with joint i and has the joint axis as its z axis; in the CS arms it is the link frame of the URDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    /// The six joint frames in the base frame, base joint first.
    pub base_from_joint: [Pose; DOF],
    /// The tool flange in the base frame.
    pub base_from_flange: Pose,
}

impl Frames {
    /// The elbow: origin of the third joint frame in the base frame, metres.
    ///
    /// It lies on the elbow axis in the plane through the base axis; the housing stands sideways of it.
    pub fn elbow(&self) -> Vector3<f64> {
        self.base_from_joint[2].translation
    }

    /// Axis of a joint (0 to 5) in the base frame, a unit vector.
    #[inline]
    pub(crate) fn axis(&self, joint: usize) -> Vector3<f64> {
        let m = self.base_from_joint[joint].rotation.matrix();
        Vector3::new(m.m13, m.m23, m.m33)
    }

    /// Geometric Jacobian of a `point` (base frame, metres) that moves with the flange: twist = J qd.
    ///
    /// Rows vx vy vz wx wy wz in base axes, columns joints 1 to 6.
    pub fn jacobian(&self, point: Vector3<f64>) -> Matrix6<f64> {
        Matrix6::from(core::array::from_fn::<[f64; 6], DOF, _>(|joint| {
            let axis = self.axis(joint);
            let linear = axis.cross(&(point - self.base_from_joint[joint].translation));
            [linear.x, linear.y, linear.z, axis.x, axis.y, axis.z]
        }))
    }

    /// Twist of a `point` (base frame, metres) that moves with the flange, in base axes.
    pub fn twist(&self, qd: &JointSpeeds, point: Vector3<f64>) -> Twist {
        let mut twist = Twist::default();
        for joint in 0..DOF {
            let rate = self.axis(joint) * qd[joint];
            twist.linear += rate.cross(&(point - self.base_from_joint[joint].translation));
            twist.angular += rate;
        }
        twist
    }

    /// The product of the Jacobian's time derivative with the joint speeds: what the `point` accelerates by when
    /// qdd = 0. Base axes; linear part m/s², angular part rad/s², as in acceleration = J qdd + this.
    pub fn jacobian_rate_times_speeds(&self, qd: &JointSpeeds, point: Vector3<f64>) -> Twist {
        let mut angular_speed = Vector3::zeros();
        let mut bias = Twist::default();
        let mut origin = self.base_from_joint[0].translation;
        for joint in 0..DOF {
            // Carry the acceleration from the previous joint's origin to this one's: both on the same rigid link.
            let next = self.base_from_joint[joint].translation;
            bias.linear += link_acceleration(bias.angular, angular_speed, next - origin);
            origin = next;
            let rate = self.axis(joint) * qd[joint];
            bias.angular += angular_speed.cross(&rate);
            angular_speed += rate;
        }
        bias.linear += link_acceleration(bias.angular, angular_speed, point - origin);
        bias
    }
}

/// Acceleration of one end of `arm` relative to the other on a body that turns: α × r + ω × (ω × r).
#[inline]
fn link_acceleration(alpha: Vector3<f64>, omega: Vector3<f64>, arm: Vector3<f64>) -> Vector3<f64> {
    alpha.cross(&arm) + omega.cross(&omega.cross(&arm))
}
