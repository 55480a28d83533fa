//! A way made of stretches with limits of their own, and the speeds at which one goes over into the next.
//!
//! At every joint of two stretches the acceleration is zero: simple, always feasible, and with one stretch (the usual
//! case) time-optimal. Owns the plan; moving along it is [`super::travel`].

use super::ScalarLimits;
use super::profile::Profile;
use super::ramp::exit_speed;
use super::{ScalarState, ramp::ramp};

/// Most stretches of a course: the rest of a leg, a blend and another leg.
pub const MAX_STRETCHES: usize = 96;

/// Halvings of the pace before a zone; the rest of the wanted duration is met by slowing all of the way.
const ZONE_HALVINGS: u32 = 10;

/// A part of the way with constant limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// How long it is, unit of s.
    pub length: f64,
    /// What is allowed on it.
    pub limits: ScalarLimits,
    /// It is done at this fraction of the speed that is allowed; below 1 when a longer duration is wanted.
    pub pace: f64,
    /// The speed at its end. Set by [`Course::new`].
    pub exit_speed: f64,
}

impl Stretch {
    const NONE: Self = Self {
        length: 0.0,
        limits: ScalarLimits {
            speed: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
        },
        pace: 1.0,
        exit_speed: 0.0,
    };

    /// A stretch of a course that is to be planned.
    pub fn new(length: f64, limits: ScalarLimits) -> Self {
        Self {
            length,
            limits,
            ..Self::NONE
        }
    }

    /// The limits it is done with.
    pub fn paced(&self) -> ScalarLimits {
        self.limits.slowed(self.pace)
    }

    /// The same stretch counted in an s of which `rate` of the present one go to one of the new.
    #[must_use]
    fn converted(self, rate: f64) -> Self {
        let l = self.limits;
        Self {
            length: self.length / rate,
            limits: ScalarLimits {
                speed: l.speed / rate,
                acceleration: l.acceleration / rate,
                jerk: l.jerk / rate,
            },
            exit_speed: self.exit_speed / rate,
            ..self
        }
    }
}

/// Stretches of a course that is being put together. More than [`MAX_STRETCHES`] make it unusable.
#[derive(Clone, Copy, Debug)]
pub struct Stretches {
    list: [Stretch; MAX_STRETCHES],
    count: usize,
    is_full: bool,
}

impl Stretches {
    /// No stretch.
    pub const NONE: Self = Self {
        list: [Stretch::NONE; MAX_STRETCHES],
        count: 0,
        is_full: false,
    };

    /// The stretches in order.
    pub fn as_slice(&self) -> &[Stretch] {
        self.list.get(..self.count).unwrap_or(&[])
    }

    /// Adds one at the end. Neighbours with the same limits become one: at the joints of stretches the acceleration is 0.
    pub fn push(&mut self, stretch: Stretch) {
        if stretch.length <= 0.0 {
            return;
        }
        if let Some(last) = self.count.checked_sub(1).and_then(|k| self.list.get_mut(k))
            && last.limits == stretch.limits
            && last.pace == stretch.pace
        {
            last.length += stretch.length;
            last.exit_speed = stretch.exit_speed;
        } else if let Some(next) = self.list.get_mut(self.count) {
            *next = stretch;
            self.count += 1;
        } else {
            self.is_full = true;
        }
    }

    /// Adds the part of `course` between two of its places, counted in an s of which `rate` of the course's go to one.
    pub fn push_part(&mut self, course: &Course, (from, to): (f64, f64), rate: f64) {
        let mut begin = 0.0;
        for stretch in course.stretches() {
            let end = begin + stretch.length;
            let length = end.min(to) - begin.max(from);
            // What rounding leaves of a stretch is none.
            if length > 1e-12 * (1.0 + end) {
                self.push(Stretch { length, ..*stretch }.converted(rate));
            }
            begin = end;
        }
    }

    /// The same stretches, done from the place `zone` on no faster than `fastest`, and than it is possible to stop within
    /// `share` of the rest.
    #[must_use]
    pub fn with_zone(&self, zone: f64, share: f64, fastest: f64) -> Self {
        let length: f64 = self.as_slice().iter().map(|s| s.length).sum();
        let mut begin = 0.0;
        let (mut acceleration, mut jerk) = (f64::INFINITY, f64::INFINITY);
        for stretch in self.as_slice() {
            begin += stretch.length;
            if begin > zone {
                let limits = stretch.paced();
                acceleration = limits.acceleration.min(acceleration);
                jerk = limits.jerk.min(jerk);
            }
        }
        let room = share * (length - zone);
        let speed = fastest_stop(room, acceleration, jerk).min(fastest);
        let mut slowed = Self::NONE;
        let mut begin = 0.0;
        for stretch in self.as_slice() {
            let before = (zone - begin).clamp(0.0, stretch.length);
            slowed.push(Stretch {
                length: before,
                ..*stretch
            });
            let mut inside = Stretch {
                length: stretch.length - before,
                ..*stretch
            };
            inside.limits.speed = inside.limits.speed.min(speed / inside.pace);
            slowed.push(inside);
            begin += stretch.length;
        }
        slowed.is_full |= self.is_full;
        slowed
    }
}

/// The whole way to rest.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    stretches: Stretches,
    /// Time it takes at full pace from rest, s; 0 when it does not begin at rest.
    fastest: f64,
    /// Wanted duration, s, when that is longer; 0 otherwise.
    stretched: f64,
    /// Time to wait at the end, s; only a way of no length has one.
    rest: f64,
}

impl Course {
    /// Plans the way over `stretches` from rest to rest. `None` when there are more than [`MAX_STRETCHES`], or limits or
    /// lengths are not usable.
    pub fn new(stretches: &[Stretch]) -> Option<Self> {
        let mut list = Stretches::NONE;
        // Not through `push`: a way of no length has a stretch too.
        list.list
            .get_mut(..stretches.len())?
            .copy_from_slice(stretches);
        list.count = stretches.len();
        let mut course = Self::joined(&list, 0.0)?;
        course.fastest = course.time_from_rest()?;
        Some(course)
    }

    /// Plans the way over `stretches` to rest, begun at a speed that the caller makes sure fits: see
    /// [`Travel::joining`](super::Travel::joining).
    pub fn moving(stretches: &Stretches) -> Option<Self> {
        let fastest = stretches.as_slice().first()?.paced().speed;
        Self::joined(stretches, fastest)
    }

    fn joined(stretches: &Stretches, entry: f64) -> Option<Self> {
        let usable = |s: &Stretch| s.limits.are_usable() && s.length.is_finite() && s.length >= 0.0;
        if stretches.is_full || !stretches.as_slice().iter().all(usable) {
            return None;
        }
        let mut course = Self {
            stretches: *stretches,
            fastest: 0.0,
            stretched: 0.0,
            rest: 0.0,
        };
        course.join(entry);
        Some(course)
    }

    /// A course of one stretch.
    pub fn of_one(length: f64, limits: ScalarLimits) -> Option<Self> {
        Self::new(&[Stretch::new(length, limits)])
    }

    /// The stretches in order.
    pub fn stretches(&self) -> &[Stretch] {
        self.stretches.as_slice()
    }

    /// The stretches as a list to go on from.
    pub fn list(&self) -> &Stretches {
        &self.stretches
    }

    /// Length of the way, unit of s.
    pub fn length(&self) -> f64 {
        self.stretches().iter().map(|s| s.length).sum()
    }

    /// Time to wait at the end of a way of no length, s.
    pub fn rest(&self) -> f64 {
        self.rest
    }

    /// Time the way takes from rest, s.
    pub fn duration(&self) -> f64 {
        self.fastest.max(self.stretched) + self.rest
    }

    /// The same way in exactly `duration` seconds if that is longer than it takes now.
    pub fn stretched_to(mut self, duration: f64) -> Self {
        if self.length() <= 0.0 {
            self.rest = duration;
        } else if duration > self.fastest {
            self.stretched = duration;
            let pace = self.fastest / duration;
            for stretch in &mut self.stretches.list {
                stretch.pace *= pace;
                stretch.exit_speed *= pace;
            }
        }
        self
    }

    /// The same way with every stretch at this fraction of what is allowed on it. For a way that is gone on with: the time it
    /// takes from rest is not worked out.
    #[must_use]
    pub fn at_pace(mut self, pace: f64) -> Self {
        for stretch in &mut self.stretches.list {
            stretch.exit_speed *= pace / stretch.pace;
            stretch.pace = pace;
        }
        self
    }

    /// The same way from rest with a zone at its end as of [`Stretches::with_zone`], in `duration` seconds, or as fast as
    /// it is when that is longer or 0. What the zone costs is made up for before it.
    pub fn with_zone(&self, zone: f64, share: f64, fastest: f64, duration: f64) -> Option<Self> {
        let at = |pace: f64| {
            let mut list = self.stretches;
            for stretch in &mut list.list {
                stretch.pace = pace;
            }
            Self::new(list.with_zone(zone, share, fastest).as_slice())
        };
        let full = at(1.0)?;
        if full.duration() >= duration {
            return Some(full);
        }
        // At the pace of the whole way without a zone it takes at least as long as asked for.
        let (mut fast, mut slow) = (1.0, self.stretches().first()?.pace);
        let mut found = full;
        for _ in 0..ZONE_HALVINGS {
            let middle = 0.5 * (fast + slow);
            let course = at(middle)?;
            if course.duration() <= duration {
                (fast, found) = (middle, course);
            } else {
                slow = middle;
            }
        }
        Some(found.stretched_to(duration))
    }

    /// Chooses the exit speeds: as high as both neighbours allow, as can be braked from later (backward pass), and as can
    /// be reached from before (forward pass, begun at the speed `entry`).
    fn join(&mut self, mut entry: f64) {
        let Some(stretches) = self.stretches.list.get_mut(..self.stretches.count) else {
            return;
        };
        let mut after = 0.0_f64; // speed at the end of the stretch looked at
        let mut next_limit = 0.0_f64;
        for stretch in stretches.iter_mut().rev() {
            let limits = stretch.paced();
            stretch.exit_speed = after.min(next_limit).min(limits.speed);
            after = fastest_entry(stretch, stretch.exit_speed);
            next_limit = limits.speed;
        }
        for stretch in stretches.iter_mut() {
            let limits = stretch.paced();
            if stretch.exit_speed > entry {
                let range = (entry, stretch.exit_speed);
                let with = (limits.acceleration, limits.jerk);
                stretch.exit_speed =
                    exit_speed((entry, 0.0), range, true, stretch.length, with).unwrap_or(entry);
            }
            entry = stretch.exit_speed;
        }
    }

    fn time_from_rest(&self) -> Option<f64> {
        let mut entry = 0.0;
        let mut time = 0.0;
        for stretch in self.stretches() {
            let start = ScalarState {
                position: 0.0,
                speed: entry,
                acceleration: 0.0,
            };
            let limits = stretch.paced();
            let profile = Profile::to_position(start, stretch.length, stretch.exit_speed, &limits)?;
            time += profile.duration();
            entry = stretch.exit_speed;
        }
        Some(time)
    }
}

/// The highest speed from which one can stop within `room`.
fn fastest_stop(room: f64, acceleration: f64, jerk: f64) -> f64 {
    let fits = |speed: f64| ramp(speed, 0.0, 0.0, acceleration, jerk).distance <= room;
    // Without a limit of jerk it would be this.
    let (mut good, mut bad) = (0.0, (2.0 * acceleration * room.max(0.0)).sqrt());
    for _ in 0..60 {
        let middle = 0.5 * (good + bad);
        if fits(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

/// The highest speed at which a stretch can be entered so that it can be left at `exit`.
fn fastest_entry(stretch: &Stretch, exit: f64) -> f64 {
    let limits = stretch.paced();
    let fits = |entry: f64| {
        ramp(entry, 0.0, exit, limits.acceleration, limits.jerk).distance <= stretch.length
    };
    let (mut good, mut bad) = (exit, limits.speed.max(exit));
    if fits(bad) {
        return bad;
    }
    for _ in 0..60 {
        let middle = 0.5 * (good + bad);
        if fits(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}
