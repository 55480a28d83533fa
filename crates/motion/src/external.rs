//! What acts on the tool from outside: loads of the cell by time, and the wrench that a port or a test sets.
//!
//! Owns no physics: the plant feels the sum, freedrive follows it, the force sensor reads it.

use kinematics::{Pose, Wrench};
use nalgebra::Vector3;

/// Most pushes that act at once.
pub(crate) const PUSHES_MAX: usize = 32;

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

impl Load {
    /// It acts no more.
    fn is_over(&self, now: f64) -> bool {
        now >= self.at + self.duration
    }
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
#[derive(Clone, Debug)]
pub(crate) struct External {
    loads: Vec<Load>,
    /// Loads that commands have set on.
    pushes: [Option<Load>; PUSHES_MAX],
    /// When all of them are over, s.
    pushed_until: f64,
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
            pushes: [None; PUSHES_MAX],
            pushed_until: 0.0,
            set: Wrench::default(),
            port_sensor: None,
        }
    }

    /// Takes a load from now on; false when too many act already.
    pub(crate) fn push(&mut self, load: Load, now: f64, replaces: bool) -> bool {
        for place in &mut self.pushes {
            *place = place.filter(|load| !replaces && !load.is_over(now));
        }
        let free = self.pushes.iter_mut().find(|place| place.is_none());
        free.is_some_and(|place| {
            *place = Some(load);
            let end = load.at + load.duration;
            self.pushed_until = match replaces {
                true => end,
                false => self.pushed_until.max(end),
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
        let is_pushed = time < self.pushed_until;
        if self.port_sensor.is_none() && self.loads.is_empty() && !is_pushed {
            return Wrench::default();
        }
        let base_from_tcp = *base_from_flange * *flange_from_tcp;
        let tcp = base_from_tcp.translation;
        let mut sum = self.port_sensor.map_or_else(Wrench::default, |sensor| {
            sensor.without_itself(&self.set, base_from_flange, tcp, gravity)
        });
        for load in self.loads.iter().chain(self.pushes.iter().flatten()) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn push(external: &mut External, newtons: f64, now: f64, replaces: bool) -> bool {
        let load = Load {
            at: now,
            duration: 1.0,
            wrench: Wrench::from_array([newtons, 0.0, 0.0, 0.0, 0.0, 0.0]),
            frame: LoadFrame::Base,
        };
        external.push(load, now, replaces)
    }

    fn force(external: &External, time: f64) -> f64 {
        let (pose, gravity) = (Pose::IDENTITY, Vector3::zeros());
        external.at(time, &pose, &pose, &gravity).force.x
    }

    #[test]
    fn pushes_add_up_until_each_is_over_and_give_their_place_back() {
        let mut external = External::new(Vec::new());
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
