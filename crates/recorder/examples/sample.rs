//! Writes a recording of an arm that goes back and forth, and prints what it costs.
//!
//!     cargo run --release -p recorder --example sample -- OUT.mcap [SECONDS]
//!
//! The arm follows smooth curves made up here (no planner, no plant), with a little noise on the actual values so that
//! the size of the file is that of a real one.

use std::path::PathBuf;
use std::time::Instant;

use kinematics::{
    DOF, JointAccelerations, JointPositions, JointSpeeds, JointTorques, Payload, Pose, RobotModel,
};
use motion_api::{
    Command, CommandId, CommandKind, MotionCommand, MotionMode, Origin, ProgramId, Record,
    RingCapacities, RobotState, ThreadNumber, motion_channel,
};
use nalgebra::Vector3;
use recorder::{LogLevel, Recorder, RecorderConfig, Setup};

const STEP: f64 = 0.004;
const GRAVITY: f64 = -9.81;
const PROGRAM: ProgramId = ProgramId(1);

/// Cycles of one movement and of the pause after it.
const MOVE: u64 = 400;
const PAUSE: u64 = 75;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path: PathBuf = arguments
        .next()
        .ok_or("usage: sample OUT.mcap [SECONDS]")?
        .into();
    let seconds: f64 = arguments.next().map_or(Ok(20.0), |text| text.parse())?;
    let cycles = (seconds / STEP).round() as u64;

    let setup = Setup::default();
    let arm = Arm::new(RobotModel::built_in(&setup.model)?, setup.home);
    let config = RecorderConfig {
        path: path.clone(),
        setup,
        model: arm.model.clone(),
        obstacles: Vec::new(),
        extra: Vec::new(),
        rotation: recorder::Rotation::default(),
        notes_wait: true,
        patience: std::time::Duration::from_secs(60),
        on_failure: Box::new(|_| ()),
    };
    let (mut motion, mut script) = motion_channel(RingCapacities::default(), &arm.state(0));
    let records = script.records.take().ok_or("the border has no records")?;
    let mut ring = motion.records.take().ok_or("the border has no records")?;

    let begin = Instant::now();
    let (recorder, handle) = Recorder::start(config, records)?;
    handle.program_started(0.0, PROGRAM, "sample.script", SCRIPT);
    let mut making = std::time::Duration::ZERO;
    for cycle in 1..=cycles {
        let making_since = Instant::now();
        let state = arm.state(cycle);
        making += making_since.elapsed();
        let mut due = Vec::new();
        if (cycle - 1) % (MOVE + PAUSE) == 0 {
            let number = (cycle - 1) / (MOVE + PAUSE);
            let line = 2 + (number % 2) as u32;
            handle.script_line(state.time - STEP, PROGRAM, ThreadNumber(0), line);
            due.push(arm.command(number, cycle, line));
        }
        due.push(Record::Cycle(state));
        for mut record in due {
            while let Err(rtrb::PushError::Full(back)) = ring.push(record) {
                record = back;
                std::thread::yield_now();
            }
        }
    }
    handle.log(
        seconds,
        LogLevel::Warning,
        "motion",
        &messages::Text::verbatim(
            "an acceleration of 9.0000 is more than the joints can do here, it is limited to 4.0000",
        ),
    );
    drop(ring);
    let totals = recorder.finish()?;
    let took = begin.elapsed() - making;
    let size = std::fs::metadata(&path)?.len();
    println!(
        "{} cycles: {:.2} µs and {:.0} bytes each, {:.1} MB a minute",
        totals.cycles,
        took.as_secs_f64() * 1e6 / totals.cycles as f64,
        size as f64 / totals.cycles as f64,
        size as f64 / 1e6 / (seconds / 60.0),
    );
    Ok(())
}

const SCRIPT: &str = "while True:\n    movej([0.8, -1.2, 1.2, -1.6, -1.6, 0.5])\n    \
    movej([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0])\nend\n";

struct Arm {
    model: RobotModel,
    ends: [JointPositions; 2],
}

impl Arm {
    fn new(model: RobotModel, home: JointPositions) -> Self {
        let away = JointPositions([0.8, -1.2, 1.2, -1.6, -1.6, 0.5]);
        Self {
            model,
            ends: [home, away],
        }
    }

    fn command(&self, number: u64, cycle: u64, line: u32) -> Record {
        Record::Command {
            cycle,
            command: Command {
                id: CommandId(number + 1),
                origin: Origin {
                    program: PROGRAM,
                    thread: ThreadNumber(0),
                    line,
                },
                kind: CommandKind::Motion(MotionCommand::MoveJ {
                    target: self.ends[(1 - number % 2) as usize],
                    acceleration: 1.4,
                    speed: 1.05,
                    duration: 0.0,
                    radius: 0.0,
                }),
            },
        }
    }

    /// A movement is a polynomial of degree five from one end to the other.
    fn state(&self, cycle: u64) -> RobotState {
        let (number, since) = (cycle / (MOVE + PAUSE), cycle % (MOVE + PAUSE));
        let (from, to) = (
            self.ends[(number % 2) as usize],
            self.ends[(1 - number % 2) as usize],
        );
        let moving = since > 0 && since < MOVE;
        let u = (since as f64 / MOVE as f64).min(1.0);
        let rate = 1.0 / (MOVE as f64 * STEP);
        let s = u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
        let sd = 30.0 * (u * (1.0 - u)).powi(2) * rate;
        let sdd = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) * rate * rate;
        let along = |k: f64| -> [f64; DOF] { std::array::from_fn(|i| (to[i] - from[i]) * k) };
        let q = JointPositions(std::array::from_fn(|i| from[i] + along(s)[i]));
        let (qd, qdd) = (JointSpeeds(along(sd)), JointAccelerations(along(sdd)));

        let mut noise = Noise(cycle);
        let actual_q = q.map(|x| x + 2e-5 * noise.next());
        let actual_qd = qd.map(|x| x + 1e-3 * noise.next());
        let gravity = Vector3::new(0.0, 0.0, GRAVITY);
        let dynamics = self.model.dynamics(&Payload::default(), gravity);
        let torque = dynamics.inverse_dynamics(&q, &qd, &qdd);
        let actual_torque = JointTorques(torque.0.map(|x| x + 0.2 * noise.next()));
        let (frames, actual) = (self.model.forward(&q), self.model.forward(&actual_q));
        let speed = frames.twist(&qd, frames.base_from_flange.translation);
        let actual_speed = actual.twist(&actual_qd, actual.base_from_flange.translation);
        RobotState {
            cycle,
            time: cycle as f64 * STEP,
            target_q: q,
            target_qd: qd,
            target_qdd: qdd,
            actual_q,
            actual_qd,
            target_torque: torque,
            actual_torque,
            target_tcp_pose: Pose::to_rpy(&frames.base_from_flange),
            actual_tcp_pose: Pose::to_rpy(&actual.base_from_flange),
            target_tcp_speed: speed.to_array(),
            actual_tcp_speed: actual_speed.to_array(),
            tcp_force: std::array::from_fn(|_| 0.3 * noise.next()),
            elbow_position: actual.elbow().into(),
            motion_mode: if moving {
                MotionMode::MoveJ
            } else {
                MotionMode::Idle
            },
            command_id: CommandId(if moving { number + 1 } else { 0 }),
            ..RobotState::at_start(q, STEP)
        }
    }
}

/// Numbers between -1 and 1 from a counter (splitmix64).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
    }
}
