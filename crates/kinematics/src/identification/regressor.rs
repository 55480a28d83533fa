//! Wrenches and torques as linear functions of mass properties.
//!
//! The parameters of a body, in some frame: mass m, first moments m c (x, y, z), and the inertia about the origin of
//! the frame (Ixx, Iyy, Izz, Ixy, Ixz, Iyz; the last three are elements of the tensor).

use nalgebra::{SMatrix, Vector3};

use crate::chain::Chain;
use crate::joint::{DOF, JointAccelerations, JointPositions, JointSpeeds};
use crate::pose::Pose;

/// Parameters of a body.
pub const BODY_PARAMETERS: usize = 10;

/// How a frame moves, in its own axes; gravity counts as an acceleration upwards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyMotion {
    /// Acceleration of the origin less that of free fall, m/s².
    pub acceleration: Vector3<f64>,
    /// Angular speed, rad/s.
    pub omega: Vector3<f64>,
    /// Angular acceleration, rad/s².
    pub alpha: Vector3<f64>,
}

impl BodyMotion {
    /// Of a frame that is fixed to this one.
    pub fn moved_to(&self, this_from_other: &Pose) -> Self {
        let arm = this_from_other.translation;
        let acceleration =
            self.acceleration + self.alpha.cross(&arm) + self.omega.cross(&self.omega.cross(&arm));
        Self {
            acceleration: this_from_other.rotate_back(acceleration),
            omega: this_from_other.rotate_back(self.omega),
            alpha: this_from_other.rotate_back(self.alpha),
        }
    }

    /// Of the tool flange.
    pub fn of_flange(
        chain: &Chain,
        q: &JointPositions,
        qd: &JointSpeeds,
        qdd: &JointAccelerations,
        gravity: Vector3<f64>,
    ) -> Self {
        let motions = joint_motions(chain, q, qd, qdd, gravity);
        motions[DOF - 1].1.moved_to(&chain.joint6_from_flange)
    }
}

/// The transforms and motions of the joint frames.
fn joint_motions(
    chain: &Chain,
    q: &JointPositions,
    qd: &JointSpeeds,
    qdd: &JointAccelerations,
    gravity: Vector3<f64>,
) -> [(Pose, BodyMotion); DOF] {
    let transforms = chain.joint_transforms(q);
    let mut motion = BodyMotion {
        acceleration: -gravity,
        ..BodyMotion::default()
    };
    core::array::from_fn(|joint| {
        motion = motion.moved_to(&transforms[joint]);
        let turned = Vector3::new(
            motion.omega.y * qd[joint],
            -motion.omega.x * qd[joint],
            qdd[joint],
        );
        motion.omega.z += qd[joint];
        motion.alpha += turned;
        (transforms[joint], motion)
    })
}

/// Force and moment about the origin that move a body so: `body_regressor(motion) * parameters`, force first.
pub fn body_regressor(motion: &BodyMotion) -> SMatrix<f64, 6, BODY_PARAMETERS> {
    let BodyMotion {
        acceleration: a,
        omega: w,
        alpha,
    } = *motion;
    let mut columns = SMatrix::<f64, 6, BODY_PARAMETERS>::zeros();
    columns.fixed_view_mut::<3, 1>(0, 0).copy_from(&a);
    for axis in 0..3 {
        let unit = Vector3::ith(axis, 1.0);
        let force = alpha.cross(&unit) + w.cross(&w.cross(&unit));
        columns
            .fixed_view_mut::<3, 1>(0, 1 + axis)
            .copy_from(&force);
        columns
            .fixed_view_mut::<3, 1>(3, 1 + axis)
            .copy_from(&unit.cross(&a));
    }
    for (column, (row, other)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
        .into_iter()
        .enumerate()
    {
        // The tensor with this one element, and its mirror, being 1.
        let times = |v: &Vector3<f64>| {
            let mut product = Vector3::zeros();
            product[row] += v[other];
            if row != other {
                product[other] += v[row];
            }
            product
        };
        let moment = times(&alpha) + w.cross(&times(&w));
        columns
            .fixed_view_mut::<3, 1>(3, 4 + column)
            .copy_from(&moment);
    }
    columns
}

/// Torques of the joints as a function of the parameters of all links, each in its joint frame: ten columns a link.
pub fn torque_regressor(
    chain: &Chain,
    q: &JointPositions,
    qd: &JointSpeeds,
    qdd: &JointAccelerations,
    gravity: Vector3<f64>,
) -> SMatrix<f64, DOF, 60> {
    let motions = joint_motions(chain, q, qd, qdd, gravity);
    let mut torques = SMatrix::<f64, DOF, 60>::zeros();
    for link in 0..DOF {
        let mut wrenches = body_regressor(&motions[link].1);
        for joint in (0..=link).rev() {
            for column in 0..BODY_PARAMETERS {
                torques[(joint, BODY_PARAMETERS * link + column)] = wrenches[(5, column)];
            }
            let parent_from_joint = motions[joint].0;
            for mut column in wrenches.column_iter_mut() {
                let force = parent_from_joint.rotate(Vector3::new(column[0], column[1], column[2]));
                let moment = parent_from_joint
                    .rotate(Vector3::new(column[3], column[4], column[5]))
                    + parent_from_joint.translation.cross(&force);
                for axis in 0..3 {
                    column[axis] = force[axis];
                    column[3 + axis] = moment[axis];
                }
            }
        }
    }
    torques
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::GRAVITY_UPRIGHT;
    use crate::model::RobotModel;
    use crate::payload::{Payload, RigidBody};

    fn parameters(body: &RigidBody) -> SMatrix<f64, BODY_PARAMETERS, 1> {
        let moments = body.com * body.mass;
        let i = body.inertia_about(Vector3::zeros());
        SMatrix::from_column_slice(&[
            body.mass, moments.x, moments.y, moments.z, i.m11, i.m22, i.m33, i.m12, i.m13, i.m23,
        ])
    }

    #[test]
    fn the_regressor_gives_the_torques_of_inverse_dynamics() {
        let payload = Payload::new(
            2.0,
            [0.01, -0.02, 0.05],
            [0.01, 0.012, 0.013, 0.001, 0.0, 0.002],
        )
        .unwrap();
        for name in ["cs63", "cs66", "cs625"] {
            let model = RobotModel::built_in(name).unwrap();
            let gravity = Vector3::new(1.0, -2.0, -9.5);
            let dynamics = model.dynamics(&payload, gravity);
            let mut all = SMatrix::<f64, 60, 1>::zeros();
            for (link, body) in dynamics.bodies().iter().enumerate() {
                all.fixed_view_mut::<10, 1>(10 * link, 0)
                    .copy_from(&parameters(body));
            }
            for k in 0..20 {
                let wave = |phase: f64| {
                    core::array::from_fn(|j| (f64::from(k) * 0.7 + phase + j as f64).sin() * 2.0)
                };
                let (q, qd, qdd) = (
                    JointPositions(wave(0.1)),
                    JointSpeeds(wave(1.3)),
                    JointAccelerations(wave(2.9)),
                );
                let expected = dynamics.inverse_dynamics(&q, &qd, &qdd);
                let found = torque_regressor(model.chain(), &q, &qd, &qdd, gravity) * all;
                for joint in 0..DOF {
                    assert!(
                        (found[joint] - expected[joint]).abs() < 1e-9,
                        "{name} {joint}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_resting_body_weighs_its_mass() {
        let model = RobotModel::built_in("cs66").unwrap();
        let q = JointPositions([0.3, -1.2, 1.4, -1.0, 0.5, 2.0]);
        let motion = BodyMotion::of_flange(
            model.chain(),
            &q,
            &JointSpeeds([0.0; DOF]),
            &JointAccelerations([0.0; DOF]),
            GRAVITY_UPRIGHT,
        );
        let force = body_regressor(&motion)
            .column(0)
            .fixed_rows::<3>(0)
            .into_owned();
        let up = model.flange_pose(&q).rotate(force);
        assert!((up - Vector3::new(0.0, 0.0, 9.81)).norm() < 1e-12);
    }
}
