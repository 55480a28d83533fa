//! What acts on the tool from outside: loads of the cell by time, and the wrench that a port or a test sets.
//!
//! Owns no physics: the plant feels the sum, freedrive follows it, the force sensor reads it.

use kinematics::{Pose, Wrench};

/// In which axes a load is given. Its point is the TCP.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoadFrame {
    /// The base's.
    #[default]
    Base,
    /// The TCP's.
    Tool,
}

/// A load for some time, `[[wrench]]` of the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// When it begins, s.
    pub at: f64,
    /// How long it acts, s.
    pub duration: f64,
    /// N and Nm.
    pub wrench: Wrench,
    /// Its axes.
    pub frame: LoadFrame,
}

/// Everything that acts on the tool.
#[derive(Clone, Debug, Default)]
pub(crate) struct External {
    loads: Vec<Load>,
    /// Base axes, about the TCP.
    pub(crate) set: Wrench,
}

impl External {
    pub(crate) fn new(loads: Vec<Load>) -> Self {
        Self {
            loads,
            set: Wrench::default(),
        }
    }

    /// The sum at `time`, s: base axes, about the TCP, which is at `base_from_tcp`.
    pub(crate) fn at(&self, time: f64, base_from_tcp: &Pose) -> Wrench {
        let mut sum = self.set;
        for load in &self.loads {
            if !(load.at..load.at + load.duration).contains(&time) {
                continue;
            }
            let (force, moment) = match load.frame {
                LoadFrame::Base => (load.wrench.force, load.wrench.moment),
                LoadFrame::Tool => (
                    base_from_tcp.rotate(load.wrench.force),
                    base_from_tcp.rotate(load.wrench.moment),
                ),
            };
            sum.force += force;
            sum.moment += moment;
        }
        sum
    }
}
