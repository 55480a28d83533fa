"""Paths as text. Questions about files need the permission of the controller."""
import _system

sep = "/"
curdir = "."
pardir = ".."


def isabs(s):
    return s.startswith("/")


def join(a, *p):
    path = a
    for b in p:
        if b.startswith("/"):
            path = b
        elif not path or path.endswith("/"):
            path += b
        else:
            path += "/" + b
    return path


def split(p):
    i = p.rfind("/") + 1
    head, tail = p[:i], p[i:]
    if head and head != "/" * len(head):
        head = head.rstrip("/")
    return head, tail


def basename(p):
    return split(p)[1]


def dirname(p):
    return split(p)[0]


def splitext(p):
    start = p.rfind("/") + 1
    dot = p.rfind(".")
    # Leading dots belong to the name.
    if dot > start and p[start:dot].strip("."):
        return p[:dot], p[dot:]
    return p, ""


def splitdrive(p):
    return "", p


def normpath(path):
    if not path:
        return "."
    slashes = "//" if path.startswith("//") and not path.startswith("///") else "/" if path.startswith("/") else ""
    parts = []
    for part in path.split("/"):
        if part in ("", "."):
            continue
        if part != ".." or (not slashes and not parts) or (parts and parts[-1] == ".."):
            parts.append(part)
        elif parts:
            parts.pop()
    return slashes + "/".join(parts) or "."


def normcase(s):
    return s


def commonprefix(m):
    if not m:
        return ""
    low, high = min(m), max(m)
    for i, c in enumerate(low):
        if c != high[i]:
            return low[:i]
    return low


def expanduser(path):
    if path.startswith("~"):
        _system.require("env", "os.path.expanduser")
        home = _system.environment().get("HOME")
        if home is not None and (path == "~" or path.startswith("~/")):
            return home + path[1:]
    return path


def expandvars(path):
    if "$" in path:
        _system.require("env", "os.path.expandvars")
        raise NotImplementedError("os.path.expandvars: not available on this controller, even with --allow env")
    return path


def _refused(name):
    def function(*args, **kwargs):
        _system.require("fs", f"os.path.{name}")
        raise NotImplementedError(f"os.path.{name}: not available on this controller, even with --allow fs")
    return function


abspath = _refused("abspath")
exists = _refused("exists")
getmtime = _refused("getmtime")
getsize = _refused("getsize")
isdir = _refused("isdir")
isfile = _refused("isfile")
islink = _refused("islink")
lexists = _refused("lexists")
realpath = _refused("realpath")
relpath = _refused("relpath")
samefile = _refused("samefile")
