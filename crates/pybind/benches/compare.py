"""Times elitescript beside numpy/scipy, pinocchio (pin) and EAIK, after checking that they agree. See ../bench.py.

Every row is measured in alternation, several rounds; the fastest round counts, because the machine's other work only
ever adds time. Prints a Markdown table, microseconds a pose or configuration.
"""

import sys
import time
from pathlib import Path

import elitescript
import numpy as np
import pinocchio as pin
from eaik.IK_DH import DhRobot
from scipy.spatial.transform import Rotation

ROWS = 10_000
ROUNDS = 7
URDF = Path(__file__).resolve().parents[3] / "robots" / "cs66" / "cs66.urdf"

random = np.random.default_rng(5)
poses_a = np.hstack([random.uniform(-0.8, 0.8, (ROWS, 3)), random.uniform(-3, 3, (ROWS, 3))])
poses_b = np.hstack([random.uniform(-0.8, 0.8, (ROWS, 3)), random.uniform(-3, 3, (ROWS, 3))])
q, qd, qdd = random.uniform(-3, 3, (3, ROWS, 6))
list_a, list_b = poses_a[0].tolist(), poses_b[0].tolist()

robot = elitescript.Robot("cs66")
reached = robot.get_forward_kin(q)
model = pin.buildModelFromUrdf(str(URDF))
data = model.createData()
flange = model.getFrameId("tool0")
quarter = np.pi / 2
eaik = DhRobot(
    np.array([quarter, 0, 0, quarter, -quarter, 0]),
    np.array([0, -0.427, -0.3905, 0, 0, 0]),
    np.array([0.1625, 0, 0, 0.1475, 0.0965, 0.092]),
)


def matrices(poses):
    out = np.tile(np.eye(4), (len(poses), 1, 1))
    out[:, :3, :3] = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
    out[:, :3, 3] = poses[:, :3]
    return out


reached_matrices = list(matrices(reached))


def scipy_trans(a, b):
    rotation_a, rotation_b = Rotation.from_euler("xyz", a[..., 3:]), Rotation.from_euler("xyz", b[..., 3:])
    position = rotation_a.apply(b[..., :3]) + a[..., :3]
    return np.concatenate([position, (rotation_a * rotation_b).as_euler("xyz")], axis=-1)


def numpy_matrix(poses):
    sines, cosines = np.sin(poses[..., 3:]), np.cos(poses[..., 3:])
    sr, sp, sy = np.moveaxis(sines, -1, 0)
    cr, cp, cy = np.moveaxis(cosines, -1, 0)
    m = np.empty(poses.shape[:-1] + (3, 3))
    m[..., 0, 0], m[..., 0, 1], m[..., 0, 2] = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    m[..., 1, 0], m[..., 1, 1], m[..., 1, 2] = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    m[..., 2, 0], m[..., 2, 1], m[..., 2, 2] = -sp, cp * sr, cp * cr
    return m


def numpy_trans(a, b):
    rotation = numpy_matrix(a)
    m = rotation @ numpy_matrix(b)
    out = np.empty(a.shape)
    out[..., :3] = (rotation @ b[..., :3, None])[..., 0] + a[..., :3]
    out[..., 3] = np.arctan2(m[..., 2, 1], m[..., 2, 2])
    out[..., 4] = np.arctan2(-m[..., 2, 0], np.hypot(m[..., 0, 0], m[..., 1, 0]))
    out[..., 5] = np.arctan2(m[..., 1, 0], m[..., 0, 0])
    return out


def pin_trans(a, b):
    def se3(p):
        return pin.SE3(pin.rpy.rpyToMatrix(p[3:]), p[:3])

    product = se3(a) * se3(b)
    return np.hstack([product.translation, pin.rpy.matrixToRpy(product.rotation)])


def pin_forward(q):
    pin.forwardKinematics(model, data, q)
    return pin.updateFramePlacement(model, data, flange)


def pin_jacobian(q):
    return pin.computeFrameJacobian(model, data, q, flange, pin.LOCAL_WORLD_ALIGNED)


def each(f, *columns):
    """A loop in Python, for libraries that take one configuration a call."""

    def run():
        for row in zip(*columns):
            f(*row)

    return run


def check_agreement():
    wanted = elitescript.pose_trans(poses_a, poses_b)
    assert np.abs(numpy_trans(poses_a, poses_b) - wanted).max() < 1e-12
    assert np.abs(scipy_trans(poses_a, poses_b) - wanted).max() < 1e-12
    mass, jacobian, torques = robot.mass_matrix(q), robot.jacobian(q), robot.inverse_dynamics(q, qd, qdd)
    solutions, counts = robot.get_all_inverse_kin(reached)
    missing = 0
    for i in range(500):
        assert np.abs(pin_trans(poses_a[i], poses_b[i]) - wanted[i]).max() < 1e-12
        assert np.abs(pin_forward(q[i]).translation - reached[i, :3]).max() < 1e-12
        assert np.abs(pin.rnea(model, data, q[i], qd[i], qdd[i]) - torques[i]).max() < 1e-8
        upper = np.triu(pin.crba(model, data, q[i]))
        assert np.abs(upper - np.triu(mass[i])).max() < 1e-9
        assert np.abs(pin_jacobian(q[i]) - jacobian[i]).max() < 1e-12
        answer = eaik.IK(reached_matrices[i])
        # Rows marked as least squares do not reach the pose.
        theirs = np.array([row for row, rough in zip(answer.Q, answer.is_LS) if not rough])
        missing += counts[i] != len(theirs)
        ours = solutions[i, : counts[i]]
        apart = np.abs((theirs[:, None] - ours[None] + np.pi) % (2 * np.pi) - np.pi).max(axis=2)
        assert apart.min(axis=1).max() < 1e-5, (i, apart)
    return missing


def fastest(candidates):
    """Seconds of the fastest round of each, measured in turns."""
    best = dict.fromkeys(candidates, float("inf"))
    for _ in range(ROUNDS):
        for name, (run, repeats) in candidates.items():
            start = time.perf_counter()
            for _ in range(repeats):
                run()
            best[name] = min(best[name], (time.perf_counter() - start) / repeats)
    return best


def one(f):
    return (f, 2000, 1)


def batch(f):
    return (f, 3, ROWS)


def loop(f, *columns, rows=2000):
    return (each(f, *(c[:rows] for c in columns)), 1, rows)


TABLE = {
    "`pose_trans`, one call": {
        "elitescript": one(lambda: elitescript.pose_trans(list_a, list_b)),
        "numpy": one(lambda: numpy_trans(poses_a[0], poses_b[0])),
        "scipy": one(lambda: scipy_trans(poses_a[0], poses_b[0])),
        "pin": one(lambda: pin_trans(poses_a[0], poses_b[0])),
    },
    "`pose_trans`, batch": {
        "elitescript": batch(lambda: elitescript.pose_trans(poses_a, poses_b)),
        "numpy": batch(lambda: numpy_trans(poses_a, poses_b)),
        "scipy": batch(lambda: scipy_trans(poses_a, poses_b)),
        "pin": loop(pin_trans, poses_a, poses_b),
    },
    "forward kinematics, one call": {
        "elitescript": one(lambda: robot.get_forward_kin(q[0])),
        "pin": one(lambda: pin_forward(q[0])),
        "eaik": one(lambda: eaik.fwdKin(q[0])),
    },
    "forward kinematics, batch": {
        "elitescript": batch(lambda: robot.get_forward_kin(q)),
        "pin": loop(pin_forward, q),
        "eaik": loop(eaik.fwdKin, q),
    },
    "all inverse solutions, one call": {
        "elitescript": one(lambda: robot.get_all_inverse_kin(reached[0])),
        "eaik": one(lambda: eaik.IK(reached_matrices[0])),
    },
    "all inverse solutions, batch": {
        "elitescript": batch(lambda: robot.get_all_inverse_kin(reached)),
        "eaik": (lambda: eaik.IK_batched(reached_matrices, 1), 1, ROWS),
    },
    "nearest inverse solution, batch": {
        "elitescript": batch(lambda: robot.get_inverse_kin(reached, q)),
    },
    "inverse dynamics, batch": {
        "elitescript": batch(lambda: robot.inverse_dynamics(q, qd, qdd)),
        "pin": loop(lambda *row: pin.rnea(model, data, *row), q, qd, qdd),
    },
    "mass matrix, batch": {
        "elitescript": batch(lambda: robot.mass_matrix(q)),
        "pin": loop(lambda row: pin.crba(model, data, row), q),
    },
    "Jacobian, batch": {
        "elitescript": batch(lambda: robot.jacobian(q)),
        "pin": loop(pin_jacobian, q),
    },
}


def main():
    missing = check_agreement()
    versions = {
        "elitescript": elitescript.__version__,
        "numpy": np.__version__,
        "scipy": sys.modules["scipy"].__version__,
        "pin": pin.__version__,
        "eaik": __import__("importlib.metadata", fromlist=["version"]).version("eaik"),
    }
    print(f"\nµs a row; batches of {ROWS}; pin and eaik's forward kinematics take one row a call.")
    print(f"All agree; eaik lists another number of solutions for {missing} of 500 poses.\n")
    print("| | " + " | ".join(f"{name} {version}" for name, version in versions.items()) + " |")
    print("|---" * (len(versions) + 1) + "|")
    for title, row in TABLE.items():
        best = fastest({name: (run, repeats) for name, (run, repeats, _) in row.items()})
        cells = [f"{best[name] / row[name][2] * 1e6:.3f}" if name in row else "" for name in versions]
        print(f"| {title} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
