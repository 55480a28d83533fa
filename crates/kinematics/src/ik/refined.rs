//! Every solution of an arm that is nearly of the closed form's shape: a calibrated one.
//!
//! Owns where to look. A solution of such an arm lies beside one of the nearest arm that has a closed form. Away from
//! that arm's singularities each of its branches leads to one solution. Where two branches meet (straight or folded
//! elbow, wrist at its least distance from the base axis) they may be there for one arm and not for the other, so
//! places to either side are tried. Where axes 4 and 6 are nearly parallel, joint 6 can be anywhere: the whole turn is.

use super::closed_form::{BRANCHES, ClosedForm, Margin, NewtonSeeds};
use super::side_by_side::{Lane, newton, newton_with_fixed_q6};
use super::{IkSolutions, iterative};
use crate::chain::Chain;
use crate::joint::{DOF, JointPositions};
use crate::pose::Pose;
use crate::rotation::wrap_angle;
use crate::trig;
use core::f64::consts::TAU;
use nalgebra::{Matrix3, Rotation3};

/// Remaining error (m and rad) at which a solution counts.
const TOLERANCE: f64 = 1e-11;
/// Two solutions nearer to each other than this (rad) are the same.
const SAME: f64 = 1e-6;
/// Sine of the angle between axes 4 and 6 below which they count as parallel: joint 6 is free.
const PARALLEL: f64 = 1e-9;
/// Borders may be so many times further from the form's than a single length or angle is.
const MARGIN: f64 = 12.0;
/// The widest margins, m and sine.
const LENGTH_MAX: f64 = 0.1;
const SINE_MAX: f64 = 0.4;
/// Where places near a border are put, as parts of the margin; the first for all poses, the others where one is near.
const BORDER_OFFSETS: [f64; 4] = [1.0, 0.1, 0.01, 4.0];
/// Newton steps from places side by side; those that need more go on by themselves.
const STEPS: usize = 8;
/// Newton steps from places that are many and mostly lead nowhere.
const STEPS_OF_MANY: usize = 24;
/// Least motion of the flange (m and rad) for a turn of a radian below which a solution may have another beside it.
const NEARLY_SINGULAR: f64 = 0.1;
/// How far away that second solution may be, rad: places a little further are tried.
const TWIN_STEPS: [f64; 4] = [0.002, 0.02, 0.1, 0.5];
/// A solution this near to a branch of the form, rad, belongs to it.
const BRANCH_RADIUS: f64 = 0.8;
/// Places around the turn of joint 6.
const RING: usize = 16;
/// How many places of the ring are looked at side by side: each of them takes a lane for either elbow.
const FIXED_Q6_LANES: usize = BRANCHES / 2;
/// Around the turn with joint 6 held, this much (m and rad) may be missing.
const FIXED_Q6_TOLERANCE: f64 = 1e-6;

/// An arm nearly of the closed form's shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefinedClosedForm {
    /// The nearest arm that has a closed form.
    pub form: ClosedForm,
    /// What the joints of that arm read when those of this one read zero, rad.
    offsets: [f64; DOF],
    margin: Margin,
}

impl RefinedClosedForm {
    /// The nearest form to a chain whose joints carry offsets, and how far the chain is from it; `None` as
    /// [`ClosedForm::nearest`].
    pub(super) fn nearest(chain: &Chain, theta: &[f64; DOF]) -> Option<(Self, f64)> {
        let mut plain = *chain;
        let (sines, cosines) = trig::sin_cos(theta);
        let mut offsets = *theta;
        // The first transform may be anything, so the first offset is part of it.
        offsets[0] = 0.0;
        for joint in 1..DOF {
            let (s, c) = (sines[joint], cosines[joint]);
            let back = Matrix3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
            let rotation = &mut plain.parent_from_joint[joint].rotation;
            *rotation = Rotation3::from_matrix_unchecked(rotation.matrix() * back);
        }
        let (form, deviation) = ClosedForm::nearest(&plain)?;
        // An angle moves what is a metre away by as much; a length turns a link the more the shorter it is.
        let link = form.a2.abs().min(form.a3.abs()).min(1.0);
        let length = (MARGIN * deviation).clamp(1e-9, LENGTH_MAX);
        let margin = Margin {
            length,
            inside: length * BORDER_OFFSETS[0],
            sine: (MARGIN * deviation / link).clamp(1e-9, SINE_MAX),
        };
        let refined = Self {
            form,
            offsets,
            margin,
        };
        Some((refined, deviation))
    }

    /// All solutions, each in [-pi, pi), in the order of the branches they were reached from; those that only a place
    /// beside a singularity led to come last. Where axes 4 and 6 are exactly parallel, joint 6 is near `free_q6`.
    pub(super) fn solve(
        &self,
        chain: &Chain,
        base_from_flange: &Pose,
        free_q6: f64,
    ) -> IkSolutions {
        let mut search = SolutionSearch {
            arm: self,
            chain,
            base_from_flange,
            target: chain.parent_from_joint[0].inverse()
                * *base_from_flange
                * chain.joint6_from_flange.inverse(),
            found: IkSolutions::default(),
        };
        let Some(starts) = search.starts(&self.margin, None) else {
            return search.found;
        };
        if starts.border_is_near || starts.wrist_is_near.contains(&true) {
            search.search_near_singularity(&starts, free_q6);
        } else {
            search.add(&starts.q, &starts.is_reachable);
        }
        search.found
    }
}

struct SolutionSearch<'a> {
    arm: &'a RefinedClosedForm,
    chain: &'a Chain,
    base_from_flange: &'a Pose,
    /// Joint frame 6 in frame 1 at rest.
    target: Pose,
    found: IkSolutions,
}

fn place(lanes: &[Lane; DOF], branch: usize) -> JointPositions {
    JointPositions(core::array::from_fn(|joint| lanes[joint][branch]))
}

impl SolutionSearch<'_> {
    /// The form's branches as this arm's joints read them.
    fn starts(&self, margin: &Margin, free_q6: Option<f64>) -> Option<NewtonSeeds> {
        let free_q6 = free_q6.map(|q6| q6 + self.arm.offsets[DOF - 1]);
        let mut starts = self.arm.form.newton_seeds(&self.target, margin, free_q6)?;
        for (lane, offset) in starts.q.iter_mut().zip(&self.arm.offsets) {
            for q in lane {
                *q -= offset;
            }
        }
        Some(starts)
    }

    /// Adds the solutions that these places lead to.
    fn add(&mut self, places: &[Lane; DOF], used: &[bool; BRANCHES]) {
        let mut q = *places;
        let left = newton(self.chain, &self.target, &mut q, used, STEPS);
        for branch in (0..BRANCHES).filter(|branch| used[*branch]) {
            let solution = if left.error[branch] < TOLERANCE {
                Some(place(&q, branch))
            } else {
                iterative::refine(self.chain, self.base_from_flange, &place(places, branch))
            };
            if let Some(q) = solution {
                self.push(q.map(wrap_angle));
            }
        }
    }

    /// Near a singularity: from the branches as well, and from other places.
    #[cold]
    fn search_near_singularity(&mut self, starts: &NewtonSeeds, free_q6: f64) {
        for shoulder in 0..2 {
            if starts.wrist_is_near[shoulder] {
                self.search_q6_circle(shoulder, free_q6);
            }
        }
        self.add(&starts.q, &starts.is_reachable);
        if starts.border_is_near {
            self.search_across_branch_limits(starts, free_q6);
        }
        self.add_paired_solutions();
        // Solutions come and go in pairs: one of an odd number stands alone.
        if self.found.is_empty() || self.found.len() % 2 == 1 {
            iterative::search(self.chain, self.base_from_flange, |q| self.push(q));
        }
        self.found.sort_by_nearest_seed(starts);
    }

    /// From places to either side of where two branches meet, at several distances, and all around where the wrist is
    /// singular as well.
    fn search_across_branch_limits(&mut self, starts: &NewtonSeeds, free_q6: f64) {
        let both = starts.wrist_is_near.contains(&true);
        for inside in BORDER_OFFSETS {
            let margin = Margin {
                inside: inside * self.arm.margin.length,
                ..self.arm.margin
            };
            if inside != BORDER_OFFSETS[0]
                && let Some(starts) = self.starts(&margin, None)
            {
                self.add(&starts.q, &starts.is_reachable);
            }
            for at in 0..if both { RING } else { 0 } {
                let q6 = free_q6 + TAU * at as f64 / RING as f64;
                let Some(mut starts) = self.starts(&margin, Some(q6)) else {
                    continue;
                };
                for branch in 0..BRANCHES {
                    // Exactly in the singularity joint 5 would be moved by second order only.
                    starts.q[4][branch] += self.arm.margin.sine;
                    starts.is_reachable[branch] &= starts.wrist_is_near[branch / 4];
                }
                self.add_converging(&mut starts.q, &starts.is_reachable);
            }
        }
    }

    /// Solutions that are about to meet lie opposite each other along the direction in which the arm hardly moves its
    /// flange: from one the other is found.
    fn add_paired_solutions(&mut self) {
        let mut at = 0;
        while let Some(q) = self.found.get(at).copied() {
            at += 1;
            let frames = self.chain.forward(&q);
            let jacobian = frames.jacobian(frames.base_from_flange.translation);
            let eigen = (jacobian.transpose() * jacobian).symmetric_eigen();
            let least = eigen.eigenvalues.imin();
            if eigen.eigenvalues[least] > NEARLY_SINGULAR * NEARLY_SINGULAR {
                continue;
            }
            let along = eigen.eigenvectors.column(least);
            let mut lanes = [[0.0; BRANCHES]; DOF];
            for branch in 0..BRANCHES {
                let step = TWIN_STEPS[branch / 2] * if branch % 2 == 0 { 1.0 } else { -1.0 };
                for joint in 0..DOF {
                    lanes[joint][branch] = q[joint] + step * along[joint];
                }
            }
            self.add_converging(&mut lanes, &[true; BRANCHES]);
        }
    }

    /// Adds the solutions that these places lead to within [`STEPS_OF_MANY`]; those that do not arrive by then are
    /// dropped.
    fn add_converging(&mut self, q: &mut [Lane; DOF], used: &[bool; BRANCHES]) {
        let left = newton(self.chain, &self.target, q, used, STEPS_OF_MANY);
        for branch in (0..BRANCHES).filter(|branch| used[*branch]) {
            if left.error[branch] < TOLERANCE {
                self.push(place(q, branch).map(wrap_angle));
            }
        }
    }

    /// Wrist nearly singular: for every joint 6 there are joint positions that miss the pose by one rotation only.
    /// Where that changes its sign around the turn is a solution.
    fn search_q6_circle(&mut self, shoulder: usize, free_q6: f64) {
        const STEP: f64 = TAU / RING as f64;
        let mut ring = [[OUT_OF_REACH; 2]; RING];
        for (at, places) in ring
            .as_chunks_mut::<FIXED_Q6_LANES>()
            .0
            .iter_mut()
            .enumerate()
        {
            let first = free_q6 + STEP * (at * FIXED_Q6_LANES) as f64;
            *places = self.solve_with_fixed_q6(shoulder, first, STEP);
        }
        let mut batch = SeedBatch::default();
        // Where joint 6 is free, the first places are the ones that are wanted.
        for first in &ring[0] {
            batch.push(self, &first.q, first.blocked.abs() < TOLERANCE);
        }
        for at in 0..RING {
            let [before, here, after] = [RING - 1, 0, 1].map(|step| ring[(at + step) % RING]);
            for elbow in 0..2 {
                let (before, here, after) = (&before[elbow], &here[elbow], &after[elbow]);
                batch.push_between(self, here, after, here.blocked * after.blocked <= 0.0);
                // Two solutions may lie between places of the same sign where it comes near to zero.
                let is_least = here.blocked.abs() <= before.blocked.abs().min(after.blocked.abs());
                let is_same =
                    here.blocked * before.blocked > 0.0 && here.blocked * after.blocked > 0.0;
                batch.push_between(self, before, here, is_least && is_same);
                batch.push_between(self, here, after, is_least && is_same);
            }
            // At the end of what the elbow reaches, one elbow becomes the other: there it is looked at more closely.
            let q6 = free_q6 + STEP * at as f64;
            for (neighbour, side) in [(&before, -1.0), (&after, 1.0)] {
                if !here[0].blocked.is_nan() && neighbour[0].blocked.is_nan() {
                    let step = side * STEP / (FIXED_Q6_LANES + 1) as f64;
                    let beyond = self.solve_with_fixed_q6(shoulder, q6 + step, step);
                    let mut last = here;
                    for next in &beyond {
                        for elbow in 0..2 {
                            let (a, b) = (last[elbow], next[elbow]);
                            batch.push_between(self, &a, &b, a.blocked * b.blocked <= 0.0);
                            if !b.blocked.is_nan() {
                                last[elbow] = b;
                            }
                        }
                    }
                    batch.push_between(self, &last[0], &last[1], true);
                }
            }
        }
        batch.flush(self);
    }

    /// Both elbows at four places of joint 6, `step` apart, with nothing asked of the blocked rotation.
    fn solve_with_fixed_q6(
        &self,
        shoulder: usize,
        first_q6: f64,
        step: f64,
    ) -> [[FixedQ6Candidate; 2]; FIXED_Q6_LANES] {
        let mut lanes = [[0.0; BRANCHES]; DOF];
        let mut used = [false; BRANCHES];
        for at in 0..FIXED_Q6_LANES {
            let starts = self.starts(&self.arm.margin, Some(first_q6 + step * at as f64));
            let Some(starts) = starts else {
                continue;
            };
            for elbow in 0..2 {
                let (from, to) = (4 * shoulder + elbow, 2 * at + elbow);
                used[to] = starts.is_reachable[from];
                for (lane, q) in lanes.iter_mut().zip(&starts.q) {
                    lane[to] = q[from];
                }
            }
        }
        let left = newton_with_fixed_q6(self.chain, &self.target, &mut lanes, &used, STEPS);
        core::array::from_fn(|at| {
            core::array::from_fn(|elbow| {
                let branch = 2 * at + elbow;
                if used[branch] && left.error[branch] < FIXED_Q6_TOLERANCE {
                    FixedQ6Candidate {
                        q: place(&lanes, branch),
                        blocked: left.unreachable_rotation[branch],
                    }
                } else {
                    OUT_OF_REACH
                }
            })
        })
    }

    fn push(&mut self, q: JointPositions) {
        let same = |other: &JointPositions, joints: &[usize]| {
            joints
                .iter()
                .all(|&joint| wrap_angle(q[joint] - other[joint]).abs() < SAME)
        };
        // Where joint 6 is free, one of its positions stands for all; joints 2, 3 and 4 follow it.
        let elbow = |q: &JointPositions| wrap_angle(q[2] + self.arm.offsets[2]) < 0.0;
        let is_free = |other: &JointPositions| {
            same(other, &[0, 4])
                && elbow(&q) == elbow(other)
                && self.is_parallel(&q)
                && self.is_parallel(other)
        };
        let known = |other: &JointPositions| same(other, &[0, 1, 2, 3, 4, 5]) || is_free(other);
        if !self.found.iter().any(known) {
            self.found.push(q);
        }
    }

    fn is_parallel(&self, q: &JointPositions) -> bool {
        let frames = self.chain.forward(q);
        frames.axis(3).cross(&frames.axis(DOF - 1)).norm() < PARALLEL
    }
}

impl IkSolutions {
    /// Brings the solutions into the order of the branches that they are nearest to; the rest stays behind.
    fn sort_by_nearest_seed(&mut self, starts: &NewtonSeeds) {
        let mut sorted = 0;
        for branch in (0..BRANCHES).filter(|branch| starts.is_reachable[*branch]) {
            let start = place(&starts.q, branch);
            let distance = |q: &JointPositions| {
                (0..DOF).fold(0.0, |most: f64, joint| {
                    most.max(wrap_angle(q[joint] - start[joint]).abs())
                })
            };
            let nearest = (sorted..self.count)
                .map(|at| (at, distance(&self.solutions[at])))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((at, distance)) = nearest
                && distance < BRANCH_RADIUS
            {
                self.solutions[sorted..=at].rotate_right(1);
                sorted += 1;
            }
        }
    }
}

/// A place with joint 6 held.
#[derive(Clone, Copy)]
struct FixedQ6Candidate {
    q: JointPositions,
    /// What is missing to the pose, rad; NaN where the arm does not reach.
    blocked: f64,
}

const OUT_OF_REACH: FixedQ6Candidate = FixedQ6Candidate {
    q: JointPositions::ZERO,
    blocked: f64::NAN,
};

/// Places that wait until there are eight.
#[derive(Default)]
struct SeedBatch {
    lanes: [Lane; DOF],
    used: [bool; BRANCHES],
    count: usize,
}

impl SeedBatch {
    fn push(&mut self, search: &mut SolutionSearch<'_>, q: &JointPositions, wanted: bool) {
        if !wanted {
            return;
        }
        for (lane, q) in self.lanes.iter_mut().zip(q.iter()) {
            lane[self.count] = *q;
        }
        self.used[self.count] = true;
        self.count += 1;
        if self.count == BRANCHES {
            self.flush(search);
        }
    }

    /// A place between two, nearer to the one where less is missing; nothing where one is out of reach.
    fn push_between(
        &mut self,
        search: &mut SolutionSearch<'_>,
        a: &FixedQ6Candidate,
        b: &FixedQ6Candidate,
        wanted: bool,
    ) {
        let sum = a.blocked.abs() + b.blocked.abs();
        if !wanted || sum.is_nan() {
            return;
        }
        let share = if sum > 0.0 {
            a.blocked.abs() / sum
        } else {
            0.5
        };
        let q =
            core::array::from_fn(|joint| a.q[joint] + share * wrap_angle(b.q[joint] - a.q[joint]));
        self.push(search, &JointPositions(q), true);
    }

    fn flush(&mut self, search: &mut SolutionSearch<'_>) {
        if self.count > 0 {
            search.add(&self.lanes, &self.used);
        }
        *self = Self::default();
    }
}
