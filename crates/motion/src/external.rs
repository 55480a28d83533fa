//! What acts on the tool from outside: loads of the cell by time, and the wrench that a port or a test sets.
//!
//! Owns no physics: the plant feels the sum, freedrive follows it, the force sensor reads it.

use kinematics::{Pose, Wrench};
use nalgebra::Vector3;

/// Most pushes that act at once.
pub(crate) const PUSHES_MAX: usize = 32;

/// In which axes a load is given. Its point is the TCP.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WrenchFrame {
    /// The base's.
    #[default]
    Base,
    /// The TCP's.
    Tool,
}

/// A load for some time, `[[wrench]]` of the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedWrench {
    /// When the wrench begins, s.
    pub at: f64,
    /// How long the wrench acts, s.
    pub duration: f64,
    /// Force and moment, N and Nm.
    pub wrench: Wrench,
    /// The frame whose axes the wrench has.
    pub frame: WrenchFrame,
}

impl TimedWrench {
    /// True when the wrench acts no more.
    fn is_over(&self, now: f64) -> bool {
        now >= self.at + self.duration
    }
}

/// The sensor whose readings come over a port, as `ft_rtsi_input_enable` describes it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PortSensor {
    /// Mass of the sensor itself, kg: the readings hold its weight.
    pub mass: f64,
    /// The point about which the sensor measures moments, flange frame, m. Zero: the TCP.
    pub measuring_offset: Vector3<f64>,
    /// Centre of gravity of the sensor, flange frame, m.
    pub cog: Vector3<f64>,
}

/// Everything that acts on the tool.
#[derive(Clone, Debug)]
pub(crate) struct ExternalWrenches {
    loads: Vec<TimedWrench>,
    /// Loads that commands have set on.
    commanded: [Option<TimedWrench>; PUSHES_MAX],
    /// When all loads of commands are over, s.
    commanded_until: f64,
    /// The latest reading from a port: base axes.
    pub(crate) port_wrench: Wrench,
    /// Readings from ports count.
    pub(crate) port_sensor: Option<PortSensor>,
}

impl PortSensor {
    /// What acts on the tool when the sensor reads `read`: base axes, about the TCP.
    fn compensate_own_weight(
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

impl ExternalWrenches {
    pub(crate) fn new(loads: Vec<TimedWrench>) -> Self {
        Self {
            loads,
            commanded: [None; PUSHES_MAX],
            commanded_until: 0.0,
            port_wrench: Wrench::default(),
            port_sensor: None,
        }
    }

    /// Takes a load from now on; false when too many act already.
    pub(crate) fn push(&mut self, load: TimedWrench, now: f64, replaces: bool) -> bool {
        for place in &mut self.commanded {
            *place = place.filter(|load| !replaces && !load.is_over(now));
        }
        let free = self.commanded.iter_mut().find(|place| place.is_none());
        free.is_some_and(|place| {
            *place = Some(load);
            let end = load.at + load.duration;
            self.commanded_until = match replaces {
                true => end,
                false => self.commanded_until.max(end),
            };
            true
        })
    }

    /// The sum at `time`, s: base axes, about the TCP. `gravity` in base axes, m/s².
    pub(crate) fn at(
        &self,
        time: f64,
        base_from_flange: &Pose,
        flange_from_tcp: &Pose,
        gravity: &Vector3<f64>,
    ) -> Wrench {
        let is_pushed = time < self.commanded_until;
        if self.port_sensor.is_none() && self.loads.is_empty() && !is_pushed {
            return Wrench::default();
        }
        let base_from_tcp = *base_from_flange * *flange_from_tcp;
        let tcp = base_from_tcp.translation;
        let mut sum = self.port_sensor.map_or_else(Wrench::default, |sensor| {
            sensor.compensate_own_weight(&self.port_wrench, base_from_flange, tcp, gravity)
        });
        for load in self.loads.iter().chain(self.commanded.iter().flatten()) {
            if !(load.at..load.at + load.duration).contains(&time) {
                continue;
            }
            let (force, moment) = match load.frame {
                WrenchFrame::Base => (load.wrench.force, load.wrench.moment),
                WrenchFrame::Tool => (
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

#[cfg(test)]
mod tests {
    use super::*;

    fn push(external: &mut ExternalWrenches, newtons: f64, now: f64, replaces: bool) -> bool {
        let load = TimedWrench {
            at: now,
            duration: 1.0,
            wrench: Wrench::from_array([newtons, 0.0, 0.0, 0.0, 0.0, 0.0]),
            frame: WrenchFrame::Base,
        };
        external.push(load, now, replaces)
    }

    fn force(external: &ExternalWrenches, time: f64) -> f64 {
        let (pose, gravity) = (Pose::IDENTITY, Vector3::zeros());
        external.at(time, &pose, &pose, &gravity).force.x
    }

    #[test]
    fn pushes_add_up_until_each_is_over_and_give_their_place_back() {
        let mut external = ExternalWrenches::new(Vec::new());
        assert!(push(&mut external, 1.0, 0.0, false) && push(&mut external, 2.0, 0.5, false));
        let at = [0.4, 0.9, 1.2, 1.6].map(|time| force(&external, time));
        assert_eq!(at, [1.0, 3.0, 2.0, 0.0]);
        assert!(push(&mut external, 5.0, 0.6, true));
        assert_eq!(force(&external, 0.9), 5.0);
        // The one that replaced the others takes a place.
        let taken = (0..PUSHES_MAX).filter(|_| push(&mut external, 1.0, 0.7, false));
        assert_eq!(taken.count(), PUSHES_MAX - 1);
        assert!(push(&mut external, 1.0, 1.65, false));
    }
}
