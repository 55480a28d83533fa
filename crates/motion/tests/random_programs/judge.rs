//! Judges every cycle of a run: limits, path, blend zones, ends, belts, durations.
//!
//! Knows the commands, the states and geometry; nothing of how motions are planned.

use kinematics::rotation::rotation_from_rotvec;
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel};
use motion_api::{CommandKind, MotionCommand, Outcome, RobotState, StopReason, Warning};
use nalgebra::Vector3;

use crate::generate::{BELT_START, Conveyor, ConveyorKind, Program};
use crate::run::{Run, Sent, What};
use crate::way::{Way, distance};

/// Largest deviation from the path, m and rad.
const PATH: f64 = 1e-6;
/// Largest distance from the target at the end, m and rad.
const END: f64 = 1e-9;
/// Largest error on a belt once it is caught up with, m, and the angle that goes with it at 0.2 m, rad.
const BELT: f64 = 0.05e-3;
const BELT_ANGLE: f64 = 0.25e-3;
/// Time in which a paused arm comes to rest, s.
const RESTING: f64 = 0.5;
/// Time in which joints that are braked come to rest, s.
const BRAKING: f64 = 0.5;
/// Time to catch up with a belt, s.
const CATCHING_UP: f64 = 0.8;
/// Faults of one program that are told.
const MOST_FAULTS: usize = 6;

/// What was found.
#[derive(Default)]
pub struct Verdict {
    pub faults: Vec<String>,
    pub tally: Tally,
}

/// Counts and extremes, so that a judge that sees nothing is noticed.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub cycles: usize,
    pub motions: usize,
    pub refused: usize,
    /// Motions that began in the zone of the one before, and those of them that began from rest after all.
    pub joined: usize,
    pub not_joined: usize,
    pub on_belts: usize,
    /// Programs that a belt ended by carrying the arm to where it could not follow.
    pub carried_away: usize,
    /// Motions that were ended because they took too long.
    pub cut_short: usize,
    pub path_max: f64,
    pub end_max: f64,
    pub belt_max: f64,
    pub rest_to_rest: Vec<RestToRest>,
}

/// A movej from rest to rest with nothing in between.
#[derive(Clone, Debug)]
pub struct RestToRest {
    pub way: [f64; 6],
    pub speed: f64,
    pub acceleration: f64,
    pub taken: f64,
}

impl Tally {
    pub fn add(&mut self, other: Self) {
        self.cycles += other.cycles;
        self.motions += other.motions;
        self.refused += other.refused;
        self.joined += other.joined;
        self.not_joined += other.not_joined;
        self.on_belts += other.on_belts;
        self.carried_away += other.carried_away;
        self.cut_short += other.cut_short;
        self.path_max = self.path_max.max(other.path_max);
        self.end_max = self.end_max.max(other.end_max);
        self.belt_max = self.belt_max.max(other.belt_max);
        self.rest_to_rest.extend(other.rest_to_rest);
    }
}

pub fn judge(program: &Program, run: &Run) -> Verdict {
    let mut verdict = Verdict::default();
    verdict.tally.cycles = run.bench.states.len();
    verdict.tally.cut_short = run.cut_short;
    for stop in &run.bench.stops {
        // A belt goes on when the arm cannot; so may the joint speeds of a motion that was planned elsewhere.
        let is_carried_away = matches!(
            stop,
            StopReason::ConveyorLost | StopReason::JointSpeed { .. }
        );
        if program.conveyor.is_some() && is_carried_away {
            verdict.tally.carried_away += 1;
        } else {
            verdict.faults.push(format!("protective stop: {stop}"));
        }
    }
    verdict.faults.extend(run.bench.limit_faults());
    verdict.faults.extend(point_faults(program, run));
    let mut follower = Follower {
        model: RobotModel::built_in(program.model).unwrap(),
        tcp: Pose::from_rpy(&program.tcp),
        conveyor: program.conveyor,
        run,
        verdict,
        on: None,
    };
    follower.all();
    let mut verdict = follower.verdict;
    let count = verdict.faults.len();
    if count > MOST_FAULTS {
        verdict.faults.truncate(MOST_FAULTS);
        verdict
            .faults
            .push(format!("... {count} cycles in all are wrong"));
    }
    verdict
}

/// Cycles in which TCP or elbow are faster than the program's limits.
fn point_faults(program: &Program, run: &Run) -> Vec<String> {
    let mut faults = Vec::new();
    for pair in run.bench.states.windows(2) {
        let [before, now] = pair else { continue };
        let elbow = |s: &RobotState| Vector3::from(s.elbow_position);
        let elbow_speed = (elbow(now) - elbow(before)).norm() / program.step_time;
        for (name, speed, limit) in [
            ("TCP", tcp_speed(now), program.limits.tcp_speed),
            ("elbow", elbow_speed, program.limits.elbow_speed),
        ] {
            if let Some(limit) = limit
                && speed > limit * (1.0 + 1e-6)
            {
                faults.push(format!(
                    "cycle {}: the {name} moves at {speed} m/s, allowed {limit}",
                    now.cycle
                ));
            }
        }
    }
    faults
}

/// Where the last motion leads that was begun.
#[derive(Clone)]
struct On {
    way: Way,
    end: Pose,
    end_q: Option<JointPositions>,
    radius: f64,
    cap: Cap,
}

/// What was asked as the most.
#[derive(Clone, Copy, PartialEq)]
enum Cap {
    Joint(f64),
    Tcp(f64),
    None,
}

struct Follower<'a> {
    model: RobotModel,
    tcp: Pose,
    conveyor: Option<Conveyor>,
    run: &'a Run,
    verdict: Verdict,
    on: Option<On>,
}

impl Follower<'_> {
    fn all(&mut self) {
        let run = self.run;
        let first = &run.bench.states[0];
        let mut nominal = self.model.tcp_pose(&first.target_q, &self.tcp);
        for (k, phase) in run.phases.iter().enumerate() {
            let end = run.phases.get(k + 1).map_or(u64::MAX, |next| next.from);
            // State k is that of cycle k.
            let states: Vec<&RobotState> = run
                .bench
                .states
                .iter()
                .filter(|s| s.cycle > phase.from && s.cycle <= end)
                .collect();
            match &phase.what {
                What::Online => self.on = None,
                What::Tool(tcp) => {
                    self.tcp = Pose::from_rpy(tcp);
                    self.on = None;
                }
                What::Move(sent) => self.motion(sent, &states, &mut nominal),
            }
        }
    }

    fn motion(&mut self, sent: &Sent, states: &[&RobotState], nominal: &mut Pose) {
        self.verdict.tally.motions += 1;
        let before = if sent.stood.is_some() {
            None
        } else {
            self.on.clone()
        };
        let start = match (&sent.stood, &before) {
            (Some(q), _) => Some((*q, self.model.tcp_pose(q, &self.tcp))),
            (None, Some(on)) => on.end_q.map(|q| (q, on.end)),
            (None, None) => None,
        };
        let Some((q, mut pose)) = start else {
            let text = format!("{:?}: where the arm is to begin is not known", sent.id);
            self.verdict.faults.push(text);
            return;
        };
        if self.conveyor.is_some() {
            pose = *nominal;
        }
        if matches!(sent.outcome, Outcome::Refused(_)) {
            self.refused(sent, states, before.as_ref());
            return;
        }
        let Some(way) = Way::of(&sent.kind, &q, pose) else {
            let text = format!("{:?}: makes no way, but was begun", sent.kind);
            self.verdict.faults.push(text);
            return;
        };
        let (radius, cap) = asked(&sent.kind);
        let on = On {
            end: way.end(&self.model, &self.tcp),
            end_q: match self.conveyor {
                None => way.end_q(&self.model, &self.tcp, &q),
                // Only lines and arcs follow, which begin at a pose.
                Some(_) => Some(q),
            },
            way,
            radius,
            cap,
        };
        if before.is_some() {
            self.verdict.tally.joined += 1;
            let warnings = &self.run.bench.warnings;
            if warnings.contains(&(sent.id, Warning::NotBlended)) {
                self.verdict.tally.not_joined += 1;
            }
        }
        if self.conveyor.is_some() {
            self.on_belt(sent, states, before.as_ref(), &on);
        } else {
            self.on_path(states, before.as_ref(), &on);
            self.at_end(sent, states, &on);
        }
        self.remember_duration(sent, &q, before.is_none());
        if sent.outcome == Outcome::Done {
            *nominal = on.end;
            self.on = Some(on);
        } else {
            self.on = None;
        }
    }

    /// A refused motion leaves the arm where it stands, or on the way that it is on.
    fn refused(&mut self, sent: &Sent, states: &[&RobotState], before: Option<&On>) {
        self.verdict.tally.refused += 1;
        if self.conveyor.is_some() {
            return;
        }
        for state in states {
            let off = match (before, &sent.stood) {
                (Some(on), _) => {
                    let pose = self.model.tcp_pose(&state.target_q, &self.tcp);
                    on.way.deviation(&state.target_q, &pose)
                }
                (None, Some(q)) => {
                    (0..6).fold(0.0, |m, j| f64::max(m, (state.target_q[j] - q[j]).abs()))
                }
                (None, None) => 0.0,
            };
            let most = if before.is_some() { PATH } else { 0.0 };
            if off > most {
                self.fault(
                    state,
                    format!("{off:e} off after a refusal of {:?}", sent.kind),
                );
            }
        }
    }

    fn on_path(&mut self, states: &[&RobotState], before: Option<&On>, on: &On) {
        for state in states {
            let q = &state.target_q;
            let pose = self.model.tcp_pose(q, &self.tcp);
            let mut off = on.way.deviation(q, &pose);
            let mut caps = vec![on.cap];
            if let Some(before) = before {
                let off_before = before.way.deviation(q, &pose);
                let from_corner = (pose.translation - before.end.translation).norm();
                if from_corner <= before.radius * (1.0 + 1e-9) {
                    off = 0.0;
                    caps.push(before.cap);
                } else if off_before <= off {
                    off = off_before;
                    caps = vec![before.cap];
                }
            }
            self.verdict.tally.path_max = self.verdict.tally.path_max.max(off);
            if off > PATH {
                self.fault(state, format!("{off:e} off the way"));
            }
            self.check_speed(state, &caps);
        }
    }

    /// No faster than asked; in a blend zone no faster than the faster of both.
    fn check_speed(&mut self, state: &RobotState, caps: &[Cap]) {
        let joint = caps.iter().try_fold(0.0, |most: f64, cap| match cap {
            Cap::Joint(v) => Some(most.max(*v)),
            _ => None,
        });
        let tcp = caps.iter().try_fold(0.0, |most: f64, cap| match cap {
            Cap::Tcp(v) => Some(most.max(*v)),
            _ => None,
        });
        for (name, speed, cap) in [
            ("the leading joint", state.target_qd.max_abs(), joint),
            ("the TCP", tcp_speed(state), tcp),
        ] {
            if let Some(cap) = cap
                && speed > cap * (1.0 + 1e-6) + 1e-9
            {
                self.fault(state, format!("{name} moves at {speed}, asked was {cap}"));
            }
        }
    }

    /// Once the arm stands after a motion that is done, it stands at the target.
    fn at_end(&mut self, sent: &Sent, states: &[&RobotState], on: &On) {
        if sent.outcome != Outcome::Done {
            return;
        }
        let stands = |s: &&&RobotState| s.target_qd == JointSpeeds::ZERO;
        let last = if on.radius > 0.0 {
            states.last().filter(stands)
        } else {
            states.iter().find(|s| s.cycle == sent.ended)
        };
        let Some(last) = last else { return };
        let (moved, turned) = distance(&self.model.tcp_pose(&last.target_q, &self.tcp), &on.end);
        let mut off = moved.max(turned);
        if let Way::Joint { to, .. } = &on.way {
            off = (0..6).fold(off, |m, j| m.max((last.target_q[j] - to[j]).abs()));
        }
        self.verdict.tally.end_max = self.verdict.tally.end_max.max(off);
        if off > END {
            self.fault(last, format!("{off:e} from the target of {:?}", sent.kind));
        }
    }

    fn on_belt(&mut self, sent: &Sent, states: &[&RobotState], before: Option<&On>, on: &On) {
        let Some(conveyor) = self.conveyor else {
            return;
        };
        self.verdict.tally.on_belts += 1;
        let caught_up = |s: &&&RobotState| s.time > BELT_START + CATCHING_UP;
        // A stop ends the motion and tracking alike.
        let last = sent.cut_short_after.unwrap_or(sent.ended);
        let is_moving = |s: &&&RobotState| s.cycle <= last && s.stop_code == 0;
        // A pause holds the arm; the belt goes on, and is caught up with afterwards.
        let step = self.run.bench.cycle.step_time();
        let cycles = |seconds: f64| (seconds / step) as u64;
        let pauses = &self.run.pauses;
        for (from, until) in pauses {
            for state in states.iter().filter(is_moving) {
                let is_held = (from + cycles(RESTING)..=*until).contains(&state.cycle);
                if is_held && state.target_qd != JointSpeeds::ZERO {
                    self.fault(state, "the arm moves in a pause".into());
                }
            }
        }
        // Joints that were braked, because motion and belt asked too much of them, stand although the belt goes on.
        let mut stood: Vec<u64> = Vec::new();
        for state in states.iter().filter(caught_up).filter(is_moving) {
            let is_new = stood.last().is_none_or(|last| state.cycle > last + 1);
            if state.target_qd == JointSpeeds::ZERO && is_new {
                stood.push(state.cycle);
            }
        }
        let goes_along = |s: &&&RobotState| {
            let is_behind = |(from, until): &(u64, u64)| {
                (*from..until + cycles(CATCHING_UP)).contains(&s.cycle)
            };
            let is_braked = |stood: &u64| {
                (stood.saturating_sub(cycles(BRAKING))..stood + cycles(CATCHING_UP))
                    .contains(&s.cycle)
            };
            !pauses.iter().any(is_behind) && !stood.iter().any(is_braked)
        };
        for state in states
            .iter()
            .filter(caught_up)
            .filter(is_moving)
            .filter(goes_along)
        {
            let pose = taken_back(
                &conveyor,
                state,
                &self.model.tcp_pose(&state.target_q, &self.tcp),
            );
            let mut off = on.way.off(&pose);
            if let Some(before) = before {
                let from_corner = (pose.translation - before.end.translation).norm();
                let off_before = before.way.off(&pose);
                if from_corner <= before.radius + BELT {
                    off = (0.0, 0.0);
                } else if off_before.0 <= off.0 {
                    off = off_before;
                }
            }
            self.verdict.tally.belt_max = self.verdict.tally.belt_max.max(off.0);
            if off.0 > BELT || off.1 > BELT_ANGLE {
                self.fault(state, format!("{off:?} off the way on the belt"));
            }
        }
    }

    fn remember_duration(&mut self, sent: &Sent, from: &JointPositions, from_rest: bool) {
        let CommandKind::Motion(MotionCommand::MoveJ {
            target,
            acceleration,
            speed,
            duration,
            radius,
        }) = sent.kind
        else {
            return;
        };
        let limits = &self.run.bench.limits;
        let is_plain = from_rest && duration == 0.0 && radius == 0.0 && !sent.is_disturbed;
        // Without limits of points; what the drives' torque takes away is told by warnings below the joints' own
        // limits.
        if !is_plain || limits.tcp_speed.is_finite() || sent.outcome != Outcome::Done {
            return;
        }
        let way: [f64; 6] = std::array::from_fn(|j| target[j] - from[j]);
        let lead = way.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if lead == 0.0 {
            return;
        }
        let (mut speed, mut acceleration) = (speed, acceleration);
        for (id, warning) in &self.run.bench.warnings {
            match warning {
                Warning::SpeedLimited { planned, .. } if *id == sent.id => speed = *planned,
                Warning::AccelerationLimited { planned, .. } if *id == sent.id => {
                    acceleration = *planned;
                }
                _ => {}
            }
        }
        let begun = self.run.bench.states.iter().rposition(|s| {
            s.cycle < sent.ended && s.target_q == *from && s.target_qd == JointSpeeds::ZERO
        });
        let Some(begun) = begun else { return };
        let cycles = sent.ended - self.run.bench.states[begun].cycle;
        self.verdict.tally.rest_to_rest.push(RestToRest {
            way,
            speed,
            acceleration,
            taken: cycles as f64 * self.run.bench.cycle.step_time(),
        });
    }

    fn fault(&mut self, state: &RobotState, text: String) {
        self.verdict
            .faults
            .push(format!("cycle {}: {text}", state.cycle));
    }
}

/// The pose without what the belt has added since it runs.
fn taken_back(conveyor: &Conveyor, state: &RobotState, pose: &Pose) -> Pose {
    let way = conveyor.speed * (state.time - BELT_START).max(0.0);
    match conveyor.kind {
        ConveyorKind::Linear { direction } => Pose::new(
            pose.rotation,
            pose.translation - direction.normalize() * way,
        ),
        ConveyorKind::Circular {
            center,
            rotate_tool,
        } => {
            let back = rotation_from_rotvec(Vector3::z() * -way);
            let rotation = if rotate_tool {
                back * pose.rotation
            } else {
                pose.rotation
            };
            Pose::new(rotation, center + back * (pose.translation - center))
        }
    }
}

fn tcp_speed(state: &RobotState) -> f64 {
    Vector3::from_row_slice(&state.target_tcp_speed[..3]).norm()
}

/// Blend radius, and the speed that is asked for when a motion is not planned by its duration.
fn asked(kind: &CommandKind) -> (f64, Cap) {
    match *kind {
        CommandKind::Motion(MotionCommand::MoveJ {
            speed,
            duration: 0.0,
            radius,
            ..
        }) => (radius, Cap::Joint(speed)),
        CommandKind::Motion(MotionCommand::MoveL {
            speed,
            duration: 0.0,
            radius,
            ..
        }) => (radius, Cap::Tcp(speed)),
        CommandKind::Motion(MotionCommand::MoveC { speed, radius, .. }) => {
            (radius, Cap::Tcp(speed))
        }
        // Its arc touches the lines there; what leads into it reaches half as far again (docs/motion.md).
        CommandKind::Motion(MotionCommand::MoveP { speed, radius, .. }) => {
            (1.5 * radius, Cap::Tcp(speed))
        }
        CommandKind::Motion(
            MotionCommand::MoveJ { radius, .. } | MotionCommand::MoveL { radius, .. },
        ) => (radius, Cap::None),
        _ => (0.0, Cap::None),
    }
}
