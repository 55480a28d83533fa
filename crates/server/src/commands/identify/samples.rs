//! What a recording says about an arm: samples of its motion, and its rests.

use std::path::Path;

use controller::recorded_run::model_of;
use kinematics::{
    DOF, GRAVITY_UPRIGHT, JointAccelerations, JointPositions, JointSpeeds, JointTorques, Pose,
    RobotModel, RpyPose,
};
use messages::text;
use nalgebra::Vector3;
use recorder::cycle::CycleMessage;
use recorder::{ReadError, Recording};

use super::IdentifyError;

/// Joints that turn slower rest, rad/s.
const REST_SPEED_RAD_S: f64 = 1e-3;
/// Shorter rests are moments between motions, s.
const REST_MIN_S: f64 = 0.2;
/// Postures of two rests that are one differ by less, rad.
const REST_DIFFERENCE_RAD: f64 = 1e-3;
/// Cycles of all files at most: a day.
const SAMPLES_MAX: usize = 22_000_000;

/// A moment of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Since the begin of its recording, s.
    pub time: f64,
    pub q: JointPositions,
    pub qd: JointSpeeds,
    pub qdd: JointAccelerations,
    /// What the joints carry.
    pub torque: JointTorques,
    /// Force and moment of the sensor in the TCP frame, payload included, about the TCP.
    pub wrench: [f64; 6],
    pub flange_from_tcp: Pose,
    pub gravity: Vector3<f64>,
}

/// An interval in which the arm stands still, with the mean of its samples.
#[derive(Clone, Copy, Debug)]
pub struct RestInterval {
    /// Middle of the interval, s.
    pub time: f64,
    /// Length of the interval, s.
    pub duration: f64,
    pub q: JointPositions,
    pub wrench: [f64; 6],
    pub flange_from_tcp: Pose,
    pub gravity: Vector3<f64>,
    pub count: usize,
}

/// Recordings of one arm.
pub struct Samples {
    /// The arm without tool and payload.
    pub model: RobotModel,
    /// Of all files, in order.
    pub samples: Vec<Sample>,
    /// Where a file begins, in `samples`.
    pub begins: Vec<usize>,
}

impl Samples {
    /// Reads recordings; a file that is cut is used up to the cut.
    pub fn read(
        files: &[impl AsRef<Path>],
        from: Option<f64>,
        to: Option<f64>,
    ) -> Result<Self, IdentifyError> {
        let mut model: Option<RobotModel> = None;
        let mut samples: Vec<Sample> = Vec::new();
        let mut begins = Vec::new();
        for file in files {
            let recording = Recording::open(file)?;
            if model.is_none() {
                let setup = recording
                    .setup()
                    .ok_or_else(|| IdentifyError::NoSetup(recording.name().to_owned()))?;
                model = Some(model_of(setup)?);
            }
            begins.push(samples.len());
            for cycle in recording.cycles()? {
                let cycle = cycle?;
                let is_wanted = from.is_none_or(|from| cycle.time >= from)
                    && to.is_none_or(|to| cycle.time <= to);
                if let (true, Some(sample)) = (is_wanted, sample(&cycle)) {
                    samples.push(sample);
                    if samples.len() > SAMPLES_MAX {
                        return Err(IdentifyError::CannotTell(text!(
                            "the recordings have more than {SAMPLES_MAX} cycles: use --from and --to",
                            "记录超过 {SAMPLES_MAX} 个周期：请用 --from 和 --to"
                        )));
                    }
                }
            }
        }
        let Some(model) = model else {
            return Err(IdentifyError::CannotTell(text!(
                "there is no recording",
                "没有记录"
            )));
        };
        Self::of(model, samples, begins)
    }

    /// Samples of cycles that are in memory, of an arm that is known.
    ///
    /// # Errors
    /// No cycle has joint positions.
    pub fn of_cycles(
        model: RobotModel,
        cycles: impl IntoIterator<Item = CycleMessage>,
    ) -> Result<Self, IdentifyError> {
        let samples = cycles.into_iter().filter_map(|cycle| sample(&cycle));
        Self::of(model, samples.collect(), vec![0])
    }

    fn of(
        model: RobotModel,
        samples: Vec<Sample>,
        begins: Vec<usize>,
    ) -> Result<Self, IdentifyError> {
        if samples.is_empty() {
            let text = text!(
                "the recordings hold no joint positions in this time",
                "这段时间的记录中没有关节位置"
            );
            return Err(IdentifyError::CannotTell(text));
        }
        Ok(Self {
            model,
            samples,
            begins,
        })
    }

    /// The samples before and after one, of the same recording.
    pub fn neighbours(&self, index: usize) -> Option<(&Sample, &Sample)> {
        let begins = |number: usize| self.begins.binary_search(&number).is_ok();
        if begins(index) || begins(index + 1) {
            return None;
        }
        let before = self.samples.get(index.checked_sub(1)?)?;
        Some((before, self.samples.get(index + 1)?))
    }

    /// The rests, in order.
    pub fn rests(&self) -> Vec<RestInterval> {
        let mut rests: Vec<RestInterval> = Vec::new();
        let mut open: Vec<Sample> = Vec::new();
        for (index, sample) in self.samples.iter().enumerate() {
            let is_still = sample
                .qd
                .0
                .iter()
                .all(|speed| speed.abs() < REST_SPEED_RAD_S);
            let is_same = open.first().is_none_or(|first| {
                let pairs = first.q.0.iter().zip(sample.q.0);
                pairs
                    .into_iter()
                    .all(|(a, b)| (a - b).abs() < REST_DIFFERENCE_RAD)
            });
            if !is_still || !is_same || self.begins.contains(&index) {
                rests.extend(rest_of(&open));
                open.clear();
            }
            if is_still {
                open.push(*sample);
            }
        }
        rests.extend(rest_of(&open));
        rests
    }

    /// The rests at these times, or every rest.
    pub fn chosen_rests(&self, at: &[f64]) -> Result<Vec<RestInterval>, IdentifyError> {
        let rests = self.rests();
        if at.is_empty() {
            return Ok(rests);
        }
        at.iter()
            .map(|time| {
                let found = rests
                    .iter()
                    .find(|rest| (rest.time - time).abs() <= rest.duration / 2.0 + 0.01);
                found.copied().ok_or_else(|| {
                    IdentifyError::CannotTell(text!(
                        "the arm does not rest at {time} s",
                        "机械臂在 {time} s 时没有静止"
                    ))
                })
            })
            .collect()
    }

    /// Poses of the flange at rests.
    pub fn flange_poses(&self, rests: &[RestInterval]) -> Vec<Pose> {
        rests
            .iter()
            .map(|rest| self.model.flange_pose(&rest.q))
            .collect()
    }
}

fn rest_of(samples: &[Sample]) -> Option<RestInterval> {
    let (first, last) = (samples.first()?, samples.last()?);
    let duration = last.time - first.time;
    if duration < REST_MIN_S {
        return None;
    }
    // The first tenth of a second may still swing.
    let settled: Vec<&Sample> = samples
        .iter()
        .filter(|sample| sample.time >= first.time + 0.1)
        .collect();
    let count = settled.len() as f64;
    let mean = |part: &dyn Fn(&Sample) -> f64| settled.iter().map(|s| part(s)).sum::<f64>() / count;
    Some(RestInterval {
        time: f64::midpoint(first.time, last.time),
        duration,
        q: JointPositions(core::array::from_fn(|joint| mean(&|s| s.q[joint]))),
        wrench: core::array::from_fn(|axis| mean(&|s| s.wrench[axis])),
        flange_from_tcp: first.flange_from_tcp,
        gravity: first.gravity,
        count: settled.len(),
    })
}

fn six(values: &[f64]) -> Option<[f64; DOF]> {
    values.try_into().ok()
}

/// None where the arm's positions are not known.
fn sample(cycle: &CycleMessage) -> Option<Sample> {
    let q = six(&cycle.actual_q).filter(|q| q.iter().all(|x| x.is_finite()))?;
    let or_zero = |values: &[f64]| {
        six(values)
            .filter(|values| values.iter().all(|x| x.is_finite()))
            .unwrap_or_default()
    };
    let or_nan = |values: &[f64]| six(values).unwrap_or([f64::NAN; DOF]);
    let tcp = or_zero(&cycle.tcp_offset);
    let gravity = <[f64; 3]>::try_from(&cycle.gravity[..])
        .ok()
        .filter(|g| g.iter().all(|x| x.is_finite()))
        .map_or(GRAVITY_UPRIGHT, Vector3::from);
    Some(Sample {
        time: cycle.time,
        q: JointPositions(q),
        qd: JointSpeeds(or_zero(&cycle.actual_qd)),
        qdd: JointAccelerations(or_zero(&cycle.target_qdd)),
        torque: JointTorques(or_nan(&cycle.actual_torque)),
        wrench: or_nan(&cycle.raw_wrench),
        flange_from_tcp: Pose::from_rpy(&RpyPose::from_array(tcp)),
        gravity,
    })
}

impl From<ReadError> for IdentifyError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}
