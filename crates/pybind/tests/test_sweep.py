"""Sweeps: the same table from every executor, in order; dead workers, folders that are taken up again, bad input."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import elitescript
import numpy as np
import pytest
from elitescript import sweep

pyarrow = pytest.importorskip("pyarrow")

PROGRAM = """
import random
if angle > 0.25:
    x = 1 / 0
end
movej([angle, -1.5708, 1.5708, -1.5708, -1.5708, 0], a=3, v=speed)
print(random.random())
"""
GRID = {"angle": [0.1, 0.2, 0.3], "speed": [0.5, 1.0]}
#: A worker that meets this dies, once or always.
DEADLY = """
import os, subprocess
while not os.path.exists(after):
    sleep(0.1)
end
if not os.path.exists(mark) or always:
    open(mark, 'w').close()
    subprocess.call(['sh', '-c', 'kill -9 $PPID'])
end
"""


@pytest.fixture(scope="module")
def table():
    return sweep(PROGRAM, GRID, options={"plant": "ideal"}, seed=5)


def test_a_grid_is_a_table_in_order(table):
    assert table.column_names == ["angle", "speed", *elitescript._sweep.COLUMNS]
    assert table["angle"].to_pylist() == [0.1, 0.1, 0.2, 0.2, 0.3, 0.3]
    assert table["speed"].to_pylist() == [0.5, 1.0] * 3
    assert table["outcome"].to_pylist() == ["ended"] * 4 + ["failed"] * 2
    assert table["error"].to_pylist()[4:] == ["ZeroDivisionError: division by zero"] * 2
    assert table["line"].to_pylist() == [None] * 4 + [4] * 2 and set(table["seed"].to_pylist()) == {5}
    assert table["time"][2].as_py() > table["time"][3].as_py() > 0
    assert 0.2 < table["peak_joint_speed"][0].as_py() <= 0.5 + 1e-9


def test_the_command_of_a_row_repeats_it(table):
    command = table["command"][4].as_py()
    command = command.replace("eliteserver", str(Path(sys.executable).with_name("eliteserver")), 1)
    done = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1 and done.stderr.splitlines()[-1] == "ZeroDivisionError: division by zero"


def test_processes_give_the_same_table(table):
    assert sweep(PROGRAM, GRID, options={"plant": "ideal"}, seed=5, executor="processes", workers=2).equals(table)


@pytest.mark.parametrize("executor, package", [("ray", "ray"), ("dask", "distributed")])
def test_clusters_give_the_same_table_and_the_same_cycles(table, tmp_path, executor, package):
    pytest.importorskip(package)
    call = dict(options={"plant": "ideal"}, seed=5, folder=tmp_path, record="all")
    assert sweep(PROGRAM, GRID, executor=executor, workers=2, **call).drop("command").equals(table.drop("command"))
    with elitescript.Controller(plant="ideal", seed=5) as c:
        c.run(PROGRAM, globals={"angle": 0.2, "speed": 0.5})
        recording = elitescript.open_recording(tmp_path / "recordings" / "000002.mcap")
        np.testing.assert_array_equal(recording["/cycle"], c.trace)


@pytest.mark.parametrize("executor", ["threads", "processes"])
def test_an_interrupted_sweep_ends_at_once_and_keeps_its_rows(tmp_path, executor):
    program = f"""
import elitescript
if __name__ == "__main__":
    samples = [{{"turns": 1}}] + [{{"turns": 10**9}}] * 5
    elitescript.sweep("for i in range(turns):\\n    sleep(0.1)\\nend\\n", samples, executor={executor!r}, workers=2,
        timeout=1e9, folder={str(tmp_path / "kept")!r}, on_row=lambda row: print("row", flush=True))
"""
    (tmp_path / "it.py").write_text(program)
    process = subprocess.Popen([sys.executable, tmp_path / "it.py"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout.readline() == b"row\n"
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert b"KeyboardInterrupt" in err and process.returncode != 0
    assert [path.name for path in (tmp_path / "kept" / "rows").iterdir()] == ["000000.json"]


def test_samples_come_from_an_iterator_and_options_from_the_parameters():
    samples = ({"seed": k, "n": [k, "a b"]} for k in range(20))
    seen = []
    table = sweep(
        "import random\nif n[0] != 3:\n    raise ValueError(random.random())\nend",
        samples,
        options=lambda chosen: {"plant": "ideal", "model": "cs63" if chosen["seed"] % 2 else "cs66"},
        workers=3,
        on_row=seen.append,
        progress=False,
    )
    assert table["seed"].to_pylist() == list(range(20)) and len(seen) == 20
    errors = table["error"].to_pylist()
    assert errors[3] is None and len(set(errors)) == 20
    assert "--model=cs63" in table["command"][1].as_py() and "--seed=1" in table["command"][1].as_py()


@pytest.mark.parametrize("executor, package", [("processes", None), ("dask", "distributed")])
def test_a_killed_worker_is_repeated_once_and_then_said(tmp_path, executor, package):
    if package:
        pytest.importorskip(package)
    # The third dies after the second, so that the second is not taken along before it has died by itself.
    samples = [{"mark": str(tmp_path / str(k)), "always": k == 2, "after": str(tmp_path)} for k in range(4)]
    samples[2]["after"] = samples[1]["mark"]
    for k in (0, 3):
        Path(samples[k]["mark"]).touch()
    options = {"plant": "ideal", "allow": ["fs", "process"]}
    # A minute of the controller's time may pass before the other worker's process has begun.
    table = sweep(DEADLY, samples, options=options, executor=executor, workers=2, timeout=86_400.0)
    assert table["outcome"].to_pylist() == ["ended", "ended", "failed", "ended"], table["error"].to_pylist()
    assert "worker process died twice" in table["error"][2].as_py() and table["time"][2].as_py() is None


@pytest.mark.parametrize("address", ["folder", "memory://sweep-test/a"])
def test_a_folder_keeps_rows_and_recordings_and_is_taken_up_again(tmp_path, address):
    folder = str(tmp_path / address) if "://" not in address else address
    call = dict(options={"plant": "ideal"}, folder=folder, record="failed")
    first = sweep(PROGRAM, {"angle": [0.1, 0.3], "speed": [1.0]}, **call)
    store = elitescript._units.Store(folder)
    kept = json.loads(store._read("rows/000001.json"))
    assert kept["row"]["outcome"] == "failed"
    assert store._read("recordings/000000.mcap") is None and store._read("recordings/000001.mcap")
    # What is there is not run again: a row that was altered shows it.
    kept["row"]["error"] = "altered"
    store._write("rows/000001.json", json.dumps(kept).encode())
    store._write("rows/000000.json", b"{broken")
    again = sweep(PROGRAM, {"angle": [0.1, 0.3], "speed": [1.0]}, **call)
    assert again["error"].to_pylist() == [None, "altered"]
    assert again["time"].equals(first["time"]) and store._read("table.parquet")
    # Another program is another sweep.
    other = sweep(PROGRAM + "# other\n", {"angle": [0.1, 0.3], "speed": [1.0]}, **call)
    assert other["error"][1].as_py() == first["error"][1].as_py()


def test_what_does_not_fit_is_said_before_anything_runs():
    for arguments, words in [
        (dict(parameters=3), "grid"),
        (dict(parameters={"a": 3}), "parameter a of a grid"),
        (dict(parameters=[3]), "sample 0"),
        (dict(parameters=[{"a": 1}, {"b": 1}]), "the first has a"),
        (dict(parameters={"error": [1]}), "cannot be called error"),
        (dict(parameters={"for": [1]}), "no name of a variable"),
        (dict(parameters={"a": [float("nan")]}), "global a"),
        (dict(parameters={"a": [1]}, executor="magic"), "threads"),
        (dict(parameters={"a": [1]}, workers=0), "workers"),
        (dict(parameters={"a": [1]}, record="all"), "folder"),
        (dict(parameters={"a": [1]}, options={"model": "cs99"}), "cs63"),
        (dict(parameters={"a": [1]}, options={"seed": 1}), "seed= of the sweep"),
        (dict(parameters={"a": [1]}, timeout=-1), "timeout"),
    ]:
        with pytest.raises(ValueError, match=words):
            sweep("pass", **arguments)


def test_an_empty_grid_is_an_empty_table():
    assert sweep("pass", {"a": []}).num_rows == 0


def test_values_of_several_types_share_a_column_as_text():
    table = sweep("pass", [{"a": 1}, {"a": "x"}, {"a": [1.0]}], options={"plant": "ideal"})
    assert table["a"].to_pylist() == ["1", '"x"', "[1.0]"] and table["outcome"].to_pylist() == ["ended"] * 3
