//! Manual 3.2, 4.8 and 3.1.35 as scripts meet them: omitted arguments, other spellings, errors, safety planes.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot make its robot fails"
)]

use crate::common;

use common::{Standing, run};
use elite_runtime::TaskEnd;
use kinematics::{PlaneMode, SafetyBounds, SafetyPlane};

/// What `print(expression)` prints.
fn printed(standing: &Standing, expression: &str) -> String {
    let ran = run(standing, &format!("print({expression})\n"));
    assert_eq!(ran.end, TaskEnd::Finished, "{expression}: {}", ran.error);
    ran.printed.trim_end().to_owned()
}

#[track_caller]
fn holds(standing: &Standing, condition: &str) {
    assert_eq!(printed(standing, condition), "True", "{condition}");
}

#[test]
fn omitted_arguments_mean_the_arm_as_it_stands() {
    let arm = Standing {
        tcp: [0.01, -0.02, 0.1, 0.1, 0.2, 0.3],
        ..Standing::default()
    };
    let q = format!("{:?}", arm.q);
    let tcp = format!("{:?}", arm.tcp);
    for same in [
        format!("get_forward_kin() == get_forward_kin({q}, {tcp})"),
        "get_forward_kin('', 'active tcp') == get_forward_kin()".into(),
        "get_forward_kin(None, 'active_tcp') == get_forward_kin(q='', tcp='')".into(),
        format!("get_forward_kin({q}, [0,0,0,0,0,0]) != get_forward_kin({q})"),
        format!(
            "get_inverse_kin(get_forward_kin()) == get_inverse_kin(get_forward_kin(), {q}, {tcp})"
        ),
        format!("norm([a - b for a, b in zip(get_inverse_kin(get_forward_kin()), {q})]) < 1e-9"),
        "get_inverse_kin(get_forward_kin(), qNear='') == get_inverse_kin(get_forward_kin(), qnear=None)".into(),
        "get_inverse_kin(p=get_forward_kin(), qNear=[0,0,1,0,1,0]) == get_inverse_kin(get_forward_kin(), \
         [0,0,1,0,1,0])".into(),
        "len(get_all_inverse_kin(get_forward_kin())) == 8".into(),
        "get_all_inverse_kin(get_forward_kin(), tcp='active tcp') == get_all_inverse_kin(get_forward_kin())".into(),
        "get_inverse_kin_has_solution(get_forward_kin())".into(),
    ] {
        holds(&arm, &same);
    }
}

#[test]
fn a_pose_out_of_reach_has_no_solution() {
    let arm = Standing::default();
    assert_eq!(
        printed(&arm, "get_all_inverse_kin([3, 0, 0, 0, 0, 0])"),
        "[]"
    );
    assert_eq!(
        printed(&arm, "get_inverse_kin_has_solution([3, 0, 0, 0, 0, 0])"),
        "False"
    );
    let text =
        "try:\n    get_inverse_kin([3, 0, 0, 0, 0, 0])\nexcept RuntimeError as e:\n    print(e)\n";
    assert_eq!(
        run(&arm, text).printed,
        "get_inverse_kin(): no joint positions of cs66 reach p = [3.0, 0.0, 0.0, 0.0, 0.0, 0.0] with this TCP\n"
    );
}

#[test]
fn results_have_the_types_of_the_manual() {
    let arm = Standing::default();
    for (expression, wanted) in [
        (
            "sqrt(4), pow(2, 3), norm(-10), norm([3, 4])",
            "2.0 8.0 10.0 5.0",
        ),
        ("ceil(-8.8), floor(8.8), floor(-0.5)", "-8 8 -1"),
        ("ceil(1e20)", "100000000000000000000"),
        ("norm(True), norm([])", "1.0 0.0"),
        (
            "length('grüß'), length((1, 2)), get_list_length([])",
            "4 2 0",
        ),
        (
            "bit_list_to_integer([]), bit_list_to_integer([1, 0, True])",
            "0 5",
        ),
        (
            "bit_list_to_integer([True] * 31), bit_list_to_integer([True] * 32)",
            "2147483647 -1",
        ),
        ("bit_list_to_integer([True] * 33)", "-1"),
        ("binary_list_to_integer(integer_to_binary_list(-7))", "-7"),
        (
            "integer_to_bit_list(4294967296 + 1)[:3]",
            "[True, False, False]",
        ),
        ("integer_to_bit_list(2.0)[:3]", "[False, True, False]"),
        (
            "rotvec2rpy([0, 0, 0]), rpy2rotvec((0, 0, 0))",
            "[0.0, 0.0, 0.0] [0.0, 0.0, 0.0]",
        ),
        (
            "wrench_trans(w_from=[1, 2, 3, 0, 0, 0], T_from_to=[0, 0, 0, 0, 0, 0])",
            "[1.0, 2.0, 3.0, 0.0, 0.0, 0.0]",
        ),
        ("log(f=8, b=2)", "3.0"),
    ] {
        assert_eq!(printed(&arm, expression), wanted, "{expression}");
    }
}

#[test]
fn random_numbers_follow_from_the_seed() {
    let arm = Standing::default();
    let text = "random() for _ in range(1000)";
    let numbers = printed(&arm, &format!("[{text}]"));
    assert_eq!(numbers, printed(&arm, &format!("[{text}]")));
    holds(&arm, &format!("all([0 <= x <= 1 for x in [{text}]])"));
    holds(&arm, &format!("0.45 < sum([{text}]) / 1000 < 0.55"));
}

#[test]
fn wrong_arguments_are_named_with_what_is_allowed() {
    let arm = Standing::default();
    for (call, wanted) in [
        (
            "acos(1.5)",
            "ValueError: acos(): f must be a number from -1 to 1, got 1.5",
        ),
        (
            "asin(-2)",
            "ValueError: asin(): f must be a number from -1 to 1, got -2",
        ),
        (
            "log(-2, 3)",
            "ValueError: log(): b must be a number > 0, got -2",
        ),
        (
            "log(2, 0)",
            "ValueError: log(): f must be a number > 0, got 0",
        ),
        (
            "log(1, 3)",
            "ValueError: log(): b must be positive and not 1, got 1",
        ),
        (
            "sqrt(-1e-9)",
            "ValueError: sqrt(): f must be a number >= 0, got -1e-09",
        ),
        (
            "sin('90')",
            "TypeError: sin(): f must be a number, not str ('90')",
        ),
        (
            "cos(float('inf'))",
            "ValueError: cos(): f must be any finite number, got inf",
        ),
        (
            "pow(-8, 0.5)",
            "ValueError: pow(): -8 to the power 0.5 is not a real number: a negative base needs a whole exponent",
        ),
        (
            "pow(0, -1)",
            "ValueError: pow(): 0 to the power -1 is not defined: 0 needs an exponent that is not negative",
        ),
        (
            "pow(10, 400)",
            "OverflowError: pow(): 10 to the power 400 is too large for a float",
        ),
        (
            "normalize([0, 0])",
            "ValueError: normalize(): invalid parameter, v has length zero and so no direction",
        ),
        (
            "normalize(3)",
            "TypeError: normalize(): v must be a list of numbers, not int (3)",
        ),
        (
            "norm('abc')",
            "TypeError: norm(): a must be a number or a list of numbers, not str ('abc')",
        ),
        (
            "norm([1, 'a'])",
            "TypeError: norm(): a[1] must be a number, not str ('a')",
        ),
        (
            "length(5)",
            "TypeError: length(): v must be a list or a string, not int (5)",
        ),
        (
            "get_list_length('abc')",
            "TypeError: get_list_length(): v must be a list, not str ('abc')",
        ),
        (
            "bit_list_to_integer([True, 2])",
            "ValueError: bit_list_to_integer(): l[1] must be True, False, 0 or 1, got 2",
        ),
        (
            "bit_list_to_integer([None])",
            "TypeError: bit_list_to_integer(): l[0] must be True, False, 0 or 1, got None",
        ),
        (
            "integer_to_bit_list(1.5)",
            "TypeError: integer_to_bit_list(): x must be an integer, not float (1.5)",
        ),
        (
            "integer_to_bit_list(10 ** 30)",
            "TypeError: integer_to_bit_list(): x must be an integer of at most 64 bits, \
             not int (1000000000000000000000000000000)",
        ),
        (
            "pose_inv([1, 2, 3])",
            "ValueError: pose_inv(): p_from must be a pose [x, y, z, Rx, Ry, Rz] in m and rad, got 3 numbers",
        ),
        (
            "rotvec2rpy([1, 2, 3, 4])",
            "ValueError: rotvec2rpy(): rotation_vector must be a list of 3 numbers, got 4 numbers",
        ),
        (
            "interpolate_pose([0] * 6, [0, 0, 0, 0, 0, float('nan')], 0)",
            "ValueError: interpolate_pose(): p_to[5] must be a finite number, got nan",
        ),
        (
            "wrench_trans([0] * 6, 'up')",
            "TypeError: wrench_trans(): w_from must be a list of 6 numbers, not str ('up')",
        ),
        (
            "get_inverse_kin([0] * 5)",
            "ValueError: get_inverse_kin(): p must be a pose [x, y, z, Rx, Ry, Rz] in m and rad, got 5 numbers",
        ),
        (
            "is_within_safety_limits()",
            "ValueError: is_within_safety_limits(): either p or q must be given, neither is",
        ),
        (
            "is_within_safety_limits([0] * 6, q=[0] * 6)",
            "ValueError: is_within_safety_limits(): either p or q must be given, both are",
        ),
        (
            "is_within_safety_limits(q=[0] * 6, ciPair=[1, 0])",
            "ValueError: is_within_safety_limits(): ciPair must be a list of 4 entries, each 0 or 1, got 2 entries",
        ),
        (
            "is_within_safety_limits(q=[0] * 6, ciPair=[1, 0, 2, 0])",
            "ValueError: is_within_safety_limits(): ciPair[2] must be True, False, 0 or 1, got 2",
        ),
    ] {
        let ran = run(&arm, &format!("{call}\n"));
        assert_eq!((ran.end, ran.error.as_str()), (TaskEnd::Failed, wanted));
    }
}

/// Allowed is what lies above z = 0.2; the pair of inputs, if any, switches it.
fn ceiling(pair: Option<u8>, mode: PlaneMode) -> SafetyBounds {
    let plane = SafetyPlane::new([0.0, 0.0, 0.2], [0.0, 0.0, 1.0], mode, pair).unwrap();
    SafetyBounds::default().with_plane(plane).unwrap()
}

const LOW: &str = "[0.4, -0.2, 0.1, 3.14159, 0, 0]";
const HIGH: &str = "[0.4, -0.2, 0.3, 3.14159, 0, 0]";

#[test]
fn safety_limits_are_joint_ranges_reach_and_planes() {
    let free = Standing::default();
    for (call, wanted) in [
        (LOW.to_owned(), "True"),
        ("[3, 0, 0, 0, 0, 0]".into(), "False"),
        ("q=[0, 0, 3.1, 0, 0, 0]".into(), "True"),
        ("q=[0, 0, 3.2, 0, 0, 0]".into(), "False"),
        ("p='', q=[0, 0, 0, 0, 0, 7]".into(), "False"),
    ] {
        assert_eq!(
            printed(&free, &format!("is_within_safety_limits({call})")),
            wanted,
            "{call}"
        );
    }
    let above = Standing {
        safety_bounds: ceiling(None, PlaneMode::Normal),
        ..Standing::default()
    };
    holds(&above, &format!("not is_within_safety_limits({LOW})"));
    holds(&above, &format!("is_within_safety_limits({HIGH})"));
    holds(
        &above,
        &format!("not is_within_safety_limits(q=get_inverse_kin({LOW}))"),
    );
    // A plane that no inputs switch is checked whatever ciPair says.
    holds(
        &above,
        &format!("not is_within_safety_limits({LOW}, '', [0, 0, 0, 0])"),
    );
    let reduced = Standing {
        safety_bounds: ceiling(None, PlaneMode::Reduced),
        ..Standing::default()
    };
    holds(&reduced, &format!("is_within_safety_limits({LOW})"));
}

#[test]
fn safety_limits_are_links_that_meet_too() {
    const FOLDED: [f64; 6] = [0.0, -1.6, 3.1, 0.0, 0.0, 0.0];
    let watched = Standing {
        safety_bounds: SafetyBounds::default().with_link_overlap(0.015),
        ..Standing::default()
    };
    holds(
        &watched,
        &format!("not is_within_safety_limits(q={FOLDED:?})"),
    );
    holds(
        &watched,
        &format!("not is_within_safety_limits(get_forward_kin({FOLDED:?}), {FOLDED:?})"),
    );
    holds(
        &watched,
        "is_within_safety_limits(q=[0, -1.5708, 2.3, 0, 0, 0])",
    );
    // An arm that stands in itself may stay there, but not go deeper.
    let inside = Standing {
        q: FOLDED,
        ..watched
    };
    holds(&inside, &format!("is_within_safety_limits(q={FOLDED:?})"));
    holds(
        &inside,
        "not is_within_safety_limits(q=[0, -1.5708, 3.14, 0, 0, 0])",
    );
}

#[test]
fn pairs_of_inputs_switch_planes_as_they_are_or_as_the_script_says() {
    let mut arm = Standing {
        safety_bounds: ceiling(Some(1), PlaneMode::Normal),
        ..Standing::default()
    };
    holds(&arm, &format!("is_within_safety_limits({LOW})"));
    holds(
        &arm,
        &format!("not is_within_safety_limits({LOW}, ciPair=[0, 1, 0, 0])"),
    );
    holds(
        &arm,
        &format!("is_within_safety_limits({LOW}, ciPair=[1, 0, 1, 1])"),
    );
    // One input of the pair is not enough.
    arm.digital_in = 0b0100 << 16;
    holds(&arm, &format!("is_within_safety_limits({LOW})"));
    arm.digital_in = 0b1100 << 16;
    holds(&arm, &format!("not is_within_safety_limits({LOW})"));
    holds(
        &arm,
        &format!("is_within_safety_limits({LOW}, ciPair=[False] * 4)"),
    );
}
