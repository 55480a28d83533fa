//! The scalar profiles and travel along a course: limits kept, ends exact, as fast as an independent planner.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

use motion::scalar::course::MAX_STRETCHES;
use motion::scalar::{Course, Drive, Profile, ScalarLimits, ScalarState, Stretch, Travel};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rsruckig::prelude::*;

const STEP: f64 = 0.004;

fn limits() -> impl Strategy<Value = ScalarLimits> {
    (0.05..3.0f64, 0.2..20.0f64, 0.01..0.1f64).prop_map(|(speed, acceleration, ramp_time)| {
        ScalarLimits {
            speed,
            acceleration,
            jerk: acceleration / ramp_time,
        }
    })
}

/// The duration of the same motion planned by rsruckig, an independent planner.
fn ruckig_duration(from: ScalarState, to: f64, exit: f64, limits: &ScalarLimits) -> f64 {
    let mut planner = Ruckig::<1, ThrowErrorHandler>::new(None, STEP);
    let mut input = InputParameter::<1>::new(None);
    input.current_position[0] = from.position;
    input.current_velocity[0] = from.speed;
    input.current_acceleration[0] = from.acceleration;
    input.target_position[0] = to;
    input.target_velocity[0] = exit;
    input.max_velocity[0] = limits.speed;
    input.max_acceleration[0] = limits.acceleration;
    input.max_jerk[0] = limits.jerk;
    let mut trajectory = Trajectory::<1>::new(None);
    planner.calculate(&input, &mut trajectory).expect("a plan");
    trajectory.get_duration()
}

/// Checks that consecutive states keep the limits, by their own derivatives and by differences of positions.
struct Watch {
    limits: ScalarLimits,
    positions: Vec<f64>,
}

impl Watch {
    fn new(limits: ScalarLimits, start: f64) -> Self {
        Self {
            limits,
            positions: vec![start; 4],
        }
    }

    fn see(&mut self, state: ScalarState) {
        let l = &self.limits;
        let slack = 1.0 + 1e-9;
        assert!(
            state.speed >= -1e-9 && state.speed <= l.speed * slack,
            "{state:?}"
        );
        assert!(
            state.acceleration.abs() <= l.acceleration * slack,
            "{state:?} {l:?}"
        );
        self.positions.push(state.position);
        let n = self.positions.len();
        let [a, b, c, d] = [1, 2, 3, 4].map(|k| self.positions[n - 5 + k]);
        let rounding = 2e-12 * (1.0 + d.abs());
        let (first, second, third) = (d - c, d - 2.0 * c + b, d - 3.0 * c + 3.0 * b - a);
        assert!(
            first >= -rounding && first <= l.speed * STEP * slack + rounding,
            "{state:?} {first} {:?}",
            &self.positions[n - 6..]
        );
        assert!(second.abs() <= l.acceleration * STEP.powi(2) * slack + rounding);
        assert!(
            third.abs() <= l.jerk * STEP.powi(3) * slack + rounding,
            "jerk {}",
            third / STEP.powi(3)
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..Default::default() })]

    #[test]
    fn a_profile_from_rest_takes_as_long_as_an_independent_planner_says(limits in limits(), exponent in -6.0..1.5f64) {
        let distance = 10f64.powf(exponent);
        let start = ScalarState::at_rest(0.3);
        let profile = Profile::to_position(start, 0.3 + distance, 0.0, &limits).unwrap();
        let expected = ruckig_duration(start, 0.3 + distance, 0.0, &limits);
        prop_assert!((profile.duration() - expected).abs() <= 1e-6 * expected, "{} {expected}", profile.duration());
    }

    #[test]
    fn a_profile_between_speeds_is_time_optimal_too(
        limits in limits(), distance in 0.5..5.0f64, entry in 0.0..1.0f64, exit in 0.0..1.0f64,
    ) {
        let start = ScalarState { position: 0.0, speed: entry * limits.speed, acceleration: 0.0 };
        let exit = exit * limits.speed;
        if let Some(profile) = Profile::to_position(start, distance, exit, &limits) {
            let expected = ruckig_duration(start, distance, exit, &limits);
            prop_assert!(profile.duration() <= expected * (1.0 + 1e-6), "{} {expected}", profile.duration());
        }
    }

    #[test]
    fn a_profile_keeps_its_limits_and_ends_exactly(limits in limits(), distance in 1e-6..5.0f64) {
        let profile = Profile::to_position(ScalarState::at_rest(0.0), distance, 0.0, &limits).unwrap();
        let mut watch = Watch::new(limits, 0.0);
        let cycles = (profile.duration() / STEP).ceil() as usize;
        for cycle in 1..=cycles + 3 {
            watch.see(profile.at(cycle as f64 * STEP));
        }
        prop_assert_eq!(*watch.positions.last().unwrap(), distance);
        // The analytic end of the phases and the exact end are the same place.
        let before = profile.at(profile.duration() * (1.0 - 1e-12));
        prop_assert!((before.position - distance).abs() < 1e-9 && before.speed.abs() < 1e-6);
    }

    #[test]
    fn any_sequence_of_pauses_and_speed_changes_keeps_the_limits_and_arrives(
        limits in limits(),
        distance in 0.01..2.0f64,
        pace in 1.0..3.0f64,
        orders in prop::collection::vec((1usize..120, 0.0..1.0f64, any::<bool>()), 0..12),
    ) {
        let course = Course::of_one(distance, limits).unwrap();
        let course = course.stretched_to(course.duration() * pace);
        drive_and_check(course, limits, distance, &orders)?;
    }

    #[test]
    fn courses_of_many_stretches_keep_every_limit_under_any_orders(
        parts in prop::collection::vec((limits(), 0.001..0.5f64), 1..12),
        orders in prop::collection::vec((1usize..120, 0.0..1.0f64, any::<bool>()), 0..12),
    ) {
        let stretches: Vec<_> = parts.iter().map(|(l, length)| Stretch::new(*length, *l)).collect();
        let course = Course::new(&stretches).unwrap();
        // The largest of each limit holds everywhere; the limits of the stretch are checked at the end of each cycle.
        let most = parts.iter().fold(parts[0].0, |m, (l, _)| ScalarLimits {
            speed: m.speed.max(l.speed),
            acceleration: m.acceleration.max(l.acceleration),
            jerk: m.jerk.max(l.jerk),
        });
        let travelled = drive_and_check(course, most, course.length(), &orders)?;
        for state in travelled {
            let mut behind = 0.0;
            for stretch in course.stretches() {
                if state.position > behind + 1e-9 && state.position < behind + stretch.length - 1e-9 {
                    prop_assert!(state.speed <= stretch.limits.speed * (1.0 + 1e-9));
                    prop_assert!(state.acceleration.abs() <= stretch.limits.acceleration * (1.0 + 1e-9));
                }
                behind += stretch.length;
            }
        }
    }
}

/// Goes along the course with the orders (cycles to wait, fraction, halt instead), then at full speed to the end.
fn drive_and_check(
    course: Course,
    limits: ScalarLimits,
    length: f64,
    orders: &[(usize, f64, bool)],
) -> Result<Vec<ScalarState>, TestCaseError> {
    let mut travel = Travel::new(course, Drive::Go(1.0));
    let mut watch = Watch::new(limits, 0.0);
    let mut seen = Vec::new();
    for (cycles, fraction, halt) in orders {
        for _ in 0..*cycles {
            let state = travel.advance(STEP);
            watch.see(state);
            seen.push(state);
        }
        travel.drive(if *halt {
            Drive::Halt
        } else {
            Drive::Go(fraction.max(0.01))
        });
    }
    travel.drive(Drive::Go(1.0));
    let mut left = 200_000;
    while !travel.is_finished() {
        let state = travel.advance(STEP);
        watch.see(state);
        seen.push(state);
        left -= 1;
        prop_assert!(left > 0, "does not arrive: {:?}", travel.state());
    }
    prop_assert_eq!(travel.state(), ScalarState::at_rest(length));
    watch.see(travel.advance(STEP));
    Ok(seen)
}

fn fast() -> ScalarLimits {
    ScalarLimits {
        speed: 1.0,
        acceleration: 2.0,
        jerk: 60.0,
    }
}

#[test]
fn half_speed_takes_exactly_twice_as_long() {
    let course = Course::of_one(1.0, fast()).unwrap();
    let cycles = |fraction| {
        let mut travel = Travel::new(course, Drive::Go(fraction));
        let mut n = 0;
        while !travel.is_finished() {
            travel.advance(1e-4);
            n += 1;
        }
        n as f64 * 1e-4
    };
    assert!((cycles(0.5) - 2.0 * cycles(1.0)).abs() < 4e-4);
}

#[test]
fn a_longer_duration_is_met_exactly() {
    let course = Course::of_one(1.0, fast()).unwrap().stretched_to(7.5);
    assert_eq!(course.duration(), 7.5);
    let mut travel = Travel::new(course, Drive::Go(1.0));
    for _ in 0..1874 {
        travel.advance(STEP);
        assert!(!travel.is_finished());
    }
    travel.advance(STEP + 1e-12);
    assert!(travel.is_finished());
}

#[test]
fn a_halt_stands_within_the_braking_time_and_does_not_pass_the_end() {
    for cycles in 1..400 {
        let mut travel = Travel::new(Course::of_one(1.0, fast()).unwrap(), Drive::Go(1.0));
        for _ in 0..cycles {
            travel.advance(STEP);
        }
        travel.drive(Drive::Halt);
        // From full speed: v/a + a/j; while accelerating a/j more.
        let most = 1.0 / 2.0 + 2.0 * 2.0 / 60.0 + STEP;
        let mut time = 0.0;
        while !travel.is_standing() {
            travel.advance(STEP);
            time += STEP;
            assert!(time <= most + STEP, "after {cycles} cycles");
        }
        assert!(travel.state().position <= 1.0);
        assert_eq!(travel.state().speed, 0.0);
    }
}

#[test]
fn unusable_stretches_are_not_planned() {
    let bad = ScalarLimits {
        speed: f64::NAN,
        ..fast()
    };
    assert!(Course::of_one(1.0, bad).is_none());
    assert!(Course::of_one(f64::INFINITY, fast()).is_none());
    assert!(Course::new(&[Stretch::new(0.1, fast()); MAX_STRETCHES + 1]).is_none());
}
