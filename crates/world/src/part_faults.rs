//! Faults of parts: missing ones, turned ones, dropped ones.

use crate::description::{FaultDescription as Plan, FaultKind};
use crate::fault::{Fault, FaultPhase};
use crate::world::World;
use kinematics::Pose;
use motion_api::PointLevels;
use nalgebra::{Rotation3, Unit, Vector3};
use std::sync::Arc;

/// A part that a fault took out of the world.
#[derive(Clone)]
pub(crate) struct MissingPart {
    fault: usize,
    name: Arc<str>,
    template: usize,
    pose: Pose,
}

impl World {
    pub(crate) fn advance_faults(
        &mut self,
        outputs: &PointLevels,
        inputs: &PointLevels,
        time: f64,
    ) {
        self.drops.clear();
        for number in 0..self.faults.len() {
            let phase = self.faults[number].advance(outputs, inputs, time);
            match phase {
                FaultPhase::Begins => self.begin_fault(number),
                FaultPhase::Ends => self.bring_back(number),
                FaultPhase::Absent | FaultPhase::Lasts => {}
            }
        }
    }

    /// Adds a fault that begins with the next step.
    pub(crate) fn add_fault(&mut self, plan: Plan) {
        self.faults.push(Fault::new(plan));
    }

    fn begin_fault(&mut self, number: usize) {
        match self.faults[number].plan.what.clone() {
            FaultKind::Missing(name) => {
                let Some(part) = self.parts.by_name(&name) else {
                    return;
                };
                let Some(body) = self.parts.bodies.get(&part) else {
                    return;
                };
                let (template, pose) = (body.template, self.engine.pose(body.body));
                let name = body.name.clone();
                self.take_out(part);
                self.absent.push(MissingPart {
                    fault: number,
                    name,
                    template,
                    pose,
                });
            }
            FaultKind::Turned(name) => {
                let angle = 0.5 + 2.0 * self.scatter.unit();
                let Some(part) = self
                    .parts
                    .by_name(&name)
                    .and_then(|n| self.parts.bodies.get(&n))
                else {
                    return;
                };
                if part.gripper.is_some() {
                    return;
                }
                let up = Unit::try_new(-self.engine.gravity(), 1e-9).unwrap_or(Vector3::z_axis());
                let pose = self.engine.pose(part.body);
                let center = self.parts.center(&self.engine, part);
                let turn = Rotation3::from_axis_angle(&up, angle);
                let turned = Pose::new(
                    turn * pose.rotation,
                    center + turn * (pose.translation - center),
                );
                self.engine.place(part.body, &turned);
            }
            FaultKind::Drop(name) => self.drops.extend(self.parts.by_name(&name)),
            // Asked for in every cycle while they last.
            FaultKind::Leak(_)
            | FaultKind::Stuck(_)
            | FaultKind::Open(_)
            | FaultKind::Blocked(_)
            | FaultKind::Slow(_) => {}
        }
    }

    fn bring_back(&mut self, fault: usize) {
        let Some(at) = self.absent.iter().position(|absent| absent.fault == fault) else {
            return;
        };
        let absent = self.absent.swap_remove(at);
        self.parts
            .add(&mut self.engine, absent.template, absent.name, &absent.pose);
    }
}
