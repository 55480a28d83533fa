//! The joint speeds nearest to a wanted twist that the joints can have in the next cycle.
//!
//! minimise ½ |W (J q̇ - v)|² + ½ ε |q̇|²  subject to  lower ≤ q̇ ≤ upper  and  |J q̇|ᵢ ≤ limitᵢ
//!
//! J and v are given in the axes in which the twist is limited. ε keeps the answer unique where J is singular. The
//! minimum without bounds is looked at first: where it keeps them it is the answer, to machine precision. Otherwise
//! clarabel's interior point method solves the program, scaled to the size of the bounds; its data are overwritten in
//! place (two allocator calls a solve, inside the library). If it needs more than a fixed number of iterations the
//! answer is the clamped minimum, drawn towards a point that keeps every bound until it does too: never the best,
//! always allowed. Owns no task frame and no force, and no rule where the bounds come from.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
};
use kinematics::bounds::within;
use kinematics::{DOF, JointSpeeds};
use messages::Localized;
use nalgebra::{Matrix6, Vector6};
use thiserror::Error;

/// ε: metres per second and radian per second of the twist count as 1, a joint's rad/s as its root, 1e-3.
const REGULARISATION: f64 = 1e-6;

/// Most iterations of a solve; a usual one takes 6 to 12. Counted and not timed, so that a run is the same everywhere.
const MAX_ITERATIONS: u32 = 40;

/// Upper and lower bound of every joint and of every component of the twist.
const ROWS: usize = 4 * DOF;

/// A component without a limit gets this many half widths of the joints' bounds: |J| ≤ 2 m makes at most 24.
const UNLIMITED_HALF_WIDTHS: f64 = 100.0;

/// An answer may miss a limit of the twist by this, m/s or rad/s: where the center is at a limit, nothing less would
/// let the joints move at all.
const TWIST_TOLERANCE: f64 = 1e-9;

/// What is wrong with a limiter or its input.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum LimiterError {
    /// An input of a solve is NaN or infinite.
    #[error("the {name} has a component that is not a finite number")]
    #[zh("{name} 有一个分量不是有限数")]
    NotFinite {
        /// The name of the input.
        name: &'static str,
    },
    /// A lower bound lies above the upper one.
    #[error(
        "joint {} may be no slower than {lower} rad/s and no faster than {upper} rad/s: no speed is left",
        joint + 1
    )]
    #[zh("关节 {} 不得慢于 {lower} rad/s 且不得快于 {upper} rad/s：没有可用的速度", joint + 1)]
    InfeasibleBounds {
        /// Joint from 0.
        joint: usize,
        /// rad/s.
        lower: f64,
        /// rad/s.
        upper: f64,
    },
    /// The solver cannot be made.
    #[error("the solver cannot be made: {status}")]
    #[zh("无法建立求解器：{status}")]
    Solver {
        /// What the solver says.
        status: &'static str,
    },
}

/// One cycle's question. Twists are linear before angular, in the axes in which they are limited.
#[derive(Clone, Copy, Debug)]
pub struct TwistProblem {
    /// A row for each component of the twist, a column for each joint.
    pub jacobian: Matrix6<f64>,
    /// Wanted twist, m/s and rad/s.
    pub desired_twist: [f64; 6],
    /// How much each component counts.
    pub weights: [f64; 6],
    /// Smallest joint speeds, rad/s.
    pub lower: JointSpeeds,
    /// Largest joint speeds, rad/s.
    pub upper: JointSpeeds,
    /// Largest components of the twist either way, m/s and rad/s; infinite for none. A component that is faster at
    /// `current_speeds` is only kept from becoming faster still: what the joints cannot do is not asked of them.
    pub limits: [f64; 6],
    /// Joint speeds now, rad/s.
    pub current_speeds: JointSpeeds,
}

/// How an answer was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolveMethod {
    /// No bound is touched: the exact minimum.
    Unconstrained,
    /// The quadratic program.
    QuadraticProgram,
    /// The program did not end in its iterations.
    Fallback,
}

/// Joint speeds within their bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwistSolution {
    /// The joint speeds, rad/s.
    pub qd: JointSpeeds,
    /// How the speeds were found.
    pub method: SolveMethod,
}

/// Finds joint speeds; made once, used every cycle.
pub struct TwistLimiter {
    solver: DefaultSolver<f64>,
    /// Upper triangle of P, column by column; q; A column by column; b. Overwritten in place.
    quadratic: Vec<f64>,
    linear: Vec<f64>,
    rows: Vec<f64>,
    bounds: Vec<f64>,
}

impl TwistLimiter {
    /// A limiter with the memory of its solver.
    ///
    /// # Errors
    /// [`LimiterError::Solver`] when the library refuses its settings or the form of the problem.
    pub fn new() -> Result<Self, LimiterError> {
        Self::with_iterations(MAX_ITERATIONS)
    }

    /// Makes a limiter with another bound on the iterations; with 0 it always takes the fallback.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn with_iterations(most: u32) -> Result<Self, LimiterError> {
        let quadratic = upper_triangle(&Matrix6::identity());
        let linear = vec![0.0; DOF];
        let mut rows = vec![0.0; DOF * (2 + 2 * DOF)];
        fill_rows(&mut rows, &Matrix6::identity());
        let bounds = vec![1.0; ROWS];
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(most)
            .max_threads(1)
            .presolve_enable(false)
            .input_sparse_dropzeros(false)
            .tol_gap_abs(1e-11)
            .tol_gap_rel(1e-11)
            .tol_feas(1e-11)
            .build()
            .map_err(|_| LimiterError::Solver {
                status: "its settings are refused",
            })?;
        let solver = DefaultSolver::new(
            &dense_upper(quadratic.clone()),
            &linear,
            &row_matrix(rows.clone()),
            &bounds,
            &[NonnegativeConeT(ROWS)],
            settings,
        )
        .map_err(|_| LimiterError::Solver {
            status: "its problem is refused",
        })?;
        Ok(Self {
            solver,
            quadratic,
            linear,
            rows,
            bounds,
        })
    }

    /// The joint speeds that answer the question.
    ///
    /// # Errors
    /// An input is not finite, or a joint has no speed left.
    pub fn solve(&mut self, problem: &TwistProblem) -> Result<TwistSolution, LimiterError> {
        check(problem)?;
        let w = Vector6::from(problem.weights);
        let jacobian = &problem.jacobian;
        let weighted = Matrix6::from_diagonal(&w.component_mul(&w)) * jacobian;
        let p = jacobian.transpose() * weighted + Matrix6::identity() * REGULARISATION;
        let pull = weighted.transpose() * Vector6::from(problem.desired_twist);
        let allowed = FeasibleSet::new(problem);
        // P is positive definite by ε; what rounding could still spoil goes on to the program.
        let minimum = p.cholesky().map(|factors| factors.solve(&pull));
        if let Some(minimum) = &minimum
            && allowed.contains(minimum)
        {
            return Ok(TwistSolution {
                qd: JointSpeeds((*minimum).into()),
                method: SolveMethod::Unconstrained,
            });
        }
        if let Some(found) = self.solve_program(&p, &pull, jacobian, &allowed) {
            return Ok(TwistSolution {
                qd: JointSpeeds(allowed.project(&found).into()),
                method: SolveMethod::QuadraticProgram,
            });
        }
        let start = minimum.unwrap_or(allowed.center);
        Ok(TwistSolution {
            qd: JointSpeeds(allowed.project(&start).into()),
            method: SolveMethod::Fallback,
        })
    }

    /// The program in the variables z = (q̇ - center) / scale; `None` when it did not end.
    fn solve_program(
        &mut self,
        p: &Matrix6<f64>,
        pull: &Vector6<f64>,
        jacobian: &Matrix6<f64>,
        allowed: &FeasibleSet,
    ) -> Option<Vector6<f64>> {
        let FeasibleSet {
            lower,
            upper,
            center,
            limits,
            at_center,
            ..
        } = allowed;
        let scale = (upper - lower).amax().max(1e-9) / 2.0;
        fill_upper_triangle(&mut self.quadratic, p);
        fill_rows(&mut self.rows, jacobian);
        let linear = (p * center - pull) / scale;
        self.linear.copy_from_slice(linear.as_slice());
        for k in 0..DOF {
            self.bounds[k] = (upper[k] - center[k]) / scale;
            self.bounds[DOF + k] = (center[k] - lower[k]) / scale;
            self.bounds[2 * DOF + k] =
                ((limits[k] - at_center[k]) / scale).min(UNLIMITED_HALF_WIDTHS);
            self.bounds[3 * DOF + k] =
                ((limits[k] + at_center[k]) / scale).min(UNLIMITED_HALF_WIDTHS);
        }
        self.solver
            .update_P(&self.quadratic)
            .and_then(|()| self.solver.update_q(&self.linear))
            .and_then(|()| self.solver.update_A(&self.rows))
            .and_then(|()| self.solver.update_b(&self.bounds))
            .ok()?;
        self.solver.solve();
        let is_solved = matches!(
            self.solver.solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved
        );
        let z = Vector6::from_column_slice(self.solver.solution.x.get(..DOF)?);
        (is_solved && z.iter().all(|x| x.is_finite())).then(|| center + z * scale)
    }
}

/// The speeds that are allowed, and one of them.
struct FeasibleSet {
    jacobian: Matrix6<f64>,
    lower: Vector6<f64>,
    upper: Vector6<f64>,
    limits: Vector6<f64>,
    center: Vector6<f64>,
    /// J at the center.
    at_center: Vector6<f64>,
}

impl FeasibleSet {
    fn new(problem: &TwistProblem) -> Self {
        let (lower, upper) = (
            Vector6::from(problem.lower.0),
            Vector6::from(problem.upper.0),
        );
        let center = Vector6::from_fn(|k, _| within(problem.current_speeds[k], lower[k], upper[k]));
        let at_center = problem.jacobian * center;
        let limits = Vector6::from_fn(|k, _| problem.limits[k].max(at_center[k].abs()));
        Self {
            jacobian: problem.jacobian,
            lower,
            upper,
            limits,
            center,
            at_center,
        }
    }

    fn contains(&self, qd: &Vector6<f64>) -> bool {
        let twist = self.jacobian * qd;
        (0..DOF).all(|k| {
            qd[k] >= self.lower[k] && qd[k] <= self.upper[k] && twist[k].abs() <= self.limits[k]
        })
    }

    /// `qd` inside the bounds of the joints, then towards the center until the twist is inside its limits too. Both
    /// sets are convex and the center lies in both. The interior point method ends a hair inside or outside.
    fn project(&self, qd: &Vector6<f64>) -> Vector6<f64> {
        let inside = Vector6::from_fn(|k, _| within(qd[k], self.lower[k], self.upper[k]));
        let way = inside - self.center;
        let twist = self.jacobian * way;
        let share = (0..DOF).fold(1.0_f64, |share, k| {
            let room = if twist[k] > 0.0 {
                self.limits[k] - self.at_center[k]
            } else {
                self.limits[k] + self.at_center[k]
            };
            if twist[k].abs() > room + TWIST_TOLERANCE {
                share.min((room + TWIST_TOLERANCE) / twist[k].abs())
            } else {
                share
            }
        });
        self.center + way * share
    }
}

fn check(problem: &TwistProblem) -> Result<(), LimiterError> {
    let is_finite = |v: &[f64; 6]| v.iter().all(|x| x.is_finite());
    for (name, is_good) in [
        ("Jacobian", problem.jacobian.iter().all(|x| x.is_finite())),
        ("wanted twist", is_finite(&problem.desired_twist)),
        ("weights", is_finite(&problem.weights)),
        ("joint speeds", problem.current_speeds.is_finite()),
        (
            "bounds",
            problem.lower.is_finite() && problem.upper.is_finite(),
        ),
        ("twist limits", problem.limits.iter().all(|x| *x >= 0.0)),
    ] {
        if !is_good {
            return Err(LimiterError::NotFinite { name });
        }
    }
    for joint in 0..DOF {
        let (lower, upper) = (problem.lower[joint], problem.upper[joint]);
        if lower > upper {
            return Err(LimiterError::InfeasibleBounds {
                joint,
                lower,
                upper,
            });
        }
    }
    Ok(())
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

/// The identity and its negative over J and its negative, column by column.
fn row_matrix(values: Vec<f64>) -> CscMatrix<f64> {
    let a_column = 2 + 2 * DOF;
    let starts = (0..=DOF).map(|column| column * a_column).collect();
    let rows = (0..DOF)
        .flat_map(|column| [column, column + DOF].into_iter().chain(2 * DOF..ROWS))
        .collect();
    CscMatrix::new(ROWS, DOF, starts, rows, values)
}

fn fill_rows(values: &mut [f64], jacobian: &Matrix6<f64>) {
    let entries = (0..DOF).flat_map(|column| {
        let twist = (0..DOF).map(move |row| jacobian[(row, column)]);
        let opposite = (0..DOF).map(move |row| -jacobian[(row, column)]);
        [1.0, -1.0].into_iter().chain(twist).chain(opposite)
    });
    for (slot, value) in values.iter_mut().zip(entries) {
        *slot = value;
    }
}
