//! Outputs and registers that a program sets between two blended motions change where the arm enters the blend radius,
//! and the arm moves as it does without them.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;

use controller::{ControllerConfig, PreparedController, StartOptions};
use elite_runtime::message::{InterpreterEvent, Message, Observer};
use elite_runtime::panel::VariableValue;
use elite_syntax::TaskNode;
use motion_api::{CycleFrame, ProgramId, ThreadNumber};
use parking_lot::Mutex;

use crate::common::program;

/// Keeps every cycle.
#[derive(Default)]
struct Frames(Mutex<Vec<CycleFrame>>);

impl Observer for Frames {
    fn message(&self, message: &Message) {
        assert!(
            !matches!(message, Message::ScriptError { .. }),
            "{message:?}"
        );
    }
    fn program_started(&self, _: ProgramId, _: &str, _: &str) {}
    fn program_compiled(&self, _: ProgramId, _: &str) {}
    fn line_changed(&self, _: ProgramId, _: ThreadNumber, _: u32, _: Option<&TaskNode>) {}
    fn program_ended(&self, _: ProgramId) {}
    fn variable_changed(&self, _: ProgramId, _: &str, _: &VariableValue) {}
    fn interpreter(&self, _: &InterpreterEvent<'_>) {}
    fn cycle_ended(&self, frame: &CycleFrame) {
        self.0.lock().push(*frame);
    }
    fn release_backpressure(&self) {}
}

/// The cycles of a program.
fn frames(text: &str) -> Vec<CycleFrame> {
    let frames = Arc::new(Frames::default());
    let prepared =
        PreparedController::new(&ControllerConfig::default(), StartOptions::for_single_run())
            .unwrap();
    let controller = prepared.start(frames.clone()).unwrap();
    let end = controller.run_to_end(program(text), "a test", std::future::pending());
    assert!(end.unwrap().is_some());
    assert!(controller.shut_down());
    let kept = frames.0.lock();
    kept.clone()
}

/// A line to a corner 100 mm away in y, statements, and a line on from there.
fn corner(speed: f64, radius: f64, between: &str, after: &str) -> String {
    format!(
        "movej([0, -1.57, 1.57, -1.57, -1.57, 0])
p = get_target_tcp_pose()
movel(pose_add(p, [0, 0.1, 0, 0, 0, 0]), a=1.2, v={speed}, r={radius})
{between}movel(pose_add(p, [{after}, 0, 0, 0]), a=1.2, v={speed})
"
    )
}

/// How far the TCP is from that corner in a cycle.
fn distance(frames: &[CycleFrame], at: &CycleFrame) -> f64 {
    let is_moving = |frame: &&CycleFrame| frame.state.target_qd.max_abs() > 0.0;
    let mut first_motion = frames.iter().skip_while(|frame| !is_moving(frame));
    let start = first_motion.find(|frame| !is_moving(frame)).unwrap();
    let [x, y, z] = start.state.target_tcp_pose.xyz;
    let there = at.state.target_tcp_pose.xyz;
    let offsets = there.iter().zip([x, y + 0.1, z]);
    offsets.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// For how many cycles the arm moves.
fn moving(frames: &[CycleFrame]) -> usize {
    let is_moving = |frame: &&CycleFrame| frame.state.target_qd.max_abs() > 0.0;
    frames.iter().filter(is_moving).count()
}

/// Whether a change is made in a cycle.
type IsChanged = fn(&CycleFrame) -> bool;

/// Statements that change something that was low, or 0, and how to see it.
const CHANGES: [(&str, IsChanged); 6] = [
    ("set_standard_digital_out(2, True)", |frame| {
        frame.state.io().digital_out & 1 << 2 != 0
    }),
    ("set_configurable_digital_out(1, True)", |frame| {
        frame.state.io().digital_out & 1 << 17 != 0
    }),
    ("set_standard_analog_out(1, 0.5)", |frame| {
        frame.state.io().analog_out()[1] == 5.0
    }),
    ("write_output_boolean_register(70, True)", |frame| {
        frame.registers.output.boolean(70)
    }),
    ("write_output_float_register(5, 2.5)", |frame| {
        frame.registers.output.float(5) == 2.5
    }),
    ("write_output_integer_register(47, -3)", |frame| {
        frame.registers.output.integer(47) == -3
    }),
];

#[test]
fn what_a_program_sets_between_two_motions_changes_at_the_radius() {
    for (speed, radius) in [(0.1, 0.02), (0.25, 0.005), (0.5, 0.02)] {
        for after in ["0, 0.2, 0", "0.1, 0.1, 0"] {
            let still = frames(&corner(speed, radius, "", after));
            let all: String = CHANGES
                .map(|(statement, _)| format!("{statement}\n"))
                .concat();
            let frames = frames(&corner(speed, radius, &all, after));
            for (statement, is_so) in CHANGES {
                let changed = frames.iter().find(|frame| is_so(frame)).unwrap();
                let early = distance(&frames, changed) - radius;
                // Registers are shown in the cycle behind the one that wrote them.
                assert!(
                    early <= 1e-9 && early > -2.5 * speed * 0.004,
                    "{statement} at {speed} m/s, {radius} m, {after}: {early} m from the radius"
                );
            }
            assert_eq!(moving(&frames), moving(&still), "{speed} {radius} {after}");
        }
    }
}

#[test]
fn a_program_reads_what_it_has_set_whether_the_arm_is_there_or_not() {
    let reads = "write_output_float_register(0, 2.5)
assert read_output_float_register(0) == 2.5
set_standard_digital_out(3, True)
assert get_standard_digital_out(3)
for i in range(200):
  set_standard_digital_out(4, i % 2 == 0)
  write_output_integer_register(0, i)
end
assert read_output_integer_register(0) == 199 and not get_standard_digital_out(4)
write_output_boolean_register(0, True)
assert read_output_boolean_register(0)
";
    for radius in [0.001, 0.02] {
        let frames = frames(&corner(0.25, radius, reads, "0, 0.2, 0"));
        let last = frames.last().unwrap();
        assert_eq!(last.registers.output.integer(0), 199);
        assert_eq!(last.state.io().digital_out & 0b1_1000, 0b0_1000);
    }
}

#[test]
fn nothing_changes_behind_a_motion_that_the_program_never_ends() {
    let text = "movej([0, -1.57, 1.57, -1.57, -1.57, 0])
def moves():
  movel(pose_add(get_target_tcp_pose(), [0, 0.2, 0, 0, 0, 0]), a=1.2, v=0.1, r=0.01)
  set_standard_digital_out(2, True)
  write_output_float_register(1, 1)
  movej([0, -1.57, 1.57, -1.57, -1.57, 0])
end
h = start_thread(moves, ())
sleep(1)
stop_thread(h)
join_thread(h)
sleep(1)
";
    let frames = frames(text);
    let is_set = |frame: &CycleFrame| {
        frame.state.io().digital_out & 1 << 2 != 0 || frame.registers.output.float(1) != 0.0
    };
    assert!(!frames.iter().any(is_set));
}
