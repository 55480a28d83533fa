//! Convex pieces that stand for a solid in contacts and distances.
//!
//! The fragment that reaches farthest beyond the solid is cut, until none does by more than a tenth of a millimetre or
//! there are as many pieces as are allowed. The planes of the faces at hollows come first: they take bins, brackets
//! and forks apart without a remainder. What is left is measured against the solid as it was read.

mod body;
mod candidates;
mod connected;
mod deviation;
mod distance;
mod fragment;
mod hull;

use std::sync::Arc;

use kinematics::polytope::Polytope;
use nalgebra::Vector3;

use crate::MAX_PIECES;
use crate::solid::{Solid, bounds_of};
use candidates::HollowPlanes;
use connected::{append, components};
use distance::SolidDistance;
use fragment::{Fragment, Plane};
use hull::{Hull, hull_of};

/// A fragment that reaches no farther beyond the solid than this, in metres, is cut no more.
const NEAR_ENOUGH_M: f64 = 1e-4;
/// Questions about what a cut makes, about a fragment before it is cut, and about all of them at the end.
const CELLS_OF_CUT: usize = 200;
const CELLS_OF_FRAGMENT: usize = 1500;
const CELLS_OF_ALL: usize = 150_000;
/// Corners and triangles of fragments whose cuts are compared.
const CORNERS_COMPARED: usize = 40;
const TRIANGLES_COMPARED: usize = 2500;
/// A cut across an axis must be better than one along a face by this share of what a hull has too much.
const AXIS_HANDICAP: f64 = 0.05;
/// Planes and points closer than this share of the size count as one.
const TOLERANCE: f64 = 1e-8;
/// Positions of files with single precision are off by this share of their size.
const SINGLE_PRECISION: f64 = 2.5e-7;

/// A convex body in the frame of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPiece {
    /// Where the origin of the body's frame is, in metres; the axes are those of the mesh.
    pub middle: Vector3<f64>,
    /// The body, about `middle`.
    pub body: Arc<Polytope>,
}

/// Convex bodies that together stand for a solid.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPieces {
    pieces: Vec<ConvexPiece>,
    deviation: f64,
}

impl ConvexPieces {
    /// The pieces in a point mirror at the origin: every point p becomes −p.
    #[must_use]
    pub fn point_mirrored(&self) -> Self {
        let mirrored = self.pieces.iter().map(|piece| ConvexPiece {
            middle: -piece.middle,
            body: Arc::new(piece.body.point_mirrored()),
        });
        Self {
            pieces: mirrored.collect(),
            ..*self
        }
    }

    /// The pieces, of which there is at least one.
    pub fn pieces(&self) -> &[ConvexPiece] {
        &self.pieces
    }

    /// No point of the solid is farther from all pieces than this, and no point of a piece is farther from the solid,
    /// in metres. The bound is above the greatest distance by at most 2 % or 1 µm, but for solids so intricate that
    /// the search for the greatest distance was ended before.
    pub fn deviation(&self) -> f64 {
        self.deviation
    }
}

/// At most `most` convex pieces for a solid; outside of 1 to [`MAX_PIECES`] the nearer of the two counts.
pub fn convex_pieces(solid: &Solid, most: usize) -> ConvexPieces {
    let most = most.clamp(1, MAX_PIECES);
    let (low, high) = bounds_of(solid.mesh().points().iter().copied());
    let size = (high - low).norm();
    let mut cutting = Cutting {
        solid: SolidDistance::new(solid.mesh()),
        tolerance: (TOLERANCE * size).max(SINGLE_PRECISION * low.abs().sup(&high.abs()).max()),
        hull_tolerance: TOLERANCE * size / 4.0,
        entries: Vec::new(),
        lost: Vec::new(),
    };
    let whole = Fragment {
        points: solid.mesh().points().to_vec(),
        triangles: solid.mesh().triangles().to_vec(),
        caps: Vec::new(),
    };
    let fragments = components(whole);
    for fragment in joined(fragments, most) {
        cutting.add(fragment);
    }
    while cutting.entries.len() < most {
        let Some(worst) = cutting.worst() else { break };
        cutting.divide(worst, most);
    }
    cutting.finish(low, high)
}

/// The corners of the convex hull of points, m; all of them where they span no volume.
pub(crate) fn hull_corners(points: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let (low, high) = bounds_of(points.iter().copied());
    let tolerance = TOLERANCE * (high - low).norm() / 4.0;
    let hull = hull_of(&points, usize::MAX, tolerance);
    hull.map_or(points, |hull| hull.points)
}

/// The fragments, or one of all of them where they are too many.
fn joined(fragments: Vec<Fragment>, most: usize) -> Vec<Fragment> {
    if fragments.len() <= most {
        return fragments;
    }
    let mut all = Fragment::default();
    for fragment in &fragments {
        append(&mut all, fragment);
    }
    vec![all]
}

/// Parts while they are cut.
struct Cutting {
    solid: SolidDistance,
    /// For sides of planes, in metres.
    tolerance: f64,
    /// For corners of hulls, in metres.
    hull_tolerance: f64,
    entries: Vec<Entry>,
    /// Corners of flat fragments, which have no hull.
    lost: Vec<Vec<Vector3<f64>>>,
}

/// A fragment with what is known of it.
struct Entry {
    fragment: Fragment,
    hull: Hull,
    /// A bound of how far the hull reaches beyond the solid, in metres.
    reach: f64,
    /// Whether `reach` is proven from the fragment alone, and needs no search.
    is_convex: bool,
    /// Whether another cut may help.
    can_be_cut: bool,
}

impl Cutting {
    fn add(&mut self, fragment: Fragment) {
        match self.hull(&fragment) {
            Some(hull) => self.add_entry(fragment, hull),
            None => self.lost.push(fragment.points),
        }
    }

    /// The hull of a fragment; none for a flat one.
    fn hull(&self, fragment: &Fragment) -> Option<Hull> {
        hull_of(&fragment.points, Polytope::MAX_POINTS, self.hull_tolerance)
    }

    fn add_entry(&mut self, fragment: Fragment, hull: Hull) {
        let convex = deviation::of_convex(&fragment, &hull.middle(), self.hull_tolerance);
        let reach = convex.unwrap_or(f64::INFINITY);
        let (reach, is_convex) = if reach < NEAR_ENOUGH_M {
            (reach, true)
        } else {
            let most = deviation::of_hulls(&[&hull], &self.solid, CELLS_OF_FRAGMENT);
            (most.min(reach), false)
        };
        self.entries.push(Entry {
            fragment,
            reach,
            // A round fragment with more corners than a body may have is not better in pieces.
            can_be_cut: reach > NEAR_ENOUGH_M,
            is_convex,
            hull,
        });
    }

    /// The entry that is farthest from the solid and can be cut.
    fn worst(&self) -> Option<usize> {
        let open = self
            .entries
            .iter()
            .enumerate()
            .filter(|(_, entry)| entry.can_be_cut);
        let worst = open.max_by(|one, other| {
            one.1
                .reach
                .total_cmp(&other.1.reach)
                .then(other.0.cmp(&one.0))
        });
        worst.map(|(number, _)| number)
    }

    /// Cuts an entry in two or more, where a plane for it is found and there is room for what comes of it.
    fn divide(&mut self, number: usize, most: usize) {
        let room = most - self.entries.len() + 1;
        let entry = &self.entries[number];
        let cut = self
            .best_plane(entry)
            .and_then(|plane| entry.fragment.cut(&plane, self.tolerance));
        let Some((below, above)) = cut else {
            self.entries[number].can_be_cut = false;
            return;
        };
        let below_fragments = components(below);
        let above_fragments = components(above);
        let fragments = if below_fragments.len() + above_fragments.len() <= room {
            below_fragments.into_iter().chain(above_fragments).collect()
        } else {
            [joined(below_fragments, 1), joined(above_fragments, 1)].concat()
        };
        let fragments: Vec<(Fragment, Option<Hull>)> = fragments
            .into_iter()
            .map(|fragment| {
                let hull = self.hull(&fragment);
                (fragment, hull)
            })
            .collect();
        // A cut that takes off nothing but flat slivers would be made for ever, since there is never one piece more.
        if fragments.iter().filter(|(_, hull)| hull.is_some()).count() < 2 {
            self.entries[number].can_be_cut = false;
            return;
        }
        self.entries.swap_remove(number);
        for (fragment, hull) in fragments {
            match hull {
                Some(hull) => self.add_entry(fragment, hull),
                None => self.lost.push(fragment.points),
            }
        }
    }

    /// The plane whose fragments have the least in their hulls that is not theirs. On round surfaces, where one cut
    /// alone takes hardly anything away, how far their hulls reach beyond the solid counts, the more the longer they
    /// are.
    fn best_plane(&self, entry: &Entry) -> Option<Plane> {
        let coarse = candidates::coarse(&entry.fragment, TRIANGLES_COMPARED);
        let (at_hollows, is_round) = match candidates::of_hollows(&entry.fragment) {
            HollowPlanes::Sharp(planes) => (planes, false),
            HollowPlanes::Round(planes) => (planes, true),
        };
        let excess = (entry.hull.volume - entry.fragment.volume()).max(0.0);
        let handicap = if is_round {
            0.0
        } else {
            AXIS_HANDICAP * excess
        };
        let at_hollows = at_hollows.into_iter().map(|plane| (plane, 0.0));
        // Where facets meet says better how to cut a ring than any axis does: across its own axis nothing is won.
        let across_axes = match is_round && at_hollows.len() > 0 {
            true => Vec::new(),
            false => candidates::of_axes(&entry.fragment, is_round),
        };
        let across_axes = across_axes.into_iter().map(|plane| (plane, handicap));
        let mut best = None::<(f64, Plane)>;
        for (plane, handicap) in at_hollows.chain(across_axes) {
            let Some((below, above)) = coarse.cut(&plane, self.tolerance) else {
                continue;
            };
            let mut cost = handicap;
            let mut hulls = 0;
            for fragment in components(below).into_iter().chain(components(above)) {
                let hull = hull_of(&fragment.points, CORNERS_COMPARED, self.hull_tolerance);
                let Some(hull) = hull else { continue };
                hulls += 1;
                cost += if is_round {
                    let (low, high) = bounds_of(hull.points.iter().copied());
                    let reach = deviation::of_hulls(&[&hull], &self.solid, CELLS_OF_CUT);
                    reach * (high - low).sum()
                } else {
                    hull.volume - fragment.volume()
                };
            }
            // Along a face that is flat but for rounding, nothing but a sliver may be on one side.
            if hulls < 2 {
                continue;
            }
            // Another plane must be better by more than rounding, so that the first of equal ones is taken.
            if best.is_none_or(|(least, _)| cost < least - 1e-9 * entry.hull.volume) {
                best = Some((cost, plane));
            }
        }
        best.map(|(_, plane)| plane)
    }

    fn finish(self, low: Vector3<f64>, high: Vector3<f64>) -> ConvexPieces {
        let mut pieces = Vec::new();
        let mut deviation = 0.0_f64;
        let mut open = Vec::new();
        for entry in &self.entries {
            let (piece, widened) = body::piece_of(&entry.hull);
            pieces.push(piece);
            deviation = deviation.max(widened);
            deviation = deviation.max(entry.hull.loss);
            if entry.is_convex {
                deviation = deviation.max(entry.reach);
            } else {
                open.push(&entry.hull);
            }
        }
        if pieces.is_empty() {
            // Rounding left nothing but flat fragments: the box around them all.
            let (piece, widened) = body::box_around(low, high);
            pieces.push(piece);
            deviation = widened;
        }
        if !open.is_empty() {
            let most = deviation::of_hulls(&open, &self.solid, CELLS_OF_ALL);
            let each = self
                .entries
                .iter()
                .filter(|entry| !entry.is_convex)
                .map(|entry| entry.reach);
            // The searches of the single fragments have proven a bound as well.
            deviation = deviation.max(most.min(each.fold(0.0, f64::max)));
        }
        for flat in &self.lost {
            // The distance from a convex body is greatest at a corner.
            let from = |piece: &ConvexPiece| {
                let each = flat
                    .iter()
                    .map(|point| piece.body.distance(&(point - piece.middle)).0.max(0.0));
                each.fold(0.0, f64::max)
            };
            deviation = deviation.max(pieces.iter().map(from).fold(f64::INFINITY, f64::min));
        }
        ConvexPieces { pieces, deviation }
    }
}
