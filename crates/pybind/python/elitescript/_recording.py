"""Recordings as numpy tables."""

from __future__ import annotations

import os
from typing import Any, List, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from ._controller import CYCLE_DTYPE
from ._elitescript import recording_cycles, recording_table


def open_recording(path: Union[str, "os.PathLike[str]"]) -> "Recording":
    """Opens a recording: ``open_recording("a.mcap")["/cycle"]["actual_q"]``."""
    return Recording(path)


class Recording:
    """A recording whose topics are tables: structured numpy arrays, a row a message.

    ``/cycle`` has the fields of ``Controller.state``. The columns of other topics are those of ``replay --csv``:
    numbers where every cell is one, NaN where a number is missing, else texts.
    """

    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        self.path = os.fspath(path)
        self._topics: List[str] = recording_table(self.path)[0]

    @property
    def topics(self) -> List[str]:
        """The names of its topics."""
        return list(self._topics)

    def __contains__(self, topic: object) -> bool:
        return topic in self._topics

    def __getitem__(self, topic: str) -> NDArray[np.void]:
        if topic not in self._topics:
            raise KeyError(f"there is no topic {topic!r} in {self.path}; there are {', '.join(self._topics)}")
        if topic == "/cycle":
            return recording_cycles(self.path).view(CYCLE_DTYPE)
        columns, rows = recording_table(self.path, topic)
        made = [_column([row[k] for row in rows]) for k in range(len(columns))]
        table = np.empty(len(rows), dtype=[(name, column.dtype) for name, column in zip(columns, made)])
        for name, column in zip(columns, made):
            table[name] = column
        return table

    def plot(self, *, joints: Optional[Sequence[int]] = None) -> Any:
        """A matplotlib figure of ``/cycle``."""
        from ._plot import figure

        return figure(self["/cycle"], joints)

    def __repr__(self) -> str:
        return f"<Recording {self.path}: {', '.join(self._topics)}>"


def _column(cells: List[Optional[str]]) -> NDArray[Any]:
    filled = [cell for cell in cells if cell]
    if filled and len(filled) == len(cells):
        try:
            return np.array([int(cell) for cell in filled], dtype=np.int64)
        except (ValueError, OverflowError):
            pass
    if filled:
        try:
            return np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            pass
    return np.array([cell or "" for cell in cells], dtype=np.str_)
