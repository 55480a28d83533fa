//! Stops of an arm whose motions have something laid over them: each belt, offset and force mode × what moves the arm
//! below × each reason to stop, at drawn moments.
//!
//! Times and ways are computed here, from the limits of the joints and what was asked for, by the law of
//! `docs/motion.md`; a motion by itself is in `stop_laws`.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, ideal, moved, tcp_speed};
use core::f64::consts::TAU;
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel, RpyPose};
use motion::modes::encoder::Belt;
use motion::{CycleConfig, InputPair, SafetyInputs};
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionCommand, MotionMode, OffsetAxes, OnlineCommand,
    Outcome, OverlayCommand, RobotState, SettingCommand, StopReason,
};
use nalgebra::Vector3;

/// Time in which an acceleration that is asked for is reached, s.
const RISE: f64 = 0.030;
/// What motions get of accelerations and jerks while a belt or an offset has the rest (docs/motion.md, Belts).
const SHARE: f64 = 0.6;
/// What a pause makes use of at least, of accelerations; what it uses of them under a stream.
const PAUSE: f64 = 0.1;
const PAUSE_OF_STREAMS: f64 = 0.3;
/// Ticks of an encoder, 1/m and 1/rad, and speeds of belt and turntable, m/s and rad/s.
const TICKS: f64 = 1000.0;
const BELT: f64 = 0.10;
const TABLE: f64 = 0.15;
/// Acceleration of lines, arcs and speeds of the TCP, m/s², and of joints, rad/s².
const OF_TCP: f64 = 0.9;
const OF_JOINTS: f64 = 1.4;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Overlay {
    Belt,
    Table,
    Offset,
    Force,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Generator {
    Nothing,
    MoveJ,
    MoveL,
    MoveC,
    MoveP,
    BlendOfJoints,
    BlendOfLines,
    SpeedJ,
    SpeedL,
    ServoJ,
}

const GENERATORS: [Generator; 10] = [
    Generator::Nothing,
    Generator::MoveJ,
    Generator::MoveL,
    Generator::MoveC,
    Generator::MoveP,
    Generator::BlendOfJoints,
    Generator::BlendOfLines,
    Generator::SpeedJ,
    Generator::SpeedL,
    Generator::ServoJ,
];

/// So many of them, from nothing at all on, are planned.
const PLANNED: usize = 7;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Reason {
    Safeguard,
    Emergency,
    Protective,
    PowerOff,
    StopTask,
    StopThread,
    Pause,
    Slider,
    StopJ(f64),
    StopL(f64),
}

/// What is expected of a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    /// Each joint of the arm brakes with this share of its acceleration.
    JointByJoint(f64),
    /// Longest time, s, in which the motion below comes to rest on its path; with what is laid over it where that ends,
    /// too.
    Below { latest: f64, arm_stands: bool },
    /// The motion below comes to rest in this time, s; what it accelerates at already takes so long to go.
    BelowWithin { expected: f64, begun: f64 },
}

/// From a speed and an acceleration to rest as fast as limits allow: time, s, and distance.
///
/// The acceleration falls to the largest deceleration that there is time for, stays there and rises to zero.
fn shortest_stop(speed: f64, acceleration: f64, most: f64, jerk: f64) -> (f64, f64) {
    let coming = speed + acceleration * acceleration.abs() / (2.0 * jerk);
    let sign = if coming < 0.0 { -1.0 } else { 1.0 };
    let (v, a) = (sign * speed, sign * acceleration);
    let deepest = (jerk * v + a * a / 2.0).max(0.0).sqrt().min(most);
    let falling = (a + deepest).abs() / jerk;
    let rising = deepest / jerk;
    let lost = -(a - deepest) / 2.0 * falling + deepest * rising / 2.0;
    let even = if deepest < most {
        0.0
    } else {
        ((v - lost) / deepest).max(0.0)
    };
    let toward = if a + deepest < 0.0 { jerk } else { -jerk };
    let (mut way, mut now) = (0.0, [v, a]);
    for (time, j) in [(falling, toward), (even, 0.0), (rising, jerk)] {
        let [v, a] = now;
        way += v * time + a * time * time / 2.0 + j * time * time * time / 6.0;
        now = [v + a * time + j * time * time / 2.0, a + j * time];
    }
    (falling + even + rising, sign * way)
}

fn from_speed(speed: f64, acceleration: f64, jerk: f64) -> f64 {
    shortest_stop(speed, 0.0, acceleration, jerk).0
}

struct Scene {
    bench: Bench,
    overlay: Overlay,
    generator: Generator,
    model: RobotModel,
    start: JointPositions,
    /// When the motion below began, s.
    began: f64,
    first: CommandId,
    last: CommandId,
    next: Option<CommandKind>,
    streams: bool,
    weaves: bool,
}

fn config(overlay: Overlay, step_time: f64) -> CycleConfig {
    let belt = |speed: f64| Belt {
        encoder: 0,
        ticks_per_second: speed * TICKS,
        start_at: 0.0,
    };
    CycleConfig {
        step_time,
        safety_inputs: SafetyInputs {
            safeguard_stop: Some(InputPair {
                pair: 0,
                is_active_low: false,
            }),
            ..SafetyInputs::default()
        },
        belts: [
            match overlay {
                Overlay::Belt => Some(belt(BELT)),
                Overlay::Table => Some(belt(TABLE)),
                Overlay::Offset | Overlay::Force => None,
            },
            None,
        ],
        ..ideal("cs66")
    }
}

fn movel(target: RpyPose, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: OF_TCP,
        speed: 0.15,
        duration: 0.0,
        radius,
    })
}

fn movej(target: JointPositions, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveJ {
        target,
        acceleration: OF_JOINTS,
        speed: 0.5,
        duration: 0.0,
        radius,
    })
}

impl Scene {
    fn new(overlay: Overlay, generator: Generator, step_time: f64) -> Self {
        let mut bench = Bench::new(config(overlay, step_time));
        bench.tick();
        let start = bench.now().target_q;
        let mut scene = Self {
            bench,
            overlay,
            generator,
            model: RobotModel::built_in("cs66").unwrap(),
            start,
            began: 0.0,
            first: CommandId::NONE,
            last: CommandId::NONE,
            next: None,
            streams: generator == Generator::ServoJ,
            weaves: overlay == Overlay::Offset,
        };
        let begin = match overlay {
            Overlay::Belt => CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
                direction: [0.0, 1.0, 0.0],
                ticks_per_meter: TICKS,
                encoder: 0,
            }),
            Overlay::Table => CommandKind::Overlay(OverlayCommand::TrackConveyorCircular {
                center: RpyPose::from_array([-0.6, 0.25, 0.0, 0.0, 0.0, 0.4]),
                ticks_per_revolution: TICKS * TAU,
                rotate_tool: true,
                encoder: 0,
            }),
            Overlay::Offset => CommandKind::Overlay(OverlayCommand::PathOffsetEnable),
            Overlay::Force => CommandKind::Overlay(OverlayCommand::ForceMode {
                frame: RpyPose::default(),
                selection: [false, false, true, false, false, false],
                wrench: [0.0, 0.0, 12.0, 0.0, 0.0, 0.0],
                mode: 0,
                speed_limits: [0.05; 6],
            }),
        };
        assert_eq!(scene.bench.do_it(begin), Outcome::Done);
        scene.seconds(0.4);
        scene.began = scene.bench.now().time;
        if let Some(kind) = scene.kind() {
            scene.first = scene.bench.send(kind);
            scene.last = scene.first;
        }
        scene
    }

    /// The motion below, and what blends into it.
    fn kind(&mut self) -> Option<CommandKind> {
        let pose = self.bench.now().path_pose;
        let q = self.base_joints(1)[0];
        let by = |turns: [f64; 3]| {
            let mut q = q;
            (q[0], q[3], q[5]) = (q[0] + turns[0], q[3] + turns[1], q[5] + turns[2]);
            q
        };
        Some(match self.generator {
            Generator::Nothing => return None,
            Generator::MoveJ => movej(by([0.5, 0.1, -0.7]), 0.0),
            Generator::MoveL => movel(moved(&pose, [0.03, -0.22, 0.0]), 0.0),
            Generator::MoveC => CommandKind::Motion(MotionCommand::MoveC {
                via: moved(&pose, [0.06, -0.1, 0.0]),
                target: moved(&pose, [0.0, -0.2, 0.0]),
                acceleration: OF_TCP,
                speed: 0.15,
                radius: 0.0,
                fixed: false,
            }),
            Generator::MoveP => CommandKind::Motion(MotionCommand::MoveP {
                target: moved(&pose, [0.03, -0.22, 0.0]),
                acceleration: OF_TCP,
                speed: 0.15,
                radius: 0.0,
            }),
            Generator::BlendOfJoints => {
                self.next = Some(movej(by([0.3, 0.4, -0.4]), 0.0));
                movej(by([0.3, 0.0, 0.3]), 0.08)
            }
            Generator::BlendOfLines => {
                self.next = Some(movel(moved(&pose, [0.0, -0.22, 0.0]), 0.0));
                movel(moved(&pose, [0.08, -0.09, 0.0]), 0.03)
            }
            Generator::SpeedJ => CommandKind::Online(OnlineCommand::SpeedJ {
                speeds: JointSpeeds([0.3, 0.02, -0.04, 0.1, 0.1, 0.4]),
                acceleration: OF_JOINTS,
                duration: None,
            }),
            Generator::SpeedL => CommandKind::Online(OnlineCommand::SpeedL {
                speed: [0.04, -0.12, 0.0, 0.0, 0.0, 0.0],
                acceleration: OF_TCP,
                rotation_acceleration: 1.0,
                duration: None,
            }),
            Generator::ServoJ => self.point(),
        })
    }

    /// The next point of a slow swing.
    fn point(&self) -> CommandKind {
        let time = self.bench.now().time + self.bench.cycle.step_time() - self.began;
        let mut target = self.start;
        target[0] += 0.2 * (1.0 - (1.5 * time).cos());
        target[4] += 0.2 * (1.0 - (1.3 * time).cos());
        CommandKind::Online(OnlineCommand::ServoJ {
            target,
            duration: self.bench.cycle.step_time(),
            lookahead: 0.1,
            gain: 300.0,
        })
    }

    fn tick(&mut self) {
        if self.weaves {
            let time = self.bench.now().time;
            self.bench.send(OverlayCommand::PathOffsetSet {
                offset: RpyPose::from_array([
                    0.0,
                    0.0,
                    0.004 * (2.0 * TAU * time).sin(),
                    0.0,
                    0.0,
                    0.0,
                ]),
                axes: OffsetAxes::Base,
            });
        }
        self.bench.tick();
        if self.bench.queued.contains(&self.first)
            && let Some(next) = self.next.take()
        {
            self.last = self.bench.send(next);
        }
        if self.streams
            && self
                .bench
                .outcome(self.first)
                .is_none_or(|end| end == Outcome::Done)
        {
            let point = self.point();
            self.first = self.bench.send(point);
            self.last = self.first;
        }
    }

    fn seconds(&mut self, seconds: f64) {
        let cycles = (seconds / self.bench.cycle.step_time()).round() as usize;
        (0..cycles).for_each(|_| self.tick());
    }

    /// The joints of the motion below in the last cycles, by inverse kinematics of the path's pose.
    fn base_joints(&self, cycles: usize) -> Vec<JointPositions> {
        let states = &self.bench.states;
        let mut near = self.start;
        // The first state is that of the configuration.
        let all = states[1..].iter().map(|state| {
            let pose = Pose::from_rpy(&state.path_pose);
            near = self
                .model
                .inverse_continuous(&pose, &Pose::IDENTITY, &near)
                .unwrap();
            near
        });
        let all: Vec<_> = all.collect();
        all[all.len() - cycles..].to_vec()
    }

    /// Speeds and accelerations of the joints of the motion below.
    fn base_motion(&self) -> [[f64; 2]; 6] {
        let h = self.bench.cycle.step_time();
        let q = self.base_joints(3);
        core::array::from_fn(|j| {
            let (before, last) = ((q[1][j] - q[0][j]) / h, (q[2][j] - q[1][j]) / h);
            let acceleration = (last - before) / h;
            [last + acceleration * h / 2.0, acceleration]
        })
    }

    /// How fast the tool of the motion below turns, rad/s.
    fn base_turning(&self) -> f64 {
        let states = &self.bench.states;
        let at = |back: usize| Pose::from_rpy(&states[states.len() - back].path_pose).rotation;
        at(1).angle_to(&at(2)) / self.bench.cycle.step_time()
    }

    /// The TCP of the motion below: its velocity, m/s.
    fn base_velocity(&self) -> Vector3<f64> {
        let states = &self.bench.states;
        let at = |back: usize| Vector3::from(states[states.len() - back].path_pose.xyz);
        (at(1) - at(2)) / self.bench.cycle.step_time()
    }

    fn arm_stands(&self) -> bool {
        let state = self.bench.now();
        state.target_qd == JointSpeeds::ZERO && state.target_qdd.0 == [0.0; 6]
    }

    /// Whether the motion below stands. Once it has ended, force mode leads its target on along the axis that presses.
    fn base_stands(&self) -> bool {
        self.bench.now().motion_mode == MotionMode::ForceMode || self.base_velocity().norm() < 1e-9
    }

    fn send(&mut self, reason: Reason) {
        let kind = match reason {
            Reason::Safeguard => CommandKind::Setting(SettingCommand::SetDigitalInput {
                index: 16,
                level: true,
            }),
            Reason::Emergency => {
                CommandKind::Machine(MachineCommand::EmergencyStop { pressed: true })
            }
            Reason::Protective => CommandKind::Machine(MachineCommand::ProtectiveStop),
            Reason::PowerOff => CommandKind::Machine(MachineCommand::PowerOff),
            Reason::StopTask => CommandKind::Machine(MachineCommand::Stop {
                only: CommandId::NONE,
            }),
            Reason::StopThread => CommandKind::Machine(MachineCommand::Stop { only: self.last }),
            Reason::Pause => CommandKind::Machine(MachineCommand::Pause),
            Reason::Slider => CommandKind::Setting(SettingCommand::SetSpeedFraction(0.0)),
            Reason::StopJ(acceleration) => {
                CommandKind::Online(OnlineCommand::StopJ { acceleration })
            }
            Reason::StopL(acceleration) => {
                CommandKind::Online(OnlineCommand::StopL { acceleration })
            }
        };
        self.bench.send(kind);
        // The program that streams or weaves is held or over.
        self.streams = false;
        self.weaves &= reason == Reason::Slider || matches!(reason, Reason::StopThread);
        self.next = None;
    }

    /// The law that holds for the reason, with the times by the state in which the arm is.
    fn law(&self, reason: Reason) -> Law {
        let on_belt = matches!(self.overlay, Overlay::Belt | Overlay::Table);
        let l = &self.bench.limits;
        let base = self.base_motion();
        let share = if self.overlay == Overlay::Force {
            1.0
        } else {
            SHARE
        };
        // On the path, where bends and drives leave less than the joints have, a stop may take a tenth longer.
        let with_share = |share: f64| {
            (0..6).fold(0.0_f64, |most, j| {
                let [v, a] = base[j];
                most.max(shortest_stop(v, a, share * l.acceleration[j], SHARE * l.jerk[j]).0)
            })
        };
        // Own acceleration of the motion: of the TCP for lines, of the fastest joint for joints.
        let speed = self.base_velocity().norm();
        let fastest = base.iter().fold(0.0_f64, |most, [v, _]| most.max(v.abs()));
        let begun = base.iter().fold(0.0_f64, |most, [_, a]| most.max(a.abs()));
        let own = match self.generator {
            Generator::MoveL | Generator::MoveC | Generator::MoveP | Generator::SpeedL => {
                from_speed(speed, OF_TCP, OF_TCP / RISE)
            }
            Generator::MoveJ | Generator::SpeedJ => {
                from_speed(fastest, OF_JOINTS, OF_JOINTS / RISE)
            }
            _ => f64::INFINITY,
        };
        let gentle = match self.generator {
            Generator::ServoJ => with_share(share * PAUSE_OF_STREAMS),
            _ => own.min(with_share(PAUSE)),
        };
        // What a tenth of the joints' ability is on a path that bends changes along it.
        let bends = match self.generator {
            Generator::BlendOfJoints | Generator::BlendOfLines => 1.5,
            _ => 1.1,
        };
        match reason {
            Reason::Safeguard
            | Reason::Emergency
            | Reason::Protective
            | Reason::PowerOff
            | Reason::StopTask => Law::JointByJoint(1.0),
            Reason::Pause if on_belt => Law::JointByJoint(1.0),
            Reason::Pause if self.generator == Generator::ServoJ => {
                Law::JointByJoint(PAUSE_OF_STREAMS)
            }
            Reason::Pause => Law::Below {
                latest: bends * gentle + 2.0 * RISE,
                arm_stands: true,
            },
            Reason::Slider => Law::Below {
                latest: bends * gentle + 2.0 * RISE,
                arm_stands: false,
            },
            Reason::StopThread => Law::Below {
                latest: 1.1 * with_share(share) + RISE,
                arm_stands: false,
            },
            Reason::StopJ(a) => Law::BelowWithin {
                expected: from_speed(fastest, a, a / RISE),
                begun: begun / (a / RISE).min(400.0),
            },
            Reason::StopL(a) => Law::BelowWithin {
                // A turning tool counts 0.25 m a radian.
                expected: from_speed(speed.max(0.25 * self.base_turning()), a, a / RISE),
                begun: begun / (a / RISE).min(400.0),
            },
        }
    }

    /// Stops the arm; what is wrong with that, if anything.
    fn stop(&mut self, reason: Reason) -> Result<(), String> {
        let h = self.bench.cycle.step_time();
        let law = self.law(reason);
        let before = self.bench.now();
        let velocity = self.base_velocity();
        let from = Vector3::from(before.path_pose.xyz);
        self.send(reason);
        let is_over = |scene: &Self| match law {
            Law::JointByJoint(_) => scene.arm_stands(),
            Law::Below { arm_stands, .. } => {
                scene.base_stands() && (!arm_stands || scene.arm_stands())
            }
            Law::BelowWithin { .. } => scene.base_stands(),
        };
        let mut cycles = 0;
        loop {
            self.tick();
            if is_over(self) {
                break;
            }
            cycles += 1;
            if cycles > 5000 {
                return Err("does not come to rest".into());
            }
        }
        let taken = f64::from(cycles) * h;
        match law {
            Law::JointByJoint(share) => self.check_joints(&before, taken, share),
            Law::Below { latest, .. } if taken > latest + 3.0 * h => {
                Err(format!("{taken:.3} s, at most {latest:.3} s"))
            }
            Law::Below { .. } if self.keeps_line(reason) => self.check_line(from, velocity),
            Law::Below { .. } => Ok(()),
            Law::BelowWithin { expected, begun } => {
                let slack = 0.03 * expected + 2.5 * begun + 0.01 + 3.0 * h;
                if (taken - expected).abs() > slack {
                    return Err(format!("{taken:.3} s instead of {expected:.3} s"));
                }
                if self.keeps_line(reason) {
                    self.check_line(from, velocity)?;
                }
                Ok(())
            }
        }
    }

    /// Whether the TCP of the motion below stays on its line. stopj brakes the joints in proportion, and a speed of the
    /// TCP has no path that a stop of its thread would keep.
    fn keeps_line(&self, reason: Reason) -> bool {
        let is_line = match self.generator {
            Generator::MoveL | Generator::MoveP => true,
            Generator::SpeedL => reason != Reason::StopThread,
            _ => false,
        };
        is_line && !matches!(reason, Reason::StopJ(_)) && self.overlay != Overlay::Force
    }

    /// Each joint took its shortest time and way.
    fn check_joints(&self, before: &RobotState, taken: f64, share: f64) -> Result<(), String> {
        let (h, l) = (self.bench.cycle.step_time(), &self.bench.limits);
        let q = self.bench.now().target_q;
        let mut longest = 0.0_f64;
        for j in 0..6 {
            let (v, a) = (before.target_qd[j], before.target_qdd[j]);
            let most = (share * l.acceleration[j]).max(a.abs());
            let (time, way) = shortest_stop(v, a, most, l.jerk[j]);
            longest = longest.max(time);
            let turned = q[j] - before.target_q[j];
            // Up to three cycles until the stop is taken, and a twentieth of the jerk in reserve.
            let slack = 0.06 * way.abs() + 3.0 * h * (v.abs() + a.abs() * h) + 1e-5;
            if (turned - way).abs() > slack {
                return Err(format!(
                    "joint {j} turned {turned:.5} instead of {way:.5} rad"
                ));
            }
        }
        let most = 1.06 * longest + 3.0 * h;
        if taken > most || taken < longest - 2.0 * h {
            return Err(format!("{taken:.3} s instead of {longest:.3} s"));
        }
        Ok(())
    }

    /// What began on a line stayed on it.
    fn check_line(&self, from: Vector3<f64>, velocity: Vector3<f64>) -> Result<(), String> {
        if velocity.norm() < 1e-6 {
            return Ok(());
        }
        let way = Vector3::from(self.bench.now().path_pose.xyz) - from;
        let direction = velocity.normalize();
        let beside = (way - direction * way.dot(&direction)).norm();
        if beside > 1e-5 {
            return Err(format!("{beside:.2e} m beside its line"));
        }
        Ok(())
    }

    /// What is laid over the motion goes on where it should, and nothing else moves.
    fn check_afterwards(&mut self, reason: Reason) -> Result<(), String> {
        self.seconds(0.3);
        let goes_on = matches!(
            reason,
            Reason::StopThread | Reason::Slider | Reason::StopJ(_) | Reason::StopL(_)
        );
        let state = self.bench.now();
        if !goes_on {
            let moves = !self.arm_stands();
            return if moves {
                Err("moves on".into())
            } else {
                Ok(())
            };
        }
        match self.overlay {
            Overlay::Belt if (tcp_speed(&state) - BELT).abs() > 1e-3 => {
                Err(format!("{} m/s on the belt", tcp_speed(&state)))
            }
            Overlay::Table if (state.target_tcp_speed[5] - TABLE).abs() > 1e-3 => {
                Err(format!("{:?} on the turntable", state.target_tcp_speed))
            }
            Overlay::Force if !state.force_mode => Err("force mode is over".into()),
            _ => Ok(()),
        }
    }
}

fn reasons(draw: &mut Draw) -> [Reason; 10] {
    [
        Reason::Safeguard,
        Reason::Emergency,
        Reason::Protective,
        Reason::PowerOff,
        Reason::StopTask,
        Reason::StopThread,
        Reason::Pause,
        Reason::Slider,
        Reason::StopJ(draw.spread(0.4, 5.0)),
        Reason::StopL(draw.spread(0.3, 2.5)),
    ]
}

fn all(overlay: Overlay, generators: &[Generator]) {
    let mut draw = Draw::new(overlay as u64 + 7);
    let (mut wrong, mut count) = (Vec::new(), 0);
    for generator in generators.iter().copied() {
        for reason in reasons(&mut draw) {
            if generator == Generator::Nothing
                && matches!(
                    reason,
                    Reason::StopJ(_) | Reason::StopL(_) | Reason::StopThread
                )
            {
                continue;
            }
            for (earliest, latest) in [(0.03, 0.2), (0.3, 1.3)] {
                count += 1;
                let step_time = *draw.pick(&[0.002, 0.004, 0.008]);
                let moment = draw.between(earliest, latest);
                let mut scene = Scene::new(overlay, generator, step_time);
                // An acceleration of force mode is the mean over its cycle.
                scene.bench.jerk_slack = 0.02;
                scene.seconds(moment);
                let result = scene
                    .stop(reason)
                    .and_then(|()| scene.check_afterwards(reason));
                let mut faults: Vec<String> = result.err().into_iter().collect();
                faults.extend(scene.bench.limit_faults().into_iter().take(2));
                let is_asked_for = |stop: &StopReason| {
                    matches!(stop, StopReason::Requested | StopReason::EmergencyStop)
                };
                if !scene.bench.stops.iter().all(is_asked_for) {
                    faults.push(format!("{:?}", scene.bench.stops));
                }
                wrong.extend(faults.into_iter().map(|fault| {
                    format!("{generator:?}, {reason:?} after {moment:.3} s of {step_time}: {fault}")
                }));
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
fn each_stop_of_a_planned_motion_on_a_belt_takes_the_time_and_the_way_of_its_law() {
    all(Overlay::Belt, &GENERATORS[..PLANNED]);
}

#[test]
fn each_stop_of_an_online_mode_on_a_belt_takes_the_time_and_the_way_of_its_law() {
    all(Overlay::Belt, &GENERATORS[PLANNED..]);
}

#[test]
fn each_stop_of_a_planned_motion_on_a_turntable_takes_the_time_and_the_way_of_its_law() {
    all(Overlay::Table, &GENERATORS[..PLANNED]);
}

#[test]
fn each_stop_of_an_online_mode_on_a_turntable_takes_the_time_and_the_way_of_its_law() {
    all(Overlay::Table, &GENERATORS[PLANNED..]);
}

#[test]
fn each_stop_of_a_planned_motion_under_a_weave_takes_the_time_and_the_way_of_its_law() {
    all(Overlay::Offset, &GENERATORS[..PLANNED]);
}

#[test]
fn each_stop_of_an_online_mode_under_a_weave_takes_the_time_and_the_way_of_its_law() {
    all(Overlay::Offset, &GENERATORS[PLANNED..]);
}

#[test]
fn each_stop_of_a_planned_motion_in_force_mode_takes_the_time_and_the_way_of_its_law() {
    all(Overlay::Force, &GENERATORS[..PLANNED]);
}

#[test]
fn each_stop_of_an_online_mode_in_force_mode_takes_the_time_and_the_way_of_its_law() {
    all(Overlay::Force, &GENERATORS[PLANNED..]);
}
