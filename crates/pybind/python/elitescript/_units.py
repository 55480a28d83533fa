"""The units of a sweep: what one is, how it becomes a row, and where rows and recordings are kept.

A unit is plain values only, because it travels to other processes and machines.
The same unit gives the same row on each.
"""

from __future__ import annotations

import concurrent.futures as futures
import hashlib
import importlib
import io
import json
import os
import shutil
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Dict, Optional, Set, Tuple

from ._elitescript import NativeController, __version__

Row = Dict[str, Any]
Unit = Dict[str, Any]


class Live:
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


def run_unit(unit: Unit, live: Optional[Live] = None) -> Row:
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
            Store(unit["keep"]).take_recording(unit["index"], texts["record"])
    finally:
        if scratch is not None:
            shutil.rmtree(scratch, ignore_errors=True)
    return _row(unit, outcome, error, line, taken, (speed, force, max(joint_speed)))


def _row(
    unit: Unit,
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


def worker_died(error: BaseException) -> bool:
    """Whether the process that ran a unit has died, in the words of all executors."""
    return isinstance(error, futures.BrokenExecutor) or type(error).__name__ in ("WorkerCrashedError", "KilledWorker")


def gave_up(unit: Unit, error: BaseException) -> Row:
    """The row of a unit that has failed twice for another reason than its program."""
    dead = worker_died(error)
    text = "WorkerDied: the worker process died twice at this unit" if dead else f"{type(error).__name__}: {error}"
    return _row(unit, "failed", text.splitlines()[0][:2000], None, None, (None, None, None))


class Store:
    """Where rows and recordings are kept: a folder, or whatever fsspec knows."""

    def __init__(self, address: str) -> None:
        self.address = address
        self.local: Optional[Path] = None
        self._fs: Any = None
        if "://" in address:
            try:
                fsspec = importlib.import_module("fsspec.core")
            except ImportError:
                raise ImportError(f'{address} needs fsspec: pip install "elitescript[sweep]"') from None
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
    def _key(unit: Unit) -> str:
        what = [__version__] + [unit[name] for name in ("text", "presets", "options", "timeout", "record")]
        return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()

    def known(self, unit: Unit) -> Optional[Row]:
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

    def keep(self, unit: Unit, row: Row) -> None:
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
