"""A controller in the process: outcomes, stepping, state and trace, I/O, wrenches, threads, forks,
signals, bad input."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import elitescript
import numpy as np
import pytest
from elitescript import Controller, ControllerClosed, ScriptError

MOVE = "movej([0.3, -1.5708, 1.5708, -1.5708, -1.5708, 0], a=3, v=1.5)\n"
FOREVER = "while True:\n    sleep(0.01)\nend\n"


@pytest.fixture
def c():
    with Controller(plant="ideal") as controller:
        yield controller


@pytest.mark.parametrize(
    "program, outcome, error, line, prints",
    [
        ("print('a')\nprint('b')\n", "ended", None, None, ["a", "b"]),
        ("print(1)\nx = 1 / 0\n", "failed", "ZeroDivisionError: division by zero", 2, ["1"]),
        ("if x\n", "failed", "SyntaxError: expected ':'", 1, []),
        ("sleep(1)\n" + FOREVER, "timeout", "TimeoutError: the program had not ended after 2 s", 3, []),
    ],
)
def test_a_program_ends_in_its_words(c, program, outcome, error, line, prints):
    result = c.run(program, timeout=2.0)
    assert (result.outcome, result.line, result.prints) == (outcome, line, prints)
    assert error is None and result.error is None or result.error.startswith(error)
    assert result.ok == (outcome == "ended") and outcome in repr(result)
    if outcome == "failed":
        with pytest.raises(ScriptError, match=error.split(":")[0]):
            result.check()
    # The next one runs.
    assert c.run("pass").ok


def test_programs_come_as_text_and_as_files(c, tmp_path):
    path = tmp_path / "one.script"
    path.write_text("print(n, name)\n")
    for program in (path, str(path)):
        assert c.run(program, globals={"n": np.float64(2.5), "name": "a b"}).prints == ["2.5 a b"]
    assert c.run("print(n)", globals={"n": [1, (2, None), {"k": True}]}).prints == ["[1, (2, None), {'k': True}]"]
    # Presets are of one program.
    assert c.run("print(n)").error.startswith("NameError")
    with pytest.raises(FileNotFoundError):
        c.run("no such.script")
    for wrong in ({"for": 1}, {"x": float("nan")}, {"x": object()}, {"a b": 1}):
        with pytest.raises(ValueError):
            c.run("pass", globals=wrong)


def test_steps_are_cycles_and_the_program_stands_between_them(c):
    c.start("for i in range(3):\n    print(i)\n    sync()\nend\n")
    assert (c.state.cycle, c.prints, c.running, c.result) == (0, ["0"], True, None)
    c.step()
    assert (c.state.cycle, c.prints) == (1, ["0", "1"])
    c.step(10)
    assert c.state.cycle == 11 and not c.running and c.result.ok
    with pytest.raises(RuntimeError, match="running"):
        c.start(FOREVER)
        c.start(FOREVER)
    assert c.stop().outcome == "stopped"
    assert c.wait().outcome == "stopped"


def test_run_until_takes_functions_and_conditions(c):
    c.start(MOVE)
    assert c.run_until(lambda state: state.actual_q[0] > 0.1)
    assert 0.1 < c.state.actual_q[0] < 0.15
    assert c.run_until("actual_q[0] > 0.2 and mode == movej and command == 'movej'")
    before = c.state.time
    assert not c.run_until("actual_q[0] > 9", timeout=0.5)
    assert c.state.time == pytest.approx(before + 0.5)
    assert not c.run_until(lambda state: False, timeout=0.1)
    for wrong in ("actual_z > 1", "time >", 3):
        with pytest.raises(ValueError):
            c.run_until(wrong)


def test_a_callback_that_raises_leaves_the_program_where_it_is(c):
    c.start(MOVE)
    with pytest.raises(KeyError, match="nothing"):
        c.run_until(lambda state: {}["nothing"] if state.cycle >= 5 else False)
    assert c.state.cycle == 5 and c.running
    assert c.wait().ok


def test_state_and_trace_have_the_names_of_a_cycle(tmp_path):
    path = tmp_path / "run.mcap"
    with Controller(record=path, seed=3) as c:
        assert c.run(MOVE).ok
        state, trace = c.state, c.trace
        assert c.recording == str(path)
    assert state.actual_q is not None and state["actual_q"].shape == (6,)
    assert isinstance(state.cycle, int) and isinstance(state.mode, str) and dict(state)["time"] == state.time
    assert trace.dtype.names == tuple(state) and trace["actual_tcp_pose"].shape == (len(trace), 6)
    assert trace["cycle"].tolist() == list(range(1, len(trace) + 1))
    np.testing.assert_array_equal(trace["actual_q"][-1], state.actual_q)
    assert "movej" in set(trace["mode"])
    with pytest.raises(AttributeError, match="actual_qd"):
        state.actual_qq
    with pytest.raises(AttributeError):
        state.time = 1.0
    # The recording is the same table, and knows more.
    recording = elitescript.open_recording(path)
    np.testing.assert_array_equal(recording["/cycle"], trace)
    assert "/script" in recording and set(recording["/command"]["name"]) >= {"movej"}
    with pytest.raises(KeyError, match="/cycle"):
        recording["/nothing"]
    with pytest.raises(OSError):
        elitescript.open_recording(tmp_path / "none.mcap")
    # The binary records the same.
    program = tmp_path / "move.script"
    program.write_text(MOVE)
    other = tmp_path / "other.mcap"
    script = "import sys, elitescript._command as c; sys.argv = ['eliteserver'] + sys.argv[1:]; c.main()"
    command = [sys.executable, "-c", script, "run", program, "--record", other, "--seed", "3"]
    subprocess.run(command, check=True, capture_output=True)
    np.testing.assert_array_equal(elitescript.open_recording(other)["/cycle"], trace)


def test_a_trace_has_a_bound():
    with Controller(plant="ideal", trace=500) as c:
        c.step(2000)
        with pytest.warns(RuntimeWarning, match="lost its first"):
            trace = c.trace
        assert 500 <= len(trace) <= 1024 and trace["cycle"][-1] == 2000


def test_inputs_outputs_and_registers(c):
    c.io["standard_digital_in[3]"] = True
    c.io["input_integer_register[5]"] = -7
    c.io["input_float_register[0]"] = 2
    c.io["standard_analog_in[0]"] = 4.5
    result = c.run(
        "set_standard_digital_out(1, get_standard_digital_in(3))\nsync()\nsync()\n"
        "print(read_input_integer_register(5), read_input_float_register(0), get_standard_analog_in(0))\n"
    )
    assert result.prints == ["-7 2.0 4.5"], result
    assert c.io["standard_digital_out[1]"] is True and c.io["standard_digital_out[2]"] is False
    assert c.io["input_integer_register[5]"] == -7
    for name, value in [
        ("standard_digital_in[16]", True),
        ("digital", True),
        ("standard_digital_in[0]", 3),
        ("standard_analog_in[0]", 11.0),
        ("input_integer_register[0]", 1 << 31),
        ("tool_digital_in[0]", True),
        (3, True),
    ]:
        with pytest.raises(ValueError):
            c.io[name] = value


def test_an_external_wrench_is_felt():
    with Controller() as c:
        c.set_external_wrench([0, 0, -20, 0, 0, 0])
        c.step(50)
        force = c.state.tcp_force[:3]
        assert np.linalg.norm(force) == pytest.approx(20, abs=0.5)
        c.set_external_wrench([5, 0, 0, 0, 0, 0], frame="tool")
        c.step(50)
        np.testing.assert_allclose(c.state.tcp_force[:3], [5, 0, 0], atol=0.3)
        assert c.peaks["tcp_force"] > 19
        for wrong in ([1, 2], [float("nan")] * 6, "x"):
            with pytest.raises(ValueError):
                c.set_external_wrench(wrong)
        with pytest.raises(ValueError, match='"base" or "tool"'):
            c.set_external_wrench([0] * 6, frame="world")


def test_stops_of_the_arm_are_outcomes():
    with Controller(plant="ideal") as c:
        c.start("movej([1, -1.5708, 1.5708, -1.5708, -1.5708, 0])")
        c.step(50)
        c.order("emergency_stop")
        assert c.wait().outcome == "emergency_stop"


@pytest.mark.parametrize(
    "options, words",
    [
        ({"speed": 1}, "there is no option speed; allowed are model"),
        ({"model": "cs99"}, "model: allowed are cs63"),
        ({"step_ms": 9}, "step_ms: allowed are whole milliseconds"),
        ({"step_ms": 2.5}, "step_ms must be a whole number"),
        ({"seed": -1}, "seed: allowed are whole numbers"),
        ({"home": [0, 1]}, r"home must have shape \(6,\)"),
        ({"tcp": [0, 0, 0, 0, 0, float("inf")]}, "tcp must be finite"),
        ({"payload": (-1,)}, "payload mass"),
        ({"payload": 1e4}, "from 0 to 1000 kg"),
        ({"payload": 500}, "rated for"),
        ({"payload": (1, [0, 0, 0.1], [1, 0, 0, 0, 0, 0])}, "no rigid body"),
        ({"plant": "soft"}, "plant: allowed are rigid"),
        ({"cell": "no such.toml"}, "no such.toml"),
        ({"cell": "[nothing]\nx = 1\n"}, "nothing"),
        ({"allow": ["everything"]}, "allow: allowed are fs"),
        ({"trace": -1}, "trace must be"),
        ({"wall_timeout": -1}, "wall_timeout must be"),
    ],
)
def test_what_does_not_fit_is_said(options, words):
    with pytest.raises(ValueError, match=words):
        Controller(**options)


def test_a_script_that_never_waits_is_stopped():
    with Controller(plant="ideal", wall_timeout=0.2) as c:
        result = c.run("x = 0\nwhile True:\n    x += 1\nend\n")
        assert result.outcome == "timeout" and "no simulated time passed" in result.error
        with pytest.raises(TimeoutError, match="computes without waiting"):
            c.start("while True:\n    pass\nend\n")
        assert c.run("print(1)").prints == ["1"]


def test_a_closed_controller_says_so():
    c = Controller(plant="ideal")
    c.start(FOREVER)
    assert c.close() and c.close()
    for call in (lambda: c.run("pass"), lambda: c.state, lambda: c.io["tool_analog_in"], c.step, c.stop):
        with pytest.raises(ControllerClosed):
            call()
    assert "closed" in repr(c)
    with pytest.raises(TypeError, match="pickled"):
        c.__reduce__()


def test_many_in_threads_are_each_the_same_run():
    def run(seed, results):
        with Controller(seed=seed) as c:
            c.run("import random\n" + MOVE + "print(random.random())\n").check()
            results.append((seed, c.prints, c.trace.tobytes()))

    alone, beside = [], []
    run(1, alone)
    threads = [threading.Thread(target=run, args=(k % 2, beside)) for k in range(6)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert sum(result == alone[0] for result in beside) == 3 and len({r[2] for r in beside}) == 1


def test_another_thread_can_stop_a_run_and_read_meanwhile(c):
    results = []
    thread = threading.Thread(target=lambda: results.append(c.run(FOREVER, timeout=1e6)))
    thread.start()
    while not c.running or c.state.cycle < 10:
        time.sleep(0.001)
    with pytest.raises(RuntimeError, match="another call"):
        c.step()
    assert c.stop() is None
    thread.join()
    assert results[0].outcome == "stopped" and c.run("pass").ok


def test_a_forked_child_is_told():
    code = """
    import os, warnings
    warnings.simplefilter("ignore")
    from elitescript import Controller
    c = Controller(plant="ideal")
    c.run("pass")
    child = os.fork()
    if child == 0:
        try:
            c.run("pass")
        except RuntimeError as error:
            with Controller(plant="ideal") as mine:
                fine = mine.run("print(1)").prints == ["1"]
            del c
            os._exit(7 if "forked" in str(error) and fine else 1)
        os._exit(2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7 if hasattr(os, "waitstatus_to_exitcode") else True
    assert c.run("pass").ok
    """
    subprocess.run([sys.executable, "-c", textwrap.dedent(code)], check=True, timeout=60)


def test_a_keyboard_interrupt_stops_the_program_and_the_controller_goes_on(c):
    for call in (
        lambda: c.run(FOREVER, timeout=1e7),
        lambda: c.step(10**12),
        lambda: c.run_until(lambda state: False, timeout=1e7),
        lambda: c.run_until("False", timeout=1e7),
    ):
        timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            call()
        assert not c.running and c.run("print(2)").prints == ["2"]


def test_calibrations_and_cells_as_text():
    cell = '[[obstacle]]\nname = "plate"\nshape = "plane"\npose = [0, 0, 0.2, 0, 0, 0]\nstiffness = 20000\n'
    with Controller(cell=cell) as c:
        assert c.run("print(1)").ok


PARTS = """
[world]
floor = 0.0

[[part]]
name = "box"
shape = "box"
size = [0.1, 0.1, 0.1]
mass = 1.0
pose = [0.6, 0, 0.0501, 0, 0, 0]

[[sink]]
name = "out"
pose = [0.6, 1.0, 0.5, 0, 0, 0]
size = [0.2, 0.2, 0.2]
"""


def test_parts_of_the_cell_are_seen_and_changed():
    with Controller(cell=PARTS) as controller:
        controller.step(10)
        box = controller.parts["box"]
        assert box.pose == pytest.approx([0.6, 0, 0.05, 0, 0, 0], abs=1e-3)
        assert box.held_by is None and box.speed < 0.01
        assert controller.add("box", [0.6, 0, 1, 0, 0, 0]) == "box#1"
        assert controller.run_until("part('box#1').z < 0.9", timeout=1.0)
        controller.place("box#1", [0.6, 1, 0.5, 0, 0, 0])
        controller.step(2)
        assert controller.count("out") == 1 and list(controller.parts) == ["box"]
        controller.remove("box")
        controller.step(1)
        assert not controller.parts
        with pytest.raises(ValueError, match="bax"):
            controller.place("bax", [0, 0, 0, 0, 0, 0])
        with pytest.raises(ValueError, match="pose"):
            controller.place("box", [0, 0, 0])
        with pytest.raises(ValueError, match="what is 'lost'|\"lost\""):
            controller.fault("lost", "box")
    with Controller() as controller:
        assert not controller.parts
        with pytest.raises(RuntimeError, match="no parts"):
            controller.remove("box")
