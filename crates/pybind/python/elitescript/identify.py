"""Payload, friction, tool, frame and force sensor of an arm, from what was recorded:
``eliteserver identify`` in Python.

Every function takes a trace: the path of a recording or an open ``Recording``, a list of these, or the rows of
``/cycle`` (``Controller.trace``), which do not say which arm they are of and so need ``robot``. What the data cannot
tell raises ``ValueError`` with the sentence that names what is missing. Sigmas are one standard deviation.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, Dict, List, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from ._elitescript import Robot, identified_arrays, identified_files
from ._paths import _number
from ._recording import Recording

__all__ = [
    "Frame",
    "Friction",
    "FrictionSigma",
    "Payload",
    "PayloadSigma",
    "Sensor",
    "SensorSigma",
    "Tool",
    "ToolSigma",
    "frame",
    "friction",
    "payload",
    "sensor",
    "tool",
]

_File = Union[str, "os.PathLike[str]", Recording]
Trace = Union[_File, Sequence[_File], NDArray[np.void]]

#: Fields of ``/cycle`` that are used.
_FIELDS = ("time", "actual_q", "actual_qd", "target_qdd", "actual_torque", "raw_wrench", "tcp_offset", "gravity")


@dataclass(frozen=True)
class PayloadSigma:
    """One standard deviation of each number."""

    mass: float
    cog: List[float]


@dataclass(frozen=True)
class Payload:
    """What hangs on the flange."""

    #: kg
    mass: float
    #: Centre of gravity in the flange frame, m.
    cog: List[float]
    #: Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of gravity, kg m²; None where the motion does not tell it.
    inertia: Optional[List[float]]
    sigma: PayloadSigma
    #: Root of the mean square of what the fit leaves: N, or Nm from torques.
    residual_rms: float
    samples: int


@dataclass(frozen=True)
class FrictionSigma:
    """One standard deviation of each number."""

    coulomb: List[float]
    viscous: List[float]


@dataclass(frozen=True)
class Friction:
    """Friction of the joints, base first."""

    #: Dry friction, Nm.
    coulomb: List[float]
    #: Viscous friction, Nm s/rad.
    viscous: List[float]
    sigma: FrictionSigma
    #: Nm
    residual_rms: float
    samples: int


@dataclass(frozen=True)
class ToolSigma:
    """One standard deviation."""

    #: Of each coordinate, m.
    position: List[float]
    #: rad; None where no orientation was asked for.
    orientation: Optional[float]


@dataclass(frozen=True)
class Tool:
    """A tool centre point."""

    #: Pose in the flange frame.
    tcp: List[float]
    sigma: ToolSigma
    #: The largest distance of a tip from the point, m.
    residual_max: float
    #: Rests that were used.
    samples: int


@dataclass(frozen=True)
class Frame:
    """A frame of the workpiece."""

    #: Pose in the base frame.
    frame: List[float]
    #: Rests that were used.
    samples: int


@dataclass(frozen=True)
class SensorSigma:
    """One standard deviation of each number."""

    bias: List[float]
    mass: float
    cog: List[float]


@dataclass(frozen=True)
class Sensor:
    """Bias of the force sensor, and what hangs below it."""

    #: Force and moment that the sensor reads too much, N and Nm.
    bias: List[float]
    #: kg
    mass: float
    #: Centre of gravity in the flange frame, m.
    cog: List[float]
    sigma: SensorSigma
    residual_rms: float
    #: Rests that were used.
    samples: int


def payload(
    trace: Trace,
    *,
    robot: Optional[Robot] = None,
    start: Optional[float] = None,
    end: Optional[float] = None,
    from_torques: bool = False,
) -> Payload:
    """Mass, centre of gravity and, where the motion tells it, inertia of what hangs on the flange.

    From the force reading, or with ``from_torques`` from the torques of the joints.
    ``start`` and ``end`` are times in s.
    """
    found = _answer("payload", trace, robot, start, end, from_torques=_switch("from_torques", from_torques))
    return Payload(**{**found, "sigma": PayloadSigma(**found["sigma"])})


def friction(
    trace: Trace, *, robot: Optional[Robot] = None, start: Optional[float] = None, end: Optional[float] = None
) -> Friction:
    """Dry and viscous friction of each joint, from the torques of the joints."""
    found = _answer("friction", trace, robot, start, end)
    return Friction(**{**found, "sigma": FrictionSigma(**found["sigma"])})


def tool(
    trace: Trace,
    *,
    robot: Optional[Robot] = None,
    start: Optional[float] = None,
    end: Optional[float] = None,
    at: Sequence[float] = (),
    orientation: bool = False,
) -> Tool:
    """The TCP, from four or more rests of its tip at one point: every rest, or those at the times ``at``.

    With ``orientation`` the last three rests are the point, the tip moved along tool +x,
    the tip moved into +y of its xy plane.
    """
    found = _answer("tool", trace, robot, start, end, at=at, orientation=_switch("orientation", orientation))
    return Tool(**{**found, "sigma": ToolSigma(**found["sigma"])})


def frame(
    trace: Trace,
    *,
    robot: Optional[Robot] = None,
    start: Optional[float] = None,
    end: Optional[float] = None,
    at: Sequence[float] = (),
) -> Frame:
    """A frame from three rests: its origin, a point on its x axis, one in its xy plane at +y."""
    return Frame(**_answer("frame", trace, robot, start, end, at=at))


def sensor(
    trace: Trace,
    *,
    robot: Optional[Robot] = None,
    start: Optional[float] = None,
    end: Optional[float] = None,
    at: Sequence[float] = (),
) -> Sensor:
    """Bias of the force sensor, mass and centre of gravity below it, from rests in three or more orientations."""
    found = _answer("sensor", trace, robot, start, end, at=at)
    return Sensor(**{**found, "sigma": SensorSigma(**found["sigma"])})


def _switch(name: str, given: Any) -> bool:
    if not isinstance(given, (bool, np.bool_)):
        raise ValueError(f"{name} must be True or False, got {given!r}")
    return bool(given)


def _time(name: str, given: Any) -> Optional[float]:
    if given is None:
        return None
    time = _number(name, given)
    if not np.isfinite(time):
        raise ValueError(f"{name} must be a finite number of seconds, got {given!r}")
    return time


def _answer(
    what: str,
    trace: Any,
    robot: Any,
    start: Any,
    end: Any,
    *,
    from_torques: bool = False,
    at: Any = (),
    orientation: bool = False,
) -> Dict[str, Any]:
    begin, until = _time("start", start), _time("end", end)
    if begin is not None and until is not None and begin > until:
        raise ValueError(f"start must not be after end, got {start!r} and {end!r}")
    if isinstance(at, str) or not isinstance(at, (Sequence, np.ndarray)):
        raise ValueError(f"at must be a list of times in seconds, got {at!r}")
    times = [time for time in (_time("at", each) for each in at) if time is not None]
    if robot is not None and not isinstance(robot, Robot):
        raise ValueError(f"robot must be a Robot, got {robot!r}")
    if isinstance(trace, np.ndarray):
        if robot is None:
            raise ValueError("robot must be given with the rows of a trace: they do not say which arm they are of")
        text = identified_arrays(what, robot, _rows(trace, begin, until), from_torques, times, orientation)
    else:
        if robot is not None:
            raise ValueError("robot must be left out with recordings: they say which arm they are of")
        text = identified_files(what, _paths(trace), begin, until, from_torques, times, orientation)
    found: Dict[str, Any] = json.loads(text)
    return found


def _paths(trace: Any) -> List[str]:
    files = list(trace) if isinstance(trace, (list, tuple)) else [trace]
    if not files:
        raise ValueError("trace must be one recording or more, got none")
    paths = []
    for file in files:
        if isinstance(file, Recording):
            file = file.path
        if not isinstance(file, (str, os.PathLike)) or not os.fspath(file):
            raise ValueError(f"trace must be a recording, its path, a list of these, or rows of /cycle, got {file!r}")
        paths.append(os.fspath(file))
    return paths


def _rows(trace: NDArray[Any], start: Optional[float], end: Optional[float]) -> NDArray[np.float64]:
    missing = [name for name in _FIELDS if name not in (trace.dtype.names or ())]
    if missing or trace.ndim != 1:
        raise ValueError(f"trace must have rows of /cycle; of their fields it lacks {', '.join(missing) or 'none'}")
    columns = [np.asarray(trace[name], dtype=np.float64).reshape(len(trace), -1) for name in _FIELDS]
    wanted = np.ones(len(trace), dtype=bool)
    if start is not None:
        wanted &= trace["time"] >= start
    if end is not None:
        wanted &= trace["time"] <= end
    return np.ascontiguousarray(np.hstack(columns)[wanted])
