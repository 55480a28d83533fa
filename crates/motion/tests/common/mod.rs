//! A controller on the bench: sends commands, ticks, and keeps every record and event.
#![allow(dead_code, missing_docs, reason = "each test binary uses a part of it")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "default speeds as the manual prints them"
)]

pub mod draw;
pub mod force;

use std::sync::Arc;

use kinematics::{JointPositions, RobotModel, RpyPose};
use motion::{ControlLoop, CycleConfig, CycleTiming, MotionLimits, PlantKind};
use motion_api::{
    CommandId, CommandKind, Event, MotionCommand, Origin, Outcome, PointList, Record,
    RingCapacities, RobotState, ScriptEndpoint, SensingCommand, StopReason, Warning,
    motion_channel,
};
use nalgebra::Vector3;

pub const MODELS: [&str; 6] = ["cs63", "cs66", "cs612", "cs616", "cs620", "cs625"];

pub struct Bench {
    pub model: &'static str,
    pub cycle: ControlLoop,
    pub script: ScriptEndpoint,
    pub states: Vec<RobotState>,
    pub ended: Vec<(CommandId, Outcome, u64)>,
    pub warnings: Vec<(CommandId, Warning)>,
    pub stops: Vec<StopReason>,
    /// Motions whose sender was told that the next may follow.
    pub queued: Vec<CommandId>,
    /// Motions whose successor is due.
    pub due: Vec<CommandId>,
    pub limits: MotionLimits,
    /// By this part differences of positions may exceed the jerk.
    pub jerk_slack: f64,
}

pub fn ideal(model: &str) -> CycleConfig {
    CycleConfig {
        plant: PlantKind::Ideal,
        ..CycleConfig::new(RobotModel::built_in(model).unwrap())
    }
}

/// The same, where nothing keeps the arm from running into itself: for tests that lead joints anywhere.
pub fn unwatched(model: &str) -> CycleConfig {
    let mut config = ideal(model);
    config.limits.self_collision = Some(false);
    config
}

impl Bench {
    pub fn new(config: CycleConfig) -> Self {
        let (motion, script) = motion_channel(RingCapacities::default(), &config.first_state());
        let limits = config.resolve().unwrap();
        let first = config.first_state();
        Self {
            model: "cs66",
            cycle: ControlLoop::new(config, motion).unwrap(),
            script,
            states: vec![first],
            ended: Vec::new(),
            warnings: Vec::new(),
            stops: Vec::new(),
            queued: Vec::new(),
            due: Vec::new(),
            limits,
            jerk_slack: 1e-3,
        }
    }

    pub fn send(&self, kind: impl Into<CommandKind>) -> CommandId {
        self.script.commands.send(Origin::default(), kind).unwrap()
    }

    /// A moveml through joint positions.
    pub fn moveml(&self, points: &[JointPositions], interval: f64) -> CommandId {
        self.send_points(PointList::from_joint_positions(points).unwrap(), interval)
    }

    /// A moveml through any points.
    pub fn send_points(&self, points: PointList, interval: f64) -> CommandId {
        let (port, points) = (&self.script.commands, Arc::new(points));
        port.send_points(Origin::default(), &points, interval, |_, _| ())
            .unwrap()
    }

    /// Joint positions that the arm follows in time.
    pub fn follow(&self, points: &[JointPositions], interval: f64) -> CommandId {
        let points = Arc::new(PointList::from_joint_positions(points).unwrap());
        let port = &self.script.commands;
        port.send_trajectory(Origin::default(), &points, interval, |_, _| ())
            .unwrap()
    }

    /// One cycle; its state.
    pub fn tick(&mut self) -> RobotState {
        self.cycle.tick(CycleTiming::default());
        while let Some(record) = self.script.records.as_mut().unwrap().next_record() {
            if let Record::Cycle(state) = record {
                self.states.push(state);
            }
        }
        while let Some(event) = self.script.events.next_event() {
            match event {
                Event::Ended { id, outcome, cycle } => self.ended.push((id, outcome, cycle)),
                Event::Warned { id, warning, .. } => self.warnings.push((id, warning)),
                Event::Stopped { reason, .. } => self.stops.push(reason),
                Event::ReadyForNext { id, .. } => self.queued.push(id),
                Event::Due { id, .. } => self.due.push(id),
            }
        }
        self.now()
    }

    pub fn run(&mut self, cycles: usize) {
        for _ in 0..cycles {
            self.tick();
        }
    }

    pub fn now(&self) -> RobotState {
        *self.states.last().unwrap()
    }

    pub fn outcome(&self, id: CommandId) -> Option<Outcome> {
        let ends: Vec<_> = self.ended.iter().filter(|(i, ..)| *i == id).collect();
        assert!(ends.len() <= 1, "{id:?} ended more than once");
        ends.first().map(|(_, outcome, _)| *outcome)
    }

    /// Ticks until the command has ended.
    pub fn finish(&mut self, id: CommandId) -> Outcome {
        for _ in 0..20_000 {
            if let Some(outcome) = self.outcome(id) {
                return outcome;
            }
            self.tick();
        }
        panic!("{id:?} does not end: {:?}", self.now());
    }

    /// Ticks until the command has ended or the next one is due.
    pub fn until_due(&mut self, id: CommandId) {
        while !self.due.contains(&id) && self.outcome(id).is_none() {
            self.tick();
        }
    }

    pub fn do_it(&mut self, kind: impl Into<CommandKind>) -> Outcome {
        let id = self.send(kind);
        self.finish(id)
    }

    /// A wrench on the tool from now on: base axes, about the TCP.
    pub fn push(&mut self, wrench: [f64; 6]) {
        let enable = CommandKind::Sensing(SensingCommand::FtRtsiInput {
            enabled: true,
            mass: 0.0,
            measuring_offset: [0.0; 3],
            cog: [0.0; 3],
        });
        assert_eq!(self.do_it(enable), Outcome::Done);
        assert_eq!(
            self.do_it(SensingCommand::SetExternalWrench(wrench)),
            Outcome::Done
        );
    }

    /// Checks every consecutive state so far against the joint limits, by what is reported and by differences.
    pub fn check_limits(&self) {
        let faults = self.limit_faults();
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }

    /// Every cycle in which a joint exceeds a limit.
    pub fn limit_faults(&self) -> Vec<String> {
        let l = &self.limits;
        let h = self.cycle.step_time();
        let mut faults = Vec::new();
        for joint in 0..6 {
            let q: Vec<f64> = std::iter::repeat_n(self.states[0].target_q[joint], 3)
                .chain(self.states.iter().map(|s| s.target_q[joint]))
                .collect();
            for (k, state) in self.states.iter().enumerate() {
                let [q0, q1, q2, q3] = [q[k], q[k + 1], q[k + 2], q[k + 3]];
                let (speed, acceleration) = (l.speed[joint], l.acceleration[joint]);
                // Differences of positions carry the rounding of the inverse kinematics.
                for (name, value, most) in [
                    ("speed", state.target_qd[joint], speed * (1.0 + 1e-6) + 1e-9),
                    (
                        "acceleration",
                        state.target_qdd[joint],
                        acceleration * (1.0 + 1e-6) + 1e-9,
                    ),
                    (
                        "difference speed",
                        (q3 - q2) / h,
                        speed * (1.0 + 1e-6) + 1e-7,
                    ),
                    (
                        "difference acceleration",
                        (q3 - 2.0 * q2 + q1) / (h * h),
                        acceleration * (1.0 + 1e-3) + 1e-3,
                    ),
                    (
                        "difference jerk",
                        (q3 - 3.0 * q2 + 3.0 * q1 - q0) / (h * h * h),
                        l.jerk[joint] * (1.0 + self.jerk_slack) + 1e-1,
                    ),
                ] {
                    if value.is_nan() || value.abs() > most {
                        faults.push(format!(
                            "{name} {value} of joint {joint} in cycle {} ({:?}), allowed {most}",
                            state.cycle, state.motion_mode
                        ));
                    }
                }
            }
        }
        faults
    }
}

pub fn movej(target: JointPositions) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveJ {
        target,
        acceleration: 1.396263,
        speed: 1.047197,
        duration: 0.0,
        radius: 0.0,
    })
}

pub fn movej_in(target: JointPositions, duration: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveJ {
        target,
        acceleration: 1.396263,
        speed: 1.047197,
        duration,
        radius: 0.0,
    })
}

pub fn movel(target: RpyPose) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: 1.2,
        speed: 0.25,
        duration: 0.0,
        radius: 0.0,
    })
}

/// A pose further on by so much, m.
pub fn moved(pose: &RpyPose, by: [f64; 3]) -> RpyPose {
    let mut pose = *pose;
    (0..3).for_each(|k| pose.xyz[k] += by[k]);
    pose
}

/// How fast the commanded TCP is, m/s.
pub fn tcp_speed(state: &RobotState) -> f64 {
    Vector3::from_row_slice(&state.target_tcp_speed[..3]).norm()
}

/// How often a series begins to rise or to fall, by more than `slack`.
pub fn turning_points(speeds: &[f64], slack: f64) -> usize {
    let (mut low, mut high, mut rises, mut turns) = (speeds[0], speeds[0], None, 0);
    for speed in speeds {
        (low, high) = (low.min(*speed), high.max(*speed));
        if rises != Some(true) && *speed > low + slack {
            (rises, high, turns) = (Some(true), *speed, turns + 1);
        } else if rises != Some(false) && *speed < high - slack {
            (rises, low, turns) = (Some(false), *speed, turns + 1);
        }
        match rises {
            Some(true) => low = *speed,
            Some(false) => high = *speed,
            None => {}
        }
    }
    turns
}
