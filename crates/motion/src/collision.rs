//! Collision detection: what the joints carry beyond their own motion.
//!
//! Generalised-momentum observer (De Luca, Albu-Schäffer, Haddadin, Hirzinger, IROS 2006): with p = M qd, the residual
//! r = K (p - ∫ (tau + C^T qd - g + r) dt) follows the torque from outside with the time constant 1/K, without
//! accelerations. C^T qd = dM/dt qd - C qd, so mass matrix and bias torques are enough. Discretised by the trapezoidal
//! rule over a cycle, with the mean torque of the drives.

use kinematics::bounds::within;
use kinematics::{Frames, JointTorques, Pose};
use motion_api::StopReason;
use nalgebra::{Matrix6, Vector6};

use crate::plant::ArmState;

/// 1/K, s.
const TIME_CONSTANT: f64 = 0.02;
/// Threshold as share of a joint's nominal torque at the least (10 %) and the highest (100 %) sensitivity. Our choice.
const THRESHOLDS: (f64, f64) = (0.6, 0.1);

/// When the servos have taken over from the brakes, what presses after this time (five time constants) pressed before,
/// s.
const TAKEOVER: f64 = 0.1;

/// Sensitivity after start, %.
pub const DEFAULT_SENSITIVITY: u8 = 50;
/// Least and highest sensitivity, % (manual 3.1.46).
pub const SENSITIVITY_RANGE: (u8, u8) = (10, 100);

/// The observer and its switch.
#[derive(Clone, Copy, Debug)]
pub struct CollisionDetector {
    /// Whether a collision stops the arm.
    pub is_enabled: bool,
    sensitivity: u8,
    residual: Vector6<f64>,
    integral: Vector6<f64>,
    /// The part of the residual that the sensor at the tool explains.
    sensed_residual: Vector6<f64>,
    previous: Option<PreviousSample>,
    /// Time since the servos took over from the brakes, s, up to [`TAKEOVER`].
    since_takeover: f64,
    /// What pressed already when the servos took over, Nm; never grows. An arm that was stopped by an obstacle stands
    /// against it, and must be able to leave.
    baseline: Vector6<f64>,
}

#[derive(Clone, Copy, Debug)]
struct PreviousSample {
    mass: Matrix6<f64>,
    bias: Vector6<f64>,
    qd: Vector6<f64>,
}

impl Default for CollisionDetector {
    fn default() -> Self {
        Self {
            is_enabled: true,
            sensitivity: DEFAULT_SENSITIVITY,
            residual: Vector6::zeros(),
            integral: Vector6::zeros(),
            sensed_residual: Vector6::zeros(),
            previous: None,
            since_takeover: TAKEOVER,
            baseline: Vector6::zeros(),
        }
    }
}

impl CollisionDetector {
    /// Sensitivity, %.
    pub fn sensitivity(&self) -> u8 {
        self.sensitivity
    }

    /// Sets the sensitivity, %; `false` when it is out of range.
    pub fn set_sensitivity(&mut self, percent: u8) -> bool {
        let is_allowed = (SENSITIVITY_RANGE.0..=SENSITIVITY_RANGE.1).contains(&percent);
        if is_allowed {
            self.sensitivity = percent;
        }
        is_allowed
    }

    /// Forgets the past: the masses have changed.
    pub fn reset(&mut self) {
        self.previous = None;
        self.residual = Vector6::zeros();
        self.sensed_residual = Vector6::zeros();
    }

    /// The brakes hold the arm, whatever presses.
    pub fn reset_for_takeover(&mut self) {
        self.reset();
        self.since_takeover = 0.0;
        self.baseline = Vector6::zeros();
    }

    /// The end of a cycle of `step` seconds; `at_tool` are the joint torques of what acts on the tool. Mass matrix and
    /// bias torques are those of the controller's model where the arm is.
    pub fn observe(
        &mut self,
        arm: &ArmState,
        at_tool: &JointTorques,
        (mass, bias): (Matrix6<f64>, JointTorques),
        step: f64,
    ) {
        let bias = bias.to_vector();
        let qd = arm.qd.to_vector();
        if let Some(before) = self.previous {
            let turned = mat_vec(&(mass - before.mass), &(qd + before.qd)) / (2.0 * step);
            let own = arm.mean_torque.to_vector() + turned - (bias + before.bias) / 2.0;
            // r after the step appears on both sides: solved for it.
            let k = 1.0 / TIME_CONSTANT;
            let left = mat_vec(&mass, &qd) - self.integral - step * own;
            self.residual = left * k / (1.0 + k * step);
            self.integral += step * (own + self.residual);
            // The sensor's torque is delayed by the same time constant, so that both residuals stay comparable.
            self.sensed_residual =
                (self.sensed_residual + k * step * at_tool.to_vector()) / (1.0 + k * step);
        } else {
            self.integral = mat_vec(&mass, &qd);
        }
        self.previous = Some(PreviousSample { mass, bias, qd });
        if self.since_takeover < TAKEOVER {
            self.since_takeover += step;
            self.baseline = self.residual;
        } else {
            self.baseline = self.baseline.zip_map(&self.residual, |accepted, now| {
                within(accepted, now.min(0.0), now.max(0.0))
            });
        }
    }

    /// The arm presses on purpose: when it ends, what the tool presses with then is no collision.
    pub fn accept_sensed_contact(&mut self) {
        self.baseline = self.sensed_residual;
    }

    /// Torques from outside, Nm.
    pub fn external_torque(&self) -> JointTorques {
        JointTorques(self.residual.into())
    }

    /// The joint that carries most over its threshold, as the reason of a stop. `frames` and `flange_from_tcp` say
    /// where the TCP is, `effort` the nominal torques. While the arm presses on purpose, what the sensor at the tool
    /// feels is no collision.
    pub fn detected_stop(
        &self,
        effort: &JointTorques,
        is_pressing: bool,
        (frames, flange_from_tcp): (&Frames, &Pose),
    ) -> Option<StopReason> {
        if !self.is_enabled {
            return None;
        }
        let (least, highest) = SENSITIVITY_RANGE;
        let share = f64::from(self.sensitivity - least) / f64::from(highest - least);
        let threshold = THRESHOLDS.0 + (THRESHOLDS.1 - THRESHOLDS.0) * share;
        let expected = if is_pressing {
            self.sensed_residual
        } else {
            self.baseline
        };
        let residual = self.residual - expected;
        let over: [f64; 6] =
            core::array::from_fn(|joint| residual[joint].abs() / (effort[joint] * threshold));
        let hit = (0..6).max_by(|a, b| over[*a].total_cmp(&over[*b]))?;
        if over[hit] <= 1.0 {
            return None;
        }
        Some(StopReason::Collision {
            joint: hit as u8,
            torque: residual[hit],
            limit: effort[hit] * threshold,
            force: equivalent_tcp_force(
                &residual,
                frames,
                &(frames.base_from_flange * *flange_from_tcp),
            ),
        })
    }
}

/// `m * v`, column by column as nalgebra does, written out: its general product takes several times as long at this
/// size.
fn mat_vec(m: &Matrix6<f64>, v: &Vector6<f64>) -> Vector6<f64> {
    let [a, b, c, d, e, f]: &[[f64; 6]; 6] = m.as_ref();
    let [p, q, r, s, t, u] = (*v).into();
    let row = |k: usize| a[k] * p + b[k] * q + c[k] * r + d[k] * s + e[k] * t + f[k] * u;
    Vector6::new(row(0), row(1), row(2), row(3), row(4), row(5))
}

/// Size of the force at the TCP that explains the torques best: least squares of tau = J^T F.
fn equivalent_tcp_force(torques: &Vector6<f64>, frames: &Frames, base_from_tcp: &Pose) -> f64 {
    let jacobian = frames.jacobian(base_from_tcp.translation);
    let rows = jacobian.fixed_rows::<3>(0);
    let square = rows * rows.transpose();
    square
        .lu()
        .solve(&(rows * torques))
        .map_or(0.0, |force| force.norm())
}

/// Joint torques of a wrench on the tool (base axes, about the TCP): J^T F.
pub fn wrench_to_torques(
    wrench: &kinematics::Wrench,
    frames: &Frames,
    base_from_tcp: &Pose,
) -> JointTorques {
    if wrench.is_zero() {
        return JointTorques::ZERO;
    }
    let jacobian = frames.jacobian(base_from_tcp.translation);
    JointTorques((jacobian.transpose() * wrench.to_vector()).into())
}
