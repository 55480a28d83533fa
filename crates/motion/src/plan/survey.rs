//! Looking along a Cartesian line before it is followed: is it possible, and what does it ask of the joints where?
//!
//! The line is walked from its start with the nearest solution of the inverse kinematics at each place; where the joints
//! change fast the steps are halved. What is kept are the limits of each interval. The walk can be interrupted after any number of places and be continued in the next cycle.

use kinematics::{JointPositions, JointSpeeds, RobotModel};
use motion_api::{PathFault, Refusal};

use super::able::{Bounds, largest_bend};
use super::direction::Direction;
use super::{Arm, Cells, Wish};
use crate::config::MotionLimits;
use crate::constants::{
    CELLS_OF_LEG, EVEN_BENDS, EvenBends, LINE_INTERVALS, LINE_PLACES_MAX, LINE_REFINEMENTS,
    PLACES_PER_INTERVAL, SINGULAR_TURN_PER_M,
};
use crate::path::{PathPoint, TcpWay};
use crate::self_collision::LinkWatch;
use crate::setpoint::elbow_speed;

/// A walk along a line.
#[derive(Clone, Copy, Debug)]
pub struct Survey {
    /// Smallest steps in the whole line.
    steps: u32,
    /// The place up to which the line is known.
    left: PathPoint,
    /// Ends of the intervals that were halved, as numbers of smallest steps; the nearest is last.
    ahead: [u32; LINE_REFINEMENTS + 1],
    ahead_count: usize,
    /// `left` in smallest steps.
    left_step: u32,
    places: u32,
    most_places: u32,
    /// What the intervals since the last cell ask for, and how many there are, and are in a cell.
    bounds: Bounds,
    since_cell: u32,
    per_cell: u32,
    watch: LinkWatch,
    /// The line leads in a direction, as far as the arm can go.
    direction: Option<Direction>,
}

impl Survey {
    /// At the start of the line, where the arm stands at `q`.
    ///
    /// # Errors
    /// The arm stands in a singular position.
    pub fn new(line: &impl TcpWay, q: JointPositions, arm: &Arm) -> Result<Self, Refusal> {
        let model = arm.model;
        let left = line.point(model, 0.0, q).ok_or_else(|| Refusal::Path {
            fraction: 0.0,
            fault: singularity(line, 0.0, &q, model),
        })?;
        let intervals = line.intervals();
        Ok(Self {
            steps: (intervals as u32) << LINE_REFINEMENTS,
            left,
            ahead: [0; LINE_REFINEMENTS + 1],
            ahead_count: 0,
            left_step: 0,
            places: 0,
            most_places: LINE_PLACES_MAX.max(PLACES_PER_INTERVAL * intervals as u32),
            bounds: Bounds::NONE,
            since_cell: 0,
            // Half of the cells are for where intervals are halved.
            per_cell: (2 * intervals).div_ceil(CELLS_OF_LEG) as u32,
            watch: LinkWatch::from(model, arm.limits.link_overlap, &q),
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
    pub(super) fn end_here(&mut self, wish: &Wish, arm: &Arm, cells: &mut Cells) -> f64 {
        if self.since_cell > 0 {
            cells.push(self.left.s, self.bounds.limits(wish, arm.limits));
            self.since_cell = 0;
        }
        self.left.s
    }

    /// The joint positions up to where the walk has come: at the line's end once it is done.
    pub fn reached(&self) -> JointPositions {
        self.left.q
    }

    /// Looks at up to `places` places more; true when the end is reached.
    ///
    /// # Errors
    /// Where and why the line cannot be followed.
    pub fn walk(
        &mut self,
        line: &impl TcpWay,
        places: usize,
        wish: &Wish,
        arm: &Arm,
        cells: &mut Cells,
    ) -> Result<bool, Refusal> {
        for _ in 0..places {
            if self.left_step >= self.steps {
                return Ok(true);
            }
            self.places += 1;
            if self.places > self.most_places {
                let fault = singularity(line, self.left.s, &self.left.q, arm.model);
                return Err(self.refusal(self.left_step, fault));
            }
            let step = self.next_step();
            let s = line.length() * (f64::from(step) / f64::from(self.steps));
            let reached = line.positions(arm.model, s, &self.left.q);
            let right = reached.and_then(|q| line.point(arm.model, s, q));
            let forbidden = self.direction.zip(reached);
            let forbidden = forbidden.and_then(|(direction, q)| direction.forbids(&q, arm));
            match right {
                // Halving narrows down where that begins.
                _ if let Some(fault) = forbidden => {
                    if !self.halve(step) {
                        return Err(self.refusal(step, fault));
                    }
                }
                Some(right)
                    if is_smooth(&self.left, &right)
                        && self
                            .evenness(step, right.s - self.left.s)
                            .is_none_or(|change| {
                                is_even(&self.left, &right, change, wish, arm)
                            }) =>
                {
                    if let Some(found) = self.watch.look(&right.q, arm.model) {
                        return Err(self.refusal(step, found.into()));
                    }
                    self.accept(line, step, right, wish, arm, cells);
                }
                // Halving also narrows down where the line becomes impossible.
                _ if self.halve(step) => {}
                _ if reached.is_some() => {
                    return Err(self.refusal(step, self.why_jump(line, s, arm)));
                }
                _ => return Err(self.refusal(step, self.why_not(line, s, arm))),
            }
        }
        Ok(self.left_step >= self.steps)
    }

    /// The end of the interval to look at next.
    fn next_step(&mut self) -> u32 {
        if self.ahead_count == 0 {
            let whole = 1 << LINE_REFINEMENTS;
            self.push((self.left_step / whole + 1) * whole);
        }
        self.ahead
            .get(self.ahead_count - 1)
            .copied()
            .unwrap_or(self.steps)
    }

    fn push(&mut self, step: u32) {
        if let Some(slot) = self.ahead.get_mut(self.ahead_count) {
            *slot = step;
            self.ahead_count += 1;
        }
    }

    /// By how much bends may change in an interval of a length, lest it is worth halving though it could do: more in one that was
    /// halved often, and only where it is still long, because places take time. `None` where it is never worth that.
    fn evenness(&self, step: u32, length: f64) -> Option<f64> {
        let whole = 1 << LINE_REFINEMENTS;
        let is_short_list = self.steps <= (LINE_INTERVALS as u32) * whole;
        let way = step - self.left_step;
        let EvenBends {
            change,
            halvings,
            last,
            ..
        } = EVEN_BENDS;
        if !is_short_list || way <= whole >> halvings {
            None
        } else if way > whole >> (halvings - 1) {
            Some(change)
        } else {
            (length > last.length).then_some(last.change)
        }
    }

    /// Looks at the middle first; false when the interval is the smallest already.
    fn halve(&mut self, step: u32) -> bool {
        let way = step - self.left_step;
        if way < 2 {
            return false;
        }
        self.push(self.left_step + way / 2);
        true
    }

    fn accept(
        &mut self,
        line: &impl TcpWay,
        step: u32,
        right: PathPoint,
        wish: &Wish,
        arm: &Arm,
        cells: &mut Cells,
    ) {
        let elbow = self.elbow_per_s(&right, arm);
        self.bounds.cover(&self.left, &right, elbow, arm);
        let tcp = line.tcp_per_s(self.left.s).max(line.tcp_per_s(right.s));
        self.bounds.tcp = self.bounds.tcp.max(tcp);
        self.since_cell += 1;
        if self.since_cell >= self.per_cell || step >= self.steps {
            cells.push(right.s, self.bounds.limits(wish, arm.limits));
            self.bounds = Bounds::NONE;
            self.since_cell = 0;
        }
        self.left = right;
        self.left_step = step;
        self.ahead_count -= 1;
    }

    /// How far the elbow goes per s at most on the way to a place; 0 when nobody asks.
    ///
    /// Looked at on both ends and in the middle, where cubics with the ends' derivatives give the joints; between those
    /// three a parabola rises by no more than an eighth of their second difference.
    fn elbow_per_s(&self, right: &PathPoint, arm: &Arm) -> f64 {
        if arm.limits.elbow_speed.is_infinite() {
            return 0.0;
        }
        let left = &self.left;
        let way = right.s - left.s;
        let at = |q: &JointPositions, first: [f64; 6]| {
            elbow_speed(&arm.model.forward(q), &JointSpeeds(first))
        };
        let q = JointPositions(core::array::from_fn(|joint| {
            let bend = left.first[joint] - right.first[joint];
            (left.q[joint] + right.q[joint]) / 2.0 + way * bend / 8.0
        }));
        let first = core::array::from_fn(|joint| {
            let mean = (right.q[joint] - left.q[joint]) / way;
            1.5 * mean - (left.first[joint] + right.first[joint]) / 4.0
        });
        let (begin, middle, end) = (
            at(&left.q, left.first),
            at(&q, first),
            at(&right.q, right.first),
        );
        begin.max(middle).max(end) + (begin - 2.0 * middle + end).abs() / 8.0
    }

    fn refusal(&self, step: u32, fault: PathFault) -> Refusal {
        Refusal::Path {
            fraction: f64::from(step) / f64::from(self.steps),
            fault,
        }
    }

    /// Why no solution inside the limits reaches the place.
    fn why_not(&self, line: &impl TcpWay, s: f64, arm: &Arm) -> PathFault {
        self.joint_limit(line, s, arm)
            .unwrap_or(PathFault::OutOfReach)
    }

    /// Why the joints do not go on smoothly.
    fn why_jump(&self, line: &impl TcpWay, s: f64, arm: &Arm) -> PathFault {
        self.joint_limit(line, s, arm)
            .unwrap_or_else(|| singularity(line, self.left.s, &self.left.q, arm.model))
    }

    /// The joint limit that the solution without limits would break, if that solution goes on smoothly.
    fn joint_limit(&self, line: &impl TcpWay, s: f64, arm: &Arm) -> Option<PathFault> {
        let unlimited = free_limits(arm.limits);
        let base_from_flange = line.pose(s) * line.flange_from_tcp().inverse();
        let model = arm.model;
        let q = model.ik_method().nearest(
            model.chain(),
            &unlimited.narrowed(model.limits()),
            &base_from_flange,
            &self.left.q,
        )?;
        let moved = q.distance_squared(&self.left.q).sqrt();
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
fn singularity(line: &impl TcpWay, s: f64, q: &JointPositions, model: &RobotModel) -> PathFault {
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

fn free_limits(limits: &MotionLimits) -> MotionLimits {
    MotionLimits {
        position_min: JointPositions([f64::MIN / 4.0; 6]),
        position_max: JointPositions([f64::MAX / 4.0; 6]),
        ..*limits
    }
}

/// True when the joints' ways bend alike between two places, or so little that the wanted speed does not suffer: a cell between
/// them is worth what the largest bend allows.
fn is_even(left: &PathPoint, right: &PathPoint, change: f64, wish: &Wish, arm: &Arm) -> bool {
    let square = wish.speed * wish.speed;
    wish.duration > 0.0
        || (0..6).all(|joint| {
            let (a, b) = (left.second[joint], right.second[joint]);
            let bend = largest_bend(left, right, joint);
            let least = a.abs().min(b.abs());
            let most = arm.limits.acceleration[joint];
            bend * square <= EVEN_BENDS.least * most || a * b > 0.0 && bend - least <= change * bend
        })
}

/// True when the joints between two places are well described by what is known at both.
///
/// Close to where two branches of solutions meet, one goes on in the other as if nothing were, but for a bend that is shorter
/// than the interval: whoever follows the way step by step stays in the branch, so it has to be the same on both sides.
fn is_smooth(left: &PathPoint, right: &PathPoint) -> bool {
    let way = right.s - left.s;
    let is_one_branch = left.branch == right.branch;
    is_one_branch
        && (0..6).all(|joint| {
            let (a, b) = (left.first[joint], right.first[joint]);
            let turned = right.q[joint] - left.q[joint];
            let expected =
                way * ((a + b) / 2.0 + way * (left.second[joint] - right.second[joint]) / 12.0);
            let change = (b - a).abs();
            a.abs().max(b.abs()) <= SINGULAR_TURN_PER_M
            && (turned - expected).abs() <= 1e-3 + 1e-2 * turned.abs()
            // A joint that hardly turns may change its mind; one that turns fast must do so evenly.
            && change <= 0.25 * a.abs().max(b.abs()) + 0.25
        })
}
