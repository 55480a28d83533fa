use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::track::TraceSample;
use super::*;

/// An arm that stands until `begin` and then swings, sampled every `step`.
fn swing(begin: f64, step: f64, end: f64, size: f64) -> RunTrace {
    let mut track = RunTrace::default();
    let count = (end / step) as usize;
    for number in 0..count {
        let time = number as f64 * step;
        let since = (time - begin).max(0.0);
        // Begins smoothly.
        let angle = size * (1.0 - (1.3 * since).cos()) * (0.4 * since).cos();
        track.push(TraceSample {
            time,
            q: [angle, 0.5 * angle, 0.0, 1.0, -0.2 * angle, 0.0],
            position: Vector3::new(angle, 0.0, 0.3),
            rotation: UnitQuaternion::from_euler_angles(0.0, 0.0, angle),
            speed: since.min(1.0),
            force: Vector3::zeros(),
        });
    }
    track
}

fn of(first: &RunTrace, second: &RunTrace) -> Comparison {
    compare(first, second, align(first, second))
}

#[test]
fn a_run_is_equal_to_itself_at_any_rate_and_any_delay() {
    let slow = swing(1.0, 0.008, 12.0, 0.5);
    for (begin, step) in [(1.0, 0.008), (3.731, 0.008), (0.2, 0.002), (2.5, 0.0051)] {
        let other = swing(begin, step, 12.0 + begin, 0.5);
        let found = of(&slow, &other);
        assert!(
            (found.alignment.shift - (begin - 1.0)).abs() < 2e-4,
            "{found:?}"
        );
        assert!(found.largest_joint().expect("joints") < 1e-4, "{found:?}");
        assert!(found.tcp_rotation.expect("known").largest < 1e-4);
        assert!(found.overlap.1 > 10.0);
    }
}

#[test]
fn differences_have_their_size_and_place() {
    let first = swing(1.0, 0.004, 10.0, 0.5);
    let mut second = RunTrace::default();
    for sample in first.samples() {
        let mut other = *sample;
        if (6.0..6.1).contains(&sample.time) {
            other.q[3] += 0.02;
            other.position.z += 0.005;
            other.force.x = 7.0;
        }
        second.push(other);
    }
    let found = of(&first, &second);
    let joint = found.joints[3].expect("known");
    assert!(
        (joint.largest - 0.02).abs() < 1e-4 && (6.0..6.1).contains(&joint.at),
        "{joint:?}"
    );
    assert!(
        (joint.rms - 0.02 * (0.1_f64 / 9.99).sqrt()).abs() < 2e-4,
        "{joint:?}"
    );
    assert!((found.tcp_position.expect("known").largest - 0.005).abs() < 1e-3);
    assert_eq!(found.force.expect("known").largest, 7.0);
    assert!(found.joints[2].expect("known").largest < 1e-9);
}

#[test]
fn what_is_not_known_is_not_compared() {
    let first = swing(1.0, 0.004, 6.0, 0.5);
    let mut second = RunTrace::default();
    for sample in first.samples() {
        let mut other = *sample;
        other.force = Vector3::repeat(f64::NAN);
        other.q[1] = f64::NAN;
        second.push(other);
    }
    let found = of(&first, &second);
    assert_eq!((found.force, found.joints[1]), (None, None));
    // Without all joints there is no motion to align by: beginnings are laid over each other.
    assert_eq!(found.alignment.shift, 0.0);
    assert!(found.joints[0].is_some_and(|joint| joint.largest == 0.0));
}

#[test]
fn runs_that_stand_are_laid_over_each_other_from_their_beginnings() {
    let still = |from: f64| {
        let mut track = RunTrace::default();
        for sample in swing(99.0, 0.01, 5.0, 0.5).samples() {
            let mut sample = *sample;
            sample.time += from;
            track.push(sample);
        }
        track
    };
    let found = of(&still(0.0), &still(70.0));
    assert_eq!(found.alignment.shift, 70.0);
    assert_eq!(found.largest_joint(), Some(0.0));
}

#[test]
fn runs_without_a_moment_in_common_have_no_figures() {
    let (first, second) = (RunTrace::default(), swing(1.0, 0.01, 3.0, 0.1));
    let found = of(&first, &second);
    assert_eq!((found.largest_joint(), found.tcp_position), (None, None));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]
    #[test]
    fn any_delay_is_found(begin in 0.1..6.0_f64, noise in 0.0..0.0004_f64, seed in any::<u64>()) {
        let first = swing(1.0, 0.004, 12.0, 0.4);
        let mut second = RunTrace::default();
        let mut state = seed;
        for sample in swing(begin, 0.004, 12.0 + begin, 0.4).samples() {
            let mut other = *sample;
            for q in &mut other.q {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                *q += noise * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
            }
            second.push(other);
        }
        let found = of(&first, &second);
        prop_assert!((found.alignment.shift - (begin - 1.0)).abs() < 2e-3, "{:?}", found.alignment);
        prop_assert!(found.largest_joint().expect("joints") < 2e-3);
    }

    #[test]
    fn any_numbers_are_compared_without_a_panic(times in proptest::collection::vec(any::<f64>(), 0..40),
        q in any::<f64>()) {
        let mut track = RunTrace::default();
        for time in times {
            track.push(TraceSample {
                time,
                q: [q, time, 0.0, -q, 1.0, 0.0],
                position: Vector3::repeat(q),
                rotation: UnitQuaternion::identity(),
                speed: time,
                force: Vector3::repeat(time),
            });
        }
        let other = swing(0.5, 0.05, 3.0, 0.1);
        let _ = of(&track, &other);
        let _ = of(&other, &track);
        let _ = of(&track, &track);
    }
}
