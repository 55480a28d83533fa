//! The least distance along a path that somebody else drives, cycle by cycle.
//!
//! Between two cycles nothing is missed: a bound on how far every pair can have come nearer says where to look closer.
//! Nearly all pairs are so far apart that this bound alone rules them out.

use kinematics::JointPositions;

use crate::scene::{CollisionScene, PairDistance, PlacedArm};

/// How much nearer than what is found two things can have been on the way, m.
pub const PATH_TOLERANCE: f64 = 5e-5;

/// The nearest place of a stretch of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPlace {
    /// The pair, and its distance there.
    pub nearest: PairDistance,
    /// The joint positions there.
    pub q: JointPositions,
    /// How far along the stretch, 0 to 1.
    pub fraction: f64,
}

/// Follows an arm.
#[derive(Debug, Default)]
pub struct ClearanceTracker {
    revision: u64,
    last: Option<JointPositions>,
    /// For every pair of the scene a number that its distance at `last` is not below, m.
    bounds: Vec<f64>,
    /// For every pair the way that its obstacle had moved by then, m.
    travels: Vec<f64>,
    /// The pair that was nearest in the last look: the first to look at.
    nearest: usize,
    arm: PlacedArm,
    arm_before: PlacedArm,
}

/// A stretch of a path, and what is looked for along it.
struct Search<'a> {
    scene: &'a CollisionScene,
    from: JointPositions,
    to: JointPositions,
    /// Only what is nearer than this is of interest, m.
    threshold: f64,
    found: Option<NearestPlace>,
}

impl ClearanceTracker {
    /// Takes the arm on to `q`. Gives the nearest place on the way there, the place before included, if something was
    /// nearer than `threshold`, m.
    pub fn advance(
        &mut self,
        scene: &CollisionScene,
        q: &JointPositions,
        threshold: f64,
    ) -> Option<NearestPlace> {
        let pairs = scene.pairs();
        if self.revision != scene.revision() || self.bounds.len() != pairs.len() {
            self.revision = scene.revision();
            self.bounds = vec![f64::NEG_INFINITY; pairs.len()];
            self.travels = pairs
                .iter()
                .map(|pair| scene.obstacle_travel(*pair))
                .collect();
            self.nearest = 0;
        }
        let from = *self.last.get_or_insert(*q);
        self.last = Some(*q);
        let mut search = Search {
            scene,
            from,
            to: *q,
            threshold,
            found: None,
        };
        let (mut is_placed, mut is_placed_before) = (false, false);
        let first = self.nearest.min(pairs.len());
        for number in (first..pairs.len()).chain(0..first) {
            let pair = pairs[number];
            let travel = scene.obstacle_travel(pair);
            let moved = travel - std::mem::replace(&mut self.travels[number], travel);
            let bound = self.bounds[number] - moved;
            let way = scene.motion_bound(pair, &from, q);
            // Every place of the stretch is this far at least, so a pair that is looked at on both sides needs no more.
            if bound - way >= search.threshold {
                self.bounds[number] = bound - way;
                continue;
            }
            if !is_placed {
                scene.place_arm(q, &mut self.arm);
                is_placed = true;
            }
            let quick = scene.least_distance(pair, &self.arm);
            if bound.min(quick) >= search.threshold
                && (bound + quick - way) / 2.0 >= search.threshold
            {
                self.bounds[number] = quick;
                continue;
            }
            let there = scene.distance(pair, &self.arm);
            self.bounds[number] = there;
            if search.note(pair, there, 1.0) {
                self.nearest = number;
            }
            if search.is_done((bound, there), way) {
                continue;
            }
            if !is_placed_before {
                scene.place_arm(&from, &mut self.arm_before);
                is_placed_before = true;
            }
            let before = scene.distance(pair, &self.arm_before);
            if search.note(pair, before, 0.0) {
                self.nearest = number;
            }
            if search.between(pair, (0.0, before), (1.0, there), way) {
                self.nearest = number;
            }
        }
        search.found
    }
}

impl Search<'_> {
    /// Takes a distance into account; true if it is the nearest so far.
    fn note(&mut self, pair: crate::Pair, distance: f64, fraction: f64) -> bool {
        if distance >= self.threshold {
            return false;
        }
        self.threshold = distance;
        self.found = Some(NearestPlace {
            nearest: PairDistance { distance, pair },
            q: self.at(fraction),
            fraction,
        });
        true
    }

    /// Whether no place between two with these distances, or bounds of them, can be nearer than what is found.
    fn is_done(&self, (before, after): (f64, f64), way: f64) -> bool {
        (before + after - way) / 2.0 >= self.threshold - PATH_TOLERANCE
    }

    /// Looks between two places with these distances that are so far apart; true if the nearest so far is there.
    fn between(
        &mut self,
        pair: crate::Pair,
        before: (f64, f64),
        after: (f64, f64),
        way: f64,
    ) -> bool {
        if self.is_done((before.1, after.1), way) {
            return false;
        }
        let middle = (before.0 + after.0) / 2.0;
        let mut arm = PlacedArm::default();
        self.scene.place_arm(&self.at(middle), &mut arm);
        let distance = self.scene.distance(pair, &arm);
        let mut is_nearer = self.note(pair, distance, middle);
        let half = way / 2.0;
        is_nearer |= self.between(pair, before, (middle, distance), half);
        is_nearer |= self.between(pair, (middle, distance), after, half);
        is_nearer
    }

    fn at(&self, fraction: f64) -> JointPositions {
        interpolate(&self.from, &self.to, fraction)
    }
}

/// Joint positions on the straight line between two.
pub(crate) fn interpolate(
    from: &JointPositions,
    to: &JointPositions,
    fraction: f64,
) -> JointPositions {
    JointPositions(core::array::from_fn(|joint| {
        from[joint] + (to[joint] - from[joint]) * fraction
    }))
}
