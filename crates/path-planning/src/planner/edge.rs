//! Whether joint positions, and the straight lines between them, keep the margin.
//!
//! A line is proven clear and not sampled: where two places are so far from touching that the way between them cannot
//! bridge it, nothing between them can touch. What is not proven is halved.

use std::collections::VecDeque;

use kinematics::JointPositions;

use crate::scene::{CollisionScene, Pair, PlacedArm};
use crate::tracker::interpolate;

/// Within this of the margin a place counts as keeping it, m.
const MARGIN_TOLERANCE: f64 = 1e-4;

/// How near to a start or goal with a lower margin that margin holds, rad, for the joint with the longest way.
const RELAXED_AROUND: f64 = 0.35;

/// A pair that is nearer than the margin where a path begins or ends.
#[derive(Clone, Copy, Debug)]
struct RelaxedPair {
    number: usize,
    margin: f64,
    around: JointPositions,
}

/// Judges joint positions and lines between them.
pub(crate) struct ClearanceCheck<'a> {
    scene: &'a CollisionScene,
    margin: f64,
    relaxed: Vec<RelaxedPair>,
    arms: [PlacedArm; 2],
    /// How often each pair was in the way.
    pub(crate) blocked: Vec<u32>,
    /// How many lines were looked at.
    pub(crate) lines: u64,
}

/// A piece of a line, and the pairs that are not proven clear on it with their distances at its ends.
struct OpenPiece {
    from: f64,
    to: f64,
    pairs: Vec<(usize, f64, f64)>,
}

impl<'a> ClearanceCheck<'a> {
    pub(crate) fn new(scene: &'a CollisionScene, margin: f64) -> Self {
        Self {
            scene,
            margin,
            relaxed: Vec::new(),
            arms: Default::default(),
            blocked: vec![0; scene.pairs().len()],
            lines: 0,
        }
    }

    /// Lowers the margin around `q` for the pairs that are nearer than it there, to what they have. The pair that
    /// touches, if one does.
    pub(crate) fn relax_around(&mut self, q: &JointPositions) -> Result<(), Pair> {
        self.scene.place_arm(q, &mut self.arms[0]);
        for (number, &pair) in self.scene.pairs().iter().enumerate() {
            if self.scene.least_distance(pair, &self.arms[0]) >= self.margin {
                continue;
            }
            let distance = self.scene.distance(pair, &self.arms[0]);
            if distance >= self.margin {
                continue;
            }
            if distance <= 0.0 {
                return Err(pair);
            }
            self.relaxed.push(RelaxedPair {
                number,
                margin: distance - MARGIN_TOLERANCE.min(distance / 2.0),
                around: *q,
            });
        }
        Ok(())
    }

    /// The margins that are lowered around some of these positions: the pair, and what is left of the margin, m.
    pub(crate) fn relaxed_at(&self, ends: &[JointPositions]) -> Vec<(Pair, f64)> {
        let pairs = self.scene.pairs();
        let of_ends = self.relaxed.iter().filter(|one| ends.contains(&one.around));
        of_ends.map(|one| (pairs[one.number], one.margin)).collect()
    }

    /// The pairs that were in the way, the most frequent first.
    pub(crate) fn most_blocked(&self) -> Vec<Pair> {
        let mut numbers: Vec<usize> = (0..self.blocked.len()).collect();
        numbers.retain(|number| self.blocked[*number] > 0);
        numbers.sort_by_key(|number| core::cmp::Reverse(self.blocked[*number]));
        let pairs = self.scene.pairs();
        numbers.into_iter().map(|number| pairs[number]).collect()
    }

    fn margin_at(&self, number: usize, q: &JointPositions) -> f64 {
        let near = |one: &RelaxedPair| {
            let apart = JointPositions(core::array::from_fn(|j| q[j] - one.around[j]));
            one.number == number && apart.max_abs() <= RELAXED_AROUND
        };
        let margins = self.relaxed.iter().filter(|one| near(one));
        margins.map(|one| one.margin).fold(self.margin, f64::min)
    }

    /// Whether the joints can go straight from one place to the other.
    pub(crate) fn is_clear(&mut self, from: &JointPositions, to: &JointPositions) -> bool {
        self.blocking_pair_between(from, to).is_none()
    }

    /// A pair that is nearer than the margin somewhere between two places, both included.
    pub(crate) fn blocking_pair_between(
        &mut self,
        from: &JointPositions,
        to: &JointPositions,
    ) -> Option<Pair> {
        self.lines += 1;
        match self.search_between(from, to) {
            Some(number) => {
                self.blocked[number] += 1;
                Some(self.scene.pairs()[number])
            }
            None => None,
        }
    }

    fn search_between(&mut self, from: &JointPositions, to: &JointPositions) -> Option<usize> {
        let scene = self.scene;
        let pairs = scene.pairs();
        let [mut first, mut second] = std::mem::take(&mut self.arms);
        scene.place_arm(from, &mut first);
        scene.place_arm(to, &mut second);
        let mut ways = Vec::with_capacity(pairs.len());
        let mut whole = OpenPiece {
            from: 0.0,
            to: 1.0,
            pairs: Vec::new(),
        };
        let mut blocking = None;
        for (number, &pair) in pairs.iter().enumerate() {
            let way = scene.motion_bound(pair, from, to);
            ways.push(way);
            let mut ends = (
                scene.least_distance(pair, &first),
                scene.least_distance(pair, &second),
            );
            if ends.0.min(ends.1) >= self.margin && (ends.0 + ends.1 - way) / 2.0 >= self.margin {
                continue;
            }
            ends = (scene.distance(pair, &first), scene.distance(pair, &second));
            if ends.0 < self.margin_at(number, from) || ends.1 < self.margin_at(number, to) {
                blocking = Some(number);
                break;
            }
            if (ends.0 + ends.1 - way) / 2.0 < self.margin {
                whole.pairs.push((number, ends.0, ends.1));
            }
        }
        let mut open = VecDeque::new();
        if blocking.is_none() && !whole.pairs.is_empty() {
            open.push_back(whole);
        }
        while let Some(piece) = open.pop_front() {
            let middle = (piece.from + piece.to) / 2.0;
            let at = |fraction| interpolate(from, to, fraction);
            let (q, q_left, q_right) = (at(middle), at(piece.from), at(piece.to));
            scene.place_arm(&q, &mut first);
            let share = middle - piece.from;
            let half = |from, to| OpenPiece {
                from,
                to,
                pairs: Vec::new(),
            };
            let (mut left, mut right) = (half(piece.from, middle), half(middle, piece.to));
            for &(number, before, after) in &piece.pairs {
                let way = ways[number] * share;
                let quick = scene.least_distance(pairs[number], &first);
                let is_proven = |end: f64, here: f64, margin: f64| {
                    (end + here - way) / 2.0 >= margin || way < MARGIN_TOLERANCE
                };
                if quick >= self.margin
                    && is_proven(before, quick, self.margin)
                    && is_proven(after, quick, self.margin)
                {
                    continue;
                }
                let here = scene.distance(pairs[number], &first);
                let margin = self.margin_at(number, &q);
                if here < margin {
                    blocking = Some(number);
                    break;
                }
                // Where the margin changes on the way, the larger one counts.
                if !is_proven(before, here, margin.max(self.margin_at(number, &q_left))) {
                    left.pairs.push((number, before, here));
                }
                if !is_proven(after, here, margin.max(self.margin_at(number, &q_right))) {
                    right.pairs.push((number, here, after));
                }
            }
            if blocking.is_some() {
                break;
            }
            for half in [left, right] {
                if !half.pairs.is_empty() {
                    open.push_back(half);
                }
            }
        }
        self.arms = [first, second];
        blocking
    }
}
