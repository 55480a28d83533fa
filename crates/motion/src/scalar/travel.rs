//! Moving along a course, cycle by cycle: at full pace, slower, held, and back again, always within the limits.
//!
//! A speed fraction f plans with limits slowed by f, so at a constant fraction the motion is the same as at full speed,
//! stretched in time by 1/f. Braking (a lower fraction, a pause, a stop) uses the full limits of the stretch. A change
//! that does not fit into what is left of a stretch is made at the beginning of the next one; a pause in the last one
//! needs none, because the motion brakes there already.

use super::course::{Course, MAX_STRETCHES, Stretch};
use super::profile::Profile;
use super::ramp::{exit_speed, natural_speed, ramp};
use super::{ScalarLimits, ScalarState};

/// What is wanted of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Go on at this fraction of the course's pace, in (0, 1].
    Go(f64),
    /// Brake on the path and stand.
    Halt,
}

/// A motion under way along a course.
#[derive(Clone, Copy, Debug)]
pub struct Travel {
    course: Course,
    stretch: usize,
    /// Position at the beginning of the current stretch.
    behind: f64,
    /// Positions of the profile count from the beginning of the stretch.
    profile: Profile,
    time: f64,
    /// What the profile was planned for; `None` when it was not, and should be as soon as possible.
    planned: Option<Drive>,
    /// The fraction of the profile.
    fraction: f64,
    wanted: Drive,
    finished: bool,
}

impl Travel {
    /// At rest at the beginning of `course`; the first [`advance`](Self::advance) moves.
    pub fn new(course: Course, drive: Drive) -> Self {
        Self {
            course,
            stretch: 0,
            behind: 0.0,
            profile: Profile::standing(0.0, 0.0),
            time: 0.0,
            planned: None,
            fraction: 0.0,
            wanted: drive,
            finished: false,
        }
    }

    /// Under way already, in the state `now` at the beginning of `course`; its position is not used. `None` when the first
    /// stretch cannot be done from there: too fast for what follows.
    pub fn joining(course: Course, now: ScalarState, drive: Drive) -> Option<Self> {
        let mut travel = Self::new(course, drive);
        let first = travel.current().copied()?;
        let start = ScalarState {
            position: 0.0,
            ..now
        };
        let profile = travel.plan(&first, start)?;
        // A way with a lower exit speed than planned for is one; braking that does not end in time is none.
        if profile.end().position < first.length
            || profile.end().speed > first.exit_speed * (1.0 + 1e-9)
        {
            return None;
        }
        travel.follow(profile);
        Some(travel)
    }

    /// Changes what is wanted; takes effect in the next [`advance`](Self::advance).
    pub fn drive(&mut self, drive: Drive) {
        self.wanted = drive;
    }

    /// What is wanted of the motion.
    pub fn wanted(&self) -> Drive {
        self.wanted
    }

    /// The course.
    pub fn course(&self) -> &Course {
        &self.course
    }

    /// True when the end of the course is reached.
    pub fn is_finished(&self) -> bool {
        self.finished
    }

    /// True when the motion stands: finished, or halted with nothing left of the braking.
    pub fn is_standing(&self) -> bool {
        self.finished
            || (self.wanted == Drive::Halt && self.current().is_none())
            || (self.wanted == Drive::Halt
                && self.planned == Some(Drive::Halt)
                && self.time >= self.profile.duration()
                && self.profile.end().speed == 0.0)
    }

    /// The speed fraction that the motion follows now, 0 when it is halted.
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// The state `dt` seconds later; from the end of the course on exactly its end, at rest.
    pub fn advance(&mut self, dt: f64) -> ScalarState {
        if self.planned != Some(self.wanted) && !self.finished {
            self.replan();
        }
        self.time += dt;
        // Each pass leaves one stretch; one more finishes.
        for _ in 0..=MAX_STRETCHES {
            let over = self.time - self.profile.duration();
            if self.finished || over < 0.0 || !self.at_end_of_stretch() {
                break;
            }
            if self.current().is_none() {
                self.finished = true;
            } else {
                self.next_stretch(over);
            }
        }
        self.state()
    }

    /// The state now.
    pub fn state(&self) -> ScalarState {
        if self.finished {
            return ScalarState::at_rest(self.course.length());
        }
        let state = self.profile.at(self.time);
        ScalarState {
            position: self.behind + state.position,
            ..state
        }
    }

    /// Time until the position is `place`, or until the end and its rest, s; infinite when it is not reached. As of now: what is
    /// wanted stays as it is.
    pub fn time_to(&self, place: f64) -> f64 {
        let mut travel = *self;
        if travel.planned != Some(travel.wanted) && !travel.finished {
            travel.replan();
        }
        let mut time = 0.0;
        for _ in 0..=MAX_STRETCHES {
            let left = (travel.profile.duration() - travel.time).max(0.0);
            if travel.finished {
                return time;
            }
            if travel.current().is_some() {
                let reaches = |after: f64| {
                    travel.behind + travel.profile.at(travel.time + after).position >= place
                };
                if reaches(left) && place < travel.course.length() {
                    return time + first_true(left, reaches);
                }
            } else {
                return time + left;
            }
            if !travel.at_end_of_stretch() {
                return f64::INFINITY;
            }
            time += left;
            travel.next_stretch(0.0);
        }
        time
    }

    /// Time until the end of the course, s; infinite when it is not reached.
    pub fn time_left(&self) -> f64 {
        self.time_to(f64::INFINITY)
    }

    fn at_end_of_stretch(&self) -> bool {
        self.current()
            .is_none_or(|s| self.profile.end().position >= s.length)
    }

    fn current(&self) -> Option<&Stretch> {
        self.course.stretches().get(self.stretch)
    }

    fn next_stretch(&mut self, over: f64) {
        let entry = self.profile.end();
        self.behind += self.current().map_or(0.0, |s| s.length);
        self.stretch += 1;
        self.time = over;
        let Some(stretch) = self.current().copied() else {
            self.profile = Profile::standing(0.0, self.course.rest());
            return;
        };
        let start = ScalarState {
            position: 0.0,
            ..entry
        };
        match self.plan(&stretch, start) {
            Some(profile) => self.follow(profile),
            None => {
                // At the full limits of the stretch there is always a way on: the course was planned with them.
                self.profile = at_full_limits(&stretch, start);
                self.planned = None;
            }
        }
    }

    /// Plans anew from where the motion is; keeps the present profile when that does not fit into the stretch.
    fn replan(&mut self) {
        let Some(stretch) = self.current().copied() else {
            return;
        };
        let now = self.profile.at(self.time);
        if let Some(profile) = self.plan(&stretch, now) {
            self.follow(profile);
            self.time = 0.0;
        }
    }

    fn follow(&mut self, profile: Profile) {
        self.profile = profile;
        self.planned = Some(self.wanted);
        self.fraction = match self.wanted {
            Drive::Go(fraction) => fraction,
            Drive::Halt => 0.0,
        };
    }

    fn plan(&self, stretch: &Stretch, now: ScalarState) -> Option<Profile> {
        let left = stretch.length - now.position;
        match self.wanted {
            Drive::Halt => plan_halt(stretch, now, left),
            Drive::Go(fraction) => {
                let limits = stretch.paced().slowed(fraction);
                let exit = stretch.exit_speed * fraction;
                plan_go(stretch, now, exit, &limits)
                    .or_else(|| plan_slower(stretch, now, left, exit, &limits))
            }
        }
    }
}

/// Where between 0 and `most` something becomes true that is true at `most`.
fn first_true(most: f64, is_true: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, most);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if is_true(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Brakes to rest within the stretch, or, where that does not fit, as far as it does.
fn plan_halt(stretch: &Stretch, now: ScalarState, left: f64) -> Option<Profile> {
    let (a, j) = (stretch.limits.acceleration, stretch.limits.jerk);
    let halt = Profile::to_speed(now, 0.0, a, j);
    if halt.end().position <= stretch.length {
        return Some(halt);
    }
    let slowest = exit_speed(
        (now.speed, now.acceleration),
        (0.0, stretch.exit_speed),
        false,
        left,
        (a, j),
    )?;
    plan_go(stretch, now, slowest, &stretch.limits)
}

/// On to the end of the stretch at `exit`, or as fast as the distance allows.
fn plan_go(
    stretch: &Stretch,
    now: ScalarState,
    exit: f64,
    limits: &ScalarLimits,
) -> Option<Profile> {
    let left = stretch.length - now.position;
    let natural = natural_speed(now.speed, now.acceleration, limits.jerk);
    let exit = if exit > natural {
        let from = (now.speed, now.acceleration);
        let with = (limits.acceleration, limits.jerk);
        exit_speed(from, (natural.max(0.0), exit), true, left, with).unwrap_or(exit)
    } else {
        exit
    };
    Profile::to_position(now, stretch.length, exit, limits)
}

/// Brakes with the full limits of the stretch to a speed from which `limits` will do.
fn plan_slower(
    stretch: &Stretch,
    now: ScalarState,
    left: f64,
    exit: f64,
    limits: &ScalarLimits,
) -> Option<Profile> {
    let (a, j) = (stretch.limits.acceleration, stretch.limits.jerk);
    let brake = |goal: f64| ramp(now.speed, now.acceleration, goal, a, j).distance;
    let then = |from: f64| {
        let goal = exit.min(from);
        ramp(from, 0.0, goal, limits.acceleration, limits.jerk).distance
    };
    let fits = |speed: f64| brake(speed) + then(speed) <= left;
    // Not below the speed at which the acceleration is gone, unless the limits ask for it.
    let natural = natural_speed(now.speed, now.acceleration, j);
    let mut speed = limits.speed.min(natural).max(0.0);
    if !fits(speed) {
        // Braking to rest takes longest: with its distance set aside the rest grows with the speed.
        let set_aside = left - brake(0.0);
        let (mut good, mut bad) = (0.0, speed);
        for _ in 0..60 {
            let middle = 0.5 * (good + bad);
            if then(middle) <= set_aside {
                good = middle;
            } else {
                bad = middle;
            }
        }
        speed = good;
    }
    let first = Profile::to_speed(now, speed, a, j);
    let start = first.end();
    let second = plan_go(stretch, start, exit, limits)?;
    first.followed_by(&second)
}

/// The way through a stretch that is always there when it is entered at or below its planned entry speed.
fn at_full_limits(stretch: &Stretch, start: ScalarState) -> Profile {
    let limits = (stretch.limits.acceleration, stretch.limits.jerk);
    let wanted = stretch.exit_speed;
    let exit = if wanted < start.speed {
        exit_speed(
            (start.speed, 0.0),
            (wanted, start.speed),
            false,
            stretch.length,
            limits,
        )
    } else {
        None
    };
    let exit = exit.unwrap_or(wanted);
    plan_go(stretch, start, exit, &stretch.limits).unwrap_or_else(|| {
        // Only rounding can lead here: brake as hard as allowed.
        Profile::to_speed(start, 0.0, limits.0, limits.1)
    })
}
