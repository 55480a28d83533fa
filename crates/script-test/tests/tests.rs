//! Tests run as people run them: files in a folder, results told.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "test helpers fail by panicking"
)]

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use controller::options::{PlantChoice, RecordTarget};
use controller::{ControllerConfig, NullObserver, PreparedController, StartOptions};
use elite_runtime::{LineCountsByText, ProgramText, TaskEnd};
use motion_api::Seconds;
use recorder::Recording;
use script_test::{FileScope, GoldenMode, Status, TestResult, TestRunOptions, discover, run};

fn options() -> TestRunOptions {
    TestRunOptions {
        jobs: NonZeroUsize::new(2).unwrap(),
        seed: 0,
        timeout: Seconds::new(60.0).unwrap(),
        wall_timeout: Duration::from_secs(30),
        goldens: GoldenMode::Compare,
        counts_lines: false,
        record_failed: None,
        files: FileScope::default(),
        stop: Arc::default(),
    }
}

fn ideal() -> ControllerConfig {
    ControllerConfig {
        plant: PlantChoice::Ideal,
        ..ControllerConfig::default()
    }
}

/// Results by name, and the executed lines.
fn run_folder(
    folder: &Path,
    options: &TestRunOptions,
) -> (BTreeMap<String, TestResult>, LineCountsByText) {
    let cases = discover(&[folder.to_owned()]).unwrap();
    let mut results = BTreeMap::new();
    let counts = run(&cases, options, &|_| Ok(ideal().into()), &mut |result| {
        results.insert(result.case.name.clone(), result);
    });
    assert_eq!(results.len(), cases.len());
    (results, counts.unwrap())
}

/// Runs one file of tests.
fn run_text(text: &str) -> BTreeMap<String, TestResult> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("test_it.script"), text).unwrap();
    run_folder(folder.path(), &options()).0
}

#[track_caller]
fn assert_all_passed(results: &BTreeMap<String, TestResult>) {
    for (name, result) in results {
        assert_eq!(result.status, Status::Passed, "{name}: {}", result.report);
    }
    assert!(!results.is_empty());
}

#[test]
fn programs_end_in_all_the_ways_they_can() {
    assert_all_passed(&run_text(
        r#"
MOVE = "movej([0.5, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)"

def test_ended():
    r = test.run("print('a')\nprint('b c')\nsleep(1)")
    assert r.outcome == "ended" and r.error is None and r.line is None
    assert r.prints == ["a", "b c"]
    assert repr(r).startswith("result(outcome='ended', error=None, line=None, time=1."), repr(r)
    assert 1.0 <= r.time < 1.1

def test_failed():
    r = test.run("x = 1\ny = x / 0")
    assert (r.outcome, r.error, r.line) == ("failed", "ZeroDivisionError: division by zero", 2)

def test_stopped():
    test.start(MOVE)
    test.advance(0.2)
    r = test.stop()
    assert r.outcome == "stopped"
    test.start("while True: sync()")
    assert not test.wait(0.5)
    assert test.result() is None
    assert test.stop().outcome == "stopped"
    assert test.result().outcome == "stopped"

def test_protective_stop():
    test.start(MOVE)
    test.advance(0.2)
    test.safety("protective_stop")
    assert test.wait(5)
    r = test.result()
    assert r.outcome == "protective_stop" and "protective stop" in r.error and r.line == 1
    test.safety("normal")
    assert test.run(MOVE).outcome == "ended"

def test_emergency_stop():
    test.start(MOVE)
    test.advance(0.2)
    test.safety("emergency_stop")
    test.wait()
    assert test.result().outcome == "emergency_stop"
    test.safety("normal")
    assert test.get("robot_mode") == 7
    assert test.run(MOVE).outcome == "ended"

def test_timeout():
    r = test.run("sleep(100)", timeout=2)
    assert r.outcome == "timeout" and "2 s" in r.error and r.line == 1
    assert 2.0 <= r.time < 2.2

def test_secondary_programs_alone():
    for n in range(20):
        r = test.run("sec s():\n    set_standard_digital_out(%d, True)\nend" % (n % 8))
        assert r.outcome == "ended" and r.time < 0.1, r
    test.advance(0.1)
    assert test.get("standard_digital_out[7]")

def test_one_at_a_time():
    test.start("sleep(1)")
    test.raises("RuntimeError", lambda: test.start("sleep(1)"))
    test.raises(RuntimeError, lambda: test.run("sleep(1)"))
"#,
    ));
}

#[test]
fn a_program_that_does_not_compile_fails_the_test_that_loads_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("broken.script", "x = 1\nmovej([0, 0, 0, 0, 0, 0]\n");
    write(
        "test_it.script",
        r#"
def test_run():
    test.run("broken.script")

def test_start():
    test.start("broken.script")
    test.advance(0.1)

def test_text():
    test.run("x = 1\ny = = 2")

def test_secondary():
    test.run("sec s():\n    x = (\nend")

def test_said():
    test.raises("SyntaxError", lambda: test.run("broken.script"))
    assert test.result().outcome == "failed" and test.result().line == 2
    assert test.run("print(1)").prints == ["1"]
"#,
    );
    let (results, _) = run_folder(folder.path(), &options());
    for (test, line) in [("test_run", 3), ("test_start", 6)] {
        let result = &results[test];
        assert_eq!(result.status, Status::Failed, "{test}");
        assert_eq!(result.line, line, "{test}");
        let begin = format!(
            "SyntaxError: {}/broken.script does not compile: line 2: ",
            folder.path().display()
        );
        assert!(
            result.message.english().starts_with(&begin),
            "{}",
            result.message
        );
    }
    let message = &results["test_text"].message;
    assert!(
        message
            .english()
            .starts_with("SyntaxError: program does not compile: line 2: "),
        "{message}"
    );
    assert_eq!(results["test_text"].status, Status::Failed);
    let message = &results["test_secondary"].message;
    assert!(
        message
            .english()
            .starts_with("SyntaxError: program does not compile: "),
        "{message}"
    );
    let said = &results["test_said"];
    assert_eq!(said.status, Status::Passed, "{}", said.report);
}

#[test]
fn messages_of_a_program_are_there_while_it_runs_and_afterwards() {
    assert_all_passed(&run_text(
        r#"
def test_messages():
    assert test.messages() == []
    test.start("textmsg('ready ', 1)\nprint('no message')\nsleep(1)\ntextmsg('done')\nsleep(1)")
    assert test.messages() == ["ready 1"]
    textmsg("of the test")
    assert test.until(lambda: "done" in test.messages(), 5)
    test.near(test.get("time"), 1, 0.1)
    assert test.wait(5)
    assert test.messages() == ["ready 1", "done"]
    test.run("textmsg('a\\nb')")
    assert test.messages() == ["a\nb"]

def test_few_are_kept():
    test.run("for n in range(140000):\n    textmsg(n)\n    if n % 1000 == 0:\n        sync()")
    messages = test.messages()
    assert len(messages) == 131073, len(messages)
    assert messages[-1] == "[cut, 8928 messages more]", messages[-1]
"#,
    ));
}

#[test]
fn time_inputs_outputs_and_loads_are_the_tests() {
    assert_all_passed(&run_text(
        r#"
def test_time():
    before = test.get("time")
    test.advance(1.5)
    test.near(test.get("time") - before, 1.5)
    assert not test.until(lambda: False, 0.5)
    test.near(test.get("time") - before, 2.0)
    assert test.until(lambda: test.get("time") - before > 3, 5)
    test.near(test.get("time") - before, 3.0, 0.005)

def test_inputs():
    test.set("standard_digital_in[3]", True)
    assert test.get("standard_digital_in[3]") is True
    test.set("standard_digital_in[3]", False, after=0.5)
    test.set("standard_analog_in[0]", 2.5)
    test.set("input_integer_register[7]", -5)
    test.set("input_float_register[1]", 0.25)
    test.set("input_boolean_register[9]", True)
    r = test.run("""
while get_standard_digital_in(3): sync()
registers = read_input_integer_register(7), read_input_float_register(1), read_input_boolean_register(9)
print(get_standard_analog_in(0), *registers)
write_output_integer_register(2, 11)
set_standard_digital_out(4, True)
""")
    assert r.prints == ["2.5 -5 0.25 True"]
    test.near(r.time, 0.5, 0.02)
    assert test.get("output_integer_register[2]") == 11
    assert test.get("standard_digital_out[4]")
    assert len(test.get("actual_q")) == 6

def test_what_cannot_be_set():
    test.raises("ValueError", lambda: test.set("standard_digital_out[0]", True))
    test.raises("ValueError", lambda: test.set("standard_digital_in[16]", True))
    test.raises("ValueError", lambda: test.set("standard_digital_in[0]", 5))
    test.raises("ValueError", lambda: test.set("standard_analog_in[0]", 99.0))
    test.raises("ValueError", lambda: test.get("nothing"))
    test.raises("ValueError", lambda: test.advance(-1))
    test.raises("ValueError", lambda: test.wrench([1, 2, 3], 1))
    test.raises("ValueError", lambda: test.wrench([0] * 6, 1, frame="flange"))
    test.raises("ValueError", lambda: test.safety("maybe"))
    test.raises("ValueError", lambda: test.peak("height"))
    test.raises("TypeError", lambda: test.until(5))
    test.raises("FileNotFoundError", lambda: test.run("nowhere.script"))

def test_loads():
    test.wrench([0, 0, -10, 0, 0, 0], 0.5, after=0.2)
    test.advance(0.4)
    test.near(abs(get_tcp_force(True)[2]), 10, 0.5)
    test.advance(0.6)
    test.near(get_tcp_force(True)[2], 0, 0.5)
    assert test.peak("tcp_force") > 9.5

def test_conditions_know_what_the_program_does():
    test.never("line == 2 and abs(actual_qd[0]) > 0.01")
    test.never("command == 'movej' and line != 3 and abs(target_qd[0]) > 0.01")
    test.never("program == '' and abs(target_qd[0]) > 0.01")
    test.run("x = 1\nsleep(0.3)\nmovej([0.3, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=2)\n")
    for condition in ("line == 2", "line == 3 and command == 'movej'", "len(program) > 0 and command == ''"):
        test.raises("AssertionError", lambda: test.never(condition))

def test_the_test_moves_the_arm_itself():
    movej([0.3, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=2)
    test.near(get_actual_joint_positions(), [0.3, -1.5, 1.5, -1.5, -1.5, 0], 1e-3)
    assert test.peak("joint_speed[0]") > 0.3
"#,
    ));
}

#[test]
fn what_is_asserted_tells_both_sides() {
    let results = run_text(
        r#"
def helper(x):
    assert x == [1, 2], "lists"

def test_sides():
    helper([1, 3])

def test_near():
    test.near([1.0, [2.0, 3.0]], [1.0, [2.0, 3.5]], 0.1)

def test_raises_nothing():
    test.raises("KeyError", lambda: 5)

def test_raises_another():
    test.raises("KeyError", lambda: [][0])

def test_never():
    test.never("joint_speed_is_no_name > 3")

def test_never_before():
    test.run("movej([0.5, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)")
    test.never("abs(actual_qd[0]) > 0.3")

def test_never_after():
    test.never("abs(actual_qd[0]) > 0.3")
    test.run("movej([0.5, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)")

def test_always():
    test.always("safety_mode == normal")
    test.safety("protective_stop")

def test_prints():
    print("said before")
    raise ValueError("no")

def test_halts():
    test.run("movej([0.5, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)")
    halt()
    assert False
"#,
    );
    for (name, line, said) in [
        (
            "test_sides",
            3,
            "AssertionError: lists (the left side is [1, 3], the right side is [1, 2])",
        ),
        ("test_near", 9, "they differ by 0.5 at [1][1]"),
        (
            "test_raises_nothing",
            12,
            "nothing was raised: the value is 5",
        ),
        (
            "test_raises_another",
            15,
            "this was raised: IndexError: list index out of range",
        ),
        ("test_never", 18, "ValueError: the condition cannot be read"),
        (
            "test_never_before",
            22,
            "AssertionError: never: `abs(actual_qd[0]) > 0.3` held at",
        ),
        ("test_never_after", 25, "; actual_qd was [0.3"),
        ("test_always", 29, "did not hold at 0.00"),
        ("test_prints", 34, "ValueError: no"),
    ] {
        let result = &results[name];
        assert_eq!(result.status, Status::Failed, "{name}");
        assert!(
            result.message.english().contains(said),
            "{name}: {}",
            result.message
        );
        assert_eq!(result.line, line, "{name}: {}", result.report);
        assert!(
            !result.report.english().contains("line 41"),
            "{}",
            result.report
        );
    }
    assert_eq!(results["test_prints"].prints, ["said before"]);
    assert_eq!(results["test_halts"].status, Status::Passed);
}

#[test]
fn a_broken_condition_names_the_line_that_moved_the_arm() {
    let results = run_text(
        r#"
def test_never_by_the_test():
    test.never("actual_q[0] > 0.05")
    movej([0.01, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)
    movej([0.5, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)

def test_never_by_the_program():
    test.never("actual_q[0] > 0.05")
    test.run("sleep(0.1)\nmovej([0.5, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)")

def test_never_beside_a_program():
    test.never("actual_q[0] > 0.05")
    test.start("while True:\n    sync()\nend\n")
    movej([0.5, -1.5, 1.5, -1.5, -1.5, 0], a=2, v=1)
    test.stop()

def test_never_by_nobody():
    test.never("time > 0.1")
    test.advance(0.2)
"#,
    );
    for (name, place) in [
        ("test_never_by_the_test", ", line 5 of the test;"),
        ("test_never_by_the_program", ", line 2 of the program;"),
        ("test_never_beside_a_program", ", line 14 of the test;"),
        ("test_never_by_nobody", ", cycle "),
    ] {
        let message = &results[name].message;
        assert!(message.english().contains(place), "{name}: {message}");
    }
    assert!(
        !results["test_never_by_nobody"]
            .message
            .english()
            .contains("line")
    );
}

#[test]
fn machines_on_the_network_are_played_within_the_test() {
    assert_all_passed(&run_text(
        r#"
def test_sockets():
    server = test.socket_server(4000, ["ONE\n", lambda message: message.strip()[::-1] + "\n", b"\x00\x00\x00\x07"])
    r = test.run("""
print(socket_open("10.0.0.99", 4000))
socket_send_line("first")
print(socket_read_string(suffix="\\n"))
socket_send_line("second")
print(socket_read_string(suffix="\\n"))
socket_send_string("third")
print(socket_read_binary_integer(1))
print(socket_read_string(timeout=1.0) == "")
""")
    assert r.outcome == "ended", r.error
    assert r.prints == ["True", "ONE", "dnoces", "[1, 7]", "True"], r.prints
    assert server.received == ["first\n", "second\n", "third"]
    assert server.port == 4000
    assert 1.0 <= r.time < 1.2

def test_pythons_sockets():
    server = test.socket_server(0, lambda message: b"pong:" + message.encode())
    r = test.run("""
import socket
s = socket.create_connection(("127.0.0.1", %d), 5)
s.sendall(b"ping")
print(s.recv(100))
s.close()
""" % server.port)
    assert r.prints == ["b'pong:ping'"], r.error

def test_rpc():
    calls = []
    def add(a, b):
        calls.append((a, b))
        return a + b
    server = test.rpc_server(9120, {"add": add, "version": "1.2", "fail": lambda: 1 / 0})
    r = test.run("""
camera = rpc_factory("xmlrpc", "10.1.1.1:9120")
print(camera.add(2, 3), camera.version())
for name in ("fail", "missing"):
    try:
        getattr(camera, name)()
    except RuntimeError as e:
        print(e)
""")
    assert r.prints[0] == "5 1.2", r.error
    assert "division by zero" in r.prints[1]
    assert "there is no method missing" in r.prints[2]
    assert calls == [(2, 3)]
    assert server.received == [("add", [2, 3]), ("version", []), ("fail", []), ("missing", [])]

def test_calls_its_own_server():
    server = test.rpc_server(9121, {"double": lambda n: 2 * n, "name": "own"})
    own = rpc_factory("xmlrpc", "127.0.0.1:9121")
    begin = controller_timestamp()
    assert own.double(4) == 8 and own.name() == "own"
    assert controller_timestamp() - begin < 2, controller_timestamp() - begin
    test.raises("RuntimeError", lambda: own.missing())
    def ask(text):
        return to_str(own.double(int(text))) + chr(10)
    test.socket_server(9122, [ask])
    socket_open("127.0.0.1", 9122, "chain")
    socket_send_line("21", 0, "chain")
    assert socket_read_string("chain", "", chr(10), 2) == "42"
    assert server.received[0] == ("double", [4])

def test_answers_while_it_sleeps():
    server = test.rpc_server(9123, {"double": lambda n: 2 * n})
    test.start("""
far = rpc_factory("xmlrpc", "10.1.1.1:9123")
print(far.double(5), get_actual_tcp_pose()[0] > -9)
""")
    begin = controller_timestamp()
    sleep(1)
    assert abs(controller_timestamp() - begin - 1) < 0.01
    assert server.received == [("double", [5])]
    assert test.result().prints[0] == "10 True"

def test_modbus():
    device = test.modbus_device(5502, registers={100: 7}, coils=[False, True])
    r = test.run("""
modbus_add_signal("10.0.0.5", 1, 100, 3, "speed", True, 1, 5502)
modbus_add_signal("10.0.0.5", 1, 1, 0, "ready", True, 1, 5502)
print(modbus_get_signal_status("speed"), modbus_get_signal_status("ready"))
modbus_set_output_register("speed", [9])
sleep(0.5)
""")
    assert r.outcome == "ended", r.error
    assert (16, 100, [9]) in device.received or (6, 100, [9]) in device.received, device.received

def test_modbus_keeps_simulated_time():
    device = test.modbus_device(5502, registers=[3, 4], coils=[True])
    r = test.run("""
modbus_add_signal("10.0.0.5", 1, 0, 2, "fast", False, 1, 5502)
modbus_set_signal_update_frequency("fast", 50)
modbus_add_signal("10.0.0.5", 1, 0, 1, "lamp", False, 1, 5502)
modbus_set_signal_update_frequency("lamp", 0)
print(modbus_get_signal_status("fast"), modbus_get_error("fast"))
modbus_set_output_signal("lamp", False)
sleep(10)
modbus_add_signal("10.0.0.5", 1, 9, 3, "none", False, 1, 5502)
modbus_set_signal_watchdog("none", 2)
try:
    modbus_get_signal_status("none")
except RuntimeError as e:
    print(modbus_get_error("none", 1))
end
modbus_delete_signal("none")
modbus_send_custom_command("10.0.0.5", 1, 6, [0, 1, 0, 77], True, 5502)
modbus_reset_connection("10.0.0.5", True, 5502)
modbus_add_signal("10.0.0.5", 1, 1, 3, "word", False, 1, 5502)
print(modbus_get_signal_status("word"), modbus_get_time_since_signal_invalid("word"))
""")
    assert r.outcome == "ended", r.error
    assert r.prints == ["3 [0, 0]", "[2]", "4 0.0"], r.prints
    reads = [what for what in device.received if what == (4, 0, [1])]
    test.near(len(reads), 12 * 50, 5)
    assert abs(r.time - 12.024) < 1e-6, r.time

def test_modbus_is_the_same_every_time():
    device = test.modbus_device(5502, registers=[3, 4])
    r = test.run("""
modbus_add_signal("10.0.0.5", 1, 0, 2, "a", False, 1, 5502)
for i in range(20):
    modbus_get_signal_status("a")
    modbus_add_signal("10.0.0.5", 1, i % 2, 2, "a", False, 1, 5502)
end
""")
    assert r.outcome == "ended" and abs(r.time - 0.088) < 1e-6, r.time
    assert len(device.received) == 21, device.received

def test_what_cannot_be_played():
    test.raises("ValueError", lambda: test.socket_server(70000))
    test.raises("TypeError", lambda: test.socket_server(1, [5]))
    test.raises("TypeError", lambda: test.rpc_server(1, ["add"]))
    test.raises("ValueError", lambda: test.modbus_device(1, {5: 70000}))
    test.socket_server(77)
    test.raises("ValueError", lambda: test.rpc_server(77))
"#,
    ));
}

#[test]
fn a_test_that_never_ends_is_given_up_and_so_is_its_program() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
def test_waits():
    test.start("while True: sync()")
    test.advance(1000)

def test_computes():
    while True:
        pass

def test_program_computes():
    test.run("x = 0\nwhile True:\n    x += 1")

def test_fine():
    test.advance(1)
"#;
    std::fs::write(folder.path().join("ends_test.script"), text).unwrap();
    let options = TestRunOptions {
        timeout: Seconds::new(5.0).unwrap(),
        wall_timeout: Duration::from_millis(500),
        ..options()
    };
    let (results, _) = run_folder(folder.path(), &options);
    for (name, said) in [
        (
            "test_waits",
            "timeout: the test had not ended after 5.000 s",
        ),
        (
            "test_computes",
            "timeout: no simulated time passed for 0.5 s",
        ),
        (
            "test_program_computes",
            "timeout: no simulated time passed for 0.5 s",
        ),
    ] {
        assert!(
            results[name].message.english().contains(said),
            "{name}: {}",
            results[name].message
        );
    }
    assert_eq!(results["test_fine"].status, Status::Passed);
}

/// A file of tests, a program and what belongs to them.
fn project() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let program = "import random\nfor i in range(3):\n    x = random.uniform(-0.3, 0.3)\
        \n    movej([x, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=2)\nif x > 10:\n    print('never')\n";
    std::fs::create_dir(folder.path().join("programs")).unwrap();
    std::fs::write(folder.path().join("programs/moves.script"), program).unwrap();
    let tests = "def test_moves():\n    assert test.run('programs/moves.script').outcome == 'ended'\
        \n    test.path_near('ways/moves.csv', 0.001)\n\ndef test_fails():\n    test.run('programs/moves.script')\
        \n    assert False\n";
    std::fs::write(folder.path().join("test_moves.script"), tests).unwrap();
    let path = folder.path().to_owned();
    (folder, path)
}

#[test]
fn executed_lines_are_counted_ways_kept_and_failures_recorded() {
    let (_folder, path) = project();
    let recordings = path.join("recordings");
    let options = TestRunOptions {
        goldens: GoldenMode::Update,
        counts_lines: true,
        record_failed: Some(recordings.clone()),
        ..options()
    };
    let (results, counts) = run_folder(&path, &options);
    assert_eq!(results["test_moves"].status, Status::Passed);
    assert!(path.join("ways/moves.csv").is_file());
    let kept: Vec<PathBuf> = std::fs::read_dir(&recordings)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    assert_eq!(kept, [recordings.join("test_moves-test_fails.mcap")]);
    assert_eq!(results["test_fails"].recording.as_ref(), kept.first());
    let cycles = Recording::open(&kept[0]).unwrap().cycles().unwrap().count();
    assert!(cycles > 100, "{cycles}");
    let (name, lines) = counts.iter().next().unwrap();
    assert!(name.ends_with("programs/moves.script"), "{name}");
    let expected = [(1, 2), (2, 2), (3, 6), (4, 6), (5, 2), (6, 0)];
    assert_eq!(lines.clone().into_iter().collect::<Vec<_>>(), expected);
    // On the way that was kept, and with another seed on another one.
    let (results, _) = run_folder(&path, &self::options());
    assert_eq!(
        results["test_moves"].status,
        Status::Passed,
        "{}",
        results["test_moves"].report
    );
}

#[test]
fn the_same_seed_is_the_same_run_whatever_runs_beside_it() {
    let (_folder, path) = project();
    let record = |name: &str, jobs: usize, seed: u64| {
        let folder = path.join(name);
        let options = TestRunOptions {
            jobs: NonZeroUsize::new(jobs).unwrap(),
            seed,
            record_failed: Some(folder.clone()),
            ..options()
        };
        run_folder(&path, &options);
        let recording = Recording::open(folder.join("test_moves-test_fails.mcap")).unwrap();
        let cycles: Vec<_> = recording.cycles().unwrap().map(Result::unwrap).collect();
        cycles
    };
    let (alone, beside) = (record("a", 1, 1), record("b", 4, 2));
    assert_eq!(alone.len(), beside.len());
    let differ = alone
        .iter()
        .zip(&beside)
        .find_map(|(a, b)| recorder::difference(a, b));
    assert!(differ.is_none(), "{differ:?}");
}

#[test]
fn a_program_in_a_test_is_the_run_that_it_is_by_itself() {
    let (_folder, path) = project();
    let alone = path.join("alone.mcap");
    let config = ControllerConfig {
        record: RecordTarget::File(alone.clone()),
        ..ideal()
    };
    let prepared = PreparedController::new(&config, StartOptions::for_single_run()).unwrap();
    let controller = prepared.start(Arc::new(NullObserver)).unwrap();
    let program = ProgramText {
        name: "moves.script".to_owned(),
        text: std::fs::read_to_string(path.join("programs/moves.script")).unwrap(),
    };
    let end = controller.run_to_end(program, "a test", std::future::pending());
    assert_eq!(end.unwrap(), Some(TaskEnd::Finished));
    assert!(controller.shut_down());
    let failed = path.join("failed");
    let options = TestRunOptions {
        record_failed: Some(failed.clone()),
        ..options()
    };
    run_folder(&path, &options);
    let cycles = |path: &Path| -> Vec<_> {
        let recording = Recording::open(path).unwrap();
        recording.cycles().unwrap().map(Result::unwrap).collect()
    };
    let (alone, tested) = (
        cycles(&alone),
        cycles(&failed.join("test_moves-test_fails.mcap")),
    );
    assert!(alone.len() > 100 && tested.len() >= alone.len());
    let differ = alone
        .iter()
        .zip(&tested)
        .find_map(|(a, b)| recorder::difference(a, b));
    assert!(differ.is_none(), "{differ:?}");
}

#[test]
fn what_is_no_test_is_said_before_anything_runs() {
    for (text, said) in [
        ("def test_x(\n", "test_it.script"),
        (
            "def test_x():\n    pass\ndef test_x():\n    pass\n",
            ":3: there are two tests called test_x",
        ),
        ("def test_x(a):\n    pass\n", ":1: test_x takes arguments"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("test_it.script"), text).unwrap();
        let error = discover(&[folder.path().to_owned()])
            .unwrap_err()
            .to_string();
        assert!(error.contains(said), "{text:?}: {error}");
    }
    let error = discover(&["no/such/folder".into()])
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("cannot read no/such/folder"), "{error}");
}
