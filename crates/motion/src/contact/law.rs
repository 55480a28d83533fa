//! The force of a contact: stiffness, damping and friction of the obstacle, as an impulse that knows its own effect.
//!
//! Normal: F = k d + c d', never pulling, with d the depth at the end of the step. The depth depends on the force: both
//! are solved for together (projected Gauss-Seidel over all places), so that any stiffness is stable at any step, and
//! an arm at rest reads exactly k d. Friction: Coulomb's, with a viscous core below [`FRICTION_REGULARIZATION_SPEED`].
//! Bodies that touch in several places share the stiffness in proportion to the depths there: together they push with k
//! times the greatest depth. Dry friction of the joints is solved for in the same rounds.

use kinematics::{DOF, Frames, JointSpeeds, JointTorques, Wrench};
use motion_api::MAX_GRIPPERS;
use nalgebra::{Cholesky, Const, Matrix3x6, Matrix6, Matrix6x3, Vector3, Vector6};

use super::{ArmPart, Contact, ContactList, MAX_CONTACTS, Obstacle};
use kinematics::bounds::within;

/// Stiffness of an obstacle without one, N/m: 100 N press it in by a micrometre.
pub const RIGID_STIFFNESS: f64 = 1e8;
/// How fast a hard obstacle pushes out what is inside it already, m/s.
const MAX_RECOVERY_SPEED: f64 = 0.5;
/// Speed at which friction reaches Coulomb's, m/s.
pub const FRICTION_REGULARIZATION_SPEED: f64 = 1e-5;
/// Most rounds over all places, and the change of a force at which they end, N.
const ROUNDS: usize = 60;
const FORCE_TOLERANCE: f64 = 1e-7;

/// How the arm answers to forces within the step.
pub(crate) struct ArmResponse {
    /// The mass matrix, factored.
    pub mass: Cholesky<f64, Const<6>>,
    /// Length of the step, s.
    pub step: f64,
    /// Largest dry friction of the joints, and what it was a step ago, Nm.
    pub dry_friction: Option<(JointTorques, JointTorques)>,
}

/// What the contacts do to the arm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactForces {
    /// Force on the arm at each place, N, base axes; in the order of the touches.
    pub forces: [Vector3<f64>; MAX_CONTACTS],
    /// What touches the tool: base axes, about the TCP.
    pub tool: Wrench,
    /// The share of `tool` that touches the part in each gripper.
    pub held: [Wrench; MAX_GRIPPERS],
    /// Joint torques of what touches the tool, Nm.
    pub tool_torque: JointTorques,
    /// Joint torques of everything that touches the arm, Nm.
    pub torque: JointTorques,
    /// Torques of dry friction on the joints, Nm.
    pub friction: JointTorques,
    /// Speeds of the joints at the end of the step, rad/s.
    pub speeds: JointSpeeds,
}

impl ContactForces {
    /// Nothing touches.
    pub(crate) const NONE: Self = Self {
        forces: [Vector3::new(0.0, 0.0, 0.0); MAX_CONTACTS],
        tool: Wrench {
            force: Vector3::new(0.0, 0.0, 0.0),
            moment: Vector3::new(0.0, 0.0, 0.0),
        },
        held: [Wrench {
            force: Vector3::new(0.0, 0.0, 0.0),
            moment: Vector3::new(0.0, 0.0, 0.0),
        }; MAX_GRIPPERS],
        tool_torque: JointTorques::ZERO,
        torque: JointTorques::ZERO,
        friction: JointTorques::ZERO,
        speeds: JointSpeeds::ZERO,
    };
}

/// One place as the solver sees it.
#[derive(Clone, Copy)]
struct ContactRow {
    jacobian: Matrix3x6<f64>,
    /// Change of the joint speeds by a force of 1 N over the step.
    effect: Matrix6x3<f64>,
    /// Compliance of the arm along the normal and across it, (m/s)/N.
    normal: f64,
    tangential: f64,
    depth: f64,
    stiffness: f64,
    damping: f64,
    friction: f64,
}

/// Dry friction of the joints: Coulomb's, which holds a joint up to its size and opposes its turning with it.
struct JointFriction {
    max_torque: JointTorques,
    torque: JointTorques,
    /// Change of the joint speeds by a torque of 1 Nm over the step, a column a joint.
    effect: Matrix6<f64>,
}

impl JointFriction {
    fn new(answer: &ArmResponse) -> Option<Self> {
        let (most, before) = answer.dry_friction?;
        Some(Self {
            max_torque: most,
            torque: before,
            effect: answer.mass.inverse() * answer.step,
        })
    }

    /// Turns each joint's torque to what stops it, or to its most; the largest change, Nm.
    fn relax(&mut self, speeds: &mut Vector6<f64>) -> f64 {
        let mut change = 0.0_f64;
        for joint in 0..DOF {
            let most = self.max_torque[joint];
            if most == 0.0 {
                continue;
            }
            let stopping = self.torque[joint] - speeds[joint] / self.effect[(joint, joint)];
            let next = within(stopping, -most, most);
            let more = next - self.torque[joint];
            *speeds += self.effect.column(joint) * more;
            self.torque[joint] = next;
            change = change.max(more.abs());
        }
        change
    }
}

/// Forces on the arm at `touches`: on one that answers within the step, or on one that moves with `qd` whatever they
/// are. `frames` say where it is, `tcp` where moments are about, base frame.
pub(crate) fn solve(
    touches: &ContactList,
    obstacles: &[Obstacle],
    frames: &Frames,
    tcp: Vector3<f64>,
    qd: &JointSpeeds,
    answer: Option<&ArmResponse>,
) -> ContactForces {
    let touches = touches.as_slice();
    let mut bearings = answer.and_then(JointFriction::new);
    if touches.is_empty() && bearings.is_none() {
        return ContactForces::NONE;
    }
    let step = answer.map_or(0.0, |answer| answer.step);
    let mut speeds = qd.to_vector();
    let mut rows = [const { None::<ContactRow> }; MAX_CONTACTS];
    let mut depths = [0.0_f64; MAX_CONTACTS];
    let of_rows = (&mut rows, &mut depths);
    build_rows(touches, obstacles, frames, &speeds, answer, of_rows);
    let mut forces = ContactForces::NONE;
    if let Some(bearings) = &bearings {
        speeds += bearings.effect * bearings.torque.to_vector();
    }
    // Shared by the depths that would be reached without contact, then by those that are.
    for _ in 0..2 {
        distribute_stiffness(touches, obstacles, &depths, &mut rows);
        for _ in 0..ROUNDS {
            let mut change = 0.0_f64;
            for (k, touch) in touches.iter().enumerate() {
                let Some(row) = &rows[k] else { continue };
                let next = row.updated_force(&touch.place.normal, &forces.forces[k], &speeds, step);
                let more = next - forces.forces[k];
                speeds += row.effect * more;
                forces.forces[k] = next;
                change = change.max(more.amax());
            }
            if let Some(bearings) = &mut bearings {
                change = change.max(bearings.relax(&mut speeds));
            }
            if change < FORCE_TOLERANCE || answer.is_none() {
                break;
            }
        }
        if answer.is_none() || touches.len() <= 1 {
            break;
        }
        for (k, touch) in touches.iter().enumerate() {
            let Some(row) = &rows[k] else { continue };
            depths[k] = row.depth - step * touch.place.normal.dot(&(row.jacobian * speeds));
        }
    }
    forces.sum_forces(touches, &rows, tcp);
    forces.friction = bearings.map_or(JointTorques::ZERO, |bearings| bearings.torque);
    forces.speeds = speeds.into();
    forces
}

impl ContactForces {
    /// What the forces at the places come to.
    fn sum_forces(
        &mut self,
        touches: &[Contact],
        rows: &[Option<ContactRow>; MAX_CONTACTS],
        tcp: Vector3<f64>,
    ) {
        let (mut all, mut tool) = (Vector6::zeros(), Vector6::zeros());
        for (k, touch) in touches.iter().enumerate() {
            let Some(row) = &rows[k] else { continue };
            let force = self.forces[k];
            let torque = row.jacobian.transpose() * force;
            all += torque;
            if matches!(touch.part, ArmPart::Link(_)) {
                continue;
            }
            tool += torque;
            let moment = (touch.place.point - tcp).cross(&force);
            self.tool.force += force;
            self.tool.moment += moment;
            if let ArmPart::Held(slot) = touch.part {
                self.held[slot].force += force;
                self.held[slot].moment += moment;
            }
        }
        self.torque = JointTorques(all.into());
        self.tool_torque = JointTorques(tool.into());
    }
}

/// The places that would be touched at the end of the step if nothing pushed back, and how deep all would be then.
/// Filled in where they are: eight kilobytes to be copied are as much as a round of the search.
fn build_rows(
    touches: &[Contact],
    obstacles: &[Obstacle],
    frames: &Frames,
    speeds: &Vector6<f64>,
    answer: Option<&ArmResponse>,
    (rows, depths): (
        &mut [Option<ContactRow>; MAX_CONTACTS],
        &mut [f64; MAX_CONTACTS],
    ),
) {
    let step = answer.map_or(0.0, |answer| answer.step);
    for (k, touch) in touches.iter().enumerate() {
        let mut jacobian: Matrix3x6<f64> =
            frames.jacobian(touch.place.point).fixed_rows::<3>(0).into();
        for joint in touch.part.link() + 1..DOF {
            jacobian.set_column(joint, &Vector3::zeros());
        }
        let normal = touch.place.normal;
        // What would be reached at the end of the step if nothing pushed back.
        depths[k] = touch.place.depth - step * normal.dot(&(jacobian * speeds));
        if depths[k] <= 0.0 {
            continue;
        }
        let obstacle = &obstacles[touch.obstacle];
        let effect = answer.map_or_else(Matrix6x3::zeros, |answer| {
            answer.mass.solve(&jacobian.transpose()) * answer.step
        });
        let compliance = jacobian * effect;
        let along = normal.dot(&(compliance * normal));
        let depth = match (obstacle.stiffness, answer) {
            (None, Some(_)) => touch.place.depth.min(MAX_RECOVERY_SPEED * step),
            _ => touch.place.depth,
        };
        rows[k] = Some(ContactRow {
            jacobian,
            effect,
            normal: along,
            tangential: compliance.trace() - along,
            depth,
            stiffness: 0.0,
            damping: 0.0,
            friction: obstacle.friction,
        });
    }
}

/// Shares the stiffness and damping of an obstacle among the places where one part touches it, in proportion to
/// `depths`.
fn distribute_stiffness(
    touches: &[Contact],
    obstacles: &[Obstacle],
    depths: &[f64; MAX_CONTACTS],
    rows: &mut [Option<ContactRow>; MAX_CONTACTS],
) {
    for (k, touch) in touches.iter().enumerate() {
        let Some(row) = &mut rows[k] else { continue };
        let (mut sum, mut most) = (0.0_f64, 0.0_f64);
        for (other, depth) in touches.iter().zip(depths) {
            if other.part == touch.part && is_one_body(obstacles, other.obstacle, touch.obstacle) {
                sum += depth.max(0.0);
                most = most.max(*depth);
            }
        }
        if most <= 0.0 {
            // Pushed out altogether: as it was shared before.
            continue;
        }
        // The place's own share of the force is depth / sum of k times the greatest depth.
        let share = if depths[k] > 0.0 { most / sum } else { 0.0 };
        let obstacle = &obstacles[touch.obstacle];
        row.stiffness = obstacle.stiffness.unwrap_or(RIGID_STIFFNESS) * share;
        // Damping begins with the touch, not with the step in which it will come.
        row.damping = if touch.place.depth > 0.0 {
            obstacle.damping * share
        } else {
            0.0
        };
    }
}

/// Whether two obstacles, by index, are the same or pieces of one body.
fn is_one_body(obstacles: &[Obstacle], a: usize, b: usize) -> bool {
    a == b || obstacles[a].body.is_some() && obstacles[a].body == obstacles[b].body
}

impl ContactRow {
    /// The force that goes with the present speeds, when it was `force` that made them.
    fn updated_force(
        &self,
        normal: &Vector3<f64>,
        force: &Vector3<f64>,
        speeds: &Vector6<f64>,
        step: f64,
    ) -> Vector3<f64> {
        let speed = self.jacobian * speeds;
        let (away, pushing) = (normal.dot(&speed), normal.dot(force));
        let drag = self.stiffness * step + self.damping;
        let wanted = self.stiffness * self.depth - drag * away;
        let pushing = (pushing + (wanted - pushing) / (1.0 + drag * self.normal)).max(0.0);
        let most = self.friction * pushing;
        let across = speed - normal * away;
        let grip = most / FRICTION_REGULARIZATION_SPEED;
        let rubbing = force - normal * normal.dot(force);
        let rubbing = rubbing - (across * grip + rubbing) / (1.0 + grip * self.tangential);
        let norm = rubbing.norm();
        let rubbing = if norm > most {
            rubbing * (most / norm)
        } else {
            rubbing
        };
        normal * pushing + rubbing
    }
}
