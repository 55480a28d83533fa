//! Motion of one number along a track: limits kept, ends exact, as fast as an independent planner where the limits are
//! the same everywhere, and never faster than a place allows.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use motion::scalar::{
    IntervalLimits, Pace, PathProgress, ProgressGoal, ScalarLimits, ScalarState,
    VelocityLimitCurve, smoothing_window,
};
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

/// What may be wanted on the way.
fn order() -> impl Strategy<Value = ProgressGoal> {
    prop_oneof![
        4 => (0.05..1.0f64).prop_map(ProgressGoal::Run),
        1 => Just(ProgressGoal::Stop),
        1 => Just(ProgressGoal::StopHard),
    ]
}

/// The duration of a motion from rest to rest planned by rsruckig, an independent planner.
fn ruckig_duration(length: f64, limits: &ScalarLimits) -> f64 {
    let mut planner = Ruckig::<1, ThrowErrorHandler>::new(None, STEP);
    let mut input = InputParameter::<1>::new(None);
    input.target_position[0] = length;
    input.max_velocity[0] = limits.speed;
    input.max_acceleration[0] = limits.acceleration;
    input.max_jerk[0] = limits.jerk;
    let mut trajectory = Trajectory::<1>::new(None);
    planner.calculate(&input, &mut trajectory).expect("a plan");
    trajectory.get_duration()
}

fn cell(limits: &ScalarLimits) -> IntervalLimits {
    IntervalLimits {
        speed: limits.speed,
        asked: [limits.acceleration; 2],
        braking: [limits.acceleration; 2],
        planned: [limits.acceleration; 2],
        max_braking: [limits.acceleration; 2],
        jerk: limits.jerk,
    }
}

fn even(length: f64, limits: &ScalarLimits) -> VelocityLimitCurve {
    let mut track = VelocityLimitCurve::new(4);
    track.restart(smoothing_window(limits, length));
    track.push(length, cell(limits)).unwrap();
    track.recompute();
    track
}

/// Steps to the end; the states, and the time of the last.
fn walk(track: &VelocityLimitCurve, drives: impl Fn(f64) -> ProgressGoal) -> Vec<ScalarState> {
    let mut travel = PathProgress::new(track);
    let mut states = vec![ScalarState::default(); 4];
    for k in 0..200_000 {
        travel.set_goal(drives(f64::from(k) * STEP));
        states.push(travel.advance(STEP, track));
        if travel.is_finished(track) {
            return states;
        }
    }
    panic!("it does not end: {:?}", states.last());
}

/// The largest speed, acceleration and jerk by differences.
fn largest(states: &[ScalarState]) -> [f64; 3] {
    let mut most = [0.0_f64; 3];
    for w in states.windows(4) {
        let p: Vec<f64> = w.iter().map(|s| s.position).collect();
        most[0] = most[0].max((p[3] - p[2]) / STEP);
        most[1] = most[1].max(((p[3] - 2.0 * p[2] + p[1]) / (STEP * STEP)).abs());
        let jerk = (p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0]) / (STEP * STEP * STEP);
        most[2] = most[2].max(jerk.abs());
    }
    most
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: RngSeed::Fixed(1),
        ..Default::default() })]

    #[test]
    fn from_rest_to_rest_it_keeps_the_limits_and_is_as_fast_as_an_independent_planner(
        limits in limits(),
        length in 0.005..3.0f64,
    ) {
        let track = even(length, &limits);
        let states = walk(&track, |_| ProgressGoal::Run(1.0));
        let end = states[states.len() - 1];
        prop_assert_eq!(end, ScalarState::at_rest(length));
        let [speed, acceleration, jerk] = largest(&states);
        prop_assert!(speed <= limits.speed * (1.0 + 1e-9));
        prop_assert!(acceleration <= limits.acceleration * (1.0 + 1e-6) + 1e-6, "{acceleration}");
        prop_assert!(jerk <= limits.jerk * (1.0 + 1e-3) + 1e-3, "{} {}", jerk, limits.jerk);
        let taken = (states.len() - 4) as f64 * STEP;
        let shortest = ruckig_duration(length, &limits);
        prop_assert!(taken >= shortest - 1e-6, "{taken} {shortest}");
        prop_assert!(taken <= shortest * 1.002 + STEP + track.window() / 32.0, "{taken} {shortest}");
        let (foreseen, _) = PathProgress::new(&track).predict_times(&track, length);
        prop_assert!((foreseen - taken).abs() <= STEP + track.window() / 16.0, "{foreseen} {taken}");
    }

    #[test]
    fn in_uneven_cells_it_is_nowhere_faster_than_allowed_and_keeps_the_jerk(
        speeds in prop::collection::vec(0.02..1.0f64, 2..12),
        cell_length in 0.001..0.3f64,
        acceleration in 0.5..8.0f64,
    ) {
        let mut track = VelocityLimitCurve::new(16);
        let limits = |speed| ScalarLimits { speed, acceleration, jerk: acceleration / 0.03 };
        track.restart(smoothing_window(&limits(10.0), f64::INFINITY));
        for (k, speed) in speeds.iter().enumerate() {
            track.push((k + 1) as f64 * cell_length, cell(&limits(*speed))).unwrap();
        }
        track.recompute();
        let states = walk(&track, |_| ProgressGoal::Run(1.0));
        for state in &states {
            let k = ((state.position / cell_length) as usize).min(speeds.len() - 1);
            prop_assert!(state.speed <= speeds[k] * (1.0 + 1e-6), "{state:?} {}", speeds[k]);
        }
        let [_, a, jerk] = largest(&states);
        prop_assert!(a <= acceleration * (1.0 + 1e-3), "{a}");
        prop_assert!(jerk <= 1.02 * acceleration / 0.03, "{jerk} {}", acceleration / 0.03);
    }

    #[test]
    fn slowed_held_and_let_go_at_any_moment_it_keeps_acceleration_and_jerk_and_gets_there(
        orders in prop::collection::vec((0.002..0.15f64, order()), 1..12),
        speeds in prop::collection::vec(0.1..1.0f64, 1..5),
        length in 0.002..0.4f64,
        acceleration in 0.5..8.0f64,
    ) {
        let limits = |speed| ScalarLimits { speed, acceleration, jerk: acceleration / 0.03 };
        let mut track = VelocityLimitCurve::new(8);
        track.restart(smoothing_window(&limits(10.0), f64::INFINITY));
        for (k, speed) in speeds.iter().enumerate() {
            let until = length * (k + 1) as f64 / speeds.len() as f64;
            track.push(until, cell(&limits(*speed))).unwrap();
        }
        track.recompute();
        let states = walk(&track, |time| {
            let mut until = 0.0;
            let now = orders.iter().find(|(lasts, _)| {
                until += lasts;
                time < until
            });
            now.map_or(ProgressGoal::Run(1.0), |(_, drive)| *drive)
        });
        prop_assert_eq!(states[states.len() - 1], ScalarState::at_rest(track.end()));
        let [_, a, jerk] = largest(&states);
        prop_assert!(a <= acceleration * (1.0 + 1e-3), "{a}");
        prop_assert!(jerk <= 1.02 * acceleration / 0.03, "{jerk} {}", acceleration / 0.03);
        prop_assert!(states.windows(2).all(|w| w[1].position >= w[0].position - 1e-12));
    }
}

#[test]
fn held_a_rounding_before_the_end_it_gets_there_when_it_is_let_go() {
    let limits = ScalarLimits {
        speed: 0.4,
        acceleration: 1.2,
        jerk: 40.0,
    };
    let mut held = 0;
    for length in (200..400).map(|k| f64::from(k) * 1.1e-3) {
        let track = even(length, &limits);
        let mut travel = PathProgress::new(&track);
        travel.set_goal(ProgressGoal::Run(1.0));
        // Whoever brakes for the end already comes to rest there.
        while travel.committed_speed() > 0.0 || travel.time() == 0.0 {
            travel.advance(STEP, &track);
            if travel.committed() > 0.9 * length {
                travel.set_goal(ProgressGoal::Stop);
            }
        }
        while !travel.is_standing(&track) {
            travel.advance(STEP, &track);
        }
        held += usize::from(!travel.is_finished(&track));
        travel.set_goal(ProgressGoal::Run(1.0));
        for _ in 0..20 {
            travel.advance(STEP, &track);
        }
        assert!(travel.is_finished(&track), "{length}: {travel:?}");
    }
    assert!(held > 10, "{held}");
}

#[test]
fn at_any_pace_the_time_that_is_foreseen_is_the_time_it_takes() {
    let limits = ScalarLimits {
        speed: 3.0,
        acceleration: 10.0,
        jerk: 500.0,
    };
    for pace in [1.0, 0.5, 0.2, 0.07, 0.01] {
        let mut track = even(0.5, &limits);
        track.set_pace(0.0, Pace::stretched(pace));
        track.recompute();
        let (foreseen, _) = PathProgress::new(&track).predict_times(&track, f64::INFINITY);
        let taken = (walk(&track, |_| ProgressGoal::Run(1.0)).len() - 4) as f64 * STEP;
        assert!(
            (foreseen - taken).abs() <= STEP,
            "{pace}: {foreseen} {taken}"
        );
    }
}

#[test]
fn at_a_constant_fraction_it_takes_so_much_longer() {
    let limits = ScalarLimits {
        speed: 0.25,
        acceleration: 1.2,
        jerk: 40.0,
    };
    let track = even(0.3, &limits);
    let full = walk(&track, |_| ProgressGoal::Run(1.0)).len();
    let half = walk(&track, |_| ProgressGoal::Run(0.5)).len();
    assert!(
        (half as i64 - 4 - 2 * (full as i64 - 4)).abs() <= 2,
        "{full} {half}"
    );
}

#[test]
fn a_way_is_lengthened_under_way_without_slowing_down() {
    let limits = ScalarLimits {
        speed: 0.25,
        acceleration: 1.2,
        jerk: 40.0,
    };
    let mut track = VelocityLimitCurve::new(64);
    track.restart(smoothing_window(&limits, f64::INFINITY));
    let mut end = 0.1;
    track.push(end, cell(&limits)).unwrap();
    track.recompute();
    let mut travel = PathProgress::new(&track);
    travel.set_goal(ProgressGoal::Run(1.0));
    let mut speeds = Vec::new();
    while !travel.is_finished(&track) {
        let state = travel.advance(STEP, &track);
        speeds.push(state.speed);
        if end < 1.0 && end - state.position < 0.08 {
            track.forget_before(travel.oldest());
            end += 0.005;
            track.push(end, cell(&limits)).unwrap();
            track.recompute();
        }
    }
    let reached = speeds.iter().position(|v| *v > 0.2499).unwrap();
    let braking = speeds.iter().rposition(|v| *v > 0.2499).unwrap();
    assert!(speeds[reached..braking].iter().all(|v| *v > 0.2499));
    assert!(braking - reached > 800, "{reached} {braking}");
}
