//! From one leg into the next without a stop: a curve inside the blend radius, and one course over what is left of the
//! first leg, the curve and the second leg.
//!
//! The next leg is known at the earliest when the arm enters the zone. The curve begins a little further on, at a share of
//! the zone, and ends at the same distance behind the waypoint. It is made in joint space (see
//! [`JointQuintic`](crate::path::JointQuintic)), so that any two kinds of legs join alike, without inverse kinematics on
//! the way.
//!
//! The curve's s is that of the first leg; the second leg's is scaled so that equal distances from the waypoint are
//! equally long, or otherwise where the arm would be too fast for that. On the curve neither leg's speed is exceeded: not
//! the faster one's TCP speed where a leg is one of the TCP, not the faster one's leading joint between two joint legs. It
//! has one set of limits, so that the speed does not ripple; only where the arm must slow down for it there are two.

use kinematics::JointPositions;
use motion_api::Warning;

use super::able::{Able, PartBounds, Shares};
use super::corner::{Corner, Curve, SCALES, limits_at, point_at};
use super::curve::{CurveParts, CurveWish};
use super::leg::Leg;
use super::{Arm, Warnings, Wish};
use crate::constants::{BLEND_ENTRIES, BLEND_ENTRIES_PER_CYCLE, BLEND_PARTS, ZONE_STOPPING_SHARE};
use crate::path::{Chain, Geometry, Path, Piece};
use crate::scalar::{Course, Drive, ScalarLimits, ScalarState, Stretch, Stretches, Travel};
use crate::setpoint::elbow_speed;

/// How a curve may be walked without slowing down on it, in the order of liking.
const EVENLY: [Shape; 2] = [
    Shape {
        slowing: 0,
        shares: Shares::EVEN,
        hardness: 1.0,
    },
    Shape {
        slowing: 0,
        shares: Shares::PACED,
        hardness: 1.0,
    },
];
/// Counts of first parts that are there for slowing down, and how much harder than asked that may be.
const SLOWING: [(usize, f64); 6] = [(2, 1.0), (3, 1.0), (4, 1.0), (0, 2.0), (2, 2.0), (4, 2.0)];
/// A curve is worth slowing down for that bears at least this share of the present speed.
const WORTH_SLOWING: f64 = 0.3;

/// Paces of a leg that are tried so that it ends in time, and how much earlier it may be, s.
const PACES_TRIED: u32 = 16;
/// See [`PACES_TRIED`].
const IN_TIME: f64 = 1e-4;
/// See [`PACES_TRIED`]: from one to the next slower one.
const WIDER: f64 = 1.4;

/// How a curve is walked.
#[derive(Clone, Copy, Debug)]
struct Shape {
    /// So many of its first parts are for slowing down.
    slowing: usize,
    /// What bends may take of the joints' limits on the rest: the more, the less is there for a change of speed.
    shares: Shares,
    /// The slowing may be this much harder than the legs are asked to accelerate.
    hardness: f64,
}

/// The attempts to join one leg to another, some in each cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Junction {
    tried: usize,
}

/// A motion under way that may be joined to another.
#[derive(Clone, Copy, Debug)]
pub struct UnderWay<'a> {
    /// Its last leg.
    pub leg: &'a Leg,
    /// The leg's place in the chain.
    pub piece: &'a Piece,
    /// How the chain is travelled.
    pub travel: &'a Travel,
    /// State along the chain.
    pub now: ScalarState,
    /// Where the joints are now.
    pub q: JointPositions,
}

/// Two legs joined.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    /// Where.
    pub chain: Chain,
    /// How fast, from the present state on.
    pub travel: Travel,
    /// The next leg; its zone may have been shortened.
    pub leg: Leg,
    /// Its zone in the chain's s.
    pub zone: f64,
}

impl Junction {
    /// True when there is nothing left to try: the motion stops at the waypoint.
    pub fn is_given_up(&self) -> bool {
        self.tried >= BLEND_ENTRIES.len()
    }

    /// The attempts of one cycle. `None` when none of the curves that are tried can be done from the present state.
    pub fn attempt(
        &mut self,
        first: &UnderWay,
        next: &Leg,
        arm: &Arm,
        warnings: &mut Warnings,
    ) -> Option<Joined> {
        for _ in 0..BLEND_ENTRIES_PER_CYCLE {
            let share = *BLEND_ENTRIES.get(self.tried)?;
            self.tried += 1;
            let Some(corner) = Corner::new(first, next, share, arm) else {
                continue;
            };
            if let Some((turn, shape, joined)) = join(first, &corner, arm) {
                corner.warnings.iter().for_each(|w| warnings.add(w));
                return Some(turn.in_time(shape, joined, arm, warnings));
            }
        }
        None
    }
}

/// Over the first curve that can be walked without slowing down on it, otherwise over the one that asks for least of it.
fn join<'a>(
    first: &'a UnderWay<'a>,
    corner: &'a Corner,
    arm: &Arm,
) -> Option<(Turn<'a>, Shape, Joined)> {
    let first_of = |turn: &Turn, mut shapes: core::slice::Iter<Shape>| {
        shapes.find_map(|shape| Some((*shape, turn.join(*shape, turn.pace(), arm)?)))
    };
    let mut best: Option<(f64, Turn)> = None;
    for scale in SCALES {
        let Some(turn) = Turn::new(first, corner, corner.curve(scale), arm) else {
            continue;
        };
        let borne = turn
            .parts
            .limits(0..BLEND_PARTS, &turn.wish, Shares::PACED, arm);
        let share = borne.map_or(0.0, |limits| limits.speed / corner.now.speed);
        if share >= 1.0
            && let Some((shape, joined)) = first_of(&turn, EVENLY.iter())
        {
            return Some((turn, shape, joined));
        }
        if best.as_ref().is_none_or(|(most, _)| share > *most) {
            best = Some((share, turn));
        }
    }
    let (_, turn) = best.filter(|(share, _)| *share >= WORTH_SLOWING)?;
    let shapes = SLOWING.map(|(slowing, hardness)| Shape {
        slowing,
        shares: Shares::PACED,
        hardness,
    });
    let (shape, joined) =
        first_of(&turn, EVENLY.iter()).or_else(|| first_of(&turn, shapes.iter()))?;
    Some((turn, shape, joined))
}

/// One curve at a corner, and what it bears.
struct Turn<'a> {
    first: &'a UnderWay<'a>,
    corner: &'a Corner,
    curve: Curve,
    parts: CurveParts,
    wish: CurveWish,
    /// Limits of the next leg where the curve ends, in the curve's s.
    right: ScalarLimits,
}

impl<'a> Turn<'a> {
    /// `None` when the curve leaves the radius or a joint's range, or there is none.
    fn new(
        first: &'a UnderWay<'a>,
        corner: &'a Corner,
        curve: Option<Curve>,
        arm: &Arm,
    ) -> Option<Self> {
        let curve = curve?;
        let parts = CurveParts::look(&curve.quintic, first.leg, arm)?;
        let left = first.leg.course.stretches().last().map(Stretch::paced)?;
        let right = slowed_by_rate(limits_at(&corner.next.course, corner.exit)?, curve.rate);
        let (before, after) = parts.tcp_at_ends();
        let (mut tcp, mut turn) = (f64::INFINITY, f64::INFINITY);
        let is_joint = |leg: &Leg| matches!(leg.path.geometry(), Geometry::Joint(_));
        if is_joint(first.leg) && is_joint(&corner.next) {
            // The leading joint turns one radian per s of the first leg, and `rate` of them on the second.
            turn = left.speed.max(right.speed * curve.rate);
        } else if before.max(after) >= 1e-6 {
            // A tool that only turns has no TCP speed to keep to.
            tcp = (before * left.speed).max(after * right.speed);
        }
        let wish = CurveWish {
            speed: left.speed.max(right.speed),
            tcp,
            turn,
            // Where the slower leg accelerates gently the arm must still get down to its speed within the radius.
            acceleration: left.acceleration.max(right.acceleration),
        };
        Some(Self {
            first,
            corner,
            curve,
            parts,
            wish,
            right,
        })
    }

    /// `joined`, or the same at the pace that lets the second leg end in time where a duration is wanted of it. The time of a
    /// leg counts from the waypoint before: from when the first leg would have ended, if that has a duration too, otherwise
    /// from the middle of the curve.
    fn in_time(&self, shape: Shape, joined: Joined, arm: &Arm, warnings: &mut Warnings) -> Joined {
        let Drive::Go(fraction) = self.first.travel.wanted() else {
            return joined;
        };
        let wanted = self.corner.next.duration;
        if wanted <= 0.0 {
            return joined;
        }
        let begins = if self.first.leg.duration > 0.0 {
            self.first.travel.time_left()
        } else {
            let middle = self.corner.lead() + self.curve.quintic.length() / 2.0;
            joined.travel.time_to(middle)
        };
        let due = begins + wanted / fraction;
        let at = |pace: f64| {
            let joined = self.join(shape, pace, arm)?;
            Some((joined.travel.time_left() - due, joined))
        };
        let Some((late, fastest)) = at(1.0) else {
            return joined;
        };
        if late > due * 1e-9 {
            warnings.add(Warning::DurationStretched {
                wanted,
                planned: wanted + late * fraction,
            });
            return fastest;
        }
        // The time left grows with the inverse of the pace: widened until it is too long, then regula falsi (Illinois).
        let (mut fast, mut slow) = ((1.0, late), None);
        let mut found = fastest;
        let mut inverse = 1.0 / self.pace();
        for _ in 0..PACES_TRIED {
            match at(1.0 / inverse) {
                Some((late, joined)) if late <= 0.0 => {
                    found = joined;
                    if -late < IN_TIME {
                        break;
                    }
                    fast = (inverse, late);
                    slow = slow.map(|(slow, late)| (slow, 0.5 * late));
                }
                Some((late, _)) => {
                    slow = Some((inverse, late));
                    fast.1 *= 0.5;
                }
                // So slow a leg cannot be entered at the speed that the arm has.
                None => slow = Some((inverse, f64::INFINITY)),
            }
            inverse = match slow {
                Some((slow, late)) if late.is_finite() => {
                    fast.0 + (slow - fast.0) * fast.1 / (fast.1 - late)
                }
                Some((slow, _)) => 0.5 * (fast.0 + slow),
                None => WIDER * inverse,
            };
        }
        found
    }

    /// The pace that the second leg was planned with.
    fn pace(&self) -> f64 {
        let stretches = self.corner.next.course.stretches();
        stretches.first().map_or(1.0, |stretch| stretch.pace)
    }

    /// `None` when the curve cannot be walked as `shape` says from the present state, and the second leg at `pace`.
    fn join(&self, shape: Shape, pace: f64, arm: &Arm) -> Option<Joined> {
        let (first, corner) = (self.first, self.corner);
        let mut next = corner.next;
        next.course = next.course.at_pace(pace);
        let (piece, rate) = (first.piece, self.curve.rate);
        let mut list = Stretches::NONE;
        let wish = CurveWish {
            acceleration: self.wish.acceleration * shape.hardness,
            ..self.wish
        };
        if shape.hardness > 1.0 {
            list.push(self.hard_lead(wish.acceleration, arm)?);
        } else {
            let entry_in_chain = piece.begin + (corner.entry - piece.from) / piece.rate;
            let part = (first.now.position, entry_in_chain);
            list.push_part(first.travel.course(), part, 1.0 / piece.rate);
        }
        let whole = self.curve.quintic.length();
        let length = |parts: usize| whole * parts as f64 / BLEND_PARTS as f64;
        if shape.slowing > 0 {
            let parts = 0..shape.slowing;
            let limits = self.parts.limits(parts, &wish, Shares::EVEN, arm)?;
            list.push(Stretch::new(length(shape.slowing), limits));
        }
        let parts = shape.slowing..BLEND_PARTS;
        let limits = self.parts.limits(parts, &self.wish, shape.shares, arm)?;
        let limits = alike(limits, &self.right);
        list.push(Stretch::new(length(BLEND_PARTS - shape.slowing), limits));
        list.push_part(&next.course, (corner.exit, next.path.length()), rate);
        let lead = corner.lead();
        let begin = lead + whole;
        let zone = begin + (next.zone - corner.exit) / rate;
        if next.radius > 0.0 {
            list = list.with_zone(zone, ZONE_STOPPING_SHARE, next.zone_speed / rate);
        }
        let travel = Travel::joining(Course::moving(&list)?, corner.now, first.travel.wanted())?;
        let chain = Chain::of_three([
            Piece {
                path: first.leg.path,
                from: corner.now.position,
                rate: 1.0,
                begin: 0.0,
            },
            Piece {
                path: Path::new(Geometry::Blend(self.curve.quintic)),
                from: 0.0,
                rate: 1.0,
                begin: lead,
            },
            Piece {
                path: next.path,
                from: corner.exit,
                rate,
                begin,
            },
        ]);
        Some(Joined {
            chain,
            travel,
            leg: next,
            zone,
        })
    }

    /// What is left of the first leg, to be walked with more acceleration than was asked for, as far as the joints can.
    fn hard_lead(&self, acceleration: f64, arm: &Arm) -> Option<Stretch> {
        let (first, corner) = (self.first, self.corner);
        let path = &first.leg.path;
        let now = corner.now.position;
        let mut bounds = PartBounds::NONE;
        let mut left = path.point(arm.model, now, &first.q)?;
        for share in [0.5, 1.0] {
            let place = now + corner.lead() * share;
            let right = point_at(path, arm.model, (left.s, &left.q), place)?;
            let frames = arm.model.forward(&right.q);
            let elbow = elbow_speed(&frames, &kinematics::JointSpeeds(right.first));
            bounds.cover(&left, &right, elbow, arm);
            left = right;
        }
        let limits = Able::of(&bounds, arm.limits).at(&Wish {
            speed: limits_at(&first.leg.course, now)?
                .speed
                .max(corner.now.speed),
            acceleration,
            duration: 0.0,
            radius: 0.0,
        });
        limits
            .are_usable()
            .then_some(Stretch::new(corner.lead(), limits))
    }
}

/// The limits of the neighbour where those are as fast: one stretch needs no end of acceleration between them.
fn alike(limits: ScalarLimits, neighbour: &ScalarLimits) -> ScalarLimits {
    let bears = |own: f64, other: f64| own >= other * (1.0 - 1e-9);
    let is_as_fast = bears(limits.speed, neighbour.speed)
        && bears(neighbour.speed, limits.speed)
        && bears(limits.acceleration, neighbour.acceleration)
        && bears(limits.jerk, neighbour.jerk);
    if is_as_fast { *neighbour } else { limits }
}

/// Limits of an s of which `rate` go to one of another, in that other.
fn slowed_by_rate(limits: ScalarLimits, rate: f64) -> ScalarLimits {
    ScalarLimits {
        speed: limits.speed / rate,
        acceleration: limits.acceleration / rate,
        jerk: limits.jerk / rate,
    }
}
