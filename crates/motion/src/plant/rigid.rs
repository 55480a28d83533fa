//! The rigid arm: six links with what hangs on the flange, moved by the servo's torques, by hands and by what they touch.
//!
//! Owns the servo steps within a cycle. The bodies are moved by our own equations of motion, or by an engine of others
//! (`rapier`) that judges them. Semi-implicit: speeds first, then positions with the new speeds, so that an arm whose torques
//! are found with the same masses stays on its targets to the last digits.

use kinematics::chain::{Chain, Frames};
use kinematics::{DOF, Dynamics, JointPositions, JointSpeeds, JointTorques, RobotModel, Wrench};
use nalgebra::{Vector3, Vector6};

use super::rapier::RapierBodies;
use super::real_arm::RealArm;
use super::servo::{Interpolation, Servo};
use super::{ArmState, Push};
use crate::config::ConfigError;
use crate::constants::{FELT_SHARE, SERVO_STEP};
use crate::contact::law::{self, Answer, ContactForces};
use crate::contact::{Contacts, Touches};
use crate::setpoint::{LimitedSetpoint, Setpoint};

/// The arm as rigid bodies.
pub struct RigidPlant {
    arm: RealArm,
    /// `None`: our own equations.
    engine: Option<RapierBodies>,
    chain: Chain,
    servo: Servo,
    target: Setpoint,
    state: ArmState,
    push: Push,
    /// Torques of dry friction in the last step, Nm: where the next search for them begins.
    friction: JointTorques,
}

/// Where the arm is at the beginning of a step, the TCP (base frame, m), and the joint torques of the hand, Nm.
struct Around {
    frames: Frames,
    tcp: Vector3<f64>,
    hand: JointTorques,
}

impl RigidPlant {
    /// The arm at rest at `q`, moved by our own equations.
    ///
    /// # Errors
    /// [`ConfigError::Plant`] when a link has no mass.
    pub(super) fn new(
        model: &RobotModel,
        arm: RealArm,
        q: &JointPositions,
    ) -> Result<Self, ConfigError> {
        if arm.dynamics().bodies().iter().any(|link| link.mass <= 0.0) {
            return Err(ConfigError::Plant {
                what: "a moving link has no mass",
            });
        }
        let mut plant = Self {
            arm,
            engine: None,
            chain: *model.chain(),
            servo: Servo::new(&model.limits().effort, q),
            target: Setpoint::standing(*q),
            state: ArmState::RESTING,
            push: Push::default(),
            friction: JointTorques::ZERO,
        };
        plant.reset(q);
        Ok(plant)
    }

    /// The same in the rapier engine; `gravity` is the free-fall acceleration in the base frame, m/s².
    ///
    /// # Errors
    /// [`ConfigError::Plant`] when a link has no mass, when the engine cannot join the links, or for what it does not know.
    pub(super) fn in_rapier(
        model: &RobotModel,
        arm: RealArm,
        gravity: &Vector3<f64>,
        q: &JointPositions,
    ) -> Result<Self, ConfigError> {
        if !arm.is_without_losses() {
            return Err(ConfigError::Plant {
                what: "the plant \"rapier\" knows no friction and no rotors, which [arm] asks for; the plant \"rigid\" does",
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
        self.rest_at(q);
    }

    /// Forgets the target it was on the way to: it is wanted at `q` from now on.
    pub(super) fn retarget(&mut self, q: &JointPositions) {
        self.servo.rest_at(q);
        self.target = Setpoint::standing(*q);
    }

    fn rest_at(&mut self, q: &JointPositions) {
        self.retarget(q);
        self.servo.hold_against(JointTorques::ZERO);
        self.state.q = *q;
        self.state.qd = JointSpeeds::ZERO;
        self.friction = JointTorques::ZERO;
    }

    /// What pushes the tool from now on.
    pub(super) fn push(&mut self, push: &Push) {
        self.push = *push;
    }

    /// The controller was told another payload or gravity.
    pub(super) fn believe(&mut self, believed: &Dynamics, gravity: &Vector3<f64>) {
        self.arm.follow(believed, gravity);
        if let Some(engine) = &mut self.engine {
            engine.set_masses(self.arm.dynamics(), gravity);
        }
    }

    /// One cycle of `step` seconds under servo control.
    pub(super) fn follow(
        &mut self,
        target: &LimitedSetpoint,
        believed: &Dynamics,
        contacts: &mut Contacts,
        step: f64,
    ) -> ArmState {
        let way = Interpolation::new(self.target, *target.get(), step);
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
            let by = if is_left_alone {
                None
            } else {
                Some(self.around(&q))
            };
            let hand = by.as_ref().map_or(JointTorques::ZERO, |by| by.hand);
            let servo = &mut self.servo;
            let torque = servo.torques(believed, &self.arm, (&q, &qd), next, &hand, servo_step);
            let pressing = self.advance(&torque, by.as_ref(), contacts, servo_step);
            self.servo
                .feel(&self.arm, &q, (&qd, &self.state.qd), servo_step);
            contact.force += pressing.force / servo_steps;
            contact.moment += pressing.moment / servo_steps;
            for joint in 0..DOF {
                mean_torque[joint] += torque[joint] / servo_steps;
            }
            self.state.torque = torque;
        }
        self.state.mean_torque = mean_torque;
        self.state.contact = contact;
        self.target = *target.get();
        self.state
    }

    /// Where the arm is, and the hand on it.
    fn around(&self, q: &JointPositions) -> Around {
        let frames = self.chain.forward(q);
        let (tcp, hand) = self.push.at(&frames);
        Around { frames, tcp, hand }
    }

    /// Moves the bodies by `step` seconds under the drives' `torque`; without `around` nothing else acts on them. What touches
    /// the tool: base axes, about the TCP.
    fn advance(
        &mut self,
        torque: &JointTorques,
        around: Option<&Around>,
        contacts: &mut Contacts,
        step: f64,
    ) -> Wrench {
        let Some(around) = around else {
            self.move_freely(torque, step);
            return Wrench::default();
        };
        let touches = contacts.touches(&around.frames, &self.push.flange_from_tcp);
        let pushing = JointTorques(core::array::from_fn(|j| torque[j] + around.hand[j]));
        let is_held = !touches.as_slice().is_empty() || self.arm.coulomb().is_some();
        let forces = if is_held {
            self.press(contacts, &touches, around, &pushing, step)
        } else {
            None
        };
        if let Some(engine) = &mut self.engine {
            let forces = forces.unwrap_or(ContactForces::NONE);
            let by = (&self.push, around.tcp);
            let (q, qd) = engine.step(torque, by, (&touches, &forces), &around.frames, step);
            (self.state.q, self.state.qd) = (q, qd);
            return forces.tool;
        }
        let Some(forces) = forces else {
            self.move_freely(&pushing, step);
            return Wrench::default();
        };
        self.friction = forces.friction;
        self.move_with(forces.speeds, step);
        forces.tool
    }

    fn move_freely(&mut self, torque: &JointTorques, step: f64) {
        let ArmState { q, qd, .. } = self.state;
        let qdd = self.arm.accelerations(&q, &qd, torque, step);
        let speeds = JointSpeeds(core::array::from_fn(|j| qd[j] + step * qdd[j]));
        self.move_with(speeds, step);
    }

    fn move_with(&mut self, speeds: JointSpeeds, step: f64) {
        let q = self.state.q;
        self.state.qd = speeds;
        self.state.q = JointPositions(core::array::from_fn(|j| q[j] + step * speeds[j]));
    }

    /// The forces of obstacles and dry friction over the next `step` seconds, in which drives and hand give `torque`, and the
    /// speeds behind them. `None` where nothing can be said: a diverged plant, which the cycle stops.
    fn press(
        &self,
        contacts: &mut Contacts,
        touches: &Touches,
        around: &Around,
        torque: &JointTorques,
        step: f64,
    ) -> Option<ContactForces> {
        let ArmState { q, qd, .. } = self.state;
        let mass = self.arm.mass_over(&q, step).cholesky()?;
        let bias = self.arm.bias(&q, &qd);
        let net = Vector6::from_fn(|joint, _| torque[joint] - bias[joint]);
        let free = JointSpeeds((qd.to_vector() + mass.solve(&net) * step).into());
        let coulomb = self.arm.coulomb().copied();
        let answer = Answer {
            mass,
            step,
            dry: coulomb.map(|most| (most, self.friction)),
        };
        let obstacles = &contacts.obstacles;
        let Around { frames, tcp, .. } = around;
        let forces = law::solve(touches, obstacles, frames, *tcp, &free, Some(&answer));
        Some(forces)
    }

    /// One cycle with the brakes engaged: no time passes for the bodies. The servo will take over with what holds the arm now.
    pub(super) fn stand(&mut self, believed: &Dynamics, contacts: &mut Contacts) -> ArmState {
        if self.state.qd != JointSpeeds::ZERO
            && let Some(engine) = &mut self.engine
        {
            engine.halt();
        }
        let q = self.state.q;
        self.rest_at(&q);
        self.state.torque = self.arm.dynamics().gravity_torques(&q);
        self.state.mean_torque = self.state.torque;
        let standing = JointSpeeds::ZERO;
        let pressing = contacts.pressed(&q, &standing, &self.push.flange_from_tcp);
        self.state.contact = pressing.tool;
        let Around { hand, .. } = self.around(&q);
        let thought = believed.gravity_torques(&q);
        let torque = &self.state.torque;
        self.servo
            .hold_against(JointTorques(core::array::from_fn(|j| {
                thought[j] - torque[j] + pressing.tool_torque[j] + (1.0 - FELT_SHARE) * hand[j]
            })));
        self.state
    }
}
