"""Is the way free, and a way around what is in it: distances of programs and planned paths."""

from __future__ import annotations

import numbers
from dataclasses import dataclass, field
from typing import Any, Iterator, List, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._elitescript import PlanningError, measure_clearance, planned_path
from ._options import option_texts, preset_pairs, program_text


@dataclass(frozen=True)
class MotionClearance:
    """How near one motion of a program comes to anything."""

    #: Line of the program, from 1; 0 for a motion that no program asked for.
    line: int
    #: Label of the task's node in which the line stands.
    node: Optional[str]
    #: Name of the function, ``movej`` for instance.
    kind: str
    #: Least distance, m; negative ones are depths. None where nothing can be touched.
    distance: Optional[float]
    #: What moves with the arm, and the other one.
    a: Optional[str]
    b: Optional[str]
    #: Simulated time, s, and TCP pose, m and rad, of the nearest place.
    time: Optional[float]
    tcp: Optional[List[float]]
    #: Least distance of a joint to the end of its range, rad.
    joint_margin: float
    #: Least singular value of the Jacobian of the TCP, in m and rad.
    singularity: float


@dataclass(frozen=True)
class ClearanceTable(Sequence[MotionClearance]):
    """The motions of a program in their order, and what holds of all of them."""

    motions: List[MotionClearance]
    #: What kept the program from its end, None if nothing did.
    error: Optional[str]
    #: How long it took, simulated s.
    time: float

    def __len__(self) -> int:
        return len(self.motions)

    def __getitem__(self, index: Any) -> Any:
        return self.motions[index]

    def __iter__(self) -> Iterator[MotionClearance]:
        return iter(self.motions)

    @property
    def nearest(self) -> Optional[MotionClearance]:
        """The motion that comes nearest to something."""
        measured = [motion for motion in self.motions if motion.distance is not None]
        return min(measured, key=lambda motion: motion.distance or 0.0) if measured else None

    @property
    def distance(self) -> Optional[float]:
        """The least distance of the whole program, m."""
        nearest = self.nearest
        return None if nearest is None else nearest.distance

    def to_table(self) -> Any:
        """The motions as a pyarrow table."""
        import pyarrow as pa  # type: ignore[import-untyped,import-not-found,unused-ignore]

        names = list(MotionClearance.__dataclass_fields__)
        return pa.table({name: [getattr(motion, name) for motion in self.motions] for name in names})


@dataclass(frozen=True)
class PlannedPath:
    """A path that was driven on a simulated arm."""

    #: Start, corners and goal, shape (N, 6), rad.
    waypoints: NDArray[np.float64] = field(repr=False)
    #: The program that drives it.
    program: str = field(repr=False)
    #: Least distance on the driven path, m; None where nothing can be touched.
    distance: Optional[float]
    #: Sum of the Euclidean distances between the waypoints, rad.
    length: float
    #: How long it takes to drive, s.
    time: float
    #: How long it took to plan, s.
    planning_time: float = field(compare=False)
    #: What a person should know of it.
    warnings: List[str] = field(default_factory=list)


def _number(name: str, given: Any) -> float:
    if isinstance(given, bool) or not isinstance(given, numbers.Real):
        raise ValueError(f"{name} must be a number, got {given!r}")
    return float(given)


def _six(name: str, given: Any) -> List[float]:
    try:
        array = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be 6 numbers, got {given!r}") from None
    if array.shape != (6,):
        raise ValueError(f"{name} must have shape (6,), got shape {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {given!r}")
    return [float(x) for x in array]


def clearance(
    program: Any,
    cell: Any = None,
    *,
    set: Optional[Mapping[str, Any]] = None,
    timeout: float = 600.0,
    **options: Any,
) -> ClearanceTable:
    """Runs a program (text or path) and tells how near each of its motions comes to anything.

    The arm is ideal, contacts stop nobody. Options are those of Controller; ``set`` are globals of the program.
    """
    if cell is not None:
        options["cell"] = cell
    name, text, _ = program_text(program)
    presets = preset_pairs(set or {})
    rows, error, time = measure_clearance(option_texts(options), name, text, presets, _number("timeout", timeout))
    return ClearanceTable([MotionClearance(*row) for row in rows], error, time)


def plan(
    to: Union[str, ArrayLike],
    *,
    start: Optional[ArrayLike] = None,
    cell: Any = None,
    pose: bool = False,
    via: Sequence[ArrayLike] = (),
    margin: float = 0.01,
    seed: int = 0,
    time: float = 5.0,
    held: Optional[str] = None,
    approach: float = 0.0,
    speed: Optional[float] = None,
    acceleration: Optional[float] = None,
    **options: Any,
) -> PlannedPath:
    """Plans a path to joint positions, or to a pose of the TCP: ``pose=True``, or the text ``"p[x,y,z,Rx,Ry,Rz]"``.

    Raises PlanningError, whose ``reason`` is "start_in_collision", "goal_in_collision", "out_of_reach" or "no_path".
    Other options are those of Controller.
    """
    if isinstance(to, str):
        text = to.strip()
        pose = pose or text.startswith("p")
        numbers_text = text.lstrip("p").strip().lstrip("[").rstrip("]")
        try:
            target = _six("to", [float(part) for part in numbers_text.split(",")])
        except ValueError:
            raise ValueError(f"to must be six joint positions or 'p[x,y,z,Rx,Ry,Rz]', got {to!r}") from None
    else:
        target = _six("to", to)
    if start is not None:
        options["home"] = start
    if cell is not None:
        options["cell"] = cell
    options["seed"] = seed
    waypoints, program, distance, length, duration, planning_time, warnings = planned_path(
        option_texts(options),
        target,
        pose,
        [_six("via", q) for q in via],
        _number("margin", margin),
        _number("time", time),
        held,
        _number("approach", approach),
        None if speed is None else _number("speed", speed),
        None if acceleration is None else _number("acceleration", acceleration),
    )
    return PlannedPath(np.array(waypoints), program, distance, length, duration, planning_time, warnings)


def _reason(error: PlanningError) -> str:
    return str(error.args[0])


def _detail(error: PlanningError) -> str:
    return str(error.args[1])


def _text(error: PlanningError) -> str:
    return f"{error.args[0]}: {error.args[1]}"


# The native module raises it with (reason, detail); with CPython's stable ABI it cannot have properties of its own.
for _name, _value in (("reason", property(_reason)), ("detail", property(_detail)), ("__str__", _text)):
    setattr(PlanningError, _name, _value)
