//! Joint paths that keep a margin: straight if possible, else around what is in the way.
//!
//! Two trees grow from the start and from all goals until they meet; the path is then made shorter, and the shortest of
//! several such paths is taken. Every line is proven clear. A seed and a bound on tries decide everything; the caller's
//! clock can only end the search.

pub(crate) mod edge;
mod shortcut;
mod tree;

use kinematics::random::RandomSequence;
use kinematics::{JointLimits, JointPositions};
use messages::Localized;
use thiserror::Error;

use crate::scene::{CollisionScene, Pair};
use edge::ClearanceCheck;
use tree::{Extension, JointTree};

/// Random joint positions that are tried for one leg of a path.
const TRIES: u32 = 12_000;
/// Paths that are looked for, of which the shortest is taken.
const PATHS: u32 = 6;
/// The first path may take all tries, each further one so many.
const TRIES_FOR_BETTER: u32 = 1_500;
/// Beyond the joint positions of start and goals the search goes so far, rad.
const SEARCH_BEYOND: f64 = core::f64::consts::PI;

/// What is planned.
#[derive(Clone, Debug)]
pub struct PathRequest<'a> {
    /// The arm and what stands around it.
    pub scene: &'a CollisionScene,
    /// Ranges of the joints.
    pub limits: &'a JointLimits,
    /// Where the path begins.
    pub start: JointPositions,
    /// Where it passes, in this order.
    pub via: &'a [JointPositions],
    /// Where it may end; at least one.
    pub goals: &'a [JointPositions],
    /// The distance that is kept, m.
    pub margin: f64,
    /// Decides all random numbers.
    pub seed: u64,
}

/// A path without time.
#[derive(Clone, Debug, PartialEq)]
pub struct JointPath {
    /// Start, corners and goal; straight lines of the joints between them.
    pub corners: Vec<JointPositions>,
    /// The numbers of the corners that were asked for by `via`.
    pub via: Vec<usize>,
    /// Sum of the Euclidean distances between the corners, rad.
    pub length: f64,
    /// The pairs that were nearer than the margin at start or goal, and what was kept there instead, m.
    pub lowered: Vec<(Pair, f64)>,
}

/// A reason why there is no path.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum PathError {
    /// Something touches at the start.
    #[error("the arm touches something at the start")]
    #[zh("机械臂在起点碰到物体")]
    StartInCollision {
        /// What touches.
        pair: Pair,
    },
    /// Something touches at every goal.
    #[error("the arm touches something at the goal")]
    #[zh("机械臂在终点碰到物体")]
    GoalInCollision {
        /// What touches, for each goal.
        pairs: Vec<Pair>,
    },
    /// Something touches at a position that the path has to pass.
    #[error("the arm touches something at via position {number}")]
    #[zh("机械臂在中间位置 {number} 碰到物体")]
    ViaInCollision {
        /// Number of the position, from 1.
        number: usize,
        /// What touches.
        pair: Pair,
    },
    /// A position beyond the ranges of the joints.
    #[error("joint {} would be at {value:.4} rad, allowed is {min:.4} to {max:.4} rad", joint + 1)]
    #[zh("关节 {} 将位于 {value:.4} rad，允许 {min:.4} 到 {max:.4} rad", joint + 1)]
    JointLimit {
        /// Joint index from 0.
        joint: usize,
        /// The position, rad.
        value: f64,
        /// Lower limit, rad.
        min: f64,
        /// Upper limit, rad.
        max: f64,
    },
    /// There are no goals.
    #[error("no joint positions reach the goal")]
    #[zh("没有关节位置能到达终点")]
    NoGoal,
    /// Tries or time were used up.
    #[error("no path was found in {tries} tries")]
    #[zh("{tries} 次尝试中没有找到路径")]
    NotFound {
        /// Random joint positions that were tried.
        tries: u32,
        /// Whether the caller's clock ended the search.
        out_of_time: bool,
        /// What was in the way most often, the most frequent first.
        in_the_way: Vec<Pair>,
    },
}

/// Finds a path. `should_stop` is asked now and then, and ends the search: with what has been found until then.
///
/// # Errors
/// [`PathError`]
pub fn plan(
    request: &PathRequest<'_>,
    should_stop: &mut dyn FnMut() -> bool,
) -> Result<JointPath, PathError> {
    let within = |q: &JointPositions| match request.limits.position_violation(q) {
        None => Ok(()),
        Some((joint, value)) => Err(PathError::JointLimit {
            joint,
            value,
            min: request.limits.position_min[joint],
            max: request.limits.position_max[joint],
        }),
    };
    within(&request.start)?;
    request.via.iter().try_for_each(within)?;
    let mut check = ClearanceCheck::new(request.scene, request.margin);
    check
        .relax_around(&request.start)
        .map_err(|pair| PathError::StartInCollision { pair })?;
    for (number, via) in (1..).zip(request.via) {
        check
            .relax_around(via)
            .map_err(|pair| PathError::ViaInCollision { number, pair })?;
    }
    let (mut goals, mut touching) = (Vec::new(), Vec::new());
    for goal in request.goals {
        if request.limits.contains(goal) {
            match check.relax_around(goal) {
                Ok(()) => goals.push(*goal),
                Err(pair) => touching.push(pair),
            }
        }
    }
    if goals.is_empty() {
        return Err(match touching.is_empty() {
            true => match request.goals.first() {
                Some(goal) => within(goal).err().unwrap_or(PathError::NoGoal),
                None => PathError::NoGoal,
            },
            false => PathError::GoalInCollision { pairs: touching },
        });
    }
    let mut corners = vec![request.start];
    let mut via_corners = Vec::new();
    let mut from = request.start;
    for (stream, target) in (0_u64..).zip(request.via.iter().map(Some).chain([None])) {
        let ends = target.map_or(&*goals, core::slice::from_ref);
        let mut leg = LegSearch {
            request,
            check: &mut check,
            random: RandomSequence::with_stream(request.seed, stream),
            should_stop,
        };
        let leg = leg.run(&from, ends)?;
        corners.extend_from_slice(&leg[1..]);
        if target.is_some() {
            via_corners.push(corners.len() - 1);
        }
        from = corners[corners.len() - 1];
    }
    let ends = [request.start, from];
    let lowered = check.relaxed_at(&ends);
    Ok(JointPath {
        length: length(&corners),
        corners,
        via: via_corners,
        lowered,
    })
}

/// The sum of the Euclidean distances between the corners, rad.
pub fn length(corners: &[JointPositions]) -> f64 {
    let pieces = corners.windows(2);
    pieces
        .map(|ends| ends[0].distance_squared(&ends[1]).sqrt())
        .sum()
}

/// The search for one leg of a path.
struct LegSearch<'a, 'b> {
    request: &'a PathRequest<'a>,
    check: &'a mut ClearanceCheck<'b>,
    random: RandomSequence,
    should_stop: &'a mut dyn FnMut() -> bool,
}

impl LegSearch<'_, '_> {
    fn run(
        &mut self,
        start: &JointPositions,
        goals: &[JointPositions],
    ) -> Result<Vec<JointPositions>, PathError> {
        let apart = |goal: &JointPositions| start.distance_squared(goal);
        let mut nearest: Vec<JointPositions> = goals.to_vec();
        nearest.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
        let mut shortest = None::<Vec<JointPositions>>;
        let straight = nearest
            .iter()
            .position(|goal| self.check.is_clear(start, goal));
        if let Some(number) = straight {
            shortest = Some(vec![*start, nearest[number]]);
            // A way around something to a nearer goal may be shorter than the line to this one.
            nearest.truncate(number);
        }
        if let Some(line) = shortest.take_if(|_| nearest.is_empty()) {
            return Ok(line);
        }
        let bounds = self.search_bounds(start, &nearest);
        let mut tries = 0;
        let mut was_stopped = false;
        for _ in 0..PATHS {
            let most = match shortest {
                None => TRIES - tries,
                Some(_) => TRIES_FOR_BETTER.min(TRIES - tries),
            };
            let grown = self.grow(start, &nearest, &bounds, most, &mut tries);
            was_stopped = (self.should_stop)();
            if let Some(mut path) = grown {
                let limits = self.request.limits;
                shortcut::shorten(
                    &mut path,
                    self.check,
                    limits,
                    &mut self.random,
                    self.should_stop,
                );
                let is_shorter = |found: &Vec<JointPositions>| length(&path) < length(found);
                if shortest.as_ref().is_none_or(is_shorter) {
                    shortest = Some(path);
                }
            }
            if tries >= TRIES || was_stopped {
                break;
            }
        }
        shortest.ok_or_else(|| PathError::NotFound {
            tries,
            out_of_time: was_stopped,
            in_the_way: self.check.most_blocked(),
        })
    }

    /// Lets two trees grow until they meet.
    fn grow(
        &mut self,
        start: &JointPositions,
        goals: &[JointPositions],
        bounds: &[(f64, f64); 6],
        most: u32,
        tries: &mut u32,
    ) -> Option<Vec<JointPositions>> {
        let mut trees = [JointTree::new(&[*start]), JointTree::new(goals)];
        let mut grows = 0;
        for _ in 0..most {
            if (self.should_stop)() {
                return None;
            }
            *tries += 1;
            let target = JointPositions(bounds.map(|(low, high)| self.random.between(low, high)));
            let [first, second] = &mut trees;
            let (growing, other) = match grows {
                0 => (first, second),
                _ => (second, first),
            };
            let node = match growing.extend(&target, self.check) {
                Extension::Reached(node) | Extension::Advanced(node) => Some(node),
                Extension::Blocked => None,
            };
            if let Some(node) = node {
                let towards = *growing.at(node);
                if let Extension::Reached(met) = other.connect(&towards, self.check) {
                    let (mut way, back) = (growing.way_to_root(node), other.way_to_root(met));
                    way.reverse();
                    // The place where they meet is in both.
                    way.extend_from_slice(&back[1..]);
                    if grows == 1 {
                        way.reverse();
                    }
                    return Some(way);
                }
            }
            grows = 1 - grows;
        }
        None
    }

    /// Where random joint positions are taken from: around start and goals, within the ranges of the joints.
    fn search_bounds(&self, start: &JointPositions, goals: &[JointPositions]) -> [(f64, f64); 6] {
        let limits = self.request.limits;
        core::array::from_fn(|joint| {
            let values = goals.iter().map(|goal| goal[joint]);
            let (low, high) = values.fold((start[joint], start[joint]), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            (
                (low - SEARCH_BEYOND).max(limits.position_min[joint]),
                (high + SEARCH_BEYOND).min(limits.position_max[joint]),
            )
        })
    }
}
