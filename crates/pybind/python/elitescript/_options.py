"""Options of a controller: Python values to the texts that the command line takes."""

from __future__ import annotations

import hashlib
import math
import numbers
import os
import tempfile
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import numpy as np

from ._elitescript import option_names, preset

#: Options of a controller; on the command line with dashes.
NAMES = tuple(option_names())

#: Longest program, bytes; as `eliteserver run`.
PROGRAM_BYTES_MAX = 8 << 20


def _vector(name: str, given: Any, length: int) -> str:
    try:
        array = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be {length} numbers, got {given!r}") from None
    if array.shape != (length,):
        raise ValueError(f"{name} must have shape ({length},), got shape {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite, got {given!r}")
    return ",".join(repr(float(x)) for x in array)


def _whole(name: str, given: Any) -> str:
    if isinstance(given, bool) or not isinstance(given, numbers.Integral):
        raise ValueError(f"{name} must be a whole number, got {given!r}")
    return str(int(given))


def _path(name: str, given: Any) -> str:
    if not isinstance(given, (str, os.PathLike)) or not os.fspath(given):
        raise ValueError(f"{name} must be a path, got {given!r}")
    return os.fspath(given)


def _payload(given: Any) -> str:
    if isinstance(given, numbers.Real):
        mass, cog, inertia = given, None, None
    else:
        parts = list(given) if isinstance(given, (list, tuple)) else []
        if not 1 <= len(parts) <= 3:
            raise ValueError(f"payload must be a mass, (mass, cog) or (mass, cog, inertia), got {given!r}")
        mass, cog, inertia = (parts + [None, None])[:3]
    if isinstance(mass, bool) or not isinstance(mass, numbers.Real) or not 0 <= float(mass) < math.inf:
        raise ValueError(f"payload mass must be a number of kg from 0 on, got {mass!r}")
    text = repr(float(mass))
    if cog is not None:
        text += "," + _vector("payload cog", cog, 3)
    if inertia is not None:
        text += "" if cog is not None else ",0,0,0"
        text += "," + _vector("payload inertia", inertia, 6)
    return text


def kept_text(text: str, suffix: str, folder: Optional[Union[str, Path]] = None) -> str:
    """A file with this text; the same text has the same file."""
    if folder is None:
        folder = Path(tempfile.gettempdir()) / f"elitescript-{os.getuid() if hasattr(os, 'getuid') else 'user'}"
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    name = hashlib.sha256(text.encode()).hexdigest()[:16] + suffix
    path = folder / name
    # Whoever writes the same text at the same time writes the same bytes.
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        beside = folder / f"{name}.{os.getpid()}"
        beside.write_text(text, encoding="utf-8")
        os.replace(beside, path)
    return str(path)


def option_texts(given: Mapping[str, Any], folder: Optional[Union[str, Path]] = None) -> Dict[str, str]:
    """The options as texts; ValueError names what does not fit and what is allowed. None means the default."""
    texts: Dict[str, str] = {}
    for name, value in given.items():
        if name not in NAMES:
            raise ValueError(f"there is no option {name}; allowed are {', '.join(NAMES)}")
        if value is None:
            continue
        if name == "home":
            texts[name] = _vector(name, value, 6)
        elif name == "tcp":
            texts[name] = _vector(name, value, 6)
        elif name == "payload":
            texts[name] = _payload(value)
        elif name in ("step_ms", "seed"):
            texts[name] = _whole(name, value)
        elif name == "allow":
            words = [value] if isinstance(value, str) else list(value)
            if not all(isinstance(word, str) and "\n" not in word for word in words):
                raise ValueError(f'allow must be words such as "fs", "net" or "fs=/data", got {value!r}')
            texts[name] = "\n".join(words)
        elif name == "cell" and isinstance(value, str) and "\n" in value:
            texts[name] = kept_text(value, ".toml", folder)
        elif name in ("cell", "calibration", "task_dir", "record"):
            texts[name] = _path(name, value)
        else:
            if not isinstance(value, (str, os.PathLike)):
                raise ValueError(f"{name} must be a text, got {value!r}")
            texts[name] = os.fspath(value)
    return texts


def command_options(texts: Mapping[str, str]) -> List[str]:
    """The same on the command line."""
    words: List[str] = []
    for name, text in texts.items():
        for word in text.split("\n") if name == "allow" else [text]:
            words.append(f"--{name.replace('_', '-')}={word}")
    return words


def literal(value: Any) -> str:
    """A Python value as EliteScript writes it."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool):
        return repr(value)
    if isinstance(value, int):
        return repr(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value!r} cannot be written in a script")
        return repr(value)
    if isinstance(value, str):
        quoted = repr(value)
        return '"' + value + '"' if not set(value) & set("\"'\\\n\r") else quoted
    if isinstance(value, (list, tuple)):
        inner = ", ".join(literal(item) for item in value)
        if isinstance(value, list):
            return f"[{inner}]"
        return f"({inner},)" if len(value) == 1 else f"({inner})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{literal(k)}: {literal(v)}" for k, v in value.items()) + "}"
    raise ValueError(f"a value of type {type(value).__name__} cannot be written in a script: {value!r}")


def preset_pairs(given: Optional[Mapping[str, Any]]) -> List[Tuple[str, str]]:
    """Globals for a program as names and texts; ValueError names the one that does not fit."""
    pairs = []
    for name, value in (given or {}).items():
        try:
            text = literal(value)
        except ValueError as error:
            raise ValueError(f"global {name}: {error}") from None
        preset(name, text)
        pairs.append((name, text))
    return pairs


def program_text(program: Union[str, "os.PathLike[str]"]) -> Tuple[str, str, Optional[Path]]:
    """Name and text of a program given as text or as the path of a file, and that path."""
    if isinstance(program, str) and "\n" not in program and not program.endswith(".script"):
        try:
            is_text = not Path(program).is_file()
        except (OSError, ValueError):
            is_text = True
    else:
        is_text = isinstance(program, str) and "\n" in program
    if isinstance(program, str) and is_text:
        size, name, text, path = len(program.encode("utf-8", "surrogatepass")), "<text>", program, None
    elif isinstance(program, (str, os.PathLike)):
        path = Path(program)
        size = path.stat().st_size
        name = path.name
        text = path.read_text(encoding="utf-8-sig") if size <= PROGRAM_BYTES_MAX else ""
    else:
        raise ValueError(f"a program is a text or the path of a file, got {program!r}")
    if size > PROGRAM_BYTES_MAX:
        raise ValueError(f"the program has {size} bytes; at most {PROGRAM_BYTES_MAX} are allowed")
    return name, text, path


def duration(name: str, given: Any) -> float:
    """Seconds of an argument."""
    if isinstance(given, bool) or not isinstance(given, numbers.Real) or not 0 <= float(given) < math.inf:
        raise ValueError(f"{name} must be seconds from 0 on, got {given!r}")
    return float(given)
