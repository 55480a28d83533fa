"""Pictures of cycles with matplotlib, which need not be there for anything else."""

from __future__ import annotations

from typing import Any, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

#: Points of a line; more are thinned out.
POINTS_MAX = 5000


def figure(cycles: NDArray[np.void], joints: Optional[Sequence[int]] = None) -> Any:
    """Joint positions, speeds, torques and the force on the tool over time."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise ImportError("a picture needs matplotlib: pip install matplotlib") from None
    shown = list(range(6)) if joints is None else [int(joint) for joint in joints]
    if not shown or any(not 0 <= joint < 6 for joint in shown):
        raise ValueError(f"joints must be numbers from 0 to 5, got {joints!r}")
    cycles = cycles[:: max(1, len(cycles) // POINTS_MAX)]
    picture = Figure(figsize=(9, 8), layout="constrained")
    axes = picture.subplots(4, 1, sharex=True)
    panels = [("actual_q", "position, rad"), ("actual_qd", "speed, rad/s"), ("actual_torque", "torque, Nm")]
    for axis, (name, label) in zip(axes, panels):
        for joint in shown:
            axis.plot(cycles["time"], cycles[name][:, joint], linewidth=1, label=f"joint {joint + 1}")
        axis.set_ylabel(label)
    for k, name in enumerate(("Fx", "Fy", "Fz")):
        axes[3].plot(cycles["time"], cycles["tcp_force"][:, k], linewidth=1, label=name)
    axes[3].set_ylabel("force on the tool, N")
    axes[3].set_xlabel("time, s")
    axes[0].legend(loc="upper right", ncols=6, fontsize="small")
    axes[3].legend(loc="upper right", ncols=3, fontsize="small")
    return picture
