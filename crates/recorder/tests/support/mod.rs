//! Makes recordings for tests: states, outputs that can be looked at or that fail, and the way through the real thread.
#![allow(dead_code, reason = "every test file uses its own part")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::{self, Write};
use std::sync::Arc;

use kinematics::{
    JointAccelerations, JointPositions, JointSpeeds, JointTorques, Payload, RobotModel, RpyPose,
};
use motion_api::{
    Command, CommandId, CommandKind, IoConfig, MotionCommand, MotionEndpoint, MotionMode, Origin,
    ProgramId, Record, RingCapacities, RobotMode, RobotState, SafetyMode, ScriptEndpoint,
    ThreadNumber, motion_channel,
};
use parking_lot::Mutex;
use recorder::{Recorder, RecorderConfig, RecorderHandle, Setup};

pub const STEP: f64 = 0.004;

/// A state that moves smoothly with the cycle, every field another value.
pub fn state(cycle: u64) -> RobotState {
    let t = cycle as f64 * STEP;
    let wave = |k: f64| std::array::from_fn(|i| k * (t * (1.0 + 0.1 * i as f64) + k).sin());
    RobotState {
        cycle,
        time: t,
        target_q: JointPositions(wave(1.0)),
        target_qd: JointSpeeds(wave(0.9)),
        target_qdd: JointAccelerations(wave(0.8)),
        actual_q: JointPositions(wave(1.001)),
        actual_qd: JointSpeeds(wave(0.901)),
        target_torque: JointTorques(wave(50.0)),
        actual_torque: JointTorques(wave(51.0)),
        target_tcp_pose: RpyPose::from_array(wave(0.5)),
        actual_tcp_pose: RpyPose::from_array(wave(0.501)),
        target_tcp_speed: wave(0.25),
        actual_tcp_speed: wave(0.251),
        tcp_force: wave(3.0),
        raw_wrench: wave(3.5),
        motion_mode: MotionMode::MoveJ,
        command_id: CommandId(cycle / 250 + 1),
        ..RobotState::at_start(JointPositions::ZERO, STEP)
    }
}

pub fn command(id: u64, cycle: u64, kind: CommandKind) -> Record {
    let origin = Origin {
        program: ProgramId(1),
        thread: ThreadNumber(0),
        line: 7,
    };
    Record::Command {
        cycle,
        command: Command {
            id: CommandId(id),
            origin,
            kind,
        },
    }
}

pub fn movej(x: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveJ {
        target: JointPositions([x; 6]),
        acceleration: 1.4,
        speed: 1.05,
        duration: 0.0,
        radius: 0.0,
    })
}

/// Bytes that many can look at while they are written.
#[derive(Clone, Default)]
pub struct Shared(pub Arc<Mutex<Vec<u8>>>);

impl Shared {
    pub fn bytes(&self) -> Vec<u8> {
        self.0.lock().clone()
    }
}

impl Write for Shared {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        self.0.lock().extend_from_slice(data);
        Ok(data.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Takes some bytes, then has no room any more.
pub struct SmallDisk {
    pub room: usize,
}

impl Write for SmallDisk {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        if self.room == 0 {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        let taken = data.len().min(self.room);
        self.room -= taken;
        Ok(taken)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

pub fn model() -> RobotModel {
    RobotModel::built_in("cs66").unwrap()
}

pub fn config() -> RecorderConfig {
    RecorderConfig {
        path: "test.mcap".into(),
        setup: Setup::default(),
        model: model(),
        obstacles: Vec::new(),
        extra: Vec::new(),
        rotation: recorder::Rotation::default(),
        notes_wait: true,
        patience: std::time::Duration::from_secs(60),
        on_failure: Box::new(|_| ()),
    }
}

/// The rings and a recorder that writes into `out`.
pub fn start(
    out: impl Write + Send + 'static,
    config: RecorderConfig,
) -> (MotionEndpoint, ScriptEndpoint, Recorder, RecorderHandle) {
    let sizes = RingCapacities {
        records: Some(4096),
        ..RingCapacities::default()
    };
    let (motion, mut script) =
        motion_channel(sizes, &RobotState::at_start(JointPositions::ZERO, STEP));
    let records = script.records.take().unwrap();
    let (recorder, handle) = Recorder::start_on(out, config, records).unwrap();
    (motion, script, recorder, handle)
}

/// Puts a record into the ring, waiting for room as the virtual clock does.
pub fn push(motion: &mut MotionEndpoint, mut record: Record) {
    let ring = motion.records.as_mut().unwrap();
    while let Err(rtrb_full) = ring.push(record) {
        let rtrb::PushError::Full(back) = rtrb_full;
        record = back;
        std::thread::yield_now();
    }
}

/// Records states through the real thread and returns the file.
pub fn record(records: impl IntoIterator<Item = Record>) -> Vec<u8> {
    let out = Shared::default();
    let (mut motion, _script, recorder, _handle) = start(out.clone(), config());
    for record in records {
        push(&mut motion, record);
    }
    drop(motion);
    recorder.finish().unwrap();
    out.bytes()
}

/// As `CycleMessage`, any finite values.
pub mod any {
    use super::*;
    use proptest::prelude::*;

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => -1e3..1e3,
            1 => proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO,
        ]
    }

    fn six() -> impl Strategy<Value = [f64; 6]> {
        proptest::array::uniform6(number())
    }

    /// A state of the given cycle.
    pub fn state(cycle: u64) -> impl Strategy<Value = RobotState> {
        let joints = (six(), six(), six(), six(), six(), six(), six());
        let cartesian = (six(), six(), six(), six(), six(), six());
        let rest = (
            proptest::array::uniform3(number()),
            proptest::array::uniform10(number()),
            0_i32..7,
            any::<u64>(),
            -1_i32..10,
            1_i32..12,
        );
        let io = (
            any::<u64>(),
            any::<u64>(),
            proptest::array::uniform3(number()),
            proptest::array::uniform3(number()),
            any::<u64>(),
            any::<u64>(),
        );
        (joints, cartesian, rest, io).prop_map(move |(j, c, r, io)| RobotState {
            cycle,
            time: cycle as f64 * STEP,
            step_time: STEP,
            target_q: JointPositions(j.0),
            target_qd: JointSpeeds(j.1),
            target_qdd: JointAccelerations(j.2),
            actual_q: JointPositions(j.3),
            actual_qd: JointSpeeds(j.4),
            target_torque: JointTorques(j.5),
            actual_torque: JointTorques(j.6),
            target_tcp_pose: RpyPose::from_array(c.0),
            actual_tcp_pose: RpyPose::from_array(c.1),
            target_tcp_speed: c.2,
            actual_tcp_speed: c.3,
            tcp_force: c.4,
            raw_wrench: c.2,
            tcp_offset: RpyPose::from_array(c.5),
            elbow_position: r.0,
            payload: Payload {
                mass: r.1[0],
                cog: [r.1[1], r.1[2], r.1[3]].into(),
                inertia: std::array::from_fn(|i| r.1[4 + i]),
            },
            motion_mode: MotionMode::from_number(r.2),
            command_id: CommandId(r.3),
            target_speed_fraction: r.0[0],
            speed_scaling: r.0[1],
            robot_mode: RobotMode::from_number(r.4),
            safety_mode: SafetyMode::from_number(r.5),
            stop_code: io.4,
            digital_in: io.0,
            digital_out: io.1,
            analog_in: io.2,
            analog_out: io.3,
            io_config: IoConfig::from_bits(io.4 & 0x0000_0018_0733_7F3F),
            records_lost: io.5,
            step_duration_us: r.0[2],
            wakeup_latency_us: r.1[9],
            external_torque: JointTorques(j.1),
            joint_temperatures: j.2,
            controller_temperature: r.1[8],
            target_waypoint: RpyPose::from_array(c.3),
            gravity: r.0,
            encoder_counts: [r.1[7], r.1[6]],
            encoder_ranges: [io.1 % 5, io.0 % 5],
            collision_detection: io.1 % 2 == 1,
            collision_sensitivity: io.0 % 101,
            force_mode: io.1 % 3 == 1,
            path_pose: RpyPose::from_array(c.1),
            path_offsets: [c.0, c.4, c.5],
        })
    }
}

/// A disk that writes at a rate and stands still now and then, as a worn card does.
pub struct SlowDisk<W> {
    pub out: W,
    pub bytes_per_sec: f64,
    /// It stands still so often and so long.
    pub stall_every: std::time::Duration,
    pub stall: std::time::Duration,
    pub last_stall: std::time::Instant,
    pub stalls: Arc<std::sync::atomic::AtomicU64>,
}

impl<W: Write> Write for SlowDisk<W> {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let secs = data.len() as f64 / self.bytes_per_sec;
        std::thread::sleep(std::time::Duration::from_secs_f64(secs));
        if self.last_stall.elapsed() >= self.stall_every {
            std::thread::sleep(self.stall);
            self.stalls
                .fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            self.last_stall = std::time::Instant::now();
        }
        self.out.write(data)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// What recording onto a slow disk did to the thread that makes the cycles.
#[derive(Debug)]
pub struct SlowRun {
    pub cycles: u64,
    /// Records that the ring did not take.
    pub lost: u64,
    pub stalls: u64,
    /// Times that the thread spent for the recording in each cycle, sorted.
    pub costs: Vec<std::time::Duration>,
    pub file: Vec<u8>,
}

/// Makes cycles at 250 Hz for `secs` of simulated time, `times` as fast as that, and records them onto a disk of
/// 400 kB/s that stands still for 2 s in every 10 s, `times` as fast too. As the motion thread does, nobody waits.
pub fn record_onto_a_slow_disk(secs: f64, times: f64) -> SlowRun {
    use std::time::{Duration, Instant};
    let out = Shared::default();
    let stalls = Arc::default();
    let disk = SlowDisk {
        out: out.clone(),
        bytes_per_sec: 400_000.0 * times,
        stall_every: Duration::from_secs_f64(8.0 / times),
        stall: Duration::from_secs_f64(2.0 / times),
        last_stall: Instant::now(),
        stalls: Arc::clone(&stalls),
    };
    let config = RecorderConfig {
        notes_wait: false,
        patience: std::time::Duration::from_secs(60),
        ..config()
    };
    let (mut motion, _script, recorder, _handle) = start(disk, config);
    let ring = motion.records.as_mut().unwrap();
    let (cycles, mut lost) = ((secs / STEP) as u64, 0);
    let mut costs = Vec::with_capacity(cycles as usize);
    let begin = Instant::now();
    for cycle in 1..=cycles {
        let due = begin + Duration::from_secs_f64(cycle as f64 * STEP / times);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        let record = Record::Cycle(state(cycle));
        let before = Instant::now();
        lost += u64::from(ring.push(record).is_err());
        costs.push(before.elapsed());
    }
    drop(motion);
    let totals = recorder.finish().unwrap();
    assert_eq!(totals.cycles + lost, cycles);
    costs.sort_unstable();
    SlowRun {
        cycles,
        lost,
        stalls: stalls.load(std::sync::atomic::Ordering::Relaxed),
        costs,
        file: out.bytes(),
    }
}
