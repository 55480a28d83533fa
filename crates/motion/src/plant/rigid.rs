//! The rigid arm: six links with what hangs on the flange, moved by the servo's torques, by hands and by what they
//! touch.
//!
//! Owns the servo steps within a cycle. The bodies are moved by our own equations of motion, or by an engine of others
//! (`rapier`) that judges them. Semi-implicit: speeds first, then positions with the new speeds, so that an arm whose
//! torques are found with the same masses stays on its targets to the last digits.

use kinematics::chain::{Chain, Frames};
use kinematics::{
    DOF, Dynamics, JointPositions, JointSpeeds, JointTorques, Payload, RobotModel, Wrench,
};
use messages::text;
use nalgebra::{Vector3, Vector6};

use super::rapier::RapierBodies;
use super::real_arm::{PlantDynamics, StepPosture};
use super::servo::{CubicInterpolation, JointServo};
use super::{ArmState, ToolWrench};
use crate::config::ConfigError;
use crate::constants::{DISTURBANCE_COMPENSATION, SERVO_STEP};
use crate::contact::law::{self, ArmResponse, ContactForces};
use crate::contact::{ContactList, ContactModel};
use crate::setpoint::{LimitedSetpoint, Setpoint};

/// The arm as rigid bodies.
pub struct RigidPlant {
    arm: PlantDynamics,
    /// `None`: our own equations.
    engine: Option<RapierBodies>,
    chain: Chain,
    servo: JointServo,
    target: Setpoint,
    state: ArmState,
    push: ToolWrench,
    /// Torques of dry friction in the last step, Nm: where the next search for them begins.
    friction: JointTorques,
}

/// Where the arm is at the beginning of a step, the TCP (base frame, m), and the joint torques of the hand, Nm.
struct StepContext {
    frames: Frames,
    tcp: Vector3<f64>,
    hand: JointTorques,
    /// Part of the cycle that the step is.
    share: f64,
}

impl RigidPlant {
    /// The arm at rest at `q`, moved by our own equations.
    ///
    /// # Errors
    /// [`ConfigError::Plant`] when a link has no mass.
    pub(super) fn new(
        model: &RobotModel,
        arm: PlantDynamics,
        q: &JointPositions,
    ) -> Result<Self, ConfigError> {
        if arm.dynamics().bodies().iter().any(|link| link.mass <= 0.0) {
            return Err(ConfigError::Plant {
                what: text!("a moving link has no mass", "有运动的连杆没有质量"),
            });
        }
        let mut plant = Self {
            arm,
            engine: None,
            chain: *model.chain(),
            servo: JointServo::new(&model.limits().effort, q),
            target: Setpoint::standing(*q),
            state: ArmState::RESTING,
            push: ToolWrench::default(),
            friction: JointTorques::ZERO,
        };
        plant.reset(q);
        Ok(plant)
    }

    /// An arm of rigid bodies in the rapier engine; `gravity` is the free-fall acceleration in the base frame, m/s².
    ///
    /// # Errors
    /// [`ConfigError::Plant`] when a link has no mass, when the engine cannot join the links, or for what it does not
    /// know.
    pub(super) fn in_rapier(
        model: &RobotModel,
        arm: PlantDynamics,
        gravity: &Vector3<f64>,
        q: &JointPositions,
    ) -> Result<Self, ConfigError> {
        if !arm.is_without_losses() {
            return Err(ConfigError::Plant {
                what: text!(
                    "the plant \"rapier\" knows no friction and no rotors, which [arm] asks for; the plant \
                     \"rigid\" does",
                    "仿真模型 \"rapier\" 没有 [arm] 要求的摩擦和转子；仿真模型 \"rigid\" 有"
                ),
            });
        }
        let mut plant = Self::new(model, arm, q)?;
        plant.engine = Some(RapierBodies::new(model, arm.dynamics(), gravity)?);
        plant.reset(q);
        Ok(plant)
    }

    /// Puts the arm at rest at `q`.
    pub(super) fn reset(&mut self, q: &JointPositions) {
        if let Some(engine) = &mut self.engine {
            engine.reset(q);
        }
        self.reset_at_rest(q);
    }

    /// Forgets the target that the arm was on the way to: from now on that is `q`.
    pub(super) fn retarget(&mut self, q: &JointPositions) {
        self.servo.reset(q);
        self.target = Setpoint::standing(*q);
    }

    fn reset_at_rest(&mut self, q: &JointPositions) {
        self.retarget(q);
        self.servo.set_disturbance(JointTorques::ZERO);
        self.state.q = *q;
        self.state.qd = JointSpeeds::ZERO;
        self.friction = JointTorques::ZERO;
    }

    /// What pushes the tool from now on.
    pub(super) fn set_tool_wrench(&mut self, push: &ToolWrench) {
        self.push = *push;
    }

    /// The controller was told another payload or gravity.
    pub(super) fn set_controller_model(&mut self, believed: &Dynamics, gravity: &Vector3<f64>) {
        self.arm.set_controller_model(believed, gravity);
        if let Some(engine) = &mut self.engine {
            engine.set_masses(self.arm.dynamics(), gravity);
        }
    }

    /// What hangs on the flange has changed.
    pub(super) fn set_actual_payload(&mut self, payload: &Payload) {
        self.arm.set_actual_payload(payload);
        if let Some(engine) = &mut self.engine {
            engine.set_masses(self.arm.dynamics(), self.arm.gravity());
        }
    }

    /// One cycle of `step` seconds under servo control.
    pub(super) fn step_to_target(
        &mut self,
        target: &LimitedSetpoint,
        believed: &Dynamics,
        contacts: &mut ContactModel,
        step: f64,
    ) -> ArmState {
        let way = CubicInterpolation::new(self.target, *target.as_setpoint(), step);
        let servo_steps = (step / SERVO_STEP).round().max(1.0);
        let servo_step = step / servo_steps;
        let is_left_alone = contacts.is_empty()
            && self.push.is_nothing()
            && self.engine.is_none()
            && self.arm.coulomb().is_none();
        let mut mean_torque = JointTorques::ZERO;
        let mut contact = Wrench::default();
        for k in 1..=servo_steps as u32 {
            let next = way.positions(f64::from(k) * servo_step);
            let ArmState { q, qd, .. } = self.state;
            let at = StepPosture::new(self.chain.posture(&q));
            let by = if is_left_alone {
                None
            } else {
                Some(self.step_context(&at, 1.0 / servo_steps))
            };
            let hand = by.as_ref().map_or(JointTorques::ZERO, |by| by.hand);
            let servo = &mut self.servo;
            let arm = (&self.arm, &at);
            let torque = servo.torques(believed, arm, (&q, &qd), next, &hand, servo_step);
            let pressing = self.advance(&torque, (&at, by.as_ref()), contacts, servo_step);
            self.servo
                .update_disturbance(&self.arm, &at, (&qd, &self.state.qd), servo_step);
            contact.force += pressing.force / servo_steps;
            contact.moment += pressing.moment / servo_steps;
            for joint in 0..DOF {
                mean_torque[joint] += torque[joint] / servo_steps;
            }
            self.state.torque = torque;
        }
        self.state.mean_torque = mean_torque;
        self.state.contact = contact;
        self.target = *target.as_setpoint();
        self.state
    }

    /// Where the arm is, and the hand on it.
    fn step_context(&self, at: &StepPosture, share: f64) -> StepContext {
        let frames = self.chain.frames(&at.posture);
        let (tcp, hand) = self.push.at(&frames);
        StepContext {
            frames,
            tcp,
            hand,
            share,
        }
    }

    /// Moves the bodies, which are in the posture `at`, by `step` seconds under the drives' `torque`; without `around`
    /// nothing else acts on them.
    /// What touches the tool: base axes, about the TCP.
    fn advance(
        &mut self,
        torque: &JointTorques,
        (at, around): (&StepPosture, Option<&StepContext>),
        contacts: &mut ContactModel,
        step: f64,
    ) -> Wrench {
        let Some(around) = around else {
            self.step_without_contact(at, torque, step);
            return Wrench::default();
        };
        let touches = contacts.find_contacts(&around.frames, &self.push.flange_from_tcp);
        let pushing = JointTorques(core::array::from_fn(|j| torque[j] + around.hand[j]));
        let is_held = !touches.as_slice().is_empty() || self.arm.coulomb().is_some();
        let forces = if is_held {
            self.solve_contacts(contacts, &touches, (at, around), &pushing, step)
        } else {
            None
        };
        if let Some(engine) = &mut self.engine {
            let forces = forces.unwrap_or(ContactForces::NONE);
            let by = (&self.push, around.tcp);
            let links = &self.push.link_torques;
            let torque = JointTorques(core::array::from_fn(|j| torque[j] + links[j]));
            let (q, qd) = engine.step(&torque, by, (&touches, &forces), &around.frames, step);
            (self.state.q, self.state.qd) = (q, qd);
            return forces.tool;
        }
        let Some(forces) = forces else {
            self.step_without_contact(at, &pushing, step);
            return Wrench::default();
        };
        self.friction = forces.friction;
        self.integrate(forces.speeds, step);
        forces.tool
    }

    fn step_without_contact(&mut self, at: &StepPosture, torque: &JointTorques, step: f64) {
        let ArmState { qd, .. } = self.state;
        let qdd = self.arm.accelerations(at, &qd, torque, step);
        let speeds = JointSpeeds(core::array::from_fn(|j| qd[j] + step * qdd[j]));
        self.integrate(speeds, step);
    }

    fn integrate(&mut self, speeds: JointSpeeds, step: f64) {
        let q = self.state.q;
        self.state.qd = speeds;
        self.state.q = JointPositions(core::array::from_fn(|j| q[j] + step * speeds[j]));
    }

    /// The forces of obstacles and dry friction over the next `step` seconds, in which drives and hand give `torque`,
    /// and the speeds behind them. `None` where nothing can be said: a diverged plant, which the cycle stops.
    fn solve_contacts(
        &self,
        contacts: &mut ContactModel,
        touches: &ContactList,
        (at, around): (&StepPosture, &StepContext),
        torque: &JointTorques,
        step: f64,
    ) -> Option<ContactForces> {
        let ArmState { qd, .. } = self.state;
        let mass = self.arm.implicit_mass_matrix(at, step).cholesky()?;
        let bias = self.arm.bias(at, &qd);
        let net = Vector6::from_fn(|joint, _| torque[joint] - bias[joint]);
        let free = JointSpeeds((qd.to_vector() + mass.solve(&net) * step).into());
        let coulomb = self.arm.coulomb().copied();
        let answer = ArmResponse {
            mass,
            step,
            dry_friction: coulomb.map(|most| (most, self.friction)),
        };
        let obstacles = &contacts.obstacles;
        let StepContext {
            frames, tcp, share, ..
        } = around;
        let forces = law::solve(touches, obstacles, frames, *tcp, &free, Some(&answer));
        contacts.add_held_forces(&forces, *share);
        Some(forces)
    }

    /// One cycle with the brakes engaged: no time passes for the bodies. The servo will take over with what holds the
    /// arm now.
    pub(super) fn step_with_brakes(
        &mut self,
        believed: &Dynamics,
        contacts: &mut ContactModel,
    ) -> ArmState {
        if self.state.qd != JointSpeeds::ZERO
            && let Some(engine) = &mut self.engine
        {
            engine.halt();
        }
        let q = self.state.q;
        self.reset_at_rest(&q);
        self.state.torque = self.arm.dynamics().gravity_torques(&q);
        self.state.mean_torque = self.state.torque;
        let standing = JointSpeeds::ZERO;
        let pressing = contacts.forces_at(&q, &standing, &self.push.flange_from_tcp);
        contacts.add_held_forces(&pressing, 1.0);
        self.state.contact = pressing.tool;
        let at = StepPosture::new(self.chain.posture(&q));
        let StepContext { hand, .. } = self.step_context(&at, 1.0);
        let thought = believed.gravity_torques(&q);
        let torque = &self.state.torque;
        self.servo
            .set_disturbance(JointTorques(core::array::from_fn(|j| {
                thought[j] - torque[j]
                    + pressing.tool_torque[j]
                    + (1.0 - DISTURBANCE_COMPENSATION) * hand[j]
            })));
        self.state
    }
}
