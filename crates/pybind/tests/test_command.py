"""The console command of the wheel: the same program, exit statuses and signals as the binary."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import elitescript
import numpy as np

COMMAND = Path(sys.executable).with_name("eliteserver")


def call(*arguments, **options):
    return subprocess.run([COMMAND, *arguments], capture_output=True, text=True, timeout=60, **options)


def test_every_subcommand_is_there(tmp_path):
    assert call("--version").stdout.split()[1] == elitescript.__version__
    assert "calibrate" in call("--help").stdout
    assert any(entry["name"] == "movej" for entry in json.loads(call("builtins", "--format", "json").stdout))
    program = tmp_path / "one.script"
    program.write_text("print(n)\n")
    done = call("run", program, "--set", "n=3")
    assert (done.returncode, done.stdout) == (0, "3\n")
    assert call("run", program).returncode == 1
    assert call("run", tmp_path / "none.script").returncode == 2
    assert call("run", program, "--set", "n").returncode == 2
    assert call("check", program, "--format", "json").returncode == 1
    assert call("replay", tmp_path / "none.mcap").returncode == 2


def test_an_interrupt_ends_a_run_as_in_the_binary(tmp_path):
    program, recording = tmp_path / "forever.script", tmp_path / "run.mcap"
    program.write_text("print('on', flush=True)\nwhile True:\n    sleep(0.01)\nend\n")
    process = subprocess.Popen(
        [COMMAND, "run", program, "--clock", "realtime", "--record", recording],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout.readline() == b"on\n"
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 1 and b"Traceback" not in err, err
    assert len(elitescript.open_recording(recording)["/cycle"]) > 0


def test_by_run_by_test_and_in_python_it_is_the_same_run(tmp_path):
    (tmp_path / "it.script").write_text(
        "import random\nmovej([0.3, -1.2, 1.4, -1.5, -1.5, random.random()], a=3, v=1.5)\n"
        "set_standard_digital_out(2, True)\n"
    )
    (tmp_path / "test_it.script").write_text('def test_it():\n    test.run("it.script")\n    assert False\nend\n')
    (tmp_path / "test.toml").write_text('plant = "ideal"\n')
    options = ["--seed", "5", "--plant", "ideal", "--record", "run.mcap"]
    assert call("run", "it.script", *options, cwd=tmp_path).returncode == 0
    assert call("test", ".", "--seed", "5", "--record-failed", "failed", cwd=tmp_path).returncode == 1
    with elitescript.Controller(plant="ideal", seed=5) as c:
        assert c.run(tmp_path / "it.script").ok
        cycles = c.trace
    by_run = elitescript.open_recording(tmp_path / "run.mcap")["/cycle"]
    by_test = elitescript.open_recording(*(tmp_path / "failed").iterdir())["/cycle"]
    np.testing.assert_array_equal(by_run, cycles)
    np.testing.assert_array_equal(by_test[: len(cycles)], cycles)
