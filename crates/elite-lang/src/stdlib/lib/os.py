"""The system around the program. Paths as text always work; what reaches files, processes or the environment needs
the permission of the controller."""
import _system
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


class _Environment:
    """The environment variables, asked for when they are needed."""

    def _all(self):
        return _system.environment()

    def __getitem__(self, key):
        return self._all()[key]

    def get(self, key, default=None):
        return self._all().get(key, default)

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
        return self._all()

    def __setitem__(self, key, value):
        raise PermissionError("scripts may not change environment variables")

    def __delitem__(self, key):
        raise PermissionError("scripts may not change environment variables")


environ = _Environment()


def getenv(key, default=None):
    return environ.get(key, default)


def urandom(size, /):
    return _system.random_bytes(size)


def cpu_count():
    return 1


def strerror(code, /):
    return f"Unknown error {code}"


def _refused(permission, what):
    def function(*args, **kwargs):
        _system.require(permission, what)
        raise NotImplementedError(f"{what}: not available on this controller, even with --allow {permission}")
    return function


access = _refused("fs", "os.access")
chdir = _refused("fs", "os.chdir")
chmod = _refused("fs", "os.chmod")
chown = _refused("fs", "os.chown")
close = _refused("fs", "os.close")
fstat = _refused("fs", "os.fstat")
getcwd = _refused("fs", "os.getcwd")
link = _refused("fs", "os.link")
listdir = _refused("fs", "os.listdir")
lstat = _refused("fs", "os.lstat")
makedirs = _refused("fs", "os.makedirs")
mkdir = _refused("fs", "os.mkdir")
open = _refused("fs", "os.open")
pipe = _refused("fs", "os.pipe")
read = _refused("fs", "os.read")
readlink = _refused("fs", "os.readlink")
remove = _refused("fs", "os.remove")
removedirs = _refused("fs", "os.removedirs")
rename = _refused("fs", "os.rename")
replace = _refused("fs", "os.replace")
rmdir = _refused("fs", "os.rmdir")
scandir = _refused("fs", "os.scandir")
stat = _refused("fs", "os.stat")
symlink = _refused("fs", "os.symlink")
truncate = _refused("fs", "os.truncate")
unlink = _refused("fs", "os.unlink")
utime = _refused("fs", "os.utime")
walk = _refused("fs", "os.walk")
write = _refused("fs", "os.write")
abort = _refused("process", "os.abort")
execl = _refused("process", "os.execl")
execv = _refused("process", "os.execv")
execve = _refused("process", "os.execve")
execvp = _refused("process", "os.execvp")
fork = _refused("process", "os.fork")
getlogin = _refused("process", "os.getlogin")
getpid = _refused("process", "os.getpid")
getppid = _refused("process", "os.getppid")
getuid = _refused("process", "os.getuid")
kill = _refused("process", "os.kill")
killpg = _refused("process", "os.killpg")
nice = _refused("process", "os.nice")
popen = _refused("process", "os.popen")
spawnl = _refused("process", "os.spawnl")
spawnv = _refused("process", "os.spawnv")
system = _refused("process", "os.system")
waitpid = _refused("process", "os.waitpid")
_exit = _refused("process", "os._exit")
putenv = _refused("env", "os.putenv")
unsetenv = _refused("env", "os.unsetenv")
