//! The law of stopping for each reason, held against own computation: random motions of every generator, stopped at
//! random moments; how long that takes, how hard the arm brakes, and which way it goes.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, ideal, moved, tcp_speed};
use kinematics::{JointPositions, JointSpeeds, RpyPose};
use motion::{CycleConfig, InputPair, SafetyInputs};
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionCommand, OnlineCommand, Outcome, RobotState,
    SettingCommand, StopReason,
};
use nalgebra::Vector3;

/// Time in which an acceleration that is asked for is reached, s.
const RISE: f64 = 0.030;

/// What moves the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Generator {
    MoveJ,
    /// With a duration much longer than the motion needs.
    MoveJInTime,
    MoveL,
    MoveLInTime,
    MoveC,
    /// Two movej with a blend, each so slow to accelerate that the blend is most of it.
    BlendOfJoints,
    BlendOfLines,
    SpeedJ,
    SpeedL,
    ServoJ,
}

const GENERATORS: [Generator; 10] = [
    Generator::MoveJ,
    Generator::MoveJInTime,
    Generator::MoveL,
    Generator::MoveLInTime,
    Generator::MoveC,
    Generator::BlendOfJoints,
    Generator::BlendOfLines,
    Generator::SpeedJ,
    Generator::SpeedL,
    Generator::ServoJ,
];

const PLANNED: usize = 7;

fn config(step_time: f64) -> CycleConfig {
    CycleConfig {
        step_time,
        safety_inputs: SafetyInputs {
            safeguard_stop: Some(InputPair {
                pair: 0,
                is_active_low: false,
            }),
            ..SafetyInputs::default()
        },
        ..ideal("cs66")
    }
}

/// A motion under way, and what has to be sent so that it goes on.
struct Scene {
    bench: Bench,
    generator: Generator,
    next: Option<CommandKind>,
    first: Option<CommandId>,
    last: Option<CommandId>,
    start: JointPositions,
    streams: bool,
}

fn line(target: RpyPose, acceleration: f64, speed: f64, duration: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration,
        speed,
        duration,
        radius,
    })
}

fn joints(
    target: JointPositions,
    acceleration: f64,
    speed: f64,
    duration: f64,
    radius: f64,
) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveJ {
        target,
        acceleration,
        speed,
        duration,
        radius,
    })
}

impl Scene {
    fn new(generator: Generator, step_time: f64, draw: &mut Draw) -> Self {
        let mut bench = Bench::new(config(step_time));
        bench.tick();
        let start = bench.now().target_q;
        let mut scene = Self {
            bench,
            generator,
            next: None,
            first: None,
            last: None,
            start,
            streams: generator == Generator::ServoJ,
        };
        let kind = scene.kind(draw);
        scene.first = Some(scene.bench.send(kind));
        scene.last = scene.first;
        scene
    }

    fn kind(&mut self, draw: &mut Draw) -> CommandKind {
        let pose = self.bench.now().target_tcp_pose;
        let mut far = self.start;
        far[0] += draw.between(0.8, 1.4);
        far[3] += draw.between(-0.4, 0.4);
        far[5] += draw.between(-1.0, 1.0);
        let side = moved(
            &pose,
            [draw.between(-0.05, 0.05), draw.between(0.2, 0.3), -0.05],
        );
        let a = draw.spread(0.1, 8.0);
        match self.generator {
            Generator::MoveJ => joints(far, a, draw.between(0.3, 2.0), 0.0, 0.0),
            Generator::MoveJInTime => joints(far, 1.4, 1.0, draw.between(5.0, 20.0), 0.0),
            Generator::MoveL => line(side, a.min(3.0), draw.between(0.1, 0.3), 0.0, 0.0),
            Generator::MoveLInTime => line(side, 1.2, 0.25, draw.between(4.0, 12.0), 0.0),
            Generator::MoveC => CommandKind::Motion(MotionCommand::MoveC {
                via: moved(&pose, [0.08, 0.12, 0.0]),
                target: moved(&pose, [0.0, 0.25, 0.0]),
                acceleration: a.min(3.0),
                speed: draw.between(0.1, 0.3),
                radius: 0.0,
                fixed: false,
            }),
            Generator::BlendOfJoints => {
                let a = draw.spread(0.1, 1.0);
                let mut corner = self.start;
                corner[0] += 0.5;
                let mut end = corner;
                end[1] += 0.3;
                end[2] -= 0.6;
                self.next = Some(joints(end, a, 0.8, 0.0, 0.0));
                joints(corner, a, 0.8, 0.0, draw.between(0.05, 0.12))
            }
            Generator::BlendOfLines => {
                let a = draw.spread(0.1, 1.0);
                let corner = moved(&pose, [0.1, 0.1, 0.0]);
                self.next = Some(line(moved(&corner, [-0.1, 0.15, 0.0]), a, 0.25, 0.0, 0.0));
                line(corner, a, 0.25, 0.0, draw.between(0.02, 0.05))
            }
            Generator::SpeedJ => CommandKind::Online(OnlineCommand::SpeedJ {
                speeds: JointSpeeds([0.7, 0.1, -0.2, 0.1, 0.3, draw.between(-0.9, 0.9)]),
                acceleration: draw.spread(0.3, 8.0),
                duration: None,
            }),
            Generator::SpeedL => CommandKind::Online(OnlineCommand::SpeedL {
                speed: [0.05, draw.between(0.1, 0.2), -0.05, 0.0, 0.0, 0.0],
                acceleration: draw.spread(0.3, 3.0),
                rotation_acceleration: 1.0,
                duration: None,
            }),
            Generator::ServoJ => self.point(),
        }
    }

    /// The next point of a slow swing.
    fn point(&self) -> CommandKind {
        let time = self.bench.now().time + self.bench.cycle.step_time();
        let mut target = self.start;
        target[0] += 0.6 * (1.0 - (0.8 * time).cos());
        target[4] += 0.3 * (1.0 - (1.3 * time).cos());
        CommandKind::Online(OnlineCommand::ServoJ {
            target,
            duration: self.bench.cycle.step_time(),
            lookahead: 0.1,
            gain: 300.0,
        })
    }

    fn tick(&mut self) {
        self.bench.tick();
        let first = self.first.unwrap();
        if self.bench.queued.contains(&first)
            && let Some(next) = self.next.take()
        {
            self.last = Some(self.bench.send(next));
        }
        if self.streams && self.bench.outcome(first) == Some(Outcome::Done) {
            let point = self.point();
            self.first = Some(self.bench.send(point));
            self.last = self.first;
        }
    }

    fn seconds(&mut self, seconds: f64) {
        let cycles = (seconds / self.bench.cycle.step_time()).round() as usize;
        (0..cycles).for_each(|_| self.tick());
    }

    /// Until the arm stands: how long that takes, s, from the cycle in which the stop is taken.
    fn time_to_rest(&mut self) -> f64 {
        self.streams = false;
        self.next = None;
        let h = self.bench.cycle.step_time();
        for cycle in 0..30_000 {
            self.tick();
            if stands(&self.bench.now()) {
                return f64::from(cycle) * h;
            }
        }
        panic!("{:?} does not come to rest", self.generator);
    }

    /// The shortest time in which the joints can stand, s; a little is added by who follows from an acceleration.
    fn shortest(&self) -> f64 {
        let (state, l) = (self.bench.now(), &self.bench.limits);
        (0..6).fold(0.0, |most: f64, j| {
            let (v, a) = (state.target_qd[j].abs(), state.target_qdd[j].abs());
            most.max(time_to_rest(v, l.acceleration[j], l.jerk[j]) + 2.0 * a / l.jerk[j])
        })
    }

    fn check(&self, what: &str) -> Vec<String> {
        let mut faults = self.bench.limit_faults();
        faults.truncate(2);
        let asked_for = |stop: &StopReason| *stop == StopReason::Requested;
        if !self.bench.stops.iter().all(asked_for) {
            faults.push(format!("protective stop {:?}", self.bench.stops));
        }
        let named = |fault| format!("{:?}, {what}: {fault}", self.generator);
        faults.into_iter().map(named).collect()
    }
}

/// From a speed to rest under limits of acceleration and jerk, s.
fn time_to_rest(speed: f64, acceleration: f64, jerk: f64) -> f64 {
    if speed * jerk >= acceleration * acceleration {
        speed / acceleration + acceleration / jerk
    } else {
        2.0 * (speed / jerk).sqrt()
    }
}

fn stands(state: &RobotState) -> bool {
    state.target_qd == JointSpeeds::ZERO && state.target_qdd.0 == [0.0; 6]
}

const SHORTEST_STOPS: [CommandKind; 4] = [
    CommandKind::Setting(SettingCommand::SetDigitalInput {
        index: 16,
        level: true,
    }),
    CommandKind::Machine(MachineCommand::Stop {
        only: CommandId::NONE,
    }),
    CommandKind::Machine(MachineCommand::PowerOff),
    CommandKind::Machine(MachineCommand::ProtectiveStop),
];

#[test]
fn safeguard_stop_power_off_and_protective_stops_are_as_short_as_the_joints_can() {
    let mut draw = Draw::new(1);
    let mut wrong = Vec::new();
    for round in 0..6 {
        for generator in GENERATORS {
            for stop in SHORTEST_STOPS {
                let step_time = *draw.pick(&[0.002, 0.004, 0.008]);
                let mut scene = Scene::new(generator, step_time, &mut draw);
                scene.seconds(draw.between(0.05, 1.5));
                let shortest = scene.shortest();
                scene.bench.send(stop);
                let taken = scene.time_to_rest();
                let most = 1.3 * shortest + 0.03 + 2.0 * step_time;
                if taken > most {
                    wrong.push(format!("{generator:?}, {stop:?} {round}: {taken} > {most}"));
                }
                wrong.extend(scene.check("as short as the joints can"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_motion_that_is_safeguarded_anywhere_goes_on_to_its_target() {
    let mut draw = Draw::new(2);
    let mut wrong = Vec::new();
    for _ in 0..12 {
        for generator in &GENERATORS[..PLANNED] {
            let mut scene = Scene::new(*generator, 0.004, &mut draw);
            scene.seconds(draw.between(0.05, 1.5));
            let safeguard =
                |level| CommandKind::Setting(SettingCommand::SetDigitalInput { index: 16, level });
            scene.bench.send(safeguard(true));
            scene.seconds(draw.between(0.02, 0.6));
            scene.bench.send(safeguard(false));
            for _ in 0..8000 {
                scene.tick();
                if scene.next.is_none() && scene.bench.cycle.is_standing() {
                    break;
                }
            }
            let ends = scene.bench.ended.iter();
            let unfinished = ends.filter(|(_, outcome, _)| *outcome != Outcome::Done);
            wrong.extend(unfinished.map(|end| format!("{generator:?}: {end:?}")));
            wrong.extend(scene.check("held by the safeguard"));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_pause_keeps_the_path_and_is_no_softer_than_a_tenth_of_what_the_joints_can_do() {
    let mut draw = Draw::new(3);
    let mut wrong = Vec::new();
    for _ in 0..10 {
        for generator in GENERATORS {
            let mut scene = Scene::new(generator, 0.004, &mut draw);
            scene.seconds(draw.between(0.05, 1.5));
            let state = scene.bench.now();
            let l = &scene.bench.limits;
            let slowest = (0..6).fold(0.0, |most: f64, j| {
                most.max(state.target_qd[j].abs() / (0.1 * l.acceleration[j]))
            });
            let taken = {
                scene.bench.send(MachineCommand::Pause);
                scene.time_to_rest()
            };
            // The share of what the joints can do on the path, which bends and drives lower; smoothing takes its time.
            let most = 1.6 * slowest + 0.12;
            if taken > most {
                wrong.push(format!("{generator:?}: {taken} > {most}"));
            }
            wrong.extend(scene.check("paused"));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn stopj_takes_the_acceleration_of_the_fastest_joint() {
    let mut draw = Draw::new(4);
    let mut wrong = Vec::new();
    for _ in 0..10 {
        for generator in GENERATORS {
            let mut scene = Scene::new(generator, 0.002, &mut draw);
            scene.seconds(draw.between(0.3, 1.5));
            let state = scene.bench.now();
            let speed = state.target_qd.max_abs();
            let a = draw.spread(0.3, 9.0);
            scene.bench.send(OnlineCommand::StopJ { acceleration: a });
            let taken = scene.time_to_rest();
            let begun = state.target_qdd.max_abs();
            let expected = time_to_rest(speed, a, a / RISE);
            // What it accelerates at when the stop comes has to go first.
            let slack = 0.02 * expected + 0.006 + 2.5 * begun / (a / RISE).min(400.0);
            if (taken - expected).abs() > slack {
                wrong.push(format!(
                    "{generator:?}, stopj({a:.2}) at {speed:.3} rad/s, {begun:.2} rad/s²: \
                     {taken:.3} instead of {expected:.3} s"
                ));
            }
            wrong.extend(scene.check("stopj"));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn stopl_takes_the_acceleration_of_the_tcp_on_its_line() {
    let mut draw = Draw::new(5);
    let mut wrong = Vec::new();
    let on_lines = [
        Generator::MoveL,
        Generator::MoveLInTime,
        Generator::SpeedL,
        Generator::MoveC,
        Generator::BlendOfLines,
    ];
    for _ in 0..12 {
        for generator in on_lines {
            let mut scene = Scene::new(generator, 0.002, &mut draw);
            scene.seconds(draw.between(0.3, 1.0));
            let state = scene.bench.now();
            let speed = tcp_speed(&state);
            let a = draw.spread(0.2, 3.0);
            let direction = Vector3::from_row_slice(&state.target_tcp_speed[..3]) / speed;
            let from = Vector3::from_row_slice(&state.target_tcp_pose.xyz);
            scene.bench.send(OnlineCommand::StopL { acceleration: a });
            let taken = scene.time_to_rest();
            let to = Vector3::from_row_slice(&scene.bench.now().target_tcp_pose.xyz);
            let beside = (to - from) - direction * (to - from).dot(&direction);
            let begun = state.target_qdd.max_abs();
            let expected = time_to_rest(speed, a, a / RISE);
            let slack = 0.03 * expected + 0.006 + 2.5 * begun / (a / RISE).min(400.0);
            if speed > 1e-3 && (taken - expected).abs() > slack {
                wrong.push(format!(
                    "{generator:?}, stopl({a:.2}) at {speed:.3} m/s, {begun:.2} rad/s²: \
                     {taken:.3} instead of {expected:.3} s"
                ));
            }
            if matches!(generator, Generator::MoveL | Generator::MoveLInTime)
                && beside.norm() > 1e-6
            {
                wrong.push(format!(
                    "{generator:?}, stopl({a:.2}): {beside:?} beside the line"
                ));
            }
            wrong.extend(scene.check("stopl"));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_motion_after_a_stopped_one_waits_for_the_braking_whoever_sends_it() {
    let mut draw = Draw::new(6);
    let mut wrong = Vec::new();
    for _ in 0..6 {
        for generator in GENERATORS {
            for everything in [false, true] {
                let mut scene = Scene::new(generator, 0.004, &mut draw);
                scene.seconds(draw.between(0.05, 1.2));
                scene.streams = false;
                let only = match everything {
                    true => CommandId::NONE,
                    false => scene.last.unwrap(),
                };
                scene.next = None;
                let stop = scene.bench.send(MachineCommand::Stop { only });
                scene.seconds(draw.between(0.0, 0.05));
                let back = scene.bench.send(joints(scene.start, 1.4, 1.0, 0.0, 0.0));
                let outcome = scene.bench.finish(back);
                if outcome != Outcome::Done || scene.bench.now().target_q != scene.start {
                    wrong.push(format!("{generator:?}, {everything}: {outcome:?}"));
                }
                if scene.bench.outcome(stop) != Some(Outcome::Done) {
                    wrong.push(format!("{generator:?}, {everything}: the stop has no end"));
                }
                wrong.extend(scene.check("the next motion"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}
