//! The arm among obstacles: forces, rest, friction, links, determinism.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use core::f64::consts::FRAC_PI_2;

use common::{Bench, ideal, movel};
use kinematics::polytope::Polytope;
use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use motion::contact::{Environment, Obstacle, PlacedShape, RIGID_STIFFNESS, Shape};
use motion::{CycleConfig, PlantKind};
use motion_api::{MachineCommand, MotionCommand, Outcome, SensingCommand, StopReason};
use nalgebra::Vector3;
use std::sync::Arc;

const HOME: JointPositions =
    JointPositions([0.0, -FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, -FRAC_PI_2, 0.0]);

fn rigid() -> CycleConfig {
    CycleConfig {
        home: HOME,
        tcp: RpyPose::from_array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]),
        ..CycleConfig::new(RobotModel::built_in("cs66").unwrap())
    }
}

/// Where the TCP stands at home.
fn tcp_at_home(config: &CycleConfig) -> RpyPose {
    config.first_state().actual_tcp_pose
}

fn obstacle(shape: Shape, pose: Pose, stiffness: Option<f64>) -> Obstacle {
    Obstacle {
        name: "plate".to_owned(),
        solid: PlacedShape { pose, shape },
        body: None,
        stiffness,
        damping: 0.0,
        friction: 0.0,
    }
}

/// A plate under the TCP at home, its surface `gap` below.
fn plate(config: &CycleConfig, gap: f64, stiffness: Option<f64>) -> Obstacle {
    let z = tcp_at_home(config).xyz[2] - gap;
    obstacle(Shape::Plane, Pose::from_translation(0.0, 0.0, z), stiffness)
}

fn among(mut config: CycleConfig, obstacles: Vec<Obstacle>) -> CycleConfig {
    config.surroundings.obstacles = obstacles;
    config
}

/// Goes down by `way` from where the TCP is.
fn down(bench: &mut Bench, way: f64, speed: f64) -> Outcome {
    let mut target = bench.now().target_tcp_pose;
    target.xyz[2] -= way;
    bench.do_it(MotionCommand::MoveL {
        target,
        acceleration: 1.2,
        speed,
        duration: 0.0,
        radius: 0.0,
    })
}

/// Depth of the TCP in a plate whose surface is at `surface`, m.
fn depth(bench: &Bench, surface: f64) -> f64 {
    surface - bench.now().actual_tcp_pose.xyz[2]
}

/// The force on the tool in base axes.
fn force(bench: &Bench) -> Vector3<f64> {
    let state = bench.now();
    let w = state.tcp_force;
    Pose::from_rpy(&state.actual_tcp_pose).rotate(Vector3::new(w[0], w[1], w[2]))
}

#[test]
fn a_plate_pushes_back_with_its_stiffness_times_the_depth() {
    for plant in [PlantKind::Rigid, PlantKind::Ideal] {
        for step_time in [0.001, 0.004] {
            for stiffness in [1e3, 1e4, 1e5, 1e6] {
                let config = CycleConfig {
                    plant,
                    step_time,
                    ..rigid()
                };
                let surface = tcp_at_home(&config).xyz[2] - 0.01;
                let plate = plate(&config, 0.01, Some(stiffness));
                let mut bench = Bench::new(among(config, vec![plate]));
                // 20 N if the arm did not give way.
                let press = 20.0 / stiffness;
                assert_eq!(down(&mut bench, 0.01 + press, 0.05), Outcome::Done);
                bench.run((1.5 / step_time) as usize);
                assert!(bench.stops.is_empty(), "{:?}", bench.stops);
                let (f, d) = (force(&bench), depth(&bench, surface));
                let place = format!("{plant:?} {step_time} {stiffness}: {f:?} at {d}");
                assert!((f.z / (stiffness * d) - 1.0).abs() < 1e-5, "{place}");
                // The arm gives way too, some hundred newtons a millimetre.
                assert!(
                    f.z > 20.0 / (1.0 + stiffness / 2e5) && f.z < 20.0 + 1e-6,
                    "{place}"
                );
                assert!(f.x.abs() < 1e-6 && f.y.abs() < 1e-6, "{place}");
            }
        }
    }
}

/// Random poses over a box of random stiffness.
fn random(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 33) as f64 / f64::from(1_u32 << 31)
}

#[test]
fn pressing_comes_to_rest_at_any_stiffness_in_any_pose() {
    let mut seed = 3;
    for round in 0..24 {
        let mut config = rigid();
        config.home = JointPositions(core::array::from_fn(|j| {
            HOME.0[j] + 1.2 * (random(&mut seed) - 0.5)
        }));
        config.step_time = [0.001, 0.002, 0.004][round % 3];
        let stiffness = match round % 8 {
            7 => None,
            _ => Some(10_f64.powf(3.0 + 3.0 * random(&mut seed))),
        };
        let friction = 0.6 * random(&mut seed) * f64::from(u8::from(round % 2 == 1));
        // A box whose upper face is just before the TCP, across the tool.
        let tcp = Pose::from_rpy(&config.first_state().actual_tcp_pose);
        let size = 0.1;
        let center = tcp * Pose::from_translation(0.0, 0.0, size + 1e-3);
        let half = [size; 3];
        let obstacle = Obstacle {
            friction,
            ..obstacle(Shape::Box { half }, center, stiffness)
        };
        let k = stiffness.unwrap_or(RIGID_STIFFNESS);
        let step_time = config.step_time;
        let mut bench = Bench::new(among(config, vec![obstacle]));
        bench.do_it(SensingCommand::SetCollisionDetection(false));
        let press = (30.0 / k).clamp(2e-5, 5e-3);
        let target = tcp * Pose::from_translation(0.0, 0.0, 1e-3 + press);
        let outcome = bench.do_it(MotionCommand::MoveL {
            target: target.to_rpy(),
            acceleration: 1.2,
            speed: 0.01,
            duration: 0.0,
            radius: 0.0,
        });
        let place = format!("round {round}, {stiffness:?} N/m, friction {friction}");
        assert_eq!(outcome, Outcome::Done, "{place}");
        bench.run((1.0 / step_time) as usize);
        assert!(bench.stops.is_empty(), "{place}: {:?}", bench.stops);
        let tail: Vec<_> = bench
            .states
            .iter()
            .rev()
            .take((0.1 / step_time) as usize)
            .collect();
        let forces: Vec<f64> = tail.iter().map(|s| -s.tcp_force[2]).collect();
        let spread = forces.iter().copied().fold(f64::MIN, f64::max)
            - forces.iter().copied().fold(f64::MAX, f64::min);
        let mean = forces.iter().sum::<f64>() / forces.len() as f64;
        println!(
            "{place}: {mean:.3} N, spread {spread:.6}, speed {:.2e}",
            tail[0].actual_qd.max_abs()
        );
        assert!(mean > 2.0, "{place}: {mean}");
        // With friction the tool still creeps to where it belongs.
        assert!(spread < 0.05 * mean, "{place}: {spread}");
        // Against the force there is nothing but the depth.
        let depth = (tcp.inverse() * Pose::from_rpy(&tail[0].actual_tcp_pose))
            .translation
            .z
            - 1e-3;
        if stiffness.is_some() {
            assert!(
                (mean / (k * depth) - 1.0).abs() < 5e-3,
                "{place}: {mean} N at {depth} m"
            );
        } else {
            assert!(depth.abs() < 1e-5, "{place}: {depth}");
        }
    }
}

/// A tool 40 mm across and 100 mm long on the flange, its end at the TCP.
fn tool(shape: Shape) -> PlacedShape {
    PlacedShape {
        pose: Pose::from_translation(0.0, 0.0, 0.05),
        shape,
    }
}

/// A box as a convex body of flat faces, which meshes give.
fn flat_faces(half: [f64; 3]) -> Shape {
    Shape::Polytope(Arc::new(Polytope::cuboid(half).unwrap()))
}

#[test]
fn flat_tools_press_with_their_face() {
    let half = [0.02, 0.02, 0.05];
    let cylinder = Shape::Cylinder {
        radius: 0.02,
        half_length: 0.05,
    };
    for shape in [Shape::Box { half }, cylinder, flat_faces(half)] {
        for below in [
            Shape::Plane,
            Shape::Box { half: [0.1; 3] },
            flat_faces([0.1; 3]),
            Shape::Cylinder {
                radius: 0.1,
                half_length: 0.1,
            },
        ] {
            for stiffness in [Some(2e4), None] {
                let mut config = rigid();
                let top = tcp_at_home(&config).xyz;
                let lower = if below == Shape::Plane { 0.0 } else { 0.1 };
                let pose = Pose::from_translation(top[0], top[1], top[2] - 0.002 - lower);
                config.surroundings.tool = vec![tool(shape.clone())];
                let mut bench = Bench::new(among(
                    config,
                    vec![obstacle(below.clone(), pose, stiffness)],
                ));
                let press = if stiffness.is_some() { 0.001 } else { 2e-5 };
                assert_eq!(down(&mut bench, 0.002 + press, 0.02), Outcome::Done);
                bench.run(250);
                let place = format!("{shape:?} on {below:?}, {stiffness:?}");
                assert!(bench.stops.is_empty(), "{place}: {:?}", bench.stops);
                let w = bench.now().tcp_force;
                let d = depth(&bench, top[2] - 0.002);
                if stiffness.is_some() {
                    assert!(
                        (force(&bench).z / (2e4 * d) - 1.0).abs() < 0.02,
                        "{place}: {w:?} {d}"
                    );
                    assert!(w[2] < -18.0, "{place}: {w:?}");
                } else {
                    assert!(w[2] < -2.0 && d.abs() < 1e-5, "{place}: {w:?} {d}");
                }
                // The arm gives way by turning a little: the middle of the pressure leaves the middle of the face, more
                // so the harder the table, but never the face.
                let lever = if stiffness.is_some() { 0.001 } else { 0.0201 };
                let most = lever * w[2].abs();
                assert!(w[3].abs() < most && w[4].abs() < most, "{place}: {w:?}");
            }
        }
    }
}

#[test]
fn friction_holds_up_to_its_share_and_then_slides_with_it() {
    let config = rigid();
    let plate = Obstacle {
        friction: 0.4,
        damping: 50.0,
        ..plate(&config, 0.002, Some(2e4))
    };
    let mut bench = Bench::new(among(config, vec![plate]));
    down(&mut bench, 0.003, 0.02);
    bench.run(100);
    let mut target = bench.now().target_tcp_pose;
    target.xyz[1] += 0.05;
    assert_eq!(bench.do_it(movel(target)), Outcome::Done);
    let sliding: Vec<_> = bench
        .states
        .iter()
        .filter(|s| s.target_tcp_speed[1] > 0.2)
        .collect();
    assert!(sliding.len() > 5);
    for state in sliding {
        let f = Pose::from_rpy(&state.actual_tcp_pose)
            .rotate(Vector3::from_row_slice(&state.tcp_force[..3]));
        assert!((f.y / f.z + 0.4).abs() < 1e-3, "{f:?}");
        assert!(f.x.abs() < 0.1 * f.z, "{f:?}");
    }
    // What friction is left at rest is within the cone.
    bench.run(250);
    let f = force(&bench);
    assert!(f.x.hypot(f.y) <= 0.4 * f.z * (1.0 + 1e-9), "{f:?}");
}

#[test]
fn a_link_that_hits_something_stops_the_arm_though_the_sensor_feels_nothing() {
    let mut config = rigid();
    config.tcp = RpyPose::default();
    // A post where the middle of the forearm would come by.
    let mut half_way = HOME;
    half_way[0] = 0.6;
    let frames = config.model.forward(&half_way).base_from_joint;
    let middle = (frames[2].translation + frames[3].translation) / 2.0;
    let post = Pose::from_translation(middle.x, middle.y, middle.z);
    let shape = Shape::Cylinder {
        radius: 0.03,
        half_length: 0.15,
    };
    let mut bench = Bench::new(among(config, vec![obstacle(shape, post, None)]));
    let mut goal = HOME;
    goal[0] = 1.2;
    let outcome = bench.do_it(common::movej(goal));
    let Outcome::ProtectiveStop(StopReason::Collision { joint, force, .. }) = outcome else {
        panic!("{outcome:?} {:?}", bench.now().actual_q);
    };
    assert_eq!(joint, 0);
    assert!(force > 10.0, "{force}");
    let felt = bench
        .states
        .iter()
        .map(|s| s.tcp_force[0].abs())
        .fold(0.0, f64::max);
    assert_eq!(felt, 0.0);
    bench.run(200);
    assert!(bench.now().actual_qd.max_abs() == 0.0);
}

/// Hits a plate at `speed`; the largest force until the arm stands, and why it stopped.
fn hit(stiffness: Option<f64>, sensitivity: u8, speed: f64) -> (f64, StopReason) {
    let config = rigid();
    let plate = plate(&config, 0.1, stiffness);
    let mut bench = Bench::new(among(config, vec![plate]));
    bench.do_it(SensingCommand::SetCollisionSensitivity(sensitivity));
    let outcome = down(&mut bench, 0.2, speed);
    let Outcome::ProtectiveStop(reason) = outcome else {
        panic!("{stiffness:?} {sensitivity}: {outcome:?}");
    };
    bench.run(300);
    assert_eq!(bench.now().actual_qd.max_abs(), 0.0);
    let peak = bench
        .states
        .iter()
        .map(|s| -s.tcp_force[2])
        .fold(0.0, f64::max);
    (peak, reason)
}

#[test]
fn a_hit_at_a_quarter_of_a_metre_a_second_stops_the_arm_and_names_joint_and_force() {
    for stiffness in [Some(1e4), Some(1e5), None] {
        let mut last = f64::INFINITY;
        for sensitivity in [10, 40, 70, 100] {
            let (peak, reason) = hit(stiffness, sensitivity, 0.25);
            println!("{stiffness:?} N/m, {sensitivity} %: peak {peak:.0} N, {reason}");
            let StopReason::Collision { force, .. } = reason else {
                panic!("{reason}");
            };
            // What it took to notice falls as the sensitivity rises.
            assert!(
                force <= last * 1.01,
                "{stiffness:?} {sensitivity}: {force} {last}"
            );
            last = force;
        }
    }
    let forces = [10, 100].map(|sensitivity| hit(Some(1e4), sensitivity, 0.25).0);
    assert!(forces[0] > 1.5 * forces[1], "{forces:?}");
}

#[test]
fn after_a_hit_the_arm_can_be_unlocked_and_led_away() {
    for stiffness in [Some(1e4), None] {
        let config = rigid();
        let plate = plate(&config, 0.1, stiffness);
        let mut bench = Bench::new(among(config, vec![plate]));
        assert!(matches!(
            down(&mut bench, 0.2, 0.25),
            Outcome::ProtectiveStop(_)
        ));
        bench.run(300);
        let pressed = force(&bench).z;
        assert_eq!(
            bench.do_it(MachineCommand::UnlockProtectiveStop),
            Outcome::Done
        );
        bench.run(50);
        println!(
            "{stiffness:?}: stood with {pressed:.1} N, then {:.1} N",
            force(&bench).z
        );
        assert_eq!(
            down(&mut bench, -0.05, 0.25),
            Outcome::Done,
            "{stiffness:?}: {:?}",
            bench.stops
        );
        assert!(force(&bench).z.abs() < 1e-9);
    }
}

#[test]
fn the_same_contact_comes_out_the_same_to_the_bit() {
    let run = || {
        let config = rigid();
        let plate = Obstacle {
            friction: 0.3,
            ..plate(&config, 0.01, Some(1e5))
        };
        let mut bench = Bench::new(among(config, vec![plate]));
        down(&mut bench, 0.012, 0.1);
        bench.run(20);
        bench.states
    };
    assert_eq!(run(), run());
}

#[test]
fn a_link_that_stands_in_an_obstacle_at_the_start_is_left_alone() {
    let config = rigid();
    let table = obstacle(Shape::Plane, Pose::from_translation(0.0, 0.0, 0.12), None);
    let surroundings = Environment {
        obstacles: vec![table],
        ..Environment::default()
    };
    assert_eq!(
        surroundings.links_inside_obstacles(&config.model, &HOME),
        [(1, 0), (2, 0)]
    );
    let mut bench = Bench::new(CycleConfig {
        surroundings,
        ..config
    });
    bench.run(100);
    assert!(bench.stops.is_empty());
    assert!(bench.now().actual_qd.max_abs() < 1e-9);
}

#[test]
fn no_capsule_of_any_arm_at_home_touches_the_floor_it_stands_on() {
    for model in common::MODELS {
        let config = ideal(model);
        let floor = obstacle(Shape::Plane, Pose::IDENTITY, None);
        let surroundings = Environment {
            obstacles: vec![floor],
            ..Environment::default()
        };
        assert_eq!(
            surroundings.links_inside_obstacles(&config.model, &config.home),
            [],
            "{model}"
        );
    }
}

/// How a tool is pressed into something thin and soft: the force along the way in, N, and what it should be, N/m times
/// depth.
fn pressed_into(
    shape: Shape,
    tool: Option<Shape>,
    plant: PlantKind,
    press: f64,
    stiffness: f64,
) -> (Vector3<f64>, f64) {
    let mut config = CycleConfig { plant, ..rigid() };
    let top = tcp_at_home(&config).xyz;
    let above = match shape {
        Shape::Box { half } => half[2],
        Shape::Cylinder { half_length, .. } => half_length,
        Shape::Sphere { radius } => radius,
        Shape::Plane => 0.0,
        Shape::Polytope(ref body) => body.reach(&Vector3::z()),
    };
    let pose = Pose::from_translation(top[0], top[1], top[2] - 0.003 - above);
    config.surroundings.tool = tool.map(self::tool).into_iter().collect();
    let mut bench = Bench::new(among(config, vec![obstacle(shape, pose, Some(stiffness))]));
    bench.do_it(SensingCommand::SetCollisionDetection(false));
    let outcome = down(&mut bench, 0.003 + press, 0.02);
    assert_eq!(outcome, Outcome::Done, "{:?}", bench.stops);
    let mut last = 0.0;
    for state in &bench.states {
        let w = state.tcp_force;
        assert!(w[2] < 1e-9, "it never pulls: {w:?}");
        assert!(
            -w[2] >= last - 0.5,
            "it lets nothing through: {w:?} after {last}"
        );
        last = -w[2];
    }
    bench.run(250);
    let depth = depth(&bench, top[2] - 0.003);
    (force(&bench), stiffness * depth)
}

#[test]
fn thin_and_soft_things_push_out_the_way_they_were_entered_however_deep() {
    let sheet = Shape::Box {
        half: [0.1, 0.1, 0.005],
    };
    let slab = Shape::Box {
        half: [0.1, 0.1, 0.01],
    };
    let disc = Shape::Cylinder {
        radius: 0.1,
        half_length: 0.005,
    };
    let ball = Shape::Sphere { radius: 0.02 };
    let flat = Shape::Box {
        half: [0.02, 0.02, 0.05],
    };
    let pin = Shape::Cylinder {
        radius: 0.005,
        half_length: 0.05,
    };
    let round = Shape::Sphere { radius: 0.05 };
    for plant in [PlantKind::Rigid, PlantKind::Ideal] {
        for (shape, stiffness, press) in [
            (sheet.clone(), 5e3, 0.008),
            (sheet.clone(), 5e3, 0.0099),
            (slab.clone(), 2e3, 0.012),
            (slab.clone(), 2e3, 0.019),
            (disc.clone(), 5e3, 0.009),
            (flat_faces([0.1, 0.1, 0.005]), 5e3, 0.0099),
            (flat_faces([0.1, 0.1, 0.01]), 2e3, 0.019),
            (ball.clone(), 2e3, 0.03),
        ] {
            let tools = [&flat, &pin, &round, &flat_faces([0.02, 0.02, 0.05])]
                .map(|tool| Some(tool.clone()));
            for tool in [None].into_iter().chain(tools) {
                let place = format!("{plant:?} {shape:?} {press} {tool:?}");
                if shape == ball && tool.is_some() {
                    continue;
                }
                let (force, wanted) = pressed_into(shape.clone(), tool, plant, press, stiffness);
                assert!(
                    (force.z / wanted - 1.0).abs() < 0.02,
                    "{place}: {force} {wanted}"
                );
                assert!(force.xy().norm() < 0.5, "{place}: {force}");
            }
        }
        // Right through to the other side: the tool's shaft is still held.
        let (force, wanted) = pressed_into(sheet.clone(), None, plant, 0.014, 5e3);
        assert!(
            (force.z / wanted - 1.0).abs() < 0.02,
            "{plant:?}: {force} {wanted}"
        );
    }
}

#[test]
fn what_is_slid_off_to_the_side_is_free_and_may_come_back_from_there() {
    let mut config = CycleConfig {
        plant: PlantKind::Ideal,
        ..rigid()
    };
    config.limits.self_collision = Some(false);
    let top = tcp_at_home(&config).xyz;
    let half = [0.03, 0.03, 0.005];
    let pose = Pose::from_translation(top[0], top[1], top[2] - 0.008);
    let sheet = obstacle(Shape::Box { half }, pose, Some(2e3));
    let mut bench = Bench::new(among(config, vec![sheet]));
    bench.do_it(SensingCommand::SetCollisionDetection(false));
    down(&mut bench, 0.011, 0.05);
    assert!((force(&bench).z - 16.0).abs() < 0.1, "{}", force(&bench));
    let mut aside = bench.now().target_tcp_pose;
    aside.xyz[1] += 0.06;
    bench.do_it(movel(aside));
    bench.run(5);
    assert!(force(&bench).norm() < 1e-9, "{}", force(&bench));
    aside.xyz[1] -= 0.035;
    bench.do_it(movel(aside));
    bench.run(5);
    // 5 mm and the ball's radius into the side: pushed back to where it came from.
    let f = force(&bench);
    assert!(f.y > 9.0 && f.z.abs() < 1e-9, "{f}");
}

#[test]
fn among_two_hundred_obstacles_the_arm_feels_those_that_it_touches_to_the_bit() {
    let run = |crowd: u16| {
        let config = CycleConfig {
            plant: PlantKind::Rigid,
            ..rigid()
        };
        let mut obstacles = vec![plate(&config, 0.01, Some(2e4))];
        let top = tcp_at_home(&config).xyz;
        // Balls on a sphere around the arm, none within reach of the way; some of them stand right beside it.
        obstacles.extend((0..crowd).map(|k| {
            let turn = f64::from(k) * 2.4;
            let away = if k % 10 == 0 { 0.25 } else { 1.6 };
            let z = if k % 10 == 0 {
                0.15
            } else {
                f64::from(k % 40) * 0.05
            };
            let (x, y) = (top[0] + away * turn.cos(), top[1] + away * turn.sin());
            let pose = Pose::from_translation(x, y, top[2] + z);
            obstacle(Shape::Sphere { radius: 0.02 }, pose, None)
        }));
        let mut config = among(config, obstacles);
        config.limits.self_collision = Some(false);
        let mut bench = Bench::new(config);
        bench.do_it(SensingCommand::SetCollisionDetection(false));
        down(&mut bench, 0.0115, 0.05);
        bench.run(300);
        bench
    };
    let (alone, crowded) = (run(0), run(199));
    assert!(alone.stops.is_empty(), "{:?}", alone.stops);
    assert!(force(&alone).z > 10.0, "{}", force(&alone));
    assert_eq!(alone.states, crowded.states);
}

#[test]
fn pieces_of_one_body_share_its_stiffness() {
    for (body, share) in [(Some(0), 1.0), (None, 2.0)] {
        let mut config = rigid();
        let top = tcp_at_home(&config).xyz;
        config.surroundings.tool = vec![tool(flat_faces([0.02, 0.02, 0.05]))];
        let pieces = [-0.1, 0.1].map(|x| Obstacle {
            body,
            ..obstacle(
                flat_faces([0.1, 0.1, 0.1]),
                Pose::from_translation(top[0] + x, top[1], top[2] - 0.102),
                Some(2e4),
            )
        });
        let mut bench = Bench::new(among(config, pieces.into()));
        assert_eq!(down(&mut bench, 0.003, 0.02), Outcome::Done);
        bench.run(250);
        let pressed = depth(&bench, top[2] - 0.002);
        let stiffness = force(&bench).z / pressed;
        assert!(
            (stiffness / (share * 2e4) - 1.0).abs() < 0.02,
            "{body:?}: {stiffness}"
        );
    }
}
