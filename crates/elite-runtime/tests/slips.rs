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

#[test]
fn reports_are_in_the_language_of_the_reader_and_programs_see_english() {
    let caught = "try:\n    movej(1)\nexcept TypeError as error:\n";
    let last = |text: &str| {
        let ran = run(&Standing::default(), text);
        let last = |report: &str| report.lines().last().unwrap().to_owned();
        (ran.printed, last(&ran.report), last(&ran.chinese))
    };
    let english = "movej(): q must be six joint positions in rad, not int (1)";
    let (printed, report, chinese) = last(&format!("{caught}    print(error)\n    raise\n"));
    assert_eq!(printed, format!("{english}\n"));
    assert_eq!(report, format!("TypeError: {english}"));
    assert_eq!(
        chinese,
        "TypeError: movej()：q 必须是六个关节位置（rad），不能是 int（1）"
    );
    // What a program makes of an exception, and Python's own words, are the same for everybody.
    for (text, said) in [
        (
            format!("{caught}    error.args = ('mine',)\n    raise\n"),
            "TypeError: mine",
        ),
        (
            "raise ValueError('q must be six joint positions in rad')".to_owned(),
            "ValueError: q must be six joint positions in rad",
        ),
        ("1 / 0".to_owned(), "ZeroDivisionError: division by zero"),
    ] {
        let (_, report, chinese) = last(&text);
        assert_eq!((report.as_str(), chinese.as_str()), (said, said), "{text}");
    }
    // Advice, and errors within what the error says.
    let text = "get_inverse_kin([0.4, 0, 9.3, 180, 0, 0])";
    let ran = run(&Standing::default(), text);
    assert!(
        ran.chinese
            .contains("  help: get_inverse_kin() 的 'p'的角度为 180：角度以弧度为单位"),
        "{}",
        ran.chinese
    );
}
