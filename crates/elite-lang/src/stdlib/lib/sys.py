"""What a program can know of the interpreter."""
import _system

version = "3.11 (EliteScript)"
version_info = (3, 11, 0, "final", 0)
hexversion = 0x030B00F0
maxsize = 2 ** 63 - 1
maxunicode = 0x10FFFF
byteorder = "little"
platform = "linux"
argv = [""]
path = []
executable = ""
modules = _system.modules()


class _Implementation:
    name = "elitescript"


class _FloatInfo:
    max = 1.7976931348623157e308
    min = 2.2250738585072014e-308
    epsilon = 2.220446049250313e-16
    dig = 15
    mant_dig = 53
    radix = 2
    max_exp = 1024
    min_exp = -1021
    max_10_exp = 308
    min_10_exp = -307
    rounds = 1


implementation = _Implementation()
float_info = _FloatInfo()


class _Output:
    """What `print` writes to."""

    encoding = "utf-8"

    def write(self, text):
        if not isinstance(text, str):
            raise TypeError(f"write() argument must be str, not {type(text).__name__}")
        _system.host_write(text)
        return len(text)

    def writelines(self, lines):
        for line in lines:
            self.write(line)

    def flush(self):
        pass

    def isatty(self):
        return False


stdout = stderr = __stdout__ = __stderr__ = _Output()


def exit(status=None, /):
    raise SystemExit(status)


def getrecursionlimit():
    return _system.recursion_limit()


def setrecursionlimit(limit, /):
    if not isinstance(limit, int):
        raise TypeError(f"'{type(limit).__name__}' object cannot be interpreted as an integer")
    if limit < 1:
        raise ValueError("recursion limit must be greater or equal than 1")
    if limit > getrecursionlimit():
        raise RuntimeError(f"the depth of calls is limited to {getrecursionlimit()} on the controller")


def exc_info():
    exception = _system.exception()
    return (None, None, None) if exception is None else (type(exception), exception, None)


def exception():
    return _system.exception()


def getdefaultencoding():
    return "utf-8"


def intern(string, /):
    return string
