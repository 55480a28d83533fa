//! The pace of a line that asks more of the joints in some places than in others.
//!
//! The speed that each part bears is a staircase over s; a line through its inner corners is the limit. Under it goes the
//! fastest speed curve with limited acceleration (backward pass over the parts, forward steps of equal time; Biagiotti and
//! Melchiorri 2008, 9.4). Its places at equal times are the control points of a [`Pace`]: at the wanted speed along its
//! parameter the arm follows the curve. What that asks of the joints is then bounded piece by piece; where it is too much
//! the parts are slowed and the pace is made anew. So nothing here needs to be exact to be safe.

use super::able::{Able, Shares};
use super::parts::Part;
use super::{Arm, Wish};
use crate::constants::{LINE_PARTS_MAX, PACE_ATTEMPTS, PACE_KNOT_TIME, PACE_SHARE};
use crate::path::{PACE_POINTS, Pace};
use crate::scalar::ramp::ramp;
use crate::scalar::{Course, ScalarLimits, Stretch, Stretches};

/// A pace counts as reached where at least this share of the wanted speed is borne.
const REACHED: f64 = 0.999;
/// Share of the wanted acceleration that is there for starting and stopping whatever the pace takes.
const LEAST_SHARE: f64 = 0.1;
/// What a part bears is lowered by this factor more where it was too much.
const SLOWED: f64 = 0.97;
/// Pieces walked evenly differ from that by no more than a rounding.
const EVEN: f64 = 1e-9;

/// A pace that is being made.
#[derive(Clone, Copy, Debug)]
pub struct PacePlanner {
    /// Speed along the parameter.
    speed: f64,
    /// What each part may be walked with.
    allowed: [Allowed; LINE_PARTS_MAX],
    count: usize,
    attempts: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Allowed {
    until: f64,
    speed: f64,
    acceleration: f64,
    jerk: f64,
}

impl PacePlanner {
    /// For a line in parts that bear different speeds; none of more than `speed` is wanted.
    pub fn new(parts: &[Part], speed: f64, wish: &Wish, arm: &Arm) -> Self {
        let mut allowed = [Allowed::default(); LINE_PARTS_MAX];
        for (slot, part) in allowed.iter_mut().zip(parts) {
            let able = Able::of(&part.bounds, arm.limits);
            let limits = able.at(&at_speed(wish, speed, 0.0, 1.0));
            *slot = Allowed {
                until: part.until,
                speed: limits.speed,
                acceleration: PACE_SHARE * limits.acceleration,
                jerk: PACE_SHARE * limits.jerk,
            };
        }
        Self {
            speed,
            allowed,
            count: parts.len().min(LINE_PARTS_MAX),
            attempts: 0,
        }
    }

    /// One attempt. `None` while there is reason for another; otherwise the pace with its course, or `Some(None)` when
    /// there is none.
    pub fn work(
        &mut self,
        parts: &[Part],
        wish: &Wish,
        arm: &Arm,
    ) -> Option<Option<(Pace, Course)>> {
        self.attempts += 1;
        let Some(pace) = self.pace() else {
            return Some(None);
        };
        let mut walked = Walked::NONE;
        let mut is_reached = true;
        let mut begin = 0.0;
        for (part, allowed) in parts.iter().zip(&mut self.allowed) {
            let end = pace.reaching(part.until);
            for piece in pace.pieces(begin, end) {
                let bounds = part
                    .bounds
                    .walked_at(piece.first, piece.second, piece.third);
                let able = Able::sharing(&bounds, arm.limits, Shares::PACED);
                if able.speed() < self.speed * REACHED {
                    is_reached = false;
                    let borne = piece.first * able.speed() * SLOWED;
                    allowed.speed = allowed.speed.min(borne);
                }
                let bend = piece.second * self.speed * self.speed;
                let limits = able.at(&at_speed(wish, self.speed, bend, piece.first));
                if !limits.are_usable() {
                    return Some(None);
                }
                let is_even = piece.first >= 1.0 - EVEN && bend <= EVEN * allowed.acceleration;
                walked.push(Step {
                    length: piece.length,
                    limits,
                    is_even,
                })?;
            }
            begin = end;
        }
        if !is_reached && self.attempts < PACE_ATTEMPTS {
            return None;
        }
        let list = walked.stretches(self.speed);
        Some(Course::new(list.as_slice()).map(|course| (pace, course)))
    }

    fn parts(&self) -> &[Allowed] {
        self.allowed.get(..self.count).unwrap_or(&[])
    }

    /// The pace under what the parts are allowed.
    fn pace(&self) -> Option<Pace> {
        let way = self.parts().last()?.until;
        let mut begin = 0.0;
        let least_time: f64 = self
            .parts()
            .iter()
            .map(|part| {
                let time = (part.until - begin) / part.speed;
                begin = part.until;
                time
            })
            .sum();
        let mut knot_time = PACE_KNOT_TIME.max(least_time / (PACE_POINTS - 16) as f64);
        for _ in 0..8 {
            let mut points = [0.0; PACE_POINTS];
            if let Some(count) = self.walk(way, knot_time, &mut points) {
                return Pace::new(points.get(..count)?, knot_time * self.speed, way);
            }
            knot_time *= 1.3;
        }
        None
    }

    /// The places at equal times along the speed curve; `None` when they are too many.
    fn walk(&self, way: f64, time: f64, points: &mut [f64; PACE_POINTS]) -> Option<usize> {
        let curve = SpeedCurve::new(self.parts(), time);
        let window = |from: f64, to: f64, first: usize| curve.least(from, to, first);
        let mut first = 0;
        let mut step = window(0.0, 2.0 * self.speed * time, 0) * time;
        (points[0], points[1], points[2]) = (-step, 0.0, step);
        let mut count = 3;
        while points[count - 2] < way {
            let here = points[count - 1];
            first = curve.part_at(points[count - 2], first);
            let fastest = self
                .speed
                .min(step / time + curve.acceleration(points[count - 2], here, first) * time);
            let least = window(points[count - 2], here + 2.0 * fastest * time, first);
            step = fastest.min(least) * time;
            if step <= 1e-12 * way {
                return None;
            }
            *points.get_mut(count)? = here + step;
            count += 1;
        }
        Some(count)
    }
}

/// The wish along a parameter of which s goes `first` per unit, where the pace itself takes `bend` of the acceleration.
fn at_speed(wish: &Wish, speed: f64, bend: f64, first: f64) -> Wish {
    let acceleration = if wish.duration > 0.0 {
        f64::INFINITY
    } else {
        (wish.acceleration - bend).max(LEAST_SHARE * wish.acceleration) / first
    };
    Wish {
        speed,
        acceleration,
        duration: 0.0,
        ..*wish
    }
}

/// Most pieces of a pace between its knots and the ends of the parts.
const STEPS_MAX: usize = PACE_POINTS + LINE_PARTS_MAX;

/// A piece of the parameter, or some neighbouring ones, with limits of its own.
#[derive(Clone, Copy, Debug)]
struct Step {
    length: f64,
    limits: ScalarLimits,
    /// The way is walked evenly there.
    is_even: bool,
}

impl Step {
    const NONE: Self = Self {
        length: 0.0,
        limits: ScalarLimits {
            speed: f64::INFINITY,
            acceleration: f64::INFINITY,
            jerk: f64::INFINITY,
        },
        is_even: false,
    };

    /// Takes in a neighbour.
    fn join(&mut self, other: &Self) {
        self.length += other.length;
        self.limits = ScalarLimits {
            speed: self.limits.speed.min(other.limits.speed),
            acceleration: self.limits.acceleration.min(other.limits.acceleration),
            jerk: self.limits.jerk.min(other.limits.jerk),
        };
    }
}

/// The pieces in order.
struct Walked {
    steps: [Step; STEPS_MAX],
    count: usize,
}

impl Walked {
    const NONE: Self = Self {
        steps: [Step::NONE; STEPS_MAX],
        count: 0,
    };

    /// `None` when there are too many.
    fn push(&mut self, step: Step) -> Option<()> {
        *self.steps.get_mut(self.count)? = step;
        self.count += 1;
        Some(())
    }

    /// Starting and stopping have the limits of the pieces on which they happen; in between, where the speed along the
    /// parameter does not change, neighbours of one kind are one.
    fn stretches(&self, speed: f64) -> Stretches {
        let steps = self.steps.get(..self.count).unwrap_or(&[]);
        let reaching = |mut steps: core::slice::Iter<Step>, is_backwards: bool| {
            let mut all = Step::NONE;
            let mut count = 0;
            while let Some(step) = if is_backwards {
                steps.next_back()
            } else {
                steps.next()
            } {
                all.join(step);
                count += 1;
                let limits = &all.limits;
                let goal = speed.min(limits.speed);
                let way = ramp(0.0, 0.0, goal, limits.acceleration, limits.jerk).distance;
                if way <= all.length {
                    break;
                }
            }
            count
        };
        let (mut first, mut last) = (reaching(steps.iter(), false), reaching(steps.iter(), true));
        if first + last > steps.len() {
            (first, last) = (0, 0);
        }
        let kind = |number: usize| {
            if number < first {
                0
            } else if number >= steps.len() - last {
                1
            } else {
                2 + usize::from(steps.get(number).is_some_and(|step| step.is_even))
            }
        };
        let mut list = Stretches::NONE;
        let mut group: Option<(usize, Step)> = None;
        for (number, step) in steps.iter().enumerate() {
            match &mut group {
                Some((of, all)) if *of == kind(number) => all.join(step),
                _ => {
                    if let Some((_, done)) = group.replace((kind(number), *step)) {
                        list.push(Stretch::new(done.length, done.limits));
                    }
                }
            }
        }
        if let Some((_, done)) = group {
            list.push(Stretch::new(done.length, done.limits));
        }
        list
    }
}

/// The speed over s from which the slower parts ahead can still be reached.
struct SpeedCurve<'a> {
    parts: &'a [Allowed],
    slopes: [Slope; LINE_PARTS_MAX],
}

/// The curve on one part: below the line between two speeds, and below the braking to the speed at its end.
#[derive(Clone, Copy, Default)]
struct Slope {
    begin: f64,
    /// Speeds of the line at both ends.
    line: (f64, f64),
    acceleration: f64,
    /// Speed at its end, with which the next part begins.
    after: f64,
}

impl<'a> SpeedCurve<'a> {
    fn new(parts: &'a [Allowed], time: f64) -> Self {
        let mut slopes = [Slope::default(); LINE_PARTS_MAX];
        let mut after = f64::INFINITY;
        for (k, part) in parts.iter().enumerate().rev() {
            // From one knot to the next the acceleration may turn into its opposite.
            let acceleration = part.acceleration.min(0.5 * part.jerk * time);
            let before = k.checked_sub(1).and_then(|k| parts.get(k));
            let begin = before.map_or(0.0, |part| part.until);
            let speed_with = |other: Option<&Allowed>| {
                other.map_or(part.speed, |other| other.speed.min(part.speed))
            };
            let line = (speed_with(before), speed_with(parts.get(k + 1)));
            let slope = Slope {
                begin,
                line,
                acceleration,
                after: after.min(line.1),
            };
            after = slope.speed(begin, part.until);
            if let Some(slot) = slopes.get_mut(k) {
                *slot = slope;
            }
        }
        Self { parts, slopes }
    }

    /// The part at s, looked for from `first` on.
    fn part_at(&self, s: f64, first: usize) -> usize {
        let last = self.parts.len().saturating_sub(1);
        (first..last)
            .find(|k| self.parts.get(*k).is_some_and(|part| s < part.until))
            .unwrap_or(last)
    }

    /// The slopes between two places, with the places where each is entered and left, and where it ends.
    fn between(
        &self,
        (from, to): (f64, f64),
        first: usize,
    ) -> impl Iterator<Item = (&Slope, [f64; 3])> {
        let first = self.part_at(from, first);
        let parts = self.parts.iter().zip(&self.slopes).skip(first);
        parts
            .enumerate()
            .take_while(move |(k, (_, slope))| *k == 0 || slope.begin <= to)
            .map(move |(_, (part, slope))| {
                let inside = |s: f64| s.max(slope.begin).min(part.until);
                (slope, [inside(from), inside(to), part.until])
            })
    }

    /// The least acceleration between two places.
    fn acceleration(&self, from: f64, to: f64, first: usize) -> f64 {
        self.between((from, to), first)
            .fold(f64::INFINITY, |least, (slope, _)| {
                least.min(slope.acceleration)
            })
    }

    /// The least speed between two places.
    fn least(&self, from: f64, to: f64, first: usize) -> f64 {
        self.between((from, to), first)
            .fold(f64::INFINITY, |least, (slope, [from, to, until])| {
                // The line is lowest at an end, the braking at the far one.
                least
                    .min(slope.speed(from, until))
                    .min(slope.speed(to, until))
            })
    }
}

impl Slope {
    /// The speed at s on a part that ends at `until`.
    fn speed(&self, s: f64, until: f64) -> f64 {
        let length = until - self.begin;
        let share = if length > 0.0 {
            (s - self.begin) / length
        } else {
            1.0
        };
        let line = self.line.0 + (self.line.1 - self.line.0) * share;
        let braking = (self.after * self.after + 2.0 * self.acceleration * (until - s)).sqrt();
        line.min(braking)
    }
}
