"""Which gain of force mode presses best on a surface of a given stiffness? A sweep finds it.

Runs from top to bottom, or cell by cell in an editor that knows `# %%`. Needs elitescript[sweep] and matplotlib:

    python examples/python/force_setting.py [PICTURE.png]
"""

# %% The program: press with 20 N; it ends when the force has been within 1 N for 0.2 s
import sys
from typing import Any, Mapping

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from elitescript import Robot, sweep

WANTED = 20.0
PROGRAM = """
force_mode_set_gain_scaling(gain)
force_mode([0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,-20,0,0,0], 0, [0,0,0.05,0,0,0])
steady = 0
while steady < 50:
    f = get_tcp_force(True)
    off = abs(norm([f[0], f[1], f[2]]) - 20)
    if off < 1:
        steady += 1
    else:
        steady = 0
    end
    sync()
end
end_force_mode()
"""

# %% The cell: a plate of some stiffness, 1 mm below the tool
HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
height = float(np.asarray(Robot("cs66").get_forward_kin(HOME))[2]) - 0.001


def cell(chosen: Mapping[str, Any]) -> dict[str, Any]:
    plate = f"""
[[obstacle]]
name = "plate"
shape = "plane"
pose = [0, 0, {height!r}, 0, 0, 0]
stiffness = {chosen["stiffness"]!r}
damping = 50
"""
    return {"cell": plate, "home": HOME}


# %% Every gain on every stiffness, on every core
stiffnesses = [2e3, 10e3, 50e3, 150e3]
gains = [0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.4, 2.0]
table = sweep(PROGRAM, {"stiffness": stiffnesses, "gain": gains}, options=cell, timeout=10.0)

# %% The best: settled soonest of those that overshoot by less than a tenth
rows = table.to_pylist()
for stiffness in stiffnesses:
    good = [r for r in rows if r["stiffness"] == stiffness and r["outcome"] == "ended"]
    good = [r for r in good if r["peak_tcp_force"] < 1.1 * WANTED]
    if good:
        best = min(good, key=lambda r: r["time"])
        print(
            f"{stiffness / 1e3:5.0f} N/mm: gain {best['gain']}, settled after {best['time']:.2f} s, "
            f"at most {best['peak_tcp_force']:.1f} N"
        )
    else:
        print(f"{stiffness / 1e3:5.0f} N/mm: none of these gains")

# %% The picture: time to settle and largest force over the gain
figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7, 6), layout="constrained")
for stiffness in stiffnesses:
    mine = [r for r in rows if r["stiffness"] == stiffness]
    label = f"{stiffness / 1e3:.0f} N/mm"
    settled = [r["time"] if r["outcome"] == "ended" else np.nan for r in mine]
    top.semilogx(gains, settled, "o-", label=label)
    bottom.semilogx(gains, [r["peak_tcp_force"] for r in mine], "o-", label=label)
top.set_ylabel("settled after, s")
top.legend()
bottom.axhline(1.1 * WANTED, color="gray", linewidth=1, linestyle="--")
bottom.set_ylabel("largest force, N")
bottom.set_xlabel("gain")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "force_setting.png", dpi=110)
