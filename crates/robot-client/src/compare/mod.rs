//! How far two runs are from each other: two recordings, laid over each other in time, and the differences.
//!
//! Owns the alignment and the figures. Both runs are sampled where the first one is; the second is interpolated there,
//! so rates may differ. What one of them does not know (not a number, or not there) is not compared.

mod align;
mod track;

pub use align::{Alignment, align};
pub use track::{RunTrace, RunTraceError, TraceSample};

use track::TraceCursor;

/// One quantity over the time that both runs have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Root of the mean square.
    pub rms: f64,
    /// The largest, without its sign.
    pub largest: f64,
    /// Time of the largest difference in the first run, s.
    pub at: f64,
    /// Number of samples that were compared.
    pub samples: u64,
}

impl Deviation {
    fn add(&mut self, at: f64, difference: f64) {
        if !difference.is_finite() {
            return;
        }
        // The sum of squares until `finish`.
        self.rms += difference * difference;
        self.samples += 1;
        if difference.abs() > self.largest {
            (self.largest, self.at) = (difference.abs(), at);
        }
    }

    fn finish(mut self) -> Option<Self> {
        self.rms = (self.rms / self.samples as f64).sqrt();
        (self.samples > 0).then_some(self)
    }
}

/// What came of it. A quantity that nothing is known of is absent.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// How the two were laid over each other.
    pub alignment: Alignment,
    /// The time that both have, in the first run's time, s; both ends equal when there is none.
    pub overlap: (f64, f64),
    /// Positions of the joints, rad.
    pub joints: [Option<Deviation>; 6],
    /// Place of the TCP, m.
    pub tcp_position: Option<Deviation>,
    /// Orientation of the TCP, rad.
    pub tcp_rotation: Option<Deviation>,
    /// Speed of the TCP, m/s.
    pub tcp_speed: Option<Deviation>,
    /// Force at the TCP, N.
    pub force: Option<Deviation>,
}

impl Comparison {
    /// The largest difference of any joint, rad.
    pub fn largest_joint(&self) -> Option<f64> {
        let largest = self.joints.iter().flatten().map(|joint| joint.largest);
        largest.reduce(f64::max)
    }
}

/// The differences of one sample, in the first run's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleDifference {
    /// Time in the first run, s.
    pub time: f64,
    /// Second minus first, rad.
    pub joints: [f64; 6],
    /// Distance of the TCPs, m.
    pub tcp_position: f64,
    /// Angle between them, rad.
    pub tcp_rotation: f64,
    /// Second minus first, m/s.
    pub tcp_speed: f64,
    /// Length of the difference of the forces, N.
    pub force: f64,
}

/// Every sample of the first run for which the second has one, shifted.
pub fn differences<'t>(
    first: &'t RunTrace,
    second: &'t RunTrace,
    alignment: Alignment,
) -> impl Iterator<Item = SampleDifference> + 't {
    let mut place = TraceCursor::default();
    first.samples().filter_map(move |sample| {
        let other = second.at(sample.time + alignment.shift, &mut place)?;
        let joints = core::array::from_fn(|i| other.q[i] - sample.q[i]);
        let rotation = sample.rotation.angle_to(&other.rotation);
        Some(SampleDifference {
            time: sample.time,
            joints,
            tcp_position: (other.position - sample.position).norm(),
            tcp_rotation: rotation,
            tcp_speed: other.speed - sample.speed,
            force: (other.force - sample.force).norm(),
        })
    })
}

/// Compares two runs.
pub fn compare(first: &RunTrace, second: &RunTrace, alignment: Alignment) -> Comparison {
    let mut joints = [Deviation::default(); 6];
    let [mut position, mut rotation, mut speed, mut force] = [Deviation::default(); 4];
    let mut overlap: Option<(f64, f64)> = None;
    for difference in differences(first, second, alignment) {
        let at = difference.time;
        overlap = Some((overlap.map_or(at, |(begin, _)| begin), at));
        for (joint, by) in joints.iter_mut().zip(difference.joints) {
            joint.add(at, by);
        }
        position.add(at, difference.tcp_position);
        rotation.add(at, difference.tcp_rotation);
        speed.add(at, difference.tcp_speed);
        force.add(at, difference.force);
    }
    Comparison {
        alignment,
        overlap: overlap.unwrap_or_default(),
        joints: joints.map(Deviation::finish),
        tcp_position: position.finish(),
        tcp_rotation: rotation.finish(),
        tcp_speed: speed.finish(),
        force: force.finish(),
    }
}

#[cfg(test)]
mod tests;
