//! Motions on belts when something slows them down and lets them go again: reduced mode, a belt that begins or gets
//! faster, a limit of the TCP that lasts. They keep every limit, are never stopped for it, end in time and where they
//! should.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal, moved};
use core::f64::consts::TAU;
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel, RpyPose};
use motion::{CycleConfig, InputPair, LimitOverrides, SafetyInputs};
use motion_api::{
    CommandId, CommandKind, EncoderRange, MachineCommand, MotionCommand, OnlineCommand, Outcome,
    OverlayCommand, SettingCommand,
};
use nalgebra::Vector3;

/// Ticks of the belts, 1/m and 1/rad.
const TICKS: f64 = 20_000.0;
/// When the cause of slowing comes and goes, s after the motion began.
const CAUSE: (f64, f64) = (0.25, 0.75);

/// What moves on the belt.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    MoveJ,
    Chain,
    MoveL,
    MoveP,
    ServoJ,
    SpeedJ,
    SpeedL,
}

const MODES: [Mode; 7] = [
    Mode::MoveJ,
    Mode::Chain,
    Mode::MoveL,
    Mode::MoveP,
    Mode::ServoJ,
    Mode::SpeedJ,
    Mode::SpeedL,
];

/// Why it has to be slower for a while.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cause {
    Nothing,
    Reduced,
    /// The belt is tracked from then on.
    Entry,
    /// The belt runs faster meanwhile.
    FasterBelt,
    Pause,
    Safeguard,
}

const CAUSES: [Cause; 6] = [
    Cause::Nothing,
    Cause::Reduced,
    Cause::Entry,
    Cause::FasterBelt,
    Cause::Pause,
    Cause::Safeguard,
];

struct Case {
    bench: Bench,
    mode: Mode,
    cause: Cause,
    is_table: bool,
    belt: f64,
    ticks: f64,
    hard: bool,
    start: JointPositions,
    last: Option<CommandId>,
    chain: Vec<CommandKind>,
    /// Where a planned motion leads on the belt.
    target: Option<RpyPose>,
    tracked_at: f64,
    stream: f64,
}

impl Case {
    fn new(mode: Mode, cause: Cause, seed: u64) -> Self {
        let mut draw = Draw::new(seed);
        let pair = |pair| {
            Some(InputPair {
                pair,
                is_active_low: false,
            })
        };
        let tcp_speed = draw.chance(0.4).then(|| draw.spread(0.25, 0.8));
        let belt = *draw.pick(&[0.0, 0.02, 0.05, 0.1]);
        // The smallest arm would be led out of its reach.
        let model = *draw.pick(&MODELS[1..]);
        let config = CycleConfig {
            step_time: *draw.pick(&[0.002, 0.004, 0.008]),
            limits: LimitOverrides {
                tcp_speed,
                ..LimitOverrides::default()
            },
            reduced_limits: LimitOverrides {
                tcp_speed: Some(0.25),
                ..LimitOverrides::default()
            },
            safety_inputs: SafetyInputs {
                reduced_mode: pair(0),
                safeguard_stop: pair(1),
                ..SafetyInputs::default()
            },
            ..ideal(model)
        };
        let mut bench = Bench::new(config);
        bench.do_it(SettingCommand::EncoderEnableSetTickCount {
            encoder: 0,
            range: EncoderRange::Signed32,
        });
        bench.model = model;
        let start = bench.now().target_q;
        Self {
            bench,
            mode,
            cause,
            is_table: draw.chance(0.3),
            belt,
            ticks: 0.0,
            hard: draw.chance(0.5),
            start,
            last: None,
            chain: Vec::new(),
            target: None,
            tracked_at: 0.0,
            stream: 0.0,
        }
    }

    fn track(&mut self) {
        self.tracked_at = self.ticks;
        let kind = if self.is_table {
            CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
                center: RpyPose::from_array([-0.6, 0.25, 0.0, 0.0, 0.0, 0.4]),
                ticks_per_revolution: TICKS * TAU,
                rotate_tool: true,
                encoder: 0,
            })
        } else {
            CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
                direction: [0.0, 1.0, 0.0],
                ticks_per_meter: TICKS,
                encoder: 0,
            })
        };
        assert_eq!(self.bench.do_it(kind), Outcome::Done);
    }

    fn begin(&mut self) {
        let at = self.bench.now().path_pose;
        let (a, v) = if self.hard { (8.0, 1.2) } else { (1.2, 0.3) };
        let line = |by: [f64; 3], radius: f64| {
            CommandKind::Motion(MotionCommand::MoveL {
                target: moved(&at, by),
                acceleration: a,
                speed: v,
                duration: 0.0,
                radius,
            })
        };
        let mut far = self.start;
        far[0] += 0.7;
        far[1] += 0.2;
        far[3] -= 0.3;
        let joints = |target: JointPositions, radius: f64| {
            CommandKind::Motion(MotionCommand::MoveJ {
                target,
                acceleration: a,
                speed: if self.hard { 3.0 } else { 1.0 },
                duration: 0.0,
                radius,
            })
        };
        let kind = match self.mode {
            Mode::MoveJ => {
                let model = RobotModel::built_in(self.bench.model).unwrap();
                self.target = Some(model.tcp_pose(&far, &Pose::IDENTITY).to_rpy());
                joints(far, 0.0)
            }
            Mode::Chain => {
                let end = [0.05, 0.25, -0.05];
                self.target = Some(moved(&at, end));
                self.chain = vec![
                    line([0.1, 0.1, 0.0], 0.03),
                    line([0.0, 0.2, 0.0], 0.03),
                    line(end, 0.0),
                ];
                line([0.05, 0.0, -0.05], 0.02)
            }
            Mode::MoveL => {
                let by = [0.05, 0.3, -0.05];
                self.target = Some(moved(&at, by));
                line(by, 0.0)
            }
            Mode::MoveP => {
                let by = [0.1, 0.25, 0.05];
                self.target = Some(moved(&at, by));
                CommandKind::Motion(MotionCommand::MoveP {
                    target: moved(&at, by),
                    acceleration: a,
                    speed: v,
                    radius: 0.0,
                })
            }
            Mode::ServoJ => return,
            Mode::SpeedJ => CommandKind::Online(OnlineCommand::SpeedJ {
                speeds: JointSpeeds([0.5, 0.1, -0.1, 0.1, 0.3, 0.4]),
                acceleration: if self.hard { 40.0 } else { 1.4 },
                duration: Some(2.0),
            }),
            Mode::SpeedL => CommandKind::Online(OnlineCommand::SpeedL {
                speed: [0.02, 0.15, -0.03, 0.0, 0.0, 0.0],
                acceleration: if self.hard { 8.0 } else { 0.5 },
                rotation_acceleration: 2.0,
                duration: Some(2.0),
            }),
        };
        self.last = Some(self.bench.send(kind));
    }

    fn tick(&mut self) {
        let h = self.bench.cycle.step_time();
        self.ticks += self.belt * TICKS * h;
        let count = self.ticks;
        self.bench
            .send(SettingCommand::EncoderSetTickCount { encoder: 0, count });
        if let Some(last) = self.last
            && self.bench.queued.contains(&last)
            && !self.chain.is_empty()
        {
            let next = self.chain.remove(0);
            self.last = Some(self.bench.send(next));
        }
        let is_free = self
            .last
            .is_none_or(|last| self.bench.outcome(last) == Some(Outcome::Done));
        if self.mode == Mode::ServoJ && is_free && self.stream < 2.5 {
            let size = if self.hard { 0.9 } else { 0.3 };
            let mut q = self.start;
            q[0] += size * (1.0 - (2.5 * self.stream).cos());
            q[4] += 0.3 * (1.0 - (1.3 * self.stream).cos());
            self.stream += h;
            self.last = Some(self.bench.send(OnlineCommand::ServoJ {
                target: q,
                duration: h,
                lookahead: 0.1,
                gain: 300.0,
            }));
        }
        self.bench.tick();
    }

    fn seconds(&mut self, seconds: f64) {
        let cycles = (seconds / self.bench.cycle.step_time()).round() as usize;
        (0..cycles).for_each(|_| self.tick());
    }

    fn input(&mut self, index: u8, level: bool) {
        self.bench
            .send(SettingCommand::SetDigitalInput { index, level });
    }

    fn is_over(&self) -> bool {
        let is_done = self.last.is_some_and(|last| {
            self.bench.outcome(last).is_some() && !self.bench.queued.contains(&last)
        });
        is_done && self.chain.is_empty() && (self.mode != Mode::ServoJ || self.stream >= 2.5)
    }

    /// How long the motion took, s, or what is wrong.
    fn run(&mut self) -> Result<f64, String> {
        if self.cause == Cause::Entry {
            self.seconds(0.8);
        } else {
            self.track();
            self.seconds(0.8);
        }
        let began = self.bench.now().time;
        self.begin();
        self.seconds(CAUSE.0);
        match self.cause {
            Cause::Nothing => {}
            Cause::Reduced => self.input(16, true),
            Cause::Entry => self.track(),
            Cause::FasterBelt => self.belt += 0.08,
            Cause::Pause => drop(self.bench.send(MachineCommand::Pause)),
            Cause::Safeguard => self.input(18, true),
        }
        self.seconds(CAUSE.1 - CAUSE.0);
        match self.cause {
            Cause::Nothing | Cause::Entry => {}
            Cause::Reduced => self.input(16, false),
            Cause::FasterBelt => self.belt -= 0.08,
            Cause::Pause => drop(self.bench.send(MachineCommand::Resume)),
            Cause::Safeguard => self.input(18, false),
        }
        let late = self.bench.now().time + 20.0;
        while !self.is_over() {
            self.tick();
            if !self.bench.stops.is_empty() {
                let state = self.bench.now();
                let at = state.time - began;
                return Err(format!("{:?} after {at:.3} s", self.bench.stops));
            }
            if self.bench.now().time > late {
                return Err(format!("does not end: {:?}", self.bench.now().motion_mode));
            }
        }
        let last = self.last.unwrap();
        let (outcome, ended) = self
            .bench
            .ended
            .iter()
            .find(|(id, ..)| *id == last)
            .map(|(_, outcome, cycle)| (*outcome, *cycle as f64 * self.bench.cycle.step_time()))
            .unwrap();
        if outcome != Outcome::Done {
            return Err(format!("{outcome:?}"));
        }
        self.seconds(0.6);
        if !self.bench.stops.is_empty() {
            return Err(format!("{:?} at the end", self.bench.stops));
        }
        let faults = self.bench.limit_faults();
        if !faults.is_empty() {
            let few = &faults[..faults.len().min(2)];
            return Err(format!("{} limits: {}", faults.len(), few.join("; ")));
        }
        if let Some(target) = self.target {
            let way = (self.ticks - self.tracked_at) / TICKS;
            let off = self.off_belt(&target, way);
            // The latest tick is followed in the next cycle.
            if off > 0.05e-3 + 0.1 * self.bench.cycle.step_time() {
                return Err(format!("{off:.2e} m beside the target"));
            }
        }
        Ok(ended - began)
    }

    /// Distance of the TCP from where the belt has carried the target to, m.
    fn off_belt(&self, target: &RpyPose, way: f64) -> f64 {
        let at = Vector3::from(self.bench.now().target_tcp_pose.xyz);
        let target = Vector3::from(target.xyz);
        let wanted = if self.is_table {
            let center = Vector3::new(-0.6, 0.25, 0.0);
            let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), way);
            center + turn * (target - center)
        } else {
            target + Vector3::new(0.0, way, 0.0)
        };
        (at - wanted).norm()
    }
}

/// Seeds for each mode.
fn seeds() -> u64 {
    let asked = std::env::var("BELT_SEEDS").ok();
    asked.and_then(|text| text.parse().ok()).unwrap_or(8)
}

#[test]
fn what_slows_a_motion_on_a_belt_down_stops_nothing_and_lets_it_go_again() {
    let (mut faults, mut slowest) = (Vec::new(), 0.0_f64);
    let mut count = 0;
    for mode in MODES {
        for seed in 0..seeds() {
            let free = Case::new(mode, Cause::Nothing, seed).run();
            for cause in CAUSES {
                let mut case = Case::new(mode, cause, seed);
                let name = format!(
                    "{mode:?} {cause:?} {seed} belt {} table {} hard {} tcp {:.2}",
                    case.belt, case.is_table, case.hard, case.bench.limits.tcp_speed
                );
                count += 1;
                match (case.run(), &free) {
                    (Ok(taken), Ok(free)) => {
                        let late = taken - free - (CAUSE.1 - CAUSE.0);
                        slowest = slowest.max(late);
                        // Braking, catching up with the belt and speeding up again.
                        if late > 1.2 {
                            faults.push(format!("{name}: {taken:.3} s for {free:.3}"));
                        }
                    }
                    (Err(fault), _) => faults.push(format!("{name}: {fault}")),
                    (Ok(_), Err(_)) => {}
                }
            }
        }
    }
    println!("{count} motions on belts, the latest ends {slowest:.2} s after its cause was gone");
    assert!(
        faults.is_empty(),
        "{} of {count}:\n{}",
        faults.len(),
        faults.join("\n")
    );
}
