//! The cycle does not allocate: 10,000 ticks in every mode are counted, the engine of the plant "rapier" apart.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

use crate::common;

use assert_no_alloc::{AllocDisabler, assert_no_alloc, violation_count};
use common::{ideal, movej, movel};
use kinematics::{JointPositions, Payload, RpyPose};
use motion::modes::encoder::Belt;
use motion::setpoint::{LimitedSetpoint, Setpoint, check_setpoint};
use motion::{ControlLoop, CycleConfig, CycleTiming, PlantKind};
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionCommand, OnlineCommand, Origin, OverlayCommand,
    RingCapacities, ScriptEndpoint, SensingCommand, SettingCommand, motion_channel,
};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn controller(config: CycleConfig) -> (ControlLoop, ScriptEndpoint) {
    let (motion, script) = motion_channel(RingCapacities::default(), &config.first_state());
    (ControlLoop::new(config, motion).unwrap(), script)
}

/// Ticks without allocating; the rings are emptied outside.
fn tick(cycle: &mut ControlLoop, script: &mut ScriptEndpoint) -> u32 {
    let before = violation_count();
    assert_no_alloc(|| cycle.tick(CycleTiming::default()));
    while script.events.next_event().is_some() {}
    while script.records.as_mut().unwrap().next_record().is_some() {}
    violation_count() - before
}

#[test]
fn ten_thousand_ticks_through_every_mode_allocate_nothing() {
    let (mut cycle, mut script) = controller(ideal("cs66"));
    let home = ideal("cs66").home;
    let there = JointPositions([0.6, -1.2, 1.4, -1.8, -1.3, 0.4]);
    let line = {
        let pose = ideal("cs66").model.flange_pose(&home).to_rpy();
        RpyPose {
            xyz: [pose.xyz[0] + 0.1, pose.xyz[1] + 0.2, pose.xyz[2]],
            ..pose
        }
    };
    let nowhere = RpyPose {
        xyz: [5.0, 0.0, 0.0],
        ..line
    };
    let stop = CommandKind::Machine(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    let payload = Payload::new(3.0, [0.0, 0.0, 0.1], [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]).unwrap();
    let round = [
        movej(there),
        CommandKind::Machine(MachineCommand::Pause),
        CommandKind::Machine(MachineCommand::Pause),
        CommandKind::Machine(MachineCommand::Resume),
        CommandKind::Setting(SettingCommand::SetSpeedFraction(0.5)),
        CommandKind::Setting(SettingCommand::SetSpeedFraction(1.0)),
        stop,
        movej(home),
        stop,
        movel(nowhere),
        movel(line),
        CommandKind::Setting(SettingCommand::SetTcp(RpyPose::from_array([
            0.0, 0.0, 0.1, 0.0, 0.0, 0.0,
        ]))),
        CommandKind::Setting(SettingCommand::SetPayload(payload)),
        CommandKind::Setting(SettingCommand::SetStandardDigitalOut {
            index: 1,
            level: true,
        }),
        movel(line),
        CommandKind::Machine(MachineCommand::PowerOff),
        CommandKind::Machine(MachineCommand::PowerOn),
        CommandKind::Machine(MachineCommand::ReleaseBrakes),
        CommandKind::Machine(MachineCommand::UnlockProtectiveStop),
        CommandKind::Sensing(SensingCommand::Push {
            wrench: [5.0; 6],
            in_tool_axes: true,
            duration: 0.1,
            replaces: false,
        }),
        CommandKind::Machine(MachineCommand::ProtectiveStop),
        CommandKind::Machine(MachineCommand::UnlockProtectiveStop),
        CommandKind::Machine(MachineCommand::RestartSafetyBoard),
        CommandKind::Setting(SettingCommand::SetTcp(RpyPose::default())),
    ];
    let mut modes = std::collections::BTreeSet::new();
    for tick_number in 0..10_000 {
        if tick_number % 61 == 0 {
            let kind = round[(tick_number / 61) % round.len()];
            script.commands.send(Origin::default(), kind).unwrap();
        }
        assert_eq!(tick(&mut cycle, &mut script), 0, "tick {tick_number}");
        modes.insert(script.snapshot.read().motion_mode);
    }
    println!("modes seen: {modes:?}");
    assert!(modes.len() >= 6, "{modes:?}");
}

#[test]
fn ten_thousand_ticks_through_the_online_modes_allocate_nothing() {
    let mut config = ideal("cs66");
    config.belts[0] = Some(motion::modes::encoder::Belt {
        encoder: 0,
        ticks_per_second: 100.0,
        start_at: 0.0,
    });
    let home = config.home;
    let (mut cycle, mut script) = controller(config);
    let stop = CommandKind::Machine(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    let round = [
        CommandKind::Online(OnlineCommand::ServoJ {
            target: JointPositions([0.3, -1.4, 1.4, -1.6, -1.4, 0.2]),
            duration: 0.1,
            lookahead: 0.2,
            gain: 300.0,
        }),
        CommandKind::Online(OnlineCommand::SpeedJ {
            speeds: kinematics::JointSpeeds([0.2; 6]),
            acceleration: 2.0,
            duration: None,
        }),
        CommandKind::Online(OnlineCommand::SpeedL {
            speed: [-0.3, 0.1, 0.1, 0.0, 0.1, 0.0],
            acceleration: 1.0,
            rotation_acceleration: 1.0,
            duration: Some(1.0),
        }),
        movej(home),
        stop,
        CommandKind::Online(OnlineCommand::StopJ { acceleration: 4.0 }),
        CommandKind::Online(OnlineCommand::Freedrive {
            free_axes: [true, true, false, false, false, true],
            frame: motion_api::FreedriveFrame::Tool,
        }),
        CommandKind::Sensing(SensingCommand::FtRtsiInput {
            enabled: true,
            mass: 0.0,
            measuring_offset: [0.0; 3],
            cog: [0.0; 3],
        }),
        CommandKind::Sensing(SensingCommand::ZeroFtSensor),
        CommandKind::Sensing(SensingCommand::SetExternalWrench([
            10.0, -20.0, 5.0, 0.0, 0.0, 1.0,
        ])),
        CommandKind::Online(OnlineCommand::EndFreedrive),
        CommandKind::Sensing(SensingCommand::SetExternalWrench([0.0; 6])),
        CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
            direction: [0.0, 1.0, 0.0],
            ticks_per_meter: 1000.0,
            encoder: 0,
        }),
        movej(home),
        CommandKind::Overlay(OverlayCommand::StopConveyorTracking),
        CommandKind::Setting(SettingCommand::SetGravity([0.0, 0.0, -9.8])),
        movej(home),
        CommandKind::Machine(MachineCommand::UnlockProtectiveStop),
    ];
    let mut modes = std::collections::BTreeSet::new();
    for tick_number in 0..10_000 {
        if tick_number % 83 == 0 {
            let kind = round[(tick_number / 83) % round.len()];
            script.commands.send(Origin::default(), kind).unwrap();
        }
        assert_eq!(tick(&mut cycle, &mut script), 0, "tick {tick_number}");
        modes.insert(script.snapshot.read().motion_mode);
    }
    println!("modes seen: {modes:?}");
    assert!(modes.len() >= 7, "{modes:?}");
}

#[test]
fn four_thousand_ticks_of_blends_and_arcs_allocate_nothing() {
    let (mut cycle, mut script) = controller(ideal("cs66"));
    let home = ideal("cs66").home;
    let pose = ideal("cs66").model.flange_pose(&home).to_rpy();
    let at = |x: f64, y: f64| RpyPose {
        xyz: [pose.xyz[0] + x, pose.xyz[1] + y, pose.xyz[2]],
        ..pose
    };
    let (acceleration, duration) = (1.2, 0.0);
    let line = |target, speed, radius| {
        CommandKind::Motion(MotionCommand::MoveL {
            target,
            acceleration,
            speed,
            duration,
            radius,
        })
    };
    let joint = CommandKind::Motion(MotionCommand::MoveJ {
        target: home,
        acceleration,
        speed: 1.0,
        duration,
        radius: 0.05,
    });
    let arc = CommandKind::Motion(MotionCommand::MoveC {
        via: at(-0.05, 0.15),
        target: at(-0.1, 0.1),
        acceleration,
        speed: 0.25,
        radius: 0.03,
        fixed: false,
    });
    let round = [
        line(at(0.0, 0.1), 0.25, 0.05),
        arc,
        line(at(-0.1, 0.0), 0.1, 0.01),
        joint,
    ];
    let mut sent = 0;
    let mut is_free = true;
    let mut modes = std::collections::BTreeSet::new();
    for tick_number in 0..4000 {
        if is_free {
            script
                .commands
                .send(Origin::default(), round[sent % round.len()])
                .unwrap();
            sent += 1;
            is_free = false;
        }
        let before = violation_count();
        assert_no_alloc(|| cycle.tick(CycleTiming::default()));
        assert_eq!(violation_count(), before, "tick {tick_number}");
        while let Some(event) = script.events.next_event() {
            is_free |= matches!(event, motion_api::Event::Ended { .. });
        }
        while script.records.as_mut().unwrap().next_record().is_some() {}
        modes.insert(script.snapshot.read().motion_mode);
    }
    assert!(sent > 2 * round.len(), "{sent}");
    assert!(modes.len() >= 3, "{modes:?}");
}

/// The solver of force mode makes two allocator calls inside its library, in cycles whose answer is at a bound.
#[test]
fn force_mode_allocates_only_inside_the_solver() {
    let mut config = ideal("cs66");
    config.loads = (0..5_u8)
        .map(|k| motion::external::TimedWrench {
            at: f64::from(k),
            duration: 0.5,
            wrench: kinematics::Wrench::from_array([60.0, -200.0, 150.0, 5.0, -8.0, 4.0]),
            frame: motion::external::WrenchFrame::Base,
        })
        .collect();
    let line = config.model.flange_pose(&config.home).to_rpy();
    let (mut cycle, mut script) = controller(config);
    let force = CommandKind::Overlay(OverlayCommand::ForceMode {
        frame: RpyPose::default(),
        selection: [true, true, true, false, true, false],
        wrench: [0.0; 6],
        mode: 3,
        speed_limits: [0.3, 0.3, 0.3, 0.5, 0.5, 0.5],
    });
    let round = [
        CommandKind::Sensing(SensingCommand::SetCollisionDetection(false)),
        force,
        movel(line),
        CommandKind::Sensing(SensingCommand::SetForceGain(0.5)),
        CommandKind::Machine(MachineCommand::Pause),
        CommandKind::Machine(MachineCommand::Resume),
        CommandKind::Overlay(OverlayCommand::EndForceMode),
    ];
    let mut counts = [0_u32; 3];
    let mut on = 0;
    for tick_number in 0..5000 {
        if tick_number % 83 == 0 {
            let kind = round[(tick_number / 83) % round.len()];
            script.commands.send(Origin::default(), kind).unwrap();
        }
        let count = tick(&mut cycle, &mut script);
        assert!(count <= 2, "tick {tick_number}: {count}");
        counts[count as usize] += 1;
        on += u32::from(script.snapshot.read().force_mode);
    }
    println!("ticks with 0, 1, 2 allocator calls: {counts:?}; {on} in force mode");
    assert!(on > 3000 && counts[0] > 2500, "{on} {counts:?}");
}

#[test]
fn a_protective_stop_allocates_nothing() {
    // A tool on the way slows the arm down; a belt that is too fast stops it.
    let mut config = ideal("cs66");
    config.limits.tcp_speed = Some(0.3);
    config.belts[0] = Some(Belt {
        encoder: 0,
        ticks_per_second: 500.0,
        start_at: 1.0,
    });
    let (mut cycle, mut script) = controller(config);
    let mut send = |script: &mut ScriptEndpoint, kind| {
        script.commands.send(Origin::default(), kind).unwrap();
        for _ in 0..120 {
            assert_eq!(tick(&mut cycle, script), 0);
        }
    };
    let q = JointPositions([1.5, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]);
    send(&mut script, movej(q));
    let far = RpyPose::from_array([0.0, -0.8, 0.0, 0.0, 0.0, 0.0]);
    send(
        &mut script,
        CommandKind::Setting(SettingCommand::SetTcp(far)),
    );
    assert_eq!(script.snapshot.read().stop_code, 0);
    let track = CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
        direction: [0.0, 1.0, 0.0],
        ticks_per_meter: 1000.0,
        encoder: 0,
    });
    send(&mut script, track);
    assert_eq!(script.snapshot.read().stop_code, 4);
}

/// The rapier plant allocates inside its engine: not a limit but a measurement that must not creep up unseen.
#[test]
fn only_the_engine_of_others_allocates_and_a_bounded_number_of_times() {
    for (plant, allowed) in [(PlantKind::Rigid, 0), (PlantKind::Rapier, 400)] {
        let mut config = CycleConfig {
            plant,
            ..ideal("cs66")
        };
        if plant == PlantKind::Rigid {
            config.truth.payload = Some(Payload::new(2.0, [0.0, 0.0, 0.05], [0.0; 6]).unwrap());
            config.truth.drivetrain.coulomb = kinematics::JointTorques([2.0; 6]);
            config.truth.drivetrain.rotor_inertia = [0.1; 6];
        }
        let (mut cycle, mut script) = controller(config);
        script
            .commands
            .send(Origin::default(), movej(JointPositions([0.5; 6])))
            .unwrap();
        for _ in 0..10 {
            cycle.tick(CycleTiming::default());
        }
        let counts: Vec<u32> = (0..100).map(|_| tick(&mut cycle, &mut script)).collect();
        let most = *counts.iter().max().unwrap();
        println!("allocator calls in a tick with {plant:?}: up to {most}");
        assert!(most <= allowed, "{plant:?}: {most}");
    }
}

#[test]
fn a_setpoint_reaches_the_plant_only_through_the_limiter() {
    let config = ideal("cs66");
    let limits = config.resolve().unwrap();
    let here = Setpoint::standing(config.home);
    let frames = config.model.forward(&here.q);
    let tcp = frames.base_from_flange.translation;
    let passed: LimitedSetpoint =
        check_setpoint(here, &here, &frames, tcp, 0.004, &limits).unwrap();
    assert_eq!(passed.as_setpoint(), &here);
    let mut jump = here;
    jump.q[3] += 0.1;
    assert!(check_setpoint(jump, &here, &frames, tcp, 0.004, &limits).is_err());
    let mut outside = here;
    outside.q[2] = 3.3;
    assert!(check_setpoint(outside, &outside, &frames, tcp, 0.004, &limits).is_err());
    let mut unusable = here;
    unusable.qd[0] = f64::NAN;
    assert!(check_setpoint(unusable, &here, &frames, tcp, 0.004, &limits).is_err());
}

/// An arm that presses a tool into three obstacles at once, and its sensor with noise.
#[test]
fn contact_allocates_nothing() {
    use kinematics::Pose;
    use kinematics::polytope::Polytope;
    use motion::contact::{Obstacle, PlacedShape, Shape};
    let mut config = ideal("cs66");
    let tool = Shape::Cylinder {
        radius: 0.03,
        half_length: 0.05,
    };
    // A tool of two pieces, as a mesh has them.
    config.surroundings.tool = vec![
        PlacedShape {
            pose: Pose::from_translation(0.0, 0.0, 0.05),
            shape: tool.clone(),
        },
        PlacedShape {
            pose: Pose::from_translation(0.02, 0.0, 0.05),
            shape: Shape::Polytope(Polytope::cuboid([0.03, 0.03, 0.05]).unwrap().into()),
        },
    ];
    let [x, y, z] = config.first_state().actual_tcp_pose.xyz;
    let shapes = [
        Shape::Box { half: [0.05; 3] },
        tool,
        Shape::Sphere { radius: 0.05 },
        Shape::Polytope(Polytope::cuboid([0.05; 3]).unwrap().into()),
    ];
    config.surroundings.obstacles = shapes
        .into_iter()
        .map(|shape| Obstacle {
            name: String::new(),
            solid: PlacedShape {
                pose: Pose::from_translation(x, y, z - 0.11),
                shape,
            },
            body: None,
            stiffness: Some(1e3),
            damping: 10.0,
            friction: 0.3,
        })
        .collect();
    config.sensor_noise.force = 0.1;
    let (mut cycle, mut script) = controller(config);
    let most = (0..500).map(|_| tick(&mut cycle, &mut script)).max();
    assert_eq!(most, Some(0));
    assert!(script.snapshot.read().tcp_force[2] < -1.0);
}
