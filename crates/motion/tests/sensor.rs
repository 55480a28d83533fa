//! The force sensor: what it reads of payload, environment and noise, its zero, the sensor of a port, and the limit.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::{Bench, ideal, movej};
use kinematics::{JointPositions, Payload, Pose, RobotModel, RpyPose, Wrench};
use motion::external::{TimedWrench, WrenchFrame};
use motion::{CycleConfig, LimitOverrides, SensorNoise};
use motion_api::{
    CommandKind, FreedriveFrame, MachineCommand, MotionCommand, OnlineCommand, Outcome, Refusal,
    RobotState, SensingCommand, SettingCommand, StopReason,
};
use nalgebra::Vector3;

fn rigid() -> CycleConfig {
    CycleConfig {
        tcp: RpyPose::from_array([0.02, 0.0, 0.15, 0.3, -0.2, 0.5]),
        payload: Payload::new(
            2.0,
            [0.01, -0.02, 0.06],
            [0.01, 0.012, 0.006, 1e-3, 0.0, 0.0],
        )
        .unwrap(),
        ..CycleConfig::new(RobotModel::built_in("cs66").unwrap())
    }
}

fn largest(values: &[f64; 6]) -> f64 {
    values.iter().fold(0.0, |most, x| most.max(x.abs()))
}

#[test]
fn a_hanging_payload_shows_in_the_raw_reading_only() {
    for config in [
        rigid(),
        CycleConfig {
            plant: motion::PlantKind::Ideal,
            ..rigid()
        },
    ] {
        let payload = config.payload;
        let flange_from_tcp = Pose::from_rpy(&config.tcp);
        let mut bench = Bench::new(config);
        for target in [
            [0.0, -1.5, 1.5, -1.5, -1.5, 0.0],
            [0.4, -1.2, 1.0, 0.3, 0.7, -1.0],
        ] {
            assert_eq!(bench.do_it(movej(JointPositions(target))), Outcome::Done);
            bench.run(200);
            let state = bench.now();
            let base_from_tcp = Pose::from_rpy(&state.actual_tcp_pose);
            let weight = base_from_tcp.rotate_back(Vector3::new(0.0, 0.0, -9.81 * payload.mass));
            let arm = flange_from_tcp.inverse().transform_point(payload.cog);
            let moment = arm.cross(&weight);
            let wanted = [weight.x, weight.y, weight.z, moment.x, moment.y, moment.z];
            for (k, wanted) in wanted.into_iter().enumerate() {
                let found = state.raw_wrench[k];
                assert!((found - wanted).abs() < 1e-3, "{k}: {found} {wanted}");
            }
            assert!(largest(&state.tcp_force) < 1e-9, "{:?}", state.tcp_force);
        }
    }
}

#[test]
fn a_moving_payload_makes_the_raw_reading_its_inertia_and_the_compensated_one_none() {
    let config = rigid();
    let (model, payload) = (config.model.clone(), config.payload);
    let step = config.step_time;
    let mut bench = Bench::new(config);
    assert_eq!(
        bench.do_it(movej(JointPositions([0.8, -1.0, 1.2, -0.5, -0.7, 1.0]))),
        Outcome::Done
    );
    let cog = |state: &RobotState| {
        model
            .flange_pose(&state.actual_q)
            .transform_point(payload.cog)
    };
    let mut most: f64 = 0.0;
    for three in bench.states.windows(3).skip(2) {
        let [p0, p1, p2] = [&three[0], &three[1], &three[2]].map(cog);
        let acceleration = (p2 - p1 * 2.0 + p0) / (step * step);
        let wanted = (Vector3::new(0.0, 0.0, -9.81) - acceleration) * payload.mass;
        // The sensor's acceleration is the mean over its cycle, half a cycle later than this difference.
        let raw = |s: &RobotState| {
            Pose::from_rpy(&s.actual_tcp_pose).rotate(Vector3::from_row_slice(&s.raw_wrench[..3]))
        };
        let found = (raw(&three[1]) + raw(&three[2])) / 2.0;
        assert!((found - wanted).norm() < 0.3, "{found:?} {wanted:?}");
        assert!(largest(&three[2].tcp_force) < 1e-9);
        most = most.max(acceleration.norm());
    }
    assert!(most > 0.5, "{most}");
}

#[test]
fn zeroing_takes_off_what_is_read_and_turns_with_the_tool() {
    let mut bench = Bench::new(rigid());
    bench.push([3.0, -4.0, 6.0, 0.5, -0.2, 0.1]);
    // Until the arm, which gives way a little, stands.
    bench.run(200);
    let raw = bench.now().raw_wrench;
    assert_eq!(bench.do_it(SensingCommand::ZeroFtSensor), Outcome::Done);
    assert!(largest(&bench.now().tcp_force) < 1e-12);
    for (now, before) in bench.now().raw_wrench.iter().zip(raw) {
        assert!((now - before).abs() < 1e-9);
    }
    // A second zero replaces the first, it does not add to it.
    bench.do_it(SensingCommand::ZeroFtSensor);
    bench.run(1);
    assert!(largest(&bench.now().tcp_force) < 1e-12);
    // Without the push its opposite is left, and keeps to the tool.
    bench.push([0.0; 6]);
    bench.run(200);
    let before = bench.now();
    let norm = |s: &RobotState| Vector3::from_row_slice(&s.tcp_force[..3]).norm();
    assert!((norm(&before) - 61.0_f64.sqrt()).abs() < 1e-9);
    bench.do_it(movej(JointPositions([0.5, -1.3, 1.2, -1.0, -0.7, 0.6])));
    for k in 0..6 {
        assert!((bench.now().tcp_force[k] - before.tcp_force[k]).abs() < 1e-9);
    }
    // Another TCP on the same flange: the same force, other axes.
    bench.do_it(SettingCommand::SetTcp(RpyPose::default()));
    bench.run(1);
    assert!((norm(&bench.now()) - 61.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn noise_is_seeded_and_has_the_deviations_that_were_set() {
    let run = |seed| {
        let noise = SensorNoise {
            force: 0.5,
            torque: 0.02,
            seed,
        };
        let mut bench = Bench::new(CycleConfig {
            sensor_noise: noise,
            ..ideal("cs66")
        });
        bench.run(2000);
        bench
            .states
            .iter()
            .skip(1)
            .map(|s| s.tcp_force)
            .collect::<Vec<_>>()
    };
    let readings = run(5);
    assert_eq!(readings, run(5));
    assert_ne!(readings, run(6));
    for k in 0..6 {
        let wanted = if k < 3 { 0.5 } else { 0.02 };
        let mean = readings.iter().map(|w| w[k]).sum::<f64>() / 2000.0;
        let square = readings.iter().map(|w| (w[k] - mean).powi(2)).sum::<f64>() / 2000.0;
        assert!(mean.abs() < 0.1 * wanted, "{k}: {mean}");
        assert!((square.sqrt() / wanted - 1.0).abs() < 0.08, "{k}: {square}");
    }
}

#[test]
fn readings_of_a_port_count_while_they_are_enabled() {
    let mut bench = Bench::new(rigid());
    let set = CommandKind::Sensing(SensingCommand::SetExternalWrench([
        0.0, 0.0, -10.0, 0.0, 0.0, 0.0,
    ]));
    bench.do_it(set);
    bench.run(3);
    assert!(largest(&bench.now().tcp_force) < 1e-9);
    let enable = |enabled, mass, measuring_offset, cog| {
        CommandKind::Sensing(SensingCommand::FtRtsiInput {
            enabled,
            mass,
            measuring_offset,
            cog,
        })
    };
    // At once what was sent last, about the TCP.
    bench.do_it(enable(true, 0.0, [0.0; 3], [0.0; 3]));
    let felt = |bench: &Bench| {
        let state = bench.now();
        let base_from_tcp = Pose::from_rpy(&state.actual_tcp_pose);
        let w = Wrench::from_array(state.tcp_force);
        (
            base_from_tcp.rotate(w.force),
            base_from_tcp.rotate(w.moment),
            state,
        )
    };
    let (force, moment, _) = felt(&bench);
    assert!((force.z + 10.0).abs() < 1e-9 && moment.norm() < 1e-9);
    // A sensor of 1 kg, measured 50 mm before the flange: its weight is 9.81 N of the 10 N.
    bench.do_it(enable(true, 1.0, [0.0, 0.0, 0.05], [0.0, 0.0, 0.02]));
    let (force, moment, state) = felt(&bench);
    assert!((force.z + 0.19).abs() < 1e-9, "{force:?}");
    let model = RobotModel::built_in("cs66").unwrap();
    let flange = model.flange_pose(&state.actual_q);
    let point = |z| flange.transform_point(Vector3::new(0.0, 0.0, z));
    let tcp = Vector3::from(state.actual_tcp_pose.xyz);
    let weight = Vector3::new(0.0, 0.0, -9.81);
    let wanted = -(point(0.02) - point(0.05)).cross(&weight) + (point(0.05) - tcp).cross(&force);
    assert!((moment - wanted).norm() < 1e-6, "{moment:?} {wanted:?}");
    bench.do_it(enable(false, 0.0, [0.0; 3], [0.0; 3]));
    bench.run(1);
    assert!(largest(&bench.now().tcp_force) < 1e-9);
    for bad in [
        enable(true, -1.0, [0.0; 3], [0.0; 3]),
        enable(true, f64::NAN, [0.0; 3], [0.0; 3]),
        enable(true, 1.0, [f64::INFINITY, 0.0, 0.0], [0.0; 3]),
        enable(true, 1.0, [0.0; 3], [0.0, 11.0, 0.0]),
    ] {
        let outcome = bench.do_it(bad);
        assert!(matches!(
            outcome,
            Outcome::Refused(Refusal::BadValue { .. })
        ));
    }
}

#[test]
fn the_force_limit_of_the_cell_stops_the_arm_and_lets_it_leave() {
    let mut bench = Bench::new(CycleConfig {
        limits: LimitOverrides {
            tcp_force: Some(25.0),
            ..LimitOverrides::default()
        },
        ..rigid()
    });
    bench.push([0.0, 0.0, 24.0, 0.0, 0.0, 0.0]);
    bench.run(50);
    assert!(bench.stops.is_empty());
    bench.push([0.0, 0.0, 26.0, 0.0, 0.0, 0.0]);
    bench.run(250);
    let [StopReason::TcpForce { force, limit }] = bench.stops[..] else {
        panic!("{:?}", bench.stops);
    };
    assert!((force - 26.0).abs() < 1e-6 && limit == 25.0);
    assert_eq!(bench.now().stop_code, 14);
    // It still presses, but no harder than it did.
    assert_eq!(
        bench.do_it(MachineCommand::UnlockProtectiveStop),
        Outcome::Done
    );
    bench.run(100);
    assert_eq!(bench.stops.len(), 1);
    bench.push([0.0, 0.0, 40.0, 0.0, 0.0, 0.0]);
    bench.run(100);
    assert_eq!(bench.stops.len(), 2);
}

#[test]
fn locked_axes_of_the_rigid_arm_hold_within_a_tenth_of_a_millimetre() {
    let turned = RpyPose::from_array([0.1, 0.2, 0.3, 0.3, -0.4, 0.7]);
    let mut worst = [0.0_f64; 2];
    for frame in [
        FreedriveFrame::Base,
        FreedriveFrame::Tool,
        FreedriveFrame::Pose(turned),
    ] {
        for free in [
            [false, true, false, false, false, false],
            [true, false, true, false, false, false],
            [false, false, false, false, true, true],
        ] {
            let mut config = rigid();
            let wrench = [12.0, -30.0, 15.0, 1.0, 2.0, -1.5];
            config.loads = vec![TimedWrench {
                at: 0.1,
                duration: 1.0,
                wrench: Wrench::from_array(wrench),
                frame: WrenchFrame::Tool,
            }];
            config.sensor_noise = SensorNoise {
                force: 0.2,
                torque: 0.01,
                seed: 1,
            };
            let mut bench = Bench::new(config);
            let start = Pose::from_rpy(&bench.now().actual_tcp_pose);
            let axes = match frame {
                FreedriveFrame::Base => Pose::IDENTITY.rotation,
                FreedriveFrame::Tool => start.rotation,
                FreedriveFrame::Pose(pose) => Pose::from_rpy(&pose).rotation,
            };
            assert_eq!(
                bench.do_it(OnlineCommand::Freedrive {
                    free_axes: free,
                    frame
                }),
                Outcome::Done
            );
            bench.run(350);
            assert!(bench.stops.is_empty(), "{:?}", bench.stops);
            let mut led = 0.0_f64;
            for state in &bench.states {
                let now = Pose::from_rpy(&state.actual_tcp_pose);
                let turn = (now.rotation * start.rotation.inverse()).scaled_axis();
                let way = axes.inverse() * (now.translation - start.translation);
                let turn = axes.inverse() * turn;
                let moved = [way.x, way.y, way.z, turn.x, turn.y, turn.z];
                for k in 0..6 {
                    if free[k] {
                        led = led.max(moved[k].abs());
                    } else if k < 3 || !free[3..].contains(&true) {
                        // With two free rotations the others are no components of the rotation vector.
                        worst[k / 3] = worst[k / 3].max(moved[k].abs());
                    }
                }
            }
            assert!(led > 0.01, "{frame:?} {free:?}: {led}");
        }
    }
    println!("locked axes: {:.2e} m, {:.2e} rad", worst[0], worst[1]);
    assert!(worst[0] < 1e-4 && worst[1] < 1e-4, "{worst:?}");
}

/// Ten minutes with `ELITE_LONG=1`; half a minute otherwise.
#[test]
fn random_rated_motion_is_never_taken_for_a_collision() {
    let long = std::env::var_os("ELITE_LONG").is_some();
    let duration = if long { 600.0 } else { 30.0 };
    let mut config = rigid();
    let rated = config.model.rated_payload_kg().unwrap();
    config.payload =
        Payload::new(rated, [0.02, 0.0, 0.06], [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]).unwrap();
    config.step_time = 0.004;
    let home = config.home;
    let effort = config.model.limits().effort;
    let mut bench = Bench::new(config);
    bench.do_it(SensingCommand::SetCollisionSensitivity(100));
    let mut seed = 11_u64;
    let mut random = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(1_u32 << 31)
    };
    let (mut most, mut moves, mut time) = (0.0_f64, 0, 0.0);
    while time < duration {
        let target = JointPositions(core::array::from_fn(|j| home[j] + 3.0 * (random() - 0.5)));
        let kind = if moves % 4 == 3 {
            CommandKind::Online(OnlineCommand::SpeedJ {
                speeds: kinematics::JointSpeeds(core::array::from_fn(|_| 1.5 * (random() - 0.5))),
                acceleration: 1.0 + 8.0 * random(),
                duration: Some(0.3),
            })
        } else {
            CommandKind::Motion(MotionCommand::MoveJ {
                target,
                acceleration: 0.5 + 10.0 * random(),
                speed: 0.3 + 2.5 * random(),
                duration: 0.0,
                radius: 0.0,
            })
        };
        let outcome = bench.do_it(kind);
        assert!(bench.stops.is_empty(), "after {time} s: {:?}", bench.stops);
        assert_eq!(outcome, Outcome::Done);
        for state in bench.states.drain(1..) {
            for joint in 0..6 {
                most = most.max((state.external_torque[joint] / effort[joint]).abs());
            }
            time = state.time;
        }
        moves += 1;
    }
    println!("{moves} motions in {time:.0} s: largest residual {most:.4} of the nominal torque");
    assert!(most < 0.05, "{most}");
}
