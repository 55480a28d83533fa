//! Parts in the grippers: they touch obstacles as the tool does, from the cycle in which they are held.
//!
//! A part that is taken while it lies on an obstacle is pressed into that a little, by the engine that had it before. A
//! hard obstacle would throw the arm up for a tenth of a millimetre. So the depth at which a part was taken is its
//! zero, until it has come out further. And a cup that sealed from a distance bears on its part only after that
//! distance.

use kinematics::{Pose, Wrench};
use motion_api::{HeldPart, MAX_GRIPPERS};

use super::entry::slot;
use super::law::ContactForces;
use super::nearest::ContactPoint;
use super::{ArmPart, Contact, ContactList, ContactModel, MARGIN, PlacedShape, nearest};

/// What hangs in the grippers.
#[derive(Clone, Debug)]
pub(super) struct HeldParts {
    /// Convex pieces of each template, in the part's frame.
    shapes: Vec<Vec<PlacedShape>>,
    parts: [Option<HeldPart>; MAX_GRIPPERS],
    /// For each pair of gripper and obstacle: the depth at which the part counts as only just touching, m.
    rest_depths: Vec<f64>,
    /// What obstacles do to each part, mean over the cycle: base axes, about the TCP.
    forces: [Wrench; MAX_GRIPPERS],
}

impl HeldParts {
    pub(super) fn new(shapes: Vec<Vec<PlacedShape>>, obstacles: usize) -> Self {
        let pairs = if shapes.is_empty() {
            0
        } else {
            MAX_GRIPPERS * obstacles
        };
        Self {
            shapes,
            parts: [None; MAX_GRIPPERS],
            rest_depths: vec![0.0; pairs],
            forces: [Wrench::default(); MAX_GRIPPERS],
        }
    }

    /// Convex pieces of a part, in its frame; none for a template that does not exist.
    fn pieces_of(&self, part: &HeldPart) -> &[PlacedShape] {
        let pieces = self.shapes.get(usize::from(part.template));
        pieces.map_or(&[], Vec::as_slice)
    }
}

impl ContactModel {
    /// The parts that the grippers hold from now on.
    pub(crate) fn set_held_parts(&mut self, parts: &[Option<HeldPart>; MAX_GRIPPERS]) {
        self.held.forces = [Wrench::default(); MAX_GRIPPERS];
        for (number, part) in parts.iter().enumerate() {
            if *part == self.held.parts[number] {
                continue;
            }
            let is_same = matches!(
                (part, &self.held.parts[number]),
                (Some(now), Some(before)) if now.template == before.template
            );
            self.held.parts[number] = *part;
            let Some(part) = part else {
                continue;
            };
            let pieces = self.held.pieces_of(part).iter();
            let extent = part.flange_from_part.translation.norm()
                + pieces.map(PlacedShape::extent).fold(0.0, f64::max);
            self.broad_phase
                .replace(slot(ArmPart::Held(number)), extent);
            // One that slips between fingers stays the part that it was.
            if !is_same {
                self.entry_faces.forget(ArmPart::Held(number));
                let first = number * self.obstacles.len();
                let depths = first..first + self.obstacles.len();
                self.held.rest_depths[depths].fill(f64::INFINITY);
            }
        }
    }

    /// What obstacles have done to each held part since [`set_held_parts`](Self::set_held_parts): base axes, about the
    /// TCP.
    pub(crate) const fn held_forces(&self) -> &[Wrench; MAX_GRIPPERS] {
        &self.held.forces
    }

    /// Adds the forces of a step that is this part of a cycle.
    pub(crate) fn add_held_forces(&mut self, forces: &ContactForces, share: f64) {
        for (sum, more) in self.held.forces.iter_mut().zip(&forces.held) {
            sum.force += more.force * share;
            sum.moment += more.moment * share;
        }
    }

    pub(super) fn touches_of_held_parts(
        &mut self,
        base_from_flange: &Pose,
        touches: &mut ContactList,
    ) {
        if self.held.shapes.is_empty() {
            return;
        }
        for number in 0..MAX_GRIPPERS {
            if let Some(part) = self.held.parts[number] {
                self.touches_of_held_part(number, &part, base_from_flange, touches);
            }
        }
    }

    fn touches_of_held_part(
        &mut self,
        number: usize,
        held_part: &HeldPart,
        base_from_flange: &Pose,
        touches: &mut ContactList,
    ) {
        let Self {
            obstacles,
            entry_faces,
            broad_phase,
            held,
            ..
        } = self;
        let part = ArmPart::Held(number);
        let base_from_part = *base_from_flange * held_part.flange_from_part;
        let play = base_from_flange.rotate(held_part.play.into());
        let first = number * obstacles.len();
        broad_phase.check_due_pairs(slot(part), |obstacle| {
            let solid = &obstacles[obstacle].solid;
            let mut places = [None::<ContactPoint>; nearest::MAX_FEATURES];
            let mut next = places.iter_mut();
            let (mut deepest, mut least_gap) = (0.0_f64, f64::INFINITY);
            for piece in held.pieces_of(held_part) {
                let piece = piece.expressed_in(&base_from_part);
                let gap = nearest::solid(&piece, solid, MARGIN, &mut |place, feature| {
                    let place =
                        entry_faces.reorient_feature(part, feature, obstacle, obstacles, place);
                    deepest = deepest.max(place.depth);
                    if let Some(next) = next.next() {
                        *next = Some(place);
                    }
                });
                least_gap = least_gap.min(gap);
            }
            let rest = &mut held.rest_depths[first + obstacle];
            *rest = rest.min(deepest);
            for mut place in places.into_iter().flatten() {
                place.depth -= *rest + place.normal.dot(&play).max(0.0);
                touches.push(Contact {
                    part,
                    obstacle,
                    place,
                });
            }
            least_gap - MARGIN
        });
    }
}
