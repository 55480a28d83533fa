"""Reference values of calibrated arms from pinocchio, a rigid-body library of other people:
tests/vectors/calibrated.json.

    python3 -m venv /tmp/pin && /tmp/pin/bin/pip install pin==4.1.0 && /tmp/pin/bin/python tests/vectors/calibrated.py

Forward kinematics, Jacobian, inverse dynamics, and every inverse solution that thousands of random starts lead to. Arms
whose joints 2 and 3 have a d of their own have no dynamics here: where along nearly parallel axes a link's frame lies,
and its mass with it, is a choice.
"""

import json
import tomllib
from pathlib import Path

import numpy as np
import pinocchio as pin

ROOT = Path(__file__).resolve().parents[2]
HALF = np.pi / 2

ARMS = [
    tomllib.loads((ROOT / "robots/calibrations/cs66-controller-2.15.0.477.toml").read_text()),
    tomllib.loads((ROOT / "robots/calibrations/cs66-measured.toml").read_text()),
    {
        "model": "cs612",
        "modified_dh": {
            "a": [0.00031, -0.00042, -0.61573, -0.57038, 0.00027, -0.00019],
            "d": [0.19261, 0.0213, -0.0308, 0.18733, 0.11841, 0.10992],
            "alpha": [0.0007, HALF - 0.0011, 0.0016, -0.0009, HALF + 0.0008, -HALF + 0.0013],
            "theta": [0.01, -0.0021, 0.0034, 0.0008, -0.0027, 0.0019],
        },
    },
    {
        "model": "cs625",
        "modified_dh": {
            "a": [-0.0011, 0.0008, -0.7523, -0.6201, -0.0006, 0.0009],
            "d": [0.2362, 0, 0, 0.1738, 0.1271, 0.1262],
            "alpha": [-0.002, HALF + 0.0031, -0.0024, 0.0017, HALF - 0.0022, -HALF - 0.0028],
            "theta": [0.0, 0.006, -0.004, 0.003, 0.005, -0.002],
        },
    },
]


def figures():
    return json.loads((ROOT / "tests/vectors/cs_figures.json").read_text())["models"]


def build(arm):
    """T_i = Rx(alpha) Tx(a) Rz(q + theta) Tz(d); turning about z and shifting along z may change places."""
    table, model = arm["modified_dh"], pin.Model()
    theta = table.get("theta", [0.0] * 6)
    links = figures()[arm["model"]]["links"]
    names = ["shoulder_link", "upperarm_link", "forearm_link", "wrist_1_link", "wrist_2_link", "wrist_3_link"]
    parent = 0
    for i in range(6):
        twist = pin.SE3(pin.utils.rotate("x", table["alpha"][i]), np.zeros(3))
        along = pin.SE3(np.eye(3), np.array([table["a"][i], 0, 0]))
        turn = pin.SE3(pin.utils.rotate("z", theta[i]), np.array([0, 0, table["d"][i]]))
        parent = model.addJoint(parent, pin.JointModelRZ(), twist * along * turn, f"joint{i + 1}")
        link = links[names[i]]
        t = link["inertia_about_com"]
        inertia = np.array(
            [[t["ixx"], t["ixy"], t["ixz"]], [t["ixy"], t["iyy"], t["iyz"]], [t["ixz"], t["iyz"], t["izz"]]]
        )
        model.appendBodyToJoint(parent, pin.Inertia(link["mass"], np.array(link["com"]), inertia), pin.SE3.Identity())
    return model


def flange(model, data, q):
    pin.forwardKinematics(model, data, q)
    return data.oMi[6].copy()


def solutions(model, data, pose, rng, starts=2500):
    found = []
    for _ in range(starts):
        q = rng.uniform(-np.pi, np.pi, 6)
        for _ in range(60):
            missing = pin.log6(flange(model, data, q).actInv(pose)).vector
            if np.abs(missing).max() < 1e-13:
                break
            jacobian = pin.computeJointJacobian(model, data, q, 6)
            damping = 1e-3 * min(1.0, missing @ missing)
            step = np.linalg.solve(jacobian.T @ jacobian + (damping + 1e-15) * np.eye(6), jacobian.T @ missing)
            q = q + step * min(1.0, 0.5 / np.abs(step).max())
        if np.abs(missing).max() > 1e-11:
            continue
        q = (q + np.pi) % (2 * np.pi) - np.pi
        if all(np.abs((q - other + np.pi) % (2 * np.pi) - np.pi).max() > 1e-6 for other in found):
            found.append(q)
    return sorted(found, key=list)


def main():
    rng = np.random.default_rng(7)
    out = []
    for arm in ARMS:
        model = build(arm)
        data = model.createData()
        has_dynamics = arm["modified_dh"]["d"][1:3] == [0, 0]
        fk, ik = [], []
        for _ in range(12):
            q, qd, qdd = (rng.uniform(-r, r, 6) for r in (2 * np.pi, 1.5, 3.0))
            at = flange(model, data, q)
            case = {"q": q.tolist(), "position": at.translation.tolist(), "rotation": at.rotation.tolist()}
            local = pin.computeJointJacobian(model, data, q, 6)
            turn = np.kron(np.eye(2), at.rotation)
            case["jacobian"] = (turn @ local).tolist()
            if has_dynamics:
                model.gravity.linear = np.array([0, 0, -9.81])
                case |= {"qd": qd.tolist(), "qdd": qdd.tolist(), "tau": pin.rnea(model, data, q, qd, qdd).tolist()}
            fk.append(case)
        for _ in range(10):
            q = rng.uniform(-np.pi, np.pi, 6)
            at = flange(model, data, q)
            found = solutions(model, data, at, rng)
            ik.append(
                {
                    "position": at.translation.tolist(),
                    "rotation": at.rotation.tolist(),
                    "solutions": [s.tolist() for s in found],
                }
            )
        out.append({"calibration": arm, "fk": fk, "ik": ik})
        print(arm["model"], [len(case["solutions"]) for case in ik])
    path = ROOT / "tests/vectors/calibrated.json"
    path.write_text(json.dumps({"source": f"pinocchio {pin.__version__}", "arms": out}, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
