//! Rigid-body dynamics of the arm with its payload: inverse dynamics, gravity torques, mass matrix, forward dynamics.
//!
//! Owns the recursions; quantities of link i are in the axes of joint frame i with moments about its origin. No
//! friction, no rotor inertia, no contact: an outside wrench w at the tool adds -Jᵀ w to the torques.
//! Symbols as in Featherstone, *Rigid Body Dynamics Algorithms*, 2008, chapters 5 to 7.

use crate::chain::Chain;
use crate::joint::{DOF, JointAccelerations, JointPositions, JointSpeeds, JointTorques};
use crate::matrix3::times;
use crate::payload::{Payload, RigidBody};
use crate::pose::Pose;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Free-fall acceleration in the frame of a base that stands upright, m/s².
///
/// Points down. The script call `set_gravity` (manual 3.1.16) takes the opposite, the direction away from the ground.
pub const GRAVITY_UPRIGHT: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// The dynamics of an arm with a given payload and mounting. Cheap to make, fixed size.
#[derive(Clone, Copy, Debug)]
pub struct Dynamics {
    chain: Chain,
    bodies: [RigidBody; DOF],
    gravity: Vector3<f64>,
}

/// A force (or linear acceleration) and a moment (or angular acceleration) about the joint frame's origin.
#[derive(Clone, Copy)]
struct Spatial {
    linear: Vector3<f64>,
    angular: Vector3<f64>,
}

impl Spatial {
    const ZERO: Self = Self {
        linear: Vector3::new(0.0, 0.0, 0.0),
        angular: Vector3::new(0.0, 0.0, 0.0),
    };

    /// A wrench on the child, expressed in the parent about the parent's origin.
    #[inline]
    fn to_parent(self, parent_from_child: &Pose) -> Self {
        let linear = parent_from_child.rotate(self.linear);
        Self {
            linear,
            angular: parent_from_child.rotate(self.angular)
                + parent_from_child.translation.cross(&linear),
        }
    }
}

impl Dynamics {
    /// From the links' mass properties (in their joint frames), a payload on the flange, and the free-fall acceleration
    /// in the base frame, m/s² (see [`GRAVITY_UPRIGHT`]).
    pub fn new(
        chain: Chain,
        mut bodies: [RigidBody; DOF],
        payload: &Payload,
        gravity: Vector3<f64>,
    ) -> Self {
        let on_joint6 = payload.body().expressed_in(&chain.joint6_from_flange);
        bodies[DOF - 1] = bodies[DOF - 1].joined_with(&on_joint6);
        Self {
            chain,
            bodies,
            gravity,
        }
    }

    /// The links' mass properties in their joint frames, the payload included in the last.
    pub fn bodies(&self) -> &[RigidBody; DOF] {
        &self.bodies
    }

    /// Torques the drives must supply, Nm: tau = M(q) qdd + C(q, qd) qd + g(q). Recursive Newton-Euler.
    pub fn inverse_dynamics(
        &self,
        q: &JointPositions,
        qd: &JointSpeeds,
        qdd: &JointAccelerations,
    ) -> JointTorques {
        self.newton_euler(&self.chain.joint_transforms(q), qd, qdd)
    }

    fn newton_euler(
        &self,
        transforms: &[Pose; DOF],
        qd: &JointSpeeds,
        qdd: &JointAccelerations,
    ) -> JointTorques {
        let mut omega = Vector3::zeros();
        let mut alpha = Vector3::zeros();
        // Accelerating the base upwards is the same as gravity on every link.
        let mut acceleration = -self.gravity;
        let mut wrenches = [Spatial::ZERO; DOF];
        for joint in 0..DOF {
            let parent_from_joint = &transforms[joint];
            let arm = &parent_from_joint.translation;
            acceleration += alpha.cross(arm) + omega.cross(&omega.cross(arm));
            acceleration = parent_from_joint.rotate_back(acceleration);
            omega = parent_from_joint.rotate_back(omega);
            alpha = parent_from_joint.rotate_back(alpha);
            // The joint turns about z: omega × (z qd) has no z component.
            alpha += Vector3::new(omega.y * qd[joint], -omega.x * qd[joint], qdd[joint]);
            omega.z += qd[joint];

            let body = &self.bodies[joint];
            let linear =
                (acceleration + alpha.cross(&body.com) + omega.cross(&omega.cross(&body.com)))
                    * body.mass;
            let angular = times(&body.inertia, &alpha)
                + omega.cross(&times(&body.inertia, &omega))
                + body.com.cross(&linear);
            wrenches[joint] = Spatial { linear, angular };
        }
        let mut torques = JointTorques::ZERO;
        let mut carried = Spatial::ZERO;
        for joint in (0..DOF).rev() {
            carried.linear += wrenches[joint].linear;
            carried.angular += wrenches[joint].angular;
            torques[joint] = carried.angular.z;
            carried = carried.to_parent(&transforms[joint]);
        }
        torques
    }

    /// Torques that hold the arm still against gravity, Nm: g(q).
    pub fn gravity_torques(&self, q: &JointPositions) -> JointTorques {
        self.inverse_dynamics(q, &JointSpeeds::ZERO, &JointAccelerations::ZERO)
    }

    /// Torques at rest plus those of motion without acceleration, Nm: C(q, qd) qd + g(q).
    pub fn bias_torques(&self, q: &JointPositions, qd: &JointSpeeds) -> JointTorques {
        self.inverse_dynamics(q, qd, &JointAccelerations::ZERO)
    }

    /// The symmetric joint-space mass matrix M(q), kg m². Composite rigid bodies (Featherstone 6.2).
    pub fn mass_matrix(&self, q: &JointPositions) -> Matrix6<f64> {
        let transforms = self.chain.joint_transforms(q);
        let mut matrix = Matrix6::zeros();
        // Everything from this joint outwards, held rigid.
        let mut composite = RigidBody::default();
        for joint in (0..DOF).rev() {
            composite = self.bodies[joint].joined_with(&composite);
            // The wrench that accelerates it by one about the joint axis.
            let linear = Vector3::z().cross(&composite.com) * composite.mass;
            let angular = composite.inertia.column(2) + composite.com.cross(&linear);
            let mut wrench = Spatial { linear, angular };
            matrix[(joint, joint)] = wrench.angular.z;
            for inner in (0..joint).rev() {
                wrench = wrench.to_parent(&transforms[inner + 1]);
                matrix[(inner, joint)] = wrench.angular.z;
                matrix[(joint, inner)] = wrench.angular.z;
            }
            composite = composite.expressed_in(&transforms[joint]);
        }
        matrix
    }

    /// Joint accelerations that the torques `tau` cause, rad/s². Articulated bodies (Featherstone 7.3).
    pub fn forward_dynamics(
        &self,
        q: &JointPositions,
        qd: &JointSpeeds,
        tau: &JointTorques,
    ) -> JointAccelerations {
        let transforms = self.chain.joint_transforms(q);
        let mut motion = [Matrix6::zeros(); DOF];
        let mut speed_bias = [Vector6::zeros(); DOF];
        let mut inertia = [Matrix6::zeros(); DOF];
        let mut force_bias = [Vector6::zeros(); DOF];
        let mut omega = Vector3::zeros();
        for joint in 0..DOF {
            let body = &self.bodies[joint];
            omega = transforms[joint].rotate_back(omega);
            // Classical acceleration of the joint origin relative to its parent's, in child axes; see `link_motion`.
            let parent_omega = omega;
            omega.z += qd[joint];
            let arm = transforms[joint].rotate_back(transforms[joint].translation);
            let centripetal = parent_omega.cross(&parent_omega.cross(&arm));
            let gyroscopic = parent_omega.cross(&Vector3::new(0.0, 0.0, qd[joint]));
            speed_bias[joint] = stacked(centripetal, gyroscopic);
            motion[joint] = link_motion(&transforms[joint]);
            inertia[joint] = spatial_inertia(body);
            let force = omega.cross(&omega.cross(&body.com)) * body.mass;
            let moment = omega.cross(&times(&body.inertia, &omega)) + body.com.cross(&force);
            force_bias[joint] = stacked(force, moment);
        }

        let mut column = [Vector6::zeros(); DOF];
        let mut effective = [0.0; DOF];
        let mut remaining = [0.0; DOF];
        for joint in (0..DOF).rev() {
            // The joint axis is angular z, the last component.
            column[joint] = inertia[joint].column(5).into_owned();
            effective[joint] = column[joint][5];
            remaining[joint] = tau[joint] - force_bias[joint][5];
            if joint > 0 {
                let articulated =
                    inertia[joint] - column[joint] * column[joint].transpose() / effective[joint];
                let bias = force_bias[joint]
                    + articulated * speed_bias[joint]
                    + column[joint] * (remaining[joint] / effective[joint]);
                inertia[joint - 1] += motion[joint].transpose() * articulated * motion[joint];
                force_bias[joint - 1] += motion[joint].transpose() * bias;
            }
        }

        let mut acceleration = stacked(-self.gravity, Vector3::zeros());
        let mut qdd = JointAccelerations::ZERO;
        for joint in 0..DOF {
            acceleration = motion[joint] * acceleration + speed_bias[joint];
            qdd[joint] = (remaining[joint] - column[joint].dot(&acceleration)) / effective[joint];
            acceleration[5] += qdd[joint];
        }
        qdd
    }
}

fn stacked(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

fn cross_matrix(v: &Vector3<f64>) -> Matrix3<f64> {
    v.cross_matrix()
}

fn blocks(
    top_left: &Matrix3<f64>,
    top_right: &Matrix3<f64>,
    bottom_left: &Matrix3<f64>,
    bottom_right: &Matrix3<f64>,
) -> Matrix6<f64> {
    let mut m = Matrix6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(top_left);
    m.fixed_view_mut::<3, 3>(0, 3).copy_from(top_right);
    m.fixed_view_mut::<3, 3>(3, 0).copy_from(bottom_left);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(bottom_right);
    m
}

/// Takes the parent's (linear, angular) acceleration to the child's origin and axes: a' = Rᵀ(a - r × α), α' = Rᵀ α.
fn link_motion(parent_from_child: &Pose) -> Matrix6<f64> {
    let r = parent_from_child.rotation.matrix().transpose();
    blocks(
        &r,
        &(-r * cross_matrix(&parent_from_child.translation)),
        &Matrix3::zeros(),
        &r,
    )
}

/// Maps (linear, angular) acceleration of the joint frame to (force, moment about its origin).
fn spatial_inertia(body: &RigidBody) -> Matrix6<f64> {
    let first_moment = cross_matrix(&(body.com * body.mass));
    blocks(
        &(Matrix3::identity() * body.mass),
        &-first_moment,
        &first_moment,
        &body.inertia_about(Vector3::zeros()),
    )
}
