"""Elite Robots CS arms: their mathematics, whole controllers in this process, recordings, sweeps.

``Controller`` runs programs on a simulated arm, ``sweep`` runs one with many parameters, ``open_recording`` reads what
was recorded, ``identify`` finds payload, friction and tool in it; ``elitescript.gym`` has environments for learning.
``Robot`` is the arm's kinematics and dynamics, the functions are those of EliteScript.

Poses are ``[x, y, z, Rx, Ry, Rz]`` in metres and radians with R = Rz(Rz) Ry(Ry) Rx(Rx), joint positions six radians,
base first. Every such argument is one row, ``(6,)``, or a batch, ``(N, 6)``; a single row goes with any batch. Lists,
tuples and numpy arrays are taken, numpy arrays of float64 are given back. A batch runs without the interpreter lock.
A bad shape or a number that is not finite raises ``ValueError`` that names the argument.

>>> import elitescript
>>> robot = elitescript.Robot("cs66")
>>> robot.get_forward_kin([0, 0, 0, 0, 0, 0]).round(4)
array([-0.8175, -0.2395,  0.066 ,  1.5708,  0.    ,  0.    ])
"""

from . import identify
from ._controller import Controller, Io, Part, Result, State
from ._elitescript import (
    ControllerClosed,
    NoSolutionError,
    PlanningError,
    Robot,
    ScriptError,
    __version__,
    bit_list_to_integer,
    d2r,
    integer_to_bit_list,
    interpolate_pose,
    models,
    norm,
    normalize,
    point_dist,
    pose_add,
    pose_dist,
    pose_inv,
    pose_sub,
    pose_trans,
    r2d,
    rotvec2rpy,
    rpy2rotvec,
    wrench_trans,
)
from ._paths import ClearanceTable, MotionClearance, PlannedPath, clearance, plan
from ._recording import Recording, open_recording
from ._sweep import sweep

# isort: split
# The manual's plain number functions (3.2.7 to 3.2.34). They are here so that script code finds them, and not in
# __all__, because several would hide Python's own.
from ._elitescript import log as log
from ._numbers import (
    acos as acos,
    asin as asin,
    atan as atan,
    atan2 as atan2,
    ceil as ceil,
    cos as cos,
    floor as floor,
    get_list_length as get_list_length,
    length as length,
    pow as pow,
    random as random,
    sin as sin,
    sqrt as sqrt,
    tan as tan,
)

__all__ = [
    "ClearanceTable",
    "Controller",
    "ControllerClosed",
    "Io",
    "MotionClearance",
    "NoSolutionError",
    "Part",
    "PlannedPath",
    "PlanningError",
    "Recording",
    "Result",
    "Robot",
    "ScriptError",
    "State",
    "__version__",
    "bit_list_to_integer",
    "clearance",
    "d2r",
    "identify",
    "integer_to_bit_list",
    "interpolate_pose",
    "models",
    "norm",
    "normalize",
    "open_recording",
    "plan",
    "point_dist",
    "pose_add",
    "pose_dist",
    "pose_inv",
    "pose_sub",
    "pose_trans",
    "r2d",
    "rotvec2rpy",
    "rpy2rotvec",
    "sweep",
    "wrench_trans",
]
