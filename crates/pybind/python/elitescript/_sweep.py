"""One program with many parameters, on every core: threads, processes, a Ray or a Dask cluster,
with the same table from each.

A unit of work is a pure function of its description, so whoever runs it, and however often, the row is the same. Owns
no queue, scheduler or protocol: the executors are those of ``concurrent.futures``, Ray and Dask.
"""

from __future__ import annotations

import importlib
import itertools
import math
import os
import shlex
import sys
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Sized, Tuple, Union

import numpy as np

from ._controller import Controller
from ._executors import EXECUTORS
from ._options import command_options, duration, kept_text, literal, option_texts, preset_pairs, program_text
from ._units import Row, Store, Unit

if TYPE_CHECKING:
    import pyarrow as _pa  # type: ignore[import-untyped,import-not-found,unused-ignore]

#: Columns behind those of the parameters.
COLUMNS = (
    "seed",
    "outcome",
    "error",
    "line",
    "time",
    "peak_tcp_speed",
    "peak_tcp_force",
    "peak_joint_speed",
    "command",
)

Parameters = Mapping[str, Any]


def sweep(
    program: Union[str, "os.PathLike[str]"],
    parameters: Union[Mapping[str, Iterable[Any]], Iterable[Parameters]],
    *,
    executor: str = "threads",
    workers: Optional[int] = None,
    options: Optional[Union[Mapping[str, Any], Callable[[Parameters], Mapping[str, Any]]]] = None,
    seed: int = 0,
    timeout: float = 60.0,
    wall_timeout: float = 30.0,
    folder: Optional[Union[str, "os.PathLike[str]"]] = None,
    record: str = "none",
    progress: Optional[bool] = None,
    on_row: Optional[Callable[[Row], Any]] = None,
) -> "_pa.Table":
    """Runs the program once for each set of parameters; a pyarrow table with a row for each, in their order.

    program: a text or the path of a file. The parameters are globals that it finds set.
    parameters: a grid, ``{"speed": [0.1, 0.2], "force": [5, 10]}`` (every combination, the last name changes fastest),
        or samples: dicts, all with the same names, from a list or any iterator. A parameter called ``seed`` is the seed
        of its row and no global.
    executor: "threads", "processes", "ray" or "dask". The rows do not depend on it.
    workers: how many at once; default: the cores (Ray, Dask: those of the cluster).
    options: options of ``Controller`` for all, or a function of the parameters that gives them.
    seed: the seed of every row, unless there is a parameter of that name.
    timeout, wall_timeout: as in ``Controller``.
    folder: a folder, or an address that fsspec knows (``s3://...``, ``memory://...``), for ``rows/``, ``recordings/``
        and ``table.parquet``. Rows that are there already, of the same program, options and parameters,
        are not run again.
    record: "none", "failed" or "all": whose recordings are kept in the folder.
    progress: a line on standard error; default: when that is a terminal.
    on_row: is called with each row, a dict, as it is finished, in the order of their ends.

    Columns: the parameters, ``seed, outcome, error, line, time, peak_tcp_speed, peak_tcp_force, peak_joint_speed,
    command``. The command repeats the row. A unit that fails for another reason than its program, or whose worker dies,
    is repeated once; then its row says so (outcome "failed").
    """
    pyarrow = _pyarrow()
    if executor not in EXECUTORS:
        raise ValueError(f"executor must be one of {', '.join(map(repr, EXECUTORS))}, got {executor!r}")
    if record not in ("none", "failed", "all"):
        raise ValueError(f'record must be "none", "failed" or "all", got {record!r}')
    if record != "none" and folder is None:
        raise ValueError("record needs a folder to keep recordings in")
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or not 1 <= workers <= 4096):
        raise ValueError(f"workers must be a whole number from 1 to 4096, got {workers!r}")
    store = None if folder is None else Store(os.fspath(folder))
    maker = _Maker(
        program, options, seed, duration("timeout", timeout), duration("wall_timeout", wall_timeout), record, store
    )
    sets, total = _sets(parameters)
    meter = _Meter(total, sys.stderr.isatty() if progress is None else progress)
    rows: Dict[int, Row] = {}

    def finished(index: int, row: Row) -> None:
        rows[index] = row
        meter.note(row)
        if on_row is not None:
            on_row(dict(row))

    def units() -> Iterator["Unit"]:
        for index, chosen in enumerate(sets):
            unit = maker.unit(index, chosen)
            known = None if store is None else store.known(unit)
            if known is not None:
                finished(index, known)
            else:
                yield unit

    with meter, EXECUTORS[executor](workers) as pool:
        for unit, row in pool.rows(units()):
            if store is not None:
                store.keep(unit, row)
            finished(unit["index"], row)
    table = _table(pyarrow, maker.names, [rows[index] for index in sorted(rows)])
    if store is not None:
        store.write_table(table)
    return table


def _pyarrow() -> Any:
    try:
        return importlib.import_module("pyarrow")
    except ImportError:
        raise ImportError('a sweep needs pyarrow: pip install "elitescript[sweep]"') from None


def _sets(parameters: Any) -> Tuple[Iterator[Parameters], Optional[int]]:
    """The sets of parameters, and how many there are, if that is known."""
    total: Optional[int]
    if isinstance(parameters, Mapping):
        names = list(parameters)
        values: List[List[Any]] = []
        for name in names:
            column = parameters[name]
            if isinstance(column, (str, bytes)) or not isinstance(column, Iterable):
                raise ValueError(f"parameter {name} of a grid must be a list of values, got {column!r}")
            values.append(list(column))
        total = math.prod(len(column) for column in values)
        return (dict(zip(names, chosen)) for chosen in itertools.product(*values)), total
    if isinstance(parameters, (str, bytes)) or not isinstance(parameters, Iterable):
        raise ValueError(f"parameters must be a grid (a dict of lists) or samples (dicts), got {parameters!r}")
    total = len(parameters) if isinstance(parameters, Sized) else None
    return iter(parameters), total


class _Maker:
    """Makes units of sets of parameters, and says what does not fit before anything runs."""

    def __init__(
        self, program: Any, options: Any, seed: int, timeout: float, wall: float, record: str, store: Optional["Store"]
    ) -> None:
        self.names: List[str] = []
        self._name, self._text, path = program_text(program)
        self._options = options
        self._seed = seed
        self._timeout, self._wall, self._record = timeout, wall, record
        self._store = store
        self._folder = store.local if store is not None else None
        self._path = str(path) if path is not None else kept_text(self._text, ".script", self._folder)

    def unit(self, index: int, chosen: Any) -> Unit:
        if not isinstance(chosen, Mapping) or not all(isinstance(name, str) for name in chosen):
            raise ValueError(f"sample {index} must be a dict from names to values, got {chosen!r}")
        if index == 0:
            self.names = list(chosen)
            taken = [name for name in self.names if name in COLUMNS and name != "seed"]
            if taken:
                raise ValueError(f"a parameter cannot be called {taken[0]}: the table has a column of that name")
        elif set(chosen) != set(self.names):
            raise ValueError(f"sample {index} has {', '.join(chosen)}; the first has {', '.join(self.names)}")
        given = self._options(chosen) if callable(self._options) else (self._options or {})
        if "record" in given or "trace" in given or "seed" in given:
            raise ValueError("options of a sweep have no record, trace or seed: record= and seed= of the sweep say it")
        options = dict(given, seed=chosen.get("seed", self._seed))
        texts = option_texts(options, self._folder)
        presets = preset_pairs({name: value for name, value in chosen.items() if name != "seed"})
        words = ["eliteserver", "run", self._path]
        words += [f"--set={name}={text}" for name, text in presets] + command_options(texts)
        unit = {
            "index": index,
            "name": self._name,
            "text": self._text,
            "parameters": {name: _plain(chosen[name]) for name in self.names},
            "presets": presets,
            "options": texts,
            "timeout": self._timeout,
            "wall": self._wall,
            "record": self._record,
            "keep": None if self._store is None else self._store.address,
            "command": " ".join(shlex.quote(word) for word in words),
        }
        if index == 0:
            # Options that fit nothing are an error of the call, not of every row.
            Controller(**options, trace=0).close()
        return unit


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value


def _table(pyarrow: Any, names: List[str], rows: List[Row]) -> Any:
    types = {
        "seed": pyarrow.uint64(),
        "outcome": pyarrow.string(),
        "error": pyarrow.string(),
        "line": pyarrow.int64(),
        "time": pyarrow.float64(),
        "peak_tcp_speed": pyarrow.float64(),
        "peak_tcp_force": pyarrow.float64(),
        "peak_joint_speed": pyarrow.float64(),
        "command": pyarrow.string(),
    }
    columns = {}
    for name in [name for name in names if name != "seed"]:
        values = [row[name] for row in rows]
        try:
            columns[name] = pyarrow.array(values)
        except (pyarrow.ArrowInvalid, pyarrow.ArrowTypeError, pyarrow.ArrowNotImplementedError):
            # Values of several types have one type as text.
            columns[name] = pyarrow.array([literal(value) for value in values])
    for name, kind in types.items():
        columns[name] = pyarrow.array([row[name] for row in rows], type=kind)
    return pyarrow.table(columns)


class _Meter:
    """One line on standard error: how far, how fast, how many failed."""

    def __init__(self, total: Optional[int], shown: bool) -> None:
        self._total, self._shown = total, shown
        self._done = self._failed = 0
        self._began = time.monotonic()
        self._told = 0.0

    def note(self, row: Row) -> None:
        self._done += 1
        self._failed += row["outcome"] != "ended"
        now = time.monotonic()
        if self._shown and (now - self._told > 0.1 or self._done == self._total):
            self._told = now
            rate = self._done / max(now - self._began, 1e-9)
            line = f"{self._done} rows"
            if self._total:
                bar = "#" * (20 * self._done // self._total)
                line = f"[{bar:<20}] {self._done}/{self._total}, {(self._total - self._done) / rate:.0f} s left"
            sys.stderr.write(f"\r{line}, {rate:.1f} a second, {self._failed} not ended \x1b[K")
            sys.stderr.flush()

    def __enter__(self) -> "_Meter":
        return self

    def __exit__(self, *_: Any) -> None:
        if self._shown and self._done:
            sys.stderr.write("\n")
