//! A recording as what is compared of it: joints, TCP, speed and force over time.

use messages::Localized;
use nalgebra::{UnitQuaternion, Vector3};
use recorder::{CycleMessage, ReadError, Recording};
use thiserror::Error;

use kinematics::{Pose, RpyPose};

/// A recording that cannot be compared.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum RunTraceError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recording has no cycles.
    #[error("there is nothing to compare: {name} has no cycles")]
    #[zh("没有可比较的内容：{name} 没有控制周期")]
    Empty {
        /// Name of the recording.
        name: String,
    },
}

/// One moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceSample {
    /// Time of the sample, s.
    pub time: f64,
    /// Positions of the joints, rad.
    pub q: [f64; 6],
    /// Place of the TCP in the base frame, m.
    pub position: Vector3<f64>,
    /// Orientation of the TCP in the base frame; the identity where it is not known.
    pub rotation: UnitQuaternion<f64>,
    /// Speed of the TCP, m/s.
    pub speed: f64,
    /// Force at the TCP, N.
    pub force: Vector3<f64>,
}

/// A run over time. Times grow.
#[derive(Clone, Debug, Default)]
pub struct RunTrace {
    samples: Vec<TraceSample>,
}

/// Where a walk along a track is, so that the next moment is found from there.
#[derive(Clone, Copy, Debug, Default)]
pub struct TraceCursor(usize);

impl RunTrace {
    /// Reads the cycles of a recording.
    ///
    /// # Errors
    /// [`RunTraceError`]
    pub fn read(recording: &Recording) -> Result<Self, RunTraceError> {
        let mut track = Self::default();
        for cycle in recording.cycles()? {
            track.push(sample(&cycle?));
        }
        if track.samples.is_empty() {
            let name = recording.name().to_owned();
            return Err(RunTraceError::Empty { name });
        }
        Ok(track)
    }

    /// Adds a moment; one that is not after the last is left out, as files may say anything.
    pub fn push(&mut self, sample: TraceSample) {
        let last = self
            .samples
            .last()
            .map_or(f64::NEG_INFINITY, |last| last.time);
        if sample.time.is_finite() && sample.time > last {
            self.samples.push(sample);
        }
    }

    /// The samples of the run in the order of time.
    pub fn samples(&self) -> impl ExactSizeIterator<Item = &TraceSample> {
        self.samples.iter()
    }

    /// The state at a moment, between its neighbours; `None` before the first and after the last.
    pub fn at(&self, time: f64, place: &mut TraceCursor) -> Option<TraceSample> {
        let all = &self.samples;
        let is_after = |index: usize| all.get(index).is_some_and(|sample| sample.time > time);
        // Walks go forward; whoever goes back begins anew.
        if place.0 > 0 && is_after(place.0) {
            place.0 = all
                .partition_point(|sample| sample.time <= time)
                .saturating_sub(1);
        }
        while all.get(place.0 + 1).is_some_and(|next| next.time <= time) {
            place.0 += 1;
        }
        let before = all.get(place.0).filter(|before| before.time <= time)?;
        let Some(after) = all.get(place.0 + 1) else {
            return (before.time >= time).then_some(*before);
        };
        let part = (time - before.time) / (after.time - before.time);
        Some(between(before, after, part, time))
    }
}

fn between(before: &TraceSample, after: &TraceSample, part: f64, time: f64) -> TraceSample {
    let mix = |a: f64, b: f64| a + (b - a) * part;
    let rotation = before.rotation.try_slerp(&after.rotation, part, 1e-9);
    TraceSample {
        time,
        q: core::array::from_fn(|i| mix(before.q[i], after.q[i])),
        position: before.position.lerp(&after.position, part),
        rotation: rotation.unwrap_or(before.rotation),
        speed: mix(before.speed, after.speed),
        force: before.force.lerp(&after.force, part),
    }
}

fn sample(cycle: &CycleMessage) -> TraceSample {
    let six = |values: &[f64]| -> [f64; 6] {
        core::array::from_fn(|i| values.get(i).copied().unwrap_or(f64::NAN))
    };
    let pose = six(&cycle.actual_tcp_pose);
    let speed = six(&cycle.actual_tcp_speed);
    let force = six(&cycle.tcp_force);
    let is_known = pose.iter().all(|value| value.is_finite());
    let rotation = match is_known {
        true => UnitQuaternion::from_rotation_matrix(
            &Pose::from_rpy(&RpyPose::from_array(pose)).rotation,
        ),
        false => UnitQuaternion::identity(),
    };
    TraceSample {
        time: cycle.time,
        q: six(&cycle.actual_q),
        // Without an orientation there is no place either, so that neither is compared.
        position: match is_known {
            true => Vector3::new(pose[0], pose[1], pose[2]),
            false => Vector3::repeat(f64::NAN),
        },
        rotation,
        speed: Vector3::new(speed[0], speed[1], speed[2]).norm(),
        force: Vector3::new(force[0], force[1], force[2]),
    }
}
