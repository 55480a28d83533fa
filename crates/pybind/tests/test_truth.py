"""The arms against reference values of an independent rigid-body library, one by one and as a batch."""

import elitescript
import numpy as np

from conftest import TRUTH, load


def column(cases, key):
    return np.array([case[key] for case in cases])


def both_ways(f, *columns):
    """The batch result, after checking that single rows give exactly the same."""
    batch = f(*columns)
    for i, row in enumerate(zip(*columns)):
        assert np.array_equal(f(*row), batch[i])
        assert np.array_equal(f(*(list(x) for x in row)), batch[i])
    return batch


def assert_torques(found, wanted):
    scale = np.maximum(np.abs(wanted).max(axis=1, keepdims=True), 1e-3)
    assert np.all(np.abs(found - wanted) <= 1e-8 * scale)


def test_forward_kinematics(arm):
    robot, truth = arm
    poses = both_ways(robot.get_forward_kin, column(truth["fk"], "q"))
    assert np.abs(poses[:, :3] - column(truth["fk"], "position")).max() < 1e-9
    assert np.abs(poses[:, 3:] - column(truth["fk"], "rpy")).max() < 1e-9


def test_jacobian(arm):
    robot, truth = arm
    found = both_ways(robot.jacobian, column(truth["jacobian"], "q"))
    assert np.abs(found - column(truth["jacobian"], "J")).max() < 1e-9


def test_dynamics(arm):
    robot, truth = arm
    cases = truth["inverse_dynamics"]
    tau = both_ways(robot.inverse_dynamics, *(column(cases, k) for k in ("q", "qd", "qdd")))
    assert_torques(tau, column(cases, "tau_com"))
    assert_torques(both_ways(robot.gravity, column(truth["gravity"], "q")), column(truth["gravity"], "tau"))
    cases = truth["mass_matrix"]
    found, wanted = both_ways(robot.mass_matrix, column(cases, "q")), column(cases, "M_com")
    assert np.abs(found - wanted).max() < 1e-8 * np.abs(wanted).max()


def test_tilted_base(arm):
    robot, truth = arm
    for case in truth["tilted_gravity"]:
        tilted = elitescript.Robot(robot.name, gravity=case["gravity"])
        assert_torques(tilted.gravity([case["q"]]), np.array([case["tau"]]))


def test_payload(arm):
    robot, truth = arm
    given = TRUTH["meta"]["payload_dynamics"]
    loaded = elitescript.Robot(robot.name, payload=(given["mass"], given["cog"], given["inertia_com"] + [0, 0, 0]))
    cases = truth["payload_dynamics"]
    tau = loaded.inverse_dynamics(*(column(cases, k) for k in ("q", "qd", "qdd")))
    assert_torques(tau, column(cases, "tau"))
    assert_torques(loaded.gravity(column(cases, "q")), column(cases, "tau_gravity"))


def test_all_inverse_solutions(arm):
    robot, truth = arm
    poses = np.hstack([column(truth["ik"], "position"), column(truth["ik"], "rpy")])
    solutions, counts = robot.get_all_inverse_kin(poses)
    assert solutions.shape == (len(poses), 8, 6)
    for pose, rows, count, case in zip(poses, solutions, counts, truth["ik"]):
        wanted = column(case["solutions"], "q")
        assert count == len(wanted)
        turn = np.abs(rows[:count] - wanted)
        assert np.minimum(turn, 2 * np.pi - turn).max() < 1e-7
        assert np.isnan(rows[count:]).all()
        assert np.array_equal(robot.get_all_inverse_kin(pose), rows[:count])


def test_solution_counts(arm):
    robot, truth = arm
    cases = truth["ik_solution_count"]
    poses = np.hstack([column(cases, "position"), column(cases, "rpy")])
    _, counts = robot.get_all_inverse_kin(poses)
    assert counts.tolist() == [case["count"] for case in cases]
    assert robot.get_inverse_kin_has_solution(poses).tolist() == [case["count"] > 0 for case in cases]


def test_inverse_is_nearest_and_inside_the_limits(arm):
    robot, truth = arm
    q = column(truth["fk"], "q")
    low, high = robot.joint_limits.T
    inside = ((q >= low) & (q <= high)).all(axis=1)
    poses = robot.get_forward_kin(q[inside])
    found = both_ways(robot.get_inverse_kin, poses, q[inside])
    assert np.abs(found - q[inside]).max() < 1e-6


def test_tool_at_construction_and_in_the_call_are_the_same(arm):
    robot, truth = arm
    q = column(truth["fk"], "q")
    tcp = [0.01, -0.02, 0.1, 0.3, -0.2, 0.5]
    tooled = elitescript.Robot(robot.name, tcp=tcp)
    poses = tooled.get_forward_kin(q)
    assert np.array_equal(poses, robot.get_forward_kin(q, tcp=tcp))
    assert np.allclose(poses, elitescript.pose_trans(robot.get_forward_kin(q), tcp), atol=1e-12)
    assert np.array_equal(tooled.jacobian(q), robot.jacobian(q, tcp=tcp))
    assert np.array_equal(tooled.get_inverse_kin(poses, q), robot.get_inverse_kin(poses, q, tcp=tcp), equal_nan=True)
    # No tool for this call.
    assert np.array_equal(tooled.get_forward_kin(q, tcp=[0] * 6), robot.get_forward_kin(q))


def test_every_example_of_the_manual():
    """The examples of manual 3.2 and 4.8 as script code, robots' methods and module functions in one namespace."""
    tested = 0
    for example in load("manual_examples.json"):
        if not example["section"].startswith(("3.1.1", "3.1.2", "3.2.", "4.8")) or example["section"] == "3.1.24":
            continue
        names = {k: getattr(elitescript, k) for k in dir(elitescript)}
        if "model" in example:
            robot = elitescript.Robot(example["model"].lower())
            names.update({k: getattr(robot, k) for k in dir(robot) if k.startswith("get_") and "list" not in k})
        tested += 1
        if example["match"] == "error":
            try:
                eval(example["code"], names)
            except ValueError as error:
                assert "invalid parameter" in str(error)
            else:
                raise AssertionError(f"{example['code']} did not raise")
            continue
        found = eval(example["code"], names)
        if example["match"] == "in range":
            low, high = example["expect"]
            assert low <= found <= high
        else:
            wanted = np.array(example["expect"], dtype=float)
            assert np.shape(found) == wanted.shape, example["code"]
            assert np.abs(np.array(found, dtype=float) - wanted).max() <= max(example["tolerance"], 1e-15), example[
                "code"
            ]
    assert tested == 85
