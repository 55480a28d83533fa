//! Pairs of things whose distance counts: links that are no neighbours, the tool and what is held against the inner
//! links, and all of them against the obstacles.

use kinematics::DOF;

use super::body::{Body, BodyOwner};
use super::{CollisionScene, ObstacleId, ObstaclePlace};

/// The innermost link that the tool does not count against: the wrist carries it.
const FIRST_WRIST: usize = 4;

/// A body of the arm, and what it may touch. Belongs to one revision of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    pub(super) body: usize,
    pub(super) partner: PairPartner,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PairPartner {
    Body(usize),
    Obstacle(ObstacleId),
}

/// Names of two things that may touch. A `*` stands for any letters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TouchRule {
    /// A name or a pattern.
    pub a: String,
    /// The one that may touch `a`.
    pub b: String,
}

impl TouchRule {
    /// Whether the two may touch, in either order.
    pub fn allows(&self, first: &str, second: &str) -> bool {
        (fits_pattern(&self.a, first) && fits_pattern(&self.b, second))
            || (fits_pattern(&self.a, second) && fits_pattern(&self.b, first))
    }
}

/// Whether a name fits a pattern in which `*` stands for any letters.
pub fn fits_pattern(pattern: &str, name: &str) -> bool {
    let mut pieces = pattern.split('*');
    let Some(mut rest) = pieces.next().and_then(|first| name.strip_prefix(first)) else {
        return false;
    };
    let Some(last) = pieces.next_back() else {
        return rest.is_empty();
    };
    for piece in pieces {
        match rest.find(piece) {
            Some(at) => rest = &rest[at + piece.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

impl CollisionScene {
    pub(super) fn make_pairs(&self) -> Vec<Pair> {
        let mut pairs = Vec::new();
        for body in 0..self.bodies.len() {
            self.pairs_within_arm(body, &mut pairs);
            if self.bodies[body].owner == BodyOwner::Link(0) {
                continue;
            }
            for number in 0..self.obstacles.len() {
                if matches!(self.obstacles[number].place, ObstaclePlace::Standing(_)) {
                    pairs.push(Pair {
                        body,
                        partner: PairPartner::Obstacle(ObstacleId(number)),
                    });
                }
            }
        }
        pairs.retain(|pair| {
            let (a, b) = self.names(*pair);
            !self.touches.iter().any(|rule| rule.allows(a, b))
        });
        pairs
    }

    /// The pairs of a body with those nearer to the base.
    fn pairs_within_arm(&self, body: usize, pairs: &mut Vec<Pair>) {
        let outer: &Body = &self.bodies[body];
        for (other, inner) in self.bodies.iter().enumerate() {
            let BodyOwner::Link(inner) = inner.owner else {
                continue;
            };
            let counts = match outer.owner {
                BodyOwner::Link(link) => {
                    let tested = self.model.collision().tested_pairs();
                    inner < link
                        && (tested.contains(&(inner, link)) || tested.contains(&(link, inner)))
                }
                BodyOwner::Tool | BodyOwner::Held(_) => inner < FIRST_WRIST,
            };
            if counts {
                pairs.push(Pair {
                    body,
                    partner: PairPartner::Body(other),
                });
            }
        }
    }

    /// The joints that move the two of a pair relative to each other: those between their links.
    pub(super) fn joints_between(&self, pair: Pair) -> core::ops::Range<usize> {
        let outer = self.bodies[pair.body].link;
        let inner = match pair.partner {
            PairPartner::Body(other) => self.bodies[other].link,
            PairPartner::Obstacle(_) => 0,
        };
        inner.min(DOF)..outer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_stands_for_any_letters() {
        for (pattern, name, fits) in [
            ("tray", "tray", true),
            ("tray", "tray 2", false),
            ("tray*", "tray", true),
            ("tray*", "tray[3]", true),
            ("*tray", "big tray", true),
            ("t*y*2", "tray 12", true),
            ("t*y*2", "tray 13", false),
            ("*", "", true),
            ("a*a", "a", false),
            ("", "", true),
            ("", "x", false),
        ] {
            assert_eq!(fits_pattern(pattern, name), fits, "{pattern} {name}");
        }
        let rule = TouchRule {
            a: "tool".to_owned(),
            b: "tray*".to_owned(),
        };
        assert!(rule.allows("tool", "tray 1") && rule.allows("tray 1", "tool"));
        assert!(!rule.allows("forearm", "tray 1") && !rule.allows("tool", "tool"));
    }
}
