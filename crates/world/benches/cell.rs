//! What a cell costs: palletising with a belt, cups and 60 boxes; 10 parts that lie still; a copy of the state.
//!
//! `cargo bench -p world --profile dev` (or the release profile). Prints multiples of real time by processor time of
//! one thread.
#![allow(
    clippy::expect_used,
    reason = "a bench that cannot go on should say where"
)]

use kinematics::{Pose, RpyPose};
use motion_api::IoPoint;
use motion_api::WorldInput;
use nix::time::ClockId;
use world::description::*;
use world::{World, WorldDescription};

const ON: IoPoint = IoPoint::Digital(0);
const PERIOD: f64 = 0.004;

/// Processor time of this thread since it began, s: others who share the machine do not count.
fn cpu_time() -> f64 {
    let now = ClockId::CLOCK_THREAD_CPUTIME_ID
        .now()
        .expect("every thread has this clock");
    now.tv_sec() as f64 + now.tv_nsec() as f64 * 1e-9
}

fn main() {
    palletising();
    parts_at_rest(10);
    parts_at_rest(60);
    copies(30);
}

fn pose(p: [f64; 6]) -> Pose {
    Pose::from_rpy(&RpyPose {
        xyz: [p[0], p[1], p[2]],
        rpy: [p[3], p[4], p[5]],
    })
}

fn down(x: f64, y: f64, z: f64) -> Pose {
    pose([x, y, z, core::f64::consts::PI, 0.0, 0.0])
}

fn part(name: &str) -> PartDescription {
    PartDescription {
        name: name.into(),
        shape: BodyShape::Box {
            size: [0.1, 0.1, 0.08],
        },
        mass: Mass::Total(0.5),
        pose: pose([0.0, 0.0, 0.04, 0.0, 0.0, 0.0]),
        friction: 0.5,
        restitution: 0.0,
        copies: None,
    }
}

fn cell() -> WorldDescription {
    WorldDescription {
        settings: Settings {
            floor: Some(0.0),
            ..Settings::default()
        },
        ..WorldDescription::default()
    }
}

/// 60 boxes come on a belt, and a hand with cups puts them on a pallet of 5 × 4 × 3, one in 20 s.
fn palletising() {
    let mut cell = cell();
    cell.parts.push(part("box"));
    cell.conveyors.push(ConveyorDescription {
        name: "belt".into(),
        surface: Surface::Belt {
            pose: pose([-0.5, 0.6, 0.05, 0.0, 0.0, 0.0]),
            size: [2.0, 0.3, 0.1],
            direction: [1.0, 0.0, 0.0],
        },
        speed: 0.2,
        friction: 0.6,
        run: None,
        speed_from: None,
        acceleration: 2.0,
        start_at: 0.0,
        encoder: None,
    });
    cell.obstacles.push(ObstacleDescription {
        name: "stopper".into(),
        shape: BodyShape::Box {
            size: [0.02, 0.3, 0.1],
        },
        pose: pose([0.46, 0.6, 0.15, 0.0, 0.0, 0.0]),
        friction: 0.5,
    });
    cell.sources.push(SourceDescription {
        name: "feed".into(),
        part: "box".into(),
        pose: pose([-1.3, 0.6, 0.141, 0.0, 0.0, 0.0]),
        when: Trigger::Time(20.0),
        start_at: 0.0,
        limit: Some(60),
        scatter: [0.0, 0.002, 0.0, 0.0, 0.0, 0.01],
    });
    let cups = [
        [0.03, 0.03, 0.1],
        [-0.03, 0.03, 0.1],
        [0.03, -0.03, 0.1],
        [-0.03, -0.03, 0.1],
    ];
    cell.grippers.push(Gripper {
        name: "cups".into(),
        kind: GripperKind::Vacuum(Vacuum {
            cups: cups.to_vec(),
            direction: [0.0, 0.0, 1.0],
            radius: 0.015,
            pressure: 60000.0,
            reach: 0.003,
            build_up: 0.1,
            decay: 0.05,
            on: ON,
            blow_off: None,
            switch: None,
            threshold: 0.7,
            gauge: None,
        }),
    });
    let mut world = World::new(&cell).expect("a possible cell");
    let mut input = WorldInput {
        base_from_joint: [Pose::from_translation(0.0, 0.0, 5.0); 6],
        base_from_flange: down(0.4, 0.6, 0.5),
        ..WorldInput::default()
    };
    let begin = cpu_time();
    let mut slowest = 0.0_f64;
    for box_number in 0..60 {
        let [x, y, z] = [box_number % 5, box_number / 5 % 4, box_number / 20].map(f64::from);
        let (x, y, z) = (0.105 * x, -0.2 - 0.105 * y, 0.08 * (z + 1.0) + 0.1005);
        let way: [(Pose, f64, bool); 8] = [
            (down(0.4, 0.6, 0.5), 9.0, false),
            (down(0.4, 0.6, 0.2805), 1.5, false),
            (down(0.4, 0.6, 0.2805), 0.5, true),
            (down(0.4, 0.6, 0.6), 1.5, true),
            (down(x, y, 0.6), 3.0, true),
            (down(x, y, z), 2.0, true),
            (down(x, y, z), 0.5, false),
            (down(x, y, 0.6), 2.0, false),
        ];
        for (target, seconds, on) in way {
            let start = input.base_from_flange.translation;
            let cycles = (seconds / PERIOD) as usize;
            for cycle in 1..=cycles {
                let t = cycle as f64 / cycles as f64;
                let s = t * t * t * (10.0 + t * (6.0 * t - 15.0));
                input.base_from_flange.translation = start + (target.translation - start) * s;
                input.outputs.set_level(ON, on);
                let before = cpu_time();
                world.step(&input);
                slowest = slowest.max(cpu_time() - before);
            }
        }
    }
    let on_pallet = world
        .state()
        .parts
        .iter()
        .filter(|p| p.pose.translation.y < -0.1)
        .count();
    let wall = cpu_time() - begin;
    println!(
        "palletising, 60 boxes: {:.0} s in {wall:.2} s of processor time, {:.0} × real time, slowest step {:.2} ms, \
         {on_pallet} boxes on the pallet",
        world.time(),
        world.time() / wall,
        slowest * 1e3
    );
}

fn parts_at_rest(count: usize) {
    for sleeping in [true, false] {
        let mut cell = cell();
        cell.settings.sleeping = sleeping;
        cell.parts.push(PartDescription {
            copies: Some(Copies {
                count: [count / 5, 5, 1],
                pitch: [0.15, 0.15, 0.0],
            }),
            ..part("box")
        });
        let mut world = World::new(&cell).expect("a possible cell");
        let input = WorldInput {
            base_from_flange: down(0.0, 0.0, 5.0),
            base_from_joint: [down(0.0, 0.0, 5.0); 6],
            ..WorldInput::default()
        };
        let begin = cpu_time();
        for _ in 0..15_000 {
            world.step(&input);
        }
        println!(
            "{count} parts at rest, sleeping {sleeping}: {:.0} × real time",
            60.0 / (cpu_time() - begin)
        );
    }
}

/// What a copy costs, and what running again costs instead.
fn copies(count: usize) {
    let mut cell = cell();
    cell.parts.push(PartDescription {
        copies: Some(Copies {
            count: [count / 5, 5, 1],
            pitch: [0.15, 0.15, 0.0],
        }),
        ..part("box")
    });
    let mut world = World::new(&cell).expect("a possible cell");
    let input = WorldInput {
        base_from_flange: down(0.0, 0.0, 5.0),
        base_from_joint: [down(0.0, 0.0, 5.0); 6],
        ..WorldInput::default()
    };
    for _ in 0..100 {
        world.step(&input);
    }
    let begin = cpu_time();
    let worlds: Vec<World> = (0..200).map(|_| world.clone()).collect();
    println!(
        "a copy of a world with {count} parts: {:.0} us ({} taken)",
        (cpu_time() - begin) / 200.0 * 1e6,
        worlds.len()
    );
}
