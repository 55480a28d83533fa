"""Arms with kinematics of their own: against pinocchio (tests/vectors/calibrated.py), and what is refused."""

import pickle
from pathlib import Path

import elitescript
import numpy as np
import pytest

from conftest import load

TRUTH = load("calibrated.json")["arms"]
ARMS = Path(__file__).resolve().parents[3] / "robots" / "calibrations"


def written(folder, calibration, name="arm.toml"):
    rows = (f"{key} = {values!r}" for key, values in calibration["modified_dh"].items())
    path = folder / name
    path.write_text(f"model = {calibration['model']!r}\n[modified_dh]\n" + "\n".join(rows))
    return path


@pytest.fixture(params=range(len(TRUTH)))
def arm(request, tmp_path):
    truth = TRUTH[request.param]
    return elitescript.Robot(calibration=written(tmp_path, truth["calibration"])), truth


def rotation(rpy):
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def test_forward_kinematics_and_jacobian(arm):
    robot, truth = arm
    assert robot.name == truth["calibration"]["model"]
    for case in truth["fk"]:
        pose = robot.get_forward_kin(case["q"])
        assert np.abs(pose[:3] - case["position"]).max() < 1e-12
        assert np.abs(rotation(pose[3:]) - case["rotation"]).max() < 1e-12
        assert np.abs(robot.jacobian(case["q"]) - case["jacobian"]).max() < 1e-12
        if "tau" in case:
            tau = robot.inverse_dynamics(case["q"], case["qd"], case["qdd"])
            assert np.abs(tau - case["tau"]).max() < 1e-11 * max(1, np.abs(tau).max())


def test_all_inverse_solutions(arm):
    robot, truth = arm
    poses = []
    for case in truth["ik"]:
        pose = robot.get_forward_kin(case["solutions"][0])
        poses.append(pose)
        found = robot.get_all_inverse_kin(pose)
        assert len(found) == len(case["solutions"])
        for wanted in case["solutions"]:
            apart = np.abs((found - wanted + np.pi) % (2 * np.pi) - np.pi).max(axis=1)
            assert apart.min() < 1e-8
    solutions, counts = robot.get_all_inverse_kin(poses)
    assert solutions.shape[2] == 6 and solutions.shape[1] >= counts.max()
    for pose, rows, count in zip(poses, solutions, counts):
        assert np.array_equal(rows[:count], robot.get_all_inverse_kin(pose))
        assert np.isnan(rows[count:]).all()


def test_the_model_is_that_of_the_file():
    path = ARMS / "cs66-measured.toml"
    robot = elitescript.Robot(calibration=path)
    assert (robot.name, robot.calibration) == ("cs66", str(path))
    assert elitescript.Robot("CS66", calibration=path).name == "cs66"
    assert elitescript.Robot().calibration is None
    with pytest.raises(ValueError, match="calibration: .* is for the model cs66, but the model cs63 is asked for"):
        elitescript.Robot("cs63", calibration=path)


def test_mistakes_name_file_table_and_key(tmp_path):
    with pytest.raises(ValueError, match="calibration: cannot read the calibration file"):
        elitescript.Robot(calibration=tmp_path / "none.toml")
    path = tmp_path / "mm.toml"
    path.write_text((ARMS / "cs66-measured.toml").read_text().replace("0.112116", "112.116"))
    with pytest.raises(ValueError, match=r"mm.toml: \[modified_dh\] has d\[5\] = 112.116; .* looks like mm"):
        elitescript.Robot(calibration=path)


def test_a_calibrated_robot_goes_through_pickle():
    robot = elitescript.Robot(calibration=ARMS / "cs66-measured.toml", tcp=[0, 0, 0.1, 0, 0, 0])
    again = pickle.loads(pickle.dumps(robot))
    q = [0.3, -1.2, 1.9, -0.7, 1.5, 0.2]
    assert np.array_equal(again.get_forward_kin(q), robot.get_forward_kin(q))
    assert repr(again) == repr(robot) and "calibration=" in repr(robot)
