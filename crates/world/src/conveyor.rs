//! Surfaces that carry: their speed, and what it means for the contacts on them.

use crate::description::{BodyShape, ConveyorDescription as Plan, Surface};
use crate::engine::{Engine, Material, STILL};
use crate::machine_fault::MachineFault;
use crate::materials::{Owner, SurfaceMotion};
use crate::state::ConveyorState;
use kinematics::Pose;
use motion_api::PointLevels;
use nalgebra::{Rotation3, Unit, Vector3};
use rapier3d_f64::dynamics::RigidBodyHandle;

/// Thickness of a turntable, m: only its top is described.
const TURNTABLE_HEIGHT: f64 = 0.05;

/// A conveyor.
#[derive(Clone, Debug)]
pub(crate) struct Conveyor {
    pub(crate) plan: Plan,
    body: RigidBodyHandle,
    pub(crate) state: ConveyorState,
}

impl Conveyor {
    pub(crate) fn new(plan: &Plan, index: usize, engine: &mut Engine) -> Self {
        let (shape, pose) = match plan.surface {
            Surface::Belt { pose, size, .. } => (BodyShape::Box { size }, pose),
            Surface::Turntable { center, radius } => {
                let below = Pose::from_translation(0.0, 0.0, -TURNTABLE_HEIGHT / 2.0);
                (
                    BodyShape::Cylinder {
                        radius,
                        length: TURNTABLE_HEIGHT,
                    },
                    center * below,
                )
            }
        };
        // The engine knows the velocity of a belt's contacts, but not their turning: a turntable is a body that turns.
        let body = match plan.surface {
            Surface::Belt { .. } => engine.add_still(&pose),
            Surface::Turntable { .. } => engine.add_driven(&pose),
        };
        let material = Material {
            owner: Owner::Conveyor(index as u32),
            friction: plan.friction,
            restitution: 0.0,
            group: STILL,
        };
        engine.attach(body, &shape, &Pose::IDENTITY, 0.0, material);
        Self {
            plan: plan.clone(),
            body,
            state: ConveyorState::default(),
        }
    }

    /// Before the engine's step: the speed that the surface has during it.
    pub(crate) fn before_step(
        &mut self,
        index: usize,
        engine: &mut Engine,
        outputs: &PointLevels,
        time: f64,
        period: f64,
        fault: MachineFault,
    ) {
        let runs =
            self.plan.run.is_none_or(|point| outputs.level(point)) && time >= self.plan.start_at;
        let share = self
            .plan
            .speed_from
            .map_or(1.0, |point| outputs.ratio(point));
        let goal = if runs {
            self.plan.speed * share * fault.speed_share()
        } else {
            0.0
        };
        let change = self.plan.acceleration * period;
        self.state.speed += match fault {
            MachineFault::Blocked => -self.state.speed,
            _ => kinematics::bounds::within(goal - self.state.speed, -change, change),
        };
        self.state.travel += self.state.speed * period;
        let speed = self.state.speed;
        let motion = match &self.plan.surface {
            Surface::Belt { direction, .. } => SurfaceMotion {
                linear: *Unit::new_normalize(Vector3::from(*direction)) * speed,
                ..SurfaceMotion::default()
            },
            Surface::Turntable { center, .. } => {
                let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), self.state.travel);
                let below = Pose::from_translation(0.0, 0.0, -TURNTABLE_HEIGHT / 2.0);
                engine.drive(
                    self.body,
                    &(*center * Pose::new(turn, Vector3::zeros()) * below),
                );
                SurfaceMotion {
                    center: center.translation,
                    contraction: speed * speed * period / 2.0,
                    ..SurfaceMotion::default()
                }
            }
        };
        if let Some(surface) = engine.materials.surfaces.get_mut(index) {
            *surface = motion;
        }
        if self.state.speed != 0.0 {
            // A part that sleeps on the belt does not see that it moves.
            engine.wake_neighbours(self.body);
        }
    }
}
