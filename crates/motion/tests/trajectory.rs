//! Lists that are followed in time: to a thousandth of a radian where the joints can, through pauses, stops, other
//! speeds and other lists without a jump.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::{Bench, MODELS, ideal};
use kinematics::JointPositions;
use motion_api::{
    CommandKind, MachineCommand, MotionCommand, Outcome, Refusal, RobotState, SettingCommand,
};

const STEP: f64 = 0.004;

/// Samples of a function of time, from `from` on.
fn samples(
    from: &JointPositions,
    seconds: f64,
    way: impl Fn(f64) -> [f64; 6],
) -> Vec<JointPositions> {
    let count = (seconds / STEP).round() as usize + 1;
    (0..count)
        .map(|k| {
            let by = way(k as f64 * STEP);
            JointPositions(core::array::from_fn(|joint| from[joint] + by[joint]))
        })
        .collect()
}

/// There and back with speeds and accelerations that begin and end at zero.
fn swing(size: f64, seconds: f64) -> impl Fn(f64) -> [f64; 6] {
    move |t| {
        let angle = t / seconds * std::f64::consts::TAU;
        let by =
            size * (1.0 - angle.cos()) * 0.5 * (std::f64::consts::PI * t / seconds).sin().powi(2);
        [by, -0.5 * by, by, 0.3 * by, -by, 0.8 * by]
    }
}

fn away(state: &RobotState, point: &JointPositions) -> f64 {
    (0..6).fold(0.0_f64, |most, joint| {
        most.max((state.target_q[joint] - point[joint]).abs())
    })
}

/// How far the arm is from the nearest piece of the list at most.
fn beside(states: &[RobotState], list: &[JointPositions]) -> f64 {
    states.iter().fold(0.0_f64, |most, state| {
        let nearest = list.windows(2).fold(f64::MAX, |least, pair| {
            let (a, b) = (&pair[0], &pair[1]);
            let way: f64 = (0..6).map(|j| (b[j] - a[j]).powi(2)).sum();
            let along: f64 = (0..6)
                .map(|j| (state.target_q[j] - a[j]) * (b[j] - a[j]))
                .sum();
            let share = if way > 0.0 {
                (along / way).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let there = JointPositions(core::array::from_fn(|j| a[j] + share * (b[j] - a[j])));
            least.min(away(state, &there))
        });
        most.max(nearest)
    })
}

/// The best agreement with the list in time, over the cycles by which it may have begun later, or its second sample
/// first.
fn late(states: &[RobotState], list: &[JointPositions]) -> f64 {
    (0..5).fold(f64::MAX, |least, shift: usize| {
        let most = states
            .iter()
            .skip(shift.saturating_sub(1))
            .zip(&list[usize::from(shift == 0)..])
            .fold(0.0_f64, |most, (state, point)| most.max(away(state, point)));
        least.min(most)
    })
}

#[test]
fn a_smooth_list_is_followed_in_time() {
    for name in MODELS {
        let mut bench = Bench::new(ideal(name));
        let list = samples(&bench.now().target_q, 3.0, swing(0.6, 3.0));
        let from = bench.states.len();
        let id = bench.follow(&list, STEP);
        assert_eq!(bench.finish(id), Outcome::Done);
        bench.check_limits();
        let apart = late(&bench.states[from..], &list);
        assert!(apart < 2e-4, "{name}: {apart}");
        assert_eq!(bench.now().target_q, *list.last().unwrap());
        assert_eq!(bench.now().target_qd.max_abs(), 0.0);
    }
}

#[test]
fn a_line_from_rest_is_caught_up_with() {
    let mut bench = Bench::new(ideal("cs66"));
    let list = samples(&bench.now().target_q, 2.0, |t| {
        [0.3 * t.min(1.5), 0.0, 0.0, 0.0, 0.0, 0.0]
    });
    let from = bench.states.len();
    let id = bench.follow(&list, STEP);
    assert_eq!(bench.finish(id), Outcome::Done);
    bench.check_limits();
    // After the start, and before the list stops as suddenly.
    let apart = late(&bench.states[from + 100..], &list[100..370]);
    assert!(apart < 1e-3, "{apart}");
}

#[test]
fn slider_pause_and_stop_keep_to_the_list() {
    let mut bench = Bench::new(ideal("cs66"));
    let list = samples(&bench.now().target_q, 4.0, swing(0.8, 4.0));
    let from = bench.states.len();
    let id = bench.follow(&list, STEP);
    bench.run(250);
    bench.send(SettingCommand::SetSpeedFraction(0.3));
    bench.run(300);
    bench.do_it(MachineCommand::Pause);
    bench.run(120);
    assert_eq!(bench.now().target_qd.max_abs(), 0.0);
    let held = bench.now().target_q;
    bench.run(50);
    assert_eq!(bench.now().target_q, held);
    bench.do_it(MachineCommand::Resume);
    bench.run(100);
    bench.send(SettingCommand::SetSpeedFraction(1.0));
    bench.run(100);
    bench.do_it(MachineCommand::Stop { only: id });
    assert_eq!(bench.finish(id), Outcome::Aborted);
    assert_eq!(bench.now().target_qd.max_abs(), 0.0);
    bench.check_limits();
    let apart = beside(&bench.states[from..], &list);
    assert!(apart < 1e-3, "{apart}");
    // The way back to the beginning, as the next list.
    let here = bench.now().target_q;
    let next = samples(&here, 1.0, |_| [0.0; 6]);
    let id = bench.follow(&next, STEP);
    assert_eq!(bench.finish(id), Outcome::Done);
    assert_eq!(bench.now().target_q, here);
}

#[test]
fn a_list_takes_over_from_another_in_motion_without_a_jump() {
    let mut bench = Bench::new(ideal("cs66"));
    let first = samples(&bench.now().target_q, 3.0, swing(0.8, 3.0));
    let id = bench.follow(&first, STEP);
    bench.run(200);
    for _ in 0..5 {
        bench.run(40);
        let now = bench.now();
        assert!(now.target_qd.max_abs() > 0.01);
        // From where the arm is, with another speed, to a goal of its own.
        let list = samples(&now.target_q, 1.0, |t| {
            [0.1 * t, 0.2 * t * t, 0.0, -0.1 * t, 0.0, 0.05]
        });
        let from = bench.states.len();
        let next = bench.follow(&list, STEP);
        bench.run(2);
        assert!(bench.states.len() > from);
        if id != next {
            let ended = bench
                .ended
                .iter()
                .any(|(ended, outcome, _)| *ended == id && *outcome == Outcome::Aborted);
            assert!(ended);
        }
    }
    bench.run(600);
    bench.check_limits();
}

#[test]
fn lists_that_begin_elsewhere_and_other_motions_are_refused() {
    let mut bench = Bench::new(ideal("cs66"));
    let home = bench.now().target_q;
    let far = samples(&home, 0.5, |_| [0.11, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let id = bench.follow(&far, STEP);
    let refused = bench.finish(id);
    let Outcome::Refused(refusal) = refused else {
        panic!("{refused:?}")
    };
    assert!(refusal.to_string().contains("0.1 rad"), "{refusal}");
    // A little away is made good.
    let near = samples(&home, 1.0, |_| [0.09, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let id = bench.follow(&near, STEP);
    bench.run(20);
    let program = motion_api::Origin {
        program: motion_api::ProgramId(7),
        ..motion_api::Origin::default()
    };
    let target = home;
    let other = bench.script.commands.send(
        program,
        CommandKind::Motion(MotionCommand::MoveJ {
            target,
            acceleration: 1.0,
            speed: 1.0,
            duration: 0.0,
            radius: 0.0,
        }),
    );
    let refused = bench.finish(other.unwrap());
    assert!(
        matches!(refused, Outcome::Refused(Refusal::Busy { .. })),
        "{refused:?}"
    );
    assert_eq!(bench.finish(id), Outcome::Done);
    bench.check_limits();
    assert_eq!(bench.now().target_q, near[0]);
}
