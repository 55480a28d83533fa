//! What one cycle costs, by mode and plant, and what planning a motion costs.
//!
//! `cargo bench -p motion`. divan prints fastest, median and mean; `percentiles` prints p50 and p99 of single ticks.
#![allow(
    clippy::expect_used,
    reason = "a bench that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

use divan::Bencher;
use kinematics::{JointPositions, RobotModel};
use motion::plan::{CartesianPlanner, MotionRequest, PlanningContext, plan_movej};
use motion::{ControlLoop, CycleConfig, CycleTiming, PlantKind};
use motion_api::{
    CommandKind, MotionCommand, OnlineCommand, Origin, OverlayCommand, RingCapacities,
    ScriptEndpoint, SensingCommand, SettingCommand, motion_channel,
};

fn main() {
    percentiles();
    online_percentiles();
    force_percentiles();
    other_percentiles();
    divan::main();
}

/// Time that this thread has had a processor, us: others who share the machine do not count.
fn cpu_time_us() -> f64 {
    let clock = nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID;
    let now = clock.now().expect("every thread has this clock");
    now.tv_sec() as f64 * 1e6 + now.tv_nsec() as f64 * 1e-3
}

fn controller(plant: PlantKind, step_time: f64) -> (ControlLoop, ScriptEndpoint) {
    let config = CycleConfig {
        plant,
        step_time,
        ..CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm"))
    };
    let sizes = RingCapacities {
        records: None,
        ..RingCapacities::default()
    };
    let (motion, script) = motion_channel(sizes, &config.first_state());
    (
        ControlLoop::new(config, motion).expect("a controller"),
        script,
    )
}

fn go(script: &ScriptEndpoint, way: f64) {
    let mut target = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0];
    // Not the joints that would fold the arm.
    [0, 3, 4, 5]
        .into_iter()
        .for_each(|joint: usize| target[joint] += way);
    let kind = CommandKind::Motion(MotionCommand::MoveJ {
        target: JointPositions(target),
        acceleration: 1.396263,
        speed: 1.047197,
        duration: 0.0,
        radius: 0.0,
    });
    script.commands.send(Origin::default(), kind).expect("room");
}

/// Times of ticks in force mode: over a plate of 20 N/mm, with a faceted tool over a faceted ball, as meshes have them,
/// and with pushes so hard that the quadratic program is solved in most cycles.
fn force_percentiles() {
    for name in ["pressing", "pressing pieces of meshes", "pushed about"] {
        let is_pushed = name == "pushed about";
        let mut config = CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm"));
        config.tcp = kinematics::RpyPose::from_array([0.0, 0.0, 0.15, 0.0, 0.0, 0.0]);
        let [x, y, z] = config.first_state().actual_tcp_pose.xyz;
        if is_pushed {
            config.loads = (0..200_u16)
                .map(|k| motion::external::TimedWrench {
                    at: 0.1 * f64::from(k),
                    duration: 0.05,
                    wrench: kinematics::Wrench::from_array([40.0, -50.0, 60.0, 3.0, -2.0, 1.0]),
                    frame: motion::external::WrenchFrame::Tool,
                })
                .collect();
        } else {
            let is_faceted = name != "pressing";
            let below = if is_faceted { 0.1 } else { 0.0 };
            if is_faceted {
                config.surroundings.tool = vec![motion::contact::PlacedShape {
                    pose: kinematics::Pose::from_translation(0.0, 0.0, 0.11),
                    shape: faceted_ball(0.04),
                }];
            }
            config
                .surroundings
                .obstacles
                .push(motion::contact::Obstacle {
                    name: "plate".to_owned(),
                    solid: motion::contact::PlacedShape {
                        pose: kinematics::Pose::from_translation(x, y, z - 1e-3 - below),
                        shape: match is_faceted {
                            true => faceted_ball(0.1),
                            false => motion::contact::Shape::Plane,
                        },
                    },
                    body: None,
                    stiffness: Some(2e4),
                    damping: 0.0,
                    friction: 0.0,
                });
        }
        let sizes = RingCapacities {
            records: None,
            ..RingCapacities::default()
        };
        let (motion, mut script) = motion_channel(sizes, &config.first_state());
        let mut cycle = ControlLoop::new(config, motion).expect("a controller");
        for kind in [
            CommandKind::Sensing(SensingCommand::SetCollisionDetection(false)),
            CommandKind::Overlay(OverlayCommand::ForceMode {
                frame: kinematics::RpyPose::default(),
                selection: [is_pushed, is_pushed, true, is_pushed, false, false],
                wrench: [0.0, 0.0, if is_pushed { 0.0 } else { -20.0 }, 0.0, 0.0, 0.0],
                mode: 0,
                speed_limits: [0.2; 6],
            }),
        ] {
            script.commands.send(Origin::default(), kind).expect("room");
        }
        let mut times: Vec<f64> = (0..5000)
            .map(|_| {
                let before = cpu_time_us();
                cycle.tick(CycleTiming::default());
                let time = cpu_time_us() - before;
                while script.events.next_event().is_some() {}
                time
            })
            .collect();
        times.sort_by(f64::total_cmp);
        println!(
            "tick, rigid plant, force mode, {name}: p50 {:.1} µs, p99 {:.1} µs",
            times[times.len() / 2],
            times[times.len() * 99 / 100]
        );
    }
}

/// p50 and p99 of 4000 ticks in a chain of blends, through points, in reduced mode and among 200 obstacles.
fn other_percentiles() {
    for plant in [PlantKind::Ideal, PlantKind::Rigid] {
        for name in [
            "a chain of blends",
            "moveml",
            "reduced mode",
            "a cell of 200 obstacles",
        ] {
            let mut config = CycleConfig {
                plant,
                ..CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm"))
            };
            if name == "a cell of 200 obstacles" {
                config.surroundings.obstacles = (0..200_u16).map(ball).collect();
            }
            config.safety_inputs.reduced_mode = Some(motion::InputPair {
                pair: 2,
                is_active_low: false,
            });
            let sizes = RingCapacities {
                records: None,
                ..RingCapacities::default()
            };
            let home = config.home;
            let start = config.model.flange_pose(&home).to_rpy();
            let (motion, mut script) = motion_channel(sizes, &config.first_state());
            let mut cycle = ControlLoop::new(config, motion).expect("a controller");
            if name == "reduced mode" {
                let level = true;
                let input =
                    CommandKind::Setting(SettingCommand::SetDigitalInput { index: 20, level });
                script
                    .commands
                    .send(Origin::default(), input)
                    .expect("room");
            }
            let mut times = Vec::with_capacity(4000);
            let mut corner = 0_u32;
            let mut is_free = true;
            while times.len() < 4000 {
                if is_free {
                    is_free = false;
                    corner += 1;
                    send_next(name, corner, &home, &start, &script);
                }
                let begin = cpu_time_us();
                cycle.tick(CycleTiming::default());
                times.push(cpu_time_us() - begin);
                while let Some(event) = script.events.next_event() {
                    use motion_api::Event;
                    is_free |= matches!(event, Event::ReadyForNext { .. } | Event::Ended { .. });
                }
            }
            times.sort_by(f64::total_cmp);
            let at = |share: usize| times[times.len() * share / 1000];
            println!(
                "tick in {name}, {plant:?} plant: p50 {:.1} us, p99 {:.1} us",
                at(500),
                at(990)
            );
        }
    }
}

/// A square of lines with blends, or a list of points there and back.
fn send_next(
    name: &str,
    corner: u32,
    home: &JointPositions,
    start: &kinematics::RpyPose,
    script: &ScriptEndpoint,
) {
    let origin = Origin::default();
    if name == "moveml" {
        let point = |k: u32| {
            let turn = f64::from(k) / 2000.0 * core::f64::consts::TAU;
            let mut q = *home;
            q[0] += 0.3 * (1.0 - turn.cos());
            q[3] += 0.2 * (1.0 - turn.cos());
            q
        };
        let points: Vec<JointPositions> = (0..=2000).map(point).collect();
        let list = motion_api::PointList::from_joint_positions(&points).expect("good points");
        let sent = script
            .commands
            .send_points(origin, &list.into(), 0.004, |_, _| ());
        sent.expect("room");
        return;
    }
    let mut target = *start;
    target.xyz[1] += [0.0, 0.1, 0.1, 0.0][corner as usize % 4];
    target.xyz[2] += [0.0, 0.0, 0.1, 0.1][corner as usize % 4];
    let kind = CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: 1.2,
        speed: 0.25,
        duration: 0.0,
        radius: 0.01,
    });
    script.commands.send(origin, kind).expect("room");
}

/// A ball of 114 corners and 128 faces.
fn faceted_ball(radius: f64) -> motion::contact::Shape {
    const RINGS: u32 = 7;
    const SIDES: u32 = 16;
    use std::f64::consts::{PI, TAU};
    let mut points = vec![nalgebra::Vector3::new(0.0, 0.0, -radius)];
    for ring in 1..=RINGS {
        let (rise, across) = (PI * f64::from(ring) / f64::from(RINGS + 1)).sin_cos();
        points.extend((0..SIDES).map(|side| {
            let (sin, cos) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
            nalgebra::Vector3::new(rise * cos, rise * sin, -across) * radius
        }));
    }
    points.push(nalgebra::Vector3::new(0.0, 0.0, radius));
    let corner = |ring: u32, side: u32| 1 + (ring - 1) * SIDES + side % SIDES;
    let mut loops = Vec::new();
    for side in 0..SIDES {
        loops.push(vec![0, corner(1, side + 1), corner(1, side)]);
        for ring in 1..RINGS {
            loops.push(vec![
                corner(ring, side),
                corner(ring, side + 1),
                corner(ring + 1, side + 1),
                corner(ring + 1, side),
            ]);
        }
        loops.push(vec![
            corner(RINGS, side),
            corner(RINGS, side + 1),
            1 + RINGS * SIDES,
        ]);
    }
    let body = kinematics::polytope::Polytope::new(points, &loops).expect("a convex body");
    motion::contact::Shape::Polytope(body.into())
}

/// One of many balls on a spiral around the arm.
fn ball(k: u16) -> motion::contact::Obstacle {
    let turn = 0.3 * f64::from(k);
    let radius = 0.9 + 0.002 * f64::from(k);
    motion::contact::Obstacle {
        name: format!("ball {k}"),
        solid: motion::contact::PlacedShape {
            pose: kinematics::Pose::from_translation(
                radius * turn.cos(),
                radius * turn.sin(),
                0.005 * f64::from(k),
            ),
            shape: motion::contact::Shape::Sphere { radius: 0.05 },
        },
        body: None,
        stiffness: Some(2e4),
        damping: 0.0,
        friction: 0.0,
    }
}

/// p50 and p99 of 5000 ticks of motion.
fn percentiles() {
    for (plant, step) in [
        (PlantKind::Ideal, 0.004),
        (PlantKind::Ideal, 0.001),
        (PlantKind::Rigid, 0.004),
        (PlantKind::Rigid, 0.001),
    ] {
        let (mut cycle, mut script) = controller(plant, step);
        let mut times = Vec::with_capacity(5000);
        let mut way = 0.0;
        while times.len() < 5000 {
            if cycle.is_standing() {
                way = if way == 0.0 { 1.5 } else { 0.0 };
                go(&script, way);
            }
            let begin = cpu_time_us();
            cycle.tick(CycleTiming::default());
            times.push(cpu_time_us() - begin);
            while script.events.next_event().is_some() {}
        }
        times.sort_by(f64::total_cmp);
        let at = |share: usize| times[times.len() * share / 1000];
        println!(
            "tick {plant:?} moving, {} ms step: p50 {:.1} us, p99 {:.1} us, p99.9 {:.1} us",
            step * 1e3,
            at(500),
            at(990),
            at(999)
        );
    }
}

/// p50 and p99 of single ticks over 12 s in each mode, with both plants.
fn online_percentiles() {
    for plant in [PlantKind::Ideal, PlantKind::Rigid] {
        modes_percentiles(plant);
    }
}

fn modes_percentiles(plant: PlantKind) {
    let q = JointPositions([0.5, -1.2, 1.2, -1.4, -1.3, 0.4]);
    let mut line = RobotModel::built_in("cs66")
        .expect("a built-in arm")
        .flange_pose(&CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm")).home)
        .to_rpy();
    line.xyz[1] += 0.3;
    let modes = [
        CommandKind::Motion(MotionCommand::MoveL {
            target: line,
            acceleration: 1.2,
            speed: 0.25,
            duration: 13.0,
            radius: 0.0,
        }),
        CommandKind::Online(OnlineCommand::ServoJ {
            target: q,
            duration: 1e5,
            lookahead: 0.2,
            gain: 300.0,
        }),
        CommandKind::Online(OnlineCommand::SpeedJ {
            speeds: kinematics::JointSpeeds([0.02; 6]),
            acceleration: 1.0,
            duration: Some(1e5),
        }),
        CommandKind::Online(OnlineCommand::SpeedL {
            speed: [0.0, 0.01, 0.01, 0.0, 0.0, 0.01],
            acceleration: 1.0,
            rotation_acceleration: 1.0,
            duration: Some(1e5),
        }),
        CommandKind::Online(OnlineCommand::Freedrive {
            free_axes: [false, true, true, false, false, false],
            frame: motion_api::FreedriveFrame::Base,
        }),
        CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
            direction: [0.0, 1.0, 0.0],
            ticks_per_meter: 1000.0,
            encoder: 0,
        }),
    ];
    for kind in modes {
        let (mut cycle, mut script) = controller(plant, 0.004);
        let hand = CommandKind::Sensing(SensingCommand::SetExternalWrench([
            0.0, 2.0, 1.5, 0.0, 0.0, 0.0,
        ]));
        let enable = CommandKind::Sensing(SensingCommand::FtRtsiInput {
            enabled: true,
            mass: 0.0,
            measuring_offset: [0.0; 3],
            cog: [0.0; 3],
        });
        for kind in [enable, hand, kind] {
            script.commands.send(Origin::default(), kind).expect("room");
        }
        let mut times = Vec::with_capacity(3000);
        while times.len() < 3000 {
            let begin = cpu_time_us();
            cycle.tick(CycleTiming::default());
            times.push(cpu_time_us() - begin);
            while script.events.next_event().is_some() {}
        }
        times.sort_by(f64::total_cmp);
        let at = |share: usize| times[times.len() * share / 1000];
        println!(
            "tick in {}, {plant:?} plant: p50 {:.1} us, p99 {:.1} us",
            kind.name(),
            at(500),
            at(990)
        );
    }
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Rigid])]
fn tick_standing(bencher: Bencher, plant: PlantKind) {
    let (mut cycle, _script) = controller(plant, 0.004);
    bencher.bench_local(|| cycle.tick(CycleTiming::default()));
}

#[divan::bench(args = [PlantKind::Ideal, PlantKind::Rigid])]
fn tick_moving(bencher: Bencher, plant: PlantKind) {
    let (mut cycle, mut script) = controller(plant, 0.004);
    let mut way = 0.0;
    bencher.bench_local(|| {
        if cycle.is_standing() {
            way = if way == 0.0 { 1.5 } else { 0.0 };
            go(&script, way);
        }
        cycle.tick(CycleTiming::default());
        while script.events.next_event().is_some() {}
    });
}

#[divan::bench]
fn movej_planning(bencher: Bencher) {
    let config = CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm"));
    let limits = config.resolve().expect("good limits");
    let arm = PlanningContext {
        model: &config.model,
        flange_from_tcp: &kinematics::Pose::IDENTITY,
        limits: &limits,
        dynamics: &config.model.dynamics(&config.payload, config.gravity),
        planes: None,
    };
    let wish = MotionRequest {
        speed: 1.0,
        acceleration: 1.4,
        duration: 0.0,
        radius: 0.0,
        is_process_move: false,
    };
    let target = JointPositions([0.5, -1.0, 1.0, -1.0, -1.0, 0.3]);
    let mut cells = motion::plan::SegmentLimits::new();
    bencher.bench_local(|| {
        let target = divan::black_box(&target);
        plan_movej(&config.home, target, &wish, &arm, &mut cells).map(|(leg, _)| leg)
    });
}

#[divan::bench]
fn movel_planning(bencher: Bencher) {
    let config = CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm"));
    let limits = config.resolve().expect("good limits");
    let arm = PlanningContext {
        model: &config.model,
        flange_from_tcp: &kinematics::Pose::IDENTITY,
        limits: &limits,
        dynamics: &config.model.dynamics(&config.payload, config.gravity),
        planes: None,
    };
    let wish = MotionRequest {
        speed: 0.25,
        acceleration: 1.2,
        duration: 0.0,
        radius: 0.0,
        is_process_move: false,
    };
    let mut target = config.model.flange_pose(&config.home).to_rpy();
    target.xyz[1] += 0.3;
    target.rpy[2] += 0.3;
    let mut cells = motion::plan::SegmentLimits::new();
    bencher.bench_local(|| {
        cells.clear();
        let mut planner =
            CartesianPlanner::line(&config.home, divan::black_box(&target), &wish, &arm)
                .expect("a line that can be followed");
        planner.advance(&arm, &mut cells).is_ok()
    });
}

/// A cycle on a straight TCP line: inverse kinematics and Jacobian besides everything else.
#[divan::bench]
fn tick_on_a_line(bencher: Bencher) {
    let (mut cycle, mut script) = controller(PlantKind::Ideal, 0.004);
    let config = CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm"));
    let start = config.model.flange_pose(&config.home).to_rpy();
    let mut there = false;
    bencher.bench_local(|| {
        if cycle.is_standing() {
            there = !there;
            let mut target = start;
            if there {
                target.xyz[1] += 0.3;
            }
            let kind = CommandKind::Motion(MotionCommand::MoveL {
                target,
                acceleration: 1.2,
                speed: 0.25,
                duration: 0.0,
                radius: 0.0,
            });
            script.commands.send(Origin::default(), kind).expect("room");
        }
        cycle.tick(CycleTiming::default());
        while script.events.next_event().is_some() {}
    });
}
