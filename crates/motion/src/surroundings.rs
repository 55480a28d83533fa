//! The control cycle's side of the world around the arm: what the world gives is put in force when a cycle begins, and
//! the arm goes to the world when it ends.
//!
//! Inputs that the world drives, faults of inputs, what pushes tool and links, what the grippers hold, the way of the
//! belts. A cycle without a world does none of it.

use kinematics::{JointTorques, Payload, RigidBody, Wrench};
use motion_api::{MAX_GRIPPERS, PointSet, WorldInput, WorldOutput, WorldPort};
use nalgebra::Vector3;

use crate::cycle::ControlLoop;

/// What the cycle has to know of a world at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldSetup {
    /// Inputs that the world drives.
    pub driven_inputs: PointSet,
    /// Ticks for a metre or a radian of the world's conveyors that turn encoders 0 and 1.
    pub ticks_per_unit: [Option<f64>; 2],
}

/// A world as the cycle knows it.
pub(crate) struct Surroundings {
    port: WorldPort,
    driven_inputs: PointSet,
    /// What hangs on the flange besides what the grippers hold; `None`: what the controller was told.
    own_payload: Option<Payload>,
    held_body: RigidBody,
    /// What the world does to the tool in this cycle: base axes, about the TCP.
    tool_wrench: Wrench,
    link_torques: JointTorques,
    /// Ticks for a metre or a radian of the conveyors that turn the encoders.
    ticks_per_unit: [Option<f64>; 2],
    /// Ticks of those encoders at the end of this cycle, with fraction.
    pub(crate) encoder_ticks: [Option<f64>; 2],
    travel_before: [f64; 2],
}

impl Surroundings {
    /// A wrench on the tool: base axes, about the TCP.
    pub(crate) const fn tool_wrench(&self) -> &Wrench {
        &self.tool_wrench
    }

    /// Joint torques of what pushes the links, Nm.
    pub(crate) const fn link_torques(&self) -> &JointTorques {
        &self.link_torques
    }
}

impl ControlLoop {
    /// The controller with a world around its arm. Templates of parts have their shapes in
    /// [`Environment::part_shapes`](crate::contact::Environment::part_shapes).
    #[must_use]
    pub fn with_world(mut self, port: WorldPort, setup: WorldSetup) -> Self {
        let own_payload = self.sensor.actual_payload();
        self.surroundings = Some(Surroundings {
            port,
            driven_inputs: setup.driven_inputs,
            own_payload,
            held_body: RigidBody::default(),
            tool_wrench: Wrench::default(),
            link_torques: JointTorques::ZERO,
            ticks_per_unit: setup.ticks_per_unit,
            encoder_ticks: [None; 2],
            travel_before: [0.0; 2],
        });
        self
    }

    /// Puts in force what the world gives to this cycle.
    pub(crate) fn take_world(&mut self) {
        let Some(world) = &mut self.surroundings else {
            return;
        };
        let output: WorldOutput = *world.port.receive(self.out.cycle);
        self.io.set_impaired_inputs(&output.stuck, &output.open);
        self.io
            .set_driven_inputs(&output.inputs, &world.driven_inputs);
        let frames = self.actual.frames();
        let tcp = self.tool.position(frames);
        let lever = frames.base_from_flange.translation - tcp;
        world.tool_wrench = Wrench {
            force: output.tool_wrench.force,
            moment: output.tool_wrench.moment + lever.cross(&output.tool_wrench.force),
        };
        world.link_torques = JointTorques(core::array::from_fn(|joint| {
            let axis = frames.base_from_joint[joint].rotate(Vector3::z());
            let at = frames.base_from_joint[joint].translation;
            let links = output
                .link_wrenches
                .iter()
                .zip(&frames.base_from_joint)
                .skip(joint);
            links
                .map(|(push, link)| {
                    axis.dot(&(push.moment + (link.translation - at).cross(&push.force)))
                })
                .sum()
        }));
        // The world tells the end of the last cycle; what turns evenly is a step further at the end of this one.
        for (k, travel) in output.encoder_travel.into_iter().enumerate() {
            let expected = travel + (travel - world.travel_before[k]);
            world.encoder_ticks[k] = world.ticks_per_unit[k].map(|ticks| ticks * expected);
            world.travel_before[k] = travel;
        }
        self.actual.contacts.set_held_parts(&output.held_parts);
        if output.held_body != world.held_body {
            world.held_body = output.held_body;
            if let Some(own) = &world.own_payload {
                let payload = Payload::from_body(&own.body().joined_with(&output.held_body));
                self.actual.plant.set_actual_payload(&payload);
                self.sensor.set_actual_payload(payload);
            }
        }
    }

    /// Gives the end of the cycle to the world.
    pub(crate) fn give_to_world(&mut self) {
        let Some(world) = &mut self.surroundings else {
            return;
        };
        let frames = self.actual.frames();
        let tcp = self.tool.position(frames);
        let lever = tcp - frames.base_from_flange.translation;
        let mut held_contacts = [Wrench::default(); MAX_GRIPPERS];
        for (at_flange, at_tcp) in held_contacts
            .iter_mut()
            .zip(self.actual.contacts.held_forces())
        {
            at_flange.force = at_tcp.force;
            at_flange.moment = at_tcp.moment + lever.cross(&at_tcp.force);
        }
        world.port.send(WorldInput {
            cycle: self.out.cycle,
            seen: 0,
            base_from_joint: frames.base_from_joint,
            base_from_flange: frames.base_from_flange,
            outputs: self.io.output_levels(),
            held_contacts,
        });
    }
}
