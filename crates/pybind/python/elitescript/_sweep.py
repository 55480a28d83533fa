"""One program with many parameters, on every core: threads, processes or a Ray cluster, with the same table from each.

A unit of work is a pure function of its description, so whoever runs it, and however often, the row is the same. Owns no
queue, scheduler or protocol: the executors are those of ``concurrent.futures`` and Ray.
"""

from __future__ import annotations

import concurrent.futures as futures
import hashlib
import importlib
import io
import itertools
import json
import math
import os
import shlex
import shutil
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Set, Sized, Tuple, Union

import numpy as np

from ._controller import Controller
from ._elitescript import NativeController, __version__
from ._options import command_options, duration, kept_text, literal, option_texts, preset_pairs, program_text

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
Row = Dict[str, Any]

#: Units that wait at each worker, so that none is idle and an endless iterator is not read ahead.
_AHEAD = 2
#: A wait is begun again so often, s: an interrupt that comes while Python is about to wait does not wake it.
_LOOK_EVERY = 0.2


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
    parameters: a grid, ``{"speed": [0.1, 0.2], "force": [5, 10]}`` (every combination, the last name changes fastest), or
        samples: dicts, all with the same names, from a list or any iterator. A parameter called ``seed`` is the seed of its
        row and no global.
    executor: "threads", "processes" or "ray". The rows do not depend on it.
    workers: how many at once; default: the cores (Ray: those of the cluster).
    options: options of ``Controller`` for all, or a function of the parameters that gives them.
    seed: the seed of every row, unless there is a parameter of that name.
    timeout, wall_timeout: as in ``Controller``.
    folder: a folder, or an address that fsspec knows (``s3://...``, ``memory://...``), for ``rows/``, ``recordings/`` and
        ``table.parquet``. Rows that are there already, of the same program, options and parameters, are not run again.
    record: "none", "failed" or "all": whose recordings are kept in the folder.
    progress: a line on standard error; default: when that is a terminal.
    on_row: is called with each row, a dict, as it is finished, in the order of their ends.

    Columns: the parameters, ``seed, outcome, error, line, time, peak_tcp_speed, peak_tcp_force, peak_joint_speed,
    command``. The command repeats the row. A unit that fails for another reason than its program, or whose worker dies, is
    repeated once; then its row says so (outcome "failed").
    """
    pyarrow = _pyarrow()
    if executor not in ("threads", "processes", "ray"):
        raise ValueError(f'executor must be "threads", "processes" or "ray", got {executor!r}')
    if record not in ("none", "failed", "all"):
        raise ValueError(f'record must be "none", "failed" or "all", got {record!r}')
    if record != "none" and folder is None:
        raise ValueError("record needs a folder to keep recordings in")
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or not 1 <= workers <= 4096):
        raise ValueError(f"workers must be a whole number from 1 to 4096, got {workers!r}")
    store = None if folder is None else _Store(os.fspath(folder))
    maker = _Maker(program, options, seed, duration("timeout", timeout), duration("wall_timeout", wall_timeout), record, store)
    sets, total = _sets(parameters)
    meter = _Meter(total, sys.stderr.isatty() if progress is None else progress)
    rows: Dict[int, Row] = {}

    def finished(index: int, row: Row) -> None:
        rows[index] = row
        meter.note(row)
        if on_row is not None:
            on_row(dict(row))

    def units() -> Iterator["_Unit"]:
        for index, chosen in enumerate(sets):
            unit = maker.unit(index, chosen)
            known = None if store is None else store.known(unit)
            if known is not None:
                finished(index, known)
            else:
                yield unit

    with meter, _EXECUTORS[executor](workers) as pool:
        for unit, row in pool.rows(units()):
            if store is not None:
                store.keep(unit, row)
            finished(unit["index"], row)
    table = _table(pyarrow, maker.names, [rows[index] for index in sorted(rows)])
    if store is not None:
        store.write_table(table)
    return table


# A unit travels to other processes and machines: plain values only.
_Unit = Dict[str, Any]


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
        self, program: Any, options: Any, seed: int, timeout: float, wall: float, record: str, store: Optional["_Store"]
    ) -> None:
        self.names: List[str] = []
        self._name, self._text, path = program_text(program)
        self._options = options
        self._seed = seed
        self._timeout, self._wall, self._record = timeout, wall, record
        self._store = store
        self._folder = store.local if store is not None else None
        self._path = str(path) if path is not None else kept_text(self._text, ".script", self._folder)

    def unit(self, index: int, chosen: Any) -> _Unit:
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


class _Live:
    """Controllers that threads of a sweep run, so that an interrupted one can end them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._running: Set[NativeController] = set()
        self._is_over = False

    def add(self, native: NativeController) -> None:
        with self._lock:
            if self._is_over:
                raise RuntimeError("the sweep was interrupted")
            self._running.add(native)

    def discard(self, native: NativeController) -> None:
        with self._lock:
            self._running.discard(native)

    def stop_all(self) -> None:
        """Returns when none runs. One that is about to begin its program is stopped the next time."""
        while True:
            with self._lock:
                self._is_over = True
                running = list(self._running)
            if not running:
                return
            for native in running:
                try:
                    native.stop()
                except RuntimeError:
                    # It was closed meanwhile.
                    pass
            time.sleep(0.01)


def run_unit(unit: _Unit, live: Optional[_Live] = None) -> Row:
    """One row. The same unit gives the same row on every machine."""
    texts = dict(unit["options"])
    scratch = None
    if unit["record"] != "none":
        scratch = tempfile.mkdtemp(prefix="elitescript-")
        texts["record"] = os.path.join(scratch, "unit.mcap")
    try:
        native = NativeController(texts, 0)
        try:
            if live is not None:
                live.add(native)
            parts = native.run(unit["name"], unit["text"], unit["presets"], unit["timeout"], unit["wall"])
            speed, force, _, joint_speed, _ = native.peaks()
        finally:
            if live is not None:
                live.discard(native)
            native.close()
        outcome, error, line, taken, _, _ = parts
        if scratch is not None and (unit["record"] == "all" or outcome != "ended"):
            _Store(unit["keep"]).take_recording(unit["index"], texts["record"])
    finally:
        if scratch is not None:
            shutil.rmtree(scratch, ignore_errors=True)
    return _row(unit, outcome, error, line, taken, (speed, force, max(joint_speed)))


def _row(
    unit: _Unit,
    outcome: str,
    error: Optional[str],
    line: Optional[int],
    taken: Optional[float],
    peaks: Tuple[Optional[float], Optional[float], Optional[float]],
) -> Row:
    row: Row = dict(unit["parameters"])
    row["seed"] = int(unit["options"]["seed"])
    row.update(outcome=outcome, error=error, line=line, time=taken)
    row.update(zip(("peak_tcp_speed", "peak_tcp_force", "peak_joint_speed"), peaks))
    row["command"] = unit["command"]
    return row


def _gave_up(unit: _Unit, error: BaseException) -> Row:
    """The row of a unit that has failed twice for another reason than its program."""
    dead = isinstance(error, futures.BrokenExecutor) or "WorkerCrashed" in type(error).__name__
    text = "WorkerDied: the worker process died twice at this unit" if dead else f"{type(error).__name__}: {error}"
    return _row(unit, "failed", text.splitlines()[0][:2000], None, None, (None, None, None))


def _awaited(future: "futures.Future[Row]") -> Row:
    while not futures.wait([future], _LOOK_EVERY).done:
        pass
    return future.result()


class _Pool:
    """Runs units on workers of some kind; each that fails is repeated once."""

    def __init__(self, workers: Optional[int]) -> None:
        self.workers = workers or os.cpu_count() or 1

    def __enter__(self) -> "_Pool":
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        pass

    def submit(self, unit: _Unit) -> "futures.Future[Row]":
        raise NotImplementedError

    def again(self, units: List[_Unit], error: BaseException) -> Iterator[Tuple[_Unit, Row]]:
        """Repeats units that have failed, one after the other, so that each answers for itself."""
        for unit in units:
            try:
                row = _awaited(self.submit(unit))
            except Exception as second:
                row = _gave_up(unit, second)
            yield unit, row

    def rows(self, units: Iterator[_Unit]) -> Iterator[Tuple[_Unit, Row]]:
        waiting: Dict["futures.Future[Row]", _Unit] = {}
        more = True
        while more or waiting:
            while more and len(waiting) < self.workers * _AHEAD:
                unit = next(units, None)
                if unit is None:
                    more = False
                    break
                try:
                    waiting[self.submit(unit)] = unit
                except futures.BrokenExecutor as refused:
                    broken: "futures.Future[Row]" = futures.Future()
                    broken.set_exception(refused)
                    waiting[broken] = unit
                    break
            if not waiting:
                continue
            done, _ = futures.wait(waiting, _LOOK_EVERY, futures.FIRST_COMPLETED)
            failed: List[_Unit] = []
            trouble: Optional[BaseException] = None
            for future in done:
                unit = waiting.pop(future)
                error = future.exception()
                if error is None:
                    yield unit, future.result()
                else:
                    failed.append(unit)
                    trouble = error
            if trouble is not None:
                if isinstance(trouble, futures.BrokenExecutor):
                    # All that waited at the pool are gone with it.
                    for future, unit in list(waiting.items()):
                        if future.exception() is None:
                            yield unit, future.result()
                        else:
                            failed.append(unit)
                    waiting.clear()
                failed.sort(key=lambda unit: unit["index"])
                yield from self.again(failed, trouble)


class _Threads(_Pool):
    def __enter__(self) -> "_Threads":
        self._pool = futures.ThreadPoolExecutor(self.workers, "sweep")
        self._live = _Live()
        return self

    def submit(self, unit: _Unit) -> "futures.Future[Row]":
        return self._pool.submit(run_unit, unit, self._live)

    def __exit__(self, kind: Any, *_: Any) -> None:
        if kind is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            self._live.stop_all()
        self._pool.shutdown()


class _Processes(_Pool):
    _pool: Optional[futures.ProcessPoolExecutor] = None

    def _made(self, workers: int) -> futures.ProcessPoolExecutor:
        import multiprocessing

        # A forked child would have none of this process's threads.
        return futures.ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"))

    def submit(self, unit: _Unit) -> "futures.Future[Row]":
        if self._pool is None:
            self._pool = self._made(self.workers)
        return self._pool.submit(run_unit, unit)

    def again(self, units: List[_Unit], error: BaseException) -> Iterator[Tuple[_Unit, Row]]:
        if not isinstance(error, futures.BrokenExecutor):
            yield from super().again(units, error)
            return
        if self._pool is not None:
            self._pool.shutdown(wait=False)
            self._pool = None
        for unit in units:
            # A worker of its own: whoever kills it takes nobody else along.
            with self._made(1) as alone:
                try:
                    row = _awaited(alone.submit(run_unit, unit))
                except Exception as second:
                    row = _gave_up(unit, second)
            yield unit, row

    def __exit__(self, kind: Any, *_: Any) -> None:
        if self._pool is None:
            return
        if kind is not None:
            for process in list((self._pool._processes or {}).values()):
                process.terminate()
        self._pool.shutdown(cancel_futures=kind is not None)


class _Ray(_Pool):
    """Ray as it runs, or a local cluster for this sweep."""

    def __enter__(self) -> "_Ray":
        try:
            ray = importlib.import_module("ray")
        except ImportError:
            raise ImportError('this executor needs Ray: pip install "elitescript[ray]"') from None
        self._began = not ray.is_initialized()
        if self._began:
            ray.init(num_cpus=self.workers, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
        else:
            self.workers = max(1, int(ray.cluster_resources().get("CPU", 1)))
        self._ray = ray
        # Repeats are counted here.
        self._run = ray.remote(max_retries=0)(run_unit)
        return self

    def submit(self, unit: _Unit) -> "futures.Future[Row]":
        future: "futures.Future[Row]" = self._run.remote(unit).future()
        return future

    def __exit__(self, kind: Any, *_: Any) -> None:
        if self._began:
            self._ray.shutdown()


_EXECUTORS: Dict[str, Callable[[Optional[int]], Any]] = {"threads": _Threads, "processes": _Processes, "ray": _Ray}


class _Store:
    """Where rows and recordings are kept: a folder, or whatever fsspec knows."""

    def __init__(self, address: str) -> None:
        self.address = address
        self.local: Optional[Path] = None
        self._fs: Any = None
        if "://" in address:
            try:
                fsspec = importlib.import_module("fsspec.core")
            except ImportError:
                raise ImportError(f"{address} needs fsspec: pip install \"elitescript[sweep]\"") from None
            self._fs, self._root = fsspec.url_to_fs(address)
        else:
            self.local = Path(address).absolute()
            self.address = str(self.local)

    def _write(self, name: str, data: bytes) -> None:
        if self.local is not None:
            path = self.local / name
            path.parent.mkdir(parents=True, exist_ok=True)
            # Whole or not at all: a sweep may be killed at any moment.
            beside = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}")
            beside.write_bytes(data)
            os.replace(beside, path)
        else:
            path_there = f"{self._root}/{name}"
            self._fs.makedirs(path_there.rsplit("/", 1)[0], exist_ok=True)
            self._fs.pipe_file(path_there, data)

    def _read(self, name: str) -> Optional[bytes]:
        try:
            if self.local is not None:
                return (self.local / name).read_bytes()
            return bytes(self._fs.cat_file(f"{self._root}/{name}"))
        except FileNotFoundError:
            return None

    @staticmethod
    def _key(unit: _Unit) -> str:
        what = [__version__] + [unit[name] for name in ("text", "presets", "options", "timeout", "record")]
        return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()

    def known(self, unit: _Unit) -> Optional[Row]:
        data = self._read(f"rows/{unit['index']:06}.json")
        if data is None:
            return None
        try:
            kept = json.loads(data)
        except ValueError:
            return None
        if not isinstance(kept, dict) or kept.get("key") != self._key(unit) or not isinstance(kept.get("row"), dict):
            return None
        row: Row = kept["row"]
        # As it was given: JSON knows no tuples.
        row.update(unit["parameters"])
        return row

    def keep(self, unit: _Unit, row: Row) -> None:
        if row["time"] is None:
            # Not the program's end: it may come out otherwise next time.
            return
        kept = {"key": self._key(unit), "row": row}
        self._write(f"rows/{unit['index']:06}.json", json.dumps(kept, default=repr).encode())

    def take_recording(self, index: int, path: str) -> None:
        self._write(f"recordings/{index:06}.mcap", Path(path).read_bytes())

    def write_table(self, table: Any) -> None:
        data = io.BytesIO()
        importlib.import_module("pyarrow.parquet").write_table(table, data)
        self._write("table.parquet", data.getvalue())


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
