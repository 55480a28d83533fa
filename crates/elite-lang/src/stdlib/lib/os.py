"""The system around the program. Paths as text always work; what reaches files, processes or the environment needs
the permission of the controller.

The folder a program is in and its environment are its own: `chdir` and `environ` change nothing for the controller."""
import _files
import _process
import _system
import io as _io
import os.path as path

name = "posix"
sep = "/"
linesep = "\n"
pathsep = ":"
curdir = "."
pardir = ".."
extsep = "."
altsep = None
devnull = "/dev/null"
error = OSError

F_OK, X_OK, W_OK, R_OK = 0, 1, 2, 4
O_RDONLY, O_WRONLY, O_RDWR = 0, 1, 2
O_CREAT, O_EXCL, O_TRUNC, O_APPEND = 0o100, 0o200, 0o1000, 0o2000
SEEK_SET, SEEK_CUR, SEEK_END = 0, 1, 2


def fspath(path):
    if isinstance(path, (str, bytes)):
        return path
    if not hasattr(type(path), "__fspath__"):
        raise TypeError(f"expected str, bytes or os.PathLike object, not {type(path).__name__}")
    return type(path).__fspath__(path)


class PathLike:
    """What has a path as text."""

    def __fspath__(self):
        raise NotImplementedError


fsencode = lambda filename: fspath(filename).encode() if isinstance(fspath(filename), str) else filename
fsdecode = _io._path


# Environment

class _Environment:
    """The environment variables, taken over when they are first needed. Changes are seen by this program and by what it
    starts."""

    _own = None

    def _all(self):
        found = _system.environment() if self._own is None else self._own
        self._own = found
        return found

    def _text(self, text):
        if not isinstance(text, str):
            raise TypeError(f"str expected, not {type(text).__name__}")
        return text

    def __getitem__(self, key):
        return self._all()[self._text(key)]

    def get(self, key, default=None):
        return self._all().get(self._text(key), default)

    def __contains__(self, key):
        return key in self._all()

    def __iter__(self):
        return iter(self._all())

    def __len__(self):
        return len(self._all())

    def keys(self):
        return self._all().keys()

    def values(self):
        return self._all().values()

    def items(self):
        return self._all().items()

    def copy(self):
        return dict(self._all())

    def __setitem__(self, key, value):
        if not self._text(key) or "=" in key:
            raise OSError(22, "Invalid argument")
        self._all()[key] = self._text(value)

    def __delitem__(self, key):
        del self._all()[self._text(key)]

    def pop(self, key, *default):
        return self._all().pop(key, *default)

    def setdefault(self, key, value):
        if key not in self:
            self[key] = value
        return self[key]

    def update(self, *others, **more):
        for key, value in dict(*others, **more).items():
            self[key] = value

    def clear(self):
        self._all().clear()

    def __or__(self, other):
        return self._all() | dict(other)

    def __repr__(self):
        return f"environ({self._all()!r})"


environ = _Environment()


def getenv(key, default=None):
    return environ.get(key, default)


def putenv(name, value, /):
    environ[name] = value


def unsetenv(name, /):
    environ.pop(name, None)


# Files and folders

class stat_result(tuple):
    """What the system knows of a file."""
    __module__ = "os"

    def __new__(cls, sequence):
        made = tuple.__new__(cls, sequence[:7] + tuple(ns // 10 ** 9 for ns in sequence[7:]))
        made.st_atime_ns, made.st_mtime_ns, made.st_ctime_ns = sequence[7:]
        made.st_atime, made.st_mtime, made.st_ctime = [ns / 10 ** 9 for ns in sequence[7:]]
        return made

    st_mode = property(lambda self: self[0])
    st_ino = property(lambda self: self[1])
    st_dev = property(lambda self: self[2])
    st_nlink = property(lambda self: self[3])
    st_uid = property(lambda self: self[4])
    st_gid = property(lambda self: self[5])
    st_size = property(lambda self: self[6])

    def __repr__(self):
        names = ("mode", "ino", "dev", "nlink", "uid", "gid", "size", "atime", "mtime", "ctime")
        return "os.stat_result(" + ", ".join(f"st_{name}={value}" for name, value in zip(names, self)) + ")"


def stat(path, *, dir_fd=None, follow_symlinks=True):
    if isinstance(path, int):
        return fstat(path)
    return stat_result(_files.stat(_io._path(path), follow_symlinks))


def lstat(path, *, dir_fd=None):
    return stat_result(_files.stat(_io._path(path), False))


def fstat(fd):
    return stat_result(_io._descriptor(fd).stat())


def listdir(path="."):
    return _files.list(_io._path(path))


class DirEntry:
    """A name in a folder."""

    def __init__(self, folder, name):
        self.name = name
        self.path = path.join(folder, name)

    def stat(self, *, follow_symlinks=True):
        return stat(self.path, follow_symlinks=follow_symlinks)

    def is_dir(self, *, follow_symlinks=True):
        return path.isdir(self.path) and (follow_symlinks or not self.is_symlink())

    def is_file(self, *, follow_symlinks=True):
        return path.isfile(self.path) and (follow_symlinks or not self.is_symlink())

    def is_symlink(self):
        return path.islink(self.path)

    def inode(self):
        return lstat(self.path).st_ino

    def __fspath__(self):
        return self.path

    def __repr__(self):
        return f"<DirEntry {self.name!r}>"


class _Scan:
    def __init__(self, entries):
        self._entries = iter(entries)

    def __iter__(self):
        return self

    def __next__(self):
        return next(self._entries)

    def __enter__(self):
        return self

    def __exit__(self, *args):
        self.close()

    def close(self):
        self._entries = iter(())


def scandir(path="."):
    folder = _io._path(path)
    return _Scan([DirEntry(folder, name) for name in _files.list(folder)])


def walk(top, topdown=True, onerror=None, followlinks=False):
    top = _io._path(top)
    try:
        names = _files.list(top)
    except OSError as error:
        if onerror is not None:
            onerror(error)
        return
    folders = [name for name in names if path.isdir(path.join(top, name))]
    files = [name for name in names if name not in folders]
    if topdown:
        yield top, folders, files
    for name in folders:
        inner = path.join(top, name)
        if followlinks or not path.islink(inner):
            yield from walk(inner, topdown, onerror, followlinks)
    if not topdown:
        yield top, folders, files


def mkdir(path, mode=0o777, *, dir_fd=None):
    _files.mkdir(_io._path(path), mode)


def _above(name):
    """The folders that a path names above its last part, the innermost first."""
    slash = b"/" if isinstance(name, bytes) else "/"
    name = path.dirname(name.rstrip(slash))
    while name.rstrip(slash):
        yield name
        name = path.dirname(name.rstrip(slash))


def makedirs(name, mode=0o777, exist_ok=False):
    name = _io._path(name)
    for folder in reversed([folder for folder in _above(name) if not path.exists(folder)]):
        # Another program may make it meanwhile.
        _make(folder, 0o777, True)
    here = b"." if isinstance(name, bytes) else curdir
    if path.basename(name) != here or not path.isdir(name):
        _make(name, mode, exist_ok)


def _make(name, mode, may_exist):
    try:
        mkdir(name, mode)
    except OSError:
        if not (may_exist and path.isdir(name)):
            raise


def rmdir(path, *, dir_fd=None):
    _files.rmdir(_io._path(path))


def removedirs(name):
    rmdir(name)
    _prune(name)


def _prune(name):
    """Removes the folders above a path as far as they are empty."""
    try:
        for folder in _above(name):
            rmdir(folder)
    except OSError:
        pass


def remove(path, *, dir_fd=None):
    _files.remove(_io._path(path))


unlink = remove


def rename(src, dst, *, src_dir_fd=None, dst_dir_fd=None):
    _files.rename(_io._path(src), _io._path(dst))


replace = rename


def symlink(src, dst, target_is_directory=False, *, dir_fd=None):
    _files.symlink(_io._path(src), _io._path(dst))


def link(src, dst):
    _files.link(_io._path(src), _io._path(dst))


def readlink(path, *, dir_fd=None):
    return _files.readlink(_io._path(path))


def chmod(path, mode, *, dir_fd=None, follow_symlinks=True):
    _files.chmod(_io._path(path), mode)


def utime(path, times=None, *, ns=None, dir_fd=None, follow_symlinks=True):
    if times is not None and ns is not None:
        raise ValueError("utime: you may specify either 'times' or 'ns' but not both")
    if ns is None:
        if times is None:
            import time
            now = time.time_ns()
            ns = (now, now)
        else:
            ns = tuple(int(moment * 10 ** 9) for moment in times)
    _files.utime(_io._path(path), ns[0], ns[1])


def access(path, mode, *, dir_fd=None, effective_ids=False, follow_symlinks=True):
    return _files.access(_io._path(path), mode)


def getcwd():
    return _files.getcwd()


def chdir(path):
    _files.chdir(_io._path(path))


def truncate(path, length):
    if isinstance(path, int):
        return ftruncate(path, length)
    with _io.open(path, "r+b") as file:
        file.truncate(length)


# Files by number

def open(path, flags, mode=0o777, *, dir_fd=None):
    letter = "r"
    if flags & O_APPEND:
        letter = "a"
    elif flags & O_CREAT and flags & O_EXCL:
        letter = "x"
    elif flags & O_CREAT:
        # Made if it is missing; emptied only if asked.
        letter = "w" if flags & O_TRUNC or not _there(path) else "r+"
    elif flags & O_TRUNC:
        _files.stat(_io._path(path), True)
        letter = "w"
    elif flags & (O_WRONLY | O_RDWR):
        letter = "r+"
    if flags & O_RDWR and "+" not in letter:
        letter += "+"
    return _io._enter(_files.open(_io._path(path), letter))


def _there(name):
    return path.exists(name)


def fdopen(fd, *args, **kwargs):
    return _io.open(fd, *args, **kwargs)


def read(fd, n, /):
    return _io._descriptor(fd).read(n)


def write(fd, data, /):
    file = _io._descriptor(fd)
    count = file.write(data)
    file.flush()
    return count


def lseek(fd, position, whence, /):
    return _io._descriptor(fd).seek(position, whence)


def ftruncate(fd, length, /):
    _io._descriptor(fd).truncate(length)


def fsync(fd):
    if not isinstance(fd, int):
        fd = fd.fileno()
    _io._descriptor(fd).sync()


fdatasync = fsync


def close(fd):
    _io._descriptor(fd).close()
    del _io._descriptors[fd]


def isatty(fd, /):
    return False


# Processes

def getpid():
    return _process.identity("os.getpid")[0]


def getppid():
    return _process.identity("os.getppid")[1]


def getuid():
    return _process.identity("os.getuid")[2]


def geteuid():
    return _process.identity("os.geteuid")[3]


def getgid():
    return _process.identity("os.getgid")[4]


def getegid():
    return _process.identity("os.getegid")[5]


def kill(pid, sig, /):
    if pid == _process.identity("os.kill")[0]:
        import signal
        return signal.raise_signal(sig) if sig else None
    _process.kill(pid, int(sig), False)


def killpg(pgid, sig, /):
    _process.kill(pgid, int(sig), True)


def system(command):
    import subprocess
    code = subprocess.call(command, shell=True)
    return -code if code < 0 else code << 8


def waitstatus_to_exitcode(status):
    return -(status & 0x7F) if status & 0x7F else status >> 8


def popen(cmd, mode="r", buffering=-1):
    import subprocess
    if mode not in ("r", "w"):
        raise ValueError(f"invalid mode {mode!r}")
    return subprocess._popen(cmd, mode)


def urandom(size, /):
    return _system.random_bytes(size)


def cpu_count():
    return 1


def _exit(status):
    raise SystemExit(status)


def get_terminal_size(fd=0, /):
    raise OSError(25, "Inappropriate ioctl for device")


_MESSAGES = {1: "Operation not permitted", 2: "No such file or directory", 3: "No such process",
             4: "Interrupted system call", 5: "Input/output error", 9: "Bad file descriptor", 10: "No child processes",
             11: "Resource temporarily unavailable", 12: "Cannot allocate memory", 13: "Permission denied",
             17: "File exists", 20: "Not a directory", 21: "Is a directory", 22: "Invalid argument",
             24: "Too many open files", 28: "No space left on device", 32: "Broken pipe", 36: "File name too long",
             39: "Directory not empty", 98: "Address already in use", 104: "Connection reset by peer",
             110: "Connection timed out", 111: "Connection refused", 113: "No route to host"}


def strerror(code, /):
    return _MESSAGES.get(code, f"Unknown error {code}")


def _unavailable(name):
    """What would replace, split or end the controller itself."""
    def function(*args, **kwargs):
        _system.require("process", f"os.{name}")
        raise OSError(95, f"os.{name} would change the controller's own process; start others with subprocess")
    function.__name__ = function.__qualname__ = name
    return function


abort = _unavailable("abort")
execl = _unavailable("execl")
execv = _unavailable("execv")
execve = _unavailable("execve")
execvp = _unavailable("execvp")
fork = _unavailable("fork")
