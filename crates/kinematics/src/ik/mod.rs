//! Inverse kinematics: from a flange pose to joint positions.
//!
//! Owns the choice between the closed form (all CS arms, and others built alike), iteration from it (calibrated arms)
//! and iteration (everything else), and the choice of one solution near given joint positions. Allocates nothing.

mod closed_form;
mod iterative;
mod refined;
mod side_by_side;

pub use closed_form::ClosedForm;
pub use refined::RefinedClosedForm;

use crate::chain::Chain;
use crate::joint::{DOF, JointPositions};
use crate::model::JointLimits;
use crate::pose::Pose;
use crate::rotation::wrap_angle;
use core::f64::consts::{PI, TAU};
use core::ops::Deref;

/// The most solutions one flange pose can have with the closed form: two shoulders, two wrists, two elbows.
pub const MAX_CLOSED_FORM_SOLUTIONS: usize = closed_form::BRANCHES;

/// The most solutions one flange pose can have with any arm of six turning joints.
pub const MAX_SOLUTIONS: usize = 16;

/// An iterated solution this near (rad², over all joints) to the wanted positions is taken without looking further.
const CONTINUITY_RADIUS_SQUARED: f64 = 0.01;

/// All joint positions that reach one flange pose, wrapped to [-pi, pi), in the order of the manual's example (3.2.3):
/// shoulder branch, within it wrist branch, within it elbow branch.
#[derive(Clone, Copy, Debug, Default)]
pub struct IkSolutions {
    solutions: [JointPositions; MAX_SOLUTIONS],
    count: usize,
}

impl IkSolutions {
    /// Adds a solution; there are no more than [`MAX_SOLUTIONS`].
    fn push(&mut self, q: JointPositions) {
        if let Some(slot) = self.solutions.get_mut(self.count) {
            *slot = q;
            self.count += 1;
        }
    }
}

impl Deref for IkSolutions {
    type Target = [JointPositions];
    fn deref(&self) -> &[JointPositions] {
        &self.solutions[..self.count]
    }
}

impl<'a> IntoIterator for &'a IkSolutions {
    type Item = &'a JointPositions;
    type IntoIter = core::slice::Iter<'a, JointPositions>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// How the inverse kinematics of a chain is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IkMethod {
    /// The chain is exactly (to 1e-12) of the closed form's shape.
    ClosedForm(ClosedForm),
    /// Nearly of that shape (a calibrated arm): the closed form of the nearest shape, then Newton steps on the chain.
    RefinedClosedForm(RefinedClosedForm),
    /// Damped Newton steps, from the wanted positions and from a fixed set of starting points: up to a millisecond, and
    /// a solution may be missed.
    Iterative,
}

impl IkMethod {
    /// The method that fits a chain.
    pub fn of(chain: &Chain) -> Self {
        match RefinedClosedForm::nearest(chain, &[0.0; DOF]) {
            Some((arm, deviation)) if deviation <= closed_form::EXACT => Self::ClosedForm(arm.form),
            Some((arm, deviation)) if deviation <= closed_form::NEARBY => {
                Self::RefinedClosedForm(arm)
            }
            _ => Self::Iterative,
        }
    }

    /// The method that fits the chain of a calibrated arm, whose joints read zero at `theta` (rad) of its model's.
    pub(crate) fn of_calibrated(chain: &Chain, theta: &[f64; DOF]) -> Self {
        match RefinedClosedForm::nearest(chain, theta) {
            Some((arm, deviation)) if deviation <= closed_form::EXACT && *theta == [0.0; DOF] => {
                Self::ClosedForm(arm.form)
            }
            // Calibrations are near their models by the check of their numbers.
            Some((arm, _)) => Self::RefinedClosedForm(arm),
            None => Self::Iterative,
        }
    }

    /// The most solutions that [`Self::all`] can list for this arm.
    pub const fn max_solutions(&self) -> usize {
        match self {
            Self::ClosedForm(_) => MAX_CLOSED_FORM_SOLUTIONS,
            Self::RefinedClosedForm(_) | Self::Iterative => MAX_SOLUTIONS,
        }
    }

    /// Every solution found for a flange pose, joint 6 taken as `free_q6` where the wrist is singular.
    pub fn all(&self, chain: &Chain, base_from_flange: &Pose, free_q6: f64) -> IkSolutions {
        match self {
            Self::ClosedForm(form) => form.solve(chain, base_from_flange, free_q6),
            Self::RefinedClosedForm(arm) => arm.solve(chain, base_from_flange, free_q6),
            Self::Iterative => iterative::search_all(chain, base_from_flange),
        }
    }

    /// The solution that damped steps from `near` lead to, inside the limits; `None` for the closed form, which needs
    /// none.
    fn iterated(
        &self,
        chain: &Chain,
        limits: &JointLimits,
        base_from_flange: &Pose,
        near: &JointPositions,
    ) -> Option<JointPositions> {
        if matches!(self, Self::ClosedForm(_)) {
            return None;
        }
        let q = iterative::refine(chain, base_from_flange, near)?;
        unwrap_towards(&q.map(wrap_angle), near, limits)
    }

    /// The solution for the next place of a path that was at `near`: as [`Self::nearest`], but an iterated arm is not
    /// searched for other branches, so it takes some 10 µs at most.
    pub fn nearest_continuous(
        &self,
        chain: &Chain,
        limits: &JointLimits,
        base_from_flange: &Pose,
        near: &JointPositions,
    ) -> Option<JointPositions> {
        match self {
            Self::ClosedForm(_) => self.nearest(chain, limits, base_from_flange, near),
            _ => self.iterated(chain, limits, base_from_flange, near),
        }
    }

    /// The solution nearest to `near` within the position limits, `None` if there is none.
    ///
    /// Every joint is first moved by whole turns towards `near` inside its limits; then the smallest Euclidean distance
    /// over the six joints wins, the first in list order among equals (the manual, 3.2.1, names no measure: our
    /// choice). Where the wrist is singular, joint 6 keeps its value in `near`.
    pub fn nearest(
        &self,
        chain: &Chain,
        limits: &JointLimits,
        base_from_flange: &Pose,
        near: &JointPositions,
    ) -> Option<JointPositions> {
        // Following a path, the next solution is right here: no need to look at every branch.
        let beside = self.iterated(chain, limits, base_from_flange, near);
        if let Some(q) = beside.filter(|q| q.distance_squared(near) < CONTINUITY_RADIUS_SQUARED) {
            return Some(q);
        }
        let mut best = beside.map(|q| (q.distance_squared(near), q));
        let consider = |best: &mut Option<(f64, JointPositions)>, q: &JointPositions| {
            if let Some(q) = unwrap_towards(q, near, limits) {
                let distance = q.distance_squared(near);
                if best.is_none_or(|(least, _)| distance < least) {
                    *best = Some((distance, q));
                }
            }
        };
        if *self == Self::Iterative {
            // No need to list them, nor to find out which are the same.
            iterative::search(chain, base_from_flange, |q| consider(&mut best, &q));
        } else {
            for q in &self.all(chain, base_from_flange, near[DOF - 1]) {
                consider(&mut best, q);
            }
        }
        best.map(|(_, q)| q)
    }
}

/// `q` with each joint moved by whole turns as near to `near` as its limits allow; `None` if no turn is inside them.
pub fn unwrap_towards(
    q: &JointPositions,
    near: &JointPositions,
    limits: &JointLimits,
) -> Option<JointPositions> {
    // A wrapped angle of -pi stands for an elbow limit of pi as well; rounding must not push it out.
    const SLACK: f64 = 1e-9;
    let mut turned = *q;
    for joint in 0..DOF {
        let (min, max) = (limits.position_min[joint], limits.position_max[joint]);
        let inside = |x: f64| x >= min - SLACK && x <= max + SLACK;
        let apart = near[joint] - q[joint];
        let mut x = q[joint];
        if apart.abs() > PI {
            x += (apart / TAU).round() * TAU;
        }
        if !inside(x) {
            let fewest = ((min - SLACK - q[joint]) / TAU).ceil();
            let most = ((max + SLACK - q[joint]) / TAU).floor();
            if fewest > most {
                return None;
            }
            x = q[joint] + (apart / TAU).round().max(fewest).min(most) * TAU;
        }
        turned[joint] = x.clamp(min, max);
    }
    Some(turned)
}
