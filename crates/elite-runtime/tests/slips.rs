//! The usual slips, as people read of them while a program runs.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set itself up should stop"
)]

use crate::common;

use common::{Standing, run};

#[test]
fn errors_of_calls_that_look_like_a_slip_carry_advice() {
    let reports = [
        "get_inverse_kin([400, 0, 300, 3.14, 0, 0])",
        "def pick(place):\n    return get_inverse_kin(place)\npick([0.4, 0, 9.3, 180, 0, 0])",
        "get_inverse_kin([0.4, 0, 9.3, 3.14, 0, 0])",
    ]
    .map(|text| run(&Standing::default(), text).report);
    insta::assert_snapshot!(reports.join("\n"));
}

#[test]
fn a_move_to_the_wrong_kind_of_place_is_warned_of_once() {
    let text = "for i in range(3): movej(get_actual_tcp_pose())\nmovel(get_target_joint_positions())\n\
                movej(get_actual_joint_positions())\n";
    let ran = run(&Standing::default(), text);
    insta::assert_snapshot!(ran.log.join("\n"));
}
