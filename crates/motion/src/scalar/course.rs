//! A way made of stretches with limits of their own, and the speeds at which one goes over into the next.
//!
//! At every joint of two stretches the acceleration is zero: simple, always feasible, and with one stretch (the usual
//! case) time-optimal. Owns the plan; moving along it is [`super::travel`].

use super::ScalarLimits;
use super::profile::Profile;
use super::ramp::exit_speed;
use super::{ScalarState, ramp::ramp};

/// Most stretches of a course.
pub const MAX_STRETCHES: usize = 64;

/// A part of the way with constant limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// How long it is, unit of s.
    pub length: f64,
    /// What is allowed on it.
    pub limits: ScalarLimits,
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
        exit_speed: 0.0,
    };

    /// A stretch of a course that is to be planned.
    pub fn new(length: f64, limits: ScalarLimits) -> Self {
        Self {
            length,
            limits,
            exit_speed: 0.0,
        }
    }
}

/// The whole way from rest to rest.
#[derive(Clone, Copy, Debug)]
pub struct Course {
    stretches: [Stretch; MAX_STRETCHES],
    count: usize,
    /// Everything is done at this fraction of the planned speed; below 1 when a longer duration is wanted.
    pace: f64,
    /// Time it takes at a pace of 1, s.
    fastest: f64,
    /// Time to wait at the end, s; only a way of no length has one.
    rest: f64,
}

impl Course {
    /// Plans the way over `stretches` from rest to rest. `None` when there are more than [`MAX_STRETCHES`], or limits or
    /// lengths are not usable.
    pub fn new(stretches: &[Stretch]) -> Option<Self> {
        let mut course = Self {
            stretches: [Stretch::NONE; MAX_STRETCHES],
            count: stretches.len(),
            pace: 1.0,
            fastest: 0.0,
            rest: 0.0,
        };
        let usable = |s: &Stretch| s.limits.are_usable() && s.length.is_finite() && s.length >= 0.0;
        if !stretches.iter().all(usable) {
            return None;
        }
        course
            .stretches
            .get_mut(..stretches.len())?
            .copy_from_slice(stretches);
        course.join();
        course.fastest = course.time_at_full_pace()?;
        Some(course)
    }

    /// A course of one stretch.
    pub fn of_one(length: f64, limits: ScalarLimits) -> Option<Self> {
        Self::new(&[Stretch::new(length, limits)])
    }

    /// The stretches in order.
    pub fn stretches(&self) -> &[Stretch] {
        self.stretches.get(..self.count).unwrap_or(&[])
    }

    /// Length of the way, unit of s.
    pub fn length(&self) -> f64 {
        self.stretches().iter().map(|s| s.length).sum()
    }

    /// The fraction of the planned speed at which the way is done.
    pub fn pace(&self) -> f64 {
        self.pace
    }

    /// Time to wait at the end of a way of no length, s.
    pub fn rest(&self) -> f64 {
        self.rest
    }

    /// Time the way takes, s.
    pub fn duration(&self) -> f64 {
        self.fastest / self.pace + self.rest
    }

    /// The same way in exactly `duration` seconds if that is longer than it takes now.
    pub fn stretched_to(mut self, duration: f64) -> Self {
        if self.length() <= 0.0 {
            self.rest = duration;
        } else if duration > self.fastest {
            self.pace = self.fastest / duration;
        }
        self
    }

    /// Chooses the exit speeds: as high as both neighbours allow, as can be braked from later (backward pass), and as can
    /// be reached from before (forward pass).
    fn join(&mut self) {
        let Some(stretches) = self.stretches.get_mut(..self.count) else {
            return;
        };
        let mut after = 0.0_f64; // speed at the end of the stretch looked at
        let mut next_limit = 0.0_f64;
        for stretch in stretches.iter_mut().rev() {
            stretch.exit_speed = after.min(next_limit).min(stretch.limits.speed);
            let exit = stretch.exit_speed;
            after = fastest_entry(stretch, exit);
            next_limit = stretch.limits.speed;
        }
        let mut entry = 0.0;
        for stretch in stretches.iter_mut() {
            let limits = (stretch.limits.acceleration, stretch.limits.jerk);
            if stretch.exit_speed > entry {
                let range = (entry, stretch.exit_speed);
                stretch.exit_speed =
                    exit_speed((entry, 0.0), range, true, stretch.length, limits).unwrap_or(entry);
            }
            entry = stretch.exit_speed;
        }
    }

    fn time_at_full_pace(&self) -> Option<f64> {
        let mut entry = 0.0;
        let mut time = 0.0;
        for stretch in self.stretches() {
            let start = ScalarState {
                position: 0.0,
                speed: entry,
                acceleration: 0.0,
            };
            let profile =
                Profile::to_position(start, stretch.length, stretch.exit_speed, &stretch.limits)?;
            time += profile.duration();
            entry = stretch.exit_speed;
        }
        Some(time)
    }
}

/// The highest speed at which a stretch can be entered so that it can be left at `exit`.
fn fastest_entry(stretch: &Stretch, exit: f64) -> f64 {
    let fits = |entry: f64| {
        ramp(
            entry,
            0.0,
            exit,
            stretch.limits.acceleration,
            stretch.limits.jerk,
        )
        .distance
            <= stretch.length
    };
    let (mut good, mut bad) = (exit, stretch.limits.speed.max(exit));
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
