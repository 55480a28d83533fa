//! Every command there is, with any numbers, at any moment, under any stop: limits hold, nothing jumps, nothing panics,
//! every command ends once.
//!
//! A few runs here; `ELITE_CASES=1000` makes that many from `ELITE_FIRST` on, `ELITE_CASE=N` one, which tells what it
//! sends.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, ideal, moved};
use kinematics::{JointPositions, JointSpeeds, Payload, RpyPose};
use motion::modes::encoder::Belt;
use motion::{CycleConfig, InputPair, LimitOverrides, SafetyInputs};
use motion_api::{
    CommandId, CommandKind, DigitalBank, EncoderRange, FreedriveFrame, InputAction, IoChange,
    MachineCommand, MotionCommand, OffsetAxes, OnlineCommand, Origin, OverlayCommand, PointList,
    ProgramId, PulseDecoding, SensingCommand, SettingCommand, StopReason, ThreadNumber,
};

/// Runs when nothing else is said.
const CASES: u64 = 40;
/// Commands of a run.
const COMMANDS: usize = 50;

/// Cases in which a limit was broken once: offsets of the path and belts that ended while the arm made good what it
/// lagged behind, force mode that began, or went on, under a motion, and `speedl` to the end of the arm's reach.
const ONCE_WRONG: [u64; 13] = [
    47, 232, 298, 370, 440, 492, 798, 983, 1427, 1783, 1861, 2662, 2845,
];

/// Kinds of commands; [`place`] puts each of them somewhere.
const KINDS: usize = 52;

/// The place of a kind among all. There is no wildcard: a new command has no place, and this does not compile until it
/// has one and is drawn below.
fn place(kind: &CommandKind) -> usize {
    match kind {
        CommandKind::Motion(MotionCommand::MoveJ { .. }) => 0,
        CommandKind::Motion(MotionCommand::MoveL { .. }) => 1,
        CommandKind::Motion(MotionCommand::MoveC { .. }) => 2,
        CommandKind::Motion(MotionCommand::MoveP { .. }) => 3,
        CommandKind::Setting(SettingCommand::SetDigitalInput { .. }) => 4,
        CommandKind::Motion(MotionCommand::MoveMl { .. }) => 5,
        CommandKind::Machine(MachineCommand::Stop { .. }) => 6,
        CommandKind::Machine(MachineCommand::Pause) => 7,
        CommandKind::Machine(MachineCommand::Resume) => 8,
        CommandKind::Setting(SettingCommand::SetTcp(_)) => 9,
        CommandKind::Setting(SettingCommand::SetPayload(_)) => 10,
        CommandKind::Setting(SettingCommand::SetStandardDigitalOut { .. }) => 11,
        CommandKind::Setting(SettingCommand::SetIo(_)) => 12,
        CommandKind::Setting(SettingCommand::SetSpeedFraction(_)) => 13,
        CommandKind::Machine(MachineCommand::PowerOn) => 14,
        CommandKind::Machine(MachineCommand::PowerOff) => 15,
        CommandKind::Machine(MachineCommand::ReleaseBrakes) => 16,
        CommandKind::Machine(MachineCommand::UnlockProtectiveStop) => 17,
        CommandKind::Machine(MachineCommand::RestartSafetyBoard) => 18,
        CommandKind::Machine(MachineCommand::EmergencyStop { .. }) => 19,
        CommandKind::Online(OnlineCommand::ServoJ { .. }) => 20,
        CommandKind::Online(OnlineCommand::SpeedJ { .. }) => 21,
        CommandKind::Online(OnlineCommand::SpeedL { .. }) => 22,
        CommandKind::Online(OnlineCommand::StopJ { .. }) => 23,
        CommandKind::Online(OnlineCommand::StopL { .. }) => 24,
        CommandKind::Setting(SettingCommand::SetGravity(_)) => 25,
        CommandKind::Online(OnlineCommand::Freedrive { .. }) => 26,
        CommandKind::Online(OnlineCommand::EndFreedrive) => 27,
        CommandKind::Overlay(OverlayCommand::ForceMode { .. }) => 28,
        CommandKind::Overlay(OverlayCommand::EndForceMode) => 29,
        CommandKind::Sensing(SensingCommand::SetForceGain(_)) => 30,
        CommandKind::Sensing(SensingCommand::SetForceDamping(_)) => 31,
        CommandKind::Sensing(SensingCommand::SetExternalWrench(_)) => 32,
        CommandKind::Sensing(SensingCommand::FtRtsiInput { .. }) => 33,
        CommandKind::Sensing(SensingCommand::ZeroFtSensor) => 34,
        CommandKind::Sensing(SensingCommand::SetCollisionDetection(_)) => 35,
        CommandKind::Sensing(SensingCommand::SetCollisionSensitivity(_)) => 36,
        CommandKind::Overlay(OverlayCommand::TrackConveyorLinear { .. }) => 37,
        CommandKind::Overlay(OverlayCommand::TrackConveyorCircular { .. }) => 38,
        CommandKind::Overlay(OverlayCommand::StopConveyorTracking) => 39,
        CommandKind::Setting(SettingCommand::EncoderEnableSetTickCount { .. }) => 40,
        CommandKind::Setting(SettingCommand::EncoderSetTickCount { .. }) => 41,
        CommandKind::Setting(SettingCommand::EncoderEnablePulseDecode { .. }) => 42,
        CommandKind::Overlay(OverlayCommand::PathOffsetEnable) => 43,
        CommandKind::Overlay(OverlayCommand::PathOffsetDisable { .. }) => 44,
        CommandKind::Overlay(OverlayCommand::PathOffsetSet { .. }) => 45,
        CommandKind::Overlay(OverlayCommand::PathOffsetFilter(_)) => 46,
        CommandKind::Overlay(OverlayCommand::PathOffsetMax { .. }) => 47,
        CommandKind::Sensing(SensingCommand::Push { .. }) => 48,
        CommandKind::Machine(MachineCommand::ProtectiveStop) => 49,
        CommandKind::Setting(SettingCommand::SetIoAtZone { .. }) => 50,
        CommandKind::Online(OnlineCommand::FollowPoints { .. }) => 51,
    }
}

/// Draws commands for an arm that is somewhere.
struct Wild {
    draw: Draw,
    at: RpyPose,
    q: JointPositions,
}

impl Wild {
    /// Mostly within `low` and `high`, sometimes anything.
    fn number(&mut self, low: f64, high: f64) -> f64 {
        if self.draw.chance(0.97) {
            return self.draw.between(low, high);
        }
        *self.draw.pick(&[
            0.0,
            -1.0,
            1e-300,
            1e-6,
            1e6,
            1e300,
            f64::NAN,
            f64::INFINITY,
            f64::MAX,
        ])
    }

    fn six(&mut self, most: f64) -> [f64; 6] {
        core::array::from_fn(|_| self.number(-most, most))
    }

    fn joints(&mut self) -> JointPositions {
        JointPositions(core::array::from_fn(|j| self.q[j] + self.number(-0.7, 0.7)))
    }

    fn pose(&mut self) -> RpyPose {
        let by = core::array::from_fn(|_| self.number(-0.15, 0.15));
        let mut pose = moved(&self.at, by);
        (0..3).for_each(|k| pose.rpy[k] += self.number(-0.3, 0.3));
        pose
    }

    fn flags(&mut self) -> [bool; 6] {
        core::array::from_fn(|_| self.draw.chance(0.5))
    }

    fn speed(&mut self) -> f64 {
        self.number(0.02, 1.5)
    }

    /// Not so little that a stop would take for ever.
    fn acceleration(&mut self) -> f64 {
        let a = self.number(0.1, 15.0);
        if a > 0.0 && a < 0.01 { 0.01 } else { a }
    }

    fn radius(&mut self) -> f64 {
        if self.draw.chance(0.5) {
            0.0
        } else {
            self.number(0.0, 0.08)
        }
    }

    fn duration(&mut self) -> f64 {
        if self.draw.chance(0.8) {
            0.0
        } else {
            self.number(0.0, 2.0)
        }
    }

    fn call(&mut self) -> Option<f64> {
        self.draw.chance(0.6).then(|| self.number(0.004, 0.4))
    }

    fn frame(&mut self) -> FreedriveFrame {
        match self.draw.whole(0, 2) {
            0 => FreedriveFrame::Base,
            1 => FreedriveFrame::Tool,
            _ => FreedriveFrame::Pose(self.pose()),
        }
    }

    fn range(&mut self) -> EncoderRange {
        *self.draw.pick(&[
            EncoderRange::Signed32,
            EncoderRange::Unsigned8,
            EncoderRange::Unsigned16,
        ])
    }

    fn tool(&mut self) -> RpyPose {
        RpyPose::from_array(core::array::from_fn(|_| self.number(-0.15, 0.15)))
    }

    fn change(&mut self) -> IoChange {
        let action = *self
            .draw
            .pick(&[InputAction::Freedrive, InputAction::Default]);
        match self.draw.whole(0, 5) {
            0 => IoChange::SafetyHardness(self.draw.whole(0, 1) as u8),
            1 => IoChange::DigitalInAction { bit: 0, action },
            2 => IoChange::BooleanRegisterAction { index: 3, action },
            3 => IoChange::InputActionsToDefault,
            4 => IoChange::ProgramRunning(self.draw.chance(0.5)),
            _ => IoChange::digital_out(DigitalBank::Standard, 1, self.draw.chance(0.5)),
        }
    }

    /// Points for a moveml; `None` where they are none.
    fn points(&mut self, count: u32) -> Option<PointList> {
        let (are_poses, by, ways) = (
            self.draw.chance(0.5),
            self.number(-0.01, 0.01),
            self.six(0.01),
        );
        let [x, y, z] = self.at.xyz;
        let sample = |k: u32| {
            let k = f64::from(k);
            if are_poses {
                return [x + by * k, y, z, 0.0, 1.0, 0.0, 0.0];
            }
            core::array::from_fn(|j| ways.get(j).map_or(0.0, |way| self.q[j] + way * k))
        };
        PointList::new((0..count).map(sample).collect(), are_poses).ok()
    }

    /// The command at that place.
    fn command(&mut self, place: usize) -> CommandKind {
        match place {
            0 => CommandKind::Motion(MotionCommand::MoveJ {
                target: self.joints(),
                acceleration: self.acceleration(),
                speed: self.speed(),
                duration: self.duration(),
                radius: self.radius(),
            }),
            1 => CommandKind::Motion(MotionCommand::MoveL {
                target: self.pose(),
                acceleration: self.acceleration(),
                speed: self.speed(),
                duration: self.duration(),
                radius: self.radius(),
            }),
            2 => CommandKind::Motion(MotionCommand::MoveC {
                via: self.pose(),
                target: self.pose(),
                acceleration: self.acceleration(),
                speed: self.speed(),
                radius: self.radius(),
                fixed: self.draw.chance(0.5),
            }),
            3 => CommandKind::Motion(MotionCommand::MoveP {
                target: self.pose(),
                acceleration: self.acceleration(),
                speed: self.speed(),
                radius: self.radius(),
            }),
            5 => CommandKind::Motion(MotionCommand::MoveMl {
                count: self.draw.whole(1, 4) as u32,
                interval: self.number(0.002, 0.2),
            }),
            51 => CommandKind::Online(OnlineCommand::FollowPoints {
                count: self.draw.whole(2, 40) as u32,
                interval: self.number(0.002, 0.2),
            }),
            6 => CommandKind::Machine(MachineCommand::Stop {
                only: CommandId(if self.draw.chance(0.5) {
                    0
                } else {
                    self.draw.whole(0, 60) as u64
                }),
            }),
            7 => CommandKind::Machine(MachineCommand::Pause),
            8 => CommandKind::Machine(MachineCommand::Resume),
            9 => CommandKind::Setting(SettingCommand::SetTcp(self.tool())),
            10 => CommandKind::Setting(SettingCommand::SetPayload(Payload {
                mass: self.number(0.0, 5.0),
                cog: [0.0, 0.0, self.number(0.0, 0.1)].into(),
                inertia: [0.0; 6],
            })),
            11 => CommandKind::Setting(SettingCommand::SetStandardDigitalOut {
                index: self.draw.whole(0, 17) as u8,
                level: self.draw.chance(0.5),
            }),
            12 => CommandKind::Setting(SettingCommand::SetIo(self.change())),
            13 => CommandKind::Setting(SettingCommand::SetSpeedFraction(self.number(0.0, 1.0))),
            14 => CommandKind::Machine(MachineCommand::PowerOn),
            15 => CommandKind::Machine(MachineCommand::PowerOff),
            16 => CommandKind::Machine(MachineCommand::ReleaseBrakes),
            17 => CommandKind::Machine(MachineCommand::UnlockProtectiveStop),
            18 => CommandKind::Machine(MachineCommand::RestartSafetyBoard),
            19 => CommandKind::Machine(MachineCommand::EmergencyStop {
                pressed: self.draw.chance(0.3),
            }),
            20 => CommandKind::Online(OnlineCommand::ServoJ {
                target: self.joints(),
                duration: self.number(0.002, 0.1),
                lookahead: self.number(0.03, 0.2),
                gain: self.number(100.0, 2000.0),
            }),
            21 => CommandKind::Online(OnlineCommand::SpeedJ {
                speeds: JointSpeeds(self.six(1.5)),
                acceleration: self.acceleration(),
                duration: self.call(),
            }),
            22 => CommandKind::Online(OnlineCommand::SpeedL {
                speed: self.six(0.5),
                acceleration: self.acceleration(),
                rotation_acceleration: self.acceleration(),
                duration: self.call(),
            }),
            23 => CommandKind::Online(OnlineCommand::StopJ {
                acceleration: self.acceleration(),
            }),
            24 => CommandKind::Online(OnlineCommand::StopL {
                acceleration: self.acceleration(),
            }),
            25 => CommandKind::Setting(SettingCommand::SetGravity(core::array::from_fn(|_| {
                self.number(-9.0, 9.0)
            }))),
            26 => CommandKind::Online(OnlineCommand::Freedrive {
                free_axes: self.flags(),
                frame: self.frame(),
            }),
            27 => CommandKind::Online(OnlineCommand::EndFreedrive),
            28 => CommandKind::Overlay(OverlayCommand::ForceMode {
                frame: self.pose(),
                selection: self.flags(),
                wrench: self.six(20.0),
                mode: self.draw.whole(0, 4) as u8,
                speed_limits: self.six(0.2).map(f64::abs),
            }),
            29 => CommandKind::Overlay(OverlayCommand::EndForceMode),
            30 => CommandKind::Sensing(SensingCommand::SetForceGain(self.number(0.0, 2.0))),
            31 => CommandKind::Sensing(SensingCommand::SetForceDamping(self.number(0.0, 1.0))),
            32 => CommandKind::Sensing(SensingCommand::SetExternalWrench(self.six(40.0))),
            33 => CommandKind::Sensing(SensingCommand::FtRtsiInput {
                enabled: self.draw.chance(0.7),
                mass: self.number(0.0, 0.3),
                measuring_offset: [0.0; 3],
                cog: [0.0; 3],
            }),
            34 => CommandKind::Sensing(SensingCommand::ZeroFtSensor),
            35 => {
                CommandKind::Sensing(SensingCommand::SetCollisionDetection(self.draw.chance(0.3)))
            }
            36 => CommandKind::Sensing(SensingCommand::SetCollisionSensitivity(
                self.draw.whole(0, 110) as u8,
            )),
            37 => CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
                direction: core::array::from_fn(|_| self.number(-1.0, 1.0)),
                ticks_per_meter: self.number(500.0, 2000.0),
                encoder: self.draw.whole(0, 2) as u8,
            }),
            38 => CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
                center: self.pose(),
                ticks_per_revolution: self.number(3000.0, 9000.0),
                rotate_tool: self.draw.chance(0.5),
                encoder: self.draw.whole(0, 1) as u8,
            }),
            39 => CommandKind::Overlay(OverlayCommand::StopConveyorTracking),
            40 => CommandKind::Setting(SettingCommand::EncoderEnableSetTickCount {
                encoder: self.draw.whole(0, 1) as u8,
                range: self.range(),
            }),
            41 => CommandKind::Setting(SettingCommand::EncoderSetTickCount {
                encoder: self.draw.whole(0, 1) as u8,
                count: self.number(0.0, 200.0),
            }),
            42 => CommandKind::Setting(SettingCommand::EncoderEnablePulseDecode {
                encoder: self.draw.whole(0, 1) as u8,
                decoding: PulseDecoding::Quadrature,
                channel_a: 16,
                channel_b: 17,
            }),
            43 => CommandKind::Overlay(OverlayCommand::PathOffsetEnable),
            44 => CommandKind::Overlay(OverlayCommand::PathOffsetDisable {
                acceleration: self.acceleration(),
            }),
            45 => CommandKind::Overlay(OverlayCommand::PathOffsetSet {
                offset: RpyPose::from_array(self.six(0.05)),
                axes: *self
                    .draw
                    .pick(&[OffsetAxes::Base, OffsetAxes::Tool, OffsetAxes::Motion]),
            }),
            46 => CommandKind::Overlay(OverlayCommand::PathOffsetFilter(self.number(0.01, 1.0))),
            47 => CommandKind::Overlay(OverlayCommand::PathOffsetMax {
                translation: self.number(0.05, 0.2),
                rotation: self.number(0.2, 0.5),
            }),
            48 => CommandKind::Sensing(SensingCommand::Push {
                wrench: self.six(40.0),
                in_tool_axes: self.draw.chance(0.5),
                duration: self.number(0.0, 0.5),
                replaces: self.draw.chance(0.3),
            }),
            49 => CommandKind::Machine(MachineCommand::ProtectiveStop),
            50 => CommandKind::Setting(SettingCommand::SetIoAtZone {
                motion: CommandId(self.draw.whole(0, 60) as u64),
                change: self.change(),
            }),
            _ => CommandKind::Setting(SettingCommand::SetDigitalInput {
                index: *self.draw.pick(&[0, 16, 18, 20, 28]),
                level: self.draw.chance(0.4),
            }),
        }
    }
}

fn config(draw: &mut Draw) -> CycleConfig {
    let pair = |pair| {
        Some(InputPair {
            pair,
            is_active_low: false,
        })
    };
    let ticks_per_second = draw.between(-120.0, 120.0);
    let model = ["cs63", "cs66", "cs612"][draw.whole(0, 2)];
    CycleConfig {
        step_time: *draw.pick(&[0.002, 0.004, 0.004, 0.008]),
        safety_inputs: SafetyInputs {
            safeguard_stop: pair(0),
            emergency_stop: pair(1),
            reduced_mode: pair(2),
            ..SafetyInputs::default()
        },
        reduced_limits: LimitOverrides {
            tcp_speed: draw.chance(0.5).then(|| draw.between(0.05, 0.4)),
            ..LimitOverrides::default()
        },
        belts: [
            Some(Belt {
                encoder: 0,
                ticks_per_second,
                start_at: 0.1,
            }),
            None,
        ],
        ..ideal(model)
    }
}

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

fn is_one_of_ours(reason: &StopReason) -> bool {
    matches!(reason, StopReason::Internal { .. })
}

/// Runs a case; what is wrong with it, and which kinds it sent.
fn run(case: u64, is_told: bool) -> (Vec<String>, [bool; KINDS]) {
    let mut draw = Draw::new(case.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x0077_696c);
    let mut bench = Bench::new(config(&mut draw));
    // In force mode an acceleration is the mean over its step: one cycle after it begins the difference shows more.
    bench.jerk_slack = 0.1;
    let mut seen = [false; KINDS];
    let mut ids = Vec::new();
    let mut wild = Wild {
        draw,
        at: bench.now().target_tcp_pose,
        q: bench.now().target_q,
    };
    // Half of the commands move the arm, or lay something over its motions.
    let lively = [
        0, 0, 0, 1, 1, 1, 2, 3, 3, 5, 5, 20, 21, 21, 22, 22, 26, 28, 37, 38, 43, 45,
    ];
    for _ in 0..COMMANDS {
        (wild.at, wild.q) = (bench.now().target_tcp_pose, bench.now().target_q);
        let which = if wild.draw.chance(0.5) {
            *wild.draw.pick(&lively)
        } else {
            wild.draw.whole(0, KINDS - 1)
        };
        let kind = wild.command(which);
        seen[place(&kind)] = true;
        let origin = Origin {
            program: ProgramId(1),
            thread: ThreadNumber(wild.draw.whole(0, 5) as u32 / 5),
            line: 0,
        };
        if is_told {
            println!("cycle {}: {kind:?}", bench.now().cycle);
        }
        let port = &bench.script.commands;
        let id = match kind {
            CommandKind::Motion(MotionCommand::MoveMl { count, interval })
                if wild.draw.chance(0.9) =>
            {
                let Some(points) = wild.points(count) else {
                    continue;
                };
                port.send_points(origin, &points.into(), interval, |_, _| ())
            }
            CommandKind::Online(OnlineCommand::FollowPoints { count, interval })
                if wild.draw.chance(0.9) =>
            {
                let Some(points) = wild.points(count) else {
                    continue;
                };
                port.send_trajectory(origin, &points.into(), interval, |_, _| ())
            }
            kind => port.send(origin, kind),
        };
        let id = id.unwrap();
        ids.push(id);
        let cycles = wild.draw.whole(0, 80);
        bench.run(cycles);
        if is_told {
            println!("  {:?}", bench.outcome(id));
        }
        // Out of whatever stop it is in, now and then.
        if wild.draw.chance(0.15) {
            recover(&mut bench, &mut ids);
        }
    }
    recover(&mut bench, &mut ids);
    let only = CommandId::NONE;
    ids.push(bench.send(MachineCommand::Stop { only }));
    bench.run(3000);
    let mut faults = bench.limit_faults();
    if is_told {
        println!("{:?}\nin the end: {:?}", bench.stops, bench.now());
        for s in &bench.states {
            let near = |fault: &String| {
                (s.cycle.saturating_sub(2)..s.cycle + 4)
                    .any(|cycle| fault.contains(&format!("in cycle {cycle} ")))
            };
            if faults.iter().take(6).any(near) {
                let (mode, force) = (s.motion_mode, s.force_mode);
                println!(
                    "at {}: {mode} {force} {:?} {:?} {:?}",
                    s.cycle, s.target_q, s.target_qd, s.target_qdd
                );
            }
        }
    }
    for id in ids {
        if bench.outcome(id).is_none() {
            faults.push(format!("{id:?} does not end"));
        }
    }
    let ours = bench.stops.iter().filter(|reason| is_one_of_ours(reason));
    faults.extend(ours.map(|reason| format!("{reason}")));
    if !bench.cycle.is_standing() {
        faults.push("moves in the end".into());
    }
    (faults, seen)
}

/// Lets go of every stop.
fn recover(bench: &mut Bench, ids: &mut Vec<CommandId>) {
    for index in [0, 16, 18, 20] {
        ids.push(bench.send(SettingCommand::SetDigitalInput {
            index,
            level: false,
        }));
    }
    for kind in [
        CommandKind::Machine(MachineCommand::EmergencyStop { pressed: false }),
        CommandKind::Machine(MachineCommand::Resume),
        CommandKind::Setting(SettingCommand::SetSpeedFraction(1.0)),
        CommandKind::Sensing(SensingCommand::SetExternalWrench([0.0; 6])),
        CommandKind::Overlay(OverlayCommand::PathOffsetFilter(1.0)),
    ] {
        ids.push(bench.send(kind));
    }
    bench.run(200);
    for kind in [
        CommandKind::Machine(MachineCommand::UnlockProtectiveStop),
        CommandKind::Machine(MachineCommand::PowerOn),
        CommandKind::Machine(MachineCommand::ReleaseBrakes),
    ] {
        ids.push(bench.send(kind));
        bench.run(150);
    }
}

#[test]
fn any_commands_at_any_moment_keep_the_limits() {
    let cases: Vec<u64> = match number("ELITE_CASE") {
        Some(case) => vec![case],
        None => {
            let first = number("ELITE_FIRST").unwrap_or(0);
            let drawn = first..first + number("ELITE_CASES").unwrap_or(CASES);
            drawn.chain(ONCE_WRONG).collect()
        }
    };
    let is_told = cases.len() == 1;
    let count = cases.len() as u64;
    let mut all = [false; KINDS];
    let mut wrong = Vec::new();
    for case in cases {
        let (faults, seen) = run(case, is_told);
        (0..KINDS).for_each(|k| all[k] |= seen[k]);
        if !faults.is_empty() {
            let few = &faults[..faults.len().min(3)];
            wrong.push(format!("{case}: {} of {}", few.join("; "), faults.len()));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
    // Each kind was tried.
    if count >= CASES {
        assert!(all.iter().all(|seen| *seen), "{all:?}");
    }
}
