"""Paths as text. Questions about files need the permission of the controller."""
import _files
import _system

sep = "/"
altsep = None
extsep = "."
pathsep = ":"
defpath = "/bin:/usr/bin"
devnull = "/dev/null"
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
    if "$" not in path:
        return path
    _system.require("env", "os.path.expandvars")
    import os
    import re

    def known(match):
        name = match.group(1) or match.group(2)
        return os.environ.get(name, match.group())
    return re.sub(r"\$(?:(\w+)|\{([^}]*)\})", known, path)


def _stat(path, what, follow=True):
    """What the system knows of a path; None if it does not exist. The permission is needed in any case."""
    _system.require("fs", "os.path." + what)
    if isinstance(path, int):
        import os
        return os.fstat(path)
    import io
    try:
        return _files.stat(io._path(path), follow)
    except (OSError, ValueError):
        return None


def _is(path, what, kind, follow=True):
    found = _stat(path, what, follow)
    return found is not None and found[0] & 0o170000 == kind


def exists(path):
    return _stat(path, "exists") is not None


def lexists(path):
    return _stat(path, "lexists", False) is not None


def isfile(path):
    return _is(path, "isfile", 0o100000)


def isdir(s):
    return _is(s, "isdir", 0o040000)


def islink(path):
    return _is(path, "islink", 0o120000, False)


def ismount(path):
    here, above = _stat(path, "ismount", False), _stat(join(path, ".."), "ismount")
    return here is not None and above is not None and (here[2] != above[2] or here[1] == above[1])


def _known(filename):
    import os
    return os.stat(filename)


def getsize(filename):
    return _known(filename).st_size


def getmtime(filename):
    return _known(filename).st_mtime


def getatime(filename):
    return _known(filename).st_atime


def getctime(filename):
    return _known(filename).st_ctime


def samefile(f1, f2):
    return samestat(_known(f1), _known(f2))


def samestat(s1, s2):
    return (s1.st_ino, s1.st_dev) == (s2.st_ino, s2.st_dev)


def _text(path):
    import io
    return io._path(path)


def abspath(path):
    path = _text(path)
    return normpath(path if isabs(path) else join(_files.getcwd(), path))


def relpath(path, start=curdir):
    if not path:
        raise ValueError("no path specified")
    start_parts = [part for part in abspath(start).split("/") if part]
    path_parts = [part for part in abspath(path).split("/") if part]
    same = len(commonprefix([start_parts, path_parts]))
    parts = [pardir] * (len(start_parts) - same) + path_parts[same:]
    return join(*parts) if parts else curdir


def commonpath(paths):
    paths = [_text(path) for path in paths]
    if not paths:
        raise ValueError("commonpath() arg is an empty sequence")
    if len({isabs(path) for path in paths}) != 1:
        raise ValueError("Can't mix absolute and relative paths")
    parts = [[part for part in path.split("/") if part and part != curdir] for path in paths]
    return ("/" if isabs(paths[0]) else "") + "/".join(commonprefix(parts))


# Links followed before it counts as a circle.
_LINKS_MAX = 40


def realpath(filename, *, strict=False):
    rest = abspath(filename).split("/")[::-1]
    path, links = "/", 0
    while rest:
        name = rest.pop()
        if not name or name == curdir:
            continue
        if name == pardir:
            path = dirname(path)
            continue
        inner = join(path, name)
        if links < _LINKS_MAX and islink(inner):
            links += 1
            target = _files.readlink(inner)
            if isabs(target):
                path = "/"
            rest += target.split("/")[::-1]
            continue
        if strict:
            _files.stat(inner, True)
        path = inner
    return path
