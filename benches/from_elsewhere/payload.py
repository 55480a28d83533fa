"""The payload from the torques of a recording: Pinocchio's regressor and numpy's least squares beside
`identify payload --from-torques`.

    run.sh payload

A cell hides a payload and friction; the arm drives what `excite payload` writes. Ends with status 1 where the two
differ by more than 0.2 % of the mass or 0.2 mm of the centre of gravity, or either is off by more than 1 % or 2 mm.
"""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin

URDF = Path(__file__).resolve().parents[2] / "robots" / "cs66" / "cs66.urdf"
MASS, COG = 1.73, [0.021, -0.034, 0.062]
CELL = f"""
[sensor]
force_noise = 0.2
torque_noise = 0.01
[payload]
mass = {MASS}
cog = {COG}
inertia = [0.006, 0.007, 0.004, 0.0, 0.0, 0.0]
[arm]
coulomb = [6.0, 7.0, 5.0, 2.0, 1.5, 1.0]
viscous = [8.0, 9.0, 6.0, 2.5, 2.0, 1.2]
"""
SLIDING_RAD_S = 0.02


def recorded(eliteserver, folder):
    """What `identify` says, and the columns of the recording."""
    (folder / "hidden.toml").write_text(CELL)
    call = lambda *arguments: (
        subprocess.run([eliteserver, *arguments], cwd=folder, check=True, capture_output=True, text=True).stdout
    )
    call("excite", "payload", "-o", "e.script")
    call("run", "e.script", "--cell", "hidden.toml", "--record", "e.mcap")
    found = json.loads(call("identify", "payload", "e.mcap", "--from-torques", "--format", "json"))
    by_forces = json.loads(call("identify", "payload", "e.mcap", "--format", "json"))
    rows = csv.DictReader(call("replay", "e.mcap", "--csv", "/cycle").splitlines())
    names = ("actual_q", "actual_qd", "target_qdd", "actual_torque")
    table = np.array([[[float(row[f"{name}_{k}"]) for k in range(6)] for name in names] for row in rows])
    return found, by_forces, [table[:, k] for k in range(len(names))]


def of_pinocchio(q, qd, qdd, torque):
    """Mass and centre of gravity: the body of ten parameters on the flange, and friction, by numpy's least squares."""
    model = pin.buildModelFromUrdf(str(URDF))
    data = model.createData()
    flange = model.frames[model.getFrameId("flange")]
    # The regressor of the last link is that of anything fixed to it.
    lefts, rights = [], []
    for k in range(len(q)):
        tau = pin.rnea(model, data, q[k], qd[k], qdd[k])
        last = pin.computeJointTorqueRegressor(model, data, q[k], qd[k], qdd[k])[:, -10:]
        slides = np.abs(qd[k]) >= SLIDING_RAD_S
        friction = np.hstack([np.diag(np.sign(qd[k])), np.diag(qd[k])])
        lefts.append(np.hstack([last, friction])[slides])
        rights.append((torque[k] - tau)[slides])
    found, *_ = np.linalg.lstsq(np.vstack(lefts), np.concatenate(rights), rcond=None)
    cog = flange.placement.actInv(found[1:4] / found[0])
    return found[0], cog


def main():
    with tempfile.TemporaryDirectory() as folder:
        found, by_forces, columns = recorded(sys.argv[1], Path(folder))
    mass, cog = of_pinocchio(*columns)
    millimetres = lambda a, b: float(np.linalg.norm(np.subtract(a, b)) * 1e3)
    print(f"hidden                    {MASS:.5f} kg  {COG} m")
    print(f"identify --from-torques   {found['mass']:.5f} kg  {np.round(found['cog'], 6).tolist()} m")
    print(f"identify, forces          {by_forces['mass']:.5f} kg  {np.round(by_forces['cog'], 6).tolist()} m")
    print(f"pinocchio {pin.__version__:15} {mass:.5f} kg  {np.round(cog, 6).tolist()} m")
    apart = (abs(found["mass"] / mass - 1) * 100, millimetres(found["cog"], cog))
    print(f"apart: {apart[0]:.4f} % and {apart[1]:.4f} mm")
    off = [(abs(m / MASS - 1), millimetres(c, COG)) for m, c in ((found["mass"], found["cog"]), (mass, cog))]
    return int(apart[0] > 0.2 or apart[1] > 0.2 or any(m > 0.01 or c > 2 for m, c in off))


if __name__ == "__main__":
    sys.exit(main())
