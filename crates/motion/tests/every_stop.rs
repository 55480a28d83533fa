//! Every mode that moves the arm, every way to stop it, and what comes after: the arm stands in time, keeps the limits
//! of its joints all the way, stays where it is as long as it is held, and goes on where that is meant.
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

use common::{Bench, ideal, moved};
use core::f64::consts::TAU;
use kinematics::{JointPositions, JointSpeeds, Pose, RpyPose};
use motion::modes::encoder::Belt;
use motion::{CycleConfig, InputPair, LimitOverrides, SafetyInputs};
use motion_api::{
    CommandId, CommandKind, FreedriveFrame, InputAction, IoChange, MachineCommand, MotionCommand,
    MotionMode, OffsetAxes, OnlineCommand, Outcome, OverlayCommand, RobotMode, SafetyMode,
    SensingCommand, SettingCommand, StopReason,
};
use nalgebra::Vector3;

/// Ticks of the belts, 1/m and 1/rad.
const TICKS: f64 = 1000.0;
/// Speeds of the belts, m/s and rad/s.
const BELT: f64 = 0.15;
const TABLE: f64 = 0.25;
/// Force at the TCP that is a protective stop, N, and the push that exceeds it.
const FORCE: f64 = 200.0;

/// What moves the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    MoveJ,
    MoveJSlowly,
    MoveJAtFivePercent,
    MoveL,
    MoveC,
    MoveP,
    ChainOfLines,
    ChainOfJoints,
    MoveMl,
    ServoJ,
    SpeedJ,
    SpeedL,
    StopJ,
    Belt,
    BeltAndLine,
    BeltAndSpeedL,
    Table,
    TableAndTurn,
    TableAndLine,
    Force,
    ForceAndLine,
    Hand,
    HandWithLockedAxes,
    HandByInput,
    OffsetAndLine,
}

const MODES: [Mode; 25] = [
    Mode::MoveJ,
    Mode::MoveJSlowly,
    Mode::MoveJAtFivePercent,
    Mode::MoveL,
    Mode::MoveC,
    Mode::MoveP,
    Mode::ChainOfLines,
    Mode::ChainOfJoints,
    Mode::MoveMl,
    Mode::ServoJ,
    Mode::SpeedJ,
    Mode::SpeedL,
    Mode::StopJ,
    Mode::Belt,
    Mode::BeltAndLine,
    Mode::BeltAndSpeedL,
    Mode::Table,
    Mode::TableAndTurn,
    Mode::TableAndLine,
    Mode::Force,
    Mode::ForceAndLine,
    Mode::Hand,
    Mode::HandWithLockedAxes,
    Mode::HandByInput,
    Mode::OffsetAndLine,
];

/// What stops it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stop {
    Safeguard,
    Emergency,
    EmergencyInput,
    Protective,
    Pause,
    Command,
    PowerOff,
}

const STOPS: [Stop; 7] = [
    Stop::Safeguard,
    Stop::Emergency,
    Stop::EmergencyInput,
    Stop::Protective,
    Stop::Pause,
    Stop::Command,
    Stop::PowerOff,
];

impl Mode {
    fn belt(self) -> Option<f64> {
        match self {
            Self::Belt | Self::BeltAndLine | Self::BeltAndSpeedL => Some(BELT),
            Self::Table | Self::TableAndTurn | Self::TableAndLine => Some(TABLE),
            _ => None,
        }
    }

    /// What reduced mode leaves of the TCP's speed, m/s: less than the mode would have, more than a belt has.
    fn reduced_speed(self) -> f64 {
        match self {
            Self::Belt | Self::BeltAndLine | Self::BeltAndSpeedL => 1.3 * BELT,
            Self::Table | Self::TableAndTurn | Self::TableAndLine => 0.13,
            Self::Force => 0.006,
            _ => 0.06,
        }
    }

    /// The same of the joints' speeds, rad/s.
    fn reduced_joint_speed(self) -> f64 {
        if self.belt().is_some() { 1.2 } else { 0.4 }
    }

    fn is_hand(self) -> bool {
        matches!(
            self,
            Self::Hand | Self::HandWithLockedAxes | Self::HandByInput
        )
    }

    /// The planned motion of the mode ends by itself.
    fn has_target(self) -> bool {
        matches!(
            self,
            Self::MoveJ
                | Self::MoveJSlowly
                | Self::MoveJAtFivePercent
                | Self::MoveL
                | Self::MoveC
                | Self::MoveP
                | Self::ChainOfLines
                | Self::ChainOfJoints
                | Self::MoveMl
                | Self::BeltAndLine
                | Self::TableAndLine
                | Self::ForceAndLine
                | Self::OffsetAndLine
        )
    }
}

fn config(mode: Mode, step_time: f64) -> CycleConfig {
    let pair = |pair| {
        Some(InputPair {
            pair,
            is_active_low: false,
        })
    };
    let limits = LimitOverrides {
        tcp_force: Some(FORCE),
        ..LimitOverrides::default()
    };
    CycleConfig {
        step_time,
        limits,
        reduced_limits: LimitOverrides {
            tcp_speed: Some(mode.reduced_speed()),
            joint_speed: Some(JointSpeeds([mode.reduced_joint_speed(); 6])),
            ..LimitOverrides::default()
        },
        safety_inputs: SafetyInputs {
            safeguard_stop: pair(0),
            emergency_stop: pair(1),
            reduced_mode: pair(2),
            ..SafetyInputs::default()
        },
        belts: [
            mode.belt().map(|speed| Belt {
                encoder: 0,
                ticks_per_second: speed * TICKS,
                start_at: 0.0,
            }),
            None,
        ],
        ..ideal("cs66")
    }
}

fn input(index: u8, level: bool) -> CommandKind {
    CommandKind::Setting(SettingCommand::SetDigitalInput { index, level })
}

fn movel(target: RpyPose, speed: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: 0.8,
        speed,
        duration: 0.0,
        radius,
    })
}

fn movej(target: JointPositions, acceleration: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveJ {
        target,
        acceleration,
        speed: 1.0,
        duration: 0.0,
        radius,
    })
}

/// A bench whose arm is moved by a mode.
struct Case {
    bench: Bench,
    mode: Mode,
    /// The command whose end is the end of the mode.
    last: Option<CommandId>,
    /// Where it leads, with the belt's way taken back.
    target: Option<Pose>,
    /// Motions that follow once their sender is told.
    chain: Vec<CommandKind>,
    start: JointPositions,
    /// What the encoder had counted when tracking began.
    ticks: f64,
    /// The sender of a stream goes on.
    streams: bool,
}

impl Case {
    fn new(mode: Mode, step_time: f64) -> Self {
        let mut bench = Bench::new(config(mode, step_time));
        bench.tick();
        let start = bench.now().target_q;
        Self {
            bench,
            mode,
            last: None,
            target: None,
            chain: Vec::new(),
            start,
            ticks: 0.0,
            streams: mode == Mode::ServoJ,
        }
    }

    fn seconds(&mut self, seconds: f64) {
        let cycles = (seconds / self.bench.cycle.step_time()).round() as usize;
        (0..cycles).for_each(|_| self.tick());
    }

    fn tick(&mut self) {
        self.bench.tick();
        // A stream goes on when its last point is done, and ends with what stops it.
        if self.streams
            && let Some(last) = self.last
            && self.bench.outcome(last) == Some(Outcome::Done)
        {
            self.servo();
        }
        if let Some(last) = self.last
            && self.bench.queued.contains(&last)
            && !self.chain.is_empty()
        {
            let next = self.chain.remove(0);
            self.last = Some(self.bench.send(next));
        }
    }

    /// The next point of a stream: a slow swing of two joints.
    fn servo(&mut self) {
        let time = self.bench.now().time + self.bench.cycle.step_time();
        let mut q = self.start;
        q[0] += 0.6 * (1.0 - (0.8 * time).cos());
        q[4] += 0.3 * (1.0 - (1.3 * time).cos());
        self.send(OnlineCommand::ServoJ {
            target: q,
            duration: self.bench.cycle.step_time(),
            lookahead: 0.1,
            gain: 300.0,
        });
    }

    fn pose(&self) -> RpyPose {
        self.bench.now().target_tcp_pose
    }

    fn send(&mut self, kind: impl Into<CommandKind>) {
        self.last = Some(self.bench.send(kind));
    }

    fn line(&mut self, by: [f64; 3]) {
        let target = moved(&self.pose_on_belt(), by);
        self.target = Some(Pose::from_rpy(&target));
        self.send(movel(target, 0.15, 0.0));
    }

    /// The TCP with the belt's way taken back.
    fn pose_on_belt(&self) -> RpyPose {
        let state = self.bench.now();
        state.path_pose
    }

    fn begin(&mut self) {
        let q = self.start;
        let far = JointPositions([1.4, -1.2, 1.9, -1.6, -1.2, 0.8]);
        match self.mode {
            Mode::MoveJ => self.joints(movej(far, 1.4, 0.0), far),
            Mode::MoveJSlowly => self.joints(movej(far, 0.4, 0.0), far),
            Mode::MoveJAtFivePercent => {
                self.bench.do_it(SettingCommand::SetSpeedFraction(0.05));
                self.joints(movej(far, 1.4, 0.0), far);
            }
            Mode::MoveL => self.line([0.05, 0.2, -0.05]),
            Mode::MoveC => {
                let (via, target) = (
                    moved(&self.pose(), [0.08, 0.12, 0.0]),
                    moved(&self.pose(), [0.0, 0.25, 0.0]),
                );
                self.target = Some(Pose::from_rpy(&target));
                self.send(MotionCommand::MoveC {
                    via,
                    target,
                    acceleration: 0.8,
                    speed: 0.15,
                    radius: 0.0,
                    fixed: false,
                });
            }
            Mode::MoveP => {
                let target = moved(&self.pose(), [0.1, 0.25, -0.05]);
                self.target = Some(Pose::from_rpy(&target));
                self.send(MotionCommand::MoveP {
                    target,
                    acceleration: 0.8,
                    speed: 0.15,
                    radius: 0.0,
                });
            }
            Mode::ChainOfLines => {
                let at = self.pose();
                let corners = [[0.05, 0.05, 0.0], [0.1, 0.1, 0.02], [0.05, 0.2, 0.0]];
                let mut chain: Vec<_> = corners
                    .iter()
                    .map(|by| movel(moved(&at, *by), 0.15, 0.03))
                    .collect();
                let end = moved(&at, [0.0, 0.25, -0.05]);
                chain.push(movel(end, 0.15, 0.0));
                self.target = Some(Pose::from_rpy(&end));
                self.send(chain.remove(0));
                self.chain = chain;
            }
            Mode::ChainOfJoints => {
                let mut corner = q;
                corner[0] += 0.5;
                corner[5] += 0.4;
                self.chain = vec![movej(far, 1.4, 0.0)];
                self.target = Some(self.tcp(&far));
                self.send(movej(corner, 1.4, 0.1));
            }
            Mode::MoveMl => self.points(),
            Mode::ServoJ => self.servo(),
            Mode::SpeedJ => self.send(OnlineCommand::SpeedJ {
                speeds: JointSpeeds([0.7, 0.1, -0.2, 0.1, 0.3, 0.9]),
                acceleration: 1.0,
                duration: None,
            }),
            Mode::SpeedL => self.speedl([0.05, 0.15, -0.05]),
            Mode::StopJ => {
                let speedj = CommandKind::Online(OnlineCommand::SpeedJ {
                    speeds: JointSpeeds([1.0, 0.1, -0.2, 0.1, 0.3, 0.9]),
                    acceleration: 5.0,
                    duration: None,
                });
                self.bench.do_it(speedj);
                self.send(OnlineCommand::StopJ { acceleration: 0.3 });
            }
            Mode::Belt | Mode::BeltAndLine | Mode::BeltAndSpeedL => {
                let track = CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
                    direction: [0.0, 1.0, 0.0],
                    ticks_per_meter: TICKS,
                    encoder: 0,
                });
                self.ticks = self.bench.now().encoder_counts[0];
                assert_eq!(self.bench.do_it(track), Outcome::Done);
                self.seconds(0.3);
                match self.mode {
                    Mode::BeltAndLine => self.line([0.05, -0.08, -0.1]),
                    Mode::BeltAndSpeedL => self.speedl([0.02, -0.05, 0.03]),
                    _ => self.target = Some(Pose::from_rpy(&self.pose_on_belt())),
                }
            }
            Mode::Table | Mode::TableAndTurn | Mode::TableAndLine => {
                let track = CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
                    center: RpyPose::from_array([-0.6, 0.25, 0.0, 0.0, 0.0, 0.4]),
                    ticks_per_revolution: TICKS * TAU,
                    rotate_tool: self.mode == Mode::TableAndTurn,
                    encoder: 0,
                });
                self.ticks = self.bench.now().encoder_counts[0];
                assert_eq!(self.bench.do_it(track), Outcome::Done);
                self.seconds(0.3);
                if self.mode == Mode::TableAndLine {
                    self.line([0.05, 0.02, -0.1]);
                }
            }
            Mode::Force | Mode::ForceAndLine => {
                let kind = CommandKind::Overlay(OverlayCommand::ForceMode {
                    frame: RpyPose::default(),
                    selection: [false, false, true, false, false, false],
                    wrench: [0.0, 0.0, 12.0, 0.0, 0.0, 0.0],
                    mode: 0,
                    speed_limits: [0.1; 6],
                });
                assert_eq!(self.bench.do_it(kind), Outcome::Done);
                if self.mode == Mode::ForceAndLine {
                    self.line([0.1, 0.2, 0.0]);
                }
            }
            Mode::Hand | Mode::HandWithLockedAxes => {
                self.push([0.0, 30.0, 0.0]);
                let free_axes = match self.mode {
                    Mode::Hand => [true; 6],
                    _ => [false, true, false, false, false, false],
                };
                let kind = CommandKind::Online(OnlineCommand::Freedrive {
                    free_axes,
                    frame: FreedriveFrame::Base,
                });
                assert_eq!(self.bench.do_it(kind), Outcome::Done);
            }
            Mode::HandByInput => {
                self.push([0.0, 30.0, 0.0]);
                let action = InputAction::Freedrive;
                let kind = CommandKind::Setting(SettingCommand::SetIo(IoChange::DigitalInAction {
                    bit: 0,
                    action,
                }));
                assert_eq!(self.bench.do_it(kind), Outcome::Done);
                self.bench.do_it(input(0, true));
            }
            Mode::OffsetAndLine => {
                self.bench.do_it(OverlayCommand::PathOffsetEnable);
                self.line([0.1, 0.25, 0.0]);
                let offset = CommandKind::Overlay(OverlayCommand::PathOffsetSet {
                    offset: RpyPose::from_array([0.0, 0.0, 0.05, 0.0, 0.0, 0.1]),
                    axes: OffsetAxes::Base,
                });
                self.bench.do_it(offset);
            }
        }
    }

    fn joints(&mut self, kind: CommandKind, target: JointPositions) {
        self.target = Some(self.tcp(&target));
        self.send(kind);
    }

    fn tcp(&self, q: &JointPositions) -> Pose {
        let model = kinematics::RobotModel::built_in("cs66").unwrap();
        model.tcp_pose(q, &Pose::IDENTITY)
    }

    fn push(&mut self, force: [f64; 3]) {
        self.bench
            .push([force[0], force[1], force[2], 0.0, 0.0, 0.0]);
    }

    fn speedl(&mut self, v: [f64; 3]) {
        self.send(OnlineCommand::SpeedL {
            speed: [v[0], v[1], v[2], 0.0, 0.0, 0.0],
            acceleration: 0.5,
            rotation_acceleration: 1.0,
            duration: None,
        });
    }

    /// A swing through 400 points.
    fn points(&mut self) {
        let at = |k: usize| {
            let share = k as f64 / 400.0;
            let mut q = self.start;
            q[0] += 0.6 * (1.0 - (share * TAU / 2.0).cos());
            q[3] += 0.3 * (1.0 - (share * TAU / 2.0).cos());
            q
        };
        let end = at(399);
        let points: Vec<JointPositions> = (0..400).map(at).collect();
        self.target = Some(self.tcp(&end));
        let id = self.bench.moveml(&points, 0.005);
        self.last = Some(id);
    }

    fn stop(&mut self, stop: Stop) {
        match stop {
            Stop::Safeguard => drop(self.bench.send(input(16, true))),
            Stop::EmergencyInput => drop(self.bench.send(input(18, true))),
            Stop::Emergency => {
                self.bench
                    .send(MachineCommand::EmergencyStop { pressed: true });
            }
            Stop::Protective => {
                self.bench.send(SensingCommand::FtRtsiInput {
                    enabled: true,
                    mass: 0.0,
                    measuring_offset: [0.0; 3],
                    cog: [0.0; 3],
                });
                let push = [0.0, 0.0, 2.0 * FORCE, 0.0, 0.0, 0.0];
                self.bench.send(SensingCommand::SetExternalWrench(push));
            }
            Stop::Pause => drop(self.bench.send(MachineCommand::Pause)),
            Stop::Command => {
                let only = CommandId::NONE;
                // Otherwise the hand leads on.
                self.bench.send(input(0, false));
                self.bench.send(MachineCommand::Stop { only });
            }
            Stop::PowerOff => drop(self.bench.send(MachineCommand::PowerOff)),
        }
    }

    /// The time in which the joints can stand at the best, s.
    fn shortest(&self) -> f64 {
        let (state, l) = (self.bench.now(), &self.bench.limits);
        (0..6).fold(0.0, |most: f64, j| {
            let rise = l.acceleration[j] / l.jerk[j];
            let (v, a) = (state.target_qd[j].abs(), state.target_qdd[j].abs());
            let ramp = (4.0 * v / l.jerk[j])
                .sqrt()
                .max(v / l.acceleration[j] + rise);
            most.max(ramp + 2.0 * a / l.jerk[j])
        })
    }

    /// The time in which a pause has to bring the arm to rest, s: with a tenth of what the joints can do, and what
    /// smoothing, the look-ahead of a stream and the way back from speeding up take.
    fn longest_pause(&self) -> f64 {
        let state = self.bench.now();
        let limits = &self.bench.limits;
        let slowest = (0..6).fold(0.0, |most: f64, j| {
            most.max(state.target_qd[j].abs() / (0.1 * limits.acceleration[j]))
        });
        1.15 * slowest + 0.2
    }

    fn stands(&self) -> bool {
        let state = self.bench.now();
        state.target_qd == JointSpeeds::ZERO && state.target_qdd.0 == [0.0; 6]
    }

    /// What is wrong, if anything.
    fn check(&mut self, stop: Stop, after: f64) -> Result<(), String> {
        self.begin();
        self.seconds(after);
        if !self.bench.stops.is_empty() {
            return Err(format!("stopped before: {:?}", self.bench.stops));
        }
        if self.stands() {
            return Err("does not move".into());
        }
        let shortest = self.shortest();
        self.stop(stop);
        self.streams &= !matches!(stop, Stop::Command | Stop::PowerOff);
        let most = match stop {
            Stop::Pause => self.longest_pause(),
            _ => 1.35 * shortest + 0.03,
        };
        let h = self.bench.cycle.step_time();
        let mut cycles = 0;
        while !self.stands() {
            self.tick();
            cycles += 1;
            let taken = f64::from(cycles - 3) * h;
            if taken > most {
                return Err(format!(
                    "moves after {taken:.3} s, allowed {most:.3} s: {:?}",
                    self.bench.now().target_qd
                ));
            }
        }
        let held = self.bench.now().target_q;
        for _ in 0..(0.4 / h) as usize {
            self.tick();
            if self.bench.now().target_q != held {
                return Err("moves on while it is held".into());
            }
        }
        let result = self.go_on(stop);
        let faults = self.bench.limit_faults();
        if !faults.is_empty() {
            let few = &faults[..faults.len().min(3)];
            return Err(format!("{} limits: {}", faults.len(), few.join("; ")));
        }
        result
    }

    /// Reduced mode is asked for, and ends again: what is wrong, if anything.
    fn check_reduced(&mut self, after: f64, hardness: u8) -> Result<(), String> {
        self.bench
            .do_it(SettingCommand::SetIo(IoChange::SafetyHardness(hardness)));
        self.begin();
        self.seconds(after);
        self.bench.send(input(20, true));
        let mut excess = self.bench.limits;
        excess.speed = JointSpeeds([self.mode.reduced_joint_speed(); 6]);
        excess.tcp_speed = self.mode.reduced_speed();
        let h = self.bench.cycle.step_time();
        let is_slow = |bench: &Bench| {
            let state = bench.now();
            common::tcp_speed(&state) <= excess.tcp_speed + 1e-6
                && state.target_qd.max_abs() <= excess.speed[0] + 1e-6
        };
        let mut fast = 0.0;
        for cycle in 0..(1.2 / h) as usize {
            self.tick();
            if !is_slow(&self.bench) {
                fast = (cycle + 1) as f64 * h;
            }
        }
        let most = if hardness == 0 { 0.35 } else { 1.1 };
        if fast > most {
            let state = self.bench.now();
            return Err(format!("too fast after {fast:.3} s: {state:?}"));
        }
        let seen = self.bench.now().safety_mode;
        self.bench.send(input(20, false));
        let result = self.ends_well();
        let faults = self.bench.limit_faults();
        if !faults.is_empty() {
            let few = &faults[..faults.len().min(3)];
            return Err(format!("{} limits: {}", faults.len(), few.join("; ")));
        }
        if seen != SafetyMode::Reduced {
            return Err(format!("{seen}: {:?}", self.bench.stops));
        }
        result
    }

    /// What comes after a stop.
    fn go_on(&mut self, stop: Stop) -> Result<(), String> {
        let state = self.bench.now();
        let expect = |is_so: bool, what: &str| {
            let text = || format!("{what}: {:?} {:?}", self.bench.stops, state.motion_mode);
            is_so.then_some(()).ok_or_else(text)
        };
        match stop {
            Stop::Safeguard => {
                expect(
                    state.safety_mode == SafetyMode::SafeguardStop,
                    "no safeguard stop",
                )?;
                self.bench.send(input(16, false));
                self.ends_well()
            }
            Stop::Pause => {
                self.bench.send(MachineCommand::Resume);
                self.ends_well()
            }
            Stop::Command => {
                expect(self.bench.stops.is_empty(), "a protective stop")?;
                let back = movej(self.start, 1.4, 0.0);
                let outcome = self.bench.do_it(back);
                (outcome == Outcome::Done)
                    .then_some(())
                    .ok_or_else(|| format!("no motion afterwards: {outcome:?}"))
            }
            Stop::PowerOff => {
                expect(state.robot_mode == RobotMode::PowerOff, "there is power")?;
                self.powered_again()
            }
            Stop::Emergency | Stop::EmergencyInput => {
                let is_one = matches!(self.bench.stops[..], [StopReason::EmergencyStop]);
                expect(is_one, "not the stop that was asked for")?;
                expect(state.robot_mode == RobotMode::PowerOff, "there is power")?;
                self.bench.do_it(input(18, false));
                self.bench
                    .do_it(MachineCommand::EmergencyStop { pressed: false });
                self.powered_again()
            }
            Stop::Protective => {
                let is_one = matches!(self.bench.stops[..], [StopReason::TcpForce { .. }]);
                expect(is_one, "not the stop that was asked for")?;
                self.bench
                    .do_it(SensingCommand::SetExternalWrench([0.0; 6]));
                let unlocked = self.bench.do_it(MachineCommand::UnlockProtectiveStop);
                if unlocked != Outcome::Done {
                    return Err(format!("{unlocked:?}"));
                }
                self.moves_again()
            }
        }
    }

    fn powered_again(&mut self) -> Result<(), String> {
        self.bench.do_it(MachineCommand::PowerOn);
        self.bench.do_it(MachineCommand::ReleaseBrakes);
        self.seconds(1.5);
        self.moves_again()
    }

    fn moves_again(&mut self) -> Result<(), String> {
        if self.mode == Mode::HandByInput {
            self.bench.do_it(input(0, false));
            self.seconds(1.0);
        }
        let outcome = self.bench.do_it(movej(self.start, 1.4, 0.0));
        (outcome == Outcome::Done)
            .then_some(())
            .ok_or_else(|| format!("no motion afterwards: {outcome:?}"))
    }

    /// After a stop that lets the mode go on: it does, and comes to where it should.
    fn ends_well(&mut self) -> Result<(), String> {
        let fine = |is_so: bool, what: String| is_so.then_some(()).ok_or(what);
        if self.mode == Mode::MoveJAtFivePercent {
            self.bench.send(SettingCommand::SetSpeedFraction(1.0));
        }
        if self.mode.has_target() {
            for _ in 0..5000 {
                let is_over = |id| self.bench.outcome(id).is_some();
                if self.chain.is_empty() && self.last.is_none_or(is_over) {
                    break;
                }
                self.tick();
            }
            let outcome = self.last.and_then(|id| self.bench.outcome(id));
            fine(
                outcome == Some(Outcome::Done),
                format!("ended as {outcome:?} {:?}", self.bench.stops),
            )?;
        } else {
            // A stopj(0.3) takes its time.
            self.seconds(if self.mode == Mode::StopJ { 3.0 } else { 1.0 });
        }
        let state = self.bench.now();
        let stops = &self.bench.stops;
        fine(stops.is_empty(), format!("a protective stop: {stops:?}"))?;
        let at = Pose::from_rpy(&state.target_tcp_pose);
        match self.mode {
            Mode::SpeedL => {
                let v = state.target_tcp_speed;
                let off = (v[0] - 0.05).abs() + (v[1] - 0.15).abs() + (v[2] + 0.05).abs();
                fine(off < 1e-6, format!("goes on at {v:?}"))
            }
            Mode::SpeedJ => {
                let v = state.target_qd[5];
                fine((v - 0.9).abs() < 1e-9, format!("goes on at {v}"))
            }
            Mode::StopJ => fine(self.stands(), "moves on".into()),
            Mode::ServoJ => fine(!self.stands(), "stands".into()),
            Mode::Hand | Mode::HandWithLockedAxes | Mode::HandByInput => {
                let v = state.target_tcp_speed[1];
                let mode = state.motion_mode;
                let is_led = v > 0.05 && mode == MotionMode::Freedrive;
                fine(is_led, format!("the hand leads at {v} in {mode}"))
            }
            Mode::Force => {
                let v = state.target_tcp_speed[2];
                fine(v > 0.005, format!("goes on at {v}"))
            }
            Mode::ForceAndLine => {
                let target = self.target.unwrap().translation;
                let off = (at.translation - target).xy().norm();
                fine(off < 1e-3, format!("{off} m beside the target"))
            }
            Mode::OffsetAndLine => {
                let target = self.target.unwrap().translation + Vector3::new(0.0, 0.0, 0.05);
                let off = (at.translation - target).norm();
                fine(off < 1e-6, format!("{off} m beside the target"))
            }
            _ if self.mode.belt().is_some() => self.is_on_the_belt(),
            _ => {
                let off = (at.translation - self.target.unwrap().translation).norm();
                fine(off < 1e-9, format!("{off} m beside the target"))
            }
        }
    }

    /// The arm has caught up with the belt: its TCP stands still in the frame that moves along.
    fn is_on_the_belt(&mut self) -> Result<(), String> {
        self.seconds(1.0);
        if !self.bench.stops.is_empty() {
            return Err(format!("a protective stop: {:?}", self.bench.stops));
        }
        let (state, way) = (
            self.bench.now(),
            Pose::from_rpy(&self.bench.now().path_pose),
        );
        let time = state.time;
        let at = Pose::from_rpy(&state.target_tcp_pose).translation;
        let passed = self.mode.belt().unwrap() * time - self.ticks / TICKS;
        let wanted = match self.mode {
            Mode::Belt | Mode::BeltAndLine | Mode::BeltAndSpeedL => {
                way.translation + Vector3::new(0.0, passed, 0.0)
            }
            _ => {
                let center = Vector3::new(-0.6, 0.25, 0.0);
                let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), passed);
                center + turn * (way.translation - center)
            }
        };
        let off = (at - wanted).norm();
        (off < 2e-4)
            .then_some(())
            .ok_or_else(|| format!("{off} m beside its place on the belt"))
    }
}

fn all(step_time: f64, after: &[f64], modes: &[Mode]) {
    let mut wrong = Vec::new();
    let mut count = 0;
    for mode in modes {
        for stop in STOPS {
            // What presses on the tool leads the hand, and is no reason to stop then.
            if stop == Stop::Protective && mode.is_hand() {
                continue;
            }
            for after in after {
                count += 1;
                let mut case = Case::new(*mode, step_time);
                if let Err(text) = case.check(stop, *after) {
                    wrong.push(format!("{mode:?}, {stop:?} after {after} s: {text}"));
                }
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of {count}:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn every_stop_stops_every_planned_motion() {
    all(0.004, &[0.05, 0.5], &MODES[..9]);
}

#[test]
fn every_stop_stops_every_online_mode() {
    all(0.004, &[0.05, 0.5], &MODES[9..13]);
}

#[test]
fn every_stop_stops_an_arm_on_a_belt() {
    all(0.004, &[0.05, 0.5], &MODES[13..19]);
}

#[test]
fn every_stop_stops_force_hands_and_offsets() {
    all(0.004, &[0.05, 0.5], &MODES[19..]);
}

#[test]
fn every_stop_stops_every_mode_at_other_steps() {
    all(0.001, &[0.31], &MODES);
    all(0.008, &[0.23], &MODES);
}

#[test]
fn reduced_mode_slows_every_mode_down_and_lets_it_go_on() {
    let mut wrong = Vec::new();
    for mode in MODES {
        for hardness in [0, 1] {
            for (step_time, after) in [(0.004, 0.05), (0.004, 0.5), (0.002, 0.3)] {
                let mut case = Case::new(mode, step_time);
                if let Err(text) = case.check_reduced(after, hardness) {
                    wrong.push(format!("{mode:?}, {hardness} after {after} s: {text}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}
