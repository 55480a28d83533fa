//! The joint speeds nearest to a wanted twist that the joints can have in the next cycle.
//!
//! minimise ½ |W (J q̇ - v)|² + ½ ε |q̇|²  subject to  lower ≤ q̇ ≤ upper
//!
//! The bounds join speed, acceleration and position limits of each joint; ε keeps the answer unique where J is singular.
//! Solved by clarabel's interior point method, whose problem data are overwritten in place: two allocator calls a solve,
//! inside the library. Owns no task frame and no force.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
};
use kinematics::{DOF, JointAccelerations, JointPositions, JointSpeeds, Twist};
use nalgebra::{Matrix6, Vector6};
use thiserror::Error;

/// ε: metres per second and radian per second of the twist count as 1, a joint's rad/s as its root, 1e-3.
const REGULARISATION: f64 = 1e-6;

/// Most iterations of a solve; a usual one takes 6 to 10.
const MAX_ITERATIONS: u32 = 40;

/// What the joints may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimits {
    /// Smallest positions, rad.
    pub position_min: JointPositions,
    /// Largest positions, rad.
    pub position_max: JointPositions,
    /// Largest speeds either way, rad/s.
    pub speed: JointSpeeds,
    /// Largest accelerations either way, rad/s².
    pub acceleration: JointAccelerations,
}

/// What is wrong with a limiter or its input.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LimiterError {
    /// A limit or the step time cannot be used.
    #[error("{name} of joint {} is {value}, it must be a positive number", joint + 1)]
    BadLimit {
        /// Which limit.
        name: &'static str,
        /// Joint from 0.
        joint: usize,
        /// As given.
        value: f64,
    },
    /// The step time cannot be used.
    #[error("the step time is {step_s} s, it must be a positive number")]
    BadStep {
        /// As given, s.
        step_s: f64,
    },
    /// An input of a solve is NaN or infinite.
    #[error("the {name} has a component that is not a finite number")]
    NotFinite {
        /// Which input.
        name: &'static str,
    },
    /// The solver gave up.
    #[error("the solver found no joint speeds: {status}")]
    NotSolved {
        /// What the solver says.
        status: &'static str,
    },
}

/// Joint speeds within their limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limited {
    /// The joint speeds, rad/s.
    pub qd: JointSpeeds,
    /// The twist they make: J q̇.
    pub twist: Twist,
    /// True when some joint is at a bound, so that the twist may differ from the wanted one.
    pub is_at_bound: bool,
}

/// Finds joint speeds; made once, used every cycle.
pub struct TwistLimiter {
    limits: SpeedLimits,
    step: f64,
    solver: DefaultSolver<f64>,
    /// Upper triangle of P, column by column; q; b. Overwritten in place.
    quadratic: Vec<f64>,
    linear: Vec<f64>,
    bounds: Vec<f64>,
}

impl TwistLimiter {
    /// A limiter for cycles of `step` seconds.
    ///
    /// # Errors
    /// A limit or the step time is not positive and finite, or the solver refuses its settings.
    pub fn new(limits: SpeedLimits, step: f64) -> Result<Self, LimiterError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(LimiterError::BadStep { step_s: step });
        }
        for joint in 0..DOF {
            for (name, value) in [
                ("speed", limits.speed[joint]),
                ("acceleration", limits.acceleration[joint]),
                (
                    "position range",
                    limits.position_max[joint] - limits.position_min[joint],
                ),
            ] {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(LimiterError::BadLimit { name, joint, value });
                }
            }
        }
        let quadratic = upper_triangle(&Matrix6::identity());
        let linear = vec![0.0; DOF];
        let bounds = vec![1.0; 2 * DOF];
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(MAX_ITERATIONS)
            .max_threads(1)
            .presolve_enable(false)
            .input_sparse_dropzeros(false)
            .build()
            .map_err(|_| LimiterError::NotSolved {
                status: "its settings are refused",
            })?;
        let solver = DefaultSolver::new(
            &dense_upper(quadratic.clone()),
            &linear,
            &stacked_identities(),
            &bounds,
            &[NonnegativeConeT(2 * DOF)],
            settings,
        )
        .map_err(|_| LimiterError::NotSolved {
            status: "its problem is refused",
        })?;
        Ok(Self {
            limits,
            step,
            solver,
            quadratic,
            linear,
            bounds,
        })
    }

    /// The speeds each joint can have at the end of the next cycle: `(lower, upper)`, rad/s.
    ///
    /// From the speed `before` within the acceleration limit; never so fast towards an end of the range that the joint
    /// could not stop before it. Where these contradict each other (a joint already too fast), it brakes as hard as it may.
    pub fn bounds(&self, q: &JointPositions, before: &JointSpeeds) -> ([f64; DOF], [f64; DOF]) {
        let l = &self.limits;
        let mut lower = [0.0; DOF];
        let mut upper = [0.0; DOF];
        for joint in 0..DOF {
            let change = l.acceleration[joint] * self.step;
            let (least, most) = (before[joint] - change, before[joint] + change);
            let up = self.stoppable(l.position_max[joint] - q[joint], joint);
            let down = -self.stoppable(q[joint] - l.position_min[joint], joint);
            upper[joint] = most.min(l.speed[joint]).min(up).max(least);
            lower[joint] = least.max(-l.speed[joint]).max(down).min(most);
            // Both rules braking against each other leave one speed.
            if lower[joint] > upper[joint] {
                let middle = 0.5 * (lower[joint] + upper[joint]);
                (lower[joint], upper[joint]) = (middle, middle);
            }
        }
        (lower, upper)
    }

    /// The largest speed towards an end `room` radians away from which the joint stops in whole cycles before it.
    ///
    /// After this cycle `room` has shrunk by v h; then v may fall by a h a cycle: v h + v² / 2a + v h / 2 ≤ room.
    fn stoppable(&self, room: f64, joint: usize) -> f64 {
        let a = self.limits.acceleration[joint];
        let b = 1.5 * a * self.step;
        ((b * b + 2.0 * a * room.max(0.0)).sqrt() - b).max(0.0)
    }

    /// The joint speeds nearest to `wanted`, given the Jacobian at the TCP, the joints now and their speeds in the cycle
    /// before. `weights` say how much each component of the twist counts, linear before angular.
    ///
    /// # Errors
    /// An input is not finite, or the solver gives up within its bounded number of iterations.
    pub fn solve(
        &mut self,
        jacobian: &Matrix6<f64>,
        wanted: &Twist,
        weights: &[f64; 6],
        q: &JointPositions,
        before: &JointSpeeds,
    ) -> Result<Limited, LimiterError> {
        let v = Vector6::from(wanted.to_array());
        let w = Vector6::from(*weights);
        for (name, is_finite) in [
            ("Jacobian", jacobian.iter().all(|x| x.is_finite())),
            ("wanted twist", v.iter().all(|x| x.is_finite())),
            ("weights", w.iter().all(|x| x.is_finite())),
            ("joint positions", q.is_finite()),
            ("joint speeds", before.is_finite()),
        ] {
            if !is_finite {
                return Err(LimiterError::NotFinite { name });
            }
        }
        let (lower, upper) = self.bounds(q, before);
        let weighted = Matrix6::from_diagonal(&w.component_mul(&w)) * jacobian;
        let p = jacobian.transpose() * weighted + Matrix6::identity() * REGULARISATION;
        let linear = -(weighted.transpose() * v);
        fill_upper_triangle(&mut self.quadratic, &p);
        for (slot, value) in self.linear.iter_mut().zip(linear.iter()) {
            *slot = *value;
        }
        let both = upper.iter().copied().chain(lower.iter().map(|x| -x));
        for (slot, value) in self.bounds.iter_mut().zip(both) {
            *slot = value;
        }
        let updated = self
            .solver
            .update_P(&self.quadratic)
            .and_then(|()| self.solver.update_q(&self.linear))
            .and_then(|()| self.solver.update_b(&self.bounds));
        if updated.is_err() {
            return Err(LimiterError::NotSolved {
                status: "its data cannot be updated",
            });
        }
        self.solver.solve();
        match self.solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {}
            SolverStatus::MaxIterations => {
                return Err(LimiterError::NotSolved {
                    status: "too many iterations",
                });
            }
            _ => {
                return Err(LimiterError::NotSolved {
                    status: "numerical trouble",
                });
            }
        }
        let x = &self.solver.solution.x;
        let mut qd = JointSpeeds::ZERO;
        let mut is_at_bound = false;
        for joint in 0..DOF {
            let value = x.get(joint).copied().unwrap_or(0.0);
            // The interior point method ends a hair inside or outside.
            qd[joint] = value.clamp(lower[joint], upper[joint]);
            let near = 1e-6 * (1.0 + qd[joint].abs());
            is_at_bound |= qd[joint] - lower[joint] < near || upper[joint] - qd[joint] < near;
        }
        let twist = jacobian * Vector6::from(qd.0);
        Ok(Limited {
            qd,
            twist: Twist {
                linear: twist.fixed_rows::<3>(0).into(),
                angular: twist.fixed_rows::<3>(3).into(),
            },
            is_at_bound,
        })
    }
}

/// Entries on and above the diagonal, column by column, as clarabel stores them.
fn upper_triangle(matrix: &Matrix6<f64>) -> Vec<f64> {
    let mut values = vec![0.0; DOF * (DOF + 1) / 2];
    fill_upper_triangle(&mut values, matrix);
    values
}

fn fill_upper_triangle(values: &mut [f64], matrix: &Matrix6<f64>) {
    let entries = (0..DOF).flat_map(|column| (0..=column).map(move |row| (row, column)));
    for (slot, (row, column)) in values.iter_mut().zip(entries) {
        *slot = matrix[(row, column)];
    }
}

fn dense_upper(values: Vec<f64>) -> CscMatrix<f64> {
    let starts = (0..=DOF).map(|column| column * (column + 1) / 2).collect();
    let rows = (0..DOF).flat_map(|column| 0..=column).collect();
    CscMatrix::new(DOF, DOF, starts, rows, values)
}

/// The identity above its negative.
fn stacked_identities() -> CscMatrix<f64> {
    let starts = (0..=DOF).map(|column| 2 * column).collect();
    let rows = (0..DOF).flat_map(|column| [column, column + DOF]).collect();
    let values = (0..DOF).flat_map(|_| [1.0, -1.0]).collect();
    CscMatrix::new(2 * DOF, DOF, starts, rows, values)
}
