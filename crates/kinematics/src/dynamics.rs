//! Rigid-body dynamics of the arm with its payload: inverse dynamics, gravity torques, mass matrix, forward dynamics.
//!
//! Owns the recursions; quantities of link i are in the axes of joint frame i with moments about its origin. No
//! friction, no rotor inertia, no contact: an outside wrench w at the tool adds -Jᵀ w to the torques.
//! Symbols as in Featherstone, *Rigid Body Dynamics Algorithms*, 2008, chapters 5 to 7.

use crate::chain::{Chain, Posture};
use crate::composite::Composite;
use crate::joint::{DOF, JointAccelerations, JointPositions, JointSpeeds, JointTorques};
use crate::matrix3::{product, times, transposed_times};
use crate::payload::{Payload, RigidBody};
use crate::pose::Pose;
use nalgebra::{Matrix3, Matrix6, Vector3};

/// Free-fall acceleration in the frame of a base that stands upright, m/s².
///
/// Points down. The script call `set_gravity` (manual 3.1.16) takes the opposite, the direction away from the ground.
pub const GRAVITY_UPRIGHT: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// The dynamics of an arm with a given payload and mounting. Cheap to make, fixed size.
#[derive(Clone, Copy, Debug)]
pub struct Dynamics {
    chain: Chain,
    bodies: [RigidBody; DOF],
    /// The bodies, each about the origin of its joint.
    about_origin: [Composite; DOF],
    gravity: Vector3<f64>,
}

/// A force and a moment about the joint frame's origin, or an acceleration of that origin and an angular one.
#[derive(Clone, Copy, Default)]
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

    /// What of [`Self::to_parent`] turns about the parent's z axis.
    #[inline]
    fn about_parent_z(self, parent_from_child: &Pose) -> f64 {
        let linear = parent_from_child.rotate(self.linear);
        parent_from_child.rotate(self.angular).z + parent_from_child.translation.cross(&linear).z
    }

    /// An acceleration of the parent, of the point under the child's origin and in the child's axes.
    #[inline]
    fn to_child(self, parent_from_child: &Pose) -> Self {
        let arm = &parent_from_child.translation;
        Self {
            linear: parent_from_child.rotate_back(self.linear + self.angular.cross(arm)),
            angular: parent_from_child.rotate_back(self.angular),
        }
    }

    /// Power of a wrench, or what it is with acceleration in place of speed.
    fn dot(&self, other: &Self) -> f64 {
        self.linear.dot(&other.linear) + self.angular.dot(&other.angular)
    }
}

impl core::ops::Add for Spatial {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            linear: self.linear + other.linear,
            angular: self.angular + other.angular,
        }
    }
}

impl core::ops::Mul<f64> for Spatial {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self {
            linear: self.linear * factor,
            angular: self.angular * factor,
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
        let about_origin = core::array::from_fn(|joint| Composite::from(&bodies[joint]));
        Self {
            chain,
            bodies,
            about_origin,
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
        self.inverse_dynamics_at(&self.chain.posture(q), qd, qdd)
    }

    /// [`Self::inverse_dynamics`] of a posture.
    pub fn inverse_dynamics_at(
        &self,
        posture: &Posture,
        qd: &JointSpeeds,
        qdd: &JointAccelerations,
    ) -> JointTorques {
        let [torques] = self.newton_euler(posture, qd, [qdd]);
        torques
    }

    /// [`Self::inverse_dynamics`] and [`Self::bias_torques`] at once, which takes little longer than one of them.
    pub fn inverse_dynamics_and_bias(
        &self,
        posture: &Posture,
        qd: &JointSpeeds,
        qdd: &JointAccelerations,
    ) -> [JointTorques; 2] {
        self.newton_euler(posture, qd, [qdd, &JointAccelerations::ZERO])
    }

    /// The torques for several accelerations at the same speeds.
    fn newton_euler<const N: usize>(
        &self,
        Posture(transforms): &Posture,
        qd: &JointSpeeds,
        qdd: [&JointAccelerations; N],
    ) -> [JointTorques; N] {
        let mut omega = Vector3::zeros();
        let mut alpha = [Vector3::zeros(); N];
        // Accelerating the base upwards is the same as gravity on every link.
        let mut acceleration = [-self.gravity; N];
        let mut wrenches = [[Spatial::ZERO; N]; DOF];
        for joint in 0..DOF {
            let parent_from_joint = &transforms[joint];
            let arm = &parent_from_joint.translation;
            let body = &self.bodies[joint];
            // What follows from the speeds alone.
            let inwards = omega.cross(&omega.cross(arm));
            omega = parent_from_joint.rotate_back(omega);
            // The joint turns about z: omega × (z qd) has no z component.
            let (turned_x, turned_y) = (omega.y * qd[joint], -omega.x * qd[joint]);
            omega.z += qd[joint];
            let inwards_of_body = omega.cross(&omega.cross(&body.com));
            let gyroscopic = omega.cross(&times(&body.inertia, &omega));
            for lane in 0..N {
                let (alpha, acceleration) = (&mut alpha[lane], &mut acceleration[lane]);
                *acceleration += alpha.cross(arm) + inwards;
                *acceleration = parent_from_joint.rotate_back(*acceleration);
                *alpha = parent_from_joint.rotate_back(*alpha);
                *alpha += Vector3::new(turned_x, turned_y, qdd[lane][joint]);

                let linear = (*acceleration + alpha.cross(&body.com) + inwards_of_body) * body.mass;
                let angular = times(&body.inertia, alpha) + gyroscopic + body.com.cross(&linear);
                wrenches[joint][lane] = Spatial { linear, angular };
            }
        }
        let mut torques = [JointTorques::ZERO; N];
        let mut carried = [Spatial::ZERO; N];
        for joint in (0..DOF).rev() {
            for lane in 0..N {
                let mut sum = carried[lane] + wrenches[joint][lane];
                torques[lane][joint] = sum.angular.z;
                if joint > 0 {
                    sum = sum.to_parent(&transforms[joint]);
                }
                carried[lane] = sum;
            }
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
        self.mass_matrix_at(&self.chain.posture(q))
    }

    /// [`Self::bias_torques`] of a posture.
    pub fn bias_torques_at(&self, posture: &Posture, qd: &JointSpeeds) -> JointTorques {
        let [bias] = self.newton_euler(posture, qd, [&JointAccelerations::ZERO]);
        bias
    }

    /// [`Self::mass_matrix`] of a posture.
    pub fn mass_matrix_at(&self, Posture(transforms): &Posture) -> Matrix6<f64> {
        let mut columns = [[0.0; DOF]; DOF];
        // Everything from this joint outwards, held rigid.
        let mut composite = Composite::default();
        for joint in (0..DOF).rev() {
            composite = self.about_origin[joint].joined_with(&composite);
            let (linear, angular) = composite.wrench_for_z_acceleration();
            let mut wrench = Spatial { linear, angular };
            columns[joint][joint] = wrench.angular.z;
            for inner in (1..joint).rev() {
                wrench = wrench.to_parent(&transforms[inner + 1]);
                columns[joint][inner] = wrench.angular.z;
                columns[inner][joint] = wrench.angular.z;
            }
            if joint > 0 {
                let about_base = wrench.about_parent_z(&transforms[1]);
                columns[joint][0] = about_base;
                columns[0][joint] = about_base;
            }
            if joint > 0 {
                composite = composite.in_parent(&transforms[joint]);
            }
        }
        Matrix6::from(columns)
    }

    /// Joint accelerations that the torques `tau` cause, rad/s². Articulated bodies (Featherstone 7.3).
    pub fn forward_dynamics(
        &self,
        q: &JointPositions,
        qd: &JointSpeeds,
        tau: &JointTorques,
    ) -> JointAccelerations {
        self.forward_dynamics_with_armature(q, qd, tau, &[0.0; DOF])
    }

    /// Joint accelerations (rad/s²) that the torques `tau` cause where each joint turns a rotor as well: `armature` is
    /// the rotors' inertia about the joint axes, kg m² (gear ratio squared times their own), whose gyroscopic effects
    /// are left out (Featherstone 9.6).
    pub fn forward_dynamics_with_armature(
        &self,
        q: &JointPositions,
        qd: &JointSpeeds,
        tau: &JointTorques,
        armature: &[f64; DOF],
    ) -> JointAccelerations {
        self.forward_dynamics_at(&self.chain.posture(q), qd, tau, armature)
    }

    /// [`Self::forward_dynamics_with_armature`] of a posture.
    pub fn forward_dynamics_at(
        &self,
        Posture(transforms): &Posture,
        qd: &JointSpeeds,
        tau: &JointTorques,
        armature: &[f64; DOF],
    ) -> JointAccelerations {
        // Outwards: what the speeds alone cause, an acceleration across each joint and a wrench on each link.
        let mut across = [Spatial::ZERO; DOF];
        let mut wrench = [Spatial::ZERO; DOF];
        let mut omega = Vector3::zeros();
        for joint in 0..DOF {
            let body = &self.bodies[joint];
            let arm = transforms[joint].rotate_back(transforms[joint].translation);
            omega = transforms[joint].rotate_back(omega);
            across[joint] = Spatial {
                linear: omega.cross(&omega.cross(&arm)),
                angular: Vector3::new(omega.y * qd[joint], -omega.x * qd[joint], 0.0),
            };
            omega.z += qd[joint];
            let linear = omega.cross(&omega.cross(&body.com)) * body.mass;
            let angular = omega.cross(&times(&body.inertia, &omega)) + body.com.cross(&linear);
            wrench[joint] = Spatial { linear, angular };
        }
        // Inwards: the inertia that each joint feels, everything beyond it free to turn.
        let mut felt = [JointInertia::default(); DOF];
        let mut inertia = ArticulatedInertia::ZERO;
        let mut carried = Spatial::ZERO;
        for joint in (0..DOF).rev() {
            inertia = inertia + ArticulatedInertia::of(&self.bodies[joint]);
            carried = carried + wrench[joint];
            let column = inertia.about_z();
            let effective = column.angular.z + armature[joint];
            let torque = tau[joint] - carried.angular.z;
            felt[joint] = JointInertia {
                column,
                inertia_about_axis: effective,
                torque,
            };
            let locked = inertia.project_out_z(&column, effective);
            carried = (carried + locked.wrench(&across[joint]) + column * (torque / effective))
                .to_parent(&transforms[joint]);
            inertia = locked.to_parent(&transforms[joint]);
        }
        // Outwards again: accelerations, with the base rising instead of everything falling.
        let mut acceleration = Spatial {
            linear: -self.gravity,
            angular: Vector3::zeros(),
        };
        let mut qdd = JointAccelerations::ZERO;
        for joint in 0..DOF {
            acceleration = acceleration.to_child(&transforms[joint]) + across[joint];
            let JointInertia {
                column,
                inertia_about_axis: effective,
                torque,
            } = &felt[joint];
            qdd[joint] = (torque - column.dot(&acceleration)) / effective;
            acceleration.angular.z += qdd[joint];
        }
        qdd
    }
}

/// What a joint feels of the arm beyond it.
#[derive(Clone, Copy, Default)]
struct JointInertia {
    /// Wrench for a unit angular acceleration about the joint axis.
    column: Spatial,
    /// Moment of `column` about the joint axis, kg m².
    inertia_about_axis: f64,
    /// Torque left for acceleration, Nm.
    torque: f64,
}

/// Inertia of an articulated body in a joint frame: force = A a + B α, moment = Bᵀ a + C α.
#[derive(Clone, Copy)]
struct ArticulatedInertia {
    a: Matrix3<f64>,
    b: Matrix3<f64>,
    c: Matrix3<f64>,
}

impl ArticulatedInertia {
    const ZERO: Self = {
        let zero = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        Self {
            a: zero,
            b: zero,
            c: zero,
        }
    };

    fn of(body: &RigidBody) -> Self {
        Self {
            a: Matrix3::from_diagonal_element(body.mass),
            b: -(body.com * body.mass).cross_matrix(),
            c: body.inertia_about(Vector3::zeros()),
        }
    }

    /// The wrench for a unit angular acceleration about z.
    fn about_z(&self) -> Spatial {
        let column = |m: &Matrix3<f64>| Vector3::new(m.m13, m.m23, m.m33);
        Spatial {
            linear: column(&self.b),
            angular: column(&self.c),
        }
    }

    /// The wrench that gives an acceleration.
    fn wrench(&self, acceleration: &Spatial) -> Spatial {
        let Spatial { linear, angular } = acceleration;
        Spatial {
            linear: times(&self.a, linear) + times(&self.b, angular),
            angular: transposed_times(&self.b, linear) + times(&self.c, angular),
        }
    }

    /// The inertia that is left when the body may turn freely about z.
    fn project_out_z(&self, column: &Spatial, effective: f64) -> Self {
        let (f, n) = (column.linear, column.angular);
        let (scaled_f, scaled_n) = ((f / effective).transpose(), (n / effective).transpose());
        Self {
            a: self.a - f * scaled_f,
            b: self.b - f * scaled_n,
            c: self.c - n * scaled_n,
        }
    }

    /// This inertia in the parent's axes about the parent's origin.
    fn to_parent(self, parent_from_child: &Pose) -> Self {
        let r = parent_from_child.rotation.matrix();
        let back = r.transpose();
        let turned = |m: &Matrix3<f64>| product(&product(r, m), &back);
        let arm = parent_from_child.translation.cross_matrix();
        let (a, b, c) = (turned(&self.a), turned(&self.b), turned(&self.c));
        let shifted = b - product(&a, &arm);
        Self {
            a,
            b: shifted,
            c: c + product(&arm, &shifted) - product(&b.transpose(), &arm),
        }
    }
}

impl core::ops::Add for ArticulatedInertia {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            a: self.a + other.a,
            b: self.b + other.b,
            c: self.c + other.c,
        }
    }
}
