//! The force/torque sensor between the flange and what hangs on it.
//!
//! Raw reading: what the environment does to the tool, the payload's weight, and its inertia. The compensated reading
//! takes weight and inertia off and then the zero that was set. Both are of the TCP, in the TCP's axes, moments about
//! the TCP (manual 4.4 to 4.6). The payload that is taken off is the one that is set; where something else hangs on the
//! flange, the difference is left and reads like a force from outside.
//! Noise is normal, independent from cycle to cycle, and the same in every run with the same seed.

use kinematics::random::RandomSequence;
use kinematics::{Frames, JointSpeeds, Payload, Pose, Twist, Wrench};
use nalgebra::Vector3;

/// `[sensor]` of the cell: standard deviations of each component, and the seed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorNoise {
    /// N.
    pub force: f64,
    /// Nm.
    pub torque: f64,
    /// Beginning of the sequence.
    pub seed: u64,
}

/// The sensor and its latest readings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForceTorqueSensor {
    noise: SensorNoise,
    random: RandomSequence,
    /// What hangs on the flange where that is another payload than the one that is set.
    actual_payload: Option<Payload>,
    /// What the compensated reading shows but for noise and zero: base axes, about the TCP.
    pub external_wrench: Wrench,
    /// What zeroing takes off: flange axes, about the flange.
    zero: Wrench,
    /// The latest compensated reading before the zero, flange axes, about the flange.
    unzeroed: Wrench,
    /// Velocity of the flange a cycle ago, base axes.
    twist: Option<Twist>,
    /// TCP axes, about the TCP.
    pub raw: Wrench,
    /// TCP axes, about the TCP.
    pub compensated: Wrench,
    /// `compensated` in base axes.
    pub compensated_in_base: Wrench,
    /// What pressed already when the servos took over from the brakes, N; never grows.
    baseline_force: f64,
}

impl ForceTorqueSensor {
    /// `actual_payload` is on the flange, or without it whatever payload is set.
    pub(crate) fn new(noise: SensorNoise, hanging: Option<Payload>) -> Self {
        let nothing = Wrench::default();
        Self {
            noise,
            random: RandomSequence::new(noise.seed),
            actual_payload: hanging,
            external_wrench: nothing,
            zero: nothing,
            unzeroed: nothing,
            twist: None,
            raw: nothing,
            compensated: nothing,
            compensated_in_base: nothing,
            baseline_force: 0.0,
        }
    }

    /// What really hangs on the flange; `None`: whatever payload is set.
    pub(crate) const fn actual_payload(&self) -> Option<Payload> {
        self.actual_payload
    }

    /// Something else hangs on the flange from now on.
    pub(crate) fn set_actual_payload(&mut self, payload: Payload) {
        self.actual_payload = Some(payload);
    }

    /// What is read now counts as nothing from now on.
    pub(crate) fn zero(&mut self) {
        self.zero = self.unzeroed;
    }

    /// The brakes hold the arm, whatever presses. It must be able to leave.
    pub(crate) fn rebaseline(&mut self) {
        self.baseline_force = self.compensated_in_base.force.norm();
    }

    /// The force at the TCP, N, when it is more than `limit` and more than what pressed already, which it may exceed a
    /// little while the servos take over.
    pub(crate) fn exceeds(&self, limit: f64) -> Option<f64> {
        let force = self.compensated_in_base.force.norm();
        (force > limit.max(1.2 * self.baseline_force)).then_some(force)
    }

    /// The arm was set somewhere else: its speed a cycle ago says nothing.
    pub(crate) fn restart(&mut self) {
        self.twist = None;
    }

    /// The end of a cycle of `step` seconds. `environment` acts on the tool: base axes, about the TCP. `payload` is the
    /// one that is set. `gravity` in base axes, m/s².
    pub(crate) fn measure(
        &mut self,
        environment: &Wrench,
        payload: &Payload,
        (frames, qd): (&Frames, &JointSpeeds),
        flange_from_tcp: &Pose,
        gravity: &Vector3<f64>,
        step: f64,
    ) {
        let base_from_flange = &frames.base_from_flange;
        let base_from_tcp = *base_from_flange * *flange_from_tcp;
        let twist = frames.twist(qd, base_from_flange.translation);
        let before = self.twist.replace(twist).unwrap_or(twist);
        let acceleration = Twist {
            linear: (twist.linear - before.linear) / step,
            angular: (twist.angular - before.angular) / step,
        };
        let weight = |payload: &Payload| {
            let at_flange =
                payload_wrench(payload, base_from_flange, &twist, &acceleration, gravity);
            let arm = base_from_flange.translation - base_from_tcp.translation;
            Wrench {
                force: at_flange.force,
                moment: at_flange.moment + arm.cross(&at_flange.force),
            }
        };
        let set = weight(payload);
        self.external_wrench = match &self.actual_payload {
            None => *environment,
            Some(hanging) => sum(environment, &sum(&weight(hanging), &set, -1.0), 1.0),
        };
        let in_tcp = |w: &Wrench| Wrench {
            force: base_from_tcp.rotate_back(w.force),
            moment: base_from_tcp.rotate_back(w.moment),
        };
        let noise = Wrench {
            force: normal(&mut self.random, self.noise.force),
            moment: normal(&mut self.random, self.noise.torque),
        };
        let read = sum(&in_tcp(&self.external_wrench), &noise, 1.0);
        self.raw = sum(&read, &in_tcp(&set), 1.0);
        self.unzeroed = read.transformed_by(flange_from_tcp);
        let zero = self.zero.transformed_by(&flange_from_tcp.inverse());
        self.compensated = sum(&read, &zero, -1.0);
        self.compensated_in_base = Wrench {
            force: base_from_tcp.rotate(self.compensated.force),
            moment: base_from_tcp.rotate(self.compensated.moment),
        };
        self.baseline_force = self
            .baseline_force
            .min(self.compensated_in_base.force.norm());
    }
}

fn sum(a: &Wrench, b: &Wrench, factor: f64) -> Wrench {
    Wrench {
        force: a.force + b.force * factor,
        moment: a.moment + b.moment * factor,
    }
}

/// What weight and inertia of the payload do to the flange: base axes, about the flange.
fn payload_wrench(
    payload: &Payload,
    base_from_flange: &Pose,
    twist: &Twist,
    acceleration: &Twist,
    gravity: &Vector3<f64>,
) -> Wrench {
    let arm = base_from_flange.rotate(payload.cog);
    let (spin, turn) = (twist.angular, acceleration.angular);
    let cog = acceleration.linear + turn.cross(&arm) + spin.cross(&spin.cross(&arm));
    let force = (gravity - cog) * payload.mass;
    // In the flange's axes, where the inertia stays the same.
    let inertia = payload.tensor();
    let (spin, turn) = (
        base_from_flange.rotate_back(spin),
        base_from_flange.rotate_back(turn),
    );
    let moment = -base_from_flange.rotate(inertia * turn + spin.cross(&(inertia * spin)));
    Wrench {
        force,
        moment: moment + arm.cross(&force),
    }
}

/// Three independent numbers with mean 0. Sums of twelve even numbers are normal enough up to six standard deviations
/// and, unlike logarithms, exact on every machine.
fn normal(random: &mut RandomSequence, deviation: f64) -> Vector3<f64> {
    if deviation == 0.0 {
        return Vector3::zeros();
    }
    Vector3::from_fn(|_, _| deviation * ((0..12).map(|_| random.unit()).sum::<f64>() - 6.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_deviation_that_was_set() {
        let mut random = RandomSequence::new(1);
        let many: Vec<f64> = (0..20_000)
            .flat_map(|_| <[f64; 3]>::from(normal(&mut random, 0.5)))
            .collect();
        let n = many.len() as f64;
        let mean = many.iter().sum::<f64>() / n;
        let deviation = (many.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!(
            mean.abs() < 0.01 && (deviation - 0.5).abs() < 0.01,
            "{mean} {deviation}"
        );
        // About 5 % of normal numbers lie beyond two deviations, 0.3 % beyond three.
        let beyond = |k: f64| many.iter().filter(|x| x.abs() > k * 0.5).count() as f64 / n;
        assert!((beyond(2.0) - 0.0455).abs() < 0.005 && (beyond(3.0) - 0.0027).abs() < 0.002);
    }
}
