"""Importing by name. There are no finders and loaders: modules are those of the controller, and what is in
sys.modules."""

import sys as _sys

__all__ = ["__import__", "import_module", "invalidate_caches", "reload"]

__import__ = __import__


def import_module(name, package=None):
    """The module of a dotted name. A name with dots before it counts from a package."""
    if not name.startswith("."):
        return __import__(name, None, None, ["*"])
    if not package:
        raise TypeError(f"the 'package' argument is required to perform a relative import for {name!r}")
    own = name.lstrip(".")
    up = len(name) - len(own) - 1
    parts = package.split(".")
    if up >= len(parts):
        raise ImportError("attempted relative import beyond top-level package")
    base = ".".join(parts[:len(parts) - up])
    return import_module(f"{base}.{own}" if own else base)


def invalidate_caches():
    """There are none."""


def reload(module):
    """The module as it is: those of the controller do not change."""
    if not isinstance(module, type(_sys)):
        raise TypeError("reload() argument must be a module")
    if _sys.modules.get(module.__name__) is not module:
        raise ImportError(f"module {module.__name__} not in sys.modules", name=module.__name__)
    return module
