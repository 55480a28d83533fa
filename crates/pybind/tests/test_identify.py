"""Payload, friction and tool from traces: what a cell hides is found, alike in files, open recordings and rows."""

import json
import subprocess
import sys

import elitescript
import numpy as np
import pytest
from elitescript import identify

CELL = """
[sensor]
force_noise = 0.2
torque_noise = 0.01

[payload]
mass = 1.73
cog = [0.021, -0.034, 0.062]

[arm]
coulomb = [6.0, 7.0, 5.0, 2.0, 1.5, 1.0]
viscous = [8.0, 9.0, 6.0, 2.5, 2.0, 1.2]
"""

TURNS = """
for q in [[0.4, -1.3, 1.2, -1.0, -0.6, 0.9], [-0.3, -1.8, 1.9, -2.2, -2.2, -0.9], [0.3, -1.2, 1.4, -1.2, -1.9, 1.2], \
[-0.2, -1.6, 1.7, -1.9, -1.0, -1.1], [0.1, -1.4, 1.2, -0.9, -1.6, 0.5]]:
    movej(q, a=3, v=1)
    sleep(0.3)
end
"""

POINT = """
set_tcp([0.01, -0.02, 0.13, 0.2, 0.1, -0.4])
movej([0.2, -1.4, 1.6, -1.7, -1.5, 0.3])
point = get_target_tcp_pose()
for turn in [[0.4, 0, 0], [-0.4, 0, 0], [0, 0.4, 0], [0, -0.4, 0.3], [0, 0, 0]]:
    movel(pose_trans(point, [0, 0, 0] + turn), v=0.2)
    sleep(0.5)
end
movel(pose_trans(point, [0.1, 0, 0, 0, 0, 0]), v=0.2)
sleep(0.5)
movel(pose_trans(point, [0.03, 0.1, 0, 0, 0, 0]), v=0.2)
sleep(0.5)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("identify")
    (folder / "hidden.toml").write_text(CELL)
    return folder


@pytest.fixture(scope="module")
def turned(folder):
    """A recording of an arm with a load, and the rows of the same run."""
    path = folder / "turned.mcap"
    with elitescript.Controller(cell=folder / "hidden.toml", record=path) as c:
        c.run(TURNS).check()
        rows = c.trace.copy()
    return path, rows


def test_a_hidden_payload_is_found_in_files_recordings_and_rows(turned):
    path, rows = turned
    found = identify.payload(path)
    assert abs(found.mass - 1.73) < 0.0173 and found.sigma.mass > 0
    np.testing.assert_allclose(found.cog, [0.021, -0.034, 0.062], atol=2e-3)
    assert len(found.sigma.cog) == 3 and found.samples > 1000
    assert identify.payload(elitescript.open_recording(path)) == found
    assert identify.payload([path]) == found
    by_rows = identify.payload(rows, robot=elitescript.Robot("cs66"))
    assert by_rows.mass == pytest.approx(found.mass, rel=1e-9) and by_rows.cog == pytest.approx(found.cog, abs=1e-9)
    by_torques = identify.payload(path, from_torques=True)
    assert abs(by_torques.mass - 1.73) < 0.0173 and by_torques.mass != found.mass


def test_the_answer_is_that_of_the_command(turned):
    path, _ = turned
    command = [sys.executable, "-c", "import sys, elitescript._command as c; sys.exit(c.main())"]
    options = ["identify", "friction", str(path), "--from", "0.5", "--format", "json"]
    said = subprocess.run([*command, *options], capture_output=True, text=True, check=True)
    told, found = json.loads(said.stdout), identify.friction(path, start=0.5)
    assert (told["coulomb"], told["viscous"]) == (found.coulomb, found.viscous)
    assert told["sigma"] == {"coulomb": found.sigma.coulomb, "viscous": found.sigma.viscous}
    assert (told["residual_rms"], told["samples"]) == (found.residual_rms, found.samples)
    np.testing.assert_allclose(found.coulomb, [6, 7, 5, 2, 1.5, 1], rtol=0.2)


def test_a_part_of_the_time_is_the_same_of_files_and_rows(turned):
    path, rows = turned
    by_file = identify.payload(path, start=1.0, end=6.0)
    by_rows = identify.payload(rows, robot=elitescript.Robot(), start=1.0, end=6.0)
    assert by_file.samples == by_rows.samples < identify.payload(path).samples
    with pytest.raises(ValueError, match="no joint positions in this time"):
        identify.payload(rows, robot=elitescript.Robot(), start=1e6)


def test_the_sensor_has_a_bias_of_nothing(turned):
    found = identify.sensor(turned[0])
    assert abs(found.mass - 1.73) < 0.02 and np.abs(found.bias).max() < 0.2
    assert len(found.sigma.bias) == 6 and found.samples >= 3


def test_tools_and_frames_are_found_from_rests():
    with elitescript.Controller(plant="ideal") as c:
        c.run(POINT).check()
        rows = c.trace
    robot = elitescript.Robot()
    found = identify.tool(rows, robot=robot, start=1.5, orientation=True)
    np.testing.assert_allclose(found.tcp, [0.01, -0.02, 0.13, 0.2, 0.1, -0.4], atol=5e-5)
    assert found.residual_max < 1e-5 and found.sigma.orientation is not None
    # The rests: start, first posture, five at the point, two beside it.
    still = np.abs(rows["actual_qd"]).max(axis=1) < 1e-3
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
    rests = [(a + b) // 2 for a, b in zip(edges[::2], edges[1::2]) if b - a > 60]
    times = [float(rows["time"][k]) for k in rests]
    chosen = identify.tool(rows, robot=robot, at=times[-7:-2])
    np.testing.assert_allclose(chosen.tcp, [*found.tcp[:3], 0, 0, 0], atol=5e-5)
    assert chosen.sigma.orientation is None and chosen.samples == 5
    with pytest.raises(ValueError, match="three are needed"):
        identify.frame(rows, robot=robot)
    found_frame = identify.frame(rows, robot=robot, at=times[-3:])
    difference = elitescript.pose_trans(elitescript.pose_inv(rows["actual_tcp_pose"][rests[-3]]), found_frame.frame)
    np.testing.assert_allclose(difference, 0, atol=1e-5)
    with pytest.raises(ValueError, match="does not rest at 1000"):
        identify.frame(rows, robot=robot, at=[1000.0])


def test_what_cannot_be_told_is_said(folder, turned):
    path, rows = turned
    with elitescript.Controller(cell=folder / "hidden.toml") as c:
        c.run("sleep(1)").check()
        still = c.trace
    robot = elitescript.Robot()
    with pytest.raises(ValueError, match="did not turn far enough"):
        identify.friction(still, robot=robot)
    with pytest.raises(ValueError, match="four or more rests at one point"):
        identify.tool(still, robot=robot)
    broken = folder / "broken.mcap"
    broken.write_bytes(b"no recording")
    with pytest.raises(ValueError, match="broken.mcap"):
        identify.payload(broken)
    with pytest.raises(OSError, match="nowhere.mcap"):
        identify.payload(folder / "nowhere.mcap")


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"start": "soon"}, "start must be a number"),
        ({"end": float("nan")}, "end must be a finite number"),
        ({"start": 2, "end": 1}, "start must not be after end"),
        ({"robot": "cs66"}, "robot must be a Robot"),
        ({"robot": elitescript.Robot()}, "robot must be left out with recordings"),
        ({"from_torques": 1}, "from_torques must be True or False"),
    ],
)
def test_a_wrong_argument_is_named(turned, arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        identify.payload(turned[0], **arguments)


def test_a_wrong_trace_is_named(turned):
    _, rows = turned
    with pytest.raises(ValueError, match="robot must be given with the rows"):
        identify.payload(rows)
    with pytest.raises(ValueError, match="lacks time, actual_q"):
        identify.payload(np.zeros(3), robot=elitescript.Robot())
    for trace in (3, [], [3], "", None):
        with pytest.raises(ValueError, match="trace must be"):
            identify.payload(trace)
    for at in ("1", 1, ["1"]):
        with pytest.raises(ValueError, match="at must be"):
            identify.tool(rows, robot=elitescript.Robot(), at=at)
