//! Bodies that graze edges: what pushes them is never more than what they are really inside.

use core::f64::consts::{PI, TAU};

use kinematics::{Frames, JointPositions, Pose, RobotModel, RpyPose};
use motion_api::{HeldPart, MAX_GRIPPERS};
use nalgebra::{Rotation3, Unit, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::{
    ArmPart, Contact, ContactModel, Environment, Obstacle, PlacedShape, Shape, test_bodies,
};

/// Where the obstacles are: out of the arm's reach, so that nothing but the body under test is near.
const FAR: Vector3<f64> = Vector3::new(5.0, 0.0, 0.0);

fn block(xyz: [f64; 3], size: [f64; 3]) -> Obstacle {
    tilted_block(xyz, [0.0; 3], size)
}

fn tilted_block(xyz: [f64; 3], rpy: [f64; 3], size: [f64; 3]) -> Obstacle {
    let mut pose = Pose::from_rpy(&RpyPose { xyz, rpy });
    pose.translation += FAR;
    Obstacle {
        name: String::new(),
        solid: PlacedShape {
            pose,
            shape: Shape::Box {
                half: size.map(|edge| edge / 2.0),
            },
        },
        body: None,
        stiffness: Some(1e5),
        damping: 0.0,
        friction: 0.0,
    }
}

/// A body on an arm that is moved from place to place.
struct MovedBody {
    contacts: ContactModel,
    frames: Frames,
    part: ArmPart,
    shape: Shape,
}

impl MovedBody {
    fn new(shape: Shape, part: ArmPart, obstacles: Vec<Obstacle>) -> Self {
        let model = RobotModel::built_in("cs66").unwrap();
        let home = JointPositions([0.0, -1.5, 1.5, -1.5, -1.5, 0.0]);
        let body = PlacedShape {
            pose: Pose::IDENTITY,
            shape: shape.clone(),
        };
        let environment = Environment {
            obstacles,
            tool: match part {
                ArmPart::Tool => vec![body.clone()],
                _ => Vec::new(),
            },
            part_shapes: vec![vec![body]],
        };
        let mut contacts = ContactModel::new(environment, &model, &home);
        if let ArmPart::Held(slot) = part {
            let mut parts = [None; MAX_GRIPPERS];
            parts[slot] = Some(HeldPart {
                template: 0,
                flange_from_part: Pose::IDENTITY,
                play: [0.0; 3],
            });
            contacts.set_held_parts(&parts);
        }
        Self {
            contacts,
            frames: model.forward(&home),
            part,
            shape,
        }
    }

    /// Where it touches once it is at `pose`.
    fn move_to(&mut self, pose: &Pose) -> Vec<Contact> {
        let mut at = *pose;
        at.translation += FAR;
        match self.part {
            ArmPart::Link(link) => self.frames.base_from_joint[link] = at,
            ArmPart::Tool | ArmPart::Held(_) => self.frames.base_from_flange = at,
        }
        let touches = self.contacts.find_contacts(&self.frames, &Pose::IDENTITY);
        let part = self.part;
        let mine = touches.as_slice().iter().filter(|t| t.part == part);
        mine.copied().collect()
    }

    /// The greatest depth in any obstacle, m: its force is the stiffness times that.
    fn depth_at(&mut self, pose: &Pose) -> f64 {
        let touches = self.move_to(pose);
        touches.iter().fold(0.0, |most, t| most.max(t.place.depth))
    }

    /// How far the body reaches from its origin in a direction, turned like that, m.
    fn reach(&mut self, rotation: Rotation3<f64>, direction: Vector3<f64>) -> f64 {
        let turned = rotation.inverse() * direction;
        match (self.part, &self.shape) {
            (ArmPart::Link(link), _) => {
                self.frames.base_from_joint[link] = Pose::new(rotation, Vector3::zeros());
                let capsules = self.contacts.links.capsules_in_base(link + 1, &self.frames);
                let ends =
                    capsules.map(|c| c.p0.dot(&direction).max(c.p1.dot(&direction)) + c.radius);
                ends.fold(f64::NEG_INFINITY, f64::max)
            }
            (_, Shape::Box { half }) => turned.abs().dot(&Vector3::from(*half)),
            (
                _,
                Shape::Cylinder {
                    radius,
                    half_length,
                },
            ) => turned.xy().norm() * radius + turned.z.abs() * half_length,
            (_, Shape::Sphere { radius }) => *radius,
            (_, Shape::Plane) => f64::INFINITY,
            (_, Shape::Polytope(body)) => body.reach(&turned),
        }
    }
}

/// An upright or slightly leaning body: its lower end at `z`, `x` the place of its axis there.
fn leaning(x: f64, z: f64, lean: f64, half_length: f64) -> Pose {
    let upright = Pose::from_rpy(&RpyPose {
        xyz: [x, 0.0, z],
        rpy: [0.0, lean, 0.0],
    });
    let middle = upright.transform_point(Vector3::z() * half_length);
    Pose::new(upright.rotation, middle)
}

#[test]
fn a_peg_that_grazes_the_upper_edge_of_a_wall_is_not_thrown_up_when_its_rim_touches_the_side() {
    let peg = Shape::Cylinder {
        radius: 0.01,
        half_length: 0.04,
    };
    let flat = Shape::Box {
        half: [0.01, 0.01, 0.04],
    };
    for shape in [peg, flat] {
        for part in [ArmPart::Held(0), ArmPart::Tool] {
            // The side of the wall at x = 0, its top at z = 0.
            let wall = block([-0.01, 0.0, -0.015], [0.02, 0.06, 0.03]);
            let mut body = MovedBody::new(shape.clone(), part, vec![wall]);
            let mut most = 0.0_f64;
            for step in 0..2200_i32 {
                let down = f64::from(step) * 1e-5;
                // First it leans towards the wall, its rim 5 µm off the side and its flank inside at the top, by up to
                // 35 µm; then it comes upright, and its rim is 20 µm inside.
                let (x, lean) = if down < 0.02 {
                    (0.01 + 5e-6, -0.002)
                } else {
                    (0.01 - 20e-6, 0.0)
                };
                let depth = body.depth_at(&leaning(x, 0.002 - down, lean, 0.04));
                most = most.max(depth);
            }
            assert!(most > 15e-6, "{part:?} {shape:?}: it touches, {most}");
            assert!(most < 40e-6, "{part:?} {shape:?}: {most}");
        }
    }
}

/// A smooth function of time from -1 to 1.
#[derive(Clone, Copy, Debug)]
struct Wave {
    rounds: f64,
    start: f64,
}

impl Wave {
    fn at(&self, time: f64) -> f64 {
        (TAU * (self.rounds * time + self.start)).sin()
    }
}

fn wave() -> impl Strategy<Value = Wave> {
    (0.2..3.0_f64, 0.0..1.0_f64).prop_map(|(rounds, start)| Wave { rounds, start })
}

/// How a body goes around a block while it overlaps it by no more than [`MOST`] along one direction or another.
#[derive(Clone, Debug)]
struct Around {
    rpy: [f64; 3],
    /// Where it begins, what it goes around, and how far, rad.
    from: Vector3<f64>,
    axis: Vector3<f64>,
    angle: f64,
    turning: [Wave; 3],
    sliding: [Wave; 3],
    pressing: Wave,
}

const MOST: f64 = 0.5e-3;

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    let along_an_axis = (0..3_usize, prop::bool::ANY).prop_map(|(axis, is_negative)| {
        let mut out = Vector3::zeros();
        out[axis] = if is_negative { -1.0 } else { 1.0 };
        out
    });
    let any = prop::array::uniform3(-1.0..1.0_f64)
        .prop_map(Vector3::from)
        .prop_filter("it has a length", |v| v.norm() > 0.1)
        .prop_map(|v| v.normalize());
    prop_oneof![along_an_axis, any]
}

fn around() -> impl Strategy<Value = Around> {
    let rpy = prop_oneof![
        Just([0.0; 3]),
        prop::array::uniform3(-0.01..0.01_f64),
        prop::array::uniform3(-PI..PI),
    ];
    // Round a corner, or only along a side.
    let angle = prop_oneof![-PI..PI, -0.01..0.01_f64, Just(0.0)];
    let waves = || [wave(), wave(), wave()];
    (
        (rpy, direction(), direction(), angle),
        (waves(), waves(), wave()),
    )
        .prop_map(
            |((rpy, from, axis, angle), (turning, sliding, pressing))| Around {
                rpy,
                from,
                axis,
                angle,
                turning,
                sliding,
                pressing,
            },
        )
}

impl Around {
    /// Where the body is at a time from 0 to 1, and how much it overlaps the block around the origin, m.
    fn at(&self, time: f64, body: &mut MovedBody, half: [f64; 3]) -> (Pose, f64) {
        let out = Rotation3::from_axis_angle(&Unit::new_normalize(self.axis), self.angle * time)
            * self.from;
        let [roll, pitch, yaw] =
            core::array::from_fn(|k| self.rpy[k] + 0.01 * self.turning[k].at(time));
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
        // It begins a millimetre off.
        let overlap = (MOST * self.pressing.at(time)).min(0.02 * time - 0.001);
        // About where the block ends in that direction, without a jump from corner to corner.
        let over = out.map(|x| x / (x * x + 0.01).sqrt());
        let slide = Vector3::from_fn(|k, _| 0.015 * self.sliding[k].at(time));
        let place = over.component_mul(&Vector3::from(half)) + slide;
        let reach = out.abs().dot(&Vector3::from(half)) + body.reach(rotation, -out);
        let place = place + out * (reach - overlap - place.dot(&out));
        (Pose::new(rotation, place), overlap)
    }
}

fn body() -> impl Strategy<Value = (Shape, ArmPart)> {
    let length = || 0.004..0.05_f64;
    let shape = prop_oneof![
        [length(), length(), length()].prop_map(|half| Shape::Box { half }),
        (length(), length()).prop_map(|(radius, half_length)| Shape::Cylinder {
            radius,
            half_length
        }),
        length().prop_map(|radius| Shape::Sphere { radius }),
        [length(), length(), length()].prop_map(test_bodies::block),
        (length(), length())
            .prop_map(|(radius, half_length)| test_bodies::faceted_cylinder(radius, half_length)),
    ];
    let part = prop_oneof![
        3 => Just(ArmPart::Held(0)),
        1 => Just(ArmPart::Held(3)),
        3 => Just(ArmPart::Tool),
        1 => Just(ArmPart::Link(2)),
    ];
    (shape, part)
}

/// Boxes as they are, or as polytopes, which meshes give.
fn obstacles(as_polytopes: bool, boxes: Vec<Obstacle>) -> Vec<Obstacle> {
    let mut obstacles = boxes;
    for obstacle in &mut obstacles {
        if let Shape::Box { half } = obstacle.solid.shape
            && as_polytopes
        {
            obstacle.solid.shape = test_bodies::block(half);
        }
    }
    obstacles
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, rng_seed: RngSeed::Fixed(51), ..ProptestConfig::default() })]

    /// A body that overlaps a block by half a millimetre along some direction can leave it that way: nowhere is it
    /// deeper.
    #[test]
    fn what_goes_around_a_block_is_pushed_by_what_it_overlaps_and_no_more(
        (shape, part) in body(),
        size in prop::array::uniform3(0.01..0.1_f64),
        path in around(),
        as_polytope in any::<bool>(),
    ) {
        let obstacle = obstacles(as_polytope, vec![block([0.0; 3], size)]);
        let mut body = MovedBody::new(shape, part, obstacle);
        let half = size.map(|edge| edge / 2.0);
        for step in 0..500_i32 {
            let time = f64::from(step) / 500.0;
            let (pose, overlap) = path.at(time, &mut body, half);
            let depth = body.depth_at(&pose);
            prop_assert!(depth <= 1.05 * MOST, "{depth} at {time}, overlapping by {overlap}");
        }
    }
}

/// A hole of 21 mm, 30 mm deep, between four walls that stand on a bed; its upper end at z = 0.
fn hole() -> Vec<Obstacle> {
    vec![
        block([0.0, 0.0, -0.08], [0.16, 0.16, 0.1]),
        block([-0.0205, 0.0, -0.015], [0.02, 0.061, 0.03]),
        block([0.0205, 0.0, -0.015], [0.02, 0.061, 0.03]),
        block([0.0, -0.0205, -0.015], [0.021, 0.02, 0.03]),
        block([0.0, 0.0205, -0.015], [0.021, 0.02, 0.03]),
    ]
}

fn peg() -> impl Strategy<Value = (Shape, ArmPart)> {
    let round = Shape::Cylinder {
        radius: 0.01,
        half_length: 0.04,
    };
    let square = Shape::Box {
        half: [0.01, 0.01, 0.04],
    };
    let faceted = test_bodies::faceted_cylinder(0.01, 0.04);
    let shape = prop_oneof![Just(round), Just(square), Just(faceted)];
    (
        shape,
        prop_oneof![Just(ArmPart::Held(0)), Just(ArmPart::Tool)],
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: RngSeed::Fixed(52), ..ProptestConfig::default() })]

    /// The walls are flush with the bed and with each other: the lower end comes by all their edges.
    #[test]
    fn what_goes_into_a_hole_is_pushed_by_what_it_overlaps_and_no_more(
        (shape, part) in peg(),
        sway in [wave(), wave(), wave(), wave()],
        deepest in 0.0299..0.0302_f64,
        as_polytopes in any::<bool>(),
    ) {
        let mut body = MovedBody::new(shape, part, obstacles(as_polytopes, hole()));
        let mut has_touched = false;
        for step in 0..900_i32 {
            let time = f64::from(step) / 900.0;
            let [x, y, roll, pitch] = core::array::from_fn(|k| sway[k].at(time));
            // Up to 0.3 mm into a side at the lower end, up to 0.15 mm more at the upper one. Into the bed and, in the
            // end, out again.
            let down = (0.06 * time - 0.002).min(deepest).min(0.06 * (1.0 - time));
            let at = Pose::from_rpy(&RpyPose {
                xyz: [0.0008 * x, 0.0008 * y, -down],
                rpy: [0.003 * roll, 0.003 * pitch, 0.0],
            });
            let middle = at.transform_point(Vector3::z() * 0.04);
            let depth = body.depth_at(&Pose::new(at.rotation, middle));
            has_touched |= depth > 0.0;
            // In a corner of two walls both overlaps count.
            prop_assert!(depth <= 2.0 * MOST, "{depth} at {time}, {down} down");
        }
        prop_assert!(has_touched);
    }
}

#[test]
fn a_body_crosses_the_joint_of_two_thin_tiles_that_it_is_pressed_into() {
    let pin = Shape::Cylinder {
        radius: 0.005,
        half_length: 0.04,
    };
    let flat = Shape::Box {
        half: [0.03, 0.02, 0.04],
    };
    for shape in [pin, flat] {
        for part in [ArmPart::Held(0), ArmPart::Tool] {
            for pressed in [0.0003, 0.003, 0.008] {
                // Their tops at z = 0, the joint at x = 0.
                let tiles = [-0.1, 0.1].map(|x| block([x, 0.0, -0.005], [0.2, 0.2, 0.01]));
                let mut body = MovedBody::new(shape.clone(), part, tiles.into());
                let place = |x: f64, z: f64| Pose::from_translation(x, 0.0, z + 0.04);
                for step in 0..100_i32 {
                    let _ = body.depth_at(&place(
                        -0.05,
                        1e-4 - f64::from(step) / 99.0 * (pressed + 1e-4),
                    ));
                }
                for step in 0..1000_i32 {
                    let x = -0.05 + f64::from(step) * 1e-4 + 1e-7;
                    for touch in body.move_to(&place(x, -pressed)) {
                        let Contact { place, .. } = touch;
                        assert!(
                            place.depth < 1.01 * pressed + 1e-9,
                            "{shape:?} {x} {touch:?}"
                        );
                        // Only the edges of the tiles themselves, at the joint, may push aside.
                        let is_at_joint = (place.point.x - FAR.x).abs() < 1e-9;
                        let is_up = place.normal.z > 0.999 || is_at_joint || place.depth < 1e-9;
                        assert!(is_up, "{shape:?} {pressed} {x} {touch:?}");
                    }
                }
            }
        }
    }
}
