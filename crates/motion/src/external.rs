//! What acts on the tool from outside: loads of the cell by time, and the wrench that a port or a test sets.
//!
//! Owns no physics: the plant feels the sum, freedrive follows it, the force sensor reads it.

use kinematics::{Pose, Wrench};
use nalgebra::Vector3;

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

/// The sensor whose readings come over a port, as `ft_rtsi_input_enable` describes it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PortSensor {
    /// Its own mass, kg: the readings hold its weight.
    pub mass: f64,
    /// What its moments are about, flange frame, m. Zero: the TCP.
    pub measuring_offset: Vector3<f64>,
    /// Its centre of gravity, flange frame, m.
    pub cog: Vector3<f64>,
}

/// Everything that acts on the tool.
#[derive(Clone, Debug, Default)]
pub(crate) struct External {
    loads: Vec<Load>,
    /// The latest reading from a port: base axes.
    pub(crate) set: Wrench,
    /// Readings from ports count.
    pub(crate) port_sensor: Option<PortSensor>,
}

impl PortSensor {
    /// What acts on the tool when the sensor reads `read`: base axes, about the TCP.
    fn without_itself(
        &self,
        read: &Wrench,
        base_from_flange: &Pose,
        tcp: Vector3<f64>,
        gravity: &Vector3<f64>,
    ) -> Wrench {
        let about = if self.measuring_offset == Vector3::zeros() {
            tcp
        } else {
            base_from_flange.transform_point(self.measuring_offset)
        };
        let weight = gravity * self.mass;
        let arm = base_from_flange.transform_point(self.cog) - about;
        let force = read.force - weight;
        Wrench {
            force,
            moment: read.moment - arm.cross(&weight) + (about - tcp).cross(&force),
        }
    }
}

impl External {
    pub(crate) fn new(loads: Vec<Load>) -> Self {
        Self {
            loads,
            set: Wrench::default(),
            port_sensor: None,
        }
    }

    /// The sum at `time`, s: base axes, about the TCP. `gravity` in base axes, m/s².
    pub(crate) fn at(
        &self,
        time: f64,
        base_from_flange: &Pose,
        flange_from_tcp: &Pose,
        gravity: &Vector3<f64>,
    ) -> Wrench {
        if self.port_sensor.is_none() && self.loads.is_empty() {
            return Wrench::default();
        }
        let base_from_tcp = *base_from_flange * *flange_from_tcp;
        let tcp = base_from_tcp.translation;
        let mut sum = self.port_sensor.map_or_else(Wrench::default, |sensor| {
            sensor.without_itself(&self.set, base_from_flange, tcp, gravity)
        });
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
