"""Writes the public names of CPython's modules that EliteScript has, too, to cpython_names.txt.

Run it with Python 3.11.
"""

import importlib
import keyword
import pathlib
import types

MODULES = (
    "builtins math time random struct json re string datetime threading queue collections itertools functools copy "
    "sys os os.path signal subprocess socket abc bisect collections.abc contextlib dataclasses enum heapq io operator "
    "statistics typing"
).split()


def names(module):
    found = importlib.import_module(module)
    listed = set(getattr(found, "__all__", ()))
    if not listed or module in ("os", "socket", "signal"):
        listed |= {
            name
            for name in dir(found)
            if not name.startswith("_") and not isinstance(getattr(found, name), types.ModuleType)
        }
    return sorted(listed - set(keyword.kwlist))


lines = [f"{module}: {' '.join(names(module))}" for module in sorted(MODULES)]
pathlib.Path(__file__).with_suffix(".txt").write_text("\n".join(lines) + "\n")
