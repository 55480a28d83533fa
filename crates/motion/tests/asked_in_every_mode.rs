//! Every family of commands while the arm does everything that it can do: taken or refused, with the reason that the
//! table here says, whatever the table inside says. Nothing jumps, and every command ends.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::{Bench, ideal, moved, movej, movel};
use core::f64::consts::TAU;
use kinematics::{JointPositions, JointSpeeds, RpyPose};
use motion::CycleConfig;
use motion::modes::encoder::Belt;
use motion_api::{
    CommandId, CommandKind, FreedriveFrame, InputAction, IoChange, MachineCommand, MotionCommand,
    OnlineCommand, Origin, Outcome, OverlayCommand, ProgramId, Refusal, SettingCommand,
    ThreadNumber,
};

/// What the arm does, and what is asked of it meanwhile by the same thread: movej, speedj, freedrive, force mode, a
/// belt, offsets, another tool. A point is taken; R not ready, B busy, S still moving, L led by hand, T tracking, F in
/// force mode, O offsets count, U turns about the TCP.
const TABLE: [(Doing, &str); 21] = [
    (Doing::WithoutPower, "RRRRRR."),
    (Doing::BrakesOn, "RRRRRR."),
    (Doing::ProtectiveStop, "RRRRRR."),
    (Doing::Standing, "......."),
    (Doing::Moving, "BBB...."),
    (Doing::Paused, "BBB...."),
    (Doing::MovingTold, ".BB...."),
    (Doing::Stopping, "......."),
    (Doing::Leaving, "......."),
    (Doing::Halting, "......."),
    (Doing::Streaming, "B.B...."),
    (Doing::SteeredByAnother, "BBB...."),
    (Doing::Coasting, "..B...."),
    (Doing::ComingToRest, "......."),
    (Doing::Led, "BB.BLL."),
    (Doing::LedByInput, "LL.LLL."),
    (Doing::OnABelt, "..TTTT."),
    (Doing::OnATable, "..TTTTU"),
    (Doing::LeavingTheBelt, "..TTTT."),
    (Doing::Pressing, "..F.FF."),
    (Doing::UnderOffsets, "..OOO.O"),
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Doing {
    WithoutPower,
    BrakesOn,
    ProtectiveStop,
    Standing,
    Moving,
    Paused,
    MovingTold,
    Stopping,
    Leaving,
    Halting,
    Streaming,
    SteeredByAnother,
    Coasting,
    ComingToRest,
    Led,
    LedByInput,
    OnABelt,
    OnATable,
    LeavingTheBelt,
    Pressing,
    UnderOffsets,
}

const FAR: JointPositions = JointPositions([1.0, -1.2, 1.9, -1.6, -1.2, 0.8]);

fn speedj(duration: Option<f64>) -> CommandKind {
    CommandKind::Online(OnlineCommand::SpeedJ {
        speeds: JointSpeeds([0.4, 0.1, -0.1, 0.1, 0.2, 0.3]),
        acceleration: 1.0,
        duration,
    })
}

const HAND: CommandKind = CommandKind::Online(OnlineCommand::Freedrive {
    free_axes: [true; 6],
    frame: FreedriveFrame::Base,
});

fn press() -> CommandKind {
    CommandKind::Overlay(OverlayCommand::ForceMode {
        frame: RpyPose::default(),
        selection: [false, false, true, false, false, false],
        wrench: [0.0, 0.0, 8.0, 0.0, 0.0, 0.0],
        mode: 0,
        speed_limits: [0.05; 6],
    })
}

const BELT: CommandKind = CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
    direction: [0.0, 1.0, 0.0],
    ticks_per_meter: 1000.0,
    encoder: 0,
});

fn asked() -> [CommandKind; 7] {
    [
        movej(FAR),
        speedj(Some(0.2)),
        HAND,
        press(),
        BELT,
        CommandKind::Overlay(OverlayCommand::PathOffsetEnable),
        CommandKind::Setting(SettingCommand::SetTcp(RpyPose::from_array([
            0.0, 0.0, 0.05, 0.0, 0.0, 0.0,
        ]))),
    ]
}

/// A bench whose arm does that.
fn doing(what: Doing) -> Bench {
    let mut bench = Bench::new(CycleConfig {
        belts: [
            Some(Belt {
                encoder: 0,
                ticks_per_second: 60.0,
                start_at: 0.0,
            }),
            None,
        ],
        ..ideal("cs66")
    });
    // A force that comes and goes with a mode is seen as the mean over its step.
    bench.jerk_slack = 0.1;
    bench.tick();
    let at = bench.now().target_tcp_pose;
    match what {
        Doing::Standing => {}
        Doing::WithoutPower => assert_eq!(bench.do_it(MachineCommand::PowerOff), Outcome::Done),
        Doing::BrakesOn => {
            bench.do_it(MachineCommand::PowerOff);
            bench.run(500);
            bench.do_it(MachineCommand::PowerOn);
        }
        Doing::ProtectiveStop => {
            bench.do_it(MachineCommand::ProtectiveStop);
            bench.run(20);
        }
        Doing::Moving => drop(bench.send(movel(moved(&at, [0.05, 0.2, -0.05])))),
        Doing::Paused => {
            bench.send(movel(moved(&at, [0.05, 0.2, -0.05])));
            bench.run(60);
            bench.send(MachineCommand::Pause);
            bench.run(200);
        }
        Doing::MovingTold => {
            let first = bench.send(MotionCommand::MoveL {
                target: moved(&at, [0.05, 0.2, -0.05]),
                acceleration: 0.8,
                speed: 0.2,
                duration: 0.0,
                radius: 0.03,
            });
            while !bench.queued.contains(&first) {
                bench.tick();
            }
        }
        Doing::Leaving | Doing::Halting => {
            bench.do_it(MotionCommand::MoveL {
                target: moved(&at, [0.05, 0.2, -0.05]),
                acceleration: 0.3,
                speed: 0.2,
                duration: 0.0,
                radius: 0.08,
            });
            if what == Doing::Halting {
                bench.send(MachineCommand::Stop {
                    only: CommandId::NONE,
                });
                bench.run(2);
            }
        }
        Doing::Stopping => {
            bench.send(MotionCommand::MoveL {
                target: moved(&at, [0.05, 0.3, -0.05]),
                acceleration: 0.3,
                speed: 0.2,
                duration: 0.0,
                radius: 0.0,
            });
            bench.run(150);
            bench.send(OnlineCommand::StopL { acceleration: 0.3 });
            bench.run(10);
        }
        Doing::Streaming => {
            bench.send(speedj(Some(2.0)));
            bench.run(50);
        }
        Doing::SteeredByAnother => {
            let other = Origin {
                program: ProgramId(0),
                thread: ThreadNumber(3),
                line: 0,
            };
            let port = &bench.script.commands;
            port.send(other, speedj(Some(2.0))).unwrap();
            bench.run(50);
        }
        Doing::Coasting => drop(bench.do_it(speedj(Some(0.3)))),
        Doing::ComingToRest => {
            bench.do_it(speedj(Some(0.5)));
            bench.send(OnlineCommand::StopJ { acceleration: 0.4 });
            bench.run(5);
        }
        Doing::Led => {
            bench.push([0.0, 30.0, 0.0, 0.0, 0.0, 0.0]);
            bench.do_it(HAND);
            bench.run(50);
        }
        Doing::LedByInput => {
            let action = InputAction::Freedrive;
            bench.do_it(SettingCommand::SetIo(IoChange::DigitalInAction {
                bit: 0,
                action,
            }));
            bench.do_it(SettingCommand::SetDigitalInput {
                index: 0,
                level: true,
            });
            bench.push([0.0, 30.0, 0.0, 0.0, 0.0, 0.0]);
            bench.run(50);
        }
        Doing::OnABelt | Doing::LeavingTheBelt => {
            bench.do_it(BELT);
            bench.run(100);
            if what == Doing::LeavingTheBelt {
                bench.send(OverlayCommand::StopConveyorTracking);
                bench.run(2);
            }
        }
        Doing::OnATable => {
            bench.do_it(OverlayCommand::TrackConveyorCircular {
                center: RpyPose::from_array([-0.6, 0.25, 0.0, 0.0, 0.0, 0.4]),
                ticks_per_revolution: 1000.0 * TAU,
                rotate_tool: false,
                encoder: 0,
            });
            bench.run(100);
        }
        Doing::Pressing => {
            bench.do_it(press());
            bench.run(50);
        }
        Doing::UnderOffsets => {
            bench.do_it(OverlayCommand::PathOffsetEnable);
            bench.run(20);
        }
    }
    bench
}

fn letter(outcome: Option<Outcome>) -> char {
    match outcome {
        Some(Outcome::Refused(refusal)) => match refusal {
            Refusal::NotReady { .. } | Refusal::WrongMode { .. } => 'R',
            Refusal::Busy { .. } => 'B',
            Refusal::StillMoving => 'S',
            Refusal::HandGuided => 'L',
            Refusal::ConveyorTracking => 'T',
            Refusal::InForceMode => 'F',
            Refusal::PathOffset => 'O',
            Refusal::NonRotatingTurntable => 'U',
            other => panic!("{other}"),
        },
        _ => '.',
    }
}

#[test]
fn every_command_in_every_mode_is_taken_or_refused_for_the_reason_in_the_table() {
    let mut wrong = Vec::new();
    for (what, expected) in TABLE {
        let mut found = String::new();
        for kind in asked() {
            let mut bench = doing(what);
            let id = bench.send(kind);
            bench.run(3);
            found.push(letter(bench.outcome(id)));
            bench.run(250);
            bench.send(SettingCommand::SetDigitalInput {
                index: 0,
                level: false,
            });
            bench.send(MachineCommand::Resume);
            let only = CommandId::NONE;
            let stop = bench.send(MachineCommand::Stop { only });
            for id in [id, stop] {
                bench.finish(id);
            }
            bench.run(200);
            if !bench.stops.is_empty() && what != Doing::ProtectiveStop {
                wrong.push(format!("{what:?}, {kind:?}: {:?}", bench.stops));
            }
            let faults = bench.limit_faults();
            if let Some(first) = faults.first() {
                wrong.push(format!("{what:?}, {kind:?}: {first}"));
            }
            if !bench.cycle.is_standing() {
                wrong.push(format!("{what:?}, {kind:?}: moves in the end"));
            }
        }
        if found != expected {
            wrong.push(format!("{what:?}: {found} instead of {expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
