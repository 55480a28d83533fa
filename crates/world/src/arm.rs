//! The arm as the world sees it: bodies whose motion is given, and the motion of the flange.

use crate::description::ArmShape;
use crate::engine::{ARM, Engine, Material, Touch, engine_pose, vector};
use crate::materials::Owner;
use kinematics::{DOF, Pose, Twist, Wrench, rotation};
use motion_api::WorldInput;
use nalgebra::Vector3;
use rapier3d_f64::dynamics::RigidBodyHandle;
use rapier3d_f64::geometry::{ColliderHandle, SharedShape};

/// Friction of links and tool towards parts.
const FRICTION: f64 = 0.5;

/// Poses of the flange at the ends of the last three cycles, the latest first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlangeMotion {
    poses: [Pose; 3],
    period: f64,
}

impl FlangeMotion {
    /// Where the flange is at the end of this cycle.
    pub(crate) fn now(&self) -> &Pose {
        &self.poses[0]
    }

    /// Way of the flange in this cycle, in its own axes, m.
    pub(crate) fn step(&self) -> Vector3<f64> {
        let [now, before, _] = &self.poses;
        now.rotate_back(now.translation - before.translation)
    }

    /// Velocity of a frame fixed to the flange during the cycle before this: what a thing has that is let go now.
    pub(crate) fn velocity_before(&self, flange_from_body: &Pose) -> Twist {
        let [_, later, earlier] = self.poses.map(|p| p * *flange_from_body);
        velocity(&later, &earlier, self.period)
    }

    /// Rotation speed at the end of this cycle, its rate of change, and the acceleration of a frame fixed to the
    /// flange, base axes.
    pub(crate) fn acceleration(&self, flange_from_body: &Pose) -> (Twist, Vector3<f64>) {
        let [now, before, earlier] = self.poses.map(|p| p * *flange_from_body);
        let (v1, v0) = (
            velocity(&now, &before, self.period),
            velocity(&before, &earlier, self.period),
        );
        let rate = Twist {
            linear: (v1.linear - v0.linear) / self.period,
            angular: (v1.angular - v0.angular) / self.period,
        };
        (rate, v1.angular)
    }
}

fn velocity(later: &Pose, earlier: &Pose, period: f64) -> Twist {
    let turn = rotation::rotvec_from_rotation(&(later.rotation * earlier.rotation.inverse()));
    Twist {
        linear: (later.translation - earlier.translation) / period,
        angular: turn / period,
    }
}

/// Bodies of links and tool.
#[derive(Clone, Debug)]
pub(crate) struct Arm {
    links: [RigidBodyHandle; DOF],
    /// Frame of everything on the flange: tool, cups.
    pub(crate) tool: RigidBodyHandle,
    link_colliders: Vec<(usize, ColliderHandle)>,
    pub(crate) tool_colliders: Vec<ColliderHandle>,
    pub(crate) motion: FlangeMotion,
    is_placed: bool,
}

impl Arm {
    pub(crate) fn new(shape: &ArmShape, engine: &mut Engine, period: f64) -> Self {
        let links = core::array::from_fn(|_| engine.add_driven(&Pose::IDENTITY));
        let tool = engine.add_driven(&Pose::IDENTITY);
        let material = |owner| Material {
            owner,
            friction: FRICTION,
            restitution: 0.0,
            group: ARM,
        };
        let link_colliders =
            shape
                .links
                .iter()
                .filter(|(link, _)| *link < DOF)
                .map(|(link, capsule)| {
                    let solid = SharedShape::capsule(
                        vector(capsule.p0),
                        vector(capsule.p1),
                        capsule.radius,
                    );
                    let owner = material(Owner::Link(*link as u32));
                    (
                        *link,
                        engine.attach_solid(
                            links[*link],
                            solid,
                            engine_pose(&Pose::IDENTITY),
                            0.0,
                            owner,
                        ),
                    )
                });
        let link_colliders = link_colliders.collect();
        let tool_colliders = shape
            .tool
            .iter()
            .map(|(shape, pose)| engine.attach(tool, shape, pose, 0.0, material(Owner::Tool)));
        let tool_colliders = tool_colliders.collect();
        let motion = FlangeMotion {
            poses: [Pose::IDENTITY; 3],
            period,
        };
        Self {
            links,
            tool,
            link_colliders,
            tool_colliders,
            motion,
            is_placed: false,
        }
    }

    /// Where the bodies are at the end of the coming step. The first time they are put there, without a velocity.
    pub(crate) fn drive(&mut self, engine: &mut Engine, input: &WorldInput) {
        let [now, before, _] = self.motion.poses;
        self.motion.poses = match self.is_placed {
            true => [input.base_from_flange, now, before],
            false => [input.base_from_flange; 3],
        };
        let links = self.links.iter().zip(&input.base_from_joint);
        for (body, pose) in links.chain([(&self.tool, &input.base_from_flange)]) {
            if !self.is_placed {
                engine.place(*body, pose);
            }
            engine.drive(*body, pose);
        }
        self.is_placed = true;
    }

    /// What parts and moved obstacles do to each link: about the origin of its joint frame, base axes.
    pub(crate) fn link_wrenches(&self, engine: &Engine, input: &WorldInput) -> [Wrench; DOF] {
        let mut wrenches = [Wrench::default(); DOF];
        for (link, collider) in &self.link_colliders {
            let about = input.base_from_joint[*link].translation;
            add_touches(&mut wrenches[*link], &engine.contacts(*collider), about);
        }
        wrenches
    }
}

/// Adds what touches do, as a wrench about a point.
pub(crate) fn add_touches(sum: &mut Wrench, touches: &[Touch], about: Vector3<f64>) {
    for touch in touches {
        let Wrench { force, moment } = touch.on_this;
        sum.force += force;
        sum.moment += moment - about.cross(&force);
    }
}
