"""A whole controller in this process: programs run on a simulated arm, faster than time, the same on every machine."""

from __future__ import annotations

import numbers
import os
import warnings
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, Iterator, List, Mapping, NamedTuple, NoReturn, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._elitescript import NativeController, ScriptError, row_fields
from ._options import duration, option_texts, preset_pairs, program_text

#: The fields of a cycle, as numpy describes them.
CYCLE_DTYPE = np.dtype(row_fields())

#: Cycles that a trace keeps unless it is told otherwise: 1000 s at 4 ms, 0.2 GB.
TRACE_CYCLES = 250_000


@dataclass(frozen=True)
class Result:
    """What became of a program."""

    #: "ended", "failed", "stopped", "protective_stop", "emergency_stop" or "timeout".
    outcome: str
    #: ``Type: message`` of an exception, or the sentence of a stop, an alarm or a time-out.
    error: Optional[str]
    #: The line of the error, from 1; of a stop or a time-out the line in which the program stood.
    line: Optional[int]
    #: Simulated time from the program's start until it had ended and the arm stood, s.
    time: float
    #: What it printed, a line each.
    prints: List[str]
    #: The whole report of its errors: places, source lines, call stacks.
    report: Optional[str] = field(default=None, compare=False)

    @property
    def ok(self) -> bool:
        """True when the program ran to its end."""
        return self.outcome == "ended"

    def check(self) -> "Result":
        """Itself when the program ran to its end; otherwise raises ScriptError with the report."""
        if not self.ok:
            raise ScriptError(self.report or self.error or f"the program {self.outcome}")
        return self

    def __repr__(self) -> str:
        words = [f"{self.outcome} after {self.time:.3f} s"]
        if self.error is not None:
            words.append(self.error if self.line is None else f"line {self.line}: {self.error}")
        shown = self.prints[-5:]
        more = len(self.prints) - len(shown)
        lines = [f"  ({more} lines before)"] if more else []
        lines += ["  " + (text if len(text) <= 100 else text[:97] + "...") for text in shown]
        return "\n".join([f"<Result {', '.join(words)}>"] + lines)


class State(Mapping[str, Any]):
    """The robot after one cycle: the fields of ``/cycle``, as attributes and as keys. Vectors are numpy arrays."""

    __slots__ = ("_row",)
    _row: Any

    def __init__(self, row: Any) -> None:
        object.__setattr__(self, "_row", row)

    def __getitem__(self, name: str) -> Any:
        if name not in CYCLE_DTYPE.names:  # type: ignore[operator]
            raise KeyError(f"there is no {name!r} in a cycle; allowed are {', '.join(CYCLE_DTYPE.names or ())}")
        value = self._row[name]
        return value if isinstance(value, np.ndarray) else value.item()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError("a state is what was measured; it cannot be changed")

    def __iter__(self) -> Iterator[str]:
        return iter(CYCLE_DTYPE.names or ())

    def __len__(self) -> int:
        return len(CYCLE_DTYPE.names or ())

    def __dir__(self) -> List[str]:
        return list(CYCLE_DTYPE.names or ()) + list(super().__dir__())

    def __repr__(self) -> str:
        lines = [f"<State of cycle {self['cycle']}, {self['time']:.3f} s, {self['mode']}>"]
        for name in ("actual_q", "actual_qd", "actual_tcp_pose", "tcp_force"):
            lines.append(f"  {name} {np.array2string(self[name], precision=4, suppress_small=True)}")
        return "\n".join(lines)


class Io:
    """Inputs, outputs and registers by the names of the cell file: ``c.io["standard_digital_in[0]"] = True``."""

    __slots__ = ("_native",)

    def __init__(self, native: NativeController) -> None:
        self._native = native

    def __getitem__(self, name: str) -> Union[bool, int, float]:
        return self._native.io_get(_point(name))

    def __setitem__(self, name: str, value: Union[bool, int, float]) -> None:
        if isinstance(value, np.generic):
            value = value.item()
        self._native.io_set(_point(name), value)

    def __repr__(self) -> str:
        return '<Io: io["standard_digital_in[0]"], io["tool_analog_in"], io["output_float_register[3]"], ...>'


def _point(name: object) -> str:
    if not isinstance(name, str):
        raise ValueError(f"the name of an input or output is a text, got {name!r}")
    return name


class Part(NamedTuple):
    """A part of the cell."""

    #: x, y, z, Rx, Ry, Rz in the base frame, m and rad, (6,).
    pose: NDArray[np.float64]
    #: Of its centre, m/s.
    speed: float
    #: Name of the gripper that holds it.
    held_by: Optional[str]


def _name(argument: str, given: object) -> str:
    if not isinstance(given, str):
        raise ValueError(f"{argument} must be a text, got {given!r}")
    return given


def _pose(given: ArrayLike) -> List[float]:
    array = np.asarray(given, dtype=float) if not isinstance(given, str) else np.empty(0)
    if array.shape != (6,) or not np.isfinite(array).all():
        raise ValueError(f"pose must be six finite numbers, got {given!r}")
    return [float(x) for x in array]


class Controller:
    """One arm with its controller, under the virtual clock, without ports.

    Options are those of the command line; None is the default:

    model: "cs63" to "cs625", or the path of a URDF file.
    cell: the path of a cell file, or its text (more than one line).
    plant: "rigid", "rapier" or "ideal".
    step_ms: length of a control cycle, 1 to 8.
    seed: of ``random()`` and of every simulated noise.
    home: joint positions at the start, (6,), rad.
    tcp: tool centre point from the flange, (6,), m and rad.
    payload: mass, (mass, cog) or (mass, cog, inertia): kg, m, kg m^2.
    calibration: the path of a calibration file.
    task_dir: the folder that ``get_task_path()`` tells programs.
    record: the path of the MCAP recording to write.
    allow: what programs may reach: "fs", "fs=DIR", "process", "env", "net"; default ("net",).
    trace: how many cycles ``trace`` keeps, 0 for none.
    wall_timeout: a program that computes for so long without simulated time passing is stopped, s.

    Time passes only in ``run``, ``step``, ``run_until`` and ``wait``, without the interpreter lock: controllers in
    threads run beside each other, each deterministic. What is set between two calls counts from the next cycle on.
    """

    _native: NativeController
    _options: Dict[str, str]
    _io: Io
    _wall: float

    def __init__(
        self,
        *,
        model: Optional[str] = None,
        cell: Optional[Union[str, "os.PathLike[str]"]] = None,
        plant: Optional[str] = None,
        step_ms: Optional[int] = None,
        seed: Optional[int] = None,
        home: Optional[ArrayLike] = None,
        tcp: Optional[ArrayLike] = None,
        payload: Any = None,
        calibration: Optional[Union[str, "os.PathLike[str]"]] = None,
        task_dir: Optional[Union[str, "os.PathLike[str]"]] = None,
        record: Optional[Union[str, "os.PathLike[str]"]] = None,
        allow: Optional[Union[str, Sequence[str]]] = None,
        trace: int = TRACE_CYCLES,
        wall_timeout: float = 30.0,
        # Type checkers refuse every name that is not above; at run time ValueError says which there are.
        **unknown: NoReturn,
    ) -> None:
        if unknown:
            options = (
                "model, cell, plant, step_ms, seed, home, tcp, payload, calibration, task_dir, record, allow, trace, "
                "wall_timeout"
            )
            raise ValueError(f"there is no option {next(iter(unknown))}; allowed are {options}")
        given = {
            "model": model,
            "cell": cell,
            "plant": plant,
            "step_ms": step_ms,
            "seed": seed,
            "home": home,
            "tcp": tcp,
            "payload": payload,
            "calibration": calibration,
            "task_dir": task_dir,
            "record": record,
            "allow": allow,
        }
        self._wall = duration("wall_timeout", wall_timeout)
        if isinstance(trace, bool) or not isinstance(trace, numbers.Integral) or not 0 <= trace <= 10**9:
            raise ValueError(f"trace must be a number of cycles from 0 to 1e9, got {trace!r}")
        self._options = option_texts(given)
        self._native = NativeController(self._options, int(trace))
        self._io = Io(self._native)

    def run(
        self,
        program: Union[str, "os.PathLike[str]"],
        timeout: float = 60.0,
        *,
        globals: Optional[Mapping[str, Any]] = None,
    ) -> Result:
        """Runs a program, a text or the path of a file, to its end.

        timeout: simulated seconds after which it is stopped (outcome "timeout").
        globals: variables that it finds set, as ``--set`` of the command line.

        How the program ended is in the result; nothing is raised for it.
        """
        name, text, _ = program_text(program)
        timeout = duration("timeout", timeout)
        return _result(self._native.run(name, text, preset_pairs(globals), timeout, self._wall))

    def start(self, program: Union[str, "os.PathLike[str]"], *, globals: Optional[Mapping[str, Any]] = None) -> None:
        """Starts a program and lets it come to where it first waits; no time passes."""
        name, text, _ = program_text(program)
        self._native.start(name, text, preset_pairs(globals), self._wall)

    def step(self, cycles: int = 1) -> None:
        """Lets cycles pass, with the program for as long as it runs.

        TimeoutError when the program computes without waiting for longer than ``wall_timeout``; it was stopped then.
        """
        if isinstance(cycles, bool) or not isinstance(cycles, numbers.Integral) or not 0 <= cycles < 1 << 63:
            raise ValueError(f"cycles must be a whole number from 0 on, got {cycles!r}")
        self._native.step(int(cycles), self._wall)

    def run_until(self, condition: Union[str, Callable[[State], Any]], timeout: float = 60.0) -> bool:
        """Lets time pass until the condition holds; False when ``timeout`` simulated seconds have passed before.

        condition: a function of the state, asked before the first and after every cycle, or a text in the language of
        ``replay --find``: ``"norm(tcp_force[0:3]) > 20"``. What a function raises comes out of here, and the program
        stands where it was.
        """
        timeout = duration("timeout", timeout)
        if isinstance(condition, str):
            return self._native.run_until(condition, timeout, self._wall)
        if not callable(condition):
            raise ValueError(f"a condition is a function of the state or a text, got {condition!r}")
        state = self.state
        until = state.time + timeout
        try:
            while not condition(state):
                if self.state.time >= until - 1e-9:
                    return False
                self._native.step(1, self._wall)
                state = self.state
        except KeyboardInterrupt:
            self._native.stop()
            raise
        return True

    def wait(self, timeout: float = 60.0) -> Result:
        """Lets the started program run to its end, for at most ``timeout`` simulated seconds more."""
        return _result(self._native.finish(duration("timeout", timeout), self._wall))

    def stop(self) -> Optional[Result]:
        """Stops the program; the arm stands when this returns. The result of the newest program,
        None if there was none.

        While another thread lets the program run, that call gets the result, and this one returns None at once.
        """
        parts = self._native.stop()
        return None if parts is None else _result(parts)

    @property
    def running(self) -> bool:
        """True while a program runs."""
        return self._native.is_running()

    @property
    def result(self) -> Optional[Result]:
        """How the newest program ended; None while it runs and before the first."""
        parts = self._native.result()
        return None if parts is None else _result(parts)

    @property
    def prints(self) -> List[str]:
        """What the newest program printed so far, a line each."""
        return self._native.prints()

    @property
    def state(self) -> State:
        """The robot after the latest cycle."""
        return State(self._native.state().view(CYCLE_DTYPE)[0])

    @property
    def trace(self) -> NDArray[np.void]:
        """Every cycle so far as one structured array: ``c.trace["actual_q"]`` is (N, 6)."""
        rows, dropped = self._native.trace()
        if dropped:
            warnings.warn(
                f"the trace has lost its first {dropped} cycles; Controller(trace=...) says how many are kept",
                RuntimeWarning,
                stacklevel=2,
            )
        return rows.view(CYCLE_DTYPE)

    @property
    def peaks(self) -> Mapping[str, Any]:
        """The largest values since the newest program began: tcp_speed, tcp_force, tcp_torque, joint_speed,
        joint_torque."""
        speed, force, torque, joint_speed, joint_torque = self._native.peaks()
        return {
            "tcp_speed": speed,
            "tcp_force": force,
            "tcp_torque": torque,
            "joint_speed": np.array(joint_speed),
            "joint_torque": np.array(joint_torque),
        }

    @property
    def io(self) -> Io:
        """Inputs, outputs and registers by name, to be read and set."""
        return self._io

    @property
    def parts(self) -> Mapping[str, Part]:
        """The parts of the cell that are there now, by name; empty where the cell has none."""
        rows = self._native.parts() or []
        return {name: Part(np.array(pose), speed, held_by) for name, pose, speed, held_by in rows}

    def count(self, sink: str) -> int:
        """How many parts a sink of the cell has removed."""
        return self._native.count(_name("sink", sink))

    def place(self, name: str, pose: ArrayLike) -> None:
        """Puts a part somewhere, at rest: (6,), m and rad, base frame. A gripper loses it."""
        self._native.place(_name("name", name), _pose(pose))

    def remove(self, name: str) -> None:
        """Takes a part out of the cell."""
        self._native.remove(_name("name", name))

    def add(self, template: str, pose: ArrayLike) -> str:
        """Puts another part of a table of the cell file into the cell; its name."""
        return self._native.add(_name("template", template), _pose(pose))

    def fault(self, what: str, name: str, duration: Optional[float] = None) -> None:
        """Lets something go wrong, as [[fault]] of the cell file does: for ``duration`` s, or for ever."""
        self._native.fault(_name("what", what), _name("name", name), None if duration is None else float(duration))

    @property
    def recording(self) -> Optional[str]:
        """The file that is being recorded."""
        path = self._native.recording_path()
        return None if path is None else str(path)

    def set_external_wrench(self, wrench: ArrayLike, frame: str = "base") -> None:
        """A force and a moment on the tool from the next cycle on until the next call, about the TCP: N and Nm, (6,).

        frame: "base" or "tool": whose axes it keeps.
        """
        array = np.asarray(wrench, dtype=float) if not isinstance(wrench, str) else np.empty(0)
        if array.shape != (6,):
            raise ValueError(f"wrench must have shape (6,), got {wrench!r}")
        if not np.isfinite(array).all() or np.abs(array).max() > 1e5:
            raise ValueError(f"wrench must be finite and at most 1e5, got {wrench!r}")
        if frame not in ("base", "tool"):
            raise ValueError(f'frame must be "base" or "tool", got {frame!r}')
        self._native.set_wrench([float(x) for x in array], frame == "tool")

    def order(self, name: str) -> None:
        """An order of the pendant, from the next cycle on: "unlock" (leaves a protective stop), "emergency_stop",
        "release_emergency_stop", "power_on", "release_brakes"."""
        self._native.order(name)

    def plot(self, *, joints: Optional[Sequence[int]] = None) -> Any:
        """A matplotlib figure of the trace: joint positions, speeds, torques, force on the tool."""
        from ._plot import figure

        return figure(self.trace, joints)

    def close(self) -> bool:
        """Ends the controller; the recording is complete afterwards. True when it was written to its end."""
        return self._native.close()

    def __enter__(self) -> "Controller":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> NoReturn:
        raise TypeError("a controller cannot be pickled; give the other process its options")

    def __repr__(self) -> str:
        try:
            state = self.state
        except RuntimeError as error:
            return f"<Controller: {error}>"
        model = self._options.get("model", "cs66")
        doing = "a program runs" if self.running else "no program runs"
        return f"<Controller {model}, cycle {state.cycle}, {state.time:.3f} s, {doing}>"


def _result(parts: Tuple[str, Optional[str], Optional[int], float, List[str], Optional[str]]) -> Result:
    return Result(*parts)
