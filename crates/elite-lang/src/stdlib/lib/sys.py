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


stdin = __stdin__ = None
api_version = 1013
copyright = "EliteScript is a language of its own; its semantics are those of CPython 3.11."
prefix = base_prefix = exec_prefix = base_exec_prefix = ""
float_repr_style = "short"
dont_write_bytecode = True
warnoptions = []
orig_argv = [""]
path_hooks = []
meta_path = []
path_importer_cache = {}
pycache_prefix = None
platlibdir = "lib"
abiflags = ""
builtin_module_names = stdlib_module_names = frozenset(_system.module_names())


class _Named(tuple):
    _names = ()

    def __new__(cls, *values):
        return tuple.__new__(cls, values)

    def __getattr__(self, name):
        if name in type(self)._names:
            return self[type(self)._names.index(name)]
        raise AttributeError(f"'sys.{type(self).__name__}' object has no attribute '{name}'")

    def __repr__(self):
        shown = ", ".join(f"{name}={value!r}" for name, value in zip(type(self)._names, self))
        return f"sys.{type(self).__name__}({shown})"


class int_info(_Named):
    _names = ("bits_per_digit", "sizeof_digit", "default_max_str_digits", "str_digits_check_threshold")


class hash_info(_Named):
    _names = ("width", "modulus", "inf", "nan", "imag", "algorithm", "hash_bits", "seed_bits", "cutoff")


class thread_info(_Named):
    _names = ("name", "lock", "version")


class _VersionInfo(_Named):
    _names = ("major", "minor", "micro", "releaselevel", "serial")


_VersionInfo.__name__ = "version_info"
version_info = _VersionInfo(3, 11, 0, "final", 0)
int_info = int_info(30, 4, 4300, 640)
hash_info = hash_info(64, 2 ** 61 - 1, 314159, 0, 1000003, "siphash13", 64, 128, 0)
thread_info = thread_info("coroutines", None, None)


def getfilesystemencoding():
    return "utf-8"


def getfilesystemencodeerrors():
    return "surrogateescape"


def getsizeof(object, default=None, /):
    """Roughly: what CPython says of its own objects means nothing here."""
    return object.__sizeof__()


def get_int_max_str_digits():
    return 4300


def set_int_max_str_digits(maxdigits):
    if maxdigits != 4300:
        raise ValueError("the limit on digits is the controller's own")


def getswitchinterval():
    return 0.005


def setswitchinterval(interval, /):
    if interval <= 0.0:
        raise ValueError("switch interval must be strictly positive")


def settrace(function, /):
    """Accepted; programs are not traced."""


def gettrace():
    return None


def setprofile(function, /):
    """Accepted; programs are not profiled."""


def getprofile():
    return None


def is_finalizing():
    return False


def audit(event, /, *args):
    """Accepted; nobody listens."""


def addaudithook(hook):
    """Accepted; nothing is audited."""


def displayhook(object, /):
    if object is not None:
        print(repr(object))


def excepthook(exctype, value, traceback, /):
    stderr.write(f"{exctype.__name__}: {value}\n")


__excepthook__, __displayhook__ = excepthook, displayhook
