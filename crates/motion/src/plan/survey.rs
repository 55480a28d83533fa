//! Looking along a Cartesian line before it is followed: is it possible, and what does it ask of the joints where?
//!
//! The line is walked from its start with the nearest solution of the inverse kinematics at each place; where the
//! joints change fast the steps are halved. What is kept are the limits of each interval. The walk can be interrupted
//! after any number of places and be continued in the next cycle.

use kinematics::{JointPositions, JointSpeeds, RobotModel};
use motion_api::{PathFault, Refusal};

use super::able::{DerivativeBounds, max_second_derivative};
use super::direction::Direction;
use super::{MotionRequest, PlanningContext, SegmentLimits};
use crate::config::MotionLimits;
use crate::constants::{
    CURVATURE_REFINEMENT, CurvatureRefinement, LINE_INTERVALS, MAX_BISECTIONS,
    MAX_INTERVALS_PER_SEGMENT, MAX_PATH_SAMPLES, SAMPLES_PER_INTERVAL, SINGULAR_TURN_PER_M,
};
use crate::path::{PathPoint, TcpPath};
use crate::self_collision::SelfCollisionMonitor;
use crate::setpoint::elbow_speed;

/// A walk along a line.
#[derive(Clone, Copy, Debug)]
pub struct PathScan {
    /// Smallest steps in the whole line.
    steps: u32,
    /// The place up to which the line is known.
    previous: PathPoint,
    /// Ends of the intervals that were halved, as numbers of smallest steps; the nearest is last.
    pending_ends: [u32; MAX_BISECTIONS + 1],
    ahead_count: usize,
    /// `previous` in smallest steps.
    left_step: u32,
    sample_count: u32,
    max_samples: u32,
    /// What the intervals since the last cell ask for, and how many there are, and are in a cell.
    bounds: DerivativeBounds,
    intervals_pending: u32,
    intervals_per_limit: u32,
    watch: SelfCollisionMonitor,
    /// The line leads in a direction, as far as the arm can go.
    direction: Option<Direction>,
}

impl PathScan {
    /// At the start of the line, where the arm stands at `q`.
    ///
    /// # Errors
    /// The arm stands in a singular position.
    pub fn new(
        line: &impl TcpPath,
        q: JointPositions,
        arm: &PlanningContext,
    ) -> Result<Self, Refusal> {
        let model = arm.model;
        let left = line.point(model, 0.0, q).ok_or_else(|| Refusal::Path {
            fraction: 0.0,
            fault: singularity(line, 0.0, &q, model),
        })?;
        let intervals = line.intervals();
        Ok(Self {
            steps: (intervals as u32) << MAX_BISECTIONS,
            previous: left,
            pending_ends: [0; MAX_BISECTIONS + 1],
            ahead_count: 0,
            left_step: 0,
            sample_count: 0,
            max_samples: MAX_PATH_SAMPLES.max(SAMPLES_PER_INTERVAL * intervals as u32),
            bounds: DerivativeBounds::NONE,
            intervals_pending: 0,
            // Half of the cells are for where intervals are halved.
            intervals_per_limit: (2 * intervals).div_ceil(MAX_INTERVALS_PER_SEGMENT) as u32,
            watch: SelfCollisionMonitor::starting_at(model, arm.limits.link_overlap, &q),
            direction: None,
        })
    }

    /// A survey along a line that leads in a direction, which ends where the arm can go no further.
    pub(super) fn towards(self, direction: Direction) -> Self {
        Self {
            direction: Some(direction),
            ..self
        }
    }

    /// Ends the line where the walk has come to; the place.
    pub(super) fn end_here(
        &mut self,
        wish: &MotionRequest,
        arm: &PlanningContext,
        cells: &mut SegmentLimits,
    ) -> f64 {
        if self.intervals_pending > 0 {
            cells.push(
                self.previous.s,
                self.bounds.interval_limits(wish, arm.limits),
            );
            self.intervals_pending = 0;
        }
        self.previous.s
    }

    /// The joint positions up to where the walk has come: at the line's end once it is done.
    pub fn last_joint_positions(&self) -> JointPositions {
        self.previous.q
    }

    /// Looks at up to `sample_count` places more; true when the end is reached.
    ///
    /// # Errors
    /// Where and why the line cannot be followed.
    pub fn advance(
        &mut self,
        line: &impl TcpPath,
        places: usize,
        wish: &MotionRequest,
        arm: &PlanningContext,
        cells: &mut SegmentLimits,
    ) -> Result<bool, Refusal> {
        for _ in 0..places {
            if self.left_step >= self.steps {
                return Ok(true);
            }
            self.sample_count += 1;
            if self.sample_count > self.max_samples {
                let fault = singularity(line, self.previous.s, &self.previous.q, arm.model);
                return Err(self.refusal(self.left_step, fault));
            }
            let step = self.next_step();
            let s = line.length() * (f64::from(step) / f64::from(self.steps));
            let reached = line.positions(arm.model, s, &self.previous.q);
            let right = reached.and_then(|q| line.point(arm.model, s, q));
            let forbidden = self.direction.zip(reached);
            let forbidden = forbidden.and_then(|(direction, q)| direction.forbids(&q, arm));
            match right {
                // Halving narrows down where that begins.
                _ if let Some(fault) = forbidden => {
                    if !self.bisect(step) {
                        return Err(self.refusal(step, fault));
                    }
                }
                Some(right)
                    if is_smooth(&self.previous, &right)
                        && self
                            .allowed_curvature_change(step, right.s - self.previous.s)
                            .is_none_or(|change| {
                                has_uniform_curvature(&self.previous, &right, change, wish, arm)
                            }) =>
                {
                    if let Some(found) = self.watch.check(&right.q, arm.model) {
                        return Err(self.refusal(step, found.into()));
                    }
                    self.accept_interval(line, step, right, wish, arm, cells);
                }
                // Halving also narrows down where the line becomes impossible.
                _ if self.bisect(step) => {}
                _ if reached.is_some() => {
                    return Err(self.refusal(step, self.discontinuity_fault(line, s, arm)));
                }
                _ => return Err(self.refusal(step, self.unreachable_fault(line, s, arm))),
            }
        }
        Ok(self.left_step >= self.steps)
    }

    /// The end of the interval to look at next.
    fn next_step(&mut self) -> u32 {
        if self.ahead_count == 0 {
            let whole = 1 << MAX_BISECTIONS;
            self.push((self.left_step / whole + 1) * whole);
        }
        self.pending_ends
            .get(self.ahead_count - 1)
            .copied()
            .unwrap_or(self.steps)
    }

    fn push(&mut self, step: u32) {
        if let Some(slot) = self.pending_ends.get_mut(self.ahead_count) {
            *slot = step;
            self.ahead_count += 1;
        }
    }

    /// By how much bends may change in an interval of a length, lest it is worth halving though it could do: more in
    /// one that was halved often, and only where it is still long, because places take time. `None` where it is never
    /// worth that.
    fn allowed_curvature_change(&self, step: u32, length: f64) -> Option<f64> {
        let whole = 1 << MAX_BISECTIONS;
        let is_short_list = self.steps <= (LINE_INTERVALS as u32) * whole;
        let way = step - self.left_step;
        let CurvatureRefinement {
            change,
            halvings,
            last,
            ..
        } = CURVATURE_REFINEMENT;
        if !is_short_list || way <= whole >> halvings {
            None
        } else if way > whole >> (halvings - 1) {
            Some(change)
        } else {
            (length > last.length).then_some(last.change)
        }
    }

    /// Looks at the middle first; false when the interval is the smallest already.
    fn bisect(&mut self, step: u32) -> bool {
        let way = step - self.left_step;
        if way < 2 {
            return false;
        }
        self.push(self.left_step + way / 2);
        true
    }

    fn accept_interval(
        &mut self,
        line: &impl TcpPath,
        step: u32,
        right: PathPoint,
        wish: &MotionRequest,
        arm: &PlanningContext,
        cells: &mut SegmentLimits,
    ) {
        let elbow = self.elbow_per_s(&right, arm);
        self.bounds
            .include_interval(&self.previous, &right, elbow, arm);
        let tcp = line
            .tcp_speed_factor(self.previous.s)
            .max(line.tcp_speed_factor(right.s));
        self.bounds.tcp = self.bounds.tcp.max(tcp);
        self.intervals_pending += 1;
        if self.intervals_pending >= self.intervals_per_limit || step >= self.steps {
            cells.push(right.s, self.bounds.interval_limits(wish, arm.limits));
            self.bounds = DerivativeBounds::NONE;
            self.intervals_pending = 0;
        }
        self.previous = right;
        self.left_step = step;
        self.ahead_count -= 1;
    }

    /// How far the elbow goes per s at most on the way to a place; 0 when nobody asks.
    ///
    /// Looked at on both ends and in the middle, where cubics with the ends' derivatives give the joints; between those
    /// three a parabola rises by no more than an eighth of their second difference.
    fn elbow_per_s(&self, right: &PathPoint, arm: &PlanningContext) -> f64 {
        if arm.limits.elbow_speed.is_infinite() {
            return 0.0;
        }
        let left = &self.previous;
        let way = right.s - left.s;
        let at = |q: &JointPositions, first: [f64; 6]| {
            elbow_speed(&arm.model.forward(q), &JointSpeeds(first))
        };
        let q = JointPositions(core::array::from_fn(|joint| {
            let bend = left.dq_ds[joint] - right.dq_ds[joint];
            (left.q[joint] + right.q[joint]) / 2.0 + way * bend / 8.0
        }));
        let first = core::array::from_fn(|joint| {
            let mean = (right.q[joint] - left.q[joint]) / way;
            1.5 * mean - (left.dq_ds[joint] + right.dq_ds[joint]) / 4.0
        });
        let (begin, middle, end) = (
            at(&left.q, left.dq_ds),
            at(&q, first),
            at(&right.q, right.dq_ds),
        );
        begin.max(middle).max(end) + (begin - 2.0 * middle + end).abs() / 8.0
    }

    fn refusal(&self, step: u32, fault: PathFault) -> Refusal {
        Refusal::Path {
            fraction: f64::from(step) / f64::from(self.steps),
            fault,
        }
    }

    /// The reason for which no solution inside the limits reaches the place.
    fn unreachable_fault(&self, line: &impl TcpPath, s: f64, arm: &PlanningContext) -> PathFault {
        self.joint_limit(line, s, arm)
            .unwrap_or(PathFault::OutOfReach)
    }

    /// The reason for which the joints do not go on smoothly.
    fn discontinuity_fault(&self, line: &impl TcpPath, s: f64, arm: &PlanningContext) -> PathFault {
        self.joint_limit(line, s, arm)
            .unwrap_or_else(|| singularity(line, self.previous.s, &self.previous.q, arm.model))
    }

    /// The joint limit that the solution without limits would break, if that solution goes on smoothly.
    fn joint_limit(&self, line: &impl TcpPath, s: f64, arm: &PlanningContext) -> Option<PathFault> {
        let unlimited = without_position_limits(arm.limits);
        let base_from_flange = line.pose(s) * line.flange_from_tcp().inverse();
        let model = arm.model;
        let q = model.ik_method().nearest(
            model.chain(),
            &unlimited.applied_to(model.limits()),
            &base_from_flange,
            &self.previous.q,
        )?;
        let moved = q.distance_squared(&self.previous.q).sqrt();
        if moved > JUMP {
            return None;
        }
        (0u8..6).zip(0..).find_map(|(number, joint): (u8, usize)| {
            let (value, min, max) = (
                q[joint],
                arm.limits.position_min[joint],
                arm.limits.position_max[joint],
            );
            (value < min || value > max).then_some(PathFault::JointLimit {
                joint: number,
                value,
                min,
                max,
            })
        })
    }
}

/// The singular position after the place `s`: the joint that turns most on the next interval, and how far.
fn singularity(line: &impl TcpPath, s: f64, q: &JointPositions, model: &RobotModel) -> PathFault {
    let beyond = (s + line.length() / LINE_INTERVALS as f64).min(line.length());
    let Some(there) = line.positions(model, beyond, q) else {
        return PathFault::OutOfReach;
    };
    let mut fault = PathFault::Singular {
        joint: 0,
        jump: 0.0,
    };
    let mut most = 0.0;
    for (joint, number) in (0u8..6).enumerate() {
        let jump = (there[joint] - q[joint]).abs();
        if jump > most {
            most = jump;
            fault = PathFault::Singular {
                joint: number,
                jump,
            };
        }
    }
    fault
}

/// A turn between two neighbouring places, rad, beyond which it is another branch of solutions.
const JUMP: f64 = 0.5;

fn without_position_limits(limits: &MotionLimits) -> MotionLimits {
    MotionLimits {
        position_min: JointPositions([f64::MIN / 4.0; 6]),
        position_max: JointPositions([f64::MAX / 4.0; 6]),
        ..*limits
    }
}

/// True when the joints' ways bend alike between two places, or so little that the wanted speed does not suffer: a cell
/// between them is worth what the largest bend allows.
fn has_uniform_curvature(
    left: &PathPoint,
    right: &PathPoint,
    change: f64,
    wish: &MotionRequest,
    arm: &PlanningContext,
) -> bool {
    let square = wish.speed * wish.speed;
    wish.duration > 0.0
        || (0..6).all(|joint| {
            let (a, b) = (left.d2q_ds2[joint], right.d2q_ds2[joint]);
            let bend = max_second_derivative(left, right, joint);
            let least = a.abs().min(b.abs());
            let most = arm.limits.acceleration[joint];
            bend * square <= CURVATURE_REFINEMENT.least * most
                || a * b > 0.0 && bend - least <= change * bend
        })
}

/// True when the joints between two places are well described by what is known at both.
///
/// Close to where two branches of solutions meet, one goes on in the other as if nothing were, but for a bend that is
/// shorter than the interval: whoever follows the way step by step stays in the branch, so it has to be the same on
/// both sides.
fn is_smooth(left: &PathPoint, right: &PathPoint) -> bool {
    let way = right.s - left.s;
    let is_one_branch = left.branch == right.branch;
    is_one_branch
        && (0..6).all(|joint| {
            let (a, b) = (left.dq_ds[joint], right.dq_ds[joint]);
            let turned = right.q[joint] - left.q[joint];
            let expected =
                way * ((a + b) / 2.0 + way * (left.d2q_ds2[joint] - right.d2q_ds2[joint]) / 12.0);
            let change = (b - a).abs();
            a.abs().max(b.abs()) <= SINGULAR_TURN_PER_M
            && (turned - expected).abs() <= 1e-3 + 1e-2 * turned.abs()
            // A joint that hardly turns may change its mind; one that turns fast must do so evenly.
            && change <= 0.25 * a.abs().max(b.abs()) + 0.25
        })
}
