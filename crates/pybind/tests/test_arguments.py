"""What goes in and out: shapes, types, errors that name the argument."""

import pickle
import subprocess
import sys
import threading
import time

import elitescript
import numpy as np
import pytest

ROBOT = elitescript.Robot("cs66")
Q = [0.3, -1.2, 1.9, -0.7, 1.5, 0.2]
P = ROBOT.get_forward_kin(Q)
OUTSIDE = [9, 0, 0, 0, 0, 0]


@pytest.mark.parametrize(
    "given",
    [
        tuple(Q),
        np.array(Q),
        np.array([Q, Q]).T[:, 0],
        np.array(Q, dtype=">f8"),
        [np.float64(x) for x in Q],
    ],
)
def test_all_kinds_of_vectors_are_the_same(given):
    assert np.array_equal(ROBOT.get_forward_kin(given), P)


def test_whole_numbers_and_other_dtypes_are_numbers():
    wanted = ROBOT.get_forward_kin([0.0, 1.0, 1.0, 0.0, 1.0, 0.0])
    for given in [[0, 1, 1, 0, 1, 0], np.array([0, 1, 1, 0, 1, 0], dtype="int8"), np.array([0, 1, 1, 0, 1, 0], "f4")]:
        found = ROBOT.get_forward_kin(given)
        assert found.dtype == np.float64 and np.array_equal(found, wanted)


@pytest.mark.parametrize("rows", [0, 1, 7, 8, 9, 1000])
def test_batches_of_any_size(rows):
    q = np.tile(Q, (rows, 1))
    assert ROBOT.get_forward_kin(q).shape == (rows, 6)
    assert ROBOT.jacobian(q).shape == (rows, 6, 6)
    assert ROBOT.mass_matrix(q).shape == (rows, 6, 6)
    assert ROBOT.gravity(q).shape == (rows, 6)
    assert ROBOT.get_inverse_kin(np.tile(P, (rows, 1))).shape == (rows, 6)
    solutions, counts = ROBOT.get_all_inverse_kin(np.tile(P, (rows, 1)))
    assert solutions.shape == (rows, 8, 6) and counts.shape == (rows,) and counts.dtype == np.int64
    assert ROBOT.get_inverse_kin_has_solution(np.tile(P, (rows, 1))).dtype == np.bool_
    assert elitescript.pose_dist(np.tile(P, (rows, 1)), P).shape == (rows,)
    # Rows of other layouts than C's.
    assert np.array_equal(ROBOT.get_forward_kin(np.asfortranarray(q)), ROBOT.get_forward_kin(q))


def test_one_row_goes_with_a_batch():
    batch = np.array([P, P, P])
    assert np.array_equal(elitescript.pose_trans(P, batch)[1], elitescript.pose_trans(P, P))
    assert np.array_equal(elitescript.pose_trans(batch, P)[2], elitescript.pose_trans(P, P))
    between = elitescript.interpolate_pose(P, [0, 0, 0, 0, 0, 0], [0, 0.5, 1])
    assert between.shape == (3, 6)
    assert np.allclose(between[0], P) and np.allclose(between[2], 0)
    assert ROBOT.inverse_dynamics(Q, [0] * 6, np.zeros((4, 6))).shape == (4, 6)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: ROBOT.get_forward_kin([1, 2, 3]), ["q", "(6,) or (N, 6)", "shape (3,)"]),
        (lambda: ROBOT.get_forward_kin(5.0), ["q", "a single number"]),
        (lambda: ROBOT.get_forward_kin(np.zeros((2, 5))), ["q", "shape (2, 5)"]),
        (lambda: ROBOT.get_forward_kin(np.zeros((2, 2, 6))), ["q", "shape (2, 2, 6)"]),
        (lambda: ROBOT.get_forward_kin([]), ["q", "shape (0,)"]),
        (lambda: ROBOT.get_forward_kin([[1, 2], [3]]), ["q", "must be numbers"]),
        (lambda: ROBOT.get_forward_kin(["1", "2", "3", "4", "5", "6"]), ["q", "must be numbers", "'1'"]),
        (lambda: ROBOT.get_forward_kin("home"), ["q", "must be numbers", "'home'"]),
        (lambda: ROBOT.get_forward_kin(None), ["q", "must be numbers", "None"]),
        (lambda: ROBOT.get_forward_kin([1j] * 6), ["q", "must be numbers", "complex"]),
        (lambda: ROBOT.get_forward_kin([0, 0, 0, float("nan"), 0, 0]), ["q", "nan at index 3"]),
        (lambda: ROBOT.get_forward_kin([[0] * 6, [0, float("-inf"), 0, 0, 0, 0]]), ["q", "-inf at row 1, column 1"]),
        (lambda: ROBOT.get_inverse_kin(P, [0]), ["qnear", "shape (1,)"]),
        (lambda: ROBOT.get_inverse_kin(P, tcp=[0]), ["tcp", "shape (1,)"]),
        (lambda: ROBOT.inverse_dynamics(np.zeros((2, 6)), Q, np.zeros((3, 6))), ["q has 2 rows", "qdd has 3"]),
        (lambda: elitescript.pose_trans(P, [1, 2]), ["p_from_to", "shape (2,)"]),
        (lambda: elitescript.pose_sub([1, 2], P), ["p_to"]),
        (lambda: elitescript.rotvec2rpy(P), ["rotation_vector", "(3,)"]),
        (lambda: elitescript.interpolate_pose(P, P, [[1]]), ["alpha"]),
        (lambda: elitescript.interpolate_pose(P, P, float("nan")), ["alpha", "nan"]),
        (lambda: elitescript.normalize([0, 0]), ["invalid parameter"]),
        (lambda: elitescript.normalize(3), ["v must have shape"]),
        (lambda: elitescript.log(-2, 3), ["b", "-2"]),
        (lambda: elitescript.log([1, 2], 3), ["b must be one number"]),
        (lambda: elitescript.Robot("cs67"), ["model", "`cs67`", "cs66"]),
        (lambda: elitescript.Robot("cs618"), ["model", "not public"]),
        (lambda: elitescript.Robot("/no/arm.urdf"), ["model", "/no/arm.urdf"]),
        (lambda: elitescript.Robot(tcp=np.zeros((2, 6))), ["tcp", "(6,)", "(2, 6)"]),
        (lambda: elitescript.Robot(payload=3), ["payload", "(mass, cog)", "3"]),
        (lambda: elitescript.Robot(payload=(1, [0, 0])), ["payload cog", "(3,)"]),
        (lambda: elitescript.Robot(payload=(-1, [0, 0, 0])), ["payload", "-1"]),
        (lambda: elitescript.Robot(payload=(1, [0, 0, 0], [1, 0, 0, 0, 0, 0])), ["inertia", "rigid body"]),
        (lambda: elitescript.Robot(gravity=[0, 0]), ["gravity", "(3,)"]),
        (lambda: ROBOT.is_within_safety_limits(), ["p or q"]),
        (lambda: ROBOT.is_within_safety_limits(P, q=Q), ["both"]),
        (lambda: ROBOT.is_within_safety_limits(q=Q, qnear=Q), ["qnear"]),
        (lambda: ROBOT.is_within_safety_limits(q=Q, planes=[0, 0, 1]), ["planes", "(6,)"]),
        (lambda: ROBOT.is_within_safety_limits(q=Q, planes=[[0] * 5 + [1], [0] * 6]), ["planes, row 1", "normal"]),
        (lambda: ROBOT.is_within_safety_limits(q=Q, planes=[[0] * 5 + [1]] * 9), ["planes, row 8", "8 safety planes"]),
    ],
)
def test_errors_name_the_argument_and_what_was_given(call, words):
    with pytest.raises(ValueError) as error:
        call()
    for word in words:
        assert word in str(error.value), str(error.value)


def test_no_solution():
    with pytest.raises(elitescript.NoSolutionError, match="cs66.*9, 0, 0"):
        ROBOT.get_inverse_kin(OUTSIDE)
    assert not issubclass(elitescript.NoSolutionError, ValueError)
    found = ROBOT.get_inverse_kin([OUTSIDE, P])
    assert np.isnan(found[0]).all() and np.isfinite(found[1]).all()
    assert ROBOT.get_all_inverse_kin(OUTSIDE).shape == (0, 6)
    assert ROBOT.get_inverse_kin_has_solution(OUTSIDE) is False
    assert ROBOT.get_inverse_kin_has_solution(P) is True


def test_default_near_position_is_home():
    home = [0, -1.5708, 1.5708, -1.5708, -1.5708, 0]
    assert np.array_equal(ROBOT.get_inverse_kin(P), ROBOT.get_inverse_kin(P, home))


def test_safety_limits():
    assert ROBOT.is_within_safety_limits(P) is True
    assert ROBOT.is_within_safety_limits(OUTSIDE) is False
    assert ROBOT.is_within_safety_limits(q=Q) is True
    beyond = np.array([Q, Q])
    beyond[1, 2] = 3.2
    assert ROBOT.is_within_safety_limits(q=beyond).tolist() == [True, False]


def test_safety_planes_hold_back_the_tcp():
    x, y, z = P[:3]
    below, above = [x, y, z - 0.01, 0, 0, 2], [x, y, z + 0.01, 0, 0, 0.5]
    for given in [{"p": P}, {"q": Q}]:
        assert ROBOT.is_within_safety_limits(**given, planes=below) is True
        assert ROBOT.is_within_safety_limits(**given, planes=[below, above]) is False
        assert ROBOT.is_within_safety_limits(**given, planes=np.zeros((0, 6))) is True
    # The tool of the call is what must stay above.
    tcps = [
        [0, 0, 0, 0, 0, 0],
        [0.02, 0, 0, 0, 0, 0],
        [-0.02, 0, 0, 0, 0, 0],
        [0, 0.02, 0, 0, 0, 0],
        [0, -0.02, 0, 0, 0, 0],
    ]
    heights = ROBOT.get_forward_kin(Q, tcp=tcps)[:, 2]
    allowed = ROBOT.is_within_safety_limits(q=Q, tcp=tcps, planes=below)
    assert allowed.tolist() == (heights >= z - 0.01).tolist() and len(set(allowed.tolist())) == 2


def test_folded_arms_are_nearer_to_themselves():
    free, folded = [0, -1.5, 1.0, -1.0, -1.5, 0], [0, -0.5, 3.0, -1.0, -1.5, 0]
    both = ROBOT.self_collision_distance([free, folded])
    assert both[0] > 0.04 > 0 > both[1]
    assert ROBOT.self_collision_distance(free) == both[0]


def test_properties():
    robot = elitescript.Robot("CS612", tcp=[0, 0, 0.1, 0, 0, 1], payload=(2, (0, 0, 0.05)), gravity=(0, 0, 9.81))
    assert (robot.name, robot.robot_type, robot.rated_payload) == ("cs612", 6212, 12.0)
    assert robot.joint_limits.shape == (6, 2)
    assert np.allclose(robot.joint_limits[2], [-np.pi, np.pi]) and np.allclose(
        robot.joint_limits[0], [-2 * np.pi, 2 * np.pi]
    )
    assert np.allclose(np.degrees(robot.speed_limits), [120, 120, 180, 180, 180, 180])
    assert robot.torque_limits.tolist() == [330, 330, 150, 56, 56, 56]
    assert robot.joint_names[2] == "elbow_joint"
    assert robot.tcp.tolist() == [0, 0, 0.1, 0, 0, 1]
    assert robot.payload == (2.0, [0, 0, 0.05], [0] * 6)
    # Hanging from the ceiling, the same torques with the other sign.
    standing = elitescript.Robot("cs612", payload=(2, (0, 0, 0.05)))
    assert np.allclose(robot.gravity(Q), -standing.gravity(Q))
    with pytest.raises(AttributeError):
        robot.tcp = [0] * 6


def test_robots_survive_pickling_and_repr():
    robot = elitescript.Robot("cs63", tcp=[0, 0, 0.1, 0, 0, 1], payload=(1.5, (0, 0, 0.05)), gravity=(0, 1, -9))
    for again in [pickle.loads(pickle.dumps(robot)), eval(repr(robot), {"Robot": elitescript.Robot})]:
        assert repr(again) == repr(robot)
        assert np.array_equal(again.gravity(Q), robot.gravity(Q))


def test_numbers_of_any_shape():
    assert elitescript.d2r(180) == np.pi and isinstance(elitescript.d2r(180), float)
    assert np.array_equal(elitescript.r2d([[np.pi, 0]]), [[180, 0]])
    assert elitescript.norm(-3) == 3 and elitescript.norm([3, 4]) == 5
    assert elitescript.norm([[3, 4], [0, 0]]).tolist() == [5, 0]
    assert elitescript.normalize([[0, 2], [3, 4]]).tolist() == [[0, 1], [0.6, 0.8]]


def test_a_batch_lets_other_threads_run():
    poses = np.tile(P, (200_000, 1))
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.perf_counter()
    ROBOT.get_all_inverse_kin(poses)
    end = time.perf_counter()
    done.set()
    thread.join()
    during = sum(start + 0.2 * (end - start) < t < start + 0.6 * (end - start) for t in ticks)
    assert during >= 3, f"{during} ticks in {end - start:.3f} s"


def test_the_module_runs():
    text = subprocess.run([sys.executable, "-m", "elitescript"], check=True, capture_output=True, text=True).stdout
    assert elitescript.__version__ in text and "cs625" in text
    assert 'Robot("cs66").get_forward_kin' in text


def test_everything_public_says_what_it_takes():
    for name in elitescript.__all__:
        if not name.startswith("__"):
            assert getattr(elitescript, name).__doc__, name
    for name in dir(elitescript.Robot):
        if not name.startswith("__"):
            assert getattr(elitescript.Robot, name).__doc__, name


def test_type_checkers_refuse_options_that_there_are_not(tmp_path):
    mypy = pytest.importorskip("mypy.api")
    script = tmp_path / "controllers.py"
    script.write_text(
        'import elitescript\nelitescript.Controller(model="cs66")\nelitescript.Controller(modell="cs66")\n'
    )
    found, _, status = mypy.run([str(script), "--cache-dir", str(tmp_path / "cache")])
    assert status == 1, found
    assert "controllers.py:3" in found and "modell" in found and found.count("error:") == 1, found
