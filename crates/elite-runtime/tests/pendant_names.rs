//! Names that programs of the pendant use beside the manual, and forms of calls that are seen in them.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::common;

use common::{Standing, run};
use elite_runtime::builtins::{all, declare::FROM_OUTPUT, known_names};
use motion_api::{CommandKind, IoChange, MotionCommand, SettingCommand};

/// What a program prints that must not fail; `check` finds no error in it either.
fn printed(text: &str) -> String {
    let file = elite_syntax::SourceFile::new("test.script", text);
    let found = elite_syntax::check(file, &known_names());
    assert!(found.is_empty(), "{found:?}");
    let ran = run(&Standing::default(), text);
    assert_eq!(ran.report, "", "{text}");
    ran.printed
}

fn error(text: &str) -> String {
    run(&Standing::default(), text).error
}

/// The changes of inputs and outputs that a program asks for.
fn changes(text: &str) -> Vec<IoChange> {
    let ran = run(&Standing::default(), text);
    assert_eq!(ran.report, "", "{text}");
    let commands = ran.commands.into_iter();
    let changes = commands.filter_map(|kind| match kind {
        CommandKind::Setting(SettingCommand::SetIo(change))
            if !matches!(change, IoChange::ProgramRunning(_)) =>
        {
            Some(change)
        }
        _ => None,
    });
    changes.collect()
}

#[test]
fn hardness_and_work_mode_are_kept_within_their_ranges() {
    let text = "set_safety_mode_transition_hardness(1)
set_tool_digital_io_work_mode(mode=3)
set_safety_mode_transition_hardness(type = 0)
";
    assert_eq!(
        changes(text),
        [
            IoChange::SafetyHardness(1),
            IoChange::ToolDigitalMode(3),
            IoChange::SafetyHardness(0)
        ]
    );
    for (call, message) in [
        (
            "set_safety_mode_transition_hardness(2)",
            "ValueError: set_safety_mode_transition_hardness(): type must be 0 to 1, got 2",
        ),
        (
            "set_safety_mode_transition_hardness(-1)",
            "ValueError: set_safety_mode_transition_hardness(): type must be 0 to 1, got -1",
        ),
        (
            "set_tool_digital_io_work_mode(4)",
            "ValueError: set_tool_digital_io_work_mode(): mode must be 0 to 3, got 4",
        ),
    ] {
        assert_eq!(error(call), message);
    }
}

#[test]
fn elicopy_is_there_without_import_and_can_be_imported() {
    let text = "def job():
  a = [1, [2, 3], {'k': [4]}]
  b = elicopy.deepcopy(a)
  c = elicopy.copy(a)
  a[1][0] = 9
  a[2]['k'].append(5)
  print(b, c[1] is a[1], c is a)
end
";
    assert_eq!(printed(text), "[1, [2, 3], {'k': [4]}] True False\n");
    assert_eq!(
        printed("import elicopy\nprint(elicopy.deepcopy((1, [2])))\n"),
        "(1, [2])\n"
    );
    assert_eq!(printed("elicopy = 5\nprint(elicopy)\n"), "5\n");
    assert_eq!(
        printed("def f(elicopy):\n  return elicopy\nprint(f(3), elicopy.copy([1]))\n"),
        "3 [1]\n"
    );
}

#[test]
fn a_frame_comes_from_an_origin_and_two_directions() {
    let text = "f = cal_rpy_frame([0.1, 0.2, 0.3], [0, 2, 0], [-1, 5, 0])
print([round(x, 6) for x in f])
print(cal_rpy_frame([0, 0, 0], [1, 0, 0], [0.5, 1, 0]) == [0, 0, 0, 0, 0, 0])
";
    assert_eq!(printed(text), "[0.1, 0.2, 0.3, 0.0, 0.0, 1.570796]\nTrue\n");
    assert_eq!(
        error("cal_rpy_frame([0, 0, 0], [1, 0, 0], [-2, 0, 0])"),
        "ValueError: cal_rpy_frame(): x_direction and y_direction are parallel, so they span no plane"
    );
    assert_eq!(
        error("cal_rpy_frame([0, 0, 0], [0, 0, 0], [1, 0, 0])"),
        "ValueError: cal_rpy_frame(): x_direction has length zero and so no direction"
    );
    let short = error("cal_rpy_frame([0, 0], [1, 0, 0], [0, 1, 0])");
    assert!(
        short.contains("origin must be a list of 3 numbers"),
        "{short}"
    );
}

#[test]
fn time_is_imported_inside_functions() {
    let text = "def since():
  import time
  return time.time()
a = since()
sleep(0.5)
print(round(since() - a, 3))
";
    assert_eq!(printed(text), "0.5\n");
}

#[test]
fn forms_of_calls_that_the_pendant_writes() {
    assert_eq!(
        printed("tool_serial_config(False,115200,0,1,modbus_rtu = False,usage = 0)\n"),
        ""
    );
    assert_eq!(printed("set_payload(0.0,[0,0,0],[0,0,0,0,0,0])\n"), "");
    let arc = "q = [0.1, -1.5, 1.5, -1.5, -1.5, 0]
p = get_forward_kin(q)
via = pose_add(p, [0.01, 0.01, 0, 0, 0, 0])
to = pose_add(p, [0.02, 0, 0, 0, 0, 0])
movec(via, to, 1.2, 0.25, 0, 1)
movej(get_inverse_kin(p, qnear=q), 1.4, 1.05, 0, 0)
";
    let ran = run(&Standing::default(), arc);
    assert_eq!(ran.report, "");
    let is_arc = |kind: &CommandKind| {
        matches!(
            kind,
            CommandKind::Motion(MotionCommand::MoveC { fixed: false, .. })
        )
    };
    assert!(ran.commands.iter().any(is_arc));
    // No output, no error; others outside are errors still.
    assert_eq!(changes("set_standard_digital_out(-1, True)\n"), []);
    let outside = error("set_standard_digital_out(-2, True)\n");
    assert_eq!(
        outside,
        "ValueError: set_standard_digital_out(): n must be -1 to 15, got -2"
    );
    assert!(error("set_standard_digital_out(-1, 'x')\n").starts_with("TypeError: "));
    assert_eq!(
        printed("print(float('-inf') < 0, float('inf') > 1e308)\n"),
        "True True\n"
    );
    let bits = "x = 10\nprint([x >> i & 1 == 1 for i in range(4)])\n";
    assert_eq!(printed(bits), "[False, True, False, True]\n");
}

#[test]
fn threads_start_threads_and_handles_begin_as_zero() {
    let text = "global result
result = []
thread = 0
def add(a, b, c):
  result.append(a + b + c)
def outer():
  inner = start_thread(add, (1, 2, 3))
  join_thread(inner)
  result.append('outer')
if thread == 0:
  thread = start_thread(outer, ())
end
join_thread(thread)
print(result, thread == 0)
";
    assert_eq!(printed(text), "[6, 'outer'] False\n");
}

#[test]
fn what_the_manual_does_not_describe_is_listed_with_its_source() {
    let mut names: Vec<&str> = all()
        .filter(|builtin| builtin.section == FROM_OUTPUT)
        .map(|builtin| builtin.name)
        .collect();
    names.sort_unstable();
    for name in [
        "cal_rpy_frame",
        "elicopy.copy",
        "elicopy.deepcopy",
        "set_safety_mode_transition_hardness",
        "set_tool_digital_io_work_mode",
    ] {
        assert!(names.contains(&name), "{name}: {names:?}");
    }
}
