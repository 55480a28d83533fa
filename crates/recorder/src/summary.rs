//! What happened in a recording, in figures.

use std::collections::BTreeMap;

use kinematics::{DOF, JointLimits};
use messages::Text;
use motion_api::SafetyMode;

use crate::cycle::CycleMessage;
use crate::lengths::{NAME_BYTES, truncate_marked, truncate_middle_marked};
use crate::losses;
use crate::reader::{FileEnd, ReadError, Recording, RecordingEntry};
use crate::topics::{LogLevel, LogMessage, Topic};

/// A joint counts as being at its speed limit from this share of it on.
const AT_SPEED_LIMIT: f64 = 0.999;
/// A joint counts as being at its position limit within this distance, rad.
const AT_POSITION_LIMIT: f64 = 1e-3;
/// Events kept in full; more are only counted.
const MAX_LISTED: usize = 100;
/// Bytes of a message that is kept.
const LISTED_BYTES: usize = 4 << 10;

/// What happened in a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Cycles in the recording.
    pub cycles: u64,
    /// Cycles missing between the first and the last one.
    pub missing: u64,
    /// Cycles with a number that is not above the one before.
    pub out_of_order: u64,
    /// Messages of programs and registers that were dropped because the recording did not keep up.
    pub notes_missing: u64,
    /// Number of the first and the last cycle.
    pub cycle_range: Option<(u64, u64)>,
    /// Simulated time covered, s.
    pub duration: f64,
    /// Simulated time of the last cycle, s.
    pub end_time: f64,
    /// Length of one cycle, s.
    pub step_time: f64,
    /// Programs that were started: when (s) and their names, the first hundred.
    pub programs: Vec<(f64, String)>,
    /// Number of programs that were started.
    pub program_count: u64,
    /// Commands that entered the ring, by name.
    pub commands: BTreeMap<String, u64>,
    /// Messages that report an error, with their times (s), the first hundred.
    pub errors: Vec<(f64, LogMessage)>,
    /// Number of messages that report an error.
    pub error_count: u64,
    /// Number of messages that warn.
    pub warning_count: u64,
    /// Protective stops: when (s) and the number of the reason.
    pub stops: Vec<(f64, u64)>,
    /// Where limits of the arm were reached, the first hundred.
    pub limits: Vec<JointLimitEvent>,
    /// Number of times that limits of the arm were reached.
    pub limit_count: u64,
    /// Cycles that ended later than the next one was due, because they took long or because they began late: the same
    /// count as the clock's own.
    pub overruns: u64,
    /// The longest cycle, µs.
    pub longest_step_us: f64,
    /// The latest wake-up, µs.
    pub max_wakeup_latency_us: f64,
    /// Largest joint speeds of the arm, rad/s.
    pub peak_joint_speed: [f64; DOF],
    /// Largest joint torques the plant carried, Nm.
    pub peak_joint_torque: [f64; DOF],
    /// Largest speed of the TCP, m/s.
    pub peak_tcp_speed: f64,
    /// Largest force on the tool, N.
    pub peak_tcp_force: f64,
    /// How the recording ends.
    pub ending: Option<FileEnd>,
}

/// A commanded joint came to its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimitEvent {
    /// Time when the joint reached the limit, s.
    pub time: f64,
    /// The joint, from 0.
    pub joint: usize,
    /// Kind of limit that the joint reached.
    pub kind: LimitKind,
}

/// The limits of a joint that a summary looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// Speed.
    Speed,
    /// Position.
    Position,
}

impl Summary {
    /// Reads the whole recording. Without `limits`, limits of the arm are not looked at.
    ///
    /// # Errors
    /// [`ReadError`] when the file cannot be read or a message is not what its topic says.
    pub fn summarize(
        recording: &Recording,
        limits: Option<&JointLimits>,
    ) -> Result<Self, ReadError> {
        let topics = [Topic::Cycle, Topic::Command, Topic::Script, Topic::Log];
        let mut entries = recording.entries(&topics)?;
        let mut summary = Self::default();
        let mut progress = CycleTracker::default();
        for entry in &mut entries {
            let (time, entry) = entry?;
            match entry {
                RecordingEntry::Cycle(cycle) => summary.cycle(&cycle, limits, &mut progress),
                RecordingEntry::Command(command) => summary.command(command.name),
                RecordingEntry::Script(script) if script.text.is_some() => {
                    summary.program_count += 1;
                    let name = script.program;
                    let name = truncate_marked(&name, NAME_BYTES).unwrap_or(name);
                    list(&mut summary.programs, (time, name));
                }
                RecordingEntry::Log(log) => summary.log(time, log),
                RecordingEntry::Script(_) | RecordingEntry::Io(_) | RecordingEntry::Variable(_) => {
                }
            }
        }
        summary.overruns += u64::from(progress.last_overran());
        summary.ending = entries.ending().cloned();
        Ok(summary)
    }

    fn cycle(
        &mut self,
        cycle: &CycleMessage,
        limits: Option<&JointLimits>,
        progress: &mut CycleTracker,
    ) {
        let first = self.cycle_range.map_or(cycle.cycle, |(first, _)| first);
        if let Some((_, last)) = self.cycle_range {
            let expected = last.saturating_add(1);
            let missing = cycle.cycle.saturating_sub(expected);
            self.missing = self.missing.saturating_add(missing);
            self.out_of_order += u64::from(cycle.cycle < expected);
        } else {
            progress.begin = cycle.time - cycle.step_time;
        }
        self.cycle_range = Some((first, cycle.cycle));
        self.cycles += 1;
        self.duration = cycle.time - progress.begin;
        self.end_time = cycle.time;
        self.step_time = cycle.step_time;
        self.overruns += u64::from(progress.overran(cycle));
        update_peak(&mut self.longest_step_us, cycle.step_duration_us);
        update_peak(&mut self.max_wakeup_latency_us, cycle.wakeup_latency_us);
        for (peak, speed) in self.peak_joint_speed.iter_mut().zip(&cycle.actual_qd) {
            update_peak(peak, speed.abs());
        }
        for (peak, torque) in self.peak_joint_torque.iter_mut().zip(&cycle.actual_torque) {
            update_peak(peak, torque.abs());
        }
        update_peak(&mut self.peak_tcp_speed, length(&cycle.actual_tcp_speed));
        update_peak(&mut self.peak_tcp_force, length(&cycle.tcp_force));
        let stopped = cycle.safety_mode == SafetyMode::ProtectiveStop.number() as u32;
        if stopped && !progress.stopped {
            list(&mut self.stops, (cycle.time, cycle.stop_code));
        }
        progress.stopped = stopped;
        if let Some(limits) = limits {
            self.limits(cycle, limits, progress);
        }
    }

    fn limits(&mut self, cycle: &CycleMessage, limits: &JointLimits, progress: &mut CycleTracker) {
        let joints = cycle.target_q.iter().zip(&cycle.target_qd);
        for (joint, (&position, &speed)) in joints.enumerate().take(DOF) {
            let at_speed = speed.abs() >= AT_SPEED_LIMIT * limits.speed[joint];
            let at_position = position >= limits.position_max[joint] - AT_POSITION_LIMIT
                || position <= limits.position_min[joint] + AT_POSITION_LIMIT;
            for (kind, now, before) in [
                (LimitKind::Speed, at_speed, &mut progress.at_speed[joint]),
                (
                    LimitKind::Position,
                    at_position,
                    &mut progress.at_position[joint],
                ),
            ] {
                if now && !*before {
                    self.limit_count += 1;
                    let time = cycle.time;
                    list(&mut self.limits, JointLimitEvent { time, joint, kind });
                }
                *before = now;
            }
        }
    }

    fn command(&mut self, name: String) {
        let is_new = !self.commands.contains_key(&name);
        let name = match is_new && self.commands.len() >= MAX_LISTED {
            true => "other".to_owned(),
            false => truncate_marked(&name, NAME_BYTES).unwrap_or(name),
        };
        *self.commands.entry(name).or_default() += 1;
    }

    fn log(&mut self, time: f64, mut log: LogMessage) {
        // A hundred long ones would be much to keep.
        if let Some(short) = truncate_marked(&log.source, LISTED_BYTES) {
            log.source = short;
        }
        // The last line of a report says what happened.
        let short = |text: &str| {
            truncate_middle_marked(text, LISTED_BYTES).unwrap_or_else(|| text.to_owned())
        };
        let chinese = log.message.other_chinese().map(short);
        log.message = Text::recorded(short(log.message.english()), chinese);
        if log.level >= LogLevel::Error {
            self.error_count += 1;
            list(&mut self.errors, (time, log));
        } else if log.level == LogLevel::Warning {
            self.warning_count += 1;
            let dropped = losses::parse_annotations_lost(&log.source, &log.message);
            self.notes_missing = self.notes_missing.saturating_add(dropped);
        }
    }
}

/// What the next cycle is compared with.
#[derive(Default)]
struct CycleTracker {
    begin: f64,
    /// How late the cycle before began, µs, and how long a cycle may take.
    late_us: f64,
    step_us: f64,
    stopped: bool,
    at_speed: [bool; DOF],
    at_position: [bool; DOF],
}

impl CycleTracker {
    /// Whether the cycle before this one overran: a record tells how late its own cycle began and how long the one
    /// before took.
    fn overran(&mut self, cycle: &CycleMessage) -> bool {
        let overran = self.late_us + cycle.step_duration_us > cycle.step_time * 1e6;
        self.late_us = cycle.wakeup_latency_us;
        self.step_us = cycle.step_time * 1e6;
        overran
    }

    /// Whether the last cycle overran, as far as is known: how long it took is in no record.
    fn last_overran(&self) -> bool {
        self.late_us > self.step_us
    }
}

fn list<T>(items: &mut Vec<T>, item: T) {
    if items.len() < MAX_LISTED {
        items.push(item);
    }
}

fn update_peak(peak: &mut f64, value: f64) {
    if value > *peak {
        *peak = value;
    }
}

/// Length of the linear part of a six-vector.
fn length(linear_angular: &[f64]) -> f64 {
    let linear = linear_angular.iter().take(3);
    linear.map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the clock counts, from what the records tell: each its own wake-up and the duration of the cycle before.
    #[test]
    fn a_cycle_that_began_late_or_took_long_is_an_overrun_once() {
        // (late, took), µs, of cycles of 4 ms
        let cycles = [
            (0.0, 3900.0),
            (200.0, 3900.0),
            (10_000.0, 50.0),
            (3900.0, 50.0),
            (0.0, 4100.0),
            (0.0, 10.0),
            (4500.0, 0.0),
        ];
        let mut summary = Summary::default();
        let mut progress = CycleTracker::default();
        let mut took_before = 0.0;
        for (number, (late, took)) in cycles.into_iter().enumerate() {
            let cycle = CycleMessage {
                cycle: number as u64 + 1,
                step_time: 0.004,
                step_duration_us: took_before,
                wakeup_latency_us: late,
                ..CycleMessage::default()
            };
            took_before = took;
            summary.cycle(&cycle, None, &mut progress);
        }
        summary.overruns += u64::from(progress.last_overran());
        let overran = |&&(late, took): &&(f64, f64)| late + took > 4000.0;
        assert_eq!(
            summary.overruns,
            cycles.iter().filter(overran).count() as u64
        );
        assert_eq!(summary.overruns, 4);
    }
}
